//! `midshell audit` as its users meet it: meshes of other programs, Verdict's metrics, the solid that a mesh stands for, and input that is none.

#![cfg(unix)]
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic)]

mod binary;
#[allow(dead_code)]
#[path = "common/tools.rs"]
mod tools;

use binary::{Bench, Ended, PLATE};
use serde_json::Value;
use std::collections::{BTreeMap, HashMap};
use std::time::Duration;

const LIMIT: Duration = Duration::from_secs(120);

fn audit(bench: &Bench, arguments: &[&str]) -> Ended {
    let mut command = bench.midshell();
    command.arg("audit").args(arguments);
    bench.run(command)
}

/// The report on a mesh, and the status.
fn report(bench: &Bench, arguments: &[&str]) -> (Value, i32) {
    let ended = audit(bench, &[arguments, &["--json", "-"]].concat());
    let report = serde_json::from_str(&ended.stdout);
    let report = report.unwrap_or_else(|e| panic!("{arguments:?}: {e}: {}", ended.stderr));
    (report, ended.status.unwrap())
}

/// The last line of a script's answer, which is JSON.
fn answer(script: &str, arguments: &[&str]) -> Value {
    let mut command = tools::python(script);
    command.args(arguments);
    let text = tools::run(command, LIMIT);
    serde_json::from_str(text.trim_end().lines().last().unwrap()).unwrap()
}

/// Rows of a CSV file by the names of its columns.
fn rows(text: &str) -> Vec<HashMap<&str, &str>> {
    let mut lines = text.lines().map(|line| line.split(',').collect::<Vec<_>>());
    let head = lines.next().unwrap();
    lines
        .map(|line| head.iter().copied().zip(line).collect())
        .collect()
}

fn count(report: &Value, kind: &str) -> u64 {
    let findings = report["findings"].as_array().unwrap();
    let of = findings.iter().find(|f| f["kind"] == kind).unwrap();
    of["count"].as_u64().unwrap()
}

/// Four quads of 10 by 10 in a row, the third with a corner drawn in.
const STRIP: &str = "*NODE\n1,0,0\n2,10,0\n3,20,0\n4,30,0\n5,40,0\n6,0,10\n7,10,10\n8,20,10\n9,24,6\n10,40,10\n*ELEMENT,TYPE=S4,ELSET=E\n11,1,2,7,6\n12,2,3,8,7\n13,3,4,9,8\n14,4,5,10,9\n*SHELL SECTION,ELSET=E\n2.\n";

#[test]
fn metrics_are_those_of_verdict() {
    let bench = Bench::new();
    let folder = bench.at(".");
    let verdict = answer("verdict.py", &["7", "500", folder.to_str().unwrap()]);
    audit(&bench, &["random.vtu", "-q", "--csv", "all.csv"]);
    let text = std::fs::read_to_string(bench.at("all.csv")).unwrap();
    let rows = rows(&text);
    assert_eq!(rows.len(), 1000);
    let mut compared = BTreeMap::new();
    for (metric, values) in verdict.as_object().unwrap() {
        for (row, value) in rows.iter().zip(values.as_array().unwrap()) {
            let Some(want) = value.as_f64() else { continue };
            let got: f64 = row[metric.as_str()].parse().unwrap();
            let close = (got - want).abs() <= 1e-9 * want.abs().max(1.0);
            assert!(close, "{metric}: {got}, Verdict {want}, {row:?}");
            *compared.entry((metric.as_str(), row["type"])).or_insert(0) += 1;
        }
    }
    // Six and one of triangles, ten and two of quads.
    assert_eq!(compared.len(), 7 + 12, "{compared:?}");
    assert!(compared.values().all(|n| *n == 500), "{compared:?}");
}

