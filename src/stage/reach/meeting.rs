//! Edges where the two sides of one wall meet: the trailing edge of a blade, the crest of a full rounding.
//!
//! There the wall ends without a lateral face between its sides, and its rim lies on the edge.

use crate::model::brep::Brep;
use crate::model::complex::Support;
use crate::model::ids::{FaceId, WallId};
use crate::model::walls::{Aag, Pairing};
use crate::spatial::TriangleBvh;
use glam::DVec3;

/// Where sides turn round by more than this, rad, both are too near to the middle for a node to be placed on that and one of them: it takes the edge itself.
/// Else one of the sides is the better support: it bends with the solid, and the edge is made of chords.
const SLIM_RAD: f64 = 5.0 / 6.0 * std::f64::consts::PI;

/// The segments of all such edges.
pub(super) struct MeetingEdges {
    bvh: TriangleBvh,
    /// Of each segment the wall, and what a rim there lies on.
    of: Vec<(WallId, Support)>,
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
                    let slim = arc.turn_rad >= SLIM_RAD;
                    let end = if slim {
                        Support::Edge(arc.curve)
                    } else {
                        Support::Face(f)
                    };
                    of.push((w, end));
                }
            }
        }
        Self {
            bvh: TriangleBvh::new(&segments),
            of,
        }
    }

    /// The nearest point of the edges of a wall within `radius`, and what a rim there lies on.
    pub fn nearest(&self, p: DVec3, wall: WallId, radius: f64) -> Option<(Support, DVec3)> {
        if self.of.is_empty() {
            return None;
        }
        let near = (self.bvh).nearest_where(p, radius, |i| self.of[i].0 == wall)?;
        Some((self.of[near.index].1, near.point))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::model::ids::CurveId;
    use crate::model::walls::Wall;
    use crate::stage::adjacency::adjacency;
    use crate::test_parts::slim_wedge;

    fn wedge() -> (Brep, Pairing) {
        let mut pairing = Pairing::default();
        pairing.walls.push(Wall {
            sides: [vec![FaceId(0)], vec![FaceId(1)]],
            thickness: 1.5,
            group: 0,
        });
        (slim_wedge(), pairing)
    }

    #[test]
    fn a_wedge_ends_at_the_edge_of_its_sides_and_nowhere_else() {
        let (solid, pairing) = wedge();
        let edges = MeetingEdges::new(&solid, &adjacency(&solid), &pairing);
        let near = edges.nearest(DVec3::new(1.0, 4.0, 0.1), WallId(0), 2.0);
        assert_eq!(
            near,
            Some((Support::Edge(CurveId(0)), DVec3::new(0.0, 4.0, 0.0)))
        );
        assert_eq!(
            edges.nearest(DVec3::new(19.0, 4.0, 1.5), WallId(0), 2.0),
            None
        );
    }
}
