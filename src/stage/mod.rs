//! Filled by the modules below.

pub mod chart_mesh;
pub mod flatten;
pub mod patch;

#[cfg(test)]
pub(crate) mod test_shapes;
