//! What a quad has to be for a solver to take it: two triangles are better than any other.

use crate::geom::quality::QuadQuality;

/// Corner angles beyond which OptiStruct warns: no quad is worth having there.
const ANGLES_DEG: [f64; 2] = [15.0, 165.0];
/// Warp angle beyond which OptiStruct warns.
const WARP_DEG: f64 = 30.0;
/// Verdict's least acceptable scaled Jacobian of a quad; two triangles are better there.
pub(super) const JACOBIAN: f64 = 0.3;

/// Whether a quad keeps to what solvers ask.
pub(super) fn is_usable(q: &QuadQuality) -> bool {
    q.min_angle_deg >= ANGLES_DEG[0]
        && q.max_angle_deg <= ANGLES_DEG[1]
        && q.warp_deg <= WARP_DEG
        && q.scaled_jacobian >= JACOBIAN
}
