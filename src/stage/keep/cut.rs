//! Cutting: edges of the complex over which the nearest face of a side changes at a wished edge are split there.

use crate::geom::split;
use crate::medial::{Line, Medial};
use crate::model::brep::Brep;
use crate::model::complex::{EdgeKind, MidComplex, MidEdge, MidNode, MidTriangle, Support};
use crate::model::ids::{CurveId, FaceId, NodeId, TriangleId, WallId};
use glam::DVec3;
use rayon::prelude::*;
use smallvec::SmallVec;
use std::collections::{BTreeMap, BTreeSet};

/// Halvings on the way to a change of faces: to a millionth of an edge, and the placing does the rest.
const HALVINGS: usize = 20;
/// Changes of faces along one edge at most, and rounds of cutting; more are noise.
const CHANGES: usize = 6;
/// A change this near to the end of an edge, as a share of its length, moves that end instead: no needles.
const NEAR: f64 = 0.15;
/// Feet this near to an edge, in thicknesses, lie on it: beneath an inner corner and beyond the end of a side. There the side of the edge decides on which the place itself lies.
const ON: f64 = 0.01;
/// Faces change at an edge where the foot is this near to it, in thicknesses; further off they change in a gap between the faces, as under a rib.
const AT: f64 = 0.1;
/// On which side of a line a triangle lies is asked at this share of the way from its edge to its corner.
const INWARD: f64 = 0.25;

type Faces = SmallVec<[FaceId; 2]>;

/// The line beneath wished edges of one side of a wall.
pub(super) struct Cut {
    wall: WallId,
    side: usize,
    line: Line,
    /// The two faces of each edge, in order.
    pairs: BTreeSet<[FaceId; 2]>,
    /// mm.
    thickness: f64,
    /// The faces that meet at the nodes on the line.
    on: BTreeMap<NodeId, Faces>,
}

/// Where the nearest face changes at a wished edge.
struct Change {
    /// Share of the way.
    at: f64,
    /// The faces before and behind.
    faces: [FaceId; 2],
}

fn in_order([a, b]: [FaceId; 2]) -> [FaceId; 2] {
    [a.min(b), a.max(b)]
}

impl Cut {
    pub fn new(
        brep: &Brep,
        medial: &Medial<'_>,
        wall: WallId,
        side: usize,
        curves: &[CurveId],
    ) -> Self {
        let line = Line::new(brep, curves);
        Self {
            wall,
            side,
            pairs: line.halves().iter().map(|h| in_order(h.faces)).collect(),
            line,
            thickness: medial.mean_thickness(wall),
            on: BTreeMap::new(),
        }
    }

    fn foot(&self, medial: &Medial<'_>, p: DVec3) -> Option<crate::medial::Foot> {
        medial.feet(p, self.wall).map(|feet| feet[self.side])
    }

    /// The face that a place lies beneath.
    fn face(&self, brep: &Brep, medial: &Medial<'_>, p: DVec3) -> Option<FaceId> {
        let foot = self.foot(medial, p)?;
        if let Some((place, half)) = self.line.nearest(foot.point)
            && place.distance(foot.point) < ON * self.thickness
        {
            let first = (p - place).dot(half.towards) >= 0.0;
            return Some(half.faces[usize::from(!first)]);
        }
        Some(brep.facets[foot.facet].face)
    }

    /// The faces that a node lies beneath.
    fn faces(&self, cutter: &Cutter<'_>, n: NodeId) -> Faces {
        match self.on.get(&n) {
            Some(faces) => faces.clone(),
            None => (self.face(cutter.brep, cutter.medial, cutter.complex.nodes[n].point))
                .into_iter()
                .collect(),
        }
    }

