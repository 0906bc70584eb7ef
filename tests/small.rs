//! Small holes and features taken out (`--min-hole`, `--min-feature`), and faces' inner edges, which are none to the mesh: held against closed forms and against the solid that never had them.
//!
//! `fixtures/small/NAME.geo` makes a solid with and without what is small; `NAME.toml` are the facts of the one without.

#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic)]
#![allow(dead_code)] // what the fixtures' families need of `common`

#[allow(unused_macros)]
mod common;

use common::facts::Facts;
use common::measured::SolidFacts;
use common::step::{MOTION, Variant, generate, step};
use common::tools;
use serde_json::Value;
use std::path::{Path, PathBuf};
use std::time::Duration;

const LIMIT: Duration = Duration::from_secs(300);
/// What is small in the fixtures, and how many holes and features that is.
const CASES: [(&str, &[&str], [usize; 2]); 3] = [
    ("drilled_tube", &["--min-hole", "9"], [3, 0]),
    // The rest of the counterbored hole is a recess.
    (
        "drilled_plate",
        &["--min-hole", "8", "--min-feature", "9"],
        [6, 1],
    ),
    ("marked_plate", &["--min-feature", "8"], [0, 5]),
];

/// The solid of a fixture, with or without what is small, moved or as made.
fn solid(name: &str, small: bool, moved: bool, folder: &Path) -> PathBuf {
    let script = tools::root().join(format!("fixtures/small/{name}.geo"));
    let mut text = std::fs::read_to_string(script).unwrap();
    assert!(text.contains("small = 1;"));
    if !small {
        text = text.replace("small = 1;", "small = 0;");
    }
    if moved {
        let save = format!("Save \"{name}.step\";");
        text = text.replace(&save, &format!("{MOTION}{save}"));
    }
    let place = folder.join(format!("{name}-{small}-{moved}"));
    std::fs::create_dir_all(&place).unwrap();
    generate(name, &text, 1.0, &place)
}

/// The file that the binary makes of a solid; it must find its own result right.
fn mesh(solid: &Path, output: PathBuf, arguments: &[&str]) -> (PathBuf, Value) {
    let mut command = tools::with_gmsh(env!("CARGO_BIN_EXE_midshell"));
    let json = output.with_extension("json");
    command.arg("mesh").arg(solid).arg("-o").arg(&output);
    command.arg("--json").arg(&json).args(arguments);
    tools::run(command, LIMIT);
    let report = std::fs::read_to_string(json).unwrap();
    (output, serde_json::from_str(&report).unwrap())
}

fn sized(facts: &Facts) -> Vec<String> {
    let mut all = vec!["--size".to_owned(), facts.size.to_string()];
    if let Some(n) = facts.size_curvature {
        all.extend(["--size-curvature".to_owned(), n.to_string()]);
    }
    all
}

fn counted(report: &Value, kind: &str) -> usize {
    let removed = report["removed"].as_array().map_or(&[][..], |a| a);
    removed.iter().filter(|r| r["kind"] == kind).count()
}

/// A case meshed without what is small has to meet the facts of the solid that never had it.
fn meets_the_facts(index: usize, moved: bool) {
    let (name, limits, [holes, features]) = CASES[index];
    let facts = Facts::of(&format!("small/{name}"));
    let folder = common::scratch();
    let drilled = solid(name, true, moved, folder.path());
    let plain = solid(name, false, moved, folder.path());
    let size = sized(&facts);
    let arguments: Vec<&str> = limits
        .iter()
        .copied()
        .chain(size.iter().map(|s| &s[..]))
        .collect();
    let (vtu, report) = mesh(&drilled, folder.path().join("out.vtu"), &arguments);
    assert_eq!(counted(&report, "hole"), holes, "{}", report["removed"]);
    assert_eq!(
        counted(&report, "feature"),
        features,
        "{}",
        report["removed"]
    );
    assert!(report["left"].is_null(), "{}", report["left"]);
    for removed in report["removed"].as_array().unwrap() {
        assert!(removed["sheet"].is_u64() && removed["size"].as_f64().unwrap() > 0.0);
    }
    let wrong = facts.violations(&common::measure(&plain, &vtu, &facts, 1.0));
    assert!(wrong.is_empty(), "{name}:\n  {}", wrong.join("\n  "));
}

