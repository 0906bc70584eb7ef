//! Merges junction curves that are one.
//!
//! Four walls that meet in a cross arrive from the dual complex as two triple curves with a strip of sheet between them, all
//! inside the block where the walls overlap. Such a strip is contracted until none of it is left, and the curves become one.
//!
//! Guarantee: the homotopy type stays (link condition without strata: Dey, Edelsbrunner, Guha, Nekhayev 1999). The graph of features is meant to change.
//! Exception: where the link condition forbids a step the strip stays.

use super::contract::merge;
use super::dust::keeps_together;
use super::forks::merge_forks;
use super::spurs::trim_spurs;
use super::surface::{Surface, key};
use super::zip::zip;
use crate::geom::placer::Placer;
use crate::model::complex::{EdgeKind, MidComplex};
use crate::model::disjoint::Disjoint;
use crate::model::ids::{NodeId, TriangleId, WallId};
use crate::spatial::TriangleBvh;
use glam::DVec3;

/// Passes over the strips; a step can make the next possible.
const PASSES: usize = 8;

/// A junction block reaches this far from its curve along a strip, in thicknesses of the thickest wall that crosses the strip's own: half of it,
/// and half as much again for walls that cross askew. The strip's own thickness says nothing: fins on a thick plate stay apart. Nor does that of walls that go on
/// from the strip beyond the curve: between fins a thick wall may have a face, and so be a wall of its own, in every gap.
const BLOCK: f64 = 0.75;
/// Cosine of the angle, 37.5 degrees, below which two walls that meet go on from each other: between the drawing angles of 30 and 45 degrees.
const GOES_ON_COS: f64 = 0.793_353_340_291_235_2;
/// A strip may end on rims; a sheet with more of its border on rims than this is a low rib, and stays.
const RIM_SHARE: f64 = 0.25;

/// Bridges slits, then contracts every sheet that lies wholly inside a junction block. `thickness(wall)`: mean thickness, mm.
pub fn merge_strips(
    mut complex: MidComplex,
    thickness: &dyn Fn(WallId) -> f64,
    placer: &dyn Placer,
) -> MidComplex {
    zip(&mut complex, thickness);
    for _ in 0..PASSES {
        complex = merge_bridged(complex, thickness, placer);
        // Where forks have become one, the two creases of a slit may now begin side by side.
        if !zip(&mut complex, thickness) {
            break;
        }
    }
    complex
}

/// Bridges slits that are left where strips have become curves, and merges what lies on each other there; a complex without slits stays as it is.
pub fn merge_slits(
    mut complex: MidComplex,
    thickness: &dyn Fn(WallId) -> f64,
    placer: &dyn Placer,
) -> MidComplex {
    for _ in 0..PASSES {
        if !zip(&mut complex, thickness) {
            break;
        }
        complex = merge_bridged(complex, thickness, placer);
    }
    complex
}

fn merge_bridged(
    complex: MidComplex,
    thickness: &dyn Fn(WallId) -> f64,
    placer: &dyn Placer,
) -> MidComplex {
    let strips = strips(&complex, thickness, placer);
    let mut surface = Surface::new(complex);
    for _ in 0..PASSES {
        let mut left = false;
        for strip in &strips {
            left |= contract_strip(&mut surface, strip, placer);
        }
        if !left {
            break;
        }
    }
    merge_forks(&mut surface, thickness, placer);
    trim_spurs(&mut surface);
    surface.finish()
}

