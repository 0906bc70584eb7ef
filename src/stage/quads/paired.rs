//! Quads of a finished shell: pairs of triangles that share a given edge, then as many more as are worth it.
//!
//! Input: a shell mesh of triangles (quads in it stay). Output: the same nodes, fewer elements: inner edges of sheets vanish, nothing else
//! changes. Which edges vanish beside the given ones is a matching in the graph of neighbours, weighted by how near the quad's angles are to 90 degrees
//! (Remacle et al., "Blossom-Quad", doi:10.1002/nme.3279).
//!
//! Guarantees: no quad folds a mesh that was not folded; Euler characteristic, pieces, rims, junctions, creases, sheets, order of sheets and element normals are kept; no quad is
//! caved in or turned over; with [`ElementShape::Mixed`] every quad is a good one by the profile's criteria (not by its limits of single metrics); with [`ElementShape::Quad`] no other pairing
//! of these triangles beside the given edges has more quads within the limits of solvers. Thickness stays at its corner; where two triangles disagree at a corner
//! that they share, the quad takes the mean.
//! Limits: nodes do not move, so that quads are no better than the triangles let them be.

use super::matching::{self, Edge};
use super::usable::is_usable;
use crate::geom::quality::{QuadQuality, quad_quality};
use crate::model::element_shape::ElementShape;
use crate::model::ids::{ElementId, Id, IndexVec, NodeId};
use crate::model::report::Profile;
use crate::model::shell::{Corners, Element, ShellMesh};
use glam::DVec3;
use rayon::prelude::*;
use std::collections::BTreeSet;

/// What a pair across two source faces is worth less: face sets stay clean where it costs little.
const ACROSS_FACES: f64 = 0.7;

/// Two triangles with a common side, and the quad that they make.
struct Candidate {
    triangles: [ElementId; 2],
    corners: [NodeId; 4],
    weight: f64,
}

/// The mesh with its triangles paired as `shape` asks: those on either side of a `diagonal` (lower node first) before all others; `profile` says what a good
/// quad is.
pub fn pair_quads(
    mesh: &ShellMesh,
    diagonals: &[[NodeId; 2]],
    shape: ElementShape,
    profile: &Profile,
) -> ShellMesh {
    if shape == ElementShape::Triangle {
        return mesh.clone();
    }
    let candidates = candidates(mesh, diagonals, shape, profile);
    let edges: Vec<Edge> = candidates
        .iter()
        .map(|c| Edge {
            ends: c.triangles.map(|t| t.0),
            weight: c.weight,
        })
        .collect();
    let mate = matching::pair(mesh.elements.len(), &edges);
    let mut chosen: Vec<&Candidate> = (candidates.iter())
        .filter(|c| mate[c.triangles[0].index()] == Some(c.triangles[1].0))
        .collect();
    loop {
        let (paired, halves) = joined(mesh, &chosen);
        let folded = folded(&paired);
        let mut apart = vec![false; mesh.elements.len()];
        for &e in &folded {
            halves[e].iter().for_each(|t| apart[t.index()] = true);
        }
        let before = chosen.len();
        chosen.retain(|c| c.triangles.iter().all(|t| !apart[t.index()]));
        // What is folded without a quad was so before.
        if chosen.len() == before {
            return paired;
        }
    }
}

/// The mesh with these pairs as quads, and the elements of the old mesh that each one is made of.
fn joined(
    mesh: &ShellMesh,
    pairs: &[&Candidate],
) -> (ShellMesh, IndexVec<ElementId, Vec<ElementId>>) {
    let mut pair_at: Vec<Option<&Candidate>> = vec![None; mesh.elements.len()];
    for c in pairs {
        c.triangles
            .iter()
            .for_each(|t| pair_at[t.index()] = Some(c));
    }
    let mut elements = IndexVec::new();
    let mut halves = IndexVec::new();
    for (id, element) in mesh.elements.enumerated() {
        match pair_at[id.index()] {
            Some(c) if c.triangles[0] == id => {
                elements.push(quad(mesh, c));
                halves.push(c.triangles.to_vec());
            }
            Some(_) => {}
            None => {
                elements.push(element.clone());
                halves.push(vec![id]);
            }
        }
    }
    let paired = ShellMesh {
        elements,
        ..mesh.clone()
    };
    (paired, halves)
}

