//! From what a file has to a mesh that holds together, or to the reason why it is none.

use super::ReadMesh;
use super::error::{ReadError, ReadErrorKind};
use super::raw::{Raw, RawElement};
use crate::model::disjoint::Disjoint;
use crate::model::ids::{Id, IndexVec, NodeId, SheetId, WallId};
use crate::model::shell::{Corners, Element, Sheet, ShellMesh};
use glam::DVec3;
use std::collections::BTreeSet;

/// Checks what no format checks, leaves out nodes that are no shell's, and finds sheets and edges.
pub(super) fn assemble(raw: Raw) -> Result<ReadMesh, ReadError> {
    refuse(&raw)?;
    let mut notes = raw.notes;
    for (count, what) in [
        (
            raw.solids,
            "solid elements are left out: only shells are audited",
        ),
        (raw.others, "lines, points and other elements are left out"),
        (
            raw.higher_order,
            "elements of higher order are taken by their corners",
        ),
    ] {
        if count > 0 {
            notes.push(format!("{count} {what}"));
        }
    }
    let (sheet_of, sheets_named) = sheets(&raw.elements);
    // Corners stay, and nodes that nothing refers to: those are for the audit to find.
    let mut corner = vec![false; raw.nodes.len()];
    for &node in raw.elements.iter().flat_map(|e| &e.corners) {
        corner[node as usize] = true;
    }
    let mut place = vec![NodeId(u32::MAX); raw.nodes.len()];
    let mut nodes: IndexVec<NodeId, DVec3> = IndexVec::new();
    let mut node_numbers = Vec::new();
    for (k, (number, at)) in raw.nodes.iter().enumerate() {
        if corner[k] || !raw.taken.get(k).copied().unwrap_or(false) {
            place[k] = nodes.push(*at);
            node_numbers.push(*number);
        }
    }
    let count = sheet_of.iter().max().map_or(0, |s| s.index() + 1);
    let mut mesh = ShellMesh {
        nodes,
        sheets: (0..count)
            .map(|k| Sheet {
                solid_tag: 1,
                wall: WallId::new(k),
                sides: [Vec::new(), Vec::new()],
            })
            .collect(),
        ..ShellMesh::default()
    };
    let mut without_thickness = 0;
    for (element, sheet) in raw.elements.iter().zip(&sheet_of) {
        let at = |k: usize| place[element.corners[k] as usize];
        let (corners, mut thickness) = match element.corners.len() {
            3 => (Corners::Triangle([0, 1, 2].map(at)), element.thickness),
            _ => (Corners::Quad([0, 1, 2, 3].map(at)), element.thickness),
        };
        if !corners.is_quad() {
            thickness[3] = thickness[2];
        }
        without_thickness += usize::from(thickness.iter().any(|t| t.is_nan()));
        mesh.elements.push(Element {
            corners,
            sheet: *sheet,
            thickness,
            source_faces: [0; 2],
            unsure: false,
        });
    }
    (mesh.node_thickness, mesh.node_normals) = at_nodes(&mesh);
    curves(&mut mesh);
    Ok(ReadMesh {
        mesh,
        node_numbers,
        element_numbers: raw.elements.iter().map(|e| e.number).collect(),
        without_thickness,
        sheets_named,
        notes,
    })
}

fn refuse(raw: &Raw) -> Result<(), ReadError> {
    let kind = if raw.elements.is_empty() && raw.solids > 0 {
        ReadErrorKind::SolidMesh { solids: raw.solids }
    } else if raw.elements.is_empty() {
        ReadErrorKind::NoShells {
            others: raw.others,
            nodes: raw.nodes.len(),
        }
    } else if raw.elements.len() > u32::MAX as usize || raw.nodes.len() >= u32::MAX as usize {
        ReadErrorKind::TooMany
    } else {
        let bad = || raw.nodes.iter().filter(|(_, at)| !at.is_finite());
        match bad().next() {
            None => return Ok(()),
            Some((node, _)) => ReadErrorKind::NotFinite {
                node: *node,
                count: bad().count(),
                nodes: raw.nodes.len(),
            },
        }
    };
    Err(kind.anywhere())
}

