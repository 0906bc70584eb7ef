//! Import does not give up: the order of its attempts, seen with a gmsh that fails in some of them, and the last resort. Needs gmsh and
//! pytetwild: `make test` installs both. `MIDSHELL_SKIP_TETWILD` lets the tests of the last resort pass on a machine that cannot have it.

#![cfg(unix)]
#![allow(clippy::unwrap_used, clippy::panic)]

mod binary;

use binary::{Bench, PLATE, gmsh};
use glam::DVec3;
use midshell::import::tetwild::{FillOptions, fill, find_tetwild};
use midshell::import::{ImportOptions, Imported, import_cad};
use std::path::Path;
use std::time::{Duration, Instant};

/// What gmsh says of the plate before it meshes.
const FACTS: &str = "echo \"Info : Running 'gmsh' [Gmsh 4.15.2, 1 node, max. 1 thread]\"
echo 'midshell: solid 1 volume 12000 area 12640 diagonal 116.6'
echo 'midshell: solids 1 surfaces 6 open 0 thickness 1.9 area 12640'";

/// A gmsh that does `deed` in its first `failures` runs and works after that.
fn failing(bench: &Bench, failures: usize, deed: &str) -> ImportOptions {
    let script = format!(
        "n=$(cat '{count}' 2>/dev/null || echo 0); n=$((n + 1)); echo $n > '{count}'
if [ $n -le {failures} ]; then
{FACTS}
{deed}
fi
exec '{gmsh}' \"$@\"",
        count = bench.at("count").display(),
        gmsh = gmsh().display(),
    );
    options(bench, &script)
}

fn options(bench: &Bench, script: &str) -> ImportOptions {
    ImportOptions {
        gmsh: Some(bench.program("failing-gmsh", script)),
        ..ImportOptions::default()
    }
}

fn imported(path: &Path, options: &ImportOptions) -> Imported {
    import_cad(path, options).unwrap_or_else(|e| panic!("{e}"))
}

const NO_HXT: &str = "echo 'Error   : HXT 3D mesh failed'; exit 1";

#[test]
fn each_attempt_follows_the_one_before() {
    let order = [
        "HXT",
        "Delaunay",
        "Frontal",
        "even size of two thicknesses",
        "even size of half a thickness",
        "healed, surface Delaunay",
        "healed, surface by MeshAdapt",
    ];
    for failures in 0..order.len() {
        let bench = Bench::new();
        let input = bench.step("plate.step", PLATE);
        let found = imported(&input, &failing(&bench, failures, NO_HXT));
        assert_eq!(found.way, order[failures]);
        assert_eq!(found.attempts.len(), failures);
        for (line, name) in found.attempts.iter().zip(order) {
            assert!(
                line.starts_with(name) && line.contains("HXT 3D mesh failed"),
                "{line}"
            );
        }
        assert!((found.pieces[0].brep.volume() - 12_000.0).abs() < 1e-6);
    }
}

#[test]
fn one_attempt_that_hangs_leaves_time_for_another() {
    let bench = Bench::new();
    let input = bench.step("plate.step", PLATE);
    let options = ImportOptions {
        time_limit: Duration::from_secs(20),
        ..failing(&bench, 1, "while :; do :; done")
    };
    let start = Instant::now();
    let found = imported(&input, &options);
    assert_eq!(found.way, "even size of two thicknesses");
    assert_eq!(found.attempts, ["HXT: out of time"]);
    assert!(start.elapsed() < 4 * options.time_limit);
}

#[test]
fn a_mesh_without_the_volume_of_the_solid_is_not_believed() {
    let bench = Bench::new();
    let input = bench.step("plate.step", PLATE);
    // The real gmsh meshes, and then a solid of twice the volume is claimed, with one face more.
    let script = format!(
        "echo 'midshell: solid 1 volume 24000 area 12640 diagonal 116.6'
echo 'midshell: solids 1 surfaces 7 open 0 thickness 3.8 area 12640'\nexec '{}' \"$@\"",
        gmsh().display()
    );
    let options = ImportOptions {
        time_limit: Duration::from_secs(10),
        ..options(&bench, &script)
    };
    let error = import_cad(&input, &options).unwrap_err();
    assert!(
        error.to_string().contains("50.0 % of its volume"),
        "{error}"
    );
}

#[test]
fn two_meshes_that_agree_are_believed_against_the_cad_kernel() {
    let bench = Bench::new();
    let script = include_str!("parts/one_face.geo");
    let input = bench.step("one_face.step", script);
    let ended = bench.mesh(&input, &["--json", "one_face.json"]);
    assert_eq!(ended.status, Some(0), "{}", ended.stderr);
    assert!(
        ended
            .stdout
            .contains("differs from that of two different meshes"),
        "{}",
        ended.stdout
    );
    let report = std::fs::read_to_string(bench.at("one_face.json")).unwrap();
    let report: serde_json::Value = serde_json::from_str(&report).unwrap();
    let solid = &report["solids"][0];
    // Its one face is divided: a wall with two sides, and one sheet.
    assert_eq!((&solid["walls"], &solid["sheets"]), (&1.into(), &1.into()));
    // 2 W ((pi - g) R + T / 2), to the crests of its round ends.
    let area = report["quality"]["area"].as_f64().unwrap();
    assert!((area / 2056.354 - 1.0).abs() < 0.01, "{area}");
    let thickness = report["audit"]["thickness_median"].as_f64().unwrap();
    assert!((thickness - 4.0).abs() < 0.01, "{thickness}");
}

