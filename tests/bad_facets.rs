//! Facet files that are odd or broken: each gives a right mesh, or is refused with the right status and a message that names the cause. And the unit,
//! which no facet file names.

#![cfg(unix)]
#![allow(clippy::unwrap_used, clippy::panic)]

mod binary;

use binary::{Bench, Ended};
use std::time::Duration;

const USAGE: i32 = 2;
const INPUT: i32 = 3;

/// Points and triangles.
#[derive(Clone, Default)]
struct Facets {
    points: Vec<[f64; 3]>,
    triangles: Vec<[usize; 3]>,
}

/// A box.
fn block(low: [f64; 3], high: [f64; 3]) -> Facets {
    let points = (0..8)
        .map(|i| [0, 1, 2].map(|k| if i >> k & 1 == 0 { low[k] } else { high[k] }))
        .collect();
    let quads = [
        [0, 2, 3, 1],
        [4, 5, 7, 6],
        [0, 1, 5, 4],
        [2, 6, 7, 3],
        [0, 4, 6, 2],
        [1, 3, 7, 5],
    ];
    let halves = |[a, b, c, d]: [usize; 4]| [[a, b, c], [a, c, d]];
    Facets {
        points,
        triangles: quads.into_iter().flat_map(halves).collect(),
    }
}

/// 100 x 60 x 2.
fn plate() -> Facets {
    block([0.0; 3], [100.0, 60.0, 2.0])
}

impl Facets {
    fn and(mut self, other: &Facets) -> Facets {
        let shift = self.points.len();
        self.points.extend(&other.points);
        self.triangles
            .extend(other.triangles.iter().map(|t| t.map(|v| v + shift)));
        self
    }

    fn scaled(mut self, factor: f64) -> Facets {
        self.points = self.points.iter().map(|p| p.map(|x| x * factor)).collect();
        self
    }

    fn moved(mut self, by: f64) -> Facets {
        self.points = self.points.iter().map(|p| p.map(|x| x + by)).collect();
        self
    }

    fn stl(&self) -> String {
        let mut text = String::from("solid part\n");
        for t in &self.triangles {
            text += "facet normal 0 0 0\nouter loop\n";
            for [x, y, z] in t.map(|v| self.points[v]) {
                text += &format!("vertex {x:e} {y:e} {z:e}\n");
            }
            text += "endloop\nendfacet\n";
        }
        text + "endsolid part\n"
    }

    fn mesh(&self, more: &[&str]) -> Ended {
        let bench = Bench::new();
        let input = bench.file("part.stl", self.stl());
        bench.mesh(&input, more)
    }
}

/// The value on a line of the report.
fn value(ended: &Ended, name: &str) -> String {
    let line = ended.stdout.lines().find(|l| l.trim().starts_with(name));
    let words = line.unwrap_or("").trim().trim_start_matches(name);
    words.split_whitespace().next().unwrap_or("").to_owned()
}

/// Meshed, right by the audit, with so many pieces.
#[track_caller]
fn right(ended: &Ended, pieces: usize) {
    assert_eq!(ended.status, Some(0), "{}{}", ended.stdout, ended.stderr);
    assert_eq!(value(ended, "pieces"), pieces.to_string());
    assert!(ended.litter.is_empty());
}

// Broken files that still are a solid.

#[test]
fn a_shell_turned_inside_out_is_the_same_solid() {
    let mut part = plate();
    part.triangles.iter_mut().for_each(|t| t.swap(0, 1));
    right(&part.mesh(&[]), 1);
    // Some facets only.
    let mut part = plate();
    part.triangles
        .iter_mut()
        .step_by(3)
        .for_each(|t| t.swap(0, 1));
    right(&part.mesh(&[]), 1);
}

#[test]
fn facets_that_are_there_twice_count_once() {
    let mut part = plate();
    part.triangles.extend(plate().triangles);
    right(&part.mesh(&[]), 1);
}

#[test]
fn a_fin_and_a_slit_without_thickness_do_no_harm() {
    for apex in [[50.0, 30.0, 40.0], [50.0, 30.0, 1.0]] {
        let mut part = plate();
        part.points.push(apex);
        let [a, b, _] = part.triangles[0];
        part.triangles.extend([[a, b, 8], [b, a, 8]]);
        right(&part.mesh(&[]), 1);
    }
}

#[test]
fn plates_that_meet_along_an_edge_or_a_face_are_two_pieces() {
    let along_an_edge = plate().and(&block([100.0, 60.0, 0.0], [200.0, 120.0, 2.0]));
    right(&along_an_edge.mesh(&[]), 2);
    let on_a_face = plate().and(&block([0.0, 0.0, 2.0], [100.0, 60.0, 4.0]));
    right(&on_a_face.mesh(&[]), 2);
    let on_a_part = plate().and(&block([10.0, 10.0, 2.0], [90.0, 50.0, 4.0]));
    right(&on_a_part.mesh(&[]), 2);
}

