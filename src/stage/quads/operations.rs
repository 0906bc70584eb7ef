//! Operations: the few ways in which quads are exchanged for others, whatever for.
//!
//! A quad is collapsed along a diagonal, an edge between two quads turned, a node opened into two with a quad between them
//! (Kinney 1997, "CleanUp: improving quadrilateral finite element meshes"; Docampo-Sánchez & Haimes 2019), a triangle and a quad cut anew.
//! Each gives the [`Change`]; whether it pays is for [`super::change`] to say.

use super::cells::{Cells, Ring};
use super::change::{Change, NewNode};
use smallvec::{SmallVec, smallvec};

/// A new node lies this far from the old one, towards the far corners of the cells that it gets.
const APART: f64 = 0.35;

/// Makes one node of the `k`-th of a quad, which vanishes, and the one opposite.
pub(super) fn collapsed(cells: &Cells, cell: u32, k: usize) -> Option<Change> {
    let ring = cells.ring(cell);
    let (a, c) = (ring[k], ring[(k + 2) % 4]);
    let star = cells.star(a);
    let others = || star.iter().filter(|&&o| o != cell);
    if cells.held[a as usize] || others().any(|&o| cells.ring(o).contains(&c)) {
        return None;
    }
    let mut change = Change {
        gone: star.clone(),
        ..Change::default()
    };
    for &o in others() {
        let swap = |&n: &u32| if n == a { c } else { n };
        change.new.push(cells.ring(o).iter().map(swap).collect());
    }
    if !cells.held[c as usize] {
        let middle = (cells.points[a as usize] + cells.points[c as usize]) / 2.0;
        change.moved.push((c, middle));
    }
    Some(change)
}

/// The other two diagonals of the hexagon that a quad makes with the one across its `k`-th edge.
pub(super) fn turned(cells: &Cells, cell: u32, k: usize) -> SmallVec<[Change; 2]> {
    let hexagon = cells.across(cell, k).and_then(|other| {
        let ring = cells.ring(cell);
        let [u, v, p, q] = [0, 1, 2, 3].map(|i| ring[(k + i) % 4]);
        let j = cells.side(other, v, u).filter(|_| cells.is_quad(other))?;
        let around = cells.ring(other);
        let [r, s] = [2, 3].map(|i| around[(j + i) % 4]);
        Some((other, [u, v, p, q, r, s]))
    });
    let Some((other, [u, v, p, q, r, s])) = hexagon else {
        return SmallVec::new();
    };
    let ways: [([u32; 2], [Ring; 2]); 2] = [
        ([p, r], [smallvec![p, q, u, r], smallvec![r, s, v, p]]),
        ([q, s], [smallvec![q, u, r, s], smallvec![s, v, p, q]]),
    ];
    (ways.into_iter())
        .filter(|([a, b], _)| a != b && !cells.joined(*a, *b))
        .map(|(_, new)| Change {
            gone: smallvec![cell, other],
            new: new.into_iter().collect(),
            ..Change::default()
        })
        .collect()
}

/// Gives neighbouring quads of a node, in their order round it, to a new node, with a quad between the two.
pub(super) fn opened(cells: &Cells, node: u32, range: &[u32]) -> Option<Change> {
    let beside = |cell: Option<&u32>, ahead: usize| {
        let ring = cells.ring(*cell?);
        let k = ring.iter().position(|&n| n == node)?;
        Some(ring[(k + ahead) % 4])
    };
    let (right, left) = (beside(range.first(), 1)?, beside(range.last(), 3)?);
    let far = |c: &u32| beside(Some(c), 2).map(|n| cells.points[n as usize]);
    let home = cells.points[node as usize];
    let mean = range.iter().filter_map(far).sum::<glam::DVec3>() / range.len() as f64;
    let new = cells.points.len() as u32;
    let swapped = range.iter().map(|&c| {
        let swap = |&n: &u32| if n == node { new } else { n };
        cells.ring(c).iter().map(swap).collect()
    });
    let between = smallvec![node, right, new, left];
    Some(Change {
        gone: range.iter().copied().collect(),
        new: swapped.chain([between]).collect(),
        added: smallvec![NewNode {
            point: home.lerp(mean, APART),
            near: node,
        }],
        ..Change::default()
    })
}

