//! Curves of the solid as places for rims: where the two sides of a wall meet, no lateral face parts them, and the rim lies on their edge.

use crate::model::brep::Brep;
use crate::model::ids::{CurveId, WallId};
use crate::spatial::TriangleBvh;
use glam::DVec3;

/// The straight pieces of all curves.
#[derive(Clone, Debug, Default)]
pub(super) struct Edges {
    bvh: TriangleBvh,
    of: Vec<(CurveId, DVec3)>,
}

/// The nearest place of a curve: the way there, and the direction of the curve.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct OnEdge {
    way: DVec3,
    along: DVec3,
}

impl Edges {
    /// Of every curve that two faces or a seam make.
    pub fn new(brep: &Brep) -> Self {
        let (mut segments, mut of) = (Vec::new(), Vec::new());
        for (id, curve) in brep.curves.enumerated() {
            for ends in &curve.segments {
                let [a, b] = ends.map(|v| brep.vertices[v]);
                segments.push([a, b, b]);
                of.push((id, (b - a).normalize_or_zero()));
            }
        }
        Self {
            bvh: TriangleBvh::new(&segments),
            of,
        }
    }

    /// The nearest place of a curve, if the solid has it.
    pub fn nearest(&self, p: DVec3, curve: CurveId) -> Option<OnEdge> {
        let near = (self.bvh).nearest_where(p, f64::INFINITY, |i| self.of[i].0 == curve)?;
        Some(OnEdge {
            way: near.point - p,
            along: self.of[near.index].1,
        })
    }
}

impl OnEdge {
    /// The plane through the curve that stands on the mid-surface of the first wall, as unit normal and how far away it is: with that mid-surface it makes
    /// the curve, however slim the edge is. Where no wall has a say, the way to the curve itself.
    pub fn across(&self, mids: &[(WallId, DVec3, f64)]) -> (DVec3, f64) {
        let standing = mids
            .first()
            .and_then(|(_, normal, _)| self.along.cross(*normal).try_normalize());
        let normal = standing.unwrap_or_else(|| self.way.normalize_or_zero());
        (normal, self.way.dot(normal))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::model::brep::Curve;
    use crate::model::ids::VertexId;

    fn one_edge() -> Edges {
        let mut brep = Brep {
            vertices: vec![DVec3::ZERO, 10.0 * DVec3::Y].into(),
            ..Brep::default()
        };
        brep.curves.push(Curve {
            segments: vec![[VertexId(0), VertexId(1)]],
            ..Curve::default()
        });
        Edges::new(&brep)
    }

    #[test]
    fn the_plane_stands_on_the_mid_surface_and_holds_the_curve() {
        let p = DVec3::new(2.0, 4.0, 0.3);
        let near = one_edge().nearest(p, CurveId(0)).unwrap();
        let (normal, away) = near.across(&[(WallId(0), DVec3::Z, 1.0)]);
        assert!((normal * away - DVec3::new(-2.0, 0.0, 0.0)).length() < 1e-12);
        // Without a wall the step goes all the way.
        let (normal, away) = near.across(&[]);
        assert!((p + normal * away - DVec3::new(0.0, 4.0, 0.0)).length() < 1e-12);
    }

    #[test]
    fn a_curve_that_the_solid_does_not_have_says_nothing() {
        assert_eq!(one_edge().nearest(DVec3::X, CurveId(1)), None);
    }
}
