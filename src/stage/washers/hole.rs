//! Round holes: rims of sheets that go round in a circle, with the sheet outside.

use super::live::{Across, Live};
use crate::geom::circle::{Plane, fit_circle};
use crate::geom::placer::Placer;
use crate::geom::rim_loops::rings_of;
use crate::model::complex::{Support, Supports};
use crate::model::ids::{NodeId, TriangleId, WallId};
use crate::model::washer::{BareHole, NoWasher, RoomEnd};
use glam::{DVec2, DVec3};

/// A rim is round where it leaves its circle by less than this share of the radius: a facet of an octagon does by 0.04, one of a hexagon by 0.07.
const ROUND: f64 = 0.05;
/// Steepest slope of the sheet at the rim of a hole, to the hole's plane, rad: beyond half of a right angle the rim is the end of a tube.
const TILT_MAX: f64 = 30.0 * std::f64::consts::PI / 180.0;
const TUBE_END: f64 = 45.0 * std::f64::consts::PI / 180.0;

/// A node of the rim.
#[derive(Clone, Debug)]
pub(super) struct RimNode {
    pub node: NodeId,
    /// In the plane of the hole, from its middle, mm.
    pub place: DVec2,
    /// Above that plane, mm.
    pub height: f64,
    pub supports: Supports,
}

/// A round hole in a sheet.
#[derive(Clone, Debug)]
pub(super) struct Hole {
    /// Its rim, counter-clockwise as the plane has it.
    pub rim: Vec<RimNode>,
    /// The plane of its rim, from its middle; the sheet is wound counter-clockwise in it.
    pub plane: Plane,
    pub radius: f64,
    pub wall: WallId,
    /// Steepest slope of the sheet at the rim, rad.
    pub tilt: f64,
}

impl Hole {
    pub fn bare(&self, why: NoWasher) -> BareHole {
        BareHole {
            centre: self.plane.origin,
            diameter: 2.0 * self.radius,
            why,
        }
    }

    /// Whether an edge lies on its rim.
    pub fn has(&self, edge: [NodeId; 2]) -> bool {
        edge.iter().all(|n| self.rim.iter().any(|r| r.node == *n))
    }
}

/// What ends sheets at both of two nodes, and the walls that both lie on.
pub(super) fn common(a: &Supports, b: &Supports) -> Supports {
    a.iter().copied().filter(|s| b.contains(s)).collect()
}

/// All round holes of a wanted diameter, and those of them that can have no washer.
pub(super) fn holes(
    live: &Live,
    placer: &dyn Placer,
    takes: &dyn Fn(f64) -> bool,
) -> (Vec<Hole>, Vec<BareHole>) {
    let (mut holes, mut bare) = (Vec::new(), Vec::new());
    for ring in rings_of(live.nodes.len(), live.rim_edges()) {
        let Some((hole, why)) = Hole::new(live, ring, placer) else {
            continue;
        };
        match why {
            _ if !takes(2.0 * hole.radius) => {}
            None => holes.push(hole),
            Some(why) => bare.push(hole.bare(why)),
        }
    }
    (holes, bare)
}

impl Hole {
    /// The hole inside a ring of free edges, and why it cannot have a washer; `None` where it is no round hole.
    fn new(
        live: &Live,
        mut ring: Vec<NodeId>,
        placer: &dyn Placer,
    ) -> Option<(Self, Option<NoWasher>)> {
        let edges = |ring: &[NodeId]| -> Vec<[NodeId; 2]> {
            (0..ring.len())
                .map(|i| [ring[i], ring[(i + 1) % ring.len()]])
                .collect()
        };
        let beside: Vec<TriangleId> = (edges(&ring).iter())
            .filter_map(|&e| live.at_edge(e).first().copied())
            .collect();
        let start = live.point(ring[0]);
        let across: DVec3 = (edges(&ring).iter())
            .map(|e| e.map(|n| live.point(n) - start))
            .map(|[a, b]| a.cross(b))
            .sum();
        let sheet: DVec3 = beside.iter().map(|&t| live.area(t)).sum();
        // The sheet is counter-clockwise, and so is the ring.
        let mut normal = across.try_normalize()?;
        if normal.dot(sheet) < 0.0 {
            normal = -normal;
            ring.reverse();
        }
        let tilts: Vec<f64> = (beside.iter())
            .map(|&t| live.area(t).angle_between(normal))
            .collect();
        if tilts.iter().sum::<f64>() > TUBE_END * tilts.len() as f64 {
            return None;
        }
        let middle = ring.iter().map(|&n| live.point(n)).sum::<DVec3>() / ring.len() as f64;
        let mut plane = Plane::new(middle, normal);
        let places: Vec<DVec2> = (ring.iter()).map(|&n| plane.flat(live.point(n))).collect();
        let (centre, radius) = fit_circle(&places)?;
        // The faces round a hole tell a circle from a polygon with nodes at its corners.
        let supports = |n: NodeId| &live.nodes[n].supports;
        let between = edges(&ring).into_iter().map(|[a, b]| {
            let [p, q] = [a, b].map(|n| live.point(n));
            let middle = p.midpoint(q);
            let placed = placer.place(middle, &common(supports(a), supports(b)));
            let near = placed.is_finite() && placed.distance(middle) < p.distance(q) / 2.0;
            plane.flat(if near { placed } else { middle })
        });
        let round = |p: DVec2| (p.distance(centre) - radius).abs() <= ROUND * radius;
        if !places.iter().copied().chain(between).all(round) {
            return None;
        }
        plane.origin = plane.space(centre, 0.0);
        // Wound the same way as the ring, a sheet outside it runs against it; one inside is a disc.
        let outside = |e: &[NodeId; 2]| {
            let t = live.at_edge(*e).first().copied();
            t.and_then(|t| live.triangle(t))
                .is_some_and(|t| !t.runs(*e))
        };
        if 2 * edges(&ring).iter().filter(|e| outside(e)).count() < ring.len() {
            return None;
        }
        let tilt = tilts.into_iter().fold(0.0, f64::max);
        let why = if !ring.iter().all(|&n| in_one_sheet(live, n)) {
            Some(NoWasher::Shared)
        } else if tilt > TILT_MAX {
            Some(NoWasher::Bent)
        } else {
            None
        };
        let wall = live.triangle(*beside.first()?)?.wall;
        let rim = (ring.into_iter())
            .map(|node| RimNode {
                node,
                place: plane.flat(live.point(node)),
                height: plane.height(live.point(node)),
                supports: without_pins(supports(node)),
            })
            .collect();
        let hole = Self {
            rim,
            plane,
            radius,
            wall,
            tilt,
        };
        Some((hole, why))
    }
}

fn without_pins(supports: &Supports) -> Supports {
    let pins = |s: &Support| matches!(s, Support::Pin(_));
    supports.iter().copied().filter(|s| !pins(s)).collect()
}

/// Whether a node of a rim has nothing but its two free edges and a smooth sheet between them.
fn in_one_sheet(live: &Live, node: NodeId) -> bool {
    let mut rims = 0;
    for &t in live.star(node) {
        for edge in live.sides(t).filter(|e| e.contains(&node)) {
            match live.across(t, edge) {
                Across::Sheet(_) => {}
                Across::End(RoomEnd::Rim) => rims += 1,
                Across::End(_) => return false,
            }
        }
    }
    rims == 2
}
