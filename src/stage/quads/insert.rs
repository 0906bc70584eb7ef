//! Insertion: two triangles become quads by a row of new quads between them.
//!
//! Where triangles stand on a boundary they cannot be carried away: the node beside them would be left with a single quad and a straight angle. Instead every side on a
//! way from the one to the other gets a node in its middle: the triangles have four nodes then, and every quad on the way six, which make two quads.
//!
//! A quad with three of its nodes on a smooth boundary is two such triangles: a row round the far side of it relieves the straight angle.

use super::cells::{Cells, Ground, Ring};
use super::change::{Change, NewNode, Want, attempt};
use std::cmp::Reverse;
use std::collections::{BTreeMap, BinaryHeap};

/// No cell may become worse: below, two triangles are the better choice.
const LEAST: f64 = 0.3;
/// What the worst cell has to gain from a row that relieves a node.
const GAIN: f64 = 0.1;
/// Ways straight through a quad cost one, turns more: they leave nodes with three and five quads.
const TURN: u32 = 3;
/// Longest way: every cell on it adds one to the mesh.
const LONGEST: u32 = 40;

/// Pairs up triangles by rows of new quads, as far as these are sound.
pub(super) fn insert(cells: &mut Cells, ground: &dyn Ground) {
    let mut left: Vec<u32> = cells.living().filter(|&c| !cells.is_quad(c)).collect();
    while let Some(triangle) = left.pop() {
        if cells.lives[triangle as usize]
            && !cells.is_quad(triangle)
            && let Some(way) = way(cells, triangle, None)
            && let Some(change) = row(cells, &way)
        {
            attempt(cells, change, Want::Sound(LEAST), ground);
        }
    }
}

/// Gives a second quad to held nodes that have one in a nearly straight angle.
pub(super) fn relieve(cells: &mut Cells, ground: &dyn Ground) {
    for node in 0..cells.points.len() as u32 {
        let &[cell] = cells.star(node).as_slice() else {
            continue;
        };
        if !cells.is_quad(cell) || cells.irregularity(node) == 0 {
            continue;
        }
        let ring = cells.ring(cell).clone();
        let Some(k) = ring.iter().position(|&n| n == node) else {
            continue;
        };
        let at = |d: usize| ring[(k + d) % 4];
        if !cells.may_join(node, at(2)) {
            continue;
        }
        let halves: [Ring; 2] = [
            [node, at(1), at(2)].into_iter().collect(),
            [node, at(2), at(3)].into_iter().collect(),
        ];
        // Halved, the quad is worth more than it was: a straight angle is none then.
        let least = cells.quality(cell) + GAIN;
        let first = cells.rings.len() as u32;
        let undo = cells.exchange(&[cell], &halves);
        let relieved = way(cells, first, Some(first + 1))
            .and_then(|way| row(cells, &way))
            .is_some_and(|change| attempt(cells, change, Want::Sound(least), ground));
        if !relieved {
            cells.take_back(undo, 0);
        }
    }
}

/// The cheapest way from a triangle to another, and not straight to `twin`: cells, and the side that leads out of each but the last.
fn way(cells: &Cells, from: u32, twin: Option<u32>) -> Option<Vec<(u32, usize)>> {
    // How each cell was entered: from which cell, over which of its sides, and over which of its own.
    let mut entered: BTreeMap<u32, (u32, usize, usize)> = BTreeMap::new();
    let mut heap = BinaryHeap::from([Reverse((0, from, from, 0, 0))]);
    while let Some(Reverse((far, cell, before, out, side))) = heap.pop() {
        if far > LONGEST {
            return None;
        }
        if entered.contains_key(&cell) {
            continue;
        }
        entered.insert(cell, (before, out, side));
        if cell != from && !cells.is_quad(cell) {
            let mut way = vec![(cell, side)];
            let mut at = cell;
            while at != from {
                let (before, out, _) = entered[&at];
                way.push((before, out));
                at = before;
            }
            way.reverse();
            return Some(way);
        }
        let ring = cells.ring(cell);
        for out in 0..ring.len() {
            let Some(next) = cells.across(cell, out) else {
                continue;
            };
            if cell == from && Some(next) == twin {
                continue;
            }
            let (a, b) = (ring[out], ring[(out + 1) % ring.len()]);
            let Some(side_there) = cells.side(next, b, a) else {
                continue;
            };
            let straight = cell == from || (out + ring.len() - side) % ring.len() == 2;
            let cost = far + if straight { 1 } else { TURN };
            heap.push(Reverse((cost, next, cell, out, side_there)));
        }
    }
    None
}

