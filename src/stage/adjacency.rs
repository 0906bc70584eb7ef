//! Adjacency: the attributed adjacency graph (AAG) of a solid's faces.
//!
//! An arc a curve and pair of different faces. The angle is taken between the normals of the six-node facets at the middle of each
//! segment, because flat facets on a fillet would show a tangent joint as a corner of several degrees.
//!
//! Reference: S. Joshi, T. C. Chang, Graph-based heuristics for recognition of machined features, CAD 20 (1988),
//! doi:10.1016/0010-4485(88)90050-4.

use crate::geom::six_node;
use crate::model::brep::Brep;
use crate::model::ids::{CurveId, FaceId, FacetId, IndexVec, VertexId};
use crate::model::walls::{Aag, Arc, Convexity};

/// Faces that meet at less than this are tangent for every purpose here: CAD systems keep tangency to well under a degree, the
/// six-node facets to two or three on the coarsest fillets.
pub const SMOOTH_RAD: f64 = 12.0 * std::f64::consts::PI / 180.0;

/// Reads the adjacency graph off the facets. Cost: one sort of the facets' sides.
pub fn adjacency(brep: &Brep) -> Aag {
    let mut sides: Vec<(VertexId, VertexId, FacetId, usize)> =
        Vec::with_capacity(brep.facets.len() * 3);
    for (id, f) in brep.facets.enumerated() {
        for k in 0..3 {
            let (a, b) = (f.corners[k], f.corners[(k + 1) % 3]);
            sides.push((a.min(b), a.max(b), id, k));
        }
    }
    sides.sort_unstable();

    let mut curve_of: Vec<(VertexId, VertexId, CurveId)> = Vec::new();
    for (id, curve) in brep.curves.enumerated() {
        curve_of.extend(
            curve
                .segments
                .iter()
                .map(|&[a, b]| (a.min(b), a.max(b), id)),
        );
    }
    curve_of.sort_unstable();

    // (faces, curve, length, turn x length) a segment
    let mut pieces: Vec<([FaceId; 2], CurveId, f64, f64)> = Vec::new();
    let mut perimeter = IndexVec::filled(0.0, brep.faces.len());
    for run in sides.chunk_by(|a, b| (a.0, a.1) == (b.0, b.1)) {
        let &[first, second] = run else { continue };
        let (f, g) = (brep.facets[first.2].face, brep.facets[second.2].face);
        if f == g {
            continue;
        }
        let at = curve_of.partition_point(|c| (c.0, c.1) < (first.0, first.1));
        let curve = curve_of
            .get(at)
            .filter(|c| (c.0, c.1) == (first.0, first.1))
            .map_or(CurveId(u32::MAX), |c| c.2);
        let length = (brep.vertices[first.0] - brep.vertices[first.1]).length();
        perimeter[f] += length;
        perimeter[g] += length;
        pieces.push((
            [f.min(g), f.max(g)],
            curve,
            length,
            length * six_node::turn(brep, (first.2, first.3), (second.2, second.3)),
        ));
    }
    pieces.sort_by_key(|p| (p.0, p.1));

    let mut arcs = Vec::new();
    for run in pieces.chunk_by(|a, b| (a.0, a.1) == (b.0, b.1)) {
        let length: f64 = run.iter().map(|p| p.2).sum();
        let turn_rad = run.iter().map(|p| p.3).sum::<f64>() / length.max(f64::MIN_POSITIVE);
        let convexity = if turn_rad.abs() < SMOOTH_RAD {
            Convexity::Smooth
        } else if turn_rad > 0.0 {
            Convexity::Convex
        } else {
            Convexity::Concave
        };
        arcs.push(Arc {
            faces: run[0].0,
            curve: run[0].1,
            length,
            turn_rad,
            convexity,
        });
    }
    let mut of_face = IndexVec::filled(Vec::new(), brep.faces.len());
    for (i, arc) in arcs.iter().enumerate() {
        for f in arc.faces {
            of_face[f].push(i as u32);
        }
    }
    let mut area = IndexVec::filled(0.0, brep.faces.len());
    for (id, f) in brep.facets.enumerated() {
        area[f.face] += brep.area_vector(id).length();
    }
    Aag {
        arcs,
        of_face,
        area,
        perimeter,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::model::brep::{Curve, Face, Facet};
    use glam::DVec3;

    /// Two squares that meet along the y axis; the second turned down by `down` (rad).
    fn fold(down: f64) -> Brep {
        let v = [
            DVec3::new(-1.0, 0.0, 0.0),
            DVec3::ZERO,
            DVec3::Y,
            DVec3::new(-1.0, 1.0, 0.0),
            DVec3::new(down.cos(), 0.0, -down.sin()),
            DVec3::new(down.cos(), 1.0, -down.sin()),
        ];
        let facet = |c: [u32; 3], face| {
            let p = c.map(|i| v[i as usize]);
            Facet {
                corners: c.map(VertexId),
                mids: [
                    (p[0] + p[1]) / 2.0,
                    (p[1] + p[2]) / 2.0,
                    (p[2] + p[0]) / 2.0,
                ],
                face: FaceId(face),
            }
        };
        Brep {
            vertices: v.to_vec().into(),
            facets: vec![
                facet([0, 1, 2], 0),
                facet([0, 2, 3], 0),
                facet([1, 4, 5], 1),
                facet([1, 5, 2], 1),
            ]
            .into(),
            faces: vec![Face::default(), Face::default()].into(),
            curves: vec![Curve {
                tag: 9,
                faces: vec![FaceId(0), FaceId(1)],
                segments: vec![[VertexId(1), VertexId(2)]],
            }]
            .into(),
            ..Brep::default()
        }
    }

    #[test]
    fn the_turn_of_a_fold_is_its_angle_with_the_right_sign() {
        for (down, kind) in [
            (1.0, Convexity::Convex),
            (-1.0, Convexity::Concave),
            (0.05, Convexity::Smooth),
        ] {
            let aag = adjacency(&fold(down));
            assert_eq!(aag.arcs.len(), 1);
            assert!((aag.arcs[0].turn_rad - down).abs() < 1e-12);
            assert_eq!(aag.arcs[0].convexity, kind);
            assert!(
                (aag.area[FaceId(0)] - 1.0).abs() < 1e-12
                    && (aag.perimeter[FaceId(1)] - 1.0).abs() < 1e-12
            );
        }
    }
}
