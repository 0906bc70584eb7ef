use super::*;
use crate::test_parts::voxels::{Filled, filled, lines, wedge};
use crate::test_parts::{box_brep, tube_brep};
use glam::DVec3;

#[test]
fn a_box_sees_itself_across_its_three_thicknesses() {
    let size = DVec3::new(100.0, 60.0, 3.0);
    let found = sight(&box_brep(size));
    assert!(found.is_sorted_by_key(|s| s.from));
    // Faces 0, 1 lie across z; 2, 3 across y; 4, 5 across x.
    let area = [60.0 * 100.0, 100.0 * 3.0, 60.0 * 3.0];
    for f in 0..6u32 {
        let axis = 2 - f as usize / 2;
        let own: Vec<&Sighting> = found.iter().filter(|s| s.from.0 == f).collect();
        assert!(own.len() >= 60);
        let sum: f64 = own.iter().map(|s| s.area).sum();
        assert!((sum / area[f as usize / 2] - 1.0).abs() < 1e-9, "{sum}");
        for s in own {
            let at = if f % 2 == 0 { 0.0 } else { size[axis] };
            assert!((s.point[axis] - at).abs() < 1e-12);
            assert!(s.point.cmpge(DVec3::ZERO).all() && s.point.cmple(size).all());
            let (seen, distance) = s.across.unwrap();
            assert_eq!(seen.0, f ^ 1);
            assert!((distance - size[axis]).abs() < 1e-9, "{distance}");
            assert!((s.inward[axis].abs() - 1.0).abs() < 1e-12);
        }
    }
}

#[test]
fn samples_are_spread_evenly() {
    let found = sight(&box_brep(DVec3::new(100.0, 60.0, 3.0)));
    let mut bins = [0; 60];
    let mut count = 0;
    for s in found.iter().filter(|s| s.from.0 == 0) {
        bins[(s.point.x / 10.0) as usize * 6 + (s.point.y / 10.0) as usize] += 1;
        count += 1;
    }
    let mean = f64::from(count) / 60.0;
    for bin in bins {
        assert!((f64::from(bin) / mean - 1.0).abs() < 0.1, "{bins:?}");
    }
}

#[test]
fn a_tube_sees_its_wall_from_outside_and_itself_from_nowhere() {
    let found = sight(&tube_brep(10.0, 9.0, 30.0, 72));
    for s in &found {
        match (s.from.0, s.across) {
            (0, Some((f, d))) => {
                assert_eq!(f.0, 1);
                // Chords of five degrees leave either circle by a thousandth of its radius.
                assert!((d - 1.0).abs() < 0.02, "{d}");
            }
            (1, Some((f, d))) => assert!(f.0 == 0 && (d - 1.0).abs() < 0.02, "{d}"),
            (2 | 3, Some((f, d))) => assert!(f.0 == 5 - s.from.0 && (d - 30.0).abs() < 1e-9),
            (_, None) => panic!("{:?} sees nothing", s.point),
            _ => panic!("an unknown face"),
        }
    }
}

#[test]
fn a_wedge_is_seen_to_thirty_degrees_and_no_further() {
    for (degrees, seen) in [(29.0, true), (31.0, false)] {
        let solid = wedge(f64::to_radians(degrees));
        let bottom = solid.face(|p| p.z == 0.0);
        let found = sight(&solid.brep);
        let mut own = found.iter().filter(|s| s.from == bottom);
        assert!(own.all(|s| s.across.is_some() == seen), "{degrees}");
    }
}

/// Least and greatest of what the looks from a face that pass say.
fn range(
    looks: &[Sighting],
    passes: impl Fn(&Sighting) -> bool,
    value: impl Fn(&Sighting) -> f64,
) -> [f64; 2] {
    let kept: Vec<f64> = looks.iter().filter(|s| passes(s)).map(value).collect();
    assert!(kept.len() >= 10, "{} looks", kept.len());
    [
        kept.iter().copied().fold(f64::INFINITY, f64::min),
        kept.iter().copied().fold(0.0, f64::max),
    ]
}

