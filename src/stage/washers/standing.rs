//! Whether washers stand in a finished mesh: looked for in the mesh alone, ring by ring from the rim of each hole.

use crate::geom::circle::Plane;
use crate::geom::rim_loops::rings_of;
use crate::model::ids::{ElementId, NodeId};
use crate::model::shell::{Corners, ShellMesh};
use crate::model::washer::Washer;
use glam::DVec2;
use smallvec::SmallVec;
use std::collections::BTreeMap;

/// Nodes of the rim lie this near to its circle, in radii: on the facets of the solid.
const RIM: f64 = 0.06;
/// Nodes of the other circles lie this near to them, in widths of a ring.
const RING: f64 = 0.05;
/// Sine of the angle by which an edge may leave its spoke, as seen from the middle.
const SPOKE: f64 = 0.05;

/// For each washer, whether the mesh has it: as many quads in each ring, their nodes on the circles and along the spokes.
pub fn standing(mesh: &ShellMesh, washers: &[Washer]) -> Vec<bool> {
    if washers.is_empty() {
        return Vec::new();
    }
    let look = Look::new(mesh);
    washers.iter().map(|w| look.has(w)).collect()
}

struct Look<'a> {
    mesh: &'a ShellMesh,
    /// Rings of free edges.
    rims: Vec<Vec<NodeId>>,
    /// The elements at each edge, lower node first.
    at: BTreeMap<[NodeId; 2], SmallVec<[ElementId; 2]>>,
}

fn sorted([a, b]: [NodeId; 2]) -> [NodeId; 2] {
    [a.min(b), a.max(b)]
}

impl<'a> Look<'a> {
    fn new(mesh: &'a ShellMesh) -> Self {
        let mut at: BTreeMap<[NodeId; 2], SmallVec<[ElementId; 2]>> = BTreeMap::new();
        for (id, element) in mesh.elements.enumerated() {
            let n = element.corners.as_slice();
            for k in 0..n.len() {
                let edge = sorted([n[k], n[(k + 1) % n.len()]]);
                at.entry(edge).or_default().push(id);
            }
        }
        Self {
            mesh,
            rims: rings_of(mesh.nodes.len(), mesh.rims.iter().copied()),
            at,
        }
    }

    fn has(&self, washer: &Washer) -> bool {
        let plane = Plane::new(washer.centre, washer.axis);
        let radius = washer.diameter / 2.0;
        let place = |n: NodeId| plane.flat(self.mesh.nodes[n]);
        let on = |nodes: &[NodeId], radius: f64, slack: f64| {
            let near = |n: &NodeId| (place(*n).length() - radius).abs() <= slack;
            nodes.iter().all(near)
        };
        let own = |rim: &&Vec<NodeId>| {
            let high = |n: &NodeId| plane.height(self.mesh.nodes[*n]).abs() < radius;
            rim.len() == washer.around as usize
                && on(rim, radius, RIM * radius)
                && rim.iter().all(high)
        };
        let Some(rim) = self.rims.iter().find(own) else {
            return false;
        };
        let mut row = rim.clone();
        let mut behind: Vec<Option<ElementId>> = vec![None; row.len()];
        for k in 1..=washer.layers {
            let Some((next, passed)) = self.next(&row, &behind, &place) else {
                return false;
            };
            let outer = radius + f64::from(k) * washer.width;
            if !on(&next, outer, RING * washer.width) {
                return false;
            }
            (row, behind) = (next, passed);
        }
        true
    }

    /// The row of nodes across one ring of quads, and these; `behind` are those of the ring before.
    fn next(
        &self,
        row: &[NodeId],
        behind: &[Option<ElementId>],
        place: &dyn Fn(NodeId) -> DVec2,
    ) -> Option<(Vec<NodeId>, Vec<Option<ElementId>>)> {
        let mut across: BTreeMap<NodeId, NodeId> = BTreeMap::new();
        let mut passed = Vec::new();
        for i in 0..row.len() {
            let edge = [row[i], row[(i + 1) % row.len()]];
            let at = self.at.get(&sorted(edge))?;
            let mut ahead = at.iter().filter(|e| behind[i] != Some(**e));
            let (Some(&quad), None) = (ahead.next(), ahead.next()) else {
                return None;
            };
            let Corners::Quad(n) = self.mesh.elements[quad].corners else {
                return None;
            };
            passed.push(Some(quad));
            let k = (0..4).find(|&k| sorted([n[k], n[(k + 1) % 4]]) == sorted(edge))?;
            let [a, b, c, d] = [0, 1, 2, 3].map(|j| n[(k + j) % 4]);
            for (from, to) in [(a, d), (b, c)] {
                let [p, q] = [from, to].map(place);
                let straight = p.perp_dot(q).abs() <= SPOKE * p.length() * q.length();
                if *across.entry(from).or_insert(to) != to || !straight {
                    return None;
                }
            }
        }
        let next = row.iter().map(|n| across.get(n).copied());
        Some((next.collect::<Option<_>>()?, passed))
    }
}
