//! From tets that fill a surface without conforming to it to a [`Piece`]: each facet of their boundary gets the nearest face.
//!
//! The boundary of the tets takes the place of the surface's own facets, because every later stage reads labels from vertices that boundary
//! and tets share. It is brought back onto the CAD surface first: a vertex of one face moves onto that face, one of several to the place where these
//! meet, and mid-side points likewise; where a tet would turn over, its corners stay. Two faces border on each other where their facets do.
//!
//! Guarantees: the laws of [`Brep`] and [`Tets`]; the boundary is a manifold (see [`pinch`](super::pinch)); every tet is positive.
//! Limits: faces narrower than the envelope may be lost, and borders between faces are ragged by about the envelope; seams inside a face are no curves.

use std::collections::BTreeMap;

use glam::DVec3;
use rayon::prelude::*;

use super::Piece;
use super::piece::{PieceError, checked};
use super::pinch::{boundary, opened};
use super::skin::{Skin, SkinCurve};
use super::tetwild::Filling;
use crate::geom::six_node::{QuadraticTriangle, nearest_on_quadratic};
use crate::geom::triangle::nearest_on_segment;
use crate::model::brep::{Brep, Curve, Facet};
use crate::model::ids::{CurveId, FaceId, Id, IndexVec, VertexId};
use crate::model::tets::Tets;
use crate::spatial::TriangleBvh;

/// A facet belongs to a face whose normal is within 60 degrees of its own, where there is one near: a facet that cuts off an edge of the part is within
/// 45 degrees of both.
const ALIKE_COS: f64 = 0.5;
/// A face this near, in envelopes, may own a facet: the boundary is within one of the facets given, and these within one of the surface.
const NEAR: f64 = 3.0;
/// A vertex may move so far, in envelopes, back onto the surface; at a corner of the part it lies further off than on a face.
const REACH: f64 = 4.0;
/// A mid-side point may be this share of its side away from the straight: a side over a third of a circle has a little more.
const BULGE: f64 = 0.25;
/// Rounds of projecting onto each of several faces in turn: two faces at a right angle need one, the error halves a round at 45 degrees.
const TURNS: usize = 16;
/// Rounds in which single facets take over the label of their neighbours; a tooth of a ragged border is seldom longer.
const SMOOTHINGS: usize = 3;

/// Gives the boundary of the tets the faces of the skin. `envelope` is that of the filling, mm.
pub(super) fn relabel(skin: &Skin, filling: &Filling, envelope: f64) -> Result<Piece, PieceError> {
    let solid = skin.solid_tag;
    let filling = opened(filling);
    let sides = boundary(&filling.tets);
    let target = Target::new(skin);
    let owner = target.owners(&filling, &sides, envelope);
    if owner.is_empty() {
        return Err(PieceError::NotFilled { solid });
    }
    let mut faces_at: Vec<Vec<u32>> = vec![Vec::new(); filling.points.len()];
    for (side, &face) in sides.iter().zip(&owner) {
        for v in side {
            let at = &mut faces_at[*v as usize];
            if let Err(place) = at.binary_search(&face) {
                at.insert(place, face);
            }
        }
    }
    let (points, moved) = target.settled(&filling, &faces_at, envelope);

    // Vertices of the boundary come first.
    let mut order: Vec<u32> = sides.iter().flatten().copied().collect();
    order.sort_unstable();
    order.dedup();
    order.extend(
        (0u32..)
            .zip(&faces_at)
            .filter(|f| f.1.is_empty())
            .map(|f| f.0),
    );
    let mut vertex_of = vec![VertexId(u32::MAX); points.len()];
    for (at, &v) in order.iter().enumerate() {
        vertex_of[v as usize] = VertexId::new(at);
    }

    // A face that lost all its facets is left out.
    let mut kept: Vec<u32> = owner.clone();
    kept.sort_unstable();
    kept.dedup();
    let face_id = |f: u32| FaceId::new(kept.partition_point(|&k| k < f));
    let mids = target.middles(&sides, &owner, &points, &moved);
    let facets = sides.iter().zip(&owner).zip(&mids);
    let facets = facets.map(|((side, &face), &mids)| Facet {
        corners: side.map(|v| vertex_of[v as usize]),
        mids,
        face: face_id(face),
    });
    let mut brep = Brep {
        solid_tag: solid,
        vertices: order.iter().map(|&v| points[v as usize]).collect(),
        facets: facets.collect(),
        faces: kept
            .iter()
            .map(|&f| skin.faces[f as usize].clone())
            .collect(),
        curves: IndexVec::new(),
    };
    borders(&mut brep, skin, &kept);
    let cells = filling.tets.iter();
    let tets = Tets {
        cells: cells.map(|t| t.map(|v| vertex_of[v as usize])).collect(),
    };
    checked(solid, brep, tets)
}

