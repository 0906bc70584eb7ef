use super::*;
use crate::geom::placer::Placer;
use crate::geom::random::Pcg;
use crate::model::walls::Wall;
use crate::stage::adjacency::adjacency;
use crate::stage::pair::{PairOptions, pair, sight};
use crate::test_parts::tube_brep;
use crate::test_parts::voxels::{self, Filled, ell, plate, step_plate, tee, wedge};

fn read(brep: &Brep) -> (Aag, Pairing) {
    let aag = adjacency(brep);
    let pairing = pair(brep, &aag, &sight(brep), &PairOptions::default());
    (aag, pairing)
}

/// Random points of a box.
fn points(low: DVec3, high: DVec3) -> Vec<DVec3> {
    let mut rng = Pcg::new(11);
    (0..200)
        .map(|_| low + DVec3::new(rng.unit(), rng.unit(), rng.unit()) * (high - low))
        .collect()
}

fn wall_of(solid: &Filled, pairing: &Pairing, on: impl Fn(DVec3) -> bool) -> WallId {
    let f = solid.face(on);
    let found = pairing.pairs.iter().find(|p| p.faces.contains(&f));
    found.unwrap().wall
}

#[test]
fn a_plate_has_its_middle_everywhere_and_goes_on_beyond_its_rims() {
    let solid = plate(1);
    let (aag, pairing) = read(&solid.brep);
    let medial = Medial::new(&solid.brep, &aag, &pairing);
    let wall = WallId(0);
    let to_first = if pairing.walls[wall].sides[0].contains(&solid.face(|p| p.z == 2.0)) {
        1.0
    } else {
        -1.0
    };
    for p in points(DVec3::new(-1.0, -1.0, 0.1), DVec3::new(41.0, 25.0, 1.9)) {
        let placed = medial.converge(p, &[Support::Mid(wall)], STEPS).0;
        assert!(
            placed.distance(DVec3::new(p.x, p.y, 1.0)) < 1e-12,
            "{p} {placed}"
        );
        assert!((medial.thickness(p, wall).unwrap() - 2.0).abs() < 1e-12);
        let n = medial.normal(p, wall).unwrap();
        assert!((n - DVec3::Z * to_first).length() < 1e-12);
        assert_eq!(medial.curvature_radius(p, wall), f64::INFINITY);
        // Inside: nearer to the first side means a negative difference.
        if p.x > 0.0 && p.x < 40.0 && p.y > 0.0 && p.y < 24.0 {
            let wanted = -2.0 * (p.z - 1.0) * to_first;
            assert!((medial.difference(p, wall).unwrap() - wanted).abs() < 1e-12);
        }
    }
    assert!((medial.mean_thickness(wall) - 2.0).abs() < 1e-9);
}

#[test]
fn rims_and_corners_are_where_the_planes_meet() {
    let solid = plate(1);
    let (aag, pairing) = read(&solid.brep);
    let medial = Medial::new(&solid.brep, &aag, &pairing);
    let mid = Support::Mid(WallId(0));
    let x = Support::Face(solid.face(|p| p.x == 40.0));
    let y = Support::Face(solid.face(|p| p.y == 24.0));
    for p in points(DVec3::new(38.0, 22.0, 0.2), DVec3::new(41.0, 25.0, 1.8)) {
        let rim = medial.place(p, &[mid, x]);
        assert!(rim.distance(DVec3::new(40.0, p.y, 1.0)) < 1e-12, "{rim}");
        let corner = medial.place(p, &[mid, x, y]);
        assert!(
            corner.distance(DVec3::new(40.0, 24.0, 1.0)) < 1e-12,
            "{corner}"
        );
        assert_eq!(medial.place(p, &[]), p);
    }
}

#[test]
fn a_leash_holds_points_that_would_run_away() {
    let solid = plate(1);
    let (aag, pairing) = read(&solid.brep);
    let medial = Medial::new(&solid.brep, &aag, &pairing);
    let start = DVec3::new(20.0, 12.0, 1.0);
    let x = Support::Face(solid.face(|p| p.x == 40.0));
    let placed = medial.place(start, &[Support::Mid(WallId(0)), x]);
    assert!(
        (placed.distance(start) - 3.0 * 2.0).abs() < 1e-9,
        "{placed}"
    );
}