/// Elements that lie against all their neighbours in the sheet taken together, and these neighbours.
fn folded(mesh: &ShellMesh) -> Vec<ElementId> {
    let area = |e: &Element| mesh.doubled_area(e);
    let mut sides: Vec<([NodeId; 2], ElementId)> = Vec::new();
    for (id, element) in mesh.elements.enumerated() {
        let nodes = element.corners.as_slice();
        for (k, &a) in nodes.iter().enumerate() {
            let b = nodes[(k + 1) % nodes.len()];
            sides.push(([a.min(b), a.max(b)], id));
        }
    }
    sides.sort_unstable();
    let pairs: Vec<[ElementId; 2]> = (sides.chunk_by(|a, b| a.0 == b.0))
        .filter_map(|run| match run {
            [a, b] if mesh.elements[a.1].sheet == mesh.elements[b.1].sheet => Some([a.1, b.1]),
            _ => None,
        })
        .collect();
    let mut around = IndexVec::filled(DVec3::ZERO, mesh.elements.len());
    for &[a, b] in &pairs {
        around[a] += area(&mesh.elements[b]);
        around[b] += area(&mesh.elements[a]);
    }
    let is_folded: IndexVec<ElementId, bool> = (mesh.elements.enumerated())
        .map(|(id, e)| around[id].dot(area(e)) < 0.0)
        .collect();
    let mut found: Vec<ElementId> = (mesh.elements.ids()).filter(|&e| is_folded[e]).collect();
    for &[a, b] in &pairs {
        if is_folded[a] || is_folded[b] {
            found.extend([a, b]);
        }
    }
    found.sort_unstable();
    found.dedup();
    found
}

/// All pairs that may become quads, by their triangles; the lower triangle first.
fn candidates(
    mesh: &ShellMesh,
    diagonals: &[[NodeId; 2]],
    shape: ElementShape,
    profile: &Profile,
) -> Vec<Candidate> {
    let diagonals: BTreeSet<[NodeId; 2]> = diagonals.iter().copied().collect();
    let mut sides: Vec<(NodeId, NodeId, ElementId, bool)> = Vec::new();
    for (id, element) in mesh.elements.enumerated() {
        let nodes = element.corners.as_slice();
        for (k, &a) in nodes.iter().enumerate() {
            let b = nodes[(k + 1) % nodes.len()];
            sides.push((a.min(b), a.max(b), id, a < b));
        }
    }
    sides.sort_unstable();
    let pairs: Vec<(ElementId, ElementId, [NodeId; 2])> = sides
        .chunk_by(|a, b| (a.0, a.1) == (b.0, b.1))
        .filter_map(|run| match run {
            // Two elements that run opposite ways: normals agree.
            [a, b] if a.3 != b.3 => Some((a.2.min(b.2), a.2.max(b.2), [a.0, a.1])),
            _ => None,
        })
        .filter(|(a, b, ends)| {
            mesh.elements[*a].sheet == mesh.elements[*b].sheet
                && mesh.creases.binary_search(ends).is_err()
        })
        .collect();
    let mut all: Vec<(Candidate, bool)> = pairs
        .par_iter()
        .filter_map(|(a, b, ends)| {
            let given = diagonals.contains(&[ends[0].min(ends[1]), ends[0].max(ends[1])]);
            Some((candidate(mesh, *a, *b, *ends, shape, profile)?, given))
        })
        .collect();
    all.sort_by_key(|c| c.0.triangles);
    // A triangle with a given partner has no other.
    let mut promised = vec![false; mesh.elements.len()];
    for (c, _) in all.iter().filter(|c| c.1) {
        c.triangles.iter().for_each(|t| promised[t.index()] = true);
    }
    all.retain(|(c, given)| *given || c.triangles.iter().all(|t| !promised[t.index()]));
    all.into_iter().map(|c| c.0).collect()
}

