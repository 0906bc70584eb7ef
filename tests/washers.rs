//! Washers end to end: rings of quads round the holes of a part, measured in the finished mesh against the circles that they have to lie on. Needs gmsh.

#![cfg(unix)]
#![allow(clippy::unwrap_used, clippy::panic)]

mod binary;

use binary::{Bench, gmsh};
use glam::DVec3;
use midshell::model::element_shape::ElementShape;
use midshell::model::washer::{NoWasher, Washer, WasherRequest, Washers};
use midshell::options::MeshOptions;
use midshell::pipeline::{MeshRun, Progress, mesh};
use std::path::Path;

/// A plate of 100 x 60 x 2 with a web on x = 50 and three holes of 8: one with room for its rings, one 3 from the rim, one 4 from the middle of the web.
const PART: &str = "Box(1) = {0, 0, 0, 100, 60, 2};\nBox(2) = {49, 0, 0, 2, 60, 22};\n\
    BooleanUnion(3) = { Volume{1}; Delete; }{ Volume{2}; Delete; };\n\
    Cylinder(4) = {22, 30, -1, 0, 0, 4, 4};\nCylinder(5) = {75, 7, -1, 0, 0, 4, 4};\nCylinder(6) = {42, 30, -1, 0, 0, 4, 4};\n\
    BooleanDifference{ Volume{3}; Delete; }{ Volume{4:6}; Delete; }\n";
/// The part turned about a skew axis, shifted and made half as large again.
const MOTION: &str = "Rotate { {1, 2, 3}, {5, -7, 11}, 0.7 } { Volume{:}; }\nTranslate {37, -53, 71} { Volume{:}; }\nDilate { {0, 0, 0}, 1.5 } { Volume{:}; }\n";
const SCALE: f64 = 1.5;

struct Silent;

impl Progress for Silent {
    fn stage(&self, _: &str) {}
}

fn run(input: &Path, element: ElementShape, washer: WasherRequest) -> (MeshRun, Washers) {
    let options = MeshOptions {
        element,
        washer,
        gmsh: Some(gmsh()),
        ..MeshOptions::default()
    };
    let run = mesh(input, &options, &Silent).unwrap();
    assert_eq!(run.report.doubts, Vec::<String>::new());
    let washers = run.report.solids[0].washers.clone().unwrap();
    (run, washers)
}

fn layers(layers: u32) -> WasherRequest {
    WasherRequest {
        layers,
        ..WasherRequest::default()
    }
}

/// The mesh within the outer circle of a washer is its rings and nothing else.
fn measure(run: &MeshRun, washer: &Washer) {
    let radius = washer.diameter / 2.0;
    let outer = radius + f64::from(washer.layers) * washer.width;
    let away = |p: DVec3| {
        let d = p - washer.centre;
        let height = d.dot(washer.axis);
        (d - washer.axis * height)
            .length()
            .hypot(if height.abs() < 1e-6 { 0.0 } else { 1e9 })
    };
    let at = |r: f64, slack: f64| {
        let on = |p: &&DVec3| (away(**p) - r).abs() <= slack;
        run.mesh.nodes.iter().filter(on).count()
    };
    let around = washer.around as usize;
    // The rim lies on the facets of the hole.
    assert_eq!(at(radius, 0.01 * radius), around);
    for k in 1..=washer.layers {
        let r = radius + f64::from(k) * washer.width;
        assert_eq!(at(r, 1e-6 * r), around, "circle {k}");
    }
    let inside = run
        .mesh
        .nodes
        .iter()
        .filter(|p| away(**p) <= outer * (1.0 + 1e-6));
    assert_eq!(inside.count(), around * (washer.layers as usize + 1));
    let truth = (std::f64::consts::PI / f64::from(washer.around)).cos();
    let mut rings = 0;
    for (element, quality) in run.mesh.elements.iter().zip(&run.cell_quality) {
        let corners = element.corners.as_slice();
        if corners
            .iter()
            .all(|n| away(run.mesh.nodes[*n]) <= outer * (1.0 + 1e-6))
        {
            assert!(element.corners.is_quad());
            assert!((quality - truth).abs() < 0.05, "{quality} for {truth}");
            rings += 1;
        }
    }
    assert_eq!(rings, around * washer.layers as usize);
}

