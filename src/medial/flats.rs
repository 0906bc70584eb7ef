//! The short way to a foot: over the flat parts of a side from facet to facet, without a search.
//!
//! Most sides are flat over most of their area, and most questions come near places asked for before. So the facet that the last foot near a place was found on is
//! remembered, and from there the way goes over the sides of facets to the one straight above the point. It is the nearest of all if no other facet
//! comes between: all that lie within reach of a clear facet stay below its plane.
//!
//! Guarantee: the foot is exactly that of the search, or none; so results depend neither on what is remembered nor on the number of threads.
//! Limit: a second facet in the place of a clear one, which no sound solid has.

use super::{Foot, IN_PLANE, Medial, Surface};
use crate::geom::triangle::nearest_on_triangle;
use crate::model::brep::Brep;
use crate::model::ids::{FacetId, Id, IndexVec, VertexId, WallId};
use crate::spatial::Hint;
use glam::DVec3;
use std::sync::atomic::{AtomicU8, AtomicU64, Ordering};

/// Facets passed on the way at most: further off a search is as fast.
const LONGEST_WAY: usize = 6;
/// A facet is clear for points up to this height below it, in thicknesses: a half is the middle, and walls differ from their mean.
const HEIGHT: f64 = 0.75;
/// Places are told apart by this many thicknesses: about a facet.
const CELL: f64 = 4.0;
/// Bounds on the number of places, as powers of two: 4 kB and 4 MB.
const BITS: [u32; 2] = [10, 20];

const NOWHERE: u32 = u32::MAX;

const UNKNOWN: u8 = 0;
const CLEAR: u8 = 1;
const COVERED: u8 = 2;

/// What is known of the facets as flats.
#[derive(Debug)]
pub(super) struct Flats {
    /// The facet across each side, itself where there is not just one.
    across: IndexVec<FacetId, [FacetId; 3]>,
    /// The side of a wall that a facet is on, see [`number`]; none where it is on several or on none.
    owner: IndexVec<FacetId, u32>,
    /// Whether a facet is clear, found out when it is first asked for.
    clear: Vec<AtomicU8>,
    /// One more than the facet last found near a place, zero where none was; and in the lower half where a search near it ended.
    guesses: Vec<AtomicU64>,
    /// Facets this little above a plane lie in it, mm.
    slack: f64,
}

/// One number for each side of each wall.
fn number(wall: WallId, side: usize) -> u32 {
    2 * wall.0 + side as u32
}

impl Flats {
    pub(super) fn new(brep: &Brep, walls: &IndexVec<WallId, [Surface; 2]>) -> Self {
        let mut owner = IndexVec::filled(NOWHERE, brep.facets.len());
        let mut shared = Vec::new();
        for (wall, sides) in walls.enumerated() {
            for (side, surface) in sides.iter().enumerate() {
                for &f in &surface.facets {
                    if owner[f] != NOWHERE {
                        shared.push(f);
                    }
                    owner[f] = number(wall, side);
                }
            }
        }
        for f in shared {
            owner[f] = NOWHERE;
        }
        let mut sides: Vec<([VertexId; 2], FacetId, usize)> =
            Vec::with_capacity(3 * brep.facets.len());
        for (id, f) in brep.facets.enumerated() {
            for k in 0..3 {
                let (a, b) = (f.corners[k], f.corners[(k + 1) % 3]);
                sides.push(([a.min(b), a.max(b)], id, k));
            }
        }
        sides.sort_unstable();
        let mut across: IndexVec<FacetId, [FacetId; 3]> =
            brep.facets.ids().map(|f| [f; 3]).collect();
        for run in sides.chunk_by(|a, b| a.0 == b.0) {
            if let &[(_, f, k), (_, g, j)] = run {
                across[f][k] = g;
                across[g][j] = f;
            }
        }
        let size = brep.vertices.iter().map(|p| p.abs().max_element());
        let bits = brep.facets.len().next_power_of_two().ilog2();
        Self::empty(
            across,
            owner,
            1 << bits.clamp(BITS[0], BITS[1]),
            IN_PLANE * size.fold(0.0, f64::max),
        )
    }

