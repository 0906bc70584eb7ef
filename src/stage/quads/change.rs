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
        let old = self.gone.iter().flat_map(|&c| cells.ring(c).iter().copied());
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
    let cost = |cells: &Cells| nodes.iter().map(|&n| irregularity(cells, n)).sum::<i64>();
    let gaps: SmallVec<[i64; 16]> = nodes.iter().map(|&n| gap(cells, n)).collect();
    let around = around(cells, &nodes);
    let (cost_before, worst_before) = (cost(cells), cells.worst(&around));
    let mut undo = cells.exchange(&change.gone, &change.new);
    let sound = nodes.iter().zip(&gaps).all(|(&n, &old)| is_sound(cells, n, old));
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
    if !kept {
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

/// How far a node is from having as many cells as there should be at it, squared: four inside a sheet, one a right angle between kept edges.
pub(super) fn irregularity(cells: &Cells, node: u32) -> i64 {
    let star = cells.star(node);
    if star.is_empty() {
        return 0;
    }
    if !cells.held[node as usize] {
        return (star.len() as i64 - 4).pow(2);
    }
    (fans(cells, node).iter())
        .map(|fan| {
            let angle: f64 = fan.iter().map(|&c| angle(cells, c, node)).sum();
            let ideal = (angle / std::f64::consts::FRAC_PI_2).round().max(1.0) as i64;
            (fan.len() as i64 - ideal).pow(2)
        })
        .sum()
}

/// The cells at a node that hang together round it, each fan in the order of its cells, the first node on the right.
pub(super) fn fans(cells: &Cells, node: u32) -> SmallVec<[Few; 2]> {
    let star = cells.star(node);
    let mut left: Few = star.clone();
    left.sort_unstable();
    let mut all = SmallVec::new();
    // The next cell over the edge that comes in, or goes out.
    let beside = |c: u32, incoming: bool| {
        let ring = cells.ring(c);
        let k = ring.iter().position(|&n| n == node)?;
        let edge = if incoming { (k + ring.len() - 1) % ring.len() } else { k };
        cells.across(c, edge)
    };
    while let Some(&first) = left.first() {
        let mut start = first;
        for _ in 0..star.len() {
            match beside(start, false) {
                Some(c) if c != first => start = c,
                _ => break,
            }
        }
        let mut fan: Few = SmallVec::new();
        let mut at = Some(start);
        while let Some(c) = at.filter(|c| !fan.contains(c)) {
            fan.push(c);
            at = beside(c, true);
        }
        left.retain(|c| !fan.contains(c));
        all.push(fan);
    }
    all
}

/// The angle of a cell at one of its nodes, rad.
fn angle(cells: &Cells, cell: u32, node: u32) -> f64 {
    let ring = cells.ring(cell);
    let Some(k) = ring.iter().position(|&n| n == node) else {
        return 0.0;
    };
    let at = |i: usize| cells.points[ring[i % ring.len()] as usize];
    (at(k + 1) - at(k)).angle_between(at(k + ring.len() - 1) - at(k))
}
