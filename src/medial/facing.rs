//! Roundings at the end of a side: which tangent plane goes on to the rim.
//!
//! Beyond the end of a side its last tangent plane goes on. Where the side ends in a rounding that leads over to an end face, the last tangent plane is
//! that of the end face, which is no side of the wall: half way to it is the way to the rim's far corner. There the face that the rounding leads on from goes on.
//!
//! A rounding that reaches down to the middle leads over no end face but a crest: there the mid-surface ends, and the distances to both sides say where.
//!
//! Limit: a rounding is a face of its own; one that is drawn as part of the face before it keeps its last tangent plane.

use super::{Foot, Medial, Surface};
use crate::model::ids::{FaceId, WallId};
use crate::model::walls::{Aag, Convexity, Pairing};
use glam::DVec3;

/// Normals whose cosine is at most this either way, 30 degrees about square, do not face each other. Feet that look the same way are those of a crest, or of two layers.
const LEAST_FACING: f64 = 0.5;
/// The place whose tangent plane goes on faces the other side within 30 degrees, as the two sides of a wedge do: the cosine of that.
const FACING: f64 = 0.866;
/// A rounding ends before the middle if it takes less than this share of the way across the wall. Half of it is a full round, and facets and drawings miss that by a few percent.
pub(super) const SHALLOW: f64 = 0.45;

/// A foot this near to the end face, in edge lengths of its facet, lies on the edge with it: both faces have its nodes.
const ENDED: f64 = 1e-6;

/// The roundings of one side. Most sides have none.
#[derive(Clone, Debug, Default)]
pub(super) struct Roundings {
    /// Each with a face of the side that it leads on from, sorted.
    before: Vec<[FaceId; 2]>,
    /// Each with an end face that it leads over to, sorted.
    after: Vec<[FaceId; 2]>,
}

impl Roundings {
    /// The faces of a sorted list that go on smoothly into an end face (one that is no side of any wall) and into another face of the list.
    pub(super) fn new(aag: &Aag, pairing: &Pairing, faces: &[FaceId]) -> Self {
        let smooth = |f: FaceId| {
            aag.arcs_of(f)
                .filter(|a| a.convexity == Convexity::Smooth)
                .map(move |a| Aag::across(a, f))
                .filter(move |&g| g != f)
        };
        let mut before: Vec<[FaceId; 2]> = faces
            .iter()
            .filter(|&&f| smooth(f).any(|g| pairing.side[g].is_none()))
            .flat_map(|&f| smooth(f).map(move |g| [f, g]))
            .filter(|[_, g]| faces.binary_search(g).is_ok())
            .collect();
        before.sort_unstable();
        before.dedup();
        let mut after: Vec<[FaceId; 2]> = (before.chunk_by(|a, b| a[0] == b[0]))
            .flat_map(|run| smooth(run[0][0]).map(|g| [run[0][0], g]))
            .filter(|[_, g]| pairing.side[*g].is_none())
            .collect();
        after.sort_unstable();
        after.dedup();
        Self { before, after }
    }

    /// The faces that a rounding leads on from; none if the face is no rounding.
    fn before(&self, rounding: FaceId) -> &[[FaceId; 2]] {
        of(&self.before, rounding)
    }

    /// The end faces that a rounding leads over to.
    fn after(&self, rounding: FaceId) -> &[[FaceId; 2]] {
        of(&self.after, rounding)
    }
}

/// The pairs of one face in a sorted list.
fn of(pairs: &[[FaceId; 2]], face: FaceId) -> &[[FaceId; 2]] {
    let from = pairs.partition_point(|pair| pair[0] < face);
    let to = pairs.partition_point(|pair| pair[0] <= face);
    &pairs[from..to]
}

impl Medial<'_> {
    /// The feet themselves, unless one of them lies at the end of a rounding over which its side has turned towards an end face. Then the nearest place of the face
    /// that the rounding leads on from is meant, if it faces the other side and the rounding ends before the middle.
    pub(super) fn facing(
        &self,
        sides: [&Surface; 2],
        mut feet: [Foot; 2],
        p: DVec3,
        wall: WallId,
    ) -> [Foot; 2] {
        if feet[0].normal.dot(feet[1].normal).abs() > LEAST_FACING {
            return feet;
        }
        let far = self.reach[wall] + self.thickness[wall];
        for (turned, other) in [(0, 1), (1, 0)] {
            let (side, foot) = (sides[turned], feet[turned]);
            let before = side.roundings.before(self.brep.facets[foot.facet].face);
            if before.is_empty() || foot.is_plumb(p) {
                continue;
            }
            // Of this layer: another one, across a gap, may be nearer.
            let leads_on = |i: usize| {
                let face = self.brep.facets[side.facets[i]].face;
                let corners = self.ground.facets[side.facets[i]].corners();
                let across = (corners[1] - corners[0]).cross(corners[2] - corners[0]);
                let depth = |of: Foot| across.dot(corners[0] - of.point);
                before.iter().any(|pair| pair[1] == face)
                    && across.dot(feet[other].normal) < -FACING * across.length()
                    && (0.0..SHALLOW * depth(feet[other])).contains(&depth(foot))
            };
            let near = (side.bvh).nearest_where(p, far, leads_on);
            if let Some(near) = near {
                feet[turned] = self.foot_on(side.facets[near.index], p, near.point);
                break;
            }
            feet[turned].normal = self.ended(side, foot);
        }
        feet
    }

    /// The normal at the end of a rounding: that of the flat end face which it leads over to smoothly. The last normal of its own facets is off by a degree and more, and over the
    /// breadth of the end face so is the sheet.
    fn ended(&self, side: &Surface, foot: Foot) -> DVec3 {
        let after = side.roundings.after(self.brep.facets[foot.facet].face);
        (after.iter())
            .filter_map(|pair| {
                let end = &self.rims[self.rim_surface[pair[1]] as usize];
                let there = self.foot(end, foot.point, &mut None)?;
                let face = self.brep.facets[there.facet].face;
                let flat = self.ground.facets[there.facet].sag() <= 0.0;
                (flat && face == pair[1] && there.normal.dot(foot.normal) > FACING)
                    .then(|| (there.point.distance_squared(foot.point), there.normal))
            })
            .filter(|(away, _)| *away <= (ENDED * side_length(self, foot)).powi(2))
            .min_by(|a, b| a.0.total_cmp(&b.0))
            .map_or(foot.normal, |(_, normal)| normal)
    }
}

/// Length of the first edge of the facet that a foot lies on.
fn side_length(medial: &Medial<'_>, foot: Foot) -> f64 {
    let [a, b, _] = medial.ground.facets[foot.facet].corners();
    a.distance(b)
}
