//! The verbs, in the order of the pipeline. Every stage is a pure function; only the pipeline knows their order.

pub mod adjacency;
pub mod assess;
pub mod audit;
pub mod balance;
pub mod chart_mesh;
pub mod collapse;
pub mod decompose;
pub mod defeature;
pub mod divide;
pub mod extract;
pub mod fair;
pub mod findings;
pub mod flatten;
pub mod keep;
pub mod kinks;
pub mod pair;
pub mod patch;
pub mod prune;
pub mod quads;
pub mod quality;
pub mod reach;
pub mod remesh;
pub mod respace;
pub mod role;
pub mod sheets;
pub mod shell;
pub mod size;
pub mod unite;
pub mod washers;
pub mod widen;
pub mod width;

#[cfg(test)]
pub(crate) mod test_shapes;
