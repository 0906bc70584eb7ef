//! The only place that knows the order of the stages.

mod clock;
mod error;
mod merge;
mod midsurface;
mod report;

pub use error::PipelineError;
pub use report::{RunReport, SolidReport};

use crate::geom::placer::Placer;
use crate::import::{ImportOptions, Piece, import_cad};
use crate::medial::Medial;
use crate::model::brep::Brep;
use crate::model::complex::MidComplex;
use crate::model::element_shape::ElementShape;
use crate::model::ids::WallId;
use crate::model::report::Profile;
use crate::model::shell::ShellMesh;
use crate::options::MeshOptions;
use crate::stage::remesh::RemeshOptions;
use crate::stage::{audit, fair, quads, quality, remesh, shell, size};
use clock::Clock;
use glam::DVec3;
use midsurface::MidSurface;
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
    let imported = clock.time("import", || import_cad(input, &import_options(options)))?;
    let mut run = mesh_pieces(&imported.pieces, options, &mut clock)?;
    run.report.input = input.to_owned();
    run.report.gmsh_version = imported.gmsh_version;
    run.report.import_attempts = imported.attempts;
    run.timings = clock.finish();
    Ok(run)
}

fn import_options(options: &MeshOptions) -> ImportOptions {
    ImportOptions {
        gmsh: options.gmsh.clone(),
        time_limit: options.time_limit,
        ..ImportOptions::default()
    }
}

/// Meshes solids that are already read and filled.
fn mesh_pieces(
    pieces: &[Piece],
    options: &MeshOptions,
    clock: &mut Clock<'_>,
) -> Result<MeshRun, PipelineError> {
    let breps: Vec<&Brep> = pieces.iter().map(|p| &p.brep).collect();
    let diagonal = breps.iter().map(|b| b.diagonal()).fold(0.0, f64::max);
    options.check_against(diagonal)?;
    let mut meshes = Vec::new();
    let mut solids = Vec::new();
    for piece in pieces {
        let (mesh, solid) = mesh_solid(piece, options, clock)?;
        meshes.push(mesh);
        solids.push(solid);
    }
    let triangles = merge::merge(meshes);
    let profile = Profile::shell();
    let mesh = match options.element {
        ElementShape::Triangle => triangles,
        shape => clock.time("quads", || quads::pair_quads(&triangles, shape, &profile)),
    };
    let wanted = solids.iter().map(|s| s.size).fold(f64::INFINITY, f64::min);
    let quality = clock.time("quality", || {
        quality::quality(&mesh, &profile, Some(wanted))
    });
    let audit = clock.time("audit", || audit::audit(&breps, &mesh, AUDIT_SEED));
    let report = RunReport::new(solids, quality, audit);
    Ok(MeshRun {
        mesh,
        report,
        timings: Vec::new(),
    })
}

/// The shell of triangles of one solid.
fn mesh_solid(
    piece: &Piece,
    options: &MeshOptions,
    clock: &mut Clock<'_>,
) -> Result<(ShellMesh, SolidReport), PipelineError> {
    let brep = &piece.brep;
    let found = midsurface::mid_surface(piece, clock)?;
    let medial = Medial::new(brep, &found.aag, &found.pairing);
    let sizing = size::sizing(brep, &found.pairing, options.size, options.size_curvature);
    let field =
        |p: DVec3, w: WallId| sizing.at(medial.curvature_radius(p, w), medial.mean_thickness(w));
    let complex = mesh_complex(&found, &sizing, &field, &medial, clock);
    let mesh = clock.time("shell", || {
        shell::shell(brep, &found.pairing, &medial, &complex)
    });
    let solid = SolidReport::new(brep, &found, sizing.target, &mesh);
    Ok((mesh, solid))
}

/// From the raw complex to good triangles.
fn mesh_complex(
    found: &MidSurface,
    sizing: &size::Sizing,
    field: &(dyn Fn(DVec3, WallId) -> f64 + Sync),
    medial: &Medial<'_>,
    clock: &mut Clock<'_>,
) -> MidComplex {
    let shortest = |p: DVec3, w: WallId| sizing.speck(field(p, w));
    let (fair, _) = clock.time("fair", || fair::fair(found.complex.clone(), medial));
    let clean = clock.time("clean", || remesh::clean(fair, &shortest, medial));
    clock.time("remesh", || {
        remesh::remesh(clean, field, medial, &RemeshOptions::default()).0
    })
}

/// x
pub fn inspect(
    _: &Path,
    _: &MeshOptions,
    _: &dyn Progress,
) -> Result<crate::inspection::Inspection, PipelineError> {
    Ok(Default::default())
}
