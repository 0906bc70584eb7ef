//! Transport: triangles that no neighbour is left for are carried through quads to one another and become a quad.
//!
//! A triangle and a quad beside it make a pentagon, which can be cut anew so that the triangle lies at any other side of the quad, in two ways. Of all chains of such cuts
//! from one triangle to another the one is taken whose quads are best (shortest path, Dijkstra 1959), and kept where all its cells are sound after settling.

use super::cells::{Cells, Ground, Ring};
use super::change::{Change, Want, attempt};
use std::cmp::Reverse;
use std::collections::{BTreeSet, BinaryHeap};

/// No cell of a chain may be worse: below, two triangles are the better choice.
const LEAST: f64 = 0.3;
/// Cuts that a search may look at: beyond, a chain bends too many quads.
const SEEN: usize = 20_000;
/// What a cell costs that is flat or turned over before it has settled, where the best quad costs nothing.
const FLAT: f64 = 10.0;
/// A cell of less quality counts as flat.
const FLAT_BELOW: f64 = 0.1;
/// What each cut costs beside the shape of its quad: short chains bend less.
const STEP: f64 = 0.05;

/// A triangle on its way.
struct Step {
    /// Its nodes, and which of its sides it goes on over.
    triangle: Ring,
    side: usize,
    /// The cell that was cut for it.
    gone: u32,
    /// The step before, and the quad left behind.
    before: Option<(usize, Ring)>,
}

/// Pairs up triangles as far as chains are sound.
pub(super) fn transport(cells: &mut Cells, ground: &dyn Ground) {
    let mut left: Vec<u32> = cells.living().filter(|&c| !cells.is_quad(c)).collect();
    while let Some(triangle) = left.pop() {
        if cells.lives[triangle as usize]
            && !cells.is_quad(triangle)
            && let Some(change) = chain(cells, triangle)
        {
            attempt(cells, change, Want::Sound(LEAST), ground);
        }
    }
}

/// The best chain from a triangle to any other.
fn chain(cells: &Cells, from: u32) -> Option<Change> {
    let mut steps: Vec<Step> = Vec::new();
    // Costs are not negative, so that their bits are in their order.
    let mut heap: BinaryHeap<Reverse<(u64, usize)>> = BinaryHeap::new();
    for side in 0..3 {
        let triangle = cells.ring(from).clone();
        heap.push(Reverse((0, steps.len())));
        steps.push(Step {
            triangle,
            side,
            gone: from,
            before: None,
        });
    }
    let cost = |ring: &Ring| {
        let worth = cells.worth(ring);
        let flat = if worth < FLAT_BELOW { FLAT } else { 0.0 };
        STEP + flat + (1.0 - worth.clamp(0.0, 1.0)).powi(2)
    };
    // By where it goes and with which nodes.
    let mut settled: BTreeSet<(u32, [u32; 3])> = BTreeSet::new();
    while let Some(Reverse((far, at))) = heap.pop() {
        if steps.len() > SEEN {
            return None;
        }
        let (triangle, side) = (&steps[at].triangle, steps[at].side);
        let [a, b, c] = [0, 1, 2].map(|i| triangle[(side + i) % 3]);
        let Some((next, k)) = beyond(cells, a, b) else {
            continue;
        };
        if !settled.insert((next, [a, b, c])) || passed(&steps, at, next) {
            continue;
        }
        let ring = cells.ring(next);
        if ring.len() == 3 {
            let far = ring[(k + 2) % 3];
            let quad: Ring = [c, a, far, b].into_iter().collect();
            if far == c {
                continue;
            }
            return Some(change(&steps, at, next, quad));
        }
        let pentagon = [c, a, ring[(k + 2) % 4], ring[(k + 3) % 4], b];
        for i in 1..4 {
            let n = |d: usize| pentagon[(i + d) % 5];
            // What goes on over the side from 0 to 1 keeps the node before it or the one behind it.
            let cuts = [
                ([n(4), n(0), n(1)], [n(1), n(2), n(3), n(4)], [n(4), n(1)]),
                ([n(2), n(0), n(1)], [n(2), n(3), n(4), n(0)], [n(0), n(2)]),
            ];
            for (carried, quad, [p, q]) in cuts {
                if p == q || cells.joined(p, q) || beyond(cells, n(0), n(1)).is_none() {
                    continue;
                }
                let quad: Ring = quad.into_iter().collect();
                let cost = f64::from_bits(far) + cost(&quad);
                heap.push(Reverse((cost.to_bits(), steps.len())));
                steps.push(Step {
                    triangle: carried.into_iter().collect(),
                    side: 1,
                    gone: next,
                    before: Some((at, quad)),
                });
            }
        }
    }
    None
}

