//! Parting: what lies on either side of a line becomes pieces of the wall.

use crate::geom::placer::Placer;
use crate::medial::Medial;
use crate::model::complex::{EdgeKind, MidComplex};
use crate::model::disjoint::Disjoint;
use crate::model::ids::{CurveId, IndexVec, NodeId, TriangleId, WallId};
use crate::model::pieces::Pieces;
use crate::model::walls::Pairing;
use glam::DVec3;
use smallvec::SmallVec;
use std::collections::{BTreeMap, BTreeSet};

/// Ends of lines inside a sheet that are shorter than this, in lengths of their longest edge, are noise of the cutting.
const SPUR: f64 = 3.0;

/// Edges on lines, and what lies beneath each of them.
pub(super) type OnLines = BTreeMap<[NodeId; 2], CurveId>;

/// The pieces that the triangles form if they hang together over inner edges that are on no line.
fn pieces_of(complex: &MidComplex, lines: &OnLines) -> Disjoint {
    let mut sets = Disjoint::new(complex.triangles.len());
    for edge in complex.edges() {
        if let (EdgeKind::Inner, [s, t]) = (complex.kind(&edge), edge.triangles.as_slice())
            && !lines.contains_key(&edge.ends)
        {
            sets.join(s.0, t.0);
        }
    }
    sets
}

/// The two triangles at every edge on a line.
fn beside(complex: &MidComplex, lines: &OnLines) -> Vec<([NodeId; 2], [TriangleId; 2])> {
    (complex.edges().into_iter())
        .filter(|e| lines.contains_key(&e.ends))
        .filter_map(|e| match e.triangles.as_slice() {
            &[s, t] => Some((e.ends, [s, t])),
            _ => None,
        })
        .collect()
}

/// Takes out the edges on lines that part nothing. Returns the edges of the solid above them, but for short ends, each with a place, mm.
pub(super) fn idle(complex: &MidComplex, lines: &mut OnLines) -> Vec<(CurveId, DVec3)> {
    let mut sets = pieces_of(complex, lines);
    let mut idle: BTreeMap<CurveId, (f64, f64, DVec3)> = BTreeMap::new();
    for (ends, [s, t]) in beside(complex, lines) {
        if sets.find(s.0) != sets.find(t.0) {
            continue;
        }
        let Some(curve) = lines.remove(&ends) else {
            continue;
        };
        let [a, b] = ends.map(|n| complex.nodes[n].point);
        let (sum, longest, _) = idle.get(&curve).copied().unwrap_or_default();
        let length = a.distance(b);
        idle.insert(curve, (sum + length, longest.max(length), (a + b) / 2.0));
    }
    (idle.into_iter())
        .filter(|(_, (sum, longest, _))| *sum > SPUR * longest)
        .map(|(curve, (_, _, at))| (curve, at))
        .collect()
}

/// Puts a node to a place, if no triangle turns over; says whether it lies there.
pub(super) fn put(complex: &mut MidComplex, star: &[TriangleId], n: NodeId, to: DVec3) -> bool {
    let areas = |complex: &MidComplex| -> Vec<DVec3> {
        (star.iter())
            .map(|&t| complex.area_vector(&complex.triangles[t]))
            .collect()
    };
    let before = areas(complex);
    let from = std::mem::replace(&mut complex.nodes[n].point, to);
    let turned = (areas(complex).iter().zip(&before)).any(|(a, b)| a.dot(*b) <= 0.0);
    let fits = to.is_finite() && !turned;
    if !fits {
        complex.nodes[n].point = from;
    }
    fits
}

/// Makes walls of the pieces that have a line beside them, each its own: two that meet at a junction only have no line between them. Returns them, and which lie beside each other.
pub(super) fn pieces(
    complex: &mut MidComplex,
    lines: &OnLines,
    pairing: &mut Pairing,
) -> (Pieces, BTreeSet<[WallId; 2]>) {
    let mut sets = pieces_of(complex, lines);
    let rings = beside(complex, lines);
    let mut names: BTreeMap<u32, WallId> = BTreeMap::new();
    let mut pieces = Pieces::default();
    for t in rings.iter().flat_map(|ring| ring.1) {
        let whole = complex.triangles[t].wall;
        names.entry(sets.find(t.0)).or_insert_with(|| {
            let wall = pairing.walls[whole].clone();
            let piece = pairing.walls.push(wall);
            pieces.add(piece, whole);
            piece
        });
    }
    for (i, t) in complex.triangles.as_mut_slice().iter_mut().enumerate() {
        if let Some(&piece) = names.get(&sets.find(i as u32)) {
            t.wall = piece;
        }
    }
    complex.support_by_walls();
    let beside = (rings.iter())
        .map(|(_, ring)| ring.map(|t| complex.triangles[t].wall))
        .map(|[a, b]| [a.min(b), a.max(b)])
        .collect();
    (pieces, beside)
}

/// Puts the nodes of lines onto them.
pub(super) fn place(complex: &mut MidComplex, lines: &OnLines, walls: &Medial<'_>) {
    let mut nodes: SmallVec<[NodeId; 64]> = lines.keys().flatten().copied().collect();
    nodes.sort_unstable();
    nodes.dedup();
    let stars: IndexVec<NodeId, _> = complex.stars();
    for n in nodes {
        let node = &complex.nodes[n];
        let to = walls.place(node.point, &node.supports);
        put(complex, &stars[n], n, to);
    }
}
