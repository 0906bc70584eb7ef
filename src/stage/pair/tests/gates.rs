use super::*;
use crate::model::ids::{CurveId, IndexVec, WallId};
use crate::model::sighting::{Extent, LeastExtent};
use crate::model::walls::{Arc, Convexity};
use crate::test_parts::voxels::{Filled, cube, filled, lines, plate, wedge};
use crate::test_parts::{box_brep, tube_brep};
use glam::DVec3;

#[test]
fn a_strip_is_paired_over_its_thickness_and_not_over_its_ends() {
    // Long, narrow, twice as wide as thick: sides 2, 3 are 6 apart and only 3 wide, ends 4, 5 are far apart.
    let found = paired(&box_brep(DVec3::new(200.0, 6.0, 3.0)));
    assert_eq!(faces(&found), [[0, 1]]);
    let thickness = found.pairs[0].thickness;
    assert!(thickness.iter().all(|t| (t - 3.0).abs() < 1e-9));
    assert!((found.pairs[0].overlap - 1200.0).abs() < 1e-6);
    assert_eq!(faces(&paired(&cube().brep)), [[0; 2]; 0]);
}

#[test]
fn the_least_width_decides_and_scale_does_not() {
    // 30 x 5 x 4 is a wall 4 thick and 5 wide; across its 5 it is a bar, a wall in the other direction, unless all bars are wanted.
    for scale in [1e-3, 1.0, 1e3] {
        let brep = box_brep(DVec3::new(30.0, 5.0, 4.0) * scale);
        let (aag, sightings) = (adjacency(&brep), sight(&brep));
        let with = |least_width| {
            let options = PairOptions {
                least_width,
                ..PairOptions::default()
            };
            faces(&pair(&brep, &aag, &sightings, &options))
        };
        assert_eq!(with(1.0), [[0, 1]]);
        assert_eq!(with(0.5), [[0, 1]]);
        assert_eq!(with(0.25), [[0, 1], [2, 3]]);
    }
}

#[test]
fn a_ridge_under_a_roof_is_a_rib() {
    // A ridge 4 thick and 3 high on a plate, under a roof 2 high that comes to an edge, or nearly so: 5 high in all.
    let grid = [
        lines(&[(20.0, 1), (24.0, 1), (44.0, 1)]),
        lines(&[(40.0, 1)]),
        lines(&[(2.0, 1), (5.0, 1), (7.0, 1)]),
    ];
    let ridge = filled(grid, |p| p.z < 2.0 || (p.x - 22.0).abs() < 2.0);
    let sides = |solid: &Filled| {
        let pairs = paired(&solid.brep).pairs;
        let side = |sign: f64| {
            solid.face(|p| {
                let off = (p.x - 22.0) * sign;
                p.z >= 2.0 && off > 0.0 && (p.z > 5.0 || off == 2.0)
            })
        };
        let wanted = sorted(side(-1.0), side(1.0));
        pairs.iter().any(|p| p.faces.map(|f| f.0) == wanted)
    };
    let roofed = ridge.mapped(|p| {
        if p.z == 7.0 {
            DVec3::new(22.0 + 0.1 * (p.x - 22.0), p.y, p.z)
        } else {
            p
        }
    });
    assert!(sides(&roofed));
}

#[test]
fn tapered_walls_are_paired_with_their_least_and_greatest_thickness() {
    for degrees in [1.0, 5.0, 10.0, 15.0] {
        let angle = f64::to_radians(degrees);
        let solid = wedge(angle);
        let found = paired(&solid.brep);
        let top = solid.face(|p| (p.z - 2.0 - p.x * angle.tan()).abs() < 1e-9);
        assert_eq!(
            faces(&found),
            [sorted(solid.face(|p| p.z == 0.0), top)],
            "{degrees}"
        );
        let [low, mean, high] = found.pairs[0].thickness;
        // Rays fall at right angles to either side in turn: from the tapered one those at the thick end leave through the end face, so
        // that the greatest is the lower side's. One sample in fifty is left out at either end.
        let (least, greatest) = (2.0, 2.0 + 60.0 * angle.tan());
        let slack = 0.05 * (greatest - least);
        assert!((least..least + slack).contains(&low), "{degrees}: {low}");
        assert!(
            (greatest - slack..greatest).contains(&high),
            "{degrees}: {high}"
        );
        assert!(
            (mean - (least + greatest) / 2.0).abs() < slack,
            "{degrees}: {mean}"
        );
        assert!((found.walls[WallId(0)].thickness - mean).abs() < 1e-12);
    }
}

