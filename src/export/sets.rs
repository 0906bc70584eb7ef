//! Named sets of elements and nodes, by which loads and boundary conditions find their places in a deck.

use super::cells::Cell;
use super::checked::sheet_name;
use super::mid_side::MidSides;
use super::number_of;
use crate::model::ids::NodeId;
use crate::model::shell::ShellMesh;
use std::collections::{BTreeMap, BTreeSet};

/// The sets of a deck: name and ascending numbers each. No set is empty.
///
/// Elements: `SHEET_n`, `SOLID_n`, `FACE_n` (the elements with that source face on either side), `UNSURE`.
/// Nodes: `SHEET_n`, `FACE_n` (the nodes of these elements), `RIM`, `JUNCTION`, `CREASE`.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct Sets {
    pub elements: Vec<(String, Vec<usize>)>,
    pub nodes: Vec<(String, Vec<usize>)>,
}

/// Elements and their nodes gathered under one number.
#[derive(Default)]
struct Gathered {
    elements: Vec<usize>,
    nodes: BTreeSet<usize>,
}

impl Gathered {
    fn add(&mut self, cell: &Cell, mids: &MidSides) {
        self.elements.push(cell.number);
        self.nodes
            .extend(cell.corners.iter().map(|&n| number_of(n)));
        self.nodes.extend(mids.of_cell(cell));
    }
}

/// All sets of the mesh, `cells` being its elements as the deck has them and `mids` the nodes in the middle of their sides: a clamped set must not leave those free.
pub(super) fn sets(mesh: &ShellMesh, cells: &[Cell], mids: &MidSides) -> Sets {
    let mut sheets: BTreeMap<_, Gathered> = BTreeMap::new();
    let mut solids: BTreeMap<i32, Gathered> = BTreeMap::new();
    let mut faces: BTreeMap<i32, Gathered> = BTreeMap::new();
    let mut unsure = Vec::new();
    for cell in cells {
        let element = &mesh.elements[cell.element];
        sheets.entry(element.sheet).or_default().add(cell, mids);
        let solid = mesh.sheets[element.sheet].solid_tag;
        solids.entry(solid).or_default().add(cell, mids);
        let [a, b] = element.source_faces;
        if a > 0 {
            faces.entry(a).or_default().add(cell, mids);
        }
        if b > 0 && b != a {
            faces.entry(b).or_default().add(cell, mids);
        }
        if element.unsure {
            unsure.push(cell.number);
        }
    }
    let mut sets = Sets::default();
    for (sheet, gathered) in sheets {
        sets.elements.push((sheet_name(sheet), gathered.elements));
        let nodes = gathered.nodes.into_iter().collect();
        sets.nodes.push((sheet_name(sheet), nodes));
    }
    for (solid, gathered) in solids {
        sets.elements
            .push((format!("SOLID_{solid}"), gathered.elements));
    }
    for (face, gathered) in faces {
        sets.elements
            .push((format!("FACE_{face}"), gathered.elements));
        let nodes = gathered.nodes.into_iter().collect();
        sets.nodes.push((format!("FACE_{face}"), nodes));
    }
    sets.elements.push(("UNSURE".into(), unsure));
    sets.nodes.push(("RIM".into(), nodes_of(&mesh.rims, mids)));
    sets.nodes
        .push(("JUNCTION".into(), nodes_of(&mesh.junctions, mids)));
    sets.nodes
        .push(("CREASE".into(), nodes_of(&mesh.creases, mids)));
    // Solvers warn of empty sets; a deck that asks for one shall fail by name.
    sets.elements.retain(|(_, numbers)| !numbers.is_empty());
    sets.nodes.retain(|(_, numbers)| !numbers.is_empty());
    sets
}

fn nodes_of(edges: &[[NodeId; 2]], mids: &MidSides) -> Vec<usize> {
    let ends = edges.iter().flatten().map(|&n| number_of(n));
    let middles = edges.iter().filter_map(|&edge| mids.between(edge));
    let numbers: BTreeSet<usize> = ends.chain(middles).collect();
    numbers.into_iter().collect()
}

#[cfg(test)]
mod tests {
    use super::super::cells::cells;
    use super::super::tests::quad;
    use super::*;
    use crate::model::ids::ElementId;

    #[test]
    fn every_set_of_one_quad() {
        let mut mesh = quad([1.0; 4]);
        mesh.rims.truncate(2);
        mesh.elements[ElementId(0)].unsure = true;
        let sets = sets(&mesh, &cells(&mesh), &MidSides::default());
        let names = |of: &[(String, Vec<usize>)]| -> Vec<String> {
            of.iter().map(|(name, _)| name.clone()).collect()
        };
        assert_eq!(
            names(&sets.elements),
            ["SHEET_1", "SOLID_1", "FACE_5", "FACE_6", "UNSURE"]
        );
        assert_eq!(names(&sets.nodes), ["SHEET_1", "FACE_5", "FACE_6", "RIM"]);
        assert_eq!(sets.nodes[3].1, [1, 2, 4]);
        assert!(sets.elements.iter().all(|(_, numbers)| *numbers == [1]));
    }

    #[test]
    fn a_face_on_both_sides_counts_once_and_no_face_makes_no_set() {
        let mut mesh = quad([1.0; 4]);
        mesh.elements[ElementId(0)].source_faces = [7, 7];
        let both = sets(&mesh, &cells(&mesh), &MidSides::default());
        assert!(both.elements.contains(&("FACE_7".into(), vec![1])));
        mesh.elements[ElementId(0)].source_faces = [0, 0];
        let none = sets(&mesh, &cells(&mesh), &MidSides::default());
        assert!(
            none.elements
                .iter()
                .all(|(name, _)| !name.starts_with("FACE"))
        );
    }

    #[test]
    fn mid_side_nodes_belong_to_the_sets_of_their_sides() {
        let mut mesh = quad([1.0; 4]);
        mesh.rims.truncate(2);
        let cells = cells(&mesh);
        let sets = sets(&mesh, &cells, &MidSides::of(&mesh, &cells));
        // Sides 0-1, 0-3, 1-2, 2-3 are nodes 5 to 8; the rim has the first two.
        let of = |name: &str| sets.nodes.iter().find(|(n, _)| n == name).unwrap();
        assert_eq!(of("SHEET_1").1, [1, 2, 3, 4, 5, 6, 7, 8]);
        assert_eq!(of("FACE_5").1, of("SHEET_1").1);
        assert_eq!(of("RIM").1, [1, 2, 4, 5, 6]);
    }
}
