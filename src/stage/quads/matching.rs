//! Matching in a graph: as many pairs as possible, and among these heavy ones.
//!
//! First the heaviest pairs are taken greedily, then Edmonds' blossom algorithm (doi:10.4153/CJM-1965-045-4) makes the number of pairs
//! maximal, then short alternating paths and rings are turned over while that gains weight.
//!
//! Guarantees: the number of pairs is the largest possible; the weight is a local maximum, not the largest. Ties are broken by
//! number, so that the answer depends on nothing but the input.
//! Cost: meant for degrees up to three or four; blossoms cost O(vertices) a pair that greed left over.

use std::collections::VecDeque;

/// An edge between two vertices, worth `weight`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Edge {
    pub ends: [u32; 2],
    pub weight: f64,
}

const NONE: u32 = u32::MAX;
/// Longest ring or path that is turned over, in pairs: beyond, gains are rare and the search doubles with every step.
const REACH: usize = 5;
/// Gains come to rest after three or four rounds; more would only chase rounding.
const ROUNDS: usize = 8;

/// For each of `count` vertices the one that it is paired with.
pub(super) fn pair(count: usize, edges: &[Edge]) -> Vec<Option<u32>> {
    let mut graph = Graph::new(count, edges);
    graph.take_greedily(edges);
    graph.make_maximal();
    for _ in 0..ROUNDS {
        if !graph.improve() {
            break;
        }
    }
    graph
        .mate
        .iter()
        .map(|&m| (m != NONE).then_some(m))
        .collect()
}

struct Graph {
    /// Neighbours of each vertex and the weights of the edges there, by number.
    near: Vec<Vec<(u32, f64)>>,
    mate: Vec<u32>,
}

impl Graph {
    fn new(count: usize, edges: &[Edge]) -> Self {
        let mut near = vec![Vec::new(); count];
        for e in edges {
            let [a, b] = e.ends;
            near[a as usize].push((b, e.weight));
            near[b as usize].push((a, e.weight));
        }
        for list in &mut near {
            list.sort_by(|a, b| a.0.cmp(&b.0).then(b.1.total_cmp(&a.1)));
            list.dedup_by_key(|n| n.0);
        }
        Self {
            near,
            mate: vec![NONE; count],
        }
    }

    fn take_greedily(&mut self, edges: &[Edge]) {
        let mut order: Vec<&Edge> = edges.iter().collect();
        order.sort_by(|a, b| b.weight.total_cmp(&a.weight).then(a.ends.cmp(&b.ends)));
        for e in order {
            let [a, b] = e.ends;
            if self.mate[a as usize] == NONE && self.mate[b as usize] == NONE {
                self.join(a, b);
            }
        }
    }

    fn join(&mut self, a: u32, b: u32) {
        self.mate[a as usize] = b;
        self.mate[b as usize] = a;
    }

    fn weight(&self, a: u32, b: u32) -> f64 {
        let list = &self.near[a as usize];
        list.iter().find(|n| n.0 == b).map_or(0.0, |n| n.1)
    }

    fn make_maximal(&mut self) {
        let mut search = Blossoms::new(self.mate.len());
        for root in 0..self.mate.len() as u32 {
            if self.mate[root as usize] == NONE
                && let Some(mut end) = search.path(self, root)
            {
                while end != NONE {
                    let before = search.parent[end as usize];
                    let next = self.mate[before as usize];
                    self.join(end, before);
                    end = next;
                }
            }
        }
    }

    /// Turns over every ring, and every path from a free vertex, that gains weight. Whether there was one.
    fn improve(&mut self) -> bool {
        let mut improved = false;
        for v in 0..self.mate.len() as u32 {
            let mut walk = Walk {
                path: vec![v],
                best: Vec::new(),
                gain: 1e-9,
            };
            if self.mate[v as usize] == NONE {
                self.walk_path(&mut walk, 0.0);
            } else {
                let first = self.mate[v as usize];
                walk.path.push(first);
                self.walk_ring(&mut walk, -self.weight(v, first));
            }
            let best = walk.best;
            if best.is_empty() {
                continue;
            }
            improved = true;
            if best.len() % 2 == 1 {
                // v-x, y-z, ...: the last vertex stays alone.
                for pair in best.chunks_exact(2) {
                    self.join(pair[0], pair[1]);
                }
                self.mate[best[best.len() - 1] as usize] = NONE;
            } else {
                // v=a, b-c, d-e, ..., last-v.
                for pair in best[1..best.len() - 1].chunks_exact(2) {
                    self.join(pair[0], pair[1]);
                }
                self.join(best[best.len() - 1], best[0]);
            }
        }
        improved
    }

