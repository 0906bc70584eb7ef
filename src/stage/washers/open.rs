//! Opening a hole to the outer circle of its washer.
//!
//! All triangles that reach into the circle go; what is left between it and the rest of the sheet is triangulated in the plane of the hole, with the nodes that are there.

use super::Rings;
use super::live::{Across, Live};
use super::room::{at_rim, away};
use crate::geom::cdt::triangulate_region;
use crate::geom::placer::Placer;
use crate::model::complex::{MidNode, MidTriangle, Support};
use crate::model::ids::{NodeId, TriangleId};
use glam::{DVec2, DVec3};
use std::collections::BTreeSet;

/// What goes reaches this much beyond the circle, in edges of it: no triangle that stays touches it.
const MARGIN: f64 = 0.15;
/// Areas are equal to this share of them: rounding.
const EQUAL: f64 = 1e-9;
/// Steps of putting a node onto the sheet above its place: each takes nine tenths of what is left, at the steepest.
const STEPS: usize = 16;

/// Opens the hole; the nodes of the circle, or `None` where the sheet does not let it, and nothing was changed.
pub(super) fn open(live: &mut Live, rings: &Rings, placer: &dyn Placer) -> Option<Vec<DVec3>> {
    let (hole, plane) = (&rings.hole, &rings.hole.plane);
    let reach = rings.outer() + MARGIN * rings.edge(rings.outer());
    let gone = reaching(live, rings, reach);
    let mut boundary: Vec<[NodeId; 2]> = Vec::new();
    let mut area = 0.0;
    for &t in &gone {
        let flat = live.area(t).dot(plane.axes[2]);
        if flat <= 0.0 {
            return None;
        }
        area += flat;
        for edge in live.sides(t) {
            let inside = matches!(live.across(t, edge), Across::Sheet(u) if gone.contains(&u));
            if !inside && !hole.has(edge) {
                boundary.push(edge);
            }
        }
    }
    let mut nodes: Vec<NodeId> = boundary.iter().flatten().copied().collect();
    nodes.sort_unstable();
    nodes.dedup();
    let local = |n: NodeId| nodes.partition_point(|m| *m < n) as u32;
    let mut places: Vec<DVec2> = nodes.iter().map(|&n| plane.flat(live.point(n))).collect();
    let mut edges: Vec<[u32; 2]> = boundary.iter().map(|e| e.map(local)).collect();
    let (first, around) = (places.len() as u32, rings.around);
    let on_circle = |i: u32| rings.way(i) * rings.outer();
    places.extend((0..around).map(on_circle));
    edges.extend((0..around).map(|i| [first + i, first + (i + 1) % around]));
    let names: Vec<u32> = (0..places.len() as u32).collect();
    let triangles = triangulate_region(&places, &names, &edges, &[]).ok()?;

    // As much is covered as before, less what lies between rim and circle.
    let rim: Vec<DVec2> = hole.rim.iter().map(|r| r.place).collect();
    let circle: Vec<DVec2> = (0..around).map(on_circle).collect();
    let wanted = area - polygon_area(&circle) + polygon_area(&rim);
    let covered: f64 = (triangles.iter())
        .map(|t| polygon_area(&t.map(|i| places[i as usize])))
        .sum();
    if (covered - wanted).abs() > EQUAL * area {
        return None;
    }
    let on_sheet: Vec<DVec3> = (circle.iter())
        .map(|&q| settled(rings, q, 0.0, placer))
        .collect::<Option<_>>()?;

    // Two nodes that are joined elsewhere must not be joined here too.
    let mut fixed: Vec<[u32; 2]> = edges.iter().map(|[a, b]| [*a.min(b), *a.max(b)]).collect();
    fixed.sort_unstable();
    let joined = |[a, b]: [u32; 2]| {
        let both = [a, b].map(|i| nodes.get(i as usize).copied());
        let [Some(n), Some(m)] = both else {
            return false;
        };
        let inner = fixed.binary_search(&[a.min(b), a.max(b)]).is_err();
        inner && live.at_edge([n, m]).iter().any(|t| !gone.contains(t))
    };
    let sides = |t: &[u32; 3]| [[t[0], t[1]], [t[1], t[2]], [t[2], t[0]]];
    if triangles.iter().flat_map(sides).any(joined) {
        return None;
    }

    for &t in &gone {
        live.remove(t);
    }
    for (&point, pin) in on_sheet.iter().zip(rings.pins()) {
        let supports = [Support::Mid(hole.wall), Support::Pin(pin)];
        let supports = supports.into_iter().collect();
        nodes.push(live.add_node(MidNode { point, supports }));
    }
    for t in triangles {
        let nodes = t.map(|i| nodes[i as usize]);
        let wall = hole.wall;
        live.add(MidTriangle { nodes, wall });
    }
    Some(on_sheet)
}

/// The triangles of the sheet that reach nearer to the middle of the hole than `reach`, mm, seen along its axis.
fn reaching(live: &Live, rings: &Rings, reach: f64) -> BTreeSet<TriangleId> {
    let mut open = at_rim(live, &rings.hole);
    let mut met: BTreeSet<TriangleId> = open.iter().copied().collect();
    while let Some(t) = open.pop() {
        for edge in live.sides(t) {
            if let Across::Sheet(next) = live.across(t, edge)
                && away(live, &rings.hole, next) < reach
                && met.insert(next)
            {
                open.push(next);
            }
        }
    }
    met
}

/// Signed area of a polygon.
fn polygon_area(places: &[DVec2]) -> f64 {
    let next = places.iter().cycle().skip(1);
    places
        .iter()
        .zip(next)
        .map(|(a, b)| a.perp_dot(*b))
        .sum::<f64>()
        / 2.0
}

/// The point of the mid-surface above a place of the hole's plane, found from a height there, mm. `None` where the surface is elsewhere.
pub(super) fn settled(
    rings: &Rings,
    place: DVec2,
    height: f64,
    placer: &dyn Placer,
) -> Option<DVec3> {
    let (plane, support) = (&rings.hole.plane, [Support::Mid(rings.hole.wall)]);
    let mut height = height;
    let mut point = plane.space(place, height);
    for _ in 0..STEPS {
        let placed = placer.place(plane.space(place, height), &support);
        if !placed.is_finite() || plane.flat(placed).distance(place) > rings.hole.radius {
            return None;
        }
        point = placed;
        height = plane.height(placed);
        if plane.flat(placed).distance(place) <= EQUAL * rings.hole.radius {
            break;
        }
    }
    Some(point)
}
