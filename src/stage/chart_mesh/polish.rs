//! Polishing: free points with a bad triangle beside them look round for a better place.
//!
//! Pattern search for the greatest least quality of a point's triangles in space (optimisation-based smoothing, Freitag & Ollivier-Gooch
//! 1997, doi:10.1002/(SICI)1097-0207(19971115)40:21<3979::AID-NME251>3.0.CO;2-9); never makes the worst triangle of a point worse.

use super::front::Point;
use super::relax::rings;
use super::surface::Surface;
use glam::{DVec2, DVec3};
use std::f64::consts::TAU;

/// Points whose triangles are all better than this are left alone: a right-angled isosceles triangle has 0.87, one of 30, 40, 110 degrees
/// 0.69.
const GOOD: f64 = 0.8;

/// Moves free points (from position `fixed` on) in the chart, `positions` with them.
pub(super) fn polish(
    surface: &Surface,
    points: &mut [Point],
    positions: &mut [DVec3],
    fixed: usize,
    triangles: &[[u32; 3]],
) {
    let (start, ring) = rings(points.len(), triangles);
    // Steps as shares of the size: large ones to get out of a corner, small ones to settle.
    for share in [0.3, 0.2, 0.1, 0.05] {
        for i in fixed..points.len() {
            let own = &ring[start[i] as usize..start[i + 1] as usize];
            let mut best = worst(own, triangles, points, positions);
            if best >= GOOD || own.is_empty() {
                continue;
            }
            let (mut point, mut position) = (points[i], positions[i]);
            let home = points[i].place;
            let Some(spot) = surface.locate(home) else {
                continue;
            };
            let step = share * points[i].size / surface.growth(spot.triangle).sqrt();
            for k in 0..8 {
                let way = DVec2::from_angle(TAU * k as f64 / 8.0);
                points[i].place = surface.snap.place(home + step * way);
                let Some(spot) = surface.locate(points[i].place) else {
                    continue;
                };
                positions[i] = surface.lift(&spot);
                let now = worst(own, triangles, points, positions);
                // A gain below rounding would make the choice depend on the part's position.
                if now > best + 1e-6 {
                    (best, point, position) = (now, points[i], positions[i]);
                }
            }
            points[i] = point;
            positions[i] = position;
        }
    }
}

/// Least quality of some triangles, negative where one is turned over in the chart.
fn worst(own: &[u32], triangles: &[[u32; 3]], points: &[Point], positions: &[DVec3]) -> f64 {
    own.iter()
        .map(|&t| {
            let corners = triangles[t as usize];
            let [a, b, c] = corners.map(|k| points[k as usize].place);
            if (b - a).perp_dot(c - a) <= 0.0 {
                return -1.0;
            }
            quality(corners.map(|k| positions[k as usize]))
        })
        .fold(f64::INFINITY, f64::min)
}

/// Area over the sum of squared sides, 1 for equal sides (mean ratio).
fn quality([a, b, c]: [DVec3; 3]) -> f64 {
    let sides = a.distance_squared(b) + b.distance_squared(c) + c.distance_squared(a);
    let doubled = (b - a).cross(c - a).length();
    if sides > 0.0 {
        2.0 * 3f64.sqrt() * doubled / sides
    } else {
        0.0
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn quality_of_known_triangles() {
        let up = DVec3::new(0.5, 0.75f64.sqrt(), 0.0);
        assert!((quality([DVec3::ZERO, DVec3::X, up]) - 1.0).abs() < 1e-12);
        let right = quality([DVec3::ZERO, DVec3::X, DVec3::Y]);
        assert!((right - 3f64.sqrt() / 2.0).abs() < 1e-12);
        assert_eq!(quality([DVec3::ZERO, DVec3::X, 2.0 * DVec3::X]), 0.0);
        assert_eq!(quality([DVec3::ZERO; 3]), 0.0);
    }
}
