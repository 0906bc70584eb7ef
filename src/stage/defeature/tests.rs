use super::boundary::Skin;
use super::cap::bent_middle;
use super::*;
use crate::geom::placer::Placer;
use crate::medial::Medial;
use crate::stage::adjacency::adjacency;
use crate::stage::extract;
use crate::test_parts::stages::stages;
use crate::test_parts::voxels::{
    Filled, filled, hollow_box, lines, motion, plate, plate_with_hole, square_tube, tee,
};
use crate::test_parts::{box_brep, tube_brep};
use std::f64::consts::{PI, TAU};

const BOTH: fn(f64) -> SmallLimits = |limit| SmallLimits {
    hole: Some(limit),
    feature: Some(limit),
};

/// Holes below a limit filled, and what they were filled in.
fn holes_of(solid: &Filled, limit: f64) -> Defeatured {
    let s = stages(solid);
    fill_holes(&solid.brep, &s.aag, &s.pairing, &s.complex(), &BOTH(limit))
}

fn features_of(solid: &Filled, limit: f64) -> Defeatured {
    let s = stages(solid);
    flatten_features(&solid.brep, &s.aag, &s.pairing, &s.complex(), &BOTH(limit))
}

/// The new mid-surface on the new boundary.
fn placed(new: &Defeatured) -> MidComplex {
    let aag = adjacency(&new.brep);
    let medial = Medial::new(&new.brep, &aag, &new.pairing);
    extract::place(new.complex.clone(), &medial)
}

/// A plate 40 x 24 x 3 with a pocket 8 x 8 that is 1 deep, or a pad as high.
fn marked(up: bool) -> Filled {
    let z = lines(&[(2.0, 2), (3.0, 1), (4.0, 1)]);
    let grid = [lines(&[(40.0, 10)]), lines(&[(24.0, 6)]), z];
    filled(grid, |p| {
        let within = (16.0..24.0).contains(&p.x) && (8.0..16.0).contains(&p.y);
        p.z < 2.0
            || if up {
                p.z < 3.0 || within
            } else {
                p.z < 3.0 && !within
            }
    })
}

#[test]
fn a_hole_is_filled_as_if_it_had_never_been() {
    let solid = plate_with_hole();
    let new = holes_of(&solid, 11.0);
    assert_eq!((new.brep.check(), new.complex.check()), (vec![], vec![]));
    assert_eq!(new.brep.euler(), solid.brep.euler() + 2);
    assert_eq!((new.complex.euler(), new.complex.pieces()), (1, 1));
    assert!((new.brep.volume() - 40.0 * 24.0 * 2.0).abs() < 1e-9);
    let [hole] = &new.removed[..] else {
        panic!("{:?}", new.removed)
    };
    assert!((hole.size - 32.0 / PI).abs() < 1e-12, "{}", hole.size);
    assert!(hole.at.distance(DVec3::new(20.0, 12.0, 1.0)) < 1e-12);
    assert_eq!(
        (hole.kind, hole.faces.len(), hole.height),
        (SmallKind::Hole, 4, 2.0)
    );
    // All of the plate is mid-surface now, half-way up.
    let complex = placed(&new);
    let area: f64 = (complex.triangles.iter())
        .map(|t| complex.area_vector(t).length())
        .sum();
    assert!((area - 40.0 * 24.0).abs() < 1e-6, "{area}");
    assert!(complex.nodes.iter().all(|n| (n.point.z - 1.0).abs() < 1e-9));
}

#[test]
fn a_hole_of_the_limit_and_the_outer_rim_stay() {
    let solid = plate_with_hole();
    for limit in [1.0, 32.0 / PI] {
        let new = holes_of(&solid, limit);
        assert_eq!((new.removed.len(), new.left.len()), (0, 0), "{limit}");
        assert_eq!(new.brep, solid.brep);
    }
    // The rim round the plate is 128 long: 40.7 across.
    let new = holes_of(&solid, 1000.0);
    assert_eq!((new.removed.len(), new.left.len()), (1, 0));
    assert_eq!(new.complex.euler(), 1);
}

#[test]
fn nothing_depends_on_place_size_or_numbers() {
    let solid = plate_with_hole();
    let want = &holes_of(&solid, 11.0).removed[0];
    for scale in [0.001, 1.0, 1000.0] {
        let moved = solid.mapped(|p| motion(p) * scale).shuffled(5);
        let new = holes_of(&moved, 11.0 * scale);
        let [hole] = &new.removed[..] else {
            panic!("{scale}: {:?}", new.left)
        };
        assert!((hole.size / scale - want.size).abs() < 1e-9);
        assert!((hole.at / scale).distance(motion(want.at)) < 1e-9);
        assert_eq!(new.complex.euler(), 1);
        assert_eq!(new.brep.check(), vec![]);
    }
}

