//! Walls that end with what is taken out: their part of the mid-surface goes on as that of the wall that they lie in, or, where it stands on that one (a raised letter as narrow as high), is left out.

use crate::model::complex::{MidComplex, MidEdge};
use crate::model::disjoint::Disjoint;
use crate::model::ids::{FaceId, NodeId, TriangleId, WallId};
use crate::model::walls::Pairing;
use std::collections::{BTreeMap, BTreeSet};

/// The mid-surface with its edges.
pub(super) struct Sheets<'a> {
    pub complex: &'a MidComplex,
    pub edges: Vec<MidEdge>,
}

impl<'a> Sheets<'a> {
    pub fn new(complex: &'a MidComplex) -> Self {
        let edges = complex.edges();
        Self { complex, edges }
    }
}

/// Walls that end, with the wall that takes their place; none where their sheets are left out.
pub(super) type Endings = Vec<(WallId, Option<WallId>)>;

/// The walls that lose a side to the faces that are `gone`, `own` of them among it, with what becomes of their sheets in that of `wall`. None where `wall` loses a side itself, where what is left of such a wall is no side
/// of `wall`, or where their sheets neither lie in that of `wall` (but for an end in `ring`, sorted) nor can be left out without a change of the topology.
pub(super) fn absorbed(
    pairing: &Pairing,
    sheets: &Sheets<'_>,
    gone: &BTreeSet<FaceId>,
    own: &BTreeSet<FaceId>,
    wall: WallId,
    ring: &[NodeId],
) -> Option<Endings> {
    let lost = |w: WallId| {
        let mut sides = pairing.walls[w].sides.iter();
        sides.any(|s| s.iter().all(|f| gone.contains(f)) && s.iter().any(|f| own.contains(f)))
    };
    if lost(wall) {
        return None;
    }
    let within = |f: &FaceId| {
        let mut sides = pairing.walls[wall].sides.iter();
        gone.contains(f) || sides.any(|s| s.binary_search(f).is_ok())
    };
    let ending: BTreeSet<WallId> = pairing.walls.ids().filter(|&w| lost(w)).collect();
    let mut rests = ending
        .iter()
        .flat_map(|&w| pairing.walls[w].sides.iter().flatten());
    if !rests.all(within) {
        return None;
    }
    let of = |t: TriangleId| sheets.complex.triangles[t].wall;
    let lies_in = |e: &MidEdge| match e.triangles.as_slice() {
        [_] => e.ends.iter().all(|n| ring.binary_search(n).is_ok()),
        [a, b] => [*a, *b]
            .into_iter()
            .all(|t| of(t) == wall || ending.contains(&of(t))),
        _ => false,
    };
    let mut standing: BTreeSet<WallId> = BTreeSet::new();
    if !ending.is_empty() {
        let ends = |e: &&MidEdge| e.triangles.iter().any(|&t| ending.contains(&of(t)));
        for edge in sheets.edges.iter().filter(ends).filter(|e| !lies_in(e)) {
            let walls = edge.triangles.iter().map(|&t| of(t));
            standing.extend(walls.filter(|w| ending.contains(w)));
        }
    }
    let stays = |w: WallId| w == wall || (ending.contains(&w) && !standing.contains(&w));
    if !standing.is_empty() && !comes_off(sheets, &standing, stays) {
        return None;
    }
    let instead = |w: WallId| (w, (!standing.contains(&w)).then_some(wall));
    Some(ending.into_iter().map(instead).collect())
}

/// Whether the sheets of some walls can be left out: they hang on inner edges of the sheet of those that stay, and neither Euler characteristic nor pieces change.
fn comes_off(
    sheets: &Sheets<'_>,
    standing: &BTreeSet<WallId>,
    stays: impl Fn(WallId) -> bool,
) -> bool {
    let complex = sheets.complex;
    let of = |t: &TriangleId| complex.triangles[*t].wall;
    let goes = |t: &TriangleId| standing.contains(&of(t));
    let mut sets = Disjoint::new(complex.triangles.len());
    let mut edges_gone = 0;
    for edge in &sheets.edges {
        let rest: Vec<TriangleId> = edge
            .triangles
            .iter()
            .copied()
            .filter(|t| !goes(t))
            .collect();
        if let [first, others @ ..] = rest.as_slice() {
            others.iter().for_each(|t| sets.join(first.0, t.0));
        }
        match (edge.triangles.len() - rest.len(), rest.len()) {
            (0, _) => {}
            (_, 0) => edges_gone += 1,
            (_, 2) if rest.iter().all(|t| stays(of(t))) => {}
            _ => return false,
        }
    }
    // For each node whether a triangle stays there.
    let mut nodes: BTreeMap<NodeId, bool> = BTreeMap::new();
    let triangles = complex.triangles.ids().filter(goes);
    let gone: Vec<TriangleId> = triangles.collect();
    for &n in gone.iter().flat_map(|&t| &complex.triangles[t].nodes) {
        nodes.insert(n, false);
    }
    for t in complex.triangles.ids().filter(|t| !goes(t)) {
        for n in complex.triangles[t].nodes {
            nodes.entry(n).and_modify(|stays| *stays = true);
        }
    }
    let nodes_gone = nodes.values().filter(|stays| !**stays).count();
    // Each triangle that goes is a set of its own.
    let pieces = sets.sets() - gone.len();
    nodes_gone + gone.len() == edges_gone && pieces == complex.pieces()
}
