//! Solids that are odd or broken: each gives a right mesh, or is refused with the right status and a message that names the cause.

#![cfg(unix)]
#![allow(clippy::unwrap_used, clippy::panic)]

mod binary;

use binary::{Bench, Ended, PLATE};

const INPUT: i32 = 3;

/// Meshed, right by the audit, with so many pieces.
fn right(ended: &Ended, pieces: usize) {
    assert_eq!(ended.status, Some(0), "{}{}", ended.stdout, ended.stderr);
    let line = ended
        .stdout
        .lines()
        .find(|l| l.trim().starts_with("pieces"));
    let words: Vec<&str> = line.unwrap_or("").split_whitespace().collect();
    assert_eq!(words.get(1), Some(&pieces.to_string().as_str()), "{line:?}");
}

fn made(script: &str) -> Ended {
    let bench = Bench::new();
    let input = bench.step("part.step", script);
    bench.mesh(&input, &[])
}

/// The plate's STEP file, its text changed.
fn edited(edit: impl Fn(&str) -> String) -> Ended {
    let bench = Bench::new();
    let text = std::fs::read_to_string(bench.step("plate.step", PLATE)).unwrap();
    let changed = edit(&text);
    assert_ne!(text, changed);
    let input = bench.file("changed.step", changed);
    bench.mesh(&input, &[])
}

#[test]
fn solids_that_meet_along_an_edge_or_a_face_are_two_pieces() {
    let fuse = "BooleanUnion{ Volume{1}; Delete; }{ Volume{2}; Delete; }";
    let along_an_edge = format!("{PLATE} Box(2) = {{100, 60, 0, 100, 60, 2}}; {fuse}");
    right(&made(&along_an_edge), 2);
    let split = "BooleanFragments{ Volume{1}; Delete; }{ Volume{2}; Delete; }";
    let on_a_face = format!("{PLATE} Box(2) = {{0, 0, 2, 100, 60, 2}}; {split}");
    right(&made(&on_a_face), 2);
}

#[test]
fn a_face_without_thickness_inside_the_material_does_no_harm() {
    let slit = "Box(1) = {0, 0, 0, 100, 60, 4}; Rectangle(50) = {20, 20, 2, 30, 20};
BooleanFragments{ Volume{1}; Delete; }{ Surface{50}; Delete; }";
    right(&made(slit), 1);
}

#[test]
fn a_shell_turned_inside_out_is_the_same_solid() {
    let turned = |text: &str| {
        let turn = |statement: &str| {
            if !statement.contains("ADVANCED_FACE(") {
                statement.to_owned()
            } else if let Some(rest) = statement.strip_suffix(".T.)") {
                format!("{rest}.F.)")
            } else if let Some(rest) = statement.strip_suffix(".F.)") {
                format!("{rest}.T.)")
            } else {
                panic!("{statement}")
            }
        };
        let statements: Vec<String> = text.split(';').map(turn).collect();
        statements.join(";")
    };
    right(&edited(turned), 1);
}

#[test]
fn a_face_that_is_listed_twice_counts_once() {
    let doubled = |text: &str| {
        let at = text.find("CLOSED_SHELL").unwrap();
        let first = at + text[at..].find("(#").unwrap() + 1;
        let comma = first + text[first..].find(',').unwrap() + 1;
        let face = text[first..comma].to_owned();
        format!("{}{face}{}", &text[..first], &text[first..])
    };
    right(&edited(doubled), 1);
}

#[test]
fn coordinates_that_are_no_numbers_are_refused() {
    for word in ["NaN", "1.E+999"] {
        let ended = edited(|text| text.replacen("(100.,60.,2.)", &format!("(100.,60.,{word})"), 1));
        // The CAD kernel drops what it cannot read; what is left is no closed solid, or cannot be filled.
        assert!(
            matches!(ended.status, Some(3 | 5)),
            "{:?} {}",
            ended.status,
            ended.stderr
        );
        assert!(ended.stderr.contains("changed.step"), "{}", ended.stderr);
        assert!(ended.left.is_empty() && ended.litter.is_empty());
    }
}

#[test]
fn absurd_units_are_no_matter_of_size() {
    for (long, wide, thick) in [
        ("100e9", "60e9", "2e9"),
        ("100e5", "60e5", "2e5"),
        ("100e-4", "60e-4", "2e-4"),
    ] {
        right(
            &made(&format!("Box(1) = {{0, 0, 0, {long}, {wide}, {thick}}};")),
            1,
        );
    }
}

#[test]
fn a_part_below_the_tolerance_of_the_cad_kernel_is_refused() {
    let ended = edited(|text| {
        let scaled = |line: &str| {
            if !line.contains("CARTESIAN_POINT") {
                return line.to_owned();
            }
            line.replace("100.", "1.E-7")
                .replace("60.", "6.E-8")
                .replace("2.)", "2.E-9)")
                .replace("2.,", "2.E-9,")
        };
        text.lines().map(scaled).collect::<Vec<_>>().join("\n")
    });
    ended.refused(INPUT, &["changed.step"]);
}
