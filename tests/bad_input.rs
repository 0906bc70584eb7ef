//! What cannot be meshed is refused with the right status and a message that names file, cause and remedy; no output and no temporary file is left.
//! The statuses are those of the README.

#![cfg(unix)]
#![allow(clippy::unwrap_used, clippy::panic)]

mod binary;

use binary::{Bench, PLATE, PLATE_DIAGONAL, gmsh};
use std::process::Command;
use std::time::Duration;

const USAGE: i32 = 2;
const INPUT: i32 = 3;
const NO_WALL: i32 = 4;
const TOOL: i32 = 5;
const OUTPUT: i32 = 6;

// The input.

#[test]
fn missing_file() {
    let bench = Bench::new();
    let ended = bench.mesh(&bench.at("missing.step"), &[]);
    ended.refused(INPUT, &["missing.step"]);
}

#[test]
fn file_of_no_bytes() {
    let bench = Bench::new();
    let input = bench.file("nothing.step", "");
    bench
        .mesh(&input, &[])
        .refused(INPUT, &["nothing.step", "empty"]);
}

#[test]
fn step_file_without_entities() {
    let bench = Bench::new();
    let content = "ISO-10303-21;\nHEADER;\nFILE_DESCRIPTION((''),'2;1');\nFILE_NAME('','',(''),(''),'','','');\nFILE_SCHEMA(('AUTOMOTIVE_DESIGN'));\nENDSEC;\nDATA;\nENDSEC;\nEND-ISO-10303-21;\n";
    let input = bench.file("hollow.step", content);
    bench.mesh(&input, &[]).refused(INPUT, &["hollow.step"]);
}

#[test]
fn truncated_step() {
    let bench = Bench::new();
    let whole = std::fs::read(bench.step("plate.step", PLATE)).unwrap();
    for percent in [10, 50, 90] {
        let input = bench.file("cut.step", &whole[..whole.len() * percent / 100]);
        bench.mesh(&input, &[]).refused(INPUT, &["cut.step"]);
    }
}

#[test]
fn text_named_step() {
    let bench = Bench::new();
    let input = bench.file("letter.step", "Dear reader,\nthis is no part.\n");
    bench.mesh(&input, &[]).refused(INPUT, &["letter.step"]);
}

#[test]
fn folder_named_step() {
    let bench = Bench::new();
    let input = bench.at("folder.step");
    std::fs::create_dir(&input).unwrap();
    bench
        .mesh(&input, &[])
        .refused(INPUT, &["folder.step", "folder"]);
}

#[test]
fn file_of_an_unknown_kind() {
    let bench = Bench::new();
    let input = bench.file("part.xyz", "0 0 0\n");
    bench.mesh(&input, &[]).refused(INPUT, &["part.xyz"]);
}

#[test]
fn surfaces_only() {
    let bench = Bench::new();
    let input = bench.step("sheet.step", "Rectangle(1) = {0, 0, 0, 100, 60};");
    bench
        .mesh(&input, &[])
        .refused(INPUT, &["sheet.step", "solid"]);
}

#[test]
fn open_shell() {
    let bench = Bench::new();
    let whole = std::fs::read_to_string(bench.step("plate.step", PLATE)).unwrap();
    // The last face is taken out of the shell.
    let start = whole.find("CLOSED_SHELL(").unwrap();
    let end = start + whole[start..].find("))").unwrap();
    let last = start + whole[start..end].rfind(',').unwrap();
    let solid = format!("{}{}", &whole[..last], &whole[end..]);
    let input = bench.file("open.step", &solid);
    bench.mesh(&input, &[]).refused(INPUT, &["open.step"]);
    // The same, and the file itself says that it is open.
    let shell = solid
        .replace("CLOSED_SHELL", "OPEN_SHELL")
        .replace("MANIFOLD_SOLID_BREP('',", "SHELL_BASED_SURFACE_MODEL('',(")
        .replace(
            "ADVANCED_BREP_SHAPE_REPRESENTATION",
            "MANIFOLD_SURFACE_SHAPE_REPRESENTATION",
        );
    let at = shell.find("SHELL_BASED_SURFACE_MODEL").unwrap();
    let close = at + shell[at..].find(");").unwrap();
    let shell = format!("{}){}", &shell[..close], &shell[close..]);
    let input = bench.file("shell.step", shell);
    bench.mesh(&input, &[]).refused(INPUT, &["shell.step"]);
}

