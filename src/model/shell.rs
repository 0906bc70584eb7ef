//! The result: a shell mesh with thickness, sheets and provenance.

use super::ids::{ElementId, IndexVec, NodeId, SheetId, WallId};
use glam::DVec3;

/// The corners of a shell element, in order round it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Corners {
    /// Three corners.
    Triangle([NodeId; 3]),
    /// Four corners.
    Quad([NodeId; 4]),
}

impl Corners {
    /// The corners as a slice of three or four.
    #[inline]
    pub fn as_slice(&self) -> &[NodeId] {
        match self {
            Corners::Triangle(n) => n,
            Corners::Quad(n) => n,
        }
    }
    /// Whether there are four.
    pub fn is_quad(&self) -> bool {
        matches!(self, Corners::Quad(_))
    }
}

/// One shell element.
#[derive(Clone, Debug, PartialEq)]
pub struct Element {
    /// Its corners; the order gives the element normal, the same way round over a whole sheet.
    pub corners: Corners,
    /// The sheet that it belongs to.
    pub sheet: SheetId,
    /// Thickness at each corner, mm; the fourth value of a triangle repeats the third.
    pub thickness: [f64; 4],
    /// Tags (numbers in the source file) of the faces on the side the normal points to and on the other side; 0 where there is none.
    pub source_faces: [i32; 2],
    /// Whether no pair of faces fixes its place (inside a lump, or a healed membrane): a solver should not trust a shell there.
    pub unsure: bool,
}

impl Element {
    /// Mean thickness of its corners, mm.
    pub fn mean_thickness(&self) -> f64 {
        let n = self.corners.as_slice().len();
        self.thickness[..n].iter().sum::<f64>() / n as f64
    }
}

/// A sheet: a two-manifold piece of the mid-surface, between rims, creases and junction curves.
#[derive(Clone, Debug, PartialEq)]
pub struct Sheet {
    /// The solid it comes from, by its number in the source file.
    pub solid_tag: i32,
    /// The wall it is the middle of.
    pub wall: WallId,
    /// Tags of the faces on either side.
    pub sides: [Vec<i32>; 2],
}

/// A shell mesh on the mid-surface of one or more solids. Lengths in mm.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ShellMesh {
    /// #N positions.
    pub nodes: IndexVec<NodeId, DVec3>,
    /// #N thickness, mm: area-weighted mean of the elements' corner values.
    pub node_thickness: IndexVec<NodeId, f64>,
    /// #N unit normals: area-weighted mean over the elements (of the lowest sheet, at a junction).
    pub node_normals: IndexVec<NodeId, DVec3>,
    /// #E elements, triangles and quads mixed, ordered by sheet.
    pub elements: IndexVec<ElementId, Element>,
    /// The sheets.
    pub sheets: IndexVec<SheetId, Sheet>,
    /// Free edges, sorted.
    pub rims: Vec<[NodeId; 2]>,
    /// Edges where three elements or more meet, sorted.
    pub junctions: Vec<[NodeId; 2]>,
    /// Edges where two sheets meet at a fold, sorted.
    pub creases: Vec<[NodeId; 2]>,
}

impl ShellMesh {
    /// Twice the area vector of an element, mm², along the normal that its corners' order gives. Its nodes have to be there.
    pub fn doubled_area(&self, element: &Element) -> DVec3 {
        match element.corners {
            Corners::Triangle(n) => {
                let [a, b, c] = n.map(|n| self.nodes[n]);
                (b - a).cross(c - a)
            }
            Corners::Quad(n) => {
                let [a, b, c, d] = n.map(|n| self.nodes[n]);
                (c - a).cross(d - b)
            }
        }
    }
}
