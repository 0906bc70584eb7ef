//! A complex that can be edited: triangles with tombstones, and at each node the list of its triangles.
//!
//! Only topology and bookkeeping; whether an edit is wise is for the callers to know.

use super::cones::Cone;
use super::shape::{may_turn, signed_quality};
use crate::model::complex::{MidComplex, MidNode, MidTriangle, Supports};
use crate::model::disjoint::Disjoint;
use crate::model::ids::{Id, IndexVec, NodeId, TriangleId};
use glam::DVec3;
use rayon::prelude::*;
use smallvec::SmallVec;

/// What a node may do.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Class {
    /// Moves on its sheet.
    Sheet,
    /// Moves along its feature curve.
    Curve,
    /// Stays.
    Corner,
}

/// The triangles round an edge.
pub(super) type Ring = SmallVec<[TriangleId; 4]>;
/// Nodes near a node.
pub(super) type Nodes = SmallVec<[NodeId; 12]>;

const DEAD: NodeId = NodeId(u32::MAX);

/// The editable complex.
#[derive(Clone, Debug)]
pub(super) struct Surface {
    /// #N positions.
    pub points: IndexVec<NodeId, DVec3>,
    /// #N what the nodes lie on.
    pub supports: IndexVec<NodeId, Supports>,
    /// #N what the nodes may do.
    pub class: IndexVec<NodeId, Class>,
    /// #T unit normal of the mid-surface under each triangle, zero where unknown.
    pub reference: IndexVec<TriangleId, DVec3>,
    /// #T for which point the reference was found; not finite where it was guessed.
    pub referred: IndexVec<TriangleId, DVec3>,
    triangles: IndexVec<TriangleId, MidTriangle>,
    stars: IndexVec<NodeId, SmallVec<[TriangleId; 8]>>,
}

impl Surface {
    /// Takes a complex whose `check()` is empty but for orphans.
    pub fn new(complex: MidComplex) -> Self {
        let count = complex.nodes.len();
        let mut stars = IndexVec::filled(SmallVec::new(), count);
        for (id, t) in complex.triangles.enumerated() {
            for n in t.nodes {
                let star: &mut SmallVec<[TriangleId; 8]> = &mut stars[n];
                star.push(id);
            }
        }
        let (points, supports): (Vec<_>, Vec<_>) = complex
            .nodes
            .into_vec()
            .into_iter()
            .map(|n| (n.point, n.supports))
            .unzip();
        Self {
            points: points.into(),
            supports: supports.into(),
            class: IndexVec::filled(Class::Corner, count),
            reference: IndexVec::filled(DVec3::ZERO, complex.triangles.len()),
            referred: IndexVec::filled(DVec3::NAN, complex.triangles.len()),
            triangles: complex.triangles,
            stars,
        }
    }

    /// The living nodes and triangles, renumbered in order of their ids.
    pub fn finish(self) -> MidComplex {
        let mut complex = MidComplex::default();
        let mut new_id = IndexVec::<NodeId, NodeId>::filled(DEAD, self.points.len());
        for n in self.live_nodes() {
            new_id[n] = complex.nodes.push(MidNode {
                point: self.points[n],
                supports: self.supports[n].clone(),
            });
        }
        for t in self.live_triangles() {
            let MidTriangle { nodes, wall } = self.triangles[t];
            complex.triangles.push(MidTriangle {
                nodes: nodes.map(|n| new_id[n]),
                wall,
            });
        }
        complex
    }