/// The sheet of each element, and whether the file said so. Names become numbers in their own order.
fn sheets(elements: &[RawElement]) -> (Vec<SheetId>, bool) {
    let named: Option<Vec<i64>> = elements.iter().map(|e| e.sheet).collect();
    if let Some(named) = named {
        let all: Vec<i64> = BTreeSet::from_iter(named.iter().copied())
            .into_iter()
            .collect();
        let of = |name: &i64| SheetId::new(all.binary_search(name).unwrap_or(0));
        return (named.iter().map(of).collect(), true);
    }
    let mut sets = Disjoint::new(elements.len());
    let sides = sides(elements.iter().map(|e| &e.corners[..]));
    for run in sides.chunk_by(|a, b| a.0 == b.0) {
        if let [a, b] = run {
            sets.join(a.1, b.1);
        }
    }
    let mut first: Vec<Option<SheetId>> = vec![None; elements.len()];
    let mut count = 0;
    let of = |k: u32| {
        *first[sets.find(k) as usize].get_or_insert_with(|| {
            count += 1;
            SheetId(count - 1)
        })
    };
    ((0..elements.len() as u32).map(of).collect(), false)
}

/// The sides of all elements, in order of their ends: ends and element.
fn sides<'a>(corners: impl Iterator<Item = &'a [u32]>) -> Vec<([u32; 2], u32)> {
    let mut sides = Vec::new();
    for (element, corners) in (0u32..).zip(corners) {
        for (k, &a) in corners.iter().enumerate() {
            let b = corners[(k + 1) % corners.len()];
            if a != b {
                sides.push(([a.min(b), a.max(b)], element));
            }
        }
    }
    sides.sort_unstable();
    sides
}

/// Thickness and normal of each node: means over its elements, by area. NaN and zero where there is none.
fn at_nodes(mesh: &ShellMesh) -> (IndexVec<NodeId, f64>, IndexVec<NodeId, DVec3>) {
    let mut sums = vec![(0.0, 0.0); mesh.nodes.len()];
    let mut normals = vec![DVec3::ZERO; mesh.nodes.len()];
    for element in mesh.elements.iter() {
        let corners = element.corners.as_slice();
        let p = |k: usize| mesh.nodes[corners[k]];
        let vector = (p(2) - p(0)).cross(p(corners.len() - 1) - p(1));
        for (k, node) in corners.iter().enumerate() {
            let sum: &mut (f64, f64) = &mut sums[node.index()];
            sum.0 += vector.length() * element.thickness[k];
            sum.1 += vector.length();
            normals[node.index()] += vector;
        }
    }
    let mean = |(sum, weight): &(f64, f64)| {
        if *weight > 0.0 {
            sum / weight
        } else {
            f64::NAN
        }
    };
    (
        sums.iter().map(mean).collect(),
        normals.iter().map(|n| n.normalize_or_zero()).collect(),
    )
}

/// Free edges, junctions and the edges between two sheets.
fn curves(mesh: &mut ShellMesh) {
    let corners: Vec<Vec<u32>> = (mesh.elements.iter())
        .map(|e| e.corners.as_slice().iter().map(|n| n.0).collect())
        .collect();
    let sides = sides(corners.iter().map(Vec::as_slice));
    let sheet = |element: u32| mesh.elements.as_slice()[element as usize].sheet;
    let (mut rims, mut junctions, mut creases) = (Vec::new(), Vec::new(), Vec::new());
    for run in sides.chunk_by(|a, b| a.0 == b.0) {
        let ends = run[0].0.map(NodeId);
        match run {
            [_] => rims.push(ends),
            [a, b] if sheet(a.1) != sheet(b.1) => creases.push(ends),
            [_, _] => {}
            _ => junctions.push(ends),
        }
    }
    (mesh.rims, mesh.junctions, mesh.creases) = (rims, junctions, creases);
}
