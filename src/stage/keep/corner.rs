//! Corners: where a line turns or forks the complex gets a node, before anything is cut.

use super::part::put;
use crate::geom::split;
use crate::geom::triangle::nearest_on_triangle;
use crate::model::complex::{MidComplex, MidNode, MidTriangle, Support};
use crate::model::ids::{NodeId, TriangleId, WallId};
use glam::DVec3;
use std::collections::BTreeMap;

/// A node this near, as a share of the longest side of its triangle, goes to the corner.
const NEAR: f64 = 0.25;
/// A node on another line has to be there already, to this share.
const THERE: f64 = 1e-3;
/// A corner this near to a side of its triangle, as a share of the longest, lies on it.
const ON_SIDE: f64 = 0.05;

/// The triangle that holds a corner, and the node of it that may go there.
pub(super) struct Holder {
    triangle: TriangleId,
    node: Option<NodeId>,
}

fn longest([a, b, c]: [DVec3; 3]) -> f64 {
    a.distance(b).max(b.distance(c)).max(c.distance(a))
}

/// What holds a corner on a wall; `taken`: whether a node lies on a line. None where the sheet does not reach so far.
pub(super) fn nearest(
    complex: &MidComplex,
    wall: WallId,
    to: DVec3,
    taken: impl Fn(NodeId) -> bool,
) -> Option<Holder> {
    let (triangle, away) = (complex.triangles.enumerated())
        .filter(|(_, t)| t.wall == wall)
        .map(|(id, t)| (id, nearest_on_triangle(complex.corners(t), to).distance(to)))
        .min_by(|a, b| a.1.total_cmp(&b.1))?;
    let holder = &complex.triangles[triangle];
    let size = longest(complex.corners(holder));
    if away.is_nan() || away > NEAR * size {
        return None;
    }
    let far = |n: NodeId| complex.nodes[n].point.distance(to);
    let node = (holder.nodes.into_iter())
        .filter(|n| complex.nodes[*n].supports.as_slice() == [Support::Mid(wall)])
        .filter(|n| far(*n) < size * if taken(*n) { THERE } else { NEAR })
        .min_by(|a, b| far(*a).total_cmp(&far(*b)));
    Some(Holder { triangle, node })
}

/// The node at a corner: one that goes there, or a new one. None at the end of the sheet.
pub(super) fn meet(complex: &mut MidComplex, holder: Holder, to: DVec3) -> Option<NodeId> {
    let Holder { triangle, node } = holder;
    if let Some(n) = node {
        let star = complex.stars()[n].clone();
        if put(complex, &star, n, to) {
            return Some(n);
        }
    }
    let MidTriangle { nodes, wall } = complex.triangles[triangle];
    let corners = complex.corners(&complex.triangles[triangle]);
    let supports = std::iter::once(Support::Mid(wall)).collect();
    let new = MidNode {
        point: to,
        supports,
    };
    let height = |k: usize| {
        let side = corners[(k + 1) % 3] - corners[k];
        side.cross(to - corners[k]).length() / side.length()
    };
    let least = (0..3).min_by(|a, b| height(*a).total_cmp(&height(*b)))?;
    if height(least) > ON_SIDE * longest(corners) {
        let n = complex.nodes.push(new);
        let [a, b, c] = nodes;
        complex.triangles[triangle].nodes = [a, b, n];
        for nodes in [[b, c, n], [c, a, n]] {
            complex.triangles.push(MidTriangle { nodes, wall });
        }
        return Some(n);
    }
    let ends = [nodes[least], nodes[(least + 1) % 3]];
    let ring: Vec<MidTriangle> = (complex.triangles.iter())
        .filter(|t| ends.iter().all(|n| t.nodes.contains(n)))
        .copied()
        .collect();
    // At a rim or a junction the line ends anyway.
    if ring.len() != 2 || ring.iter().any(|t| t.wall != wall) {
        return None;
    }
    let n = complex.nodes.push(new);
    let [a, b] = ends;
    let cuts: BTreeMap<[NodeId; 2], NodeId> = [([a.min(b), a.max(b)], n)].into();
    split::split(complex, &cuts);
    Some(n)
}
