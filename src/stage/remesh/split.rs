//! Splits edges that are too long, or whose chord leaves its feature curve.

use super::guide::GuideId;
use super::job::Job;
use super::shape::{may_turn, quality, signed_quality};
use super::surface::key;
use crate::model::complex::Supports;
use crate::model::ids::NodeId;
use glam::DVec3;
use rayon::prelude::*;

/// Edges longer than this times the wanted length are split: then both halves are nearer to it than the whole was (Botsch & Kobbelt 2004).
pub(super) const LONGEST: f64 = 4.0 / 3.0;
/// Sides this much longer still count as equal: of an equilateral triangle all may be split in one pass.
const TIE: f64 = 1.02;
/// Each pass splits the longest edges of all places; a bound for size fields that no splits can follow.
const PASSES: usize = 100;

/// A new node on an edge.
pub(super) struct Middle {
    pub point: DVec3,
    /// The point of the straight edge that it stands for.
    pub on_edge: DVec3,
    pub supports: Supports,
    pub spot: Option<(GuideId, f64)>,
}

/// Splits until no edge is too long.
pub(super) fn split_long(job: &mut Job) {
    for _ in 0..PASSES {
        let mut long: Vec<(u64, [NodeId; 2])> = job
            .surface
            .edges()
            .into_par_iter()
            .filter_map(|[a, b]| {
                let ratio = job.ratio(a, b);
                let over =
                    (ratio > LONGEST && leads(job, a, b)) || (ratio > 0.2 && strays(job, a, b));
                (over && !folded(job, a, b)).then(|| (key(ratio), [a, b]))
            })
            .collect();
        if long.is_empty() {
            return;
        }
        long.sort_unstable_by(|x, y| y.0.cmp(&x.0).then(x.1.cmp(&y.1)));
        // No split removes another edge of the list, so that all middles can be found beforehand.
        let middles: Vec<Middle> = long.par_iter().map(|&(_, e)| middle(job, e)).collect();
        for ((_, edge), new) in long.into_iter().zip(middles) {
            apply(job, edge, new);
        }
    }
}

/// Whether no triangle at an edge has a side that needs a split more: where all sides of a triangle are split at once, too many nodes come
/// of it, which contractions then take out again.
fn leads(job: &Job, a: NodeId, b: NodeId) -> bool {
    let most = TIE * job.ratio(a, b);
    job.surface.around(a, b).into_iter().all(|t| {
        let c = job.surface.apex(t, a, b);
        job.ratio(a, c) <= most && job.ratio(b, c) <= most
    })
}

/// Whether a triangle at an edge is turned over: splits would only make many folds of one.
fn folded(job: &Job, a: NodeId, b: NodeId) -> bool {
    let surface = &job.surface;
    surface
        .around(a, b)
        .into_iter()
        .any(|t| signed_quality(surface.corners(t), surface.reference[t]) < 0.0)
}

/// Whether a feature edge leaves its curve by more than allowed.
fn strays(job: &Job, a: NodeId, b: NodeId) -> bool {
    let surface = &job.surface;
    surface.is_feature(&surface.around(a, b))
        && job.guides.span(surface, a, b).is_some_and(|span| {
            job.guides
                .deviation(&span, surface.points[a], surface.points[b])
                > 1.0
        })
}

/// Where to split an edge: in the middle, or, where it is some odd number of wanted lengths long, so that the parts are whole numbers of
/// them. Halving alone would end between half and whole lengths by chance.
fn fraction(ratio: f64) -> f64 {
    // Past 100 lengths the half is as good.
    let parts = ratio.clamp(2.0, 100.0).round();
    (parts / 2.0).floor() / parts
}

/// The new node of an edge, on its supports.
pub(super) fn middle(job: &Job, [a, b]: [NodeId; 2]) -> Middle {
    let surface = &job.surface;
    let (p, q) = (surface.points[a], surface.points[b]);
    let supports = job.middle_supports(a, b);
    let feature = surface.is_feature(&surface.around(a, b));
    let span = feature.then(|| job.guides.span(surface, a, b)).flatten();
    let f = fraction(job.ratio(a, b));
    let spot = span.map(|s| {
        let along = if s.forward { f } else { 1.0 - f };
        (s.guide, s.from + along * (s.to - s.from))
    });
    let on_edge = p.lerp(q, f);
    let start = spot.map_or(on_edge, |(guide, at)| job.guides.point(guide, at));
    let placed = job.placer.place(start, &supports);
    // A place far from the edge is another branch of the surface.
    let near = |x: DVec3| x.distance(on_edge) <= 0.5 * p.distance(q);
    let point = [placed, start]
        .into_iter()
        .find(|&x| x.is_finite() && near(x))
        .unwrap_or(on_edge);
    Middle {
        point,
        on_edge,
        supports,
        spot,
    }
}

/// Splits an edge, at the point of the straight edge where the wanted point would turn a triangle over.
pub(super) fn apply(job: &mut Job, [a, b]: [NodeId; 2], new: Middle) -> NodeId {
    let surface = &job.surface;
    let (p, q) = (surface.points[a], surface.points[b]);
    let sound = surface.around(a, b).into_iter().all(|t| {
        let old = surface.corners(t);
        [p, q].into_iter().all(|end| {
            let half = old.map(|x| if x == end { new.point } else { x });
            may_turn(old, half, surface.reference[t]) && quality(half) > 0.1 * quality(old)
        })
    });
    let point = if sound { new.point } else { new.on_edge };
    job.stats.splits += 1;
    job.split_edge([a, b], point, new.supports, new.spot)
}
