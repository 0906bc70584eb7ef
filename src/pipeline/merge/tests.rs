use super::*;
use crate::test_parts::{grid_mesh, plate_mesh};
use glam::DVec3;

fn marked(mut mesh: ShellMesh, tag: i32) -> ShellMesh {
    mesh.sheets[SheetId(0)].solid_tag = tag;
    mesh.rims.push([NodeId(0), NodeId(1)]);
    mesh.junctions.push([NodeId(1), NodeId(2)]);
    mesh.creases.push([NodeId(2), NodeId(3)]);
    mesh
}

#[test]
fn nothing_and_one_stay_what_they_are() {
    assert_eq!(merge(vec![]), ShellMesh::default());
    let one = marked(plate_mesh(4, 3), 7);
    assert_eq!(merge(vec![one.clone()]), one);
}

#[test]
fn every_element_keeps_its_corners_sheet_and_solid() {
    let quads = marked(plate_mesh(4, 3), 7);
    let mut triangles = marked(grid_mesh(|u, v| DVec3::new(u, v, 9.0), 1, 1, false, 0.5), 8);
    let Corners::Quad([a, b, c, d]) = triangles.elements.as_slice()[0].corners else {
        panic!("a grid has quads")
    };
    triangles.elements.as_mut_slice()[0].corners = Corners::Triangle([a, b, c]);
    let mut other = triangles.elements.as_slice()[0].clone();
    other.corners = Corners::Triangle([a, c, d]);
    triangles.elements.push(other);

    let parts = [quads.clone(), triangles.clone(), quads];
    let all = merge(parts.to_vec());
    let mut elements = all.elements.iter();
    let mut nodes = 0;
    for (k, part) in parts.iter().enumerate() {
        for e in &part.elements {
            let merged = elements.next().unwrap();
            assert_eq!(merged.corners.is_quad(), e.corners.is_quad());
            let (n, m) = (e.corners.as_slice(), merged.corners.as_slice());
            for (n, m) in n.iter().zip(m) {
                assert_eq!(m.0, n.0 + nodes);
                assert_eq!(all.nodes[*m], part.nodes[*n]);
                assert_eq!(all.node_thickness[*m], part.node_thickness[*n]);
                assert_eq!(all.node_normals[*m], part.node_normals[*n]);
            }
            assert_eq!(merged.thickness, e.thickness);
            assert_eq!(merged.sheet, SheetId(k as u32));
            let sheet = &all.sheets[merged.sheet];
            // Each of these parts has one wall.
            assert_eq!(sheet.wall, WallId(k as u32));
            let (tag, sides) = (sheet.solid_tag, &sheet.sides);
            let own = &part.sheets[e.sheet];
            assert_eq!((tag, sides), (own.solid_tag, &own.sides));
        }
        for (whole, own) in [
            (&all.rims, &part.rims),
            (&all.junctions, &part.junctions),
            (&all.creases, &part.creases),
        ] {
            assert_eq!(whole[k], own[0].map(|n| NodeId(n.0 + nodes)));
        }
        nodes += part.nodes.len() as u32;
    }
    assert!(elements.next().is_none());
    assert_eq!(all.nodes.len() as u32, nodes);
    assert_eq!((all.rims.len(), all.sheets.len()), (3, 3));
}
