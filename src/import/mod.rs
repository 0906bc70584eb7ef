//! Import: a CAD or facet file in, one [`Piece`] a solid out.
//!
//! STEP, IGES and OpenCASCADE BREP go through one run of the `gmsh` command an attempt (their order: `script.rs`; the last: `last_resort.rs`): it reads and
//! heals the file, converts the unit to mm, tessellates every face with six-node triangles and fills the volume with tets; its binary mesh is read here. STL,
//! OBJ and PLY are read here, see [`facet`].
//!
//! Guarantees: every piece is closed, outward oriented and filled, and its facets are exactly the boundary of its tets (see [`piece`]). The result
//! depends on the file and the options only, not on how many threads this program uses (for a part that only fTetWild fills: where
//! [`tetwild`] says so). Nothing is left behind: all files live in a private temporary
//! folder, and gmsh is killed when its time is over (processor time, see `spent.rs`). What was tried in vain is told in [`Imported::attempts`].
//!
//! Limits: made for gmsh 4.15; one too old for the script is refused with its own words. Gmsh cannot fill a part whose faces overlap or touch from two sides (a slit without
//! width); that is left to fTetWild. Face names are known only where the file has them as physical groups, which gmsh makes of no STEP file.
//!
//! Reference: C. Geuzaine, J.-F. Remacle, "Gmsh: a three-dimensional finite element mesh generator", IJNME 79 (2009), doi:10.1002/nme.2579.

mod ears;
mod error;
pub mod facet;
mod gmsh;
mod header;
mod last_resort;
pub mod msh;
pub mod piece;
mod pinch;
mod process;
mod relabel;
mod script;
mod skin;
mod spent;
pub mod tetwild;
mod volume;

use std::path::{Path, PathBuf};
use std::time::Duration;

pub use error::{ImportError, MeshFault};
pub use gmsh::{Gmsh, INSTALL, find_gmsh};
pub use tetwild::TetWildError;

use crate::model::brep::Brep;
use crate::model::length_unit::LengthUnit;
use crate::model::tets::Tets;
use gmsh::Launcher;
use piece::PieceError;
use process::{Ended, Limits, Run};
use script::{ATTEMPTS, Attempt, Facts, SolidFacts};
use spent::Budget;
use volume::{Doubted, OUTVOTED};

/// One solid: its boundary and the tets that fill it.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Piece {
    /// The boundary, with the vertices of both.
    pub brep: Brep,
    /// The filling.
    pub tets: Tets,
}

/// Address space for one child, bytes. The largest of our real parts need 1 GB; a runaway must not take the machine with it.
const MEMORY_LIMIT: u64 = 16 << 30;

/// How to import.
#[derive(Clone, Debug, PartialEq)]
pub struct ImportOptions {
    /// The gmsh to use; found by [`find_gmsh`] where none is named.
    pub gmsh: Option<PathBuf>,
    /// Unit of files that name none (STL, OBJ, PLY); mm where none is given. Other files name their own.
    pub unit: Option<LengthUnit>,
    /// Factor on the size of facets and tets; 1 is some three thicknesses.
    pub size_factor: f64,
    /// Longest that all attempts may take together, of processor time of the foreign programs; four times as long by the clock.
    pub time_limit: Duration,
    /// Threads of gmsh. More than one is faster, but the mesh depends on their number; one where none is given.
    pub threads: Option<usize>,
    /// Address space of each child, bytes (Unix only); unlimited where none is given.
    pub memory_limit: Option<u64>,
}

impl Default for ImportOptions {
    fn default() -> Self {
        Self {
            gmsh: None,
            unit: None,
            size_factor: 1.0,
            time_limit: Duration::from_secs(58),
            threads: None,
            memory_limit: Some(MEMORY_LIMIT),
        }
    }
}

/// The solids of a file.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Imported {
    /// One a solid, in the order of the file.
    pub pieces: Vec<Piece>,
    /// The version of the gmsh that made them.
    pub gmsh_version: String,
    /// The way that led to success, in words.
    pub way: String,
    /// What was tried before in vain, and why it failed, in order; empty where the first attempt went well.
    pub attempts: Vec<String>,
    /// What the user should know of how the file was read: an assumed unit, an absurd size.
    pub notes: Vec<String>,
}