#[test]
fn walls_meet_where_their_middles_do() {
    let solid = tee(1);
    let (aag, pairing) = read(&solid.brep);
    let medial = Medial::new(&solid.brep, &aag, &pairing);
    let floor = Support::Mid(wall_of(&solid, &pairing, |p| p.z == 0.0));
    let rib = Support::Mid(wall_of(&solid, &pairing, |p| p.y == 11.0));
    for p in points(DVec3::new(1.0, 11.0, 0.0), DVec3::new(39.0, 13.0, 2.0)) {
        let placed = medial.place(p, &[floor, rib]);
        assert!(
            placed.distance(DVec3::new(p.x, 12.0, 1.0)) < 1e-12,
            "{placed}"
        );
        // Under the rib the plate's upper side has a gap; its plane goes on.
        let under = medial.place(p, &[floor]);
        assert!(under.distance(DVec3::new(p.x, p.y, 1.0)) < 1e-12, "{under}");
    }
    let solid = ell(1);
    let (aag, pairing) = read(&solid.brep);
    let medial = Medial::new(&solid.brep, &aag, &pairing);
    let floor = Support::Mid(wall_of(&solid, &pairing, |p| p.z == 0.0));
    let wall = Support::Mid(wall_of(&solid, &pairing, |p| p.x == 0.0));
    let end = Support::Face(solid.face(|p| p.y == 0.0));
    for p in points(DVec3::ZERO, DVec3::new(3.0, 3.0, 3.0)) {
        let placed = medial.place(p, &[floor, wall]);
        assert!(
            placed.distance(DVec3::new(1.0, p.y, 1.0)) < 1e-12,
            "{placed}"
        );
        let placed = medial.place(p, &[floor, wall, end]);
        assert!(
            placed.distance(DVec3::new(1.0, 0.0, 1.0)) < 1e-12,
            "{placed}"
        );
    }
}

#[test]
fn mid_points_of_a_wedge_have_equal_distances() {
    let angle = 15f64.to_radians();
    let solid = wedge(angle);
    let (aag, pairing) = read(&solid.brep);
    let medial = Medial::new(&solid.brep, &aag, &pairing);
    for p in points(DVec3::new(5.0, 1.0, 0.5), DVec3::new(40.0, 39.0, 3.0)) {
        let placed = medial.place(p, &[Support::Mid(WallId(0))]);
        let wanted = (placed.x + 2.0 / angle.tan()) * (angle / 2.0).tan();
        assert!((placed.z - wanted).abs() < 1e-9);
        let difference = medial.difference(placed, WallId(0)).unwrap();
        assert!(difference.abs() < 1e-9, "{difference}");
        let thickness = medial.thickness(placed, WallId(0)).unwrap();
        assert!((thickness - 2.0 * wanted).abs() < 1e-9);
    }
}

#[test]
fn a_tube_has_a_round_middle_on_curved_facets() {
    // Flat facets of ten degrees leave the circles by 0.4 % of the radius, 0.04; six-node ones by 2e-5. Beside their seams the foot may lie on
    // the neighbour's border, which costs ten times that.
    let brep = tube_brep(10.0, 8.0, 30.0, 36);
    let (aag, pairing) = read(&brep);
    let medial = Medial::new(&brep, &aag, &pairing);
    assert_eq!(pairing.walls.len(), 1);
    let mut rng = Pcg::new(3);
    for _ in 0..200 {
        let (turn, r) = (rng.unit() * std::f64::consts::TAU, 8.2 + 1.6 * rng.unit());
        let p = DVec3::new(r * turn.cos(), r * turn.sin(), 2.0 + 26.0 * rng.unit());
        let placed = medial.place(p, &[Support::Mid(WallId(0))]);
        let radius = placed.truncate().length();
        assert!((radius - 9.0).abs() < 3e-4, "{radius}");
        let t = medial.thickness(placed, WallId(0)).unwrap();
        assert!((t - 2.0).abs() < 1e-3, "{t}");
        let curvature = medial.curvature_radius(placed, WallId(0));
        assert!((curvature / 9.0 - 1.0).abs() < 0.02, "{curvature}");
        let across = medial
            .normal(placed, WallId(0))
            .unwrap()
            .dot(p.with_z(0.0).normalize());
        assert!((across.abs() - 1.0).abs() < 1e-4, "{across}");
    }
    // A rim slides on the end.
    let end = Support::Face(FaceId(2));
    let placed = medial.place(DVec3::new(9.3, 0.1, 29.0), &[Support::Mid(WallId(0)), end]);
    assert!((placed.z - 30.0).abs() < 1e-9 && (placed.truncate().length() - 9.0).abs() < 1e-4);
}

