//! Why a mesh file cannot be read.

use crate::import::facet::soup::{self, Place};
use std::borrow::Cow;

/// What is wrong with the bytes of a mesh file, and where.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[error("{}{kind}", place.map(|p| format!("{p}: ")).unwrap_or_default())]
pub struct ReadError {
    /// Where, if it is at one place.
    pub place: Option<Place>,
    /// What.
    pub kind: ReadErrorKind,
}

/// The kinds of [`ReadError`].
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum ReadErrorKind {
    /// The file is of another format, or of a kind of this one that is not read.
    #[error("{what}")]
    Format {
        /// What it is.
        what: Cow<'static, str>,
        /// What to do.
        remedy: &'static str,
    },
    /// The file ends inside something.
    #[error("the file ends inside {0}")]
    Truncated(&'static str),
    /// Something else is expected there.
    #[error("{0} is expected, not '{1}'")]
    Expected(&'static str, String),
    /// Counts in the file contradict each other.
    #[error("{0}")]
    Counts(String),
    /// An element names a node that the file does not have.
    #[error("element {element} names node {node}, which the file does not have")]
    MissingNode {
        /// The element.
        element: u64,
        /// The node.
        node: u64,
    },
    /// A node or an element is there twice.
    #[error("{what} {number} is defined twice")]
    DefinedTwice {
        /// `node` or `element`.
        what: &'static str,
        /// Its number.
        number: u64,
    },
    /// A coordinate that is infinite or no number.
    #[error("node {node} has a coordinate that is no finite number; of {nodes} nodes {count} have")]
    NotFinite {
        /// The first such node.
        node: u64,
        /// How many there are.
        count: usize,
        /// How many nodes the file has.
        nodes: usize,
    },
    /// There are solid elements, and no shells.
    #[error("it is a solid mesh: {solids} solid elements and no shell")]
    SolidMesh {
        /// How many.
        solids: usize,
    },
    /// There is no shell at all.
    #[error(
        "there is no shell element in the file ({nodes} nodes, {others} lines, points and other elements)"
    )]
    NoShells {
        /// Elements that are neither shells nor solids.
        others: usize,
        /// How many nodes the file has.
        nodes: usize,
    },
    /// More nodes or elements than can be numbered.
    #[error("more than {} nodes or elements", u32::MAX)]
    TooMany,
    /// An STL file that cannot be read.
    #[error("{0}")]
    Stl(soup::ReadErrorKind),
}

impl ReadErrorKind {
    /// An error of this kind that is not at one place.
    pub(super) fn anywhere(self) -> ReadError {
        ReadError {
            place: None,
            kind: self,
        }
    }

    /// An error of this kind in a line, from 1.
    pub(super) fn line(self, line: usize) -> ReadError {
        ReadError {
            place: Some(Place::Line(line)),
            kind: self,
        }
    }

    /// An error of this kind at a byte, from 0.
    pub(super) fn byte(self, byte: usize) -> ReadError {
        ReadError {
            place: Some(Place::Byte(byte)),
            kind: self,
        }
    }
}

/// What is expected, and what stands there instead, cut short.
pub(super) fn expected(what: &'static str, found: &[u8]) -> ReadErrorKind {
    let text = String::from_utf8_lossy(found);
    ReadErrorKind::Expected(what, text.trim().chars().take(40).collect())
}

impl ReadError {
    /// What the user can do.
    pub fn remedy(&self) -> &'static str {
        match &self.kind {
            ReadErrorKind::Format { remedy, .. } => remedy,
            ReadErrorKind::Truncated(_)
            | ReadErrorKind::Expected(..)
            | ReadErrorKind::Counts(_)
            | ReadErrorKind::Stl(_) => {
                "write the mesh again from the program that made it; if the file was copied, check that the copy is complete"
            }
            ReadErrorKind::MissingNode { .. } => {
                "write the whole mesh into one file: nodes that stand elsewhere, as behind an include, are not read"
            }
            ReadErrorKind::DefinedTwice { .. } => {
                "give each its own number: several parts in one deck are to be renumbered, or written to a file each"
            }
            ReadErrorKind::NotFinite { .. } => {
                "mend the node, or what wrote it: nothing can be measured on such an element"
            }
            ReadErrorKind::SolidMesh { .. } => {
                "audit judges shells: triangles and quads. Give it the shell mesh; 'midshell mesh' makes one from the CAD solid"
            }
            ReadErrorKind::NoShells { .. } => {
                "give a file with triangles or quads; see that they were exported with the nodes"
            }
            ReadErrorKind::TooMany => "audit the mesh in parts",
        }
    }
}
