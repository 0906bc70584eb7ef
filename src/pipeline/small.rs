//! A solid and its mid-surface without the holes and features that are smaller than the user wants them: holes first, so that a feature may have had one.

use super::clock::Clock;
use super::error::PipelineError;
use super::midsurface::MidSurface;
use crate::model::brep::Brep;
use crate::model::ids::{Id, SheetId};
use crate::model::removal::{Left, Removal, SmallKind, SmallLimits};
use crate::model::shell::ShellMesh;
use crate::stage::adjacency::adjacency;
use crate::stage::defeature::{Defeatured, fill_holes, flatten_features};
use glam::DVec3;

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
) -> Result<Option<Plain>, PipelineError> {
    if limits.are_none() {
        return Ok(None);
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
            plain.take(next)?;
        }
        Ok(Some(plain))
    })
}

impl Plain {
    /// Goes on with what a step has left, after a look at its promises.
    fn take(&mut self, next: Defeatured) -> Result<(), PipelineError> {
        let holes = next.removed.iter().filter(|r| r.kind == SmallKind::Hole);
        let filled = holes.count() as i64;
        let internal = |what: String| PipelineError::Internal {
            stage: "defeature",
            what,
        };
        if let Some(fault) = next.brep.check().first() {
            return Err(internal(fault.to_string()));
        }
        // The boundary of a solid gains two with every hole that it loses, the mid-surface one.
        let gains = [
            next.brep.euler() - self.brep.euler(),
            2 * (next.complex.euler() - self.found.complex.euler()),
        ];
        if gains != [2 * filled; 2] {
            let what = format!("{filled} holes filled, but twice the gains are {gains:?}");
            return Err(internal(what));
        }
        if !next.removed.is_empty() {
            self.found.aag = adjacency(&next.brep);
            self.brep = next.brep;
            self.found.pairing = next.pairing;
            self.found.complex = next.complex;
        }
        self.removed.extend(next.removed);
        self.left.extend(next.left);
        Ok(())
    }
}

/// Names the sheet that goes on where each removal was: that of the nearest element.
pub(super) fn name_sheets(removed: &mut [Removal], mesh: &ShellMesh) {
    let centres: Vec<(DVec3, SheetId)> = (mesh.elements.iter())
        .map(|e| {
            let corners = e.corners.as_slice();
            let sum: DVec3 = corners.iter().map(|&n| mesh.nodes[n]).sum();
            (sum / corners.len() as f64, e.sheet)
        })
        .collect();
    for removal in removed {
        let away = |(centre, _): &&(DVec3, SheetId)| centre.distance_squared(removal.at);
        let nearest = centres.iter().min_by(|a, b| away(a).total_cmp(&away(b)));
        removal.sheet = nearest.map(|(_, sheet)| sheet.index() + 1);
    }
}
