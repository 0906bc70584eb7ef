//! Elements as a solver takes them: quads with a corner of 180 degrees or more become two triangles.

use super::number_of;
use crate::model::ids::{ElementId, NodeId};
use crate::model::shell::ShellMesh;
use glam::DVec3;
use smallvec::SmallVec;

/// An element of a deck.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Cell {
    /// Its number in the deck, from 1.
    pub number: usize,
    /// The element that it is, or is half of.
    pub element: ElementId,
    /// Three or four corners.
    pub corners: SmallVec<[NodeId; 4]>,
    /// Thickness at each corner, mm.
    pub thickness: SmallVec<[f64; 4]>,
}

impl Cell {
    /// Mean thickness of its corners, mm.
    pub fn mean_thickness(&self) -> f64 {
        self.thickness.iter().sum::<f64>() / self.thickness.len() as f64
    }
}

/// The cells in the order of their numbers, which are those of the elements; the second halves of split quads come last.
pub(super) fn cells(mesh: &ShellMesh) -> Vec<Cell> {
    let mut cells = Vec::with_capacity(mesh.elements.len());
    let mut second_halves = Vec::new();
    for (id, element) in mesh.elements.enumerated() {
        let corners = element.corners.as_slice();
        let cell = |number: usize, which: &[usize]| Cell {
            number,
            element: id,
            corners: which.iter().map(|&k| corners[k]).collect(),
            thickness: which.iter().map(|&k| element.thickness[k]).collect(),
        };
        let number = number_of(id);
        if corners.len() == 3 {
            cells.push(cell(number, &[0, 1, 2]));
            continue;
        }
        let points = [0, 1, 2, 3].map(|k| mesh.nodes[corners[k]]);
        match reflex_corner(points) {
            None => cells.push(cell(number, &[0, 1, 2, 3])),
            Some(k) => {
                let at = |step: usize| (k + step) % 4;
                cells.push(cell(number, &[k, at(1), at(2)]));
                let next = mesh.elements.len() + second_halves.len() + 1;
                second_halves.push(cell(next, &[k, at(2), at(3)]));
            }
        }
    }
    cells.extend(second_halves);
    cells
}

/// The corner whose interior angle is 180 degrees or more, seen along the quad's mean normal; the worst one if there are several.
fn reflex_corner(points: [DVec3; 4]) -> Option<usize> {
    let normal = (points[2] - points[0]).cross(points[3] - points[1]);
    // Sine below which a corner counts as straight: a wide Nastran field keeps some eleven digits, so that a sine of 1e-6 survives being written.
    const STRAIGHT: f64 = 1e-6;
    let mut worst = None;
    let mut least = STRAIGHT;
    for k in 0..4 {
        let ahead = points[(k + 1) % 4] - points[k];
        let back = points[(k + 3) % 4] - points[k];
        let scale = ahead.length() * back.length() * normal.length();
        let sine = if scale > 0.0 {
            ahead.cross(back).dot(normal) / scale
        } else {
            0.0
        };
        if sine <= least {
            least = sine;
            worst = Some(k);
        }
    }
    worst
}

#[cfg(test)]
mod tests {
    use super::super::tests::quad;
    use super::*;
    use crate::model::ids::NodeId;

    #[test]
    fn a_convex_quad_stays_whole() {
        let cells = cells(&quad([1.0, 2.0, 3.0, 4.0]));
        assert_eq!(cells.len(), 1);
        assert_eq!(cells[0].corners.len(), 4);
        assert_eq!(cells[0].mean_thickness(), 2.5);
    }

    #[test]
    fn a_reflex_or_straight_corner_splits_its_quad_there() {
        for place in [0.4, 0.5] {
            let mut mesh = quad([1.0, 2.0, 3.0, 4.0]);
            mesh.nodes[NodeId(2)] = DVec3::new(place, place, 0.0);
            let cells = cells(&mesh);
            let corners: Vec<Vec<u32>> = cells
                .iter()
                .map(|c| c.corners.iter().map(|n| n.0).collect())
                .collect();
            assert_eq!(corners, [[2, 3, 0], [2, 0, 1]]);
            assert_eq!((cells[0].number, cells[1].number), (1, 2));
            assert_eq!(cells[1].thickness.as_slice(), [3.0, 1.0, 2.0]);
        }
    }

    #[test]
    fn no_corner_of_a_split_quad_is_turned_over() {
        let mut mesh = quad([1.0; 4]);
        mesh.nodes[NodeId(1)] = DVec3::new(0.2, 0.3, 0.0);
        for cell in cells(&mesh) {
            let p: Vec<DVec3> = cell.corners.iter().map(|&n| mesh.nodes[n]).collect();
            assert!((p[1] - p[0]).cross(p[2] - p[0]).z > 0.0);
        }
    }
}