    /// From a free vertex: pair it with a neighbour, whose mate is then free, and so on.
    fn walk_path(&self, walk: &mut Walk, gain: f64) {
        let at = walk.path[walk.path.len() - 1];
        for &(x, weight) in &self.near[at as usize] {
            let y = self.mate[x as usize];
            if y == NONE || walk.path.contains(&x) || walk.path.contains(&y) {
                continue;
            }
            let gain = gain + weight - self.weight(x, y);
            walk.path.extend([x, y]);
            walk.keep(gain);
            if walk.path.len() < 2 * REACH {
                self.walk_path(walk, gain);
            }
            walk.path.truncate(walk.path.len() - 2);
        }
    }

    /// From a pair: leave it, pair its second with a neighbour, and so on round to the first.
    fn walk_ring(&self, walk: &mut Walk, gain: f64) {
        let at = walk.path[walk.path.len() - 1];
        let first = walk.path[0];
        for &(x, weight) in &self.near[at as usize] {
            if x == first {
                if walk.path.len() > 2 {
                    walk.keep(gain + weight);
                }
                continue;
            }
            let y = self.mate[x as usize];
            if y == NONE || walk.path.len() >= 2 * REACH || walk.path.contains(&x) {
                continue;
            }
            walk.path.extend([x, y]);
            self.walk_ring(walk, gain + weight - self.weight(x, y));
            walk.path.truncate(walk.path.len() - 2);
        }
    }
}

/// A depth-first walk and the best end that it met.
struct Walk {
    path: Vec<u32>,
    best: Vec<u32>,
    gain: f64,
}

impl Walk {
    fn keep(&mut self, gain: f64) {
        if gain > self.gain {
            self.gain = gain;
            self.best.clone_from(&self.path);
        }
    }
}

/// The search for an augmenting path, blossoms shrunk on the way.
struct Blossoms {
    parent: Vec<u32>,
    base: Vec<u32>,
    even: Vec<bool>,
    in_blossom: Vec<bool>,
    queue: VecDeque<u32>,
    touched: Vec<u32>,
}

impl Blossoms {
    fn new(count: usize) -> Self {
        Self {
            parent: vec![NONE; count],
            base: (0..count as u32).collect(),
            even: vec![false; count],
            in_blossom: vec![false; count],
            queue: VecDeque::new(),
            touched: Vec::new(),
        }
    }

    /// The free end of an augmenting path from `root`; the way back is in `parent` and the mates.
    fn path(&mut self, graph: &Graph, root: u32) -> Option<u32> {
        for v in self.touched.drain(..) {
            let i = v as usize;
            (self.parent[i], self.base[i], self.even[i]) = (NONE, v, false);
        }
        self.queue.clear();
        self.reach(root);
        while let Some(v) = self.queue.pop_front() {
            for &(to, _) in &graph.near[v as usize] {
                let mate = graph.mate[to as usize];
                if self.base[v as usize] == self.base[to as usize] || graph.mate[v as usize] == to {
                    continue;
                }
                let to_is_even = to == root || (mate != NONE && self.parent[mate as usize] != NONE);
                if to_is_even {
                    self.shrink(graph, v, to);
                } else if self.parent[to as usize] == NONE {
                    self.parent[to as usize] = v;
                    self.touched.push(to);
                    if mate == NONE {
                        return Some(to);
                    }
                    self.reach(mate);
                }
            }
        }
        None
    }

    fn reach(&mut self, v: u32) {
        if !self.even[v as usize] {
            self.even[v as usize] = true;
            self.touched.push(v);
            self.queue.push_back(v);
        }
    }

    /// An odd ring was found through `v` and `to`: its vertices become one.
    fn shrink(&mut self, graph: &Graph, v: u32, to: u32) {
        let base = self.common_base(graph, v, to);
        let mut members = Vec::new();
        self.mark(graph, v, base, to, &mut members);
        self.mark(graph, to, base, v, &mut members);
        for &b in &members {
            self.in_blossom[b as usize] = true;
        }
        // Only vertices that the search has touched can have these bases.
        for i in 0..self.touched.len() {
            let u = self.touched[i];
            if self.in_blossom[self.base[u as usize] as usize] {
                self.base[u as usize] = base;
                self.reach(u);
            }
        }
        for &b in &members {
            self.in_blossom[b as usize] = false;
        }
    }

    fn common_base(&self, graph: &Graph, mut a: u32, mut b: u32) -> u32 {
        let mut seen = Vec::new();
        loop {
            a = self.base[a as usize];
            seen.push(a);
            let mate = graph.mate[a as usize];
            if mate == NONE {
                break;
            }
            a = self.parent[mate as usize];
        }
        loop {
            b = self.base[b as usize];
            if seen.contains(&b) {
                return b;
            }
            b = self.parent[graph.mate[b as usize] as usize];
        }
    }

