//! Flips inner edges where that makes the worse of the two triangles better; one that is turned over counts as worse than any other.

use super::job::Job;
use super::shape::{area_vector, signed_quality};
use super::surface::Surface;
use crate::model::ids::{NodeId, TriangleId};
use glam::DVec3;
use rayon::prelude::*;
use std::collections::VecDeque;

/// Cosine of the sharpest fold over which an edge is flipped: 45 degrees. Across a sharper one the flip would cut the fold off.
const SHARPEST: f64 = 0.7;
/// A flip must gain this much, so that rounding does not flip a square's diagonal for ever.
const GAIN: f64 = 1e-6;
/// No edge needs more flips than this on the mean; a bound for surfaces on which the gains do not add up.
const MOST: usize = 20;

/// Flips until no edge gains.
pub(super) fn flip_all(job: &mut Job) {
    flip_below(job, f64::INFINITY);
}

/// Flips until no edge gains at which a triangle's signed quality is below `limit`.
pub(super) fn flip_below(job: &mut Job, limit: f64) {
    let surface = &job.surface;
    let poor = |surface: &Surface, [a, b]: [NodeId; 2]| {
        limit == f64::INFINITY
            || surface
                .around(a, b)
                .into_iter()
                .any(|t| signed_quality(surface.corners(t), surface.reference[t]) < limit)
    };
    let edges = surface.edges();
    let mut left = MOST * edges.len();
    let mut queue: VecDeque<[NodeId; 2]> = edges
        .into_par_iter()
        .filter(|&[a, b]| poor(surface, [a, b]) && gain(surface, a, b).is_some())
        .collect::<Vec<_>>()
        .into();
    while let Some([a, b]) = queue.pop_front() {
        if left == 0 {
            break;
        }
        if !poor(&job.surface, [a, b]) {
            continue;
        }
        let Some((pair, _)) = gain(&job.surface, a, b) else {
            continue;
        };
        left -= 1;
        let (c, d) = (
            job.surface.apex(pair[0], a, b),
            job.surface.apex(pair[1], a, b),
        );
        job.surface.flip([a, b], pair);
        job.stats.flips += 1;
        for n in [a, b] {
            for m in [c, d] {
                queue.push_back([n.min(m), n.max(m)]);
            }
        }
    }
}

/// The two triangles of an edge whose flip is allowed and gains, and the least quality after it.
pub(super) fn gain(surface: &Surface, a: NodeId, b: NodeId) -> Option<([TriangleId; 2], f64)> {
    let ring = surface.around(a, b);
    let &[s, t] = ring.as_slice() else {
        return None;
    };
    if surface.triangle(s).wall != surface.triangle(t).wall {
        return None;
    }
    let old = [surface.corners(s), surface.corners(t)];
    let reference = (surface.reference[s] + surface.reference[t]).normalize_or_zero();
    let least = |p: [[DVec3; 3]; 2]| p.map(|p| signed_quality(p, reference));
    let before = least(old).into_iter().fold(1.0, f64::min);
    let new = surface
        .flipped([a, b], [s, t])
        .map(|nodes| nodes.map(|n| surface.points[n]));
    let after = least(new).into_iter().fold(1.0, f64::min);
    if after <= before + GAIN {
        return None;
    }
    let (c, d) = (surface.apex(s, a, b), surface.apex(t, a, b));
    if c == d || !surface.around(c, d).is_empty() {
        return None;
    }
    let normals = new.map(|p| area_vector(p).normalize_or_zero());
    if normals[0].dot(normals[1]) < SHARPEST {
        return None;
    }
    // Where no normal is known, both old triangles together tell the side: one of them is often a needle without a normal of its own.
    let whole = area_vector(old[0]) + winding(surface, s, t, [a, b]) * area_vector(old[1]);
    let whole = whole.normalize_or_zero();
    let sound = normals
        .into_iter()
        .all(|n| reference != DVec3::ZERO || n.dot(whole) > 0.5);
    sound.then_some(([s, t], after))
}

/// 1 where both triangles are wound the same way, else -1 (a one-sided sheet has such an edge).
fn winding(surface: &Surface, s: TriangleId, t: TriangleId, [a, b]: [NodeId; 2]) -> f64 {
    let forward = |t: TriangleId| {
        let n = surface.triangle(t).nodes;
        (0..3).any(|k| [n[k], n[(k + 1) % 3]] == [a, b])
    };
    if forward(s) == forward(t) { -1.0 } else { 1.0 }
}
