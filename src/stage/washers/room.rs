//! How far round a hole its sheet goes on flat enough, and without anything in the way.

use super::hole::Hole;
use super::live::{Across, Live};
use crate::model::ids::{IndexVec, NodeId, TriangleId};
use crate::model::washer::RoomEnd;
use glam::DVec2;
use std::collections::BTreeSet;
use std::f64::consts::PI;

/// A sheet bends where it slopes by more than this, rad, beyond what the hole's own rim says of a curved wall.
const BEND: f64 = 10.0 * PI / 180.0;
/// On a curved wall the slope grows with the distance; by so much more it is a bend.
const GROWTH: f64 = 1.5;
/// Steeper than this, rad, it is one anyway.
const BEND_MAX: f64 = 45.0 * PI / 180.0;

/// What is seen from a hole.
#[derive(Clone, Debug)]
pub(super) struct Seen {
    /// From the middle of the hole, mm; infinite where nothing is in the way within reach.
    pub room: f64,
    /// What ends it.
    pub end: RoomEnd,
    /// The way to the nearest curve, in the plane of the hole.
    pub toward: Option<DVec2>,
    /// Other holes with washers, by their numbers.
    pub holes: BTreeSet<u32>,
}

/// The place of a segment nearest to the middle of the hole.
fn nearest([a, b]: [DVec2; 2]) -> DVec2 {
    let along = b - a;
    let share = -a.dot(along) / along.length_squared();
    if share.is_finite() {
        a + along * share.clamp(0.0, 1.0)
    } else {
        a
    }
}

/// How far a triangle, seen along the axis of the hole, lies from its middle.
pub(super) fn away(live: &Live, hole: &Hole, triangle: TriangleId) -> f64 {
    let sides: Vec<[DVec2; 2]> = (live.sides(triangle))
        .map(|e| e.map(|n| hole.plane.flat(live.point(n))))
        .collect();
    let turns = sides.iter().map(|[a, b]| a.perp_dot(*b));
    if !sides.is_empty() && turns.clone().all(|t| t > 0.0) {
        return 0.0;
    }
    let far = sides.iter().map(|s| nearest(*s).length());
    far.fold(f64::INFINITY, f64::min)
}

/// The triangles at the rim of a hole.
pub(super) fn at_rim(live: &Live, hole: &Hole) -> Vec<TriangleId> {
    let count = hole.rim.len();
    (0..count)
        .map(|i| [i, (i + 1) % count].map(|i| hole.rim[i].node))
        .filter_map(|edge| live.at_edge(edge).first().copied())
        .collect()
}

/// Looks round hole number `own` as far as `reach` from its middle, mm. `owners`: the hole with a washer that a node lies on.
pub(super) fn look(
    live: &Live,
    hole: &Hole,
    reach: f64,
    owners: &IndexVec<NodeId, Option<u32>>,
    own: u32,
) -> Seen {
    let mut seen = Seen {
        room: f64::INFINITY,
        end: RoomEnd::Rim,
        toward: None,
        holes: BTreeSet::new(),
    };
    let mut curve = f64::INFINITY;
    let mut open = at_rim(live, hole);
    let mut met: BTreeSet<TriangleId> = open.iter().copied().collect();
    while let Some(t) = open.pop() {
        let far = away(live, hole, t);
        if far > reach {
            continue;
        }
        let slope = live.area(t).angle_between(hole.plane.axes[2]);
        let growth = GROWTH * (far / hole.radius).max(1.0);
        if slope > (BEND + growth * hole.tilt).min(BEND_MAX) {
            if far < seen.room {
                (seen.room, seen.end) = (far, RoomEnd::Bend);
            }
            continue;
        }
        for edge in live.sides(t) {
            let end = match live.across(t, edge) {
                Across::Sheet(next) => {
                    if met.insert(next) {
                        open.push(next);
                    }
                    continue;
                }
                Across::End(end) => end,
            };
            let owner = owners[edge[0]].filter(|o| owners[edge[1]] == Some(*o));
            if owner == Some(own) && end == RoomEnd::Rim {
                continue;
            }
            let place = nearest(edge.map(|n| hole.plane.flat(live.point(n))));
            let far = place.length();
            // Of equal ones rounding must not decide.
            if far < curve * (1.0 - 1e-6) {
                curve = far;
                seen.toward = place.try_normalize();
            }
            match owner {
                Some(other) if end == RoomEnd::Rim => {
                    seen.holes.insert(other);
                }
                _ if far < seen.room => (seen.room, seen.end) = (far, end),
                _ => {}
            }
        }
    }
    seen
}
