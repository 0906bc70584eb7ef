//! The filling of one solid.

use super::ids::{Id, IndexVec, TetId, VertexId};

/// The tetrahedra that fill a solid; their corners are vertices of the [`Brep`](super::brep::Brep) beside them.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Tets {
    /// Four corners each, positively oriented.
    pub cells: IndexVec<TetId, [VertexId; 4]>,
}

/// What can be wrong with [`Tets`].
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum TetsFault {
    /// A corner is missing or named twice.
    #[error("tet {0:?} has corners that are missing or equal")]
    BadTet(TetId),
}

impl Tets {
    /// All violations, given how many vertices there are.
    pub fn check(&self, vertices: usize) -> Vec<TetsFault> {
        self.cells
            .enumerated()
            .filter(|(_, t)| {
                (0..4).any(|i| t[i].index() >= vertices || (0..i).any(|j| t[i] == t[j]))
            })
            .map(|(id, _)| TetsFault::BadTet(id))
            .collect()
    }
}
