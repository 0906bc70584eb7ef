//! The nouns: plain data with `check()`, no algorithms.

pub mod brep;
pub mod complex;
pub mod ids;
pub mod patch;
pub mod shell;
pub mod tets;
