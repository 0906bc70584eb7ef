//! What must hold of a mesh before any writer sees it: indices in range, finite positions, positive thickness, fields of the right length.

use super::{ExportOptions, number_of};
use crate::model::ids::{ElementId, Id, NodeId, SheetId};
use crate::model::shell::ShellMesh;

/// Why a mesh is not written.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum ExportError {
    /// There is nothing to write.
    #[error("the mesh has no elements")]
    Empty,
    /// An element names a node that does not exist.
    #[error("{element:?} names {node:?}, but there are {nodes} nodes")]
    NoSuchNode {
        /// The element.
        element: ElementId,
        /// The node that it names.
        node: NodeId,
        /// How many nodes there are.
        nodes: usize,
    },
    /// A rim, junction or crease edge names a node that does not exist.
    #[error("a {set} edge names {node:?}, but there are {nodes} nodes")]
    NoSuchEdgeNode {
        /// `rim`, `junction` or `crease`.
        set: &'static str,
        /// The node that it names.
        node: NodeId,
        /// How many nodes there are.
        nodes: usize,
    },
    /// An element names a sheet that does not exist.
    #[error("{element:?} names {sheet:?}, but there are {sheets} sheets")]
    NoSuchSheet {
        /// The element.
        element: ElementId,
        /// The sheet that it names.
        sheet: SheetId,
        /// How many sheets there are.
        sheets: usize,
    },
    /// An element has the same corner twice.
    #[error("{element:?} has {node:?} at two corners")]
    RepeatedCorner {
        /// The element.
        element: ElementId,
        /// The node.
        node: NodeId,
    },
    /// A node belongs to no element: in a solver it would float.
    #[error("{node:?} belongs to no element")]
    UnusedNode {
        /// The node.
        node: NodeId,
    },
    /// A position, a nodal thickness or a normal is infinite or no number.
    #[error("the {what} of {node:?} is not finite")]
    NotFinite {
        /// The node.
        node: NodeId,
        /// `position`, `thickness` or `normal`.
        what: &'static str,
    },
    /// A thickness that no solver takes.
    #[error("{element:?} has a corner thickness of {thickness} mm, which is not positive")]
    ThicknessNotPositive {
        /// The element.
        element: ElementId,
        /// Its thickness at one corner, mm.
        thickness: f64,
    },
    /// A list has another length than the mesh.
    #[error("the field `{name}` has {found} values for {expected}")]
    FieldLength {
        /// The field.
        name: String,
        /// How many values it has.
        found: usize,
        /// How many nodes or elements there are.
        expected: usize,
    },
    /// Two cell fields have one name.
    #[error("there is already a cell field `{name}`")]
    RepeatedField {
        /// The name.
        name: String,
    },
    /// More numbers than the fields of a Nastran deck can hold.
    #[error("a Nastran deck holds numbers up to {limit}; this mesh needs {needed}")]
    TooManyForNastran {
        /// The greatest number that fits.
        limit: usize,
        /// The greatest number that the mesh needs.
        needed: usize,
    },
}

/// The cell fields that every VTU file has.
pub(super) const CELL_FIELDS: [&str; 9] = [
    "thickness",
    "sheet",
    "wall",
    "solid",
    "source_face_a",
    "source_face_b",
    "unsure",
    "quality",
    "doubt",
];

/// The first violation, in the order nodes, elements, edges, fields.
pub(super) fn check(mesh: &ShellMesh, options: &ExportOptions<'_>) -> Result<(), ExportError> {
    if mesh.elements.is_empty() {
        return Err(ExportError::Empty);
    }
    check_nodes(mesh)?;
    check_elements(mesh)?;
    check_edges(mesh)?;
    check_fields(mesh, options)
}

fn check_nodes(mesh: &ShellMesh) -> Result<(), ExportError> {
    check_length(
        "node_thickness",
        mesh.node_thickness.len(),
        mesh.nodes.len(),
    )?;
    check_length("node_normals", mesh.node_normals.len(), mesh.nodes.len())?;
    for (node, position) in mesh.nodes.enumerated() {
        let finite = [
            ("position", position.is_finite()),
            ("thickness", mesh.node_thickness[node].is_finite()),
            ("normal", mesh.node_normals[node].is_finite()),
        ];
        if let Some((what, _)) = finite.into_iter().find(|(_, finite)| !finite) {
            return Err(ExportError::NotFinite { node, what });
        }
    }
    Ok(())
}

fn check_elements(mesh: &ShellMesh) -> Result<(), ExportError> {
    let mut used = vec![false; mesh.nodes.len()];
    for (id, element) in mesh.elements.enumerated() {
        let corners = element.corners.as_slice();
        for (k, &node) in corners.iter().enumerate() {
            match used.get_mut(node.index()) {
                Some(used) => *used = true,
                None => {
                    return Err(ExportError::NoSuchNode {
                        element: id,
                        node,
                        nodes: mesh.nodes.len(),
                    });
                }
            }
            if corners[..k].contains(&node) {
                return Err(ExportError::RepeatedCorner { element: id, node });
            }
        }
        if mesh.sheets.get(element.sheet).is_none() {
            return Err(ExportError::NoSuchSheet {
                element: id,
                sheet: element.sheet,
                sheets: mesh.sheets.len(),
            });
        }
        let bad = element.thickness[..corners.len()]
            .iter()
            .find(|t| !(t.is_finite() && **t > 0.0));
        if let Some(&thickness) = bad {
            return Err(ExportError::ThicknessNotPositive {
                element: id,
                thickness,
            });
        }
    }
    match used.iter().position(|used| !used) {
        Some(index) => Err(ExportError::UnusedNode {
            node: NodeId::new(index),
        }),
        None => Ok(()),
    }
}

