use super::*;
use crate::model::ids::{FaceId, WallId};
use crate::model::walls::FacePair;
use crate::test_parts::box_brep;
use glam::DVec3;

fn pairing(pairs: &[(f64, f64)]) -> Pairing {
    Pairing {
        pairs: (pairs.iter().zip(0..))
            .map(|(&(thickness, overlap), i)| FacePair {
                faces: [FaceId(2 * i), FaceId(2 * i + 1)],
                overlap,
                thickness: [thickness; 3],
                wall: WallId(i),
            })
            .collect(),
        ..Pairing::default()
    }
}

#[test]
fn a_wish_is_taken_as_it_is() {
    let brep = box_brep(DVec3::new(100.0, 60.0, 3.0));
    let found = sizing(&brep, &pairing(&[(3.0, 6000.0)]), Some(7.5), Some(24.0));
    assert_eq!((found.target, found.per_turn), (7.5, Some(24.0)));
}

#[test]
fn without_a_wish_three_thicknesses_within_bounds() {
    let size = |x: f64, y: f64, t: f64| {
        let brep = box_brep(DVec3::new(x, y, t));
        let target = sizing(&brep, &pairing(&[(t, x * y)]), None, None).target;
        (target, brep)
    };
    // A plate of 40 x 30 elements of three thicknesses and more: the thickness decides.
    assert!((size(200.0, 150.0, 1.0).0 - 3.0).abs() < 1e-12);
    // Thick: the part's diagonal decides.
    let (target, brep) = size(30.0, 30.0, 3.0);
    assert!(target < 9.0 && target / brep.diagonal() <= 0.04 + 1e-12);
    // Huge and thin: the number of triangles decides, half of the skin over equal triangles.
    let (target, brep) = size(3000.0, 3000.0, 1.0);
    let triangles = brep.area() / 2.0 / (target * target * 3f64.sqrt() / 4.0);
    assert!((triangles - 40_000.0).abs() < 1.0, "{triangles}");
}

#[test]
fn the_typical_thickness_is_the_median_by_area() {
    let typical = |p: &[(f64, f64)]| typical_thickness(&pairing(p));
    assert_eq!(typical(&[(5.0, 1.0), (1.0, 10.0), (9.0, 1.0)]), 1.0);
    assert_eq!(typical(&[(5.0, 10.0), (1.0, 4.0), (9.0, 4.0)]), 5.0);
    assert_eq!(typical(&[]), 0.0);
}

#[test]
fn sizes_scale_with_the_part() {
    for scale in [1e-3, 1e3] {
        let of = |s: f64| {
            let brep = box_brep(DVec3::new(200.0, 150.0, 1.0) * s);
            sizing(&brep, &pairing(&[(s, 3e4 * s * s)]), None, None).target
        };
        assert!((of(scale) / of(1.0) / scale - 1.0).abs() < 1e-12);
    }
}

#[test]
fn on_curves_the_chord_stays_near_or_the_turn_is_divided() {
    let sizing = |per_turn| Sizing {
        target: 10.0,
        per_turn,
        shortest: SHORTEST,
    };
    // The sagitta of a chord h on radius R is h²/8R to first order.
    let h = sizing(None).at(50.0, 2.0) / EVENNESS;
    let sagitta = 50.0 - (50f64 * 50.0 - h * h / 4.0).sqrt();
    assert!((sagitta / 2.0 - CHORD).abs() < 1e-4, "{sagitta}");
    assert_eq!(sizing(None).at(f64::INFINITY, 2.0), 10.0);
    assert_eq!(sizing(None).at(1e-6, 2.0), EVENNESS * SHORTEST * 2.0);
    let turn = std::f64::consts::TAU * 3.0;
    assert!((sizing(Some(24.0)).at(3.0, 2.0) - EVENNESS * turn / 24.0).abs() < 1e-12);
    assert_eq!(sizing(Some(24.0)).at(1e9, 2.0), 10.0);
}