#[test]
fn a_drilled_tube_is_a_tube() {
    meets_the_facts(0, false);
    meets_the_facts(0, true);
}

#[test]
fn a_drilled_plate_is_a_plate() {
    meets_the_facts(1, false);
    meets_the_facts(1, true);
}

#[test]
fn a_marked_plate_is_a_plate() {
    meets_the_facts(2, false);
    meets_the_facts(2, true);
}

#[test]
fn holes_below_the_limit_go_and_are_told_the_others_and_the_rim_stay() {
    let folder = common::scratch();
    let plate = step("plate_holes", Variant::AsMade);
    // Round holes 16 and 10 across, one of 14 by 10: as long as a circle 48 / pi across.
    let cases = [
        ("9.99", 0),
        ("10", 0),
        ("10.01", 1),
        ("15.3", 2),
        ("16.1", 3),
        ("94", 3),
    ];
    for (limit, filled) in cases {
        let out = folder.path().join(format!("{limit}.vtu"));
        let (_, report) = mesh(&plate, out, &["--min-hole", limit, "--size", "4"]);
        assert_eq!(counted(&report, "hole"), filled, "{limit}");
        assert_eq!(report["audit"]["euler"], -2 + filled as i64, "{limit}");
        assert_eq!(
            report["audit"]["euler_solid"],
            -2.0 + filled as f64,
            "{limit}"
        );
        assert!(report["left"].is_null());
    }
    let (_, report) = mesh(&plate, folder.path().join("one.vtu"), &["--min-hole", "11"]);
    let hole = &report["removed"][0];
    let number = |v: &Value| v.as_f64().unwrap();
    assert!((number(&hole["size"]) - 10.0).abs() < 1e-6, "{hole}");
    for (k, want) in [42.0, 14.0, 1.5].into_iter().enumerate() {
        assert!((number(&hole["at"][k]) - want).abs() < 1e-6, "{hole}");
    }
}

#[test]
fn the_ends_of_a_tube_are_left_and_told() {
    let folder = common::scratch();
    let tube = step("tube", Variant::AsMade);
    let (_, report) = mesh(&tube, folder.path().join("tube.vtu"), &["--min-hole", "60"]);
    assert_eq!(counted(&report, "hole"), 0);
    let left = report["left"].as_array().unwrap();
    assert!(
        left.len() == 2 && left.iter().all(|l| l["why"] == "end"),
        "{left:?}"
    );
    assert_eq!(report["audit"]["euler"], 0);
}

#[test]
fn limits_that_nothing_is_below_change_no_byte() {
    let folder = common::scratch();
    for name in ["plate_holes", "emboss", "boss_on_rib"] {
        let part = step(name, Variant::AsMade);
        let made = [&[][..], &["--min-hole", "0.01", "--min-feature", "0.01"]].map(|limits| {
            let (vtu, _) = mesh(&part, folder.path().join("out.vtu"), limits);
            std::fs::read(vtu).unwrap()
        });
        assert!(made[0] == made[1], "{name}");
    }
}

#[test]
fn filled_meshes_are_the_same_for_any_number_of_threads() {
    let folder = common::scratch();
    let (name, limits, _) = CASES[1];
    let part = solid(name, true, false, folder.path());
    let made = ["1", "4"].map(|threads| {
        let all: Vec<&str> = limits
            .iter()
            .copied()
            .chain(["--threads", threads])
            .collect();
        let (vtu, _) = mesh(&part, folder.path().join("out.vtu"), &all);
        std::fs::read(vtu).unwrap()
    });
    assert!(made[0] == made[1]);
}

#[test]
fn filled_holes_are_meshed_in_quads() {
    let folder = common::scratch();
    let (name, limits, _) = CASES[1];
    let part = solid(name, true, false, folder.path());
    let all: Vec<&str> = limits
        .iter()
        .copied()
        .chain(["--element", "quad", "--size", "4"])
        .collect();
    let (_, report) = mesh(&part, folder.path().join("out.vtu"), &all);
    let share = report["quality"]["quad_share"].as_f64().unwrap();
    assert!(share > 0.98, "{share}");
    assert_eq!(report["audit"]["euler"], 1);
}

