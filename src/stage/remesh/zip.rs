//! Zips creases that lie on each other.
//!
//! Where walls cross, the strip of sheet inside their common block is thin and may be eaten from a rim before the complex is read off: what is left are two creases, one on either side of the block,
//! that part at the end of the junction and run side by side to the rim. Such a pair is bridged with triangles again; `strips` then makes one curve of it.
//! Where five walls meet, a junction parts into a crease and a junction of three, and this into a crease and the free border of the fifth wall: every
//! parting of the triangles at a junction among two curves in one place is a slit. At a free border the slit may be a notch as wide as the block; what fills it is a
//! piece of the wall whose border it is.
//!
//! Guarantee: the homotopy type stays, every triangle is added over edges that are there with one new, free edge (an elementary expansion).
//! A slit that closes again at its far end is a hole and stays.

use super::shape::distance_to_segment;
use crate::model::complex::{EdgeKind, MidComplex, MidTriangle, Support};
use crate::model::ids::{IndexVec, NodeId, WallId};
use smallvec::SmallVec;
use std::collections::{BTreeMap, BTreeSet};

/// Creases nearer to each other than this many thicknesses are in one block of material: walls of half a thickness on either side overlap there.
const NEAR: f64 = 0.35;

/// A free border nearer than this to a crease that goes on from the same junction, in thicknesses, lies in the block of that junction: five walls overlap to 0.7
/// thicknesses from their common line, and the border may cut the corner by a tetrahedron more.
const NOTCH: f64 = 1.0;

/// Two nodes that stand side by side; the same one twice where the slit begins in a point.
type Front = [NodeId; 2];

/// Bridges every slit between two creases; whether there was one. `thickness(wall)`: mean thickness, mm.
pub(super) fn zip(complex: &mut MidComplex, thickness: &dyn Fn(WallId) -> f64) -> bool {
    let before = complex.triangles.len();
    let net = Net::new(complex);
    let mut known: BTreeSet<[NodeId; 2]> = net.edges.clone();
    for (front, firsts) in net.starts() {
        let [a, b] = [0, 1].map(|k| net.chain(front[k], firsts[k]));
        let chains = [net.cut(complex, &a, &b), net.cut(complex, &b, &a)];
        let wall = net.wall[&ordered(front[0], firsts[0])];
        let other = net.wall[&ordered(front[1], firsts[1])];
        let share = if net.is_free(&chains[0]) { NOTCH } else { NEAR };
        let near = share * thickness(wall).min(thickness(other));
        if fits(complex, &chains, near) {
            bridge(complex, &mut known, chains, wall);
        }
    }
    complex.triangles.len() > before
}

fn ordered(a: NodeId, b: NodeId) -> [NodeId; 2] {
    [a.min(b), a.max(b)]
}

/// The feature edges at every node.
struct Net {
    edges: BTreeSet<[NodeId; 2]>,
    /// A wall of every feature edge.
    wall: BTreeMap<[NodeId; 2], WallId>,
    /// The triangles at every feature edge.
    triangles: BTreeMap<[NodeId; 2], usize>,
    at: IndexVec<NodeId, SmallVec<[(NodeId, EdgeKind); 4]>>,
}

impl Net {
    fn new(complex: &MidComplex) -> Self {
        let mut net = Self {
            edges: BTreeSet::new(),
            wall: BTreeMap::new(),
            triangles: BTreeMap::new(),
            at: IndexVec::filled(SmallVec::new(), complex.nodes.len()),
        };
        for edge in complex.edges() {
            net.edges.insert(edge.ends);
            let kind = complex.kind(&edge);
            if kind == EdgeKind::Inner {
                continue;
            }
            let wall = complex.triangles[edge.triangles[0]].wall;
            net.wall.insert(edge.ends, wall);
            net.triangles.insert(edge.ends, edge.triangles.len());
            let [a, b] = edge.ends;
            net.at[a].push((b, kind));
            net.at[b].push((a, kind));
        }
        net
    }

