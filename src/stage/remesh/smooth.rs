//! Moves nodes so that triangles become even: sheet nodes in the tangent plane, curve nodes along their curve.
//!
//! Targets are found from the old positions (in parallel, so that their order cannot matter) and accepted one after the other, each against
//! the positions of its neighbours as they are then.

use super::guide::{GuideId, Span};
use super::job::Job;
use super::shape::area_vector;
use super::surface::Class;
use crate::model::ids::NodeId;
use glam::DVec3;
use rayon::prelude::*;

/// A move that worsens its triangles is still good while all of them stay above this (angles about 38 to 90 degrees, edges 1 : 1.6).
const GOOD: f64 = 0.8;
/// Share of the way to the target: all nodes move at once, and full steps would overshoot together.
const RELAX: f64 = 0.7;

/// A move shorter than this share of the size changes no quality that anyone could tell.
const STILL: f64 = 0.01;

/// A place for a node; for a curve node with its arc length on the guide.
#[derive(Clone, Copy, Debug)]
pub(super) struct Target {
    pub point: DVec3,
    pub at: Option<f64>,
}

/// Moves all nodes but corners, `times` over.
pub(super) fn smooth(job: &mut Job, times: usize) {
    for time in 0..times {
        // Sheet nodes leave the surface by the square of a step: the last time of all brings them back.
        let exact = time + 1 == times;
        let nodes: Vec<NodeId> = job
            .surface
            .live_nodes()
            .filter(|&n| job.surface.class[n] != Class::Corner)
            .collect();
        let targets: Vec<Option<Target>> =
            (nodes.par_iter().map(|&n| smoothed(job, n, exact))).collect();
        for (&n, target) in nodes.iter().zip(targets) {
            if let Some(target) = target {
                if is_still(job, n, target.point) {
                    continue;
                }
                let before = job.surface.quality_now(n);
                if job
                    .surface
                    .quality_at(n, target.point, before)
                    .is_some_and(|q| q >= before.min(GOOD))
                {
                    accept(job, n, target);
                }
            }
        }
    }
}

/// Where smoothing takes a node; not always `exact`ly onto its supports.
fn smoothed(job: &Job, n: NodeId, exact: bool) -> Option<Target> {
    if job.surface.class[n] != Class::Sheet {
        return target(job, n, RELAX);
    }
    let start = sheet_start(job, n, RELAX);
    if is_still(job, n, start) {
        return None;
    }
    if exact {
        placed(job, n, start, None)
    } else {
        start.is_finite().then_some(Target {
            point: start,
            at: None,
        })
    }
}

fn is_still(job: &Job, n: NodeId, point: DVec3) -> bool {
    point.distance(job.surface.points[n]) < STILL * job.size[n]
}

/// Carries a move out.
pub(super) fn accept(job: &mut Job, n: NodeId, target: Target) {
    job.surface.points[n] = target.point;
    if let Some(at) = target.at {
        job.guides.slide(n, at);
    }
    job.stats.moves += 1;
}

/// Where a node should go.
pub(super) fn target(job: &Job, n: NodeId, share: f64) -> Option<Target> {
    match job.surface.class[n] {
        Class::Corner => None,
        Class::Sheet => placed(job, n, sheet_start(job, n, share), None),
        Class::Curve => curve_target(job, n, share),
    }
}

/// The middle of the triangles of a sheet node, in its tangent plane.
fn sheet_start(job: &Job, n: NodeId, share: f64) -> DVec3 {
    let surface = &job.surface;
    let (mut sum, mut weight) = (DVec3::ZERO, 0.0);
    for &t in surface.star(n) {
        let [a, b, c] = surface.corners(t);
        let area = area_vector([a, b, c]).length();
        let size: f64 = surface.triangle(t).nodes.map(|m| job.size[m]).iter().sum();
        // In a centroidal Voronoi tessellation cells have width h where the density is h^-4 (Du, Faber, Gunzburger 1999).
        let w = area / size.powi(4);
        sum += (a + b + c) / 3.0 * w;
        weight += w;
    }
    let from = surface.points[n];
    let step = sum / weight - from;
    let normal = job.normal_at(n);
    let tangent = (step - normal * step.dot(normal)) * share;
    from + tangent
}

/// The feature neighbours of a curve node in order along its guide, with the spans to them.
pub(super) fn beside(job: &Job, n: NodeId) -> Option<[(NodeId, Span); 2]> {
    let ends = job.surface.feature_neighbours(n);
    let &[a, b] = ends.as_slice() else {
        return None;
    };
    let (s, t) = (
        job.guides.span(&job.surface, n, a)?,
        job.guides.span(&job.surface, n, b)?,
    );
    if s.forward == t.forward {
        return None;
    }
    Some(if t.forward {
        [(a, s), (b, t)]
    } else {
        [(b, t), (a, s)]
    })
}

fn curve_target(job: &Job, n: NodeId, share: f64) -> Option<Target> {
    let [(a, s), (b, t)] = beside(job, n)?;
    let (behind, ahead) = (s.to - s.from, t.to - t.from);
    let (wa, wb) = (job.wanted(a, n), job.wanted(b, n));
    let wanted = (behind + ahead) * wa / (wa + wb);
    along(job, n, s.guide, t.from, share * (wanted - behind))
}

/// The place of a curve node after a slide.
pub(super) fn along(job: &Job, n: NodeId, guide: GuideId, from: f64, step: f64) -> Option<Target> {
    let at = from + step;
    // Its distance from the guide, mostly the sag of a coarse guide, stays as it is until the placer decides.
    placed(job, n, job.guides.point(guide, at), Some(at))
}

/// The start point put onto the supports of the node; `None` where they send it far off.
pub(super) fn placed(job: &Job, n: NodeId, start: DVec3, at: Option<f64>) -> Option<Target> {
    let point = job.placer.draw(start, &job.surface.supports[n]);
    let near = point.is_finite() && point.distance(start) <= 0.5 * job.size[n];
    near.then_some(Target { point, at })
}
