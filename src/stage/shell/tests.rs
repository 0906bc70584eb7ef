use super::*;
use crate::model::ids::{ElementId, Id};
use crate::test_parts::stages::stages;
use crate::test_parts::voxels::{self, Filled, motion, thin_parts};
use std::collections::BTreeMap;

fn shell_of(solid: &Filled) -> ShellMesh {
    let stages = stages(solid);
    shell(
        &solid.brep,
        &stages.pairing,
        &stages.medial(),
        &stages.complex(),
    )
}

fn area(mesh: &ShellMesh, e: &Element) -> DVec3 {
    let p: Vec<DVec3> = e
        .corners
        .as_slice()
        .iter()
        .map(|&n| mesh.nodes[n])
        .collect();
    (p[1] - p[0]).cross(p[2] - p[0]) / 2.0
}

#[test]
fn thickness_is_exact_and_the_mass_is_the_solids() {
    for solid in [
        voxels::plate(1),
        voxels::plate_with_hole(),
        voxels::plate(3),
    ] {
        let mesh = shell_of(&solid);
        for e in &mesh.elements {
            assert!(e.thickness.iter().all(|t| (t - 2.0).abs() < 1e-12));
            assert!(!e.unsure);
        }
        assert!(mesh.node_thickness.iter().all(|t| (t - 2.0).abs() < 1e-12));
        let mass: f64 = (mesh.elements.iter())
            .map(|e| area(&mesh, e).length() * e.mean_thickness())
            .sum();
        assert!((mass / solid.brep.volume() - 1.0).abs() < 1e-9, "{mass}");
        assert_eq!(mesh.sheets.len(), 1);
        assert!(mesh.junctions.is_empty() && mesh.creases.is_empty());
    }
}

#[test]
fn a_wedge_has_the_depths_of_both_sides_as_its_thickness() {
    let angle = 10f64.to_radians();
    let solid = voxels::wedge(angle);
    let mesh = shell_of(&solid);
    for (n, t) in mesh.node_thickness.enumerated() {
        // Distance to either plane from the plane that halves the angle, twice.
        let apex = mesh.nodes[n].x + 2.0 / angle.tan();
        let wanted = 2.0 * apex * (angle / 2.0).tan();
        // Interior nodes take the mean over their elements of equal corner values.
        assert!((t - wanted).abs() < 1e-9 * wanted, "{t} {wanted}");
    }
}

#[test]
fn sheets_are_turned_one_way_over_their_whole() {
    for (name, solid, _) in thin_parts() {
        let mesh = shell_of(&solid);
        let mut uses: BTreeMap<(SheetId, NodeId, NodeId), usize> = BTreeMap::new();
        for e in &mesh.elements {
            let n = e.corners.as_slice();
            for k in 0..n.len() {
                *uses
                    .entry((e.sheet, n[k], n[(k + 1) % n.len()]))
                    .or_default() += 1;
            }
        }
        assert!(
            uses.values().all(|&u| u == 1),
            "{name}: a side is used twice one way"
        );
    }
}

#[test]
fn normals_look_to_the_first_source_face() {
    for solid in [
        voxels::plate(1),
        voxels::tee(1),
        voxels::hollow_box(),
        voxels::ell(1),
    ] {
        let mesh = shell_of(&solid);
        // Planes of the faces by their tags: the boxes' faces are flat.
        let mut plane: BTreeMap<i32, (DVec3, DVec3)> = BTreeMap::new();
        for (id, f) in solid.brep.facets.enumerated() {
            let [a, b, c] = solid.brep.corners(id);
            let n = (b - a).cross(c - a).normalize();
            plane.insert(solid.brep.faces[f.face].tag, (a, n));
        }
        for e in &mesh.elements {
            // The raw complex has triangles without area at junctions; meshing takes them away.
            if area(&mesh, e).length() < 1e-9 {
                continue;
            }
            let n = area(&mesh, e).normalize();
            let [first, second] = e.source_faces.map(|tag| plane[&tag]);
            assert!((n - first.1).length() < 1e-9 && (n + second.1).length() < 1e-9);
            let p = mesh.nodes[e.corners.as_slice()[0]];
            for (at, normal) in [first, second] {
                assert!(((at - p).dot(normal) - 1.0).abs() < 1e-9, "not one away");
            }
            let sides = &mesh.sheets[e.sheet].sides;
            assert!(sides[0].contains(&e.source_faces[0]));
            assert!(sides[1].contains(&e.source_faces[1]));
        }
    }
}

