//! Shell: the finished mid-complex as a shell mesh: sheets, orientation, thickness, provenance.

mod lump;
mod sides;

use crate::geom::orient::orient;
use crate::geom::placer::Placer;
use crate::medial::{Foot, Medial};
use crate::model::brep::Brep;
use crate::model::complex::{EdgeKind, MidComplex, MidEdge, MidTriangle};
use crate::model::ids::{IndexVec, NodeId, SheetId, TriangleId, WallId};
use crate::model::shell::{Corners, Element, Sheet, ShellMesh};
use crate::model::walls::Pairing;
use glam::DVec3;
use rayon::prelude::*;

/// A place whose nearest points on both sides lie further to the side than this, in thicknesses, is fixed by no pair of faces.
const SURE_OFFSET: f64 = 0.75;
/// A wall is never thinner than this share of its mean for a solver: knife edges have no thickness, and no solver takes zero.
const LEAST_THICKNESS: f64 = 0.01;

/// Sheets in the order of their first triangle, elements ordered by sheet, normals the same way round over each sheet and on over creases.
pub fn shell(
    brep: &Brep,
    pairing: &Pairing,
    medial: &Medial<'_>,
    complex: &MidComplex,
) -> ShellMesh {
    let mut complex = complex.clone();
    orient(&mut complex, medial);
    let edges = complex.edges();
    let (sheet_of, walls) = sheets(&complex, &edges);
    let turned = sides::turned(&complex, &edges, &sheet_of);
    for t in complex.triangles.ids().filter(|&t| turned[sheet_of[t]]) {
        complex.triangles[t].nodes.swap(1, 2);
    }
    let mut order: Vec<TriangleId> = complex.triangles.ids().collect();
    order.sort_by_key(|&t| (sheet_of[t], t));
    let material = lump::Material::new(brep);
    let elements: Vec<Element> = order
        .par_iter()
        .map(|&t| {
            let mut element = element(brep, medial, complex.triangles[t], &complex, sheet_of[t]);
            in_lump(&mut element, &material, &complex);
            if turned[sheet_of[t]] {
                element.source_faces.swap(0, 1);
            }
            element
        })
        .collect();
    let tags = |faces: &[crate::model::ids::FaceId]| {
        faces.iter().map(|&f| brep.faces[f].tag).collect::<Vec<_>>()
    };
    let mut mesh = ShellMesh {
        nodes: complex.nodes.iter().map(|n| n.point).collect(),
        elements: elements.into(),
        sheets: walls
            .enumerated()
            .map(|(sheet, &wall)| {
                let mut sides = [0, 1].map(|s| tags(&pairing.walls[wall].sides[s]));
                if turned[sheet] {
                    sides.swap(0, 1);
                }
                Sheet {
                    solid_tag: brep.solid_tag,
                    wall,
                    sides,
                }
            })
            .collect(),
        ..ShellMesh::default()
    };
    for edge in &edges {
        match complex.kind(edge) {
            EdgeKind::Inner => {}
            EdgeKind::Rim => mesh.rims.push(edge.ends),
            EdgeKind::Junction => mesh.junctions.push(edge.ends),
            EdgeKind::Crease => mesh.creases.push(edge.ends),
        }
    }
    nodal(&mut mesh);
    mesh
}

/// The sheet of every triangle, and the wall of every sheet: pieces that hang together over inner edges, in the order of their first triangles.
fn sheets(
    complex: &MidComplex,
    edges: &[MidEdge],
) -> (IndexVec<TriangleId, SheetId>, IndexVec<SheetId, WallId>) {
    let first_of = complex.sheets(edges);
    let mut walls = IndexVec::new();
    let mut sheet_of: IndexVec<TriangleId, SheetId> = IndexVec::new();
    for (t, triangle) in complex.triangles.enumerated() {
        // The first of its sheet comes before all others.
        let first = first_of[t];
        let sheet = if first == t {
            walls.push(triangle.wall)
        } else {
            sheet_of[first]
        };
        sheet_of.push(sheet);
    }
    (sheet_of, walls)
}

fn element(
    brep: &Brep,
    medial: &Medial<'_>,
    triangle: MidTriangle,
    complex: &MidComplex,
    sheet: SheetId,
) -> Element {
    let MidTriangle { nodes, wall } = triangle;
    let mean = medial.mean_thickness(wall);
    let at = |n: NodeId| {
        medial
            .thickness(complex.nodes[n].point, wall)
            .filter(|t| t.is_finite())
            .unwrap_or(mean)
            .max(LEAST_THICKNESS * mean)
    };
    let [a, b, c] = nodes.map(at);
    let centre = nodes.iter().map(|&n| complex.nodes[n].point).sum::<DVec3>() / 3.0;
    let feet = medial.feet(centre, wall);
    let offset = |f: &Foot| ((f.point - centre) - f.normal * f.depth(centre)).length();
    let reach = SURE_OFFSET * a.max(b).max(c);
    Element {
        corners: Corners::Triangle(nodes),
        sheet,
        thickness: [a, b, c, c],
        source_faces: feet.map_or([0, 0], |f| {
            f.map(|f| brep.faces[brep.facets[f.facet].face].tag)
        }),
        unsure: feet.is_none_or(|f| f.iter().all(|f| offset(f) > reach)),
    }
}

/// An element inside a lump is as thick as that, and no shell stands for the material there.
fn in_lump(element: &mut Element, material: &lump::Material, complex: &MidComplex) {
    let Corners::Triangle(nodes) = element.corners else {
        return;
    };
    let [a, b, c] = nodes.map(|n| complex.nodes[n].point);
    let Some(normal) = (b - a).cross(c - a).try_normalize() else {
        return;
    };
    let thickest = element.thickness.iter().copied().fold(0.0, f64::max);
    if let Some(thickness) = material.lump((a + b + c) / 3.0, normal, thickest) {
        element.thickness = [thickness; 4];
        element.unsure = true;
    }
}

/// Nodal thickness and normals from the elements.
fn nodal(mesh: &mut ShellMesh) {
    let mut weight: IndexVec<NodeId, f64> = IndexVec::filled(0.0, mesh.nodes.len());
    let mut thickness: IndexVec<NodeId, f64> = IndexVec::filled(0.0, mesh.nodes.len());
    let mut normal: IndexVec<NodeId, (Option<SheetId>, DVec3)> =
        IndexVec::filled((None, DVec3::ZERO), mesh.nodes.len());
    for e in &mesh.elements {
        let n = e.corners.as_slice();
        let area = mesh.doubled_area(e);
        for (k, &node) in n.iter().enumerate() {
            weight[node] += area.length();
            thickness[node] += area.length() * e.thickness[k];
            // Elements come by sheet: a junction node takes the normal of its lowest.
            let (sheet, sum) = &mut normal[node];
            if *sheet.get_or_insert(e.sheet) == e.sheet {
                *sum += area;
            }
        }
    }
    mesh.node_thickness = mesh
        .nodes
        .ids()
        .map(|n| thickness[n] / weight[n].max(f64::MIN_POSITIVE))
        .collect();
    mesh.node_normals = normal.iter().map(|n| n.1.normalize_or_zero()).collect();
}

#[cfg(test)]
mod tests;