    /// Nodes that have triangles, in order.
    pub fn live_nodes(&self) -> impl Iterator<Item = NodeId> + '_ {
        self.stars
            .enumerated()
            .filter(|(_, s)| !s.is_empty())
            .map(|(n, _)| n)
    }

    /// Triangles that were not removed, in order.
    pub fn live_triangles(&self) -> impl Iterator<Item = TriangleId> + '_ {
        self.triangles
            .enumerated()
            .filter(|(_, t)| t.nodes[0] != DEAD)
            .map(|(id, _)| id)
    }

    /// A triangle; of a removed one all nodes are past the end.
    #[inline]
    pub fn triangle(&self, t: TriangleId) -> MidTriangle {
        self.triangles[t]
    }

    /// Whether the triangle is still there.
    #[inline]
    pub fn lives(&self, t: TriangleId) -> bool {
        self.triangles[t].nodes[0] != DEAD
    }

    /// The triangles at a node.
    #[inline]
    pub fn star(&self, n: NodeId) -> &[TriangleId] {
        &self.stars[n]
    }

    /// Corner positions of a triangle.
    #[inline]
    pub fn corners(&self, t: TriangleId) -> [DVec3; 3] {
        self.triangles[t].nodes.map(|n| self.points[n])
    }

    /// Corner positions of a triangle if node `n` stood at `p`.
    #[inline]
    pub fn corners_with(&self, t: TriangleId, n: NodeId, p: DVec3) -> [DVec3; 3] {
        self.triangles[t]
            .nodes
            .map(|m| if m == n { p } else { self.points[m] })
    }

    /// Distance of two nodes.
    #[inline]
    pub fn length(&self, a: NodeId, b: NodeId) -> f64 {
        self.points[a].distance(self.points[b])
    }

    /// The triangles that share edge `a`-`b`; empty where there is no such edge.
    #[inline]
    pub fn around(&self, a: NodeId, b: NodeId) -> Ring {
        let mut ring = Ring::new();
        for &t in &self.stars[a] {
            if self.triangles[t].nodes.contains(&b) {
                ring.push(t);
            }
        }
        ring
    }

    /// The corner of `t` that is neither `a` nor `b`.
    #[inline]
    pub fn apex(&self, t: TriangleId, a: NodeId, b: NodeId) -> NodeId {
        let [x, y, z] = self.triangles[t].nodes;
        if x != a && x != b {
            x
        } else if y != a && y != b {
            y
        } else {
            z
        }
    }

    /// Neighbours of a node, sorted.
    pub fn neighbours(&self, n: NodeId) -> Nodes {
        // Each neighbour comes twice: leaving the second out at once keeps the list on the stack.
        let mut all = Nodes::new();
        for &t in &self.stars[n] {
            for m in self.triangles[t].nodes {
                if m != n && !all.contains(&m) {
                    all.push(m);
                }
            }
        }
        all.sort_unstable();
        all
    }

    /// Whether an edge with these triangles belongs to a feature curve: anything but two triangles of one wall.
    #[inline]
    pub fn is_feature(&self, ring: &[TriangleId]) -> bool {
        match ring {
            [a, b] => self.triangles[*a].wall != self.triangles[*b].wall,
            _ => true,
        }
    }

    /// Pairs of neighbour and triangle at a node, sorted, so that each run of one neighbour is the ring of an edge.
    pub fn spokes(&self, n: NodeId) -> SmallVec<[(NodeId, TriangleId); 16]> {
        let mut all = SmallVec::new();
        for &t in &self.stars[n] {
            for m in self.triangles[t].nodes {
                if m != n {
                    all.push((m, t));
                }
            }
        }
        all.sort_unstable();
        all
    }

    /// Neighbours along feature edges, sorted.
    pub fn feature_neighbours(&self, n: NodeId) -> SmallVec<[NodeId; 4]> {
        self.spokes(n)
            .chunk_by(|a, b| a.0 == b.0)
            .filter(|run| {
                run.len() != 2 || self.triangles[run[0].1].wall != self.triangles[run[1].1].wall
            })
            .map(|run| run[0].0)
            .collect()
    }

    /// All edges, sorted.
    pub fn edges(&self) -> Vec<[NodeId; 2]> {
        (0..self.points.len())
            .into_par_iter()
            .flat_map_iter(|i| {
                let a = NodeId::new(i);
                let near = self.neighbours(a).into_iter();
                near.filter(move |&b| a < b).map(move |b| [a, b])
            })
            .collect()
    }

    /// Puts a new node on edge `a`-`b`, which splits every triangle round it.
    pub fn split(
        &mut self,
        [a, b]: [NodeId; 2],
        point: DVec3,
        supports: Supports,
        class: Class,
    ) -> NodeId {
        let m = self.points.push(point);
        self.supports.push(supports);
        self.class.push(class);
        self.stars.push(SmallVec::new());
        for t in self.around(a, b) {
            let apex = self.apex(t, a, b);
            let MidTriangle { nodes, wall } = self.triangles[t];
            self.triangles[t].nodes = nodes.map(|n| if n == b { m } else { n });
            let other = self.triangles.push(MidTriangle {
                nodes: nodes.map(|n| if n == a { m } else { n }),
                wall,
            });
            self.reference.push(self.reference[t]);
            self.referred.push(DVec3::NAN);
            self.leave(b, t);
            self.stars[b].push(other);
            self.stars[apex].push(other);
            self.stars[m].push(t);
            self.stars[m].push(other);
        }
        m
    }

    /// Merges node `gone` into its neighbour `kept`, which stays where it is.
    pub fn contract(&mut self, gone: NodeId, kept: NodeId) {
        for t in std::mem::take(&mut self.stars[gone]) {
            let nodes = self.triangles[t].nodes;
            if nodes.contains(&kept) {
                for n in nodes {
                    self.leave(n, t);
                }
                self.triangles[t].nodes = [DEAD; 3];
            } else {
                self.triangles[t].nodes = nodes.map(|n| if n == gone { kept } else { n });
                self.stars[kept].push(t);
            }
        }
    }

    /// How many pieces hang together by edges.
    pub fn pieces(&self) -> usize {
        let mut sets = Disjoint::new(self.triangles.len());
        for n in self.live_nodes() {
            for run in self.spokes(n).chunk_by(|a, b| a.0 == b.0) {
                for spoke in &run[1..] {
                    sets.join(run[0].1.0, spoke.1.0);
                }
            }
        }
        sets.sets() + self.live_triangles().count() - self.triangles.len()
    }

    /// Takes a triangle away.
    pub fn remove(&mut self, t: TriangleId) {
        for n in self.triangles[t].nodes {
            self.leave(n, t);
        }
        self.triangles[t].nodes = [DEAD; 3];
    }

    /// Puts the base of a cone in the place of its three triangles.
    pub fn cap(&mut self, cone: &Cone) {
        let [t, s, u] = cone.triangles;
        self.remove(s);
        self.remove(u);
        for n in self.triangles[t].nodes {
            self.leave(n, t);
        }
        self.triangles[t].nodes = cone.base;
        for n in cone.base {
            self.stars[n].push(t);
        }
        self.referred[t] = DVec3::NAN;
    }

    /// Puts triangles in the place of others of one wall, no fewer than these.
    pub fn refill(&mut self, old: &[TriangleId], new: &[[NodeId; 3]]) {
        for (i, &t) in old.iter().enumerate() {
            let MidTriangle { nodes, .. } = self.triangles[t];
            for n in nodes {
                self.leave(n, t);
            }
            self.triangles[t].nodes = new.get(i).copied().unwrap_or([DEAD; 3]);
            self.referred[t] = DVec3::NAN;
            for &n in new.get(i).into_iter().flatten() {
                self.stars[n].push(t);
            }
        }
    }

    /// Replaces edge `a`-`b` of exactly two triangles by the edge between their apexes.
    pub fn flip(&mut self, [a, b]: [NodeId; 2], [s, t]: [TriangleId; 2]) {
        let new = self.flipped([a, b], [s, t]);
        let (c, d) = (self.apex(s, a, b), self.apex(t, a, b));
        self.triangles[s].nodes = new[0];
        self.triangles[t].nodes = new[1];
        let normal = (self.reference[s] + self.reference[t]).normalize_or_zero();
        self.reference[s] = normal;
        self.reference[t] = normal;
        self.referred[s] = DVec3::NAN;
        self.referred[t] = DVec3::NAN;
        // The first new triangle holds a, the second b.
        self.leave(b, s);
        self.leave(a, t);
        self.stars[d].push(s);
        self.stars[c].push(t);
    }

    /// The triangles that a flip would make, the first with `a`, the second with `b`, wound as `s` is.
    pub fn flipped(&self, [a, b]: [NodeId; 2], [s, t]: [TriangleId; 2]) -> [[NodeId; 3]; 2] {
        let d = self.apex(t, a, b);
        let nodes = self.triangles[s].nodes;
        [
            nodes.map(|n| if n == b { d } else { n }),
            nodes.map(|n| if n == a { d } else { n }),
        ]
    }

    fn leave(&mut self, n: NodeId, t: TriangleId) {
        if let Some(at) = self.stars[n].iter().position(|&s| s == t) {
            self.stars[n].swap_remove(at);
        }
    }

    /// How many ids were given out to nodes, dead ones included.
    pub fn node_count(&self) -> usize {
        self.points.len()
    }

    /// Least signed quality of the triangles at a node, with the node at `p`, given that with the node
    /// where it is; `None` where one that was sound would turn over.
    pub fn quality_at(&self, n: NodeId, p: DVec3, before: f64) -> Option<f64> {
        let mut least = f64::INFINITY;
        // Where the star is folded already the turns say nothing: callers ask for better than before, and that unfolds it.
        let folded = before < 0.0;
        for &t in &self.stars[n] {
            let new = self.corners_with(t, n, p);
            if !folded && !may_turn(self.corners(t), new, self.reference[t]) {
                return None;
            }
            least = least.min(signed_quality(new, self.reference[t]));
        }
        Some(least)
    }

    /// Least signed quality of the triangles at a node.
    pub fn quality_now(&self, n: NodeId) -> f64 {
        self.stars[n]
            .iter()
            .map(|&t| signed_quality(self.corners(t), self.reference[t]))
            .fold(f64::INFINITY, f64::min)
    }

    /// Walls of the triangles at a node, sorted.
    pub fn walls(&self, n: NodeId) -> SmallVec<[crate::model::ids::WallId; 4]> {
        let mut walls: SmallVec<[_; 4]> = SmallVec::new();
        for &t in &self.stars[n] {
            let wall = self.triangles[t].wall;
            if !walls.contains(&wall) {
                walls.push(wall);
            }
        }
        walls.sort_unstable();
        walls
    }
}

/// An order-preserving key for a length or ratio that is not negative.
#[inline]
pub(super) fn key(value: f64) -> u64 {
    value.max(0.0).to_bits()
}
