//! Removes caps: triangles with one angle near 180 degrees, which have no short edge that a contraction could take.

use super::contract::keeps_topology;
use super::flip::gain;
use super::job::Job;
use super::shape::{area_vector, may_turn};
use super::surface::Class;
use crate::model::ids::{NodeId, TriangleId};
use smallvec::SmallVec;

/// A triangle lower than this share of the wanted length is a cap if its edges are longer than that length.
const LOW: f64 = 0.2;

/// Flips the long edges of caps, or, where these are feature edges, moves the apex onto them. Returns how many went.
pub(super) fn remove_caps(job: &mut Job) -> usize {
    let flat: Vec<TriangleId> = job
        .surface
        .live_triangles()
        .filter(|&t| longest_if_low(job, t).is_some())
        .collect();
    let mut count = 0;
    for t in flat {
        if !job.surface.lives(t) {
            continue;
        }
        let Some([a, b]) = longest_if_low(job, t) else {
            continue;
        };
        if let Some((pair, _)) = gain(&job.surface, a, b) {
            job.surface.flip([a, b], pair);
            job.stats.flips += 1;
            count += 1;
        } else if job.surface.is_feature(&job.surface.around(a, b)) && onto(job, t, [a, b]) {
            count += 1;
        }
    }
    count
}

fn longest_if_low(job: &Job, t: TriangleId) -> Option<[NodeId; 2]> {
    let nodes = job.surface.triangle(t).nodes;
    let (length, edge) = [0, 1, 2]
        .map(|k| [nodes[k], nodes[(k + 1) % 3]])
        .into_iter()
        .map(|e| (job.surface.length(e[0], e[1]), e))
        .max_by(|x, y| x.0.total_cmp(&y.0))?;
    let height = area_vector(job.surface.corners(t)).length() / length;
    (height < LOW * job.wanted(edge[0], edge[1])).then_some(edge)
}

/// Splits feature edge `a`-`b` beside the apex of `t` and takes the apex into the new node.
fn onto(job: &mut Job, t: TriangleId, [a, b]: [NodeId; 2]) -> bool {
    let surface = &job.surface;
    let apex = surface.apex(t, a, b);
    if surface.class[apex] != Class::Sheet {
        return false;
    }
    let (p, q, x) = (surface.points[a], surface.points[b], surface.points[apex]);
    let f = (x - p).dot(q - p) / (q - p).length_squared();
    // Next to an end of the edge the contraction into that end is the cure.
    if !(0.05..=0.95).contains(&f) {
        return false;
    }
    let foot = p.lerp(q, f);
    // After the split and the contraction the apex stands at the foot in all its triangles but `t`, which is gone.
    let ring = surface.around(a, b);
    let sound = surface.star(apex).iter().filter(|&&s| s != t).all(|&s| {
        may_turn(
            surface.corners(s),
            surface.corners_with(s, apex, foot),
            surface.reference[s],
        )
    });
    // A second apex beside the same edge that is a neighbour of this one would fall onto it.
    let others: SmallVec<[NodeId; 4]> = ring
        .iter()
        .filter(|&&s| s != t)
        .map(|&s| surface.apex(s, a, b))
        .collect();
    if !sound || others.iter().any(|&o| !surface.around(o, apex).is_empty()) {
        return false;
    }
    let Some(span) = job.guides.span(surface, a, b) else {
        return false;
    };
    let along = if span.forward { f } else { 1.0 - f };
    let at = span.from + along * (span.to - span.from);
    let supports = job.middle_supports(a, b);
    let m = job.split_edge([a, b], foot, supports, Some((span.guide, at)));
    job.stats.splits += 1;
    if keeps_topology(&job.surface, apex, m) {
        job.contract_edge(apex, m);
        job.stats.contractions += 1;
        return true;
    }
    false
}
