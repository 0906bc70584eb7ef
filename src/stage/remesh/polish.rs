//! The last pass: a local search at each triangle that is still out of shape.

use super::contract::{Bounds, outcome};
use super::flip::gain;
use super::job::Job;
use super::shape::{angles, edge_ratio, quality};
use super::smooth::{Target, accept, along, beside, placed, target};
use super::split;
use super::still::Still;
use super::surface::{Class, key};
use crate::model::ids::{NodeId, TriangleId};
use glam::DVec3;

/// Edge ratio that is out of shape: just inside the 2.5 that is promised.
const WORST_RATIO: f64 = 2.3;
/// Angles out of shape, degrees: just inside the 30 and 110 that are aimed at.
const WORST_ANGLES: [f64; 2] = [33.0, 107.0];
/// A step of the search must gain this much, or it goes on for ever with ever less.
const GAIN: f64 = 1e-3;
/// What placing may add to a quality: half an edge off a bend of six edges a turn changes it by about this much.
const DOUBT: f64 = 0.05;
/// Passes over the bad triangles; mending one shows at its neighbours, and few need more than three.
const PASSES: usize = 6;
/// Bad triangles whose searches are foreseen together: enough work for all threads, few enough that most of them lie apart.
const AT_ONCE: usize = 256;
/// Halvings of the step of a search: down to a thirtieth of the shortest edge; below that the gain is not worth the placing.
const HALVINGS: usize = 5;
/// Edges in this range of ratios may be contracted or split for the sake of shape.
const LOOSE: [f64; 2] = [0.7, 1.8];

/// Whether a triangle is out of shape.
pub(super) fn is_bad(p: [DVec3; 3]) -> bool {
    let [least, most] = angles(p);
    edge_ratio(p) > WORST_RATIO
        || least.to_degrees() < WORST_ANGLES[0]
        || most.to_degrees() > WORST_ANGLES[1]
}

/// Mends triangles, the worst first.
pub(super) fn polish(job: &mut Job) {
    let still = &mut Still::default();
    for _ in 0..PASSES {
        let mut bad: Vec<(u64, TriangleId)> = job
            .surface
            .live_triangles()
            .filter(|&t| is_bad(job.surface.corners(t)))
            .map(|t| (key(quality(job.surface.corners(t))), t))
            .collect();
        bad.sort_unstable();
        let mut mended = 0;
        for some in bad.chunks(AT_ONCE) {
            // Most searches end in vain, and those can be made side by side: what mending changes shows at its neighbours only.
            let mut nodes: Vec<NodeId> = (some.iter())
                .filter(|b| job.surface.lives(b.1) && is_bad(job.surface.corners(b.1)))
                .flat_map(|b| job.surface.triangle(b.1).nodes)
                .collect();
            nodes.sort_unstable();
            nodes.dedup();
            still.foresee(job, &nodes, |n| is_in_vain(job, n));
            for &(_, t) in some {
                if job.surface.lives(t) && is_bad(job.surface.corners(t)) && mend(job, still, t) {
                    mended += 1;
                }
            }
        }
        if mended == 0 {
            return;
        }
    }
}

fn mend(job: &mut Job, still: &mut Still, t: TriangleId) -> bool {
    let nodes = job.surface.triangle(t).nodes;
    let mut done = false;
    for n in nodes {
        done |= search(job, still, n);
    }
    if !is_bad(job.surface.corners(t)) {
        return true;
    }
    let mut edges = [0, 1, 2].map(|k| [nodes[k], nodes[(k + 1) % 3]]);
    edges.sort_by(|x, y| {
        let length = |e: &[NodeId; 2]| job.surface.length(e[0], e[1]);
        length(x).total_cmp(&length(y)).then(x.cmp(y))
    });
    let [short, _, long] = edges;
    for [a, b] in edges.into_iter().rev() {
        if let Some((pair, _)) = gain(&job.surface, a, b) {
            job.surface.flip([a, b], pair);
            job.stats.flips += 1;
            return true;
        }
    }
    contract(job, still, short) || split_long(job, still, long) || done
}

fn contract(job: &mut Job, still: &mut Still, [a, b]: [NodeId; 2]) -> bool {
    let bounds = Bounds {
        longest: LOOSE[1],
        ..Bounds::remesh()
    };
    for (gone, kept) in [(a, b), (b, a)] {
        let before = job.surface.quality_now(gone);
        if let Some(after) = outcome(job, gone, kept, bounds)
            && after > before + GAIN
        {
            job.contract_edge(gone, kept);
            job.stats.contractions += 1;
            search(job, still, kept);
            return true;
        }
    }
    false
}

