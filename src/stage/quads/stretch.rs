//! Stretch: which way the squares of a sheet were laid long, and how much, so that smoothing leaves them so.

use glam::{DMat3, DVec3};

/// Halves of squares of sides up to this ratio are no longer one way than the other: what a front leaves in a gap.
const LEAST: f64 = 1.5;

/// For each triangle the direction in which the halves of squares round it are long, as long as their sides' ratio; zero where they are about square.
pub(super) fn stretches(points: &[DVec3], triangles: &[[u32; 3]]) -> Vec<DVec3> {
    let mut at = vec![DMat3::ZERO; points.len()];
    for t in triangles {
        let mut sides = [0, 1, 2].map(|k| points[t[(k + 1) % 3] as usize] - points[t[k] as usize]);
        sides.sort_by(|a, b| a.length_squared().total_cmp(&b.length_squared()));
        // The two that stand at right angles: with the third their sum would lean to it.
        let legs = outer(sides[0]) + outer(sides[1]);
        t.iter().for_each(|&n| at[n as usize] += legs);
    }
    (triangles.iter())
        .map(|t| {
            let [a, b, c] = t.map(|n| points[n as usize]);
            let sum = t.iter().map(|&n| at[n as usize]).sum::<DMat3>();
            stretch(sum, (b - a).cross(c - a).normalize_or_zero())
        })
        .collect()
}

fn outer(v: DVec3) -> DMat3 {
    DMat3::from_cols(v * v.x, v * v.y, v * v.z)
}

/// The long axis of the ellipse of a tensor in the plane across the normal.
fn stretch(tensor: DMat3, normal: DVec3) -> DVec3 {
    if normal == DVec3::ZERO {
        return DVec3::ZERO;
    }
    let (x, y) = normal.any_orthonormal_pair();
    let (xx, xy, yy) = (x.dot(tensor * x), x.dot(tensor * y), y.dot(tensor * y));
    let (mean, spread) = ((xx + yy) / 2.0, ((xx - yy) / 2.0).hypot(xy));
    let ratio = ((mean + spread) / (mean - spread)).sqrt();
    if !(ratio.is_finite() && ratio >= LEAST) {
        return DVec3::ZERO;
    }
    let angle = xy.atan2((xx - yy) / 2.0) / 2.0;
    (x * angle.cos() + y * angle.sin()) * ratio
}

/// A vector as it is where that stretch is undone.
pub(super) fn undone(vector: DVec3, stretch: DVec3) -> DVec3 {
    scaled(vector, stretch, |ratio| 1.0 / ratio)
}

/// A vector with the stretch.
pub(super) fn done(vector: DVec3, stretch: DVec3) -> DVec3 {
    scaled(vector, stretch, |ratio| ratio)
}

/// A vector with its part along the stretch made longer or shorter.
fn scaled(vector: DVec3, stretch: DVec3, by: impl Fn(f64) -> f64) -> DVec3 {
    if stretch == DVec3::ZERO {
        return vector;
    }
    let ratio = stretch.length();
    let axis = stretch / ratio;
    vector + axis * axis.dot(vector) * (by(ratio) - 1.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Halves of rectangles `long` by 1 along a slanted direction, diagonals both ways.
    fn rectangles(long: f64) -> (Vec<DVec3>, Vec<[u32; 3]>) {
        let axis = DVec3::new(0.6, 0.8, 0.0);
        let side = DVec3::new(-0.8, 0.6, 0.0);
        let at = |i: u32, j: u32| 5 * j + i;
        let points = (0..25u32)
            .map(|k| axis * long * f64::from(k % 5) + side * f64::from(k / 5))
            .collect();
        let mut triangles = Vec::new();
        for (i, j) in (0..16).map(|k| (k % 4, k / 4)) {
            let [a, b, c, d] = [at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)];
            triangles.extend(match (i + j) % 2 {
                0 => [[a, b, c], [a, c, d]],
                _ => [[a, b, d], [b, c, d]],
            });
        }
        (points, triangles)
    }

    #[test]
    fn long_rectangles_are_long_along_their_axis_and_squares_no_way() {
        let (points, triangles) = rectangles(3.0);
        for s in stretches(&points, &triangles) {
            assert!((s.length() - 3.0).abs() < 1e-9);
            assert!(s.cross(DVec3::new(0.6, 0.8, 0.0)).length() < 1e-9);
        }
        for long in [1.0, 1.4] {
            let (points, triangles) = rectangles(long);
            assert!(
                stretches(&points, &triangles)
                    .iter()
                    .all(|s| *s == DVec3::ZERO)
            );
        }
    }

    #[test]
    fn what_is_undone_and_done_is_as_before() {
        let stretch = DVec3::new(0.0, 4.0, 0.0);
        let v = DVec3::new(1.0, 2.0, 3.0);
        assert_eq!(undone(v, stretch), DVec3::new(1.0, 0.5, 3.0));
        assert!(done(undone(v, stretch), stretch).distance(v) < 1e-12);
        assert_eq!(done(v, DVec3::ZERO), v);
    }

    #[test]
    fn a_triangle_without_area_has_none() {
        let points = [DVec3::ZERO, DVec3::X, 2.0 * DVec3::X];
        assert_eq!(stretches(&points, &[[0, 1, 2]]), [DVec3::ZERO]);
    }
}
