use super::*;
use crate::stage::pair::sight;
use crate::test_parts::{box_brep, brep, tube_brep, wing_brep};

/// The solid with all its faces as one.
fn as_one(mut brep: Brep) -> Brep {
    for facet in brep.facets.iter_mut() {
        facet.face = FaceId(0);
    }
    brep.faces = brep.faces.iter().take(1).cloned().collect();
    brep
}

fn divided(brep: &Brep) -> Option<Brep> {
    divide(brep, &sight(brep))
}

/// Facets by face, by the z of their middles.
fn heights(brep: &Brep, face: u32) -> Vec<f64> {
    let mut all: Vec<f64> = (brep.facets.enumerated())
        .filter(|(_, f)| f.face == FaceId(face))
        .map(|(id, _)| brep.corners(id).iter().map(|p| p.z).sum::<f64>() / 3.0)
        .collect();
    all.sort_unstable_by(f64::total_cmp);
    all
}

#[test]
fn a_plate_of_one_face_gets_two_sides_and_four_rims() {
    let plate = divided(&as_one(box_brep(DVec3::new(20.0, 20.0, 2.0)))).unwrap();
    assert_eq!(plate.check(), vec![]);
    // Its four edges are sharp: each rim is a face.
    assert_eq!(plate.faces.len(), 6);
    assert!(plate.faces.iter().all(|f| f.tag == 1));
    let mut across: Vec<f64> = (0..6)
        .map(|f| heights(&plate, f))
        .map(|z| z[1] - z[0])
        .collect();
    across.sort_unstable_by(f64::total_cmp);
    // Two facets each: level on the sides, two thirds and one third up the rims.
    for (found, true_) in across.iter().zip([0.0, 0.0, 2.0, 2.0, 2.0, 2.0]) {
        assert!((found - true_ / 3.0).abs() < 1e-12);
    }
    // As many borders as a box has edges.
    assert_eq!(plate.curves.len(), 12);
    assert!(
        plate
            .curves
            .iter()
            .all(|c| c.faces.len() == 2 && c.segments.len() == 1)
    );
    for (id, curve) in plate.curves.enumerated() {
        for face in &curve.faces {
            assert!(plate.faces[*face].curves.contains(&id));
        }
    }
}

#[test]
fn faces_that_lie_on_one_side_each_stay_as_they_are() {
    assert_eq!(divided(&box_brep(DVec3::new(20.0, 20.0, 2.0))), None);
    assert_eq!(divided(&tube_brep(10.0, 8.0, 30.0, 24)), None);
}

#[test]
fn a_rod_of_one_face_is_no_wall() {
    assert_eq!(divided(&as_one(box_brep(DVec3::new(2.0, 2.0, 40.0)))), None);
}

#[test]
fn a_tube_of_one_face_gets_an_inside_and_an_outside() {
    let tube = divided(&as_one(tube_brep(10.0, 8.0, 30.0, 24))).unwrap();
    assert_eq!(tube.check(), vec![]);
    // Both ends are rims.
    assert_eq!(tube.faces.len(), 4);
    let mut radii: Vec<[f64; 2]> = (0..4)
        .map(|face| {
            let corners = (tube.facets.enumerated())
                .filter(|(_, f)| f.face == FaceId(face))
                .flat_map(|(id, _)| tube.corners(id));
            let radii: Vec<f64> = corners.map(|p| p.x.hypot(p.y)).collect();
            [
                radii.iter().copied().fold(f64::INFINITY, f64::min),
                radii.iter().copied().fold(0.0, f64::max),
            ]
        })
        .collect();
    radii.sort_unstable_by(|a, b| a[0].total_cmp(&b[0]).then(a[1].total_cmp(&b[1])));
    for (found, true_) in radii
        .iter()
        .zip([[8.0, 8.0], [8.0, 10.0], [8.0, 10.0], [10.0, 10.0]])
    {
        assert!((found[0] - true_[0]).abs() < 1e-9 && (found[1] - true_[1]).abs() < 1e-9);
    }
}

