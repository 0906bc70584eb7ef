//! Closed forms for every step of pairing.

mod chamfers;
mod gates;
mod risers;
mod sight;
mod walls;

use super::*;
use crate::model::ids::FaceId;
use crate::stage::adjacency::adjacency;

/// The whole of pairing, as the pipeline calls it.
fn paired(brep: &Brep) -> Pairing {
    let found = pair(
        brep,
        &adjacency(brep),
        &sight(brep),
        &PairOptions::default(),
    );
    assert_eq!(found.check(), vec![]);
    found
}

/// The pairs by their faces.
fn faces(pairing: &Pairing) -> Vec<[u32; 2]> {
    pairing.pairs.iter().map(|p| p.faces.map(|f| f.0)).collect()
}

/// The two ids in order.
fn sorted(a: FaceId, b: FaceId) -> [u32; 2] {
    [a.0.min(b.0), a.0.max(b.0)]
}
