//! Kept edges end to end: element edges along the line beneath an edge between two faces of one side, measured in the finished mesh against the line as drawn. Needs gmsh.

#![cfg(unix)]
#![allow(clippy::unwrap_used, clippy::panic)]

mod binary;

use binary::{Bench, gmsh};
use glam::{DAffine3, DQuat, DVec2, DVec3};
use midshell::import::{ImportOptions, import_cad};
use midshell::model::brep::Brep;
use midshell::model::element_shape::ElementShape;
use midshell::model::keep::KeepEdge;
use midshell::model::shell::ShellMesh;
use midshell::options::{MeshOptions, OptionFault};
use midshell::pipeline::{MeshRun, PipelineError, Progress, mesh};
use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

const SHAPES: [ElementShape; 2] = [ElementShape::Triangle, ElementShape::Quad];
/// Nodes of kept lines are this near to them, in thicknesses.
const NEAR: f64 = 0.02;

struct Silent;

impl Progress for Silent {
    fn stage(&self, _: &str) {}
}

fn options(element: ElementShape, keep: &[[i32; 2]]) -> MeshOptions {
    MeshOptions {
        element,
        keep: keep.iter().map(|&faces| KeepEdge { faces }).collect(),
        gmsh: Some(gmsh()),
        ..MeshOptions::default()
    }
}

/// A right mesh.
fn meshed(part: &Path, options: &MeshOptions) -> MeshRun {
    let run = mesh(part, options, &Silent).unwrap_or_else(|e| panic!("{e}"));
    assert!(run.report.doubts.is_empty(), "{:?}", run.report.doubts);
    run
}

fn refusal(part: &Path, keep: &[[i32; 2]]) -> OptionFault {
    match mesh(part, &options(ElementShape::Triangle, keep), &Silent) {
        Err(PipelineError::BadSize(fault)) => fault,
        Err(other) => panic!("{other}"),
        Ok(_) => panic!("{keep:?} is kept"),
    }
}

fn solid(part: &Path) -> Brep {
    let options = ImportOptions {
        gmsh: Some(gmsh()),
        ..ImportOptions::default()
    };
    import_cad(part, &options).unwrap().pieces.remove(0).brep
}

/// The numbers of the two faces of the only edge all of whose points are told to lie on it.
fn faces(brep: &Brep, on_edge: impl Fn(DVec3) -> bool) -> [i32; 2] {
    let found: Vec<[i32; 2]> = (brep.curves.iter())
        .filter(|c| c.faces.len() == 2 && !c.segments.is_empty())
        .filter(|c| (c.segments.iter().flatten()).all(|&v| on_edge(brep.vertices[v])))
        .map(|c| [0, 1].map(|k| brep.faces[c.faces[k]].tag))
        .collect();
    assert_eq!(found.len(), 1, "{found:?}");
    found[0]
}

/// The edges of elements both ends of which lie on a line. `away` tells how far a place is from it, mm.
fn on_line(mesh: &ShellMesh, near: f64, away: impl Fn(DVec3) -> f64) -> Vec<[DVec3; 2]> {
    let mut edges = BTreeSet::new();
    for e in &mesh.elements {
        let n = e.corners.as_slice();
        for k in 0..n.len() {
            let (a, b) = (n[k], n[(k + 1) % n.len()]);
            edges.insert([a.min(b), a.max(b)]);
        }
    }
    (edges.into_iter())
        .map(|ends| ends.map(|n| mesh.nodes[n]))
        .filter(|ends| ends.iter().all(|p| away(*p) < near))
        .collect()
}

/// How much of a straight line is covered by edges of elements that lie on it.
fn covered(mesh: &ShellMesh, near: f64, [a, b]: [DVec3; 2]) -> f64 {
    let along = |p: DVec3| (p - a).dot(b - a) / (b - a).length_squared();
    let away = |p: DVec3| p.distance(a.lerp(b, along(p)));
    let mut spans: Vec<[f64; 2]> = (on_line(mesh, near, away).into_iter())
        .map(|ends| ends.map(along))
        .map(|[s, t]| [s.min(t), s.max(t)])
        .collect();
    spans.sort_by(|a, b| a[0].total_cmp(&b[0]));
    let (mut sum, mut reached) = (0.0, 0.0f64);
    for [from, to] in spans {
        sum += (to.min(1.0) - from.max(reached)).max(0.0);
        reached = reached.max(to);
    }
    sum
}