    fn creases(&self, n: NodeId) -> SmallVec<[NodeId; 4]> {
        let at = self.at[n].iter();
        at.filter(|x| x.1 == EdgeKind::Crease)
            .map(|x| x.0)
            .collect()
    }

    fn is_fork(&self, n: NodeId) -> bool {
        self.at[n].iter().any(|x| x.1 == EdgeKind::Junction)
    }

    /// Whether a chain is a free border.
    fn is_free(&self, chain: &[NodeId]) -> bool {
        self.triangles[&ordered(chain[0], chain[1])] == 1
    }

    /// The first nodes of the two curves among which the triangles at a junction part, the one with fewer first: the bridge takes its wall.
    /// Of three curves the third is for the next time.
    fn parting(&self, n: NodeId) -> Option<Front> {
        let count = |x: &(NodeId, EdgeKind)| self.triangles[&ordered(n, x.0)];
        let mut at = self.at[n].clone();
        at.sort_by_key(count);
        let (stem, parts) = at.split_last()?;
        let [few, more, ..] = parts else {
            return None;
        };
        // Where two walls end in one place they are slotted, and their borders are no accident of the labels.
        if more.1 == EdgeKind::Rim {
            return None;
        }
        let all: usize = parts.iter().map(count).sum();
        (stem.1 == EdgeKind::Junction && all == count(stem)).then_some([few.0, more.0])
    }

    /// Where junctions end and two curves go on, in one point or at both ends of an edge; with the first node of either curve.
    fn starts(&self) -> Vec<(Front, Front)> {
        let mut starts = Vec::new();
        for (n, at) in self.at.enumerated().filter(|x| self.is_fork(x.0)) {
            if let [a, b] = *self.creases(n)
                && at.iter().all(|x| x.1 != EdgeKind::Rim)
            {
                starts.push(([n, n], [a, b]));
            } else if let Some(firsts) = self.parting(n) {
                starts.push(([n, n], firsts));
            }
        }
        for &[n, m] in &self.edges {
            if self.is_fork(n)
                && self.is_fork(m)
                && let ([a], [b]) = (&*self.creases(n), &*self.creases(m))
                && (*a, *b) != (m, n)
            {
                starts.push(([n, m], [*a, *b]));
            }
        }
        starts
    }

    /// A chain as far as it goes beside another: a free border has no end of its own where it turns off along the edge of its sheet.
    fn cut(&self, complex: &MidComplex, chain: &[NodeId], other: &[NodeId]) -> Vec<NodeId> {
        let (true, Some(&end)) = (self.is_free(chain), other.last()) else {
            return chain.to_vec();
        };
        let far = |&n: &NodeId| complex.nodes[n].point.distance(complex.nodes[end].point);
        let nearest = (1..chain.len()).min_by(|&i, &j| far(&chain[i]).total_cmp(&far(&chain[j])));
        chain[..=nearest.unwrap_or(1)].to_vec()
    }

    /// The nodes of a curve from `from` over `first` to where it ends or forks.
    fn chain(&self, from: NodeId, first: NodeId) -> Vec<NodeId> {
        let mut chain = vec![from, first];
        while let [before, last] = chain[chain.len() - 2..] {
            let &[(a, _), (b, _)] = self.at[last].as_slice() else {
                break;
            };
            let next = if a == before { b } else { a };
            if chain.contains(&next) {
                break;
            }
            chain.push(next);
        }
        chain
    }
}

/// Whether two chains run side by side from end to end, and do not meet at the far end.
fn fits(complex: &MidComplex, chains: &[Vec<NodeId>; 2], near: f64) -> bool {
    let p = |n: NodeId| complex.nodes[n].point;
    let beside = |n: NodeId, chain: &[NodeId]| {
        chain
            .windows(2)
            .any(|w| distance_to_segment(p(n), p(w[0]), p(w[1])) < near)
    };
    let [a, b] = chains;
    let shared = a[1..].iter().any(|n| b[1..].contains(n));
    !shared && a.iter().all(|&n| beside(n, b)) && b.iter().all(|&n| beside(n, a))
}

