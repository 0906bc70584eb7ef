//! Readers: the bytes of a shell mesh in, whatever program wrote it, a [`ReadMesh`] out. One file a format.
//!
//! Guarantees: no bytes make a reader panic, nor allocate much more than the file is long (compressed arrays: than they say, within what their bytes can hold);
//! all coordinates of what is returned are finite, corners are in range, sheets and edges are complete. What is wrong is told with its place in the file and a remedy.
//! Numbers of nodes and elements are those of the file; VTU and STL have none, theirs count from 1.
//!
//! Elements of higher order are taken by their corners, and the nodes in the middle of their sides are left out. Solid elements, lines and points are counted, not read.
//! Lengths are as in the file.

mod assemble;
pub mod bdf;
mod bdf_cards;
mod error;
pub mod inp;
mod inp_elements;
pub mod msh;
mod msh_source;
mod raw;
pub mod stl;
pub mod vtu;
mod vtu_array;
mod xml;

pub use error::{ReadError, ReadErrorKind};

use crate::model::shell::ShellMesh;

/// A format that can be read.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum MeshFormat {
    /// VTK XML unstructured grid.
    Vtu,
    /// Gmsh MSH 2.2 and 4.1, text and binary.
    Msh,
    /// Abaqus and CalculiX input deck.
    Inp,
    /// Nastran bulk data.
    Bdf,
    /// STL, text and binary.
    Stl,
}

impl MeshFormat {
    /// Every format, in the order of the help texts.
    pub const ALL: [MeshFormat; 5] = [
        MeshFormat::Vtu,
        MeshFormat::Msh,
        MeshFormat::Inp,
        MeshFormat::Bdf,
        MeshFormat::Stl,
    ];

    /// The format that a file extension (without the dot, any case) means.
    pub fn from_extension(extension: &str) -> Option<Self> {
        match extension.to_ascii_lowercase().as_str() {
            "vtu" => Some(Self::Vtu),
            "msh" => Some(Self::Msh),
            "inp" => Some(Self::Inp),
            "bdf" | "nas" | "fem" => Some(Self::Bdf),
            "stl" => Some(Self::Stl),
            _ => None,
        }
    }

    /// Its name for people.
    pub fn name(self) -> &'static str {
        match self {
            Self::Vtu => "VTU",
            Self::Msh => "Gmsh MSH",
            Self::Inp => "Abaqus or CalculiX deck",
            Self::Bdf => "Nastran deck",
            Self::Stl => "STL",
        }
    }

    /// Reads the bytes of a whole file.
    pub fn parse(self, bytes: &[u8]) -> Result<ReadMesh, ReadError> {
        let raw = match self {
            Self::Vtu => vtu::parse(bytes),
            Self::Msh => msh::parse(bytes),
            Self::Inp => inp::parse(bytes),
            Self::Bdf => bdf::parse(bytes),
            Self::Stl => stl::parse(bytes),
        }?;
        assemble::assemble(raw)
    }
}

/// A shell mesh as a file has it.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ReadMesh {
    /// The mesh. Thickness that the file does not have is NaN; walls and source faces are not known.
    pub mesh: ShellMesh,
    /// #N numbers in the file.
    pub node_numbers: Vec<u64>,
    /// #E numbers in the file.
    pub element_numbers: Vec<u64>,
    /// Elements without thickness at some corner.
    pub without_thickness: usize,
    /// Whether the file says which element is of which sheet; else sheets hang together over edges of two elements.
    pub sheets_named: bool,
    /// What the user should know: what was left out, what was assumed.
    pub notes: Vec<String>,
}

#[cfg(test)]
mod tests;