    /// The first change at a wished edge on the way from `a` to `b`.
    fn change(&self, cutter: &Cutter<'_>, [a, b]: [NodeId; 2]) -> Option<Change> {
        let (brep, medial) = (cutter.brep, cutter.medial);
        let [p, q] = [a, b].map(|n| cutter.complex.nodes[n].point);
        let (mut left, last) = (self.faces(cutter, a), self.faces(cutter, b));
        let mut from = 0.0;
        for _ in 0..CHANGES {
            if left.iter().any(|f| last.contains(f)) {
                return None;
            }
            let (mut low, mut high) = (from, 1.0);
            let mut faces = [*left.first()?, *last.first()?];
            for _ in 0..HALVINGS {
                let middle = (low + high) / 2.0;
                let face = self.face(brep, medial, p.lerp(q, middle))?;
                if left.contains(&face) {
                    (low, faces[0]) = (middle, face);
                } else {
                    (high, faces[1]) = (middle, face);
                }
            }
            let foot = self.foot(medial, p.lerp(q, high))?.point;
            let (place, _) = self.line.nearest(foot)?;
            if self.pairs.contains(&in_order(faces)) && place.distance(foot) < AT * self.thickness {
                return Some(Change { at: high, faces });
            }
            from = high;
            left = smallvec::smallvec![faces[1]];
        }
        None
    }

    fn put_on(&mut self, n: NodeId, faces: &[FaceId]) {
        let at = self.on.entry(n).or_default();
        for &f in faces {
            if !at.contains(&f) {
                at.push(f);
            }
        }
    }

    /// Wished edges whose faces meet at both nodes.
    fn common(&self, [a, b]: [NodeId; 2]) -> Vec<[FaceId; 2]> {
        let (Some(a), Some(b)) = (self.on.get(&a), self.on.get(&b)) else {
            return Vec::new();
        };
        let both = |pair: &&[FaceId; 2]| pair.iter().all(|f| a.contains(f) && b.contains(f));
        self.pairs.iter().filter(both).copied().collect()
    }
}

/// A complex being cut.
pub(super) struct Cutter<'a> {
    complex: MidComplex,
    brep: &'a Brep,
    medial: &'a Medial<'a>,
    cuts: Vec<Cut>,
}

impl<'a> Cutter<'a> {
    pub fn new(
        complex: MidComplex,
        brep: &'a Brep,
        medial: &'a Medial<'a>,
        cuts: Vec<Cut>,
    ) -> Self {
        Self {
            complex,
            brep,
            medial,
            cuts,
        }
    }

    /// Cuts along one line after the other.
    pub fn cut(&mut self) {
        for i in 0..self.cuts.len() {
            self.snap(i);
            for _ in 0..CHANGES {
                if !self.slice(i) {
                    break;
                }
            }
            self.fork(i);
        }
    }

    /// The edges with a triangle of the wall over which faces change, and where.
    fn changes(&self, i: usize) -> Vec<(MidEdge, Change)> {
        let cut = &self.cuts[i];
        let of_wall = |t: &TriangleId| self.complex.triangles[*t].wall == cut.wall;
        let edges: Vec<MidEdge> = (self.complex.edges().into_iter())
            .filter(|e| e.triangles.iter().any(of_wall))
            .collect();
        (edges.into_par_iter())
            .filter_map(|e| {
                let change = cut.change(self, e.ends)?;
                Some((e, change))
            })
            .collect()
    }

    /// Ends of edges that lie next to the line come to lie on it, unless they are corners.
    fn snap(&mut self, i: usize) {
        for (edge, change) in self.changes(i) {
            let n = if change.at < NEAR {
                edge.ends[0]
            } else if change.at > 1.0 - NEAR {
                edge.ends[1]
            } else {
                continue;
            };
            if self.complex.nodes[n].supports.len() <= 2 {
                self.cuts[i].put_on(n, &change.faces);
            }
        }
    }

