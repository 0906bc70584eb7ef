use super::*;
use crate::test_parts::voxels::wedge;
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