#[test]
fn meshes_of_other_programs_are_one_mesh() {
    let bench = Bench::new();
    let folder = bench.at(".");
    let files = answer("write_meshes.py", &[folder.to_str().unwrap()]);
    let (reference, _) = report(&bench, &["vtk-text.vtu"]);
    assert_eq!(reference["quality"]["elements"], 15);
    for file in files.as_array().unwrap() {
        let (name, has_thickness) = (file[0].as_str().unwrap(), file[1].as_bool().unwrap());
        let (seen, _) = report(&bench, &[name]);
        let without = seen["without_thickness"].as_u64().unwrap();
        assert_eq!(without == 0, has_thickness, "{name}");
        let quality = &seen["quality"];
        // Small fields and single precision keep seven digits or fewer.
        let near = |a: &Value, b: &Value| {
            let (a, b) = (a.as_f64().unwrap(), b.as_f64().unwrap());
            (a - b).abs() < 1e-5 * b.abs().max(1.0)
        };
        let area = &reference["quality"]["area"];
        assert!(near(&quality["area"], area), "{name}: {}", quality["area"]);
        if name.starts_with("triangles") {
            assert_eq!(
                (&quality["triangles"], &quality["quads"]),
                (&24.into(), &0.into())
            );
            continue;
        }
        for key in ["nodes", "elements", "triangles", "quads"] {
            assert_eq!(quality[key], reference["quality"][key], "{name}: {key}");
        }
        let metrics = reference["quality"]["metrics"].as_array().unwrap();
        for (own, want) in quality["metrics"].as_array().unwrap().iter().zip(metrics) {
            assert_eq!(own["name"], want["name"]);
            for key in ["min", "mean", "max"] {
                assert!(near(&own[key], &want[key]), "{name}: {own} {want}");
            }
        }
        for kind in ["free-edges", "t-connections", "duplicate-nodes"] {
            assert_eq!(
                count(&seen, kind),
                count(&reference, kind),
                "{name}: {kind}"
            );
        }
    }
    for solid in ["solid.vtu", "solid.msh", "solid.inp", "solid.bdf"] {
        audit(&bench, &[solid]).refused(3, &[solid, "solid mesh: 1 solid", "midshell mesh"]);
    }
    audit(&bench, &["nan.vtu"]).refused(3, &["nan.vtu", "node 4", "no finite number"]);
    audit(&bench, &["lz4.vtu"]).refused(3, &["LZ4", "zlib"]);
}

#[test]
fn a_plate_comes_back_from_every_format_and_is_right_by_its_solid() {
    let bench = Bench::new();
    let input = bench.step("plate.step", PLATE);
    let outputs = ["-o", "b.inp", "-o", "c.bdf", "-o", "d.msh"];
    let json = ["--json", "mesh.json"];
    let made = bench.mesh(&input, &[&outputs[..], &json].concat());
    assert_eq!(made.status, Some(0), "{}", made.stderr);
    let text = std::fs::read_to_string(bench.at("mesh.json")).unwrap();
    let own: Value = serde_json::from_str(&text).unwrap();
    for name in ["out.vtu", "b.inp", "c.bdf", "d.msh"] {
        let (seen, status) = report(&bench, &[name, "--solid", "plate.step"]);
        assert_eq!(status, 0, "{name}: {}", seen["faults"]);
        for key in ["nodes", "elements", "triangles", "quads", "pass_share"] {
            assert_eq!(seen["quality"][key], own["quality"][key], "{name}: {key}");
        }
        // Samples are the same where the mesh is, to the last digits that a deck keeps.
        for key in [
            "euler",
            "pieces",
            "betti",
            "orphans",
            "flipped",
            "misoriented",
        ] {
            assert_eq!(seen["audit"][key], own["audit"][key], "{name}: {key}");
        }
        for key in ["r95", "cover", "mass", "thickness_error", "off_middle"] {
            let [a, b] = [&seen, &own].map(|r| r["audit"][key].as_f64().unwrap());
            assert!((a - b).abs() < 5e-3, "{name}: {key} {a} {b}");
        }
    }
    // Without thickness the rest is still measured.
    let deck = std::fs::read_to_string(bench.at("b.inp")).unwrap();
    let bare = deck.split("*MATERIAL").next().unwrap();
    bench.file("bare.inp", bare);
    let (seen, status) = report(&bench, &["bare.inp", "--solid", "plate.step"]);
    assert_eq!(status, 0, "{}", seen["faults"]);
    assert!(seen["audit"]["mass"].is_null() && seen["audit"]["thickness_error"].is_null());
    assert!(seen["notes"].to_string().contains("no thickness"));
    assert!(seen["audit"]["r95"].as_f64().unwrap() < 0.01);
    // Lifted by a quarter of the thickness, and as one that lost its last element.
    let lifted = bare.replace(", 1.0\n", ", 1.5\n");
    assert_ne!(lifted, bare);
    bench.file("lifted.inp", lifted);
    let (seen, status) = report(&bench, &["lifted.inp", "--solid", "plate.step"]);
    assert_eq!(status, 1);
    assert!(
        seen["faults"].to_string().contains("r-error"),
        "{}",
        seen["faults"]
    );
}

