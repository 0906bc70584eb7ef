//! CalculiX deck: `S3` and `S4` shells.
//!
//! A sheet of constant thickness has its own `*SHELL SECTION`; a varying one takes `NODAL THICKNESS`, from `*NODAL THICKNESS` (the thickness in its section is
//! read and ignored). Where varying sheets of different thickness meet, a node cannot serve them all: the elements there get sections of their mean
//! thickness. That makes rigid knots on the far side of this one row of elements, measured to stiffen a cantilever of S4 by 0.01 %; a nodal mean would put a 1 mm rib
//! on a 3 mm plate at 2 mm.
//!
//! Limits: CalculiX expands `S3` into one linear wedge, which locks in bending: a cantilever plate of triangles five thicknesses long deflects 0.53 of theory, at
//! 1.25 thicknesses 0.89 (quads: 0.999). The deck says so where it has triangles; prefer quads for CalculiX. The deck has no step.
//!
//! Reference: CalculiX CrunchiX user's manual, `*SHELL SECTION`, `*NODAL THICKNESS`.

use super::ExportOptions;
use super::cells::cells;
use super::checked::sheet_name;
use super::deck::Deck;
use super::sections::{by_sheet, clashing_groups, plan};
use super::sets::sets;
use crate::model::ids::Id;
use crate::model::shell::ShellMesh;

pub(super) fn render(mesh: &ShellMesh, options: &ExportOptions<'_>) -> Vec<u8> {
    let cells = cells(mesh);
    let sets = sets(mesh, &cells);
    let plan = plan(mesh, &cells);
    let mut deck = Deck::start("CalculiX", ["S3", "S4"], mesh, &cells, &sets, options);
    let triangles = cells.iter().filter(|c| c.corners.len() == 3).count();
    if triangles > 0 {
        deck.line(&format!(
            "** {triangles} elements are S3, which CalculiX makes much too stiff in bending where they are longer than the thickness."
        ));
    }
    for (sheet, places) in mesh.sheets.ids().zip(by_sheet(mesh, &cells)) {
        let name = sheet_name(sheet);
        let served: Vec<usize> = places
            .iter()
            .filter(|&&place| !plan.clashing[place])
            .map(|&place| cells[place].number)
            .collect();
        if served.is_empty() {
            continue;
        }
        if let Some(thickness) = plan.constant[sheet.index()] {
            deck.section(&name, "", thickness);
            continue;
        }
        let sum: f64 = places
            .iter()
            .map(|&place| cells[place].mean_thickness())
            .sum();
        let mean = sum / places.len() as f64;
        if served.len() == places.len() {
            deck.section(&name, ", NODAL THICKNESS", mean);
        } else {
            let part = format!("{name}_NODAL");
            deck.element_set(&part, &served);
            deck.section(&part, ", NODAL THICKNESS", mean);
        }
    }
    let groups = clashing_groups(&cells, &plan);
    for (k, (thickness, numbers)) in groups.iter().enumerate() {
        let name = format!("JUNCTION_ROW_{}", k + 1);
        deck.element_set(&name, numbers);
        deck.section(&name, "", *thickness);
    }
    deck.nodal_thickness(&plan.nodal);
    deck.finish()
}

#[cfg(test)]
mod tests {
    use super::super::Format;
    use super::super::tests::{quad, text};
    use crate::model::ids::NodeId;
    use glam::DVec3;

    #[test]
    fn one_quad_golden() {
        let deck = text(Format::Calculix, &quad([1.5; 4]));
        let body: Vec<&str> = deck.lines().filter(|l| !l.starts_with("**")).collect();
        let expected = "*HEADING\nmid-surface shell mesh\n*NODE, NSET=NALL\n1, 0.0, 0.0, 0.0\n2, 1.0, 0.0, 0.0\n3, 1.0, 1.0, 0.0\n4, 0.0, 1.0, 0.0\n\
            *ELEMENT, TYPE=S4, ELSET=EALL\n1, 1, 2, 3, 4\n*ELSET, ELSET=SHEET_1\n1\n*ELSET, ELSET=SOLID_1\n1\n*ELSET, ELSET=FACE_5\n1\n*ELSET, ELSET=FACE_6\n1\n\
            *NSET, NSET=SHEET_1\n1, 2, 3, 4\n*NSET, NSET=FACE_5\n1, 2, 3, 4\n*NSET, NSET=FACE_6\n1, 2, 3, 4\n*NSET, NSET=RIM\n1, 2, 3, 4\n\
            *MATERIAL, NAME=STEEL\n*ELASTIC\n210000.0, 0.3\n*DENSITY\n7.85e-9\n*SHELL SECTION, ELSET=SHEET_1, MATERIAL=STEEL\n1.5";
        assert_eq!(body.join("\n"), expected);
    }

    #[test]
    fn varying_thickness_is_nodal_and_a_reflex_quad_becomes_two_triangles() {
        let mut mesh = quad([1.0, 1.0, 2.0, 1.0]);
        mesh.nodes[NodeId(2)] = DVec3::new(0.4, 0.4, 0.0);
        let deck = text(Format::Calculix, &mesh);
        assert!(!deck.contains("TYPE=S4"));
        assert!(deck.contains("*ELEMENT, TYPE=S3, ELSET=EALL\n1, 3, 4, 1\n2, 3, 1, 2\n"));
        assert!(deck.contains("*ELSET, ELSET=FACE_5\n1, 2\n"));
        assert!(deck.ends_with("*NODAL THICKNESS\n1, 1.0\n2, 1.0\n3, 2.0\n4, 1.0\n"));
    }
}
