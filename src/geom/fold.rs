//! When two triangles of one wall that share an edge meet at a fold instead of a bend.

use glam::DVec3;

/// A fold sharper than this stays an edge of the mesh: a bend sampled by fewer than nine flat elements a turn (40 degrees each) cannot
/// be told from a sharp crease.
pub const FOLD_RAD: f64 = 40.0 * std::f64::consts::PI / 180.0;

/// Whether triangles with these normals (of any length), wound the same way, meet at a fold.
pub fn is_fold(n: DVec3, m: DVec3) -> bool {
    n.cross(m).length().atan2(n.dot(m)) > FOLD_RAD
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_fold_begins_at_forty_degrees() {
        let turned = |deg: f64| DVec3::new(0.0, deg.to_radians().sin(), deg.to_radians().cos());
        for (deg, wanted) in [(0.0, false), (39.9, false), (40.1, true), (180.0, true)] {
            assert_eq!(is_fold(DVec3::Z, turned(deg) * 3.0), wanted, "{deg}");
        }
    }
}
