//! Contracts the triangles that lie the wrong way round.
//!
//! What smoothing cannot turn is a knot: more nodes than the place has room for. Each of its triangles loses its shortest edge that topology and features can spare.
//!
//! Guarantee: homotopy type and feature curves stay (the link condition of `contract`, features judged as they are now), and sheets hang together by edges as before.

use super::dust::keeps_together;
use super::surface::{Surface, key};
use crate::geom::orient::{folded, turned};
use crate::geom::placer::Placer;
use crate::model::complex::{EdgeKind, MidComplex, ends};
use crate::model::ids::{IndexVec, NodeId, TriangleId};

/// Contracts an edge of every triangle whose normal is turned from its wall's, in a complex whose sheets are wound one way.
pub fn contract_turned(complex: MidComplex, placer: &dyn Placer) -> MidComplex {
    let all: Vec<TriangleId> = complex.triangles.ids().collect();
    let turned = turned(&complex, &all, placer);
    contract(complex, turned)
}

/// The same for those that are folded over as well: in a finished mesh, whose triangles are of one size with their neighbours.
pub fn contract_folded(complex: MidComplex, placer: &dyn Placer) -> MidComplex {
    let all: Vec<TriangleId> = complex.triangles.ids().collect();
    let mut wrong = turned(&complex, &all, placer);
    wrong.extend(folded(&complex));
    wrong.sort_unstable();
    wrong.dedup();
    contract(complex, wrong)
}

fn contract(complex: MidComplex, wrong: Vec<TriangleId>) -> MidComplex {
    let fixed = fixed(&complex);
    let mut surface = Surface::new(complex);
    for t in wrong {
        if surface.lives(t)
            && let Some((gone, kept)) = best(&surface, &fixed, t)
        {
            surface.contract(gone, kept);
        }
    }
    surface.finish()
}

/// Ends and forks of feature curves, and corners of rims.
fn fixed(complex: &MidComplex) -> IndexVec<NodeId, bool> {
    let mut degree = IndexVec::<NodeId, u32>::filled(0, complex.nodes.len());
    for edge in complex
        .edges()
        .iter()
        .filter(|e| complex.kind(e) != EdgeKind::Inner)
    {
        for n in edge.ends {
            degree[n] += 1;
        }
    }
    complex
        .nodes
        .enumerated()
        .map(|(n, node)| !matches!(degree[n], 0 | 2) || ends(&node.supports).count() > 1)
        .collect()
}

/// The shortest edge of the triangle that may go, as (gone, kept).
fn best(
    surface: &Surface,
    fixed: &IndexVec<NodeId, bool>,
    t: TriangleId,
) -> Option<(NodeId, NodeId)> {
    let nodes = surface.triangle(t).nodes;
    let mut edges: Vec<(u64, NodeId, NodeId)> = (0..3)
        .flat_map(|k| {
            let (a, b) = (nodes[k], nodes[(k + 1) % 3]);
            let length = key(surface.length(a, b));
            [(length, a, b), (length, b, a)]
        })
        .collect();
    edges.sort_unstable();
    edges
        .into_iter()
        .map(|(_, gone, kept)| (gone, kept))
        .find(|&(gone, kept)| may_go(surface, fixed, gone, kept))
}

fn may_go(surface: &Surface, fixed: &IndexVec<NodeId, bool>, gone: NodeId, kept: NodeId) -> bool {
    let near = surface.feature_neighbours(gone);
    let strata = near.is_empty()
        || !fixed[gone]
            && near.contains(&kept)
            && !surface
                .feature_neighbours(kept)
                .iter()
                .any(|n| near.contains(n));
    strata && keeps_together(surface, gone, kept)
}
