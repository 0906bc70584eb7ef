use super::*;
use crate::test_parts::voxels::{Filled, filled, lines, motion, plate_with_block, step_plate, tee};
use glam::DVec3;

/// The faces of each side of the only wall, the first side the one with `face`; `None` where there are more walls.
fn only_wall(solid: &Filled, face: FaceId) -> Option<[Vec<FaceId>; 2]> {
    let found = paired(&solid.brep);
    if found.walls.len() != 1 {
        return None;
    }
    let mut sides = found.walls.as_slice()[0].sides.clone();
    if !sides[0].contains(&face) {
        sides.swap(0, 1);
    }
    // The colours say the same as the sides.
    for (s, t) in [(0, 0), (1, 1), (0, 1)] {
        for f in &sides[s] {
            for g in &sides[t] {
                assert_eq!(found.side[*f] == found.side[*g], s == t);
                assert_eq!(found.opposing(*f, *g), s != t);
            }
        }
    }
    Some(sides)
}

fn ids(mut faces: Vec<FaceId>) -> Vec<FaceId> {
    faces.sort_unstable();
    faces
}

/// A plate 40 x 24 that fills its profile in x and z.
fn profile(x: &[f64], z: &[f64], full: impl Fn(f64, f64) -> bool) -> Filled {
    let stops = |at: &[f64]| lines(&at.iter().map(|&a| (a, 1)).collect::<Vec<_>>());
    filled([stops(x), lines(&[(24.0, 1)]), stops(z)], |p| {
        full(p.x, p.z)
    })
}

#[test]
fn a_riser_belongs_to_the_side_that_steps() {
    let on_step = |solid: &Filled| {
        let riser = solid.face(|p| p.x == 20.0);
        let tops = [solid.face(|p| p.z == 2.0), solid.face(|p| p.z == 4.0)];
        let wanted = ids(vec![tops[0], tops[1], riser]);
        (riser, [wanted, vec![solid.face(|p| p.z == 0.0)]])
    };
    let solid = step_plate();
    let (riser, wanted) = on_step(&solid);
    assert_eq!(only_wall(&solid, riser), Some(wanted.clone()));
    for other in [
        solid.mapped(motion),
        solid.mapped(|p| p * 1e-3),
        // Slanted by 45 degrees: a chamfer.
        solid.mapped(|p| {
            if p.x == 20.0 && p.z == 4.0 {
                p + DVec3::X
            } else {
                p
            }
        }),
    ] {
        assert_eq!(only_wall(&other, riser), Some(wanted.clone()));
    }
    let shuffled = solid.shuffled(3);
    let (riser, wanted) = on_step(&shuffled);
    assert_eq!(only_wall(&shuffled, riser), Some(wanted));
}

#[test]
fn a_pocket_has_four_risers_and_a_stair_one_a_step() {
    let pocket = filled(
        [
            lines(&[(10.0, 1), (30.0, 1), (40.0, 1)]),
            lines(&[(10.0, 1), (30.0, 1), (40.0, 1)]),
            lines(&[(3.0, 1), (4.0, 1)]),
        ],
        |p| p.z < 3.0 || p.x < 10.0 || p.x > 30.0 || p.y < 10.0 || p.y > 30.0,
    );
    let sides = only_wall(&pocket, pocket.face(|p| p.z == 3.0)).unwrap();
    assert_eq!(sides.map(|s| s.len()), [6, 1]);
    let stair = profile(&[20.0, 40.0, 60.0], &[2.0, 3.0, 4.0], |x, z| {
        z < 2.0 + (x / 20.0).floor()
    });
    let sides = only_wall(&stair, stair.face(|p| p.z == 3.0)).unwrap();
    assert_eq!(sides.map(|s| s.len()), [5, 1]);
}

#[test]
fn both_sides_may_step_up_down_or_together() {
    // Thicker on both sides; joggled by half the thickness.
    for full in [
        (|x, z| x > 20.0 || (z > 1.0 && z < 3.0)) as fn(f64, f64) -> bool,
        |x, z| if x > 20.0 { z > 1.0 } else { z < 3.0 },
    ] {
        let solid = profile(&[20.0, 40.0], &[1.0, 3.0, 4.0], full);
        let upper = solid.face(|p| p.x == 20.0 && p.z >= 3.0);
        let lower = solid.face(|p| p.x == 20.0 && p.z <= 1.0);
        let sides = only_wall(&solid, upper).unwrap();
        assert!(sides[0].contains(&upper) && sides[1].contains(&lower));
        assert_eq!(sides.map(|s| s.len()), [3, 3]);
    }
}

#[test]
fn ridges_ribs_lumps_and_high_steps_have_no_risers() {
    let ridge = profile(&[20.0, 21.0, 41.0], &[2.0, 3.0], |x, z| {
        z < 2.0 || (x - 20.5).abs() < 0.5
    });
    // A joggle by all but a sixth of the thickness, and a step to four thicknesses.
    let shear = profile(&[20.0, 40.0], &[2.5, 3.0, 5.5], |x, z| {
        if x > 20.0 { z > 2.5 } else { z < 3.0 }
    });
    let high = profile(&[20.0, 60.0], &[1.0, 4.0], |x, z| z < 1.0 || x > 20.0);
    for (name, solid, paired_faces) in [
        ("ridge", ridge, 3),
        ("shear", shear, 4),
        ("high", high, 3),
        ("tee", tee(1), 5),
        ("block", plate_with_block(), 2),
    ] {
        let found = paired(&solid.brep);
        let on_sides: usize = found
            .walls
            .iter()
            .flat_map(|w| &w.sides)
            .map(Vec::len)
            .sum();
        let coloured = found.side.iter().filter(|s| s.is_some()).count();
        assert_eq!(coloured, paired_faces, "{name}");
        let in_pairs = found.pairs.iter().flat_map(|p| p.faces);
        let mut all: Vec<FaceId> = in_pairs.collect();
        all.sort_unstable();
        all.dedup();
        assert_eq!(all.len(), coloured, "{name}");
        assert!(on_sides >= coloured, "{name}");
    }
}