/// The cells of a way with a node in the middle of every side that it crosses.
fn row(cells: &Cells, way: &[(u32, usize)]) -> Option<Change> {
    let mut change = Change {
        gone: way.iter().map(|w| w.0).collect(),
        ..Change::default()
    };
    let middles: Vec<(u32, u32)> = (way[..way.len() - 1].iter())
        .map(|&(cell, out)| {
            let ring = cells.ring(cell);
            (ring[out], ring[(out + 1) % ring.len()])
        })
        .collect();
    let first = cells.points.len() as u32;
    for &(a, b) in &middles {
        let point = (cells.points[a as usize] + cells.points[b as usize]) / 2.0;
        change.added.push(NewNode { point, near: a });
    }
    // Whether the node on the side just crossed has an edge of its own: with two cells only it would be no node.
    let mut has_edge = false;
    for (i, &(cell, _)) in way.iter().enumerate() {
        // The ring with its new nodes.
        let ring = cells.ring(cell);
        let (entry, exit) = (first + i as u32 - 1, first + i as u32);
        let mut full: Vec<u32> = Vec::with_capacity(6);
        for (k, &a) in ring.iter().enumerate() {
            let b = ring[(k + 1) % ring.len()];
            full.push(a);
            let crossed = |j: usize| middles.get(j).is_some_and(|&m| m == (a, b) || m == (b, a));
            if i > 0 && crossed(i - 1) {
                full.push(entry);
            } else if crossed(i) {
                full.push(exit);
            }
        }
        let place = |n: u32| full.iter().position(|&m| m == n);
        match (full.len(), place(entry), place(exit)) {
            (4, ..) => change.new.push(full.into_iter().collect()),
            (6, Some(p), Some(q)) => {
                // Straight through, one edge serves both.
                let straight = p.abs_diff(q) == 3;
                let from = if has_edge { q } else { p };
                has_edge |= straight;
                change.new.extend(halves(&full, from));
            }
            _ => break,
        }
    }
    let whole = change.new.len() == 2 * way.len() - 2;
    (whole && (has_edge || without_last(&mut change))).then_some(change)
}

/// Takes the last new node away where nothing but the two cells of its side have it, as on a way that never goes straight: these become one. Whether they can.
fn without_last(change: &mut Change) -> bool {
    let Some(last) = change.new.pop() else {
        return false;
    };
    // The last cell was a triangle: its ends, and the node that stands across from the new one.
    let shared = |ring: &Ring| last.iter().filter(|n| ring.contains(n)).count() == 3;
    let apex = |ring: &Ring| last.iter().copied().find(|n| !ring.contains(n));
    let Some((other, apex)) = (change.new.iter_mut())
        .find(|r| shared(r))
        .and_then(|r| apex(r).map(|a| (r, a)))
    else {
        return false;
    };
    let Some(k) = (0..4).find(|&k| {
        let ends = [other[(k + 1) % 4], other[(k + 3) % 4]];
        last.contains(&other[k]) && ends.iter().all(|n| last.contains(n))
    }) else {
        return false;
    };
    other[k] = apex;
    change.added.pop();
    true
}

/// The two quads of a hexagon on either side of the edge from one of its nodes to the one opposite.
fn halves(hexagon: &[u32], from: usize) -> [Ring; 2] {
    let at = |d: usize| hexagon[(from + d) % 6];
    [
        [at(0), at(1), at(2), at(3)].into_iter().collect(),
        [at(3), at(4), at(5), at(0)].into_iter().collect(),
    ]
}

#[cfg(test)]
mod tests {
    use super::super::test_grid::{Plane, at, triangles, with_rings, worst};
    use super::*;

    /// A row of squares over another, where the lower row has a triangle standing on the rim at either end: its nodes above are fewer.
    fn rows() -> Cells {
        let n = |i, j| at(6, i, j);
        let mut rings: Vec<Ring> = Vec::new();
        for i in 0..6 {
            rings.push(
                [n(i, 1), n(i + 1, 1), n(i + 1, 2), n(i, 2)]
                    .into_iter()
                    .collect(),
            );
        }
        // Below: quads sheared to the right between a triangle on the rim and one beneath the row above.
        rings.push([n(0, 0), n(1, 0), n(1, 1), n(0, 1)].into_iter().collect());
        rings.push([n(1, 0), n(2, 0), n(1, 1)].into_iter().collect());
        for i in 2..5 {
            rings.push(
                [n(i, 0), n(i + 1, 0), n(i, 1), n(i - 1, 1)]
                    .into_iter()
                    .collect(),
            );
        }
        rings.push([n(5, 0), n(5, 1), n(4, 1)].into_iter().collect());
        rings.push([n(5, 0), n(6, 0), n(6, 1), n(5, 1)].into_iter().collect());
        with_rings(6, 2, rings)
    }

