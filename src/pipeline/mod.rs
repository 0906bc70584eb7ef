//! The only place that knows the order of the stages.

mod clock;
mod dump;
mod error;
mod facts;
mod fins;
mod halved;
mod inspect;
mod memory;
mod merge;
mod mesh_audit;
mod middle;
mod midsurface;
mod report;
mod seen;
mod small;
mod solid;
mod targets;
mod tidy;
mod wished;

pub use error::PipelineError;
pub use inspect::inspect;
pub use memory::PeakMemory;
pub use mesh_audit::{MeshAudit, audit_mesh};
pub use report::{RunReport, SolidReport};

use crate::import::{ImportOptions, Piece, import_cad_told};
use crate::model::brep::Brep;
use crate::model::shell::ShellMesh;
use crate::options::MeshOptions;
use crate::stage::{audit, quality};
use clock::Clock;
use dump::Dump;
use glam::DVec3;
use seen::Seen;
use solid::Turn;
use std::path::Path;

/// Seed of the audit's samples: any number would do, but always the same one.
const AUDIT_SEED: u64 = 7;

/// Told of every stage as it begins.
pub trait Progress: Sync {
    /// A stage begins.
    fn stage(&self, name: &str);
}

/// A finished run.
#[derive(Clone, Debug, Default)]
pub struct MeshRun {
    /// The shell.
    pub mesh: ShellMesh,
    /// Scaled Jacobian of every element.
    pub cell_quality: Vec<f64>,
    /// What the run says of it.
    pub report: RunReport,
    /// Seconds a stage, in order.
    pub timings: Vec<(String, f64)>,
}

/// Meshes the mid-surface of a part.
pub fn mesh(
    input: &Path,
    options: &MeshOptions,
    progress: &dyn Progress,
) -> Result<MeshRun, PipelineError> {
    options.check()?;
    let mut clock = Clock::new(progress);
    let imported = clock.time("import", || {
        import_cad_told(input, &import_options(options), &mut |line| {
            progress.stage(&format!("import: {line}"));
        })
    })?;
    let mut run = mesh_pieces(imported.pieces, options, &mut clock)?;
    run.report.input = input.to_owned();
    run.report.gmsh_version = imported.gmsh_version;
    run.report.import_way = imported.way;
    run.report.import_attempts = imported.attempts;
    run.report.notes = imported.notes;
    run.timings = clock.finish();
    run.report.peak_memory = memory::peak();
    Ok(run)
}

fn import_options(options: &MeshOptions) -> ImportOptions {
    ImportOptions {
        gmsh: options.gmsh.clone(),
        unit: options.unit,
        time_limit: options.time_limit,
        ..ImportOptions::default()
    }
}

/// Diagonal of the box round all solids together, mm.
fn diagonal(pieces: &[Piece]) -> f64 {
    let points = pieces.iter().flat_map(|p| p.brep.vertices.as_slice());
    let none = [DVec3::INFINITY, DVec3::NEG_INFINITY];
    let [low, high] = points.fold(none, |[l, h], &p| [l.min(p), h.max(p)]);
    (high - low).max(DVec3::ZERO).length()
}

/// Meshes solids that are already read and filled.
fn mesh_pieces(
    pieces: Vec<Piece>,
    options: &MeshOptions,
    clock: &mut Clock<'_>,
) -> Result<MeshRun, PipelineError> {
    options.check_against(diagonal(&pieces))?;
    wished::faces_are_there(&pieces, options)?;
    wished::edges_are_there(&pieces, options)?;
    let pieces: Vec<Seen> = (pieces.into_iter()).map(|p| Seen::new(p, clock)).collect();
    let mut meshes = Vec::new();
    let mut solids = Vec::new();
    let mut plains = Vec::new();
    let mut sheets = 0;
    for (i, seen) in pieces.iter().enumerate() {
        let turn = Turn {
            sheets_before: sheets,
            is_last: i + 1 == pieces.len(),
        };
        let (mesh, solid, plain) = solid::mesh_solid(seen, turn, options, clock)?;
        sheets += mesh.sheets.len();
        meshes.push(mesh);
        solids.push(solid);
        plains.push(plain);
    }
    wished::sheets_are_there(sheets, options)?;
    let mesh = merge::merge(meshes);
    // What the user wanted out is not missing: the mesh is held against the solids without it.
    let breps: Vec<&Brep> = (pieces.iter().zip(&plains))
        .map(|(seen, plain)| plain.as_ref().map_or(&seen.piece.brep, |p| &p.brep))
        .collect();
    let profile = &options.profile;
    // The wanted length changes from place to place with curvature, so that no one length can be held against the edges.
    let quality = clock.time("quality", || quality::quality(&mesh, profile, None));
    let cell_quality = clock.time("quality", || quality::scaled_jacobians(&mesh).into_vec());
    let audit = clock.time("audit", || audit::audit(&breps, &mesh, AUDIT_SEED));
    Dump::new(options, None)?.mesh(&mesh, &cell_quality)?;
    let mut report = RunReport::new(solids, quality, audit);
    for plain in plains.into_iter().flatten() {
        report.removed.extend(plain.removed);
        report.left.extend(plain.left);
    }
    small::name_sheets(&mut report.removed, &mesh);
    Ok(MeshRun {
        mesh,
        cell_quality,
        report,
        timings: Vec::new(),
    })
}
