//! Shared mathematics: no topology, no files, no clocks.

pub mod cdt;
pub mod placer;
pub mod snap;