/// Splits the longest edge where both halves are better than the worst triangle at it.
fn split_long(job: &mut Job, still: &mut Still, [a, b]: [NodeId; 2]) -> bool {
    if job.ratio(a, b) < 2.0 * LOOSE[0] {
        return false;
    }
    let surface = &job.surface;
    let ring = surface.around(a, b);
    let before = ring
        .iter()
        .map(|&t| quality(surface.corners(t)))
        .fold(f64::INFINITY, f64::min);
    let new = split::middle(job, [a, b]);
    let after = ring
        .iter()
        .flat_map(|&t| [a, b].map(|n| quality(surface.corners_with(t, n, new.point))))
        .fold(f64::INFINITY, f64::min);
    if after <= before + GAIN {
        return false;
    }
    let m = split::apply(job, [a, b], new);
    search(job, still, m);
    true
}

/// Pattern search for the place of a node that makes the worst of its triangles better.
fn search(job: &mut Job, still: &mut Still, n: NodeId) -> bool {
    if job.surface.class[n] == Class::Corner || still.holds(job, n) {
        return false;
    }
    let mut best = job.surface.quality_now(n);
    let mut moved = false;
    let mut attempt = |job: &mut Job, target: Option<Target>| -> bool {
        let Some(target) = target else {
            return false;
        };
        match job.surface.quality_at(n, target.point, best) {
            // A folded star looks better the further its node goes off; only what unfolds it counts.
            Some(q) if q > best + GAIN && q > 0.0 => {
                best = q;
                accept(job, n, target);
                moved = true;
                true
            }
            _ => false,
        }
    };
    let start = target(job, n, 1.0);
    attempt(job, start);
    let mut step = first_step(job, n);
    for _ in 0..HALVINGS {
        let any = (0..tries(job, n)).any(|k| {
            let place = step_target(job, n, step, k, job.surface.quality_now(n));
            attempt(job, place)
        });
        if !any {
            step *= 0.5;
        }
    }
    if !moved {
        still.record(job, n);
    }
    moved
}

/// Whether a search at a node as things are now would move nothing.
fn is_in_vain(job: &Job, n: NodeId) -> bool {
    if job.surface.class[n] == Class::Corner {
        return false;
    }
    let best = job.surface.quality_now(n);
    let gains = |target: Option<Target>| {
        let quality = target.and_then(|t| job.surface.quality_at(n, t.point, best));
        quality.is_some_and(|q| q > best + GAIN && q > 0.0)
    };
    let step = first_step(job, n);
    !gains(target(job, n, 1.0))
        && (0..HALVINGS).all(|halving| {
            let step = step * 0.5f64.powi(halving as i32);
            !(0..tries(job, n)).any(|k| gains(step_target(job, n, step, k, best)))
        })
}

/// Half of the shortest edge at a node.
fn first_step(job: &Job, n: NodeId) -> f64 {
    let edges = job.surface.neighbours(n).into_iter();
    0.5 * (edges.map(|m| job.surface.length(n, m))).fold(f64::INFINITY, f64::min)
}

/// Ways in which a node may be moved.
fn tries(job: &Job, n: NodeId) -> usize {
    match job.surface.class[n] {
        Class::Corner => 0,
        Class::Curve => 2,
        Class::Sheet => 6,
    }
}

fn step_target(job: &Job, n: NodeId, step: f64, k: usize, best: f64) -> Option<Target> {
    if job.surface.class[n] == Class::Curve {
        let [(_, s), (_, t)] = beside(job, n)?;
        let by = if k == 0 { step } else { -step };
        // Half of the way to a neighbour at most, so that no two nodes meet.
        let by = by.clamp(-0.5 * (s.to - s.from), 0.5 * (t.to - t.from));
        return along(job, n, s.guide, t.from, by);
    }
    let normal = job.normal_at(n);
    if normal == DVec3::ZERO {
        return None;
    }
    let (x, y) = normal.any_orthonormal_pair();
    let (sin, cos) = (std::f64::consts::FRAC_PI_3 * k as f64).sin_cos();
    let start = job.surface.points[n] + (x * cos + y * sin) * step;
    // In the tangent plane the quality is nearly that on the surface; only what may gain is worth the placing.
    let hopeful = (job.surface.quality_at(n, start, best)).is_some_and(|q| q > best - DOUBT);
    hopeful.then(|| placed(job, n, start, None)).flatten()
}