#[test]
fn solid_ball_has_no_thin_wall() {
    let bench = Bench::new();
    let input = bench.step("ball.step", "Sphere(1) = {0, 0, 0, 20};");
    bench
        .mesh(&input, &[])
        .refused(NO_WALL, &["ball.step", "thin"]);
}

#[test]
fn input_without_rights() {
    use std::os::unix::fs::PermissionsExt;
    let bench = Bench::new();
    let input = bench.file("secret.step", "x");
    std::fs::set_permissions(&input, std::fs::Permissions::from_mode(0o000)).unwrap();
    // Root reads it all the same, and then it is no STEP file: the status is one.
    bench.mesh(&input, &[]).refused(INPUT, &["secret.step"]);
}

// The output.

#[test]
fn no_rights_to_write() {
    let bench = Bench::new();
    let input = bench.step("plate.step", PLATE);
    let file = bench.file("file", "");
    let kept = bench.file("kept.vtu", "kept");
    let mut rights = std::fs::metadata(&kept).unwrap().permissions();
    rights.set_readonly(true);
    std::fs::set_permissions(&kept, rights).unwrap();
    std::fs::create_dir(bench.at("folder.vtu")).unwrap();
    // Mode bits do not bind root: these places bind everybody.
    for output in [
        "/proc/midshell.vtu".to_owned(),
        file.join("out.vtu").display().to_string(),
        bench.at("missing/out.vtu").display().to_string(),
        bench.at("folder.vtu").display().to_string(),
        kept.display().to_string(),
        "/dev/full".to_owned(),
    ] {
        let mut command = bench.midshell();
        command
            .arg("mesh")
            .arg(&input)
            .args(["-o", "other.vtu", "-o", &output]);
        command.args(["--format", "vtu"]);
        bench.run(command).refused(OUTPUT, &[&output]);
    }
    assert_eq!(std::fs::read_to_string(&kept).unwrap(), "kept");
}

#[test]
fn folder_closed_by_its_mode() {
    use std::os::unix::fs::PermissionsExt;
    let bench = Bench::new();
    let input = bench.file("plate.step", "x");
    let folder = bench.at("closed");
    std::fs::create_dir(&folder).unwrap();
    std::fs::set_permissions(&folder, std::fs::Permissions::from_mode(0o555)).unwrap();
    let may_write = tempfile::tempfile_in(&folder).is_ok();
    let output = folder.join("out.vtu").display().to_string();
    let mut command = bench.midshell();
    command.arg("mesh").arg(&input).args(["-o", &output]);
    let ended = bench.run(command);
    // Root may write there and gets as far as the input.
    ended.refused(if may_write { INPUT } else { OUTPUT }, &[]);
    std::fs::set_permissions(&folder, std::fs::Permissions::from_mode(0o755)).unwrap();
}

#[test]
fn report_without_a_place() {
    let bench = Bench::new();
    let input = bench.step("plate.step", PLATE);
    let ended = bench.mesh(&input, &["--json", "missing/report.json"]);
    ended.refused(OUTPUT, &["missing/report.json"]);
}

#[test]
fn full_disk() {
    let bench = Bench::new();
    let input = bench.step("plate.step", PLATE);
    let old = bench.file("old.msh", "old");
    // A limit on file size fails a write half-way as a full disk does. gmsh is let off: the disk is full for us alone.
    let limit = "ulimit -S -f $(ulimit -H -f)";
    let free = bench.program(
        "free-gmsh",
        &format!("{limit}\nexec '{}' \"$@\"", gmsh().display()),
    );
    let script = "trap '' XFSZ; ulimit -S -f 8; exec \"$0\" \"$@\"";
    let mut shell = Command::new("sh");
    shell
        .args(["-c", script, env!("CARGO_BIN_EXE_midshell"), "mesh"])
        .arg(&input);
    shell
        .args(["--size", "2", "-o", "out.vtu", "-o", "old.msh", "--gmsh"])
        .arg(&free);
    bench.run(bench.ready(shell)).refused(OUTPUT, &["room"]);
    assert_eq!(std::fs::read_to_string(old).unwrap(), "old");
}

