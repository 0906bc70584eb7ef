//! How far beyond its blends a wall may be carried on.

use crate::model::walls::{Aag, Convexity, Pairing, Wall};

/// A blend turns from the side that it leads on from by less than this: a chamfer does by 45 degrees, the wall of a boss by 90.
const BLEND_RAD: f64 = std::f64::consts::FRAC_PI_3;

/// The width of the widest blend that leads on from a side of the wall: the fillet or chamfer at its foot ends the side before the block where walls join.
pub(super) fn blends(aag: &Aag, pairing: &Pairing, wall: &Wall) -> f64 {
    wall.sides
        .iter()
        .flatten()
        .flat_map(|&f| aag.arcs_of(f).map(move |a| (a, Aag::across(a, f))))
        .filter(|(a, g)| {
            pairing.side[*g].is_none()
                && a.convexity != Convexity::Convex
                && a.turn_rad.abs() < BLEND_RAD
        })
        .map(|(_, g)| 2.0 * aag.area[g] / aag.perimeter[g].max(f64::MIN_POSITIVE))
        .fold(0.0, f64::max)
}
