//! Which nodes are corners, which lie on feature curves, which inside a sheet.
//!
//! Feature edges are all that do not have exactly two triangles of one wall. First the topology decides: a node inside a sheet has a link
//! that is one circle; a node on a curve has a link of arcs between its two feature neighbours, and the same walls on both sides;
//! all else is a corner, and so is a node with a place of its own (strata of Dey, Edelsbrunner, Guha, Nekhayev 1999, "Topology preserving edge contraction").
//! Then curves are cut at corners of shape.

use super::surface::{Class, Surface};
use crate::model::complex::{ends, pin};
use crate::model::ids::{IndexVec, NodeId, WallId};
use glam::DVec3;
use smallvec::SmallVec;

/// A node that lies on two lateral faces is a corner at this share of the usual angle: the faces say that an edge of the part is there.
const FACE_SHARE: f64 = 0.4;
/// A turn stands alone when those at its neighbours are below this share of it: a corner between straight pieces, not part of a bend.
const ALONE: f64 = 0.25;
/// A turn that stands alone is a corner at this share of the usual angle.
const ALONE_SHARE: f64 = 0.5;

/// A feature curve as a chain of nodes: from corner to corner, or round without a repeated node where `closed`.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Chain {
    pub nodes: Vec<NodeId>,
    pub closed: bool,
}

/// Sets the classes of all nodes, and returns the feature curves between corners in a fixed order.
///
/// Turns are measured over a distance `reach` to both sides (or one edge, where that is longer), so that noise below it makes no corner.
pub(super) fn classify(
    surface: &mut Surface,
    crease_angle: f64,
    reach: &dyn Fn(NodeId) -> f64,
) -> Vec<Chain> {
    let nodes: Vec<NodeId> = surface.live_nodes().collect();
    for &n in &nodes {
        surface.class[n] = topological(surface, n);
    }
    let chains = chains(surface);
    for chain in &chains {
        for i in sharp(surface, chain, crease_angle, reach) {
            surface.class[chain.nodes[i]] = Class::Corner;
        }
    }
    chains.into_iter().flat_map(|c| cut(surface, c)).collect()
}

fn topological(surface: &Surface, n: NodeId) -> Class {
    if pin(&surface.supports[n]).is_some() {
        return Class::Corner;
    }
    let spokes = surface.spokes(n);
    let rings: SmallVec<[&[_]; 12]> = spokes.chunk_by(|a, b| a.0 == b.0).collect();
    let wall = |ring: &[(NodeId, _)]| -> SmallVec<[WallId; 4]> {
        let mut walls: SmallVec<[WallId; 4]> =
            ring.iter().map(|s| surface.triangle(s.1).wall).collect();
        walls.sort_unstable();
        walls
    };
    let features: SmallVec<[&[_]; 4]> = rings
        .iter()
        .copied()
        .filter(|r| r.len() != 2 || wall(r)[0] != wall(r)[1])
        .collect();
    // Walks through the link from ring to ring until it meets `stop`; gives the last node and the number of triangles passed.
    let walk = |from: NodeId, first, stops: [NodeId; 2]| {
        let (mut node, mut t, mut steps) = (from, first, 0);
        loop {
            node = surface.apex(t, n, node);
            steps += 1;
            if stops.contains(&node) || steps > spokes.len() {
                return (node, steps);
            }
            let ring = rings.iter().find(|r| r[0].0 == node);
            match ring.and_then(|r| r.iter().find(|s| s.1 != t)) {
                Some(next) => t = next.1,
                None => return (node, usize::MAX),
            }
        }
    };
    match features.as_slice() {
        [] => {
            let (start, t) = spokes[0];
            let (_, steps) = walk(start, t, [start; 2]);
            if steps == surface.star(n).len() {
                return Class::Sheet;
            }
        }
        [p, q] if wall(p) == wall(q) => {
            let ends = [p[0].0, q[0].0];
            let mut total = 0usize;
            for spoke in p.iter() {
                let (end, steps) = walk(ends[0], spoke.1, ends);
                if end != ends[1] {
                    return Class::Corner;
                }
                total = total.saturating_add(steps);
            }
            if total == surface.star(n).len() {
                return Class::Curve;
            }
        }
        _ => {}
    }
    Class::Corner
}

/// The feature curves: first those that end at corners, by their lower end, then the closed ones.
fn chains(surface: &Surface) -> Vec<Chain> {
    let mut seen = IndexVec::<NodeId, bool>::filled(false, surface.node_count());
    let mut all = Vec::new();
    for n in surface.live_nodes() {
        if surface.class[n] == Class::Corner {
            for m in surface.feature_neighbours(n) {
                let new = match surface.class[m] {
                    Class::Curve => !seen[m],
                    _ => n < m,
                };
                if new {
                    let nodes = follow(surface, n, m, &mut seen);
                    all.push(Chain {
                        nodes,
                        closed: false,
                    });
                }
            }
        }
    }
    for n in surface.live_nodes() {
        if surface.class[n] == Class::Curve && !seen[n] {
            let next = surface.feature_neighbours(n)[0];
            let mut nodes = follow(surface, n, next, &mut seen);
            nodes.pop();
            seen[n] = true;
            all.push(Chain {
                nodes,
                closed: true,
            });
        }
    }
    all
}

