//! Closed rims inside a lump: kept as wide as they were.
//!
//! A rim round a hole lies on the hole's wall, and comes back to it however it is smoothed. Where the hole ends in a lump its supports may say nothing, and a closed string
//! whose nodes move to the middle of their neighbours draws itself together to a point: the hole is shut, and the triangles round it have no area. So a ring that has shrunk is
//! scaled back about its middle; what its supports do say puts it where it belongs.

use super::Net;
use crate::geom::placer::Placer;
use crate::geom::rim_loops::{breadths, closed_rims};
use crate::model::complex::MidComplex;
use crate::model::ids::NodeId;
use glam::DVec3;
use rayon::prelude::*;

/// Rings narrower than this share of what they were have shrunk: rims that only come into order lose less.
const LEAST_LEFT: f64 = 0.9;

/// Closed rims that may slide, with their breadths at the beginning.
pub(super) struct Strings {
    rings: Vec<(Vec<NodeId>, f64)>,
}

impl Strings {
    pub fn new(complex: &MidComplex, net: &Net) -> Self {
        let slides = |n: &NodeId| net.curve_nodes.binary_search(n).is_ok();
        let rings = closed_rims(complex)
            .into_iter()
            .filter(|ring| ring.iter().all(slides))
            .map(|ring| {
                let breadth = breadth(&points(complex, &ring)).1;
                (ring, breadth)
            })
            .collect();
        Self { rings }
    }

    /// Scales rings that have shrunk back to what they were, and puts them onto their supports again.
    pub fn reopen(&self, complex: &mut MidComplex, placer: &dyn Placer) {
        let moved: Vec<Vec<DVec3>> = self
            .rings
            .par_iter()
            .map(|(ring, width)| {
                let points = points(complex, ring);
                let (middle, now) = breadth(&points);
                if now >= LEAST_LEFT * width || now <= f64::MIN_POSITIVE {
                    return points;
                }
                let scaled = |p: &DVec3| middle + (*p - middle) * (width / now);
                (ring.iter().zip(points.iter().map(scaled)))
                    .map(|(&n, p)| {
                        let placed = placer.draw(p, &complex.nodes[n].supports);
                        if placed.is_finite() { placed } else { p }
                    })
                    .collect()
            })
            .collect();
        for ((ring, _), points) in self.rings.iter().zip(moved) {
            for (&n, p) in ring.iter().zip(points) {
                complex.nodes[n].point = p;
            }
        }
    }
}

fn points(complex: &MidComplex, nodes: &[NodeId]) -> Vec<DVec3> {
    nodes.iter().map(|&n| complex.nodes[n].point).collect()
}

/// Middle and breadth over both principal axes.
fn breadth(ring: &[DVec3]) -> (DVec3, f64) {
    let (middle, [long, short]) = breadths(ring);
    (middle, long.hypot(short))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::model::complex::{MidNode, MidTriangle, Support, Supports};
    use crate::model::ids::{FaceId, WallId};
    use crate::stage::fair::fair;

    /// Wall 0 is the plane z = 0; face 0 says nothing, face 1 is the cylinder of radius 2 about z.
    struct Plane;

    impl Placer for Plane {
        fn place(&self, mut p: DVec3, supports: &[Support]) -> DVec3 {
            for s in supports {
                match s {
                    Support::Mid(_) => p.z = 0.0,
                    Support::Face(FaceId(1)) => {
                        let flat = p.with_z(0.0);
                        p = 2.0 * flat.normalize_or(DVec3::X) + DVec3::Z * p.z;
                    }
                    _ => {}
                }
            }
            p
        }
        fn normal(&self, _: DVec3, _: WallId) -> Option<DVec3> {
            Some(DVec3::Z)
        }
        fn thickness(&self, _: DVec3, _: WallId) -> Option<f64> {
            Some(1.0)
        }
        fn curvature_radius(&self, _: DVec3, _: WallId) -> f64 {
            f64::INFINITY
        }
    }

    /// Radii of the nodes of a hole of seven nodes and radius 1 after fairing; its nodes lie on wall 0 and the face. The rim outside, of radius 4, is held by its corners.
    fn radii(face: u32) -> Vec<f64> {
        let count = 7;
        let mut complex = MidComplex::default();
        for radius in [1.0, 4.0] {
            for k in 0..count {
                let angle = std::f64::consts::TAU * f64::from(k) / f64::from(count);
                let ends: &[u32] = if radius < 2.0 { &[face] } else { &[7, 8] };
                let ends = ends.iter().map(|&f| Support::Face(FaceId(f)));
                complex.nodes.push(MidNode {
                    point: DVec3::new(angle.cos(), angle.sin(), 0.0) * radius,
                    supports: std::iter::once(Support::Mid(WallId(0)))
                        .chain(ends)
                        .collect::<Supports>(),
                });
            }
        }
        for k in 0..count {
            let [a, b] = [k, (k + 1) % count].map(NodeId);
            let [c, d] = [a, b].map(|n| NodeId(n.0 + count));
            for nodes in [[a, c, d], [a, d, b]] {
                complex.triangles.push(MidTriangle {
                    nodes,
                    wall: WallId(0),
                });
            }
        }
        let (complex, _) = fair(complex, &Plane);
        (0..count)
            .map(|n| complex.nodes[NodeId(n)].point.length())
            .collect()
    }

    #[test]
    fn a_closed_rim_that_nothing_holds_stays_as_wide_as_it_was() {
        // Six rounds of plain smoothing would leave a quarter of it: each takes 1 - cos(2 pi / 7) of the radius.
        for r in radii(0) {
            assert!((LEAST_LEFT - 1e-9..=1.0 + 1e-9).contains(&r), "{r}");
        }
    }

    #[test]
    fn a_rim_comes_to_lie_on_the_wall_of_its_hole() {
        for r in radii(1) {
            assert!((r - 2.0).abs() < 1e-12, "{r}");
        }
    }
}
