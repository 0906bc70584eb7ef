//! Metrics of a triangle.

use super::{angle_deg, line_angle_deg, ratio};
use glam::DVec3;

/// Metrics of one triangle. Angles in degrees.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TriangleQuality {
    /// Longest edge times perimeter over 4 sqrt(3) area; 1 is ideal, up to 1.3 acceptable.
    pub aspect_ratio: f64,
    /// Longest edge over shortest; 1 is ideal, up to 5 acceptable.
    pub edge_ratio: f64,
    /// Radius of the circle outside over twice that inside; 1 is ideal, up to 3 acceptable.
    pub radius_ratio: f64,
    /// Sine of the angle between the two longest edges, scaled so that an equilateral triangle has 1; from 0.5 acceptable.
    pub scaled_jacobian: f64,
    /// Smallest angle.
    pub min_angle_deg: f64,
    /// Largest angle.
    pub max_angle_deg: f64,
    /// 90 degrees less the smallest angle between a median and the line that joins the middles of the two sides beside it; 0 is ideal.
    pub skew_deg: f64,
    /// Shortest edge.
    pub shortest: f64,
    /// Area.
    pub area: f64,
}

/// All metrics of the triangle with these corners.
pub fn triangle_quality(p: [DVec3; 3]) -> TriangleQuality {
    let edge = [p[1] - p[0], p[2] - p[1], p[0] - p[2]];
    let length = edge.map(DVec3::length);
    let longest = length[0].max(length[1]).max(length[2]);
    let shortest = length[0].min(length[1]).min(length[2]);
    let perimeter: f64 = length.iter().sum();
    let double_area = edge[0].cross(-edge[2]).length();
    let area = double_area / 2.0;
    let product = length[0] * length[1] * length[2];
    let largest_pair = (length[0] * length[1])
        .max(length[1] * length[2])
        .max(length[2] * length[0]);
    let angles: [f64; 3] = std::array::from_fn(|k| angle_deg(edge[k], -edge[(k + 2) % 3]));
    let mut skew_deg = 0.0_f64;
    for k in 0..3 {
        let (a, b, c) = (p[k], p[(k + 1) % 3], p[(k + 2) % 3]);
        skew_deg = skew_deg.max(90.0 - line_angle_deg((b + c) / 2.0 - a, c - b));
    }
    TriangleQuality {
        aspect_ratio: ratio(longest * perimeter, 4.0 * 3.0_f64.sqrt() * area),
        edge_ratio: ratio(longest, shortest),
        // R = abc / 4A and r = 2A / perimeter.
        radius_ratio: ratio(product * perimeter, 16.0 * area * area),
        scaled_jacobian: if largest_pair > 0.0 {
            2.0 / 3.0_f64.sqrt() * double_area / largest_pair
        } else {
            0.0
        },
        min_angle_deg: angles[0].min(angles[1]).min(angles[2]),
        max_angle_deg: angles[0].max(angles[1]).max(angles[2]),
        skew_deg,
        shortest,
        area,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn near(a: f64, b: f64) {
        assert!((a - b).abs() < 1e-12, "{a} is not {b}");
    }

    #[test]
    fn equilateral_is_ideal_at_any_size_and_place() {
        for size in [1e-3, 1.0, 1e4] {
            let at = DVec3::new(3.0, -2.0, 5.0) * size;
            let q = triangle_quality([
                at,
                at + DVec3::X * size,
                at + DVec3::new(0.5, 0.0, 0.75_f64.sqrt()) * size,
            ]);
            near(q.aspect_ratio, 1.0);
            near(q.edge_ratio, 1.0);
            near(q.radius_ratio, 1.0);
            near(q.scaled_jacobian, 1.0);
            near(q.min_angle_deg, 60.0);
            near(q.max_angle_deg, 60.0);
            near(q.skew_deg, 0.0);
            near(q.area / (size * size), 3.0_f64.sqrt() / 4.0);
        }
    }

    #[test]
    fn right_triangle_3_4_5() {
        let q = triangle_quality([DVec3::ZERO, DVec3::X * 3.0, DVec3::Y * 4.0]);
        near(q.area, 6.0);
        near(q.aspect_ratio, 60.0 / (24.0 * 3.0_f64.sqrt()));
        near(q.edge_ratio, 5.0 / 3.0);
        // Radius outside 2.5, inside 1.
        near(q.radius_ratio, 1.25);
        near(q.scaled_jacobian, 2.0 / 3.0_f64.sqrt() * 12.0 / 20.0);
        near(q.min_angle_deg, 0.6_f64.asin().to_degrees());
        near(q.max_angle_deg, 90.0);
        near(q.shortest, 3.0);
    }

    #[test]
    fn a_line_and_a_point_are_the_worst() {
        let line = triangle_quality([DVec3::ZERO, DVec3::X, DVec3::X * 3.0]);
        assert_eq!(line.scaled_jacobian, 0.0);
        assert!(line.aspect_ratio.is_infinite() && line.radius_ratio.is_infinite());
        assert_eq!((line.min_angle_deg, line.max_angle_deg), (0.0, 180.0));
        let point = triangle_quality([DVec3::ONE; 3]);
        assert!(point.edge_ratio.is_infinite() && point.scaled_jacobian == 0.0);
    }
}
