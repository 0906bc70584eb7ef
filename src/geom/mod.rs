//! Shared mathematics: no topology, no files, no clocks.

pub mod placer;
pub mod quadratic;
pub mod quality;
pub mod random;
pub mod triangle;
