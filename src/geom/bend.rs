//! How a triangle with normals at its corners bends: its principal curvatures.

use glam::{DMat2, DVec2, DVec3};

/// The principal curvatures of a triangle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bend {
    /// Unit direction in which it bends most, in the plane of the triangle.
    pub way: DVec3,
    /// Curvature that way, 1/mm; above zero where the triangle bulges towards its normals.
    pub most: f64,
    /// Curvature at right angles to it, of lesser size.
    pub least: f64,
}

/// The bend of a triangle with these unit normals at its corners; zero where it is flat, not finite where it has no area.
///
/// The normals are taken to change linearly over it (Rusinkiewicz 2004, doi:10.1109/TDPVT.2004.1335277).
pub fn bend(p: [DVec3; 3], normals: [DVec3; 3]) -> Bend {
    let [u, v] = [p[1] - p[0], p[2] - p[0]];
    let (x, y) = (u.cross(v).normalize_or(DVec3::Z)).any_orthonormal_pair();
    let flat = |w: DVec3| DVec2::new(w.dot(x), w.dot(y));
    let sides = DMat2::from_cols(flat(u), flat(v));
    let turns = DMat2::from_cols(flat(normals[1] - normals[0]), flat(normals[2] - normals[0]));
    let change = turns * sides.inverse();
    let (xx, yy) = (change.x_axis.x, change.y_axis.y);
    let xy = (change.x_axis.y + change.y_axis.x) / 2.0;
    let (mean, spread) = ((xx + yy) / 2.0, ((xx - yy) / 2.0).hypot(xy));
    // The axis of the greater of the two; where that is of lesser size, the other is at right angles.
    let angle = xy.atan2((xx - yy) / 2.0) / 2.0;
    let way = x * angle.cos() + y * angle.sin();
    if mean >= 0.0 {
        let [most, least] = [mean + spread, mean - spread];
        return Bend { way, most, least };
    }
    Bend {
        way: y * angle.cos() - x * angle.sin(),
        most: mean - spread,
        least: mean + spread,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Three points of a surface, with its normals.
    fn of(point: impl Fn(f64, f64) -> (DVec3, DVec3)) -> Bend {
        let all = [(0.0, 0.0), (0.2, 0.05), (-0.04, 0.2)].map(|(u, v)| point(u, v));
        bend(all.map(|a| a.0), all.map(|a| a.1))
    }

    #[test]
    fn a_cylinder_bends_round_its_axis_only() {
        let bulging = |u: f64, v: f64| {
            let out = DVec3::new(u.cos(), u.sin(), 0.0);
            (4.0 * out + v * DVec3::Z, out)
        };
        let bend = of(bulging);
        assert!((bend.most - 0.25).abs() < 6e-3 && bend.least.abs() < 6e-3);
        assert!(bend.way.z.abs() < 0.05);
        let hollow = of(|u, v| {
            let (p, n) = bulging(u, v);
            (p, -n)
        });
        assert!((hollow.most + 0.25).abs() < 6e-3 && hollow.least.abs() < 6e-3);
        assert!(hollow.way.z.abs() < 0.05);
    }

    #[test]
    fn a_saddle_has_both_signs_and_a_plane_none() {
        // z = (x^2 - 2 y^2) / 20: curvatures -0.1 along x and 0.2 along y, by the upward normal.
        let saddle = of(|u, v| {
            let normal = DVec3::new(-u / 10.0, v / 5.0, 1.0).normalize();
            (DVec3::new(u, v, (u * u - 2.0 * v * v) / 20.0), normal)
        });
        assert!((saddle.most - 0.2).abs() < 6e-3 && (saddle.least + 0.1).abs() < 6e-3);
        assert!(saddle.way.y.abs() > 0.999);
        let flat = of(|u, v| (DVec3::new(u, v, 0.0), DVec3::Z));
        assert_eq!((flat.most, flat.least), (0.0, 0.0));
    }

    #[test]
    fn what_has_no_area_has_no_bend() {
        let bend = bend([DVec3::ZERO, DVec3::X, 2.0 * DVec3::X], [DVec3::Z; 3]);
        assert!(!bend.most.is_finite());
    }
}
