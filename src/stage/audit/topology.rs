//! What the mesh is as a complex: Euler characteristic, pieces, free edges, junctions and folds, elements that are turned over.

use crate::model::disjoint::Disjoint;
use crate::model::ids::{ElementId, Id, NodeId, SheetId};
use crate::model::shell::ShellMesh;
use glam::DVec3;

/// Folds sharper than this have no thickness of their own nearby.
const FOLD_DEG: f64 = 20.0;

/// Facts about the mesh as a complex.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct Topology {
    pub euler: i64,
    pub pieces: usize,
    /// For each element the first of its piece.
    pub piece_of: Vec<ElementId>,
    pub orphans: Vec<NodeId>,
    pub not_finite: Vec<ElementId>,
    pub flipped: Vec<ElementId>,
    /// Edges inside a sheet whose two elements run the same way.
    pub misoriented: Vec<([NodeId; 2], [ElementId; 2])>,
    /// Edges of one element.
    pub free: Vec<([NodeId; 2], ElementId)>,
    /// Edges of three elements or more, and sharp folds.
    pub special: Vec<[NodeId; 2]>,
    /// How many of these are of three elements or more.
    pub junctions: usize,
}

/// A side of an element: its ends in order of id, the element, whether the element runs from the lower to the higher.
type Side = (NodeId, NodeId, ElementId, bool);

/// Whether the element's numbers can be used.
pub(super) fn is_sound(mesh: &ShellMesh, id: ElementId) -> bool {
    let element = &mesh.elements[id];
    let nodes = element.corners.as_slice();
    nodes
        .iter()
        .all(|n| mesh.nodes.get(*n).is_some_and(|p| p.is_finite()))
        && element.thickness[..nodes.len()]
            .iter()
            .all(|t| t.is_finite() && *t > 0.0)
}

/// Twice the area vector of an element; zero where it is not sound.
fn area_vector(mesh: &ShellMesh, id: ElementId) -> DVec3 {
    if !is_sound(mesh, id) {
        return DVec3::ZERO;
    }
    mesh.doubled_area(&mesh.elements[id])
}

/// Whether a corner of a quad caves in or vanishes, or a triangle has no area.
fn is_inverted(mesh: &ShellMesh, id: ElementId, normal: DVec3) -> bool {
    let nodes = mesh.elements[id].corners;
    let p: Vec<DVec3> = nodes.as_slice().iter().map(|n| mesh.nodes[*n]).collect();
    let n = p.len();
    (0..n).any(|k| {
        let (u, v) = (p[(k + 1) % n] - p[k], p[(k + n - 1) % n] - p[k]);
        // Below this sine a corner is flat within the rounding of the coordinates.
        u.cross(v).dot(normal) <= 1e-9 * u.length() * v.length() * normal.length()
    })
}

/// Looks at the mesh. Elements that name missing nodes or hold numbers that are not finite are counted in `not_finite`; in Euler
/// characteristic and pieces they count like any other.
pub(super) fn look_at(mesh: &ShellMesh) -> Topology {
    let mut used = vec![false; mesh.nodes.len()];
    let mut sides: Vec<Side> = Vec::with_capacity(4 * mesh.elements.len());
    for (id, element) in mesh.elements.enumerated() {
        let nodes = element.corners.as_slice();
        for (k, &a) in nodes.iter().enumerate() {
            let b = nodes[(k + 1) % nodes.len()];
            sides.push((a.min(b), a.max(b), id, a < b));
            if let Some(used) = used.get_mut(a.index()) {
                *used = true;
            }
        }
    }
    sides.sort_unstable();
    let vectors: Vec<DVec3> = mesh
        .elements
        .ids()
        .map(|id| area_vector(mesh, id))
        .collect();
    let mut out = Topology::default();
    let mut sets = Disjoint::new(mesh.elements.len());
    let mut around = vec![DVec3::ZERO; mesh.elements.len()];
    let sheet = |id: ElementId| -> SheetId { mesh.elements[id].sheet };
    let mut edges = 0usize;
    for run in sides.chunk_by(|a, b| (a.0, a.1) == (b.0, b.1)) {
        edges += 1;
        for side in &run[1..] {
            sets.join(run[0].2.0, side.2.0);
        }
        let ends = [run[0].0, run[0].1];
        match run {
            [one] => out.free.push((ends, one.2)),
            [a, b] => {
                let (u, v) = (vectors[a.2.index()], vectors[b.2.index()]);
                let cosine = u.normalize_or_zero().dot(v.normalize_or_zero());
                if cosine.abs() < FOLD_DEG.to_radians().cos() {
                    out.special.push(ends);
                }
                if sheet(a.2) == sheet(b.2) {
                    if a.3 == b.3 {
                        out.misoriented.push((ends, [a.2, b.2]));
                    } else {
                        around[a.2.index()] += v;
                        around[b.2.index()] += u;
                    }
                }
            }
            _ => {
                out.special.push(ends);
                out.junctions += 1;
            }
        }
    }
    for (id, vector) in mesh.elements.ids().zip(&vectors) {
        if !is_sound(mesh, id) {
            out.not_finite.push(id);
        } else if is_inverted(mesh, id, *vector) || vector.dot(around[id.index()]) < 0.0 {
            // Against all of its neighbours in the sheet: folded over.
            out.flipped.push(id);
        }
    }
    out.orphans = mesh.nodes.ids().filter(|n| !used[n.index()]).collect();
    let nodes = used.len() - out.orphans.len();
    out.euler = nodes as i64 - edges as i64 + mesh.elements.len() as i64;
    out.pieces = sets.sets();
    out.piece_of = mesh
        .elements
        .ids()
        .map(|e| ElementId(sets.find(e.0)))
        .collect();
    out
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::model::shell::Corners;
    use crate::test_parts::plate_mesh;

    #[test]
    fn a_plate_is_one_disc() {
        let t = look_at(&plate_mesh(20, 12));
        assert_eq!((t.euler, t.pieces), (1, 1));
        assert!(t.flipped.is_empty() && t.misoriented.is_empty());
        assert!(t.not_finite.is_empty() && t.orphans.is_empty());
        assert_eq!((t.free.len(), t.special.len()), (64, 0));
    }

    #[test]
    fn every_planted_defect_is_counted() {
        let mut mesh = plate_mesh(20, 12);
        mesh.nodes.push(DVec3::ZERO);
        assert_eq!(look_at(&mesh).orphans, [NodeId(273)]);

        let mut mesh = plate_mesh(20, 12);
        if let Corners::Quad(n) = &mut mesh.elements[ElementId(125)].corners {
            n.reverse();
        }
        let wrong = look_at(&mesh).misoriented;
        assert_eq!(wrong.len(), 4);
        assert!(wrong.iter().all(|(_, e)| e.contains(&ElementId(125))));

        let mut mesh = plate_mesh(20, 12);
        mesh.nodes[NodeId(130)].x += 7.0;
        assert!(look_at(&mesh).flipped.len() >= 2);

        let mut mesh = plate_mesh(20, 12);
        mesh.elements[ElementId(7)].thickness[2] = 0.0;
        mesh.elements[ElementId(9)].corners =
            Corners::Triangle([NodeId(0), NodeId(1), NodeId(99_999)]);
        assert_eq!(look_at(&mesh).not_finite, [7, 9].map(ElementId));
    }
}
