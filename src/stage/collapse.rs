//! Collapse: the living 2-cells of the dual complex after all that is no wall has been collapsed away (ARCHITECTURE, "Choices").
//!
//! The dual complex has a 3-cell a vertex, a 2-cell an edge, a 1-cell a triangle and a 0-cell a tet of the filling, and one cell more on the
//! boundary for everything there. It fills the solid. Only simple collapses are made: a cell goes together with a free face of it. What is
//! left is therefore homotopy-equivalent to the solid whatever the labels say: labels protect the duals of through-wall edges from being eaten
//! from the rims, so they decide where the sheets lie, never whether they hang together.
//!
//! Guarantee: homotopy type kept. Exception: none; but part of it may be one-dimensional (a bar), see [`Collapsed::bars`].
//! Cost: linear in the edges: queues by passage, first in first out, so that unprotected regions shrink evenly from all sides.
//!
//! Reference: J. H. C. Whitehead, Simplicial spaces, nuclei and m-groups, Proc. LMS 45 (1939), doi:10.1112/plms/s2-45.1.243.

use crate::model::decomposition::{Collapsed, Grade};
use crate::model::ids::{Id, IndexVec, TetEdgeId, TetFaceId, VertexId};
use crate::model::tet_graph::TetGraph;
use std::collections::VecDeque;

/// Number of grades.
pub const GRADES: usize = 4;

struct Incidence {
    star: Vec<u32>,
    star_start: Vec<u32>,
    around: Vec<u32>,
    around_start: Vec<u32>,
}

/// Collapses all that may go.
///
/// `protected`: 2-cells that never go unless a 3-cell has to be opened through them; `grade`: the order of the others.
pub fn collapse(
    graph: &TetGraph,
    vertices: usize,
    protected: &IndexVec<TetEdgeId, bool>,
    grade: &IndexVec<TetEdgeId, Grade>,
) -> Collapsed {
    let inc = incidence(graph, vertices);
    let star = |v: VertexId| {
        &inc.star[inc.star_start[v.index()] as usize..inc.star_start[v.index() + 1] as usize]
    };
    let around = |e: TetEdgeId| {
        &inc.around[inc.around_start[e.index()] as usize..inc.around_start[e.index() + 1] as usize]
    };

    let mut outer: IndexVec<TetEdgeId, bool> = IndexVec::filled(false, graph.edges.len());
    let mut open: IndexVec<VertexId, bool> = IndexVec::filled(false, vertices);
    for f in graph.faces.ids().filter(|&f| graph.on_boundary(f)) {
        for e in graph.face_edges[f] {
            outer[e] = true;
        }
        for v in graph.faces[f] {
            open[v] = true;
        }
    }
    let mut alive: IndexVec<TetEdgeId, bool> = IndexVec::filled(true, graph.edges.len());

    // 3-cells. Those of boundary vertices went through their boundary cell. Inner ones go each through one 2-cell, unprotected ones first.
    let mut queues: [VecDeque<TetEdgeId>; GRADES + 1] = Default::default();
    let rank = |e: TetEdgeId| {
        if protected[e] {
            GRADES
        } else {
            usize::from(grade[e]).min(GRADES - 1)
        }
    };
    for (e, &[u, v]) in graph.edges.enumerated() {
        if open[u] != open[v] {
            queues[rank(e)].push_back(e);
        }
    }
    while let Some(e) = queues.iter_mut().find_map(VecDeque::pop_front) {
        let [u, v] = graph.edges[e];
        if open[u] == open[v] {
            continue;
        }
        let inner = if open[u] { v } else { u };
        open[inner] = true;
        alive[e] = false;
        for &k in star(inner) {
            let next = TetEdgeId(k);
            let [a, b] = graph.edges[next];
            if open[a] != open[b] {
                queues[rank(next)].push_back(next);
            }
        }
    }

    // 2-cells with a free 1-face.
    let mut uses: IndexVec<TetFaceId, u8> = graph
        .face_edges
        .iter()
        .map(|es| es.iter().filter(|&&e| alive[e]).count() as u8)
        .collect();
    let mut line: IndexVec<TetFaceId, bool> = IndexVec::filled(true, graph.faces.len());
    let may_go = |e: TetEdgeId, alive: &IndexVec<TetEdgeId, bool>| alive[e] && !protected[e];
    for e in graph.edges.ids() {
        if may_go(e, &alive) && (outer[e] || around(e).iter().any(|&k| uses[TetFaceId(k)] == 1)) {
            queues[rank(e)].push_back(e);
        }
    }
    while let Some(e) = queues.iter_mut().find_map(VecDeque::pop_front) {
        if !alive[e] {
            continue;
        }
        if outer[e] {
            outer[e] = false;
        } else if let Some(&k) = around(e)
            .iter()
            .find(|&&k| line[TetFaceId(k)] && uses[TetFaceId(k)] == 1)
        {
            line[TetFaceId(k)] = false;
        } else {
            continue;
        }
        alive[e] = false;
        for &k in around(e) {
            let f = TetFaceId(k);
            uses[f] -= 1;
            if uses[f] == 1 && line[f] {
                for n in graph.face_edges[f] {
                    if may_go(n, &alive) {
                        queues[rank(n)].push_back(n);
                    }
                }
            }
        }
    }
    // The 2-cell of a boundary edge always goes through its boundary cell, so no line is ever left on the boundary.
    let bars = bars(graph, &alive, &uses, &line);
    Collapsed { cells: alive, bars }
}

