//! The only place that knows the order of the stages.

use crate::exit_class::ExitClass;
use crate::inspection::Inspection;
use crate::model::shell::ShellMesh;
use crate::options::{MeshOptions, OptionFault};
use serde::Serialize;
use std::fmt;
use std::path::{Path, PathBuf};

/// Told of every stage as it begins.
pub trait Progress: Sync {
    /// A stage begins.
    fn stage(&self, name: &str);
}

/// What a run says of its own result.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct RunReport {
    /// The file that was read.
    pub input: PathBuf,
    /// What the audit holds against the result; nothing where it is right.
    pub doubts: Vec<String>,
}

impl fmt::Display for RunReport {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(f, "{}", self.input.display())
    }
}

/// A finished run.
#[derive(Clone, Debug, Default)]
pub struct MeshRun {
    /// The shell.
    pub mesh: ShellMesh,
    /// What the run says of it.
    pub report: RunReport,
    /// Seconds a stage.
    pub timings: Vec<(String, f64)>,
}

/// Why a run has no result.
#[derive(Debug, thiserror::Error)]
pub enum PipelineError {
    /// The options do not suit the part.
    #[error(transparent)]
    BadSize(#[from] OptionFault),
    /// There is no wall.
    #[error("no thin wall found in the part")]
    NoThinWall,
    /// A stage broke its own promise.
    #[error("{0}")]
    Internal(String),
    /// The stages are not there.
    #[error("the meshing stages are not part of this build")]
    Unavailable,
}

impl PipelineError {
    /// The exit status that it stands for.
    pub fn exit_class(&self) -> ExitClass {
        match self {
            PipelineError::BadSize(_) => ExitClass::BadUsage,
            PipelineError::NoThinWall => ExitClass::NoThinWall,
            PipelineError::Internal(_) | PipelineError::Unavailable => ExitClass::Internal,
        }
    }

    /// What the user can do about it.
    pub fn remedy(&self) -> String {
        match self {
            PipelineError::BadSize(fault) => fault.remedy(),
            PipelineError::NoThinWall => "a solid without thin walls wants a volume mesh".into(),
            PipelineError::Internal(_) | PipelineError::Unavailable => {
                "please report it with the file that it happens on".into()
            }
        }
    }
}

/// Meshes the mid-surface of a part.
pub fn mesh(_: &Path, options: &MeshOptions, _: &dyn Progress) -> Result<MeshRun, PipelineError> {
    options.check()?;
    Err(PipelineError::Unavailable)
}

/// Finds out what a part is made of.
pub fn inspect(
    _: &Path,
    options: &MeshOptions,
    _: &dyn Progress,
) -> Result<Inspection, PipelineError> {
    options.check()?;
    Err(PipelineError::Unavailable)
}
