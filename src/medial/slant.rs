//! Rims on slanted lateral faces.
//!
//! ```text
//!        ________________            a: foot of the shorter side, the last place that is midway between the two sides
//!       - - - - - - a - -m           m: the middle of the slanted face, half a thickness times the tangent of the slant further on
//!       ______________/
//! ```
//! A sheet ends at m: it has the length of the wall, and so its mass. Between a and m it is nearer to the slanted face than to the other side. On most walls that
//! strip is nothing beside the sheet. Where rims are many and the wall is narrow it is not; there sheets are cut back towards a until the strips are a small share again.
//!
//! Guarantees: a rim on a square face, and any rim of a wall whose strips are a small share, lies on its face. Limits: only faces that go right across the wall, with
//! an outer edge at either side, count as slanted. Beside a chamfer or rounding at one side of the end (`bevel`) the sheet is not midway either; that strip is treated alike.

use super::Medial;
use super::bevel::bevels;
use crate::geom::placer::Placer;
use crate::model::brep::Brep;
use crate::model::ids::{FaceId, FacetId, IndexVec, WallId};
use crate::model::walls::{Aag, Convexity, Pairing, Wall};
use glam::DVec3;
use rayon::prelude::*;
use smallvec::SmallVec;

/// Share of a wall that may lie beyond the feet of its shorter sides: with the twentieth of the mesh that may be off its middle in all, more than that again is
/// left for junctions and for elements on bent walls.
const STRIPS: f64 = 0.03;
/// Within so many thicknesses of another wall a sheet is part of a junction, which is midway between nothing: only what is further away counts.
const JUNCTION: f64 = 1.5;
/// That counts for no less than this share of a wall: of a short one the rest would all be cut off.
const LEAST_CLEAR: f64 = 0.5;
/// Share of a wall's mass that may be cut off at bevels beyond what they have taken away.
const MOST: f64 = 0.04;

/// How a sheet is cut back at a lateral surface.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Cut {
    wall: WallId,
    /// Share of the strip that is cut off.
    share: f64,
    /// Width of the strip that a bevel makes, mm; zero where the surface itself is slanted.
    leg: f64,
}

/// How far rims stay inside each lateral surface.
#[derive(Clone, Debug, Default)]
pub(super) struct Slants {
    /// By lateral surface.
    cuts: Vec<SmallVec<[Cut; 2]>>,
    /// Whether rims go on above bevels for now.
    pub bevels_stand: bool,
}

impl Slants {
    /// Cost: linear in arcs, and a nearest-point query a facet of the faces that go across a wall at a slant.
    pub(super) fn new(medial: &Medial<'_>, brep: &Brep, aag: &Aag, pairing: &Pairing) -> Self {
        let side_of = &pairing.side;
        let mut cuts: Vec<SmallVec<[Cut; 2]>> = vec![SmallVec::new(); medial.rims.len()];
        for (w, wall) in pairing.walls.enumerated() {
            let across = faces_across(wall, aag);
            // Strips on either side of the sheet count for one, sides for one.
            let facets: Vec<FacetId> = (across.iter())
                .flat_map(|&f| medial.ground.of_face[f].iter().copied())
                .collect();
            let strips: Vec<f64> = (facets.par_iter())
                .map(|&facet| {
                    let [a, b, c] = brep.corners(facet);
                    let area = brep.area_vector(facet);
                    let normal = medial.normal((a + b + c) / 3.0, w);
                    normal.map_or(0.0, |n| n.dot(area).abs())
                })
                .collect();
            let bevels = bevels(medial, brep, w, wall, aag);
            let bevelled: f64 = bevels.iter().map(|b| b.area).sum();
            // The sheet is too heavy over a bevel by what that has taken away.
            let taken: f64 = (bevels.iter())
                .map(|b| b.area * b.depth / wall.thickness)
                .sum();
            let strips = strips.iter().sum::<f64>() + 2.0 * bevelled;
            // A large face may be a side of many walls, of each only as much as the other side.
            let [a, b] = [0, 1].map(|side| areas(wall, side, aag, side_of));
            let (sides, clear) = (2.0 * a.0.min(b.0), 2.0 * a.1.min(b.1));
            let allowed = STRIPS * clear.max(LEAST_CLEAR * sides);
            let share = 1.0 - allowed / strips.max(f64::MIN_POSITIVE);
            if share > 0.0 {
                let slants = across.into_iter().map(|f| (f, 0.0));
                // The rim lies on the end face or, where the bevel comes down to the middle, on that.
                let ends = (bevels.iter()).flat_map(|b| [(b.end, b.leg), (b.face, b.leg)]);
                for (f, leg) in slants.chain(ends) {
                    let most = if leg > 0.0 {
                        (MOST * sides + taken) / strips
                    } else {
                        1.0
                    };
                    let cut = Cut {
                        wall: w,
                        share: share.min(most),
                        leg,
                    };
                    let list = &mut cuts[medial.rim_surface[f] as usize];
                    if !list.contains(&cut) {
                        list.push(cut);
                    }
                }
            }
        }
        Self {
            cuts,
            bevels_stand: false,
        }
    }