/// A curve's number in the skin, where it has one, and the two faces that meet there.
type Border = (Option<i32>, [FaceId; 2]);

/// The curves of a labelled boundary: where facets of different faces meet; those of the skin where it has one between these faces.
fn borders(brep: &mut Brep, skin: &Skin, kept: &[u32]) {
    let mut between: BTreeMap<[u32; 2], Vec<&SkinCurve>> = BTreeMap::new();
    for curve in &skin.curves {
        for (i, &f) in curve.faces.iter().enumerate() {
            for &g in &curve.faces[i + 1..] {
                between.entry([f.min(g), f.max(g)]).or_default().push(curve);
            }
        }
    }
    let mut sides: Vec<([VertexId; 2], FaceId)> = Vec::with_capacity(3 * brep.facets.len());
    for facet in &brep.facets {
        let [a, b, c] = facet.corners;
        sides.extend([[a, b], [b, c], [c, a]].map(|[p, q]| ([p.min(q), p.max(q)], facet.face)));
    }
    sides.sort_unstable();
    let last = skin.curves.iter().map(|c| c.tag).max().unwrap_or(0);
    // The curves of the skin first, in the order of their numbers; then those that it does not know.
    let mut found: BTreeMap<Border, Vec<[VertexId; 2]>> = BTreeMap::new();
    for run in sides.chunk_by(|a, b| a.0 == b.0) {
        let &[(segment, f), (_, g)] = run else {
            continue;
        };
        if f == g {
            continue;
        }
        let faces = [f.min(g), f.max(g)];
        let known = between.get(&faces.map(|f| kept[f.index()]));
        let middle = brep.vertices[segment[0]].midpoint(brep.vertices[segment[1]]);
        let nearest = known
            .into_iter()
            .flatten()
            .min_by(|a, b| distance(&a.segments, middle).total_cmp(&distance(&b.segments, middle)));
        let key = (nearest.map(|c| c.tag), faces);
        found.entry(key).or_default().push(segment);
    }
    let (unknown, known): (Vec<_>, Vec<_>) = found.into_iter().partition(|(k, _)| k.0.is_none());
    let mut next = last;
    for ((tag, faces), segments) in known.into_iter().chain(unknown) {
        let tag = tag.unwrap_or_else(|| {
            next += 1;
            next
        });
        for f in faces {
            let id = CurveId::new(brep.curves.len());
            brep.faces[f].curves.push(id);
        }
        brep.curves.push(Curve {
            tag,
            faces: faces.to_vec(),
            segments,
        });
    }
}

fn distance(segments: &[[DVec3; 2]], p: DVec3) -> f64 {
    let to = |&[a, b]: &[DVec3; 2]| nearest_on_segment(a, b, p).distance(p);
    segments.iter().map(to).fold(f64::INFINITY, f64::min)
}

/// The skin, made ready for nearest points.
struct Target<'a> {
    skin: &'a Skin,
    /// A hierarchy a face, over its flat facets.
    of_face: Vec<TriangleBvh>,
    all: TriangleBvh,
    owner: Vec<u32>,
    normal: Vec<DVec3>,
}

impl<'a> Target<'a> {
    fn new(skin: &'a Skin) -> Self {
        let flat = |q: &QuadraticTriangle| q.corners;
        let of_face = skin.facets.iter();
        let of_face = of_face.map(|f| TriangleBvh::new(&f.iter().map(flat).collect::<Vec<_>>()));
        let all: Vec<[DVec3; 3]> = skin.facets.iter().flatten().map(flat).collect();
        let owner = (0u32..).zip(&skin.facets);
        Self {
            skin,
            of_face: of_face.collect(),
            owner: owner
                .flat_map(|(f, own)| own.iter().map(move |_| f))
                .collect(),
            normal: all.iter().map(|&t| normal(t)).collect(),
            all: TriangleBvh::new(&all),
        }
    }

    /// The face of each side.
    fn owners(&self, filling: &Filling, sides: &[[u32; 3]], envelope: f64) -> Vec<u32> {
        let corners = |s: &[u32; 3]| s.map(|v| filling.points[v as usize]);
        let first: Option<Vec<u32>> = sides
            .par_iter()
            .map(|side| {
                let corners = corners(side);
                let n = normal(corners);
                let centre = (corners[0] + corners[1] + corners[2]) / 3.0;
                // The surface mesher may turn a face inside out, so that only the line of the normal counts.
                let alike = |i: usize| self.normal[i].dot(n).abs() >= ALIKE_COS;
                let near = self.all.nearest_where(centre, NEAR * envelope, alike);
                let near = near.or_else(|| self.all.nearest(centre))?;
                Some(self.owner[near.index])
            })
            .collect();
        let mut owner = first.unwrap_or_default();
        if owner.is_empty() {
            return owner;
        }
        let mates = mates(sides);
        for _ in 0..SMOOTHINGS {
            let next: Vec<u32> = sides
                .par_iter()
                .enumerate()
                .map(|(i, side)| {
                    let [f, g, h] = mates[i].map(|m| owner[m as usize]);
                    let own = owner[i];
                    let most = if f == g || f == h { f } else { g };
                    let twice = f == g || g == h || f == h;
                    if !twice || most == own {
                        return own;
                    }
                    let [a, b, c] = corners(side);
                    let bvh = &self.of_face[most as usize];
                    let near = bvh.nearest_within((a + b + c) / 3.0, NEAR * envelope);
                    if near.is_some() { most } else { own }
                })
                .collect();
            if next == owner {
                break;
            }
            owner = next;
        }
        owner
    }

