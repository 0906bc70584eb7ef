//! How far a wall goes on round a mid-point: what tells a wall from a strip of overlap, a neck, a rim and a lump.
//!
//! The width of a whole face says little about the region in which it faces another: a strip of overlap along the border of a large face may be
//! narrower than the distance across it, and a broad wall may be made of narrow faces. So from the mid-point of a look steps are made sideways,
//! in eight directions, and at each step both sides are looked for again: the wall goes on where they are about as far apart as here,
//! along the first look or, round a bore narrower than the wall, by their nearest points.
//!
//! Limit: the eight directions miss the narrowest one by up to 22.5 degrees, so that widths are up to 8 % too great.
//! Cost: at most eight times [`STEPS`] steps of two rays a look and the halvings of the last, fewer where the wall soon ends; as many again at most
//! where it ends in a rib.

use crate::model::sighting::Extent;
use crate::spatial::TriangleBvh;
use glam::DVec3;
use std::f64::consts::FRAC_PI_4;

/// Steps in one direction.
const STEPS: u32 = 4;
/// Halvings of the step in which the wall ends: to a few hundredths of the thickness, as good as the directions.
const HALVINGS: u32 = 3;
/// Reach in one direction, in thicknesses: to know widths up to twice the thickness, the literature's limit of a wall.
const REACH: f64 = 1.0;
/// The wall goes on while its thickness changes by less than this factor: draft and the curvature of a tight bend change it by a quarter
/// over such a reach.
const ALIKE: f64 = 1.35;

/// Rays end here, in thicknesses: what is further off is beyond reach, and no side of a wall that goes on.
const FAR: f64 = if ALIKE > REACH { ALIKE } else { REACH };
/// Beneath a rib that stands on one of its sides a wall goes on if it is found again nearer than this, in thicknesses: from the middle of a strip as wide
/// as the wall is thick that is beyond a rib of one and a half thicknesses, the thickest that the wall carries and not the other way round.
const BENEATH: f64 = 2.0;

/// Between two sides that bend together the sum of the distances stays; it may change by this factor, the sagitta of six facets round a bore. Between
/// a bore and a flat face it changes more before the bore is as wide as the wall is thick.
const SAME: f64 = 1.1;
/// A side bends away by less than 60 degrees within reach.
const FACING_COS: f64 = 0.5;
/// It bends by three degrees at least: between flat sides the ray along the first look is right.
const BENT_COS: f64 = 0.998_6;
/// A nearest point at the border of a face is seen at more than this cosine off its normal: there the side ends.
const PLUMB_COS: f64 = 0.97;

/// A wall of one thickness is measured the same everywhere up to this share.
const ROUNDING: f64 = 1e-6;

/// How a wall ends in one direction.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum End {
    /// Not within reach.
    Open,
    /// At the solid's boundary.
    Free,
    /// In material of another thickness.
    Other,
}

/// What lies round a wall.
pub(super) struct Boundary<'a> {
    /// Facets of the boundary.
    pub bvh: &'a TriangleBvh,
    /// Their outward unit normals.
    pub flat: &'a [DVec3],
    /// Outward unit normal of the curved facet at a point of it.
    pub outward: &'a (dyn Fn(usize, DVec3) -> DVec3 + Sync),
}

impl Boundary<'_> {
    /// Sum of the distances from `at` to the side that faces `inward` and the side that faces against it, each met at right angles and bent;
    /// infinite where one is none of that.
    fn distances(&self, at: DVec3, inward: DVec3, reach: f64) -> f64 {
        let distance = |n: DVec3| {
            self.bvh
                .nearest_where(at, reach, |i| self.flat[i].dot(n) > FACING_COS)
                .filter(|near| {
                    let normal = (self.outward)(near.index, near.point);
                    let plumb = (near.point - at).dot(normal) > PLUMB_COS * near.distance;
                    plumb && normal.dot(n) < BENT_COS
                })
                .map_or(f64::INFINITY, |near| near.distance)
        };
        match distance(inward) {
            d if d.is_finite() => d + distance(-inward),
            none => none,
        }
    }
}

