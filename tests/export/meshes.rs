//! Tiny meshes that between them have everything a writer can meet.

use glam::DVec3;
use midshell::model::ids::{IndexVec, NodeId, SheetId, WallId};
use midshell::model::shell::{Corners, Element, Sheet, ShellMesh};
use std::collections::BTreeMap;

/// An element to be: corners (from 0), sheet, corner thickness.
type Sketch<'a> = (&'a [u32], u32, &'a [f64]);

/// A mesh from nodes and elements. Rims and junctions are found by counting, creases are edges of two sheets. Sheet `s` lies between faces `10 + s` and `20 + s` and belongs to solid 1.
pub fn build(nodes: &[[f64; 3]], sketches: &[Sketch<'_>]) -> ShellMesh {
    let nodes: IndexVec<NodeId, DVec3> = nodes.iter().map(|p| DVec3::from(*p)).collect();
    let sheets = 1 + sketches.iter().map(|s| s.1).max().unwrap();
    let mut sums = IndexVec::filled((0.0, 0.0), nodes.len());
    let mut normals: IndexVec<NodeId, DVec3> = IndexVec::filled(DVec3::ZERO, nodes.len());
    let mut edges: BTreeMap<[NodeId; 2], Vec<u32>> = BTreeMap::new();
    let mut elements = IndexVec::new();
    for &(corners, sheet, thickness) in sketches {
        let ids: Vec<NodeId> = corners.iter().map(|&n| NodeId(n)).collect();
        let diagonal = nodes[ids[2]] - nodes[ids[0]];
        let normal = diagonal.cross(nodes[*ids.last().unwrap()] - nodes[ids[1]]);
        for (k, &id) in ids.iter().enumerate() {
            sums[id].0 += thickness[k];
            sums[id].1 += 1.0;
            normals[id] += normal;
            let next = ids[(k + 1) % ids.len()];
            edges
                .entry([id.min(next), id.max(next)])
                .or_default()
                .push(sheet);
        }
        elements.push(Element {
            corners: match *ids.as_slice() {
                [a, b, c] => Corners::Triangle([a, b, c]),
                [a, b, c, d] => Corners::Quad([a, b, c, d]),
                _ => unreachable!("three or four corners"),
            },
            sheet: SheetId(sheet),
            thickness: [0, 1, 2, 3].map(|k| thickness[k.min(thickness.len() - 1)]),
            source_faces: [10 + sheet as i32, 20 + sheet as i32],
            unsure: sheet == 2,
        });
    }
    let with = |wanted: &dyn Fn(&[u32]) -> bool| -> Vec<[NodeId; 2]> {
        let found = edges.iter().filter(|(_, sheets)| wanted(sheets));
        found.map(|(edge, _)| *edge).collect()
    };
    ShellMesh {
        node_thickness: sums.iter().map(|(sum, count)| sum / count).collect(),
        node_normals: normals.iter().map(|n| n.normalize_or(DVec3::Z)).collect(),
        rims: with(&|sheets| sheets.len() == 1),
        junctions: with(&|sheets| sheets.len() > 2),
        creases: with(&|sheets| sheets.len() == 2 && sheets[0] != sheets[1]),
        elements,
        sheets: (0..sheets)
            .map(|s| Sheet {
                solid_tag: 1,
                wall: WallId(s),
                sides: [vec![10 + s as i32], vec![20 + s as i32]],
            })
            .collect(),
        nodes,
    }
}

/// A T of a plate in two halves and a rib; `thickness` gives each of the three sheets' value at a distance from the junction (0 or 10).
fn tee(thickness: impl Fn(u32, f64) -> f64) -> ShellMesh {
    let nodes = [
        [0.0, 0.0, 0.0],
        [0.0, 10.0, 0.0],
        [-10.0, 0.0, 0.0],
        [-10.0, 10.0, 0.0],
        [10.0, 0.0, 0.0],
        [10.0, 10.0, 0.0],
        [0.0, 0.0, 10.0],
        [0.0, 10.0, 10.0],
    ];
    let near = |s: u32| thickness(s, 0.0);
    let far = |s: u32| thickness(s, 10.0);
    let quad = |s: u32| [far(s), near(s), near(s), far(s)];
    let (left, right, rib) = (quad(0), quad(1), quad(2));
    build(
        &nodes,
        &[
            (&[2, 0, 1, 3], 0, &left),
            (&[4, 0, 1, 5], 1, &right),
            (&[6, 0, 1, 7], 2, &rib),
        ],
    )
}

/// Every tiny mesh with its name.
pub fn all() -> Vec<(&'static str, ShellMesh)> {
    let square = [
        [0.0, 0.0, 0.0],
        [10.0, 0.0, 0.0],
        [10.0, 10.0, 0.0],
        [0.0, 10.0, 0.0],
    ];
    // A thickness with more digits than a narrow field holds.
    let third = 1.0 / 3.0;
    let mixed_nodes = [
        [0.0, 0.0, -1.0 / 7.0],
        [10.0, 0.0, -1.0 / 7.0],
        [10.0, 10.0, -1.0 / 7.0],
        [0.0, 10.0, -1.0 / 7.0],
        [20.0, 0.0, -1.0 / 7.0],
        [20.0, 10.0, -1.0 / 7.0],
    ];
    let two = [2.0; 4];
    let mixed: [Sketch<'_>; 3] = [
        (&[0, 1, 2, 3], 0, &two),
        (&[1, 4, 2], 0, &two[..3]),
        (&[4, 5, 2], 0, &two[..3]),
    ];
    let fold_nodes = [
        square[0],
        square[1],
        square[2],
        square[3],
        [10.0, 0.0, 10.0],
        [10.0, 10.0, 10.0],
    ];
    vec![
        (
            "triangle",
            build(&square[..3], &[(&[0, 1, 2], 0, &[third; 3])]),
        ),
        ("quad", build(&square, &[(&[0, 1, 2, 3], 0, &[1.0; 4])])),
        ("mixed", build(&mixed_nodes, &mixed)),
        (
            "taper",
            build(
                &square,
                &[(&[0, 1, 2, 3], 0, &[1.0, 1.5, 1.5 + third, 1.0 + third])],
            ),
        ),
        (
            "fold",
            build(
                &fold_nodes,
                &[(&[0, 1, 2, 3], 0, &two), (&[1, 4, 5, 2], 1, &[1.0; 4])],
            ),
        ),
        ("tee", tee(|sheet, _| if sheet == 2 { 1.0 } else { 3.0 })),
        (
            "tapered tee",
            tee(|sheet, far| {
                if sheet == 2 {
                    2.0 - far / 10.0
                } else {
                    3.0 + far / 20.0
                }
            }),
        ),
    ]
}

/// What a plate is made of.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Kind {
    Quads,
    Triangles,
    /// Two columns of quads, two of triangles, and so on.
    Mixed,
}