/// Triangles of every strip.
fn strips(
    complex: &MidComplex,
    thickness: &dyn Fn(WallId) -> f64,
    placer: &dyn Placer,
) -> Vec<Vec<TriangleId>> {
    let edges = complex.edges();
    let mut curves: Vec<[DVec3; 3]> = Vec::new();
    let mut meeting: Vec<Vec<(WallId, f64)>> = Vec::new();
    let mut sets = Disjoint::new(complex.triangles.len());
    for edge in &edges {
        match complex.kind(edge) {
            EdgeKind::Inner => {
                sets.join(edge.triangles[0].0, edge.triangles[1].0);
            }
            EdgeKind::Junction => {
                let [a, b] = edge.ends.map(|n| complex.nodes[n].point);
                curves.push([a, b, b]);
                let walls = edge.triangles.iter().map(|&t| complex.triangles[t].wall);
                meeting.push(walls.map(|w| (w, thickness(w))).collect());
            }
            EdgeKind::Rim | EdgeKind::Crease => {}
        }
    }
    if curves.is_empty() {
        return Vec::new();
    }
    let bvh = TriangleBvh::new(&curves);
    let inside = |p: DVec3, wall: WallId| {
        bvh.nearest(p).is_some_and(|near| {
            let walls = &meeting[near.index];
            let thickest = |kept: &dyn Fn(WallId) -> bool| {
                let kept = walls.iter().filter(|w| kept(w.0));
                kept.map(|w| w.1).fold(0.0, f64::max)
            };
            let all = thickest(&|_| true);
            // Spares most points the normals.
            near.distance <= BLOCK * all && {
                let normal = placer.normal(near.point, wall);
                let goes_on = |w: WallId| {
                    let other = || placer.normal(near.point, w);
                    w == wall
                        || normal
                            .is_some_and(|n| other().is_some_and(|o| n.dot(o).abs() > GOES_ON_COS))
                };
                let crossing = thickest(&|w| !goes_on(w));
                let across = if crossing > 0.0 { crossing } else { all };
                near.distance <= BLOCK * across
            }
        })
    };
    // Border length and rim length a sheet.
    let mut border = vec![(0.0, 0.0); complex.triangles.len()];
    for edge in &edges {
        let kind = complex.kind(edge);
        let [a, b] = edge.ends.map(|n| complex.nodes[n].point);
        for &t in edge.triangles.iter().filter(|_| kind != EdgeKind::Inner) {
            let sheet = &mut border[sets.find(t.0) as usize];
            sheet.0 += a.distance(b);
            sheet.1 += if kind == EdgeKind::Rim {
                a.distance(b)
            } else {
                0.0
            };
        }
    }
    let mut members: Vec<(u32, TriangleId)> = complex
        .triangles
        .ids()
        .map(|t| (sets.find(t.0), t))
        .collect();
    members.sort_unstable();
    members
        .chunk_by(|a, b| a.0 == b.0)
        .filter(|sheet| {
            let (all, rims) = border[sheet[0].0 as usize];
            rims <= RIM_SHARE * all
                && sheet.iter().all(|&(_, t)| {
                    let triangle = &complex.triangles[t];
                    let [a, b, c] = complex.corners(triangle);
                    // Of a strip one triangle wide all nodes lie on its curves: the middles of the sides tell its width.
                    [a, b, c, (a + b) / 2.0, (b + c) / 2.0, (c + a) / 2.0]
                        .into_iter()
                        .all(|p| inside(p, triangle.wall))
                })
        })
        .map(|sheet| sheet.iter().map(|m| m.1).collect())
        .collect()
}

/// Contracts the strip as far as it goes; whether something was done and something is left.
fn contract_strip(surface: &mut Surface, strip: &[TriangleId], placer: &dyn Placer) -> bool {
    let mut done = false;
    while let Some((kept, gone)) = next(surface, strip) {
        merge(surface, gone, kept, placer);
        done = true;
    }
    done && strip.iter().any(|&t| surface.lives(t))
}

