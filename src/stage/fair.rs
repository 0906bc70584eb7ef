//! Fair: undoes the tangles of a raw complex without changing its topology.
//!
//! The nodes of a raw complex come from the tets they were read in, then each is put onto its own supports. Along a junction curve or a rim two of them may
//! have changed places, and beside it a small triangle may lie the other way round. Here curve nodes are moved to the middle between their two neighbours on the
//! curve and put back onto it, which brings them into order; then the nodes of turned triangles to the middle of their neighbours, until none is turned.
//!
//! Guarantees: topology untouched, and supports but those that shut a closed rim; corners stay; nodes lie on their supports as exactly as before. Exception: where supports
//! say nothing along a curve (a rim inside a lump), it is smoothed like a string, and a closed one is held open (`Strings`); and a node stays off its supports, or where it was, where
//! they would take its triangles out of the material (`leave`).
//! Cost: a few placings a curve node; for sheet nodes only near turned triangles.
//!
//! Reference: W. T. Tutte, How to draw a graph, Proc. LMS 13 (1963), doi:10.1112/plms/s3-13.1.743: nodes in the middle of their neighbours do not cross.

mod leave;
mod strings;

use crate::geom::orient::{orient, turned};
use crate::geom::placer::Placer;
use crate::geom::rim_loops::open_shut;
use crate::model::complex::{EdgeKind, MidComplex, ends};
use crate::model::ids::{IndexVec, NodeId, TriangleId};
use glam::DVec3;
use rayon::prelude::*;
use smallvec::SmallVec;
use strings::Strings;

/// Rounds for curves: a node that lies two places off needs two; more only spread the spacing.
const CURVE_ROUNDS: usize = 6;
/// Rounds for sheets: each lets a tangle spread over one more ring of neighbours.
const SHEET_ROUNDS: usize = 24;

/// Rings round turned triangles in which curves move when a complex is faired again: a knot that was contracted is smaller than that.
const NEAR_RINGS: usize = 3;

/// What was done.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct FairStats {
    /// Turned triangles before.
    pub turned_before: usize,
    /// Turned triangles left.
    pub turned_after: usize,
}

/// Untangles curves, then sheets.
pub fn fair(mut complex: MidComplex, placer: &dyn Placer) -> (MidComplex, FairStats) {
    orient(&mut complex, placer);
    let net = Net::new(&complex);
    let before = complex.clone();
    let strings = Strings::new(&complex, &net);
    for _ in 0..CURVE_ROUNDS {
        relax(&mut complex, &net.curve_nodes, &net.along, placer);
        strings.reopen(&mut complex, placer);
    }
    let then = before.nodes.iter().map(|n| n.point).collect();
    open_shut(&mut complex, &then, placer);
    let stats = untangle(&mut complex, &net, placer);
    settle(&mut complex, &before, &net, placer);
    (complex, stats)
}

/// The same for a complex that is fair but for a few places, wound as [`fair`] leaves it: only what is near turned triangles moves.
pub fn fair_again(mut complex: MidComplex, placer: &dyn Placer) -> (MidComplex, FairStats) {
    let net = Net::new(&complex);
    let before = complex.clone();
    let everywhere: Vec<TriangleId> = complex.triangles.ids().collect();
    let bad = turned(&complex, &everywhere, placer);
    let near: Vec<NodeId> = net
        .within(&complex, &bad, NEAR_RINGS)
        .into_iter()
        .filter(|n| net.curve_nodes.binary_search(n).is_ok())
        .collect();
    for _ in 0..CURVE_ROUNDS {
        relax(&mut complex, &near, &net.along, placer);
    }
    let stats = untangle(&mut complex, &net, placer);
    settle(&mut complex, &before, &net, placer);
    (complex, stats)
}

/// Nodes are drawn towards their supports while they move; here those that did come to lie on them. Where that, or all the moving, takes sheets out of the material, they go back.
fn settle(complex: &mut MidComplex, before: &MidComplex, net: &Net, placer: &dyn Placer) {
    let then = complex.clone();
    complex
        .nodes
        .as_mut_slice()
        .par_iter_mut()
        .zip(before.nodes.as_slice())
        .filter(|(now, then)| now.point != then.point)
        .for_each(|(now, _)| {
            let p = placer.place(now.point, &now.supports);
            if p.is_finite() {
                now.point = p;
            }
        });
    leave::stay(complex, &then, &net.stars, placer);
    leave::stay(complex, before, &net.stars, placer);
}