/// The doubts of an audit of a mesh against a solid.
fn doubts(mesh: &Path, solid: &Path) -> String {
    let mut command = tools::with_gmsh(env!("CARGO_BIN_EXE_midshell"));
    command.arg("audit").arg(mesh).arg("--solid").arg(solid);
    tools::run_to(command, LIMIT, &[0, 1])
}

#[test]
fn the_audit_sees_a_hole_too_many_and_one_too_few() {
    let folder = common::scratch();
    let name = "drilled_plate";
    let drilled = solid(name, true, false, folder.path());
    let plain = solid(name, false, false, folder.path());
    let at = |name: &str| folder.path().join(name);
    let (open, _) = mesh(&drilled, at("open.vtu"), &["--size", "3"]);
    let (filled, _) = mesh(
        &drilled,
        at("filled.vtu"),
        &["--size", "3", "--min-hole", "8"],
    );
    // One that is filled by mistake, one that is left open by mistake.
    assert!(doubts(&filled, &drilled).contains("! euler"));
    assert!(doubts(&open, &plain).contains("! euler"));
    assert!(!doubts(&open, &drilled).contains("! euler"));
}

#[test]
fn limits_that_are_no_length_or_beyond_the_part_are_refused() {
    let folder = common::scratch();
    let plate = step("flat_plate", Variant::AsMade);
    for flag in ["--min-hole", "--min-feature"] {
        for bad in ["-1", "0", "nan", "inf", "1000"] {
            let mut command = tools::with_gmsh(env!("CARGO_BIN_EXE_midshell"));
            command.arg("mesh").arg(&plate).arg("-o");
            command.arg(folder.path().join("no.vtu")).args([flag, bad]);
            tools::run_to(command, LIMIT, &[2]);
            assert!(!folder.path().join("no.vtu").exists());
        }
    }
}

/// Nodes of a CalculiX deck, mm.
fn nodes(deck: &Path) -> Vec<[f64; 3]> {
    let text = std::fs::read_to_string(deck).unwrap();
    let mut lines = text
        .lines()
        .skip_while(|l| !l.to_uppercase().starts_with("*NODE"));
    lines.next();
    let rows = lines.take_while(|l| !l.starts_with('*'));
    rows.map(|l| {
        let mut numbers = l.split(',').skip(1).map(|n| n.trim().parse().unwrap());
        std::array::from_fn(|_| numbers.next().unwrap())
    })
    .collect()
}

#[test]
fn no_row_of_nodes_follows_an_inner_edge_of_faces() {
    let folder = common::scratch();
    let made = ["flat_plate", "split_plate", "strip_plate"].map(|name| {
        let part = step(name, Variant::AsMade);
        let deck = folder.path().join(format!("{name}.inp"));
        mesh(&part, deck, &["--size", "3"])
    });
    let number = |r: &Value, key: &str| r["quality"][key].as_f64().unwrap();
    let (_, plain) = &made[0];
    for (_, split) in &made[1..] {
        let more = number(split, "elements") / number(plain, "elements");
        assert!((0.9..1.1).contains(&more), "{more}");
        assert!(edge_ratio(split) <= 2.5, "{}", edge_ratio(split));
        assert_eq!(number(split, "pass_share"), 1.0);
    }
    // The slanted edge of the split plate has room for fifteen nodes at this size; where the plate is not split six lie as near to that line.
    let (deck, _) = &made[1];
    let [a, b]: [[f64; 2]; 2] = [[27.0, 0.0], [35.0, 40.0]];
    let length = (b[0] - a[0]).hypot(b[1] - a[1]);
    let near = nodes(deck).into_iter().filter(|p| {
        let away = (p[0] - a[0]) * (b[1] - a[1]) - (p[1] - a[1]) * (b[0] - a[0]);
        (away / length).abs() < 0.15
    });
    let near = near.count();
    assert!(
        near <= 8,
        "{near} nodes lie on the common edge of two faces"
    );
}