#[test]
fn places_turn_and_scale_with_the_part() {
    let solid = tee(1);
    let moved = solid.mapped(|p| voxels::motion(p * 1e3));
    let ((aag, pairing), (other_aag, other)) = (read(&solid.brep), read(&moved.brep));
    let medial = Medial::new(&solid.brep, &aag, &pairing);
    let image = Medial::new(&moved.brep, &other_aag, &other);
    for p in points(DVec3::new(1.0, 11.0, 0.0), DVec3::new(39.0, 13.0, 2.0)) {
        for supports in [
            &[Support::Mid(WallId(0))][..],
            &[Support::Mid(WallId(0)), Support::Mid(WallId(1))],
        ] {
            let q = image.place(voxels::motion(p * 1e3), supports);
            let wanted = voxels::motion(medial.place(p, supports) * 1e3);
            assert!(q.distance(wanted) < 1e-6, "{q} {wanted}");
        }
    }
}

#[test]
fn the_middle_climbs_a_step_along_the_parabola() {
    // From 1 below the thin side to 2 below the thick one: as far from the inner edge (20, 2) as from the bottom.
    let solid = step_plate();
    let (aag, pairing) = read(&solid.brep);
    let medial = Medial::new(&solid.brep, &aag, &pairing);
    let wall = WallId(0);
    let wanted = |x: f64| match x - 20.0 {
        d if d < 0.0 => 1.0,
        d if d < 2.0 => 1.0 + d * d / 4.0,
        _ => 2.0,
    };
    let mut on_slope = 0;
    // Beyond the ends of the edge, at y = 0 and 24, it goes on.
    for p in points(DVec3::new(15.0, -1.0, 0.8), DVec3::new(26.0, 25.0, 1.6)) {
        let placed = medial.converge(p, &[Support::Mid(wall)], STEPS).0;
        assert!((placed.z - wanted(placed.x)).abs() < 1e-8, "{p} {placed}");
        assert!((placed.y - p.y).abs() < 1e-9, "{p} {placed}");
        let t = medial.thickness(placed, wall).unwrap();
        assert!((t - 2.0 * placed.z).abs() < 1e-8, "{placed}: {t}");
        let n = medial.normal(placed, wall).unwrap();
        let slope = if placed.x > 20.0 && placed.x < 22.0 {
            (placed.x - 20.0) / 2.0
        } else {
            0.0
        };
        // The ends of the parabola have a kink: to rounding either slope is right there.
        if (placed.x - 22.0).abs() > 1e-6 {
            assert!((n.x / n.z + slope).abs() < 1e-7, "{placed} {n}");
        }
        on_slope += u32::from(slope > 0.0);
    }
    assert!(on_slope > 20);
    // It bends most below the edge; sizes grow from there.
    let radius = |x: f64| medial.curvature_radius(DVec3::new(x, 12.0, wanted(x)), wall);
    assert!((radius(20.0) - 2.0).abs() < 1e-9);
    assert!(radius(17.0) > 6.0 && radius(5.0) == f64::INFINITY);
    // A rim meets it at the end of the plate.
    let end = Support::Face(solid.face(|p| p.y == 0.0));
    let rim = medial.place(DVec3::new(21.0, 0.3, 1.2), &[Support::Mid(wall), end]);
    assert!(
        rim.y.abs() < 1e-9 && (rim.z - wanted(rim.x)).abs() < 1e-8,
        "{rim}"
    );
}

#[test]
fn at_the_crest_of_a_rim_the_middle_is_where_both_sides_are_as_far() {
    // A plate of 4 whose sides end in bevels that face forward more than up and down: their tangent planes define no middle.
    let outline = [
        (0.0, -2.0),
        (20.0, -2.0),
        (20.4, -0.4),
        (20.4, 0.4),
        (20.0, 2.0),
        (0.0, 2.0),
    ];
    let solid = crate::test_parts::prism(&outline, 30.0, |a, b| (a + b) / 2.0);
    let aag = adjacency(&solid);
    let mut pairing = Pairing {
        side: IndexVec::filled(None, solid.faces.len()),
        ..Pairing::default()
    };
    pairing.walls.push(crate::model::walls::Wall {
        sides: [vec![FaceId(3), FaceId(4)], vec![FaceId(0), FaceId(1)]],
        thickness: 4.0,
        group: 0,
    });
    let medial = Medial::new(&solid, &aag, &pairing);
    for z in [-0.3, -0.1, 0.2, 0.35] {
        let p = DVec3::new(12.0, 20.1, z);
        let placed = medial.place(p, &[Support::Mid(WallId(0))]);
        assert!(placed.z.abs() < 1e-6, "{p} {placed}");
        assert!(placed.distance(p) < 0.5, "{p} {placed}");
        let normal = medial.normal(p, WallId(0)).unwrap();
        assert!(normal.z.abs() > 0.5, "{normal}");
    }
}