/// 1-cells that no 2-cell uses and that no free end lets collapse: ends are tets (and the boundary cell of a boundary triangle).
fn bars(
    graph: &TetGraph,
    alive: &IndexVec<TetEdgeId, bool>,
    uses: &IndexVec<TetFaceId, u8>,
    line: &IndexVec<TetFaceId, bool>,
) -> Vec<TetFaceId> {
    let mut lives: IndexVec<TetFaceId, bool> =
        graph.faces.ids().map(|f| line[f] && uses[f] == 0).collect();
    let mut degree = IndexVec::filled(0u8, graph.tet_faces.len());
    let mut held = IndexVec::filled(false, graph.tet_faces.len());
    for (t, faces) in graph.tet_faces.enumerated() {
        degree[t] = faces.iter().filter(|&&f| lives[f]).count() as u8;
        held[t] = graph.tet_edges[t].iter().any(|&e| alive[e]);
    }
    let mut queue: VecDeque<TetFaceId> = graph.faces.ids().filter(|&f| lives[f]).collect();
    while let Some(f) = queue.pop_front() {
        if !lives[f] {
            continue;
        }
        let [a, b] = graph.face_tets[f];
        let free = a == b || (degree[a] == 1 && !held[a]) || (degree[b] == 1 && !held[b]);
        if !free {
            continue;
        }
        lives[f] = false;
        for t in if a == b { vec![a] } else { vec![a, b] } {
            degree[t] -= 1;
            queue.extend(graph.tet_faces[t].iter().copied().filter(|&g| lives[g]));
        }
    }
    graph.faces.ids().filter(|&f| lives[f]).collect()
}

fn incidence(graph: &TetGraph, vertices: usize) -> Incidence {
    let (star_start, star) = compress(
        vertices,
        graph
            .edges
            .enumerated()
            .flat_map(|(e, ends)| ends.map(|v| (v.0, e.0))),
    );
    let (around_start, around) = compress(
        graph.edges.len(),
        graph
            .face_edges
            .enumerated()
            .flat_map(|(f, es)| es.map(|e| (e.0, f.0))),
    );
    Incidence {
        star,
        star_start,
        around,
        around_start,
    }
}

/// Lists of values by key, one after the other, with the start of each list.
fn compress(keys: usize, pairs: impl Iterator<Item = (u32, u32)> + Clone) -> (Vec<u32>, Vec<u32>) {
    let mut start = vec![0u32; keys + 1];
    for (k, _) in pairs.clone() {
        start[k as usize + 1] += 1;
    }
    for i in 0..keys {
        start[i + 1] += start[i];
    }
    let mut next = start.clone();
    let mut values = vec![0u32; start[keys] as usize];
    for (k, v) in pairs {
        values[next[k as usize] as usize] = v;
        next[k as usize] += 1;
    }
    (start, values)
}

#[cfg(test)]
mod tests;
