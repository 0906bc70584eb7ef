//! Pair: which faces face each other across a wall, and which pairs make up one wall.
//!
//! Four steps. `sight` looks from every face through the material, and `extent` how far the wall goes on round each look. `gates` decides
//! which faces that see each other are a pair: the test is scale-free, the width of the wall round about against the distance, so that a
//! part may have walls of any number of thicknesses; faces that stay alone get a second chance with soft limits beside faces already paired
//! (MidSurfer, algorithm 2). `chamfers` adds the bevelled rims of walls, which look across too steeply for the gates. `walls` colours the pair graph and
//! joins pairs that continue each other into walls: smoothly, or over the risers that `risers` finds.
//!
//! Cost: some twenty to ninety rays a sample; the rest is linear in the number of faces that see each other.

mod chamfers;
mod extent;
mod gates;
mod peaks;
mod risers;
mod sight;
mod walls;

pub use gates::PairOptions;
pub use sight::sight;

use crate::model::brep::Brep;
use crate::model::sighting::Sighting;
use crate::model::walls::{Aag, Pairing};

/// Pairs, walls and thickness peaks from what the faces see.
pub fn pair(brep: &Brep, aag: &Aag, sightings: &[Sighting], options: &PairOptions) -> Pairing {
    let mut pairs = gates::pairs(aag, sightings, options);
    pairs.extend(chamfers::chamfers(brep, aag, sightings, &pairs));
    pairs.sort_by_key(|p| p.faces);
    let mut pairing = walls::walls(brep, aag, pairs);
    let (histogram, peaks) = peaks::peaks(&pairing, sightings);
    pairing.histogram = histogram;
    pairing.peaks = peaks;
    pairing
}

#[cfg(test)]
mod tests;