    fn mark(
        &mut self,
        graph: &Graph,
        mut v: u32,
        base: u32,
        mut child: u32,
        members: &mut Vec<u32>,
    ) {
        while self.base[v as usize] != base {
            let mate = graph.mate[v as usize];
            members.extend([self.base[v as usize], self.base[mate as usize]]);
            self.parent[v as usize] = child;
            self.touched.push(v);
            child = mate;
            v = self.parent[mate as usize];
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geom::random::Pcg;

    fn check(count: usize, edges: &[Edge], mate: &[Option<u32>]) -> (usize, f64) {
        let (mut pairs, mut weight) = (0, 0.0);
        for v in 0..count {
            if let Some(m) = mate[v] {
                assert_eq!(mate[m as usize], Some(v as u32));
                let found = edges
                    .iter()
                    .filter(|e| e.ends == [v as u32, m] || e.ends == [m, v as u32]);
                let best = found.map(|e| e.weight).fold(f64::NEG_INFINITY, f64::max);
                assert!(best.is_finite(), "{v} and {m} are no neighbours");
                if (v as u32) < m {
                    pairs += 1;
                    weight += best;
                }
            }
        }
        (pairs, weight)
    }

    /// The most pairs and the most weight of as many pairs, by trying everything.
    fn brute(edges: &[Edge], used: u32) -> (usize, f64) {
        let Some((first, rest)) = edges.split_first() else {
            return (0, 0.0);
        };
        let without = brute(rest, used);
        let bits = 1 << first.ends[0] | 1 << first.ends[1];
        if used & bits != 0 {
            return without;
        }
        let with = brute(rest, used | bits);
        let with = (with.0 + 1, with.1 + first.weight);
        if with.0 > without.0 || (with.0 == without.0 && with.1 > without.1) {
            with
        } else {
            without
        }
    }

    #[test]
    fn the_number_of_pairs_is_the_largest_on_random_graphs() {
        let mut rng = Pcg::new(4);
        let (mut got, mut possible) = (0.0, 0.0);
        for _ in 0..300 {
            let count = 4 + (rng.unit() * 9.0) as u32;
            let mut edges = Vec::new();
            for a in 0..count {
                for b in a + 1..count {
                    if edges.len() < 18 && rng.unit() < 2.6 / f64::from(count) {
                        let weight = rng.unit();
                        edges.push(Edge {
                            ends: [a, b],
                            weight,
                        });
                    }
                }
            }
            let mate = pair(count as usize, &edges);
            let (pairs, weight) = check(count as usize, &edges, &mate);
            let (most, heaviest) = brute(&edges, 0);
            assert_eq!(pairs, most, "{edges:?}");
            (got, possible) = (got + weight, possible + heaviest);
        }
        assert!(got > 0.995 * possible, "{got} of {possible}");
    }

    #[test]
    fn greed_is_mended_on_a_long_chain_and_through_a_blossom() {
        // Greed takes every second edge from the wrong end and leaves both ends alone.
        let chain: Vec<Edge> = (0..201)
            .map(|i| Edge {
                ends: [i, i + 1],
                weight: if i % 2 == 1 { 1.0 } else { 0.9 },
            })
            .collect();
        assert!(pair(202, &chain).iter().all(Option::is_some));
        let edge = |a, b, weight| Edge {
            ends: [a, b],
            weight,
        };
        // A ring of five with a tail at two of its corners.
        let ring = [
            edge(0, 1, 0.2),
            edge(1, 2, 0.9),
            edge(2, 3, 0.2),
            edge(3, 4, 0.9),
            edge(4, 0, 0.2),
            edge(0, 5, 0.1),
            edge(2, 6, 0.1),
            edge(6, 7, 0.8),
        ];
        assert!(pair(8, &ring).iter().all(Option::is_some));
    }

    #[test]
    fn a_ring_is_turned_over_when_that_gains() {
        // The heaviest edge is in the lighter of the two ways round.
        let weights = [1.0, 0.9, 0.1, 0.9];
        let ring: Vec<Edge> = (0..4)
            .map(|i| Edge {
                ends: [i, (i + 1) % 4],
                weight: weights[i as usize],
            })
            .collect();
        let mate = pair(4, &ring);
        assert_eq!(mate, vec![Some(3), Some(2), Some(1), Some(0)]);
        assert_eq!(pair(3, &[]), vec![None; 3]);
    }
}
