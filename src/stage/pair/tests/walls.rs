use super::*;
use crate::model::ids::{CurveId, IndexVec, WallId};
use crate::model::walls::{Aag, Arc, Convexity, FacePair, PairingFault, Wall};
use crate::test_parts::voxels::{
    Filled, channel, cross, ell, filled, hollow_box, lines, motion, plate, square_tube, step_plate,
    tee, thin_parts,
};
use crate::test_parts::wing_brep;
use glam::DVec3;

/// The walls by tags of their faces, sides and walls in order.
fn by_tags(solid: &Filled) -> Vec<[Vec<i32>; 2]> {
    let found = paired(&solid.brep);
    let mut walls: Vec<[Vec<i32>; 2]> = (found.walls.iter())
        .map(|w| {
            let mut sides = w.sides.clone().map(|s| {
                let mut tags: Vec<i32> = s.iter().map(|&f| solid.brep.faces[f].tag).collect();
                tags.sort_unstable();
                tags
            });
            sides.sort();
            sides
        })
        .collect();
    walls.sort();
    walls
}

#[test]
fn ribs_divide_a_side_and_not_the_wall() {
    let solid = tee(1);
    let found = paired(&solid.brep);
    let bottom = solid.face(|p| p.z == 0.0);
    let left = solid.face(|p| p.z == 2.0 && p.y <= 11.0);
    let right = solid.face(|p| p.z == 2.0 && p.y >= 13.0);
    let rib = [solid.face(|p| p.y == 11.0), solid.face(|p| p.y == 13.0)];
    assert_eq!(found.walls.len(), 2);
    let plate = found.pair(bottom, left).unwrap().wall;
    assert_eq!(found.pair(bottom, right).unwrap().wall, plate);
    let own = found.pair(rib[0], rib[1]).unwrap().wall;
    assert_ne!(own, plate);
    let mut sides = found.walls[plate].sides.clone();
    sides.sort_by_key(Vec::len);
    let mut tops = vec![left, right];
    tops.sort_unstable();
    assert_eq!(sides, [vec![bottom], tops]);
    // Both tops have one colour, the bottom the other; the rib is a group of its own.
    let side = |f| found.side[f].unwrap();
    assert_eq!(side(left), side(right));
    assert!(side(left).0 == side(bottom).0 && side(left).1 != side(bottom).1);
    assert_ne!(side(rib[0]).0, side(bottom).0);
    assert!(found.opposing(left, bottom) && found.opposing(rib[0], rib[1]));
    assert!(!found.opposing(left, right) && !found.opposing(left, rib[0]));
    assert!(!found.opposing(left, left));
    for wall in &found.walls {
        assert!((wall.thickness - 2.0).abs() < 1e-9);
    }
}

#[test]
fn every_part_has_its_walls() {
    for (solid, walls) in [
        (plate(1), 1),
        (plate(3), 1),
        (tee(3), 2),
        (cross(), 4),
        (ell(1), 2),
        (channel(), 3),
        (hollow_box(), 6),
        (square_tube(), 4),
    ] {
        let found = paired(&solid.brep);
        assert_eq!(found.walls.len(), walls);
        assert_eq!(found.peaks.len(), 1);
        assert!((found.peaks[0].thickness - 2.0).abs() < 1e-9);
        assert!((found.peaks[0].share - 1.0).abs() < 1e-12);
    }
}

#[test]
fn two_thicknesses_are_two_peaks_and_one_wall() {
    let solid = step_plate();
    let found = paired(&solid.brep);
    let bottom = solid.face(|p| p.z == 0.0);
    let (thin, thick) = (solid.face(|p| p.z == 2.0), solid.face(|p| p.z == 4.0));
    let (a, b) = (
        found.pair(bottom, thin).unwrap(),
        found.pair(bottom, thick).unwrap(),
    );
    assert_eq!((found.pairs.len(), found.walls.len()), (2, 1));
    assert_eq!(a.wall, b.wall);
    assert!((a.thickness[1] - 2.0).abs() < 1e-9 && (b.thickness[1] - 4.0).abs() < 1e-9);
    assert!((found.walls[a.wall].thickness - 3.0).abs() < 0.02);
    // Halves of one plate: equal shares.
    assert_eq!(found.peaks.len(), 2);
    let mut peaks: Vec<f64> = found.peaks.iter().map(|p| p.thickness).collect();
    peaks.sort_by(f64::total_cmp);
    assert!((peaks[0] - 2.0).abs() < 1e-9 && (peaks[1] - 4.0).abs() < 1e-9);
    for p in &found.peaks {
        assert!((p.share - 0.5).abs() < 0.01, "{}", p.share);
    }
}