/// A plate 2 thick with a groove 1 wide across it down to a height.
fn grooved(down_to: f64) -> Filled {
    profile(&[20.0, 21.0, 41.0], &[down_to, 2.0], |x, z| {
        z < down_to || (x - 20.5).abs() > 0.5
    })
}

/// Whether a face is of some pair.
fn has_mate(solid: &Filled, face: FaceId) -> bool {
    let pairs = paired(&solid.brep).pairs;
    pairs.iter().any(|p| p.faces.contains(&face))
}

#[test]
fn a_narrow_groove_belongs_to_the_side_that_it_is_cut_into() {
    // As wide as what it leaves or narrower the floor has no mate; deeper or shallower it has one, and the groove is two steps.
    for (down_to, mate) in [(0.8, true), (1.0, false), (1.4, false), (1.6, true)] {
        let solid = grooved(down_to);
        let floor = solid.face(|p| p.z == down_to);
        assert_eq!(has_mate(&solid, floor), mate, "{down_to}");
        let sides = only_wall(&solid, floor).unwrap();
        let walls = [20.0, 21.0].map(|x| solid.face(|p| p.x == x));
        assert!(walls.iter().all(|f| sides[0].contains(f)), "{down_to}");
        assert_eq!(sides.map(|s| s.len()), [5, 1]);
    }
    // Nearly through: what is left is a wall of its own, too thin for a step.
    let through = grooved(0.4);
    let found = paired(&through.brep);
    for x in [20.0, 21.0] {
        assert_eq!(found.side[through.face(|p| p.x == x)], None);
    }
}

/// A plate 2 thick with a square hole 2 wide, and round its mouth a ring 0.8 wide down to a height of 1.2, or without the hole.
fn spot_faced(hole: bool) -> Filled {
    let across = |half: f64, p: DVec3| (p.x - 20.0).abs() < half && (p.y - 12.0).abs() < half;
    let stops = |c: f64, end: f64| {
        lines(&[
            (c - 1.8, 2),
            (c - 1.0, 1),
            (c + 1.0, 1),
            (c + 1.8, 1),
            (end, 2),
        ])
    };
    let grid = [
        stops(20.0, 40.0),
        stops(12.0, 24.0),
        lines(&[(1.2, 1), (2.0, 1)]),
    ];
    filled(grid, |p| {
        !(hole && across(1.0, p)) && (p.z < 1.2 || !across(1.8, p))
    })
}

#[test]
fn the_narrow_ring_of_a_spot_face_is_a_groove() {
    for hole in [true, false] {
        let solid = spot_faced(hole);
        let floor = solid.face(|p| p.z == 1.2);
        assert_eq!(has_mate(&solid, floor), !hole);
        let sides = only_wall(&solid, floor).unwrap();
        let wall = solid.face(|p| p.x == 20.0 - 1.8);
        assert!(sides[0].contains(&wall));
        assert_eq!(sides.map(|s| s.len()), [6, 1]);
    }
}

/// A wall 2 thick and 8 high, bent by a right angle round an outer radius of 8, that carries a lip 1 thick and 2 high along its outside.
fn lipped_bend() -> Filled {
    let (radius, arc) = (8.0, 4.0 * std::f64::consts::PI);
    let grid = [
        lines(&[(20.0, 2), (20.0 + arc, 8), (40.0 + arc, 2)]),
        lines(&[(1.0, 1), (2.0, 1)]),
        lines(&[(8.0, 2), (10.0, 1)]),
    ];
    filled(grid, |p| p.z < 8.0 || p.y < 1.0).mapped(|p| {
        let along = p.x - 20.0;
        let (sin, cos) = (along.clamp(0.0, arc) / radius).sin_cos();
        let beyond = (along - arc).max(0.0);
        let before = along.min(0.0);
        DVec3::new(
            20.0 + before + (radius - p.y) * sin,
            radius - (radius - p.y) * cos + beyond,
            p.z,
        )
    })
}

#[test]
fn a_ledge_that_runs_round_a_bend_joins_the_lip_to_its_wall() {
    let solid = lipped_bend();
    let ledge = solid.face(|p| p.z == 8.0);
    let sides = only_wall(&solid, ledge).unwrap();
    assert_eq!(sides.map(|s| s.len()), [3, 1]);
    let rim = solid.face(|p| p.z == 10.0);
    assert_eq!(paired(&solid.brep).side[rim], None);
}

#[test]
fn walls_at_an_angle_are_joined_by_no_riser() {
    let joggle = profile(&[20.0, 40.0], &[1.0, 3.0, 4.0], |x, z| {
        if x > 20.0 { z > 1.0 } else { z < 3.0 }
    });
    for (degrees, walls) in [(0f64, 1), (20.0, 1), (50.0, 2)] {
        let rise = degrees.to_radians().tan();
        let bent = joggle.mapped(|p| p + DVec3::Z * rise * (p.x - 20.0).max(0.0));
        assert_eq!(paired(&bent.brep).walls.len(), walls, "{degrees}");
    }
}
