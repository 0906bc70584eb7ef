use super::*;
use crate::charts;
use crate::geom::placer::Lengths;
use crate::geom::quality::quad_quality;
use crate::model::element_shape::ElementShape;
use crate::model::ids::WallId;
use crate::model::report::Profile;
use crate::model::shell::{Corners, ShellMesh};
use crate::stage::chart_mesh::Pattern;
use crate::stage::respace::respace;
use crate::stage::test_shapes::{self as shapes, Build, Onto, Stay};
use crate::test_parts::{element, sheet};
use glam::DVec3;

/// A complex meshed in squares of a size.
fn squares(complex: &MidComplex, size: f64, placer: &dyn Placer) -> MidComplex {
    let lengths = |_: DVec3, _: WallId| Lengths::equal(size);
    let even = respace(complex.clone(), &lengths, placer);
    charts::mesh_charts(&even, Pattern::Squares, &lengths, placer).complex
}

/// The same, then in quads.
fn made(complex: &MidComplex, size: f64, placer: &dyn Placer) -> Halves {
    let halves = quads(squares(complex, size, placer), placer);
    assert_eq!(halves.complex.check(), vec![]);
    assert_eq!(halves.complex.euler(), complex.euler());
    assert_eq!(halves.complex.pieces(), complex.pieces());
    halves
}

/// Its elements by way of a shell: triangles left over, and scaled Jacobians of the quads.
fn counted(halves: &Halves) -> (usize, Vec<f64>) {
    let complex = &halves.complex;
    let mesh = ShellMesh {
        nodes: complex.nodes.iter().map(|n| n.point).collect(),
        elements: (complex.triangles.iter())
            .map(|t| element(Corners::Triangle(t.nodes), t.wall.0, 1.0))
            .collect(),
        sheets: (0..3).map(|_| sheet()).collect(),
        ..ShellMesh::default()
    };
    let paired = pair_quads(
        &mesh,
        &halves.diagonals,
        ElementShape::Quad,
        &Profile::shell(),
    );
    let jacobians: Vec<f64> = (paired.elements.iter())
        .filter_map(|e| match e.corners {
            Corners::Quad(n) => Some(quad_quality(n.map(|n| paired.nodes[n])).scaled_jacobian),
            Corners::Triangle(_) => None,
        })
        .collect();
    (paired.elements.len() - jacobians.len(), jacobians)
}

fn least(all: &[f64]) -> f64 {
    all.iter().copied().fold(f64::INFINITY, f64::min)
}

fn mean(all: &[f64]) -> f64 {
    all.iter().sum::<f64>() / all.len() as f64
}

#[test]
fn a_plate_divided_evenly_becomes_its_squares() {
    let plate = shapes::sheet(20, 12, |u, v| DVec3::new(20.0 * u, 12.0 * v, 0.0));
    let (triangles, quads) = counted(&made(&plate, 1.0, &Stay));
    assert_eq!((triangles, quads.len()), (0, 240));
    assert!(least(&quads) > 1.0 - 1e-9);
}

#[test]
fn a_plate_with_holes_is_all_quads_and_good_ones() {
    let plate = shapes::plate_with_holes(3.0);
    let (triangles, quads) = counted(&made(&plate, 3.0, &Stay));
    assert_eq!(triangles, 0);
    assert!(least(&quads) >= 0.65, "{}", least(&quads));
    assert!(mean(&quads) >= 0.94, "{}", mean(&quads));
    // 6000 mm² less the holes, in squares of 3 mm.
    let ideal = (6000.0 - std::f64::consts::PI * 200.0) / 9.0;
    assert!(
        (quads.len() as f64 / ideal - 1.0).abs() < 0.15,
        "{} for {ideal}",
        quads.len()
    );
}

#[test]
fn a_curved_wall_keeps_its_nodes_on_the_surface() {
    let tube = shapes::tube(40, 20, 30.0);
    let round = Onto(|p: DVec3| {
        let flat = DVec3::new(p.x, p.y, 0.0).normalize() * 10.0;
        DVec3::new(flat.x, flat.y, p.z)
    });
    let halves = made(&tube, 1.57, &round);
    for node in &halves.complex.nodes {
        assert!((node.point.truncate().length() - 10.0).abs() < 1e-9);
    }
    let (triangles, quads) = counted(&halves);
    assert_eq!(triangles, 0);
    assert!(least(&quads) > 0.75, "{}", least(&quads));
}

#[test]
fn sheets_at_a_junction_stay_joined_node_by_node() {
    let rib = shapes::rib_on_plate(1.0);
    let halves = made(&rib, 2.0, &Stay);
    let junctions = |c: &MidComplex| -> usize {
        let edges = c.edges();
        edges.iter().filter(|e| e.triangles.len() == 3).count()
    };
    assert!(junctions(&halves.complex) >= 20);
    let (triangles, quads) = counted(&halves);
    assert_eq!(triangles, 0);
    assert!(least(&quads) > 0.7, "{}", least(&quads));
    // Nothing else is free than before.
    let free: f64 = free_length(&halves.complex);
    assert!((free - free_length(&rib)).abs() < 1e-9);
}

