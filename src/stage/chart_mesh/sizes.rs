//! Sizes over a patch: the wanted ones at its old corners, grown from the short ones outwards, linear in between.
//!
//! A front that knew the size only where it stands would step across a bend narrower than its step; and to ask the field at every place is slow.

use super::surface::Spot;
use crate::model::patch::Patch;
use glam::DVec3;
use rayon::prelude::*;
use std::cmp::Reverse;
use std::collections::BinaryHeap;

/// Wanted edge length at every corner of a patch, mm; infinite where none is known.
pub(super) struct Sizes<'a> {
    patch: &'a Patch,
    corners: Vec<f64>,
}

impl<'a> Sizes<'a> {
    /// `field` is asked at every corner; sizes grow by `growth`, length per length, at most.
    pub(super) fn new(
        patch: &'a Patch,
        field: &(dyn Fn(DVec3) -> f64 + Sync),
        growth: f64,
    ) -> Self {
        let mut corners: Vec<f64> = (patch.points.par_iter())
            .map(|&p| field(p))
            .map(|s| if s > 0.0 { s } else { f64::INFINITY })
            .collect();
        let mut near: Vec<Vec<u32>> = vec![Vec::new(); corners.len()];
        for t in &patch.triangles {
            for k in 0..3 {
                near[t[k] as usize].extend([t[(k + 1) % 3], t[(k + 2) % 3]]);
            }
        }
        // Dijkstra; sizes are positive, so that their bits have their order.
        let mut heap: BinaryHeap<Reverse<(u64, u32)>> = (corners.iter().zip(0..))
            .filter(|(s, _)| s.is_finite())
            .map(|(s, c)| Reverse((s.to_bits(), c)))
            .collect();
        while let Some(Reverse((bits, c))) = heap.pop() {
            let size = corners[c as usize];
            if bits != size.to_bits() {
                continue;
            }
            for &d in &near[c as usize] {
                let length = patch.points[c as usize].distance(patch.points[d as usize]);
                let most = size + growth * length;
                if most < corners[d as usize] {
                    corners[d as usize] = most;
                    heap.push(Reverse((most.to_bits(), d)));
                }
            }
        }
        Self { patch, corners }
    }

    /// The size at a spot; not finite where none is known.
    pub(super) fn at(&self, spot: &Spot) -> f64 {
        let corners = self.patch.triangles[spot.triangle as usize];
        (corners.iter().zip(spot.weights))
            .map(|(&c, w)| self.corners[c as usize] * w)
            .sum()
    }

    /// The mean size of an old triangle; not finite where none is known.
    pub(super) fn of(&self, triangle: [u32; 3]) -> f64 {
        triangle
            .map(|c| self.corners[c as usize])
            .iter()
            .sum::<f64>()
            / 3.0
    }

    /// The size at an old corner.
    pub(super) fn corner(&self, corner: u32) -> f64 {
        self.corners[corner as usize]
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::model::ids::{NodeId, WallId};

    /// A strip of squares of side 1 along x, each cut in two.
    fn strip(length: u32) -> Patch {
        let at = |i: u32, j: u32| 2 * i + j;
        let mut patch = Patch {
            wall: WallId(0),
            nodes: Vec::new(),
            points: Vec::new(),
            triangles: Vec::new(),
            source: Vec::new(),
            loops: Vec::new(),
            kept_edges: Vec::new(),
            kept_corners: Vec::new(),
        };
        for i in 0..=length {
            for j in 0..2 {
                patch.nodes.push(NodeId(at(i, j)));
                patch
                    .points
                    .push(DVec3::new(f64::from(i), f64::from(j), 0.0));
            }
        }
        for i in 0..length {
            let [a, b, c, d] = [at(i, 0), at(i + 1, 0), at(i + 1, 1), at(i, 1)];
            patch.triangles.extend([[a, b, c], [a, c, d]]);
        }
        patch
    }

    #[test]
    fn sizes_grow_from_a_short_one_by_length_and_are_linear_between() {
        let patch = strip(10);
        let field = |p: DVec3| if p.x < 0.5 { 0.1 } else { 100.0 };
        let sizes = Sizes::new(&patch, &field, 0.4);
        for i in 0..=10 {
            let wanted = 0.1 + 0.4 * f64::from(i);
            assert!((sizes.corner(2 * i) - wanted).abs() < 1e-12);
        }
        let spot = Spot {
            triangle: 0,
            weights: [0.5, 0.5, 0.0],
        };
        assert!((sizes.at(&spot) - 0.3).abs() < 1e-12);
        // Without a bound on growth nothing spreads.
        assert_eq!(Sizes::new(&patch, &field, 1e3).corner(4), 100.0);
    }

    #[test]
    fn an_unknown_size_is_no_number() {
        let patch = strip(1);
        let sizes = Sizes::new(&patch, &|_| f64::NAN, 0.4);
        assert!(!sizes.of([0, 1, 2]).is_finite());
    }
}