#[test]
fn a_tube_is_one_pair_of_its_skins() {
    let found = paired(&tube_brep(10.0, 9.0, 30.0, 72));
    assert_eq!(faces(&found), [[0, 1]]);
    assert!((found.pairs[0].thickness[1] - 1.0).abs() < 0.01);
}

#[test]
fn a_tube_thicker_than_its_bore_is_a_wall() {
    for (outer, inner) in [(3.5, 0.8), (5.0, 2.0), (10.0, 9.0)] {
        for height in [10.0, 40.0] {
            let found = paired(&tube_brep(outer, inner, height, 24));
            assert!(faces(&found).contains(&[0, 1]), "{outer} {inner} {height}");
        }
    }
}

#[test]
fn numbers_of_faces_do_not_matter() {
    let solid = wedge(0.1);
    for seed in 0..4 {
        let other = solid.shuffled(seed);
        let (a, b) = (paired(&solid.brep), paired(&other.brep));
        let tags = |p: &Pairing, b: &Brep| {
            let mut t = p.pairs[0].faces.map(|f| b.faces[f].tag);
            t.sort_unstable();
            t
        };
        assert_eq!(tags(&a, &solid.brep), tags(&b, &other.brep));
        for k in 0..3 {
            assert!((a.pairs[0].thickness[k] - b.pairs[0].thickness[k]).abs() < 1e-9);
        }
    }
}

#[test]
fn a_patch_on_a_large_face_is_paired_whatever_its_share() {
    // A pad 20 x 20 x 1 that hangs 1 above one end of a block is no wall; under the pad of a T-shaped lump the flange is one.
    let x = lines(&[(20.0, 5), (100.0, 8), (120.0, 5)]);
    let solid = filled(
        [x, lines(&[(100.0, 8)]), lines(&[(38.0, 4), (40.0, 1)])],
        |p| p.z > 38.0 || (20.0..100.0).contains(&p.x),
    );
    // The flanges beside the block are 20 wide, 2 thick; they see the one top, a sixth each.
    let found = paired(&solid.brep);
    let top = solid.face(|p| p.z == 40.0);
    let flanges = [
        solid.face(|p| p.z == 38.0 && p.x <= 20.0),
        solid.face(|p| p.z == 38.0 && p.x >= 100.0),
    ];
    let mut wanted = flanges.map(|f| sorted(top, f));
    wanted.sort_unstable();
    assert!(
        wanted.iter().all(|w| faces(&found).contains(w)),
        "{:?}",
        faces(&found)
    );
}

/// Sightings of one face of another, `n` of them with the given area in all.
fn look(from: u32, to: u32, distance: f64, area: f64) -> Vec<Sighting> {
    vec![
        Sighting {
            from: FaceId(from),
            point: DVec3::ZERO,
            inward: DVec3::Z,
            area: area / 100.0,
            across: Some((FaceId(to), distance)),
            extent: Extent::WIDE,
        };
        100
    ]
}

/// A graph of squares 10 x 10 with the given arcs.
fn squares(faces: usize, arcs: &[(u32, u32, f64)]) -> Aag {
    let mut aag = Aag {
        area: IndexVec::filled(100.0, faces),
        perimeter: IndexVec::filled(40.0, faces),
        of_face: IndexVec::filled(Vec::new(), faces),
        ..Aag::default()
    };
    for (i, &(f, g, turn_rad)) in arcs.iter().enumerate() {
        aag.arcs.push(Arc {
            faces: [FaceId(f), FaceId(g)],
            curve: CurveId(i as u32),
            length: 10.0,
            turn_rad,
            convexity: Convexity::Smooth,
        });
        for f in [f, g] {
            aag.of_face[FaceId(f)].push(i as u32);
        }
    }
    aag
}

fn gated(aag: &Aag, sightings: &[Sighting]) -> Vec<[u32; 2]> {
    (super::super::gates::pairs(aag, sightings, &PairOptions::default()).iter())
        .map(|p| p.faces.map(|f| f.0))
        .collect()
}

