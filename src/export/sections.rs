//! How thickness reaches Abaqus and CalculiX: one value a sheet where it is constant, one a node where it varies.
//!
//! CalculiX makes a rigid knot of every node whose elements differ in thickness, however little. Sheets that are constant within [`CONSTANT`] and near to each other
//! therefore share one number. A varying sheet takes nodal thickness, which makes no knots.
//!
//! A node has but one nodal thickness. Where varying sheets of different thickness meet, it would be wrong for all of them: the elements there
//! ([`Plan::clashing`]) must get theirs in another way.

use super::cells::Cell;
use super::mid_side::{MidSides, sides_of};
use super::number_of;
use crate::model::ids::{Id, NodeId};
use crate::model::shell::ShellMesh;
use std::collections::BTreeMap;

/// Spread of thickness, relative to its least value, within which a sheet counts as constant: half of it is the error, which changes the bending stiffness by 0.15 %.
pub(super) const CONSTANT: f64 = 1e-3;

/// Relative difference between a node's thickness and a corner's beyond which the corner is not served by it: 1 % changes the bending stiffness of its element by 3 %.
const CLASH: f64 = 1e-2;

/// The thickness of each sheet of a deck.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Plan {
    /// For each sheet its constant thickness, mm; `None` where it varies, or has no element.
    pub constant: Vec<Option<f64>>,
    /// Node numbers and thickness, mm, of the nodes of those cells that nodal thickness serves, ascending.
    pub nodal: Vec<(usize, f64)>,
    /// For each cell whether it is of a varying sheet and nodal thickness would be wrong at a corner.
    pub clashing: Vec<bool>,
}

/// Decides for every sheet. A mid-side node has the mean thickness of the ends of its side: nodal thickness that serves both of them serves it too.
pub(super) fn plan(mesh: &ShellMesh, cells: &[Cell], mids: &MidSides) -> Plan {
    let constant = constants(mesh);
    let varies = |cell: &Cell| constant[mesh.elements[cell.element].sheet.index()].is_none();
    // Only corners of varying sheets count: a constant neighbour has its own section.
    let mut sums = vec![(0.0, 0_u32); mesh.nodes.len()];
    for cell in cells.iter().filter(|c| varies(c)) {
        for (node, thickness) in cell.corners.iter().zip(&cell.thickness) {
            sums[node.index()].0 += thickness;
            sums[node.index()].1 += 1;
        }
    }
    let mean = |(sum, count): (f64, u32)| sum / f64::from(count);
    let clashing = cells.iter().map(|cell| {
        let wrong = |(node, thickness): (&NodeId, &f64)| {
            (mean(sums[node.index()]) - thickness).abs() > CLASH * thickness
        };
        varies(cell) && cell.corners.iter().zip(&cell.thickness).any(wrong)
    });
    let clashing: Vec<bool> = clashing.collect();
    let mut served = vec![false; mesh.nodes.len()];
    for (cell, clashing) in cells.iter().zip(&clashing) {
        if varies(cell) && !clashing {
            for node in &cell.corners {
                served[node.index()] = true;
            }
        }
    }
    let at_corner = |node: &NodeId| mean(sums[node.index()]);
    let corners = mesh.nodes.ids().filter(|node| served[node.index()]);
    let mut nodal: Vec<(usize, f64)> = corners.map(|n| (number_of(n), at_corner(&n))).collect();
    let mut between = BTreeMap::new();
    for (cell, clashing) in cells.iter().zip(&clashing) {
        if varies(cell) && !clashing {
            for side in sides_of(cell) {
                if let Some(number) = mids.between(side) {
                    between.insert(number, 0.5 * side.iter().map(at_corner).sum::<f64>());
                }
            }
        }
    }
    nodal.extend(between);
    Plan {
        constant,
        nodal,
        clashing,
    }
}

/// For each sheet its cells, by their places in `cells`.
pub(super) fn by_sheet(mesh: &ShellMesh, cells: &[Cell]) -> Vec<Vec<usize>> {
    let mut places = vec![Vec::new(); mesh.sheets.len()];
    for (place, cell) in cells.iter().enumerate() {
        places[mesh.elements[cell.element].sheet.index()].push(place);
    }
    places
}

/// The constant thickness of each sheet that has one. Sheets are gathered, thinnest first, as long as all of them stay within [`CONSTANT`].
fn constants(mesh: &ShellMesh) -> Vec<Option<f64>> {
    let mut ranges = vec![(f64::INFINITY, 0.0_f64); mesh.sheets.len()];
    for element in mesh.elements.iter() {
        let (low, high) = &mut ranges[element.sheet.index()];
        for &thickness in &element.thickness[..element.corners.as_slice().len()] {
            *low = low.min(thickness);
            *high = high.max(thickness);
        }
    }
    let steady: Vec<(usize, (f64, f64))> = ranges
        .iter()
        .copied()
        .enumerate()
        .filter(|(_, (low, high))| *high > 0.0 && *high <= low * (1.0 + CONSTANT))
        .collect();
    let mut constants = vec![None; mesh.sheets.len()];
    for (thickness, group) in gather(steady) {
        for sheet in group {
            constants[sheet] = Some(thickness);
        }
    }
    constants
}