#[test]
fn a_region_never_sees_itself() {
    // A ring of six that all touch; each sees the one across.
    let mate: Vec<Option<u32>> = (0..6).map(|i| Some((i + 3) % 6)).collect();
    let mut regions = Regions::new(&mate);
    for i in 0..6 {
        regions.join(i, (i + 1) % 6);
    }
    let sets: Vec<u32> = (0..6).map(|i| regions.sets.find(i)).collect();
    assert_eq!(sets, [0, 0, 0, 3, 3, 3]);
    assert!((0..6).all(|i| sets[i] != sets[(i + 3) % 6]));
}

/// A hollow wing whose outer and inner skin are one face each, and its ends.
fn wing_of_two_faces(half_angle: f64) -> Brep {
    let mut wing = wing_brep(10.0, 8.0, half_angle, 20.0, 24);
    for facet in wing.facets.iter_mut() {
        facet.face = FaceId([0, 0, 0, 1, 1, 1, 2, 3][facet.face.index()]);
    }
    wing.faces = wing.faces.iter().take(4).cloned().collect();
    wing
}

#[test]
fn a_face_that_meets_itself_in_a_corner_becomes_an_upper_and_a_lower_one() {
    let wing = wing_of_two_faces(0.4);
    let parted = divide_at_corners(&wing).unwrap();
    assert_eq!(parted.check(), vec![]);
    assert_eq!(parted.faces.len(), 6);
    let mut above: BTreeMap<FaceId, [bool; 2]> = BTreeMap::new();
    for (id, facet) in parted.facets.enumerated() {
        let z = parted.corners(id).iter().map(|p| p.z).sum::<f64>();
        // Facets at the very nose may go either way.
        if z.abs() > 3.0 * 2.0 {
            above.entry(facet.face).or_default()[usize::from(z > 0.0)] = true;
        }
    }
    let skins: Vec<[bool; 2]> = [0, 1, 4, 5].map(|f| above[&FaceId(f)]).to_vec();
    assert!(skins.iter().all(|[low, high]| low != high), "{skins:?}");
    assert_eq!(above[&FaceId(2)], [true, true]);
}

/// A cone of sixteen facets in one face, one of whose sides is a corner of 27 degrees: a point of its foot is drawn outwards.
fn ridged_cone() -> Brep {
    let ring = |i: usize| std::f64::consts::TAU * (i % 16) as f64 / 16.0;
    let mut points: Vec<DVec3> = (0..16)
        .map(|i| DVec3::new(9.0 * ring(i).cos(), 9.0 * ring(i).sin(), 0.0))
        .collect();
    points[0].x += 1.2;
    points.push(DVec3::new(0.0, 0.0, 5.0));
    let mut polygons: Vec<(Vec<usize>, u32)> =
        (0..16).map(|i| (vec![i, (i + 1) % 16, 16], 0)).collect();
    polygons.push(((0..16).rev().collect(), 1));
    brep(points, &polygons, |a, b| (a + b) / 2.0)
}

#[test]
fn bends_and_corners_that_end_within_a_face_part_nothing() {
    assert!(divide_at_corners(&tube_brep(10.0, 8.0, 20.0, 24)).is_none());
    // Four facets round the nose turn 60 degrees each where they are flat, but are drawn on the round.
    assert!(divide_at_corners(&wing_brep(10.0, 8.0, 0.4, 20.0, 4)).is_none());
    // On flat facets all sides of a bend turn as much.
    let mut coarse = tube_brep(10.0, 8.0, 20.0, 8);
    for id in coarse.facets.ids().collect::<Vec<_>>() {
        let [a, b, c] = coarse.corners(id);
        coarse.facets[id].mids = [(a + b) / 2.0, (b + c) / 2.0, (c + a) / 2.0];
    }
    assert!(divide_at_corners(&coarse).is_none());
    // Four facets round a hole, whose middles lie on the round: where their sides cross the hole they turn by 80 degrees.
    assert!(divide_at_corners(&tube_brep(10.0, 0.8, 20.0, 4)).is_none());
    // Eleven degrees are no corner.
    let seamless = divide_at_corners(&wing_of_two_faces(std::f64::consts::FRAC_PI_2 - 0.1));
    assert!(seamless.is_none());
    // A ridge up to the tip of a cone: round the tip one comes from its one hand to the other.
    assert!(divide_at_corners(&ridged_cone()).is_none());
}