/// Fills surfaces well and fails in every volume.
fn surfaces_only(bench: &Bench) -> ImportOptions {
    let script = format!(
        "if grep -q 'Mesh 3;' run.geo 2>/dev/null; then\n{FACTS}\n{NO_HXT}\nfi\nexec '{}' \"$@\"",
        gmsh().display()
    );
    options(bench, &script)
}

fn has_tetwild() -> bool {
    if std::env::var_os("MIDSHELL_SKIP_TETWILD").is_some() {
        return false;
    }
    find_tetwild(Some(&gmsh())).unwrap_or_else(|e| panic!("{e}: `make test` installs it"));
    true
}

#[test]
fn what_gmsh_cannot_fill_is_filled_by_ftetwild() {
    if !has_tetwild() {
        return;
    }
    let bench = Bench::new();
    let bent = "Box(1) = {0,0,0, 40,30,2}; Cylinder(2) = {0,0,10, 40,0,0, 12}; Cylinder(3) = {0,0,10, 40,0,0, 10};
BooleanDifference(4) = { Volume{2}; Delete; }{ Volume{3}; Delete; };
Box(5) = {0,0,-20, 40,40,60};
BooleanIntersection(6) = { Volume{4}; Delete; }{ Volume{5}; Delete; };
Delete { Volume{1}; Surface{:}; Curve{:}; Point{:}; }";
    for (script, volume, faces) in [
        (PLATE, 12_000.0, 6),
        (bent, 40.0 * 22.0 * std::f64::consts::PI * 2.0 / 2.0, 6),
    ] {
        let input = bench.step("part.step", script);
        let found = imported(&input, &surfaces_only(&bench));
        assert!(found.way.starts_with("fTetWild"), "{}", found.way);
        assert!(found.attempts.len() >= 4, "{:?}", found.attempts);
        let brep = &found.pieces[0].brep;
        assert!(brep.check().is_empty());
        assert_eq!((brep.faces.len(), brep.euler()), (faces, 2));
        // Flat facets round the bend sag; the curved ones are held against the volume by import itself.
        assert!(
            (brep.volume() / volume - 1.0).abs() < 0.02,
            "{}",
            brep.volume()
        );
    }
}

/// Facets of a box with the given counts of squares along its edges; each square is two triangles of its own corners.
fn box_facets(counts: [usize; 3]) -> (Vec<DVec3>, Vec<[u32; 3]>) {
    let (mut points, mut triangles) = (Vec::new(), Vec::new());
    for axis in 0..3 {
        let (u, v) = ((axis + 1) % 3, (axis + 2) % 3);
        for (i, j, end) in (0..counts[u])
            .flat_map(|i| (0..counts[v]).flat_map(move |j| [(i, j, false), (i, j, true)]))
        {
            let corner = |a: usize, b: usize| {
                let mut p = [0.0; 3];
                p[u] = (i + a) as f64;
                p[v] = (j + b) as f64;
                p[axis] = if end { counts[axis] as f64 } else { 0.0 };
                DVec3::from(p)
            };
            let at = points.len() as u32;
            points.extend([corner(0, 0), corner(1, 0), corner(1, 1), corner(0, 1)]);
            for [a, b, c] in [[0, 1, 2], [0, 2, 3]] {
                let (b, c) = if end { (b, c) } else { (c, b) };
                triangles.push([at + a, at + b, at + c]);
            }
        }
    }
    (points, triangles)
}

#[cfg(all(
    target_os = "linux",
    any(target_arch = "x86_64", target_arch = "aarch64")
))]
#[test]
fn ftetwild_fills_the_same_surface_in_the_same_way() {
    if !has_tetwild() {
        return;
    }
    let tool = find_tetwild(Some(&gmsh())).unwrap();
    let (points, triangles) = box_facets([12, 9, 2]);
    let options = FillOptions {
        edge_length: 1.0,
        envelope: 0.02,
        time_limit: std::time::Duration::from_secs(60),
        memory_limit: None,
    };
    let first = fill(&tool, &points, &triangles, &options).unwrap();
    let volume: f64 = (first.tets.iter())
        .map(|t| {
            let [a, b, c, d] = t.map(|i| first.points[i as usize]);
            (b - a).dot((c - a).cross(d - a)) / 6.0
        })
        .sum();
    assert!((volume / 216.0 - 1.0).abs() < 0.01, "{volume}");
    for _ in 0..2 {
        let again = fill(&tool, &points, &triangles, &options).unwrap();
        assert!(first == again, "the filling differs from run to run");
    }
}

#[test]
fn without_ftetwild_the_message_tells_how_to_get_it() {
    let bench = Bench::new();
    let input = bench.step("plate.step", PLATE);
    let fake = surfaces_only(&bench).gmsh.unwrap();
    let bare = bench.program("bare-python", "exit 1");
    let mut command = bench.midshell();
    command.arg("mesh").arg(&input).args(["-o", "out.vtu"]);
    command
        .env("MIDSHELL_PYTHON", &bare)
        .arg("--gmsh")
        .arg(&fake);
    let ended = bench.run(command);
    ended.refused(
        5,
        &["plate.step", "HXT 3D mesh failed", "pip install pytetwild"],
    );
}