/// The clashing cells in groups of one thickness, mm, with their numbers: thinnest group first.
pub(super) fn clashing_groups(cells: &[Cell], plan: &Plan) -> Vec<(f64, Vec<usize>)> {
    let clashing = cells
        .iter()
        .zip(&plan.clashing)
        .filter(|(_, clashing)| **clashing);
    gather(
        clashing
            .map(|(cell, _)| (cell.number, (cell.mean_thickness(), cell.mean_thickness())))
            .collect(),
    )
}

/// Gathers numbered ranges of thickness, thinnest first, as long as all of a group stay within [`CONSTANT`]; each group with the middle of its range.
fn gather(mut ranges: Vec<(usize, (f64, f64))>) -> Vec<(f64, Vec<usize>)> {
    ranges.sort_by(|(i, a), (j, b)| a.0.total_cmp(&b.0).then(i.cmp(j)));
    let mut groups = Vec::new();
    let mut rest = ranges.as_slice();
    while let Some((_, (low, _))) = rest.first() {
        let within = |(_, (_, high)): &&(usize, (f64, f64))| *high <= low * (1.0 + CONSTANT);
        let count = rest.iter().take_while(within).count().max(1);
        let (group, others) = rest.split_at(count);
        let high = group
            .iter()
            .map(|(_, (_, high))| *high)
            .fold(*low, f64::max);
        let mut numbers: Vec<usize> = group.iter().map(|(number, _)| *number).collect();
        numbers.sort_unstable();
        groups.push((0.5 * (low + high), numbers));
        rest = others;
    }
    groups
}

#[cfg(test)]
mod tests {
    use super::super::cells::cells;
    use super::super::tests::quad;
    use super::*;
    use crate::model::ids::{ElementId, SheetId};

    /// Quads on the same four nodes, one sheet each: only thickness matters here.
    fn stacked(thickness: &[[f64; 4]]) -> Plan {
        let mut mesh = quad(thickness[0]);
        for (k, &t) in thickness.iter().enumerate().skip(1) {
            let mut element = mesh.elements[ElementId(0)].clone();
            let sheet = mesh.sheets[SheetId(0)].clone();
            element.thickness = t;
            element.sheet = SheetId(k as u32);
            mesh.elements.push(element);
            mesh.sheets.push(sheet);
        }
        plan(&mesh, &cells(&mesh), &MidSides::default())
    }

    #[test]
    fn near_sheets_share_one_number_and_far_ones_do_not() {
        let plan = stacked(&[[2.0; 4], [1.0; 4], [2.0015; 4], [2.003; 4]]);
        assert_eq!(
            plan.constant,
            [Some(2.00075), Some(1.0), Some(2.00075), Some(2.003)]
        );
        assert!(plan.nodal.is_empty());
    }

    #[test]
    fn one_thickness_stays_exact() {
        assert_eq!(stacked(&[[0.1; 4], [0.1; 4]]).constant, [Some(0.1); 2]);
    }

    #[test]
    fn a_varying_sheet_gets_nodal_values_that_a_constant_neighbour_does_not_touch() {
        let taper = [1.0, 2.0, 2.0, 1.0];
        let plan = stacked(&[taper, [9.0; 4]]);
        assert_eq!(plan.constant, [None, Some(9.0)]);
        assert_eq!(plan.nodal, [(1, 1.0), (2, 2.0), (3, 2.0), (4, 1.0)]);
        assert_eq!(plan.clashing, [false, false]);
    }

    #[test]
    fn varying_sheets_of_different_thickness_clash() {
        let plan = stacked(&[[1.0, 2.0, 2.0, 1.0], [3.0, 4.0, 4.0, 3.0]]);
        assert_eq!(plan.clashing, [true, true]);
        assert!(plan.nodal.is_empty());
        let alike = stacked(&[[1.0, 2.0, 2.0, 1.0], [1.01, 2.02, 2.02, 1.01]]);
        assert_eq!(alike.clashing, [false, false]);
    }

    #[test]
    fn a_mid_side_node_is_as_thick_as_its_ends_on_the_mean() {
        let mesh = quad([1.0, 1.0, 2.0, 3.0]);
        let cells = cells(&mesh);
        let plan = plan(&mesh, &cells, &MidSides::of(&mesh, &cells));
        // Sides 0-1, 0-3, 1-2, 2-3 are nodes 5 to 8.
        assert_eq!(plan.nodal[4..], [(5, 1.0), (6, 2.0), (7, 1.5), (8, 2.5)]);
    }
}
