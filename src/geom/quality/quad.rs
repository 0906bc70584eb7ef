//! Metrics of a quad.

use super::{angle_deg, line_angle_deg, ratio};
use glam::DVec3;

/// Metrics of one quad. Angles in degrees.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct QuadQuality {
    /// Least corner Jacobian over the product of the two edges there; 1 is ideal, 0 or less is not convex.
    pub scaled_jacobian: f64,
    /// Longest edge times perimeter over four areas; 1 is ideal, up to 1.3 acceptable.
    pub aspect_ratio: f64,
    /// Longest edge over shortest: the "aspect" of pre-processors; up to 5 acceptable.
    pub edge_ratio: f64,
    /// Cosine between the two principal axes; 0 is ideal, up to 0.5 acceptable.
    pub skew: f64,
    /// Cross derivative over the shorter principal axis; 0 is ideal, up to 0.7 acceptable.
    pub taper: f64,
    /// Cube of the lesser cosine between opposite corner normals; 1 is flat, from 0.3 acceptable.
    pub warpage: f64,
    /// Twice the least corner area over the squared edges there; 1 is a square, from 0.3 acceptable.
    pub shape: f64,
    /// Largest condition number of the corner Jacobians; 1 is ideal, up to 4 acceptable.
    pub condition: f64,
    /// How far the angles are from 90 degrees, 0 to 1, above 1 where a corner caves in; 0 is ideal.
    pub equiangle_skew: f64,
    /// Angle between the normals of the two triangles, across the worse diagonal; up to 15 acceptable.
    pub warp_deg: f64,
    /// Least over largest Jacobian at the 2 x 2 Gauss points; from 0.7 acceptable.
    pub gauss_jacobian_ratio: f64,
    /// 90 degrees less the angle between the lines that join opposite mid-sides (Nastran's Q4 skew is that angle); up to 60 acceptable.
    pub skew_deg: f64,
    /// Nastran GEOMCHECK taper: largest difference of a corner triangle from half of the quad, relative.
    pub corner_taper: f64,
    /// Nastran GEOMCHECK warp: distance of the corners from the mean plane over the mean diagonal.
    pub plane_warp: f64,
    /// Smallest angle.
    pub min_angle_deg: f64,
    /// Largest angle; of a corner that caves in, that on the inside of the quad, above 180.
    pub max_angle_deg: f64,
    /// Shortest edge.
    pub shortest: f64,
    /// Area seen along the mean normal.
    pub area: f64,
}

