use super::*;
use crate::model::walls::Role;
use crate::test_parts::stages::stages;
use crate::test_parts::voxels::{cube, plate, tee, two_ribs};

#[test]
fn edges_from_one_side_of_a_plate_to_the_other_run_through() {
    let solid = plate(1);
    let stages = stages(&solid);
    let (bottom, top) = (solid.face(|p| p.z == 0.0), solid.face(|p| p.z == 2.0));
    for (v, labels) in stages.decomposition.labels.enumerated() {
        let side = if solid.brep.vertices[v].z == 0.0 {
            bottom
        } else {
            top
        };
        assert_eq!(labels.as_slice(), [side]);
    }
    for (e, ends) in stages.graph.edges.enumerated() {
        let [a, b] = ends.map(|v| solid.brep.vertices[v].z);
        let wanted = if a == b {
            Passage::Along
        } else {
            Passage::Through
        };
        assert_eq!(stages.decomposition.passage[e], wanted);
    }
}

#[test]
fn vertices_inside_take_the_nearest_wall_face() {
    let solid = plate(3);
    let stages = stages(&solid);
    let (bottom, top) = (solid.face(|p| p.z == 0.0), solid.face(|p| p.z == 2.0));
    for (v, labels) in stages.decomposition.labels.enumerated() {
        let side = if solid.brep.vertices[v].z < 1.0 {
            bottom
        } else {
            top
        };
        assert_eq!(labels.as_slice(), [side]);
    }
}

#[test]
fn concave_edges_carry_both_walls_and_join_their_sides() {
    let solid = tee(1);
    let stages = stages(&solid);
    let face = |on: &dyn Fn(DVec3) -> bool| solid.face(on);
    let bottom = face(&|p| p.z == 0.0);
    let (left, right) = (
        face(&|p| p.z == 2.0 && p.y <= 11.0),
        face(&|p| p.z == 2.0 && p.y >= 13.0),
    );
    let (rib_left, rib_right) = (face(&|p| p.y == 11.0), face(&|p| p.y == 13.0));
    for (v, labels) in stages.decomposition.labels.enumerated() {
        let p = solid.brep.vertices[v];
        let floor = if p.y < 12.0 { left } else { right };
        let rib = if p.y < 12.0 { rib_left } else { rib_right };
        let mut wanted = Vec::new();
        if p.z == 0.0 {
            wanted.push(bottom);
        }
        if p.z == 2.0 {
            wanted.push(floor);
        }
        if p.z > 2.0 || (p.z == 2.0 && (p.y - 12.0).abs() == 1.0) {
            wanted.push(rib);
        }
        wanted.sort_unstable();
        assert_eq!(labels.as_slice(), wanted, "{p}");
    }
    for (e, ends) in stages.graph.edges.enumerated() {
        let [p, q] = ends.map(|v| solid.brep.vertices[v]);
        let passage = stages.decomposition.passage[e];
        // Both plate tops lie on one side of the plate, so an edge over the foot of the rib is through the rib alone.
        let through = (p.z == 0.0) != (q.z == 0.0)
            || (p.z >= 2.0 && q.z >= 2.0 && (p.y <= 11.0) != (q.y <= 11.0));
        assert_eq!(passage == Passage::Through, through, "{p} {q}");
        assert_ne!(passage, Passage::Apart, "{p} {q}");
    }
}

#[test]
fn a_solid_without_walls_has_no_labels_and_no_passage() {
    let solid = cube();
    let stages = stages(&solid);
    assert!(stages.pairing.pairs.is_empty());
    assert!(stages.roles.role.iter().all(|r| *r == Role::Lump));
    assert!(stages.decomposition.labels.iter().all(|l| l.is_empty()));
    let passage = &stages.decomposition.passage;
    assert!(passage.iter().all(|p| *p == Passage::Apart));
}

#[test]
fn from_one_layer_of_a_wall_to_the_next_no_edge_runs_through() {
    let solid = two_ribs();
    let mut stages = stages(&solid);
    let flanks = [10.0, 13.0, 11.0, 14.0].map(|y| solid.face(|p| p.y == y));
    // As if both ribs were turns of one.
    for (face, colour) in flanks.into_iter().zip([0, 0, 1, 1]) {
        stages.pairing.side[face] = Some((7, colour));
    }
    assert!(stages.pairing.opposing(flanks[2], flanks[1]));
    let made = decompose(&solid.brep, &stages.graph, &stages.pairing, &stages.roles);
    let mut checked = [0; 2];
    for (e, ends) in stages.graph.edges.enumerated() {
        let [p, q] = ends.map(|v| solid.brep.vertices[v]);
        let ys = [p.y.min(q.y), p.y.max(q.y)];
        let through = made.passage[e] == Passage::Through;
        if p.z == 2.0 && q.z == 2.0 && ys == [11.0, 13.0] {
            assert!(!through, "{p} {q}");
            checked[0] += 1;
        } else if p.z >= 2.0 && q.z >= 2.0 && (ys == [10.0, 11.0] || ys == [13.0, 14.0]) {
            assert!(through, "{p} {q}");
            checked[1] += 1;
        }
    }
    assert!(checked.into_iter().all(|n| n > 20), "{checked:?}");
}