#[test]
fn what_fails_is_told_counted_and_written() {
    let bench = Bench::new();
    bench.file("strip.inp", STRIP);
    let files = [
        "-o",
        "failing.vtu",
        "--csv",
        "all.csv",
        "--json",
        "report.json",
    ];
    let ended = audit(&bench, &[&["strip.inp"], &files[..]].concat());
    assert_eq!(ended.status, Some(1), "{}", ended.stderr);
    assert_eq!(ended.stderr, "");
    assert_eq!(ended.left, ["all.csv", "failing.vtu", "report.json"]);
    for words in [
        "doubted: 10 nodes, 4 elements",
        "! angle: ",
        "wrote failing.vtu",
        "free edges",
        "t connections",
        "worst",
    ] {
        assert!(ended.stdout.contains(words), "{words}: {}", ended.stdout);
    }
    assert!(
        ended.stdout.lines().all(|l| l.chars().count() <= 100),
        "{}",
        ended.stdout
    );
    let text = std::fs::read_to_string(bench.at("report.json")).unwrap();
    let report: Value = serde_json::from_str(&text).unwrap();
    let failing = 4.0 * (1.0 - report["quality"]["pass_share"].as_f64().unwrap());
    assert!(failing >= 1.0);
    let worst = report["worst_numbers"][0].as_u64().unwrap();
    assert!([13, 14].contains(&worst), "{worst}");
    let csv = std::fs::read_to_string(bench.at("all.csv")).unwrap();
    let rows = rows(&csv);
    assert_eq!(rows.len(), 4);
    assert_eq!(
        (rows[0]["element"], rows[0]["thickness"], rows[0]["fails"]),
        ("11", "2", "")
    );
    let broken = rows.iter().filter(|r| !r["fails"].is_empty()).count();
    assert_eq!(broken as f64, failing);
    // What is written can be audited in its turn.
    let (again, status) = self::report(&bench, &["failing.vtu"]);
    assert_eq!(
        (status, again["quality"]["elements"].as_f64()),
        (1, Some(failing))
    );
    let vtu = std::fs::read_to_string(bench.at("failing.vtu")).unwrap();
    for field in ["element", "fails", "angle"] {
        assert!(vtu.contains(&format!("Name=\"{field}\"")), "{field}");
    }
}

#[test]
fn a_sound_mesh_ends_with_nothing_against_it() {
    let bench = Bench::new();
    bench.file("strip.inp", STRIP.replace("9,24,6", "9,30,10"));
    let ended = audit(&bench, &["strip.inp", "-o", "failing.vtu"]);
    ended.went_well(&["failing.vtu"]);
    assert!(
        ended
            .stdout
            .contains("sound: 10 nodes, 4 elements (4 quads"),
        "{}",
        ended.stdout
    );
    let vtu = std::fs::read_to_string(bench.at("failing.vtu")).unwrap();
    assert!(vtu.contains("NumberOfCells=\"0\""));
    // Against a wanted length the edges may be short.
    let short = audit(&bench, &["strip.inp", "--size", "30"]);
    assert_eq!(short.status, Some(1));
    assert!(
        short.stdout.contains("! short-edge: 4 of 4"),
        "{}",
        short.stdout
    );
    let quiet = audit(&bench, &["strip.inp", "-q"]);
    assert_eq!((quiet.status, quiet.stdout.as_str()), (Some(0), ""));
}

#[cfg(target_os = "linux")]
#[test]
fn a_full_terminal_hides_no_verdict_once_files_are_written() {
    let bench = Bench::new();
    bench.file("strip.inp", STRIP);
    let full = || {
        std::fs::File::options()
            .write(true)
            .open("/dev/full")
            .unwrap()
    };
    for (files, status, word) in [(&["--csv", "all.csv"][..], 1, "warning"), (&[], 6, "error")] {
        let mut command = bench.midshell();
        command
            .args(["audit", "strip.inp"])
            .args(files)
            .stdout(full());
        let ended = bench.run(command);
        assert_eq!(ended.status, Some(status), "{}", ended.stderr);
        assert!(ended.stderr.contains(word), "{}", ended.stderr);
    }
    assert!(bench.at("all.csv").is_file());
}