#[test]
fn a_plate_is_wide_and_its_rim_a_bar() {
    let looks = sight(&box_brep(DVec3::new(100.0, 60.0, 3.0)));
    // From a thickness inside the rim nothing ends within reach.
    let inside = |s: &Sighting| {
        s.from.0 == 0 && (3.0..97.0).contains(&s.point.x) && (3.0..57.0).contains(&s.point.y)
    };
    assert_eq!(range(&looks, inside, |s| s.extent.rib), [2.0; 2]);
    assert_eq!(range(&looks, inside, |s| s.extent.most), [2.0; 2]);
    // Across the sixty of its width, away from the corners, the wall is three wide, to the error of the eight directions.
    let rim = |s: &Sighting| s.from.0 == 2 && (4.0..96.0).contains(&s.point.x);
    let [low, high] = range(&looks, rim, |s| s.extent.bar * 60.0);
    assert!(
        (3.0 - 1e-4..=3.0 / (22.5f64.to_radians().cos()) + 1e-4).contains(&low),
        "{low}"
    );
    assert!(high < 3.3, "{high}");
}

#[test]
fn a_wall_goes_on_beneath_a_fin_and_ends_at_a_step() {
    // A plate 40 x 24, 2 thick, with a fin 0.5 thick across it at x = 12; looks from where the fin is within reach in all directions.
    let plate = filled(
        [
            lines(&[(12.0, 6), (12.5, 1), (40.0, 14)]),
            lines(&[(24.0, 12)]),
            lines(&[(2.0, 1), (8.0, 3)]),
        ],
        |p| p.z < 2.0 || (12.0..12.5).contains(&p.x),
    );
    let looks = sight(&plate.brep);
    let beside = |s: &Sighting| {
        s.inward.z < -0.9
            && s.point.z < 3.0
            && (12.6..12.9).contains(&s.point.x)
            && (3.0..21.0).contains(&s.point.y)
    };
    assert_eq!(
        range(&looks, beside, |s| s.extent.rib.min(s.extent.neck))[0],
        2.0
    );
    // Two thick up to x = 12, six beyond: seen from 1 before the step the wall goes on for less than 1 more.
    let step = filled(
        [
            lines(&[(12.0, 6), (40.0, 14)]),
            lines(&[(24.0, 12)]),
            lines(&[(2.0, 1), (6.0, 2)]),
        ],
        |p| p.z < 2.0 || p.x > 12.0,
    );
    let looks = sight(&step.brep);
    let before = |s: &Sighting| {
        s.inward.z < -0.9
            && s.point.z < 3.0
            && (10.9..11.1).contains(&s.point.x)
            && (3.0..21.0).contains(&s.point.y)
    };
    let [low, high] = range(&looks, before, |s| s.extent.rib);
    assert!((1.3..1.8).contains(&low) && high < 1.8, "{low} {high}");
}

/// A plate 40 x 24, 2 thick, a rib 3 high on it that starts at x = 12 and is as thick as told, and on the plate's far half a block up to the same height
/// that starts 2 behind the rib.
fn strip(rib: f64) -> Filled {
    let (behind, block) = (12.0 + rib, 14.0 + rib);
    filled(
        [
            lines(&[(12.0, 6), (behind, 2), (block, 2), (40.0, 10)]),
            lines(&[(24.0, 12)]),
            lines(&[(2.0, 1), (5.0, 2)]),
        ],
        |p| p.z < 2.0 || (12.0..behind).contains(&p.x) || p.x > block,
    )
}

/// Least width of the necks seen from the strip's middle.
fn neck(rib: f64) -> f64 {
    let looks = sight(&strip(rib).brep);
    let middle = |s: &Sighting| {
        let x = s.point.x - 12.0 - rib;
        s.inward.z < -0.9
            && s.point.z < 3.0
            && (0.8..1.2).contains(&x)
            && (5.0..19.0).contains(&s.point.y)
    };
    range(&looks, middle, |s| s.extent.neck)[0]
}

#[test]
fn a_strip_beside_a_rib_is_the_wall_that_carries_the_rib() {
    // Two thick, two wide, and beyond the rib the plate goes on. Across it there is no neck; aslant the way through the rib is longer than what is looked at,
    // and the strip is √2 thicknesses wide, less the error of the last halving.
    let width = neck(2.0);
    assert!((1.3..1.42).contains(&width), "{width}");
    // Beyond four there is no telling plate and block apart: a neck as wide as it is thick.
    let width = neck(4.0);
    assert!((0.9..1.2).contains(&width), "{width}");
}
