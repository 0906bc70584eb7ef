//! A fragment of the pipeline: every patch of a complex is meshed anew in a chart of its own.
//!
//! [`patches`], [`flatten`] and
//! [`triangulate`] in turn, patch by patch in parallel; a patch without a good chart or mesh is
//! [`cut`] and tried again. A cut leaves its old edges in the mesh; a second round cuts the new mesh elsewhere
//! and so takes the traces of the first cuts away.
//!
//! **Guarantees.** Nodes and edges on rims, junctions, creases and folds stay; Euler characteristic and pieces stay; the same bytes for any
//! number of threads. What cannot be improved keeps its old triangles and is listed.
//! **Limits.** Boundary nodes are taken as they are: where they are spaced badly, so are the triangles beside them.

use crate::geom::placer::{LengthField, Placer};
use crate::model::complex::{MidComplex, MidNode, MidTriangle, Support};
use crate::model::ids::{Id, IndexVec, NodeId, PatchId, TriangleId};
use crate::model::patch::{Patch, PatchMesh};
use crate::stage::chart_mesh::{Layout, triangulate};
use crate::stage::flatten::flatten;
use crate::stage::patch::{cut, patches};
use rayon::prelude::*;

/// Pieces of fewer triangles are not cut further: there is nothing to gain inside them.
const SMALLEST: usize = 12;

/// A complex meshed anew.
#[derive(Clone, Debug, PartialEq)]
#[must_use]
pub struct Outcome {
    /// The new complex: old nodes that stay, in their order, then new ones, patch by patch.
    pub complex: MidComplex,
    /// For every old node its new id, if it stays.
    pub nodes: IndexVec<NodeId, Option<NodeId>>,
    /// How many pieces were meshed or kept in the end.
    pub patches: usize,
    /// How many cuts were made to get them.
    pub cut: usize,
    /// Pieces (counted in order) that keep old triangles, because no chart or mesh of them was good.
    pub kept: Vec<PatchId>,
}

/// Meshes every patch at the wanted edge lengths; triangles are as long everywhere as these are across.
pub fn mesh_charts(
    complex: &MidComplex,
    layout: impl Into<Layout>,
    lengths: &LengthField,
    placer: &dyn Placer,
) -> Outcome {
    let how = How {
        layout: layout.into(),
        lengths,
        placer,
    };
    let old = vec![true; complex.triangles.len()];
    let first = round(complex, None, &old, &how);
    if first.traces.is_empty() {
        return first.outcome(None);
    }
    let second = round(&first.complex, Some(&first.traces), &first.old, &how);
    second.outcome(Some(first))
}

/// What every patch is meshed with.
struct How<'a> {
    layout: Layout,
    lengths: &'a LengthField<'a>,
    placer: &'a dyn Placer,
}

/// What one round over all patches gives.
struct Round {
    complex: MidComplex,
    nodes: IndexVec<NodeId, Option<NodeId>>,
    /// Nodes on cuts, sorted.
    traces: Vec<NodeId>,
    /// Which triangles are still those of the input.
    old: Vec<bool>,
    patches: usize,
    cut: usize,
    kept: Vec<PatchId>,
}

impl Round {
    fn outcome(self, before: Option<Round>) -> Outcome {
        let nodes = match before {
            None => self.nodes,
            Some(first) => (first.nodes.iter())
                .map(|n| n.and_then(|n| self.nodes[n]))
                .collect(),
        };
        Outcome {
            complex: self.complex,
            nodes,
            patches: self.patches,
            cut: self.cut,
            kept: self.kept,
        }
    }
}

/// A patch or a part of one, with its new triangles if there are good ones.
struct Piece {
    patch: Patch,
    mesh: Option<PatchMesh>,
}

/// One round; with `avoid` only patches that hold such nodes are meshed, and cut away from them.
fn round(complex: &MidComplex, avoid: Option<&[NodeId]>, old: &[bool], how: &How) -> Round {
    let all = patches(complex);
    let results: Vec<(Vec<Piece>, Vec<NodeId>)> = (all.as_slice().par_iter())
        .map(|patch| {
            let concerned = avoid.is_none_or(|avoid| {
                let on = |n: &NodeId| avoid.binary_search(n).is_ok();
                patch.nodes.iter().any(on)
            });
            if !concerned || !patch.check().is_empty() {
                let patch = patch.clone();
                return (vec![Piece { patch, mesh: None }], Vec::new());
            }
            let pieces = mesh_or_cut(patch, avoid.unwrap_or(&[]), how);
            let traces = traces(patch, &pieces);
            (pieces, traces)
        })
        .collect();
    let whole = results.len();
    let (mut pieces, mut traces) = (Vec::new(), Vec::new());
    for (p, t) in results {
        pieces.extend(p);
        traces.extend(t);
    }
    drop_clashes(&mut pieces);
    let kept = (pieces.iter().enumerate())
        .filter(|(_, p)| p.mesh.is_none() && p.patch.source.iter().any(|t| old[t.index()]))
        .map(|(i, _)| PatchId::new(i))
        .collect();
    let joined = join(complex, &pieces);
    let mut traces: Vec<NodeId> = traces.iter().filter_map(|n| joined.nodes[*n]).collect();
    traces.sort_unstable();
    traces.dedup();
    Round {
        complex: joined.complex,
        nodes: joined.nodes,
        traces,
        old: (joined.source.iter())
            .map(|source| source.is_some_and(|t| old[t.index()]))
            .collect(),
        patches: pieces.len(),
        cut: pieces.len() - whole,
        kept,
    }
}

