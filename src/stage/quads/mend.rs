//! Mending: what smoothing leaves poor is changed until it is good, or nothing helps.
//!
//! Here quality counts and valence does not: every one of the [`super::operations`] is tried at every poor cell, and kept where the cells round it fall less short of good
//! ones, all together.

use super::cells::{Cells, Ground};
use super::change::{Change, Want, attempt};
use super::operations::{collapsed, opened, recut, runs, turned};

/// Sweeps over what is still poor; later ones only look where something has changed.
const SWEEPS: usize = 4;
/// Cells that go to the new node of an opening.
const TAKEN: [usize; 3] = [1, 2, 3];
/// By as much a change has to bring cells nearer to good ones: less is rounding, or no better after smoothing.
const GAIN: f64 = 0.02;

/// Changes poor cells for better ones; whether there were any.
pub(super) fn mend(cells: &mut Cells, ground: &dyn Ground) -> bool {
    let mut mended = false;
    let mut fresh = vec![true; cells.points.len()];
    for _ in 0..SWEEPS {
        cells.take_fresh();
        let mut changed = false;
        for cell in 0..cells.rings.len() as u32 {
            let is_fresh = |n: &u32| fresh.get(*n as usize).copied().unwrap_or(true);
            let poor = cells.lives[cell as usize]
                && cells.ring(cell).iter().any(is_fresh)
                && cells.shortfall(cell) > 0.0;
            changed |= poor && mend_cell(cells, cell, ground);
        }
        if !changed {
            break;
        }
        mended = true;
        fresh = cells.take_fresh();
    }
    mended
}

/// Takes the first change that helps.
fn mend_cell(cells: &mut Cells, cell: u32, ground: &dyn Ground) -> bool {
    let sides = cells.ring(cell).len();
    let changed = (0..sides).any(|k| {
        let mut ways: Vec<Change> = Vec::new();
        if sides == 4 {
            ways.extend(turned(cells, cell, k));
            ways.extend(beside(cells, cell, k));
        } else {
            ways.extend(recut(cells, cell, k));
        }
        first(cells, ways, ground)
    });
    changed
        || sides == 4 && (0..4).any(|k| first(cells, collapsed(cells, cell, k), ground))
        || (0..sides).any(|k| {
            let node = cells.ring(cell)[k];
            TAKEN.into_iter().any(|taken| {
                let ways: Vec<Change> = (runs(cells, node, taken).into_iter())
                    .filter_map(|run| opened(cells, node, &run))
                    .collect();
                first(cells, ways, ground)
            })
        })
}

/// Makes the first of these changes that helps.
fn first(cells: &mut Cells, ways: impl IntoIterator<Item = Change>, ground: &dyn Ground) -> bool {
    (ways.into_iter()).any(|change| attempt(cells, change, Want::Nearer(GAIN), ground))
}

/// A quad and the triangle across its `k`-th edge, cut anew.
fn beside(cells: &Cells, cell: u32, k: usize) -> Vec<Change> {
    let ring = cells.ring(cell);
    let (a, b) = (ring[k], ring[(k + 1) % ring.len()]);
    (cells.across(cell, k))
        .filter(|&o| !cells.is_quad(o))
        .and_then(|o| cells.side(o, b, a).map(|j| recut(cells, o, j).into_vec()))
        .unwrap_or_default()
}

#[cfg(test)]
mod tests {
    use super::super::cells::{GOOD, Ring};
    use super::super::test_grid::{Plane, at, grid, triangles, with_rings, worst};
    use super::*;
    use smallvec::smallvec;

    #[test]
    fn a_grid_of_squares_stays_as_it_is() {
        let mut cells = grid(5, 4);
        assert!(!mend(&mut cells, &Plane));
        assert_eq!(cells.living().count(), 20);
    }

    #[test]
    fn an_edge_the_wrong_way_is_turned() {
        let mut cells = grid(6, 5);
        // The two quads in the middle with their common edge turned: both are poor, however their nodes are moved.
        let [a, b] = [2 * 6 + 2, 2 * 6 + 3];
        let k = (0..4).find(|&k| cells.across(a, k) == Some(b)).unwrap();
        let change = &turned(&cells, a, k)[0];
        cells.exchange(&change.gone, &change.new);
        let before = worst(&cells);
        assert!(before < GOOD, "{before}");
        assert!(mend(&mut cells, &Plane));
        assert!(worst(&cells) >= GOOD, "{}", worst(&cells));
        assert_eq!((cells.living().count(), triangles(&cells)), (30, 0));
    }

    #[test]
    fn a_caved_quad_between_two_triangles_takes_them() {
        // A strip of two squares as triangle, quad, triangle: the quad leans.
        let n = |i, j| at(3, i, j);
        let mut rings: Vec<Ring> = vec![
            smallvec![n(0, 0), n(1, 0), n(0, 1)],
            smallvec![n(1, 0), n(2, 0), n(1, 1), n(0, 1)],
            smallvec![n(2, 0), n(2, 1), n(1, 1)],
        ];
        rings.push(smallvec![n(2, 0), n(3, 0), n(3, 1), n(2, 1)]);
        for i in 0..3 {
            rings.push(smallvec![n(i, 1), n(i + 1, 1), n(i + 1, 2), n(i, 2)]);
        }
        let mut cells = with_rings(3, 2, rings);
        let short = |cells: &Cells| cells.living().map(|c| cells.shortfall(c)).sum::<f64>();
        let before = short(&cells);
        mend(&mut cells, &Plane);
        assert!(short(&cells) <= before - GAIN);
    }

    #[test]
    fn what_nothing_helps_is_left_as_it_is() {
        // A single slanted quad whose nodes are all held.
        let n = |i, j| at(2, i, j);
        let mut cells = with_rings(2, 1, vec![smallvec![n(0, 0), n(1, 0), n(2, 1), n(1, 1)]]);
        let before = format!("{:?}", cells.rings);
        assert!(!mend(&mut cells, &Plane));
        assert_eq!(format!("{:?}", cells.rings), before);
    }
}
