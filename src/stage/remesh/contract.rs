//! Contracts edges that are too short, where neither topology nor features nor shape suffer.
//!
//! The link condition for 2-complexes with feature strata: Dey, Edelsbrunner, Guha, Nekhayev 1999, "Topology preserving edge contraction",
//! Publ. Inst. Math. 66. With the cone over the feature edges it says: the common neighbours of both ends are the apexes of the triangles
//! between them, no two triangles fall together, ends that both lie on features are joined by a feature edge and share no feature neighbour.

use super::job::Job;
use super::shape::{may_turn, quality, signed_quality};
use super::split::LONGEST;
use super::surface::{Class, Surface, key};
use crate::geom::placer::Placer;
use crate::model::ids::{NodeId, TriangleId};
use glam::DVec3;
use rayon::prelude::*;
use std::cmp::Reverse;
use std::collections::BinaryHeap;

/// Edges shorter than this times the wanted length are contracted (Botsch & Kobbelt 2004).
pub(super) const SHORTEST: f64 = 4.0 / 5.0;
/// A contraction may leave triangles this good whatever was there before; smoothing mends them. Worse ones must be better than before.
const FAIR: f64 = 0.3;
/// A new turn of a feature curve stays below this share of the corner angle, so that a later look takes it for no corner.
const TURN_SHARE: f64 = 0.75;
/// Where a node between two on one line goes the turn at its neighbours stays, to rounding, radians: of an edge a millionth as long as the part.
const SAME_TURN: f64 = 1e-9;

/// Edges this much shorter than short ones, that cannot go by the rules, belong to knots: crumpled places smaller than the mesh can show.
const KNOT: f64 = 0.5;
/// A triangle whose sides are below this share of the wanted length is noise: where its normal points means nothing.
const SPECK: f64 = 0.2;

/// Ends this near are one point at the scale of the mesh: only triangles flatter than that can turn over when they merge, and those are
/// for flips to mend.
const DUST: f64 = 0.05;
/// New edges may be longer than those that are split: they even out when the nodes about them move. With the shorter bound, meshes that come
/// from finer ones keep a quarter too many nodes.
const STRETCHED: f64 = 1.5;

/// Edges below this ratio go before anything else: what they belong to is no shape at this size.
const SPECKS: f64 = 0.3;

/// What a contraction must keep to.
#[derive(Clone, Copy, Debug)]
pub(super) struct Bounds {
    /// Edges whose ratio to the wanted length is below this are contracted.
    pub shorter_than: f64,
    /// New edges stay below this ratio, where no edge was longer before.
    pub longest: f64,
    /// How far a curve may be left, as a multiple of its slack.
    pub deviation: f64,
    /// Whether a knot may be undone by steps that only must not make it worse.
    pub knots: bool,
}

impl Bounds {
    /// Those of the first rounds of remeshing.
    pub fn stretched() -> Self {
        Self {
            longest: STRETCHED,
            ..Self::remesh()
        }
    }
    /// Those of remeshing.
    pub fn remesh() -> Self {
        Self {
            shorter_than: SHORTEST,
            longest: LONGEST,
            deviation: 1.0,
            knots: false,
        }
    }
    /// Those of the cleaning that begins a remeshing.
    pub fn specks() -> Self {
        Self {
            shorter_than: SPECKS,
            ..Self::clean()
        }
    }
    /// Those of cleaning: what is short goes, however long the others get.
    pub fn clean() -> Self {
        Self {
            shorter_than: 1.0,
            longest: f64::INFINITY,
            deviation: 1.0,
            knots: false,
        }
    }
}

/// Contracts the shortest edge until no short one can go: first with all guards, then the rest where triangles are folded or flat already.
pub(super) fn contract_short(job: &mut Job, bounds: Bounds) {
    sweep(job, bounds);
    let knots = Bounds {
        shorter_than: KNOT * bounds.shorter_than,
        knots: true,
        ..bounds
    };
    sweep(job, knots);
}

