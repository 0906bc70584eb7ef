//! Divide: a face that lies on both sides of a wall, or meets itself in a corner, becomes several.
//!
//! CAD systems sweep a closed profile into a single face: the skin of a blade, a C with rounded ends, a spiral. Pairing speaks of two faces a wall, so such a face is
//! cut here: facets that see other facets of their own face across the material are joined with their neighbours, the smoothest joint first, as long as no region comes to
//! see itself; what sees nothing lies on a rounded end and becomes a face of its own, as it is where the CAD system cut there.
//!
//! So is a face that meets itself in a corner ([`divide_at_corners`]): the skin of a wing swept as one face has a sharp trailing edge that no two faces meet at.
//!
//! Guarantees: facets and vertices stay as they are; a part keeps the number (`tag`) of its face; no region of a divided face holds a facet and the facet that it sees;
//! the result depends on the order of the facets only. Cost: nothing but a pass over the sightings where no face sees itself, which is the rule.
//!
//! Limits: borders run along sides of facets.

mod creased;
mod curves;

pub use creased::divide_at_corners;

use crate::geom::six_node;
use crate::model::brep::Brep;
use crate::model::disjoint::Disjoint;
use crate::model::ids::{FaceId, FacetId, Id, IndexVec};
use crate::model::sighting::{ANTIPARALLEL_COS, LeastExtent, Sighting};
use crate::spatial::TriangleBvh;
use glam::DVec3;
use rayon::prelude::*;
use std::collections::{BTreeMap, BTreeSet};

/// A face lies on both sides of a wall where this share of it sees the face itself across one that is wide enough: less is a notch in a thick face.
const SELF_SEEN: f64 = 0.05;
/// Or where that many squared distances do: a patch as large is a wall whatever share of its face it is.
const LARGE_PATCH: f64 = 9.0;
/// As many thicknesses wide as a wall is at the least.
const LEAST_WIDTH: f64 = 1.0;
/// Facets of one face that turn more than this at their common side lie on two sides of an edge: three facets on a quarter turn turn 30 degrees.
const SHARP_COS: f64 = 0.5;
/// How far below the surface a look starts, as a share of the part's diagonal: above rounding, far below any thickness.
const START: f64 = 1e-6;
/// Looks from other places of a plane wall are as long as those of the sightings but for this share.
const ROUNDING: f64 = 1e-3;

/// The boundary with every face cut that lies on both sides of a wall; `None` where there is no such face.
pub fn divide(brep: &Brep, sightings: &[Sighting]) -> Option<Brep> {
    let widest = on_both_sides(brep, sightings);
    let facets: Vec<FacetId> = (brep.facets.enumerated())
        .filter(|(_, f)| widest[f.face] > 0.0)
        .map(|(id, _)| id)
        .collect();
    if facets.is_empty() {
        return None;
    }
    let region = regions(brep, &facets, &widest);
    parted(brep, &facets, &region)
}

/// The boundary with a face for each region of these facets, which are all of those of their faces; `None` where each face is one region.
fn parted(brep: &Brep, facets: &[FacetId], region: &[u32]) -> Option<Brep> {
    let mut divided = brep.clone();
    // The first region of a face, by its first facet, stays the face.
    let mut known: BTreeMap<(FaceId, u32), FaceId> = BTreeMap::new();
    let mut begun: BTreeSet<FaceId> = BTreeSet::new();
    for (&facet, &region) in facets.iter().zip(region) {
        let face = brep.facets[facet].face;
        let face = *known.entry((face, region)).or_insert_with(|| {
            if begun.insert(face) {
                face
            } else {
                divided.faces.push(brep.faces[face].clone())
            }
        });
        divided.facets[facet].face = face;
    }
    if divided.faces.len() == brep.faces.len() {
        return None;
    }
    curves::renew(&mut divided);
    Some(divided)
}

/// Of the faces that lie on both sides of a wall the greatest distance across it, mm; of the others zero.
fn on_both_sides(brep: &Brep, sightings: &[Sighting]) -> IndexVec<FaceId, f64> {
    let none = (0.0, 0.0, Vec::new());
    let mut looks: IndexVec<FaceId, (f64, f64, Vec<f64>)> =
        IndexVec::filled(none, brep.faces.len());
    for s in sightings {
        let (all, own, distances) = &mut looks[s.from];
        *all += s.area;
        if let Some((to, distance)) = s.across
            && to == s.from
            && s.extent.is_wide(&LeastExtent::of_walls(LEAST_WIDTH))
        {
            *own += s.area;
            distances.push(distance);
        }
    }
    let judge = |(all, own, mut distances): (f64, f64, Vec<f64>)| {
        distances.sort_unstable_by(f64::total_cmp);
        let median = distances.get(distances.len() / 2).copied();
        let double = median.is_some_and(|d| own > SELF_SEEN * all || own > LARGE_PATCH * d * d);
        distances.last().copied().filter(|_| double).unwrap_or(0.0)
    };
    looks.into_vec().into_iter().map(judge).collect()
}

