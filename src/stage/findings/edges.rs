//! The edges of a mesh, each with the sides of elements that lie on it.

use super::mean;
use crate::model::ids::{ElementId, NodeId};
use crate::model::mesh_audit::Found;
use crate::model::shell::ShellMesh;

/// A side of an element.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) struct Side {
    /// The ends, the lower id first.
    pub ends: [NodeId; 2],
    /// The element.
    pub element: ElementId,
    /// Whether the element runs from the lower to the higher id.
    pub ahead: bool,
}

/// Every edge, in order of its ends.
pub(super) struct Edges {
    sides: Vec<Side>,
}

impl Edges {
    /// Sides between a node and itself are left out.
    pub fn new(mesh: &ShellMesh) -> Self {
        let mut sides = Vec::with_capacity(4 * mesh.elements.len());
        for (element, of) in mesh.elements.enumerated() {
            let nodes = of.corners.as_slice();
            for (k, &a) in nodes.iter().enumerate() {
                let b = nodes[(k + 1) % nodes.len()];
                if a != b {
                    sides.push(Side {
                        ends: [a.min(b), a.max(b)],
                        element,
                        ahead: a < b,
                    });
                }
            }
        }
        sides.sort_unstable();
        Self { sides }
    }

    /// The sides of each edge.
    pub fn iter(&self) -> impl Iterator<Item = &[Side]> {
        self.sides.chunk_by(|a, b| a.ends == b.ends)
    }

    /// Findings for the edges that are wanted.
    pub fn found(&self, mesh: &ShellMesh, wanted: impl Fn(&[Side]) -> bool) -> Vec<Found> {
        let wanted = self.iter().filter(|sides| wanted(sides));
        wanted
            .map(|sides| Found {
                at: mean(mesh, &sides[0].ends),
                nodes: sides[0].ends.to_vec(),
                elements: sides.iter().map(|s| s.element).collect(),
            })
            .collect()
    }
}

/// Whether these are the two sides of one sheet's inner edge.
pub(super) fn is_inner(mesh: &ShellMesh, sides: &[Side]) -> bool {
    matches!(sides, [a, b] if mesh.elements[a.element].sheet == mesh.elements[b.element].sheet)
}

/// Whether two elements of one sheet run the same way along their edge.
pub(super) fn is_opposite(mesh: &ShellMesh, sides: &[Side]) -> bool {
    is_inner(mesh, sides) && sides[0].ahead == sides[1].ahead
}
