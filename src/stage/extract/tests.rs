use super::*;
use crate::model::complex::EdgeKind;
use crate::test_parts::homology::of_complex;
use crate::test_parts::stages::{Stages, stages};
use crate::test_parts::voxels::{self, Filled, motion, thin_parts};

/// Rounding of coordinates of a few tens of millimetres after a few steps of placing.
const EXACT: f64 = 1e-12;

fn area(complex: &MidComplex) -> f64 {
    (complex.triangles.iter())
        .map(|t| {
            let [a, b, c] = t.nodes.map(|n| complex.nodes[n].point);
            (b - a).cross(c - a).length() / 2.0
        })
        .sum()
}

/// Total length of the edges of a kind; every one must have both ends where `on` says.
fn length(complex: &MidComplex, kind: EdgeKind, on: impl Fn(DVec3) -> bool) -> f64 {
    (complex.edges().iter())
        .filter(|e| complex.kind(e) == kind)
        .map(|e| {
            let [a, b] = e.ends.map(|n| complex.nodes[n].point);
            assert!(on(a) && on(b), "{kind:?} edge at {a} - {b}");
            (b - a).length()
        })
        .sum()
}

fn near(x: f64, y: f64) -> bool {
    (x - y).abs() <= EXACT * 40.0
}

fn close(x: f64, y: f64) -> bool {
    (x - y).abs() <= 1e-9 * y.abs()
}

#[test]
fn every_part_keeps_its_pieces_loops_and_voids() {
    for (name, solid, betti) in thin_parts() {
        let complex = stages(&solid).complex();
        assert_eq!(complex.check(), vec![], "{name}");
        assert_eq!(of_complex(&complex), betti, "{name}");
        assert_eq!(complex.pieces(), 1, "{name}");
        assert_eq!(2 * complex.euler(), solid.boundary_euler(), "{name}");
    }
}

#[test]
fn every_part_keeps_them_when_it_is_turned() {
    for (name, solid, betti) in thin_parts() {
        let solid = solid.mapped(motion);
        assert_eq!(of_complex(&stages(&solid).complex()), betti, "{name}");
    }
}

#[test]
fn a_plate_lies_in_its_exact_middle_and_ends_on_its_faces() {
    for layers in [1, 2, 3] {
        let solid = voxels::plate(layers);
        let complex = stages(&solid).complex();
        for n in &complex.nodes {
            assert!(near(n.point.z, 1.0), "{}", n.point);
        }
        assert!(close(area(&complex), 960.0), "{}", area(&complex));
        let rim = |p: DVec3| near(p.x, 0.0) || near(p.x, 40.0) || near(p.y, 0.0) || near(p.y, 24.0);
        assert!(close(length(&complex, EdgeKind::Rim, rim), 128.0));
        for corner in [(0.0, 0.0), (40.0, 0.0), (40.0, 24.0), (0.0, 24.0)] {
            let corner = DVec3::new(corner.0, corner.1, 1.0);
            let hit = |n: &&MidNode| n.point.distance(corner) < 40.0 * EXACT;
            assert_eq!(complex.nodes.iter().filter(hit).count(), 1, "{corner}");
        }
    }
}

#[test]
fn a_hole_keeps_its_sharp_corners() {
    let solid = voxels::plate_with_hole();
    let complex = stages(&solid).complex();
    assert!(close(area(&complex), 960.0 - 64.0));
    let rim = |p: DVec3| {
        let outer = near(p.x, 0.0) || near(p.x, 40.0) || near(p.y, 0.0) || near(p.y, 24.0);
        let inner = near(p.x, 16.0) || near(p.x, 24.0) || near(p.y, 8.0) || near(p.y, 16.0);
        near(p.z, 1.0) && (outer || inner)
    };
    assert!(close(length(&complex, EdgeKind::Rim, rim), 128.0 + 32.0));
}

#[test]
fn a_rib_meets_its_plate_on_one_exact_line() {
    let solid = voxels::tee(1);
    let complex = stages(&solid).complex();
    for n in &complex.nodes {
        let p = n.point;
        assert!(near(p.z, 1.0) || near(p.y, 12.0), "{p}");
    }
    let line = |p: DVec3| near(p.y, 12.0) && near(p.z, 1.0);
    assert!(close(length(&complex, EdgeKind::Junction, line), 40.0));
    assert_eq!(length(&complex, EdgeKind::Crease, |_| false), 0.0);
    assert!(
        close(area(&complex), 960.0 + 40.0 * 13.0),
        "{}",
        area(&complex)
    );
}

#[test]
fn crossing_plates_meet_on_one_exact_line() {
    let solid = voxels::cross();
    let complex = stages(&solid).complex();
    for n in &complex.nodes {
        assert!(
            near(n.point.z, 12.0) || near(n.point.y, 12.0),
            "{}",
            n.point
        );
    }
}

#[test]
fn folds_come_to_lie_where_the_middles_meet() {
    let at = |p: DVec3, x: f64, z: f64| near(p.x, x) && near(p.z, z);
    let ell = voxels::ell(1);
    let complex = stages(&ell).complex();
    assert!(close(
        length(&complex, EdgeKind::Crease, |p| at(p, 1.0, 1.0)),
        24.0
    ));
    assert!(
        close(area(&complex), 24.0 * (29.0 + 19.0)),
        "{}",
        area(&complex)
    );
    let channel = voxels::channel();
    let complex = stages(&channel).complex();
    let fold = |p| at(p, 1.0, 1.0) || at(p, 29.0, 1.0);
    assert!(close(length(&complex, EdgeKind::Crease, fold), 48.0));
    assert!(close(area(&complex), 24.0 * (28.0 + 2.0 * 19.0)));
}

