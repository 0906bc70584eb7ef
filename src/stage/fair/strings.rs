//! Closed rims inside a lump: kept as wide as they were.
//!
//! A rim round a hole lies on the hole's wall, and comes back to it however it is smoothed. Where the hole ends in a lump its supports may say nothing, and a closed string
//! whose nodes move to the middle of their neighbours draws itself together to a point: the hole is shut, and the triangles round it have no area. So a loop that has shrunk is
//! scaled back about its middle; what its supports do say puts it where it belongs.

use super::Net;
use crate::geom::placer::Placer;
use crate::model::complex::MidComplex;
use crate::model::ids::NodeId;
use glam::DVec3;
use rayon::prelude::*;

/// Loops that are narrower than this share of what they were have shrunk: rims that only come into order lose less.
const LEAST_LEFT: f64 = 0.9;

/// Closed rims with their widths at the beginning.
pub(super) struct Strings {
    loops: Vec<(Vec<NodeId>, f64)>,
}

impl Strings {
    pub fn new(complex: &MidComplex, net: &Net) -> Self {
        let mut loops = Vec::new();
        let mut seen = vec![false; complex.nodes.len()];
        let free = |n: NodeId| net.curve_nodes.binary_search(&n).is_ok();
        for &first in &net.curve_nodes {
            let mut nodes = vec![first];
            let (mut before, mut at) = (first, net.along[first][0]);
            while at != first && free(at) && !seen[at.0 as usize] {
                nodes.push(at);
                let [a, b] = [net.along[at][0], net.along[at][1]];
                (before, at) = (at, if a == before { b } else { a });
            }
            let closed = at == first && nodes.len() > 2;
            for n in &nodes {
                seen[n.0 as usize] = true;
            }
            if closed {
                let width = breadth(&points(complex, &nodes)).1;
                loops.push((nodes, width));
            }
        }
        Self { loops }
    }

    /// Scales loops that have shrunk back to what they were, and puts them onto their supports again.
    pub fn reopen(&self, complex: &mut MidComplex, placer: &dyn Placer) {
        let moved: Vec<Vec<DVec3>> = self
            .loops
            .par_iter()
            .map(|(nodes, width)| {
                let points = points(complex, nodes);
                let (middle, now) = breadth(&points);
                if now >= LEAST_LEFT * width || now <= f64::MIN_POSITIVE {
                    return points;
                }
                let scaled = |p: &DVec3| middle + (*p - middle) * (width / now);
                nodes
                    .iter()
                    .zip(points.iter().map(scaled))
                    .map(|(&n, p)| {
                        let placed = placer.draw(p, &complex.nodes[n].supports);
                        if placed.is_finite() { placed } else { p }
                    })
                    .collect()
            })
            .collect();
        for ((nodes, _), points) in self.loops.iter().zip(moved) {
            for (&n, p) in nodes.iter().zip(points) {
                complex.nodes[n].point = p;
            }
        }
    }
}

fn points(complex: &MidComplex, nodes: &[NodeId]) -> Vec<DVec3> {
    nodes.iter().map(|&n| complex.nodes[n].point).collect()
}

/// Middle of a closed polygon and the root mean square distance of its sides' middles from it, both weighted by the sides' lengths.
fn breadth(points: &[DVec3]) -> (DVec3, f64) {
    let sides = || {
        let next = points.iter().cycle().skip(1);
        let sides = points.iter().zip(next);
        sides.map(|(a, b)| ((*a + *b) / 2.0, a.distance(*b)))
    };
    let length: f64 = sides().map(|(_, l)| l).sum();
    if length <= 0.0 {
        return (points[0], 0.0);
    }
    let middle = sides().map(|(m, l)| m * l).sum::<DVec3>() / length;
    let square: f64 = sides()
        .map(|(m, l)| m.distance_squared(middle) * l)
        .sum::<f64>()
        / length;
    (middle, square.sqrt())
}
