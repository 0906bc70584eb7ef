//! Lines on mid-surfaces beneath edges of the solid that lie within a side of a wall.
//!
//! A wall is cut along such a line into pieces that have all of its faces for sides. Their mid-surfaces are one, so that they do not tell where they part: a node that two pieces of a
//! wall share lies on the plane through the edge that stands on the mid-surface as well. Beyond the end of the edge the line goes straight on.

use crate::geom::triangle::nearest_on_segment;
use crate::model::brep::Brep;
use crate::model::complex::MidComplex;
use crate::model::ids::{CurveId, FaceId, FacetId, VertexId, WallId};
use crate::model::pieces::Pieces;
use crate::spatial::TriangleBvh;
use glam::DVec3;
use smallvec::SmallVec;
use std::collections::{BTreeMap, BTreeSet};

/// A side of a facet on an edge is taken for a parabola through its middle, in so many straight pieces: they leave it by a 64th of what the side itself does.
const PIECES: u32 = 8;

/// A piece of an edge.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Piece {
    /// The edge.
    pub curve: CurveId,
    /// The vertex that it begins at, if it begins at one.
    pub vertex: Option<VertexId>,
    /// Its two ends, mm.
    pub ends: [DVec3; 2],
    /// The faces on either side.
    pub faces: [FaceId; 2],
    /// Across the edge, towards the first of the faces.
    pub towards: DVec3,
}

impl Piece {
    /// Unit direction; none where it has no length.
    pub fn along(&self) -> DVec3 {
        (self.ends[1] - self.ends[0]).normalize_or_zero()
    }
}

/// Where edges turn by more than this they have a corner: 20 degrees, which no bend divided for import does.
const CORNER_RAD: f64 = 20.0 * std::f64::consts::PI / 180.0;

/// Edges of the solid in pieces.
#[derive(Clone, Debug, Default)]
pub struct Line {
    bvh: TriangleBvh,
    pieces: Vec<Piece>,
    /// Where the edges turn or fork, and the faces that meet there.
    corners: BTreeMap<VertexId, SmallVec<[FaceId; 4]>>,
}

impl Line {
    /// Of these edges, as far as they have a face on either side.
    pub fn new(brep: &Brep, curves: &[CurveId]) -> Self {
        let mut sides: BTreeMap<[VertexId; 2], SmallVec<[(FacetId, usize); 2]>> = BTreeMap::new();
        for &[a, b] in curves.iter().flat_map(|&c| &brep.curves[c].segments) {
            sides.insert([a.min(b), a.max(b)], SmallVec::new());
        }
        for (id, facet) in brep.facets.enumerated() {
            for k in 0..3 {
                let [a, b] = [facet.corners[k], facet.corners[(k + 1) % 3]];
                if let Some(at) = sides.get_mut(&[a.min(b), a.max(b)]) {
                    at.push((id, k));
                }
            }
        }
        let mut pieces = Vec::new();
        for &curve in curves {
            for &[a, b] in &brep.curves[curve].segments {
                let Some(&[one, other]) = sides.get(&[a.min(b), a.max(b)]).map(|s| s.as_slice())
                else {
                    continue;
                };
                let middle = brep.facets[one.0].mids[one.1];
                let [p, q] = [a, b].map(|v| brep.vertices[v]);
                let along = (q - p).normalize_or_zero();
                let away = |(facet, k): (FacetId, usize)| {
                    let apex = brep.facets[facet].corners[(k + 2) % 3];
                    let way = brep.vertices[apex] - p;
                    (way - along * way.dot(along)).normalize_or_zero()
                };
                let bulge = middle - (p + q) / 2.0;
                let at = |i: u32| {
                    let t = f64::from(i) / f64::from(PIECES);
                    p.lerp(q, t) + bulge * (4.0 * t * (1.0 - t))
                };
                // Both halves run inwards, so that either vertex has a piece that begins there.
                let inwards = |i: u32| match i {
                    _ if 2 * i < PIECES => [i, i + 1],
                    _ => [i + 1, i],
                };
                pieces.extend((0..PIECES).map(|i| Piece {
                    curve,
                    vertex: match i {
                        0 => Some(a),
                        _ if i + 1 == PIECES => Some(b),
                        _ => None,
                    },
                    ends: inwards(i).map(at),
                    faces: [one, other].map(|s| brep.facets[s.0].face),
                    towards: away(one) - away(other),
                }));
            }
        }
        let corners: Vec<[DVec3; 3]> = (pieces.iter())
            .map(|piece| [piece.ends[0], piece.ends[1], piece.ends[1]])
            .collect();
        Self {
            bvh: TriangleBvh::new(&corners),
            corners: corners_of(&pieces),
            pieces,
        }
    }