/// Meshes a patch, or cuts it and meshes the parts.
fn mesh_or_cut(patch: &Patch, avoid: &[NodeId], how: &How) -> Vec<Piece> {
    let mesh = flatten(patch)
        .ok()
        .and_then(|chart| triangulate(patch, &chart, how.layout, how.lengths, how.placer).ok());
    if mesh.is_some() || patch.triangles.len() < SMALLEST {
        let patch = patch.clone();
        return vec![Piece { patch, mesh }];
    }
    let parts = cut(patch, avoid);
    if parts.len() < 2 {
        return (parts.into_iter())
            .map(|patch| Piece { patch, mesh: None })
            .collect();
    }
    parts
        .par_iter()
        .map(|part| mesh_or_cut(part, avoid, how))
        .collect::<Vec<_>>()
        .into_iter()
        .flatten()
        .collect()
}

/// Nodes inside a patch that lie on the boundary of its pieces.
fn traces(patch: &Patch, pieces: &[Piece]) -> Vec<NodeId> {
    let boundary = |p: &Patch| -> Vec<NodeId> {
        let mut nodes: Vec<NodeId> = p.boundary().map(|e| p.nodes[e[0] as usize]).collect();
        nodes.sort_unstable();
        nodes.dedup();
        nodes
    };
    let mut fixed = boundary(patch);
    fixed.extend(patch.kept_corners.iter().map(|&c| patch.nodes[c as usize]));
    fixed.sort_unstable();
    (pieces.iter())
        .flat_map(|p| boundary(&p.patch))
        .filter(|n| fixed.binary_search(n).is_err())
        .collect()
}

/// Takes meshes away whose inner edges join two old nodes that are joined elsewhere too: two such edges would become one.
fn drop_clashes(pieces: &mut [Piece]) {
    loop {
        // A pinched or cut patch has two corners for one node, so that even two edges of one piece may be the same.
        let mut edges: Vec<([NodeId; 2], u32, [u32; 2], bool)> = Vec::new();
        for (i, piece) in pieces.iter().enumerate() {
            let named = named_edges(piece).into_iter();
            edges.extend(named.map(|(e, corners, inner)| (e, i as u32, corners, inner)));
        }
        edges.sort_unstable();
        edges.dedup();
        let mut changed = false;
        for run in edges.chunk_by(|a, b| a.0 == b.0) {
            if run.len() < 2 || run.iter().all(|e| !e.3) {
                continue;
            }
            for (_, i, ..) in run.iter().filter(|e| e.3) {
                changed |= pieces[*i as usize].mesh.take().is_some();
            }
        }
        if !changed {
            return;
        }
    }
}

/// Edges of a piece between nodes of the old complex, with their corners in the patch, and whether they lie inside it.
fn named_edges(piece: &Piece) -> Vec<([NodeId; 2], [u32; 2], bool)> {
    let patch = &piece.patch;
    let named = |a: u32, b: u32| {
        let (a, b) = (patch.nodes.get(a as usize)?, patch.nodes.get(b as usize)?);
        Some([*a.min(b), *a.max(b)])
    };
    // By corners, not by nodes: an edge inside may have the nodes of one on the boundary, and that is the clash looked for.
    let mut fixed: Vec<[u32; 2]> = (patch.boundary())
        .chain(patch.kept_edges.iter().copied())
        .map(|[a, b]| [a.min(b), a.max(b)])
        .collect();
    fixed.sort_unstable();
    let triangles = match &piece.mesh {
        Some(mesh) => &mesh.triangles,
        None => &patch.triangles,
    };
    (triangles.iter())
        .flat_map(|t| (0..3).map(|k| (t[k], t[(k + 1) % 3])))
        .filter_map(|(a, b)| named(a, b).map(|e| (e, [a.min(b), a.max(b)])))
        .map(|(e, corners)| (e, corners, fixed.binary_search(&corners).is_err()))
        .collect()
}

/// Pieces put together.
struct Joined {
    complex: MidComplex,
    /// For every old node its new id.
    nodes: IndexVec<NodeId, Option<NodeId>>,
    /// For every triangle the old one that it is, if it is one.
    source: Vec<Option<TriangleId>>,
}

/// The pieces as one complex.
fn join(complex: &MidComplex, pieces: &[Piece]) -> Joined {
    let mut used = IndexVec::<NodeId, bool>::filled(false, complex.nodes.len());
    for piece in pieces {
        let triangles = match &piece.mesh {
            Some(mesh) => &mesh.triangles,
            None => &piece.patch.triangles,
        };
        for c in triangles.iter().flatten() {
            if let Some(n) = piece.patch.nodes.get(*c as usize) {
                used[*n] = true;
            }
        }
    }
    let mut new = MidComplex::default();
    let nodes: IndexVec<NodeId, Option<NodeId>> = (complex.nodes.enumerated())
        .map(|(id, node)| used[id].then(|| new.nodes.push(node.clone())))
        .collect();
    let mut source = Vec::new();
    for piece in pieces {
        let (patch, first) = (&piece.patch, new.nodes.len());
        let wall = patch.wall;
        let id = |c: u32| match patch.nodes.get(c as usize) {
            Some(n) => nodes[*n].unwrap_or(NodeId(u32::MAX)),
            None => NodeId::new(first + c as usize - patch.nodes.len()),
        };
        let triangles = match &piece.mesh {
            Some(mesh) => {
                source.extend(mesh.triangles.iter().map(|_| None));
                for &point in &mesh.points {
                    new.nodes.push(MidNode {
                        point,
                        supports: [Support::Mid(wall)].into_iter().collect(),
                    });
                }
                &mesh.triangles
            }
            None => {
                source.extend(patch.source.iter().map(|t| Some(*t)));
                &patch.triangles
            }
        };
        for t in triangles {
            new.triangles.push(MidTriangle {
                nodes: t.map(id),
                wall,
            });
        }
    }
    Joined {
        complex: new,
        nodes,
        source,
    }
}

#[cfg(test)]
mod tests;
