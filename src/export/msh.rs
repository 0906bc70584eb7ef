//! Gmsh MSH 4.1, text.
//!
//! Each sheet is a surface entity with its physical group `SHEET_n`; rims, junctions and creases are curve entities with line elements and the physical groups
//! `RIM`, `JUNCTION`, `CREASE`. Thickness comes three times, as `$NodeData`, `$ElementData` and, exact at junctions, `$ElementNodeData`.
//!
//! Nodes and elements keep their numbers; lines are numbered after the elements. Data sections follow the order of `$Nodes` and `$Elements`, and lines carry the mean thickness
//! of their ends, because meshio takes one value for each in file order and ignores the numbers.
//!
//! Limits: an element belongs to one physical group (several readers take only the first), so solids and source faces are not groups here; the decks and VTU have them.
//!
//! Reference: <https://gmsh.info/doc/texinfo/gmsh.html#MSH-file-format>.

use super::checked::sheet_name;
use super::number::shortest;
use super::number_of;
use crate::model::ids::{ElementId, NodeId};
use crate::model::shell::ShellMesh;
use glam::DVec3;
use std::fmt::Write;

/// An entity with its nodes and its elements, each element by number and corners.
struct Entity {
    dimension: usize,
    tag: usize,
    name: String,
    nodes: Vec<NodeId>,
    blocks: Vec<Block>,
}

/// Elements of one type.
struct Block {
    /// 1 line, 2 triangle, 3 quad.
    kind: usize,
    elements: Vec<(usize, Vec<NodeId>)>,
}

pub(super) fn render(mesh: &ShellMesh) -> Vec<u8> {
    let entities = entities(mesh);
    let mut out = String::new();
    // Writing to a String cannot fail.
    let _ = write_file(&mut out, mesh, &entities);
    out.into_bytes()
}

/// Curves first, then surfaces: the order that the format asks for.
fn entities(mesh: &ShellMesh) -> Vec<Entity> {
    let mut free = vec![true; mesh.nodes.len()];
    let mut take = |candidates: &mut dyn Iterator<Item = NodeId>| -> Vec<NodeId> {
        let mut taken: Vec<NodeId> = candidates
            .filter(|n| std::mem::replace(&mut free[n.0 as usize], false))
            .collect();
        taken.sort();
        taken
    };
    let mut entities = Vec::new();
    // A node lies on one entity: where curves meet, the junction has it.
    let curves = [
        (2, "JUNCTION", &mesh.junctions),
        (3, "CREASE", &mesh.creases),
        (1, "RIM", &mesh.rims),
    ];
    for (tag, name, edges) in curves {
        if edges.is_empty() {
            continue;
        }
        entities.push(Entity {
            dimension: 1,
            tag,
            name: name.into(),
            nodes: take(&mut edges.iter().flatten().copied()),
            blocks: vec![Block {
                kind: 1,
                elements: edges.iter().map(|edge| (0, edge.to_vec())).collect(),
            }],
        });
    }
    entities.sort_by_key(|entity| entity.tag);
    let mut next = mesh.elements.len();
    for (number, _) in entities.iter_mut().flat_map(|e| &mut e.blocks[0].elements) {
        next += 1;
        *number = next;
    }
    let mut by_sheet: Vec<Vec<ElementId>> = vec![Vec::new(); mesh.sheets.len()];
    for (id, element) in mesh.elements.enumerated() {
        by_sheet[element.sheet.0 as usize].push(id);
    }
    for (sheet, elements) in mesh.sheets.ids().zip(&by_sheet) {
        if elements.is_empty() {
            continue;
        }
        let corners = |id: &ElementId| mesh.elements[*id].corners.as_slice();
        let block = |kind: usize| Block {
            kind,
            elements: elements
                .iter()
                .filter(|id| corners(id).len() == kind + 1)
                .map(|id| (number_of(*id), corners(id).to_vec()))
                .collect(),
        };
        entities.push(Entity {
            dimension: 2,
            tag: number_of(sheet),
            name: sheet_name(sheet),
            nodes: take(&mut elements.iter().flat_map(corners).copied()),
            blocks: [block(2), block(3)]
                .into_iter()
                .filter(|b| !b.elements.is_empty())
                .collect(),
        });
    }
    entities
}

fn write_file(out: &mut String, mesh: &ShellMesh, entities: &[Entity]) -> std::fmt::Result {
    writeln!(out, "$MeshFormat\n4.1 0 8\n$EndMeshFormat")?;
    writeln!(out, "$PhysicalNames\n{}", entities.len())?;
    for e in entities {
        writeln!(out, "{} {} \"{}\"", e.dimension, e.tag, e.name)?;
    }
    writeln!(out, "$EndPhysicalNames")?;
    write_entities(out, mesh, entities)?;
    write_nodes(out, mesh, entities)?;
    write_elements(out, entities)?;
    write_node_data(out, mesh, entities)?;
    write_element_data(out, mesh, entities)?;
    write_element_node_data(out, mesh)
}

fn write_entities(out: &mut String, mesh: &ShellMesh, entities: &[Entity]) -> std::fmt::Result {
    let curves = entities.iter().filter(|e| e.dimension == 1).count();
    writeln!(out, "$Entities\n0 {curves} {} 0", entities.len() - curves)?;
    for e in entities {
        let corners = e
            .blocks
            .iter()
            .flat_map(|b| &b.elements)
            .flat_map(|(_, c)| c);
        let (mut low, mut high) = (DVec3::INFINITY, DVec3::NEG_INFINITY);
        for &node in corners {
            low = low.min(mesh.nodes[node]);
            high = high.max(mesh.nodes[node]);
        }
        // One physical tag, no bounding entities: the curves are not split where sheets end.
        writeln!(
            out,
            "{} {} {} 1 {} 0",
            e.tag,
            triple(low),
            triple(high),
            e.tag
        )?;
    }
    writeln!(out, "$EndEntities")
}

