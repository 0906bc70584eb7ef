//! Measures of one triangle, and the guard that keeps an operation from turning it over.

use glam::DVec3;

/// Cosine of the largest turn of a triangle's normal in one operation: 60 degrees, beyond which a surface folds.
const LARGEST_TURN: f64 = 0.5;
/// Cosine of the largest angle between a triangle and the mid-surface under it: 75 degrees, so that a fold (past 90) keeps a distance.
const LARGEST_TILT: f64 = 0.26;
/// Below this quality (a needle of 1 : 40) rounding and noise, not the surface, decide where a triangle's normal points.
const TRUSTED: f64 = 0.05;

/// Twice the area, along the normal.
#[inline]
pub(super) fn area_vector([a, b, c]: [DVec3; 3]) -> DVec3 {
    (b - a).cross(c - a)
}

/// Shape: 4 sqrt 3 area / sum of squared sides; 1 for the equilateral triangle, 0 for a degenerate one.
#[inline]
pub(super) fn quality(p: [DVec3; 3]) -> f64 {
    let sides = sides_squared(p);
    let sum = sides[0] + sides[1] + sides[2];
    if sum > 0.0 {
        2.0 * 3f64.sqrt() * area_vector(p).length() / sum
    } else {
        0.0
    }
}

/// Quality with the sign of the side that the triangle shows; it fades where the triangle leans further than 60 degrees from the surface.
/// Without a known normal (`reference` zero) the plain quality.
#[inline]
pub(super) fn signed_quality(p: [DVec3; 3], reference: DVec3) -> f64 {
    if reference == DVec3::ZERO {
        return quality(p);
    }
    let lean = area_vector(p).normalize_or_zero().dot(reference);
    quality(p) * (lean / LARGEST_TURN).clamp(-1.0, 1.0)
}

/// Longest side over shortest side.
pub(super) fn edge_ratio(p: [DVec3; 3]) -> f64 {
    let s = sides_squared(p);
    (s[0].max(s[1]).max(s[2]) / s[0].min(s[1]).min(s[2])).sqrt()
}

/// Smallest and largest angle, radians.
pub(super) fn angles([a, b, c]: [DVec3; 3]) -> [f64; 2] {
    let at = |p: DVec3, q: DVec3, r: DVec3| (q - p).angle_between(r - p);
    let all = [at(a, b, c), at(b, c, a), at(c, a, b)];
    [
        all[0].min(all[1]).min(all[2]),
        all[0].max(all[1]).max(all[2]),
    ]
}

#[inline]
fn sides_squared([a, b, c]: [DVec3; 3]) -> [f64; 3] {
    [
        (b - a).length_squared(),
        (c - b).length_squared(),
        (a - c).length_squared(),
    ]
}

/// Whether a triangle may go from `old` to `new` over a surface with unit normal `reference` (zero where unknown).
///
/// A triangle that has a trustworthy normal may neither turn far in one step nor lean far from the surface. One that is a needle, or
/// that leans already, only has to come closer to the surface than it was.
pub(super) fn may_turn(old: [DVec3; 3], new: [DVec3; 3], reference: DVec3) -> bool {
    let n = area_vector(new).normalize_or_zero();
    if n == DVec3::ZERO {
        return false;
    }
    let before = area_vector(old).normalize_or_zero();
    let (lean, lean_before) = (n.dot(reference), before.dot(reference));
    let known = reference != DVec3::ZERO;
    if quality(old) >= TRUSTED && (!known || lean_before >= LARGEST_TURN) {
        before.dot(n) >= LARGEST_TURN && (!known || lean >= LARGEST_TILT)
    } else if known {
        lean >= LARGEST_TILT || (lean >= lean_before && before.dot(n) >= LARGEST_TURN)
    } else {
        before.dot(n) > 0.0
    }
}

/// Distance of a point from a segment.
pub(super) fn distance_to_segment(p: DVec3, a: DVec3, b: DVec3) -> f64 {
    let d = b - a;
    let squared = d.length_squared();
    let t = if squared > 0.0 {
        ((p - a).dot(d) / squared).clamp(0.0, 1.0)
    } else {
        0.0
    };
    p.distance(a + d * t)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn measures_of_the_equilateral_and_of_the_half_square() {
        let flat = |x: [f64; 6]| {
            [
                DVec3::new(x[0], x[1], 0.0),
                DVec3::new(x[2], x[3], 0.0),
                DVec3::new(x[4], x[5], 0.0),
            ]
        };
        let equal = flat([0.0, 0.0, 1.0, 0.0, 0.5, 0.75f64.sqrt()]);
        assert!((quality(equal) - 1.0).abs() < 1e-12);
        assert!((edge_ratio(equal) - 1.0).abs() < 1e-12);
        let half = flat([0.0, 0.0, 1.0, 0.0, 0.0, 1.0]);
        assert!((quality(half) - 3f64.sqrt() / 2.0).abs() < 1e-12);
        assert!((edge_ratio(half) - 2f64.sqrt()).abs() < 1e-12);
        let [least, most] = angles(half);
        assert!(
            (least.to_degrees() - 45.0).abs() < 1e-9 && (most.to_degrees() - 90.0).abs() < 1e-9
        );
    }

    #[test]
    fn the_guard_refuses_a_triangle_turned_over_and_lets_a_folded_one_unfold() {
        let up = [DVec3::ZERO, DVec3::X, DVec3::Y];
        let down = [DVec3::ZERO, DVec3::Y, DVec3::X];
        assert!(may_turn(up, up, DVec3::Z));
        assert!(!may_turn(up, down, DVec3::Z));
        assert!(!may_turn(up, down, DVec3::ZERO));
        assert!(may_turn(down, up, DVec3::Z));
    }
}
