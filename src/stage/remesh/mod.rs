//! Remeshing of a non-manifold triangle complex to a size field, with the topology and the feature curves kept.
//!
//! [`clean`] contracts what is small in a raw complex (needles, caps, specks); [`remesh`] then makes good triangles: rounds of
//! splitting long edges, contracting short ones, flipping and tangential smoothing (Botsch & Kobbelt 2004, "A remeshing approach to
//! multiresolution modeling", DOI 10.1145/1057432.1057457), every node put back onto its supports, then a local search at the worst triangles.
//!
//! # Input
//! A [`MidComplex`] whose `check()` is empty, orphan nodes allowed (they are dropped). Windings may be mixed.
//!
//! # Guarantees
//! - The homotopy type and the graph of feature curves (rims, junctions, creases between walls, their corners and loops) stay: contraction
//!   only under the link condition with feature strata (see `contract`), splits and flips cannot change them.
//! - Corners stay: ends and forks of feature curves, and sharp turns (see `strata`).
//! - Curves stay within `max_deviation` of where they were at the start, and nodes on them are put onto their supports.
//! - No triangle turns over in one operation, nor leans further than 75 degrees from its wall; exceptions are triangles that did so at the
//!   start (they may only get better), and those far smaller or flatter than the size, which go without regard to their normals.
//! - Each sheet comes out wound one way, to the side of the wall's normal.
//! - Same result for any number of threads; scale-free.
//!
//! # Limits
//! - Feature edges that form a triangle, or that lie closer than the wanted size, stay; sizes shrink there, down to a tenth.
//! - Sheets do not see each other: two that come near may touch, where the size is far above their distance.
//!
//! # Cost
//! Near-linear: about ten sweeps over all edges a round.

mod caps;
mod cones;
mod contract;
mod dust;
mod fill;
mod flat;
mod flip;
mod forks;
mod guide;
mod job;
mod knots;
mod polish;
mod rate;
mod refill;
mod search;
mod shape;
mod sizes;
mod smooth;
mod split;
mod spurs;
mod still;
mod strata;
mod strips;
mod surface;
#[cfg(test)]
mod tests;
mod tried;
mod unfold;
mod zip;

use crate::geom::orient::orient;
use crate::geom::placer::Placer;
use crate::model::complex::MidComplex;
use crate::model::ids::{IndexVec, NodeId, WallId};
pub use flat::without_flat;
pub use knots::{contract_folded, contract_turned};
pub use strips::{merge_slits, merge_strips};
pub use unfold::unfold;

use contract::Bounds;
use glam::DVec3;
use guide::{GuideRules, Guides};
use job::{Job, SizeField};
use surface::Surface;

/// How to remesh.
#[derive(Clone, Debug, PartialEq)]
pub struct RemeshOptions {
    /// Rounds of split, contract, flip, smooth. 5 by default: then the edge lengths have settled, more is smoothing.
    pub rounds: usize,
    /// How far an edge may leave its feature curve, as a share of the wall's thickness. 0.05 by default: a hole as wide as ten thicknesses
    /// gets 22 edges.
    pub max_deviation: f64,
    /// Feature curves that turn by more than this, radians, have a corner there. 50 degrees by default: above the 45 of an octagon, which a
    /// coarse circle may be.
    pub crease_angle: f64,
    /// Edges round a full circle, at least, on curves and on curved walls. 10 by default.
    pub segments_per_turn: f64,
    /// Neighbouring sizes differ by this factor at most. 1.3 by default.
    pub gradation: f64,
    /// No bend of a curve or a wall and no narrow place asks for shorter edges, mm; curves may be left by as much as such edges leave them. Zero by default.
    pub least: f64,
}

impl Default for RemeshOptions {
    fn default() -> Self {
        Self {
            rounds: 5,
            max_deviation: 0.05,
            crease_angle: 50f64.to_radians(),
            segments_per_turn: 10.0,
            gradation: 1.3,
            least: 0.0,
        }
    }
}

impl RemeshOptions {
    /// For meshes that are to be quads: rows of quads do not get wider as fast as triangles, so that curves are followed less closely.
    pub fn for_quads() -> Self {
        Self {
            max_deviation: 0.12,
            ..Self::default()
        }
    }
}

/// What was done.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct RemeshStats {
    /// Edges split.
    pub splits: usize,
    /// Edges contracted.
    pub contractions: usize,
    /// Edges flipped.
    pub flips: usize,
    /// Node moves accepted.
    pub moves: usize,
    /// Nodes that at the end could not be put wholly onto their supports without turning a triangle over.
    pub unplaced: usize,
    /// Triangles that are still out of shape: edge ratio above 2.3 or an angle outside 33 to 107 degrees.
    pub out_of_shape: usize,
}

/// Share of the size over which turns and bends of a curve are judged: finer ones are noise at that size.
const REACH: f64 = 0.1;
/// At a knife edge or the crest of a rounding a wall has no thickness, and a curve that may not be left at all would be split without end: this share of the size stands for it.
const KNIFE: f64 = 0.01;
/// In cleaning a curve may be left by this share of the shortest edge: noise of that height goes, an octagon of two such radii stays.
const CLEAN_SLACK: f64 = 0.25;
/// Passes of cleaning; each cap that goes can make a short edge, few need more than two.
const CLEAN_PASSES: usize = 6;
/// Signed quality below which cleaning flips: needles and folded triangles, which keep short edges from going.
const CRUMPLED: f64 = 0.2;
/// One split or contraction for this many triangles in a round: the mesh has settled, and more rounds only shift nodes.
const SETTLED: usize = 500;
/// Smoothing steps in a round: more help little before the next splits and contractions.
const SMOOTHINGS: usize = 3;