#[test]
fn every_gate_shuts() {
    let aag = squares(4, &[]);
    let both = |a, b, d, area| [look(a, b, d, area), look(b, a, d, area)].concat();
    // Squares of ten are five wide; those that are seen whole may be sides of a wider wall.
    assert_eq!(gated(&aag, &both(0, 1, 4.9, 59.0)), [[0, 1]]);
    assert_eq!(gated(&aag, &both(0, 1, 5.1, 59.0)), [[0; 2]; 0]);
    assert_eq!(gated(&aag, &both(0, 1, 5.1, 61.0)), [[0, 1]]);
    // The wall round about must be wide: in one direction at least, and in all as its ends ask.
    let wide = Extent::WIDE;
    let narrow = |extent| {
        let mut looks = both(0, 1, 2.0, 31.0);
        looks.iter_mut().for_each(|look| look.extent = extent);
        gated(&aag, &looks).len()
    };
    for (extent, pairs) in [
        (Extent { most: 1.6, ..wide }, 1),
        (Extent { most: 1.4, ..wide }, 0),
        (Extent { rib: 1.05, ..wide }, 1),
        (Extent { rib: 0.95, ..wide }, 0),
        (Extent { neck: 1.05, ..wide }, 1),
        (Extent { neck: 0.95, ..wide }, 0),
        (Extent { bar: 1.15, ..wide }, 1),
        (Extent { bar: 1.05, ..wide }, 0),
    ] {
        assert_eq!(narrow(extent), pairs, "{extent:?}");
    }
    // Seen: at least three hundredths, then three tenths or nine squared thicknesses.
    assert_eq!(gated(&aag, &both(0, 1, 0.5, 2.9)), [[0; 2]; 0]);
    assert_eq!(gated(&aag, &both(0, 1, 0.5, 3.1)), [[0, 1]]);
    assert_eq!(gated(&aag, &both(0, 1, 2.0, 29.0)), [[0; 2]; 0]);
    assert_eq!(gated(&aag, &both(0, 1, 2.0, 31.0)), [[0, 1]]);
    // A face never pairs with itself.
    assert_eq!(gated(&aag, &look(0, 0, 1.0, 100.0)), [[0; 2]; 0]);
}

#[test]
fn the_halves_of_a_hole_are_judged_as_one_round() {
    // 0 sees a third of the rim 2. One smooth seam to 1 makes a bend, two make a round, of which it is a sixth.
    let seen = |arcs: &[(u32, u32, f64)], t: f64, of_other: f64| {
        let mut looks = [look(0, 2, t, 33.0), look(2, 0, t, 33.0)].concat();
        looks.extend(look(1, 2, t, of_other));
        looks.extend(look(2, 1, t, of_other));
        gated(&squares(3, arcs), &looks).contains(&[0, 2])
    };
    let (bend, round) = ([(0, 1, 0.0)], [(0, 1, 0.0), (0, 1, 0.0)]);
    assert!(seen(&bend, 2.0, 0.1));
    assert!(!seen(&round, 2.0, 0.1));
    // The other half sees as much: a wall round the hole. Or the patch is large whatever its share.
    assert!(seen(&round, 2.0, 33.0));
    assert!(seen(&round, 1.9, 0.1));
}

#[test]
fn a_face_that_goes_on_with_a_paired_one_gets_a_second_chance() {
    // 0-1 are a pair, 2 goes on with 0 and sees 3, which goes on with 1, but is too narrow for the first gate.
    let try_with = |turn: f64, distance: f64, area: f64| {
        let mut aag = squares(4, &[(0, 2, turn), (1, 3, turn)]);
        // Seen by less than the share that lets a narrow face through.
        aag.perimeter[FaceId(2)] = 1000.0;
        aag.perimeter[FaceId(3)] = 1000.0;
        let looks = [
            look(0, 1, 1.0, 100.0),
            look(1, 0, 1.0, 100.0),
            look(2, 3, distance, area),
            look(3, 2, distance, area),
        ];
        gated(&aag, &looks.concat())
    };
    assert_eq!(try_with(0.1, 1.5, 50.0), [[0, 1], [2, 3]]);
    assert_eq!(try_with(1.57, 1.5, 50.0), [[0, 1]], "it turns away");
    assert_eq!(try_with(0.1, 2.1, 50.0), [[0, 1]], "it is too far");
    assert_eq!(try_with(0.1, 1.5, 29.0), [[0, 1]], "it sees too little");
}

