//! Nearest point on a six-node triangle.

use super::six_node::{frame, normal};
use glam::DVec3;

/// Nearest point and unit normal on the six-node triangle, for a point near it.
pub fn nearest_on_quadratic(corners: [DVec3; 3], mids: [DVec3; 3], p: DVec3) -> (DVec3, DVec3) {
    let [a, b, c] = corners;
    let (e, f, g) = (b - a, c - a, p - a);
    let n = e.cross(f);
    let d = n.length_squared();
    if d == 0.0 {
        return (a, DVec3::ZERO);
    }
    let (mut u, mut v) = clamp(g.cross(f).dot(n) / d, e.cross(g).dot(n) / d, e, f);
    let flat = (0..3).all(|k| {
        let m = (corners[k] + corners[(k + 1) % 3]) / 2.0;
        (mids[k] - m).length_squared() < 1e-22 * d.sqrt()
    });
    if flat {
        return (a + e * u + f * v, n / d.sqrt());
    }
    for _ in 0..10 {
        let (x, du, dv) = frame(&corners, &mids, u, v);
        let r = p - x;
        // Gauss-Newton: the second derivatives of the patch matter little as long as the point is near against its radius.
        let (aa, ab, bb) = (du.dot(du), du.dot(dv), dv.dot(dv));
        let det = aa * bb - ab * ab;
        if det <= 0.0 {
            break;
        }
        let (ra, rb) = (du.dot(r), dv.dot(r));
        let (nu, nv) = clamp(
            u + (ra * bb - rb * ab) / det,
            v + (rb * aa - ra * ab) / det,
            du,
            dv,
        );
        let moved = (nu - u).abs() + (nv - v).abs();
        (u, v) = (nu, nv);
        if moved < 1e-12 {
            break;
        }
    }
    (
        frame(&corners, &mids, u, v).0,
        normal(&corners, &mids, u, v),
    )
}

/// The nearest parameters inside the triangle, in the metric of the tangents.
fn clamp(u: f64, v: f64, du: DVec3, dv: DVec3) -> (f64, f64) {
    if u >= 0.0 && v >= 0.0 && u + v <= 1.0 {
        return (u, v);
    }
    let q = du * u + dv * v;
    let mut best = (f64::INFINITY, 0.0, 0.0);
    for (s, t) in [
        ((0.0, 0.0), (1.0, 0.0)),
        ((1.0, 0.0), (0.0, 1.0)),
        ((0.0, 1.0), (0.0, 0.0)),
    ] {
        let (p, e) = (du * s.0 + dv * s.1, du * (t.0 - s.0) + dv * (t.1 - s.1));
        let x = ((q - p).dot(e) / e.length_squared().max(f64::MIN_POSITIVE)).clamp(0.0, 1.0);
        let d = (p + e * x - q).length_squared();
        if d < best.0 {
            best = (d, s.0 + (t.0 - s.0) * x, s.1 + (t.1 - s.1) * x);
        }
    }
    (best.1, best.2)
}
