//! Chamfers and roundings that take the corner off one side of a wall's end.
//!
//! ```text
//!        ________ ....leg            The sheet ends on the end face, half way between the sides; over the leg it is nearer to the bevel than to the other side.
//!       - - - - -\- - |depth
//!       __________|___|end           Where both corners are taken off alike it stays midway.
//! ```
//!
//! Limits: a bevel is one face with an edge to the side and another to the end face; one that goes deeper than the middle is an end face of its own, see `slant`.

use super::Medial;
use crate::model::brep::Brep;
use crate::model::ids::{FaceId, WallId};
use crate::model::walls::{Aag, Convexity, Wall};
use glam::DVec3;

/// Bevels that differ by less than this share of the thickness leave the sheet as good as midway: its R-error stays below a tenth.
const SHALLOW: f64 = 0.1;
/// A bevel that goes deeper than the middle is met by the sheet itself; facets miss that by a few percent.
const DEEPEST: f64 = 0.55;
/// A bevel leans by 20 to 70 degrees on the whole, as the tangent of the lesser; what leans less or more is a step or its riser.
const LEAST_SLOPE: f64 = 0.36;
/// A rounding that is part of the side and goes deeper is followed by the sheet.
const ROUNDED: f64 = super::facing::SHALLOW;
/// The end face stands across the wall within 30 degrees, as the sine of that.
const SQUARE: f64 = 0.5;

/// A face that takes the corner off one side of a wall's end.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Bevel {
    pub face: FaceId,
    /// The end face that it leads over to.
    pub end: FaceId,
    side: usize,
    /// How far along the wall it goes, and how deep across, mm.
    pub leg: f64,
    pub depth: f64,
    /// Area of the sheet above it that is off the middle, mm².
    pub area: f64,
}

/// The bevels of a wall at ends that have none alike at the other side, sorted by faces. Cost: linear in the arcs of its sides, and a nearest-point query a facet of a bevel and
/// of its end face.
pub(super) fn bevels(
    medial: &Medial<'_>,
    brep: &Brep,
    wall: WallId,
    of: &Wall,
    aag: &Aag,
) -> Vec<Bevel> {
    let own = |g: FaceId| of.sides.iter().any(|side| side.binary_search(&g).is_ok());
    let beside = |f: FaceId| {
        (aag.arcs_of(f))
            .filter(|a| a.convexity != Convexity::Concave)
            .map(move |a| (Aag::across(a, f), a))
            .filter(move |(g, _)| *g != f)
    };
    let mut all: Vec<Bevel> = Vec::new();
    for side in 0..2 {
        for &f in &of.sides[side] {
            let at = Place {
                medial,
                brep,
                wall,
                side,
            };
            for (face, _) in beside(f) {
                // A rounding may be part of the side, which goes on flat beyond it unless it comes down to the middle.
                let deepest = if own(face) { ROUNDED } else { DEEPEST } * of.thickness;
                if own(face) && of.sides[side].binary_search(&face).is_err() {
                    continue;
                }
                let ends = beside(face).filter(|(end, _)| *end != f && !own(*end));
                all.extend(ends.filter_map(|(end, arc)| {
                    at.bevel(
                        [face, end],
                        arc.length,
                        aag.area[face],
                        [SHALLOW * of.thickness, deepest],
                    )
                }));
            }
        }
    }
    all.sort_by_key(|b| (b.face, b.end, b.side));
    all.dedup_by_key(|b| (b.face, b.end, b.side));
    let alike = |b: &Bevel| {
        let mate = |c: &&Bevel| c.end == b.end && c.side != b.side;
        all.iter()
            .filter(mate)
            .any(|c| (c.depth - b.depth).abs() < SHALLOW * of.thickness)
    };
    all.iter().filter(|b| !alike(b)).copied().collect()
}

/// One side of one wall.
struct Place<'a> {
    medial: &'a Medial<'a>,
    brep: &'a Brep,
    wall: WallId,
    side: usize,
}