fn candidate(
    mesh: &ShellMesh,
    a: ElementId,
    b: ElementId,
    ends: [NodeId; 2],
    shape: ElementShape,
    profile: &Profile,
) -> Option<Candidate> {
    let corners = union(mesh, a, b, ends)?;
    let points = corners.map(|n| mesh.nodes.get(n).copied());
    let [Some(p0), Some(p1), Some(p2), Some(p3)] = points else {
        return None;
    };
    let quality = quad_quality([p0, p1, p2, p3]);
    let fits = match shape {
        ElementShape::Mixed => is_good(&quality, profile),
        ElementShape::Quad | ElementShape::Triangle => is_usable(&quality),
    };
    let across = mesh.elements[a].source_faces != mesh.elements[b].source_faces;
    fits.then(|| Candidate {
        triangles: [a, b],
        corners,
        weight: score(&quality) * if across { ACROSS_FACES } else { 1.0 },
    })
}

/// The corners of two triangles with a common side, in the order that both have, from an end of that side: who parts a quad again parts it from its first corner.
fn union(mesh: &ShellMesh, a: ElementId, b: ElementId, ends: [NodeId; 2]) -> Option<[NodeId; 4]> {
    let (Corners::Triangle(t), Corners::Triangle(u)) =
        (mesh.elements[a].corners, mesh.elements[b].corners)
    else {
        return None;
    };
    let apex = t.iter().position(|n| !ends.contains(n))?;
    let across = u.into_iter().find(|n| !ends.contains(n))?;
    let (first, second) = (t[(apex + 1) % 3], t[(apex + 2) % 3]);
    (across != t[apex]).then_some([first, across, second, t[apex]])
}

fn is_good(q: &QuadQuality, profile: &Profile) -> bool {
    is_usable(q)
        && q.min_angle_deg >= profile.quad_angle_deg[0]
        && q.max_angle_deg <= profile.quad_angle_deg[1]
        && q.warp_deg <= profile.warp_deg_max
        && q.scaled_jacobian >= profile.scaled_jacobian_min
        && q.edge_ratio <= profile.edge_ratio_max
        && q.skew_deg <= profile.skew_deg_max
}

/// One for a flat quad of right angles, less the further its worst angle is off, and the more it is warped.
fn score(q: &QuadQuality) -> f64 {
    (1.0 - q.equiangle_skew).max(0.0) * (1.0 - q.warp_deg / 90.0).max(0.0)
}

fn quad(mesh: &ShellMesh, candidate: &Candidate) -> Element {
    let [a, b] = candidate.triangles.map(|t| &mesh.elements[t]);
    let at = |element: &Element, node: NodeId| {
        let nodes = element.corners.as_slice();
        let k = nodes.iter().position(|n| *n == node)?;
        Some(element.thickness[k])
    };
    let thickness = candidate.corners.map(|n| match (at(a, n), at(b, n)) {
        (Some(t), Some(u)) => (t + u) / 2.0,
        (Some(t), None) | (None, Some(t)) => t,
        (None, None) => 0.0,
    });
    // The faces of the larger triangle.
    let area = |e: &Element| {
        let p = e.corners.as_slice();
        let [o, u, v] = [p[0], p[1], p[2]].map(|n| mesh.nodes[n]);
        (u - o).cross(v - o).length_squared()
    };
    let source_faces = if area(b) > area(a) {
        b.source_faces
    } else {
        a.source_faces
    };
    Element {
        corners: Corners::Quad(candidate.corners),
        sheet: a.sheet,
        thickness,
        source_faces,
        unsure: a.unsure || b.unsure,
    }
}

