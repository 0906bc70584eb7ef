//! Pinholes: closed rims that were drawn together into one point.
//!
//! A hole whose rim lies on surfaces that meet in a point, inside a lump, ends as a ring of nodes in one place. Its topology is right and has to stay; but the triangles at the ring have no
//! area or fold over. The nodes are put round the place, so near to it that nothing else changes, in the way that leaves the fewest such triangles.
//!
//! Guarantees: only nodes of such rings move, by at most a quarter of the shortest edge that ends there, and only where that makes folded triangles fewer.

use super::rim_loops::{breadths, closed_rims};
use crate::model::complex::{EdgeKind, MidComplex};
use crate::model::ids::{IndexVec, NodeId, TriangleId};
use glam::DVec3;
use smallvec::SmallVec;
use std::collections::BTreeSet;

/// A ring this much smaller than the edges that end there is a point.
const POINT: f64 = 1e-3;
/// How far its nodes may go, as shares of the shortest of these edges; the widest that helps is taken.
const WIDTHS: [f64; 3] = [0.25, 0.1, 0.03];
/// Turns of the ring that are tried; a hole in a flat sheet leaves a third of them.
const TURNS: u32 = 24;
/// A triangle this much lower than its longest side is long has no area.
const FLAT: f64 = 1e-6;

/// Opens all pinholes that fold triangles. The sheets have to be wound one way. How many were opened.
pub fn open_pinholes(complex: &mut MidComplex) -> usize {
    let rings = closed_rims(complex);
    let points = |complex: &MidComplex, ring: &[NodeId]| -> Vec<DVec3> {
        ring.iter().map(|&n| complex.nodes[n].point).collect()
    };
    let mut stars = None;
    let mut beside = None;
    let mut opened = 0;
    for ring in rings {
        let now = points(complex, &ring);
        let stars = stars.get_or_insert_with(|| complex.stars());
        let (middle, [wide, _]) = breadths(&now);
        let own: BTreeSet<NodeId> = ring.iter().copied().collect();
        let at: BTreeSet<TriangleId> = ring
            .iter()
            .flat_map(|&n| stars[n].iter().copied())
            .collect();
        let edges = at.iter().flat_map(|&t| complex.triangles[t].nodes);
        let shortest = edges
            .filter(|n| !own.contains(n))
            .map(|n| complex.nodes[n].point.distance(middle))
            .fold(f64::INFINITY, f64::min);
        if !shortest.is_finite() || wide > POINT * shortest {
            continue;
        }
        let beside = beside.get_or_insert_with(|| neighbours(complex));
        let near: BTreeSet<TriangleId> = (at.iter())
            .flat_map(|&t| beside[t].iter().copied().chain([t]))
            .collect();
        let before = folded(complex, &near, beside);
        if before == 0 {
            continue;
        }
        let normal: DVec3 = at.iter().map(|&t| area(complex, t)).sum();
        let Some(normal) = normal.try_normalize() else {
            continue;
        };
        let (u, v) = normal.any_orthonormal_pair();
        let mut best = (before, now);
        for width in WIDTHS {
            for turn in 0..2 * TURNS {
                let way = if turn < TURNS { 1.0 } else { -1.0 };
                let first = f64::from(turn % TURNS) / f64::from(TURNS);
                for (k, &n) in ring.iter().enumerate() {
                    let share = k as f64 / ring.len() as f64;
                    let (sin, cos) = ((first + way * share) * std::f64::consts::TAU).sin_cos();
                    complex.nodes[n].point = middle + (u * cos + v * sin) * (width * shortest);
                }
                let folds = folded(complex, &near, beside);
                if folds < best.0 {
                    best = (folds, points(complex, &ring));
                }
            }
            if best.0 == 0 {
                break;
            }
        }
        opened += usize::from(best.0 < before);
        for (&n, p) in ring.iter().zip(best.1) {
            complex.nodes[n].point = p;
        }
    }
    opened
}

