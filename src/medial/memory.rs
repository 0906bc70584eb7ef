//! Remembers the feet of points that were asked for lately: stages ask for the normal, the thickness and the curvature at one and the same point, one after the other.
//!
//! Guarantee: an answer is either exactly the one that was put in for this very point and wall, or none; so results do not depend on what is remembered, nor on
//! the number of threads. Size is fixed: a new answer takes the place of an old one.

use super::Foot;
use crate::model::ids::{Id, WallId};
use glam::DVec3;
use std::sync::Mutex;

/// Points worth remembering a facet: a raw complex has about as many triangles as the solid has facets, each is asked for round after round, and with four
/// places a point few take the place of another.
const A_FACET: usize = 8;
/// Bounds on the number of places, as powers of two: about 0.2 MB and 80 MB. Passes over a complex with more triangles than places find nothing remembered.
const BITS: [u32; 2] = [10, 19];

#[derive(Clone, Copy, Debug)]
struct Entry {
    point: [u64; 3],
    wall: WallId,
    feet: Option<[Foot; 2]>,
}

/// Feet by point and wall.
#[derive(Debug)]
pub(super) struct Memory {
    places: Vec<Mutex<Option<Entry>>>,
    shift: u32,
}

impl Memory {
    /// For a solid with so many facets.
    pub fn new(facets: usize) -> Self {
        let wanted = (A_FACET * facets).next_power_of_two().ilog2();
        let bits = wanted.clamp(BITS[0], BITS[1]);
        Self {
            places: std::iter::repeat_with(|| Mutex::new(None))
                .take(1 << bits)
                .collect(),
            shift: u64::BITS - bits,
        }
    }

    /// The feet at a point; `find` is asked where they are not remembered.
    pub fn feet(
        &self,
        p: DVec3,
        wall: WallId,
        find: impl FnOnce() -> Option<[Foot; 2]>,
    ) -> Option<[Foot; 2]> {
        let point = p.to_array().map(f64::to_bits);
        let place = &self.places[self.place(point, wall)];
        // A place that another thread holds, or held when it failed, is passed by.
        if let Ok(entry) = place.try_lock()
            && let Some(e) = *entry
            && e.point == point
            && e.wall == wall
        {
            return e.feet;
        }
        let feet = find();
        if let Ok(mut entry) = place.try_lock() {
            *entry = Some(Entry { point, wall, feet });
        }
        feet
    }

    fn place(&self, point: [u64; 3], wall: WallId) -> usize {
        // Multiplicative hashing: the top bits have seen all words.
        const GOLDEN: u64 = 0x9e37_79b9_7f4a_7c15;
        let mut print = wall.index() as u64;
        for word in point {
            print = (print.rotate_left(29) ^ word).wrapping_mul(GOLDEN);
            print ^= print >> 32;
        }
        (print.wrapping_mul(GOLDEN) >> self.shift) as usize
    }
}

impl Clone for Memory {
    /// A copy remembers nothing.
    fn clone(&self) -> Self {
        Self::new(self.places.len() / A_FACET)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::model::ids::FacetId;

    #[test]
    fn what_is_remembered_is_what_was_found_for_this_point_and_wall_alone() {
        let memory = Memory::new(0);
        let found = |x: f64| {
            let foot = Foot {
                point: DVec3::splat(x),
                normal: DVec3::Z,
                facet: FacetId::new(1),
            };
            Some([foot, foot])
        };
        let ask = |x: f64, w: u32, answer: f64| {
            let feet = memory.feet(DVec3::splat(x), WallId(w), || found(answer));
            feet.unwrap()[0].point.x
        };
        assert_eq!(ask(1.0, 0, 7.0), 7.0);
        assert_eq!(ask(1.0, 0, 8.0), 7.0);
        assert_eq!(ask(1.0, 1, 9.0), 9.0);
        // Far more points than places: none is mistaken for another.
        for round in 0..2 {
            for i in 0..5000 {
                let x = f64::from(i);
                assert_eq!(ask(x, 2, x), x, "{round}");
            }
        }
        assert_eq!(memory.feet(DVec3::X, WallId(0), || None), None);
        assert_eq!(memory.feet(DVec3::X, WallId(0), || found(1.0)), None);
    }
}
