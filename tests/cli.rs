//! The command line as its users meet it: streams, statuses, files.

#![cfg(unix)]
#![allow(clippy::unwrap_used, clippy::panic)]

mod binary;

use binary::{Bench, PLATE, gmsh};
use midshell::exit_class::ExitClass;

fn said(arguments: &[&str]) -> (i32, String, String) {
    let bench = Bench::new();
    let mut command = bench.midshell();
    command.args(arguments);
    let ended = bench.run(command);
    assert!(ended.left.is_empty() && ended.litter.is_empty());
    (ended.status.unwrap(), ended.stdout, ended.stderr)
}

/// The lines of a text that give a status and its meaning, however they are set.
fn status_lines(text: &str) -> Vec<(u8, String)> {
    text.lines()
        .map(|line| line.replace(['|', '`'], " "))
        .filter_map(|line| {
            let (code, meaning) = line.trim().split_once(' ')?;
            Some((code.parse().ok()?, meaning.trim().to_owned()))
        })
        .collect()
}

#[test]
fn help_and_readme_show_the_one_table_of_statuses() {
    let table: Vec<(u8, String)> = ExitClass::ALL
        .iter()
        .map(|c| (c.code(), c.meaning().to_owned()))
        .collect();
    let readme = include_str!("../README.md");
    assert_eq!(status_lines(readme), table, "README.md");
    for arguments in [
        &["--help"][..],
        &["mesh", "--help"],
        &["mesh", "-h"],
        &["audit", "--help"],
    ] {
        let (status, out, err) = said(arguments);
        assert_eq!((status, err.as_str()), (0, ""));
        assert_eq!(status_lines(&out), table, "{arguments:?}");
        assert!(out.contains("Examples:"), "{arguments:?}");
    }
}

#[test]
fn version_is_a_result() {
    let (status, out, err) = said(&["--version"]);
    assert_eq!((status, err.as_str()), (0, ""));
    assert_eq!(out, format!("midshell {}\n", env!("CARGO_PKG_VERSION")));
}

#[test]
fn bad_usage_ends_with_two_and_an_empty_stdout() {
    for arguments in [
        &[][..],
        &["frobnicate"],
        &["mesh"],
        &["mesh", "a.step"],
        &["mesh", "a.step", "-o"],
        &["mesh", "a.step", "-o", "a.vtu", "--element", "hex"],
        &["mesh", "a.step", "-o", "a.vtu", "--threads", "0"],
        &["mesh", "a.step", "-o", "a.vtu", "--time-limit", "-1"],
        &["mesh", "a.step", "-o", "a.vtu", "--time-limit", "0"],
        &["mesh", "a.step", "-o", "a.vtu", "--size-curvature", "1"],
        &[
            "mesh",
            "a.step",
            "-o",
            "a.vtu",
            "--size-min",
            "3",
            "--size-max",
            "2",
        ],
        &["mesh", "a.step", "-o", "a.vtu", "--size-min", "x"],
        &["mesh", "a.step", "-o", "a.vtu", "--growth", "1"],
        &["mesh", "a.step", "-o", "a.vtu", "--rows", "0"],
        &["mesh", "a.step", "-o", "a.vtu", "--sizes", "missing.toml"],
        &["mesh", "a.step", "-o", "a.vtu", "-q", "-v"],
        &["mesh", "a.step", "-o", "a.unknown"],
        &["mesh", "a.step", "-o", "a"],
        &["mesh", "a.step", "-o", "a.vtu", "--format", "unknown"],
        &["mesh", "a.step", "-o", "a.vtu", "-o", "./a.vtu"],
        &["mesh", "a.step", "-o", "a.vtu", "--json", "a.vtu"],
        &["inspect"],
        &["audit"],
        &["audit", "a.vtu", "--profile"],
        &["audit", "a.vtu", "--profile", "unknown"],
        &["completions", "tcsh"],
    ] {
        let (status, out, err) = said(arguments);
        assert_eq!((status, out.as_str()), (2, ""), "{arguments:?}: {err}");
        assert!(!err.is_empty(), "{arguments:?}");
    }
}

#[test]
fn the_input_is_never_overwritten() {
    let bench = Bench::new();
    let input = bench.file("part.vtu", "precious");
    let mut command = bench.midshell();
    command.args(["mesh", "part.vtu", "-o", "./part.vtu"]);
    bench
        .run(command)
        .refused(2, &["part.vtu", "it is the input"]);
    assert_eq!(std::fs::read(input).unwrap(), b"precious");
}

#[test]
fn completions_know_every_verb() {
    for shell in ["bash", "zsh", "fish", "elvish", "powershell"] {
        let (status, out, err) = said(&["completions", shell]);
        assert_eq!((status, err.as_str()), (0, ""));
        for verb in ["mesh", "inspect", "audit", "doctor", "size-curvature"] {
            assert!(out.contains(verb), "{shell}: {verb}");
        }
    }
}

