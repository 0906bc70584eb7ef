//! Patches: a mid-complex comes apart into pieces that one chart can hold.
//!
//! **In** a clean complex. **Out** patches in order of their lowest triangle, and together every triangle once.
//!
//! A patch is a set of triangles of one wall that hang together over edges of two triangles. A feature curve both sides of which lie in
//! the patch (a rib that ends in the middle of a plate) does not cut it: its edges are kept edges inside the patch; so are folds
//! sharper than [`fold::FOLD_RAD`]. A one-sided strip is cut open where its sides meet the wrong way round.
//!
//! **Guarantees.** Each patch is connected, orientable and two-manifold with its boundary in loops; [`Patch::check`] is empty.
//! **Limits.** It may be closed, a tube or have handles: [`cut`] takes it apart further.
//! **Cost.** O(n log n) for the edges.

mod assemble;
mod cut;

pub use cut::cut;

use crate::geom::fold;
use crate::model::complex::{EdgeKind, MidComplex, Support};
use crate::model::disjoint::Disjoint;
use crate::model::ids::{Id, NodeId, PatchId};
use crate::model::ids::{IndexVec, TriangleId};
use crate::model::patch::Patch;
use assemble::{Link, Links, Soup};

/// The patches of a complex.
pub fn patches(complex: &MidComplex) -> IndexVec<PatchId, Patch> {
    let links = links(complex);
    let mut piece = vec![u32::MAX; complex.triangles.len()];
    let mut members: Vec<Vec<u32>> = Vec::new();
    let mut stack = Vec::new();
    for start in 0..piece.len() {
        if piece[start] != u32::MAX {
            continue;
        }
        let id = members.len() as u32;
        piece[start] = id;
        stack.push(start as u32);
        let mut list = Vec::new();
        while let Some(t) = stack.pop() {
            list.push(t);
            for link in links[t as usize].iter().flatten() {
                if piece[link.triangle as usize] == u32::MAX {
                    piece[link.triangle as usize] = id;
                    stack.push(link.triangle);
                }
            }
        }
        list.sort_unstable();
        members.push(list);
    }

    let foreign = feature_nodes(complex, &piece);
    members
        .iter()
        .map(|list| {
            let soup = Soup {
                wall: complex.triangles[TriangleId(list[0])].wall,
                corners: list
                    .iter()
                    .map(|&t| complex.triangles[TriangleId(t)].nodes)
                    .collect(),
                source: list.iter().map(|&t| TriangleId(t)).collect(),
                links: assemble::restrict(&links, list),
            };
            soup.assemble(|n| complex.nodes[n].point, |n| foreign[n.index()])
        })
        .collect()
}

/// What lies across each edge of each triangle.
fn links(complex: &MidComplex) -> Vec<Links> {
    let edges = complex.edges();
    let mut links: Vec<Links> = vec![[None; 3]; complex.triangles.len()];
    let side = |t: TriangleId, ends: [NodeId; 2]| {
        let n = complex.triangles[t].nodes;
        (0..3).find(|&k| {
            let (a, b) = (n[k], n[(k + 1) % 3]);
            [a.min(b), a.max(b)] == ends
        })
    };
    let join = |links: &mut Vec<Links>, ends, a: TriangleId, b: TriangleId, kept| {
        if let (Some(i), Some(j)) = (side(a, ends), side(b, ends)) {
            let (i8, j8) = (i as u8, j as u8);
            links[a.index()][i] = Some(Link::new(b.0, j8, kept));
            links[b.index()][j] = Some(Link::new(a.0, i8, kept));
        }
    };
    let mut sets = Disjoint::new(complex.triangles.len());
    for edge in &edges {
        if complex.kind(edge) == EdgeKind::Inner {
            let (a, b) = (edge.triangles[0], edge.triangles[1]);
            join(&mut links, edge.ends, a, b, is_fold(complex, a, b));
            sets.join(a.0, b.0);
        }
    }
    for edge in &edges {
        if complex.kind(edge) == EdgeKind::Junction {
            let mut sides: Vec<(u32, TriangleId)> = edge
                .triangles
                .iter()
                .map(|t| (sets.find(t.0), *t))
                .collect();
            sides.sort_unstable();
            for run in sides.chunk_by(|a, b| a.0 == b.0) {
                if let [a, b] = run {
                    join(&mut links, edge.ends, a.1, b.1, true);
                }
            }
        }
    }
    links
}

/// Whether the two triangles at an edge meet at a fold.
fn is_fold(complex: &MidComplex, a: TriangleId, b: TriangleId) -> bool {
    let normal = |t: TriangleId, turn: bool| {
        let [p, q, r] = complex.corners(&complex.triangles[t]);
        let n = (q - p).cross(r - p);
        if turn { -n } else { n }
    };
    let (s, t) = (complex.triangles[a].nodes, complex.triangles[b].nodes);
    // The same way round, neighbours run along their common edge in opposite directions.
    let turn = (0..3).any(|i| (0..3).any(|j| s[i] == t[j] && s[(i + 1) % 3] == t[(j + 1) % 3]));
    let (n, m) = (normal(a, false), normal(b, turn));
    fold::is_fold(n, m)
}

/// Nodes that must stay wherever they lie: those of several patches, and those on more than one wall's middle.
fn feature_nodes(complex: &MidComplex, piece: &[u32]) -> Vec<bool> {
    let mut owner = vec![u32::MAX; complex.nodes.len()];
    let mut feature = vec![false; complex.nodes.len()];
    for (id, t) in complex.triangles.enumerated() {
        for n in t.nodes {
            let (o, p) = (owner[n.index()], piece[id.index()]);
            feature[n.index()] |= o != u32::MAX && o != p;
            owner[n.index()] = p;
            let own = |s: &Support| *s == Support::Mid(t.wall);
            feature[n.index()] |= !complex.nodes[n].supports.iter().all(own);
        }
    }
    feature
}

#[cfg(test)]
mod tests;
