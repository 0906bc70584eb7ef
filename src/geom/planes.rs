//! Where several planes meet, in the least-squares sense, near a given point: the quadratic error function of dual contouring.
//!
//! Reference: T. Ju, F. Losasso, S. Schaefer, J. Warren, Dual contouring of Hermite data, SIGGRAPH 2002, doi:10.1145/566654.566586.

use glam::DVec3;
use nalgebra::{Matrix3, SymmetricEigen};

/// Directions in which the planes say less than this share of what they say in the best-known direction are left alone. Two unit
/// normals at an angle a have eigenvalues 1 + cos a and 1 - cos a: planes within 15 degrees of each other count as one.
const TRUNCATE: f64 = 0.0175;

/// The smallest step `d` that minimises the sum of (n.d - offset)² over `(n, offset)` with unit normals, nearly parallel planes
/// taken as one.
pub fn meet(planes: &[(DVec3, f64)]) -> DVec3 {
    match planes {
        [] => DVec3::ZERO,
        [(n, offset)] => *n * *offset,
        _ => {
            let mut a = Matrix3::<f64>::zeros();
            let mut b = DVec3::ZERO;
            for (n, offset) in planes {
                let v = nalgebra::Vector3::new(n.x, n.y, n.z);
                a += v * v.transpose();
                b += *n * *offset;
            }
            let eigen = SymmetricEigen::new(a);
            let greatest = eigen.eigenvalues.max();
            let mut step = DVec3::ZERO;
            for k in 0..3 {
                let value = eigen.eigenvalues[k];
                if value > TRUNCATE * greatest {
                    let c = eigen.eigenvectors.column(k);
                    let axis = DVec3::new(c[0], c[1], c[2]);
                    step += axis * (axis.dot(b) / value);
                }
            }
            step
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn three_planes_meet_in_their_point_two_in_the_nearest_point_of_their_line() {
        let three = [
            (DVec3::X, 1.0),
            (DVec3::Y, 2.0),
            ((DVec3::X + DVec3::Z).normalize(), 4.0 / 2f64.sqrt()),
        ];
        assert!((meet(&three) - DVec3::new(1.0, 2.0, 3.0)).length() < 1e-12);
        let two = [
            (DVec3::X, 1.0),
            ((DVec3::X + DVec3::Y).normalize(), 3.0 / 2f64.sqrt()),
        ];
        assert!((meet(&two) - DVec3::new(1.0, 2.0, 0.0)).length() < 1e-12);
    }

    #[test]
    fn nearly_parallel_planes_do_not_send_the_point_away() {
        let tilted = DVec3::new(0.0, 0.1f64.sin(), 0.1f64.cos());
        assert!(meet(&[(DVec3::Z, 1.0), (tilted, 0.9)]).length() < 1.01);
    }
}
