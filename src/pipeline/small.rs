//! A solid and its mid-surface without the holes and features that are smaller than the user wants them: holes first, so that a feature may have had one.

use super::clock::Clock;
use super::midsurface::MidSurface;
use crate::geom::triangle::nearest_on_triangle;
use crate::model::brep::Brep;
use crate::model::complex::MidComplex;
use crate::model::ids::{Id, NodeId};
use crate::model::removal::{Left, Obstacle, Removal, SmallKind, SmallLimits};
use crate::model::shell::ShellMesh;
use crate::stage::adjacency::adjacency;
use crate::stage::defeature::{Defeatured, fill_holes, flatten_features};

/// What is meshed instead of the solid as read.
#[derive(Clone, Debug)]
pub(super) struct Plain {
    /// The boundary without what is small.
    pub brep: Brep,
    /// Its mid-surface.
    pub found: MidSurface,
    /// What was taken out.
    pub removed: Vec<Removal>,
    /// What is small enough and stays.
    pub left: Vec<Left>,
}

/// The solid without what is small; none where nothing is to be taken out.
pub(super) fn plain(
    brep: &Brep,
    found: &MidSurface,
    limits: &SmallLimits,
    clock: &mut Clock<'_>,
) -> Option<Plain> {
    if limits.are_none() {
        return None;
    }
    clock.time("defeature", || {
        let mut plain = Plain {
            brep: brep.clone(),
            found: found.clone(),
            removed: Vec::new(),
            left: Vec::new(),
        };
        for step in [fill_holes, flatten_features] {
            let MidSurface {
                aag,
                pairing,
                complex,
                ..
            } = &plain.found;
            let next = step(&plain.brep, aag, pairing, complex, limits);
            plain.take(next);
        }
        Some(plain)
    })
}

impl Plain {
    /// Goes on with what a step has left, if it kept its promises: else all that it took out stays.
    fn take(&mut self, next: Defeatured) {
        self.left.extend(next.left.iter().cloned());
        if !keeps_the_rest(&self.brep, &self.found.complex, &next) {
            self.left.extend(next.removed.iter().map(|r| Left {
                kind: r.kind,
                solid: r.solid,
                at: r.at,
                size: r.size,
                why: Obstacle::Together,
            }));
        } else if !next.removed.is_empty() {
            self.found.aag = adjacency(&next.brep);
            self.brep = next.brep;
            self.found.pairing = next.pairing;
            self.found.complex = next.complex;
            self.removed.extend(next.removed);
        }
    }
}

/// Whether a step leaves a sound boundary, and all topology but that of the holes that it filled: the boundary of a solid gains two with every hole that it loses, the
/// mid-surface one.
fn keeps_the_rest(brep: &Brep, complex: &MidComplex, next: &Defeatured) -> bool {
    let holes = next.removed.iter().filter(|r| r.kind == SmallKind::Hole);
    let filled = holes.count() as i64;
    next.brep.check().is_empty()
        && next.brep.euler() - brep.euler() == 2 * filled
        && next.complex.euler() - complex.euler() == filled
}

/// Names the sheet that goes on where each removal was: that of the nearest element of its solid.
pub(super) fn name_sheets(removed: &mut [Removal], mesh: &ShellMesh) {
    for removal in removed {
        let away = |corners: &[NodeId]| {
            let p = |i: usize| mesh.nodes[corners[i]];
            let halves = (2..corners.len()).map(|i| [p(0), p(i - 1), p(i)]);
            (halves.map(|t| nearest_on_triangle(t, removal.at).distance_squared(removal.at)))
                .fold(f64::INFINITY, f64::min)
        };
        let nearest = (mesh.elements.iter())
            .filter(|e| mesh.sheets[e.sheet].solid_tag == removal.solid)
            .map(|e| (away(e.corners.as_slice()), e.sheet))
            .min_by(|a, b| a.0.total_cmp(&b.0));
        removal.sheet = nearest.map(|(_, sheet)| sheet.index() + 1);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::test_parts::stages::stages;
    use crate::test_parts::voxels::plate_with_hole;

    #[test]
    fn a_step_that_changes_more_than_its_holes_is_found() {
        let solid = plate_with_hole();
        let s = stages(&solid);
        let before = s.complex();
        let limits = SmallLimits {
            hole: Some(1e3),
            feature: None,
        };
        let next = fill_holes(&solid.brep, &s.aag, &s.pairing, &before, &limits);
        assert_eq!(next.removed.len(), 1);
        let keeps = |next: &Defeatured| keeps_the_rest(&solid.brep, &before, next);
        assert!(keeps(&next));
        // A hole that is told but not filled, one in the mid-surface alone, a boundary with a gap.
        let mut told = next.clone();
        told.removed.push(next.removed[0].clone());
        let mut torn = next.clone();
        torn.complex = before.clone();
        let mut open = next.clone();
        open.brep = solid.brep.clone();
        for bad in [told, torn, open] {
            assert!(!keeps(&bad));
        }
    }
}
