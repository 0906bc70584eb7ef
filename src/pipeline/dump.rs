//! `--dump`: what each stage made, as VTU files for ParaView, to look into a run that went wrong.
//!
//! Files of a solid with number N: `tets-N` (a point field counts the edges that run through a wall), `faces-N` (face, role, group, side, kind of
//! surface), `raw-N`, `fair-N`, `kept-N` (where edges are kept), `clean-N`, `remeshed-N`, `charted-N`, `polished-N`, `squares-N` and `halves-N` (where quads are asked for), `balanced-N` (the mid-complex: wall, edges that are junctions); of the part: `mesh`. Each is written as soon as it is
//! there, so that a run that fails leaves what it had.

use super::error::PipelineError;
use super::midsurface::MidSurface;
use crate::export::{CellSet, ExportOptions, Format, WriteError, render, render_cells, write_all};
use crate::geom::kind::{FaceKind, face_kind};
use crate::geom::six_node::facets_of_faces;
use crate::import::Piece;
use crate::model::brep::Brep;
use crate::model::complex::MidComplex;
use crate::model::decomposition::Passage;
use crate::model::ids::{FaceId, Id, IndexVec};
use crate::model::shell::ShellMesh;
use crate::model::tet_graph::TetGraph;
use crate::options::MeshOptions;
use crate::stage::decompose;
use std::path::Path;

/// Where the stages' results of one solid (or of the whole part) go, if anywhere.
pub(super) struct Dump<'a> {
    folder: Option<&'a Path>,
    solid: Option<i32>,
}

impl<'a> Dump<'a> {
    /// Makes the folder.
    pub(super) fn new(options: &'a MeshOptions, solid: Option<i32>) -> Result<Self, PipelineError> {
        let folder = options.dump.as_deref();
        if let Some(path) = folder {
            std::fs::create_dir_all(path).map_err(|e| WriteError::of(path, 0, e))?;
        }
        Ok(Self { folder, solid })
    }

    fn write(&self, name: &str, make: impl FnOnce() -> Vec<u8>) -> Result<(), PipelineError> {
        let Some(folder) = self.folder else {
            return Ok(());
        };
        let file = match self.solid {
            Some(tag) => format!("{name}-{tag}.vtu"),
            None => format!("{name}.vtu"),
        };
        Ok(write_all(&[(folder.join(file), make())])?)
    }

    /// What import made: tets and facets with the tags of their faces.
    pub(super) fn import(&self, piece: &Piece) -> Result<(), PipelineError> {
        self.write("tets", || render_cells(&tet_cells(piece)))?;
        self.write("faces", || render_cells(&facet_cells(&piece.brep)))
    }

    /// What adjacency to extraction made.
    pub(super) fn mid_surface(
        &self,
        piece: &Piece,
        found: &MidSurface,
    ) -> Result<(), PipelineError> {
        let brep = &piece.brep;
        self.write("tets", || {
            let mut set = tet_cells(piece);
            let graph = TetGraph::new(&piece.tets);
            let made = decompose::decompose(brep, &graph, &found.pairing, &found.roles);
            let through = graph.tet_edges.iter().map(|edges| {
                edges
                    .iter()
                    .filter(|&&e| made.passage[e] == Passage::Through)
                    .count() as f64
            });
            set.fields.push(("through", through.collect()));
            render_cells(&set)
        })?;
        self.write("faces", || {
            let mut set = facet_cells(brep);
            let mut add = |name, value: &dyn Fn(FaceId) -> f64| {
                let values = brep.facets.iter().map(|f| value(f.face)).collect();
                set.fields.push((name, values));
            };
            let side = &found.pairing.side;
            add("role", &|f| f64::from(found.roles.role[f] as u8));
            add("group", &|f| side[f].map_or(-1.0, |s| f64::from(s.0)));
            add("side", &|f| side[f].map_or(-1.0, |s| f64::from(s.1)));
            let mut wall: IndexVec<FaceId, f64> = IndexVec::filled(-1.0, brep.faces.len());
            for pair in found.pairing.pairs.iter().rev() {
                for f in pair.faces {
                    wall[f] = f64::from(pair.wall.0);
                }
            }
            add("wall", &|f| wall[f]);
            render_cells(&set)
        })?;
        self.complex("raw", &found.complex)
    }

    /// A mid-complex under the name of the stage that made it.
    pub(super) fn complex(&self, name: &str, complex: &MidComplex) -> Result<(), PipelineError> {
        self.write(name, || render_cells(&complex_cells(complex)))
    }

    /// The result.
    pub(super) fn mesh(&self, mesh: &ShellMesh, quality: &[f64]) -> Result<(), PipelineError> {
        let options = ExportOptions {
            cell_quality: Some(quality),
            ..ExportOptions::default()
        };
        // A mesh that no format takes is refused later, with its own words.
        match render(Format::Vtu, mesh, &options) {
            Ok(bytes) => self.write("mesh", || bytes),
            Err(_) => Ok(()),
        }
    }
}

fn tet_cells(piece: &Piece) -> CellSet {
    CellSet {
        points: piece.brep.vertices.as_slice().to_vec(),
        cells: piece
            .tets
            .cells
            .iter()
            .map(|t| t.iter().map(|v| v.0).collect())
            .collect(),
        ..CellSet::default()
    }
}

fn facet_cells(brep: &Brep) -> CellSet {
    let kind: Vec<FaceKind> = facets_of_faces(brep).iter().map(|f| face_kind(f)).collect();
    let field = |value: &dyn Fn(FaceId) -> f64| brep.facets.iter().map(|f| value(f.face)).collect();
    CellSet {
        points: brep.vertices.as_slice().to_vec(),
        cells: brep
            .facets
            .iter()
            .map(|f| f.corners.iter().map(|v| v.0).collect())
            .collect(),
        fields: vec![
            ("face", field(&|f| f64::from(brep.faces[f].tag))),
            ("kind", field(&|f| f64::from(kind[f.index()] as u8))),
        ],
        ..CellSet::default()
    }
}

fn complex_cells(complex: &MidComplex) -> CellSet {
    let mut most = vec![0.0; complex.triangles.len()];
    for edge in complex.edges() {
        for t in &edge.triangles {
            let at: &mut f64 = &mut most[t.index()];
            *at = at.max(edge.triangles.len() as f64);
        }
    }
    CellSet {
        points: complex.nodes.iter().map(|n| n.point).collect(),
        cells: complex
            .triangles
            .iter()
            .map(|t| t.nodes.iter().map(|n| n.0).collect())
            .collect(),
        fields: vec![
            (
                "wall",
                complex
                    .triangles
                    .iter()
                    .map(|t| f64::from(t.wall.0))
                    .collect(),
            ),
            ("most_round_an_edge", most),
        ],
        ..CellSet::default()
    }
}
