//! Why a run has no result.

use crate::exit_class::ExitClass;
use crate::export::WriteError;
use crate::import::ImportError;
use crate::options::OptionFault;

/// Why a run has no result.
#[derive(Debug, thiserror::Error)]
pub enum PipelineError {
    /// The file could not be read, or the tool that reads it failed.
    #[error(transparent)]
    Import(#[from] ImportError),
    /// The options do not suit the part.
    #[error(transparent)]
    BadSize(#[from] OptionFault),
    /// There is no wall.
    #[error(
        "no thin wall found in solid {solid}: no two of its {faces} faces face each other across material that is wider than thick"
    )]
    NoThinWall {
        /// The solid's number in the file.
        solid: i32,
        /// How many faces it has.
        faces: usize,
    },
    /// The result of a stage could not be kept.
    #[error("the result of a stage cannot be kept: {0}")]
    Dump(#[from] WriteError),
    /// A stage broke its own promise.
    #[error("stage '{stage}' broke its promise: {what}")]
    Internal {
        /// Which.
        stage: &'static str,
        /// The first fault that its check found.
        what: String,
    },
}

impl PipelineError {
    /// The exit status that it stands for.
    pub fn exit_class(&self) -> ExitClass {
        match self {
            PipelineError::Import(
                ImportError::GmshMissing { .. }
                | ImportError::GmshUnusable { .. }
                | ImportError::GmshFailed { .. }
                | ImportError::TimedOut { .. }
                | ImportError::BadMesh { .. },
            ) => ExitClass::ToolFailed,
            PipelineError::Import(ImportError::NoFolder { .. }) => ExitClass::OutputFailed,
            PipelineError::Import(_) => ExitClass::BadInput,
            PipelineError::BadSize(_) => ExitClass::BadUsage,
            PipelineError::NoThinWall { .. } => ExitClass::NoThinWall,
            PipelineError::Dump(_) => ExitClass::OutputFailed,
            PipelineError::Internal { .. } => ExitClass::Internal,
        }
    }

    /// What the user can do about it.
    pub fn remedy(&self) -> String {
        match self {
            PipelineError::Import(e) => e.remedy(),
            PipelineError::BadSize(fault) => fault.remedy(),
            PipelineError::NoThinWall { .. } => {
                "a solid without thin walls wants a volume mesh; 'midshell inspect' shows what its faces see of each other".into()
            }
            PipelineError::Dump(_) => {
                "name a folder with --dump that you may write to and that has room".into()
            }
            PipelineError::Internal { .. } => "please report it with the file that it happens on".into(),
        }
    }
}
