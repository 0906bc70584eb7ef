//! **midshell**: from a thin-walled solid to a connected shell mesh on its mid-surface.

pub mod charts;
pub mod criteria;
pub mod doctor;
pub mod exit_class;
pub mod export;
pub mod geom;
pub mod import;
pub mod inspection;
pub mod medial;
pub mod model;
pub mod options;
pub mod pipeline;
pub mod read;
pub mod report_text;
pub mod size_file;
pub mod solve;
pub mod spatial;
pub mod stage;
mod toml_text;

#[cfg(test)]
mod test_parts;
