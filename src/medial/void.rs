//! Places that lie outside the material.
//!
//! ```text
//!       |   |
//!       | : |                        The wall (:) ends at the ledge over a pocket. Carried on, its mid-surface meets that of the plate (-) in the pocket, at x.
//!       | : |_______
//!       |_:_|  _    |                What joins the two runs through the block beside the pocket. There the supports say nothing: a node stays where it
//!     ledge |   `.  |_______         was, in the material, or is put back into that from the pocket.
//!           |     `.- - - -
//!         x |______________
//! ```
//! Beyond the ends of its sides a wall is carried on as if they went on. Through the block where walls join that is right, over a pocket it is not.
//!
//! Guarantees: a place over a side of any of its walls, or on a face, is not looked at; any other is in the material, or outside by less than a tenth of a
//! thickness. Limits: how deep in the material a node lies there is no one's word; triangles between two such nodes may bridge a corner of the pocket.
//! Cost: a nearest-point query and a ray a place beyond the ends of all of its walls.

use super::{Medial, Surface};
use crate::model::brep::Brep;
use crate::model::complex::Support;
use crate::spatial::TriangleBvh;
use glam::DVec3;

/// Places up to this far outside, and beyond the end of a side by no more, are as good as inside, in thicknesses: far above the sag of flat facets.
pub(super) const NEAR: f64 = 0.1;

/// Where the material is.
#[derive(Clone, Debug, Default)]
pub(super) struct Material {
    /// All facets of the solid.
    pub(super) skin: Surface,
}

impl Material {
    pub(super) fn new(brep: &Brep) -> Self {
        let corners: Vec<[DVec3; 3]> = brep.facets.ids().map(|f| brep.corners(f)).collect();
        Self {
            skin: Surface {
                bvh: TriangleBvh::new(&corners),
                facets: brep.facets.ids().collect(),
                faces: brep.faces.ids().collect(),
                ..Surface::default()
            },
        }
    }

    /// For a place outside by more than `slack`: the nearest one that is as far inside.
    fn held(&self, p: DVec3, slack: f64) -> Option<DVec3> {
        let boundary = &self.skin.bvh;
        if boundary.any_within(p, slack).is_some() || boundary.inside(p) {
            return None;
        }
        let near = boundary.nearest(p)?;
        Some(near.point + (near.point - p) * (slack / near.distance))
    }
}

impl Medial<'_> {
    /// `p`, unless it lies outside the material beyond the ends of all walls in question: then `start`, or what is in the material next to that.
    /// `sure`: it need not be looked at.
    pub(super) fn held(&self, start: DVec3, p: DVec3, sure: bool, supports: &[Support]) -> DVec3 {
        if sure || supports.is_empty() {
            return p;
        }
        let mut slack = 0.0f64;
        for support in supports {
            let &Support::Mid(wall) = support else {
                return p;
            };
            let near = NEAR * self.thickness[wall];
            slack = slack.max(near);
            let over = (0..2).any(|k| match self.sides[wall][k] {
                Surface {
                    plane: Some(plane),
                    ref bvh,
                    ..
                } => {
                    let below = p + plane.normal * plane.depth(p);
                    bvh.any_within(below, near).is_some()
                }
                _ => (self.side_foot(wall, k, p, &mut None)).is_some_and(|f| f.beyond(p) <= near),
            });
            if over {
                return p;
            }
        }
        match self.ground.material.held(p, slack) {
            None => p,
            Some(_) => self.ground.material.held(start, slack).unwrap_or(start),
        }
    }
}

#[cfg(test)]
mod tests {
    use crate::geom::placer::Placer;
    use crate::medial::Medial;
    use crate::model::complex::Support;
    use crate::model::ids::{FaceId, WallId};
    use crate::model::walls::{Pairing, Wall};
    use crate::stage::adjacency::adjacency;
    use crate::test_parts::voxels::{filled, lines};
    use glam::DVec3;

    /// Where nodes of a wall two thick, of a plate two thick, and of both lie; `pocket`: the block beside the pocket fills it as well.
    fn place(start: DVec3, on: &[u32], pocket: bool) -> DVec3 {
        let grid = [
            lines(&[(10.0, 2), (12.0, 1), (16.0, 2), (40.0, 6)]),
            lines(&[(24.0, 6)]),
            lines(&[(2.0, 1), (3.0, 1), (5.0, 1), (14.0, 3)]),
        ];
        let solid = filled(grid, |p| {
            let wall = (10.0..12.0).contains(&p.x) && (p.z > 3.0 || !pocket);
            let block = (12.0..16.0).contains(&p.x) && p.z < 5.0;
            wall || block || (p.x > 16.0 && p.z < 2.0)
        });
        let face = |on: &dyn Fn(DVec3) -> bool| vec![solid.face(on)];
        let wall = |sides: [Vec<FaceId>; 2]| Wall {
            sides,
            thickness: 2.0,
            group: 0,
        };
        let mut pairing = Pairing::default();
        (pairing.walls).push(wall([
            face(&|p| p.x == 10.0),
            face(&|p| p.x == 12.0 && p.z >= 5.0),
        ]));
        (pairing.walls).push(wall([face(&|p| p.z == 0.0), face(&|p| p.z == 2.0)]));
        pairing.side = crate::model::ids::IndexVec::filled(None, solid.brep.faces.len());
        let aag = adjacency(&solid.brep);
        let medial = Medial::new(&solid.brep, &aag, &pairing);
        let supports: Vec<Support> = on.iter().map(|&w| Support::Mid(WallId(w))).collect();
        medial.place(start, &supports)
    }

    #[test]
    fn walls_that_meet_in_a_pocket_leave_a_node_in_the_block_beside_it() {
        let start = DVec3::new(13.0, 12.0, 1.5);
        assert_eq!(place(start, &[0, 1], true), start);
        assert_eq!(place(start, &[0], true), start);
        // With the pocket filled they meet in the material.
        let met = place(start, &[0, 1], false);
        assert!(met.distance(DVec3::new(11.0, 12.0, 1.0)) < 1e-12, "{met}");
    }

    #[test]
    fn a_node_in_the_pocket_is_put_a_tenth_of_a_thickness_into_the_block() {
        let held = place(DVec3::new(11.5, 12.0, 1.5), &[0, 1], true);
        assert!(held.distance(DVec3::new(12.2, 12.0, 1.5)) < 1e-12, "{held}");
    }

    #[test]
    fn over_a_side_a_node_lies_in_the_middle() {
        let wall = place(DVec3::new(11.5, 12.0, 8.0), &[0], true);
        assert!(wall.distance(DVec3::new(11.0, 12.0, 8.0)) < 1e-12, "{wall}");
        let plate = place(DVec3::new(13.0, 12.0, 0.5), &[1], true);
        assert!(
            plate.distance(DVec3::new(13.0, 12.0, 1.0)) < 1e-12,
            "{plate}"
        );
    }
}
