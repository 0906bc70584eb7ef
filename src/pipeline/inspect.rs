//! What a part is made of, before anything is meshed.
//!
//! A solid without a thin wall is a finding here, not an error: its faces are told all the same.

use super::clock::Clock;
use super::error::PipelineError;
use super::facts::{Before, solid_facts, wall_facts};
use super::middle::Middle;
use super::seen::Seen;
use super::solid::Untangled;
use super::{Progress, import_options, midsurface, tidy};
use crate::import::{Piece, import_cad_told};
use crate::inspection::{Inspection, SolidFacts};
use crate::options::MeshOptions;
use crate::stage::sheets::Sheets;
use std::path::Path;

/// Finds out what a part is made of.
pub fn inspect(
    input: &Path,
    options: &MeshOptions,
    progress: &dyn Progress,
) -> Result<Inspection, PipelineError> {
    options.check()?;
    let mut clock = Clock::new(progress);
    let imported = clock.time("import", || {
        import_cad_told(input, &import_options(options), &mut |line| {
            progress.stage(&format!("import: {line}"));
        })
    })?;
    let mut before = Before::default();
    let solids = imported
        .pieces
        .into_iter()
        .map(|piece| inspect_solid(piece, &mut before, options, &mut clock))
        .collect::<Result<_, _>>()?;
    Ok(Inspection {
        input: input.display().to_string(),
        notes: imported.notes,
        solids,
    })
}

fn inspect_solid(
    piece: Piece,
    before: &mut Before,
    options: &MeshOptions,
    clock: &mut Clock<'_>,
) -> Result<SolidFacts, PipelineError> {
    // Of the faces in the file, before any is divided.
    let facts = clock.time("faces", || solid_facts(&piece.brep));
    let seen = Seen::new(piece, clock);
    let brep = &seen.piece.brep;
    let found = match midsurface::mid_surface(&seen, clock) {
        Ok(found) => found,
        Err(PipelineError::NoThinWall { .. }) => return Ok(facts),
        Err(error) => return Err(error),
    };
    let fair = Untangled::new(brep, &found, options, clock);
    let sheets = clock.time("size", || Sheets::new(&fair.complex));
    // Counted on the raw complex, every crumb of a sheet between two close junction curves would be one.
    let clean = clock.time("clean", || {
        let middle = Middle::new(&fair.walls, fair.leaves);
        tidy::clean(fair.complex, &fair.sizing, &middle)
    });
    let in_order = sheets.of_complex(&clean);
    let facts = wall_facts(facts, brep, &found, &clean, &in_order, before);
    *before = before.after(&in_order);
    Ok(facts)
}