/// All metrics of the quad with these corners, in order round it.
pub fn quad_quality(p: [DVec3; 4]) -> QuadQuality {
    let edge: [DVec3; 4] = std::array::from_fn(|k| p[(k + 1) % 4] - p[k]);
    let length = edge.map(DVec3::length);
    let longest = length.iter().copied().fold(0.0, f64::max);
    let shortest = length.iter().copied().fold(f64::INFINITY, f64::min);
    let (x1, x2) = (edge[0] - edge[2], edge[1] - edge[3]);
    let x12 = p[0] - p[1] + p[2] - p[3];
    let corner: [DVec3; 4] = std::array::from_fn(|k| edge[(k + 3) % 4].cross(edge[k]));
    let centre = x1.cross(x2).normalize_or_zero();
    let a = corner.map(|n| centre.dot(n));
    let area = a.iter().sum::<f64>() / 4.0;
    let least = |f: &dyn Fn(usize) -> f64| (0..4).map(f).fold(f64::INFINITY, f64::min);
    let squares = |k: usize| length[k].powi(2) + length[(k + 3) % 4].powi(2);
    let angles: [f64; 4] = std::array::from_fn(|k| match angle_deg(edge[k], -edge[(k + 3) % 4]) {
        outside if a[k] < 0.0 => 360.0 - outside,
        inside => inside,
    });
    let min_angle_deg = angles.iter().copied().fold(f64::INFINITY, f64::min);
    let max_angle_deg = angles.iter().copied().fold(0.0, f64::max);
    let unit = corner.map(DVec3::normalize_or_zero);
    let shape = least(&|k| {
        let s = squares(k);
        if s > 0.0 { 2.0 * a[k] / s } else { 0.0 }
    })
    .max(0.0);
    let (diagonal0, diagonal1) = (p[2] - p[0], p[3] - p[1]);
    QuadQuality {
        scaled_jacobian: least(&|k| {
            let l = length[k] * length[(k + 3) % 4];
            if l > 0.0 { a[k] / l } else { 0.0 }
        }),
        aspect_ratio: ratio(longest * length.iter().sum::<f64>(), 4.0 * area),
        edge_ratio: ratio(longest, shortest),
        skew: x1.normalize_or_zero().dot(x2.normalize_or_zero()).abs(),
        taper: ratio(x12.length(), x1.length().min(x2.length())),
        warpage: unit[0].dot(unit[2]).min(unit[1].dot(unit[3])).powi(3),
        shape,
        condition: ratio(1.0, shape),
        equiangle_skew: ((max_angle_deg - 90.0) / 90.0).max((90.0 - min_angle_deg) / 90.0),
        warp_deg: angle_deg(corner[0], corner[2]).max(angle_deg(corner[1], corner[3])),
        gauss_jacobian_ratio: gauss_jacobian_ratio(a),
        skew_deg: 90.0 - line_angle_deg(x1, x2),
        corner_taper: a
            .iter()
            .map(|a| ratio((a - area).abs(), area))
            .fold(0.0, f64::max),
        plane_warp: ratio(
            x12.dot(centre).abs() / 4.0,
            (diagonal0.length() + diagonal1.length()) / 2.0,
        ),
        min_angle_deg,
        max_angle_deg,
        shortest,
        area,
    }
}

