//! The mid-complex: a non-manifold triangulated mid-surface with what each node must lie on.

use super::disjoint::Disjoint;
use super::ids::{CurveId, FaceId, Id, IndexVec, NodeId, PinId, TriangleId, WallId};
use glam::DVec3;
use smallvec::SmallVec;

/// A surface that a node must lie on.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Support {
    /// The mid-surface of a wall.
    Mid(WallId),
    /// A face of the solid: rims lie on lateral faces.
    Face(FaceId),
    /// A curve of the solid: where the two sides of a wall meet, its rim lies on their edge.
    Edge(CurveId),
    /// A place of its own: the node neither moves nor vanishes. The nodes round a washer have one.
    Pin(PinId),
}

/// The supports of a node, sorted and without repetition.
pub type Supports = SmallVec<[Support; 4]>;

/// The faces of the solid among supports.
pub fn faces(supports: &[Support]) -> impl Iterator<Item = FaceId> {
    supports.iter().filter_map(|s| match s {
        Support::Face(face) => Some(*face),
        Support::Mid(_) | Support::Edge(_) | Support::Pin(_) => None,
    })
}

/// What ends sheets among supports: faces and edges of the solid. A node with two of them is a corner of its rim.
pub fn ends(supports: &[Support]) -> impl Iterator<Item = Support> {
    let ending = |s: &Support| matches!(s, Support::Face(_) | Support::Edge(_));
    supports.iter().copied().filter(ending)
}

/// The place of its own among a node's supports.
pub fn pin(supports: &[Support]) -> Option<PinId> {
    supports.iter().find_map(|s| match s {
        Support::Pin(pin) => Some(*pin),
        _ => None,
    })
}

/// A node of the mid-complex.
#[derive(Clone, Debug, PartialEq)]
pub struct MidNode {
    /// Position, mm.
    pub point: DVec3,
    /// What it must lie on: one wall inside a sheet, a wall and a lateral face on a rim, several walls at a junction.
    pub supports: Supports,
}

/// A triangle of the mid-complex.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct MidTriangle {
    /// Its corners.
    pub nodes: [NodeId; 3],
    /// The wall whose mid-surface it lies on.
    pub wall: WallId,
}

impl MidTriangle {
    /// Whether its boundary runs from the first of the nodes straight to the second.
    pub fn runs(&self, [from, to]: [NodeId; 2]) -> bool {
        let n = self.nodes;
        (0..3).any(|k| [n[k], n[(k + 1) % 3]] == [from, to])
    }
}

/// A triangulated, possibly non-manifold mid-surface.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct MidComplex {
    /// #N nodes.
    pub nodes: IndexVec<NodeId, MidNode>,
    /// #T triangles.
    pub triangles: IndexVec<TriangleId, MidTriangle>,
}

/// How an edge of the mid-complex lies in it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum EdgeKind {
    /// Inside a sheet: two triangles of one wall.
    Inner,
    /// Free boundary: one triangle.
    Rim,
    /// Three triangles or more.
    Junction,
    /// Two triangles of different walls.
    Crease,
}

/// What can be wrong with a [`MidComplex`].
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum ComplexFault {
    /// A triangle names a node that does not exist, or one node twice.
    #[error("triangle {0:?} has nodes that are missing or equal")]
    BadTriangle(TriangleId),
    /// Two triangles have the same three nodes.
    #[error("triangles {0:?} and {1:?} have the same nodes")]
    Doubled(TriangleId, TriangleId),
    /// A node belongs to no triangle.
    #[error("node {0:?} belongs to no triangle")]
    Orphan(NodeId),
    /// A coordinate is not a finite number.
    #[error("node {0:?} is not finite")]
    NotFinite(NodeId),
}

/// An edge with the triangles round it, in order of their ids.
#[derive(Clone, Debug, PartialEq)]
pub struct MidEdge {
    /// Its ends, the lower id first.
    pub ends: [NodeId; 2],
    /// The triangles that share it.
    pub triangles: SmallVec<[TriangleId; 2]>,
}

impl MidComplex {
    /// The same without nodes that no triangle has; the others keep their order.
    pub fn without_orphans(mut self) -> Self {
        let mut used = IndexVec::<NodeId, bool>::filled(false, self.nodes.len());
        for n in self.triangles.iter().flat_map(|t| t.nodes) {
            used[n] = true;
        }
        let mut nodes = IndexVec::new();
        let names: IndexVec<NodeId, Option<NodeId>> = (self.nodes.enumerated())
            .map(|(id, node)| used[id].then(|| nodes.push(node.clone())))
            .collect();
        for t in self.triangles.iter_mut() {
            t.nodes = t.nodes.map(|n| names[n].unwrap_or(n));
        }
        Self { nodes, ..self }
    }

