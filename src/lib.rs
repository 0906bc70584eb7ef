//! **midshell**: from a thin-walled solid to a connected shell mesh on its mid-surface.

pub mod export;
pub mod geom;
pub mod import;
pub mod model;
pub mod report_text;
pub mod spatial;
pub mod stage;

#[cfg(test)]
mod test_parts;