    /// Where the edges turn or fork, and the faces that meet there.
    pub fn corners(&self) -> &BTreeMap<VertexId, SmallVec<[FaceId; 4]>> {
        &self.corners
    }

    /// All pieces.
    pub fn pieces(&self) -> &[Piece] {
        &self.pieces
    }

    /// How far a place is from each edge, mm, `normal` not counted: the height of the edges over a mid-surface with this unit normal.
    fn off(&self, p: DVec3, normal: DVec3) -> BTreeMap<CurveId, f64> {
        let mut off: BTreeMap<CurveId, f64> = BTreeMap::new();
        for piece in &self.pieces {
            let flat = |q: DVec3| q - normal * normal.dot(q - p);
            let [a, b] = piece.ends.map(flat);
            let away = nearest_on_segment(a, b, p).distance(p);
            let known = off.entry(piece.curve).or_insert(f64::INFINITY);
            *known = known.min(away);
        }
        off
    }

    /// The nearest place and the piece that it lies on.
    pub fn nearest(&self, p: DVec3) -> Option<(DVec3, &Piece)> {
        let near = self.bvh.nearest(p)?;
        Some((near.point, &self.pieces[near.index]))
    }
}

fn corners_of(pieces: &[Piece]) -> BTreeMap<VertexId, SmallVec<[FaceId; 4]>> {
    let mut at: BTreeMap<VertexId, Vec<&Piece>> = BTreeMap::new();
    for piece in pieces {
        if let Some(vertex) = piece.vertex {
            at.entry(vertex).or_default().push(piece);
        }
    }
    at.retain(|_, begin| match begin.as_slice() {
        [_] => false,
        [a, b] => a.along().angle_between(-b.along()) > CORNER_RAD,
        _ => true,
    });
    let faces = |begin: Vec<&Piece>| {
        let mut faces: SmallVec<[FaceId; 4]> = begin.iter().flat_map(|p| p.faces).collect();
        faces.sort_unstable();
        faces.dedup();
        faces
    };
    at.into_iter().map(|(v, begin)| (v, faces(begin))).collect()
}

/// The lines that walls are cut along.
#[derive(Clone, Debug, Default)]
pub struct Lines {
    of: BTreeMap<WallId, Line>,
    /// Which wall each piece is of.
    pieces: Pieces,
    /// Pieces that lie on either side of a line, in order. Others may meet at a junction.
    beside: BTreeSet<[WallId; 2]>,
    /// Which piece the parts are of that it was cut into for other reasons.
    parts: Pieces,
}

impl Lines {
    /// Of whole walls, with the pieces that these were cut into, and those that lie beside each other.
    pub fn new(of: BTreeMap<WallId, Line>, pieces: Pieces, beside: BTreeSet<[WallId; 2]>) -> Self {
        let parts = Pieces::default();
        Self {
            of,
            pieces,
            beside,
            parts,
        }
    }

    /// The same for walls that were cut once more.
    pub fn parted(&self, parts: &Pieces) -> Self {
        Self {
            parts: parts.clone(),
            ..self.clone()
        }
    }

    /// The line between two walls, if they are pieces of one that lie beside it, and the whole wall.
    fn between(&self, walls: [WallId; 2]) -> Option<(WallId, &Line)> {
        let [a, b] = walls.map(|w| self.parts.whole(w));
        let whole = self.pieces.whole(a);
        let line = self.of.get(&whole)?;
        (self.beside.contains(&[a.min(b), a.max(b)])).then_some((whole, line))
    }

