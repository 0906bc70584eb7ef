//! Contracts the triangles that lie the wrong way round.
//!
//! What smoothing cannot turn is a knot: more nodes than the place has room for. Each of its triangles loses its shortest edge that topology and features can spare.
//!
//! Guarantee: homotopy type and feature curves stay (the link condition of `contract`, features judged as they are now), and sheets hang together by edges as before.

use super::dust::keeps_together;
use super::surface::{Surface, key};
use crate::geom::orient::{folded, turned};
use crate::geom::placer::Placer;
use crate::model::complex::{EdgeKind, MidComplex, ends};
use crate::model::ids::{IndexVec, NodeId, TriangleId};
use glam::DVec3;

/// Contracts an edge of every triangle whose normal is turned from its wall's, in a complex whose sheets are wound one way.
pub fn contract_turned(complex: MidComplex, placer: &dyn Placer) -> MidComplex {
    let all: Vec<TriangleId> = complex.triangles.ids().collect();
    let turned = turned(&complex, &all, placer);
    contract(complex, turned, placer)
}

/// The same for those that are folded over as well: in a finished mesh, whose triangles are of one size with their neighbours.
pub fn contract_folded(complex: MidComplex, placer: &dyn Placer) -> MidComplex {
    let all: Vec<TriangleId> = complex.triangles.ids().collect();
    let mut wrong = turned(&complex, &all, placer);
    wrong.extend(folded(&complex));
    wrong.sort_unstable();
    wrong.dedup();
    contract(complex, wrong, placer)
}

fn contract(complex: MidComplex, wrong: Vec<TriangleId>, placer: &dyn Placer) -> MidComplex {
    let fixed = fixed(&complex);
    let mut surface = Surface::new(complex);
    for t in wrong {
        if surface.lives(t)
            && let Some((gone, kept)) = best(&surface, &fixed, t, placer)
        {
            surface.contract(gone, kept);
        }
    }
    surface.finish()
}

/// Ends and forks of feature curves, and corners of rims.
fn fixed(complex: &MidComplex) -> IndexVec<NodeId, bool> {
    let mut degree = IndexVec::<NodeId, u32>::filled(0, complex.nodes.len());
    for edge in complex
        .edges()
        .iter()
        .filter(|e| complex.kind(e) != EdgeKind::Inner)
    {
        for n in edge.ends {
            degree[n] += 1;
        }
    }
    complex
        .nodes
        .enumerated()
        .map(|(n, node)| !matches!(degree[n], 0 | 2) || ends(&node.supports).count() > 1)
        .collect()
}

/// The shortest edge of the triangle that may go, as (gone, kept).
fn best(
    surface: &Surface,
    fixed: &IndexVec<NodeId, bool>,
    t: TriangleId,
    placer: &dyn Placer,
) -> Option<(NodeId, NodeId)> {
    let nodes = surface.triangle(t).nodes;
    let mut edges: Vec<(u64, NodeId, NodeId)> = (0..3)
        .flat_map(|k| {
            let (a, b) = (nodes[k], nodes[(k + 1) % 3]);
            let length = key(surface.length(a, b));
            [(length, a, b), (length, b, a)]
        })
        .collect();
    edges.sort_unstable();
    edges
        .into_iter()
        .map(|(_, gone, kept)| (gone, kept))
        .find(|&(gone, kept)| {
            may_go(surface, fixed, gone, kept) && stays_inside(surface, gone, kept, placer)
        })
}

/// Whether no more of the sheets lies outside the material than before: in a ring round a bore all triangles may be turned, and drawn together it spans the bore.
fn stays_inside(surface: &Surface, gone: NodeId, kept: NodeId, placer: &dyn Placer) -> bool {
    let outside = |t: TriangleId, at: DVec3| {
        let [a, b, c] = surface.corners_with(t, gone, at);
        if placer.outside((a + b + c) / 3.0, surface.triangle(t).wall) {
            (b - a).cross(c - a).length()
        } else {
            0.0
        }
    };
    let [from, to] = [gone, kept].map(|n| surface.points[n]);
    let star = surface.star(gone);
    let after: f64 = (star.iter()).map(|&t| outside(t, to)).sum();
    after == 0.0 || after <= star.iter().map(|&t| outside(t, from)).sum()
}

fn may_go(surface: &Surface, fixed: &IndexVec<NodeId, bool>, gone: NodeId, kept: NodeId) -> bool {
    let near = surface.feature_neighbours(gone);
    let strata = near.is_empty()
        || !fixed[gone]
            && near.contains(&kept)
            && !surface
                .feature_neighbours(kept)
                .iter()
                .any(|n| near.contains(n));
    strata && keeps_together(surface, gone, kept)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::model::complex::Support;
    use crate::model::ids::WallId;
    use crate::stage::test_shapes::Build;

    /// The plane z = 0 seen from below, with a bore of this radius at its middle.
    struct Bored(f64);

    impl Placer for Bored {
        fn place(&self, start: DVec3, _: &[Support]) -> DVec3 {
            start
        }
        fn normal(&self, _: DVec3, _: WallId) -> Option<DVec3> {
            Some(DVec3::NEG_Z)
        }
        fn thickness(&self, _: DVec3, _: WallId) -> Option<f64> {
            None
        }
        fn outside(&self, point: DVec3, _: WallId) -> bool {
            point.length() < self.0
        }
        fn curvature_radius(&self, _: DVec3, _: WallId) -> f64 {
            f64::INFINITY
        }
    }

    /// Area of a ring from radius 1 to 1.2, all of whose triangles are turned, contracted as far as they can be.
    fn area_left(bore: f64) -> f64 {
        let mut b = Build::default();
        b.sheet(0, 24, 1, |u, v| {
            let (sin, cos) = (std::f64::consts::TAU * u).sin_cos();
            DVec3::new(cos, sin, 0.0) * (1.0 + 0.2 * v)
        });
        for t in b.complex.triangles.as_mut_slice() {
            t.nodes.sort_unstable();
        }
        crate::geom::orient::orient(&mut b.complex, &Bored(0.0));
        for t in b.complex.triangles.as_mut_slice() {
            t.nodes.swap(1, 2);
        }
        let area = |c: &MidComplex| -> f64 {
            (c.triangles.iter())
                .map(|t| c.area_vector(t).length())
                .sum()
        };
        let mut complex = b.complex;
        for _ in 0..8 {
            complex = contract_turned(complex, &Bored(bore));
        }
        assert!(complex.check().is_empty());
        area(&complex)
    }

    #[test]
    fn a_turned_ring_is_not_drawn_over_its_bore() {
        // Its area is pi 0.44 at first; drawn together to its last three sides it has but slivers.
        let [free, bored] = [0.0, 0.9].map(area_left);
        assert!(free < 0.3 && bored > 0.7, "{free} {bored}");
    }
}
