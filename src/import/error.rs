//! Why a file could not be imported, and what the user can do about it.

use std::path::PathBuf;
use std::time::Duration;

use super::facet::shells::ShellFault;
use super::facet::soup::ReadError;
use super::msh::MshError;
use super::piece::PieceError;
use super::tetwild::{self, TetWildError};

/// What an attempt says where the last resort is not installed.
pub(super) const NO_TETWILD: &str = "no Python with pytetwild";

/// Why a file could not be imported. [`ImportError::remedy`] says what to do.
#[derive(Debug, thiserror::Error)]
pub enum ImportError {
    /// There is no such file.
    #[error("{} does not exist", path.display())]
    NotFound {
        /// The input.
        path: PathBuf,
    },
    /// The path is a directory or a device.
    #[error("{} is not a file", path.display())]
    NotAFile {
        /// The input.
        path: PathBuf,
    },
    /// The file has no bytes.
    #[error("{} is empty", path.display())]
    Empty {
        /// The input.
        path: PathBuf,
    },
    /// The file, or the temporary folder for its work, could not be read or written.
    #[error("cannot read {}: {cause}", path.display())]
    Unreadable {
        /// The input, or the file that was needed for it.
        path: PathBuf,
        /// What the operating system said.
        cause: std::io::Error,
    },
    /// There is no temporary folder to work in.
    #[error("the temporary folder {} cannot be used: {cause}", path.display())]
    NoFolder {
        /// Where it should have been.
        path: PathBuf,
        /// What the operating system said.
        cause: std::io::Error,
    },
    /// The extension belongs to no format that is read here.
    #[error("{}: unknown format {}", path.display(), named(extension))]
    UnknownFormat {
        /// The input.
        path: PathBuf,
        /// Its extension in lower case; empty where it has none.
        extension: String,
    },
    /// The bytes of a facet file are not what its format says.
    #[error("{} cannot be read: {cause}", path.display())]
    BadFacets {
        /// The input.
        path: PathBuf,
        /// Where, and what is wrong there.
        cause: ReadError,
    },
    /// The facets bound no solid.
    #[error("{} is no solid: {cause}", path.display())]
    NotASolid {
        /// The input.
        path: PathBuf,
        /// Why, with places and counts.
        cause: ShellFault,
    },
    /// The file is not what its extension says, or it is cut short.
    #[error("{} is not a CAD file that can be read: {reason}", path.display())]
    NotCad {
        /// The input.
        path: PathBuf,
        /// What is wrong with it.
        reason: String,
    },
    /// The file holds surfaces or curves, but no solid.
    #[error("{} holds no solid, only {surfaces} surfaces", path.display())]
    NoSolid {
        /// The input.
        path: PathBuf,
        /// How many surfaces it holds.
        surfaces: usize,
    },
    /// A solid's boundary has an open border.
    #[error("a solid of {} is not closed: {length_mm} mm of its edges bound one face only", path.display())]
    NotClosed {
        /// The input.
        path: PathBuf,
        /// Length of the edges with one face.
        length_mm: f64,
    },
    /// No gmsh was found.
    #[error("no gmsh was found; looked at {}", looked_at.join(", "))]
    GmshMissing {
        /// The places that were tried, in order.
        looked_at: Vec<String>,
    },
    /// A gmsh was found, but it does not start.
    #[error("{} does not start: {}", gmsh.display(), lines.join(" | "))]
    GmshUnusable {
        /// The command.
        gmsh: PathBuf,
        /// The last lines that it wrote.
        lines: Vec<String>,
    },
    /// Gmsh could not fill the solid, whichever way it was asked.
    #[error("gmsh could not mesh {} ({}): {}", path.display(), attempts.join("; "), lines.join(" | "))]
    GmshFailed {
        /// The input.
        path: PathBuf,
        /// What was tried and why it failed, in order.
        attempts: Vec<String>,
        /// The last lines of error that gmsh wrote.
        lines: Vec<String>,
    },
    /// The time limit over all attempts ran out; what ran was killed.
    #[error("{} could not be meshed within {:.0} s of processor time ({})", path.display(), limit.as_secs_f64(), attempts.join("; "))]
    TimedOut {
        /// The input.
        path: PathBuf,
        /// The limit over all attempts.
        limit: Duration,
        /// What was tried before and in it, in order.
        attempts: Vec<String>,
    },
    /// Gmsh ended well, but its mesh is no filled solid.
    #[error("the mesh that gmsh made of {} cannot be used: {cause}", path.display())]
    BadMesh {
        /// The input.
        path: PathBuf,
        /// What is wrong with the mesh.
        cause: MeshFault,
        /// What was tried and why it failed, in order.
        attempts: Vec<String>,
    },
}