// No solids.

#[test]
fn bodies_that_cut_each_other_are_refused() {
    let part = plate().and(&block([40.0, 20.0, -10.0], [42.0, 40.0, 10.0]));
    part.mesh(&[]).refused(INPUT, &["part.stl", "cut through"]);
}

#[test]
fn a_shell_that_cuts_itself_is_refused() {
    // The bottom's corner is drawn up through the top.
    let mut part = plate();
    part.points[0] = [7.0, 3.0, 10.0];
    part.mesh(&[])
        .refused(INPUT, &["part.stl", "cuts through itself"]);
}

#[test]
fn coordinates_that_are_no_numbers_are_refused_with_their_place() {
    for word in ["NaN", "inf", "1e999"] {
        let bench = Bench::new();
        let text = plate().stl().replacen("0e0", word, 1);
        let input = bench.file("part.stl", text);
        bench
            .mesh(&input, &[])
            .refused(INPUT, &["part.stl", "line 4"]);
    }
}

#[test]
fn facets_without_volume_are_refused() {
    let mut part = plate();
    for p in &mut part.points {
        p[2] = 0.0;
    }
    part.mesh(&[]).refused(INPUT, &["part.stl", "no volume"]);
}

// Sizes and units.

#[test]
fn absurd_units_are_no_matter_of_size_and_told() {
    for factor in [1e-9, 1e-3, 10.0, 1e3, 1e9] {
        let ended = plate().scaled(factor).mesh(&[]);
        right(&ended, 1);
        // The plate is 117 mm long, corner to corner.
        let odd = factor != 10.0;
        assert_eq!(ended.stdout.contains("is the unit right?"), odd, "{factor}");
    }
    // So far away that single precision leaves no thickness.
    plate().moved(1e12).mesh(&[]).refused(INPUT, &["part.stl"]);
}

#[test]
fn a_unit_makes_the_same_part_of_other_numbers() {
    let want = plate().mesh(&["--unit", "mm"]);
    right(&want, 1);
    assert!(!want.stdout.contains("note:"), "{}", want.stdout);
    for (unit, mm) in [
        ("um", 1e-3),
        ("cm", 10.0),
        ("m", 1e3),
        ("in", 25.4),
        ("ft", 304.8),
    ] {
        let ended = plate().scaled(1.0 / mm).mesh(&["--unit", unit]);
        right(&ended, 1);
        let thickness: f64 = value(&ended, "wall thickness, median").parse().unwrap();
        assert!((thickness - 2.0).abs() < 1e-3, "{unit}: {thickness}");
        assert!(!ended.stdout.contains("note:"), "{}", ended.stdout);
    }
    let assumed = plate().scaled(1e-3).mesh(&[]);
    right(&assumed, 1);
    for word in ["mm are assumed", "--unit m it would be 116.6 mm"] {
        assert!(assumed.stdout.contains(word), "{word}: {}", assumed.stdout);
    }
    assert_eq!(plate().mesh(&["--unit", "parsec"]).status, Some(USAGE));
}

// Many faces.

#[test]
fn ten_thousand_tiny_faces_end_in_time() {
    // A plate whose top is 50 x 50 pyramids: every facet there is a face.
    let n = 50;
    let (mut part, step) = (Facets::default(), 2.0);
    let at = |i: usize, j: usize| j * (n + 1) + i;
    for z in [2.0, 0.0] {
        for j in 0..=n {
            for i in 0..=n {
                part.points.push([step * i as f64, step * j as f64, z]);
            }
        }
    }
    let below = (n + 1) * (n + 1);
    for j in 0..n {
        for i in 0..n {
            let apex = part.points.len();
            let middle = |k: usize| step * (k as f64 + 0.5);
            part.points.push([middle(i), middle(j), 3.5]);
            let ring = [at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)];
            for k in 0..4 {
                part.triangles.push([ring[k], ring[(k + 1) % 4], apex]);
            }
            let [a, b, c, d] = ring.map(|v| v + below);
            part.triangles.extend([[a, c, b], [a, d, c]]);
        }
    }
    for k in 0..n {
        for (a, b) in [
            (at(k + 1, 0), at(k, 0)),
            (at(k, n), at(k + 1, n)),
            (at(0, k), at(0, k + 1)),
            (at(n, k + 1), at(n, k)),
        ] {
            part.triangles
                .extend([[a, b, b + below], [a, b + below, a + below]]);
        }
    }
    let ended = part.mesh(&[]);
    assert!(matches!(ended.status, Some(0..=5)), "{}", ended.stderr);
    assert!(ended.took < Duration::from_secs(120), "{:?}", ended.took);
    assert!(ended.litter.is_empty() && !ended.stderr.contains("panicked"));
}