    /// The planes over the lines that a place on these mid-surfaces (wall, unit normal, thickness) must lie on, as unit normals and how far away they are, mm.
    pub(super) fn planes(
        &self,
        p: DVec3,
        mids: &[(WallId, DVec3, f64)],
    ) -> SmallVec<[(DVec3, f64); 1]> {
        let mut planes = SmallVec::new();
        if self.of.is_empty() {
            return planes;
        }
        let mut seen: SmallVec<[WallId; 2]> = SmallVec::new();
        for (i, &(one, normal, _)) in mids.iter().enumerate() {
            for &(other, ..) in &mids[i + 1..] {
                let Some((whole, line)) = self.between([one, other]) else {
                    continue;
                };
                if seen.contains(&whole) {
                    continue;
                }
                seen.push(whole);
                if let Some((place, piece)) = line.nearest(p)
                    && let Some(across) = piece.along().cross(normal).try_normalize()
                {
                    planes.push((across, across.dot(place - p)));
                }
            }
        }
        planes
    }

    /// For every edge of a complex between pieces of a wall: how far its middle is from being beneath each edge of the solid, and its length, mm.
    pub fn along(&self, complex: &MidComplex) -> Vec<(BTreeMap<CurveId, f64>, f64)> {
        let mut found = Vec::new();
        for edge in complex.edges() {
            let &[s, t] = edge.triangles.as_slice() else {
                continue;
            };
            let [s, t] = [s, t].map(|t| &complex.triangles[t]);
            let Some((_, line)) = self.between([s.wall, t.wall]) else {
                continue;
            };
            let [a, b] = edge.ends.map(|n| complex.nodes[n].point);
            let normal = |t| complex.area_vector(t).normalize_or_zero();
            let (one, other) = (normal(s), normal(t));
            // Nothing winds neighbours one way yet.
            let normal = (one + other * one.dot(other).signum()).normalize_or_zero();
            found.push((line.off((a + b) / 2.0, normal), a.distance(b)));
        }
        found
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::test_parts::slim_wedge;

    /// The edge between the flat side and the slope of a wedge, along y: beneath it walls 1 and 2, pieces of wall 0 as is wall 3.
    fn lines() -> Lines {
        let line = Line::new(&slim_wedge(), &[CurveId(0)]);
        let mut pieces = Pieces::default();
        for piece in 1..4 {
            pieces.add(WallId(piece), WallId(0));
        }
        let beside = [[WallId(1), WallId(2)]].into();
        Lines::new([(WallId(0), line)].into(), pieces, beside)
    }

    fn mids(walls: &[u32]) -> Vec<(WallId, DVec3, f64)> {
        walls.iter().map(|&w| (WallId(w), DVec3::Z, 1.0)).collect()
    }

    #[test]
    fn a_place_on_two_pieces_of_a_wall_lies_over_their_line_and_beyond_its_end_straight_on() {
        for y in [3.0, 30.0] {
            let planes = lines().planes(DVec3::new(2.0, y, 0.7), &mids(&[1, 2]));
            let &[(normal, away)] = planes.as_slice() else {
                panic!("{planes:?}");
            };
            assert!((normal * away + 2.0 * DVec3::X).length() < 1e-12);
        }
    }

    #[test]
    fn only_pieces_beside_each_other_have_a_line_and_so_have_their_parts() {
        let count = |lines: &Lines, walls: &[u32]| lines.planes(DVec3::X, &mids(walls)).len();
        let lines = lines();
        for none in [&[1][..], &[1, 3], &[2, 3], &[1, 7]] {
            assert_eq!(count(&lines, none), 0, "{none:?}");
        }
        assert_eq!(count(&lines, &[1, 7, 2]), 1);
        let mut parts = Pieces::default();
        for (part, piece) in [(4, 1), (5, 1), (6, 2)] {
            parts.add(WallId(part), WallId(piece));
        }
        let parted = lines.parted(&parts);
        assert_eq!(count(&parted, &[4, 5]), 0);
        assert_eq!(count(&parted, &[4, 5, 6]), 1);
    }

    #[test]
    fn across_an_edge_lies_the_first_of_its_faces() {
        let line = Line::new(&slim_wedge(), &[CurveId(0)]);
        let piece = line.pieces()[0];
        // Both faces lie in the direction of x; the slope above the flat side.
        let up = piece.towards.z > 0.0;
        assert_eq!(piece.faces[0] == FaceId(1), up);
        assert!(piece.along().cross(DVec3::Y).length() < 1e-12);
    }
}