impl Place<'_> {
    fn bevel(
        &self,
        [face, end]: [FaceId; 2],
        length: f64,
        area: f64,
        [shallowest, deepest]: [f64; 2],
    ) -> Option<Bevel> {
        // So large a face is no bevel, whichever way it lies.
        if area > 2.0 * deepest * length {
            return None;
        }
        let [along, across] = self.extents(face)?;
        let [leg, depth] = [along, across].map(|area| area / length);
        if depth < shallowest
            || depth.max(leg) > deepest
            || depth.min(leg) < LEAST_SLOPE * depth.max(leg)
        {
            return None;
        }
        let [lying, standing] = self.extents(end)?;
        (lying < SQUARE * standing).then_some(Bevel {
            face,
            end,
            side: self.side,
            leg,
            depth,
            area: along * (1.0 - shallowest / depth),
        })
    }

    /// Area of a face as seen along the normal of the side across, and as seen from beside, mm².
    fn extents(&self, face: FaceId) -> Option<[f64; 2]> {
        let mut sum = [0.0; 2];
        for &facet in &self.medial.ground.of_face[face] {
            let [a, b, c]: [DVec3; 3] = self.brep.corners(facet);
            let area = self.brep.area_vector(facet);
            let feet = self.medial.feet((a + b + c) / 3.0, self.wall)?;
            let normal = feet[1 - self.side].normal;
            sum[0] += area.dot(normal).abs();
            sum[1] += area.reject_from(normal).length();
        }
        Some(sum)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geom::placer::Placer;
    use crate::model::complex::Support;
    use crate::model::ids::IndexVec;
    use crate::model::walls::Pairing;
    use crate::stage::adjacency::adjacency;

    /// What `ask` finds on a plate 20 x 4, 30 long, where the end at y = 20 has the upper and the lower corner taken off by so much. The sides are the faces listed for them.
    fn asked<T>(
        [upper, lower]: [f64; 2],
        sides: [&[u32]; 2],
        turned: bool,
        ask: impl Fn(&Medial<'_>, &Brep, &Wall, &Aag) -> T,
    ) -> T {
        let outline = [
            (0.0, -2.0),
            (20.0 - lower, -2.0),
            (20.0, -2.0 + lower),
            (20.0, 2.0 - upper),
            (20.0 - upper, 2.0),
            (0.0, 2.0),
        ];
        let mut solid = crate::test_parts::prism(&outline, 30.0, |a, b| (a + b) / 2.0);
        if turned {
            let motion = crate::test_parts::voxels::motion;
            for p in solid.vertices.iter_mut() {
                *p = motion(*p);
            }
            for facet in solid.facets.iter_mut() {
                facet.mids = facet.mids.map(motion);
            }
        }
        let aag = adjacency(&solid);
        let mut pairing = Pairing {
            side: IndexVec::filled(None, solid.faces.len()),
            ..Pairing::default()
        };
        for (side, faces) in (0u8..).zip(sides) {
            for &f in faces {
                pairing.side[FaceId(f)] = Some((0, side));
            }
        }
        let wall = Wall {
            sides: sides.map(|faces| faces.iter().map(|&f| FaceId(f)).collect()),
            thickness: 4.0,
            group: 0,
        };
        pairing.walls.push(wall.clone());
        let medial = Medial::new(&solid, &aag, &pairing);
        ask(&medial, &solid, &wall, &aag)
    }

    fn found(upper: f64, lower: f64, sides: [&[u32]; 2], turned: bool) -> Vec<[f64; 3]> {
        asked([upper, lower], sides, turned, |medial, solid, wall, aag| {
            let all = bevels(medial, solid, WallId(0), wall, aag);
            all.iter().map(|b| [b.leg, b.depth, b.area]).collect()
        })
    }

    fn close(found: &[[f64; 3]], wanted: &[[f64; 3]]) -> bool {
        found.len() == wanted.len()
            && (found.iter().flatten().zip(wanted.iter().flatten()))
                .all(|(a, b)| (a - b).abs() < 1e-9)
    }

    #[test]
    fn a_corner_taken_off_one_side_is_a_bevel_and_one_at_either_side_is_none() {
        // Faces: 0 below, 1 the lower bevel, 2 the end, 3 the upper bevel, 4 above. Off the middle is what is deeper than a tenth of 4.
        let sides: [&[u32]; 2] = [&[4], &[0]];
        for turned in [false, true] {
            let one = found(1.0, 0.01, sides, turned);
            assert!(close(&one, &[[1.0, 1.0, 30.0 * 0.6]]), "{one:?}");
            let both = found(1.0, 0.9, sides, turned);
            assert!(both.is_empty(), "{both:?}");
            let unlike = found(1.6, 0.8, sides, turned);
            let wanted = [[0.8, 0.8, 30.0 * 0.4], [1.6, 1.6, 30.0 * 1.2]];
            assert!(close(&unlike, &wanted), "{unlike:?}");
            // The same with the sides the other way about.
            assert!(close(&found(1.0, 0.01, [&[0], &[4]], turned), &one));
        }
    }

    #[test]
    fn what_is_too_shallow_or_reaches_below_the_middle_is_none() {
        let sides: [&[u32]; 2] = [&[4], &[0]];
        assert!(found(0.3, 0.01, sides, false).is_empty());
        assert!(found(2.4, 0.01, sides, false).is_empty());
        // As part of the side it is followed from 0.45 of the thickness on, and below that it is a bevel like any other.
        let part: [&[u32]; 2] = [&[3, 4], &[0]];
        assert!(close(
            &found(1.5, 0.01, part, false),
            &[[1.5, 1.5, 30.0 * 1.1]]
        ));
        assert!(found(1.9, 0.01, part, false).is_empty());
    }

    #[test]
    fn where_bevels_are_more_than_a_small_share_the_rim_is_cut_back() {
        // Off the middle are 36 mm² of 552; 3 % of these may be.
        let share = 1.0 - 0.03 * 552.0 / 36.0;
        let sides: [&[u32]; 2] = [&[4], &[0]];
        let rim = |upper: f64| {
            asked([upper, 0.01], sides, false, |medial, _, _, _| {
                let rim = [Support::Mid(WallId(0)), Support::Face(FaceId(2))];
                medial.place(DVec3::new(12.0, 19.0, 0.2), &rim)
            })
        };
        let cut = rim(1.6);
        let wanted = DVec3::new(12.0, 20.0 - share * 1.6, 0.0);
        assert!(cut.distance(wanted) < 1e-9, "{cut} {wanted}");
        assert!(rim(0.5).distance(DVec3::new(12.0, 20.0, 0.0)) < 1e-9);
    }
}