    #[test]
    fn a_row_of_quads_between_two_triangles_takes_both() {
        let mut cells = rows();
        let before = cells.living().count();
        assert_eq!(triangles(&cells), 2);
        insert(&mut cells, &Plane);
        assert_eq!(triangles(&cells), 0);
        // One cell more for every quad on the way.
        assert!(cells.living().count() > before);
        assert!(worst(&cells) >= LEAST, "{}", worst(&cells));
        // Every free node has three quads at the least.
        for n in 0..cells.points.len() as u32 {
            assert!(cells.held[n as usize] || cells.star(n).len() >= 3);
        }
    }

    #[test]
    fn where_there_is_no_way_nothing_is_left_behind() {
        let n = |i, j| at(1, i, j);
        let mut cells = with_rings(
            1,
            1,
            vec![[n(0, 0), n(1, 0), n(1, 1)].into_iter().collect()],
        );
        let nodes = cells.points.len();
        insert(&mut cells, &Plane);
        assert_eq!((triangles(&cells), cells.points.len()), (1, nodes));
    }

    #[test]
    fn a_way_that_only_turns_leaves_no_node_with_two_cells() {
        // A grid whose corner quad has three nodes on the rim once its corner is rounded: the way round its inner node is all turns.
        let n = |i, j| at(4, i, j);
        let mut cells = super::super::test_grid::grid(4, 4);
        for (i, j, x, y) in [(0, 0, 0.45, 0.45), (1, 0, 1.0, 0.05), (0, 1, 0.05, 1.0)] {
            let place = cells.place(n(i, j));
            let point = glam::DVec3::new(x, y, 0.0);
            cells.put(n(i, j), super::super::cells::Place { point, ..place });
        }
        let corner = n(0, 0);
        assert_eq!(cells.star(corner).len(), 1);
        // What it was when its ideal number was told by a right angle: now the angle is nearly straight.
        let rings: Vec<Ring> = cells.rings.clone();
        let mut cells = {
            let places = (0..cells.points.len() as u32).map(|n| cells.place(n));
            Cells::new(
                places.collect(),
                cells.held.clone(),
                rings,
                cells.kept.clone(),
            )
        };
        relieve(&mut cells, &Plane);
        assert_eq!(cells.star(corner).len(), 2);
        for node in 0..cells.points.len() as u32 {
            assert!(cells.held[node as usize] || cells.star(node).len() >= 3);
        }
        assert_eq!(triangles(&cells), 0);
        assert!(worst(&cells) > 0.4, "{}", worst(&cells));
    }

    #[test]
    fn a_straight_angle_on_the_rim_gets_a_second_quad() {
        // The lower row is sheared away from its middle, where a quad has three nodes on the rim, to a triangle at either end.
        let n = |i, j| at(6, i, j);
        let mut rings: Vec<Ring> = Vec::new();
        for j in 1..4 {
            for i in 0..6 {
                rings.push(
                    [n(i, j), n(i + 1, j), n(i + 1, j + 1), n(i, j + 1)]
                        .into_iter()
                        .collect(),
                );
            }
        }
        rings.push([n(0, 0), n(1, 1), n(0, 1)].into_iter().collect());
        for i in [0, 1] {
            rings.push(
                [n(i, 0), n(i + 1, 0), n(i + 2, 1), n(i + 1, 1)]
                    .into_iter()
                    .collect(),
            );
        }
        rings.push([n(2, 0), n(3, 0), n(4, 0), n(3, 1)].into_iter().collect());
        for i in [4, 5] {
            rings.push(
                [n(i, 0), n(i + 1, 0), n(i, 1), n(i - 1, 1)]
                    .into_iter()
                    .collect(),
            );
        }
        rings.push([n(6, 0), n(6, 1), n(5, 1)].into_iter().collect());
        let mut cells = with_rings(6, 4, rings);
        let straight = n(3, 0);
        assert_eq!((cells.star(straight).len(), triangles(&cells)), (1, 2));
        relieve(&mut cells, &Plane);
        assert_eq!(cells.star(straight).len(), 2);
        assert!(triangles(&cells) <= 2);
        assert!(worst(&cells) > GAIN, "{}", worst(&cells));
    }
}