// The tool.

/// A gmsh that says its version as a good one does, and then does something else.
fn fake_gmsh(bench: &Bench, deed: &str) -> String {
    let version = "case \"$*\" in *--version*) echo 4.15.2 >&2; exit 0;; esac";
    let path = bench.program("fake-gmsh", &format!("{version}\n{deed}"));
    path.display().to_string()
}

#[test]
fn gmsh_missing() {
    let bench = Bench::new();
    let input = bench.step("plate.step", PLATE);
    let ended = bench.mesh(&input, &["--gmsh", "/nonexistent/gmsh"]);
    ended.refused(TOOL, &["plate.step", "/nonexistent/gmsh", "gmsh"]);
    for path in ["", "/nonexistent"] {
        let mut command = bench.midshell();
        command.arg("mesh").arg(&input).args(["-o", "out.vtu"]);
        command.env("PATH", path).env_remove("MIDSHELL_GMSH");
        bench
            .run(command)
            .refused(TOOL, &["plate.step", "gmsh", "pip install gmsh"]);
    }
}

#[test]
fn gmsh_that_is_no_program() {
    let bench = Bench::new();
    let input = bench.step("plate.step", PLATE);
    let text = bench.file("gmsh.txt", "hello");
    let ended = bench.mesh(&input, &["--gmsh", &text.display().to_string()]);
    ended.refused(TOOL, &["plate.step", "gmsh.txt"]);
}

#[test]
fn gmsh_that_dies_at_its_start() {
    let bench = Bench::new();
    let input = bench.step("plate.step", PLATE);
    let complaint = "libGLU.so.1: cannot open shared object file";
    let fake = bench.program("broken-gmsh", &format!("echo '{complaint}' >&2\nexit 127"));
    let ended = bench.mesh(&input, &["--gmsh", &fake.display().to_string()]);
    ended.refused(TOOL, &["plate.step", "libGLU.so.1", "apt-get install"]);
}

#[test]
fn gmsh_killed() {
    let bench = Bench::new();
    let input = bench.step("plate.step", PLATE);
    for script in ["kill -9 $$", "kill -SEGV $$"] {
        let ended = bench.mesh(&input, &["--gmsh", &fake_gmsh(&bench, script)]);
        ended.refused(TOOL, &["plate.step", "signal"]);
    }
}

#[test]
fn gmsh_that_fails_is_quoted() {
    let bench = Bench::new();
    let input = bench.step("plate.step", PLATE);
    let fake = fake_gmsh(
        &bench,
        "echo 'Error   : the moon is in the way' >&2\nexit 1",
    );
    let ended = bench.mesh(&input, &["--gmsh", &fake]);
    ended.refused(TOOL, &["plate.step", "the moon is in the way"]);
}

#[test]
fn gmsh_that_writes_nothing() {
    let bench = Bench::new();
    let input = bench.step("plate.step", PLATE);
    let fake = fake_gmsh(&bench, "exit 0");
    let ended = bench.mesh(&input, &["--gmsh", &fake]);
    ended.refused(TOOL, &["plate.step"]);
}

#[test]
fn gmsh_hanging() {
    let bench = Bench::new();
    let input = bench.step("plate.step", PLATE);
    // The second leaves a child that holds the pipes open: killing the script alone would not free us.
    for script in ["exec sleep 60", "sleep 60\nexit 0"] {
        let gmsh = fake_gmsh(&bench, script);
        let ended = bench.mesh(&input, &["--gmsh", &gmsh, "--time-limit", "1"]);
        ended.refused(TOOL, &["plate.step", "time"]);
        assert!(ended.took < Duration::from_secs(30), "{:?}", ended.took);
    }
}

