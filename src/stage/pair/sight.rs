//! What every face sees when it looks through the material: the one measurement that all pairing rests on.
//!
//! Rays go inwards along the normal of the six-node facets from sample points spread over every face in proportion to its area, so
//! that small faces are seen as well as large ones. Cost: one ray a sample and those of `extent`, in parallel.

use super::extent::{Boundary, extent};
use crate::geom::six_node;
use crate::model::brep::Brep;
use crate::model::ids::{FaceId, FacetId};
use crate::model::sighting::{ANTIPARALLEL_COS, Extent, Sighting};
use crate::spatial::TriangleBvh;
use glam::DVec3;
use rayon::prelude::*;

/// Samples every face gets, however small: enough for an overlap share to be known to a few per cent.
const LEAST_SAMPLES: f64 = 60.0;
/// Samples spread over the whole boundary by area.
const SHARED_SAMPLES: f64 = 20_000.0;
/// How far below the surface a ray starts, as a share of the part's diagonal: above rounding, far below any thickness.
const START: f64 = 1e-6;

/// Looks from every face through the material, in order of the faces.
pub fn sight(brep: &Brep) -> Vec<Sighting> {
    let triangles: Vec<[DVec3; 3]> = brep.facets.ids().map(|f| brep.corners(f)).collect();
    let bvh = TriangleBvh::new(&triangles);
    let start = START * brep.diagonal();
    let outward = |i: usize, at: DVec3| {
        let (u, v) = barycentric(&triangles[i], at);
        six_node::normal(&triangles[i], &brep.facets[FacetId(i as u32)].mids, u, v)
    };
    let flat: Vec<DVec3> = triangles
        .iter()
        .map(|[a, b, c]| (*b - *a).cross(*c - *a).normalize_or_zero())
        .collect();
    let boundary = Boundary {
        bvh: &bvh,
        flat: &flat,
        outward: &outward,
    };
    samples(brep)
        .into_par_iter()
        .map(|(facet, u, v, area)| {
            let corners = &triangles[facet.0 as usize];
            let normal = six_node::normal(corners, &brep.facets[facet].mids, u, v);
            let point = corners[0] + (corners[1] - corners[0]) * u + (corners[2] - corners[0]) * v;
            let across =
                bvh.first_hit(point - normal * start, -normal)
                    .and_then(|(hit, distance)| {
                        let seen = FacetId(hit as u32);
                        let far = point - normal * (start + distance);
                        let (a, b) = barycentric(&triangles[hit], far);
                        let other =
                            six_node::normal(&triangles[hit], &brep.facets[seen].mids, a, b);
                        (other.dot(normal) < -ANTIPARALLEL_COS)
                            .then_some((brep.facets[seen].face, distance + start))
                    });
            let extent = across.map_or_else(Extent::default, |(_, distance)| {
                extent(&boundary, point, -normal, distance)
            });
            Sighting {
                from: brep.facets[facet].face,
                point,
                inward: -normal,
                area,
                across,
                extent,
            }
        })
        .collect()
}

/// Sample points: facet, two barycentric parameters, area. Systematic along the running area of each face, so that every facet
/// gets its share; inside a facet by the R2 sequence (M. Roberts, 2018), which needs no random numbers.
fn samples(brep: &Brep) -> Vec<(FacetId, f64, f64, f64)> {
    let mut by_face: Vec<(FaceId, FacetId, f64)> = brep
        .facets
        .enumerated()
        .map(|(id, f)| (f.face, id, brep.area_vector(id).length()))
        .collect();
    by_face.sort_unstable_by_key(|&(face, facet, _)| (face, facet));
    let total: f64 = by_face.iter().map(|f| f.2).sum();
    let mut out = Vec::new();
    for run in by_face.chunk_by(|a, b| a.0 == b.0) {
        let area: f64 = run.iter().map(|f| f.2).sum();
        if area <= 0.0 {
            continue;
        }
        let count = (LEAST_SAMPLES + SHARED_SAMPLES * area / total).round();
        let step = area / count;
        let (mut passed, mut next, mut index) = (0.0, step / 2.0, 0.0f64);
        for &(_, facet, size) in run {
            passed += size;
            while next < passed {
                let (mut u, mut v) = (
                    (0.5 + index * 0.754_877_666_246_693).fract(),
                    (0.5 + index * 0.569_840_290_998_053_3).fract(),
                );
                if u + v > 1.0 {
                    (u, v) = (1.0 - u, 1.0 - v);
                }
                out.push((facet, u, v, step));
                next += step;
                index += 1.0;
            }
        }
    }
    out
}

fn barycentric([a, b, c]: &[DVec3; 3], p: DVec3) -> (f64, f64) {
    let (e, f, g) = (*b - *a, *c - *a, p - *a);
    let n = e.cross(f);
    let d = n.length_squared();
    if d == 0.0 {
        (1.0 / 3.0, 1.0 / 3.0)
    } else {
        (g.cross(f).dot(n) / d, e.cross(g).dot(n) / d)
    }
}
