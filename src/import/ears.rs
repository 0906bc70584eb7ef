//! Facets that lie in the face beside their own.
//!
//! Where a face ends in a curve, gmsh may lay a facet of it between three points of that curve: an ear, which lies in the plane of the face beyond the curve, squarely to its own. What is
//! asked for its normal gets that of the wrong face. Such a facet is given to the face in which it lies, and the curve passes behind it. Between four points and more there are several
//! facets in a row, that go together.
//!
//! Guarantees: the facets stay as they are but for their face; every face keeps a facet.

use std::collections::BTreeMap;

use crate::model::brep::Brep;
use crate::model::ids::{CurveId, FaceId, FacetId, VertexId};
use glam::DVec3;

/// An ear lies in the face beyond within 10 degrees.
const IN_PLANE_COS: f64 = 0.985;
/// And is turned from its neighbour in its own face by more than 60 degrees: facets of a curve that has six to a circle or more turn less.
const TURNED_COS: f64 = 0.5;

type Side = [VertexId; 2];

/// Ears have few facets; what has more is a face in one plane with another.
const MOST: usize = 16;

/// Gives ears to the faces in which they lie; how many facets there were.
pub(super) fn hand_over(brep: &mut Brep) -> usize {
    let beside = Beside::new(brep);
    let mut found = 0;
    for id in brep.facets.ids() {
        if let Some((face, facets)) = ear(brep, &beside, id) {
            found += facets.len();
            for facet in facets {
                brep.facets[facet].face = face;
            }
        }
    }
    if found > 0 {
        pass_behind(brep, &beside);
    }
    found
}

/// The facets at every side, by side.
struct Beside(Vec<(Side, FacetId)>);

impl Beside {
    fn new(brep: &Brep) -> Self {
        let mut all: Vec<(Side, FacetId)> = (brep.facets.enumerated())
            .flat_map(|(id, facet)| sides(facet.corners).map(|side| (side, id)))
            .collect();
        all.sort_unstable();
        Self(all)
    }

    fn at(&self, side: Side) -> &[(Side, FacetId)] {
        let from = self.0.partition_point(|s| s.0 < side);
        let count = self.0[from..].partition_point(|s| s.0 == side);
        &self.0[from..from + count]
    }

    /// The facet beyond a side of a facet; `None` where there is not exactly one.
    fn beyond(&self, side: Side, facet: FacetId) -> Option<FacetId> {
        match *self.at(side) {
            [(_, f), (_, g)] => Some(if f == facet { g } else { f }),
            _ => None,
        }
    }

    /// The faces that meet at a side.
    fn faces(&self, brep: &Brep, side: Side) -> Vec<FaceId> {
        let mut faces: Vec<FaceId> = (self.at(side).iter())
            .map(|&(_, f)| brep.facets[f].face)
            .collect();
        faces.sort_unstable();
        faces.dedup();
        faces
    }
}

fn sides(c: [VertexId; 3]) -> [Side; 3] {
    [[c[0], c[1]], [c[1], c[2]], [c[2], c[0]]].map(|[a, b]| [a.min(b), a.max(b)])
}

fn flat_normal(brep: &Brep, facet: FacetId) -> DVec3 {
    brep.area_vector(facet).normalize_or_zero()
}

