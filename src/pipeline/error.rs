//! Why a run has no result.

use crate::exit_class::ExitClass;
use crate::export::WriteError;
use crate::import::ImportError;
use crate::options::OptionFault;
use crate::read::{MeshFormat, ReadError};
use std::io;
use std::path::PathBuf;

/// Why a run has no result.
#[derive(Debug, thiserror::Error)]
pub enum PipelineError {
    /// The file could not be read, or the tool that reads it failed.
    #[error(transparent)]
    Import(#[from] ImportError),
    /// The mesh file is not there, or may not be read.
    #[error("{} cannot be read: {cause}", path.display())]
    NoMeshFile {
        /// The mesh.
        path: PathBuf,
        /// What the system said.
        cause: io::Error,
    },
    /// The extension of a mesh file belongs to no format that is read.
    #[error("{}: no mesh format has the extension '{extension}'", path.display())]
    UnknownMesh {
        /// The mesh.
        path: PathBuf,
        /// Its extension.
        extension: String,
    },
    /// The bytes of a mesh file are not what they should be.
    #[error("{} ({}): {cause}", path.display(), format.name())]
    BadMesh {
        /// The mesh.
        path: PathBuf,
        /// What it was read as.
        format: MeshFormat,
        /// Where, and what is wrong there.
        cause: ReadError,
    },
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
            PipelineError::Import(_)
            | PipelineError::NoMeshFile { .. }
            | PipelineError::UnknownMesh { .. }
            | PipelineError::BadMesh { .. } => ExitClass::BadInput,
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
            PipelineError::NoMeshFile { .. } => "check the path and the rights on the file".into(),
            PipelineError::UnknownMesh { .. } => {
                "give a shell mesh as .vtu, .msh, .inp, .bdf (.nas, .fem) or .stl; 'midshell mesh' and 'inspect' read CAD files".into()
            }
            PipelineError::BadMesh { cause, .. } => cause.remedy().into(),
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
