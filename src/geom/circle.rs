//! The circle through points of a plane.

use glam::{DVec2, DVec3};
use nalgebra::{Matrix3, Vector3};

/// Middle and radius of the circle that fits the points best (least squares of the squared distance: Kåsa 1976, doi:10.1109/TIM.1976.6312298); exact where they lie on one.
/// `None` where they lie on a line.
pub fn fit_circle(points: &[DVec2]) -> Option<(DVec2, f64)> {
    let count = points.len() as f64;
    let middle = points.iter().sum::<DVec2>() / count;
    // About the middle and in its own size, or squares lose digits.
    let size = points
        .iter()
        .map(|p| p.distance(middle))
        .fold(0.0, f64::max);
    if points.len() < 3 || size.is_nan() || size <= 0.0 {
        return None;
    }
    let (mut normal, mut right) = (Matrix3::zeros(), Vector3::zeros());
    for p in points {
        let q = (p - middle) / size;
        let row = Vector3::new(q.x, q.y, 1.0);
        normal += row * row.transpose();
        right += row * q.length_squared();
    }
    let solved = normal.cholesky()?.solve(&right);
    let centre = DVec2::new(solved.x, solved.y) / 2.0;
    let radius = (solved.z + centre.length_squared()).sqrt();
    let usable = centre.is_finite() && radius.is_finite() && radius < 1e3;
    usable.then(|| (middle + centre * size, radius * size))
}

/// Axes of a plane in space: places in it and heights above it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Plane {
    /// Where its axes begin, mm.
    pub origin: DVec3,
    /// Unit axes; the third is the normal.
    pub axes: [DVec3; 3],
}

impl Plane {
    /// The plane through `origin` across the unit vector `normal`.
    pub fn new(origin: DVec3, normal: DVec3) -> Self {
        let (u, v) = normal.any_orthonormal_pair();
        let axes = [u, v, normal];
        Self { origin, axes }
    }

    /// The place below or above a point.
    pub fn flat(&self, p: DVec3) -> DVec2 {
        let [u, v, _] = self.axes;
        DVec2::new((p - self.origin).dot(u), (p - self.origin).dot(v))
    }

    /// How far a point lies above it.
    pub fn height(&self, p: DVec3) -> f64 {
        (p - self.origin).dot(self.axes[2])
    }

    /// The point above a place.
    pub fn space(&self, q: DVec2, height: f64) -> DVec3 {
        let [u, v, n] = self.axes;
        self.origin + u * q.x + v * q.y + n * height
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn points_of_a_circle_give_it_back_however_few_and_far() {
        for (count, turn) in [(3, 1.0), (7, 1.0), (40, 0.2)] {
            let centre = DVec2::new(1e4, -3e3);
            let at = |i: i32| {
                centre
                    + 2.5
                        * DVec2::from_angle(
                            turn * std::f64::consts::TAU * f64::from(i) / f64::from(count),
                        )
            };
            let points: Vec<DVec2> = (0..count).map(at).collect();
            let (found, radius) = fit_circle(&points).unwrap();
            assert!(found.distance(centre) < 1e-8 && (radius - 2.5).abs() < 1e-8);
        }
    }

    #[test]
    fn a_line_and_a_point_have_none() {
        let line: Vec<DVec2> = (0..5).map(|i| DVec2::splat(f64::from(i))).collect();
        assert_eq!(fit_circle(&line), None);
        assert_eq!(fit_circle(&[DVec2::ONE; 4]), None);
        assert_eq!(fit_circle(&[]), None);
    }

    #[test]
    fn places_and_heights_give_the_point_back() {
        let plane = Plane::new(DVec3::new(1.0, 2.0, 3.0), DVec3::new(2.0, -3.0, 6.0) / 7.0);
        let p = DVec3::new(-4.0, 0.5, 9.0);
        let again = plane.space(plane.flat(p), plane.height(p));
        assert!(again.distance(p) < 1e-12);
    }
}
