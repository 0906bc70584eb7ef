//! Flips inner edges where that makes the worse of the two triangles better.

use super::job::Job;
use super::shape::{LARGEST_TILT, area_vector, quality};
use super::surface::Surface;
use crate::model::ids::{NodeId, TriangleId};
use glam::DVec3;
use std::collections::VecDeque;

/// Cosine of the sharpest fold over which an edge is flipped: 45 degrees. Across a sharper one the flip would cut the fold off.
const SHARPEST: f64 = 0.7;
/// A flip must gain this much, so that rounding does not flip a square's diagonal for ever.
const GAIN: f64 = 1e-6;
/// No edge needs more flips than this on the mean; a bound for surfaces on which the gains do not add up.
const MOST: usize = 20;

/// Flips until no edge gains.
pub(super) fn flip_all(job: &mut Job) {
    let mut queue: VecDeque<[NodeId; 2]> = job.surface.edges().into();
    let mut left = MOST * queue.len();
    while let Some([a, b]) = queue.pop_front() {
        if left == 0 {
            break;
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
    let before = quality(old[0]).min(quality(old[1]));
    let new = surface
        .flipped([a, b], [s, t])
        .map(|nodes| nodes.map(|n| surface.points[n]));
    let after = quality(new[0]).min(quality(new[1]));
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
    // Compared with both old triangles together: one of them is often a needle without a normal of its own.
    let whole = area_vector(old[0]) + winding(surface, s, t, [a, b]) * area_vector(old[1]);
    let whole = whole.normalize_or_zero();
    let reference = (surface.reference[s] + surface.reference[t]).normalize_or_zero();
    let lean = |p| area_vector(p).normalize_or_zero().dot(reference);
    let least_lean = old.into_iter().map(lean).fold(LARGEST_TILT, f64::min);
    let sound = [0, 1].into_iter().all(|i| {
        normals[i].dot(whole) > 0.5
            && (reference == DVec3::ZERO || normals[i].dot(reference) >= least_lean)
    });
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