#[cfg(test)]
mod tests {
    use super::super::usable::JACOBIAN;
    use super::*;
    use crate::geom::random::Pcg;
    use crate::model::ids::SheetId;
    use crate::test_parts::{element, plate_mesh, sheet};
    use glam::DVec3;

    /// The plate's mesh with every quad cut in two, in a random direction or always the same.
    fn cut(nu: usize, nv: usize, seed: Option<u64>) -> ShellMesh {
        let mut mesh = plate_mesh(nu, nv);
        let mut rng = Pcg::new(seed.unwrap_or(0));
        let mut elements = IndexVec::new();
        for e in &mesh.elements {
            let Corners::Quad([a, b, c, d]) = e.corners else {
                continue;
            };
            let halves = if seed.is_some() && rng.unit() < 0.5 {
                [[a, b, d], [b, c, d]]
            } else {
                [[a, b, c], [a, c, d]]
            };
            for t in halves {
                elements.push(element(Corners::Triangle(t), 0, 3.0));
            }
        }
        mesh.elements = elements;
        mesh
    }

    /// V - E + F and the free edges.
    fn facts(mesh: &ShellMesh) -> (i64, Vec<[NodeId; 2]>) {
        let mut edges: Vec<[NodeId; 2]> = mesh
            .elements
            .iter()
            .flat_map(|e| {
                let n = e.corners.as_slice();
                (0..n.len()).map(move |k| {
                    let (a, b) = (n[k], n[(k + 1) % n.len()]);
                    [a.min(b), a.max(b)]
                })
            })
            .collect();
        edges.sort_unstable();
        let runs: Vec<&[[NodeId; 2]]> = edges.chunk_by(|a, b| a == b).collect();
        let free = runs.iter().filter(|r| r.len() == 1).map(|r| r[0]).collect();
        let euler = mesh.nodes.len() as i64 - runs.len() as i64 + mesh.elements.len() as i64;
        (euler, free)
    }

    fn quads(mesh: &ShellMesh) -> Vec<QuadQuality> {
        mesh.elements
            .iter()
            .filter_map(|e| match e.corners {
                Corners::Quad(n) => Some(quad_quality(n.map(|n| mesh.nodes[n]))),
                Corners::Triangle(_) => None,
            })
            .collect()
    }

    #[test]
    fn a_cut_grid_becomes_its_squares_again() {
        for seed in [None, Some(1), Some(2)] {
            let triangles = cut(20, 12, seed);
            for shape in [ElementShape::Quad, ElementShape::Mixed] {
                let paired = pair_quads(&triangles, &[], shape, &Profile::shell());
                assert_eq!(paired.elements.len(), 240);
                let quads = quads(&paired);
                assert_eq!(quads.len(), 240);
                assert!(
                    quads
                        .iter()
                        .all(|q| (q.scaled_jacobian - 1.0).abs() < 1e-12)
                );
                assert_eq!(facts(&paired), facts(&triangles));
            }
            let same = pair_quads(&triangles, &[], ElementShape::Triangle, &Profile::shell());
            assert_eq!(same, triangles);
        }
    }

    #[test]
    fn a_shaken_grid_keeps_topology_and_mixed_takes_good_quads_only() {
        let mut triangles = cut(40, 24, Some(3));
        let mut rng = Pcg::new(8);
        for p in triangles.nodes.iter_mut() {
            if p.x > 0.1 && p.x < 99.9 && p.y > 0.1 && p.y < 59.9 {
                *p += DVec3::new(rng.unit() - 0.5, rng.unit() - 0.5, 0.0) * 1.6;
            }
        }
        let profile = Profile::shell();
        let all = pair_quads(&triangles, &[], ElementShape::Quad, &profile);
        let good = pair_quads(&triangles, &[], ElementShape::Mixed, &profile);
        assert_eq!(facts(&all), facts(&triangles));
        assert_eq!(facts(&good), facts(&triangles));
        assert!(quads(&all).iter().all(|q| q.scaled_jacobian >= JACOBIAN));
        assert!(quads(&good).iter().all(|q| is_good(q, &profile)));
        let share = |m: &ShellMesh| quads(m).len() as f64 / m.elements.len() as f64;
        assert!(share(&all) > 0.95, "{}", share(&all));
        assert!(share(&good) > 0.7 && share(&good) <= share(&all));
    }