#[test]
fn a_layer_keeps_its_middle_though_another_layer_of_its_wall_is_nearer() {
    // Two plates of 2 with a gap of 0.2, bent round into each other: what faces the gap is the outer side of one and the inner side of the other.
    let grid = [
        voxels::lines(&[(2.0, 1), (40.0, 10)]),
        voxels::lines(&[(24.0, 6)]),
        voxels::lines(&[(2.0, 1), (2.2, 1), (4.2, 1)]),
    ];
    let solid = voxels::filled(grid, |p| p.x < 2.0 || p.z < 2.0 || p.z > 2.2);
    let (aag, mut pairing) = read(&solid.brep);
    let sides = [[0.0, 2.2], [2.0, 4.2]].map(|levels| {
        let mut side = levels
            .map(|z| solid.face(|p| p.z == z && (z == 0.0 || z == 4.2 || p.x >= 2.0)))
            .to_vec();
        side.sort_unstable();
        side
    });
    let wall = Wall {
        sides,
        thickness: 2.0,
        group: 0,
    };
    pairing.walls = [wall].into_iter().collect();
    let medial = Medial::new(&solid.brep, &aag, &pairing);
    for p in points(DVec3::new(8.0, 2.0, 0.1), DVec3::new(36.0, 22.0, 1.9)) {
        for (up, middle) in [(0.0, 1.0), (2.2, 3.2)] {
            let p = p + DVec3::Z * up;
            let placed = medial.place(p, &[Support::Mid(WallId(0))]);
            assert!((placed.z - middle).abs() < 1e-9, "{p} {placed}");
            let t = medial.thickness(p, WallId(0)).unwrap();
            assert!((t - 2.0).abs() < 1e-9, "{p}: {t}");
        }
    }
}

#[test]
fn in_what_two_layers_stand_on_a_node_goes_to_the_nearer_layer_and_not_between_them() {
    let solid = voxels::two_ribs();
    let (aag, mut pairing) = read(&solid.brep);
    let sides = [[10.0, 13.0], [11.0, 14.0]].map(|at| {
        let mut side = at.map(|y| solid.face(|p| p.y == y)).to_vec();
        side.sort_unstable();
        side
    });
    pairing.walls = [Wall {
        sides,
        thickness: 1.0,
        group: 0,
    }]
    .into_iter()
    .collect();
    let medial = Medial::new(&solid.brep, &aag, &pairing);
    for (y, middle) in [
        (9.8, 10.5),
        (10.5, 10.5),
        (11.2, 10.5),
        (11.8, 10.5),
        (12.2, 13.5),
        (12.8, 13.5),
        (14.3, 13.5),
    ] {
        let placed = medial.place(DVec3::new(17.0, y, 1.0), &[Support::Mid(WallId(0))]);
        let wanted = DVec3::new(17.0, middle, 1.0);
        assert!(placed.distance(wanted) < 1e-9, "{y}: {placed}");
    }
}

#[test]
fn round_the_inner_edge_of_a_step_the_mid_surface_bends() {
    let solid = step_plate();
    let (aag, pairing) = read(&solid.brep);
    let medial = Medial::new(&solid.brep, &aag, &pairing);
    let wall = WallId(0);
    for (x, z) in [(19.5, 1.2), (20.0, 1.0), (20.5, 1.4)] {
        let p = DVec3::new(x, 11.0, z);
        let wanted = 2.0 * (x - 20.0).hypot(z - 2.0);
        assert!((medial.curvature_radius(p, wall) - wanted).abs() < 1e-12);
    }
    for x in [4.0, 36.0] {
        let p = DVec3::new(x, 11.0, 1.0);
        assert_eq!(medial.curvature_radius(p, wall), f64::INFINITY);
    }
}

