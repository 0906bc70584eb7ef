//! The six-node (second-order) triangle: exact to third order in the element size on a curved face.
//!
//! Parameters (u, v) run over u >= 0, v >= 0, u + v <= 1; corners at (0,0), (1,0), (0,1), mid-side points between corners
//! (0,1), (1,2), (2,0). Shape functions: Zienkiewicz & Taylor, The Finite Element Method, vol. 1, section 8.8.

use glam::DVec3;

/// Position and the two tangents at (u, v).
#[inline]
pub fn frame(corners: &[DVec3; 3], mids: &[DVec3; 3], u: f64, v: f64) -> (DVec3, DVec3, DVec3) {
    let w = 1.0 - u - v;
    let point = corners[0] * (w * (2.0 * w - 1.0))
        + corners[1] * (u * (2.0 * u - 1.0))
        + corners[2] * (v * (2.0 * v - 1.0))
        + mids[0] * (4.0 * w * u)
        + mids[1] * (4.0 * u * v)
        + mids[2] * (4.0 * v * w);
    let du = corners[0] * (1.0 - 4.0 * w)
        + corners[1] * (4.0 * u - 1.0)
        + mids[0] * (4.0 * (w - u))
        + (mids[1] - mids[2]) * (4.0 * v);
    let dv = corners[0] * (1.0 - 4.0 * w)
        + corners[2] * (4.0 * v - 1.0)
        + (mids[1] - mids[0]) * (4.0 * u)
        + mids[2] * (4.0 * (w - v));
    (point, du, dv)
}

/// Unit normal at (u, v), the flat triangle's where the curved one degenerates; zero for a triangle without area.
#[inline]
pub fn normal(corners: &[DVec3; 3], mids: &[DVec3; 3], u: f64, v: f64) -> DVec3 {
    let (_, du, dv) = frame(corners, mids, u, v);
    let curved = du.cross(dv);
    let flat = (corners[1] - corners[0]).cross(corners[2] - corners[0]);
    // A curved normal against the flat one means a folded element: the flat one is the better word then.
    if curved.dot(flat) > 0.1 * curved.length() * flat.length() {
        curved.normalize_or_zero()
    } else {
        flat.normalize_or_zero()
    }
}

/// Parameters of the middle of side `k` (between corners k and k+1).
pub const SIDE_MIDDLE: [(f64, f64); 3] = [(0.5, 0.0), (0.5, 0.5), (0.0, 0.5)];

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn normals_on_a_cylinder_are_radial_to_third_order() {
        let on = |a: f64, z: f64| DVec3::new(a.cos(), a.sin(), z);
        let h = 0.2;
        let corners = [on(0.0, 0.0), on(h, 0.0), on(0.0, h)];
        let mids = [on(h / 2.0, 0.0), on(h / 2.0, h / 2.0), on(0.0, h / 2.0)];
        for (u, v) in SIDE_MIDDLE {
            let (p, ..) = frame(&corners, &mids, u, v);
            let radial = DVec3::new(p.x, p.y, 0.0).normalize();
            assert!(normal(&corners, &mids, u, v).dot(radial) > 1.0 - 1e-5);
        }
        let flat = (corners[1] - corners[0])
            .cross(corners[2] - corners[0])
            .normalize();
        assert!(
            flat.dot(DVec3::X) < 1.0 - 1e-3,
            "the flat triangle is visibly worse"
        );
    }
}
