//! Cones of three triangles that a single triangle can stand for.
//!
//! Three triangles of one wall that go all round a node (its hub) are a disc whose border is a triangle. Where the hub belongs to nothing else it is not needed. Where it hangs
//! on one edge of a junction as well, the cone is a sheet that was caught there: it runs to the junction and back again, and lies on itself. No move, flip or contraction takes
//! it off, since the edge has other triangles; its base lies free beside the junction.
//!
//! Guarantees: the homotopy type stays. A cone meets the rest in its border, and in one spoke at most: cut open along the spoke it is a disc on the same border.
//! The spoke keeps two triangles or more, so no new rim comes about.

use super::surface::Surface;
use crate::model::ids::{NodeId, TriangleId};

/// Three triangles round a hub.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Cone {
    pub hub: NodeId,
    pub triangles: [TriangleId; 3],
    /// The triangle that stands for them, wound as the first.
    pub base: [NodeId; 3],
}

/// The cones that a triangle is the first of and whose base may take their place.
pub(super) fn cones(surface: &Surface, t: TriangleId) -> Vec<Cone> {
    let triangle = surface.triangle(t);
    let mut all = Vec::new();
    for k in 0..3 {
        let [hub, x, y] = [0, 1, 2].map(|i| triangle.nodes[(k + i) % 3]);
        let beside = |n: NodeId| {
            let ring = surface.around(hub, n).into_iter();
            ring.filter(|&s| s != t && surface.triangle(s).wall == triangle.wall)
        };
        for s in beside(x) {
            let z = surface.apex(s, hub, x);
            let Some(u) = beside(y).find(|&u| surface.apex(u, hub, y) == z) else {
                continue;
            };
            let is_there = surface
                .around(x, y)
                .iter()
                .any(|&b| surface.apex(b, x, y) == z);
            if z != y && !is_there && may_go(surface, hub, [x, y, z]) {
                all.push(Cone {
                    hub,
                    triangles: [t, s, u],
                    base: triangle.nodes.map(|n| if n == hub { z } else { n }),
                });
            }
        }
    }
    all
}

/// Whether the hub hangs on nothing but the cone, or on one spoke with two other triangles or more.
fn may_go(surface: &Surface, hub: NodeId, rim: [NodeId; 3]) -> bool {
    let others = rim.map(|n| surface.around(hub, n).len() - 2);
    match others.iter().filter(|c| **c > 0).count() {
        0 => surface.star(hub).len() == 3,
        1 => others.iter().all(|c| *c != 1),
        _ => false,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geom::orient::folded;
    use crate::model::complex::{MidComplex, MidNode, MidTriangle};
    use crate::model::ids::WallId;
    use crate::stage::remesh::unfold::unfold;
    use crate::stage::test_shapes::{Stay, sheet};
    use glam::DVec3;

    fn node(complex: &mut MidComplex, x: f64, y: f64, z: f64) -> NodeId {
        complex.nodes.push(MidNode {
            point: DVec3::new(x, y, z),
            supports: Default::default(),
        })
    }

    fn triangle(complex: &mut MidComplex, wall: u32, nodes: [NodeId; 3]) {
        let wall = WallId(wall);
        complex.triangles.push(MidTriangle { nodes, wall });
    }

    /// A triangle cut into three round a hub that lies `beyond` the middle of its first side, on which two fins of other walls stand, from the hub to the first corner.
    fn caught(beyond: f64, fins: u32) -> MidComplex {
        let mut complex = MidComplex::default();
        let a = node(&mut complex, 0.0, 0.0, 0.0);
        let b = node(&mut complex, 4.0, 0.0, 0.0);
        let c = node(&mut complex, 2.0, 4.0, 0.0);
        let hub = node(&mut complex, 2.0, -beyond, 0.0);
        for [p, q] in [[a, b], [b, c], [c, a]] {
            triangle(&mut complex, 0, [hub, p, q]);
        }
        for wall in 1..=fins {
            let tip = node(&mut complex, 1.0, -1.0, f64::from(wall));
            triangle(&mut complex, wall, [hub, a, tip]);
        }
        complex
    }

    #[test]
    fn a_cone_hooked_on_a_junction_comes_off_and_the_junction_stays() {
        let mut complex = caught(1.0, 2);
        // The fins hang on the sheet elsewhere as well: without that they would come off with the cone.
        triangle(&mut complex, 3, [0, 4, 2].map(NodeId));
        assert_eq!(folded(&complex).len(), 1);
        let mended = unfold(complex.clone(), &Stay);
        assert!(folded(&mended).is_empty());
        let of_wall = |w: u32| {
            mended
                .triangles
                .iter()
                .filter(|t| t.wall == WallId(w))
                .count()
        };
        assert_eq!([of_wall(0), of_wall(1), of_wall(2)], [1, 1, 1]);
        assert_eq!((mended.euler(), complex.euler()), (1, 1));
        assert_eq!(mended.pieces(), 1);
        assert!(mended.check().is_empty());
    }

    #[test]
    fn a_node_that_three_triangles_go_round_is_not_needed() {
        let surface = Surface::new(caught(-1.0, 0));
        let found = cones(&surface, TriangleId(0));
        assert_eq!(found.len(), 1);
        assert_eq!(found[0].hub, NodeId(3));
        assert_eq!(found[0].base, [2, 0, 1].map(NodeId));
    }

    #[test]
    fn one_fin_alone_would_get_a_rim_and_two_spokes_a_loop() {
        let surface = Surface::new(caught(1.0, 1));
        assert!(cones(&surface, TriangleId(0)).is_empty());
        let mut complex = caught(1.0, 2);
        for wall in [3, 4] {
            let tip = node(&mut complex, 3.0, -1.0, f64::from(wall));
            triangle(&mut complex, wall, [NodeId(3), NodeId(1), tip]);
        }
        assert!(cones(&Surface::new(complex), TriangleId(0)).is_empty());
    }

    #[test]
    fn a_base_that_is_there_already_may_not_come_twice() {
        let mut complex = caught(-1.0, 0);
        triangle(&mut complex, 0, [0, 1, 2].map(NodeId));
        assert!(cones(&Surface::new(complex), TriangleId(0)).is_empty());
    }

    #[test]
    fn a_plate_has_no_cones() {
        let surface = Surface::new(sheet(6, 6, |u, v| DVec3::new(u, v, 0.0)));
        assert!(
            surface
                .live_triangles()
                .all(|t| cones(&surface, t).is_empty())
        );
    }
}
