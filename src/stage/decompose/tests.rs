use super::*;
use crate::model::walls::Role;
use crate::test_parts::stages::stages;
use crate::test_parts::voxels::{cube, plate, tee};

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