fn free_length(complex: &MidComplex) -> f64 {
    (complex.edges().iter())
        .filter(|e| complex.kind(e) == EdgeKind::Rim)
        .map(|e| {
            let [a, b] = e.ends.map(|n| complex.nodes[n].point);
            a.distance(b)
        })
        .sum()
}

#[test]
fn nodes_on_both_sides_of_a_strip_come_to_face_each_other() {
    // Twenty edges on either side; those above are shifted by half.
    let mut b = Build::default();
    let low = |i: usize| DVec3::new(i as f64, 0.0, 0.0);
    let high = |i: usize| match i {
        0 => DVec3::Y,
        20 => DVec3::new(20.0, 1.0, 0.0),
        i => DVec3::new(i as f64 + 0.45, 1.0, 0.0),
    };
    for i in 0..20 {
        b.triangle(WallId(0), [low(i), low(i + 1), high(i)]);
        b.triangle(WallId(0), [low(i + 1), high(i + 1), high(i)]);
    }
    let halves = quads(b.complex.clone(), &Stay);
    let (triangles, after) = counted(&halves);
    let before = counted(&Halves {
        complex: b.complex,
        diagonals: Vec::new(),
    });
    assert_eq!((triangles, after.len()), (0, 20));
    assert!(
        mean(&before.1) < 0.93 && least(&after) > 0.95,
        "{}",
        least(&after)
    );
}

#[test]
fn the_same_for_any_number_of_threads() {
    let rib = shapes::rib_on_plate(0.5);
    let [one, four] = [1, 4].map(|n| {
        let pool = rayon::ThreadPoolBuilder::new()
            .num_threads(n)
            .build()
            .unwrap();
        pool.install(|| made(&rib, 1.5, &Stay))
    });
    assert_eq!(one, four);
}

#[test]
fn a_plate_turned_in_space_is_as_good() {
    let plate = shapes::plate_with_holes(4.0);
    let [a, b] = [plate.clone(), shapes::moved(&plate)].map(|c| counted(&made(&c, 4.0, &Stay)));
    assert_eq!((a.0, b.0), (0, 0));
    let ratio = a.1.len() as f64 / b.1.len() as f64;
    assert!((ratio - 1.0).abs() < 0.1, "{} and {}", a.1.len(), b.1.len());
    assert!((mean(&a.1) - mean(&b.1)).abs() < 0.02);
}

#[test]
fn a_sheet_that_is_folded_keeps_its_triangles() {
    let mut plate = shapes::sheet(6, 6, |u, v| DVec3::new(6.0 * u, 6.0 * v, 0.0));
    // A node beyond the next: both sides of it are turned over, and held as they are on the rim.
    let at = |p: DVec3, c: &MidComplex| -> NodeId {
        c.nodes
            .enumerated()
            .find(|n| n.1.point.distance(p) < 1e-9)
            .unwrap()
            .0
    };
    let node = at(DVec3::new(3.0, 0.0, 0.0), &plate);
    plate.nodes[node].point = DVec3::new(3.0, 2.6, 0.0);
    let halves = quads(plate.clone(), &Stay);
    assert_eq!(halves.complex.euler(), plate.euler());
    assert_eq!(halves.complex.pieces(), 1);
}

#[test]
fn a_spared_sheet_keeps_its_triangles_and_the_others_get_quads() {
    let squares = squares(&shapes::rib_on_plate(1.0), 2.0, &Stay);
    let quadding = Quadding::new(squares, &Stay);
    let (halves, owner) = quadding.without(&[0]);
    assert_eq!(halves.complex.check(), vec![]);
    assert_eq!(owner.len(), halves.complex.triangles.len());
    let corners = |complex: &MidComplex, t: TriangleId| {
        let mut p = complex.triangles[t]
            .nodes
            .map(|n| complex.nodes[n].point.to_array().map(f64::to_bits));
        p.sort_unstable();
        p
    };
    let mut before: Vec<_> = (quadding.sheets[0].source.iter())
        .map(|&t| corners(&quadding.complex, t))
        .collect();
    let mut after: Vec<_> = (halves.complex.triangles.ids())
        .filter(|t| owner[t.index()] == 0)
        .map(|t| corners(&halves.complex, t))
        .collect();
    before.sort_unstable();
    after.sort_unstable();
    assert_eq!(before, after);
    let (triangles, quads) = counted(&halves);
    // Pairs that nobody has laid are still found in it; the other sheets are all quads.
    assert!(!halves.diagonals.is_empty() && !quads.is_empty());
    assert!(triangles <= before.len());
}

#[test]
fn where_nothing_folds_both_ways_give_the_same_quads() {
    let squares = squares(&shapes::plate_with_holes(3.0), 3.0, &Stay);
    assert_eq!(
        quads(squares.clone(), &Stay),
        unfolded_quads(squares, &Stay)
    );
}
