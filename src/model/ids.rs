//! Typed indices: every entity is named by a `u32` newtype, so that a face cannot be taken for a node.

use std::fmt;
use std::marker::PhantomData;
use std::ops::{Index, IndexMut};

/// A typed `u32` index into an [`IndexVec`].
pub trait Id: Copy + Eq + Ord + fmt::Debug + Send + Sync + 'static {
    /// The id of the `index`-th entity. Panics past `u32::MAX`, which no mesh that fits in memory here reaches.
    fn new(index: usize) -> Self;
    /// The position in the vector that the id belongs to.
    fn index(self) -> usize;
}

macro_rules! ids {
    ($($(#[$doc:meta])* $name:ident),* $(,)?) => {$(
        $(#[$doc])*
        #[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, serde::Serialize, serde::Deserialize)]
        #[serde(transparent)]
        pub struct $name(pub u32);

        impl Id for $name {
            #[inline]
            fn new(index: usize) -> Self {
                debug_assert!(index <= u32::MAX as usize);
                Self(index as u32)
            }
            #[inline]
            fn index(self) -> usize {
                self.0 as usize
            }
        }

        impl fmt::Debug for $name {
            fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                write!(f, "{}{}", stringify!($name), self.0)
            }
        }
    )*};
}

ids! {
    /// A vertex of the filled solid: a corner of boundary triangles and tets.
    VertexId,
    /// A boundary triangle of the solid.
    FacetId,
    /// A face of the solid's boundary representation.
    FaceId,
    /// An edge (curve) of the solid's boundary representation.
    CurveId,
    /// A tetrahedron.
    TetId,
    /// An edge of the tetrahedral mesh.
    TetEdgeId,
    /// A triangle of the tetrahedral mesh.
    TetFaceId,
    /// A wall: two sides of faces with material between them.
    WallId,
    /// A node of a mid-complex or of a shell mesh.
    NodeId,
    /// A triangle of a mid-complex.
    TriangleId,
    /// An element of a shell mesh.
    ElementId,
    /// A sheet: a two-manifold piece of the mid-surface.
    SheetId,
    /// A patch: a piece of a sheet that is meshed in one chart.
    PatchId,
    /// A place that a node of a mid-complex was given.
    PinId,
}

/// A vector that only its own id type can index.
#[derive(Clone, PartialEq, Eq)]
pub struct IndexVec<I, T> {
    items: Vec<T>,
    ids: PhantomData<fn(I)>,
}

impl<I: Id, T> IndexVec<I, T> {
    /// An empty vector.
    pub fn new() -> Self {
        Self::from(Vec::new())
    }
    /// `count` copies of `item`.
    pub fn filled(item: T, count: usize) -> Self
    where
        T: Clone,
    {
        Self::from(vec![item; count])
    }
    /// How many entities there are.
    #[inline]
    pub fn len(&self) -> usize {
        self.items.len()
    }
    /// Whether there is no entity.
    pub fn is_empty(&self) -> bool {
        self.items.is_empty()
    }
    /// Appends an entity and returns its id.
    pub fn push(&mut self, item: T) -> I {
        self.items.push(item);
        I::new(self.items.len() - 1)
    }
    /// The entity with this id, if there is one.
    pub fn get(&self, id: I) -> Option<&T> {
        self.items.get(id.index())
    }
    /// All ids in order.
    pub fn ids(
        &self,
    ) -> impl ExactSizeIterator<Item = I> + DoubleEndedIterator + Clone + use<I, T> {
        (0..self.items.len()).map(I::new)
    }
    /// All entities in order of their ids.
    pub fn iter(&self) -> std::slice::Iter<'_, T> {
        self.items.iter()
    }
    /// All entities in order of their ids, mutable.
    pub fn iter_mut(&mut self) -> std::slice::IterMut<'_, T> {
        self.items.iter_mut()
    }
    /// Pairs of id and entity in order.
    pub fn enumerated(
        &self,
    ) -> impl ExactSizeIterator<Item = (I, &T)> + DoubleEndedIterator + Clone {
        self.items.iter().enumerate().map(|(i, t)| (I::new(i), t))
    }
    /// The entities as a slice, in order of their ids.
    pub fn as_slice(&self) -> &[T] {
        &self.items
    }
    /// The entities as a mutable slice, in order of their ids.
    pub fn as_mut_slice(&mut self) -> &mut [T] {
        &mut self.items
    }
    /// The entities as a plain vector.
    pub fn into_vec(self) -> Vec<T> {
        self.items
    }
}

impl<I: Id, T> Default for IndexVec<I, T> {
    fn default() -> Self {
        Self::new()
    }
}

impl<I, T> From<Vec<T>> for IndexVec<I, T> {
    fn from(items: Vec<T>) -> Self {
        Self {
            items,
            ids: PhantomData,
        }
    }
}

impl<I: Id, T> FromIterator<T> for IndexVec<I, T> {
    fn from_iter<It: IntoIterator<Item = T>>(iter: It) -> Self {
        Self::from(iter.into_iter().collect::<Vec<T>>())
    }
}

impl<I: Id, T> Index<I> for IndexVec<I, T> {
    type Output = T;
    #[inline]
    fn index(&self, id: I) -> &T {
        &self.items[id.index()]
    }
}

impl<I: Id, T> IndexMut<I> for IndexVec<I, T> {
    #[inline]
    fn index_mut(&mut self, id: I) -> &mut T {
        &mut self.items[id.index()]
    }
}

impl<'a, I: Id, T> IntoIterator for &'a IndexVec<I, T> {
    type Item = &'a T;
    type IntoIter = std::slice::Iter<'a, T>;
    fn into_iter(self) -> Self::IntoIter {
        self.items.iter()
    }
}

impl<I, T: fmt::Debug> fmt::Debug for IndexVec<I, T> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.items.fmt(f)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn push_returns_the_id_that_finds_the_item_again() {
        let mut faces: IndexVec<FaceId, &str> = IndexVec::new();
        let top = faces.push("top");
        let bottom = faces.push("bottom");
        assert_eq!((faces[top], faces[bottom]), ("top", "bottom"));
        assert_eq!(faces.ids().collect::<Vec<_>>(), vec![FaceId(0), FaceId(1)]);
    }
}
