use super::*;
use crate::model::ids::{CurveId, WallId};
use crate::model::walls::{Arc, Convexity, FacePair};
use crate::test_parts::stages::stages;
use crate::test_parts::voxels::{plate, plate_with_block, step_plate, tee};

#[test]
fn a_plate_has_two_sides_and_four_lateral_faces() {
    let solid = plate(1);
    let roles = stages(&solid).roles;
    for (f, role) in roles.role.enumerated() {
        let side = [0.0, 2.0].iter().any(|&z| f == solid.face(|p| p.z == z));
        assert_eq!(*role, if side { Role::WallSide } else { Role::Lateral });
        assert_eq!(
            roles.carries[f].as_slice(),
            if side { vec![f] } else { vec![] }
        );
    }
}

#[test]
fn a_riser_is_a_wall_side_and_ends_of_the_step_are_lateral() {
    let solid = step_plate();
    let roles = stages(&solid).roles;
    let riser = solid.face(|p| p.x == 20.0);
    assert_eq!(roles.role[riser], Role::WallSide);
    assert_eq!(roles.carries[riser].as_slice(), [riser]);
    for end in [
        solid.face(|p| p.x == 0.0),
        solid.face(|p| p.x == 40.0),
        solid.face(|p| p.y == 0.0),
        solid.face(|p| p.y == 24.0),
    ] {
        assert_eq!(roles.role[end], Role::Lateral);
    }
}

#[test]
fn ends_of_a_tee_are_lateral() {
    let solid = tee(1);
    let roles = stages(&solid).roles;
    let lateral: Vec<FaceId> = [
        solid.face(|p| p.x == 0.0),
        solid.face(|p| p.x == 40.0),
        solid.face(|p| p.y == 0.0),
        solid.face(|p| p.y == 24.0),
        solid.face(|p| p.z == 14.0),
    ]
    .to_vec();
    for (f, role) in roles.role.enumerated() {
        let wanted = if lateral.contains(&f) {
            Role::Lateral
        } else {
            Role::WallSide
        };
        assert_eq!(*role, wanted, "{f:?}");
    }
}

#[test]
fn a_block_on_a_plate_stands_for_the_side_that_it_stands_on() {
    let solid = plate_with_block();
    let stages = stages(&solid);
    let top = solid.face(|p| p.z == 2.0);
    for block in [
        solid.face(|p| p.x == 24.0),
        solid.face(|p| p.y == 26.0),
        solid.face(|p| p.z == 12.0),
    ] {
        assert_eq!(stages.roles.role[block], Role::Blend);
        assert_eq!(stages.roles.carries[block].as_slice(), [top]);
    }
}

/// As `turned`, with all arcs smooth.
fn planted(faces: usize, arcs: &[(u32, u32)]) -> FaceRoles {
    let smooth: Vec<_> = arcs.iter().map(|&(f, g)| (f, g, 0.0)).collect();
    turned(faces, &smooth)
}

/// Faces 0-1 and 2-3 are pairs of two groups; the arcs are given with their turns, degrees.
fn turned(faces: usize, arcs: &[(u32, u32, f64)]) -> FaceRoles {
    let mut aag = Aag {
        area: IndexVec::filled(1.0, faces),
        perimeter: IndexVec::filled(4.0, faces),
        of_face: IndexVec::filled(Vec::new(), faces),
        ..Aag::default()
    };
    for (i, &(f, g, degrees)) in arcs.iter().enumerate() {
        aag.arcs.push(Arc {
            faces: [FaceId(f), FaceId(g)],
            curve: CurveId(i as u32),
            length: 1.0,
            turn_rad: degrees.to_radians(),
            convexity: match degrees {
                0.0 => Convexity::Smooth,
                d if d > 0.0 => Convexity::Convex,
                _ => Convexity::Concave,
            },
        });
        for f in [f, g] {
            aag.of_face[FaceId(f)].push(i as u32);
        }
    }
    let mut side = IndexVec::filled(None, faces);
    for (f, s) in [(0, (0, 0)), (1, (0, 1)), (2, (1, 0)), (3, (1, 1))] {
        side[FaceId(f)] = Some(s);
    }
    let pair = |f: u32, wall: u32| FacePair {
        faces: [FaceId(f), FaceId(f + 1)],
        overlap: 1.0,
        thickness: [1.0; 3],
        wall: WallId(wall),
    };
    let pairing = Pairing {
        pairs: vec![pair(0, 0), pair(2, 1)],
        side,
        ..Pairing::default()
    };
    roles(&aag, &pairing)
}

#[test]
fn a_fillet_carries_both_walls_and_its_end_face_none() {
    // 4: fillet between walls; 5: rim of the first; 6: beside the fillet only; 7: rim of both and of the fillet.
    let found = planted(
        8,
        &[
            (0, 4),
            (2, 4),
            (0, 5),
            (1, 5),
            (4, 6),
            (0, 7),
            (1, 7),
            (4, 7),
        ],
    );
    let carries = |f: u32| {
        found.carries[FaceId(f)]
            .iter()
            .map(|f| f.0)
            .collect::<Vec<_>>()
    };
    use Role::{Blend, Lateral, WallSide};
    assert_eq!(
        found.role.as_slice(),
        [
            WallSide, WallSide, WallSide, WallSide, Blend, Lateral, Blend, Lateral
        ]
    );
    assert_eq!((carries(4), carries(5)), (vec![0, 2], vec![]));
    assert_eq!((carries(6), carries(7)), (vec![0, 2], vec![]));
}

#[test]
fn labels_travel_three_faces_far() {
    let found = planted(9, &[(0, 4), (4, 5), (5, 6), (6, 7)]);
    let wanted = [
        Role::Blend,
        Role::Blend,
        Role::Blend,
        Role::Lump,
        Role::Lump,
    ];
    assert_eq!(found.role.as_slice()[4..], wanted);
    assert!(found.carries[FaceId(7)].is_empty());
}

#[test]
fn faces_on_either_end_of_a_chain_of_blends_meet_in_it() {
    // 0 - 4 - 5 - 2: both blends lie between the walls, each carries at least the one beside it.
    let found = planted(6, &[(0, 4), (4, 5), (2, 5)]);
    assert_eq!(found.role.as_slice()[4..], [Role::Blend, Role::Blend]);
    assert!(found.carries[FaceId(4)].contains(&FaceId(0)));
    assert!(found.carries[FaceId(5)].contains(&FaceId(2)));
}

#[test]
fn a_rib_that_butts_against_a_fillet_does_not_end_at_it() {
    // 4: fillet from plate 0 on; both sides of the rib 2-3 meet it, over these turns.
    let with = |degrees: f64| turned(5, &[(0, 4, 0.0), (2, 4, degrees), (3, 4, degrees)]);
    let (butting, rim) = (with(-90.0), with(90.0));
    assert_eq!(butting.role[FaceId(4)], Role::Blend);
    assert_eq!(butting.carries[FaceId(4)].as_slice(), [FaceId(0)]);
    assert_eq!(rim.role[FaceId(4)], Role::Lateral);
    assert!(rim.carries[FaceId(4)].is_empty());
    // Over chamfers it is the rib's rim as before.
    assert_eq!(with(-45.0).role[FaceId(4)], Role::Lateral);
}