#[test]
fn the_ends_of_a_tube_stay_and_say_why() {
    let new = holes_of(&square_tube(), 100.0);
    assert!(new.removed.is_empty());
    let why: Vec<Obstacle> = new.left.iter().map(|l| l.why).collect();
    assert_eq!(why, [Obstacle::End; 2]);
}

#[test]
fn a_hole_that_something_runs_through_stays() {
    let mut solid = plate_with_hole();
    let pin = box_brep(DVec3::new(1.0, 1.0, 10.0));
    let (vertices, faces) = (
        solid.brep.vertices.len() as u32,
        solid.brep.faces.len() as u32,
    );
    let shift = DVec3::new(18.7, 11.2, -4.0);
    let plain = plate_with_hole();
    let stages = stages(&plain);
    solid.brep.vertices = (solid.brep.vertices.iter().copied())
        .chain(pin.vertices.iter().map(|&p| p + shift))
        .collect();
    for f in &pin.facets {
        solid.brep.facets.push(Facet {
            corners: f
                .corners
                .map(|v| crate::model::ids::VertexId(v.0 + vertices)),
            mids: f.mids.map(|m| m + shift),
            face: FaceId(f.face.0 + faces),
        });
    }
    for face in &pin.faces {
        solid.brep.faces.push(face.clone());
    }
    let aag = adjacency(&solid.brep);
    let mut pairing = stages.pairing.clone();
    pairing.side = solid
        .brep
        .faces
        .ids()
        .map(|f| stages.pairing.side.get(f).copied().flatten())
        .collect();
    let new = fill_holes(&solid.brep, &aag, &pairing, &stages.complex(), &BOTH(11.0));
    assert!(new.removed.is_empty());
    assert_eq!(new.left[0].why, Obstacle::Obstructed);
}

#[test]
fn pockets_and_pads_are_flattened() {
    for up in [false, true] {
        let solid = marked(up);
        let new = features_of(&solid, 12.0);
        let [feature] = &new.removed[..] else {
            panic!("{up}: {:?}", new.left)
        };
        // A circle round a square of 8.
        assert!((feature.size - 8.0 * 2f64.sqrt()).abs() < 1e-9);
        assert!((feature.height - 1.0).abs() < 1e-9);
        assert!(feature.at.distance(DVec3::new(20.0, 12.0, 3.0)) < 1e-9);
        assert!((new.brep.volume() - 40.0 * 24.0 * 3.0).abs() < 1e-6);
        assert_eq!((new.brep.check(), new.complex.check()), (vec![], vec![]));
        assert_eq!(new.complex.euler(), 1);
        let complex = placed(&new);
        assert!(complex.nodes.iter().all(|n| (n.point.z - 1.5).abs() < 1e-9));
        let walls: BTreeSet<WallId> = complex.triangles.iter().map(|t| t.wall).collect();
        assert_eq!(walls.len(), 1);
        // A pad that is as high as the limit allows, and no wider, stays.
        assert!(features_of(&solid, 11.0).removed.is_empty());
    }
}

#[test]
fn a_small_rib_with_a_sheet_of_its_own_comes_off_its_plate() {
    // 1 thick, 6 long and 4 high, in the middle of a plate 40 x 24 x 2.
    let grid = [
        lines(&[(17.0, 5), (23.0, 4), (40.0, 5)]),
        lines(&[(11.5, 4), (12.5, 1), (24.0, 4)]),
        lines(&[(2.0, 1), (6.0, 3)]),
    ];
    let solid = filled(grid, |p| {
        p.z < 2.0 || ((17.0..23.0).contains(&p.x) && (11.5..12.5).contains(&p.y))
    });
    let s = stages(&solid);
    let before = s.complex();
    assert!(before.edges().iter().any(|e| e.triangles.len() == 3));
    let new = flatten_features(&solid.brep, &s.aag, &s.pairing, &before, &BOTH(7.0));
    assert_eq!(new.removed.len(), 1, "{:?}", new.left);
    assert_eq!((new.brep.check(), new.complex.check()), (vec![], vec![]));
    assert_eq!((new.complex.euler(), new.complex.pieces()), (1, 1));
    let complex = placed(&new);
    assert!(complex.edges().iter().all(|e| e.triangles.len() <= 2));
    assert!(complex.nodes.iter().all(|n| (n.point.z - 1.0).abs() < 1e-9));
}

#[test]
fn ribs_boxes_and_plain_plates_have_nothing_to_flatten() {
    for solid in [plate(1), tee(1), hollow_box(), square_tube()] {
        let new = features_of(&solid, 1000.0);
        assert!(new.removed.is_empty(), "{:?}", new.removed);
        assert_eq!(new.brep, solid.brep);
    }
}

