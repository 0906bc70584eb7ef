//! CalculiX deck: `S4` shells where all elements are quads, else `S6` and `S8R`.
//!
//! CalculiX makes one layer of solid elements of its shells. Of an `S3` that is a linear wedge, which locks in bending, so triangles are written
//! as `S6`, with a node in the middle of each straight side, and quads beside them as `S8R`, to fit. Tip deflection of a cantilever plate 1 mm thick in
//! cells of 5 mm, over beam theory: `S3` 0.533, `S6` 0.99996, `S4` 0.99944, `S6` and `S8R` mixed 1.00001.
//! The nodes of the mesh keep their numbers; the mid-side nodes follow, are in every set that their side lies in, and have the mean thickness of its ends.
//!
//! A sheet of constant thickness has its own `*SHELL SECTION`; a varying one takes `NODAL THICKNESS`, from `*NODAL THICKNESS` (the thickness in its section is
//! read and ignored). Where varying sheets of different thickness meet, a node cannot serve them all: the elements there get sections of their mean
//! thickness. That makes rigid knots on the far side of this one row of elements, measured to stiffen a cantilever by 0.01 %; a nodal mean would put a 1 mm rib
//! on a 3 mm plate at 2 mm.
//!
//! An element much shorter than it is thick may be turned inside out by its neighbours' normals: it gets its own (see `own_normals`).
//!
//! Limits: a load shared out evenly over the nodes of an edge is not a line load for elements of second order (mid-side nodes carry two thirds of it). The deck
//! has no step.
//!
//! Reference: CalculiX CrunchiX user's manual, `*SHELL SECTION`, `*NODAL THICKNESS`.

use super::ExportOptions;
use super::cells::cells;
use super::checked::sheet_name;
use super::deck::Deck;
use super::mid_side::MidSides;
use super::own_normals::own_normals;
use super::sections::{by_sheet, clashing_groups, plan};
use super::sets::sets;
use crate::model::ids::Id;
use crate::model::shell::ShellMesh;

pub(super) fn render(mesh: &ShellMesh, options: &ExportOptions<'_>) -> Vec<u8> {
    let cells = cells(mesh);
    // Elements of first and of second order do not fit together: one triangle decides for all.
    let (types, mids) = if cells.iter().any(|c| c.corners.len() == 3) {
        (["S6", "S8R"], MidSides::of(mesh, &cells))
    } else {
        (["S3", "S4"], MidSides::default())
    };
    let sets = sets(mesh, &cells, &mids);
    let plan = plan(mesh, &cells, &mids);
    let mut deck = Deck::start("CalculiX", types, mesh, (&cells, &mids), &sets, options);
    deck.normals(&own_normals(mesh, &cells), (&cells, &mids));
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
    use crate::model::ids::{ElementId, NodeId};
    use crate::model::shell::Corners;
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
    fn a_quad_beside_a_triangle_is_of_second_order_too() {
        let mut mesh = quad([1.0; 4]);
        let mut half = mesh.elements[ElementId(0)].clone();
        half.corners = Corners::Triangle([0, 1, 2].map(NodeId));
        mesh.elements.push(half);
        let deck = text(Format::Calculix, &mesh);
        // Sides 0-1, 0-2, 0-3, 1-2, 2-3 have nodes 5 to 9.
        assert!(deck.contains("*ELEMENT, TYPE=S6, ELSET=EALL\n2, 1, 2, 3, 5, 8, 6\n"));
        assert!(deck.contains("*ELEMENT, TYPE=S8R, ELSET=EALL\n1, 1, 2, 3, 4, 5, 8, 9, 7\n"));
    }

    #[test]
    fn varying_thickness_is_nodal_and_a_reflex_quad_becomes_two_triangles() {
        let mut mesh = quad([1.0, 1.0, 2.0, 1.0]);
        mesh.nodes[NodeId(2)] = DVec3::new(0.4, 0.4, 0.0);
        let deck = text(Format::Calculix, &mesh);
        assert!(!deck.contains("TYPE=S4"));
        // Sides 0-1, 0-2, 0-3, 1-2, 2-3 have nodes 5 to 9.
        assert!(deck.contains("\n4, 0.0, 1.0, 0.0\n5, 0.5, 0.0, 0.0\n6, 0.2, 0.2, 0.0\n"));
        assert!(
            deck.contains(
                "*ELEMENT, TYPE=S6, ELSET=EALL\n1, 3, 4, 1, 9, 7, 6\n2, 3, 1, 2, 6, 5, 8\n"
            )
        );
        assert!(deck.contains("*ELSET, ELSET=FACE_5\n1, 2\n"));
        assert!(deck.contains("*NSET, NSET=FACE_5\n1, 2, 3, 4, 5, 6, 7, 8, 9\n"));
        assert!(deck.contains("*NSET, NSET=RIM\n1, 2, 3, 4, 5, 7, 8, 9\n"));
        assert!(deck.ends_with(
            "*NODAL THICKNESS\n1, 1.0\n2, 1.0\n3, 2.0\n4, 1.0\n5, 1.0\n6, 1.5\n7, 1.0\n8, 1.5\n9, 1.5\n"
        ));
    }
}
