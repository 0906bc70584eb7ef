//! Elements that need a normal of their own in a CalculiX deck.
//!
//! CalculiX expands a shell along its nodes' normals, each the mean of those of the elements there within 20 degrees of each other. Where an element is
//! much shorter than it is thick, two such means may lean so far towards each other that its top or bottom turns inside out, at which CalculiX stops
//! ("nonpositive jacobian"). With the element's own normal at all its nodes (`*NORMAL`) it is a straight prism, which cannot.
//! The price: its nodes are rigid knots, measured to change the deflection of a part with tight bends by 1 % at most.
//!
//! Reference: CalculiX CrunchiX user's manual, `*NORMAL` and the section on shell elements.

use super::cells::Cell;
use crate::model::ids::{IndexVec, NodeId};
use crate::model::shell::ShellMesh;
use glam::DVec3;

/// The mean at a node takes in elements on either side of 20 degrees: two of them may be twice that apart. Further apart they do not share a normal.
const AVERAGED_DEG: f64 = 40.0;

/// The edges of an element lean towards each other, over its thickness, by thickness x tangent of the angle to its neighbours at most, and by about half of that as a rule. An
/// element that is higher than this share of the most is left alone; with half the share every fixture's deck was sound as well.
const LEAN: f64 = 1.0 / 1.2;

/// The places of these cells, ascending, with the unit normal of each.
pub(super) fn own_normals(mesh: &ShellMesh, cells: &[Cell]) -> Vec<(usize, DVec3)> {
    let normals: Vec<DVec3> = cells
        .iter()
        .map(|cell| doubled_area(mesh, cell).normalize_or_zero())
        .collect();
    let mut at_node: IndexVec<NodeId, Vec<usize>> = IndexVec::filled(Vec::new(), mesh.nodes.len());
    for (place, cell) in cells.iter().enumerate() {
        for &node in &cell.corners {
            at_node[node].push(place);
        }
    }
    let least_cosine = AVERAGED_DEG.to_radians().cos();
    let needs = |&place: &usize| {
        let (cell, normal) = (&cells[place], normals[place]);
        let neighbours = cell.corners.iter().flat_map(|&node| &at_node[node]);
        let cosine = neighbours
            .map(|&other| normals[other].dot(normal))
            .filter(|&cosine| cosine >= least_cosine)
            .fold(1.0, f64::min);
        let tangent = (1.0 - cosine * cosine).sqrt() / cosine;
        let thickness = cell.thickness.iter().copied().fold(0.0, f64::max);
        normal != DVec3::ZERO && LEAN * thickness * tangent > height(mesh, cell)
    };
    (0..cells.len())
        .filter(needs)
        .map(|place| (place, normals[place]))
        .collect()
}

/// Normal of a cell, twice its area long.
fn doubled_area(mesh: &ShellMesh, cell: &Cell) -> DVec3 {
    let p = |k: usize| mesh.nodes[cell.corners[k]];
    let last = cell.corners.len() - 1;
    (p(2) - p(0)).cross(p(last) - p(1))
}

/// Least height of a triangle, mm; of a quad its area over its longest side.
fn height(mesh: &ShellMesh, cell: &Cell) -> f64 {
    let n = cell.corners.len();
    let side =
        |k: usize| mesh.nodes[cell.corners[k]].distance(mesh.nodes[cell.corners[(k + 1) % n]]);
    let longest = (0..n).map(side).fold(0.0, f64::max);
    let area = doubled_area(mesh, cell).length() / if n == 3 { 1.0 } else { 2.0 };
    area / longest
}

#[cfg(test)]
mod tests {
    use super::super::cells::cells;
    use super::super::tests::quad;
    use super::*;
    use crate::model::ids::ElementId;

    /// A unit quad and, folded down by this angle along its side at x = 1, a strip of this width.
    fn folded(angle_deg: f64, width: f64, thickness: f64) -> Vec<usize> {
        let mut mesh = quad([thickness; 4]);
        let (sine, cosine) = angle_deg.to_radians().sin_cos();
        for y in [0.0, 1.0] {
            mesh.nodes
                .push(DVec3::new(1.0 + width * cosine, y, -width * sine));
        }
        let mut strip = mesh.elements[ElementId(0)].clone();
        strip.corners = crate::model::shell::Corners::Quad([1, 4, 5, 2].map(NodeId));
        mesh.elements.push(strip);
        let own = own_normals(&mesh, &cells(&mesh));
        for (place, normal) in &own {
            let down = if *place == 0 {
                DVec3::Z
            } else {
                DVec3::new(sine, 0.0, cosine)
            };
            assert!(normal.distance(down) < 1e-12);
        }
        own.iter().map(|(place, _)| *place).collect()
    }

    #[test]
    fn only_an_element_short_against_its_thickness_at_a_bend_needs_one() {
        assert_eq!(folded(15.0, 0.1, 1.0), [1]);
        // Thin, flat, wide, or folded so sharply that no normal is shared.
        assert_eq!(folded(15.0, 0.1, 0.3), [0; 0]);
        assert_eq!(folded(0.0, 0.1, 1.0), [0; 0]);
        assert_eq!(folded(15.0, 0.5, 1.0), [0; 0]);
        assert_eq!(folded(60.0, 0.1, 1.0), [0; 0]);
        assert_eq!(folded(15.0, 0.1, 10.0), [0, 1]);
    }
}
