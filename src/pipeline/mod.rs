//! The only place that knows the order of the stages.

mod clock;
mod dump;
mod error;
mod facts;
mod fins;
mod inspect;
mod memory;
mod merge;
mod midsurface;
mod report;
mod seen;

pub use error::PipelineError;
pub use inspect::inspect;
pub use memory::PeakMemory;
pub use report::{RunReport, SolidReport};

use crate::charts;
use crate::geom::orient;
use crate::geom::pinhole::open_pinholes;
use crate::geom::placer::Placer;
use crate::import::{ImportOptions, Piece, import_cad_told};
use crate::medial::{Held, Medial};
use crate::model::brep::Brep;
use crate::model::complex::MidComplex;
use crate::model::element_shape::ElementShape;
use crate::model::ids::{TriangleId, WallId};
use crate::model::report::Profile;
use crate::model::shell::ShellMesh;
use crate::options::MeshOptions;
use crate::stage::fair::FairStats;
use crate::stage::remesh::RemeshOptions;
use crate::stage::{
    audit, balance, extract, fair, kinks, prune, quads, quality, remesh, shell, size,
};
use clock::Clock;
use dump::Dump;
use glam::DVec3;
use midsurface::MidSurface;
use rayon::prelude::*;
use seen::Seen;
use std::path::Path;

/// Rounds of untangling; every one takes the knots of the last away.
const KNOT_ROUNDS: usize = 8;
/// Seed of the audit's samples: any number would do, but always the same one.
const AUDIT_SEED: u64 = 7;

/// Share of an untangled complex outside the material from which its sheets are held inside: the audit doubts a mesh of which a little more lies outside.
const LEAVES: f64 = 0.005;

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

/// Meshes solids that are already read and filled.
fn mesh_pieces(
    pieces: Vec<Piece>,
    options: &MeshOptions,
    clock: &mut Clock<'_>,
) -> Result<MeshRun, PipelineError> {
    let pieces: Vec<Seen> = (pieces.into_iter()).map(|p| Seen::new(p, clock)).collect();
    let breps: Vec<&Brep> = pieces.iter().map(|p| &p.piece.brep).collect();
    let diagonal = breps.iter().map(|b| b.diagonal()).fold(0.0, f64::max);
    options.check_against(diagonal)?;
    let mut meshes = Vec::new();
    let mut solids = Vec::new();
    for seen in &pieces {
        let (mesh, solid) = mesh_solid(seen, options, clock)?;
        meshes.push(mesh);
        solids.push(solid);
    }
    let triangles = merge::merge(meshes);
    let profile = Profile::shell();
    let mesh = match options.element {
        ElementShape::Triangle => triangles,
        shape => clock.time("quads", || quads::pair_quads(&triangles, shape, &profile)),
    };
    // The wanted length changes from place to place with curvature, so that no one length can be held against the edges.
    let quality = clock.time("quality", || quality::quality(&mesh, &profile, None));
    let cell_quality = clock.time("quality", || quality::scaled_jacobians(&mesh).into_vec());
    let audit = clock.time("audit", || audit::audit(&breps, &mesh, AUDIT_SEED));
    Dump::new(options, None)?.mesh(&mesh, &cell_quality)?;
    let report = RunReport::new(solids, quality, audit);
    Ok(MeshRun {
        mesh,
        cell_quality,
        report,
        timings: Vec::new(),
    })
}

