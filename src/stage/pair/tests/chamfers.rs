use super::*;
use crate::test_parts::prism;
use std::f64::consts::SQRT_2;

const BOTTOM: u32 = 0;
const END: u32 = 1;
const CHAMFER: u32 = 2;
const TOP: u32 = 3;

/// A plate 60 x 40 x 3 with a chamfer at the end y = 60 that takes away `drop` of the end face and `run` of the upper side.
fn plate(run: f64, drop: f64, scale: f64) -> Brep {
    let outline = [
        (0.0, 0.0),
        (60.0, 0.0),
        (60.0, 3.0 - drop),
        (60.0 - run, 3.0),
        (0.0, 3.0),
    ]
    .map(|(y, z)| (y * scale, z * scale));
    prism(&outline, 40.0 * scale, |a, b| (a + b) / 2.0)
}

#[test]
fn a_chamfer_is_a_side_opposite_to_the_side_below_it() {
    for scale in [1e-3, 1.0, 1e3] {
        let found = paired(&plate(1.8, 1.8, scale));
        assert_eq!(faces(&found), [[BOTTOM, CHAMFER], [BOTTOM, TOP]]);
        // The heights above the bottom, from the end face up to the edge with the upper side, to rounding.
        let [low, mean, high] = found.pairs[0].thickness.map(|t| t / scale);
        assert!((1.2 - 1e-9..1.2 + 0.1 * 1.8).contains(&low), "{low}");
        assert!((3.0 - 0.1 * 1.8..3.0 + 1e-9).contains(&high), "{high}");
        assert!((mean - 2.1).abs() < 0.05, "{mean}");
        let area = 1.8 * SQRT_2 * 40.0;
        assert!((found.pairs[0].overlap / scale / scale / area - 1.0).abs() < 0.05);
        assert!(found.opposing(FaceId(BOTTOM), FaceId(CHAMFER)));
        assert!(found.side[FaceId(END)].is_none());
    }
}

#[test]
fn little_and_steep_chamfers_and_those_that_leave_nothing_are_none() {
    let chamfered = |run: f64, drop: f64| {
        let found = paired(&plate(run, drop, 1.0));
        assert!(faces(&found).contains(&[BOTTOM, TOP]));
        found.side[FaceId(CHAMFER)].is_some()
    };
    let steep = |degrees: f64| 1.8 / degrees.to_radians().tan();
    assert!(chamfered(1.2, 1.2));
    assert!(chamfered(0.75, 0.75), "a quarter of the thickness");
    assert!(chamfered(2.4, 2.4));
    assert!(!chamfered(0.6, 0.6), "a fifth of the thickness");
    assert!(!chamfered(2.9, 2.9), "a knife's edge");
    assert!(chamfered(steep(50.0), 1.8));
    assert!(!chamfered(steep(60.0), 1.8), "an end face that leans");
}

#[test]
fn equal_chamfers_on_both_sides_leave_the_middle_straight() {
    let outline = [
        (0.0, 0.0),
        (58.8, 0.0),
        (60.0, 1.2),
        (60.0, 1.8),
        (58.8, 3.0),
        (0.0, 3.0),
    ];
    let found = paired(&prism(&outline, 40.0, |a, b| (a + b) / 2.0));
    assert_eq!(faces(&found), [[0, 4]]);
}

#[test]
fn a_chamfer_between_two_sides_is_no_rim() {
    // The outer corner of a bent plate 3 thick, bevelled.
    let outline = [
        (2.0, 0.0),
        (40.0, 0.0),
        (40.0, 3.0),
        (3.0, 3.0),
        (3.0, 30.0),
        (0.0, 30.0),
        (0.0, 2.0),
    ];
    // Convex polygons only: the outline is two plates and a corner, each end drawn in four.
    let points = [0.0, 40.0]
        .into_iter()
        .flat_map(|x| outline.map(|(y, z)| glam::DVec3::new(x, y, z)))
        .collect();
    let mut polygons: Vec<(Vec<usize>, u32)> = (0..7)
        .map(|i| (vec![i, (i + 1) % 7, (i + 1) % 7 + 7, i + 7], i as u32))
        .collect();
    for (offset, face) in [(0, 7), (7, 8)] {
        for triangle in [[0, 1, 2], [0, 2, 3], [0, 3, 6], [6, 3, 4], [6, 4, 5]] {
            let mut at = triangle.map(|i| i + offset).to_vec();
            if offset == 0 {
                at.reverse();
            }
            polygons.push((at, face));
        }
    }
    let found = paired(&crate::test_parts::brep(points, &polygons, |a, b| {
        (a + b) / 2.0
    }));
    assert!(faces(&found).contains(&[0, 2]));
    assert!(faces(&found).contains(&[3, 5]));
    assert!(found.side[FaceId(6)].is_none());
}

#[test]
fn without_its_side_or_seen_from_outside_a_chamfer_is_none() {
    let solid = plate(1.8, 1.8, 1.0);
    let (aag, mut looks) = (adjacency(&solid), sight(&solid));
    let pairs = super::super::gates::pairs(&aag, &looks, &PairOptions::default());
    let found = |looks: &[_], pairs: &[_]| {
        super::super::chamfers::chamfers(&solid, &aag, looks, pairs).len()
    };
    // The gates alone do not know it.
    assert_eq!(pairs.len(), 1);
    assert_eq!(found(&looks, &pairs), 1);
    assert_eq!(found(&looks, &[]), 0);
    for look in &mut looks {
        look.inward = -look.inward;
    }
    assert_eq!(found(&looks, &pairs), 0);
}
