//! fTetWild, the last resort: a filling of a surface that no Delaunay mesher can fill, by the Python package `pytetwild`.
//!
//! fTetWild takes any triangles, whether they cut each other, overlap or leave small gaps, and fills what they enclose; its boundary lies within an
//! envelope round them. It needs no file format: points and triangles go over as plain little-endian numbers.
//!
//! Guarantees: every tet of the result names four different points that exist and has a positive volume; coordinates are finite; the process is
//! killed, with all that it started, when the time is over.
//! The same surface gives the same filling on Linux (x86-64 and ARM64) with the system's C++ library; elsewhere two runs differ a little.
//! Limits: the boundary of the result does not conform to the triangles, it only lies near them; it may touch itself along edges and in points.
//!
//! Reference: Y. Hu, T. Schneider, B. Wang, D. Zorin, D. Panozzo, "Fast Tetrahedral Meshing in the Wild", ACM TOG 39 (2020),
//! doi:10.1145/3386569.3392385.

use std::env;
use std::path::{Path, PathBuf};
use std::time::Duration;

use glam::DVec3;

use super::gmsh::{absolute, on_path};
use super::process::{self, Ended, Limits};
use super::spent::Budget;

/// How to install what is missing.
pub const INSTALL: &str = "python3 -m venv .venv && .venv/bin/pip install pytetwild==0.4.2 pyvista==0.49.1, or name a Python that has it with MIDSHELL_PYTHON";

/// Of processor time; by the clock it is long enough for a cold disk.
const IMPORT_LIMIT: Duration = Duration::from_secs(15);

const PROGRAM: &str = include_str!("tetwild.py");

/// Why fTetWild gave no filling.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum TetWildError {
    /// No Python with `pytetwild` was found.
    #[error("no Python with pytetwild was found; looked at {}", looked_at.join(", "))]
    Missing {
        /// The places that were tried, in order.
        looked_at: Vec<String>,
    },
    /// The surface has no triangles, or they name points that are missing or not finite.
    #[error("the surface of {points} points and {triangles} triangles cannot be filled")]
    BadSurface {
        /// How many points.
        points: usize,
        /// How many triangles.
        triangles: usize,
    },
    /// The working folder could not be used, or the process not started.
    #[error("fTetWild cannot be run: {0}")]
    Run(String),
    /// The time was over.
    #[error("fTetWild was stopped after {:.0} s", limit.as_secs_f64())]
    TimedOut {
        /// The limit.
        limit: Duration,
    },
    /// It ended without a result.
    #[error("fTetWild failed: {}", lines.join(" | "))]
    Failed {
        /// The last lines that it wrote.
        lines: Vec<String>,
    },
    /// It wrote something that is no filling.
    #[error("the result of fTetWild cannot be used: {0}")]
    BadResult(&'static str),
}

/// A Python that has `pytetwild`.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct TetWild {
    /// The Python.
    pub python: PathBuf,
    /// The version of `pytetwild`.
    pub version: String,
}

/// How to fill.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FillOptions {
    /// Ideal edge length of the tets, in the unit of the points.
    pub edge_length: f64,
    /// How far the boundary of the filling may lie off the triangles, in the unit of the points.
    pub envelope: f64,
    /// Longest that it may take, of processor time; four times as long by the clock.
    pub time_limit: Duration,
    /// Address space, bytes (Unix only); unlimited where none is given.
    pub memory_limit: Option<u64>,
}

/// Tets that fill a surface.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Filling {
    /// The corners of all tets.
    pub points: Vec<DVec3>,
    /// Four different positions in `points` each, of positive volume: `(b - a) · ((c - a) x (d - a)) > 0`.
    pub tets: Vec<[u32; 4]>,
}