/// Widths of the wall round the point at a depth of half of `across` below `point`.
pub(super) fn extent(boundary: &Boundary<'_>, point: DVec3, inward: DVec3, across: f64) -> Extent {
    let middle = point + inward * (across / 2.0);
    let (u, v) = inward.any_orthonormal_pair();
    let mut found = Extent {
        most: 0.0,
        ..Extent::WIDE
    };
    for k in 0..4 {
        let (sin, cos) = (f64::from(k) * FRAC_PI_4).sin_cos();
        let direction = u * cos + v * sin;
        let (a, end_a) = reach(boundary, middle, inward, direction, across);
        let (b, end_b) = reach(boundary, middle, inward, -direction, across);
        let width = a + b;
        found.most = found.most.max(width);
        let bound = match (end_a, end_b) {
            (End::Free, End::Free) => &mut found.bar,
            (End::Other, End::Other) => &mut found.neck,
            _ => &mut found.rib,
        };
        *bound = bound.min(width);
    }
    found
}

/// Whether a wall that ends in other material after `reached` thicknesses only carries a rib there: one of its sides goes on flat, the other
/// stands back, and behind the rib both are where they were.
fn beneath_rib(
    boundary: &Boundary<'_>,
    middle: DVec3,
    inward: DVec3,
    direction: DVec3,
    across: f64,
    reached: f64,
) -> bool {
    let half = across / 2.0;
    let stays = |d: f64| (half / ALIKE..half * ALIKE).contains(&d);
    let step = REACH / f64::from(STEPS);
    let first = (reached / step).round() as u32 + 1;
    let last = (BENEATH / step).round() as u32;
    let mut carrying = [true; 2];
    for i in first..=last {
        let next = step * f64::from(i);
        let at = middle + direction * (next * across);
        let distances = boundary.bvh.first_distances(at, inward, FAR * across);
        let here = distances.map(stays);
        if here == [true; 2] {
            // Sideways nothing may lie between: what is seen behind a gap is another wall.
            return i > first
                && boundary
                    .bvh
                    .first_hit_between(middle, direction, [0.0, next * across])
                    .is_none();
        }
        for ((carrying, here), d) in carrying.iter_mut().zip(here).zip(distances) {
            // The other side must be further off than before, not nearer.
            *carrying &= here;
            if !here && d < half {
                return false;
            }
        }
        if carrying == [false; 2] {
            return false;
        }
    }
    false
}

/// How far the wall goes on in one direction, in thicknesses, and how it ends. It goes on beneath a rib that is thinner than the reach, and
/// where it only gets thinner up to its end, as a ridge with a roof does, it goes on up to there.
fn reach(
    boundary: &Boundary<'_>,
    middle: DVec3,
    inward: DVec3,
    direction: DVec3,
    across: f64,
) -> (f64, End) {
    let bvh = boundary.bvh;
    let free = bvh
        .first_hit_between(middle, direction, [0.0, FAR * across])
        .map_or(f64::INFINITY, |(_, hit)| hit.t / across);
    // Infinite where either side is further off than the wall may be thick: how far does not matter then.
    let thickness = |next: f64| {
        let at = middle + direction * (next * across);
        let [a, b] = bvh.first_distances(at, inward, FAR * across);
        a + b
    };
    // Round a thick tube the ray leaves the bore beside it long before the wall ends: there the distances to both sides tell.
    let bends_on = |next: f64| {
        let at = middle + direction * (next * across);
        (across / SAME..across * SAME).contains(&boundary.distances(at, inward, across))
    };
    let goes_on =
        |here: f64, next: f64| (across / ALIKE..across * ALIKE).contains(&here) || bends_on(next);
    let step = REACH / f64::from(STEPS);
    let (mut reached, mut broken) = (0.0, false);
    let (mut before, mut tapers) = (across, true);
    for i in 1..=STEPS {
        let next = step * f64::from(i);
        if next > free {
            if broken && !tapers {
                break;
            }
            return (free, End::Free);
        }
        let here = thickness(next);
        broken = !goes_on(here, next);
        tapers &= here < before * (1.0 + ROUNDING);
        before = here;
        if !broken {
            reached = next;
        }
    }
    if broken && beneath_rib(boundary, middle, inward, direction, across, reached) {
        return (REACH, End::Open);
    }
    if broken {
        // Somewhere in the step after the last good one; never more than there is, so that a ridge as high as thick is none too wide.
        let mut half = step / 2.0;
        for _ in 0..HALVINGS {
            if goes_on(thickness(reached + half), reached + half) {
                reached += half;
            }
            half /= 2.0;
        }
        (reached, End::Other)
    } else {
        (REACH, End::Open)
    }
}
