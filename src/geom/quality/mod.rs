//! Element metrics: how good one triangle or one quad is, from its corner points alone.
//!
//! Guarantees: the formulas are those of the Verdict library's code (Stimpson, Ernst, Knupp, Pébay and Thompson, "The Verdict geometric
//! quality library", SAND2007-1751, 2007; where manual and code disagree, as on quad warpage, the code holds), with the measures of
//! pre-processors and solvers beside them (warp angle, Gauss-point Jacobian ratio, Nastran GEOMCHECK). All are scale-free but areas and
//! lengths, in the unit of the points. A degenerate element gets the worst value of each metric, infinite where the metric has no
//! upper end. Where a coordinate is not finite the area is NaN, and the rest means nothing.
//!
//! Limits: a triangle in space has no wrong side of its own; whether it is flipped only its neighbours tell.

mod quad;
mod triangle;

pub use quad::{QuadQuality, quad_quality};
pub use triangle::{TriangleQuality, triangle_quality};

use glam::DVec3;

/// Angle between two directions in degrees; zero where one of them vanishes.
fn angle_deg(a: DVec3, b: DVec3) -> f64 {
    // atan2 keeps its digits near 0 and 180 degrees, where acos loses half of them.
    a.cross(b).length().atan2(a.dot(b)).to_degrees()
}

/// Angle between two lines in degrees, 0 to 90.
fn line_angle_deg(a: DVec3, b: DVec3) -> f64 {
    let angle = angle_deg(a, b);
    angle.min(180.0 - angle)
}

/// `a / b` for non-negative numbers, where nothing over nothing is the worst case too.
fn ratio(a: f64, b: f64) -> f64 {
    if b > 0.0 { a / b } else { f64::INFINITY }
}