#[test]
fn planted_defects_are_faults() {
    let bench = Bench::new();
    let sound = STRIP.replace("9,24,6", "9,30,10");
    for (kind, from, to) in [
        ("duplicate-nodes", "*ELEMENT", "15,30,10\n*ELEMENT"),
        (
            "duplicate-elements",
            "14,4,5,10,9\n",
            "14,4,5,10,9\n15,9,10,5,4\n",
        ),
        (
            "t-connections",
            "14,4,5,10,9\n",
            "14,4,5,10,9\n15,16,17,18\n",
        ),
        ("opposite-normals", "12,2,3,8,7\n", "12,7,8,3,2\n"),
        ("repeated-corners", "14,4,5,10,9\n", "14,4,5,10,10\n"),
    ] {
        let text = sound
            .replace(from, to)
            .replace("15,16,17,18", "15,16,17,18,19");
        let text = match kind {
            "t-connections" => {
                text.replace("*ELEMENT", "16,5,0\n17,5,-5\n18,6,-5\n19,6,0\n*ELEMENT")
            }
            _ => text,
        };
        bench.file("spoilt.inp", text);
        let (report, status) = report(&bench, &["spoilt.inp"]);
        assert_eq!(status, 1, "{kind}");
        assert!(count(&report, kind) > 0, "{kind}");
        assert!(
            report["faults"].to_string().contains(kind),
            "{kind}: {}",
            report["faults"]
        );
    }
}

#[test]
fn criteria_come_by_name_or_by_file() {
    let bench = Bench::new();
    bench.file("strip.inp", STRIP.replace("9,24,6", "9,30,10"));
    let (crash, status) = report(&bench, &["strip.inp", "--profile", "crash"]);
    assert_eq!(
        (status, &crash["quality"]["profile"]["name"]),
        (0, &"crash".into())
    );
    bench.file("strict.toml", "[quad]\nedge_ratio = { max = 0.5 }\n");
    let (strict, status) = report(&bench, &["strip.inp", "--profile", "strict.toml"]);
    assert_eq!(
        (status, &strict["quality"]["profile"]["name"]),
        (1, &"strict".into())
    );
    assert_eq!(strict["quality"]["failures"][0][0], "quad.edge_ratio");
    bench.file("unknown.toml", "[quad]\nwarping = { max = 5 }\n");
    let unknown = audit(&bench, &["strip.inp", "--profile", "unknown.toml"]);
    unknown.refused(2, &["unknown.toml", "'warping'", "warp_deg", "taper"]);
    bench.file("limit.toml", "warping_max = 5\n");
    let unknown = audit(&bench, &["strip.inp", "--profile", "limit.toml"]);
    unknown.refused(2, &["limit.toml", "warping_max", "warp_deg_max"]);
    let missing = audit(&bench, &["strip.inp", "--profile", "steel"]);
    missing.refused(2, &["steel", "shell, crash"]);
    // The same for meshing.
    let input = bench.step("plate.step", PLATE);
    bench
        .mesh(&input, &["--profile", "unknown.toml"])
        .refused(2, &["'warping'"]);
    let made = bench.mesh(&input, &["--profile", "crash"]);
    made.went_well(&["out.vtu"]);
    assert!(
        made.stdout.contains("pass profile 'crash'"),
        "{}",
        made.stdout
    );
}

#[test]
fn input_that_is_none_is_told_as_what_it_is() {
    let bench = Bench::new();
    bench.file("strip.inp", STRIP);
    bench.file("part.xyz", "");
    bench.file("points.inp", "*NODE\n1,0,0,0\n");
    bench.file("nan.inp", STRIP.replace("9,24,6", "9,nan,6"));
    bench.file("broken.vtu", "<VTKFile type=\"UnstructuredGrid\"");
    for (arguments, status, words) in [
        (&["none.vtu"][..], 3, &["none.vtu", "No such file"][..]),
        (&["part.xyz"], 3, &["part.xyz", "'xyz'", ".bdf"]),
        (
            &["points.inp"],
            3,
            &["points.inp", "no shell element", "1 nodes"],
        ),
        (&["nan.inp"], 3, &["nan.inp", "node 9", "no finite number"]),
        (&["broken.vtu"], 3, &["broken.vtu", "byte", "ends inside"]),
        (&["."], 3, &["cannot audit ."]),
        (&["strip.inp", "--solid", "none.step"], 3, &["none.step"]),
        (&["strip.inp", "--size", "-1"], 2, &["element size"]),
        (
            &["strip.inp", "-o", "failing.inp"],
            2,
            &["failing.inp", ".vtu"],
        ),
        (
            &["strip.inp", "-o", "a.vtu", "--csv", "a.vtu"],
            2,
            &["two outputs"],
        ),
        (
            &["strip.inp", "--csv", "strip.inp"],
            2,
            &["it is the input"],
        ),
        (
            &["strip.inp", "-o", "a.vtu", "--csv", "none/a.csv"],
            6,
            &["none/a.csv", "no folder"],
        ),
    ] {
        audit(&bench, arguments).refused(status, words);
    }
}
