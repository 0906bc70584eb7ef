//! Edges and triangles of a tetrahedral mesh, by id: what the dual complex is read from.

use super::ids::{IndexVec, TetEdgeId, TetFaceId, TetId, VertexId};
use super::tets::Tets;
use rayon::prelude::*;

/// The local corner pairs of a tet's six edges.
pub const TET_EDGES: [(usize, usize); 6] = [(0, 1), (0, 2), (0, 3), (1, 2), (1, 3), (2, 3)];
/// The local corners of a tet's four triangles; triangle `i` lies opposite corner `3 - i`.
pub const TET_FACES: [[usize; 3]; 4] = [[0, 1, 2], [0, 1, 3], [0, 2, 3], [1, 2, 3]];
/// The local edges (into [`TET_EDGES`]) of each of a tet's four triangles.
pub const TET_FACE_EDGES: [[usize; 3]; 4] = [[0, 1, 3], [0, 2, 4], [1, 2, 5], [3, 4, 5]];

/// Incidences of a tetrahedral mesh. Ids are in the order of sorted vertex ids, hence the same whatever the number of threads.
#[derive(Clone, Debug, Default)]
pub struct TetGraph {
    /// Ends of each edge, the lower id first.
    pub edges: IndexVec<TetEdgeId, [VertexId; 2]>,
    /// Corners of each triangle, ascending.
    pub faces: IndexVec<TetFaceId, [VertexId; 3]>,
    /// The three edges of each triangle.
    pub face_edges: IndexVec<TetFaceId, [TetEdgeId; 3]>,
    /// The one or two tets at each triangle; the second repeats the first on the boundary.
    pub face_tets: IndexVec<TetFaceId, [TetId; 2]>,
    /// The six edges of each tet, in the order of [`TET_EDGES`].
    pub tet_edges: IndexVec<TetId, [TetEdgeId; 6]>,
    /// The four triangles of each tet, in the order of [`TET_FACES`].
    pub tet_faces: IndexVec<TetId, [TetFaceId; 4]>,
}

impl TetGraph {
    /// Reads the incidences of `tets`. Cost: two parallel sorts, of six and four keys a tet.
    pub fn new(tets: &Tets) -> Self {
        let cells = tets.cells.as_slice();
        let mut edge_keys: Vec<(u64, u32)> = cells
            .par_iter()
            .enumerate()
            .flat_map_iter(|(t, c)| {
                TET_EDGES.iter().enumerate().map(move |(k, &(i, j))| {
                    let (a, b) = (c[i].0.min(c[j].0), c[i].0.max(c[j].0));
                    ((u64::from(a) << 32) | u64::from(b), (t * 6 + k) as u32)
                })
            })
            .collect();
        edge_keys.par_sort_unstable();
        let mut edges = IndexVec::new();
        let mut tet_edges = IndexVec::filled([TetEdgeId(0); 6], cells.len());
        for run in edge_keys.chunk_by(|a, b| a.0 == b.0) {
            let id = edges.push([VertexId((run[0].0 >> 32) as u32), VertexId(run[0].0 as u32)]);
            for &(_, slot) in run {
                tet_edges[TetId(slot / 6)][slot as usize % 6] = id;
            }
        }
        drop(edge_keys);

        let mut face_keys: Vec<([u32; 3], u32)> = cells
            .par_iter()
            .enumerate()
            .flat_map_iter(|(t, c)| {
                TET_FACES.iter().enumerate().map(move |(k, f)| {
                    let mut key = f.map(|i| c[i].0);
                    key.sort_unstable();
                    (key, (t * 4 + k) as u32)
                })
            })
            .collect();
        face_keys.par_sort_unstable();
        let mut graph = TetGraph {
            edges,
            tet_edges,
            tet_faces: IndexVec::filled([TetFaceId(0); 4], cells.len()),
            ..TetGraph::default()
        };
        for run in face_keys.chunk_by(|a, b| a.0 == b.0) {
            let id = graph.faces.push(run[0].0.map(VertexId));
            let first = run[0].1;
            let owner = TetId(first / 4);
            graph
                .face_edges
                .push(TET_FACE_EDGES[first as usize % 4].map(|k| graph.tet_edges[owner][k]));
            let other = run.get(1).map_or(owner, |r| TetId(r.1 / 4));
            graph.face_tets.push([owner, other]);
            for &(_, slot) in run {
                graph.tet_faces[TetId(slot / 4)][slot as usize % 4] = id;
            }
        }
        graph
    }

    /// Whether a triangle lies on the boundary.
    #[inline]
    pub fn on_boundary(&self, face: TetFaceId) -> bool {
        let [a, b] = self.face_tets[face];
        a == b
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn two_tets_share_one_triangle() {
        let v = |i| VertexId(i);
        let tets = Tets {
            cells: vec![[v(0), v(1), v(2), v(3)], [v(1), v(0), v(2), v(4)]].into(),
        };
        let graph = TetGraph::new(&tets);
        assert_eq!((graph.edges.len(), graph.faces.len()), (9, 7));
        let inner: Vec<_> = graph
            .faces
            .ids()
            .filter(|&f| !graph.on_boundary(f))
            .collect();
        assert_eq!(inner.len(), 1);
        assert_eq!(graph.faces[inner[0]], [v(0), v(1), v(2)]);
        for f in graph.faces.ids() {
            let mut ends: Vec<_> = graph.face_edges[f]
                .iter()
                .flat_map(|&e| graph.edges[e])
                .collect();
            ends.sort_unstable();
            ends.dedup();
            assert_eq!(
                ends,
                graph.faces[f].to_vec(),
                "edges of a triangle have its corners"
            );
        }
    }
}