#[test]
fn rings_stand_round_each_hole_however_the_part_lies() {
    let bench = Bench::new();
    let input = bench.step("part.step", PART);
    let moved = bench.step("moved.step", &format!("{PART}{MOTION}"));
    let (run_here, here) = run(&input, ElementShape::Quad, layers(2));
    assert_eq!((here.made.len(), here.left_out.len()), (3, 0));
    here.made.iter().for_each(|w| measure(&run_here, w));
    let own = |x: f64| {
        let near = |w: &&Washer| (w.centre.x - x).abs() < 0.01;
        here.made.iter().find(near).unwrap()
    };
    // Beside the rim, 7 from the middle, a whole edge of the outer circle would leave less than half of what the rings want: half an edge is left.
    let beside_rim = |w: &Washer, scale: f64| {
        let edge = std::f64::consts::TAU / f64::from(w.around);
        let truth = (7.0 / (1.0 + edge / 2.0) - 4.0) / 2.0;
        assert!((w.width / scale - truth).abs() < 0.01, "{w:?}");
    };
    let narrow = own(75.0);
    beside_rim(narrow, 1.0);
    assert!(own(22.0).width > own(42.0).width && own(42.0).width > narrow.width);
    let (run_there, there) = run(&moved, ElementShape::Quad, layers(2));
    assert_eq!(there.made.len(), 3);
    there.made.iter().for_each(|w| measure(&run_there, w));
    // How many edges the remesher gives a rim hangs on how the part lies; all else follows from it.
    let narrowest = there.made.iter().min_by(|a, b| a.width.total_cmp(&b.width));
    beside_rim(narrowest.unwrap(), SCALE);
    for washer in &there.made {
        assert!((washer.diameter / SCALE - 8.0).abs() < 0.08, "{washer:?}");
    }
}

#[test]
fn on_mixed_elements_and_pipes_too() {
    let bench = Bench::new();
    let input = bench.step("part.step", PART);
    let request = WasherRequest {
        holes: Some([7.0, 9.0]),
        width: Some(1.2),
        ..layers(1)
    };
    let (there, washers) = run(&input, ElementShape::Mixed, request);
    assert_eq!((washers.made.len(), washers.left_out.len()), (3, 0));
    for washer in &washers.made {
        assert_eq!(washer.width, 1.2);
        measure(&there, washer);
    }
    // A hole across a pipe has one; the ends of the pipe are no holes, and across a wide hole the pipe bends too much.
    let pipe = "Cylinder(1) = {0, 0, 0, 0, 0, 70, 25};\nCylinder(2) = {0, 0, -1, 0, 0, 72, 23};\n\
                BooleanDifference(3) = { Volume{1}; Delete; }{ Volume{2}; Delete; };\n\
                Cylinder(4) = {0, 0, 20, 50, 0, 0, 5};\nCylinder(5) = {0, 0, 48, 0, 50, 0, 14};\n\
                BooleanDifference{ Volume{3}; Delete; }{ Volume{4:5}; Delete; }\n";
    let request = WasherRequest {
        holes: Some([1.0, 60.0]),
        ..layers(2)
    };
    let input = bench.step("pipe.step", pipe);
    let (_, washers) = run(&input, ElementShape::Quad, request);
    assert_eq!((washers.made.len(), washers.left_out.len()), (1, 1));
    assert!((washers.made[0].diameter - 10.0).abs() < 0.2);
    assert_eq!(washers.left_out[0].why, NoWasher::Bent);
}

#[test]
fn the_report_lists_them_and_threads_change_no_byte() {
    let bench = Bench::new();
    let input = bench.step("part.step", PART);
    let more = |threads: &'static str| {
        [
            "--element",
            "quad",
            "--washer",
            "2",
            "--threads",
            threads,
            "--json",
            "out.json",
        ]
    };
    let ended = bench.mesh(&input, &more("1"));
    ended.went_well(&["out.json", "out.vtu"]);
    assert!(
        ended
            .stdout
            .contains("washers: 3 holes of 8.0 mm: 2 rings of"),
        "{}",
        ended.stdout
    );
    let json: serde_json::Value =
        serde_json::from_slice(&std::fs::read(bench.at("out.json")).unwrap()).unwrap();
    let washers = &json["solids"][0]["washers"];
    assert_eq!(washers["made"].as_array().unwrap().len(), 3);
    assert_eq!(washers["made"][0]["layers"], 2);
    assert_eq!(washers["left_out"].as_array().unwrap().len(), 0);
    let once = std::fs::read(bench.at("out.vtu")).unwrap();
    bench.mesh(&input, &more("4"));
    assert!(std::fs::read(bench.at("out.vtu")).unwrap() == once);
}