/// A plate of `cells` between (0, 0) and `size`, quads or pairs of triangles, with a thickness that depends on x; node `i * (cells[1] + 1) + j` is the `j`-th across.
pub fn plate(
    size: [f64; 2],
    cells: [u32; 2],
    thickness: impl Fn(f64) -> f64,
    kind: Kind,
) -> ShellMesh {
    let [along, across] = cells;
    let mut nodes = Vec::new();
    for i in 0..=along {
        for j in 0..=across {
            let part = [
                f64::from(i) / f64::from(along),
                f64::from(j) / f64::from(across),
            ];
            nodes.push([size[0] * part[0], size[1] * part[1], 0.0]);
        }
    }
    let mut corners: Vec<Vec<u32>> = Vec::new();
    for i in 0..along {
        for j in 0..across {
            let at = |di: u32, dj: u32| (i + di) * (across + 1) + j + dj;
            let [a, b, c, d] = [at(0, 0), at(1, 0), at(1, 1), at(0, 1)];
            let triangles = match kind {
                Kind::Quads => false,
                Kind::Triangles => true,
                Kind::Mixed => i / 2 % 2 == 1,
            };
            match (triangles, (i + j) % 2) {
                (false, _) => corners.push(vec![a, b, c, d]),
                // Alternate diagonals: all one way would favour a direction.
                (true, 0) => corners.extend([vec![a, b, c], vec![a, c, d]]),
                (true, _) => corners.extend([vec![a, b, d], vec![b, c, d]]),
            }
        }
    }
    let at_node = |n: &u32| thickness(nodes[*n as usize][0]);
    let values: Vec<Vec<f64>> = corners
        .iter()
        .map(|c| c.iter().map(at_node).collect())
        .collect();
    let sketches: Vec<Sketch<'_>> = corners
        .iter()
        .zip(&values)
        .map(|(c, v)| (c.as_slice(), 0, v.as_slice()))
        .collect();
    build(&nodes, &sketches)
}
