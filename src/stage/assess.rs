//! Assess: how well a placed mid-complex stands for its solid, cheaply enough to choose between several.
//!
//! `cover`: share of the thin wall area whose mid-point lies near the complex. `astray`: share of the complex's area whose distances to the boundary on either
//! side differ by more than a tenth, away from junctions and creases. `outside`: share of it outside the material. They come from the sightings that pairing
//! rests on and from rays along the triangles' normals. Cost: one nearest-point query a sighting; three rays and a search of the near boundary a triangle.

use crate::model::brep::Brep;
use crate::model::complex::{EdgeKind, MidComplex};
use crate::model::sighting::Sighting;
use crate::spatial::TriangleBvh;
use glam::DVec3;
use rayon::prelude::*;

/// A wall counts as thin up to this many median thicknesses.
const THIN: f64 = 2.5;
/// A mid-point is covered within this share of the thickness.
const NEAR: f64 = 0.35;
/// A sample is astray where its two distances differ by more than this share of their sum.
const ASTRAY: f64 = 0.1;
/// A piece of boundary faces a direction within this cosine; a lateral face faces neither.
const FACING_COS: f64 = 0.5;
/// A nearest point seen at more than this cosine off the normal is at an edge; the flat facets of a curved face differ by less.
const PLUMB_COS: f64 = 0.97;

/// Nearer to a junction or crease than this many thicknesses the two distances say nothing.
const AWAY: f64 = 1.5;

/// A place this little outside, in lengths of its triangle, is on the boundary: rims lie there, and flat facets cut off what is round.
const LEAK: f64 = 0.05;

/// What [`assess`] finds.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Assessment {
    /// Share of the thin wall area that is covered.
    pub cover: f64,
    /// Share of the complex's area that is off the middle.
    pub astray: f64,
    /// Share of the complex's area outside the material.
    pub outside: f64,
}

impl Assessment {
    /// One figure to choose by: what is covered less what is astray and what is outside. Missing walls and wild points weigh alike.
    pub fn score(&self) -> f64 {
        self.cover - self.astray - self.outside
    }
}

/// Measures cover and straying of a complex.
pub fn assess(brep: &Brep, sightings: &[Sighting], complex: &MidComplex) -> Assessment {
    let boundary: Vec<[DVec3; 3]> = brep.facets.ids().map(|f| brep.corners(f)).collect();
    let bvh = TriangleBvh::new(&boundary);
    Assessment {
        cover: cover(sightings, complex),
        astray: astray(&boundary, &bvh, complex),
        outside: outside(&bvh, complex),
    }
}

/// Share of the area whose triangles have their middles outside the material.
fn outside(bvh: &TriangleBvh, complex: &MidComplex) -> f64 {
    let judged: Vec<(f64, bool)> = corners(complex)
        .par_iter()
        .map(|[a, b, c]| {
            let area = (*b - *a).cross(*c - *a).length();
            let p = (*a + *b + *c) / 3.0;
            let leaves = bvh.any_within(p, LEAK * area.sqrt()).is_none() && !bvh.inside(p);
            (area, leaves)
        })
        .collect();
    let total: f64 = judged.iter().map(|j| j.0).sum();
    let out: f64 = judged.iter().filter(|j| j.1).map(|j| j.0).sum();
    if total > 0.0 { out / total } else { 0.0 }
}

fn corners(complex: &MidComplex) -> Vec<[DVec3; 3]> {
    complex
        .triangles
        .iter()
        .map(|t| complex.corners(t))
        .collect()
}

fn cover(sightings: &[Sighting], complex: &MidComplex) -> f64 {
    let mut thin: Vec<&Sighting> = sightings.iter().filter(|s| s.across.is_some()).collect();
    let distance = |s: &Sighting| s.across.map_or(f64::INFINITY, |a| a.1);
    thin.sort_by(|a, b| distance(a).total_cmp(&distance(b)));
    let half = thin.iter().map(|s| s.area).sum::<f64>() / 2.0;
    let mut passed = 0.0;
    let median = thin.iter().find(|s| {
        passed += s.area;
        passed >= half
    });
    let Some(limit) = median.map(|s| THIN * distance(s)) else {
        return 0.0;
    };
    thin.retain(|s| distance(s) <= limit);
    let bvh = TriangleBvh::new(&corners(complex));
    let near: Vec<f64> = thin
        .par_iter()
        .map(|s| {
            let d = distance(s);
            let middle = s.point + s.inward * (d / 2.0);
            if bvh.nearest_within(middle, NEAR * d).is_some() {
                s.area
            } else {
                0.0
            }
        })
        .collect();
    near.iter().sum::<f64>() / thin.iter().map(|s| s.area).sum::<f64>()
}

fn astray(boundary: &[[DVec3; 3]], bvh: &TriangleBvh, complex: &MidComplex) -> f64 {
    let special: Vec<[DVec3; 3]> = complex
        .edges()
        .iter()
        .filter(|edge| matches!(complex.kind(edge), EdgeKind::Junction | EdgeKind::Crease))
        .map(|edge| {
            let [a, b] = edge.ends.map(|n| complex.nodes[n].point);
            [a, b, b]
        })
        .collect();
    let special = TriangleBvh::new(&special);
    let triangles = corners(complex);
    let outward: Vec<DVec3> = boundary
        .iter()
        .map(|[a, b, c]| (*b - *a).cross(*c - *a).normalize_or_zero())
        .collect();
    // Whether the boundary that faces `n` is as far from `p` as the boundary that faces away from it, one of them at an edge.
    let midway = |p: DVec3, n: DVec3, reach: f64| {
        let foot = |n: DVec3| {
            bvh.nearest_where(p, reach, |i| outward[i].dot(n) > FACING_COS)
                .map(|near| {
                    let plumb = (near.point - p).dot(outward[near.index]);
                    (near.distance, plumb < PLUMB_COS * near.distance)
                })
        };
        let (Some((d, slant)), Some((e, aslant))) = (foot(n), foot(-n)) else {
            return false;
        };
        (slant || aslant) && (d - e).abs() <= ASTRAY * (d + e)
    };
    let judged: Vec<(f64, bool)> = triangles
        .par_iter()
        .map(|[a, b, c]| {
            let area = (*b - *a).cross(*c - *a);
            let Some(n) = area.try_normalize() else {
                return (0.0, false);
            };
            let p = (*a + *b + *c) / 3.0;
            let off = match (bvh.first_hit(p, n), bvh.first_hit(p, -n)) {
                (Some((_, d)), Some((_, e))) => {
                    // Of the wall that the sheet stands for: under a lump or a rib the ray on that side is longer.
                    let thickness = 2.0 * d.min(e);
                    if special.nearest_within(p, AWAY * thickness).is_some() {
                        return (0.0, false);
                    }
                    // On the slope over a step the rays miss the nearest points: there the distances proper are asked.
                    (d - e).abs() > ASTRAY * (d + e) && !midway(p, n, d + e)
                }
                _ => true,
            };
            (area.length(), off)
        })
        .collect();
    let total: f64 = judged.iter().map(|j| j.0).sum();
    let off: f64 = judged.iter().filter(|j| j.1).map(|j| j.0).sum();
    if total > 0.0 { off / total } else { 0.0 }
}

#[cfg(test)]
mod tests;
