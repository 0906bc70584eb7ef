//! **midshell**: from a thin-walled solid to a connected shell mesh on its mid-surface.

pub mod charts;
pub mod export;
pub mod geom;
pub mod import;
pub mod model;
pub mod solve;
pub mod stage;
