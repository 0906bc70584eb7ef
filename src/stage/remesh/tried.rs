//! What was tried at folds in vain, so that a later pass does not try it again where nothing has changed round about.
//!
//! Guarantee: an attempt reads nothing but the triangles within the rings that it is recorded with, so leaving out one whose print is that of an attempt in vain changes no
//! result (but for a chance of 1 in 2^64 a fold: the print is a 64-bit digest).

use super::surface::Surface;
use super::unfold::rings;
use crate::model::complex::Support;
use crate::model::ids::{Id, NodeId, TriangleId};
use std::collections::BTreeMap;

/// Odd, with bits evenly spread: Knuth's multiplicative hashing by the golden ratio.
const GOLDEN: u64 = 0x9e37_79b9_7f4a_7c15;

/// The prints of places at their last attempt in vain, by how many rings the attempt reads: that tells the kinds of attempts apart.
#[derive(Clone, Debug, Default)]
pub(super) struct Tried {
    prints: BTreeMap<(usize, TriangleId), u64>,
}

impl Tried {
    /// Does `attempt` at a triangle, which reads so many rings round it, unless it was in vain with everything there as it is now; whether it did anything.
    pub fn unless_in_vain(
        &mut self,
        surface: &mut Surface,
        (t, reads): (TriangleId, usize),
        attempt: impl FnOnce(&mut Surface) -> bool,
    ) -> bool {
        let print = digest(surface, t, reads);
        if self.prints.get(&(reads, t)) == Some(&print) {
            return false;
        }
        let done = attempt(surface);
        if !done {
            self.prints.insert((reads, t), print);
        }
        done
    }
}

/// Everything within the rings: triangles, their nodes, where these are and what they lie on.
fn digest(surface: &Surface, t: TriangleId, reads: usize) -> u64 {
    let mut print = 0u64;
    let mut add = |word: u64| {
        print = (print.rotate_left(23) ^ word).wrapping_mul(GOLDEN);
    };
    let all = rings(surface, t, reads);
    let mut nodes: Vec<NodeId> = Vec::with_capacity(3 * all.len());
    for t in all {
        let triangle = surface.triangle(t);
        add(t.index() as u64);
        add(triangle.wall.index() as u64);
        for n in triangle.nodes {
            add(n.index() as u64);
            nodes.push(n);
        }
    }
    nodes.sort_unstable();
    nodes.dedup();
    for n in nodes {
        for x in surface.points[n].to_array() {
            add(x.to_bits());
        }
        // The order of a star decides between equals.
        for &t in surface.star(n) {
            add(t.index() as u64);
        }
        for support in &surface.supports[n] {
            match support {
                Support::Mid(w) => add(w.index() as u64),
                Support::Face(f) => add(1 << 40 | f.index() as u64),
                Support::Edge(c) => add(2 << 40 | c.index() as u64),
                Support::Pin(p) => add(3 << 40 | p.index() as u64),
            }
        }
    }
    // The last products mix upwards only: the top bits have seen all words.
    print ^ (print >> 32)
}