fn sweep(job: &mut Job, bounds: Bounds) {
    let short: Vec<Reverse<(u64, NodeId, NodeId)>> = job
        .surface
        .edges()
        .into_par_iter()
        .filter_map(|[a, b]| entry(job, a, b, bounds))
        .collect();
    let mut heap = BinaryHeap::from(short);
    while let Some(Reverse((k, a, b))) = heap.pop() {
        // Entries of edges that are gone or changed are stale; the change has put in new ones.
        if job.surface.around(a, b).is_empty() || k != key(job.ratio(a, b)) {
            continue;
        }
        if let Some((gone, kept)) = choose(job, a, b, bounds) {
            job.contract_edge(gone, kept);
            job.stats.contractions += 1;
            for n in job.surface.neighbours(kept) {
                heap.extend(entry(job, kept.min(n), kept.max(n), bounds));
            }
        }
    }
}

fn entry(
    job: &Job,
    a: NodeId,
    b: NodeId,
    bounds: Bounds,
) -> Option<Reverse<(u64, NodeId, NodeId)>> {
    let ratio = job.ratio(a, b);
    (ratio < bounds.shorter_than).then(|| Reverse((key(ratio), a, b)))
}

/// Which end of an edge may go; the one that leaves the better triangles.
fn choose(job: &Job, a: NodeId, b: NodeId, bounds: Bounds) -> Option<(NodeId, NodeId)> {
    let rate = |gone, kept| {
        let quality = outcome(job, gone, kept, bounds)?;
        let least = if bounds.knots && job.ratio(gone, kept) < DUST {
            -1.0
        } else if bounds.knots {
            knot_quality(job, gone)
        } else {
            FAIR.min(job.surface.quality_now(gone))
        };
        (quality >= least).then_some(quality)
    };
    match (rate(a, b), rate(b, a)) {
        (Some(p), Some(q)) if q > p => Some((b, a)),
        (Some(_), _) => Some((a, b)),
        (None, Some(_)) => Some((b, a)),
        (None, None) => None,
    }
}

/// Least quality of the triangles that a contraction changes; `None` where it is not allowed.
pub(super) fn outcome(job: &Job, gone: NodeId, kept: NodeId, bounds: Bounds) -> Option<f64> {
    let surface = &job.surface;
    if !keeps_topology(surface, gone, kept) {
        return None;
    }
    if surface.class[gone] == Class::Curve && !keeps_curve(job, gone, kept, bounds) {
        return None;
    }
    let p = surface.points[kept];
    let mut least = f64::INFINITY;
    let mut turned = 0i64;
    for &t in surface.star(gone) {
        let nodes = surface.triangle(t).nodes;
        let old = surface.corners(t);
        if bounds.knots {
            turned -= i64::from(rated(job, t, old) < 0.0);
        }
        if nodes.contains(&kept) {
            continue;
        }
        let new = surface.corners_with(t, gone, p);
        if bounds.knots {
            let quality = rated(job, t, new);
            turned += i64::from(quality < 0.0);
            least = least.min(quality);
        } else if may_turn(old, new, surface.reference[t]) {
            least = least.min(signed_quality(new, surface.reference[t]));
        } else {
            return None;
        }
        for n in nodes.into_iter().filter(|&n| n != gone) {
            let ratio = job.ratio(kept, n);
            if ratio > bounds.longest && ratio > job.ratio(gone, n) {
                return None;
            }
        }
    }
    match turned {
        _ if job.ratio(gone, kept) < DUST => Some(least),
        // Fewer folded triangles than before are worth any shape.
        ..0 => Some(least.max(FAIR)),
        0 => Some(least),
        _ => None,
    }
}

/// Signed quality of a triangle; without the sign where it is a speck.
fn rated(job: &Job, t: TriangleId, p: [DVec3; 3]) -> f64 {
    let size = job.surface.triangle(t).nodes.map(|n| job.size[n]);
    let small = SPECK * size[0].min(size[1]).min(size[2]);
    let longest = (p[0].distance(p[1]))
        .max(p[1].distance(p[2]))
        .max(p[2].distance(p[0]));
    if longest < small {
        quality(p)
    } else {
        signed_quality(p, job.surface.reference[t])
    }
}

