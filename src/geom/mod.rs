//! Shared mathematics: no topology, no files, no clocks.

pub mod bend;
pub mod cdt;
pub mod circle;
pub mod curve_corner;
pub mod fold;
pub mod kind;
pub mod orient;
pub mod pinhole;
pub mod placer;
pub mod planes;
pub mod point_tree;
pub mod quality;
pub mod random;
pub mod rim_loops;
pub mod six_node;
pub mod snap;
pub mod split;
pub mod triangle;
