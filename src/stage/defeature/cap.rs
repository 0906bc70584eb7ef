//! Closes a loop of a side with facets that carry the side on.
//!
//! The cap has no vertices of its own. Between the vertices of the loop its sides are bent as the normals of the surface round the loop say (A. Vlachos, J. Peters, C. Boyd,
//! J. L. Mitchell, Curved PN triangles, I3D 2001, doi:10.1145/364338.364387), scaled such that planes, tubes and spheres are carried on as what they are.

use super::boundary::{Loop, Skin};
use crate::geom::cdt::triangulate_region;
use crate::model::brep::Facet;
use crate::model::ids::{FaceId, VertexId};
use glam::{DVec2, DVec3};
use std::collections::BTreeSet;

/// Surfaces that turn by more than this (cosine of half the turn) from rim to rim are no longer scaled to a circle: 60 degrees, far more than a hole in a wall has.
const LEAST_COSINE: f64 = 0.5;

/// The facets that close a loop, of the face that they carry on; none where the loop crosses itself seen along the surface's normal. The two sides of a slit close by themselves.
pub(super) fn cap(
    skin: &Skin<'_>,
    of: &Loop,
    set: &BTreeSet<FaceId>,
    face: FaceId,
) -> Option<Vec<Facet>> {
    if of.sides.len() < 3 {
        return Some(Vec::new());
    }
    let normals = skin.normals(of, set)?;
    let up = normals.iter().sum::<DVec3>().try_normalize()?;
    let (x, y) = up.any_orthonormal_pair();
    let middle = skin.middle(of);
    let corners: Vec<VertexId> = of.sides.iter().map(|s| s.from).collect();
    let place = |i: u32| skin.brep.vertices[corners[i as usize]];
    let count = corners.len() as u32;
    let flat: Vec<DVec2> = (0..count)
        .map(|i| {
            let d = place(i) - middle;
            DVec2::new(d.dot(x), d.dot(y))
        })
        .collect();
    let next = |i: u32| (i + 1) % count;
    let doubled: f64 = (0..count)
        .map(|i| flat[i as usize].perp_dot(flat[next(i) as usize]))
        .sum();
    if doubled <= 0.0 {
        return None;
    }
    let rim: Vec<[u32; 2]> = (0..count).map(|i| [i, next(i)]).collect();
    let names: Vec<u32> = (0..count).collect();
    let triangles = triangulate_region(&flat, &names, &rim, &[]).ok()?;
    let mid = |i: u32, j: u32| {
        if j == next(i) {
            of.sides[i as usize].mid
        } else {
            let ends = [place(i), place(j)];
            bent_middle(ends, [normals[i as usize], normals[j as usize]])
        }
    };
    let facet = |[a, b, c]: [u32; 3]| Facet {
        corners: [a, b, c].map(|i| corners[i as usize]),
        mids: [mid(a, b), mid(b, c), mid(c, a)],
        face,
    };
    Some(triangles.into_iter().map(facet).collect())
}

/// Middle of a curve between two points that stands on the normals there: of the cubic with these tangents, scaled by what this lacks on a circle.
pub(super) fn bent_middle([a, b]: [DVec3; 2], [n, m]: [DVec3; 2]) -> DVec3 {
    let way = b - a;
    // Of half the angle between the normals; a half turn has no middle.
    let cosine = ((n + m).length() / 2.0).max(LEAST_COSINE);
    let scale = 2.0 / ((1.0 + cosine) * cosine);
    (a + b) / 2.0 - (n * way.dot(n) - m * way.dot(m)) / 8.0 * scale
}
