//! Curves of a complex with more or fewer nodes: edges are split and contracted, and what is left is spread along the curve as it was.

use super::Curve;
use crate::geom::orient::folded;
use crate::geom::placer::Placer;
use crate::model::complex::{MidComplex, MidNode, MidTriangle, Support, Supports};
use crate::model::ids::{IndexVec, NodeId, TriangleId};
use glam::DVec3;
use smallvec::SmallVec;
use std::collections::BTreeSet;

/// Every curve with as many edges as it is to have.
pub(super) fn redivided(
    complex: &MidComplex,
    mut curves: Vec<Curve>,
    placer: &dyn Placer,
) -> MidComplex {
    let before = folded(complex).len();
    let mut stars = complex.stars();
    let mut new = complex.clone();
    let mut gone: BTreeSet<TriangleId> = BTreeSet::new();
    let old: Vec<Vec<DVec3>> = (curves.iter())
        .map(|c| c.nodes.iter().map(|&n| complex.nodes[n].point).collect())
        .collect();
    for curve in &mut curves {
        while curve.count() < curve.target() {
            split(&mut new, &mut stars, curve);
        }
        while curve.count() > curve.target() && contract(&mut new, &mut stars, &mut gone, curve) {}
    }
    let plain = new.clone();
    for (curve, line) in curves.iter().zip(&old) {
        spread(&mut new, line, curve, placer);
    }
    let living = |c: &MidComplex| living(c, &gone);
    if folded(&living(&new)).len() <= before {
        return living(&new);
    }
    // Curve by curve: where nodes fold a triangle they stay as they were.
    let folds: BTreeSet<[u64; 3]> = {
        let spread = living(&new);
        let corners = |t: TriangleId| spread.corners(&spread.triangles[t]);
        (folded(&spread).into_iter())
            .flat_map(corners)
            .map(|p| p.to_array().map(f64::to_bits))
            .collect()
    };
    for curve in &curves {
        let at = |n: &NodeId| new.nodes[*n].point.to_array().map(f64::to_bits);
        if curve.nodes.iter().any(|n| folds.contains(&at(n))) {
            for &n in &curve.nodes {
                new.nodes[n].point = plain.nodes[n].point;
            }
        }
    }
    if folded(&living(&new)).len() <= before {
        living(&new)
    } else {
        living(&plain)
    }
}

/// The complex without these triangles, and without nodes that no triangle has.
fn living(complex: &MidComplex, gone: &BTreeSet<TriangleId>) -> MidComplex {
    let kept = (complex.triangles.enumerated())
        .filter(|(t, _)| !gone.contains(t))
        .map(|(_, t)| *t);
    MidComplex {
        nodes: complex.nodes.clone(),
        triangles: kept.collect(),
    }
    .without_orphans()
}

/// The living triangles at each node.
type Stars = IndexVec<NodeId, SmallVec<[TriangleId; 8]>>;

/// Splits the longest edge of a curve.
fn split(complex: &mut MidComplex, stars: &mut Stars, curve: &mut Curve) {
    let length = |i: usize| {
        let [a, b] = [i, i + 1].map(|i| complex.nodes[curve.nodes[i]].point);
        a.distance(b)
    };
    let longest = (1..curve.count()).fold(0, |best, i| {
        // Of equal ones rounding must not decide.
        if length(i) > length(best) * (1.0 + 1e-9) {
            i
        } else {
            best
        }
    });
    let [a, b] = [curve.nodes[longest], curve.nodes[longest + 1]];
    let both = [a, b].map(|n| complex.nodes[n].clone());
    let mut supports: Supports = (both[0].supports.iter().copied())
        .filter(|s| both[1].supports.contains(s))
        .collect();
    let at: Vec<TriangleId> = (stars[a].iter().copied())
        .filter(|&t| complex.triangles[t].nodes.contains(&b))
        .collect();
    for &t in &at {
        supports.push(Support::Mid(complex.triangles[t].wall));
    }
    supports.sort_unstable();
    supports.dedup();
    let middle = complex.nodes.push(MidNode {
        point: (both[0].point + both[1].point) / 2.0,
        supports,
    });
    stars.push(SmallVec::new());
    for t in at {
        let mut other = complex.triangles[t];
        let swap = |n: NodeId, gone: NodeId| if n == gone { middle } else { n };
        other.nodes = other.nodes.map(|n| swap(n, a));
        complex.triangles[t].nodes = complex.triangles[t].nodes.map(|n| swap(n, b));
        let id = complex.triangles.push(other);
        stars[b].retain(|s| *s != t);
        stars[middle].extend([t, id]);
        for n in other.nodes.into_iter().filter(|n| *n != middle) {
            stars[n].push(id);
        }
    }
    curve.nodes.insert(longest + 1, middle);
}