/// What is wrong with a mesh that gmsh wrote.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum MeshFault {
    /// The bytes are no MSH 4.1 file.
    #[error(transparent)]
    Msh(#[from] MshError),
    /// The elements do not make a closed, filled solid.
    #[error(transparent)]
    Piece(#[from] PieceError),
    /// The elements do not have the volume of the solid.
    #[error("the mesh of solid {solid} has {:.1} % of its volume", 100.0 * share)]
    Volume {
        /// The solid's number in the file.
        solid: i32,
        /// Volume of the mesh over that of the solid.
        share: f64,
    },
    /// The surface mesh has no facet, or too many for fTetWild.
    #[error("{facets} facets are none or too many to fill")]
    Surface {
        /// How many.
        facets: usize,
    },
    /// FTetWild gave no filling.
    #[error(transparent)]
    TetWild(#[from] TetWildError),
}

fn named(extension: &str) -> String {
    if extension.is_empty() {
        "(no extension)".to_owned()
    } else {
        format!(".{extension}")
    }
}

impl ImportError {
    /// What the user can do.
    pub fn remedy(&self) -> String {
        match self {
            Self::NotFound { .. } => "Check the path and its spelling.".to_owned(),
            Self::NotAFile { .. } => "Name one CAD or facet file, not a folder.".to_owned(),
            Self::Empty { .. } => "Export the part from the CAD system again.".to_owned(),
            Self::Unreadable { .. } => {
                "Check the rights on the file and the free space in the temporary folder (TMPDIR)."
                    .to_owned()
            }
            Self::NoFolder { .. } => {
                "Name a folder that may be written to and has room in the variable TMPDIR.".to_owned()
            }
            Self::UnknownFormat { .. } => {
                "Export the part as STEP (.step, .stp), IGES (.iges, .igs), OpenCASCADE BREP (.brep), or as facets (.stl, .obj, .ply)."
                    .to_owned()
            }
            Self::BadFacets { .. } => {
                "Export the part again; if the file was copied, check that the copy is complete. STEP (.step) is better than facets where there is a choice."
                    .to_owned()
            }
            Self::NotASolid { cause, .. } => match cause {
                ShellFault::Open { .. } => {
                    "Close the surface where the part was made (a mesh repair tool does it too), or export a solid as STEP."
                }
                ShellFault::NotOrientable { .. } => {
                    "The surface has one side only or is glued along wrong edges: mend it where the part was made."
                }
                ShellFault::NoVolume => {
                    "A surface has no thickness: thicken it into a solid, or mesh it as a shell directly."
                }
                ShellFault::SelfCut { .. } => {
                    "Mend the surface where the part was made (a mesh repair tool shows where it cuts itself), or export a solid as STEP."
                }
                ShellFault::Overlap { .. } => {
                    "Unite the bodies into one solid (boolean union) where the part was made, or export them one by one."
                }
            }
            .to_owned(),
            Self::NotCad { .. } => {
                "Export the part as STEP again; if it was copied, check that the copy is complete."
                    .to_owned()
            }
            Self::NoSolid { .. } => {
                "Export a solid: in the CAD system sew or knit the surfaces into a closed body first."
                    .to_owned()
            }
            Self::NotClosed { .. } => {
                "Close the gaps in the CAD system (a face is missing, or neighbours do not meet), then export again."
                    .to_owned()
            }
            Self::GmshMissing { .. } => {
                format!("Install it with `{}`, or name it with --gmsh or MIDSHELL_GMSH.", super::gmsh::INSTALL)
            }
            Self::GmshUnusable { lines, .. } => {
                if lines.iter().any(|l| l.contains("shared object") || l.contains("shared libraries")) {
                    "Install the libraries that gmsh needs: `apt-get install libglu1-mesa libxcursor1 libxft2 libxinerama1 libgomp1`."
                        .to_owned()
                } else {
                    format!("Install it anew with `{}`, or name another with --gmsh or MIDSHELL_GMSH.", super::gmsh::INSTALL)
                }
            }
            Self::GmshFailed { attempts, .. } | Self::BadMesh { attempts, .. }
                if attempts.iter().any(|a| a.contains(NO_TETWILD)) =>
            {
                format!(
                    "Install the more robust mesher that is tried last: {}; or heal the part in the CAD system: faces that overlap, touch or are slivers are the usual cause.",
                    tetwild::INSTALL
                )
            }
            Self::GmshFailed { .. } | Self::BadMesh { .. } => {
                "Faces that overlap, touch or are slivers are the usual cause: heal the part in the CAD system."
                    .to_owned()
            }
            Self::TimedOut { .. } => {
                "Give it a longer time limit, or take small features off the part; very long and slender curved faces take the longest."
                    .to_owned()
            }
        }
    }
}
