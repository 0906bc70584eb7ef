//! Complexes put in order: untangled before anything has a size, without specks before they are meshed, mended when they are.
//!
//! Each step is a stage's; here stands which follows on which, and how often.

use super::clock::Clock;
use super::fins;
use super::middle::Middle;
use super::midsurface::MidSurface;
use crate::geom::orient;
use crate::geom::pinhole::open_pinholes;
use crate::geom::placer::Placer;
use crate::medial::{Held, Medial};
use crate::model::complex::MidComplex;
use crate::model::ids::{TriangleId, WallId};
use crate::stage::fair::FairStats;
use crate::stage::size::Sizing;
use crate::stage::{extract, fair, prune, remesh};
use glam::DVec3;

/// Rounds of untangling; every one takes the knots of the last away.
const KNOT_ROUNDS: usize = 8;
/// Share of an untangled complex outside the material from which its sheets are held inside: the audit doubts a mesh of which a little more lies outside.
const LEAVES: f64 = 0.005;

/// Folded triangles.
pub(super) fn folds(complex: &MidComplex) -> usize {
    orient::folded(complex).len()
}

/// The changed complex, or the old one where sheets would come to hang together only by a point: contraction keeps the homotopy type, not that.
pub(super) fn connected(
    old: MidComplex,
    change: impl FnOnce(MidComplex) -> MidComplex,
) -> MidComplex {
    let new = change(old.clone());
    if new.pieces() == old.pieces() {
        new
    } else {
        old
    }
}

/// The raw complex untangled, and whether its sheets had to be held in the material. Holding what does not leave it would only stand in the way of untangling.
pub(super) fn untangled(
    found: &MidSurface,
    walls: &Medial<'_>,
    clock: &mut Clock<'_>,
) -> (MidComplex, bool) {
    clock.time("fair", || {
        let fair = untangled_by(found, walls, walls);
        let held = Held::new(walls);
        if held.outside(&fair) > LEAVES {
            (untangled_by(found, walls, &held), true)
        } else {
            (fair, false)
        }
    })
}

fn untangled_by(found: &MidSurface, walls: &Medial<'_>, medial: &dyn Placer) -> MidComplex {
    let thickness = |w: WallId| walls.mean_thickness(w);
    let (complex, _) = fair::fair(extract::place(found.complex.clone(), medial), medial);
    let complex = connected(complex, |c| remesh::merge_strips(c, &thickness, medial));
    let complex = connected(complex, |c| remesh::without_flat(c, medial));
    // Where strips have become curves, what hung between them is a fin.
    let (complex, _) = prune::prune(complex, medial);
    let complex = unknotted(fair::fair(complex, medial), medial);
    let complex = connected(complex, |c| remesh::without_flat(c, medial));
    let (complex, _) = prune::prune(complex, medial);
    // A junction of five walls parts twice on its way to a rim: the second slit shows when the strips between its curves are gone.
    connected(complex, |c| remesh::merge_slits(c, &thickness, medial))
}

/// Contracts what is still turned and untangles again, in turns.
fn unknotted((mut complex, mut stats): (MidComplex, FairStats), medial: &dyn Placer) -> MidComplex {
    for _ in 1..KNOT_ROUNDS {
        if stats.turned_after == 0 {
            break;
        }
        let next = connected(complex, |c| remesh::contract_turned(c, medial));
        (complex, stats) = fair::fair_again(next, medial);
    }
    complex
}

/// An untangled complex without what is far smaller than an element.
pub(super) fn clean(fair: MidComplex, sizing: &Sizing, middle: &Middle<'_>) -> MidComplex {
    let field = middle.field(sizing);
    let shortest = |p: DVec3, w: WallId| sizing.speck(field(p, w));
    let complex = remesh::clean(fair, &shortest, middle.placer());
    // The remesher refines a fold into many.
    connected(complex, |c| remesh::unfold(c, middle.placer()))
}

/// A meshed complex with as few folds as can be had.
pub(super) fn unfolded(complex: MidComplex, medial: &dyn Placer) -> MidComplex {
    let complex = mended(complex, medial);
    let complex = connected(complex, |c| remesh::without_flat(c, medial));
    let complex = connected(complex, |c| fins::unfinned(c, medial));
    let mut complex = connected(complex, |c| remesh::unfold(c, medial));
    open_pinholes(&mut complex);
    complex
}

/// A meshed complex with fewer turned or folded triangles, if it can be had.
fn mended(mut complex: MidComplex, medial: &dyn Placer) -> MidComplex {
    // What is folded over stops a solver; what only leans from its wall's normal may be a coarse bend.
    let count = |c: &MidComplex| {
        let all: Vec<TriangleId> = c.triangles.ids().collect();
        (folds(c), orient::turned(c, &all, medial).len())
    };
    let mut left = count(&complex);
    for _ in 0..KNOT_ROUNDS {
        if left == (0, 0) {
            break;
        }
        let next = connected(complex.clone(), |c| remesh::contract_folded(c, medial));
        let (next, _) = fair::fair_again(next, medial);
        let now = count(&next);
        if now >= left {
            break;
        }
        (complex, left) = (next, now);
    }
    complex
}
