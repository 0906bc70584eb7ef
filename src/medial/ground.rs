//! What mid-surfaces need of a solid whichever of its faces are paired; made once and shared.

use super::edges::Edges;
use super::void::Material;
use crate::geom::bend::{Bend, bend};
use crate::geom::six_node::{self, ReadyFacet};
use crate::model::brep::Brep;
use crate::model::ids::{FaceId, FacetId, IndexVec, VertexId};

/// What does not depend on which faces are paired: pairings of one solid share it.
#[derive(Debug)]
pub(super) struct Ground {
    pub(super) material: Material,
    pub(super) edges: Edges,
    /// The facets of each face.
    pub(super) of_face: IndexVec<FaceId, Vec<FacetId>>,
    pub(super) facets: IndexVec<FacetId, ReadyFacet>,
    /// The bent ones among the facets that touch each facet.
    pub(super) bent: IndexVec<FacetId, Vec<FacetId>>,
    /// Normal curvature of each facet, 1/mm, estimated from its corner normals: the largest, above zero where the face bulges and below where it is hollow.
    pub(super) curvature: IndexVec<FacetId, f64>,
    /// The principal curvatures of each facet, from the same normals.
    pub(super) bends: IndexVec<FacetId, Bend>,
}

/// Normals of a flat facet differ by rounding, which is far less than this, rad; a bend of that little is none.
const NO_TURN: f64 = 1e-9;

impl Ground {
    pub(super) fn new(brep: &Brep) -> Self {
        let mut of_face: IndexVec<FaceId, Vec<FacetId>> =
            IndexVec::filled(Vec::new(), brep.faces.len());
        for (id, f) in brep.facets.enumerated() {
            of_face[f.face].push(id);
        }
        let corners = |id: FacetId| {
            let (p, mids) = (brep.corners(id), &brep.facets[id].mids);
            let n =
                [(0.0, 0.0), (1.0, 0.0), (0.0, 1.0)].map(|(u, v)| six_node::normal(&p, mids, u, v));
            (p, n)
        };
        let bends = (brep.facets.ids())
            .map(|id| {
                let (p, n) = corners(id);
                bend(p, n)
            })
            .collect();
        let curvature = (brep.facets.ids())
            .map(|id| {
                let (p, n) = corners(id);
                (0..3)
                    .map(|k| {
                        let (turn, side) = (n[k] - n[(k + 1) % 3], p[k] - p[(k + 1) % 3]);
                        let bend = if turn.length() > NO_TURN {
                            turn.length() / side.length()
                        } else {
                            0.0
                        };
                        bend.copysign(turn.dot(side))
                    })
                    .fold(0.0, |a: f64, b| if b.abs() > a.abs() { b } else { a })
            })
            .collect();
        let facets: IndexVec<FacetId, ReadyFacet> = brep
            .facets
            .enumerated()
            .map(|(id, f)| ReadyFacet::new(brep.corners(id), f.mids))
            .collect();
        Self {
            material: Material::new(brep),
            edges: Edges::new(brep),
            of_face,
            bent: bent_neighbours(brep, &facets),
            facets,
            curvature,
            bends,
        }
    }
}

/// The bent facets that share a corner with each facet, each once.
fn bent_neighbours(
    brep: &Brep,
    facets: &IndexVec<FacetId, ReadyFacet>,
) -> IndexVec<FacetId, Vec<FacetId>> {
    let mut at: IndexVec<VertexId, Vec<FacetId>> =
        IndexVec::filled(Vec::new(), brep.vertices.len());
    for (id, f) in brep.facets.enumerated() {
        if facets[id].sag() > 0.0 {
            for v in f.corners {
                at[v].push(id);
            }
        }
    }
    brep.facets
        .enumerated()
        .map(|(id, f)| {
            let mut near: Vec<FacetId> = Vec::new();
            for &other in f.corners.iter().flat_map(|&v| &at[v]) {
                if other != id && !near.contains(&other) {
                    near.push(other);
                }
            }
            near
        })
        .collect()
}
