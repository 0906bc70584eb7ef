use super::*;
use crate::model::ids::WallId;
use crate::stage::test_shapes::{Build, moved, plate_with_holes, rib_on_plate, sheet, tube};
use std::f64::consts::TAU;

const ANY: f64 = 1e9;

fn within(complex: &MidComplex, most: f64) -> Vec<(TriangleId, f64)> {
    narrow(complex, &|_| most)
}

/// Least and largest width found, and on how many triangles.
fn range(found: &[(TriangleId, f64)]) -> (f64, f64, usize) {
    let widths = || found.iter().map(|f| f.1);
    let least = widths().fold(f64::INFINITY, f64::min);
    (least, widths().fold(0.0, f64::max), found.len())
}

#[test]
fn a_strip_is_as_wide_as_it_was_drawn_wherever_it_lies() {
    let strip = sheet(30, 3, |s, t| DVec3::new(40.0 * s, 5.0 * t, 0.0));
    for complex in [strip.clone(), moved(&strip)] {
        let (least, largest, count) = range(&within(&complex, 10.0));
        assert!((least - 5.0).abs() < 1e-9 && (largest - 5.0).abs() < 1e-9);
        assert_eq!(count, complex.triangles.len());
    }
    // Nobody asked for that.
    assert!(within(&strip, 4.9).is_empty());
}

#[test]
fn a_bent_strip_is_measured_along_its_surface() {
    // A quarter of a tube of radius 4, 60 long: 2 pi wide.
    let bent = sheet(40, 16, |s, t| {
        let a = t * TAU / 4.0;
        DVec3::new(60.0 * s, 4.0 * a.cos(), 4.0 * a.sin())
    });
    let (least, largest, _) = range(&within(&bent, 10.0));
    let chords = 16.0 * 8.0 * (TAU / 128.0).sin();
    assert!((least - chords).abs() < 1e-9, "{least} {chords}");
    assert!((largest - chords).abs() < 1e-9, "{largest}");
    // A ring, whose border has no ends.
    let ring = tube(48, 2, 1.5);
    let (least, largest, count) = range(&within(&ring, 2.0));
    assert!((least - 1.5).abs() < 1e-9 && (largest - 1.5).abs() < 1e-9);
    assert_eq!(count, ring.triangles.len());
}

#[test]
fn a_taper_is_narrow_as_far_as_its_sides_are_about_parallel() {
    let taper = |far: f64| {
        sheet(40, 4, move |s, t| {
            DVec3::new(40.0 * s, (4.0 + (far - 4.0) * s) * (t - 0.5), 0.0)
        })
    };
    // Sides that lean by 5.7 degrees each: looks square to one side are longer than the strip is wide by the cosine.
    let found = within(&taper(12.0), 8.0);
    let (least, largest, _) = range(&found);
    assert!((4.0..4.2).contains(&least), "{least}");
    assert!((7.7..=8.0).contains(&largest), "{largest}");
    // By 21.8 degrees each: a wedge.
    assert!(within(&taper(36.0), 20.0).iter().all(|f| f.1 > 12.0));
}

#[test]
fn between_holes_and_in_corners_nothing_is_narrow() {
    let plate = plate_with_holes(1.0);
    let (least, ..) = range(&within(&plate, ANY));
    // Only the plate itself is as wide as it is.
    assert!(least > 50.0, "{least}");
    let triangle = sheet(10, 10, |s, t| DVec3::new(s * (1.0 - t), t, 0.0));
    assert!(within(&triangle, ANY).is_empty());
}

#[test]
fn a_junction_bounds_a_sheet_and_a_step_of_height_two() {
    // A rib 3 high on the middle of a plate 20 wide, all along it.
    let mut build = Build::default();
    build.sheet(0, 30, 10, |s, t| DVec3::new(60.0 * s, 10.0 * t, 0.0));
    build.sheet(0, 30, 10, |s, t| DVec3::new(60.0 * s, -10.0 * t, 0.0));
    build.sheet(1, 30, 3, |s, t| DVec3::new(60.0 * s, 0.0, 3.0 * t));
    let complex = build.complex;
    let width = |wall: u32| {
        let on = |f: &&(TriangleId, f64)| complex.triangles[f.0].wall == WallId(wall);
        let found = within(&complex, 15.0);
        range(&found.iter().filter(on).copied().collect::<Vec<_>>())
    };
    let (least, largest, _) = width(1);
    assert!((least - 3.0).abs() < 1e-9 && (largest - 3.0).abs() < 1e-9);
    let (least, largest, _) = width(0);
    assert!((least - 10.0).abs() < 1e-9 && (largest - 10.0).abs() < 1e-9);
    // A limit of its own for each wall.
    let only = narrow(&complex, &|w| if w == WallId(1) { 5.0 } else { 0.0 });
    assert!(
        only.iter()
            .all(|f| complex.triangles[f.0].wall == WallId(1))
    );
    assert_eq!(only.len(), 180);
    // A rib that ends on the plate leaves it one sheet, which is not narrow.
    let (least, ..) = range(&within(&rib_on_plate(0.5), 1e-3));
    assert!(least.is_infinite());
}

#[test]
fn widths_grow_with_the_part_and_hang_on_no_thread() {
    let at = |scale: f64| {
        let strip = sheet(30, 3, |s, t| scale * DVec3::new(40.0 * s, 5.0 * t, s * t));
        within(&strip, 10.0 * scale)
    };
    let one = at(1.0);
    assert!(!one.is_empty());
    for scale in [1e-3, 1e3] {
        let scaled = at(scale);
        assert_eq!(scaled.len(), one.len());
        for (a, b) in one.iter().zip(&scaled) {
            assert!(a.0 == b.0 && (b.1 / a.1 / scale - 1.0).abs() < 1e-9);
        }
    }
    let pool = rayon::ThreadPoolBuilder::new().num_threads(1).build();
    assert_eq!(pool.unwrap().install(|| at(1.0)), one);
}