/// Reads a CAD or facet file and fills its solids.
///
/// # Errors
/// See [`ImportError`]; each has a remedy.
pub fn import_cad(path: &Path, options: &ImportOptions) -> Result<Imported, ImportError> {
    import_cad_told(path, options, &mut |_| {})
}

/// As [`import_cad`], and tells of every attempt, one line as it begins and one with the reason where it fails.
///
/// # Errors
/// See [`ImportError`]; each has a remedy.
pub fn import_cad_told(
    path: &Path,
    options: &ImportOptions,
    tell: &mut dyn FnMut(&str),
) -> Result<Imported, ImportError> {
    let format = match header::look_at(path)? {
        header::Format::Cad(format) => format,
        header::Format::Facets(format) => return facet::import_facets(path, format, options, tell),
    };
    let launcher = Launcher::find(options.gmsh.as_deref())?;
    let here = |cause| ImportError::NoFolder {
        path: std::env::temp_dir(),
        cause,
    };
    let folder = tempfile::Builder::new()
        .prefix("midshell-")
        .tempdir()
        .map_err(here)?;
    let job = Job {
        path,
        extension: format.extension(),
        launcher,
        options,
        folder: folder.path(),
        budget: Budget::new(options.time_limit),
    };
    job.bring_input()?;
    let mut imported = job.run(tell)?;
    if let Some(unit) = options.unit {
        let note = format!("--unit {unit} is for STL, OBJ and PLY: this file says its own");
        tell(&note);
        imported.notes.push(note);
    }
    Ok(imported)
}

/// How an attempt failed.
enum Failure {
    Gmsh {
        log: String,
        reason: String,
    },
    Mesh {
        fault: MeshFault,
        log: String,
    },
    /// Filled, but not of the volume that the CAD kernel measures.
    Volume {
        fault: MeshFault,
        pieces: Vec<Piece>,
        log: String,
    },
    Time {
        log: String,
    },
}

impl Failure {
    fn log(&self) -> &str {
        match self {
            Self::Gmsh { log, .. }
            | Self::Mesh { log, .. }
            | Self::Volume { log, .. }
            | Self::Time { log } => log,
        }
    }

    fn reason(&self) -> String {
        match self {
            Self::Gmsh { reason, .. } => reason.clone(),
            Self::Mesh { fault, .. } | Self::Volume { fault, .. } => fault.to_string(),
            Self::Time { .. } => "out of time".to_owned(),
        }
    }
}

/// Share of the time limit that one run of gmsh may take. Of 61 real parts that gmsh fills, the largest took 25 s on a busy machine.
const ATTEMPT_SHARE: f64 = 0.5;
/// Share of the time limit that all runs of gmsh may take; the rest is for fTetWild, which takes 10 to 30 s.
pub(in crate::import) const GMSH_SHARE: f64 = 0.6;
struct Job<'a> {
    path: &'a Path,
    extension: &'static str,
    launcher: Launcher,
    options: &'a ImportOptions,
    folder: &'a Path,
    budget: Budget,
}