    #[test]
    fn sheets_creases_and_orientation_are_not_crossed() {
        // The cells left and right of the middle belong to different sheets.
        let mut mesh = cut(4, 2, None);
        mesh.sheets.push(sheet());
        let centre = |mesh: &ShellMesh, e: &Element| {
            let n = e.corners.as_slice();
            n.iter().map(|n| mesh.nodes[*n].x).sum::<f64>() / n.len() as f64
        };
        let ids: Vec<ElementId> = mesh.elements.ids().collect();
        for id in ids {
            if centre(&mesh, &mesh.elements[id]) > 50.0 {
                mesh.elements[id].sheet = SheetId(1);
            }
        }
        let paired = pair_quads(&mesh, &[], ElementShape::Quad, &Profile::shell());
        for e in &paired.elements {
            let x = centre(&paired, e);
            assert_eq!(e.sheet == SheetId(1), x > 50.0);
        }
        // A crease along every diagonal: only pairs across the squares' own sides are left.
        let mut creased = cut(4, 2, None);
        for t in creased
            .elements
            .iter()
            .filter(|e| e.corners.as_slice()[0].0 % 5 < 4)
        {
            let n = t.corners.as_slice();
            let (a, c) = (n[0].min(n[2]), n[0].max(n[2]));
            if c.0 == a.0 + 6 {
                creased.creases.push([a, c]);
            }
        }
        creased.creases.sort_unstable();
        creased.creases.dedup();
        assert_eq!(creased.creases.len(), 8);
        let paired = pair_quads(&creased, &[], ElementShape::Quad, &Profile::shell());
        for e in &paired.elements {
            if let Corners::Quad(n) = e.corners {
                let q = quad_quality(n.map(|n| paired.nodes[n]));
                assert!(q.scaled_jacobian < 0.99);
            }
        }
        // Opposite normals do not pair.
        let mut turned = cut(1, 1, None);
        if let Corners::Triangle(n) = &mut turned.elements[ElementId(0)].corners {
            n.swap(0, 1);
        }
        let paired = pair_quads(&turned, &[], ElementShape::Quad, &Profile::shell());
        assert_eq!(paired.elements.len(), 2);
    }

    #[test]
    fn thickness_stays_at_its_corner_and_doubt_is_kept() {
        let mut mesh = cut(1, 1, None);
        let thick = |n: NodeId| 1.0 + f64::from(n.0);
        for e in mesh.elements.iter_mut() {
            let n: Vec<NodeId> = e.corners.as_slice().to_vec();
            e.thickness = [thick(n[0]), thick(n[1]), thick(n[2]), thick(n[2])];
        }
        mesh.elements[ElementId(1)].unsure = true;
        let paired = pair_quads(&mesh, &[], ElementShape::Quad, &Profile::shell());
        assert_eq!(paired.elements.len(), 1);
        let quad = &paired.elements[ElementId(0)];
        for (n, t) in quad.corners.as_slice().iter().zip(quad.thickness) {
            assert_eq!(t, thick(*n));
        }
        assert!(quad.unsure);
        // The normal is the triangles'.
        let p: Vec<DVec3> = quad
            .corners
            .as_slice()
            .iter()
            .map(|n| paired.nodes[*n])
            .collect();
        assert!((p[2] - p[0]).cross(p[3] - p[1]).z > 0.0);
    }

    #[test]
    fn a_caved_in_pair_is_left_as_triangles() {
        let mut mesh = cut(1, 1, None);
        mesh.nodes[NodeId(1)] = DVec3::new(49.0, 31.0, 1.5);
        let paired = pair_quads(&mesh, &[], ElementShape::Quad, &Profile::shell());
        assert_eq!(paired.elements.len(), 2);
    }
}
