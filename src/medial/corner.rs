//! The inner edges of steps: where a side goes on round a corner of the material.
//!
//! Beyond the end of a side its tangent plane goes on. An inner edge is no end: a point of the material whose foot lies there is as far from the side as from the
//! edge, and the foot looks straight at it. Beyond the end of the edge itself, at a rim, the edge goes on straight.

use super::Foot;
use crate::model::brep::Brep;
use crate::model::ids::{FaceId, FacetId, Id, VertexId};
use crate::model::walls::{Aag, Convexity};
use crate::spatial::TriangleBvh;
use glam::DVec3;

/// A foot lies on an edge or a corner within this share of the facet's size: rounding, no more.
const ON: f64 = 1e-9;

/// The inner edges of one side. Most sides have none.
#[derive(Clone, Debug, Default)]
pub(super) struct InnerEdges {
    /// Ends of the segments, the lower first, sorted.
    segments: Vec<[VertexId; 2]>,
    near: TriangleBvh,
}

impl InnerEdges {
    /// The segments of all concave curves between two faces of a sorted list.
    pub(super) fn new(brep: &Brep, aag: &Aag, faces: &[FaceId]) -> Self {
        let within = |f: &FaceId| faces.binary_search(f).is_ok();
        let mut segments: Vec<[VertexId; 2]> = aag
            .arcs
            .iter()
            .filter(|a| a.convexity == Convexity::Concave && a.faces.iter().all(within))
            .filter_map(|a| brep.curves.as_slice().get(a.curve.index()))
            .flat_map(|c| c.segments.iter().map(|&[u, v]| [u.min(v), u.max(v)]))
            .collect();
        segments.sort_unstable();
        segments.dedup();
        let lines: Vec<[DVec3; 3]> = segments
            .iter()
            .map(|s| {
                let [a, b] = s.map(|v| brep.vertices[v]);
                [a, b, b]
            })
            .collect();
        let near = TriangleBvh::new(&lines);
        Self { segments, near }
    }

    /// Radius of the curve that the mid-surface makes round the inner edge nearest to `p`, if one lies within `reach`.
    ///
    /// It is a parabola with its focus at the edge: at a distance d from the focus its radius is 2 d at least.
    pub(super) fn radius(&self, p: DVec3, reach: f64) -> f64 {
        self.near
            .nearest_within(p, reach)
            .map_or(f64::INFINITY, |near| 2.0 * near.distance)
    }

    /// The foot of `p` with its normal turned to look at `p`, where it lies on an inner edge; as it is elsewhere.
    pub(super) fn rounded(&self, brep: &Brep, foot: Foot, p: DVec3) -> Foot {
        if self.segments.is_empty() {
            return foot;
        }
        let Some(along) = self.along(brep, foot.facet, foot.point) else {
            return foot;
        };
        let look = foot.point - p;
        let look = look - along * look.dot(along);
        Foot {
            normal: look
                .try_normalize()
                .map_or(foot.normal, |n| n * n.dot(foot.normal).signum()),
            ..foot
        }
    }

    /// Direction in which the side goes on straight from a point of an inner edge: that of the edge at its end, none elsewhere. `None` off the edges.
    fn along(&self, brep: &Brep, facet: FacetId, point: DVec3) -> Option<DVec3> {
        let facet = &brep.facets[facet];
        let place = |v: VertexId| brep.vertices[v];
        let sides =
            [0, 1, 2].map(|k| (facet.corners[k], facet.corners[(k + 1) % 3], facet.mids[k]));
        let size = sides
            .iter()
            .map(|&(u, v, _)| place(u).distance(place(v)))
            .fold(0.0, f64::max);
        if let Some(v) = facet
            .corners
            .into_iter()
            .find(|&v| place(v).distance(point) <= ON * size)
        {
            let mut at = self.segments.iter().filter(|s| s.contains(&v));
            let &[a, b] = at.next()?;
            let ends = at.next().is_none();
            return Some(if ends {
                (place(b) - place(a)).normalize_or_zero()
            } else {
                DVec3::ZERO
            });
        }
        sides
            .into_iter()
            .any(|(u, v, mid)| {
                let (a, b) = (place(u), place(v));
                let d = b - a;
                let t = (point - a).dot(d) / d.length_squared().max(f64::MIN_POSITIVE);
                let off = point.distance(a + d * t.clamp(0.0, 1.0));
                // A curved edge leaves its chord by no more than its middle does.
                off <= mid.distance((a + b) / 2.0) + ON * size
                    && self.segments.binary_search(&[u.min(v), u.max(v)]).is_ok()
            })
            .then_some(DVec3::ZERO)
    }
}
