//! Writers: a shell mesh with thickness to the bytes of one file format.
//!
//! [`render`] is pure (mesh in, bytes out); [`write_all`] alone touches the disk, and leaves either every output whole or none.
//!
//! Guarantees: same mesh, same bytes, whatever the locale or the number of threads; a mesh that a solver would reject
//! ([`ExportError`]) is never written. Numbers are the shortest that read back to the same `f64`; the two formats with a width limit keep all
//! digits that fit (20 characters in Abaqus and CalculiX decks, 16 in Nastran's wide fields).
//!
//! **Numbering.** Nodes, elements, sheets and walls are numbered from 1, in the order of their ids, alike in every format:
//! `SHEET_3`, property 3 and the VTU cell field `sheet` = 3 are `SheetId(2)`. Solids and source faces keep their tags.

mod abaqus;
mod calculix;
mod cell_set;
mod cells;
mod checked;
mod deck;
mod metrics_csv;
mod mid_side;
mod msh;
mod nastran;
mod number;
mod own_normals;
mod sections;
mod sets;
mod vtu;
mod write;

pub use cell_set::{CellSet, render_cells};
pub use checked::ExportError;
pub use metrics_csv::{MetricRow, render_metrics};
pub use write::{WriteError, probe, write_all, write_all_with};

use crate::model::shell::ShellMesh;

/// A file format that [`render`] can write.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Format {
    /// VTK XML unstructured grid: ParaView, PyVista.
    Vtu,
    /// Gmsh MSH 4.1, text.
    Msh,
    /// Abaqus input deck.
    Abaqus,
    /// CalculiX input deck.
    Calculix,
    /// Nastran bulk data deck.
    Nastran,
}

impl Format {
    /// Every format, in the order of the help texts.
    pub const ALL: [Format; 5] = [
        Format::Vtu,
        Format::Msh,
        Format::Calculix,
        Format::Abaqus,
        Format::Nastran,
    ];

    /// The format that a file extension (without the dot, any case) means; `.inp` means CalculiX.
    pub fn from_extension(extension: &str) -> Option<Self> {
        match extension.to_ascii_lowercase().as_str() {
            "vtu" => Some(Format::Vtu),
            "msh" => Some(Format::Msh),
            "inp" => Some(Format::Calculix),
            "bdf" | "nas" => Some(Format::Nastran),
            _ => None,
        }
    }

    /// The format with this name (any case): `vtu`, `msh` or `gmsh`, `calculix` or `ccx`, `abaqus`, `nastran` or `bdf`.
    pub fn from_name(name: &str) -> Option<Self> {
        match name.to_ascii_lowercase().as_str() {
            "vtu" => Some(Format::Vtu),
            "msh" | "gmsh" => Some(Format::Msh),
            "calculix" | "ccx" => Some(Format::Calculix),
            "abaqus" => Some(Format::Abaqus),
            "nastran" | "bdf" => Some(Format::Nastran),
            _ => None,
        }
    }

    /// The name that [`Format::from_name`] reads.
    pub fn name(self) -> &'static str {
        match self {
            Format::Vtu => "vtu",
            Format::Msh => "msh",
            Format::Calculix => "calculix",
            Format::Abaqus => "abaqus",
            Format::Nastran => "nastran",
        }
    }

    /// The usual file extension, without the dot.
    pub fn extension(self) -> &'static str {
        match self {
            Format::Vtu => "vtu",
            Format::Msh => "msh",
            Format::Calculix | Format::Abaqus => "inp",
            Format::Nastran => "bdf",
        }
    }
}

/// The linear elastic material of the decks, in N, mm and t.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Material {
    /// Young's modulus, MPa.
    pub young_mpa: f64,
    /// Poisson's ratio.
    pub poisson: f64,
    /// Density, t/mm^3.
    pub density_t_per_mm3: f64,
}

impl Default for Material {
    /// Structural steel: the deck has to name some material to be read; the user puts in the right one.
    fn default() -> Self {
        Self {
            young_mpa: 210_000.0,
            poisson: 0.3,
            density_t_per_mm3: 7.85e-9,
        }
    }
}