/// The shell of triangles of one solid.
fn mesh_solid(
    seen: &Seen,
    options: &MeshOptions,
    clock: &mut Clock<'_>,
) -> Result<(ShellMesh, SolidReport), PipelineError> {
    let piece = &seen.piece;
    let brep = &piece.brep;
    let dump = Dump::new(options, Some(brep.solid_tag))?;
    dump.import(piece)?;
    let found = midsurface::mid_surface(seen, clock)?;
    dump.mid_surface(piece, &found)?;
    let mut medial = Medial::new(brep, &found.aag, &found.pairing);
    medial.let_bevels_stand(true);
    let sizing = clock.time("size", || sizing(brep, &found, &medial, options));
    let (fair, leaves) = inside(&found, &medial, clock);
    dump.complex("fair", &fair)?;
    medial.let_bevels_stand(false);
    let sizing = clock.time("size", || sizing.afforded(&asked(&fair, &sizing, &medial)));
    let kinked = clock.time("kinks", || {
        let kinked = kinks::kinks(&fair, brep, &found.aag, &found.pairing, &medial)?;
        let parted = medial.paired(&found.aag, &kinked.pairing);
        Some((kinked, parted))
    });
    let held = leaves.then(|| Held::new(&medial));
    let cleaned = || clean(fair.clone(), &sizing, &medial, placer(&medial, &held));
    // Without kinks, or where they are cut without a fold, one of the two is enough; else both are wanted and made side by side.
    let (plain, cut) = clock.time("clean", || {
        let Some((kinked, parted)) = &kinked else {
            return (Some(cleaned()), None);
        };
        let held = leaves.then(|| Held::new(parted));
        let cut = || {
            let complex = kinked.complex.clone();
            clean(complex, &sizing, parted, placer(parted, &held))
        };
        if folds(&kinked.complex) > 0 {
            let (plain, cut) = rayon::join(cleaned, cut);
            (Some(plain), Some((cut, kinked, parted)))
        } else {
            (None, Some((cut(), kinked, parted)))
        }
    });
    let made = |plain: Option<MidComplex>, clock: &mut Clock<'_>| {
        plain.unwrap_or_else(|| clock.time("clean", cleaned))
    };
    let (plain, cut) = match cut {
        Some(cut) if folds(&cut.0) > 0 => {
            let plain = made(plain, clock);
            let fewer = folds(&cut.0) <= folds(&plain);
            (Some(plain), fewer.then_some(cut))
        }
        cut => (plain, cut),
    };
    let complex = match cut {
        None => meshed(made(plain, clock), &sizing, &medial, leaves, &dump, clock)?,
        Some((cut, kinked, parted)) => {
            let cut = kinked.joined(meshed(cut, &sizing, parted, leaves, &dump, clock)?);
            // What was parted at a kink has no neighbours there; joined, it may show a fold.
            let cut = clock.time("polish", || {
                connected(cut, |c| remesh::unfold(c, placer(&medial, &held)))
            });
            // A kink that leads into a crowded corner may fold; without it the mesh is less exact but fit for a solver.
            if folds(&cut) == 0 {
                cut
            } else {
                let plain = made(plain, clock);
                if folds(&plain) > 0 {
                    cut
                } else {
                    let plain = meshed(plain, &sizing, &medial, leaves, &dump, clock)?;
                    if folds(&plain) == 0 { plain } else { cut }
                }
            }
        }
    };
    let mesh = clock.time("shell", || {
        shell::shell(brep, &found.pairing, &medial, &complex)
    });
    let solid = SolidReport::new(brep, &found, sizing.target, &mesh);
    Ok((mesh, solid))
}

fn folds(complex: &MidComplex) -> usize {
    orient::folded(complex).len()
}

/// A clean complex meshed at the wanted sizes.
fn meshed(
    clean: MidComplex,
    sizing: &size::Sizing,
    medial: &Medial<'_>,
    leaves: bool,
    dump: &Dump<'_>,
    clock: &mut Clock<'_>,
) -> Result<MidComplex, PipelineError> {
    let held = leaves.then(|| Held::new(medial));
    let held = placer(medial, &held);
    let field = field(sizing, medial);
    dump.complex("clean", &clean)?;
    let options = RemeshOptions::default();
    let complex = clock.time("remesh", || remesh::remesh(clean, &field, held, &options).0);
    dump.complex("remeshed", &complex)?;
    let complex = clock.time("charts", || {
        charts::mesh_charts(&complex, &field, held).complex
    });
    dump.complex("charted", &complex)?;
    let complex = clock.time("polish", || {
        let complex = remesh::polish(complex, &field, held, &options);
        let complex = mended(complex, held);
        let complex = connected(complex, |c| remesh::without_flat(c, held));
        let complex = connected(complex, |c| fins::unfinned(c, held));
        let mut complex = connected(complex, |c| remesh::unfold(c, held));
        open_pinholes(&mut complex);
        complex
    });
    dump.complex("polished", &complex)?;
    let complex = clock.time("balance", || balance::balance(complex, medial));
    dump.complex("balanced", &complex)?;
    Ok(complex)
}

/// The wanted edge lengths of a solid.
fn sizing(
    brep: &Brep,
    found: &MidSurface,
    medial: &Medial<'_>,
    options: &MeshOptions,
) -> size::Sizing {
    size::sizing(brep, &found.pairing, options.size, options.size_curvature).eased(
        brep,
        &found.pairing,
        &|p, w| medial.curvature_radius(p, w),
    )
}

/// The edge length wanted at a place on a wall, mm.
fn field<'a>(
    sizing: &'a size::Sizing,
    medial: &'a Medial<'_>,
) -> impl Fn(DVec3, WallId) -> f64 + Sync + 'a {
    |p, w| {
        let thickness = medial.mean_thickness(w);
        let bend = sizing.at(medial.curvature_radius(p, w), thickness);
        bend.min(sizing.at_step(medial.step_radius(p, w), thickness))
    }
}

