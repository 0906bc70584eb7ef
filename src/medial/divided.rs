//! The round end of a wall whose two sides were one face.
//!
//! Where such a face was cut, the border of a side runs along facets, somewhere near the crest, and not quite: the tangent plane at the end of a side, which goes on elsewhere, leans as the
//! last facet happens to, and a rim wanders to and fro across the round end. There the mid-surface goes straight on from the last place that has a plumb foot on either side, and ends
//! on the crest by itself.

use super::{Foot, Hints, Medial, Tangent, middle};
use crate::model::brep::Brep;
use crate::model::ids::WallId;
use crate::model::walls::Wall;
use glam::DVec3;
use std::collections::BTreeMap;

/// Beyond the end of either side both look the same way: the sum of their normals is this long, a degree and a half each. So it is on a tapered wall; there the point itself has plumb feet.
const TURNED: f64 = 0.05;
/// A round end is half as long as the wall is thick, a pointed one twice as long; so far back a wall is looked for, in thicknesses.
const BACK: f64 = 2.0;
/// The end of a wall is known to a facet's error: the tangent plane is that of a place this much further back, in thicknesses.
const CLEAR: f64 = 0.1;
/// Steps of a point beside the middle onto it.
const STEPS_TO_MIDDLE: usize = 3;
/// Halvings of that way until the end of the wall is known, to less than a hundredth of the thickness.
const HALVINGS: usize = 8;

/// Whether sides of a wall are parts of one face, that is of the same number.
pub(super) fn was_one_face(brep: &Brep, wall: &Wall) -> bool {
    let mut of_tag: BTreeMap<i32, _> = BTreeMap::new();
    for (k, side) in wall.sides.iter().enumerate() {
        for &f in side {
            if *of_tag.entry(brep.faces[f].tag).or_insert(k) != k {
                return true;
            }
        }
    }
    false
}

impl Medial<'_> {
    /// The middle at a point beyond the end of both sides, `feet` there: the tangent plane of the last place before that.
    pub(super) fn straight_on(&self, p: DVec3, wall: WallId, feet: [Foot; 2]) -> Option<Tangent> {
        let out = feet[0].normal + feet[1].normal;
        if !self.divided[wall] || out.length() < TURNED {
            return None;
        }
        let out = out.normalize();
        // Beside the middle a point past the end may have a plumb foot on either side, one of them on the rounding.
        let at = |back: f64| {
            let mut q = p - out * back;
            for _ in 0..STEPS_TO_MIDDLE {
                let [a, b] = self.feet_from(q, wall, &mut Hints::default())?;
                let middle = middle([a.normal, b.normal], [a.depth(q), b.depth(q)], 0.0)?;
                q += middle.plane.0 * middle.plane.1;
            }
            let [a, b] = self.feet_from(q, wall, &mut Hints::default())?;
            (a.is_plumb(q) && b.is_plumb(q)).then_some((q, [a, b]))
        };
        if at(0.0).is_some() {
            return None;
        }
        let [mut near, mut far] = [0.0, BACK * self.thickness[wall]];
        let mut last = None;
        for step in 1..=4 {
            let back = far * f64::from(step) / 4.0;
            if let Some(found) = at(back) {
                (last, far) = (Some(found), back);
                break;
            }
            near = back;
        }
        let mut last = last?;
        for _ in 0..HALVINGS {
            let back = (near + far) / 2.0;
            if let Some(found) = at(back) {
                (last, far) = (found, back);
            } else {
                near = back;
            }
        }
        let (q, [a, b]) = at(far + CLEAR * self.thickness[wall]).unwrap_or(last);
        let mut tangent = middle([a.normal, b.normal], [a.depth(q), b.depth(q)], 0.0)?;
        tangent.plane.1 -= tangent.plane.0.dot(p - q);
        tangent.beyond = feet[0].beyond(p).min(feet[1].beyond(p));
        Some(tangent)
    }
}