/// What goes into a file beside the mesh.
#[derive(Clone, Debug, Default)]
pub struct ExportOptions<'a> {
    /// One line that names the part, in the header of the decks. Characters outside printable ASCII become `_`.
    pub title: String,
    /// #E scaled Jacobians, the VTU cell field `quality`; left out if `None`.
    pub cell_quality: Option<&'a [f64]>,
    /// #E what the audit doubts of each element, sums of [`DoubtRule::bit`](crate::model::report::DoubtRule::bit), the VTU cell field `doubt`; left out if `None`.
    pub cell_doubts: Option<&'a [u32]>,
    /// More VTU cell fields: name and #E values each.
    pub cell_fields: Vec<(String, Vec<f64>)>,
    /// The material of the decks.
    pub material: Material,
}

/// The bytes of `mesh` in `format`.
///
/// Quads with a corner of 180 degrees or more stay as they are in VTU and MSH (to be seen); the decks get two triangles for each, because solvers stop at
/// them: the first keeps the quad's number, the second is numbered after all elements.
pub fn render(
    format: Format,
    mesh: &ShellMesh,
    options: &ExportOptions<'_>,
) -> Result<Vec<u8>, ExportError> {
    checked::check(mesh, options)?;
    match format {
        Format::Vtu => Ok(vtu::render(mesh, options)),
        Format::Msh => Ok(msh::render(mesh)),
        Format::Abaqus => Ok(abaqus::render(mesh, options)),
        Format::Calculix => Ok(calculix::render(mesh, options)),
        Format::Nastran => nastran::render(mesh, options),
    }
}

/// The number in a file of the entity with this index.
fn number_of(id: impl crate::model::ids::Id) -> usize {
    id.index() + 1
}

/// The title as one line of at most 60 printable ASCII characters, which no deck can take for a card.
fn title_line(options: &ExportOptions<'_>) -> String {
    options
        .title
        .chars()
        .take(60)
        .map(|c| match c {
            ' '..='~' if !matches!(c, '*' | '$' | ',') => c,
            _ => '_',
        })
        .collect()
}

#[cfg(test)]
pub(crate) mod tests {
    use super::*;
    use crate::model::ids::{IndexVec, NodeId, SheetId, WallId};
    use crate::model::shell::{Corners, Element, Sheet};
    use glam::DVec3;

    /// A unit quad of one sheet with these corner thicknesses.
    pub(crate) fn quad(thickness: [f64; 4]) -> ShellMesh {
        ShellMesh {
            nodes: vec![DVec3::ZERO, DVec3::X, DVec3::new(1.0, 1.0, 0.0), DVec3::Y].into(),
            node_thickness: thickness.to_vec().into(),
            node_normals: IndexVec::filled(DVec3::Z, 4),
            elements: vec![Element {
                corners: Corners::Quad([0, 1, 2, 3].map(NodeId)),
                sheet: SheetId(0),
                thickness,
                source_faces: [5, 6],
                unsure: false,
            }]
            .into(),
            sheets: vec![Sheet {
                solid_tag: 1,
                wall: WallId(0),
                sides: [vec![5], vec![6]],
            }]
            .into(),
            rims: vec![[0, 1], [0, 3], [1, 2], [2, 3]]
                .into_iter()
                .map(|e| e.map(NodeId))
                .collect(),
            ..ShellMesh::default()
        }
    }

    /// The rendered text.
    pub(crate) fn text(format: Format, mesh: &ShellMesh) -> String {
        let options = ExportOptions::default();
        String::from_utf8(render(format, mesh, &options).unwrap()).unwrap()
    }

    #[test]
    fn names_and_extensions_lead_back_to_the_format() {
        for format in Format::ALL {
            assert_eq!(Format::from_name(format.name()), Some(format));
            let by_extension = Format::from_extension(format.extension()).unwrap();
            assert!(by_extension == format || format == Format::Abaqus);
        }
        assert_eq!(Format::from_extension("INP"), Some(Format::Calculix));
        assert_eq!(Format::from_extension("NAS"), Some(Format::Nastran));
        assert_eq!(Format::from_extension("stl"), None);
        assert_eq!(Format::from_name("ansys"), None);
    }

    #[test]
    fn a_title_cannot_become_a_card() {
        let options = ExportOptions {
            title: "*NODE\n1, 2 Gehäuse".into(),
            ..ExportOptions::default()
        };
        assert_eq!(title_line(&options), "_NODE_1_ 2 Geh_use");
    }
}