/// Of every triangle the area, mm², and the edge length wanted in its middle, mm.
fn asked(complex: &MidComplex, sizing: &size::Sizing, medial: &Medial<'_>) -> Vec<(f64, f64)> {
    let field = field(sizing, medial);
    (complex.triangles.as_slice().par_iter())
        .map(|t| {
            let [a, b, c] = t.nodes.map(|n| complex.nodes[n].point);
            let area = (b - a).cross(c - a).length() / 2.0;
            (area, field((a + b + c) / 3.0, t.wall))
        })
        .collect()
}

/// What places nodes: the medial surfaces, held in the material where sheets would leave it otherwise.
fn placer<'a>(medial: &'a Medial<'a>, held: &'a Option<Held<'a>>) -> &'a dyn Placer {
    match held {
        Some(held) => held,
        None => medial,
    }
}

/// The raw complex untangled, and whether its sheets had to be held in the material. Holding what does not leave it would only stand in the way of untangling.
fn inside(found: &MidSurface, medial: &Medial<'_>, clock: &mut Clock<'_>) -> (MidComplex, bool) {
    let fair = untangled(found, medial, medial, clock);
    let held = Held::new(medial);
    let leaves = clock.time("fair", || held.outside(&fair)) > LEAVES;
    if leaves {
        (untangled(found, medial, &held, clock), true)
    } else {
        (fair, false)
    }
}

/// The raw complex untangled.
fn untangled(
    found: &MidSurface,
    walls: &Medial<'_>,
    medial: &dyn Placer,
    clock: &mut Clock<'_>,
) -> MidComplex {
    let thickness = |w: WallId| walls.mean_thickness(w);
    clock.time("fair", || {
        let (complex, _) = fair::fair(extract::place(found.complex.clone(), medial), medial);
        let complex = connected(complex, |c| remesh::merge_strips(c, &thickness, medial));
        let complex = connected(complex, |c| remesh::without_flat(c, medial));
        // Where strips have become curves, what hung between them is a fin.
        let (complex, _) = prune::prune(complex, medial);
        let (complex, _) = unknotted(fair::fair(complex, medial), medial);
        let complex = connected(complex, |c| remesh::without_flat(c, medial));
        let (complex, _) = prune::prune(complex, medial);
        // A junction of five walls parts twice on its way to a rim: the second slit shows when the strips between its curves are gone.
        connected(complex, |c| remesh::merge_slits(c, &thickness, medial))
    })
}

/// Contracts what is still turned and untangles again, in turns; with how many turned triangles are left.
fn unknotted(
    (mut complex, mut stats): (MidComplex, FairStats),
    medial: &dyn Placer,
) -> (MidComplex, usize) {
    for _ in 1..KNOT_ROUNDS {
        if stats.turned_after == 0 {
            break;
        }
        complex = connected(complex, |c| remesh::contract_turned(c, medial));
        (complex, stats) = fair::fair_again(complex, medial);
    }
    (complex, stats.turned_after)
}

/// A finished complex with fewer turned or folded triangles, if it can be had.
fn mended(mut complex: MidComplex, medial: &dyn Placer) -> MidComplex {
    // What is folded over stops a solver; what only leans from its wall's normal may be a coarse bend.
    let count = |c: &MidComplex| {
        let all: Vec<TriangleId> = c.triangles.ids().collect();
        (
            orient::folded(c).len(),
            orient::turned(c, &all, medial).len(),
        )
    };
    let mut left = count(&complex);
    for _ in 0..KNOT_ROUNDS {
        if left == (0, 0) {
            break;
        }
        let next = connected(complex.clone(), |c| remesh::contract_folded(c, medial));
        let (next, _) = fair::fair_again(next, medial);
        let now = count(&next);
        if now >= left {
            break;
        }
        (complex, left) = (next, now);
    }
    complex
}

/// The complex without what is far smaller than an element.
fn clean(
    fair: MidComplex,
    sizing: &size::Sizing,
    walls: &Medial<'_>,
    medial: &dyn Placer,
) -> MidComplex {
    let field = field(sizing, walls);
    let shortest = |p: DVec3, w: WallId| sizing.speck(field(p, w));
    let complex = remesh::clean(fair, &shortest, medial);
    // The remesher refines a fold into many.
    connected(complex, |c| remesh::unfold(c, medial))
}

/// The changed complex, or the old one where sheets would come to hang together only by a point: contraction keeps the homotopy type, not that.
fn connected(old: MidComplex, change: impl FnOnce(MidComplex) -> MidComplex) -> MidComplex {
    let new = change(old.clone());
    if new.pieces() == old.pieces() {
        new
    } else {
        old
    }
}
