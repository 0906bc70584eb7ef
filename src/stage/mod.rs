//! Filled by the modules below.

pub mod remesh;
