//! A complex whose triangles come and go, with those at every node.

use crate::geom::fold::is_fold;
use crate::model::complex::{MidComplex, MidNode, MidTriangle};
use crate::model::ids::{IndexVec, NodeId, TriangleId};
use crate::model::washer::RoomEnd;
use glam::DVec3;
use smallvec::SmallVec;

/// What lies on the other side of an edge of a triangle.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Across {
    /// The sheet goes on smoothly.
    Sheet(TriangleId),
    /// Something else begins.
    End(RoomEnd),
}

pub(super) struct Live {
    pub nodes: IndexVec<NodeId, MidNode>,
    triangles: IndexVec<TriangleId, Option<MidTriangle>>,
    stars: IndexVec<NodeId, SmallVec<[TriangleId; 8]>>,
}

impl Live {
    pub fn new(complex: &MidComplex) -> Self {
        Self {
            nodes: complex.nodes.clone(),
            triangles: complex.triangles.iter().map(|t| Some(*t)).collect(),
            stars: complex.stars(),
        }
    }

    /// The edges with one triangle, in order of their lower ends.
    pub fn rim_edges(&self) -> Vec<[NodeId; 2]> {
        let mut edges: Vec<[NodeId; 2]> = (self.triangles.ids())
            .flat_map(|t| self.sides(t))
            .filter(|&e| self.at_edge(e).len() == 1)
            .map(|[a, b]| [a.min(b), a.max(b)])
            .collect();
        edges.sort_unstable();
        edges
    }

    /// Where a node lies, mm.
    pub fn point(&self, node: NodeId) -> DVec3 {
        self.nodes[node].point
    }

    /// The triangles at a node.
    pub fn star(&self, node: NodeId) -> &[TriangleId] {
        &self.stars[node]
    }

    /// A triangle that is there.
    pub fn triangle(&self, id: TriangleId) -> Option<&MidTriangle> {
        self.triangles[id].as_ref()
    }

    /// The edges of a triangle, in order; none where it is gone.
    pub fn sides(&self, id: TriangleId) -> impl Iterator<Item = [NodeId; 2]> + use<> {
        let nodes = self.triangle(id).map(|t| t.nodes);
        let sides = |n: [NodeId; 3]| [[n[0], n[1]], [n[1], n[2]], [n[2], n[0]]];
        nodes.map(sides).into_iter().flatten()
    }

    /// The triangles at an edge.
    pub fn at_edge(&self, [a, b]: [NodeId; 2]) -> SmallVec<[TriangleId; 3]> {
        let has = |t: &&TriangleId| self.triangle(**t).is_some_and(|t| t.nodes.contains(&b));
        self.star(a).iter().filter(has).copied().collect()
    }

    /// Area along the normal that the winding gives, mm²; zero where it is gone.
    pub fn area(&self, id: TriangleId) -> DVec3 {
        self.triangle(id).map_or(DVec3::ZERO, |t| {
            let [a, b, c] = t.nodes.map(|n| self.point(n));
            (b - a).cross(c - a) / 2.0
        })
    }

    /// What lies across an edge of a triangle.
    pub fn across(&self, from: TriangleId, edge: [NodeId; 2]) -> Across {
        let at = self.at_edge(edge);
        let &[s, t] = at.as_slice() else {
            let rim = at.len() < 2;
            return Across::End(if rim { RoomEnd::Rim } else { RoomEnd::Junction });
        };
        let both = [s, t].map(|t| self.triangle(t));
        let [Some(a), Some(b)] = both else {
            return Across::End(RoomEnd::Rim);
        };
        let [n, m] = [s, t].map(|t| self.area(t).normalize_or_zero());
        let smooth = a.wall == b.wall && a.runs(edge) != b.runs(edge) && !is_fold(n, m);
        if smooth {
            Across::Sheet(if s == from { t } else { s })
        } else {
            Across::End(RoomEnd::Bend)
        }
    }

    pub fn remove(&mut self, id: TriangleId) {
        let gone = self.triangles.as_mut_slice()[id.0 as usize].take();
        for n in gone.into_iter().flat_map(|t| t.nodes) {
            self.stars[n].retain(|t| *t != id);
        }
    }

    pub fn add_node(&mut self, node: MidNode) -> NodeId {
        self.stars.push(SmallVec::new());
        self.nodes.push(node)
    }

    pub fn add(&mut self, triangle: MidTriangle) {
        let id = self.triangles.push(Some(triangle));
        for n in triangle.nodes {
            self.stars[n].push(id);
        }
    }

    /// The triangles that are there, with the nodes that they have.
    pub fn finish(self) -> MidComplex {
        MidComplex {
            nodes: self.nodes,
            triangles: self.triangles.iter().flatten().copied().collect(),
        }
        .without_orphans()
    }
}
