use super::*;
use crate::medial::Medial;
use crate::model::ids::IndexVec;
use crate::model::walls::{FacePair, Wall};
use crate::stage::adjacency::adjacency;
use crate::stage::test_shapes::Build;
use crate::stage::unite::over_steps;
use crate::test_parts::voxels::step_plate;
use glam::DVec3;

/// The step of a plate from 2 to 4, its levels in walls as told; which faces the first wall has on the side that steps.
fn stepped(walls: [u32; 2], thickness: [f64; 2]) -> Option<Vec<FaceId>> {
    let solid = step_plate();
    let brep = &solid.brep;
    let aag = adjacency(brep);
    let low = solid.face(|p| p.z == 2.0);
    let high = solid.face(|p| p.z == 4.0);
    let bottom = solid.face(|p| p.z == 0.0);
    let mut pairing = Pairing {
        side: IndexVec::filled(None, brep.faces.len()),
        ..Pairing::default()
    };
    let count = 1 + walls[1];
    for w in 0..count {
        let mut levels: Vec<FaceId> = [(low, walls[0]), (high, walls[1])]
            .into_iter()
            .filter(|x| x.1 == w)
            .map(|x| x.0)
            .collect();
        levels.sort_unstable();
        pairing.walls.push(Wall {
            sides: [levels, vec![bottom]],
            thickness: 3.0,
            group: 0,
        });
    }
    for ((f, w), t) in [(low, walls[0]), (high, walls[1])]
        .into_iter()
        .zip(thickness)
    {
        pairing.pairs.push(FacePair {
            faces: [f.min(bottom), f.max(bottom)],
            overlap: 480.0,
            thickness: [t; 3],
            wall: WallId(w),
        });
        pairing.side[f] = Some((0, 0));
    }
    pairing.side[bottom] = Some((0, 1));
    pairing.pairs.sort_by_key(|p| p.faces);
    let medial = Medial::new(brep, &aag, &pairing);
    let mut build = Build::default();
    build.sheet(walls[0], 8, 8, |u, v| DVec3::new(20.0 * u, 24.0 * v, 1.5));
    build.sheet(walls[1], 8, 8, |u, v| {
        DVec3::new(20.0 + 20.0 * u, 24.0 * v, 1.5)
    });
    let (complex, pairing) = over_steps(&build.complex, &pairing, &aag, &medial)?;
    assert_eq!(pairing.walls.len(), 1);
    assert!(complex.triangles.iter().all(|t| t.wall == WallId(0)));
    let riser = solid.face(|p| p.x == 20.0);
    assert_eq!(pairing.side[riser], Some((0, 0)));
    let mut wanted = vec![low, high, riser];
    wanted.sort_unstable();
    assert_eq!(pairing.walls[WallId(0)].sides[0], wanted);
    Some(wanted)
}

#[test]
fn walls_before_and_behind_a_step_are_one_with_the_riser() {
    assert!(stepped([0, 1], [2.0, 4.0]).is_some());
    // And so where they are one already, without the riser.
    assert!(stepped([0, 0], [2.0, 4.0]).is_some());
}

#[test]
fn levels_of_one_thickness_or_of_very_different_ones_have_no_riser() {
    assert!(stepped([0, 0], [2.0, 2.0]).is_none());
    assert!(stepped([0, 0], [1.0, 4.0]).is_none());
}
