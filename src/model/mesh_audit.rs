//! What an audit says of a mesh that may come from anywhere: every element's metrics, and what is odd about how elements hang together.
//!
//! In a report nodes and elements have the numbers of their file; places are in its unit of length, mm being assumed.

use super::ids::{ElementId, NodeId};
use super::report::{AuditReport, Criterion, QualityReport};
use glam::DVec3;
use serde::Serialize;
use std::path::PathBuf;

/// Every metric of one element.
#[derive(Clone, Debug, PartialEq)]
pub struct ElementMetrics {
    /// Which one.
    pub element: ElementId,
    /// Mean of its corners.
    pub centre: DVec3,
    /// Its area.
    pub area: f64,
    /// Its shortest edge.
    pub shortest: f64,
    /// Whether it is a quad.
    pub is_quad: bool,
    /// Values in the order of the shape's list in [`super::metric`].
    pub values: Vec<f64>,
    /// The limits that it breaks.
    pub fails: Vec<Criterion>,
}

/// A kind of thing that is found in how elements hang together.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum FindingKind {
    /// An edge of one element.
    FreeEdge,
    /// An edge of three elements or more.
    NonManifoldEdge,
    /// A node that lies on the edge of an element which does not have it as a corner.
    TConnection,
    /// Nodes in one place.
    DuplicateNode,
    /// Elements with the same corners.
    DuplicateElement,
    /// Elements that have a node at two corners.
    RepeatedCorner,
    /// An edge inside a sheet whose two elements have opposite normals.
    OppositeNormals,
    /// A node of no element.
    UnusedNode,
}

impl FindingKind {
    /// Every kind, in the order of reports.
    pub const ALL: [FindingKind; 8] = [
        FindingKind::FreeEdge,
        FindingKind::NonManifoldEdge,
        FindingKind::TConnection,
        FindingKind::DuplicateNode,
        FindingKind::DuplicateElement,
        FindingKind::RepeatedCorner,
        FindingKind::OppositeNormals,
        FindingKind::UnusedNode,
    ];

    /// Its code in reports.
    pub fn code(self) -> &'static str {
        self.text().0
    }

    /// What it means for a shell model.
    pub fn meaning(self) -> &'static str {
        self.text().1
    }

    /// What to do about it.
    pub fn remedy(self) -> &'static str {
        self.text().2
    }

    /// Whether it speaks against the mesh. Every part has rims, most have junctions, and a deck may have nodes for other things than shells: those are told, not held against it.
    pub fn is_fault(self) -> bool {
        !matches!(
            self,
            FindingKind::FreeEdge | FindingKind::NonManifoldEdge | FindingKind::UnusedNode
        )
    }

    fn text(self) -> (&'static str, &'static str, &'static str) {
        match self {
            FindingKind::FreeEdge => (
                "free-edges",
                "edges of one element: rims of the part, or seams where elements do not hang together",
                "look whether each lies on a rim of the part; with --solid this is measured",
            ),
            FindingKind::NonManifoldEdge => (
                "non-manifold-edges",
                "edges of three elements or more: junctions of walls, or elements there too often",
                "look whether walls meet there",
            ),
            FindingKind::TConnection => (
                "t-connections",
                "a node lies on the edge of an element that does not have it as a corner: the mesh can open there",
                "split the element at the node, or move the node off the edge",
            ),
            FindingKind::DuplicateNode => (
                "duplicate-nodes",
                "several nodes lie in one place: what looks joined is not",
                "merge them, unless a hinge or a contact is meant there",
            ),
            FindingKind::DuplicateElement => (
                "duplicate-elements",
                "several elements have the same corners: stiffness and mass are there twice",
                "delete all but one",
            ),
            FindingKind::RepeatedCorner => (
                "repeated-corners",
                "an element has one node at two corners: a quad so written is a triangle, a triangle has no area",
                "write such a quad as a triangle; delete such a triangle",
            ),
            FindingKind::OppositeNormals => (
                "opposite-normals",
                "neighbours in one sheet have opposite normals: pressure loads and offsets change sign there",
                "let the pre-processor align the normals of the sheet, unless it is one-sided",
            ),
            FindingKind::UnusedNode => (
                "unused-nodes",
                "nodes are corners of no shell: some solvers stop on them, others need them for loads and rigid bodies",
                "delete those that nothing else refers to",
            ),
        }
    }
}