fn check_edges(mesh: &ShellMesh) -> Result<(), ExportError> {
    let sets = [
        ("rim", &mesh.rims),
        ("junction", &mesh.junctions),
        ("crease", &mesh.creases),
    ];
    for (set, edges) in sets {
        for &node in edges.iter().flatten() {
            if mesh.nodes.get(node).is_none() {
                return Err(ExportError::NoSuchEdgeNode {
                    set,
                    node,
                    nodes: mesh.nodes.len(),
                });
            }
        }
    }
    Ok(())
}

fn check_fields(mesh: &ShellMesh, options: &ExportOptions<'_>) -> Result<(), ExportError> {
    let count = mesh.elements.len();
    if let Some(quality) = options.cell_quality {
        check_length("quality", quality.len(), count)?;
    }
    if let Some(doubts) = options.cell_doubts {
        check_length("doubt", doubts.len(), count)?;
    }
    for (k, (name, values)) in options.cell_fields.iter().enumerate() {
        check_length(name, values.len(), count)?;
        let earlier = options.cell_fields[..k]
            .iter()
            .any(|(other, _)| other == name);
        if earlier || CELL_FIELDS.contains(&name.as_str()) {
            return Err(ExportError::RepeatedField { name: name.clone() });
        }
    }
    Ok(())
}

fn check_length(name: &str, found: usize, expected: usize) -> Result<(), ExportError> {
    if found == expected {
        return Ok(());
    }
    Err(ExportError::FieldLength {
        name: name.to_owned(),
        found,
        expected,
    })
}

/// `SHEET_3` and the like.
pub(super) fn sheet_name(sheet: SheetId) -> String {
    format!("SHEET_{}", number_of(sheet))
}

#[cfg(test)]
mod tests {
    use super::super::tests::quad;
    use super::*;
    use crate::model::shell::Corners;
    use glam::DVec3;

    fn verdict(spoil: impl FnOnce(&mut ShellMesh)) -> Result<(), ExportError> {
        let mut mesh = quad([1.0; 4]);
        spoil(&mut mesh);
        check(&mesh, &ExportOptions::default())
    }

    #[test]
    fn a_sound_mesh_passes_and_each_defect_is_named() {
        assert_eq!(verdict(|_| ()), Ok(()));
        assert_eq!(
            verdict(|m| *m = ShellMesh::default()),
            Err(ExportError::Empty)
        );
        let element = ElementId(0);
        assert_eq!(
            verdict(|m| m.elements[element].corners = Corners::Quad([0, 1, 2, 9].map(NodeId))),
            Err(ExportError::NoSuchNode {
                element,
                node: NodeId(9),
                nodes: 4
            })
        );
        assert_eq!(
            verdict(|m| m.elements[element].corners = Corners::Quad([0, 1, 2, 1].map(NodeId))),
            Err(ExportError::RepeatedCorner {
                element,
                node: NodeId(1)
            })
        );
        assert_eq!(
            verdict(|m| m.elements[element].sheet = SheetId(4)),
            Err(ExportError::NoSuchSheet {
                element,
                sheet: SheetId(4),
                sheets: 1
            })
        );
        assert_eq!(
            verdict(|m| m.elements[element].thickness[2] = 0.0),
            Err(ExportError::ThicknessNotPositive {
                element,
                thickness: 0.0
            })
        );
        assert_eq!(
            verdict(|m| m.elements[element].corners = Corners::Triangle([0, 1, 2].map(NodeId))),
            Err(ExportError::UnusedNode { node: NodeId(3) })
        );
        assert_eq!(
            verdict(|m| m.nodes[NodeId(2)] = DVec3::NAN),
            Err(ExportError::NotFinite {
                node: NodeId(2),
                what: "position"
            })
        );
        assert_eq!(
            verdict(|m| m.rims.push([NodeId(0), NodeId(7)])),
            Err(ExportError::NoSuchEdgeNode {
                set: "rim",
                node: NodeId(7),
                nodes: 4
            })
        );
    }

    #[test]
    fn a_field_of_the_wrong_length_or_a_taken_name_is_refused() {
        let mesh = quad([1.0; 4]);
        let with = |name: &str, values: Vec<f64>| {
            let options = ExportOptions {
                cell_fields: vec![(name.into(), values)],
                ..ExportOptions::default()
            };
            check(&mesh, &options)
        };
        assert_eq!(with("skew", vec![0.0]), Ok(()));
        assert!(matches!(
            with("skew", vec![]),
            Err(ExportError::FieldLength { .. })
        ));
        assert!(matches!(
            with("sheet", vec![0.0]),
            Err(ExportError::RepeatedField { .. })
        ));
    }
}
