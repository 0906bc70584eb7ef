//! Laying the rings of quads between the rim of a hole and the outer circle of its washer.

use super::Rings;
use super::hole::{RimNode, common};
use super::open::settled;
use crate::geom::placer::Placer;
use crate::model::complex::{MidComplex, MidNode, MidTriangle, Support, Supports, ends};
use crate::model::ids::{NodeId, PinId};
use glam::{DVec2, DVec3, FloatExt};

/// A node of the rim is put this far from where the circle has it at most, in radii of the hole: further is another face.
const NEAR: f64 = 0.25;

/// The nodes of the outer circle, if they and the edges between them are what they were. `pinned`: nodes by their pins, sorted.
pub(super) fn circle(
    complex: &MidComplex,
    rings: &Rings,
    pinned: &[(PinId, NodeId)],
) -> Option<Vec<NodeId>> {
    let nodes: Vec<NodeId> = (rings.pins())
        .map(|pin| {
            let i = pinned.binary_search_by_key(&pin, |p| p.0).ok()?;
            Some(pinned[i].1)
        })
        .collect::<Option<_>>()?;
    let stayed = (nodes.iter().zip(&rings.circle)).all(|(n, p)| complex.nodes[*n].point == *p);
    stayed.then_some(nodes)
}

/// Lays the rings; the diagonals of their quads, lower node first. The edges of the `circle` have to be free edges.
pub(super) fn fill(
    complex: &mut MidComplex,
    rings: &Rings,
    circle: &[NodeId],
    placer: &dyn Placer,
) -> Vec<[NodeId; 2]> {
    let wall = rings.hole.wall;
    let heights: Vec<[f64; 2]> = (0..rings.around)
        .map(|i| {
            let outer = complex.nodes[circle[i as usize]].point;
            [
                on_rim(rings, rings.way(i)).1,
                rings.hole.plane.height(outer),
            ]
        })
        .collect();
    let mut rows: Vec<Vec<NodeId>> = Vec::new();
    for k in 0..rings.layers {
        let share = f64::from(k) / f64::from(rings.layers);
        let node = |i: u32| {
            let place = rings.way(i) * rings.radius(k);
            let [inner, outer] = heights[i as usize];
            let height = inner.lerp(outer, share);
            let start = rings.hole.plane.space(place, height);
            if k == 0 {
                let supports = on_rim(rings, rings.way(i)).0;
                let point = at_rim(rings, start, &supports, placer);
                return MidNode { point, supports };
            }
            MidNode {
                point: settled(rings, place, height, placer).unwrap_or(start),
                supports: [Support::Mid(wall)].into_iter().collect(),
            }
        };
        let row: Vec<MidNode> = (0..rings.around).map(node).collect();
        rows.push(row.into_iter().map(|n| complex.nodes.push(n)).collect());
    }
    rows.push(circle.to_vec());
    let turned = runs_inwards(complex, circle);
    let count = circle.len();
    let mut diagonals = Vec::new();
    for pair in rows.windows(2) {
        for i in 0..count {
            let j = (i + 1) % count;
            let [a, b, c, d] = [pair[0][i], pair[1][i], pair[1][j], pair[0][j]];
            let halves = if turned {
                [[a, c, b], [a, d, c]]
            } else {
                [[a, b, c], [a, c, d]]
            };
            for nodes in halves {
                complex.triangles.push(MidTriangle { nodes, wall });
            }
            diagonals.push([a.min(c), a.max(c)]);
        }
    }
    diagonals
}

/// Whether the sheet round the circle is wound clockwise, in the plane of its hole: triangles were turned since.
fn runs_inwards(complex: &MidComplex, circle: &[NodeId]) -> bool {
    let edge = [circle[0], circle[1]];
    let at = |t: &&MidTriangle| edge.iter().all(|n| t.nodes.contains(n));
    // Wound counter-clockwise, the sheet outside runs against the circle.
    complex
        .triangles
        .iter()
        .find(at)
        .is_some_and(|t| t.runs(edge))
}

/// What the rim of the hole lies on in this direction, and how high above the plane of the hole, mm.
fn on_rim(rings: &Rings, way: DVec2) -> (Supports, f64) {
    let rim = &rings.hole.rim;
    let pairs = (0..rim.len()).map(|i| [&rim[i], &rim[(i + 1) % rim.len()]]);
    // The side that the ray passes between.
    let between = |[a, b]: &[&RimNode; 2]| {
        let ahead = a.place.dot(way) > 0.0 || b.place.dot(way) > 0.0;
        ahead && a.place.perp_dot(way) >= 0.0 && b.place.perp_dot(way) < 0.0
    };
    let [a, b] = pairs.clone().find(between).unwrap_or([&rim[0], &rim[0]]);
    let (s, t) = (a.place.perp_dot(way), b.place.perp_dot(way));
    let share = if s > t { s / (s - t) } else { 0.0 };
    let both = common(&a.supports, &b.supports);
    // Where a side lies on no face of its own it goes with its first end.
    let supports = if ends(&both).next().is_some() {
        both
    } else {
        a.supports.clone()
    };
    (supports, a.height.lerp(b.height, share))
}

/// A node of the rim onto the faces round the hole.
fn at_rim(rings: &Rings, start: DVec3, supports: &Supports, placer: &dyn Placer) -> DVec3 {
    let placed = placer.place(start, supports);
    let near = placed.is_finite() && placed.distance(start) < NEAR * rings.hole.radius;
    if near { placed } else { start }
}
