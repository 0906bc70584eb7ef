//! Places that lie outside the material.
//!
//! ```text
//!        | | |___________
//!        | | | ledge     \           The tube ends at the ledge, its mid-surface carried on (t) meets that of the plate (p) in the empty pocket below.
//!        |_|_|    ___     \
//!          :     |   \_____\____     What joins the two runs through the block beside the pocket: there the supports say nothing.
//!          t p p p p p p p p p p
//! ```
//! Beyond the ends of its sides a wall is carried on as if they went on. Over a block of material that is right up to where other walls are met, over a pocket it is not.
//!
//! A place beyond both ends of every wall that it lies on is looked at: it must be in the material.

use super::Medial;
use crate::model::brep::Brep;
use crate::model::complex::Support;
use crate::spatial::TriangleBvh;
use glam::DVec3;

/// Places up to this far outside, and beyond the end of a side by no more, are as good as inside, in thicknesses: far above the sag of flat facets.
pub(super) const NEAR: f64 = 0.1;

/// Where the material is.
#[derive(Clone, Debug, Default)]
pub(super) struct Material {
    boundary: TriangleBvh,
}

impl Material {
    pub(super) fn new(brep: &Brep) -> Self {
        let corners: Vec<[DVec3; 3]> = brep.facets.ids().map(|f| brep.corners(f)).collect();
        Self {
            boundary: TriangleBvh::new(&corners),
        }
    }

    /// The place itself, or, where that lies outside by more than `slack`, the nearest one that is as far inside.
    fn held(&self, p: DVec3, slack: f64) -> Option<DVec3> {
        if self.boundary.nearest_within(p, slack).is_some() || self.boundary.inside(p) {
            return None;
        }
        let near = self.boundary.nearest(p)?;
        Some(near.point + (near.point - p) * (slack / near.distance))
    }
}

impl Medial<'_> {
    /// `p`, unless walls carried on beyond their ends meet there outside the material: then `start`, or what is in the material next to it. Rims are
    /// left alone: their faces end the walls.
    pub(super) fn in_material(&self, start: DVec3, p: DVec3, supports: &[Support]) -> DVec3 {
        let mut slack = 0.0f64;
        for support in supports {
            let &Support::Mid(wall) = support else {
                return p;
            };
            let near = NEAR * self.thickness[wall];
            slack = slack.max(near);
            let over = self.sides[wall].iter().any(|side| match side.plane {
                Some(plane) => {
                    let below = p + plane.normal * plane.depth(p);
                    side.bvh.any_within(below, near).is_some()
                }
                None => (self.foot(side, p, &mut None)).is_some_and(|f| f.beyond(p) <= near),
            });
            if over {
                return p;
            }
        }
        match self.material.held(p, slack) {
            None => p,
            Some(_) => self.material.held(start, slack).unwrap_or(start),
        }
    }
}