    /// Splits the edges over which faces change; says whether there were any.
    fn slice(&mut self, i: usize) -> bool {
        let changes = self.changes(i);
        let mut splits: BTreeMap<[NodeId; 2], NodeId> = BTreeMap::new();
        for (edge, change) in &changes {
            let ring = &edge.triangles;
            let node = split::node_on(&self.complex, edge.ends, change.at, ring, self.medial);
            let n = self.complex.nodes.push(node);
            for (j, cut) in self.cuts.iter_mut().enumerate() {
                if j == i {
                    cut.put_on(n, &change.faces);
                } else {
                    // Where lines cross, the new node lies on the other one as well.
                    let pairs = cut.common(edge.ends);
                    if !pairs.is_empty() {
                        cut.put_on(n, &pairs.concat());
                    }
                }
            }
            splits.insert(edge.ends, n);
        }
        split::split(&mut self.complex, &splits);
        !changes.is_empty()
    }

    /// A triangle cut thrice, between three faces, gets a node in its middle, where the three lines meet.
    fn fork(&mut self, i: usize) {
        let mut triangles = Vec::new();
        for t in self.complex.triangles.as_slice() {
            let cut = &mut self.cuts[i];
            let faces: BTreeSet<FaceId> = (t.nodes.iter())
                .filter_map(|n| cut.on.get(n).filter(|faces| faces.len() == 2))
                .flatten()
                .copied()
                .collect();
            let [a, b, c] = t.nodes;
            let apart = [[a, b], [b, c], [c, a]].map(|e| cut.common(e).is_empty());
            let all = t.nodes.iter().all(|n| cut.on.contains_key(n));
            if t.wall != cut.wall || faces.len() != 3 || !all || apart != [true; 3] {
                triangles.push(*t);
                continue;
            }
            let point = self.complex.corners(t).iter().sum::<DVec3>() / 3.0;
            let supports = std::iter::once(Support::Mid(t.wall)).collect();
            let n = self.complex.nodes.push(MidNode { point, supports });
            cut.put_on(n, &faces.into_iter().collect::<Vec<_>>());
            for [a, b] in [[a, b], [b, c], [c, a]] {
                triangles.push(MidTriangle {
                    nodes: [a, b, n],
                    wall: t.wall,
                });
            }
        }
        self.complex.triangles = triangles.into();
    }

    /// The cut complex, and its edges on lines with the edge of the solid that each lies beneath.
    pub fn finish(self) -> (MidComplex, BTreeMap<[NodeId; 2], CurveId>) {
        let mut lines = BTreeMap::new();
        for edge in self.complex.edges() {
            let Some(&first) = edge.triangles.first() else {
                continue;
            };
            let wall = self.complex.triangles[first].wall;
            if self.complex.kind(&edge) != EdgeKind::Inner {
                continue;
            }
            for cut in self.cuts.iter().filter(|c| c.wall == wall) {
                if let Some(curve) = self.parts(cut, &edge) {
                    lines.insert(edge.ends, curve);
                }
            }
        }
        (self.complex, lines)
    }

    /// The edge of the solid beneath which this one parts two faces.
    fn parts(&self, cut: &Cut, edge: &MidEdge) -> Option<CurveId> {
        let pairs = cut.common(edge.ends);
        if pairs.is_empty() {
            return None;
        }
        let [p, q] = edge.ends.map(|n| self.complex.nodes[n].point);
        let middle = (p + q) / 2.0;
        let beside = |t: TriangleId| {
            let nodes = self.complex.triangles[t].nodes;
            let apex = nodes.into_iter().find(|n| !edge.ends.contains(n))?;
            let faces = cut.faces(self, apex);
            if let &[face] = faces.as_slice()
                && pairs.iter().flatten().any(|f| *f == face)
            {
                return Some(face);
            }
            let inward = middle.lerp(self.complex.nodes[apex].point, INWARD);
            cut.face(self.brep, self.medial, inward)
        };
        let &[s, t] = edge.triangles.as_slice() else {
            return None;
        };
        let beside = in_order([beside(s)?, beside(t)?]);
        let foot = cut.foot(self.medial, middle)?;
        let (_, half) = cut.line.nearest(foot.point)?;
        pairs.contains(&beside).then_some(half.curve)
    }
}
