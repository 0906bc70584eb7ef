//! Widen: which 2-cells to protect so that a bar becomes a strip of sheet.
//!
//! A bar is a chain of triangles of the filling, each dual to a living line. Two consecutive ones lie in one tet and share an edge: its 2-cell holds both lines,
//! so the 2-cells of all these edges make a strip along the bar. At either end the edge is chosen that shares a triangle with a living cell, so that the strip
//! hangs on to the sheet by an edge, not only by a point. Sheets that touch only in the middle of a tet (two opposite edges of it live) get a third edge likewise.
//! Protecting more never changes the homotopy type: the collapse is run again with it.

use std::cmp::Reverse;

use crate::model::decomposition::{Collapsed, Grade};
use crate::model::ids::{IndexVec, TetEdgeId, TetFaceId};
use crate::model::tet_graph::TetGraph;

/// Edges to protect, sorted. Empty where there is no bar.
///
/// `grade`: how wall-like every edge is; where several would do, the most wall-like is taken.
pub fn widen(
    graph: &TetGraph,
    collapsed: &Collapsed,
    grade: &IndexVec<TetEdgeId, Grade>,
) -> Vec<TetEdgeId> {
    let mut is_bar: IndexVec<TetFaceId, bool> = IndexVec::filled(false, graph.faces.len());
    let mut tets = Vec::new();
    for &f in &collapsed.bars {
        is_bar[f] = true;
        tets.extend(graph.face_tets[f]);
    }
    tets.sort_unstable();
    tets.dedup();
    let mut chosen = Vec::new();
    for t in tets {
        let bars: Vec<TetFaceId> = graph.tet_faces[t]
            .into_iter()
            .filter(|&f| is_bar[f])
            .collect();
        if let [first, rest @ ..] = bars.as_slice() {
            chosen.extend(rest.iter().flat_map(|f| {
                graph.face_edges[*f]
                    .into_iter()
                    .filter(|e| graph.face_edges[*first].contains(e))
            }));
        }
        let living: Vec<TetEdgeId> = graph.tet_edges[t]
            .into_iter()
            .filter(|&e| collapsed.cells[e])
            .collect();
        if living.is_empty() {
            continue;
        }
        for &f in &bars {
            // An edge that has an end in common with a living one shares with it the triangle that both span.
            let touches = |e: TetEdgeId| {
                living
                    .iter()
                    .filter(|&&l| graph.edges[l].iter().any(|v| graph.edges[e].contains(v)))
                    .count()
            };
            let best = graph.face_edges[f]
                .into_iter()
                .max_by_key(|&e| (touches(e), grade[e], Reverse(e)));
            chosen.extend(best);
        }
    }
    for edges in &graph.tet_edges {
        let living: Vec<TetEdgeId> = edges
            .iter()
            .copied()
            .filter(|&e| collapsed.cells[e])
            .collect();
        if let [a, b] = living.as_slice()
            && !graph.edges[*a].iter().any(|v| graph.edges[*b].contains(v))
        {
            chosen.extend(
                edges
                    .iter()
                    .copied()
                    .filter(|e| e != a && e != b)
                    .max_by_key(|&e| (grade[e], Reverse(e))),
            );
        }
    }
    chosen.sort_unstable();
    chosen.dedup();
    chosen
}

#[cfg(test)]
mod tests;
