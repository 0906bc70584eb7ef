//! Topological clean-up: changes of a few quads that bring nodes nearer to four quads each.
//!
//! Quads are collapsed along a diagonal, edges between two quads are turned, and nodes with many quads are opened into two with a quad between them
//! (Kinney 1997, "CleanUp: improving quadrilateral finite element meshes"; Docampo-Sánchez & Haimes 2019). Only changes that pay are kept ([`super::change`]),
//! so that the sweeps end.

use super::cells::{Cells, Ground, Ring};
use super::change::{Change, Want, attempt};
use smallvec::{SmallVec, smallvec};

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

/// By how much nodes come nearer to the cells that they should have, where their numbers change by so many.
fn gain(cells: &Cells, changes: &[(u32, i64)]) -> i64 {
    (changes.iter())
        .map(|&(n, more)| cells.irregularity(n) - cells.irregularity_with(n, more))
        .sum()
}

/// Makes one node of two opposite ones of a quad.
fn collapse(cells: &mut Cells, cell: u32, ground: &dyn Ground) -> bool {
    if !cells.lives[cell as usize] || !cells.is_quad(cell) {
        return false;
    }
    for k in 0..4 {
        let ring = cells.ring(cell);
        let (a, c) = (ring[k], ring[(k + 2) % 4]);
        let (b, d) = (ring[(k + 1) % 4], ring[(k + 3) % 4]);
        // One node has the cells of both, less the one between them.
        let more = cells.star(a).len() as i64 - 2;
        let gain = gain(cells, &[(b, -1), (d, -1), (c, more)]) + cells.irregularity(a);
        if cells.held[a as usize] || gain <= 0 {
            continue;
        }
        if cells
            .star(a)
            .iter()
            .any(|&o| o != cell && cells.ring(o).contains(&c))
        {
            continue;
        }
        let mut change = Change {
            gone: cells.star(a).clone(),
            ..Change::default()
        };
        if change.gone.iter().any(|&o| !cells.is_quad(o)) {
            continue;
        }
        for &o in change.gone.iter().filter(|&&o| o != cell) {
            let swap = |&n: &u32| if n == a { c } else { n };
            change.new.push(cells.ring(o).iter().map(swap).collect());
        }
        if !cells.held[c as usize] {
            let middle = (cells.points[a as usize] + cells.points[c as usize]) / 2.0;
            change
                .moved
                .push((c, ground.foot(middle, cells.place(c).hint)));
        }
        if attempt(cells, change, Want::Regular(LEAST), ground) {
            return true;
        }
    }
    false
}

/// Turns an edge between two quads to another diagonal of the hexagon that they make.
fn turn(cells: &mut Cells, cell: u32, want: Want, ground: &dyn Ground) -> bool {
    for k in 0..4 {
        if !cells.lives[cell as usize] || !cells.is_quad(cell) {
            return false;
        }
        let Some(other) = cells.across(cell, k).filter(|&o| cells.is_quad(o)) else {
            continue;
        };
        let ring = cells.ring(cell).clone();
        let [u, v, p, q] = [0, 1, 2, 3].map(|i| ring[(k + i) % 4]);
        let Some(j) = cells.side(other, v, u) else {
            continue;
        };
        let around = cells.ring(other);
        let [r, s] = [2, 3].map(|i| around[(j + i) % 4]);
        let ways: [([u32; 2], [Ring; 2]); 2] = [
            ([p, r], [smallvec![p, q, u, r], smallvec![r, s, v, p]]),
            ([q, s], [smallvec![q, u, r, s], smallvec![s, v, p, q]]),
        ];
        let open: SmallVec<[(i64, [Ring; 2]); 2]> = (ways.into_iter())
            .filter(|([a, b], _)| a != b && !cells.joined(*a, *b))
            .map(|([a, b], new)| (gain(cells, &[(u, -1), (v, -1), (a, 1), (b, 1)]), new))
            .collect();
        // Only a change for the better makes up for one that no valence gains by.
        let least_gain = match want {
            Want::Regular(_) => 1,
            _ if cells.worst(&[cell, other]) < POOR => 0,
            _ => continue,
        };
        for (gain, new) in open {
            let change = Change {
                gone: smallvec![cell, other],
                new: new.into_iter().collect(),
                ..Change::default()
            };
            if gain >= least_gain && attempt(cells, change, want, ground) {
                return true;
            }
        }
    }
    false
}

/// Parts a node with many quads in two.
fn open(cells: &mut Cells, node: u32, ground: &dyn Ground) -> bool {
    let held = cells.held[node as usize];
    for fan in cells.fans(node) {
        let n = fan.len();
        if fan.iter().any(|&c| !cells.is_quad(c)) {
            continue;
        }
        // On a boundary the first and the last edge stay at the node.
        let starts = if held { 1..n } else { 0..n };
        for taken in OPENED {
            if n < taken + 2 {
                continue;
            }
            for i in starts.clone() {
                if held && i + taken >= n {
                    break;
                }
                let range: Vec<u32> = (0..taken).map(|d| fan[(i + d) % n]).collect();
                if opened(cells, node, &range, ground) {
                    return true;
                }
            }
        }
    }
    false
}

/// Gives these neighbouring cells of a node, in their order round it, to a new node, with a quad between the two.
fn opened(cells: &mut Cells, node: u32, range: &[u32], ground: &dyn Ground) -> bool {
    let beside = |cell: Option<&u32>, ahead: usize| {
        let ring = cells.ring(*cell?);
        let k = ring.iter().position(|&n| n == node)?;
        Some(ring[(k + ahead) % 4])
    };
    let (Some(right), Some(left)) = (beside(range.first(), 1), beside(range.last(), 3)) else {
        return false;
    };
    let taken = range.len() as i64;
    let new_node = (taken + 1 - 4).pow(2);
    if gain(cells, &[(right, 1), (left, 1), (node, 1 - taken)]) <= new_node {
        return false;
    }
    let far = |c: &u32| beside(Some(c), 2).map(|n| cells.points[n as usize]);
    let home = cells.points[node as usize];
    let mean = range.iter().filter_map(far).sum::<glam::DVec3>() / range.len() as f64;
    // Half an edge towards the cells that it gets.
    let new = cells.add_node(ground.foot(home.lerp(mean, 0.35), cells.place(node).hint));
    let mut change = Change {
        gone: range.iter().copied().collect(),
        added: 1,
        ..Change::default()
    };
    for &c in range {
        let swap = |&n: &u32| if n == node { new } else { n };
        change.new.push(cells.ring(c).iter().map(swap).collect());
    }
    change.new.push(smallvec![node, right, new, left]);
    attempt(cells, change, Want::Regular(LEAST), ground)
}

#[cfg(test)]
mod tests {
    use super::super::test_grid::{Plane, grid};
    use super::*;
    use glam::DVec3;

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
