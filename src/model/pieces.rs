//! Walls cut into pieces for meshing, each a wall of its own until the mesh is done.

use super::complex::MidComplex;
use super::ids::WallId;
use std::collections::BTreeMap;

/// Which wall each piece is of. A wall that is not named is whole.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Pieces(BTreeMap<WallId, WallId>);

impl Pieces {
    /// Adds a piece of a wall.
    pub fn add(&mut self, piece: WallId, whole: WallId) {
        self.0.insert(piece, whole);
    }

    /// Whether nothing is cut.
    pub fn is_empty(&self) -> bool {
        self.0.is_empty()
    }

    /// The wall that a piece is of; a wall that is whole itself.
    pub fn whole(&self, piece: WallId) -> WallId {
        self.0.get(&piece).copied().unwrap_or(piece)
    }

    /// A complex with the pieces of each wall one wall again.
    pub fn joined(&self, mut complex: MidComplex) -> MidComplex {
        for t in complex.triangles.as_mut_slice() {
            t.wall = self.whole(t.wall);
        }
        complex.support_by_walls();
        complex
    }
}