/// The face that an ear lies in, and all facets of the ear; `None` where the facet is part of none.
fn ear(brep: &Brep, beside: &Beside, id: FacetId) -> Option<(FaceId, Vec<FacetId>)> {
    let own = brep.facets[id].face;
    let normal = flat_normal(brep, id);
    let mut ear = vec![id];
    let mut lies_in: Option<FaceId> = None;
    let mut hanging = 0;
    let mut at = 0;
    while let Some(&facet) = ear.get(at) {
        at += 1;
        for side in sides(brep.facets[facet].corners) {
            let neighbour = beside.beyond(side, facet)?;
            let face = brep.facets[neighbour].face;
            let cosine = flat_normal(brep, neighbour).dot(normal);
            if face != own {
                // All around it lies one face, in its plane.
                if cosine <= IN_PLANE_COS || *lies_in.get_or_insert(face) != face {
                    return None;
                }
            } else if cosine > IN_PLANE_COS {
                if !ear.contains(&neighbour) {
                    ear.push(neighbour);
                }
            } else if cosine < TURNED_COS {
                hanging += 1;
            } else {
                return None;
            }
        }
        if ear.len() > MOST {
            return None;
        }
    }
    // On its own face it hangs by one side, the chord; more of them would be corners of that face.
    lies_in.filter(|_| hanging == 1).map(|face| (face, ear))
}

