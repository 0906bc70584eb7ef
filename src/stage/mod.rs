//! Filled by the modules below.

pub mod audit;
pub mod quads;
pub mod quality;
