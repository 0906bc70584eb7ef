//! Abaqus deck: `S3` and `S4R` shells, a flat deck without parts or steps.
//!
//! A sheet of constant thickness has its own `*SHELL SECTION`; a varying one takes `NODAL THICKNESS`. Where varying sheets of different thickness meet, a node
//! cannot serve them all: such a sheet gets one thickness an element by `SHELL THICKNESS=` and a `*DISTRIBUTION`.
//!
//! Limits: read back by meshio in the tests, not run in Abaqus.
//!
//! Reference: Abaqus keyword reference, `*SHELL SECTION`, `*NODAL THICKNESS`, `*DISTRIBUTION`.

use super::ExportOptions;
use super::cells::{Cell, cells};
use super::checked::sheet_name;
use super::deck::{Deck, real};
use super::mid_side::MidSides;
use super::sections::{Plan, by_sheet, plan};
use super::sets::sets;
use crate::model::ids::Id;
use crate::model::shell::ShellMesh;

pub(super) fn render(mesh: &ShellMesh, options: &ExportOptions<'_>) -> Vec<u8> {
    let cells = cells(mesh);
    let mids = MidSides::default();
    let sets = sets(mesh, &cells, &mids);
    let plan = plan(mesh, &cells, &mids);
    let mut deck = Deck::start(
        "Abaqus",
        ["S3", "S4R"],
        mesh,
        (&cells, &mids),
        &sets,
        options,
    );
    if plan.clashing.contains(&true) {
        deck.line("*DISTRIBUTION TABLE, NAME=THICKNESS_TABLE");
        deck.line("LENGTH");
    }
    for (sheet, places) in mesh.sheets.ids().zip(by_sheet(mesh, &cells)) {
        if !places.is_empty() {
            let of_sheet: Vec<&Cell> = places.iter().map(|&place| &cells[place]).collect();
            let constant = plan.constant[sheet.index()];
            let clashes = places.iter().any(|&place| plan.clashing[place]);
            section(&mut deck, &sheet_name(sheet), &of_sheet, constant, clashes);
        }
    }
    deck.nodal_thickness(&nodal_values(mesh, &cells, &plan));
    deck.finish()
}

/// The section of one sheet.
fn section(deck: &mut Deck, name: &str, cells: &[&Cell], constant: Option<f64>, clashes: bool) {
    if let Some(thickness) = constant {
        deck.section(name, "", thickness);
        return;
    }
    // Abaqus reads and ignores this one.
    let mean = cells.iter().map(|c| c.mean_thickness()).sum::<f64>() / cells.len() as f64;
    if !clashes {
        deck.section(name, ", NODAL THICKNESS", mean);
        return;
    }
    let distribution = format!("THICKNESS_{name}");
    deck.line(&format!(
        "*DISTRIBUTION, NAME={distribution}, LOCATION=ELEMENT, TABLE=THICKNESS_TABLE"
    ));
    deck.line(&format!(", {}", real(mean)));
    for cell in cells {
        deck.line(&format!("{}, {}", cell.number, real(cell.mean_thickness())));
    }
    deck.section(name, &format!(", SHELL THICKNESS={distribution}"), mean);
}

/// The nodal values, if any sheet takes them.
fn nodal_values(mesh: &ShellMesh, cells: &[Cell], plan: &Plan) -> Vec<(usize, f64)> {
    let mut clashes = vec![false; mesh.sheets.len()];
    for (cell, clashing) in cells.iter().zip(&plan.clashing) {
        clashes[mesh.elements[cell.element].sheet.index()] |= clashing;
    }
    let takes = |cell: &Cell| {
        let sheet = mesh.elements[cell.element].sheet.index();
        plan.constant[sheet].is_none() && !clashes[sheet]
    };
    if cells.iter().any(takes) {
        plan.nodal.clone()
    } else {
        Vec::new()
    }
}

#[cfg(test)]
mod tests {
    use super::super::Format;
    use super::super::tests::{quad, text};
    use crate::model::ids::{ElementId, SheetId};

    #[test]
    fn constant_and_varying_sections() {
        let constant = text(Format::Abaqus, &quad([1.5; 4]));
        assert!(constant.contains("*ELEMENT, TYPE=S4R, ELSET=EALL\n"));
        assert!(constant.ends_with("*SHELL SECTION, ELSET=SHEET_1, MATERIAL=STEEL\n1.5\n"));
        let varying = text(Format::Abaqus, &quad([1.0, 1.0, 2.0, 2.0]));
        assert!(varying.ends_with(
            "*SHELL SECTION, ELSET=SHEET_1, MATERIAL=STEEL, NODAL THICKNESS\n1.5\n\
             *NODAL THICKNESS\n1, 1.0\n2, 1.0\n3, 2.0\n4, 2.0\n"
        ));
    }

    #[test]
    fn clashing_sheets_get_distributions() {
        let mut mesh = quad([1.0, 1.0, 2.0, 2.0]);
        let mut other = mesh.elements[ElementId(0)].clone();
        other.sheet = SheetId(1);
        other.thickness = [3.0, 3.0, 4.0, 4.0];
        mesh.elements.push(other);
        mesh.sheets.push(mesh.sheets[SheetId(0)].clone());
        let deck = text(Format::Abaqus, &mesh);
        assert!(deck.contains(
            "*DISTRIBUTION, NAME=THICKNESS_SHEET_2, LOCATION=ELEMENT, TABLE=THICKNESS_TABLE\n, 3.5\n2, 3.5\n\
             *SHELL SECTION, ELSET=SHEET_2, MATERIAL=STEEL, SHELL THICKNESS=THICKNESS_SHEET_2\n3.5\n"
        ));
        assert!(!deck.contains("*NODAL THICKNESS"));
    }
}