    /// How deep below a lateral surface a rim lies, mm. `normal`: of the surface there; `mids`: wall, unit mid normal and thickness of the sheets that end there.
    pub(super) fn inset(
        &self,
        surface: usize,
        normal: DVec3,
        mids: &[(WallId, DVec3, f64)],
    ) -> f64 {
        let Some(cuts) = self.cuts.get(surface) else {
            return 0.0;
        };
        let of = |&(w, across, thickness): &(WallId, DVec3, f64)| {
            let (lying, standing) = (
                normal.dot(across).abs(),
                normal.reject_from(across).length(),
            );
            let deep = |c: &Cut| c.share * (thickness / 2.0 * lying + c.leg * standing);
            let stands = |c: &Cut| self.bevels_stand && c.leg > 0.0;
            let here = cuts.iter().filter(|c| c.wall == w && !stands(c));
            here.map(deep).reduce(f64::max)
        };
        mids.iter().filter_map(of).fold(0.0, f64::max)
    }
}

/// Area of one side of a wall, and as much of it as is clear of other walls, mm².
fn areas(
    wall: &Wall,
    side: usize,
    aag: &Aag,
    side_of: &IndexVec<FaceId, Option<(u32, u8)>>,
) -> (f64, f64) {
    let own = |g: FaceId| wall.sides.iter().any(|s| s.binary_search(&g).is_ok());
    let near = |f: FaceId| -> f64 {
        let beside = aag.arcs_of(f).filter(|a| {
            let g = Aag::across(a, f);
            side_of[g].is_some() && !own(g)
        });
        let length: f64 = beside.map(|a| a.length).sum();
        JUNCTION * wall.thickness * length
    };
    let faces = &wall.sides[side];
    let area: f64 = faces.iter().map(|&f| aag.area[f]).sum();
    let near: f64 = faces.iter().map(|&f| near(f)).sum();
    (area, area - near)
}

/// The lateral faces with outer edges along both sides of a wall, sorted.
fn faces_across(wall: &Wall, aag: &Aag) -> Vec<FaceId> {
    let on = |side: usize, f: FaceId| wall.sides[side].binary_search(&f).is_ok();
    let beside = |side: usize| {
        let mut found: Vec<FaceId> = wall.sides[side]
            .iter()
            .flat_map(|&f| aag.arcs_of(f).map(move |a| (f, a)))
            .filter(|(_, a)| a.convexity == Convexity::Convex)
            .map(|(f, a)| Aag::across(a, f))
            .filter(|&g| !on(0, g) && !on(1, g))
            .collect();
        found.sort_unstable();
        found.dedup();
        found
    };
    let (mut first, second) = (beside(0), beside(1));
    first.retain(|f| second.binary_search(f).is_ok());
    first
}

#[cfg(test)]
mod tests {
    use super::*;

    use crate::model::complex::Support;
    use crate::stage::adjacency::adjacency;
    use crate::stage::pair::{PairOptions, pair, sight};
    use crate::test_parts::voxels::{Filled, plate, tee};

    /// Where the rim lies at the end x = 40 of a plate 40 x 24 x 2.
    fn rim(solid: &Filled) -> f64 {
        let aag = adjacency(&solid.brep);
        let pairing = pair(
            &solid.brep,
            &aag,
            &sight(&solid.brep),
            &PairOptions::default(),
        );
        let medial = Medial::new(&solid.brep, &aag, &pairing);
        let end = solid.face(|p| p.x > 38.9);
        let placed = medial.place(
            DVec3::new(39.0, 12.0, 1.0),
            &[Support::Mid(WallId(0)), Support::Face(end)],
        );
        assert!((placed.z - 1.0).abs() < 1e-9);
        placed.x
    }

    #[test]
    fn a_rim_is_cut_back_only_where_slanted_ends_are_more_than_a_small_share() {
        // Leaning by 45 degrees an end has a strip one wide: a fortieth of the plate is little, two of them are 5 %, of which 2 % are cut off.
        let one = plate(1)
            .mapped(|p| DVec3::new(if p.x > 20.0 { p.x + p.z - 1.0 } else { p.x }, p.y, p.z));
        let two = plate(1).mapped(|p| DVec3::new(p.x + p.z - 1.0, p.y, p.z));
        assert!((rim(&one) - 40.0).abs() < 1e-9, "{}", rim(&one));
        assert!((rim(&two) - 39.6).abs() < 1e-9, "{}", rim(&two));
        assert!((rim(&plate(1)) - 40.0).abs() < 1e-9);
    }

    #[test]
    fn of_a_rib_only_what_is_clear_of_the_plate_counts() {
        // The rib is 40 long and 12 high; within 1.5 times its thickness of 2 it is part of the junction.
        let solid = tee(1);
        let aag = adjacency(&solid.brep);
        let pairing = pair(
            &solid.brep,
            &aag,
            &sight(&solid.brep),
            &PairOptions::default(),
        );
        let on_rib = solid.face(|p| p.y == 11.0);
        let rib = (pairing.walls.iter())
            .find(|w| w.sides.iter().flatten().any(|&f| f == on_rib))
            .unwrap();
        for side in [0, 1] {
            let (area, clear) = areas(rib, side, &aag, &pairing.side);
            assert!((area - 40.0 * 12.0).abs() < 1e-9, "{area}");
            assert!((clear - 40.0 * (12.0 - 3.0)).abs() < 1e-9, "{clear}");
        }
        // Were the plate no wall, all of it would.
        let alone = IndexVec::filled(None, aag.area.len());
        assert!((areas(rib, 0, &aag, &alone).1 - 40.0 * 12.0).abs() < 1e-9);
    }
}
