//! How many triangles a size field makes: an estimate on the solid's own facets, before anything is meshed.
//!
//! Half of the skin of the walls stands for the mid-surface. Sizes grow away from short ones as in the mesh, so that the rows beside a bend count too.
//! Limits: growth is followed along the edges of the facets, which may be longer than the sizes; the count is then right within a third.

use crate::model::brep::Brep;
use crate::model::ids::{FaceId, FacetId, IndexVec, VertexId, WallId};
use crate::model::walls::Pairing;
use glam::DVec3;
use rayon::prelude::*;
use std::cmp::Reverse;
use std::collections::BinaryHeap;

/// A facet on a side of a wall.
struct Piece {
    corners: [VertexId; 3],
    /// mm².
    area: f64,
    /// Radius of the wall there, mm.
    radius: f64,
    /// Thickness of the wall, mm.
    thickness: f64,
}

/// The skin of the walls, ready to be counted with any size.
pub(super) struct Count {
    pieces: Vec<Piece>,
    /// For every vertex the vertices next to it, and how far they are.
    near: IndexVec<VertexId, Vec<(VertexId, f64)>>,
}

impl Count {
    /// `radius(point, wall)`: how the wall is bent, mm.
    pub fn new(
        brep: &Brep,
        pairing: &Pairing,
        radius: &(dyn Fn(DVec3, WallId) -> f64 + Sync),
    ) -> Self {
        // A face of several walls counts once: its walls are about as thick and bent there.
        let mut wall_of: IndexVec<FaceId, Option<WallId>> =
            IndexVec::filled(None, brep.faces.len());
        for (id, wall) in pairing.walls.enumerated() {
            for &face in wall.sides.iter().flatten() {
                wall_of[face].get_or_insert(id);
            }
        }
        let ids: Vec<FacetId> = brep.facets.ids().collect();
        let pieces: Vec<Piece> = ids
            .into_par_iter()
            .filter_map(|id| {
                let facet = &brep.facets[id];
                let wall = wall_of[facet.face]?;
                let [a, b, c] = brep.corners(id);
                Some(Piece {
                    corners: facet.corners,
                    area: brep.area_vector(id).length(),
                    radius: radius((a + b + c) / 3.0, wall),
                    thickness: pairing.walls[wall].thickness,
                })
            })
            .collect();
        let mut near: IndexVec<VertexId, Vec<(VertexId, f64)>> =
            IndexVec::filled(Vec::new(), brep.vertices.len());
        for piece in &pieces {
            for k in 0..3 {
                let (a, b) = (piece.corners[k], piece.corners[(k + 1) % 3]);
                let length = brep.vertices[a].distance(brep.vertices[b]);
                near[a].push((b, length));
                near[b].push((a, length));
            }
        }
        Self { pieces, near }
    }

    /// How many triangles there will be where the edge length wanted is `size(radius, thickness)`, mm, and grows away from short ones by `growth`, length per length.
    pub fn triangles(&self, growth: f64, size: impl Fn(f64, f64) -> f64) -> f64 {
        let mut sizes = IndexVec::<VertexId, f64>::filled(f64::INFINITY, self.near.len());
        for piece in &self.pieces {
            let wanted = size(piece.radius, piece.thickness);
            for v in piece.corners {
                sizes[v] = sizes[v].min(wanted);
            }
        }
        self.grade(growth, &mut sizes);
        (self.pieces.iter())
            .map(|piece| {
                let mean = piece.corners.iter().map(|&v| sizes[v]).sum::<f64>() / 3.0;
                // Two sides of the skin to one mid-surface.
                piece.area / 2.0 / (mean * mean * 3f64.sqrt() / 4.0)
            })
            .sum()
    }

    /// Lowers sizes until none exceeds a neighbour's by more than the growth (Dijkstra).
    fn grade(&self, growth: f64, sizes: &mut IndexVec<VertexId, f64>) {
        // Sizes are positive, so that their bits have their order.
        let mut heap: BinaryHeap<Reverse<(u64, VertexId)>> = (sizes.enumerated())
            .filter(|(_, s)| s.is_finite())
            .map(|(v, s)| Reverse((s.to_bits(), v)))
            .collect();
        while let Some(Reverse((bits, v))) = heap.pop() {
            if bits != sizes[v].to_bits() {
                continue;
            }
            for &(w, length) in &self.near[v] {
                let most = sizes[v] + growth * length;
                if most < sizes[w] {
                    sizes[w] = most;
                    heap.push(Reverse((most.to_bits(), w)));
                }
            }
        }
    }
}
