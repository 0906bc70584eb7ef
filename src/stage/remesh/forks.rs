//! Merges forks of junctions that are one.
//!
//! Where a curve of four walls meets a plate, the dual complex has a fork for every change of the walls round about: several points of the graph of curves in one
//! place. An edge between two forks that is far shorter than the walls are thick is contracted; a node inside a sheet that parts two such forks goes first.
//!
//! Guarantee: the homotopy type stays (link condition). The graph of curves is meant to change.

use super::contract::merge;
use super::dust::keeps_together;
use super::surface::{Surface, key};
use crate::geom::placer::Placer;
use crate::model::complex::ends;
use crate::model::ids::{NodeId, WallId};

/// Forks nearer to each other than this many thicknesses are one.
const NEAR: f64 = 0.35;

/// Contracts short edges between forks, the shortest first, until none is left. `thickness(wall)`: mean thickness, mm.
pub(super) fn merge_forks(
    surface: &mut Surface,
    thickness: &dyn Fn(WallId) -> f64,
    placer: &dyn Placer,
) {
    draw_together(surface, thickness);
    loop {
        let mut merged = false;
        for (_, gone, kept) in short(surface, thickness) {
            // An earlier merger may have taken either end along, or moved it.
            if is_short(surface, gone, kept, thickness) && keeps_together(surface, gone, kept) {
                merge(surface, gone, kept, placer);
                merged = true;
            }
        }
        if !merged {
            break;
        }
    }
}

/// Contracts nodes inside a sheet that lie between two forks in one place, so that an edge joins these.
fn draw_together(surface: &mut Surface, thickness: &dyn Fn(WallId) -> f64) {
    let forks = forks(surface);
    for &kept in &forks {
        for between in surface.neighbours(kept) {
            if !surface.feature_neighbours(between).is_empty()
                || !is_short(surface, between, kept, thickness)
            {
                continue;
            }
            let parts = surface.neighbours(between).into_iter().any(|n| {
                n != kept
                    && forks.binary_search(&n).is_ok()
                    && surface.around(n, kept).is_empty()
                    && is_short(surface, between, n, thickness)
            });
            if parts && keeps_together(surface, between, kept) {
                surface.contract(between, kept);
            }
        }
    }
}

/// Nodes where more than two feature edges meet, sorted.
fn forks(surface: &Surface) -> Vec<NodeId> {
    surface
        .live_nodes()
        .filter(|&n| surface.feature_neighbours(n).len() > 2)
        .collect()
}

/// Short edges between two forks, the shortest first, as (length, gone, kept). The corner of a rim stays in its place: it is the other end that goes.
fn short(surface: &Surface, thickness: &dyn Fn(WallId) -> f64) -> Vec<(u64, NodeId, NodeId)> {
    let forks = forks(surface);
    let mut short = Vec::new();
    for &kept in &forks {
        for gone in surface.feature_neighbours(kept) {
            if forks.binary_search(&gone).is_ok()
                && !is_corner(surface, gone)
                && is_short(surface, gone, kept, thickness)
            {
                short.push((key(surface.length(gone, kept)), gone, kept));
            }
        }
    }
    short.sort_unstable();
    short
}

fn is_short(surface: &Surface, a: NodeId, b: NodeId, thickness: &dyn Fn(WallId) -> f64) -> bool {
    let ring = surface.around(a, b);
    let walls = ring.iter().map(|&t| thickness(surface.triangle(t).wall));
    !ring.is_empty() && surface.length(a, b) < NEAR * walls.fold(f64::INFINITY, f64::min)
}

fn is_corner(surface: &Surface, n: NodeId) -> bool {
    ends(&surface.supports[n]).count() > 1
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::model::complex::{MidComplex, MidNode, MidTriangle};
    use crate::stage::test_shapes::Stay;
    use glam::DVec3;

    /// A plate of four fields round an edge of length `gap`, each field a wall of its own: two forks of three creases.
    fn plate(gap: f64) -> MidComplex {
        let mut complex = MidComplex::default();
        let at = [
            (0.0, 0.0),
            (gap, 0.0),
            (-5.0, 5.0),
            (-5.0, -5.0),
            (5.0, 5.0),
            (5.0, -5.0),
        ];
        for (x, y) in at {
            complex.nodes.push(MidNode {
                point: DVec3::new(x, y, 0.0),
                supports: Default::default(),
            });
        }
        for (wall, nodes) in [
            (0, [0, 2, 3]),
            (1, [0, 1, 2]),
            (1, [1, 4, 2]),
            (2, [1, 5, 4]),
            (3, [0, 3, 1]),
            (3, [1, 3, 5]),
        ] {
            complex.triangles.push(MidTriangle {
                nodes: nodes.map(NodeId),
                wall: WallId(wall),
            });
        }
        complex
    }

    /// A plate of one wall with two bent fins on it, whose feet are joined by a node inside the plate.
    fn fins(gap: f64) -> MidComplex {
        let mut complex = MidComplex::default();
        let at = [
            (-gap, 0.0, 0.0),
            (gap, 0.0, 0.0),
            (0.0, 0.0, 0.0),
            (-5.0, -5.0, 0.0),
            (5.0, -5.0, 0.0),
            (5.0, 5.0, 0.0),
            (-5.0, 5.0, 0.0),
            (-5.0, 0.0, 0.0),
            (5.0, 0.0, 0.0),
            (-gap, 0.0, 5.0),
            (gap, 0.0, 5.0),
        ];
        for (x, y, z) in at {
            complex.nodes.push(MidNode {
                point: DVec3::new(x, y, z),
                supports: Default::default(),
            });
        }
        for (wall, nodes) in [
            (0, [0, 7, 3]),
            (0, [0, 6, 7]),
            (0, [0, 3, 2]),
            (0, [2, 3, 4]),
            (0, [2, 4, 1]),
            (0, [1, 4, 8]),
            (0, [1, 8, 5]),
            (0, [1, 5, 2]),
            (0, [2, 5, 6]),
            (0, [2, 6, 0]),
            (1, [7, 0, 9]),
            (2, [8, 1, 10]),
            (3, [0, 6, 9]),
            (4, [1, 4, 10]),
        ] {
            complex.triangles.push(MidTriangle {
                nodes: nodes.map(NodeId),
                wall: WallId(wall),
            });
        }
        complex
    }

    #[test]
    fn a_node_between_two_feet_in_one_place_goes() {
        for (gap, triangles) in [(0.1, 12), (1.0, 14)] {
            let mut surface = Surface::new(fins(gap));
            merge_forks(&mut surface, &|_| 1.0, &Stay);
            let complex = surface.finish();
            assert_eq!(complex.triangles.len(), triangles, "gap {gap}");
            assert_eq!(complex.euler(), 1);
        }
    }

    #[test]
    fn two_forks_in_one_place_become_one_and_two_apart_stay() {
        for (gap, triangles) in [(0.1, 4), (1.0, 6)] {
            let mut surface = Surface::new(plate(gap));
            merge_forks(&mut surface, &|_| 1.0, &Stay);
            let complex = surface.finish();
            assert_eq!(complex.triangles.len(), triangles);
            assert_eq!(complex.euler(), 1);
            assert!(complex.check().is_empty());
        }
    }
}
