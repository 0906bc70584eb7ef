//! The wanted edge length at every node.

use super::RemeshOptions;
use super::job::{Job, SizeField};
use super::surface::{Class, key};
use crate::model::ids::{IndexVec, NodeId, WallId};
use glam::DVec3;
use rayon::prelude::*;
use smallvec::SmallVec;
use std::cmp::Reverse;
use std::collections::BinaryHeap;

/// Bends and narrow places shrink the wanted length to this share at most: smaller than that they are not worth their elements.
const FLOOR: f64 = 0.3;
/// A triangle over a narrow place or at a short curve has an edge this many times as long as the place is wide, at most.
const NARROW: f64 = 1.6;
/// Two curves that meet at a corner come near each other there by nature; no narrow place within so many widths of the corner.
const NEAR_CORNER: f64 = 4.0;

/// How far bends and narrow places may shrink a wanted length.
pub(super) fn floor(options: &RemeshOptions, size: f64) -> f64 {
    (FLOOR * size).max(options.least)
}

/// The size that field and curvature want at a place, for the walls that it was asked for.
#[derive(Clone, Debug)]
pub(super) struct Asked {
    point: DVec3,
    walls: SmallVec<[WallId; 4]>,
    size: f64,
}

/// Sizes from the field and the curvature of the walls alone; where a node has not moved since it was last asked for (`job.asked`, always of the same field),
/// the answer is taken from there.
pub(super) fn raw(job: &mut Job, field: SizeField) -> IndexVec<NodeId, f64> {
    let surface = &job.surface;
    let options = job.options;
    let segments = options.segments_per_turn;
    let ids: Vec<NodeId> = surface.points.ids().collect();
    let asked: Vec<Asked> = ids
        .into_par_iter()
        .map(|n| {
            let (point, walls) = (surface.points[n], surface.walls(n));
            if let Some(known) = job.asked.get(n)
                && known.point == point
                && known.walls == walls
            {
                return known.clone();
            }
            let mut least = f64::INFINITY;
            for &wall in &walls {
                let size = field(point, wall);
                if size > 0.0 {
                    let radius = job.placer.curvature_radius(point, wall);
                    let bend = std::f64::consts::TAU * radius / segments;
                    least = least.min(size.min(bend.max(floor(options, size))));
                }
            }
            Asked {
                point,
                walls,
                size: least,
            }
        })
        .collect();
    job.asked = asked.into();
    job.asked.iter().map(|a| a.size).collect()
}

/// Renews the sizes of all nodes: field, bends of curves, narrow places (`narrow`: judged by the present edges), then graded.
pub(super) fn renew(job: &mut Job, field: SizeField, narrow: bool) {
    let mut size = raw(job, field);
    let raw = size.clone();
    let nodes: Vec<NodeId> = job.surface.live_nodes().collect();
    for &n in &nodes {
        if job.surface.class[n] != Class::Sheet {
            size[n] = size[n].min(job.guides.limit(n).max(floor(job.options, raw[n])));
        }
    }
    if narrow {
        let edges = job.surface.edges();
        let widths: Vec<([NodeId; 2], f64)> = edges
            .into_par_iter()
            .filter_map(|e| width(job, e[0], e[1]).map(|w| (e, w)))
            .collect();
        for (edge, width) in widths {
            for n in edge {
                size[n] = size[n].min((NARROW * width).max(floor(job.options, raw[n])));
            }
        }
    }
    grade(job, &mut size, &nodes);
    job.size = size;
}

/// The length of an edge that no contraction can remove and that is no wedge's.
fn width(job: &Job, a: NodeId, b: NodeId) -> Option<f64> {
    let surface = &job.surface;
    let (ca, cb) = (surface.class[a], surface.class[b]);
    if ca == Class::Sheet || cb == Class::Sheet {
        return None;
    }
    let length = surface.length(a, b);
    if surface.is_feature(&surface.around(a, b)) {
        return (ca == Class::Corner && cb == Class::Corner).then_some(length);
    }
    let ends = |n: NodeId| match job.guides.spot(n) {
        Some(spot) => job.guides.ends(spot.guide).map_or(vec![], |e| e.to_vec()),
        None => vec![n],
    };
    // Two nodes of one smooth curve: a chord that cuts a bend. A neck closer than its own arc is seen by the nodes between.
    if let (Some(s), Some(t)) = (job.guides.spot(a), job.guides.spot(b))
        && s.guide == t.guide
    {
        let common = surface
            .feature_neighbours(a)
            .iter()
            .any(|n| surface.feature_neighbours(b).contains(n));
        return (!common).then_some(length);
    }
    let (ea, eb) = (ends(a), ends(b));
    let wedge = ea.iter().filter(|e| eb.contains(e)).any(|&e| {
        let far = surface.length(a, e).max(surface.length(b, e));
        far < NEAR_CORNER * length
    });
    (!wedge).then_some(length)
}

/// Lowers sizes until none exceeds that of a neighbour by more than the growth times the edge between them (Dijkstra).
fn grade(job: &Job, size: &mut IndexVec<NodeId, f64>, nodes: &[NodeId]) {
    let growth = job.options.gradation - 1.0;
    let mut heap: BinaryHeap<Reverse<(u64, NodeId)>> =
        nodes.iter().map(|&n| Reverse((key(size[n]), n))).collect();
    while let Some(Reverse((k, n))) = heap.pop() {
        if k != key(size[n]) {
            continue;
        }
        for m in job.surface.neighbours(n) {
            let most = size[n] + growth * job.surface.length(n, m);
            if most < size[m] {
                size[m] = most;
                heap.push(Reverse((key(most), m)));
            }
        }
    }
}
