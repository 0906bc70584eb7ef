//! Decompose: labels on the vertices of the filling, and which of its edges run through a wall (ARCHITECTURE, "Choices").
//!
//! A vertex carries the wall faces it lies on; on a blend, those that the blend joins; elsewhere the nearest wall face. An edge runs through
//! a wall where its ends carry opposing labels, unless it leaves both sides outwards: then it crosses the gap between two layers of one wall (the turns of a thread), in
//! what both stand on. Cost: one nearest-point query a vertex without label; the rest linear in the edges.

use crate::model::brep::Brep;
use crate::model::decomposition::{Decomposition, FaceRoles, Labels, Passage};
use crate::model::disjoint::Disjoint;
use crate::model::ids::{FaceId, Id, IndexVec, VertexId};
use crate::model::tet_graph::TetGraph;
use crate::model::walls::Pairing;
use crate::spatial::TriangleBvh;
use glam::DVec3;
use rayon::prelude::*;
use smallvec::SmallVec;

/// Sine above the face from which an edge leads outwards: far more than the sag of facets, far less than from one flank to another.
const OUTWARD: f64 = 0.2;

/// Labels every vertex and grades every edge.
pub fn decompose(
    brep: &Brep,
    graph: &TetGraph,
    pairing: &Pairing,
    roles: &FaceRoles,
) -> Decomposition {
    let labels = labels(brep, pairing, roles);
    let class = classes(&labels, brep.faces.len());
    let outward = Outward::new(brep);
    let across_gap = |[u, v]: [VertexId; 2], [a, b]: [FaceId; 2]| {
        let way = brep.vertices[v] - brep.vertices[u];
        outward.leaves(u, a, way) && outward.leaves(v, b, -way)
    };
    let passage = graph
        .edges
        .as_slice()
        .par_iter()
        .map(|&[u, v]| {
            let (a, b) = (&labels[u], &labels[v]);
            let through =
                |x: FaceId, y: FaceId| pairing.opposing(x, y) && !across_gap([u, v], [x, y]);
            if a.iter().any(|&x| b.iter().any(|&y| through(x, y))) {
                Passage::Through
            } else if a.iter().any(|&x| b.iter().any(|&y| class[x] == class[y])) {
                Passage::Along
            } else {
                Passage::Apart
            }
        })
        .collect::<Vec<_>>()
        .into();
    Decomposition { labels, passage }
}

fn labels(brep: &Brep, pairing: &Pairing, roles: &FaceRoles) -> IndexVec<VertexId, Labels> {
    let mut labels: IndexVec<VertexId, Labels> =
        IndexVec::filled(Labels::new(), brep.vertices.len());
    for facet in &brep.facets {
        for v in facet.corners {
            labels[v].extend_from_slice(&roles.carries[facet.face]);
        }
    }
    let (mut walls, mut owner): (Vec<[DVec3; 3]>, Vec<FaceId>) = (Vec::new(), Vec::new());
    for (id, facet) in brep.facets.enumerated() {
        if pairing.side[facet.face].is_some() {
            walls.push(brep.corners(id));
            owner.push(facet.face);
        }
    }
    let bvh = TriangleBvh::new(&walls);
    let points = &brep.vertices;
    labels
        .as_mut_slice()
        .par_iter_mut()
        .enumerate()
        .for_each(|(i, l)| {
            l.sort_unstable();
            l.dedup();
            if l.is_empty()
                && let Some(near) = bvh.nearest(points[VertexId::new(i)])
            {
                l.push(owner[near.index]);
            }
        });
    labels
}

/// The normals of faces at their vertices.
struct Outward {
    /// #V each face there with the sum of its facets' areas along their normals.
    normals: IndexVec<VertexId, SmallVec<[(FaceId, DVec3); 2]>>,
}

impl Outward {
    fn new(brep: &Brep) -> Self {
        let mut normals: IndexVec<VertexId, SmallVec<[(FaceId, DVec3); 2]>> =
            IndexVec::filled(SmallVec::new(), brep.vertices.len());
        for (id, facet) in brep.facets.enumerated() {
            let [p, q, r] = brep.corners(id);
            let area = (q - p).cross(r - p);
            for v in facet.corners {
                let there = &mut normals[v];
                match there.iter_mut().find(|n| n.0 == facet.face) {
                    Some(sum) => sum.1 += area,
                    None => there.push((facet.face, area)),
                }
            }
        }
        Self { normals }
    }

    /// Whether this way leads out of the face at a vertex on it. Vertices that only carry a face's label say nothing.
    fn leaves(&self, vertex: VertexId, face: FaceId, way: DVec3) -> bool {
        let there = self.normals[vertex].iter().find(|n| n.0 == face);
        there.is_some_and(|(_, n)| n.dot(way) > OUTWARD * n.length() * way.length())
    }
}

/// Wall faces that some vertex carries together belong to one side of the material.
fn classes(labels: &IndexVec<VertexId, Labels>, faces: usize) -> IndexVec<FaceId, u32> {
    let mut sets = Disjoint::new(faces);
    for l in labels {
        for pair in l.windows(2) {
            sets.join(pair[0].0, pair[1].0);
        }
    }
    (0..faces as u32).map(|f| sets.find(f)).collect()
}

#[cfg(test)]
mod tests;