fn split_plate(bench: &Bench, more: &str) -> PathBuf {
    let script = concat!(env!("CARGO_MANIFEST_DIR"), "/fixtures/gen/split_plate.geo");
    let text = std::fs::read_to_string(script).unwrap();
    let (text, _) = text.split_once("Save ").unwrap();
    bench.step("split.step", &format!("{text}\n{more}"))
}

#[test]
fn a_slanted_line_across_a_plate_is_kept_in_triangles_and_quads_wherever_the_plate_is() {
    let bench = Bench::new();
    // Half-way up, from one rim to the other.
    let line = [DVec3::new(27.0, 0.0, 1.5), DVec3::new(35.0, 40.0, 1.5)];
    let turn = DAffine3::from_quat(DQuat::from_axis_angle(
        DVec3::new(1.0, 2.0, 3.0).normalize(),
        0.7,
    ));
    let moved = "Rotate { {1, 2, 3}, {0, 0, 0}, 0.7 } { Volume{:}; }";
    for (more, motion) in [("", DAffine3::IDENTITY), (moved, turn)] {
        let part = split_plate(&bench, more);
        let brep = solid(&part);
        let back = motion.inverse();
        let top = |p: DVec3| {
            let p = back.transform_point3(p);
            let x = 27.0 + 8.0 * p.y / 40.0;
            (p.z - 3.0).abs() < 1e-6 && (p.x - x).abs() < 1e-6
        };
        let wish = faces(&brep, top);
        let line = line.map(|p| motion.transform_point3(p));
        for element in SHAPES {
            let run = meshed(&part, &options(element, &[wish]));
            let share = covered(&run.mesh, NEAR * 3.0, line);
            assert!(share > 1.0 - 1e-6, "{element}: {share}");
            let audit = run.report.audit.unwrap();
            assert_eq!((audit.euler, run.mesh.sheets.len()), (1, 1));
            let [kept] = run.report.solids[0].kept_edges.as_slice() else {
                panic!("{:?}", run.report.solids[0].kept_edges);
            };
            assert_eq!(kept.faces, wish);
            assert!(kept.edges > 5);
            assert!((kept.length - line[0].distance(line[1])).abs() < 1e-6);
            // Nothing of it without the wish: the measure finds what is not there.
            let free = meshed(&part, &options(element, &[]));
            assert!(covered(&free.mesh, NEAR * 3.0, line) < 0.5);
            assert!(free.report.solids[0].kept_edges.is_empty());
        }
    }
}

#[test]
fn the_same_bytes_come_of_one_thread_and_four() {
    let bench = Bench::new();
    let part = split_plate(&bench, "");
    let wish = faces(&solid(&part), |p| {
        p.z < 1e-6 && (p.x - 27.0 - p.y / 5.0).abs() < 1e-6
    });
    let with = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build();
        let options = options(ElementShape::Quad, &[wish]);
        (pool.unwrap()).install(|| meshed(&part, &options).mesh)
    };
    assert_eq!(with(1), with(4));
}

#[test]
fn a_rectangle_and_a_circle_are_kept_with_their_corners() {
    let bench = Bench::new();
    let script = "Box(1) = {0, 0, 0, 80, 40, 2}; Rectangle(10) = {10, 12, 2, 20, 13}; Disk(11) = {60, 20, 2, 9}; \
                  BooleanFragments{ Volume{1}; Delete; }{ Surface{10, 11}; Delete; }";
    let part = bench.step("prints.step", script);
    let brep = solid(&part);
    let centre = DVec2::new(60.0, 20.0);
    let circle = |p: DVec3| p.truncate().distance(centre) - 9.0;
    let round = faces(&brep, |p| circle(p).abs() < 1e-6);
    let side = faces(&brep, |p| {
        (p.x - 10.0).abs() < 1e-6 && (11.9..25.1).contains(&p.y) && p.z > 1.9
    });
    for element in SHAPES {
        let run = meshed(&part, &options(element, &[round, side]));
        let away = |p: DVec3| circle(p).abs().max((p.z - 1.0).abs());
        let around: f64 = (on_line(&run.mesh, NEAR * 2.0, away).iter())
            .map(|ends| ends.map(|p| p.truncate() - centre))
            .map(|[u, v]| u.angle_to(v).abs())
            .sum();
        assert!(
            (around - std::f64::consts::TAU).abs() < 1e-6,
            "{element}: {around}"
        );
        let at = |x: f64, y: f64| DVec3::new(x, y, 1.0);
        let corners = [
            at(10.0, 12.0),
            at(30.0, 12.0),
            at(30.0, 25.0),
            at(10.0, 25.0),
        ];
        for k in 0..4 {
            let line = [corners[k], corners[(k + 1) % 4]];
            let share = covered(&run.mesh, NEAR * 2.0, line);
            assert!(share > 1.0 - 1e-6, "{element}, side {k}: {share}");
        }
        let kept = &run.report.solids[0].kept_edges;
        let length = |wish: [i32; 2]| kept.iter().find(|k| k.faces == wish).unwrap().length;
        assert!((length(side) - 66.0).abs() < 1e-6);
        // A polygon in the circle.
        let whole = std::f64::consts::TAU * 9.0;
        assert!((0.98 * whole..whole).contains(&length(round)));
    }
}

