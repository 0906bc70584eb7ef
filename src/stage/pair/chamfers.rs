//! Chamfers: where a wall is bevelled on one side at its rim, the bevel is a side of it.
//!
//! ```text
//!      ________________ inner edge
//!                      \  chamfer
//!      - - - - - - - .   \              Midway between chamfer and opposite side the sheet goes down at half the chamfer's angle, from a little before the inner edge
//!                      ` - .|  end      on, down to the end face.
//!      _____________________|
//! ```
//! Without this the sheet runs straight on at the wall's middle and comes out through the chamfer, nearer and nearer to it. A look inwards from a chamfer of 45 degrees meets
//! the opposite side at too great an angle to be a look across a wall, so that the gates know nothing of it.
//!
//! A chamfer is no side yet, meets a side at a convex edge and leans by 52.5 degrees at most, lies plumb above the faces opposite to that side, is no foot of anything,
//! and leads to an end face, not to another wall: on the corner of a box it belongs to the block where the walls join. Two equal chamfers on both sides of a wall are not
//! above its sides but beyond their ends; there the middle is straight. What takes away a fifth of the thickness or less leaves the middle
//! on the end face as well as the sheet can tell.
//!
//! Limits: an end cut off aslant right across the wall is an end face (`medial::slant`), and what is rounded is left to the gates.
//! Cost: a nearest-point query a look from a face that leans from a side.

use super::walls::other;
use crate::model::brep::Brep;
use crate::model::ids::{FaceId, IndexVec, WallId};
use crate::model::sighting::Sighting;
use crate::model::walls::{Aag, Convexity, FacePair};
use crate::spatial::TriangleBvh;
use glam::DVec3;
use std::collections::BTreeMap;

/// A chamfer leans from its side by less than this: between the drawing angles of 45 and 60 degrees, as in `gates`.
const LEANS_RAD: f64 = 52.5 * std::f64::consts::PI / 180.0;
/// Its points lie plumb above the opposite side, to this cosine: the draft of end faces is less, what lies beyond the end of the side is more.
const PLUMB_COS: f64 = 0.95;
/// Share of a chamfer that lies plumb above the opposite side: it may run on round corners.
const ABOVE: f64 = 0.6;
/// It takes away at least this share of the thickness at the rim. With `TRIM` off both ends nine tenths of a chamfer are measured: a quarter of the thickness, often
/// drawn, as 0.22 and a fifth as 0.18; the limit lies between them.
const LEAST_DROP: f64 = 0.2;
/// And leaves at least this share: less is an end face that leans, or a knife's edge.
const LEAST_LEFT: f64 = 0.1;
/// It runs along its side with at least this share of its border.
const LEAST_BORDER: f64 = 0.25;
/// Less than this share of its border lies in inner corners, and along sides of other walls.
const FOREIGN: f64 = 0.2;
/// A face that sees less than this share of a chamfer is not opposite to it.
const LEAST_SHARE: f64 = 0.1;
/// Looks left out at either end of the range of heights, one in this many: at the corners of a chamfer they lie elsewhere.
const TRIM: usize = 20;

/// Pairs of chamfers with the sides opposite to them. Sightings are in order of their faces; `pairs` are those known so far.
pub(super) fn chamfers(
    brep: &Brep,
    aag: &Aag,
    sightings: &[Sighting],
    pairs: &[FacePair],
) -> Vec<FacePair> {
    let mut of_face: IndexVec<FaceId, Vec<u32>> = IndexVec::filled(Vec::new(), aag.area.len());
    for (i, p) in pairs.iter().enumerate() {
        for f in p.faces {
            of_face[f].push(i as u32);
        }
    }
    let mut found = Vec::new();
    for own in sightings.chunk_by(|a, b| a.from == b.from) {
        let c = own[0].from;
        if !of_face[c].is_empty() {
            continue;
        }
        let leans = |f: FaceId| {
            let along: Vec<_> = aag.arcs_of(c).filter(|a| Aag::across(a, c) == f).collect();
            let length: f64 = along.iter().map(|a| a.length).sum();
            let convex = |a: &&_| is_chamfered(a);
            !of_face[f].is_empty()
                && length >= LEAST_BORDER * aag.perimeter[c]
                && along.iter().all(convex)
        };
        let mut sides: Vec<FaceId> = aag.arcs_of(c).map(|a| Aag::across(a, c)).collect();
        sides.sort_unstable();
        sides.dedup();
        sides.retain(|&f| leans(f));
        // Between two sides a chamfer is the bend of a wall.
        let &[f] = sides.as_slice() else {
            continue;
        };
        let opposite: Vec<FaceId> = (of_face[f].iter())
            .map(|&i| other(&pairs[i as usize], f))
            .collect();
        let thickness = (of_face[f].iter())
            .map(|&i| pairs[i as usize].thickness[1])
            .fold(0.0, f64::max);
        if is_foreign(aag, &of_face, c, f, &opposite) {
            continue;
        }
        found.extend(above(brep, own, &opposite, thickness));
    }
    found.sort_by_key(|p| p.faces);
    found
}