#[test]
fn a_reader_that_goes_away_is_no_failure() {
    use std::process::{Command, Stdio};
    let mut child = Command::new(env!("CARGO_BIN_EXE_midshell"))
        .args(["completions", "zsh"])
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    drop(child.stdout.take());
    let output = child.wait_with_output().unwrap();
    assert_eq!(output.status.code(), Some(0));
    assert_eq!(String::from_utf8_lossy(&output.stderr), "");
}

#[cfg(target_os = "linux")]
#[test]
fn a_full_terminal_takes_nothing_back_that_was_written() {
    let bench = Bench::new();
    let input = bench.step("plate.step", PLATE);
    let mut command = bench.midshell();
    command.arg("mesh").arg(&input).args(["-o", "out.vtu"]);
    let mut shell = std::process::Command::new("sh");
    let program = command.get_program().to_string_lossy().into_owned();
    let words: Vec<String> = (command.get_args())
        .map(|a| format!("'{}'", a.to_string_lossy()))
        .collect();
    shell.args([
        "-c",
        &format!("'{program}' {} > /dev/full", words.join(" ")),
    ]);
    shell.current_dir(bench.at("."));
    for (name, value) in command.get_envs() {
        shell.env(name, value.unwrap_or_default());
    }
    let output = shell.output().unwrap();
    let stderr = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(0), "{stderr}");
    assert!(stderr.contains("warning"), "{stderr}");
    assert!(bench.at("out.vtu").is_file());
}

#[test]
fn a_temporary_folder_that_is_none_is_no_fault_of_the_input() {
    let bench = Bench::new();
    let input = bench.step("plate.step", PLATE);
    let mut command = bench.midshell();
    command.arg("mesh").arg(&input).args(["-o", "out.vtu"]);
    command.env("TMPDIR", "/nonexistent/folder");
    let ended = bench.run(command);
    ended.refused(6, &["/nonexistent/folder", "TMPDIR"]);
}

#[test]
fn a_size_is_held_against_the_whole_part() {
    let bench = Bench::new();
    let apart = "Box(1) = {0, 0, 0, 50, 40, 2}; Box(2) = {500, 0, 0, 50, 40, 2};";
    let input = bench.step("apart.step", apart);
    bench
        .mesh(&input, &["--size", "90"])
        .went_well(&["out.vtu"]);
    let ended = bench.mesh(&input, &["--size", "600"]);
    ended.refused(2, &["mm corner to corner"]);
}

#[test]
fn a_complaint_names_the_verb() {
    let bench = Bench::new();
    let input = bench.step("plate.step", PLATE);
    let mut command = bench.midshell();
    command
        .arg("inspect")
        .arg(&input)
        .args(["--time-limit", "0"]);
    bench.run(command).refused(2, &["cannot inspect"]);
}

#[test]
fn doctor_knows_a_sound_gmsh_from_a_missing_one() {
    let sound = gmsh().display().to_string();
    let (status, out, _) = said(&["doctor", "--gmsh", &sound]);
    assert_eq!(status, 0, "{out}");
    assert!(
        out.contains(&sound) && out.contains("gmsh version"),
        "{out}"
    );
    let (status, out, _) = said(&["doctor", "--gmsh", "/nonexistent/gmsh"]);
    assert_eq!(status, i32::from(ExitClass::ToolFailed.code()), "{out}");
    assert!(
        out.contains("!!") && out.contains("pip install gmsh"),
        "{out}"
    );
}

#[test]
fn a_plate_is_meshed_into_every_output() {
    let bench = Bench::new();
    let input = bench.step("plate.step", PLATE);
    let ended = bench.mesh(
        &input,
        &[
            "-o",
            "b.inp",
            "-o",
            "c.bdf",
            "-o",
            "d.msh",
            "--json",
            "report.json",
            "--timings",
            "--threads",
            "2",
        ],
    );
    ended.went_well(&["b.inp", "c.bdf", "d.msh", "out.vtu", "report.json"]);
    assert!(
        ended.stdout.contains("wrote out.vtu") && ended.stdout.contains("total"),
        "{}",
        ended.stdout
    );
    for line in ["right: ", "walls covered", "triangle.scaled_jacobian"] {
        assert!(ended.stdout.contains(line), "{line}: {}", ended.stdout);
    }
    let vtu = std::fs::read_to_string(bench.at("out.vtu")).unwrap();
    assert!(vtu.contains("Name=\"quality\""));
    let report = std::fs::read_to_string(bench.at("report.json")).unwrap();
    let report: serde_json::Value = serde_json::from_str(&report).unwrap();
    assert!(report.is_object());
}