/// An angle 2 thick with legs of 40 and 30 and inner radius 5, 25 wide: the bend begins at x = 7 on the one leg, at z = 7 on the other.
const BEND: &str = "Point(1)={0,0,7}; Point(2)={0,0,30}; Point(3)={2,0,30}; Point(4)={2,0,7}; Point(5)={7,0,2}; Point(6)={40,0,2}; Point(7)={40,0,0}; Point(8)={7,0,0}; Point(9)={7,0,7}; \
    Line(1)={1,2}; Line(2)={2,3}; Line(3)={3,4}; Circle(4)={4,9,5}; Line(5)={5,6}; Line(6)={6,7}; Line(7)={7,8}; Circle(8)={8,9,1}; \
    Curve Loop(1)={1:8}; Plane Surface(1)={1}; Extrude{0,25,0}{ Surface{1}; } Recursive Delete{ Surface{:}; }";

#[test]
fn a_bend_begins_at_a_line_from_either_side() {
    let bench = Bench::new();
    let part = bench.step("bend.step", BEND);
    let brep = solid(&part);
    let starts =
        |x: f64, z: f64| faces(&brep, |p| (p.x - x).abs() < 1e-6 && (p.z - z).abs() < 1e-6);
    let (inner, outer) = (starts(7.0, 2.0), starts(7.0, 0.0));
    let line = [DVec3::new(7.0, 0.0, 1.0), DVec3::new(7.0, 25.0, 1.0)];
    for element in SHAPES {
        // One line beneath both edges, or beneath either of them.
        for wish in [&[inner][..], &[outer], &[inner, outer]] {
            let run = meshed(&part, &options(element, wish));
            let share = covered(&run.mesh, NEAR * 2.0, line);
            assert!(share > 1.0 - 1e-6, "{element}: {share}");
            assert_eq!(run.report.audit.unwrap().euler, 1);
            let kept = &run.report.solids[0].kept_edges;
            assert_eq!(kept.len(), wish.len());
            assert!(
                kept.iter().all(|k| (k.length - 25.0).abs() < 1e-3),
                "{kept:?}"
            );
        }
    }
}

#[test]
fn a_line_goes_on_beneath_a_rib_to_the_junction() {
    let bench = Bench::new();
    let script = "Box(1) = {0, 0, 0, 60, 40, 2}; Box(2) = {0, 19, 2, 60, 2, 12}; BooleanUnion(3) = { Volume{1}; Delete; }{ Volume{2}; Delete; }; \
                  Point(90) = {22, 0, 2}; Point(91) = {22, 19, 2}; Line(90) = {90, 91}; BooleanFragments{ Volume{3}; Delete; }{ Curve{90}; Delete; }";
    let part = bench.step("rib.step", script);
    let wish = faces(&solid(&part), |p| {
        (p.x - 22.0).abs() < 1e-6 && (p.z - 2.0).abs() < 1e-6 && p.y < 19.1
    });
    let line = [DVec3::new(22.0, 0.0, 1.0), DVec3::new(22.0, 20.0, 1.0)];
    for element in SHAPES {
        let run = meshed(&part, &options(element, &[wish]));
        let share = covered(&run.mesh, NEAR * 2.0, line);
        assert!(share > 1.0 - 1e-6, "{element}: {share}");
        let kept = &run.report.solids[0].kept_edges;
        assert!((kept[0].length - 20.0).abs() < 1e-6, "{kept:?}");
    }
}

