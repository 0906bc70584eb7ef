//! Shared mathematics: no topology, no files, no clocks.

pub mod placer;
pub mod random;
pub mod triangle;