fn knot_quality(job: &Job, n: NodeId) -> f64 {
    let star = job.surface.star(n).iter();
    star.map(|&t| rated(job, t, job.surface.corners(t)))
        .fold(f64::INFINITY, f64::min)
}

/// The link condition, with the strata of features and corners.
pub(super) fn keeps_topology(surface: &Surface, gone: NodeId, kept: NodeId) -> bool {
    keeps_homotopy(surface, gone, kept)
        && match (surface.class[gone], surface.class[kept]) {
            (Class::Corner, _) | (Class::Curve, Class::Sheet) => false,
            (Class::Sheet, _) => true,
            (Class::Curve, _) => {
                surface.is_feature(&surface.around(gone, kept)) && {
                    let near = surface.feature_neighbours(kept);
                    !surface
                        .feature_neighbours(gone)
                        .iter()
                        .any(|n| near.contains(n))
                }
            }
        }
}

/// The link condition without strata: the homotopy type stays, the graph of the features may change.
pub(super) fn keeps_homotopy(surface: &Surface, gone: NodeId, kept: NodeId) -> bool {
    let ring = surface.around(gone, kept);
    if ring.is_empty() {
        return false;
    }
    let (of_gone, of_kept) = (surface.neighbours(gone), surface.neighbours(kept));
    let common = |n: &NodeId| of_kept.binary_search(n).is_ok();
    // Apexes are distinct, as no two triangles have the same nodes: counting them is enough.
    if of_gone.iter().filter(|n| common(n)).count() != ring.len() {
        return false;
    }
    let falls_together = surface.star(gone).iter().any(|&t| {
        let nodes = surface.triangle(t).nodes;
        if nodes.contains(&kept) {
            return false;
        }
        let mut others = nodes.into_iter().filter(|&n| n != gone);
        let (Some(x), Some(y)) = (others.next(), others.next()) else {
            return true;
        };
        common(&x)
            && common(&y)
            && surface
                .around(x, y)
                .iter()
                .any(|&s| surface.apex(s, x, y) == kept)
    });
    !falls_together
}

/// Makes one node of two, in the middle between them and on the supports of both.
pub(super) fn merge(surface: &mut Surface, gone: NodeId, kept: NodeId, placer: &dyn Placer) {
    let middle = (surface.points[gone] + surface.points[kept]) / 2.0;
    let mut supports = surface.supports[kept].clone();
    supports.extend_from_slice(&surface.supports[gone]);
    supports.sort_unstable();
    supports.dedup();
    surface.contract(gone, kept);
    let placed = placer.place(middle, &supports);
    surface.points[kept] = if placed.is_finite() { placed } else { middle };
    surface.supports[kept] = supports;
}

/// Whether the curve through `gone` stays near its guide and makes no new corner when its node goes.
fn keeps_curve(job: &Job, gone: NodeId, kept: NodeId, bounds: Bounds) -> bool {
    let surface = &job.surface;
    let ends = surface.feature_neighbours(gone);
    let Some(&far) = ends.iter().find(|&&n| n != kept) else {
        return false;
    };
    let (p, q) = (surface.points[kept], surface.points[far]);
    for n in [kept, far] {
        let Some(span) = job.guides.span(surface, gone, n) else {
            return false;
        };
        if job.guides.deviation(&span, p, q) > bounds.deviation {
            return false;
        }
    }
    let most = TURN_SHARE * job.options.crease_angle;
    let v = surface.points[gone];
    [(kept, far), (far, kept)].into_iter().all(|(n, other)| {
        if surface.class[n] != Class::Curve {
            return true;
        }
        let Some(&beyond) = surface.feature_neighbours(n).iter().find(|&&m| m != gone) else {
            return false;
        };
        let before = surface.points[n] - surface.points[beyond];
        let turn = |to: DVec3| before.angle_between(to - surface.points[n]);
        let new = turn(surface.points[other]);
        new <= most || new <= turn(v) + SAME_TURN
    })
}
