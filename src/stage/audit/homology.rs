//! Betti numbers over Z/2 of the mesh and of the solids: pieces, loops, voids.
//!
//! The Euler characteristic alone cannot see a void that is traded for a handle. A solid's boundary is closed surfaces, so its numbers follow from counting:
//! a boundary surface that encloses negative volume is a void, and loops follow from the Euler characteristic. The mesh is a complex of elements: a set of elements
//! is closed if it uses each edge an even number of times. Over an edge of two elements it takes both or none, so elements are first joined into blocks over these;
//! what is left is one column a block, with a row for each set of blocks that meet in edges, reduced as in persistent homology.
//!
//! Cost: a sort of the edges, and elimination among blocks (tens to thousands), which is given up beyond a stated number of steps.
//! Limits: a boundary that touches itself in a point is counted as if it did not.
//!
//! Reference: H. Edelsbrunner, J. Harer, Computational Topology (2010), chapters IV and VII.

use crate::model::brep::Brep;
use crate::model::disjoint::Disjoint;
use crate::model::ids::{ElementId, FaceId, FacetId, Id};
use crate::model::shell::ShellMesh;
use glam::DVec3;
use std::collections::BTreeMap;

/// Homology of the mesh.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct Homology {
    pub betti: [usize; 3],
    /// A basis of the closed sets of elements, one a void.
    pub closed: Vec<Vec<ElementId>>,
}

/// A void of a solid.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Void {
    pub centre: DVec3,
    /// Half of the diagonal of the box around it.
    pub reach: f64,
    /// Tags of the faces round it.
    pub faces: Vec<i32>,
}

/// Of the mesh with this Euler characteristic; none where elimination takes more than `steps`.
pub(super) fn of_mesh(mesh: &ShellMesh, euler: i64, steps: usize) -> Option<Homology> {
    let count = mesh.elements.len();
    let mut sides = Vec::with_capacity(4 * count);
    for (id, element) in mesh.elements.enumerated() {
        let nodes = element.corners.as_slice();
        for (k, &a) in nodes.iter().enumerate() {
            let b = nodes[(k + 1) % nodes.len()];
            sides.push((a.min(b), a.max(b), id.0));
        }
    }
    sides.sort_unstable();
    let runs = || sides.chunk_by(|a, b| (a.0, a.1) == (b.0, b.1));
    let mut blocks = Disjoint::new(count);
    let mut nodes = Disjoint::new(mesh.nodes.len());
    let mut used = vec![false; mesh.nodes.len()];
    for run in runs() {
        let (a, b) = (run[0].0, run[0].1);
        if b.index() < used.len() {
            nodes.join(a.0, b.0);
            (used[a.index()], used[b.index()]) = (true, true);
        }
        if let [one, other] = run {
            blocks.join(one.2, other.2);
        }
    }
    let pieces = (0..used.len() as u32)
        .filter(|&n| used[n as usize] && nodes.find(n) == n)
        .count();
    // The blocks that meet an odd number of times in an edge; edges of the same blocks say the same.
    let mut rows: Vec<Vec<u32>> = runs()
        .filter(|run| run.len() != 2)
        .map(|run| odd(run.iter().map(|s| blocks.find(s.2)).collect()))
        .collect();
    rows.sort_unstable();
    rows.dedup();
    let mut columns: BTreeMap<u32, Vec<u32>> = (0..count as u32)
        .filter(|&e| blocks.find(e) == e)
        .map(|e| (e, Vec::new()))
        .collect();
    for (row, of) in rows.iter().enumerate() {
        for block in of {
            columns.entry(*block).or_default().push(row as u32);
        }
    }
    let cycles = kernel(columns.into_iter().collect(), steps)?;
    let closed: Vec<Vec<ElementId>> = cycles
        .into_iter()
        .map(|cycle| {
            let all = mesh.elements.ids();
            all.filter(|e| cycle.binary_search(&blocks.find(e.0)).is_ok())
                .collect()
        })
        .collect();
    let loops = pieces as i64 + closed.len() as i64 - euler;
    Some(Homology {
        betti: [pieces, usize::try_from(loops).unwrap_or(0), closed.len()],
        closed,
    })
}

/// Those that are there an odd number of times, ascending.
fn odd(mut all: Vec<u32>) -> Vec<u32> {
    all.sort_unstable();
    all.chunk_by(|a, b| a == b)
        .filter(|run| run.len() % 2 == 1)
        .map(|run| run[0])
        .collect()
}

/// A basis of the sets of columns that add up to nothing, each ascending. A column is its name and its rows, ascending.
fn kernel(columns: Vec<(u32, Vec<u32>)>, steps: usize) -> Option<Vec<Vec<u32>>> {
    /// A reduced column, and the columns that it is the sum of.
    type Reduced = (Vec<u32>, Vec<u32>);
    let mut by_last: BTreeMap<u32, Reduced> = BTreeMap::new();
    let mut cycles = Vec::new();
    let mut spent = 0;
    for (name, mut rows) in columns {
        let mut of = vec![name];
        while let Some(&last) = rows.last() {
            let Some((other, others)) = by_last.get(&last) else {
                break;
            };
            spent += rows.len() + other.len() + of.len() + others.len();
            if spent > steps {
                return None;
            }
            rows = odd([&rows[..], other].concat());
            of = odd([&of[..], others].concat());
        }
        match rows.last() {
            Some(&last) => {
                by_last.insert(last, (rows, of));
            }
            None => cycles.push(of),
        }
    }
    Some(cycles)
}