/// Finds a Python that has `pytetwild`: the variable `MIDSHELL_PYTHON`, `.venv/bin/python3` in the current folder or one above it, the Python beside
/// `gmsh` where one is given, `python3` on `PATH`; the first that has it, in this order. One that is named by the variable is the only one asked.
pub fn find_tetwild(gmsh: Option<&Path>) -> Result<TetWild, TetWildError> {
    let mut candidates = Vec::new();
    if let Some(named) = env::var_os("MIDSHELL_PYTHON") {
        candidates.push(absolute(Path::new(&named)));
    } else {
        let here = env::current_dir().unwrap_or_default();
        candidates.extend(here.ancestors().map(|f| f.join(".venv/bin/python3")));
        candidates.extend(gmsh.map(|g| absolute(g).with_file_name("python3")));
        candidates.extend(on_path("python3"));
    }
    let mut looked_at = Vec::new();
    for python in candidates {
        if !python.is_file() {
            continue;
        }
        if let Some(version) = version_of(&python) {
            return Ok(TetWild { python, version });
        }
        looked_at.push(python.display().to_string());
    }
    if looked_at.is_empty() {
        looked_at.push("MIDSHELL_PYTHON, .venv/bin/python3, PATH".to_owned());
    }
    Err(TetWildError::Missing { looked_at })
}

/// The version of `pytetwild`; none where the Python does not start or cannot load it.
fn version_of(python: &Path) -> Option<String> {
    const ASK: &str = "import pytetwild; print('pytetwild', pytetwild.__version__)";
    let folder = tempfile::tempdir().ok()?;
    let limits = Limits {
        time: IMPORT_LIMIT,
        memory: None,
    };
    let run = process::run(
        python,
        &["-c", ASK],
        &[],
        folder.path(),
        "python.log",
        limits,
    );
    let run = run.ok()?;
    match run.ended {
        Ended::Exit(status) if status.success() => {}
        _ => return None,
    }
    let line = run.log.lines().find_map(|l| l.strip_prefix("pytetwild "))?;
    Some(line.trim().to_owned())
}

/// Fills what triangles enclose, however bad they are.
///
/// # Errors
/// See [`TetWildError`].
pub fn fill(
    tool: &TetWild,
    points: &[DVec3],
    triangles: &[[u32; 3]],
    options: &FillOptions,
) -> Result<Filling, TetWildError> {
    let budget = Budget::new(options.time_limit);
    fill_counted(tool, points, triangles, options, &budget)
}

/// As [`fill`], and takes the time that it took off the budget.
pub(super) fn fill_counted(
    tool: &TetWild,
    points: &[DVec3],
    triangles: &[[u32; 3]],
    options: &FillOptions,
    budget: &Budget,
) -> Result<Filling, TetWildError> {
    let (low, high) = triangles
        .iter()
        .flatten()
        .filter_map(|&i| points.get(i as usize))
        .fold((DVec3::INFINITY, DVec3::NEG_INFINITY), |(l, h), &p| {
            (l.min(p), h.max(p))
        });
    let diagonal = (high - low).length();
    let known = |t: &[u32; 3]| t.iter().all(|&i| (i as usize) < points.len());
    let sizes = [options.edge_length, options.envelope, diagonal];
    let fine = points.iter().all(|p| p.is_finite())
        && triangles.iter().all(known)
        && sizes.iter().all(|s| s.is_finite() && *s > 0.0);
    if !fine {
        return Err(TetWildError::BadSurface {
            points: points.len(),
            triangles: triangles.len(),
        });
    }
    let folder = tempfile::Builder::new().prefix("midshell-").tempdir();
    let folder = folder.map_err(|e| TetWildError::Run(e.to_string()))?;
    // Into the unit cube: fTetWild works with absolute tolerances of single precision, which a part in metres or far from the origin would fall below.
    let scale = 1.0 / diagonal;
    std::fs::write(
        folder.path().join("in.bin"),
        packed(points, triangles, low, scale),
    )
    .map_err(|e| TetWildError::Run(e.to_string()))?;
    let numbers = [
        options.edge_length * scale,
        options.envelope * scale,
        STOP_ENERGY,
    ];
    let numbers = numbers.map(|n| format!("{n:e}"));
    let passes = MOST_PASSES.to_string();
    let mut arguments = vec!["-c", PROGRAM];
    arguments.extend(numbers.iter().map(String::as_str));
    arguments.push(&passes);
    let limits = Limits {
        time: options.time_limit,
        memory: options.memory_limit,
    };
    let run = process::run(
        &tool.python,
        &arguments,
        // Threads of numpy's linear algebra, which is not used, would only reserve memory.
        &[("OPENBLAS_NUM_THREADS", Path::new("1"))],
        folder.path(),
        "tetwild.log",
        limits,
    )
    .map_err(|e| TetWildError::Run(e.to_string()))?;
    budget.charge(run.spent);
    let bytes = std::fs::read(folder.path().join("out.bin"));
    match (run.ended, bytes) {
        (Ended::TimedOut, _) => Err(TetWildError::TimedOut {
            limit: options.time_limit,
        }),
        (Ended::Exit(status), Ok(bytes)) if status.success() => unpacked(&bytes, low, scale),
        _ => Err(TetWildError::Failed {
            lines: run.last_words(),
        }),
    }
}