// The sizes.

#[test]
fn sizes_that_are_no_length() {
    let bench = Bench::new();
    // The size is wrong whatever the part is: it is not even looked at.
    let input = bench.at("missing.step");
    for size in ["0", "-1", "-0.0", "NaN", "inf", "-inf"] {
        let ended = bench.mesh(&input, &["--size", size]);
        ended.refused(USAGE, &["missing.step", "element size", "--size"]);
    }
}

#[test]
fn size_that_is_no_number() {
    let bench = Bench::new();
    let ended = bench.mesh(&bench.at("missing.step"), &["--size", "wide"]);
    assert_eq!(ended.status, Some(USAGE));
    assert!(ended.stderr.contains("--size") && ended.stderr.contains("wide"));
    assert!(ended.left.is_empty());
}

#[test]
fn washers_that_mean_nothing() {
    let bench = Bench::new();
    // They are wrong whatever the part is: it is not even looked at.
    let input = bench.at("missing.step");
    for (line, words) in [
        ("--washer 2", ["triangles", "--element quad"]),
        ("--element tri --washer 1", ["triangles", "--element quad"]),
        (
            "--element quad --washer-holes 4..12",
            ["no washers", "--washer 2"],
        ),
        (
            "--element quad --washer-width 2",
            ["no washers", "--washer 2"],
        ),
        (
            "--element quad --washer 1 --washer-holes 12..4",
            ["12 to 4", "4..12"],
        ),
        (
            "--element quad --washer 1 --washer-holes -3..-1",
            ["-3 to -1", "4..12"],
        ),
        (
            "--element quad --washer 1 --washer-width 0",
            ["width", "--washer-width 2"],
        ),
        (
            "--element mixed --washer 1 --washer-width -1",
            ["width", "--washer-width 2"],
        ),
        ("--element quad --washer 1000", ["1000 rings", "fewer"]),
    ] {
        let more: Vec<&str> = line.split(' ').collect();
        bench.mesh(&input, &more).refused(USAGE, &words);
    }
    for bad in [
        "--washer=-1",
        "--washer=1.5",
        "--washer-holes=4-12",
        "--washer-holes=4",
    ] {
        let ended = bench.mesh(&input, &["--element", "quad", bad]);
        assert_eq!(ended.status, Some(USAGE), "{bad}");
        assert!(ended.stderr.contains("--washer") && ended.left.is_empty());
    }
}

#[test]
fn a_washer_wider_than_the_room_for_it() {
    let bench = Bench::new();
    // The first hole is 4 mm from the rim, the second 26.
    let script = "Box(1) = {0, 0, 0, 60, 60, 2};\nCylinder(2) = {15, 7, -1, 0, 0, 4, 3};\nCylinder(3) = {35, 30, -1, 0, 0, 4, 4};\n\
                  BooleanDifference{ Volume{1}; Delete; }{ Volume{2:3}; Delete; }";
    let input = bench.step("holes.step", script);
    let wide = ["--element", "quad", "--washer", "2", "--washer-width", "2"];
    let ended = bench.mesh(&input, &wide);
    let words = [
        "hole of 6.",
        "(15.0, 7.0, 1.0)",
        "4.00 mm wide",
        "an edge of the sheet",
        "--washer-holes",
    ];
    ended.refused(USAGE, &words);
    assert!(!ended.stderr.contains("(35.0"), "{}", ended.stderr);
    // The range may leave it out.
    let more = [&wide[..], &["--washer-holes", "7..9", "--quiet"]].concat();
    bench.mesh(&input, &more).went_well(&["out.vtu"]);
}

#[test]
fn size_beyond_the_part() {
    let bench = Bench::new();
    let input = bench.step("plate.step", PLATE);
    for size in ["117", "1e9"] {
        let ended = bench.mesh(&input, &["--size", size]);
        ended.refused(
            USAGE,
            &["plate.step", "larger than the part", PLATE_DIAGONAL],
        );
    }
}
