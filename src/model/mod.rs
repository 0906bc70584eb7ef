//! The nouns: plain data with `check()`, no algorithms.

pub mod brep;
pub mod complex;
pub mod decomposition;
pub mod disjoint;
pub mod doubt;
pub mod element_shape;
pub mod ids;
pub mod keep;
pub mod length_unit;
pub mod local_size;
pub mod mesh_audit;
pub mod metric;
pub mod patch;
pub mod pieces;
pub mod profile;
pub mod removal;
pub mod report;
pub mod shell;
pub mod sighting;
pub mod tet_graph;
pub mod tets;
pub mod walls;
pub mod washer;