#[test]
fn stdout_holds_nothing_but_what_was_asked_for() {
    let bench = Bench::new();
    let input = bench.step("plate.step", PLATE);
    let quiet = bench.mesh(&input, &["-q"]);
    quiet.went_well(&["out.vtu"]);
    assert_eq!(quiet.stdout, "");
    let json = bench.mesh(&input, &["--json", "-", "--timings"]);
    assert_eq!(json.status, Some(0), "{}", json.stderr);
    assert!(
        serde_json::from_str::<serde_json::Value>(&json.stdout).is_ok(),
        "{}",
        json.stdout
    );
    let verbose = bench.mesh(&input, &["-v"]);
    assert_eq!(verbose.status, Some(0));
    assert!(verbose.stderr.contains(" s  "), "{}", verbose.stderr);
}

#[test]
fn the_dialect_of_an_inp_follows_the_format() {
    let bench = Bench::new();
    let input = bench.step("plate.step", PLATE);
    let text = |dialect: &str| {
        let mut command = bench.midshell();
        command
            .arg("mesh")
            .arg(&input)
            .args(["-o", "out.inp", "--format", dialect]);
        assert_eq!(bench.run(command).status, Some(0));
        std::fs::read_to_string(bench.at("out.inp")).unwrap()
    };
    assert_ne!(text("calculix"), text("abaqus"));
}

#[test]
fn inspect_shows_a_table_and_json() {
    let bench = Bench::new();
    bench.step("plate.step", PLATE);
    let inspect = |more: &[&str]| {
        let mut command = bench.midshell();
        command.args(["inspect", "plate.step"]).args(more);
        bench.run(command)
    };
    let table = inspect(&[]);
    table.went_well(&[]);
    for word in ["1 solid", "12000.0 mm3", "2.000", "wall"] {
        assert!(table.stdout.contains(word), "{word}: {}", table.stdout);
    }
    let json = inspect(&["--json", "-"]);
    let value: serde_json::Value = serde_json::from_str(&json.stdout).unwrap();
    assert_eq!(value["solids"].as_array().map(Vec::len), Some(1));
    inspect(&["--json", "facts.json"]).went_well(&["facts.json"]);
}

#[test]
fn inspect_counts_faces_sheets_junctions_and_walls() {
    let bench = Bench::new();
    // A flange of 2 mm and a web of 3 mm.
    let t = "Box(1) = {0, 0, 0, 100, 60, 2}; Box(2) = {48.5, 0, 2, 3, 60, 40}; BooleanUnion(3) = {Volume{1}; Delete;}{Volume{2}; Delete;};";
    let input = bench.step("t.step", t);
    let mut command = bench.midshell();
    command.arg("inspect").arg(&input).args(["--json", "-"]);
    let ended = bench.run(command);
    let found: serde_json::Value = serde_json::from_str(&ended.stdout).unwrap();
    let solid = &found["solids"][0];
    assert_eq!(solid["faces_by_kind"]["plane"], 10, "{solid}");
    assert_eq!(
        solid["faces_by_role"]["lump"],
        serde_json::Value::Null,
        "{solid}"
    );
    assert_eq!(solid["sheets"], 3, "{solid}");
    assert_eq!(solid["junctions"], 1, "{solid}");
    assert_eq!(solid["lumps"], 0, "{solid}");
    let gauges: Vec<f64> = solid["walls"]
        .as_array()
        .unwrap()
        .iter()
        .map(|w| w["mean"].as_f64().unwrap())
        .collect();
    for gauge in [2.0, 3.0] {
        assert!(
            gauges.iter().any(|t| (t - gauge).abs() < 0.01),
            "{gauges:?}"
        );
    }
}

#[test]
fn inspect_tells_the_faces_of_a_solid_without_walls() {
    let bench = Bench::new();
    let input = bench.step("ball.step", "Sphere(1) = {0, 0, 0, 20};");
    let mut command = bench.midshell();
    command.arg("inspect").arg(&input);
    let ended = bench.run(command);
    ended.went_well(&[]);
    for word in ["1 sphere", "no thin wall"] {
        assert!(ended.stdout.contains(word), "{word}: {}", ended.stdout);
    }
}

#[test]
fn dump_keeps_what_every_stage_made() {
    let bench = Bench::new();
    let input = bench.step("plate.step", PLATE);
    bench
        .mesh(&input, &["--dump", "stages"])
        .went_well(&["out.vtu", "stages"]);
    let mut files: Vec<String> = std::fs::read_dir(bench.at("stages"))
        .unwrap()
        .map(|e| e.unwrap().file_name().to_string_lossy().into_owned())
        .collect();
    files.sort();
    let stages = [
        "balanced-1",
        "charted-1",
        "clean-1",
        "faces-1",
        "fair-1",
        "mesh",
        "polished-1",
        "raw-1",
        "remeshed-1",
        "tets-1",
    ];
    assert_eq!(files, stages.map(|s| format!("{s}.vtu")));
    let other = Bench::new();
    let input = other.step("plate.step", PLATE);
    let ended = other.mesh(&input, &["--dump", "/proc/stages"]);
    ended.refused(6, &["plate.step", "/proc/stages", "--dump"]);
}
