//! A solid and what its faces see of each other.

use super::clock::Clock;
use crate::import::Piece;
use crate::model::sighting::Sighting;
use crate::stage::{divide, pair};

/// A filled solid none of whose faces lies on both sides of a wall.
pub(super) struct Seen {
    /// The solid, with such faces divided.
    pub piece: Piece,
    /// What its faces see through the material.
    pub sightings: Vec<Sighting>,
}

impl Seen {
    /// Looks, and looks again where a face had to be divided.
    pub fn new(mut piece: Piece, clock: &mut Clock<'_>) -> Self {
        if let Some(brep) = clock.time("divide", || divide::divide_at_corners(&piece.brep)) {
            piece.brep = brep;
        }
        let mut sightings = clock.time("pair", || pair::sight(&piece.brep));
        let divided = clock.time("divide", || divide::divide(&piece.brep, &sightings));
        if let Some(brep) = divided {
            piece.brep = brep;
            sightings = clock.time("pair", || pair::sight(&piece.brep));
        }
        Self { piece, sightings }
    }
}