/// Whether two faces meet as a side and its chamfer do.
fn is_chamfered(arc: &crate::model::walls::Arc) -> bool {
    arc.convexity == Convexity::Convex && arc.turn_rad < LEANS_RAD
}

/// Whether a chamfer lies in inner corners, or leads to another wall.
fn is_foreign(
    aag: &Aag,
    of_face: &IndexVec<FaceId, Vec<u32>>,
    c: FaceId,
    side: FaceId,
    opposite: &[FaceId],
) -> bool {
    let foreign = aag.arcs_of(c).filter(|a| {
        let g = Aag::across(a, c);
        let another = g != side && !opposite.contains(&g) && !of_face[g].is_empty();
        a.convexity == Convexity::Concave || another
    });
    foreign.map(|a| a.length).sum::<f64>() > FOREIGN * aag.perimeter[c]
}

/// The pairs of one chamfer, from its looks.
fn above(brep: &Brep, own: &[Sighting], opposite: &[FaceId], thickness: f64) -> Vec<FacePair> {
    let (mut corners, mut whose): (Vec<[DVec3; 3]>, Vec<FaceId>) = (Vec::new(), Vec::new());
    for (id, facet) in brep.facets.enumerated() {
        if opposite.contains(&facet.face) {
            corners.push(brep.corners(id));
            whose.push(facet.face);
        }
    }
    let bvh = TriangleBvh::new(&corners);
    let mut heights: BTreeMap<FaceId, Vec<f64>> = BTreeMap::new();
    let (mut all, mut plumb) = (0.0, 0.0);
    for s in own {
        all += s.area;
        let Some(near) = bvh.nearest_within(s.point, (1.0 + LEAST_LEFT) * thickness) else {
            continue;
        };
        let [a, b, c] = corners[near.index];
        let normal = (b - a).cross(c - a).normalize_or_zero();
        let down = near.point - s.point;
        if down.dot(normal) > PLUMB_COS * near.distance && s.inward.dot(normal) > LEANS_RAD.cos() {
            plumb += s.area;
            (heights.entry(whose[near.index]).or_default()).push(near.distance);
        }
    }
    let mut every: Vec<f64> = heights.values().flatten().copied().collect();
    every.sort_by(f64::total_cmp);
    let trim = every.len() / TRIM;
    let (Some(low), Some(high)) = (every.get(trim), every.iter().rev().nth(trim)) else {
        return Vec::new();
    };
    if plumb < ABOVE * all || high - low < LEAST_DROP * thickness || *low < LEAST_LEFT * thickness {
        return Vec::new();
    }
    let share = all / own.len() as f64;
    (heights.into_iter())
        .filter(|(_, h)| h.len() as f64 >= LEAST_SHARE * own.len() as f64)
        .map(|(g, mut h)| {
            h.sort_by(f64::total_cmp);
            let c = own[0].from;
            FacePair {
                faces: [c.min(g), c.max(g)],
                overlap: h.len() as f64 * share,
                thickness: [h[0], h.iter().sum::<f64>() / h.len() as f64, h[h.len() - 1]],
                wall: WallId(0),
            }
        })
        .collect()
}