fn write_nodes(out: &mut String, mesh: &ShellMesh, entities: &[Entity]) -> std::fmt::Result {
    let blocks: Vec<&Entity> = entities.iter().filter(|e| !e.nodes.is_empty()).collect();
    let count = mesh.nodes.len();
    writeln!(out, "$Nodes\n{} {count} 1 {count}", blocks.len())?;
    for e in blocks {
        writeln!(out, "{} {} 0 {}", e.dimension, e.tag, e.nodes.len())?;
        for &node in &e.nodes {
            writeln!(out, "{}", number_of(node))?;
        }
        for &node in &e.nodes {
            writeln!(out, "{}", triple(mesh.nodes[node]))?;
        }
    }
    writeln!(out, "$EndNodes")
}

fn write_elements(out: &mut String, entities: &[Entity]) -> std::fmt::Result {
    let blocks = entities.iter().map(|e| e.blocks.len()).sum::<usize>();
    let count = element_count(entities);
    writeln!(out, "$Elements\n{blocks} {count} 1 {count}")?;
    for e in entities {
        for block in &e.blocks {
            let count = block.elements.len();
            writeln!(out, "{} {} {} {count}", e.dimension, e.tag, block.kind)?;
            for (number, corners) in &block.elements {
                write!(out, "{number}")?;
                for &node in corners {
                    write!(out, " {}", number_of(node))?;
                }
                out.push('\n');
            }
        }
    }
    writeln!(out, "$EndElements")
}

/// The head of a data section: one name, time 0, step 0, one component.
fn write_tags(out: &mut String, section: &str, count: usize) -> std::fmt::Result {
    writeln!(out, "${section}\n1\n\"thickness\"\n1\n0\n3\n0\n1\n{count}")
}

fn write_node_data(out: &mut String, mesh: &ShellMesh, entities: &[Entity]) -> std::fmt::Result {
    write_tags(out, "NodeData", mesh.nodes.len())?;
    for &node in entities.iter().flat_map(|e| &e.nodes) {
        let thickness = shortest(mesh.node_thickness[node]);
        writeln!(out, "{} {thickness}", number_of(node))?;
    }
    writeln!(out, "$EndNodeData")
}

fn write_element_data(out: &mut String, mesh: &ShellMesh, entities: &[Entity]) -> std::fmt::Result {
    write_tags(out, "ElementData", element_count(entities))?;
    let elements = entities
        .iter()
        .flat_map(|e| &e.blocks)
        .flat_map(|b| &b.elements);
    for (number, corners) in elements {
        let thickness = match mesh.elements.as_slice().get(number - 1) {
            Some(element) => element.mean_thickness(),
            None => {
                let ends = corners.iter().map(|&n| mesh.node_thickness[n]);
                ends.sum::<f64>() / corners.len() as f64
            }
        };
        writeln!(out, "{number} {}", shortest(thickness))?;
    }
    writeln!(out, "$EndElementData")
}

fn write_element_node_data(out: &mut String, mesh: &ShellMesh) -> std::fmt::Result {
    write_tags(out, "ElementNodeData", mesh.elements.len())?;
    for (id, element) in mesh.elements.enumerated() {
        let corners = element.corners.as_slice().len();
        write!(out, "{} {corners}", number_of(id))?;
        for &thickness in &element.thickness[..corners] {
            write!(out, " {}", shortest(thickness))?;
        }
        out.push('\n');
    }
    writeln!(out, "$EndElementNodeData")
}

fn element_count(entities: &[Entity]) -> usize {
    let blocks = entities.iter().flat_map(|e| &e.blocks);
    blocks.map(|b| b.elements.len()).sum()
}

fn triple(p: DVec3) -> String {
    format!("{} {} {}", shortest(p.x), shortest(p.y), shortest(p.z))
}

#[cfg(test)]
mod tests {
    use super::super::Format;
    use super::super::tests::{quad, text};

    #[test]
    fn one_quad_golden() {
        let msh = text(Format::Msh, &quad([1.0, 1.5, 2.0, 1.5]));
        let section = |name: &str| -> Vec<String> {
            let start = msh.find(&format!("${name}\n")).unwrap() + name.len() + 2;
            let end = msh.find(&format!("$End{name}\n")).unwrap();
            msh[start..end].lines().map(str::to_owned).collect()
        };
        assert_eq!(
            section("PhysicalNames"),
            ["2", "1 1 \"RIM\"", "2 1 \"SHEET_1\""]
        );
        let boxed = "1 0.0 0.0 0.0 1.0 1.0 0.0 1 1 0";
        assert_eq!(section("Entities"), ["0 1 1 0", boxed, boxed]);
        assert_eq!(section("Nodes")[..3], ["1 4 1 4", "1 1 0 4", "1"]);
        assert_eq!(section("Elements")[6..], ["2 1 3 1", "1 1 2 3 4"]);
        assert_eq!(
            section("ElementNodeData").last().unwrap(),
            "1 4 1.0 1.5 2.0 1.5"
        );
        assert_eq!(section("ElementData")[8..10], ["2 1.25", "3 1.25"]);
    }
}