#[test]
fn what_would_part_nothing_is_kept_with_the_other_edges_of_the_smaller_face() {
    let bench = Bench::new();
    // Three faces round a hole; the smallest lies between x = 30 and the slanted line.
    let script = "Box(1) = {0, 0, 0, 60, 40, 2}; Cylinder(2) = {30, 20, -1, 0, 0, 4, 7}; BooleanDifference(3) = { Volume{1}; Delete; }{ Volume{2}; Delete; }; \
                  Point(90) = {30, 20, 2}; Point(91) = {30, 40, 2}; Point(92) = {60, 35, 2}; Point(93) = {0, 20, 2}; \
                  Line(90) = {90, 91}; Line(91) = {90, 92}; Line(92) = {90, 93}; BooleanFragments{ Volume{3}; Delete; }{ Curve{90:92}; Delete; }";
    let part = bench.step("hole.step", script);
    let wish = faces(&solid(&part), |p| (p.x - 30.0).abs() < 1e-6 && p.y > 26.9);
    let lines = [
        [DVec3::new(30.0, 27.0, 1.0), DVec3::new(30.0, 40.0, 1.0)],
        [
            DVec3::new(36.2610, 23.1305, 1.0),
            DVec3::new(60.0, 35.0, 1.0),
        ],
    ];
    for element in SHAPES {
        let run = meshed(&part, &options(element, &[wish]));
        for line in lines {
            let share = covered(&run.mesh, NEAR * 2.0, line);
            assert!(share > 0.999, "{element}: {share}");
        }
        assert_eq!(run.report.solids[0].kept_edges.len(), 2);
        assert_eq!(run.report.audit.unwrap().euler, 0);
    }
}

#[test]
fn what_is_no_edge_or_no_inner_one_is_refused() {
    let bench = Bench::new();
    let part = split_plate(&bench, "");
    let brep = solid(&part);
    let on = |want: fn(DVec3) -> bool| faces(&brep, want);
    let inner = on(|p| p.z > 2.9 && (p.x - 27.0 - p.y / 5.0).abs() < 1e-6);
    let rim = on(|p| p.z > 2.9 && p.x < 1e-6);
    let below = on(|p| p.z < 1e-6 && (p.x - 27.0 - p.y / 5.0).abs() < 1e-6);
    let fault = refusal(&part, &[inner, [inner[0], 99]]);
    assert!(
        matches!(fault, OptionFault::NoFace { face: 99, .. }),
        "{fault}"
    );
    let fault = refusal(&part, &[[inner[0], below[0]]]);
    assert!(matches!(fault, OptionFault::NoEdge { .. }), "{fault}");
    assert_eq!(
        refusal(&part, &[rim]),
        OptionFault::OuterEdge(KeepEdge { faces: rim })
    );
}

#[test]
fn the_program_lists_kept_edges_and_ends_with_2_on_bad_ones() {
    let bench = Bench::new();
    let part = split_plate(&bench, "");
    let [a, b] = faces(&solid(&part), |p| {
        p.z > 2.9 && (p.x - 27.0 - p.y / 5.0).abs() < 1e-6
    });
    let run = |wish: &str| {
        let mut command = bench.midshell();
        command.arg("mesh").arg(&part);
        command.args(["-o", "out.vtu", "--json", "out.json", "--keep-edge", wish]);
        bench.run(command)
    };
    let good = run(&format!("{b}-{a}"));
    assert_eq!(good.status, Some(0), "{}", good.stderr);
    assert!(
        good.stdout.contains(&format!("kept edge {b}-{a}: ")),
        "{}",
        good.stdout
    );
    assert!(
        good.stdout.contains(" element edges, 40.792 mm\n"),
        "{}",
        good.stdout
    );
    let json = std::fs::read_to_string(bench.at("out.json")).unwrap();
    assert!(json.contains("\"kept_edges\""));
    for (wish, word) in [
        ("7", "two different faces"),
        ("7-7", "two different faces"),
        (&format!("{a}-99"), "no face 99"),
    ] {
        let bad = run(wish);
        assert_eq!(bad.status, Some(2), "{wish}");
        assert!(bad.stderr.contains(word), "{}", bad.stderr);
    }
}
