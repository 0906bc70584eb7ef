//! Edges where the two sides of one wall meet: the trailing edge of a blade, the crest of a full rounding.
//!
//! There the wall ends without a lateral face between its sides, and its rim lies on the edge.

use crate::model::brep::Brep;
use crate::model::ids::{FaceId, WallId};
use crate::model::walls::{Aag, Pairing};
use crate::spatial::TriangleBvh;
use glam::DVec3;

/// Sides that turn round by more than this, rad, are both too near to the middle for a node to be placed on that and one of them.
const SLIM_RAD: f64 = 5.0 / 6.0 * std::f64::consts::PI;

/// A place on such an edge.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct End {
    /// A face that the rim may be said to lie on; none at a slim edge.
    pub face: Option<FaceId>,
    /// Where.
    pub point: DVec3,
}

/// The segments of all such edges.
pub(super) struct MeetingEdges {
    bvh: TriangleBvh,
    /// Of each segment the wall, and a face beside it unless it is slim.
    of: Vec<(WallId, Option<FaceId>)>,
}

impl MeetingEdges {
    /// Finds them. Cost: linear in arcs and walls of their faces.
    pub fn new(brep: &Brep, aag: &Aag, pairing: &Pairing) -> Self {
        let (mut segments, mut of) = (Vec::new(), Vec::new());
        for (w, wall) in pairing.walls.enumerated() {
            let on = |side: usize, f: FaceId| wall.sides[side].binary_search(&f).is_ok();
            let arcs = wall.sides[0]
                .iter()
                .flat_map(|&f| aag.arcs_of(f).map(move |a| (f, a)));
            for (f, arc) in arcs {
                let g = Aag::across(arc, f);
                if !on(1, g) || on(0, g) || on(1, f) {
                    continue;
                }
                let Some(curve) = brep.curves.get(arc.curve) else {
                    continue;
                };
                for ends in &curve.segments {
                    let [a, b] = ends.map(|v| brep.vertices[v]);
                    segments.push([a, b, b]);
                    of.push((w, (arc.turn_rad < SLIM_RAD).then_some(f)));
                }
            }
        }
        Self {
            bvh: TriangleBvh::new(&segments),
            of,
        }
    }

    /// The nearest point of the edges of a wall within `radius`.
    pub fn nearest(&self, p: DVec3, wall: WallId, radius: f64) -> Option<End> {
        if self.of.is_empty() {
            return None;
        }
        let near = (self.bvh).nearest_where(p, radius, |i| self.of[i].0 == wall)?;
        Some(End {
            face: self.of[near.index].1,
            point: near.point,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::model::brep::Curve;
    use crate::model::ids::{FaceId, VertexId};
    use crate::model::walls::Wall;
    use crate::stage::adjacency::adjacency;
    use crate::test_parts::brep;

    /// A wedge along y: its flat side z = 0 (face 0) and its slope (face 1) meet at x = 0; the faces of each edge are curves of their own.
    fn wedge() -> (Brep, Pairing) {
        let points = [0.0, 8.0]
            .into_iter()
            .flat_map(|y| [(0.0, 0.0), (20.0, 0.0), (20.0, 3.0)].map(|(x, z)| DVec3::new(x, y, z)))
            .collect();
        let polygons = [
            (vec![0, 3, 4, 1], 0),
            (vec![0, 2, 5, 3], 1),
            (vec![1, 4, 5, 2], 2),
            (vec![0, 1, 2], 3),
            (vec![3, 5, 4], 4),
        ];
        let mut solid = brep(points, &polygons, |a, b| (a + b) / 2.0);
        for ends in [[0, 3], [1, 4], [2, 5]] {
            solid.curves.push(Curve {
                segments: vec![ends.map(VertexId)],
                ..Curve::default()
            });
        }
        let mut pairing = Pairing::default();
        pairing.walls.push(Wall {
            sides: [vec![FaceId(0)], vec![FaceId(1)]],
            thickness: 1.5,
            group: 0,
        });
        (solid, pairing)
    }

    #[test]
    fn a_wedge_ends_at_the_edge_of_its_sides_and_nowhere_else() {
        let (solid, pairing) = wedge();
        let edges = MeetingEdges::new(&solid, &adjacency(&solid), &pairing);
        let near = edges.nearest(DVec3::new(1.0, 4.0, 0.1), WallId(0), 2.0);
        // Nine degrees between the sides: no face stands for the edge.
        let point = DVec3::new(0.0, 4.0, 0.0);
        assert_eq!(near, Some(End { face: None, point }));
        assert_eq!(
            edges.nearest(DVec3::new(19.0, 4.0, 1.5), WallId(0), 2.0),
            None
        );
    }
}
