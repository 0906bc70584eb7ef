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
//! an outer edge at either side, count as slanted; a chamfer beside an end face does not.

use super::Medial;
use crate::geom::placer::Placer;
use crate::model::brep::Brep;
use crate::model::ids::{FaceId, FacetId, IndexVec, WallId};
use crate::model::walls::{Aag, Convexity, Wall};
use glam::DVec3;
use rayon::prelude::*;
use smallvec::SmallVec;

/// Share of a wall that may lie beyond the feet of its shorter sides: a fifth of the twentieth of the mesh that may be off its middle in all, and more mass than that is not cut off
/// a wall but where its ends are many. (At 0.03 countersunk plates were doubted: junctions are not judged, so that the strips are more of what is.)
const STRIPS: f64 = 0.01;

/// A wall that a lateral surface goes right across, and the share of the strip that is cut off there.
type Cut = (WallId, f64);

/// How far rims stay inside each lateral surface.
#[derive(Clone, Debug, Default)]
pub(super) struct Slants {
    /// By lateral surface.
    cuts: Vec<SmallVec<[Cut; 2]>>,
}

impl Slants {
    /// Cost: linear in arcs, and a nearest-point query a facet of the faces that go across a wall at a slant.
    pub(super) fn new(
        medial: &Medial<'_>,
        brep: &Brep,
        aag: &Aag,
        walls: &IndexVec<WallId, Wall>,
    ) -> Self {
        let mut cuts: Vec<SmallVec<[Cut; 2]>> = vec![SmallVec::new(); medial.rims.len()];
        for (w, wall) in walls.enumerated() {
            let across = faces_across(wall, aag);
            // Strips on either side of the sheet count for one, sides for one. A large face may be a side of many walls, of each only as much as the other side.
            let facets: Vec<FacetId> = (across.iter())
                .flat_map(|&f| medial.ground.of_face[f].iter().copied())
                .collect();
            let strips: Vec<f64> = (facets.par_iter())
                .map(|&facet| {
                    let [a, b, c] = brep.corners(facet);
                    let area = (b - a).cross(c - a) / 2.0;
                    let normal = medial.normal((a + b + c) / 3.0, w);
                    normal.map_or(0.0, |n| n.dot(area).abs())
                })
                .collect();
            let strips: f64 = strips.iter().sum();
            let area = |side: &[FaceId]| -> f64 { side.iter().map(|&f| aag.area[f]).sum() };
            let sides = 2.0 * area(&wall.sides[0]).min(area(&wall.sides[1]));
            let cut = 1.0 - STRIPS * sides / strips.max(f64::MIN_POSITIVE);
            if cut > 0.0 {
                for f in across {
                    let list = &mut cuts[medial.rim_surface[f] as usize];
                    if !list.contains(&(w, cut)) {
                        list.push((w, cut));
                    }
                }
            }
        }
        Self { cuts }
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
            let cut = cuts.iter().find(|c| c.0 == w)?;
            Some(cut.1 * thickness / 2.0 * normal.dot(across).abs())
        };
        mids.iter().filter_map(of).fold(0.0, f64::max)
    }
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
    use crate::test_parts::voxels::{Filled, plate};

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
        // Leaning by 1 in 4 an end has a strip a quarter wide, 0.6 % of the plate; leaning by 45 degrees both ends have 5 %, of which 4 % are cut off.
        let leaning = |p: DVec3| p.x + (p.z - 1.0) / 4.0;
        let one =
            plate(1).mapped(|p| DVec3::new(if p.x > 20.0 { leaning(p) } else { p.x }, p.y, p.z));
        let two = plate(1).mapped(|p| DVec3::new(p.x + p.z - 1.0, p.y, p.z));
        assert!((rim(&one) - 40.0).abs() < 1e-9, "{}", rim(&one));
        assert!((rim(&two) - 39.2).abs() < 1e-9, "{}", rim(&two));
        assert!((rim(&plate(1)) - 40.0).abs() < 1e-9);
    }
}