/// The nodes from `start` over `next` to the first corner or back to `start`, both ends included.
fn follow(
    surface: &Surface,
    start: NodeId,
    next: NodeId,
    seen: &mut IndexVec<NodeId, bool>,
) -> Vec<NodeId> {
    let mut nodes = vec![start];
    let (mut before, mut at) = (start, next);
    while at != start && surface.class[at] == Class::Curve && !seen[at] {
        nodes.push(at);
        seen[at] = true;
        let ends = surface.feature_neighbours(at);
        let onward = ends.iter().copied().find(|&e| e != before);
        before = at;
        at = onward.unwrap_or(start);
    }
    nodes.push(at);
    nodes
}

/// Positions in the chain that are corners by shape.
fn sharp(
    surface: &Surface,
    chain: &Chain,
    crease_angle: f64,
    reach: &dyn Fn(NodeId) -> f64,
) -> Vec<usize> {
    let points: Vec<DVec3> = chain.nodes.iter().map(|&n| surface.points[n]).collect();
    let inside = if chain.closed {
        0..points.len()
    } else {
        1..points.len() - 1
    };
    let mut turns = vec![0.0; points.len()];
    let mut sides = vec![[0; 2]; points.len()];
    for i in inside.clone() {
        let far = reach(chain.nodes[i]);
        let back = walk(&points, chain.closed, i, false, far);
        let ahead = walk(&points, chain.closed, i, true, far);
        sides[i] = [back, ahead];
        let (u, v) = (points[i] - points[back], points[ahead] - points[i]);
        if u != DVec3::ZERO && v != DVec3::ZERO {
            turns[i] = u.angle_between(v);
        }
    }
    let mut found = Vec::new();
    for i in inside {
        let turn = turns[i];
        let faces = ends(&surface.supports[chain.nodes[i]]).count();
        let alone = sides[i].iter().all(|&s| turns[s] < ALONE * turn);
        let least = if faces >= 2 {
            FACE_SHARE * crease_angle
        } else if alone {
            ALONE_SHARE * crease_angle
        } else {
            crease_angle
        };
        if turn > least {
            let on_edge = faces >= 2;
            found.push((i, on_edge, turn));
        }
    }
    // Within one reach the same corner shows at several nodes: keep the strongest.
    let mut order = found.clone();
    order.sort_by(|a, b| b.1.cmp(&a.1).then(b.2.total_cmp(&a.2)).then(a.0.cmp(&b.0)));
    let mut kept: Vec<usize> = Vec::new();
    let mut blocked = vec![false; points.len()];
    for (i, _, _) in order {
        if blocked[i] {
            continue;
        }
        kept.push(i);
        for (forward, end) in [(false, sides[i][0]), (true, sides[i][1])] {
            let mut at = i;
            // The node at the end of the walk is beyond the reach: it may be a corner of its own.
            while let Some(next) = step(points.len(), chain.closed, at, forward) {
                if next == end || next == i {
                    break;
                }
                blocked[next] = true;
                at = next;
            }
        }
    }
    kept.sort_unstable();
    kept
}

fn step(count: usize, closed: bool, i: usize, forward: bool) -> Option<usize> {
    match (forward, closed) {
        (true, true) => Some((i + 1) % count),
        (false, true) => Some((i + count - 1) % count),
        (true, false) => (i + 1 < count).then_some(i + 1),
        (false, false) => i.checked_sub(1),
    }
}

/// The first chain position at least `far` along the chain from `i` (the end, where the chain is shorter).
pub(super) fn walk(points: &[DVec3], closed: bool, i: usize, forward: bool, far: f64) -> usize {
    let (mut at, mut gone) = (i, 0.0);
    // On a closed chain a third of the way round at most: past that the two sides would meet.
    let most = (points.len() / 3).max(1);
    for _ in 0..most.max(if closed { 1 } else { points.len() }) {
        let Some(next) = step(points.len(), closed, at, forward) else {
            break;
        };
        gone += points[at].distance(points[next]);
        at = next;
        if gone >= far {
            break;
        }
    }
    at
}

/// Cuts a chain at the corners inside it.
fn cut(surface: &Surface, chain: Chain) -> Vec<Chain> {
    let corner = |n: &NodeId| surface.class[*n] == Class::Corner;
    let mut nodes = chain.nodes;
    if chain.closed {
        let Some(first) = nodes.iter().position(corner) else {
            return vec![Chain {
                nodes,
                closed: true,
            }];
        };
        nodes.rotate_left(first);
        nodes.push(nodes[0]);
    }
    let mut pieces = Vec::new();
    let mut piece = vec![nodes[0]];
    for &n in &nodes[1..] {
        piece.push(n);
        if corner(&n) {
            let nodes = std::mem::replace(&mut piece, vec![n]);
            pieces.push(Chain {
                nodes,
                closed: false,
            });
        }
    }
    pieces
}
