//! Nodes that take their triangles out of the material go back.
//!
//! ```text
//!    ________a__   _____      Walls that hardly turn from each other meet, carried on beyond their ends, far from where the labels part: node a is put to b, and its triangles become spikes
//!   _ _ _ _ / `.|  |_ _       over what is no material. Whether the node itself lies outside says little: the spike may end in the wall beyond the bore.
//!    _________|_`. b___
//! ```
//!
//! Guarantee: no node far from where it was has more of its triangles' area outside than there, but for what the neighbours that went back with it, or did not, add.
//! Cost: a look at the triangles round each node that moved far, there and here.

use crate::geom::placer::Placer;
use crate::model::complex::MidComplex;
use crate::model::ids::{IndexVec, NodeId, TriangleId};
use rayon::prelude::*;
use smallvec::SmallVec;

/// A node that moved by less than this share of the longest edge at it has changed its triangles too little to be looked at.
const MOVED: f64 = 0.1;

/// Puts nodes back to where they were `then` whose triangles have more of their area outside the material where they are now.
pub(super) fn stay(
    complex: &mut MidComplex,
    then: &MidComplex,
    stars: &IndexVec<NodeId, SmallVec<[TriangleId; 8]>>,
    placer: &dyn Placer,
) {
    let far: Vec<NodeId> = (complex.nodes.ids().collect::<Vec<_>>().par_iter())
        .copied()
        .filter(|&n| {
            let old = then.nodes[n].point;
            let way = complex.nodes[n].point.distance(old);
            let longest = || {
                (stars[n].iter())
                    .flat_map(|&t| complex.triangles[t].nodes)
                    .map(|m| complex.nodes[m].point.distance(old))
                    .fold(0.0, f64::max)
            };
            way > 0.0 && way > MOVED * longest()
        })
        .collect();
    // Two neighbours may leave together: the one put back alone would leave a larger triangle.
    let back: Vec<NodeId> = (far.par_iter())
        .copied()
        .filter(|&n| outside(complex, &stars[n], placer) > outside(then, &stars[n], placer))
        .collect();
    for n in back {
        complex.nodes[n].point = then.nodes[n].point;
    }
}

/// Area of those of the triangles that have their middles outside the material.
fn outside(complex: &MidComplex, triangles: &[TriangleId], placer: &dyn Placer) -> f64 {
    (triangles.iter())
        .map(|&t| {
            let triangle = &complex.triangles[t];
            let [a, b, c] = complex.corners(triangle);
            if placer.outside((a + b + c) / 3.0, triangle.wall) {
                complex.area_vector(triangle).length()
            } else {
                0.0
            }
        })
        .sum()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::model::complex::Support;
    use crate::model::ids::WallId;
    use crate::stage::test_shapes::Build;
    use glam::DVec3;

    /// Beyond x = `end` there is no material.
    struct Ends(f64);

    impl Placer for Ends {
        fn place(&self, start: DVec3, _: &[Support]) -> DVec3 {
            start
        }
        fn normal(&self, _: DVec3, _: WallId) -> Option<DVec3> {
            None
        }
        fn thickness(&self, _: DVec3, _: WallId) -> Option<f64> {
            None
        }
        fn outside(&self, point: DVec3, _: WallId) -> bool {
            point.x > self.0
        }
        fn curvature_radius(&self, _: DVec3, _: WallId) -> f64 {
            f64::INFINITY
        }
    }

    /// Where the middle one and the last one of the nodes of a rim along x = 1 lie after they were put so far outwards, and what moved along the rim.
    fn rim(far: [f64; 2], along: f64, end: f64) -> [DVec3; 2] {
        let mut b = Build::default();
        b.sheet(0, 4, 4, |u, v| DVec3::new(u, v, 0.0));
        let [m, l] = [0.5, 1.0].map(|y| b.node(DVec3::new(1.0, y, 0.0)));
        let then = b.complex;
        let mut now = then.clone();
        now.nodes[m].point += DVec3::new(far[0], along, 0.0);
        now.nodes[l].point += DVec3::new(far[1], 0.0, 0.0);
        stay(&mut now, &then, &then.stars(), &Ends(end));
        [m, l].map(|n| now.nodes[n].point - then.nodes[n].point)
    }

    #[test]
    fn a_spike_over_no_material_is_drawn_in_and_one_in_the_material_stays() {
        let far = DVec3::X * 2.0;
        assert_eq!(rim([2.0, 0.0], 0.0, 1.1), [DVec3::ZERO; 2]);
        assert_eq!(rim([2.0, 0.0], 0.0, 4.0), [far, DVec3::ZERO]);
    }

    #[test]
    fn nodes_that_leave_together_go_back_together() {
        assert_eq!(rim([2.0, 2.0], 0.0, 1.1), [DVec3::ZERO; 2]);
    }

    #[test]
    fn what_was_outside_before_may_move() {
        // Half a triangle's width along the rim of a sheet that lies outside as a whole: no more of it is.
        let way = DVec3::new(-0.05, 0.1, 0.0);
        assert!(rim([way.x, 0.0], way.y, -1.0)[0].distance(way) < 1e-12);
    }

    #[test]
    fn a_little_way_is_not_looked_at() {
        let way = DVec3::X * 0.02;
        assert!(rim([way.x, 0.0], 0.0, 0.0)[0].distance(way) < 1e-12);
    }
}