/// The cell on the other side of an edge that a cell has from `a` to `b`, and its side there.
fn beyond(cells: &Cells, a: u32, b: u32) -> Option<(u32, usize)> {
    if cells.is_kept(a, b) {
        return None;
    }
    (cells.star(a).iter()).find_map(|&c| Some((c, cells.side(c, b, a)?)))
}

/// Whether a cell was cut already on the way to a step.
fn passed(steps: &[Step], mut at: usize, cell: u32) -> bool {
    loop {
        if steps[at].gone == cell {
            return true;
        }
        match &steps[at].before {
            Some((before, _)) => at = *before,
            None => return false,
        }
    }
}

/// All cuts of a chain that ends in a triangle.
fn change(steps: &[Step], mut at: usize, last: u32, quad: Ring) -> Change {
    let mut change = Change::default();
    change.gone.push(last);
    change.new.push(quad);
    loop {
        change.gone.push(steps[at].gone);
        match &steps[at].before {
            Some((before, quad)) => {
                change.new.push(quad.clone());
                at = *before;
            }
            None => return change,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::test_grid::{Plane, at, grid, triangles, worst};
    use super::*;

    /// Cuts the square at (i, j) of a grid eight wide in two triangles, and gives one of them to a neighbour's place: the triangles of two cut squares with a chain of quads between.
    fn cut(cells: &mut Cells, i: u32, j: u32) {
        let [a, b, c, d] =
            [[i, j], [i + 1, j], [i + 1, j + 1], [i, j + 1]].map(|[i, j]| at(8, i, j));
        let cell = cells
            .living()
            .find(|&c| cells.side(c, a, b).is_some())
            .unwrap();
        cells.exchange(
            &[cell],
            &[
                [a, b, c].into_iter().collect(),
                [a, c, d].into_iter().collect(),
            ],
        );
    }

    #[test]
    fn two_halves_of_a_square_become_it_again() {
        let mut cells = grid(8, 6);
        cut(&mut cells, 4, 3);
        assert_eq!(triangles(&cells), 2);
        transport(&mut cells, &Plane);
        assert_eq!((triangles(&cells), cells.living().count()), (0, 48));
        assert!(worst(&cells) > 1.0 - 1e-12);
    }

    #[test]
    fn triangles_far_apart_are_carried_to_one_another() {
        let mut cells = grid(8, 6);
        // A pentagon cut at either end of a row: a quad and a triangle each.
        let n = |i, j| at(8, i, j);
        let find = |cells: &Cells, i, j| {
            let edge = (n(i, j), n(i + 1, j));
            cells
                .living()
                .find(|&c| cells.side(c, edge.0, edge.1).is_some())
                .unwrap()
        };
        cut(&mut cells, 2, 3);
        cut(&mut cells, 5, 3);
        // The right half of the left square becomes a quad with its neighbour's left half.
        let [left, right] = [(2, 3), (5, 3)].map(|(i, j)| find(&cells, i, j));
        assert!(!cells.is_quad(left) && !cells.is_quad(right));
        let middle = [3, 4].map(|i| find(&cells, i, 3));
        cells.exchange(
            &[left, middle[0], middle[1]],
            &[
                [n(2, 3), n(3, 3), n(4, 4), n(3, 4)].into_iter().collect(),
                [n(3, 3), n(4, 3), n(5, 4), n(4, 4)].into_iter().collect(),
                [n(4, 3), n(5, 3), n(5, 4)].into_iter().collect(),
            ],
        );
        assert_eq!(triangles(&cells), 4);
        transport(&mut cells, &Plane);
        assert_eq!(triangles(&cells), 0);
        assert!(worst(&cells) > 0.6, "{}", worst(&cells));
    }

    #[test]
    fn a_single_triangle_stays() {
        let mut cells = grid(8, 6);
        let corner = cells
            .living()
            .find(|&c| cells.star(0).contains(&c))
            .unwrap();
        cells.exchange(
            &[corner],
            &[[at(8, 1, 0), at(8, 1, 1), at(8, 0, 1)]
                .into_iter()
                .collect()],
        );
        transport(&mut cells, &Plane);
        assert_eq!(triangles(&cells), 1);
    }
}