/// A plate of 4 whose upper side (face 3) ends in a rounding (face 2) of the given radius down to the end face (1); its lower side is face 0.
fn rounded_plate(radius: f64) -> (Brep, Aag, Pairing) {
    let (y, z) = (20.0 - radius, 2.0 - radius);
    let outline = [(0.0, -2.0), (20.0, -2.0), (20.0, z), (y, 2.0), (0.0, 2.0)];
    let solid = crate::test_parts::prism(&outline, 30.0, |a, b| {
        let m = (a + b) / 2.0;
        let centre = DVec3::new(m.x, y, z);
        if m.y > y && m.y < 20.0 && m.z > z && m.z < 2.0 {
            centre + (m - centre).normalize() * radius
        } else {
            m
        }
    });
    let aag = adjacency(&solid);
    let mut pairing = Pairing {
        side: IndexVec::filled(None, solid.faces.len()),
        ..Pairing::default()
    };
    pairing.walls.push(crate::model::walls::Wall {
        sides: [vec![FaceId(2), FaceId(3)], vec![FaceId(0)]],
        thickness: 4.0,
        group: 0,
    });
    for face in [0, 2, 3] {
        pairing.side[FaceId(face)] = Some((0, u8::from(face == 0)));
    }
    (solid, aag, pairing)
}

#[test]
fn over_a_rounded_corner_the_middle_of_the_flat_sides_goes_on_to_the_rim() {
    let (solid, aag, pairing) = rounded_plate(0.6);
    let medial = Medial::new(&solid, &aag, &pairing);
    let rim = [Support::Mid(WallId(0)), Support::Face(FaceId(1))];
    // At x = 35 the plate has ended by more than its thickness, by less than it may be carried on: the foot of a handle goes on as far.
    for (x, z) in [(12.0, -0.5), (12.0, 0.0), (12.0, 0.4), (35.0, 0.3)] {
        let placed = medial.place(DVec3::new(x, 19.8, z), &rim);
        // Half way between the lower side and the tangent plane at the rounding's end would be the corner at z = -2.
        assert!(
            placed.distance(DVec3::new(x, 20.0, 0.0)) < 1e-9,
            "{x} {z}: {placed}"
        );
    }
}

#[test]
fn under_a_rounding_that_reaches_the_middle_the_foot_stays_at_its_end() {
    for (radius, turned) in [(0.6, false), (2.0, true), (3.0, true)] {
        let (solid, aag, pairing) = rounded_plate(radius);
        let medial = Medial::new(&solid, &aag, &pairing);
        let p = DVec3::new(12.0, 19.8, 2.0 - radius - 0.2);
        let [upper, _] = medial.feet(p, WallId(0)).unwrap();
        assert_eq!(upper.normal.y > 0.9, turned, "{radius}: {upper:?}");
        assert_eq!(upper.normal.z > 0.999, !turned, "{radius}: {upper:?}");
    }
}

#[test]
fn beyond_a_rounding_that_reaches_the_middle_its_end_face_goes_on() {
    // Midway between the end face, carried on down, and the lower side is the corner, to rounding; the last normal of the rounding's one facet is off by several degrees.
    for radius in [2.0, 2.8] {
        let (solid, aag, pairing) = rounded_plate(radius);
        let medial = Medial::new(&solid, &aag, &pairing);
        let rim = [Support::Mid(WallId(0)), Support::Face(FaceId(1))];
        let placed = medial.place(DVec3::new(12.0, 19.7, -1.6), &rim);
        let corner = DVec3::new(12.0, 20.0, -2.0);
        assert!(placed.distance(corner) < 1e-9, "{radius}: {placed}");
        // The facet alone: the same place looked at through a pairing in which the end face is a side, so that the rounding leads over to none.
        let mut without = pairing.clone();
        without.side[FaceId(1)] = Some((0, 0));
        let medial = Medial::new(&solid, &aag, &without);
        let [upper, _] = medial
            .feet(DVec3::new(12.0, 19.8, -1.7), WallId(0))
            .unwrap();
        assert!(upper.normal.y < 0.9999, "{radius}: {}", upper.normal);
    }
}

#[test]
fn a_flat_side_is_flat_however_the_part_lies() {
    // Turned, corner normals of a flat facet differ by rounding: that is no bend with a radius of light years, which would outweigh the rounding across the wall.
    let (mut solid, aag, pairing) = rounded_plate(2.8);
    for p in solid.vertices.iter_mut() {
        *p = voxels::motion(*p);
    }
    for facet in solid.facets.iter_mut() {
        facet.mids = facet.mids.map(voxels::motion);
    }
    let medial = Medial::new(&solid, &aag, &pairing);
    let at =
        |y: f64, z: f64| medial.curvature_radius(voxels::motion(DVec3::new(12.0, y, z)), WallId(0));
    assert_eq!(at(10.0, 0.0), f64::INFINITY);
    // The rounding has one facet, which knows its bend to a tenth.
    let under = at(19.0, -1.0);
    assert!((under / (2.0 * 2.8) - 1.0).abs() < 0.15, "{under}");
}

