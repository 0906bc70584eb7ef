//! Topological clean-up: changes of a few quads that bring nodes nearer to four quads each.
//!
//! Every one of the [`super::operations`] is tried where a node has too few or too many; only changes that pay are kept ([`super::change`]), so that the sweeps end.

use super::cells::{Cells, Ground};
use super::change::{Change, Want, attempt};
use super::operations::{collapsed, opened, runs, turned};

/// Sweeps over all cells; most gain comes with the first two.
const SWEEPS: usize = 6;
/// No cell becomes worse than this for the sake of valences: what the shell profile asks for, and a little more, since smoothing goes on.
const LEAST: f64 = 0.5;
/// A cell worse than this is worth turning an edge for, even where no valence gains.
const POOR: f64 = 0.5;
/// By as much the worst cell has to gain from that.
const GAIN: f64 = 0.05;
/// Cells that go to the new node of an opening: it then has one more.
const OPENED: [usize; 2] = [3, 2];

/// Sweeps until nothing pays any more.
pub(super) fn clean_up(cells: &mut Cells, ground: &dyn Ground) {
    for _ in 0..SWEEPS {
        // What was tried in vain is not tried again until something near it has changed.
        let fresh = cells.take_fresh();
        let is_fresh = |n: &u32| fresh.get(*n as usize).copied().unwrap_or(true);
        let mut changed = false;
        for node in 0..fresh.len() as u32 {
            if is_fresh(&node) && is_odd(cells, node) {
                changed |= open(cells, node, ground);
            }
        }
        let concerned = |cells: &Cells, cell: u32| {
            cells.lives[cell as usize] && cells.ring(cell).iter().any(is_fresh)
        };
        for cell in 0..cells.rings.len() as u32 {
            if concerned(cells, cell) {
                changed |= collapse(cells, cell, ground)
                    || turn(cells, cell, Want::Regular(LEAST), ground);
            }
        }
        // What only moves irregular nodes about comes last, or it would take them away from where they can be mended.
        for cell in 0..cells.rings.len() as u32 {
            if concerned(cells, cell) {
                changed |= turn(cells, cell, Want::Better(GAIN), ground);
            }
        }
        if !changed {
            return;
        }
    }
}

/// Whether a node has fewer or more cells than it should.
fn is_odd(cells: &Cells, node: u32) -> bool {
    cells.irregularity(node) > 0
}

/// Makes one node of two opposite ones of a quad.
fn collapse(cells: &mut Cells, cell: u32, ground: &dyn Ground) -> bool {
    if !cells.lives[cell as usize] || !cells.is_quad(cell) {
        return false;
    }
    (0..4).any(|k| {
        let quads = |change: &Change| change.gone.iter().all(|&o| cells.is_quad(o));
        let change = collapsed(cells, cell, k).filter(quads);
        change.is_some_and(|c| attempt(cells, c, Want::Regular(LEAST), ground))
    })
}

/// Turns an edge between two quads to another diagonal of the hexagon that they make.
fn turn(cells: &mut Cells, cell: u32, want: Want, ground: &dyn Ground) -> bool {
    if !cells.lives[cell as usize] || !cells.is_quad(cell) {
        return false;
    }
    (0..4).any(|k| {
        (turned(cells, cell, k).into_iter()).any(|change| {
            // Only a change for the better makes up for one that no valence gains by.
            let worth = matches!(want, Want::Regular(_)) || cells.worst(&change.gone) < POOR;
            worth && attempt(cells, change, want, ground)
        })
    })
}

/// Parts a node with many quads in two.
fn open(cells: &mut Cells, node: u32, ground: &dyn Ground) -> bool {
    OPENED.into_iter().any(|taken| {
        (runs(cells, node, taken).into_iter()).any(|run| {
            let change = opened(cells, node, &run);
            change.is_some_and(|c| attempt(cells, c, Want::Regular(LEAST), ground))
        })
    })
}

#[cfg(test)]
mod tests {
    use super::super::cells::Ring;
    use super::super::test_grid::{Plane, grid};
    use super::*;
    use glam::DVec3;
    use smallvec::smallvec;

    fn cost(cells: &Cells) -> i64 {
        (0..cells.points.len() as u32)
            .map(|n| cells.irregularity(n))
            .sum()
    }

    #[test]
    fn a_grid_is_regular_and_stays_as_it_is() {
        let mut cells = grid(6, 5);
        assert_eq!(cost(&cells), 0);
        clean_up(&mut cells, &Plane);
        assert_eq!(cells.living().count(), 30);
    }

    #[test]
    fn a_quad_too_many_is_collapsed() {
        let mut cells = grid(6, 5);
        // The node in the middle opened by hand: two nodes with three quads, two with five.
        let node = 2 * 7 + 3;
        let fan = cells.fans(node)[0].clone();
        let new = cells.add_node(Plane.foot(DVec3::new(3.3, 2.3, 0.0), None));
        let taken = [fan[0], fan[1]];
        let ring = |c: u32| cells.ring(c).clone();
        let beside = |c: u32, ahead: usize| {
            let ring = ring(c);
            let k = ring.iter().position(|&n| n == node).unwrap();
            ring[(k + ahead) % 4]
        };
        let mut rings: Vec<Ring> = (taken.iter())
            .map(|&c| {
                ring(c)
                    .iter()
                    .map(|&n| if n == node { new } else { n })
                    .collect()
            })
            .collect();
        rings.push(smallvec![
            node,
            beside(taken[0], 1),
            new,
            beside(taken[1], 3)
        ]);
        cells.exchange(&taken, &rings);
        assert_eq!((cells.living().count(), cost(&cells)), (31, 4));
        clean_up(&mut cells, &Plane);
        assert_eq!((cells.living().count(), cost(&cells)), (30, 0));
    }

    #[test]
    fn an_edge_turned_by_hand_is_turned_back() {
        let mut cells = grid(6, 5);
        let [a, b] = [2 * 6 + 2, 2 * 6 + 3];
        let k = (0..4).find(|&k| cells.across(a, k) == Some(b)).unwrap();
        let r = cells.ring(a).clone();
        let [u, v, p, q] = [0, 1, 2, 3].map(|i| r[(k + i) % 4]);
        let j = cells.side(b, v, u).unwrap();
        let [x, y] = [2, 3].map(|i| cells.ring(b)[(j + i) % 4]);
        cells.exchange(&[a, b], &[smallvec![p, q, u, x], smallvec![x, y, v, p]]);
        assert_eq!(cost(&cells), 4);
        clean_up(&mut cells, &Plane);
        assert_eq!((cells.living().count(), cost(&cells)), (30, 0));
    }

    #[test]
    fn held_corners_ask_for_as_many_quads_as_they_have_right_angles() {
        let cells = grid(6, 5);
        assert_eq!(cells.star(0).len(), 1);
        assert_eq!(
            (cells.irregularity(0), cells.irregularity_with(0, 1)),
            (0, 1)
        );
        assert_eq!(
            (cells.irregularity(3), cells.irregularity_with(3, -1)),
            (0, 1)
        );
    }
}