/// For each triangle those beyond its inner edges.
fn neighbours(complex: &MidComplex) -> IndexVec<TriangleId, SmallVec<[TriangleId; 3]>> {
    let mut beside = IndexVec::filled(SmallVec::new(), complex.triangles.len());
    for edge in complex.edges() {
        if complex.kind(&edge) == EdgeKind::Inner {
            let (s, t) = (edge.triangles[0], edge.triangles[1]);
            beside[s].push(t);
            beside[t].push(s);
        }
    }
    beside
}

fn area(complex: &MidComplex, t: TriangleId) -> DVec3 {
    complex.area_vector(&complex.triangles[t])
}

/// How many of these triangles lie against their neighbours or have no area.
fn folded(
    complex: &MidComplex,
    near: &BTreeSet<TriangleId>,
    beside: &IndexVec<TriangleId, SmallVec<[TriangleId; 3]>>,
) -> usize {
    let is_folded = |t: TriangleId| {
        let own = area(complex, t);
        let [a, b, c] = complex.corners(&complex.triangles[t]);
        let longest = a
            .distance_squared(b)
            .max(b.distance_squared(c))
            .max(c.distance_squared(a));
        let around: DVec3 = beside[t].iter().map(|&s| area(complex, s)).sum();
        2.0 * own.length() <= FLAT * longest || own.dot(around) < 0.0
    };
    near.iter().filter(|&&t| is_folded(t)).count()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::model::complex::{MidNode, MidTriangle};
    use crate::model::ids::WallId;

    /// A flat disc of radius 3 with a hole of this radius, in the plane across the last of three axes.
    fn annulus(radius: f64, axes: [DVec3; 3], count: u32) -> MidComplex {
        let mut complex = MidComplex::default();
        for r in [radius, 3.0] {
            for k in 0..count {
                let (sin, cos) =
                    (std::f64::consts::TAU * f64::from(k) / f64::from(count)).sin_cos();
                complex.nodes.push(MidNode {
                    point: (axes[0] * cos + axes[1] * sin) * r + axes[2] * 7.0,
                    supports: Default::default(),
                });
            }
        }
        for k in 0..count {
            let [a, b] = [k, (k + 1) % count].map(NodeId);
            let [c, d] = [a, b].map(|n| NodeId(n.0 + count));
            for nodes in [[a, c, d], [a, d, b]] {
                complex.triangles.push(MidTriangle {
                    nodes,
                    wall: WallId(0),
                });
            }
        }
        complex
    }

    fn all_folded(complex: &MidComplex) -> usize {
        let all = complex.triangles.ids().collect();
        folded(complex, &all, &neighbours(complex))
    }

    #[test]
    fn a_hole_in_one_point_is_opened_and_nothing_else_moves() {
        let tilted = [
            DVec3::new(2.0, 2.0, 1.0) / 3.0,
            DVec3::new(-2.0, 1.0, 2.0) / 3.0,
            DVec3::new(1.0, -2.0, 2.0) / 3.0,
        ];
        for axes in [[DVec3::X, DVec3::Y, DVec3::Z], tilted] {
            for (count, scale) in [(3, 1.0), (5, 1e-3), (8, 1e3)] {
                let axes = axes.map(|a| a * scale);
                let mut complex = annulus(0.0, axes, count);
                let before = complex.clone();
                assert_eq!(all_folded(&complex), count as usize);
                assert_eq!(open_pinholes(&mut complex), 1);
                assert_eq!(all_folded(&complex), 0);
                for (n, node) in complex.nodes.enumerated() {
                    let moved = node.point.distance(before.nodes[n].point);
                    let most = if n.0 < count { 0.75 * scale } else { 0.0 };
                    assert!(moved <= most * (1.0 + 1e-9), "{n:?} {moved}");
                }
            }
        }
    }

    #[test]
    fn open_holes_stay() {
        let mut complex = annulus(0.5, [DVec3::X, DVec3::Y, DVec3::Z], 6);
        let before = complex.clone();
        assert_eq!(open_pinholes(&mut complex), 0);
        assert_eq!(complex, before);
    }
}
