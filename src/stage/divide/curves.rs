//! The curves of a boundary whose faces were divided.

use crate::model::brep::{Brep, Curve};
use crate::model::ids::{CurveId, FaceId, VertexId};
use std::collections::BTreeMap;

/// Gives every piece of a curve the faces that meet there now: a curve along several parts of a face becomes several with one number, and borders between two parts of one face
/// get numbers of their own.
pub(super) fn renew(brep: &mut Brep) {
    let mut old: Vec<([VertexId; 2], CurveId)> = Vec::new();
    for (id, curve) in brep.curves.enumerated() {
        old.extend(
            curve
                .segments
                .iter()
                .map(|&[a, b]| ([a.min(b), a.max(b)], id)),
        );
    }
    old.sort_unstable();
    let mut sides: Vec<([VertexId; 2], FaceId)> = Vec::with_capacity(3 * brep.facets.len());
    for facet in &brep.facets {
        for k in 0..3 {
            let (a, b) = (facet.corners[k], facet.corners[(k + 1) % 3]);
            sides.push(([a.min(b), a.max(b)], facet.face));
        }
    }
    sides.sort_unstable();
    // Old curves keep their order; new borders come last.
    let mut found: BTreeMap<(CurveId, Vec<FaceId>), Vec<[VertexId; 2]>> = BTreeMap::new();
    for run in sides.chunk_by(|a, b| a.0 == b.0) {
        let mut faces: Vec<FaceId> = run.iter().map(|s| s.1).collect();
        faces.dedup();
        let ends = run[0].0;
        let curve = match old.binary_search_by(|c| c.0.cmp(&ends)) {
            Ok(place) => old[place].1,
            Err(_) if faces.len() > 1 => CurveId(u32::MAX),
            Err(_) => continue,
        };
        found.entry((curve, faces)).or_default().push(ends);
    }
    let mut last = brep.curves.iter().map(|c| c.tag).max().unwrap_or(0);
    let renewed: Vec<Curve> = found
        .into_iter()
        .map(|((curve, faces), segments)| {
            let tag = brep.curves.get(curve).map_or_else(
                || {
                    last += 1;
                    last
                },
                |c| c.tag,
            );
            Curve {
                tag,
                faces,
                segments,
            }
        })
        .collect();
    for face in brep.faces.iter_mut() {
        face.curves.clear();
    }
    brep.curves = renewed.into_iter().collect();
    for (id, curve) in brep.curves.enumerated() {
        for &face in &curve.faces {
            brep.faces[face].curves.push(id);
        }
    }
}
