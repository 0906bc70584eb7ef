//! One change of a few cells: tried, settled, and kept only where it pays.

use super::cells::{Cells, Few, Ground, Place, Ring, Undo};
use super::smooth::{search, settle};
use smallvec::SmallVec;

/// Sweeps over the nodes round a change before it is judged.
const SETTLED: usize = 4;

/// Cells to take away and to put in their place.
#[derive(Debug, Default)]
pub(super) struct Change {
    pub gone: Few,
    pub new: SmallVec<[Ring; 6]>,
    /// Nodes that are moved by it, and where to.
    pub moved: SmallVec<[(u32, Place); 2]>,
    /// How many nodes were added for it, the last ones.
    pub added: usize,
}

impl Change {
    /// All nodes that it concerns, each once.
    pub(super) fn nodes(&self, cells: &Cells) -> SmallVec<[u32; 16]> {
        let old = self
            .gone
            .iter()
            .flat_map(|&c| cells.ring(c).iter().copied());
        let new = self.new.iter().flatten().copied();
        let mut all: SmallVec<[u32; 16]> = old.chain(new).collect();
        all.sort_unstable();
        all.dedup();
        all
    }
}

/// What a change has to do for it to be kept.
#[derive(Clone, Copy, Debug)]
pub(super) enum Want {
    /// Nodes come nearer to the valence that they should have, and no cell becomes worse than this, unless one was.
    Regular(f64),
    /// The worst cell gains as much, and no valence gets worse.
    Better(f64),
    /// No cell is worse than this, unless one was, whatever becomes of valences.
    Sound(f64),
}

/// Makes a change and keeps it if it does what is wanted.
pub(super) fn attempt(cells: &mut Cells, change: Change, want: Want, ground: &dyn Ground) -> bool {
    let nodes = change.nodes(cells);
    let edges =
        || (change.new.iter()).flat_map(|r| (0..r.len()).map(|k| (r[k], r[(k + 1) % r.len()])));
    if edges().any(|(a, b)| !cells.may_join(a, b) && !cells.joined(a, b)) {
        (0..change.added).for_each(|_| cells.drop_node());
        return false;
    }
    let cost = |cells: &Cells| nodes.iter().map(|&n| cells.irregularity(n)).sum::<i64>();
    let gaps: SmallVec<[i64; 16]> = nodes.iter().map(|&n| gap(cells, n)).collect();
    let (cost_before, worst_before) = (cost(cells), worst_round(cells, &nodes));
    let mut undo = cells.exchange(&change.gone, &change.new);
    let sound = nodes
        .iter()
        .zip(&gaps)
        .all(|(&n, &old)| is_sound(cells, n, old));
    let fits = match want {
        Want::Regular(_) => cost(cells) < cost_before,
        Want::Better(_) => cost(cells) <= cost_before,
        Want::Sound(_) => true,
    };
    if !(sound && fits) {
        cells.take_back(undo, change.added);
        return false;
    }
    for &(n, place) in &change.moved {
        cells.remember(&mut undo, n);
        cells.put(n, place);
    }
    settle_round(cells, &nodes, &mut undo, ground);
    let worst = worst_round(cells, &nodes);
    let kept = match want {
        Want::Regular(least) | Want::Sound(least) => worst >= least.min(worst_before),
        Want::Better(gain) => worst > worst_before + gain,
    };
    if kept {
        nodes.iter().for_each(|&n| cells.refresh(n));
    } else {
        cells.take_back(undo, change.added);
    }
    kept
}

/// All living cells at these nodes, each once.
fn around(cells: &Cells, nodes: &[u32]) -> SmallVec<[u32; 32]> {
    let mut all: SmallVec<[u32; 32]> = nodes
        .iter()
        .flat_map(|&n| cells.star(n).iter().copied())
        .collect();
    all.sort_unstable();
    all.dedup();
    all
}

/// The least quality of the cells at these nodes.
fn worst_round(cells: &Cells, nodes: &[u32]) -> f64 {
    cells.worst(&around(cells, nodes))
}

/// Settles the free ones of these nodes and of their neighbours.
fn settle_round(cells: &mut Cells, nodes: &[u32], undo: &mut Undo, ground: &dyn Ground) {
    let mut free: SmallVec<[u32; 32]> = nodes
        .iter()
        .flat_map(|&n| std::iter::once(n).chain(cells.neighbours(n)))
        .filter(|&n| !cells.held[n as usize] && !cells.star(n).is_empty())
        .collect();
    free.sort_unstable();
    free.dedup();
    for &n in &free {
        cells.remember(undo, n);
    }
    for _ in 0..SETTLED {
        for &n in &free {
            settle(cells, n, false, ground);
        }
    }
    for &n in &free {
        search(cells, n, ground);
    }
}

/// Neighbours less cells at a node: none inside a sheet, one for each fan on a boundary.
fn gap(cells: &Cells, node: u32) -> i64 {
    cells.neighbours(node).len() as i64 - cells.star(node).len() as i64
}

/// Whether the cells at a node still make the same sheet.
fn is_sound(cells: &Cells, node: u32, gap_before: i64) -> bool {
    let star = cells.star(node);
    let held = cells.held[node as usize];
    if star.is_empty() {
        return !held;
    }
    if !held && star.len() < 3 {
        return false;
    }
    if gap(cells, node) != if held { gap_before } else { 0 } {
        return false;
    }
    let mut ways: SmallVec<[[u32; 2]; 16]> = SmallVec::new();
    for &c in star {
        let ring = cells.ring(c);
        for (k, &a) in ring.iter().enumerate() {
            let b = ring[(k + 1) % ring.len()];
            if ring[..k].contains(&a) || a == b {
                return false;
            }
            if a == node || b == node {
                ways.push([a, b]);
            }
        }
    }
    ways.sort_unstable();
    ways.windows(2).all(|w| w[0] != w[1])
}
