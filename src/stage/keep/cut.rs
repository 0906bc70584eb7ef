//! Cutting: edges of the complex over which the nearest face of a side changes at a wished edge are split there.

use super::corner;
use super::part::put;
use crate::geom::placer::Placer;
use crate::geom::split;
use crate::medial::{Line, Medial};
use crate::model::brep::Brep;
use crate::model::complex::{EdgeKind, MidComplex, MidEdge, MidNode, MidTriangle, Support};
use crate::model::disjoint::Disjoint;
use crate::model::ids::{CurveId, FaceId, FacetId, NodeId, TriangleId, VertexId, WallId};
use crate::spatial::TriangleBvh;
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
/// Where the foot is this near to an edge, in thicknesses, the plane over the line decides on which side a place is: facets are too coarse for that, and beneath an inner corner all feet are one.
const CLOSE: f64 = 0.5;
/// A foot this near to the corner of a line, in thicknesses, lies on it.
const ON: f64 = 1e-3;
/// Faces change at an edge where the foot is this near to it, in thicknesses; further off others lie between. Beyond the end of a side the line may run aslant.
const AT: f64 = 2.0 * CLOSE;
/// Where a sheet ends, at a rim or a junction, the line goes on so far beyond the end of its edge, in thicknesses: through a fillet and half of the other wall.
const BEYOND: f64 = 3.0;
/// A corner of the sheet this near lies on it.
const THERE: f64 = 0.01;
/// So far from a node on the line a place is clearly beside it, wherever the node was moved from.
const AWAY: f64 = 0.2;
/// On which side of a line a triangle lies is asked at this share of the way from its edge to its corner.
const INWARD: f64 = 0.25;

type Faces = SmallVec<[FaceId; 2]>;

/// The line beneath wished edges of one side of a wall.
pub(super) struct Cut {
    wall: WallId,
    side: usize,
    line: Line,
    /// The facets of the faces on either side of the edges, and which face each is of: of others the line knows nothing.
    bvh: TriangleBvh,
    of: Vec<FaceId>,
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
    /// One cut for all edges that hang together by their faces.
    pub fn all(
        brep: &Brep,
        medial: &Medial<'_>,
        wall: WallId,
        side: usize,
        curves: &[CurveId],
    ) -> Vec<Self> {
        let mut sets = Disjoint::new(brep.faces.len());
        let faces = |c: CurveId| brep.curves[c].faces.as_slice();
        for &c in curves {
            if let &[a, b] = faces(c) {
                sets.join(a.0, b.0);
            }
        }
        let mut groups: BTreeMap<u32, Vec<CurveId>> = BTreeMap::new();
        for &c in curves {
            if let Some(first) = faces(c).first() {
                groups.entry(sets.find(first.0)).or_default().push(c);
            }
        }
        (groups.values())
            .map(|curves| Self::new(brep, medial, wall, side, curves))
            .collect()
    }

    fn new(
        brep: &Brep,
        medial: &Medial<'_>,
        wall: WallId,
        side: usize,
        curves: &[CurveId],
    ) -> Self {
        let line = Line::new(brep, curves);
        let pairs: BTreeSet<[FaceId; 2]> =
            line.pieces().iter().map(|h| in_order(h.faces)).collect();
        let facets: Vec<FacetId> = (brep.facets.enumerated())
            .filter(|(_, facet)| pairs.iter().flatten().any(|f| *f == facet.face))
            .map(|(id, _)| id)
            .collect();
        let corners: Vec<[DVec3; 3]> = facets.iter().map(|&f| brep.corners(f)).collect();
        Self {
            wall,
            side,
            line,
            bvh: TriangleBvh::new(&corners),
            of: facets.iter().map(|&f| brep.facets[f].face).collect(),
            pairs,
            thickness: medial.mean_thickness(wall),
            on: BTreeMap::new(),
        }
    }

    /// The place of the side that is nearest, all its faces taken.
    fn foot(&self, medial: &Medial<'_>, p: DVec3) -> Option<DVec3> {
        medial.feet(p, self.wall).map(|feet| feet[self.side].point)
    }

    /// Which of the faces on either side of the edges a place lies beneath.
    fn face(&self, brep: &Brep, medial: &Medial<'_>, p: DVec3) -> Option<FaceId> {
        let near = self.bvh.nearest(p)?;
        let nearest = Some(self.of[near.index]);
        let (on_line, _) = self.line.nearest(near.point)?;
        if on_line.distance(near.point) > CLOSE * self.thickness {
            return nearest;
        }
        let (place, piece) = self.line.nearest(p)?;
        // At a corner neither plane goes on.
        let is_corner = |v: VertexId| {
            self.line.corners().contains_key(&v)
                && brep.vertices[v].distance(place) < ON * self.thickness
        };
        if piece.vertex.is_some_and(is_corner) {
            return nearest;
        }
        let normal = medial.normal(p, self.wall)?;
        let across = piece.along().cross(normal);
        let first = (p - place).dot(across) * piece.towards.dot(across) >= 0.0;
        Some(piece.faces[usize::from(!first)])
    }

