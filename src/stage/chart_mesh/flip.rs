//! Edge flips towards Delaunay in space: two triangles that share an edge are exchanged for the other two of the same quad where the angles
//! opposite to the edge add up to more than half a turn (Lawson 1977). Where lengths differ by direction, angles are those after stretching.

use super::directed::Frame;
use super::front::Point;
use glam::{DMat3, DVec3};

/// Flips until no edge asks for it, at most a few sweeps; only where the quad is convex in the chart, and never to an edge between two
/// fixed points (the first `fixed` ones), which another patch may have too. `metrics` measure vectors at each point, see [`metric`].
pub(super) fn flip(
    points: &[Point],
    positions: &[DVec3],
    metrics: &[DMat3],
    fixed: usize,
    kept: &[[u32; 2]],
    triangles: &mut [[u32; 3]],
) {
    // The mesh is Delaunay in a nearly isometric chart: a few edges in a hundred turn, seldom twice.
    for _ in 0..4 {
        let mut sides: Vec<([u32; 2], u32, u8)> = Vec::with_capacity(3 * triangles.len());
        for (i, t) in triangles.iter().enumerate() {
            for k in 0..3 {
                let (a, b) = (t[k], t[(k + 1) % 3]);
                sides.push(([a.min(b), a.max(b)], i as u32, k as u8));
            }
        }
        sides.sort_unstable();
        let mut stale = vec![false; triangles.len()];
        let mut changed = false;
        for pair in sides.windows(2) {
            let ((edge, s, k), (other, t, j)) = (pair[0], pair[1]);
            let (s, t) = (s as usize, t as usize);
            if edge != other || stale[s] || stale[t] || kept.binary_search(&edge).is_ok() {
                continue;
            }
            let at = |t: usize, k: u8, by: usize| triangles[t][(k as usize + by) % 3];
            let (a, b) = (at(s, k, 0), at(s, k, 1));
            let (c, d) = (at(s, k, 2), at(t, j, 2));
            if at(t, j, 0) != b || ((c as usize) < fixed && (d as usize) < fixed) {
                continue;
            }
            let metric: Option<DMat3> = (metrics.first())
                .map(|_| [a, b, c, d].map(|i| metrics[i as usize]).into_iter().sum());
            let angle = |apex: u32| {
                let p = positions[apex as usize];
                let [u, v] = [a, b].map(|i| positions[i as usize] - p);
                match metric {
                    None => u.angle_between(v),
                    Some(m) => {
                        let size = (u.dot(m * u) * v.dot(m * v)).sqrt();
                        (u.dot(m * v) / size).clamp(-1.0, 1.0).acos()
                    }
                }
            };
            // A hair above half a turn, so that rounding cannot turn an edge to and fro.
            if angle(c) + angle(d) <= std::f64::consts::PI * (1.0 + 1e-9) {
                continue;
            }
            let area = |a: u32, b: u32, c: u32| {
                let [a, b, c] = [a, b, c].map(|i| points[i as usize].place);
                (b - a).perp_dot(c - a)
            };
            if area(d, c, a) <= 0.0 || area(c, d, b) <= 0.0 {
                continue;
            }
            triangles[s] = [d, c, a];
            triangles[t] = [c, d, b];
            stale[s] = true;
            stale[t] = true;
            changed = true;
        }
        if !changed {
            return;
        }
    }
}

/// The metric in which the directions' wanted lengths are one, each (a vector's length squared by it is `v.dot(m * v)`).
pub(super) fn metric(frame: &Frame) -> DMat3 {
    let along = |i: usize| {
        let way = frame.ways[i] / frame.lengths[i];
        DMat3::from_cols(way * way.x, way * way.y, way * way.z)
    };
    along(0) + along(1)
}
