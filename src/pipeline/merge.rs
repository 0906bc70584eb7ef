//! Shells of several solids as one mesh.

use crate::model::ids::{Id, NodeId, SheetId, WallId};
use crate::model::shell::{Corners, Sheet, ShellMesh};

/// Puts meshes behind one another; nodes are never shared between solids.
pub(super) fn merge(meshes: Vec<ShellMesh>) -> ShellMesh {
    let mut meshes = meshes.into_iter();
    let mut all = meshes.next().unwrap_or_default();
    for mesh in meshes {
        let (nodes, sheets) = (all.nodes.len() as u32, all.sheets.len());
        let walls = (all.sheets.iter()).map(|s| s.wall.index() + 1).max();
        let walls = walls.unwrap_or(0);
        let node = |n: NodeId| NodeId(n.0 + nodes);
        let edges = |e: Vec<[NodeId; 2]>| e.into_iter().map(move |e| e.map(node));
        all.nodes = all
            .nodes
            .into_vec()
            .into_iter()
            .chain(mesh.nodes.into_vec())
            .collect();
        all.node_thickness = all
            .node_thickness
            .into_vec()
            .into_iter()
            .chain(mesh.node_thickness.into_vec())
            .collect();
        all.node_normals = all
            .node_normals
            .into_vec()
            .into_iter()
            .chain(mesh.node_normals.into_vec())
            .collect();
        for mut e in mesh.elements.into_vec() {
            e.corners = match e.corners {
                Corners::Triangle(n) => Corners::Triangle(n.map(node)),
                Corners::Quad(n) => Corners::Quad(n.map(node)),
            };
            e.sheet = SheetId::new(e.sheet.index() + sheets);
            all.elements.push(e);
        }
        all.sheets = all
            .sheets
            .into_vec()
            .into_iter()
            .chain(mesh.sheets.into_vec().into_iter().map(|sheet| Sheet {
                wall: WallId::new(sheet.wall.index() + walls),
                ..sheet
            }))
            .collect();
        all.rims.extend(edges(mesh.rims));
        all.junctions.extend(edges(mesh.junctions));
        all.creases.extend(edges(mesh.creases));
    }
    all
}

#[cfg(test)]
mod tests;