    /// All edges in order of their ends.
    pub fn edges(&self) -> Vec<MidEdge> {
        // Sorted by the lower end through counting, which leaves short lists to sort by the other.
        let mut first = vec![0u32; self.nodes.len() + 2];
        let sides = || {
            self.triangles.enumerated().flat_map(|(id, t)| {
                [0, 1, 2].map(|k| {
                    let (a, b) = (t.nodes[k], t.nodes[(k + 1) % 3]);
                    (a.min(b), a.max(b), id)
                })
            })
        };
        for (low, ..) in sides() {
            first[low.index() + 2] += 1;
        }
        for i in 2..first.len() {
            first[i] += first[i - 1];
        }
        let mut half = vec![(NodeId(0), TriangleId(0)); 3 * self.triangles.len()];
        for (low, high, id) in sides() {
            let at = &mut first[low.index() + 1];
            half[*at as usize] = (high, id);
            *at += 1;
        }
        let mut edges = Vec::with_capacity(half.len() / 2);
        for low in self.nodes.ids() {
            let of_low = &mut half[first[low.index()] as usize..first[low.index() + 1] as usize];
            of_low.sort_unstable();
            edges.extend(of_low.chunk_by(|a, b| a.0 == b.0).map(|run| MidEdge {
                ends: [low, run[0].0],
                triangles: run.iter().map(|h| h.1).collect(),
            }));
        }
        edges
    }

    /// Where the corners of a triangle lie, mm.
    pub fn corners(&self, triangle: &MidTriangle) -> [DVec3; 3] {
        triangle.nodes.map(|n| self.nodes[n].point)
    }

    /// The area of a triangle along the normal that its winding has, mm².
    pub fn area_vector(&self, triangle: &MidTriangle) -> DVec3 {
        let [a, b, c] = self.corners(triangle);
        (b - a).cross(c - a) / 2.0
    }

    /// How an edge lies in the complex.
    pub fn kind(&self, edge: &MidEdge) -> EdgeKind {
        match edge.triangles.as_slice() {
            [] | [_] => EdgeKind::Rim,
            [a, b] if self.triangles[*a].wall == self.triangles[*b].wall => EdgeKind::Inner,
            [_, _] => EdgeKind::Crease,
            _ => EdgeKind::Junction,
        }
    }

    /// The triangles round every node, in order of their ids.
    pub fn stars(&self) -> IndexVec<NodeId, SmallVec<[TriangleId; 8]>> {
        let mut stars = IndexVec::filled(SmallVec::new(), self.nodes.len());
        for (id, t) in self.triangles.enumerated() {
            for n in t.nodes {
                stars[n].push(id);
            }
        }
        stars
    }

    /// Puts every node onto the walls of its triangles and no others; the faces and edges that it lies on stay.
    pub fn support_by_walls(&mut self) {
        for node in self.nodes.as_mut_slice() {
            node.supports.retain(|s| !matches!(s, Support::Mid(_)));
        }
        for t in self.triangles.as_slice() {
            for n in t.nodes {
                self.nodes[n].supports.push(Support::Mid(t.wall));
            }
        }
        for node in self.nodes.as_mut_slice() {
            node.supports.sort_unstable();
            node.supports.dedup();
        }
    }

    /// Euler characteristic V - E + F.
    pub fn euler(&self) -> i64 {
        self.nodes.len() as i64 - self.edges().len() as i64 + self.triangles.len() as i64
    }

    /// Number of edge-connected pieces.
    pub fn pieces(&self) -> usize {
        let mut sets = Disjoint::new(self.triangles.len());
        for edge in self.edges() {
            for t in &edge.triangles[1..] {
                sets.join(edge.triangles[0].0, t.0);
            }
        }
        sets.sets()
    }

    /// The first triangle of the sheet of every triangle: pieces that hang together over inner edges. `edges` are all of the complex.
    pub fn sheets(&self, edges: &[MidEdge]) -> IndexVec<TriangleId, TriangleId> {
        let mut pieces = Disjoint::new(self.triangles.len());
        for edge in edges.iter().filter(|e| self.kind(e) == EdgeKind::Inner) {
            pieces.join(edge.triangles[0].0, edge.triangles[1].0);
        }
        // The lowest member stands for its piece.
        (self.triangles.ids())
            .map(|t| TriangleId(pieces.find(t.0)))
            .collect()
    }

    /// All violations.
    pub fn check(&self) -> Vec<ComplexFault> {
        let mut faults = Vec::new();
        let mut used = IndexVec::<NodeId, bool>::filled(false, self.nodes.len());
        let mut keys = Vec::with_capacity(self.triangles.len());
        for (id, t) in self.triangles.enumerated() {
            let [a, b, c] = t.nodes;
            if a == b || b == c || c == a || t.nodes.iter().any(|n| n.index() >= self.nodes.len()) {
                faults.push(ComplexFault::BadTriangle(id));
                continue;
            }
            let mut key = t.nodes;
            key.sort_unstable();
            keys.push((key, id));
            for n in t.nodes {
                used[n] = true;
            }
        }
        keys.sort_unstable();
        for pair in keys.windows(2) {
            if pair[0].0 == pair[1].0 {
                faults.push(ComplexFault::Doubled(pair[0].1, pair[1].1));
            }
        }
        for (id, node) in self.nodes.enumerated() {
            if !used[id] {
                faults.push(ComplexFault::Orphan(id));
            }
            if !node.point.is_finite() {
                faults.push(ComplexFault::NotFinite(id));
            }
        }
        faults
    }
}