#[test]
fn a_closed_box_becomes_a_closed_box() {
    let solid = voxels::hollow_box();
    let complex = stages(&solid).complex();
    let on = |p: DVec3| {
        [
            near(p.x, 1.0),
            near(p.x, 23.0),
            near(p.y, 1.0),
            near(p.y, 19.0),
        ]
        .into_iter()
        .chain([near(p.z, 1.0), near(p.z, 15.0)])
        .filter(|b| *b)
        .count()
    };
    assert!(complex.nodes.iter().all(|n| on(n.point) >= 1));
    assert_eq!(length(&complex, EdgeKind::Rim, |_| false), 0.0);
    let folds = length(&complex, EdgeKind::Crease, |p| on(p) >= 2);
    assert!(close(folds, 4.0 * (22.0 + 18.0 + 14.0)), "{folds}");
    let wanted = 2.0 * (22.0 * 18.0 + 22.0 * 14.0 + 18.0 * 14.0);
    assert!(close(area(&complex), wanted), "{}", area(&complex));
}

#[test]
fn a_step_of_thickness_is_one_sheet_along_its_parabola() {
    let solid = voxels::step_plate();
    let complex = stages(&solid).complex();
    for n in &complex.nodes {
        let p = n.point;
        let beyond = (p.x - 20.0).clamp(0.0, 2.0);
        assert!((p.z - 1.0 - beyond * beyond / 4.0).abs() < 1e-6, "{p}");
    }
    assert_eq!(length(&complex, EdgeKind::Crease, |_| true), 0.0);
}

#[test]
fn a_wedge_lies_in_the_plane_that_halves_its_angle() {
    for degrees in [1f64, 5.0, 15.0] {
        let angle = degrees.to_radians();
        let solid = voxels::wedge(angle);
        let complex = stages(&solid).complex();
        // The apex of the wedge lies at x = -2 / tan.
        for n in &complex.nodes {
            let p = n.point;
            let wanted = (p.x + 2.0 / angle.tan()) * (angle / 2.0).tan();
            assert!((p.z - wanted).abs() < 1e-9, "{p} {wanted}");
        }
    }
}

/// What must not change: area, length of rims and of junctions. Triangles may: regular parts are full of ties, and two walls that are equally
/// near or two diagonals of equal length change places.
fn figures(solid: &Filled) -> [f64; 3] {
    let complex = stages(solid).complex();
    let long = |kind| length(&complex, kind, |_| true);
    [
        area(&complex),
        long(EdgeKind::Rim),
        long(EdgeKind::Junction),
    ]
}

fn assert_same(name: &str, solid: &Filled, other: &Filled, scale: f64) {
    // In these, vertices inside a junction or a lump are equally near to several faces, or a strip between two levels has quads with equal
    // diagonals: what is made of them is a matter of rounding.
    let tied = ["three layers", "block", "step"]
        .iter()
        .any(|w| name.contains(w));
    let exactness = if tied { 0.005 } else { 1e-9 };
    let (first, second) = (figures(solid), figures(other));
    let size = solid.brep.diagonal();
    for (k, power) in [2, 1, 1].into_iter().enumerate() {
        let slack = exactness * size.powi(power);
        let found = second[k] / scale.powi(power);
        assert!(
            (found - first[k]).abs() < slack,
            "{name}: {first:?} {second:?}"
        );
    }
}

#[test]
fn numbers_of_faces_do_not_matter() {
    for (name, solid, _) in thin_parts() {
        assert_same(name, &solid, &solid.shuffled(3), 1.0);
    }
}

#[test]
fn scale_does_not_matter() {
    for (name, solid, _) in thin_parts() {
        for scale in [1e-3, 1e3] {
            assert_same(name, &solid, &solid.mapped(|p| p * scale), scale);
        }
    }
}

#[test]
fn place_in_space_does_not_matter() {
    for (name, solid, _) in thin_parts() {
        assert_same(name, &solid, &solid.mapped(motion), 1.0);
    }
}

#[test]
fn cells_of_plain_walls_know_their_wall_and_others_ask_their_neighbours() {
    let wall_at = |stages: &Stages<'_>| {
        let medial = stages.medial();
        stages.cell_walls(&medial)
    };
    let solid = voxels::plate(1);
    let (walls, adopted) = wall_at(&stages(&solid));
    assert_eq!(adopted, 0);
    let cells = stages(&solid).widened().cells;
    for (e, wall) in walls.enumerated() {
        assert_eq!(wall.is_some(), cells[e]);
    }
    let solid = voxels::tee(1);
    let stages = stages(&solid);
    let (walls, _) = wall_at(&stages);
    let rib = solid.face(|p| p.y == 11.0);
    for (e, wall) in walls.enumerated() {
        let Some(wall) = *wall else { continue };
        let [p, q] = stages.graph.edges[e].map(|v| solid.brep.vertices[v]);
        let is_rib = stages.pairing.walls[wall]
            .sides
            .iter()
            .any(|s| s.contains(&rib));
        if p.z > 2.0 && q.z > 2.0 {
            assert!(is_rib, "{p} {q}");
        } else if (p.y - 12.0).abs() > 1.0 && (q.y - 12.0).abs() > 1.0 {
            assert!(!is_rib, "{p} {q}");
        }
    }
}