/// Moves the nodes near turned triangles until none is turned or the rounds are over.
fn untangle(complex: &mut MidComplex, net: &Net, placer: &dyn Placer) -> FairStats {
    let everywhere: Vec<TriangleId> = complex.triangles.ids().collect();
    let mut bad = turned(complex, &everywhere, placer);
    let mut stats = FairStats {
        turned_before: bad.len(),
        turned_after: bad.len(),
    };
    let mut reach = 1;
    for round in 0..SHEET_ROUNDS {
        if bad.is_empty() {
            break;
        }
        // Stubborn tangles get more room.
        if round % 4 == 3 {
            reach += 1;
        }
        let moving = net.around(complex, &bad, reach);
        relax(complex, &moving, &net.beside, placer);
        let mut touched: Vec<TriangleId> = moving
            .iter()
            .flat_map(|&n| net.stars[n].iter().copied())
            .collect();
        touched.extend(&bad);
        touched.sort_unstable();
        touched.dedup();
        bad = turned(complex, &touched, placer);
        stats.turned_after = bad.len();
    }
    stats
}

/// Neighbours of every node, and which of them may move how.
struct Net {
    /// Neighbours of sheet nodes; empty for nodes on curves.
    beside: IndexVec<NodeId, SmallVec<[NodeId; 8]>>,
    /// The two neighbours along the curve of nodes that may slide on one.
    along: IndexVec<NodeId, SmallVec<[NodeId; 8]>>,
    curve_nodes: Vec<NodeId>,
    stars: IndexVec<NodeId, SmallVec<[TriangleId; 8]>>,
}

impl Net {
    fn new(complex: &MidComplex) -> Self {
        let empty = || IndexVec::filled(SmallVec::<[NodeId; 8]>::new(), complex.nodes.len());
        let (mut beside, mut along) = (empty(), empty());
        for edge in complex.edges() {
            let [a, b] = edge.ends;
            beside[a].push(b);
            beside[b].push(a);
            if complex.kind(&edge) != EdgeKind::Inner {
                along[a].push(b);
                along[b].push(a);
            }
        }
        let mut curve_nodes = Vec::new();
        for n in complex.nodes.ids() {
            if along[n].is_empty() {
                continue;
            }
            beside[n].clear();
            if along[n].len() == 2 && ends(&complex.nodes[n].supports).count() < 2 {
                curve_nodes.push(n);
            }
        }
        Self {
            beside,
            along,
            curve_nodes,
            stars: complex.stars(),
        }
    }

    /// All nodes of the triangles and `rings` rings of triangles round them, sorted.
    fn within(&self, complex: &MidComplex, triangles: &[TriangleId], rings: usize) -> Vec<NodeId> {
        let mut nodes: Vec<NodeId> = triangles
            .iter()
            .flat_map(|&t| complex.triangles[t].nodes)
            .collect();
        for _ in 0..=rings {
            nodes.sort_unstable();
            nodes.dedup();
            let ring: Vec<NodeId> = nodes
                .iter()
                .flat_map(|&n| &self.stars[n])
                .flat_map(|&t| complex.triangles[t].nodes)
                .collect();
            nodes.extend(ring);
        }
        nodes.sort_unstable();
        nodes.dedup();
        nodes
    }

    /// The sheet nodes of the triangles and `reach` rings round them, sorted.
    fn around(&self, complex: &MidComplex, triangles: &[TriangleId], reach: usize) -> Vec<NodeId> {
        let mut nodes: Vec<NodeId> = triangles
            .iter()
            .flat_map(|&t| complex.triangles[t].nodes)
            .collect();
        for _ in 0..reach {
            let ring: Vec<NodeId> = nodes
                .iter()
                .flat_map(|&n| self.beside[n].iter().copied())
                .collect();
            nodes.extend(ring);
            nodes.sort_unstable();
            nodes.dedup();
        }
        nodes.retain(|&n| !self.beside[n].is_empty());
        nodes
    }
}

/// Moves each of the nodes to the middle of its neighbours and onto its supports, all from the old positions.
fn relax(
    complex: &mut MidComplex,
    nodes: &[NodeId],
    neighbours: &IndexVec<NodeId, SmallVec<[NodeId; 8]>>,
    placer: &dyn Placer,
) {
    let moved: Vec<DVec3> = nodes
        .par_iter()
        .map(|&n| {
            let list = &neighbours[n];
            let middle =
                list.iter().map(|&m| complex.nodes[m].point).sum::<DVec3>() / list.len() as f64;
            let p = placer.draw(middle, &complex.nodes[n].supports);
            if p.is_finite() {
                p
            } else {
                complex.nodes[n].point
            }
        })
        .collect();
    for (&n, p) in nodes.iter().zip(moved) {
        complex.nodes[n].point = p;
    }
}