#[test]
fn the_blend_at_the_foot_of_a_rib_is_no_side_of_the_plate() {
    // Plate 0 over 1, rib 2 against 3, and 4 from the one to the other, 5 wide, which sees the plate's far side.
    let try_with = |distance: f64, hollow: f64, far_sides: &[(u32, u32, f64)]| {
        let smooth = [(0, 4, 0.0), (2, 4, 0.0)];
        let aag = squares(5, &[&smooth[..], far_sides].concat());
        let mut blend = look(4, 1, distance, 50.0);
        for (i, look) in blend.iter_mut().enumerate() {
            let along = i as f64 / 100.0;
            look.point = DVec3::X * along;
            // Of a hollow face the outward normals come together, so that the inward ones part.
            look.inward = DVec3::new(hollow * along, 0.0, 1.0).normalize();
        }
        let walls = [(0, 1), (1, 0), (2, 3), (3, 2)].map(|(f, g)| look(f, g, distance, 90.0));
        gated(&aag, &[walls.concat(), blend].concat())
    };
    let (both, with_blend) = (vec![[0, 1], [2, 3]], vec![[0, 1], [1, 4], [2, 3]]);
    // 5 wide is 2.4 thicknesses of 2.08.
    assert_eq!(try_with(2.2, -0.5, &[]), with_blend, "it is not hollow");
    assert_eq!(try_with(2.2, 0.5, &[]), both);
    assert_eq!(try_with(2.2, 1e-9, &[]), with_blend, "it is flat");
    assert_eq!(try_with(2.0, 0.5, &[]), with_blend, "it is broad");
    let corner = [(1, 3, std::f64::consts::FRAC_PI_2)];
    assert_eq!(try_with(2.2, 0.5, &corner), with_blend, "it is a bend");
}

#[test]
fn a_rim_beside_both_sides_is_no_pair() {
    let solid = plate(1);
    let found = paired(&solid.brep);
    assert_eq!(found.pairs.len(), 1);
    let sides = found.side.iter().filter(|s| s.is_some()).count();
    assert_eq!(sides, 2);
}

#[test]
fn lumps_have_no_walls_whatever_width_is_asked_for() {
    for size in [[20.0, 20.0, 20.0], [20.0, 22.0, 24.0]] {
        for scale in [1e-3, 1.0, 1e3] {
            let brep = box_brep(DVec3::from(size) * scale);
            let (aag, sightings) = (adjacency(&brep), sight(&brep));
            for least_width in [1.0, 0.5, 0.25] {
                let options = PairOptions {
                    least_width,
                    ..PairOptions::default()
                };
                assert!(pair(&brep, &aag, &sightings, &options).pairs.is_empty());
            }
        }
    }
    // A square bar is a wall in neither direction.
    assert_eq!(
        faces(&paired(&box_brep(DVec3::new(80.0, 20.0, 20.0)))),
        [[0; 2]; 0]
    );
}

#[test]
fn a_lump_is_a_wall_only_where_lumps_are_asked_for() {
    // A floor 24 thick and 26 wide and long: a lump beside walls, longer than thick only along its diagonals.
    let pairs = |lumps| {
        let brep = box_brep(DVec3::new(26.0, 26.0, 24.0));
        let options = PairOptions {
            least_width: 0.5,
            lumps,
            ..PairOptions::default()
        };
        faces(&pair(&brep, &adjacency(&brep), &sight(&brep), &options))
    };
    assert_eq!(pairs(false), [[0; 2]; 0]);
    assert!(pairs(true).contains(&[0, 1]), "{:?}", pairs(true));
}

#[test]
fn the_floor_of_a_groove_between_thicker_parts_is_a_lump() {
    // Width of the neck against its depth: 0.8 is no wall, and one with lumps.
    let extent = |neck| Extent {
        neck,
        ..Extent::WIDE
    };
    for (neck, walls, lumps) in [(0.4, false, false), (0.8, false, true), (1.2, true, true)] {
        assert_eq!(extent(neck).is_wide(&LeastExtent::of_walls(0.5)), walls);
        assert_eq!(extent(neck).is_wide(&LeastExtent::of_lumps(0.5)), lumps);
    }
}

#[test]
fn a_face_that_sees_a_bore_by_a_strip_is_its_wall_where_that_is_enough() {
    // Squares 10 wide, before a bore 3.2 in diameter: within 30 degrees a strip half as wide is seen, 16 hundredths; less than nine squared distances.
    let aag = squares(2, &[]);
    let looks = [look(0, 1, 2.0, 16.0), look(1, 0, 2.0, 16.0)].concat();
    let with = |least_cover| {
        let options = PairOptions {
            least_cover,
            ..PairOptions::default()
        };
        super::super::gates::pairs(&aag, &looks, &options).len()
    };
    assert_eq!((with(0.3), with(0.15)), (0, 1));
}
