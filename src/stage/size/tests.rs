use super::*;
use crate::model::ids::{FaceId, WallId};
use crate::model::walls::{FacePair, Wall};
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
    let found = sizing(
        &brep,
        &pairing(&[(3.0, 6000.0)]),
        &Wishes {
            size: Some(7.5),
            per_turn: Some(24.0),
            ..Wishes::default()
        },
    );
    assert_eq!((found.target, found.per_turn), (7.5, Some(24.0)));
}

#[test]
fn without_a_wish_three_thicknesses_within_bounds() {
    let size = |x: f64, y: f64, t: f64| {
        let brep = box_brep(DVec3::new(x, y, t));
        let target = sizing(&brep, &pairing(&[(t, x * y)]), &Wishes::default()).target;
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
fn bounds_hold_for_what_the_part_decides_and_for_bends() {
    let brep = box_brep(DVec3::new(200.0, 150.0, 1.0));
    let with = |min: Option<f64>, max: Option<f64>| {
        let wishes = Wishes {
            min,
            max,
            ..Wishes::default()
        };
        sizing(&brep, &pairing(&[(1.0, 3e4)]), &wishes)
    };
    // Three thicknesses by itself; half of one, less what evenness takes, where it bends sharply.
    assert!((with(None, None).target - 3.0).abs() < 1e-12);
    assert!(with(None, None).at(1e-6, 1.0) < 0.5);
    assert_eq!(with(Some(5.0), None).target, 5.0);
    assert_eq!(with(None, Some(2.0)).target, 2.0);
    assert_eq!(with(Some(2.0), Some(4.0)).at(1e-6, 1.0), 2.0);
    assert_eq!(with(Some(2.0), Some(4.0)).at_step(1e-6, 1.0), 2.0);
    // What is too much keeps at least the user's bound.
    let bounded = with(Some(2.0), None).afforded(&[(1e6, 3.0), (1e5, 0.01)]);
    assert!(bounded.least >= 2.0);
    // A place with a finer size of its own keeps that.
    let place = Sizing {
        target: 1.0,
        ..bounded
    };
    assert_eq!(place.at(f64::INFINITY, 1.0), 1.0);
}

#[test]
fn slow_growth_makes_more_triangles() {
    let brep = box_brep(DVec3::new(100.0, 100.0, 1.0));
    let pairing = one_wall(&brep, 1.0);
    let count = Count::new(&brep, &pairing, &|p, _| if p.x < 40.0 { 0.1 } else { 1e9 });
    let of = |growth: f64| count.triangles(growth, |r, _| if r < 1.0 { 0.5 } else { 9.0 });
    assert!(of(0.05) > of(0.3) && of(0.3) >= of(1.0));
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
            sizing(&brep, &pairing(&[(s, 3e4 * s * s)]), &Wishes::default()).target
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
        least: 0.0,
        growth: GROWTH,
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

#[test]
fn at_a_step_edges_are_shorter_than_in_a_bend_of_that_radius() {
    let with = |per_turn, shortest| Sizing {
        target: 10.0,
        per_turn,
        shortest,
        least: 0.0,
        growth: GROWTH,
    };
    let own = with(None, SHORTEST);
    // The parabola's radius is twice its distance from the inner edge, about the thickness.
    assert_eq!(own.at_step(2.0, 2.0), EVENNESS * SHORTEST_AT_STEPS * 2.0);
    assert!(own.at_step(2.0, 2.0) < own.at(2.0, 2.0));
    assert_eq!(own.at_step(f64::INFINITY, 2.0), 10.0);
    // Eased like bends; the user's own number rules.
    let eased = with(None, EASED).at_step(0.1, 2.0);
    assert!((eased / own.at_step(0.1, 2.0) - EASED / SHORTEST).abs() < 1e-12);
    assert_eq!(with(Some(24.0), SHORTEST).at_step(2.0, 2.0), 10.0);
}

/// A pairing with one wall between the two large faces of a box.
fn one_wall(brep: &Brep, thickness: f64) -> Pairing {
    let mut area: Vec<(f64, FaceId)> = (brep.faces.ids())
        .map(|f| {
            let own = brep.facets.enumerated().filter(|(_, t)| t.face == f);
            let twice = own.map(|(id, _)| {
                let [a, b, c] = brep.corners(id);
                (b - a).cross(c - a).length()
            });
            (twice.sum(), f)
        })
        .collect();
    area.sort_by(|a, b| b.0.total_cmp(&a.0).then(a.1.cmp(&b.1)));
    let mut pairing = pairing(&[(thickness, 1.0)]);
    pairing.walls.push(Wall {
        sides: [vec![area[0].1], vec![area[1].1]],
        thickness,
        group: 0,
    });
    pairing
}

#[test]
fn bends_are_eased_only_where_they_would_be_too_many() {
    let eased = |side: f64, radius: f64, per_turn: Option<f64>| {
        let brep = box_brep(DVec3::new(side, side, 1.0));
        let pairing = one_wall(&brep, 1.0);
        let sizing = sizing(
            &brep,
            &pairing,
            &Wishes {
                size: Some(5.0),
                per_turn,
                ..Wishes::default()
            },
        );
        sizing.eased(&brep, &pairing, &|_, _| radius)
    };
    // 100 x 100 at half a thickness are some 1e5 triangles and more than the budget; 50 x 50 a quarter of that.
    assert_eq!(eased(50.0, 1.5, None).shortest, SHORTEST);
    assert_eq!(eased(1000.0, f64::INFINITY, None).shortest, SHORTEST);
    assert_eq!(eased(1000.0, 1.5, None).shortest, EASED);
    let some = eased(100.0, 1.5, None).shortest;
    assert!(SHORTEST < some && some < EASED, "{some}");
    // As far as needed and no further: the count is area over the triangle's.
    let h = EVENNESS * some;
    let count = 1e4 / (h * h * 3f64.sqrt() / 4.0);
    let most = MOST_BENT * MOST_TRIANGLES;
    assert!(count <= most && count > 0.9 * most, "{count}");
    assert_eq!(eased(1000.0, 1.5, Some(24.0)).shortest, SHORTEST);
}

#[test]
fn an_eased_quarter_turn_has_two_edges_where_that_is_no_shorter_than_the_least() {
    let eased = Sizing {
        target: 10.0,
        per_turn: None,
        shortest: EASED,
        least: 0.0,
        growth: GROWTH,
    };
    let quarter = 0.8 * std::f64::consts::FRAC_PI_2;
    assert!(eased.at(0.8, 1.0) <= EVENNESS * quarter / 2.0 + 1e-12);
    assert_eq!(eased.at(0.1, 1.0), EVENNESS * SHORTEST);
    assert_eq!(eased.at(2.0, 1.0), EVENNESS * EASED);
}

#[test]
fn what_asks_for_too_many_triangles_gets_longer_edges_there_and_nowhere_else() {
    let sizing = Sizing {
        target: 1.0,
        per_turn: None,
        shortest: SHORTEST,
        least: 0.0,
        growth: GROWTH,
    };
    // A hundredth of the part asks for edges of a hundredth: the most that may come of it are three times the finest default.
    let most = MOST_ASKED * MOST_TRIANGLES;
    let equilateral = 3f64.sqrt() / 4.0;
    let (flat, thread) = (9900.0, 100.0);
    let found = sizing.afforded(&[(flat, 1.0), (thread, 0.01)]);
    let exact = (thread / (equilateral * most - flat)).sqrt();
    assert!(
        (exact..exact + 2e-3).contains(&found.least),
        "{}",
        found.least
    );
    assert_eq!(found.at(1e-6, 1e-3), found.least);
    assert_eq!(found.at(1e9, 1.0), 1.0);
    // Where there is room nothing changes, and a part that is large at its own size is left alone.
    assert_eq!(sizing.afforded(&[(flat, 1.0), (thread, 0.1)]), sizing);
    assert_eq!(sizing.afforded(&[(1e6, 1.0)]), sizing);
}