    fn on_face(&self, face: u32, p: DVec3) -> Option<DVec3> {
        let near = self.of_face[face as usize].nearest(p)?;
        let facet = &self.skin.facets[face as usize][near.index];
        Some(nearest_on_quadratic(facet.corners, facet.mids, p).0)
    }

    /// Where the faces meet, near `p`.
    fn on_faces(&self, faces: &[u32], p: DVec3) -> Option<DVec3> {
        let mut q = p;
        for _ in 0..if faces.len() > 1 { TURNS } else { 1 } {
            for &f in faces {
                q = self.on_face(f, q)?;
            }
        }
        q.is_finite().then_some(q)
    }

    /// The points brought back onto the surface, and which of them were.
    fn settled(
        &self,
        filling: &Filling,
        faces_at: &[Vec<u32>],
        envelope: f64,
    ) -> (Vec<DVec3>, Vec<bool>) {
        let old = &filling.points;
        let goal: Vec<Option<DVec3>> = old
            .par_iter()
            .zip(faces_at)
            .map(|(&p, faces)| {
                let q = self.on_faces(faces, p).filter(|_| !faces.is_empty())?;
                (q.distance(p) <= REACH * envelope).then_some(q)
            })
            .collect();
        let mut moved: Vec<bool> = goal.iter().map(Option::is_some).collect();
        let mut points: Vec<DVec3> = old
            .iter()
            .zip(&goal)
            .map(|(&p, g)| g.unwrap_or(p))
            .collect();
        loop {
            let mut again = false;
            for tet in &filling.tets {
                let [a, b, c, d] = tet.map(|v| points[v as usize]);
                if (b - a).dot((c - a).cross(d - a)) > 0.0 {
                    continue;
                }
                for v in tet.map(|v| v as usize) {
                    again |= std::mem::replace(&mut moved[v], false);
                    points[v] = old[v];
                }
            }
            if !again {
                return (points, moved);
            }
        }
    }

    /// The mid-side points of every side: on the surface where both ends are.
    fn middles(
        &self,
        sides: &[[u32; 3]],
        owner: &[u32],
        points: &[DVec3],
        moved: &[bool],
    ) -> Vec<[DVec3; 3]> {
        let mates = mates(sides);
        sides
            .par_iter()
            .enumerate()
            .map(|(i, side)| {
                [0, 1, 2].map(|k| {
                    let (u, v) = (side[k], side[(k + 1) % 3]);
                    let (u, v) = (u.min(v) as usize, u.max(v) as usize);
                    let straight = points[u].midpoint(points[v]);
                    if !(moved[u] && moved[v]) {
                        return straight;
                    }
                    let (f, g) = (owner[i], owner[mates[i][k] as usize]);
                    let both = [f.min(g), f.max(g)];
                    let faces = if f == g { &both[..1] } else { &both[..] };
                    let most = BULGE * points[u].distance(points[v]);
                    let curved = self.on_faces(faces, straight);
                    curved
                        .filter(|c| c.distance(straight) <= most)
                        .unwrap_or(straight)
                })
            })
            .collect()
    }
}

fn normal([a, b, c]: [DVec3; 3]) -> DVec3 {
    (b - a).cross(c - a).normalize_or_zero()
}

/// The facet beyond each side of a closed manifold; the facet itself where there is none.
fn mates(facets: &[[u32; 3]]) -> Vec<[u32; 3]> {
    let mut sides: Vec<([u32; 2], u32, usize)> = Vec::with_capacity(3 * facets.len());
    for (i, f) in (0u32..).zip(facets) {
        for k in 0..3 {
            let (a, b) = (f[k], f[(k + 1) % 3]);
            sides.push(([a.min(b), a.max(b)], i, k));
        }
    }
    sides.sort_unstable();
    let mut mates: Vec<[u32; 3]> = (0..facets.len() as u32).map(|i| [i; 3]).collect();
    for run in sides.chunk_by(|a, b| a.0 == b.0) {
        if let &[(_, i, k), (_, j, l)] = run {
            mates[i as usize][k] = j;
            mates[j as usize][l] = i;
        }
    }
    mates
}

#[cfg(test)]
#[path = "relabel_tests.rs"]
mod tests;