/// Longest edge over shortest, of the worst element.
fn edge_ratio(report: &Value) -> f64 {
    let metrics = report["quality"]["metrics"].as_array().unwrap();
    let ratio = metrics.iter().find(|m| m["name"] == "triangle.edge_ratio");
    ratio.unwrap()["max"].as_f64().unwrap()
}

/// The three indicators of virtual topology hold without being asked for: edges of no length, at no angle and next to others leave no trace in the mesh.
#[test]
fn short_edges_of_rims_are_straightened() {
    let facts = Facts::of("small/stepped_rim");
    let folder = common::scratch();
    let [stepped, plain] = [true, false].map(|s| solid("stepped_rim", s, false, folder.path()));
    let (vtu, report) = mesh(&stepped, folder.path().join("out.vtu"), &["--size", "4"]);
    let wrong = facts.violations(&common::measure(&plain, &vtu, &facts, 1.0));
    assert!(wrong.is_empty(), "{wrong:?}");
    assert!(edge_ratio(&report) <= 2.5, "{}", edge_ratio(&report));
}

#[test]
fn slight_creases_are_none() {
    let folder = common::scratch();
    let bent = solid("slight_bends", true, false, folder.path());
    let (deck, report) = mesh(&bent, folder.path().join("out.inp"), &["--size", "4"]);
    assert_eq!(report["solids"][0]["sheets"], 1);
    assert!(edge_ratio(&report) <= 2.5, "{}", edge_ratio(&report));
    // The bend at x = 20 has room for nine nodes.
    let on = nodes(&deck)
        .into_iter()
        .filter(|p| (p[0] - 20.0).abs() < 0.2);
    assert!(on.count() <= 4);
}

#[test]
fn curves_side_by_side_are_meshed_within_the_criteria() {
    let folder = common::scratch();
    let ribbed = solid("rib_at_rim", true, false, folder.path());
    let (_, report) = mesh(&ribbed, folder.path().join("out.vtu"), &["--size", "4"]);
    // A strip of 0.5 between rim and junction, of elements of 4: eight to one if they were all of that size.
    assert!(edge_ratio(&report) <= 5.0, "{}", edge_ratio(&report));
    assert!(report["quality"]["pass_share"].as_f64().unwrap() > 0.99);
}

#[test]
fn narrow_faces_meshed_one_by_one_are_forty_times_as_long_as_wide() {
    let folder = common::scratch();
    let part = step("strip_plate", Variant::AsMade);
    let out = folder.path().join("faces.msh");
    let mut command = tools::with_gmsh(tools::gmsh());
    command
        .arg("-2")
        .arg(&part)
        .args(["-clmin", "3", "-clmax", "3", "-o"])
        .arg(&out);
    tools::run(command, LIMIT);
    let json = folder.path().join("faces.json");
    let mut command = tools::with_gmsh(env!("CARGO_BIN_EXE_midshell"));
    command.arg("audit").arg(&out).arg("--json").arg(&json);
    tools::run_to(command, LIMIT, &[0, 1]);
    let report: Value = serde_json::from_str(&std::fs::read_to_string(json).unwrap()).unwrap();
    let ratio = edge_ratio(&report);
    assert!(ratio >= 42.0, "{ratio}");
}

#[test]
fn every_fixture_has_facts_that_its_solid_without_what_is_small_meets() {
    let folder = common::scratch();
    let mut names: Vec<String> = std::fs::read_dir(tools::root().join("fixtures/small"))
        .unwrap()
        .filter_map(|entry| entry.unwrap().file_name().into_string().ok())
        .filter_map(|file| file.strip_suffix(".geo").map(str::to_owned))
        .collect();
    names.sort();
    assert!(names.len() >= CASES.len());
    for name in names {
        let facts = Facts::of(&format!("small/{name}"));
        let plain = solid(&name, false, false, folder.path());
        let mut command = tools::python("measure.py");
        command.arg("solid").arg(&plain);
        let said = tools::run(command, LIMIT);
        let measured: SolidFacts = serde_json::from_str(&said).unwrap();
        let wrong = facts.solid_violations(&measured);
        assert!(wrong.is_empty(), "{name}: {wrong:?}");
    }
}