/// Remeshes a complex to edges of length `size(point, wall)`, mm. See the module's page for what is kept.
///
/// `size` must be positive; where it is not, the wall sets no size.
pub fn remesh(
    mut complex: MidComplex,
    size: &(dyn Fn(DVec3, WallId) -> f64 + Sync),
    placer: &dyn Placer,
    options: &RemeshOptions,
) -> (MidComplex, RemeshStats) {
    orient(&mut complex, placer);
    let mut job = start(complex, placer, options);
    job.refresh_references();
    job.place_all();
    follow(&mut job, size);
    uncrumple(&mut job, Bounds::specks());
    uncrumple(&mut job, Bounds::stretched());
    for round in 0..options.rounds {
        job.refresh_references();
        sizes::renew(&mut job, size, round > 0);
        let before = job.stats;
        split::split_long(&mut job);
        flip::flip_all(&mut job);
        // Stretched edges would be split and contracted in turn for ever: the later rounds settle.
        let bounds = if 4 * round < options.rounds {
            Bounds::stretched()
        } else {
            Bounds::remesh()
        };
        contract::contract_short(&mut job, bounds);
        flip::flip_all(&mut job);
        smooth::smooth(&mut job, SMOOTHINGS);
        let changes =
            job.stats.splits + job.stats.contractions - (before.splits + before.contractions);
        if 2 * round >= options.rounds && changes * SETTLED < job.surface.live_triangles().count() {
            break;
        }
    }
    job.refresh_references();
    flip::flip_all(&mut job);
    job.place_all();
    polish::polish(&mut job);
    job.refresh_references();
    job.place_all();
    job.stats.out_of_shape = job
        .surface
        .live_triangles()
        .filter(|&t| polish::is_bad(job.surface.corners(t)))
        .count();
    (job.surface.finish(), job.stats)
}

/// Mends the triangles that are out of shape, one by one, and leaves all others as they are; what is kept is kept as by [`remesh`].
pub fn polish(
    mut complex: MidComplex,
    size: &(dyn Fn(DVec3, WallId) -> f64 + Sync),
    placer: &dyn Placer,
    options: &RemeshOptions,
) -> MidComplex {
    orient(&mut complex, placer);
    let mut job = start(complex, placer, options);
    job.refresh_references();
    follow(&mut job, size);
    polish::polish(&mut job);
    job.place_all();
    job.surface.finish()
}

/// Contracts edges shorter than `shortest(point, wall)`, mm, and removes caps as low as a fifth of it, with the topology and the feature
/// curves kept. Nodes that stay do not move.
pub fn clean(
    mut complex: MidComplex,
    shortest: &(dyn Fn(DVec3, WallId) -> f64 + Sync),
    placer: &dyn Placer,
) -> MidComplex {
    orient(&mut complex, placer);
    let options = RemeshOptions::default();
    let mut job = start(complex, placer, &options);
    job.refresh_references();
    job.size = sizes::raw(&mut job, shortest);
    let size_at = job.size.clone();
    trace(
        &mut job,
        &|n| CLEAN_SLACK * size_at[n],
        &|n| size_at[n],
        false,
    );
    uncrumple(&mut job, Bounds::clean());
    job.surface.finish()
}

/// Contracts what is short, and what a contraction cannot take, flips; over and over until nothing gives.
fn uncrumple(job: &mut Job, bounds: Bounds) {
    for _ in 0..CLEAN_PASSES {
        contract::contract_short(job, bounds);
        let before = job.stats;
        flip::flip_below(job, CRUMPLED);
        caps::remove_caps(job);
        if job.stats == before {
            break;
        }
        job.refresh_references();
    }
}

/// Takes the sizes, and records the feature curves as they are at these.
fn follow(job: &mut Job, size: SizeField) {
    job.size = sizes::raw(job, size);
    let slack: IndexVec<NodeId, f64> = job
        .surface
        .points
        .ids()
        .map(|n| {
            let p = job.surface.points[n];
            let thickness = job
                .surface
                .walls(n)
                .into_iter()
                .filter_map(|w| job.placer.thickness(p, w))
                .fold(f64::INFINITY, f64::min);
            // Where no thickness is known the size stands for it.
            let scale = if thickness.is_finite() && thickness > 0.0 {
                thickness.max(KNIFE * job.size[n])
            } else {
                job.size[n]
            };
            job.options.max_deviation * scale
        })
        .collect();
    let size_at = job.size.clone();
    trace(job, &|n| slack[n], &|n| REACH * size_at[n], true);
    sizes::renew(job, size, false);
}

fn start<'a>(complex: MidComplex, placer: &'a dyn Placer, options: &'a RemeshOptions) -> Job<'a> {
    let mut surface = Surface::new(complex);
    flat::remove_flat(&mut surface, placer);
    Job {
        surface,
        guides: Guides::default(),
        placer,
        options,
        size: IndexVec::new(),
        asked: IndexVec::new(),
        stats: RemeshStats::default(),
    }
}

/// Classifies the nodes and records the feature curves; `exact`: as the placer has them, not as the edges have them.
fn trace(job: &mut Job, slack: &dyn Fn(NodeId) -> f64, reach: &dyn Fn(NodeId) -> f64, exact: bool) {
    let chains = strata::classify(&mut job.surface, job.options.crease_angle, reach);
    let (size, held) = (&job.size, &*job);
    let onto = |[a, b]: [NodeId; 2], p: DVec3| held.placer.place(p, &held.middle_supports(a, b));
    let guides = Guides::new(
        &job.surface,
        &chains,
        &GuideRules {
            segments: job.options.segments_per_turn,
            slack,
            floor: &|n| sizes::floor(job.options, size[n]),
            reach,
            onto: exact.then_some(&onto),
            growth: job.options.gradation - 1.0,
            least: job.options.least,
        },
    );
    job.guides = guides;
}