/// The region of each of these facets, which are all of those of the faces to divide.
fn regions(brep: &Brep, facets: &[FacetId], widest: &IndexVec<FaceId, f64>) -> Vec<u32> {
    let mate = mates(brep, facets, widest);
    let joints = joints(brep, facets);
    let mut regions = Regions::new(&mate);
    for &(_, [a, b]) in &joints {
        if mate[a as usize].is_some() && mate[b as usize].is_some() {
            regions.join(a, b);
        }
    }
    // What sees nothing: a hole in a region is part of it, what lies between two is not.
    let mut blind = Disjoint::new(facets.len());
    let sees = |i: u32| mate[i as usize].is_some();
    for &(_, [a, b]) in &joints {
        if !sees(a) && !sees(b) {
            blind.join(a, b);
        }
    }
    let mut beside: BTreeMap<u32, BTreeSet<u32>> = BTreeMap::new();
    for &(_, [a, b]) in &joints {
        for (a, b) in [(a, b), (b, a)] {
            if !sees(a) && sees(b) {
                let region = regions.sets.find(b);
                beside.entry(blind.find(a)).or_default().insert(region);
            }
        }
    }
    (0..facets.len() as u32)
        .map(|i| {
            if sees(i) {
                return regions.sets.find(i);
            }
            let patch = blind.find(i);
            match beside.get(&patch) {
                Some(round) if round.len() == 1 => round.first().copied().unwrap_or(patch),
                _ => patch,
            }
        })
        .collect()
}

/// For each facet the place of the one of its own face that it sees across the wall, not along it.
fn mates(brep: &Brep, facets: &[FacetId], widest: &IndexVec<FaceId, f64>) -> Vec<Option<u32>> {
    let triangles: Vec<[DVec3; 3]> = brep.facets.ids().map(|f| brep.corners(f)).collect();
    let bvh = TriangleBvh::new(&triangles);
    let start = START * brep.diagonal();
    facets
        .par_iter()
        .map(|&facet| {
            let normal = middle_normal(brep, facet);
            let [a, b, c] = brep.corners(facet);
            let (hit, distance) = bvh.first_hit((a + b + c) / 3.0 - normal * start, -normal)?;
            let seen = FacetId(hit as u32);
            let face = brep.facets[facet].face;
            let own = brep.facets[seen].face == face
                && distance <= widest[face] * (1.0 + ROUNDING)
                && middle_normal(brep, seen).dot(normal) < -ANTIPARALLEL_COS;
            let place = facets.binary_search(&seen).ok()?;
            own.then_some(place as u32)
        })
        .collect()
}

fn middle_normal(brep: &Brep, facet: FacetId) -> DVec3 {
    let third = 1.0 / 3.0;
    six_node::normal(&brep.corners(facet), &brep.facets[facet].mids, third, third)
}

/// Facets of one face with a common side, by their places, those that turn least first; the first number grows with the turn.
fn joints(brep: &Brep, facets: &[FacetId]) -> Vec<(f64, [u32; 2])> {
    let mut sides: Vec<([u32; 2], u32)> = Vec::with_capacity(3 * facets.len());
    for (i, &facet) in (0u32..).zip(facets) {
        let corners = brep.facets[facet].corners.map(|v| v.index() as u32);
        for k in 0..3 {
            let (a, b) = (corners[k], corners[(k + 1) % 3]);
            sides.push(([a.min(b), a.max(b)], i));
        }
    }
    sides.sort_unstable();
    let mut joints: Vec<(f64, [u32; 2])> = sides
        .chunk_by(|a, b| a.0 == b.0)
        .filter_map(|run| match *run {
            [(_, a), (_, b)] => Some([a, b]),
            _ => None,
        })
        .filter(|pair| {
            let [f, g] = pair.map(|i| brep.facets[facets[i as usize]].face);
            f == g
        })
        .map(|pair| {
            let [n, m] = pair.map(|i| middle_normal(brep, facets[i as usize]));
            (1.0 - n.dot(m), pair)
        })
        .filter(|(turn, _)| *turn < 1.0 - SHARP_COS)
        .collect();
    joints.sort_unstable_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
    joints
}

/// Sets of facets none of which sees itself.
struct Regions {
    sets: Disjoint,
    /// Who is seen by, or sees, the members of a set; kept at its lowest member.
    seen: Vec<Vec<u32>>,
}

impl Regions {
    fn new(mate: &[Option<u32>]) -> Self {
        let mut seen = vec![Vec::new(); mate.len()];
        for (i, mate) in (0u32..).zip(mate) {
            if let Some(mate) = *mate {
                seen[i as usize].push(mate);
                seen[mate as usize].push(i);
            }
        }
        Self {
            sets: Disjoint::new(mate.len()),
            seen,
        }
    }

    /// Makes one set of two, unless it would see itself.
    fn join(&mut self, a: u32, b: u32) {
        let (a, b) = (self.sets.find(a), self.sets.find(b));
        if a == b {
            return;
        }
        let (few, many) = if self.seen[a as usize].len() < self.seen[b as usize].len() {
            (a, b)
        } else {
            (b, a)
        };
        // Seeing goes both ways here, so that the shorter list says it all.
        let list = std::mem::take(&mut self.seen[few as usize]);
        if list.iter().any(|&i| self.sets.find(i) == many) {
            self.seen[few as usize] = list;
            return;
        }
        let mut all = std::mem::take(&mut self.seen[many as usize]);
        all.extend(list);
        self.sets.join(a, b);
        self.seen[a.min(b) as usize] = all;
    }
}

#[cfg(test)]
mod tests;