/// Fills the slit with triangles, the shorter new edge first.
fn bridge(
    complex: &mut MidComplex,
    known: &mut BTreeSet<[NodeId; 2]>,
    chains: [Vec<NodeId>; 2],
    wall: WallId,
) {
    let [a, b] = &chains;
    let (mut i, mut j) = (0, 0);
    let mut made: Vec<[NodeId; 3]> = Vec::new();
    let mut fresh: Vec<[NodeId; 2]> = Vec::new();
    if a[0] == b[0] {
        (i, j) = (1, 1);
        made.push([a[0], a[1], b[1]]);
        fresh.push(ordered(a[1], b[1]));
    }
    while i + 1 < a.len() || j + 1 < b.len() {
        let length = |x: Option<&NodeId>, y: NodeId| {
            x.map_or(f64::INFINITY, |&x| {
                complex.nodes[x].point.distance(complex.nodes[y].point)
            })
        };
        if length(a.get(i + 1), b[j]) <= length(b.get(j + 1), a[i]) {
            made.push([a[i], b[j], a[i + 1]]);
            i += 1;
        } else {
            made.push([a[i], b[j], b[j + 1]]);
            j += 1;
        }
        fresh.push(ordered(a[i], b[j]));
    }
    if fresh.iter().any(|e| known.contains(e)) {
        return;
    }
    known.extend(fresh);
    for nodes in made {
        complex.triangles.push(MidTriangle { nodes, wall });
        for n in nodes {
            let supports = &mut complex.nodes[n].supports;
            supports.push(Support::Mid(wall));
            supports.sort_unstable();
            supports.dedup();
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::model::complex::MidNode;
    use glam::DVec3;

    /// The same on a plate, wall 4, across the far end: each spine ends at its own node of the plate, the two are joined by an edge of it.
    fn on_a_plate(gap: f64, shared: usize) -> MidComplex {
        let mut complex = cross(gap, shared, false);
        let ends: Vec<NodeId> = (complex.nodes.enumerated())
            .filter(|(_, n)| n.point.x > 5.9)
            .map(|x| x.0)
            .collect();
        let &[upper, lower, ..] = ends.as_slice() else {
            unreachable!("both spines end there")
        };
        let at = |y: f64, z: f64| {
            let of = |n: &&NodeId| {
                let p = complex.nodes[**n].point;
                (p.y, p.z) == (y, z)
            };
            *ends.iter().find(of).unwrap()
        };
        let corners = [at(-5.0, 5.0), at(5.0, 5.0), at(5.0, -5.0), at(-5.0, -5.0)];
        for nodes in [
            [upper, corners[0], corners[1]],
            [lower, corners[2], corners[3]],
            [upper, corners[1], lower],
            [lower, corners[1], corners[2]],
            [upper, lower, corners[0]],
            [lower, corners[3], corners[0]],
        ] {
            complex.triangles.push(MidTriangle {
                nodes,
                wall: WallId(4),
            });
        }
        complex
    }

    #[test]
    fn a_slit_that_begins_in_an_edge_of_a_plate_is_bridged() {
        let mut complex = on_a_plate(0.01, 0);
        let before = (complex.euler(), complex.pieces(), complex.triangles.len());
        zip(&mut complex, &|_| 1.0);
        assert_eq!((complex.euler(), complex.pieces()), (before.0, before.1));
        assert!(complex.triangles.len() > before.2);
        assert!(complex.check().is_empty());
    }

    /// Two bent sheets, walls 0|1 above and 2|3 below the plane, that touch along x: they share the nodes up to `shared` and run `gap` apart beyond.
    fn cross(gap: f64, shared: usize, closed: bool) -> MidComplex {
        let mut complex = MidComplex::default();
        let mut node = |x: f64, y: f64, z: f64| {
            complex.nodes.push(MidNode {
                point: DVec3::new(x, y, z),
                supports: Default::default(),
            })
        };
        let count = 7;
        let line = |node: &mut dyn FnMut(f64, f64, f64) -> NodeId, y: f64, z: f64| {
            (0..count)
                .map(|i| node(f64::from(i), y, z))
                .collect::<Vec<_>>()
        };
        let upper = line(&mut node, 0.0, 0.0);
        let mut lower = upper.clone();
        for (i, n) in lower.iter_mut().enumerate().skip(shared) {
            if !(closed && i + 1 == count as usize) {
                *n = node(i as f64 + 0.1, 0.0, -gap);
            }
        }
        let arms = [(-5.0, 5.0), (5.0, 5.0), (-5.0, -5.0), (5.0, -5.0)]
            .map(|(y, z)| line(&mut node, y, z));
        for (wall, arm) in arms.iter().enumerate() {
            let spine = if wall < 2 { &upper } else { &lower };
            for i in 0..spine.len() - 1 {
                for nodes in [
                    [spine[i], spine[i + 1], arm[i]],
                    [arm[i], spine[i + 1], arm[i + 1]],
                ] {
                    complex.triangles.push(MidTriangle {
                        nodes,
                        wall: WallId(wall as u32),
                    });
                }
            }
        }
        complex
    }

    #[test]
    fn a_slit_that_runs_out_at_the_rim_is_bridged() {
        let mut complex = cross(0.01, 3, false);
        let euler = complex.euler();
        zip(&mut complex, &|_| 1.0);
        // A triangle where it begins, then two for each of the three further steps.
        assert_eq!(complex.triangles.len(), 48 + 7);
        assert_eq!((complex.euler(), complex.pieces()), (euler, 1));
        assert!(complex.check().is_empty());
    }

    /// A fifth wall, `high` above the plane, stands on the upper of the two sheets; its free border cuts off the corner at the rim.
    fn five(high: f64) -> MidComplex {
        let mut complex = cross(0.01, 3, false);
        let first = complex.nodes.len() as u32;
        for i in 0..7 {
            complex.nodes.push(MidNode {
                point: DVec3::new(f64::from(i), 0.0, high),
                supports: Default::default(),
            });
        }
        let (foot, top) = (NodeId, |i| NodeId(first + i));
        for i in 0..6 {
            complex.triangles.push(MidTriangle {
                nodes: [foot(i), top(i), top(i + 1)],
                wall: WallId(4),
            });
            if i < 5 {
                complex.triangles.push(MidTriangle {
                    nodes: [foot(i), top(i + 1), foot(i + 1)],
                    wall: WallId(4),
                });
            }
        }
        complex
    }

    #[test]
    fn a_junction_of_five_that_parts_twice_is_bridged_twice() {
        let mut complex = five(0.8);
        let (euler, before) = (complex.euler(), complex.triangles.len());
        assert!(zip(&mut complex, &|_| 1.0));
        // The notch of the fifth wall is filled with a triangle of that wall: its foot reaches the rim.
        assert_eq!(complex.triangles.len(), before + 1);
        assert_eq!(
            complex.triangles[complex.triangles.ids().last().unwrap()].wall,
            WallId(4)
        );
        // Then three walls and two lie side by side to the rim.
        assert!(zip(&mut complex, &|_| 1.0));
        assert_eq!(complex.triangles.len(), before + 1 + 7);
        assert!(!zip(&mut complex, &|_| 1.0));
        assert_eq!((complex.euler(), complex.pieces()), (euler, 1));
        assert!(complex.check().is_empty());
    }

    #[test]
    fn a_notch_wider_than_the_walls_are_thick_stays() {
        let before = five(1.5);
        let mut complex = before.clone();
        zip(&mut complex, &|_| 1.0);
        assert_eq!(complex, before);
    }

    #[test]
    fn creases_apart_and_holes_stay() {
        for before in [
            cross(0.5, 3, false),
            cross(0.01, 3, true),
            on_a_plate(0.01, 3),
        ] {
            let mut complex = before.clone();
            zip(&mut complex, &|_| 1.0);
            assert_eq!(complex, before);
        }
    }
}