impl Serialize for FindingKind {
    fn serialize<S: serde::Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.serialize_str(self.code())
    }
}

/// One thing found in a mesh.
#[derive(Clone, Debug, PartialEq)]
pub struct Found {
    /// Where.
    pub at: DVec3,
    /// The nodes that make it up: the ends of an edge, the node of a T-connection and then the ends of the edge that it lies on, nodes in one place.
    pub nodes: Vec<NodeId>,
    /// The elements that it concerns.
    pub elements: Vec<ElementId>,
}

/// Normals over one sheet.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct SheetNormals {
    /// Its number, from 1.
    pub sheet: usize,
    /// Its elements.
    pub elements: usize,
    /// Its area.
    pub area: f64,
    /// Edges inside it whose two elements have opposite normals.
    pub opposite_edges: usize,
    /// Elements to be turned over so that all agree: the lesser part by area.
    pub turned: usize,
    /// Whether no turning over of elements makes all agree, as on a Moebius strip.
    pub one_sided: bool,
}

/// Everything found in how the elements of a mesh hang together.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Findings {
    /// What was found of each kind, in order of the kinds; kinds of which nothing was found are left out.
    pub found: Vec<(FindingKind, Vec<Found>)>,
    /// The sheets, in order of their ids.
    pub sheets: Vec<SheetNormals>,
}

impl Findings {
    /// What was found of one kind.
    pub fn of(&self, kind: FindingKind) -> &[Found] {
        (self.found.iter())
            .find(|(other, _)| *other == kind)
            .map_or(&[], |(_, found)| found.as_slice())
    }
}

/// A finding in the numbers of the file.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Located {
    /// Where.
    pub at: DVec3,
    /// Numbers of its nodes, as in [`Found::nodes`].
    pub nodes: Vec<u64>,
    /// Numbers of its elements.
    pub elements: Vec<u64>,
}

/// All findings of one kind.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct FindingReport {
    /// Which.
    pub kind: FindingKind,
    /// Whether it speaks against the mesh.
    pub fault: bool,
    /// What it means.
    pub meaning: &'static str,
    /// What to do.
    pub remedy: &'static str,
    /// How many there are.
    pub count: usize,
    /// Each of them.
    pub places: Vec<Located>,
}

/// What an audit says of a mesh.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct MeshAuditReport {
    /// The file that was read.
    pub input: PathBuf,
    /// Its format.
    pub format: &'static str,
    /// What the user should know of how the file was read.
    pub notes: Vec<String>,
    /// Elements for which the file has no thickness.
    pub without_thickness: usize,
    /// Whether the sheets are named in the file; else they are what hangs together over edges of two elements.
    pub sheets_named: bool,
    /// Element quality. Its worst elements count from 0; their numbers in the file follow.
    pub quality: QualityReport,
    /// Numbers in the file of the worst elements of the quality report.
    pub worst_numbers: Vec<u64>,
    /// How the elements hang together, every kind.
    pub findings: Vec<FindingReport>,
    /// Normals, sheet by sheet.
    pub sheets: Vec<SheetNormals>,
    /// The solid that the mesh was held against.
    pub solid: Option<PathBuf>,
    /// The mesh against the solid.
    pub audit: Option<AuditReport>,
    /// What speaks against the mesh; nothing where it is sound.
    pub faults: Vec<String>,
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_kind_has_its_own_code_and_both_sentences() {
        let mut codes: Vec<&str> = FindingKind::ALL.iter().map(|k| k.code()).collect();
        codes.sort_unstable();
        codes.dedup();
        assert_eq!(codes.len(), FindingKind::ALL.len());
        for kind in FindingKind::ALL {
            assert!(kind.meaning().len() > 20 && kind.remedy().len() > 15);
        }
    }
}
