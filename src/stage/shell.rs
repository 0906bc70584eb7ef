//! Shell: the finished mid-complex as a shell mesh: sheets, orientation, thickness, provenance.

use crate::geom::placer::Placer;
use crate::medial::{Foot, Medial};
use crate::model::brep::Brep;
use crate::model::complex::{EdgeKind, MidComplex, MidEdge};
use crate::model::ids::{Id, IndexVec, NodeId, SheetId, TriangleId, WallId};
use crate::model::shell::{Corners, Element, Sheet, ShellMesh};
use crate::model::walls::Pairing;
use glam::DVec3;
use rayon::prelude::*;

/// A place whose nearest points on both sides lie further to the side than this, in thicknesses, is fixed by no pair of faces.
const SURE_OFFSET: f64 = 0.75;
/// A wall is never thinner than this share of its mean for a solver: knife edges have no thickness, and no solver takes zero.
const LEAST_THICKNESS: f64 = 0.01;

/// Sheets in the order of their first triangle, elements ordered by sheet, normals the same way round over each sheet.
pub fn shell(
    brep: &Brep,
    pairing: &Pairing,
    medial: &Medial<'_>,
    complex: &MidComplex,
) -> ShellMesh {
    let edges = complex.edges();
    let (sheet_of, flipped, sheets) = sheets(complex, &edges, medial);
    let mut order: Vec<TriangleId> = complex.triangles.ids().collect();
    order.sort_by_key(|&t| (sheet_of[t], t));
    let elements: Vec<Element> = order
        .par_iter()
        .map(|&t| element(brep, medial, complex, t, sheet_of[t], flipped[t]))
        .collect();
    let tags = |faces: &[crate::model::ids::FaceId]| {
        faces.iter().map(|&f| brep.faces[f].tag).collect::<Vec<_>>()
    };
    let mut mesh = ShellMesh {
        nodes: complex.nodes.iter().map(|n| n.point).collect(),
        elements: elements.into(),
        sheets: sheets
            .into_iter()
            .map(|wall| Sheet {
                solid_tag: brep.solid_tag,
                wall,
                sides: [0, 1].map(|s| tags(&pairing.walls[wall].sides[s])),
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

/// Sheet and orientation of every triangle: breadth first over inner edges; the first triangle of a sheet looks to its wall's first side.
fn sheets(
    complex: &MidComplex,
    edges: &[MidEdge],
    medial: &Medial<'_>,
) -> (
    IndexVec<TriangleId, SheetId>,
    IndexVec<TriangleId, bool>,
    Vec<WallId>,
) {
    let mut neighbours: IndexVec<TriangleId, smallvec::SmallVec<[(TriangleId, bool); 3]>> =
        IndexVec::filled(smallvec::SmallVec::new(), complex.triangles.len());
    let runs = |t: TriangleId, ends: [NodeId; 2]| {
        let n = complex.triangles[t].nodes;
        (0..3).any(|k| n[k] == ends[0] && n[(k + 1) % 3] == ends[1])
    };
    for edge in edges.iter().filter(|e| complex.kind(e) == EdgeKind::Inner) {
        let (a, b) = (edge.triangles[0], edge.triangles[1]);
        let same_way = runs(a, edge.ends) == runs(b, edge.ends);
        neighbours[a].push((b, same_way));
        neighbours[b].push((a, same_way));
    }
    let mut sheet_of = IndexVec::filled(SheetId(u32::MAX), complex.triangles.len());
    let mut flipped = IndexVec::filled(false, complex.triangles.len());
    let mut walls = Vec::new();
    for seed in complex.triangles.ids() {
        if sheet_of[seed] != SheetId(u32::MAX) {
            continue;
        }
        let sheet = SheetId::new(walls.len());
        let wall = complex.triangles[seed].wall;
        walls.push(wall);
        sheet_of[seed] = sheet;
        let mut members = vec![seed];
        let mut at = 0;
        while at < members.len() {
            let t = members[at];
            at += 1;
            for &(u, same_way) in &neighbours[t] {
                if sheet_of[u] == SheetId(u32::MAX) {
                    sheet_of[u] = sheet;
                    // Two triangles that run along their common edge the same way look to different sides.
                    flipped[u] = flipped[t] ^ same_way;
                    members.push(u);
                }
            }
        }
        // The sheet as a whole looks to the first side of its wall: every triangle votes with its area.
        let vote: f64 = members
            .iter()
            .map(|&t| {
                let p = complex.triangles[t].nodes.map(|n| complex.nodes[n].point);
                let area = (p[1] - p[0]).cross(p[2] - p[0]) * if flipped[t] { -1.0 } else { 1.0 };
                medial
                    .normal((p[0] + p[1] + p[2]) / 3.0, wall)
                    .map_or(0.0, |n| n.dot(area))
            })
            .sum();
        if vote < 0.0 {
            for t in members {
                flipped[t] = !flipped[t];
            }
        }
    }
    (sheet_of, flipped, walls)
}

fn element(
    brep: &Brep,
    medial: &Medial<'_>,
    complex: &MidComplex,
    t: TriangleId,
    sheet: SheetId,
    flipped: bool,
) -> Element {
    let triangle = complex.triangles[t];
    let mut nodes = triangle.nodes;
    if flipped {
        nodes.swap(1, 2);
    }
    let wall = triangle.wall;
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

/// Nodal thickness and normals from the elements.
fn nodal(mesh: &mut ShellMesh) {
    let mut weight: IndexVec<NodeId, f64> = IndexVec::filled(0.0, mesh.nodes.len());
    let mut thickness: IndexVec<NodeId, f64> = IndexVec::filled(0.0, mesh.nodes.len());
    let mut normal: IndexVec<NodeId, (Option<SheetId>, DVec3)> =
        IndexVec::filled((None, DVec3::ZERO), mesh.nodes.len());
    for e in &mesh.elements {
        let n = e.corners.as_slice();
        let p = |k: usize| mesh.nodes[n[k]];
        let area = if n.len() == 4 {
            (p(2) - p(0)).cross(p(3) - p(1))
        } else {
            (p(1) - p(0)).cross(p(2) - p(0))
        };
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