/// The best edge that may be contracted: across the strip first, then the shortest; only what is left of a strip of one triangle goes along its border.
fn next(surface: &Surface, strip: &[TriangleId]) -> Option<(NodeId, NodeId)> {
    let mut candidates: Vec<(bool, u64, NodeId, NodeId)> = Vec::new();
    for &t in strip.iter().filter(|&&t| surface.lives(t)) {
        let nodes = surface.triangle(t).nodes;
        for k in 0..3 {
            let (a, b) = (
                nodes[k].min(nodes[(k + 1) % 3]),
                nodes[k].max(nodes[(k + 1) % 3]),
            );
            let inner = surface
                .around(a, b)
                .iter()
                .all(|s| strip.binary_search(s).is_ok());
            candidates.push((!inner, key(surface.length(a, b)), a, b));
        }
    }
    candidates.sort_unstable();
    candidates.dedup();
    candidates
        .into_iter()
        .find(|c| keeps_together(surface, c.3, c.2))
        .map(|c| (c.2, c.3))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::model::complex::{MidNode, MidTriangle};
    use crate::stage::test_shapes::Stay;

    /// Four flaps round a strip of `width` along x: the cross section is >-<.
    fn cross(width: f64) -> MidComplex {
        let mut complex = MidComplex::default();
        let n = 5u32;
        for i in 0..n {
            let x = f64::from(i);
            for (y, z) in [
                (0.0, 0.0),
                (width, 0.0),
                (-1.0, 1.0),
                (-1.0, -1.0),
                (1.0, 1.0),
                (1.0, -1.0),
            ] {
                complex.nodes.push(MidNode {
                    point: DVec3::new(x, y, z),
                    supports: Default::default(),
                });
            }
        }
        for i in 0..n - 1 {
            for (wall, a, b) in [(0, 0, 1), (1, 0, 2), (2, 0, 3), (1, 1, 4), (2, 1, 5)] {
                let [p, q, r, s] = [6 * i + a, 6 * i + b, 6 * i + 6 + a, 6 * i + 6 + b].map(NodeId);
                for nodes in [[p, q, s], [p, s, r]] {
                    complex.triangles.push(MidTriangle {
                        nodes,
                        wall: WallId(wall),
                    });
                }
            }
        }
        complex
    }

    #[test]
    fn two_triple_curves_in_one_block_become_one_curve_of_four() {
        let merged = merge_strips(cross(0.1), &|_| 1.0, &Stay);
        assert!(merged.check().is_empty());
        assert_eq!((merged.euler(), merged.pieces()), (1, 1));
        let four = merged
            .edges()
            .iter()
            .filter(|e| e.triangles.len() == 4)
            .count();
        assert_eq!(four, 4);
        assert_eq!(merged.triangles.len(), 32);
    }

    #[test]
    fn fins_that_stand_close_on_a_thick_plate_stay_apart() {
        // The strip's own wall goes on beyond both curves.
        let mut plate = cross(0.8);
        for t in plate.triangles.as_mut_slice() {
            t.wall = WallId(t.wall.0.saturating_sub(1));
        }
        let thickness = |fin: f64| move |w: WallId| if w.0 == 0 { 8.0 } else { fin };
        assert!(strips(&plate, &thickness(0.5), &Stay).is_empty());
        assert_eq!(strips(&plate, &thickness(0.6), &Stay).len(), 1);
    }

    /// Walls 0 to 2 are pieces of one flat plate, the others stand on it.
    struct Plate;

    impl Placer for Plate {
        fn place(&self, start: DVec3, _: &[crate::model::complex::Support]) -> DVec3 {
            start
        }
        fn normal(&self, _: DVec3, wall: WallId) -> Option<DVec3> {
            Some(if wall.0 < 3 { DVec3::Z } else { DVec3::Y })
        }
        fn thickness(&self, _: DVec3, _: WallId) -> Option<f64> {
            None
        }
        fn curvature_radius(&self, _: DVec3, _: WallId) -> f64 {
            f64::INFINITY
        }
    }

    #[test]
    fn fins_on_a_plate_that_is_another_wall_in_every_gap_stay_apart() {
        // The strip is wall 0; wall 1 goes on from it on one side and wall 2 on the other; on each curve stands a fin.
        let mut plate = cross(0.8);
        for t in plate.triangles.as_mut_slice() {
            let right = t.nodes.iter().all(|n| n.0 % 6 != 0);
            t.wall = WallId(match (t.wall.0, right) {
                (0, _) => 0,
                (1, side) => 1 + u32::from(side),
                (_, side) => 3 + u32::from(side),
            });
        }
        let thickness = |fin: f64| move |w: WallId| if w.0 < 3 { 8.0 } else { fin };
        assert!(strips(&plate, &thickness(0.5), &Plate).is_empty());
        assert_eq!(strips(&plate, &thickness(0.6), &Plate).len(), 1);
        // Where nothing tells that the plate goes on, it crosses.
        assert_eq!(strips(&plate, &thickness(0.5), &Stay).len(), 1);
    }

    #[test]
    fn a_strip_with_width_stays() {
        assert_eq!(merge_strips(cross(2.0), &|_| 1.0, &Stay), cross(2.0));
    }
}