#[test]
fn sheets_are_divided_at_junctions_and_folds() {
    for (solid, sheets, walls) in [
        (voxels::plate(1), 1, 1),
        (voxels::tee(1), 3, 2),
        (voxels::cross(), 4, 4),
        (voxels::ell(1), 2, 2),
        (voxels::channel(), 3, 3),
        (voxels::hollow_box(), 6, 6),
        (voxels::square_tube(), 4, 4),
    ] {
        let mesh = shell_of(&solid);
        // Where four walls cross, two close junction lines come to lie on one: the strip between them has no area.
        let mut size = vec![0.0; mesh.sheets.len()];
        for e in &mesh.elements {
            size[e.sheet.index()] += area(&mesh, e).length();
        }
        let mut found: Vec<WallId> = (mesh.sheets.enumerated())
            .filter(|(id, _)| size[id.index()] > 1e-9)
            .map(|(_, s)| s.wall)
            .collect();
        assert_eq!(found.len(), sheets);
        found.sort_unstable();
        found.dedup();
        assert_eq!(found.len(), walls);
        let order: Vec<SheetId> = mesh.elements.iter().map(|e| e.sheet).collect();
        assert!(order.is_sorted(), "elements are not ordered by sheet");
        assert!(mesh.sheets.iter().all(|s| s.solid_tag == 1));
    }
}

#[test]
fn edges_of_a_tee_are_told_apart() {
    let solid = voxels::tee(1);
    let mesh = shell_of(&solid);
    let length = |edges: &[[NodeId; 2]]| -> f64 {
        assert!(edges.is_sorted());
        edges
            .iter()
            .map(|e| mesh.nodes[e[0]].distance(mesh.nodes[e[1]]))
            .sum()
    };
    assert!((length(&mesh.junctions) - 40.0).abs() < 1e-9);
    assert!((length(&mesh.rims) - (128.0 + 40.0 + 26.0)).abs() < 1e-9);
    assert!(mesh.creases.is_empty());
}

#[test]
fn elements_inside_a_lump_are_unsure_and_others_are_not() {
    let solid = voxels::plates_through_block();
    let mesh = shell_of(&solid);
    let middle = |e: &Element| {
        let n = e.corners.as_slice();
        n.iter().map(|&n| mesh.nodes[n]).sum::<DVec3>() / n.len() as f64
    };
    let unsure: Vec<ElementId> = (mesh.elements.enumerated())
        .filter(|(_, e)| e.unsure)
        .map(|(id, _)| id)
        .collect();
    assert!(!unsure.is_empty());
    for id in unsure {
        let x = middle(&mesh.elements[id]).x;
        assert!((30.0..42.0).contains(&x), "{x}");
    }
}

#[test]
fn nodal_normals_are_unit_and_turn_with_the_part() {
    let solid = voxels::plate(1);
    let turned = solid.mapped(motion);
    let (mesh, moved) = (shell_of(&solid), shell_of(&turned));
    let up = motion(DVec3::Z) - motion(DVec3::ZERO);
    for (n, m) in mesh.node_normals.iter().zip(&moved.node_normals) {
        assert!((n.z.abs() - 1.0).abs() < 1e-12);
        assert!((*m - up * n.z).length() < 1e-9);
    }
}