#[test]
fn peaks_come_by_share_and_small_ones_are_left_out() {
    // Thickness 1, 2 and 1.5 on 70, 28 and 2 of 100 mm.
    let x = lines(&[(70.0, 1), (98.0, 1), (100.0, 1)]);
    let z = lines(&[(1.0, 1), (1.5, 1), (2.0, 1)]);
    let solid = filled([x, lines(&[(50.0, 1)]), z], |p| match p.x {
        x if x < 70.0 => p.z < 1.0,
        x if x < 98.0 => true,
        _ => p.z < 1.5,
    });
    let found = paired(&solid.brep);
    let peaks: Vec<f64> = found.peaks.iter().map(|p| p.thickness).collect();
    assert_eq!(peaks.len(), 2, "{peaks:?}");
    assert!((peaks[0] - 1.0).abs() < 1e-9 && (peaks[1] - 2.0).abs() < 1e-9);
    assert!(found.histogram.is_sorted_by(|a, b| a.0 < b.0));
    let area: f64 = found.histogram.iter().map(|h| h.1).sum();
    assert!((area / 1e4 - 1.0).abs() < 0.01, "{area}");
    assert_eq!(
        found.pairs.len(),
        3,
        "the narrow strip is a wall all the same"
    );
}

#[test]
fn numbers_place_and_scale_do_not_matter() {
    for (name, solid, _) in thin_parts() {
        let wanted = by_tags(&solid);
        assert!(!wanted.is_empty(), "{name}");
        assert_eq!(by_tags(&solid.shuffled(5)), wanted, "{name} shuffled");
        assert_eq!(by_tags(&solid.mapped(motion)), wanted, "{name} moved");
        for scale in [1e-3, 1e3] {
            assert_eq!(
                by_tags(&solid.mapped(|p| p * scale)),
                wanted,
                "{name} x {scale}"
            );
        }
    }
}

#[test]
fn a_bend_of_smooth_faces_is_one_wall() {
    // A strip of three facets a side that turn by ten degrees each.
    let solid = filled(
        [lines(&[(60.0, 3)]), lines(&[(30.0, 3)]), lines(&[(1.0, 1)])],
        |_| true,
    );
    let mut split = solid.mapped(|p| {
        let angle = f64::to_radians(10.0) * (p.x / 20.0 - 1.5);
        let r = 20.0 / f64::to_radians(10.0) - p.z;
        DVec3::new(r * angle.sin(), p.y, -r * angle.cos())
    });
    // Each third of top and bottom becomes a face of its own.
    let (bottom, top) = (solid.face(|p| p.z == 0.0), solid.face(|p| p.z == 1.0));
    let brep = &mut split.brep;
    let first = brep.faces.len() as u32;
    for _ in 0..4 {
        let tag = brep.faces.len() as i32 + 1;
        brep.faces.push(crate::model::brep::Face {
            tag,
            ..Default::default()
        });
    }
    let middles: Vec<f64> = (solid.brep.facets.ids())
        .map(|f| solid.brep.corners(f).iter().map(|p| p.x).sum::<f64>() / 3.0)
        .collect();
    for (f, x) in brep.facets.iter_mut().zip(middles) {
        let third = (x / 20.0) as u32;
        if third > 0 && f.face == bottom {
            f.face = FaceId(first + third - 1);
        } else if third > 0 && f.face == top {
            f.face = FaceId(first + 1 + third);
        }
    }
    brep.curves = Default::default();
    let found = paired(&split.brep);
    assert_eq!((found.pairs.len(), found.walls.len()), (3, 1));
    let lengths = found.walls[WallId(0)].sides.each_ref().map(Vec::len);
    assert_eq!(lengths, [3, 3]);
}

#[test]
fn the_check_finds_a_face_on_both_sides_and_a_pair_out_of_order() {
    let mut found = paired(&tee(1).brep);
    let face = found.walls[WallId(0)].sides[0][0];
    found.walls[WallId(0)].sides[1].insert(0, face);
    found.walls[WallId(0)].sides[1].sort_unstable();
    assert_eq!(found.check(), [PairingFault::BothSides(WallId(0), face)]);
    let bad = Pairing {
        pairs: vec![FacePair {
            faces: [FaceId(2), FaceId(2)],
            overlap: 1.0,
            thickness: [1.0; 3],
            wall: WallId(0),
        }],
        walls: vec![Wall::default()].into(),
        ..Pairing::default()
    };
    assert_eq!(bad.check(), [PairingFault::BadPair(FaceId(2), FaceId(2))]);
}

