//! Mid-side nodes: they turn the elements of a deck into elements of second order.
//!
//! A node in the middle of every straight element side, shared by all elements along it, numbered after the nodes of the mesh in the order of the sides' ends.
//! Its thickness is the mean of that at both ends.
//!
//! Limits: the sides stay straight, so a curved sheet is as many-sided as its triangles are; that is what the mesh was audited as.

use super::cells::Cell;
use crate::model::ids::NodeId;
use crate::model::shell::ShellMesh;
use glam::DVec3;

/// The element sides of a deck that have a node in the middle: all of them, or none.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct MidSides {
    /// Number of the first mid-side node.
    first: usize,
    /// The ends of each side, lower node first, ascending.
    sides: Vec<[NodeId; 2]>,
}

impl MidSides {
    /// One on every side of the cells.
    pub fn of(mesh: &ShellMesh, cells: &[Cell]) -> Self {
        let mut sides: Vec<_> = cells.iter().flat_map(sides_of).map(ascending).collect();
        sides.sort_unstable();
        sides.dedup();
        Self {
            first: mesh.nodes.len() + 1,
            sides,
        }
    }

    /// How many there are.
    pub fn len(&self) -> usize {
        self.sides.len()
    }

    /// Number and position, mm, of every mid-side node, ascending.
    pub fn points<'a>(&'a self, mesh: &'a ShellMesh) -> impl Iterator<Item = (usize, DVec3)> + 'a {
        let middle = |[a, b]: &[NodeId; 2]| 0.5 * (mesh.nodes[*a] + mesh.nodes[*b]);
        (self.first..).zip(self.sides.iter().map(middle))
    }

    /// The number of the node in the middle of a side; `None` where there is none.
    pub fn between(&self, side: [NodeId; 2]) -> Option<usize> {
        let place = self.sides.binary_search(&ascending(side)).ok()?;
        Some(self.first + place)
    }

    /// The numbers of the mid-side nodes of a cell, that between its first and second corner first.
    pub fn of_cell<'a>(&'a self, cell: &'a Cell) -> impl Iterator<Item = usize> + 'a {
        sides_of(cell).filter_map(|side| self.between(side))
    }
}

/// The sides of a cell, from its first corner on.
pub(super) fn sides_of(cell: &Cell) -> impl Iterator<Item = [NodeId; 2]> + '_ {
    let n = cell.corners.len();
    (0..n).map(move |k| [cell.corners[k], cell.corners[(k + 1) % n]])
}

fn ascending([a, b]: [NodeId; 2]) -> [NodeId; 2] {
    [a.min(b), a.max(b)]
}

#[cfg(test)]
mod tests {
    use super::super::cells::cells;
    use super::super::tests::quad;
    use super::*;
    use crate::model::ids::ElementId;
    use crate::model::shell::Corners;

    /// The unit quad as two triangles.
    fn halves() -> ShellMesh {
        let mut mesh = quad([1.0; 4]);
        let mut other = mesh.elements[ElementId(0)].clone();
        mesh.elements[ElementId(0)].corners = Corners::Triangle([0, 1, 2].map(NodeId));
        other.corners = Corners::Triangle([0, 2, 3].map(NodeId));
        mesh.elements.push(other);
        mesh
    }

    #[test]
    fn two_triangles_share_the_node_between_them() {
        let mesh = halves();
        let cells = cells(&mesh);
        let mids = MidSides::of(&mesh, &cells);
        assert_eq!(mids.len(), 5);
        let of = |k: usize| mids.of_cell(&cells[k]).collect::<Vec<_>>();
        // Sides 0-1, 0-2, 0-3, 1-2, 2-3 are nodes 5 to 9.
        assert_eq!([of(0), of(1)], [[5, 8, 6], [6, 9, 7]]);
        assert_eq!(mids.between([NodeId(2), NodeId(0)]), Some(6));
        assert_eq!(mids.between([NodeId(1), NodeId(3)]), None);
        let points: Vec<_> = mids.points(&mesh).collect();
        assert_eq!(points[1], (6, DVec3::new(0.5, 0.5, 0.0)));
        assert_eq!(points[4], (9, DVec3::new(0.5, 1.0, 0.0)));
    }

    #[test]
    fn a_deck_without_them_names_none() {
        let mesh = halves();
        let none = MidSides::default();
        assert_eq!(none.of_cell(&cells(&mesh)[0]).count(), 0);
        assert_eq!(none.points(&mesh).count(), 0);
    }
}