    fn empty(
        across: IndexVec<FacetId, [FacetId; 3]>,
        owner: IndexVec<FacetId, u32>,
        places: usize,
        slack: f64,
    ) -> Self {
        Self {
            clear: std::iter::repeat_with(|| AtomicU8::new(UNKNOWN))
                .take(across.len())
                .collect(),
            guesses: std::iter::repeat_with(|| AtomicU64::new(0))
                .take(places)
                .collect(),
            across,
            owner,
            slack,
        }
    }

    /// The place of a point seen from one side of a wall.
    fn place(&self, p: DVec3, thickness: f64, side: u32) -> &AtomicU64 {
        let mut print = u64::from(side);
        for x in (p / (CELL * thickness)).floor().to_array() {
            print = (print.rotate_left(23) ^ x as i64 as u64).wrapping_mul(0x9e37_79b9_7f4a_7c15);
        }
        &self.guesses[(print >> 32) as usize & (self.guesses.len() - 1)]
    }
}

impl Clone for Flats {
    /// A copy knows the neighbours and has to find out the rest again.
    fn clone(&self) -> Self {
        let (across, owner) = (self.across.clone(), self.owner.clone());
        Self::empty(across, owner, self.guesses.len(), self.slack)
    }
}

impl Medial<'_> {
    /// The nearest point of one side of a wall; `hint` as for [`Medial::foot`].
    pub(super) fn side_foot(
        &self,
        wall: WallId,
        side: usize,
        p: DVec3,
        hint: &mut Option<Hint>,
    ) -> Option<Foot> {
        let place = (self.flats).place(p, self.thickness[wall], number(wall, side));
        let known = place.load(Ordering::Relaxed);
        let (guess, ended) = ((known >> 32) as u32, known as u32);
        let foot = match guess {
            0 => None,
            guess => self.flat_foot(wall, side, p, FacetId(guess - 1)),
        };
        let foot = match foot {
            Some(foot) => foot,
            None => {
                if hint.is_none() && guess > 0 {
                    *hint = Some(Hint::numbered(ended));
                }
                self.foot(&self.sides[wall][side], p, hint)?
            }
        };
        let ended = hint.map_or(ended, Hint::number);
        let now = u64::from(foot.facet.0 + 1) << 32 | u64::from(ended);
        if now != known {
            place.store(now, Ordering::Relaxed);
        }
        Some(foot)
    }

    /// The foot of `p` on a clear facet near `from`.
    fn flat_foot(&self, wall: WallId, side: usize, p: DVec3, from: FacetId) -> Option<Foot> {
        let thickness = self.thickness[wall];
        let mut id = from;
        for _ in 0..LONGEST_WAY {
            let facet = &self.ground.facets[id];
            if facet.sag() > 0.0 || self.flats.owner[id] != number(wall, side) {
                return None;
            }
            let corners = facet.corners();
            let normal = facet.flat_normal();
            // How far inside each side the point lies.
            let room = [0, 1, 2].map(|k| {
                let along = corners[(k + 1) % 3] - corners[k];
                normal.cross(along).dot(p - corners[k]) / along.length()
            });
            let k = (0..3).fold(0, |least, k| if room[k] < room[least] { k } else { least });
            if room[k] <= 0.0 {
                let next = self.flats.across[id][k];
                if next == id {
                    return None;
                }
                id = next;
                continue;
            }
            let height = normal.dot(corners[0] - p);
            // What lies `slack` above the plane is nearer than the foot only within this distance of it.
            let margin = 2.0 * height * self.flats.slack;
            let inside = height > 0.0 && height <= HEIGHT * thickness && room[k].powi(2) > margin;
            if !inside || !self.is_clear(&self.sides[wall][side], id, thickness) {
                return None;
            }
            let foot = self.foot_on(id, p, nearest_on_triangle(corners, p));
            return foot.is_plumb(p).then_some(foot);
        }
        None
    }

    /// Whether no other facet of the surface comes between the facet and the points up to [`HEIGHT`] below it: such a point's
    /// ball reaches twice that far from the facet.
    fn is_clear(&self, surface: &Surface, id: FacetId, thickness: f64) -> bool {
        let known = &self.flats.clear[id.index()];
        match known.load(Ordering::Relaxed) {
            UNKNOWN => {}
            found => return found == CLEAR,
        }
        let (corners, normal) = (
            self.ground.facets[id].corners(),
            self.ground.facets[id].flat_normal(),
        );
        let middle = (corners[0] + corners[1] + corners[2]) / 3.0;
        let own = corners.map(|c| c.distance(middle));
        let reach = own[0].max(own[1]).max(own[2]) + 2.0 * HEIGHT * thickness;
        let between = |i: usize| {
            let other = self.ground.facets[surface.facets[i]].corners();
            other
                .iter()
                .any(|&c| normal.dot(corners[0] - c) > self.flats.slack)
        };
        let clear = surface.bvh.nearest_where(middle, reach, between).is_none();
        known.store(if clear { CLEAR } else { COVERED }, Ordering::Relaxed);
        clear
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geom::random::Pcg;
    use crate::stage::adjacency::adjacency;
    use crate::stage::pair::{PairOptions, pair, sight};
    use crate::test_parts::voxels::{ell, plate, step_plate, tee};

    #[test]
    fn the_short_way_ends_where_the_search_does_whatever_was_asked_before() {
        let mut short = 0;
        for solid in [plate(2), ell(2), tee(2), step_plate()] {
            let brep = &solid.brep;
            let aag = adjacency(brep);
            let pairing = pair(brep, &aag, &sight(brep), &PairOptions::default());
            let medial = Medial::new(brep, &aag, &pairing);
            let (low, high) = brep
                .vertices
                .iter()
                .fold((DVec3::INFINITY, DVec3::NEG_INFINITY), |(low, high), &v| {
                    (low.min(v), high.max(v))
                });
            let mut rng = Pcg::new(3);
            for _ in 0..4000 {
                let share = DVec3::new(rng.unit(), rng.unit(), rng.unit());
                let p = low - 0.5 + share * (high - low + 1.0);
                for (wall, sides) in medial.sides.enumerated() {
                    for (side, surface) in sides.iter().enumerate() {
                        let sought = medial.foot(surface, p, &mut None);
                        assert_eq!(medial.side_foot(wall, side, p, &mut None), sought, "{p}");
                        let from =
                            surface.facets[(rng.unit() * surface.facets.len() as f64) as usize];
                        let found = medial.flat_foot(wall, side, p, from);
                        short += usize::from(found.is_some());
                        assert!(found.is_none() || found == sought, "{p}");
                    }
                }
            }
        }
        assert!(short > 1000, "only {short} by the short way");
    }

    #[test]
    fn a_facet_under_another_one_is_not_clear() {
        let solid = ell(2);
        let aag = adjacency(&solid.brep);
        let pairing = pair(
            &solid.brep,
            &aag,
            &sight(&solid.brep),
            &PairOptions::default(),
        );
        let medial = Medial::new(&solid.brep, &aag, &pairing);
        // Both sides as one surface: each facet has the other side within twice the thickness below it.
        let mut both: Vec<_> = medial.sides[WallId(0)]
            .iter()
            .flat_map(|s| s.facets.iter().copied())
            .collect();
        both.sort_unstable();
        let corners: Vec<[DVec3; 3]> = both.iter().map(|&f| solid.brep.corners(f)).collect();
        let surface = Surface {
            bvh: crate::spatial::TriangleBvh::new(&corners),
            facets: both.clone(),
            ..Surface::default()
        };
        let thickness = medial.thickness[WallId(0)];
        let covered = (both.iter()).filter(|&&f| !medial.is_clear(&surface, f, thickness));
        assert_eq!(covered.count(), both.len());
    }
}