/// A plate of 3 with a full round end at y = 20. Of the 16 facets round it the first `lower` belong to the lower side (face 0), the others to the upper one (face 1); `one_face`: the two were one.
fn round_ended(lower: u32, one_face: bool) -> (Brep, Aag, Pairing) {
    let centre = |x: f64| DVec3::new(x, 18.5, 0.0);
    let quarter = |k: u32| {
        let turn = f64::from(k) * 11.25f64.to_radians();
        (18.5 + 1.5 * turn.sin(), -1.5 * turn.cos())
    };
    let mut outline = vec![(0.0, -1.5)];
    outline.extend((0..=16).map(quarter));
    outline.push((0.0, 1.5));
    let mut solid = crate::test_parts::prism(&outline, 30.0, |a, b| {
        let m = (a + b) / 2.0;
        let round = a.y > 18.4 && b.y > 18.4 && (a.x - b.x).abs() < 30.1;
        let out = m - centre(m.x);
        if round && m.x > 0.0 && m.x < 30.0 || round && a.x == b.x {
            centre(m.x) + out.normalize() * 1.5
        } else {
            m
        }
    });
    // Face 0 is the flat lower side, 1 to 16 go round the end, 17 is the upper side.
    for facet in solid.facets.as_mut_slice() {
        let face = facet.face.0;
        if face <= 17 {
            facet.face = FaceId(u32::from(face > lower));
        }
    }
    if one_face {
        solid.faces[FaceId(1)].tag = solid.faces[FaceId(0)].tag;
    }
    let aag = adjacency(&solid);
    let mut pairing = Pairing {
        side: IndexVec::filled(None, solid.faces.len()),
        ..Pairing::default()
    };
    pairing.walls.push(Wall {
        sides: [vec![FaceId(1)], vec![FaceId(0)]],
        thickness: 3.0,
        group: 0,
    });
    (solid, aag, pairing)
}

#[test]
fn beneath_the_crest_of_a_full_rounding_the_middle_is_found_from_beside_it() {
    // Two quarters of a circle of 1.5 that meet at y = 20: near there the ways to both differ by less than a tangent plane has to, to say anything.
    let (solid, aag, pairing) = round_ended(8, false);
    let medial = Medial::new(&solid, &aag, &pairing);
    for (y, z) in [(19.0, 0.3), (19.5, 0.177), (19.5, -0.177), (19.8, 0.05)] {
        let placed = medial.place(DVec3::new(12.0, y, z), &[Support::Mid(WallId(0))]);
        // The distances differ by the square of the height: steps halve it.
        assert!(placed.z.abs() < 3e-3, "{y} {z}: {placed}");
        assert!(
            (placed.y - y).abs() < 0.2 && (placed.x - 12.0).abs() < 1e-9,
            "{placed}"
        );
    }
}

#[test]
fn where_one_face_was_cut_beside_the_crest_the_rim_is_on_the_crest() {
    let rim = [Support::Mid(WallId(0)), Support::Face(FaceId(1))];
    for lower in [6, 8, 10] {
        let (solid, aag, pairing) = round_ended(lower, true);
        let medial = Medial::new(&solid, &aag, &pairing);
        for (y, z) in [(19.9, 0.0), (19.8, 0.4), (19.8, -0.4), (19.3, 0.2)] {
            let placed = medial.place(DVec3::new(12.0, y, z), &rim);
            let crest = DVec3::new(12.0, 20.0, 0.0);
            assert!(placed.distance(crest) < 3e-3, "{lower} {y} {z}: {placed}");
            let inside = medial.place(DVec3::new(12.0, y - 0.3, z), &rim[..1]);
            assert!(inside.z.abs() < 3e-3, "{lower} {y} {z}: {inside}");
            let normal = medial.normal(inside, WallId(0)).unwrap();
            assert!(normal.z > 1.0 - 1e-4, "{lower} {y} {z}: {normal}");
            assert_eq!(medial.curvature_radius(placed, WallId(0)), f64::INFINITY);
        }
    }
    // Of two faces each has its own border, and there the sides meet: a quarter of a right angle from the crest.
    let (solid, aag, pairing) = round_ended(10, false);
    let placed = Medial::new(&solid, &aag, &pairing).place(DVec3::new(12.0, 19.9, 0.0), &rim);
    assert!(placed.z > 0.3, "{placed}");
}