#[test]
fn an_odd_ring_of_pairs_never_puts_a_face_on_both_sides() {
    // Three faces that all see each other: no colouring has all pairs opposed, and no join may contradict itself.
    let pair = |f: u32, g: u32| FacePair {
        faces: [FaceId(f), FaceId(g)],
        overlap: 1.0,
        thickness: [1.0; 3],
        wall: WallId(0),
    };
    let brep = filled(std::array::from_fn(|_| lines(&[(1.0, 1)])), |_| true).brep;
    let aag = adjacency(&brep);
    let found = super::super::walls::walls(&brep, &aag, vec![pair(0, 1), pair(0, 2), pair(1, 2)]);
    assert_eq!(found.check(), []);
    let all: Vec<FaceId> = found.walls.iter().flat_map(|w| w.sides.concat()).collect();
    assert!((0..3).all(|f| all.contains(&FaceId(f))));
}

#[test]
fn faces_beside_one_air_are_not_opposed_by_their_colours() {
    // Walls 0|1, 1|2 and 2|3 meet in a Y, where 0 and 3 look into the same air; 4 is a fillet, 5 stands elsewhere.
    let pair = |f: u32, g: u32| FacePair {
        faces: [FaceId(f), FaceId(g)],
        overlap: 1.0,
        thickness: [f64::from(f + 1); 3],
        wall: WallId(0),
    };
    let brep = filled(std::array::from_fn(|_| lines(&[(1.0, 1)])), |_| true).brep;
    let opposed = |arcs: &[(u32, u32, Convexity)], f: u32, g: u32| {
        let mut aag = Aag {
            area: (1..=6).map(f64::from).collect::<Vec<_>>().into(),
            perimeter: IndexVec::filled(1.0, 6),
            of_face: IndexVec::filled(Vec::new(), 6),
            ..Aag::default()
        };
        for (i, &(a, b, convexity)) in arcs.iter().enumerate() {
            aag.arcs.push(Arc {
                faces: [FaceId(a), FaceId(b)],
                curve: CurveId(i as u32),
                length: 1.0,
                turn_rad: 0.0,
                convexity,
            });
            for f in [a, b] {
                aag.of_face[FaceId(f)].push(i as u32);
            }
        }
        let pairs = vec![pair(0, 1), pair(1, 2), pair(2, 3)];
        super::super::walls::walls(&brep, &aag, pairs).opposing(FaceId(f), FaceId(g))
    };
    use Convexity::{Concave, Convex, Smooth};
    let fillet = [(0, 4, Smooth), (3, 4, Smooth)];
    let corner = [(0, 3, Concave)];
    for arcs in [fillet.as_slice(), &corner] {
        assert!(!opposed(arcs, 0, 3), "{arcs:?}");
        for f in 0..3 {
            assert!(opposed(arcs, f, f + 1), "{f} {arcs:?}");
        }
    }
    // An end face between them says nothing, nor does a fillet elsewhere.
    for arcs in [
        [(0, 4, Convex), (3, 4, Convex)],
        [(0, 4, Smooth), (4, 5, Smooth)],
    ] {
        assert!(opposed(&arcs, 0, 3), "{arcs:?}");
    }
}

#[test]
fn a_wall_does_not_run_round_the_corner_of_a_wing() {
    let wing = wing_brep(10.0, 8.0, 0.4, 20.0, 24);
    let found = paired(&wing);
    let wall = |a: u32, b: u32| found.pair(FaceId(a), FaceId(b)).unwrap().wall;
    // Joined over the nose on one of its ends, and not on the other.
    assert_eq!(found.walls.len(), 2);
    assert_ne!(wall(0, 3), wall(2, 5));
    assert!([wall(0, 3), wall(2, 5)].contains(&wall(1, 4)));
    // Where the trailing edge is no corner the skin is one wall.
    let round = wing_brep(10.0, 8.0, std::f64::consts::FRAC_PI_2 - 0.1, 20.0, 24);
    assert_eq!(paired(&round).walls.len(), 1);
}
