//! One change of a few cells: tried, settled, and kept only where it pays.

use super::cells::{Cells, Few, Ground, Ring, Undo};
use super::smooth::{search, settle};
use glam::DVec3;
use smallvec::SmallVec;

/// Sweeps over the nodes round a change before it is judged; after each, the shortfall that there may still be above the wanted one. Of changes to crowded castings those
/// beyond came to something in one case of a hundred, and these are most.
const HOPES: [f64; 4] = [0.8, 0.4, 0.4, 0.2];
/// By as much valences may get worse for the sake of quality: as beyond hopes.
const ASTRAY: i64 = 4;

/// Cells to take away and to put in their place.
#[derive(Debug, Default)]
pub(super) struct Change {
    pub gone: Few,
    pub new: SmallVec<[Ring; 6]>,
    /// Nodes that are moved by it, and where to.
    pub moved: SmallVec<[(u32, DVec3); 2]>,
    /// Nodes that it needs; they follow those that there are.
    pub added: SmallVec<[NewNode; 2]>,
}

/// A node to be added.
#[derive(Clone, Copy, Debug)]
pub(super) struct NewNode {
    pub point: DVec3,
    /// A node not far from it.
    pub near: u32,
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

    /// By how much nodes come nearer to the cells that they should have.
    fn gain(&self, cells: &Cells, nodes: &[u32]) -> i64 {
        let count = |rings: &mut dyn Iterator<Item = &Ring>, n: u32| {
            rings.flatten().filter(|&&m| m == n).count() as i64
        };
        (nodes.iter())
            .map(|&n| {
                let gone = count(&mut self.gone.iter().map(|&c| cells.ring(c)), n);
                let more = count(&mut self.new.iter(), n) - gone;
                match cells.stars.get(n as usize) {
                    Some(_) => cells.irregularity(n) - cells.irregularity_with(n, more),
                    None => -Cells::irregularity_inside(more),
                }
            })
            .sum()
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
    /// Cells fall less short of good ones, all together, by as much.
    Nearer(f64),
}

/// Makes a change and keeps it if it does what is wanted.
pub(super) fn attempt(cells: &mut Cells, change: Change, want: Want, ground: &dyn Ground) -> bool {
    let nodes = change.nodes(cells);
    let old = &nodes[..nodes.partition_point(|&n| (n as usize) < cells.points.len())];
    let mut edges =
        (change.new.iter()).flat_map(|r| (0..r.len()).map(|k| (r[k], r[(k + 1) % r.len()])));
    if edges.any(|(a, b)| !cells.may_join(a, b) && !cells.joined(a, b)) {
        return false;
    }
    let fits = match want {
        Want::Regular(_) => change.gain(cells, &nodes) > 0,
        Want::Better(_) => change.gain(cells, &nodes) >= 0,
        Want::Sound(_) => true,
        Want::Nearer(_) => change.gain(cells, &nodes) >= -ASTRAY,
    };
    if !fits {
        return false;
    }
    let added = change.added.len();
    let gaps: SmallVec<[i64; 16]> = old.iter().map(|&n| gap(cells, n)).collect();
    let worst_before = worst_round(cells, old);
    let short_before = matches!(want, Want::Nearer(_)).then(|| shortfall_round(cells, old));
    for new in &change.added {
        cells.add_node(ground.foot(new.point, cells.place(new.near).hint));
    }
    let mut undo = cells.exchange(&change.gone, &change.new);
    let gaps = gaps.into_iter().chain(std::iter::repeat(0));
    let sound = (nodes.iter().zip(gaps)).all(|(&n, gap)| is_sound(cells, n, gap));
    if !sound {
        cells.take_back(undo, added);
        return false;
    }
    for &(n, point) in &change.moved {
        cells.remember(&mut undo, n);
        cells.put(n, ground.foot(point, cells.place(n).hint));
    }
    let hopeful = settle_round(cells, &nodes, &mut undo, ground, short_before);
    let worst = worst_round(cells, &nodes);
    let kept = hopeful
        && match want {
            Want::Regular(least) | Want::Sound(least) => worst >= least.min(worst_before),
            Want::Better(gain) => worst > worst_before + gain,
            Want::Nearer(gain) => {
                short_before.is_some_and(|before| shortfall_round(cells, &nodes) < before - gain)
            }
        };
    if kept {
        nodes.iter().for_each(|&n| cells.refresh(n));
    } else {
        cells.take_back(undo, added);
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

/// By how much the cells at these nodes fall short of good ones, all together.
fn shortfall_round(cells: &Cells, nodes: &[u32]) -> f64 {
    around(cells, nodes)
        .iter()
        .map(|&c| cells.shortfall(c))
        .sum()
}

/// Settles the free ones of these nodes and of their neighbours; whether it went to the end. With a shortfall to get below it stops where there is no hope of that.
fn settle_round(
    cells: &mut Cells,
    nodes: &[u32],
    undo: &mut Undo,
    ground: &dyn Ground,
    below: Option<f64>,
) -> bool {
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
    for hope in HOPES {
        for &n in &free {
            settle(cells, n, false, ground);
        }
        if below.is_some_and(|below| shortfall_round(cells, nodes) > below + hope) {
            return false;
        }
    }
    for &n in &free {
        search(cells, n, ground);
    }
    true
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
