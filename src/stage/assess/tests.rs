use super::*;
use crate::stage::pair::sight;
use crate::stage::test_shapes::{Build, sheet};
use crate::test_parts::stages::stages;
use crate::test_parts::voxels::{Filled, filled, lines, plate, plate_with_block, tee, thin_parts};

/// The rectangle over x up to `length` of the plate 40 x 24 x 2, at height z.
fn level(length: f64, z: f64) -> MidComplex {
    sheet(20, 12, |u, v| DVec3::new(length * u, 24.0 * v, z))
}

fn of_plate(complex: &MidComplex) -> Assessment {
    let brep = plate(1).brep;
    assess(&brep, &sight(&brep), complex)
}

#[test]
fn the_exact_middle_of_a_plate_covers_all_and_strays_nowhere() {
    let found = of_plate(&level(40.0, 1.0));
    assert_eq!((found.cover, found.astray, found.score()), (1.0, 0.0, 1.0));
}

#[test]
fn half_a_plate_covers_half() {
    let found = of_plate(&level(20.0, 1.0));
    // Mid-points up to 0.35 of the thickness beyond the edge count as well.
    let wanted = (20.0 + 0.35 * 2.0) / 40.0;
    assert!((found.cover - wanted).abs() < 0.005, "{}", found.cover);
    assert_eq!(found.astray, 0.0);
    assert_eq!(of_plate(&MidComplex::default()).score(), 0.0);
}

#[test]
fn a_sheet_off_the_middle_strays_from_a_tenth_on() {
    // |d - e| / (d + e) = |z - 1|
    for (z, astray) in [(1.09, 0.0), (0.91, 0.0), (1.11, 1.0), (0.89, 1.0)] {
        assert_eq!(of_plate(&level(40.0, z)).astray, astray, "{z}");
    }
    assert_eq!(of_plate(&level(40.0, 1.8)).cover, 0.0);
    assert_eq!(of_plate(&level(40.0, 2.5)).astray, 1.0);
}

#[test]
fn what_leaves_the_material_counts_by_its_area_and_a_rim_on_the_boundary_does_not() {
    // A quarter of the sheet is beyond the end of the plate.
    let mut build = Build::default();
    build.sheet(0, 30, 12, |u, v| DVec3::new(40.0 * u, 24.0 * v, 1.0));
    build.sheet(0, 10, 12, |u, v| {
        DVec3::new(40.0 + 40.0 / 3.0 * u, 24.0 * v, 1.0)
    });
    let found = of_plate(&build.complex);
    assert!((found.outside - 0.25).abs() < 1e-9, "{found:?}");
    assert!((found.score() - (found.cover - found.astray - 0.25)).abs() < 1e-12);
    // Half inside, in a slot's place: both rays meet a side, and the one distance is as long as the other.
    let solid = slotted();
    let (sightings, mut build) = (sight(&solid.brep), Build::default());
    build.sheet(0, 8, 8, |u, v| DVec3::new(40.0 * u, 24.0 * v, 3.0));
    let slot = assess(&solid.brep, &sightings, &build.complex);
    assert_eq!((slot.outside, slot.astray), (1.0, 0.0));
    assert_eq!(of_plate(&level(40.0, 2.0)).outside, 0.0);
}

/// Two plates 40 x 24 x 2 with a slot 2 high between them, joined by a wall at x = 40.
fn slotted() -> Filled {
    let grid = [
        lines(&[(40.0, 4), (42.0, 1)]),
        lines(&[(24.0, 4)]),
        lines(&[(2.0, 1), (4.0, 1), (6.0, 1)]),
    ];
    filled(grid, |p| p.x > 40.0 || (p.z - 3.0).abs() > 1.0)
}

#[test]
fn a_wild_flap_counts_by_its_area() {
    let mut build = Build::default();
    build.sheet(0, 20, 12, |u, v| DVec3::new(40.0 * u, 24.0 * v, 1.0));
    build.sheet(0, 4, 4, |u, v| DVec3::new(10.0 * u, 24.0 * v, 1.5));
    let found = of_plate(&build.complex);
    assert!((found.astray - 0.2).abs() < 1e-9, "{}", found.astray);
    assert_eq!(found.cover, 1.0);
}

#[test]
fn junctions_are_left_out_of_straying_and_a_missing_rib_shows() {
    let solid = tee(1);
    let sightings = sight(&solid.brep);
    let mut build = Build::default();
    build.sheet(0, 40, 24, |u, v| DVec3::new(40.0 * u, 24.0 * v, 1.0));
    let ribless = assess(&solid.brep, &sightings, &build.complex);
    build.sheet(1, 40, 13, |u, v| DVec3::new(40.0 * u, 12.0, 1.0 + 13.0 * v));
    let found = assess(&solid.brep, &sightings, &build.complex);
    assert_eq!((found.cover, found.astray), (1.0, 0.0));
    // Sides seen: twice 24 - 2 wide of the plate's, twice 12 of the rib's.
    let wanted = 44.0 / (44.0 + 24.0);
    assert!((ribless.cover - wanted).abs() < 0.02, "{}", ribless.cover);
}

#[test]
fn a_plate_that_runs_on_under_a_lump_strays_there() {
    let solid = plate_with_block();
    let (sightings, mut build) = (sight(&solid.brep), Build::default());
    build.sheet(0, 60, 40, |u, v| DVec3::new(60.0 * u, 40.0 * v, 1.0));
    // A crease 10 beside the border of the block: nearer than one and a half times its height, but far from the plate's thickness.
    build.sheet(1, 4, 40, |u, v| DVec3::new(14.0, 40.0 * v, 1.0 + u));
    let found = assess(&solid.brep, &sightings, &build.complex);
    // The block stands on 12 x 12 of 60 x 40. Within 1 of its foot the plate's top is about as near as its bottom; within 3 of the crease nothing is judged.
    let wanted = 100.0 / (2400.0 - 6.0 * 40.0);
    assert!((found.astray - wanted).abs() < 0.01, "{found:?}");
}

#[test]
fn the_raw_complexes_of_thin_parts_are_good() {
    for (name, solid, _) in thin_parts() {
        let stages = stages(&solid);
        let found = assess(&solid.brep, &stages.sightings, &stages.complex());
        // A lump is no wall; what lies in it may stray.
        let (cover, astray) = if name.contains("block") {
            (0.95, 0.25)
        } else {
            (0.97, 0.02)
        };
        assert!(
            found.cover > cover && found.astray < astray,
            "{name}: {found:?}"
        );
    }
}