    /// A place moved to the plane over the line; to `else_to` where there is none.
    fn onto(&self, medial: &Medial<'_>, p: DVec3, else_to: DVec3) -> DVec3 {
        let across = self.line.nearest(p).and_then(|(place, piece)| {
            let across = piece.along().cross(medial.normal(p, self.wall)?);
            let across = across.try_normalize()?;
            Some(across * across.dot(place - p))
        });
        across.map_or(else_to, |way| p + way)
    }

    /// The faces at a node where faces change: at a corner of the line all that meet there.
    fn faces_at(&self, brep: &Brep, p: DVec3, faces: [FaceId; 2]) -> Faces {
        let foot = self.bvh.nearest(p).map_or(p, |near| near.point);
        let here = |v: &VertexId| brep.vertices[*v].distance(foot) < ON * self.thickness;
        let corner = self.line.corners().iter().find(|(v, _)| here(v));
        corner.map_or_else(
            || Faces::from_slice(&faces),
            |(_, all)| Faces::from_slice(all),
        )
    }

    /// Whether faces that change at this place do so at an edge.
    fn is_at_edge(&self, medial: &Medial<'_>, p: DVec3, kind: EdgeKind) -> bool {
        let inner = || self.foot(medial, p);
        // The sides of a junction lie beneath other faces: there only nearness counts.
        let outer = || {
            let (place, _) = self.line.nearest(p)?;
            (place.distance(p) < BEYOND * self.thickness).then_some(self.bvh.nearest(p)?.point)
        };
        let foot = match kind {
            EdgeKind::Inner => inner(),
            _ => outer(),
        };
        let Some(foot) = foot else {
            return false;
        };
        let away = self.line.nearest(foot).map(|near| near.0.distance(foot));
        away.is_some_and(|away| away < AT * self.thickness)
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
    fn change(&self, cutter: &Cutter<'_>, edge: &MidEdge) -> Option<Change> {
        let ([a, b], kind) = (edge.ends, cutter.complex.kind(edge));
        let [p, q] = [a, b].map(|n| cutter.complex.nodes[n].point);
        let (mut left, mut last) = (self.faces(cutter, a), self.faces(cutter, b));
        let (mut from, mut to) = (0.0, 1.0);
        // From a node on the line the way may lead to either side, and over the line again at its next corner.
        let beside = |share: f64, faces: &Faces| {
            let face = self.face(cutter.brep, cutter.medial, p.lerp(q, share))?;
            faces
                .contains(&face)
                .then(|| -> Faces { smallvec::smallvec![face] })
        };
        match [a, b].map(|n| self.on.contains_key(&n)) {
            [true, false] => {
                if let Some(faces) = beside(AWAY, &left) {
                    (left, from) = (faces, AWAY);
                }
            }
            [false, true] => {
                if let Some(faces) = beside(1.0 - AWAY, &last) {
                    (last, to) = (faces, 1.0 - AWAY);
                }
            }
            _ => {}
        }
        for _ in 0..CHANGES {
            if left.iter().any(|f| last.contains(f)) {
                return None;
            }
            let (mut low, mut high) = (from, to);
            let mut faces = [*left.first()?, *last.first()?];
            for _ in 0..HALVINGS {
                let middle = (low + high) / 2.0;
                let face = self.face(cutter.brep, cutter.medial, p.lerp(q, middle))?;
                if left.contains(&face) {
                    (low, faces[0]) = (middle, face);
                } else {
                    (high, faces[1]) = (middle, face);
                }
            }
            let is_wished = self.pairs.contains(&in_order(faces));
            if is_wished && self.is_at_edge(cutter.medial, p.lerp(q, high), kind) {
                return Some(Change { at: high, faces });
            }
            from = high;
            left = smallvec::smallvec![faces[1]];
        }
        None
    }

    /// Says whether that is new.
    fn put_on(&mut self, n: NodeId, faces: &[FaceId]) -> bool {
        let at = self.on.entry(n).or_default();
        let before = at.len();
        for &f in faces {
            if !at.contains(&f) {
                at.push(f);
            }
        }
        at.len() > before
    }

    /// Faces that have wished edges with others at both nodes.
    fn common(&self, [a, b]: [NodeId; 2]) -> Faces {
        let (Some(a), Some(b)) = (self.on.get(&a), self.on.get(&b)) else {
            return Faces::new();
        };
        let ends_at = |f: FaceId, at: &Faces| {
            let wished = |g: &FaceId| self.pairs.contains(&in_order([f, *g]));
            at.contains(&f) && at.iter().any(wished)
        };
        let both = |f: &&FaceId| ends_at(**f, a) && ends_at(**f, b);
        a.iter().filter(both).copied().collect()
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
            self.meet_corners(i);
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
                let change = cut.change(self, &e)?;
                Some((e, change))
            })
            .collect()
    }

    /// The end of an edge that a change lies next to.
    fn end_near(edge: &MidEdge, change: &Change) -> Option<NodeId> {
        match change.at {
            at if at < NEAR => Some(edge.ends[0]),
            at if at > 1.0 - NEAR => Some(edge.ends[1]),
            _ => None,
        }
    }

    /// Ends of edges that lie next to the line go there, unless they are corners or that turns a triangle over.
    fn snap(&mut self, i: usize) {
        let stars = self.complex.stars();
        for (edge, change) in self.changes(i) {
            if Self::end_near(&edge, &change).is_none() {
                continue;
            }
            // The last one may have moved it.
            let cut = &self.cuts[i];
            let Some(change) = cut.change(self, &edge) else {
                continue;
            };
            let Some(n) = Self::end_near(&edge, &change) else {
                continue;
            };
            let node = &self.complex.nodes[n];
            let at = if n == edge.ends[0] {
                change.at
            } else {
                1.0 - change.at
            };
            // A corner of the sheet cannot move, but may be where the line ends.
            if node.supports.len() > 2 {
                if at < THERE {
                    self.cuts[i].put_on(n, &change.faces);
                }
                continue;
            }
            // Lines nearer to each other than that are one: a node on another line stays.
            if self.cuts.iter().any(|c| c.on.contains_key(&n)) {
                self.cuts[i].put_on(n, &change.faces);
                continue;
            }
            let [p, q] = edge.ends.map(|n| self.complex.nodes[n].point);
            let from = cut.onto(self.medial, node.point, p.lerp(q, change.at));
            let to = self.medial.place(from, &node.supports);
            if put(&mut self.complex, &stars[n], n, to) {
                self.cuts[i].put_on(n, &change.faces);
            }
        }
    }

    /// Splits the edges over which faces change; says whether there were any.
    fn slice(&mut self, i: usize) -> bool {
        let changes = self.changes(i);
        let mut splits: BTreeMap<[NodeId; 2], NodeId> = BTreeMap::new();
        for (edge, change) in &changes {
            // Next to a node on the line no second one.
            if let Some(n) = Self::end_near(edge, change)
                && self.cuts[i].on.contains_key(&n)
                && self.cuts[i].put_on(n, &change.faces)
            {
                continue;
            }
            let ring = &edge.triangles;
            let node = split::node_on(&self.complex, edge.ends, change.at, ring, self.medial);
            let faces = self.cuts[i].faces_at(self.brep, node.point, change.faces);
            let n = self.complex.nodes.push(node);
            self.cuts[i].put_on(n, &faces);
            for (j, cut) in self.cuts.iter_mut().enumerate() {
                // Where lines cross, the new node lies on the other one as well.
                let common = cut.common(edge.ends);
                if j != i && common.len() > 1 {
                    cut.put_on(n, &common);
                }
            }
            splits.insert(edge.ends, n);
        }
        split::split(&mut self.complex, &splits);
        !changes.is_empty()
    }

    /// Where the line turns or forks it has a node.
    fn meet_corners(&mut self, i: usize) {
        let (wall, on) = (self.cuts[i].wall, [Support::Mid(self.cuts[i].wall)]);
        for (vertex, faces) in self.cuts[i].line.corners().clone() {
            let to = self.medial.place(self.brep.vertices[vertex], &on);
            let taken = |n: NodeId| self.cuts.iter().any(|cut| cut.on.contains_key(&n));
            let nearest = corner::nearest(&self.complex, wall, to, taken);
            if let Some(n) = nearest.and_then(|t| corner::meet(&mut self.complex, t, to)) {
                self.cuts[i].put_on(n, &faces);
            }
        }
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
            let apart = [[a, b], [b, c], [c, a]].map(|e| cut.common(e).len() < 2);
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
        let common = cut.common(edge.ends);
        let &[s, t] = edge.triangles.as_slice() else {
            return None;
        };
        if common.is_empty() {
            return None;
        }
        let [p, q] = edge.ends.map(|n| self.complex.nodes[n].point);
        let middle = (p + q) / 2.0;
        let beside = |t: TriangleId| {
            let nodes = self.complex.triangles[t].nodes;
            let apex = nodes.into_iter().find(|n| !edge.ends.contains(n))?;
            match cut.faces(self, apex).as_slice() {
                &[face] => Some(face),
                _ => {
                    let inward = middle.lerp(self.complex.nodes[apex].point, INWARD);
                    cut.face(self.brep, self.medial, inward)
                }
            }
        };
        let [one, other] = [beside(s)?, beside(t)?];
        let parts = one != other && (common.contains(&one) || common.contains(&other));
        let (_, piece) = cut.line.nearest(middle)?;
        parts.then_some(piece.curve)
    }
}