/// The Jacobian is bilinear over the quad, so that its corner values give those at the Gauss points.
fn gauss_jacobian_ratio(corner: [f64; 4]) -> f64 {
    let (far, near) = (
        (1.0 - 1.0 / 3.0_f64.sqrt()) / 2.0,
        (1.0 + 1.0 / 3.0_f64.sqrt()) / 2.0,
    );
    let at = |k: usize| {
        near * near * corner[k]
            + near * far * (corner[(k + 1) % 4] + corner[(k + 3) % 4])
            + far * far * corner[(k + 2) % 4]
    };
    let values: [f64; 4] = std::array::from_fn(at);
    let low = values.iter().copied().fold(f64::INFINITY, f64::min);
    let high = values.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    if high > 0.0 { low / high } else { -1.0 }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn near(a: f64, b: f64) {
        assert!((a - b).abs() < 1e-12, "{a} is not {b}");
    }

    fn flat(p: [[f64; 2]; 4]) -> [DVec3; 4] {
        p.map(|[x, y]| DVec3::new(x, y, 0.0))
    }

    #[test]
    fn square_is_ideal() {
        let q = quad_quality(flat([[1., 1.], [3., 1.], [3., 3.], [1., 3.]]));
        for (value, truth) in [
            (q.scaled_jacobian, 1.0),
            (q.aspect_ratio, 1.0),
            (q.edge_ratio, 1.0),
            (q.skew, 0.0),
            (q.taper, 0.0),
            (q.warpage, 1.0),
            (q.shape, 1.0),
            (q.condition, 1.0),
            (q.equiangle_skew, 0.0),
            (q.warp_deg, 0.0),
            (q.gauss_jacobian_ratio, 1.0),
            (q.skew_deg, 0.0),
            (q.corner_taper, 0.0),
            (q.plane_warp, 0.0),
            (q.min_angle_deg, 90.0),
            (q.max_angle_deg, 90.0),
            (q.shortest, 2.0),
            (q.area, 4.0),
        ] {
            near(value, truth);
        }
    }

    #[test]
    fn rectangle_two_by_one() {
        let q = quad_quality(flat([[0., 0.], [2., 0.], [2., 1.], [0., 1.]]));
        near(q.scaled_jacobian, 1.0);
        near(q.aspect_ratio, 2.0 * 6.0 / 8.0);
        near(q.edge_ratio, 2.0);
        near(q.shape, 2.0 * 2.0 / 5.0);
        near(q.condition, 1.25);
        near(q.gauss_jacobian_ratio, 1.0);
    }

    #[test]
    fn rhombus_of_60_degrees() {
        let h = 0.75_f64.sqrt();
        let q = quad_quality(flat([[0., 0.], [1., 0.], [1.5, h], [0.5, h]]));
        near(q.scaled_jacobian, h);
        near(q.skew, 0.5);
        near(q.skew_deg, 30.0);
        near(q.min_angle_deg, 60.0);
        near(q.max_angle_deg, 120.0);
        near(q.equiangle_skew, 1.0 / 3.0);
        near(q.shape, h);
        near(q.aspect_ratio, 1.0 / h);
        near(q.corner_taper, 0.0);
    }

    #[test]
    fn trapezoid_has_taper() {
        // Parallel sides 4 and 2, height 2: area 6, corner Jacobians 8, 8, 4, 4.
        let q = quad_quality(flat([[0., 0.], [4., 0.], [3., 2.], [1., 2.]]));
        near(q.area, 6.0);
        near(q.taper, 2.0 / 4.0);
        near(q.corner_taper, 1.0 / 3.0);
        let (n, f) = (
            (1.0 + 1.0 / 3.0_f64.sqrt()) / 2.0,
            (1.0 - 1.0 / 3.0_f64.sqrt()) / 2.0,
        );
        near(
            q.gauss_jacobian_ratio,
            (8.0 * f + 4.0 * n) / (8.0 * n + 4.0 * f),
        );
    }

    #[test]
    fn warped_square() {
        // Corners up and down by h over a unit square: opposite corner normals (+-2h, +-2h, 1).
        let h = 0.1;
        let mut p = flat([[0., 0.], [1., 0.], [1., 1.], [0., 1.]]);
        for (k, p) in p.iter_mut().enumerate() {
            p.z = if k % 2 == 0 { h } else { -h };
        }
        let q = quad_quality(p);
        let c = (1.0 - 8.0 * h * h) / (1.0 + 8.0 * h * h);
        near(q.warpage, c.powi(3));
        near(q.warp_deg, c.acos().to_degrees());
        near(q.plane_warp, h / 2.0_f64.sqrt());
        near(q.scaled_jacobian, 1.0 / (1.0 + 4.0 * h * h));
        near(q.area, 1.0);
    }

    #[test]
    fn caved_in_bow_tie_and_collapsed_are_found() {
        let dart = quad_quality(flat([[0., 0.], [4., 0.], [1., 1.], [0., 4.]]));
        assert!(dart.scaled_jacobian < 0.0 && dart.shape == 0.0);
        assert!(dart.condition.is_infinite());
        // On the inside of the caved-in corner.
        let inside = 180.0 + 2.0 * 0.5f64.atan().to_degrees();
        near(dart.max_angle_deg, inside);
        near(dart.equiangle_skew, (inside - 90.0) / 90.0);
        near(dart.min_angle_deg, (1.0f64 / 3.0).atan().to_degrees());
        let bow = quad_quality(flat([[0., 0.], [1., 0.], [0., 1.], [1., 1.]]));
        assert!(bow.scaled_jacobian <= 0.0);
        let triangle = quad_quality(flat([[0., 0.], [1., 0.], [0., 1.], [0., 1.]]));
        assert_eq!(triangle.scaled_jacobian, 0.0);
        let point = quad_quality([DVec3::ONE; 4]);
        assert!(point.scaled_jacobian == 0.0 && point.aspect_ratio.is_infinite());
    }
}