/// Betti numbers of the solids, and their voids.
pub(super) fn of_solids(solids: &[&Brep]) -> ([usize; 3], Vec<Void>) {
    let voids: Vec<Void> = solids.iter().flat_map(|s| voids(s)).collect();
    let half: i64 = solids.iter().map(|s| s.euler()).sum::<i64>() / 2;
    let loops = solids.len() as i64 + voids.len() as i64 - half;
    let loops = usize::try_from(loops).unwrap_or(0);
    ([solids.len(), loops, voids.len()], voids)
}

/// The closed pieces of the boundary that have the material outside.
fn voids(solid: &Brep) -> Vec<Void> {
    let mut sides = Vec::with_capacity(3 * solid.facets.len());
    for (id, facet) in solid.facets.enumerated() {
        let [a, b, c] = facet.corners;
        for (p, q) in [(a, b), (b, c), (c, a)] {
            sides.push((p.min(q), p.max(q), id.0));
        }
    }
    sides.sort_unstable();
    let mut shells = Disjoint::new(solid.facets.len());
    // Where four facets meet two surfaces touch: each hangs together without that side.
    for run in sides.chunk_by(|a, b| (a.0, a.1) == (b.0, b.1)) {
        if let [one, other] = run {
            shells.join(one.2, other.2);
        }
    }
    let mut members: Vec<(u32, FacetId)> = (0..solid.facets.len() as u32)
        .map(|f| (shells.find(f), FacetId(f)))
        .collect();
    members.sort_unstable();
    members
        .chunk_by(|a, b| a.0 == b.0)
        .filter_map(|shell| {
            let origin = solid.corners(shell[0].1)[0];
            let (mut volume, mut low, mut high) = (0.0, DVec3::INFINITY, DVec3::NEG_INFINITY);
            let mut faces: Vec<FaceId> = Vec::new();
            for (_, facet) in shell {
                let corners = solid.corners(*facet);
                for p in corners {
                    (low, high) = (low.min(p), high.max(p));
                }
                let [a, b, c] = corners.map(|p| p - origin);
                volume += a.dot(b.cross(c));
                faces.push(solid.facets[*facet].face);
            }
            faces.sort_unstable();
            faces.dedup();
            let tag = |f: &FaceId| solid.faces.get(*f).map(|face| face.tag);
            (volume < 0.0).then(|| Void {
                centre: (low + high) / 2.0,
                reach: (high - low).length() / 2.0,
                faces: faces.iter().filter_map(tag).collect(),
            })
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::model::shell::Corners;
    use crate::test_parts::{box_brep, drum_mesh, element, hollow_brep, plate_mesh, tube_brep};

    const STEPS: usize = 1_000_000;

    fn betti(mesh: &ShellMesh) -> [usize; 3] {
        let euler = super::super::topology::look_at(mesh).euler;
        of_mesh(mesh, euler, STEPS).unwrap().betti
    }

    #[test]
    fn known_surfaces_have_their_numbers() {
        assert_eq!(betti(&plate_mesh(4, 3)), [1, 0, 0]);
        assert_eq!(betti(&drum_mesh(false)), [1, 1, 0]);
        assert_eq!(betti(&drum_mesh(true)), [1, 0, 1]);
        let mut holed = plate_mesh(6, 6);
        let kept = holed.elements.iter().enumerate();
        holed.elements = kept
            .filter(|(i, _)| ![7, 10, 25].contains(i))
            .map(|(_, e)| e.clone())
            .collect();
        assert_eq!(betti(&holed), [1, 3, 0]);
        assert_eq!(betti(&ShellMesh::default()), [0, 0, 0]);
    }

    #[test]
    fn a_wall_across_a_closed_box_makes_two_voids() {
        // A drum with a disc in its middle: a junction ring, three blocks, any two of them closed.
        let mut mesh = drum_mesh(true);
        let centre = mesh.nodes.push(DVec3::Z);
        for i in 0..8u32 {
            let at = |i: u32| crate::model::ids::NodeId(8 + i % 8);
            let fan = Corners::Triangle([at(i), at(i + 1), centre]);
            mesh.elements.push(element(fan, 0, 1.0));
        }
        assert_eq!(betti(&mesh), [1, 0, 2]);
        let found = of_mesh(&mesh, 3, STEPS).unwrap();
        let all: usize = found.closed.iter().map(Vec::len).sum();
        assert!(all >= mesh.elements.len(), "each void has its own walls");
        // Too dear: it is not counted.
        assert_eq!(of_mesh(&mesh, 3, 1), None);
    }

    #[test]
    fn solids_and_their_voids() {
        let tube = tube_brep(50.0, 49.0, 80.0, 24);
        assert_eq!(of_solids(&[&tube]).0, [1, 1, 0]);
        let plate = box_brep(DVec3::new(10.0, 10.0, 1.0));
        assert_eq!(of_solids(&[&plate, &plate]).0, [2, 0, 0]);
        let (betti, voids) = of_solids(&[&hollow_brep()]);
        assert_eq!(betti, [1, 0, 1]);
        assert_eq!(voids[0].centre, DVec3::splat(10.0));
        assert_eq!(voids[0].faces, [7, 8, 9, 10, 11, 12]);
    }
}
