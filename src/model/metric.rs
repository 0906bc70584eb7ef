//! The names of the element metrics, the one list behind reports, profiles and tables.
//!
//! Formulas and directions: [`crate::model::report`] names what is acceptable, `geom::quality` computes.

/// Metrics of a triangle, in the order of reports.
pub const TRIANGLE_METRICS: [&str; 7] = [
    "triangle.scaled_jacobian",
    "triangle.aspect_ratio",
    "triangle.edge_ratio",
    "triangle.radius_ratio",
    "triangle.min_angle_deg",
    "triangle.max_angle_deg",
    "triangle.skew_deg",
];

/// Metrics of a quad, in the order of reports.
pub const QUAD_METRICS: [&str; 16] = [
    "quad.scaled_jacobian",
    "quad.aspect_ratio",
    "quad.edge_ratio",
    "quad.skew",
    "quad.taper",
    "quad.warpage",
    "quad.shape",
    "quad.condition",
    "quad.equiangle_skew",
    "quad.warp_deg",
    "quad.gauss_jacobian_ratio",
    "quad.skew_deg",
    "quad.corner_taper",
    "quad.plane_warp",
    "quad.min_angle_deg",
    "quad.max_angle_deg",
];

/// A metric's name without the shape: `taper` of `quad.taper`.
pub fn bare(name: &str) -> &str {
    name.split_once('.').map_or(name, |(_, bare)| bare)
}

/// The place of the metric with this bare name in a list.
pub fn place_of(list: &[&str], name: &str) -> Option<usize> {
    list.iter().position(|full| bare(full) == name)
}
