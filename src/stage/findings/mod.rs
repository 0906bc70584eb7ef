//! Findings: what is odd about how the elements of a mesh hang together, whatever program made it.
//!
//! Input: a [`ShellMesh`] with finite nodes; of its elements only corners and sheets are looked at.
//!
//! Guarantees: every finding names its nodes, its elements and a place; the same findings in the same order on any number of threads; about n log n
//! for n elements, also where many nodes lie in one place.
//!
//! Limits: nodes count as being in one place within [`SAME_PLACE`] of the mesh's size, and as lying on an edge within [`ON_EDGE`] of its length: a hanging node on a
//! curve of which the edge spans more than about 4 degrees is farther off.

mod edges;
mod places;
mod sheets;

use crate::model::ids::{ElementId, IndexVec, NodeId};
use crate::model::mesh_audit::{FindingKind, Findings, Found};
use crate::model::shell::ShellMesh;
use edges::Edges;
use glam::DVec3;

/// Nodes nearer than this share of the diagonal of the mesh's box are in one place: single precision, in which many formats hold coordinates, rounds to a sixteenth of it.
pub const SAME_PLACE: f64 = 1e-6;
/// A node nearer than this share of its length lies on an edge: seen from a node in its middle, the edge then turns by less than 2.3 degrees.
pub const ON_EDGE: f64 = 0.01;

/// Everything odd in a mesh.
pub fn findings(mesh: &ShellMesh) -> Findings {
    let edges = Edges::new(mesh);
    let of_node = elements_of_nodes(mesh);
    let reach = SAME_PLACE * diagonal(mesh);
    let found = FindingKind::ALL.map(|kind| {
        let found = match kind {
            FindingKind::FreeEdge => edges.found(mesh, |sides| sides.len() == 1),
            FindingKind::NonManifoldEdge => edges.found(mesh, |sides| sides.len() > 2),
            FindingKind::TConnection => places::t_connections(mesh, &edges, &of_node, reach),
            FindingKind::DuplicateNode => places::duplicate_nodes(mesh, &of_node, reach),
            FindingKind::DuplicateElement => duplicate_elements(mesh),
            FindingKind::RepeatedCorner => repeated_corners(mesh),
            FindingKind::OppositeNormals => {
                edges.found(mesh, |sides| edges::is_opposite(mesh, sides))
            }
            FindingKind::UnusedNode => unused_nodes(mesh, &of_node),
        };
        (kind, found)
    });
    Findings {
        found: found.into_iter().filter(|(_, f)| !f.is_empty()).collect(),
        sheets: sheets::normals(mesh, &edges),
    }
}

/// The elements round each node.
type AtNodes = IndexVec<NodeId, Vec<ElementId>>;

fn elements_of_nodes(mesh: &ShellMesh) -> AtNodes {
    let mut of: AtNodes = IndexVec::filled(Vec::new(), mesh.nodes.len());
    for (id, element) in mesh.elements.enumerated() {
        for &node in element.corners.as_slice() {
            if of[node].last() != Some(&id) {
                of[node].push(id);
            }
        }
    }
    of
}

fn diagonal(mesh: &ShellMesh) -> f64 {
    let none = [DVec3::INFINITY, DVec3::NEG_INFINITY];
    let finite = mesh.nodes.iter().filter(|p| p.is_finite());
    let [low, high] = finite.fold(none, |[l, h], &p| [l.min(p), h.max(p)]);
    (high - low).max(DVec3::ZERO).length()
}

/// Mean of the places of nodes.
fn mean(mesh: &ShellMesh, nodes: &[NodeId]) -> DVec3 {
    nodes.iter().map(|&n| mesh.nodes[n]).sum::<DVec3>() / nodes.len().max(1) as f64
}

fn duplicate_elements(mesh: &ShellMesh) -> Vec<Found> {
    let mut by_corners: Vec<(Vec<NodeId>, ElementId)> = (mesh.elements.enumerated())
        .map(|(id, element)| {
            let mut corners = element.corners.as_slice().to_vec();
            corners.sort_unstable();
            (corners, id)
        })
        .collect();
    by_corners.sort_unstable();
    let mut found: Vec<Found> = by_corners
        .chunk_by(|a, b| a.0 == b.0)
        .filter(|run| run.len() > 1)
        .map(|run| Found {
            at: mean(mesh, &run[0].0),
            nodes: run[0].0.clone(),
            elements: run.iter().map(|(_, id)| *id).collect(),
        })
        .collect();
    found.sort_by(|a, b| a.elements.cmp(&b.elements));
    found
}

fn repeated_corners(mesh: &ShellMesh) -> Vec<Found> {
    let twice = mesh.elements.enumerated().filter_map(|(id, element)| {
        let corners = element.corners.as_slice();
        let repeated = (1..corners.len()).find(|&k| corners[..k].contains(&corners[k]))?;
        let node = corners[repeated];
        Some(Found {
            at: mesh.nodes[node],
            nodes: vec![node],
            elements: vec![id],
        })
    });
    twice.collect()
}

fn unused_nodes(mesh: &ShellMesh, of_node: &AtNodes) -> Vec<Found> {
    let unused = of_node.enumerated().filter(|(_, of)| of.is_empty());
    unused
        .map(|(node, _)| Found {
            at: mesh.nodes[node],
            nodes: vec![node],
            elements: Vec::new(),
        })
        .collect()
}

#[cfg(test)]
mod tests;