impl Job<'_> {
    /// Gives the input a plain name in the working folder, so that no character of its path has to be quoted.
    fn bring_input(&self) -> Result<(), ImportError> {
        let unreadable = |cause| ImportError::Unreadable {
            path: self.path.to_path_buf(),
            cause,
        };
        let source = self.path.canonicalize().map_err(unreadable)?;
        let target = self
            .folder
            .join(format!("{}.{}", script::INPUT, self.extension));
        #[cfg(unix)]
        let linked = std::os::unix::fs::symlink(&source, &target).is_ok();
        #[cfg(not(unix))]
        let linked = false;
        if !linked {
            std::fs::copy(&source, &target).map_err(unreadable)?;
        }
        Ok(())
    }

    fn run(&self, tell: &mut dyn FnMut(&str)) -> Result<Imported, ImportError> {
        let limit = self.options.time_limit;
        let mut attempts: Vec<String> = Vec::new();
        let mut facts = Facts::default();
        let mut last: Option<Failure> = None;
        let mut doubted = Doubted::default();
        for attempt in &ATTEMPTS {
            let out_of_time = matches!(last, Some(Failure::Time { .. }));
            if let Some(failure) = &last
                && (!attempt.is_worth_it(failure.log(), out_of_time, facts)
                    || doubted.knows_surface_of(attempt))
            {
                continue;
            }
            let left = self.budget.left_of(GMSH_SHARE);
            if left.is_zero() {
                break;
            }
            tell(attempt.name);
            let run = self.start(attempt, facts, left.min(limit.mul_f64(ATTEMPT_SHARE)))?;
            let version = gmsh::version_in(&run.log);
            if version.is_none() && !matches!(run.ended, Ended::TimedOut) {
                return Err(ImportError::GmshUnusable {
                    gmsh: self.launcher.path.clone(),
                    lines: run.last_words(),
                });
            }
            if let Some(found) = Facts::in_log(&run.log) {
                // Sewing that makes no solid of the surfaces tells nothing new.
                if found.solids > 0 || last.is_none() {
                    facts = found;
                }
            } else if last.is_none() {
                return Err(match run.ended {
                    Ended::Exit(_) => self.not_read(&run.log),
                    Ended::TimedOut => {
                        attempts.push(format!(
                            "{}: out of time before the file was read",
                            attempt.name
                        ));
                        self.out_of_time(attempts)
                    }
                });
            }
            match self.read(run) {
                Ok(pieces) => {
                    return Ok(Imported {
                        pieces,
                        gmsh_version: version.unwrap_or_default(),
                        way: attempt.name.to_owned(),
                        attempts,
                        notes: Vec::new(),
                    });
                }
                Err(mut failure) => {
                    let line = format!("{}: {}", attempt.name, failure.reason());
                    tell(&line);
                    attempts.push(line);
                    if let Failure::Volume { pieces, .. } = &mut failure
                        && let Some(agreed) =
                            doubted.agree(*attempt, std::mem::take(pieces), facts.surfaces)
                    {
                        return Ok(Imported {
                            pieces: agreed,
                            gmsh_version: version.unwrap_or_default(),
                            way: attempt.name.to_owned(),
                            attempts,
                            notes: vec![OUTVOTED.to_owned()],
                        });
                    }
                    last = Some(failure);
                }
            }
        }
        if facts.solids > 0
            && !facts.is_open()
            && let Some(imported) = last_resort::try_it(self, facts, &mut attempts, tell)?
        {
            return Ok(imported);
        }
        Err(self.give_up(facts, last, attempts))
    }

    fn out_of_time(&self, attempts: Vec<String>) -> ImportError {
        ImportError::TimedOut {
            path: self.path.to_path_buf(),
            limit: self.options.time_limit,
            attempts,
        }
    }

    fn start(&self, attempt: &Attempt, facts: Facts, left: Duration) -> Result<Run, ImportError> {
        let unreadable = |cause| ImportError::NoFolder {
            path: self.folder.to_path_buf(),
            cause,
        };
        // Healing takes away what is far smaller than the wall and keeps the wall's own edges.
        let tolerance = facts.thickness_mm.max(f64::MIN_POSITIVE) * 1e-3;
        let text = attempt.script(self.extension, self.options.size_factor, tolerance);
        std::fs::write(self.folder.join(script::SCRIPT), text).map_err(unreadable)?;
        // The mesh of an attempt that failed half-way must not be taken for this one's.
        match std::fs::remove_file(self.folder.join(script::MESH)) {
            Err(cause) if cause.kind() != std::io::ErrorKind::NotFound => {
                return Err(unreadable(cause));
            }
            _ => {}
        }
        let threads = self.options.threads.unwrap_or(1).max(1).to_string();
        let run = self
            .launcher
            .run(
                self.folder,
                &[script::SCRIPT, "-nt", &threads, "-"],
                Limits {
                    time: left,
                    memory: self.options.memory_limit,
                },
            )
            .map_err(|cause| ImportError::GmshUnusable {
                gmsh: self.launcher.path.clone(),
                lines: vec![cause.to_string()],
            })?;
        self.budget.charge(run.spent);
        Ok(run)
    }

    fn read(&self, run: Run) -> Result<Vec<Piece>, Failure> {
        let Run { ended, log, .. } = run;
        let bytes = std::fs::read(self.folder.join(script::MESH));
        let Ended::Exit(status) = ended else {
            return Err(Failure::Time { log });
        };
        let bytes = match bytes {
            Ok(bytes) if status.success() => bytes,
            _ => {
                let lines = gmsh::error_lines(&log);
                let reason = if status.success() || status.code() == Some(1) {
                    lines.join(" | ")
                } else {
                    format!("{status} | {}", lines.join(" | "))
                };
                return Err(Failure::Gmsh { log, reason });
            }
        };
        msh::Msh::parse(&bytes)
            .map_err(MeshFault::from)
            .and_then(|msh| piece::build_pieces(&msh).map_err(MeshFault::from))
            .map_err(|fault| match fault {
                // Gmsh may write the surfaces alone after an error: the error is the cause then.
                MeshFault::Piece(PieceError::NotFilled { .. }) if log.contains("Error") => {
                    let reason = gmsh::error_lines(&log).join(" | ");
                    Failure::Gmsh {
                        log: log.clone(),
                        reason,
                    }
                }
                fault => Failure::Mesh {
                    fault,
                    log: log.clone(),
                },
            })
            .and_then(|pieces| {
                let solids = SolidFacts::in_log(&log);
                match pieces.iter().find_map(|p| volume::fault(p, &solids)) {
                    None => Ok(pieces),
                    Some(fault) => Err(Failure::Volume { fault, pieces, log }),
                }
            })
    }

    /// The error where gmsh did not come past reading the file.
    fn not_read(&self, log: &str) -> ImportError {
        let path = self.path.to_path_buf();
        let lines = gmsh::error_lines(log);
        // An error that names the script's own line is a gmsh too old for the script.
        if lines.iter().any(|l| l.contains(script::SCRIPT)) {
            let attempts = vec![format!("{}: the script was refused", ATTEMPTS[0].name)];
            return ImportError::GmshFailed {
                path,
                attempts,
                lines,
            };
        }
        ImportError::NotCad {
            path,
            reason: format!("gmsh cannot read it ({})", lines.join(" | ")),
        }
    }

    /// Whether a STEP file speaks of a solid, though its shell may be too broken to become one.
    fn claims_a_solid(&self) -> bool {
        std::fs::read(self.path).is_ok_and(|bytes| {
            ["SOLID_BREP", "BREP_WITH_VOIDS"]
                .iter()
                .any(|mark| bytes.windows(mark.len()).any(|w| w == mark.as_bytes()))
        })
    }

    fn give_up(&self, facts: Facts, last: Option<Failure>, attempts: Vec<String>) -> ImportError {
        let path = self.path.to_path_buf();
        if facts.solids == 0 && facts.open_mm > 0.0 && self.claims_a_solid() {
            return ImportError::NotClosed {
                path,
                length_mm: facts.open_mm,
            };
        }
        if facts.solids == 0 {
            return ImportError::NoSolid {
                path,
                surfaces: facts.surfaces,
            };
        }
        if facts.is_open() {
            return ImportError::NotClosed {
                path,
                length_mm: facts.open_mm,
            };
        }
        match last {
            Some(Failure::Time { .. }) => self.out_of_time(attempts),
            Some(Failure::Mesh { fault, .. } | Failure::Volume { fault, .. }) => {
                ImportError::BadMesh {
                    path,
                    cause: fault,
                    attempts,
                }
            }
            Some(Failure::Gmsh { log, .. }) => ImportError::GmshFailed {
                path,
                attempts,
                lines: gmsh::error_lines(&log),
            },
            None => ImportError::GmshFailed {
                path,
                attempts,
                lines: Vec::new(),
            },
        }
    }
}
