//! Betti numbers over GF(2) of two-dimensional complexes: pieces, loops, voids. The judge of all topology in the unit tests.

use crate::model::complex::MidComplex;
use crate::model::decomposition::Collapsed;
use crate::model::ids::Id;
use crate::model::tet_graph::TetGraph;
use std::collections::{BTreeMap, BTreeSet};

/// Pieces, independent loops, voids.
pub(crate) type Betti = [usize; 3];

/// A cell complex: `lines` by their two ends, `cells` by their lines; ends and lines are named by any numbers.
#[derive(Default)]
pub(crate) struct Cells {
    points: BTreeSet<u64>,
    lines: BTreeMap<u64, [u64; 2]>,
    cells: Vec<Vec<u64>>,
}

impl Cells {
    fn line(&mut self, name: u64, ends: [u64; 2]) {
        self.points.extend(ends);
        self.lines.insert(name, ends);
    }

    pub fn betti(&self) -> Betti {
        let columns = self.lines.values().map(|e| {
            if e[0] == e[1] {
                Vec::new()
            } else {
                vec![e[0].min(e[1]), e[0].max(e[1])]
            }
        });
        let first = rank(columns);
        let second = rank(self.cells.iter().cloned());
        [
            self.points.len() - first,
            self.lines.len() - first - second,
            self.cells.len() - second,
        ]
    }
}

/// Rank over GF(2) of columns given by the rows of their ones.
fn rank(columns: impl Iterator<Item = Vec<u64>>) -> usize {
    let mut by_last: BTreeMap<u64, Vec<u64>> = BTreeMap::new();
    for mut column in columns {
        column.sort_unstable();
        while let Some(&last) = column.last() {
            let Some(other) = by_last.get(&last) else {
                by_last.insert(last, column);
                break;
            };
            column = sum(&column, other);
        }
    }
    by_last.len()
}

/// Rows that are in one of two sorted columns, not in both.
fn sum(a: &[u64], b: &[u64]) -> Vec<u64> {
    let (mut i, mut j) = (0, 0);
    let mut out = Vec::with_capacity(a.len() + b.len());
    while i < a.len() || j < b.len() {
        if j == b.len() || (i < a.len() && a[i] < b[j]) {
            out.push(a[i]);
            i += 1;
        } else if i == a.len() || b[j] < a[i] {
            out.push(b[j]);
            j += 1;
        } else {
            (i, j) = (i + 1, j + 1);
        }
    }
    out
}

/// Of all that a collapse leaves: living 2-cells with their borders, and bars. `None` where nothing but a point is left.
pub(crate) fn of_collapsed(graph: &TetGraph, collapsed: &Collapsed) -> Option<Betti> {
    let tet = |t: u32| u64::from(t) * 2;
    let outer = |f: u32| u64::from(f) * 2 + 1;
    let mut cells = Cells::default();
    let mut around: BTreeMap<u32, Vec<u32>> = BTreeMap::new();
    for (f, es) in graph.face_edges.enumerated() {
        for e in es.iter().filter(|&&e| collapsed.cells[e]) {
            around.entry(e.0).or_default().push(f.0);
        }
    }
    let mut lines: BTreeSet<u32> = collapsed.bars.iter().map(|f| f.0).collect();
    for (&e, faces) in &around {
        lines.extend(faces);
        let mut border: Vec<u64> = faces.iter().map(|&f| tet(f)).collect();
        let ends: Vec<u32> = faces
            .iter()
            .copied()
            .filter(|&f| graph.on_boundary(Id::new(f as usize)))
            .collect();
        // The 2-cell of a boundary edge has one more line, on the boundary.
        if let [f, g] = ends[..] {
            cells.line(outer(e), [outer(f), outer(g)]);
            border.push(outer(e));
        }
        cells.cells.push(border);
    }
    for f in lines {
        let id = Id::new(f as usize);
        let [a, b] = graph.face_tets[id];
        let end = if graph.on_boundary(id) {
            outer(f)
        } else {
            tet(b.0)
        };
        cells.line(tet(f), [tet(a.0), end]);
    }
    (!cells.points.is_empty()).then(|| cells.betti())
}

/// Of a mid-complex.
pub(crate) fn of_complex(complex: &MidComplex) -> Betti {
    let mut cells = Cells::default();
    let mut of_triangle = vec![Vec::new(); complex.triangles.len()];
    for (i, edge) in complex.edges().iter().enumerate() {
        cells.line(i as u64, edge.ends.map(|n| u64::from(n.0)));
        for t in &edge.triangles {
            of_triangle[t.index()].push(i as u64);
        }
    }
    cells.cells = of_triangle;
    cells.betti()
}

#[test]
fn betti_numbers_of_known_surfaces() {
    use crate::stage::test_shapes as shapes;
    for (complex, betti) in [
        (shapes::half_cylinder(8, 4), [1, 0, 0]),
        (shapes::tube(12, 4, 30.0), [1, 1, 0]),
        (shapes::torus(12, 8), [1, 2, 1]),
        (shapes::sphere(3, false), [1, 0, 1]),
        (shapes::moebius(), [1, 1, 0]),
        (shapes::rib_on_plate(0.5), [1, 0, 0]),
    ] {
        assert_eq!(of_complex(&complex), betti);
    }
}