/// All runs of so many neighbouring quads round a node that may go to a new one. On a boundary the first and the last edge stay at the node.
pub(super) fn runs(cells: &Cells, node: u32, taken: usize) -> Vec<SmallVec<[u32; 4]>> {
    let held = cells.held[node as usize];
    let mut all = Vec::new();
    for fan in cells.fans(node) {
        let n = fan.len();
        if n < taken + 2 || fan.iter().any(|&c| !cells.is_quad(c)) {
            continue;
        }
        let starts = if held { 1..n - taken } else { 0..n };
        all.extend(starts.map(|i| (0..taken).map(|d| fan[(i + d) % n]).collect()));
    }
    all
}

/// A triangle and the quad across its `k`-th edge, cut in the four other ways.
pub(super) fn recut(cells: &Cells, triangle: u32, k: usize) -> SmallVec<[Change; 4]> {
    let pentagon = cells.across(triangle, k).and_then(|other| {
        let ring = cells.ring(triangle);
        let [a, b, c] = [0, 1, 2].map(|i| ring[(k + i) % 3]);
        let j = cells.side(other, b, a).filter(|_| cells.is_quad(other))?;
        let around = cells.ring(other);
        Some((other, [c, a, around[(j + 2) % 4], around[(j + 3) % 4], b]))
    });
    let Some((other, pentagon)) = pentagon else {
        return SmallVec::new();
    };
    // The triangle is cut off at one of the corners; as it is, it is cut off at the first.
    (1..5)
        .map(|i| [0, 1, 2, 3, 4].map(|d| pentagon[(i + d) % 5]))
        .filter(|n| n[1] != n[4] && !cells.joined(n[1], n[4]))
        .map(|n| Change {
            gone: smallvec![triangle, other],
            new: smallvec![
                smallvec![n[4], n[0], n[1]],
                smallvec![n[1], n[2], n[3], n[4]]
            ],
            ..Change::default()
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::super::test_grid::{at, grid, with_rings};
    use super::*;

    /// The area of all living cells, as if in the plane.
    fn area(cells: &Cells) -> f64 {
        let of = |c: u32| {
            let p = cells.corners(c);
            let edge = |k: usize| p[k].cross(p[(k + 1) % p.len()]).z;
            (0..p.len()).map(edge).sum::<f64>() / 2.0
        };
        cells.living().map(of).sum()
    }

    fn applied(mut cells: Cells, change: &Change) -> Cells {
        for new in &change.added {
            cells.add_node(super::super::cells::Place {
                point: new.point,
                ..cells.place(new.near)
            });
        }
        cells.exchange(&change.gone, &change.new);
        cells
    }

    #[test]
    fn every_operation_covers_what_was_there() {
        let cells = grid(4, 4);
        let inner = at(4, 2, 2);
        let cell = 5;
        let mut all: Vec<(Change, i64)> = Vec::new();
        for k in 0..4 {
            all.extend(collapsed(&cells, cell, k).map(|c| (c, -1)));
            all.extend(turned(&cells, cell, k).into_iter().map(|c| (c, 0)));
        }
        let run = &runs(&cells, inner, 2)[0];
        all.extend(opened(&cells, inner, run).map(|c| (c, 1)));
        assert!(all.len() > 8, "{}", all.len());
        for (change, more) in all {
            let new = applied(cells.clone(), &change);
            assert!((area(&new) - 16.0).abs() < 1e-12, "{change:?}");
            assert_eq!(new.living().count() as i64, 16 + more);
        }
    }

    #[test]
    fn a_held_node_never_vanishes() {
        let cells = grid(3, 3);
        // The corner cell has one free node, which may be made one with the corner, but not the other way round.
        let vanish = (0..4).filter(|&k| collapsed(&cells, 0, k).is_some());
        let gone: Vec<u32> = vanish.map(|k| cells.ring(0)[k]).collect();
        assert_eq!(gone, [at(3, 1, 1)]);
    }

    #[test]
    fn a_triangle_and_a_quad_have_four_other_ways() {
        let n = |i, j| at(2, i, j);
        let rings = vec![
            smallvec![n(0, 0), n(1, 0), n(0, 1)],
            smallvec![n(1, 0), n(2, 0), n(1, 1), n(0, 1)],
        ];
        let cells = with_rings(2, 1, rings);
        let before = area(&cells);
        let ways = recut(&cells, 0, 1);
        assert_eq!(ways.len(), 4);
        for change in &ways {
            assert!((area(&applied(cells.clone(), change)) - before).abs() < 1e-12);
        }
        assert!(recut(&cells, 0, 0).is_empty());
    }
}
