//! Which tet edges run through a wall, and what the vertices lie on.

use super::ids::{FaceId, IndexVec, TetEdgeId, TetFaceId, VertexId};
use super::walls::Role;
use smallvec::SmallVec;

/// Roles of the faces and the wall faces that each of them stands for.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct FaceRoles {
    /// The role of every face.
    pub role: IndexVec<FaceId, Role>,
    /// The wall faces whose label a vertex on this face carries: itself for a wall side, the joined walls for a blend, none otherwise.
    pub carries: IndexVec<FaceId, Labels>,
}

/// Wall faces that a vertex lies on or stands for, sorted.
pub type Labels = SmallVec<[FaceId; 4]>;

/// How wall-like a tet edge is.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Passage {
    /// Both ends on one side of a wall.
    Along,
    /// The ends share no side, yet no pair stands behind it.
    Apart,
    /// From one side of a wall to the other.
    Through,
}

/// Labels and passages: what the collapse must not eat.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Decomposition {
    /// Labels of every vertex.
    pub labels: IndexVec<VertexId, Labels>,
    /// Passage of every tet edge.
    pub passage: IndexVec<TetEdgeId, Passage>,
}

/// What is left of the dual complex.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Collapsed {
    /// Whether the 2-cell of each tet edge lives.
    pub cells: IndexVec<TetEdgeId, bool>,
    /// Triangles whose 1-cell lives without any living 2-cell: pieces that hang together only by a line there.
    pub bars: Vec<TetFaceId>,
}

/// Order in which a 2-cell may go: lower first. What has none is protected.
pub type Grade = u8;