/// The mean energy of a tet at which fTetWild stops to improve them (a regular tet has 3): only connectivity counts here, so that
/// slivers may stay, and ten times its own limit costs a third less time.
const STOP_ENERGY: f64 = 100.0;

/// Passes over all tets after which fTetWild stops in any case. What it can insert it has inserted after three or four; one tet that
/// stays a little above the limit was seen to keep it at work for fifty.
const MOST_PASSES: usize = 12;

fn packed(points: &[DVec3], triangles: &[[u32; 3]], low: DVec3, scale: f64) -> Vec<u8> {
    let mut bytes = Vec::with_capacity(16 + 24 * points.len() + 12 * triangles.len());
    for count in [points.len(), triangles.len()] {
        bytes.extend((count as u64).to_le_bytes());
    }
    for p in points {
        for x in ((*p - low) * scale).to_array() {
            bytes.extend(x.to_le_bytes());
        }
    }
    for &i in triangles.iter().flatten() {
        bytes.extend(i.to_le_bytes());
    }
    bytes
}

fn unpacked(bytes: &[u8], low: DVec3, scale: f64) -> Result<Filling, TetWildError> {
    use TetWildError::BadResult;
    let (counts, rest) = bytes
        .split_first_chunk::<16>()
        .ok_or(BadResult("it is cut short"))?;
    let count = |at: usize| {
        counts[at..]
            .first_chunk::<8>()
            .map_or(0, |c| u64::from_le_bytes(*c))
    };
    let (n, m) = (count(0), count(8));
    let split = n
        .checked_mul(24)
        .and_then(|s| Some((s, s.checked_add(m.checked_mul(16)?)?)));
    let Some((split, length)) = split.filter(|s| s.1 == rest.len() as u64) else {
        return Err(BadResult("its length is not what it says"));
    };
    debug_assert!(split <= length);
    let (points, tets) = rest.split_at(split as usize);
    let points: Vec<DVec3> = points
        .chunks_exact(24)
        .map(|c| {
            let x = |k: usize| {
                c[8 * k..]
                    .first_chunk::<8>()
                    .map_or(f64::NAN, |b| f64::from_le_bytes(*b))
            };
            DVec3::new(x(0), x(1), x(2)) / scale + low
        })
        .collect();
    if points.iter().any(|p| !p.is_finite()) {
        return Err(BadResult("a coordinate is not finite"));
    }
    let mut cells: Vec<[u32; 4]> = Vec::with_capacity(tets.len() / 16);
    for c in tets.chunks_exact(16) {
        let node = |k: usize| {
            c[4 * k..]
                .first_chunk::<4>()
                .map_or(u32::MAX, |b| u32::from_le_bytes(*b))
        };
        let mut tet = [node(0), node(1), node(2), node(3)];
        if tet.iter().any(|&i| i as usize >= points.len()) {
            return Err(BadResult("a tet names a point that does not exist"));
        }
        let [a, b, c, d] = tet.map(|i| points[i as usize]);
        let volume = (b - a).dot((c - a).cross(d - a));
        if volume == 0.0 {
            return Err(BadResult("a tet is flat"));
        }
        if volume < 0.0 {
            tet.swap(0, 1);
        }
        cells.push(tet);
    }
    if cells.is_empty() {
        return Err(BadResult("it has no tets"));
    }
    Ok(Filling {
        points,
        tets: cells,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    const POINTS: [DVec3; 4] = [DVec3::ZERO, DVec3::X, DVec3::Y, DVec3::Z];
    const TRIANGLES: [[u32; 3]; 4] = [[0, 2, 1], [0, 1, 3], [1, 2, 3], [0, 3, 2]];

    #[cfg(unix)]
    /// Fills one tet with a Python that does what the shell script says in place of fTetWild.
    fn with_fake(script: &str) -> Result<Filling, TetWildError> {
        use std::os::unix::fs::PermissionsExt;
        let folder = tempfile::tempdir().unwrap();
        let python = folder.path().join("python3");
        std::fs::write(&python, format!("#!/bin/sh\n{script}\n")).unwrap();
        std::fs::set_permissions(&python, std::fs::Permissions::from_mode(0o755)).unwrap();
        let tool = TetWild {
            python,
            version: String::new(),
        };
        let options = FillOptions {
            edge_length: 1.0,
            envelope: 0.01,
            time_limit: Duration::from_secs(1),
            memory_limit: None,
        };
        fill(&tool, &POINTS, &TRIANGLES, &options)
    }

    #[cfg(unix)]
    #[test]
    fn one_that_fails_hangs_or_writes_rubbish_is_told_apart() {
        let failed = with_fake("echo 'MemoryError: no room' >&2; exit 1").unwrap_err();
        assert!(failed.to_string().contains("no room"), "{failed}");
        let hung = with_fake("sleep 60").unwrap_err();
        assert!(matches!(hung, TetWildError::TimedOut { .. }), "{hung}");
        for rubbish in [
            "printf hello > out.bin",
            "head -c 16 /dev/zero > out.bin",
            "exit 0",
        ] {
            let error = with_fake(rubbish).unwrap_err();
            let told = matches!(
                error,
                TetWildError::BadResult(_) | TetWildError::Failed { .. }
            );
            assert!(told, "{rubbish}: {error}");
        }
    }

    #[test]
    fn results_are_scaled_back_and_turned_the_right_way() {
        let (low, scale) = (DVec3::new(5.0, 6.0, 7.0), 0.25);
        let mut bytes = packed(&POINTS, &[], DVec3::ZERO, 1.0);
        bytes[8] = 1;
        // This one has a negative volume.
        for i in [1u32, 0, 2, 3] {
            bytes.extend(i.to_le_bytes());
        }
        let filling = unpacked(&bytes, low, scale).unwrap();
        assert_eq!(filling.points[1], DVec3::new(9.0, 6.0, 7.0));
        assert_eq!(filling.tets, [[0, 1, 2, 3]]);
        // A point that does not exist.
        let last = bytes.len() - 4;
        bytes[last] = 4;
        assert!(unpacked(&bytes, low, scale).is_err());
    }

    #[test]
    fn surfaces_that_are_none_are_refused_before_anything_is_started() {
        let tool = TetWild {
            python: PathBuf::from("/nonexistent"),
            version: String::new(),
        };
        let options = FillOptions {
            edge_length: 1.0,
            envelope: 0.01,
            time_limit: Duration::from_secs(1),
            memory_limit: None,
        };
        let bad = |points: &[DVec3], triangles: &[[u32; 3]]| {
            let error = fill(&tool, points, triangles, &options).unwrap_err();
            assert!(matches!(error, TetWildError::BadSurface { .. }), "{error}");
        };
        bad(&POINTS, &[]);
        bad(&POINTS, &[[0, 1, 4]]);
        bad(&[DVec3::NAN, DVec3::X, DVec3::Y], &[[0, 1, 2]]);
    }
}