/// Takes one node of a curve away, that with the shortest edges first; whether one could go.
fn contract(
    complex: &mut MidComplex,
    stars: &mut Stars,
    gone: &mut BTreeSet<TriangleId>,
    curve: &mut Curve,
) -> bool {
    let point = |n: NodeId| complex.nodes[n].point;
    let mut inner: Vec<usize> = (1..curve.count()).collect();
    let around = |i: &usize| {
        let [a, b, c] = [i - 1, *i, i + 1].map(|i| point(curve.nodes[i]));
        a.distance(b) + b.distance(c)
    };
    inner.sort_by(|a, b| around(a).total_cmp(&around(b)).then(a.cmp(b)));
    for i in inner {
        let node = curve.nodes[i];
        for to in [curve.nodes[i - 1], curve.nodes[i + 1]] {
            if !may_go(complex, stars, node, to) {
                continue;
            }
            for t in std::mem::take(&mut stars[node]) {
                let nodes = complex.triangles[t].nodes;
                if nodes.contains(&to) {
                    gone.insert(t);
                    nodes.iter().for_each(|&n| stars[n].retain(|s| *s != t));
                } else {
                    complex.triangles[t].nodes = nodes.map(|n| if n == node { to } else { n });
                    stars[to].push(t);
                }
            }
            curve.nodes.remove(i);
            return true;
        }
    }
    false
}

/// Whether a node may be drawn into a neighbour: the link condition holds, and no triangle turns over.
fn may_go(complex: &MidComplex, stars: &Stars, node: NodeId, to: NodeId) -> bool {
    let others = |n: NodeId| -> BTreeSet<NodeId> {
        let corners = stars[n].iter().flat_map(|&t| complex.triangles[t].nodes);
        corners.filter(|m| *m != n).collect()
    };
    let apexes: BTreeSet<NodeId> = (stars[node].iter())
        .filter(|&&t| complex.triangles[t].nodes.contains(&to))
        .flat_map(|&t| complex.triangles[t].nodes)
        .filter(|n| *n != node && *n != to)
        .collect();
    let common: BTreeSet<NodeId> = others(node).intersection(&others(to)).copied().collect();
    common == apexes
        && stars[node].iter().all(|&t| {
            let triangle = &complex.triangles[t];
            let nodes = triangle.nodes.map(|n| if n == node { to } else { n });
            let moved = MidTriangle { nodes, ..*triangle };
            triangle.nodes.contains(&to)
                || complex
                    .area_vector(&moved)
                    .dot(complex.area_vector(triangle))
                    > 0.0
        })
}

/// Nodes of a curve moved along it: all edges equally long, or as they were but for the difference in their number.
fn spread(new: &mut MidComplex, line: &[DVec3], curve: &Curve, placer: &dyn Placer) {
    let old = line.len() - 1;
    if !curve.even && old == curve.count() {
        return;
    }
    // How far along the curve each of its old nodes lies.
    let mut along = vec![0.0];
    for pair in line.windows(2) {
        let step = if curve.even {
            pair[0].distance(pair[1])
        } else {
            1.0
        };
        along.push(along[along.len() - 1] + step);
    }
    let whole = along[old];
    for (j, &n) in curve.nodes.iter().enumerate().take(curve.count()).skip(1) {
        let far = whole * j as f64 / curve.count() as f64;
        let i = (along.partition_point(|&a| a <= far) - 1).min(old - 1);
        let share = (far - along[i]) / (along[i + 1] - along[i]);
        let start = line[i].lerp(line[i + 1], share);
        let placed = placer.place(start, &new.nodes[n].supports);
        // A place far off is another branch of the surface.
        let near = placed.is_finite() && placed.distance(start) < line[i].distance(line[i + 1]);
        new.nodes[n].point = if near { placed } else { start };
    }
}