#[test]
fn without_limits_nothing_changes() {
    let solid = plate_with_hole();
    let s = stages(&solid);
    let (complex, none) = (s.complex(), SmallLimits::default());
    for step in [fill_holes, flatten_features] {
        let new = step(&solid.brep, &s.aag, &s.pairing, &complex, &none);
        assert_eq!(new.brep, solid.brep);
        assert_eq!(new.pairing, s.pairing);
        assert_eq!(new.complex.triangles, complex.triangles);
    }
}

#[test]
fn loops_are_as_long_as_their_arcs_and_turn_as_their_surface_says() {
    // Seen from the ends of a tube its skins do not turn; from a face of a box the next ones turn by a quarter at each corner.
    let tube = tube_brep(10.0, 8.0, 5.0, 12);
    let skin = Skin::new(&tube);
    let end = BTreeSet::from([FaceId(2)]);
    let loops = skin.loops(&end).unwrap();
    assert_eq!(loops.len(), 2);
    for (l, radius) in loops.iter().zip([10.0, 8.0]) {
        assert!((skin.length(l) - TAU * radius).abs() < 1e-9);
        assert!(skin.turning(l, &end).abs() < 1e-9);
        assert!(skin.middle(l).distance(DVec3::new(0.0, 0.0, 5.0)) < 1e-9);
    }
    let plate = plate_with_hole().brep;
    let skin = Skin::new(&plate);
    let rims: BTreeSet<FaceId> = (plate.faces.ids())
        .filter(|&f| plate.area_vector(skin.of_face[f][0]).z.abs() < 1e-9)
        .collect();
    let mut turns: Vec<f64> = (skin.loops(&rims).unwrap().iter())
        .map(|l| skin.turning(l, &rims) / TAU)
        .collect();
    turns.sort_by(f64::total_cmp);
    for (turn, want) in turns.iter().zip([-1.0, -1.0, 1.0, 1.0]) {
        assert!((turn - want).abs() < 1e-12, "{turns:?}");
    }
}

#[test]
fn the_middle_between_two_points_of_a_circle_or_a_helix_lies_on_their_surface() {
    let on = |angle: f64, z: f64| {
        let n = DVec3::new(angle.cos(), angle.sin(), 0.0);
        (n * 7.0 + DVec3::Z * z, n)
    };
    for (angle, rise) in [(0.3, 0.0), (1.0, 4.0), (1.9, 0.0)] {
        let ((a, n), (b, m)) = (on(0.2, 1.0), on(0.2 + angle, 1.0 + rise));
        let middle = bent_middle([a, b], [n, m]);
        let (want, _) = on(0.2 + angle / 2.0, 1.0 + rise / 2.0);
        assert!(middle.distance(want) < 1e-12, "{angle}");
    }
    let flat = bent_middle([DVec3::ZERO, DVec3::X], [DVec3::Z; 2]);
    assert_eq!(flat, DVec3::X / 2.0);
}

#[test]
fn the_cap_over_a_hole_in_a_tube_has_the_tubes_thickness() {
    // A wedge of rays through the wall is the whole of a voxel plate bent to a tube of radius 21 outside and 19 inside.
    let bent = plate_with_hole().mapped(|p| {
        let angle = (p.x - 20.0) / 20.0;
        DVec3::new(angle.sin(), 0.0, angle.cos()) * (19.0 + p.z) + DVec3::Y * p.y
    });
    // Facets as the importer's: mid-side points on the surface.
    let mut bent = bent;
    let radius = |p: DVec3| p.x.hypot(p.z);
    let v = bent.brep.vertices.clone();
    for f in bent.brep.facets.iter_mut() {
        for k in 0..3 {
            let [a, b] = [f.corners[k], f.corners[(k + 1) % 3]].map(|c| v[c]);
            let (middle, r) = ((a + b) / 2.0, (radius(a) + radius(b)) / 2.0);
            let scale = r / radius(middle);
            f.mids[k] = DVec3::new(middle.x * scale, middle.y, middle.z * scale);
        }
    }
    let new = holes_of(&bent, 11.5);
    assert_eq!(new.removed.len(), 1, "{:?}", new.left);
    let aag = adjacency(&new.brep);
    let medial = Medial::new(&new.brep, &aag, &new.pairing);
    let wall = new.complex.triangles[crate::model::ids::TriangleId(0)].wall;
    for (angle, y) in [(0.0, 12.0), (0.1, 10.0), (-0.17, 14.5), (0.05, 9.0)] {
        let up = DVec3::new(f64::sin(angle), 0.0, f64::cos(angle));
        let start = up * 20.2 + DVec3::Y * y;
        let p = medial.place(start, &[Support::Mid(wall)]);
        // A hundredth of the thickness: the normals at the rim are those of six-node facets that turn by 11 degrees.
        assert!((radius(p) - 20.0).abs() < 0.02, "{}", radius(p));
        let thickness = medial.thickness(p, wall).unwrap();
        assert!((thickness - 2.0).abs() < 0.02, "{thickness}");
    }
}
