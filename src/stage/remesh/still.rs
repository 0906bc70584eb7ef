//! Where a search for a better place found nothing, so that it is not repeated before something about the node has changed.
//!
//! Guarantee: the outcome of a search depends only on what goes into the print (a 64-bit digest, so but for a chance of 1 in 2^64 a node), hence leaving out
//! a search whose print is that of one without success changes no result.

use super::job::Job;
use crate::model::ids::{Id, NodeId};
use rayon::prelude::*;

/// Odd, with bits evenly spread: Knuth's multiplicative hashing by the golden ratio.
const GOLDEN: u64 = 0x9e37_79b9_7f4a_7c15;

/// The prints of all nodes at their last search in vain.
#[derive(Clone, Debug, Default)]
pub(super) struct Still {
    prints: Vec<Option<u64>>,
}

impl Still {
    /// Whether nothing has changed about the node since its last search in vain.
    pub fn holds(&self, job: &Job, n: NodeId) -> bool {
        let seen = self.prints.get(n.index()).copied().flatten();
        seen.is_some_and(|print| print == digest(job, n))
    }

    /// Records beforehand, all at once, which of the nodes would be searched `in_vain` as things are now.
    pub fn foresee(
        &mut self,
        job: &Job,
        nodes: &[NodeId],
        in_vain: impl Fn(NodeId) -> bool + Sync,
    ) {
        let found: Vec<bool> = (nodes.par_iter())
            .map(|&n| !self.holds(job, n) && in_vain(n))
            .collect();
        for (&n, _) in nodes.iter().zip(found).filter(|x| x.1) {
            self.record(job, n);
        }
    }

    /// Records a search in vain.
    pub fn record(&mut self, job: &Job, n: NodeId) {
        if self.prints.len() <= n.index() {
            self.prints.resize(job.surface.node_count(), None);
        }
        self.prints[n.index()] = Some(digest(job, n));
    }
}

/// Everything that a search at a node reads: its star with places, sizes, normals under it and spots on curves.
fn digest(job: &Job, n: NodeId) -> u64 {
    let surface = &job.surface;
    let mut print = 0u64;
    let mut add = |word: u64| {
        print = (print.rotate_left(23) ^ word).wrapping_mul(GOLDEN);
    };
    add(surface.class[n] as u64);
    for &t in surface.star(n) {
        add(t.index() as u64);
        for x in surface.reference[t].to_array() {
            add(x.to_bits());
        }
        for m in surface.triangle(t).nodes {
            add(m.index() as u64);
            add(job.size[m].to_bits());
            for x in surface.points[m].to_array() {
                add(x.to_bits());
            }
            if let Some(spot) = job.guides.spot(m) {
                add(spot.guide.index() as u64);
                add(spot.at.to_bits());
            }
        }
    }
    // The last products mix upwards only: the top bits have seen all words.
    print ^ (print >> 32)
}
