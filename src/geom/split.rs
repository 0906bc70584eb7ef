//! Splitting edges of a mid-complex: what cuts sheets along lines has in common.

use super::placer::Placer;
use crate::model::complex::{MidComplex, MidNode, MidTriangle, Support, Supports, ends};
use crate::model::ids::{IndexVec, NodeId, TriangleId};
use std::collections::BTreeMap;

/// A new node on an edge with these triangles; on a rim it lies on what the ends lie on.
pub fn node_on(
    complex: &MidComplex,
    [a, b]: [NodeId; 2],
    at: f64,
    ring: &[TriangleId],
    placer: &dyn Placer,
) -> MidNode {
    let nodes = &complex.nodes;
    let point = nodes[a].point.lerp(nodes[b].point, at);
    let walls = ring.iter().map(|&t| complex.triangles[t].wall);
    let mut supports: Supports = walls.map(Support::Mid).collect();
    if let &[t] = ring {
        let wall = Support::Mid(complex.triangles[t].wall);
        let far = &nodes[b].supports;
        let common: Supports = ends(&nodes[a].supports)
            .filter(|s| far.contains(s))
            .collect();
        if common.is_empty() {
            let moved = |s: Support| placer.place(point, &[wall, s]).distance(point);
            let either = ends(&nodes[a].supports).chain(ends(far));
            supports.extend(either.min_by(|s, t| moved(*s).total_cmp(&moved(*t)).then(s.cmp(t))));
        } else {
            supports.extend(common);
        }
    }
    supports.sort_unstable();
    supports.dedup();
    MidNode { point, supports }
}

/// Splits edges (lower node first) at nodes that are there already, and the triangles round them.
pub fn split(complex: &mut MidComplex, cuts: &BTreeMap<[NodeId; 2], NodeId>) {
    let on = |a: NodeId, b: NodeId| cuts.get(&[a.min(b), a.max(b)]).copied();
    let length = |a: NodeId, b: NodeId| {
        let nodes = &complex.nodes;
        nodes[a].point.distance(nodes[b].point)
    };
    let mut triangles: IndexVec<TriangleId, MidTriangle> = IndexVec::new();
    for t in &complex.triangles {
        let wall = t.wall;
        let mut add = |nodes: [NodeId; 3]| {
            triangles.push(MidTriangle { nodes, wall });
        };
        // Turned so that with one cut it is the first edge, with two the edge without a cut is the second.
        let turned = |k: usize| [0, 1, 2].map(|i| t.nodes[(i + k) % 3]);
        let made = |n: [NodeId; 3]| [on(n[0], n[1]), on(n[1], n[2]), on(n[2], n[0])];
        let all = [0, 1, 2].map(|k| (turned(k), made(turned(k))));
        let count = all[0].1.iter().flatten().count();
        let fits = |m: &[Option<NodeId>; 3]| match count {
            1 => m[0].is_some(),
            2 => m[1].is_none(),
            _ => true,
        };
        match all.into_iter().find(|(_, m)| fits(m)) {
            Some(([a, b, c], [Some(m), None, None])) => {
                add([a, m, c]);
                add([m, b, c]);
            }
            Some(([a, b, c], [Some(m), None, Some(n)])) => {
                add([a, m, n]);
                if length(m, c) <= length(n, b) {
                    add([m, b, c]);
                    add([m, c, n]);
                } else {
                    add([m, b, n]);
                    add([n, b, c]);
                }
            }
            Some(([a, b, c], [Some(m), Some(n), Some(o)])) => {
                add([a, m, o]);
                add([m, b, n]);
                add([o, n, c]);
                add([m, n, o]);
            }
            _ => add(t.nodes),
        }
    }
    complex.triangles = triangles;
}