/// Leads the curves along the sides that lie between two faces now.
fn pass_behind(brep: &mut Brep, beside: &Beside) {
    let mut known: Vec<Side> = Vec::new();
    let mut curve_of: BTreeMap<Vec<FaceId>, CurveId> = BTreeMap::new();
    for (id, curve) in brep.curves.enumerated() {
        known.extend(curve.segments.iter().map(|&[a, b]| [a.min(b), a.max(b)]));
        let mut between = curve.faces.clone();
        between.sort_unstable();
        curve_of.entry(between).or_insert(id);
    }
    known.sort_unstable();
    let fresh: Vec<(CurveId, Side)> = (beside.0)
        .chunk_by(|a, b| a.0 == b.0)
        .map(|run| run[0].0)
        .filter(|side| known.binary_search(side).is_err())
        .filter_map(|side| {
            let between = beside.faces(brep, side);
            let curve = curve_of.get(&between)?;
            (between.len() > 1).then_some((*curve, side))
        })
        .collect();
    let stay: Vec<Vec<Side>> = (brep.curves.iter())
        .map(|curve| {
            let seam = curve.faces.len() < 2;
            let kept =
                |[a, b]: &&Side| seam || beside.faces(brep, [*a.min(b), *a.max(b)]).len() > 1;
            curve.segments.iter().filter(kept).copied().collect()
        })
        .collect();
    for (curve, segments) in brep.curves.iter_mut().zip(stay) {
        curve.segments = segments;
    }
    for (curve, side) in fresh {
        brep.curves[curve].segments.push(side);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::model::brep::{Curve, Face};
    use crate::test_parts::brep;

    /// A box 4 x 4 x 2 whose top is cut in three by points on its front edge, which lies in the plane of the front: the middle part of the top edge sags to z = 1, and the facet over the sag
    /// belongs to the top.
    fn sagging() -> Brep {
        let points = [
            (0.0, 0.0, 0.0),
            (4.0, 0.0, 0.0),
            (4.0, 4.0, 0.0),
            (0.0, 4.0, 0.0),
            (0.0, 0.0, 2.0),
            (4.0, 0.0, 2.0),
            (4.0, 4.0, 2.0),
            (0.0, 4.0, 2.0),
            (2.0, 0.0, 1.0),
        ]
        .map(|(x, y, z)| DVec3::new(x, y, z));
        let polygons = [
            (vec![0, 3, 2, 1], 0),
            (vec![4, 5, 6, 7], 1),
            // The ear, in the plane y = 0.
            (vec![4, 8, 5], 1),
            (vec![0, 1, 8], 2),
            (vec![0, 8, 4], 2),
            (vec![1, 5, 8], 2),
            (vec![1, 2, 6, 5], 3),
            (vec![2, 3, 7, 6], 4),
            (vec![3, 0, 4, 7], 5),
        ];
        let mut solid = brep(points.to_vec(), &polygons, |a, b| (a + b) / 2.0);
        let id = solid.curves.push(Curve {
            tag: 1,
            faces: vec![FaceId(1), FaceId(2)],
            segments: vec![[VertexId(4), VertexId(8)], [VertexId(8), VertexId(5)]],
        });
        for face in [1, 2] {
            let face: &mut Face = &mut solid.faces[FaceId(face)];
            face.curves.push(id);
        }
        solid
    }

    #[test]
    fn an_ear_goes_to_the_face_it_lies_in_and_the_curve_passes_behind_it() {
        let mut solid = sagging();
        assert_eq!(hand_over(&mut solid), 1);
        let ear = solid.facets.iter().find(|f| {
            let mut corners = f.corners.map(|v| v.0);
            corners.sort_unstable();
            corners == [4, 5, 8]
        });
        assert_eq!(ear.map(|f| f.face), Some(FaceId(2)));
        assert_eq!(
            solid.curves[CurveId(0)].segments,
            [[VertexId(4), VertexId(5)]]
        );
        assert_eq!(solid.check(), vec![]);
        // Nothing is left to hand over.
        assert_eq!(hand_over(&mut solid), 0);
    }

    #[test]
    fn facets_in_a_row_go_together() {
        // The sag has two more points: three facets in the plane of the front.
        let mut points: Vec<DVec3> = sagging().vertices.iter().copied().collect();
        points.push(DVec3::new(1.0, 0.0, 1.3));
        points.push(DVec3::new(3.0, 0.0, 1.3));
        let polygons = [
            (vec![0, 3, 2, 1], 0),
            (vec![4, 5, 6, 7], 1),
            (vec![4, 8, 5], 1),
            (vec![4, 9, 8], 1),
            (vec![8, 10, 5], 1),
            (vec![0, 1, 8], 2),
            (vec![0, 8, 9], 2),
            (vec![0, 9, 4], 2),
            (vec![1, 10, 8], 2),
            (vec![1, 5, 10], 2),
            (vec![1, 2, 6, 5], 3),
            (vec![2, 3, 7, 6], 4),
            (vec![3, 0, 4, 7], 5),
        ];
        let mut solid = brep(points, &polygons, |a, b| (a + b) / 2.0);
        let along = [4, 9, 8, 10, 5].map(VertexId);
        let id = solid.curves.push(Curve {
            tag: 1,
            faces: vec![FaceId(1), FaceId(2)],
            segments: along.windows(2).map(|w| [w[0], w[1]]).collect(),
        });
        for face in [1, 2] {
            solid.faces[FaceId(face)].curves.push(id);
        }
        assert_eq!(hand_over(&mut solid), 3);
        let segments = &solid.curves[CurveId(0)].segments;
        assert_eq!(*segments, [[VertexId(4), VertexId(5)]]);
        assert_eq!(solid.check(), vec![]);
    }

    #[test]
    fn two_faces_of_one_plane_keep_their_facets() {
        // The front of the box above, cut in two faces by the line to its sag.
        let mut solid = sagging();
        let facets: Vec<FacetId> = (solid.facets.enumerated())
            .filter(|(_, f)| f.face == FaceId(2) && f.corners.contains(&VertexId(4)))
            .map(|(id, _)| id)
            .collect();
        let fresh = solid.faces.push(Face {
            tag: 9,
            ..Face::default()
        });
        for id in facets {
            solid.facets[id].face = fresh;
        }
        let beside = Beside::new(&solid);
        let flat: Vec<FacetId> = (solid.facets.enumerated())
            .filter(|(_, f)| f.face == fresh || f.face == FaceId(2))
            .map(|(id, _)| id)
            .collect();
        assert!(flat.len() > 2);
        assert!(flat.iter().all(|id| ear(&solid, &beside, *id).is_none()));
    }

    #[test]
    fn a_facet_in_the_plane_of_its_own_face_is_no_ear() {
        let mut solid = crate::test_parts::box_brep(DVec3::new(4.0, 4.0, 2.0));
        let before = solid.clone();
        assert_eq!(hand_over(&mut solid), 0);
        assert_eq!(solid, before);
    }
}
