//! Makes one node of two in one place.
//!
//! Where curves meet, two nodes of theirs may be placed in the same point: the triangles between them have no area, and since both are corners no rule of
//! remeshing may take either. Their edge is contracted, whatever they are.
//!
//! Guarantee: the homotopy type stays (link condition), and no sheet that hangs on by such an edge alone is cut off. Nothing moves by more than the threshold.

use super::contract::keeps_homotopy;
use super::surface::{Surface, key};
use crate::geom::placer::Placer;
use crate::model::disjoint::Disjoint;
use crate::model::ids::NodeId;
use rayon::prelude::*;

/// Nodes nearer than this share of the thickness are in one place: a hundred times what placing leaves of a distance, and far below what is drawn.
pub(super) const ONE_PLACE: f64 = 0.005;
/// The supports of both are kept where placing on all of them moves the node by less than this share of the thickness.
const AGREE: f64 = 0.05;

/// Contracts all edges without length, the shortest first.
pub(super) fn merge_coincident(surface: &mut Surface, placer: &dyn Placer) {
    loop {
        let mut merged = false;
        let mut short: Vec<(u64, NodeId, NodeId)> = surface
            .edges()
            .into_par_iter()
            .filter(|&[a, b]| is_dust(surface, a, b, placer))
            .map(|[a, b]| (key(surface.length(a, b)), a, b))
            .collect();
        short.sort_unstable();
        for (_, a, b) in short {
            // The one on more supports stays.
            let (gone, kept) = if surface.supports[a].len() > surface.supports[b].len() {
                (b, a)
            } else {
                (a, b)
            };
            if is_dust(surface, gone, kept, placer) && keeps_together(surface, gone, kept) {
                merge(surface, gone, kept, placer);
                merged = true;
            }
        }
        if !merged {
            break;
        }
    }
}

fn is_dust(surface: &Surface, a: NodeId, b: NodeId, placer: &dyn Placer) -> bool {
    let length = surface.length(a, b);
    let ring = surface.around(a, b);
    ring.first().is_some_and(|&t| {
        // Most edges are longer than any wall is thick at this threshold: their own triangle says so without a query.
        let [p, q, r] = surface.corners(t);
        let longest = p.distance(q).max(q.distance(r)).max(r.distance(p));
        length <= ONE_PLACE * longest
            && placer
                .thickness(p, surface.triangle(t).wall)
                .is_none_or(|thickness| length <= ONE_PLACE * thickness.abs())
    })
}

/// Whether the two nodes may become one: the homotopy type stays, and sheets hang together by edges as before.
pub(super) fn keeps_together(surface: &Surface, gone: NodeId, kept: NodeId) -> bool {
    keeps_homotopy(surface, gone, kept) && !cuts_off(surface, gone, kept)
}

/// Whether the triangles round the node that the two become would no longer hang together by edges.
fn cuts_off(surface: &Surface, gone: NodeId, kept: NodeId) -> bool {
    let mut outer = surface.neighbours(gone);
    outer.extend(surface.neighbours(kept));
    outer.retain(|n| *n != gone && *n != kept);
    outer.sort_unstable();
    outer.dedup();
    let mut link = Disjoint::new(outer.len());
    for &t in surface.star(gone).iter().chain(surface.star(kept)) {
        let ends = surface.triangle(t).nodes.map(|n| outer.binary_search(&n));
        // Triangles at the edge that goes have one outer node.
        if let [Ok(a), Ok(b), _] | [Ok(a), _, Ok(b)] | [_, Ok(a), Ok(b)] = ends {
            link.join(a as u32, b as u32);
        }
    }
    link.sets() > 1
}

fn merge(surface: &mut Surface, gone: NodeId, kept: NodeId, placer: &dyn Placer) {
    join_supports(surface, gone, kept, placer);
    surface.contract(gone, kept);
}

/// Puts a node onto the supports of another one in the same place as well, where that leaves it there.
pub(super) fn join_supports(
    surface: &mut Surface,
    gone: NodeId,
    kept: NodeId,
    placer: &dyn Placer,
) {
    let mut supports = surface.supports[kept].clone();
    supports.extend_from_slice(&surface.supports[gone]);
    supports.sort_unstable();
    supports.dedup();
    if supports == surface.supports[kept] {
        return;
    }
    let (p, wall) = (
        surface.points[kept],
        surface
            .star(kept)
            .first()
            .map(|&t| surface.triangle(t).wall),
    );
    let thickness = wall.and_then(|w| placer.thickness(p, w)).unwrap_or(0.0);
    if placer.place(p, &supports).distance(p) <= AGREE * thickness.abs() {
        surface.supports[kept] = supports;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::model::complex::{MidComplex, MidNode, MidTriangle};
    use crate::model::ids::WallId;
    use crate::stage::test_shapes::Stay;
    use glam::DVec3;

    /// Three fins on one upright edge whose middle node stands twice, `gap` apart.
    fn fins(gap: f64) -> MidComplex {
        let mut complex = MidComplex::default();
        for z in [0.0, 5.0, 5.0 + gap, 10.0] {
            complex.nodes.push(MidNode {
                point: DVec3::new(0.0, 0.0, z),
                supports: Default::default(),
            });
        }
        for (wall, turn) in [0.0, 2.0, 4.0].into_iter().enumerate() {
            let tip = complex.nodes.push(MidNode {
                point: DVec3::new(8.0 * f64::cos(turn), 8.0 * f64::sin(turn), 5.0),
                supports: Default::default(),
            });
            for k in 0..3 {
                complex.triangles.push(MidTriangle {
                    nodes: [NodeId(k), NodeId(k + 1), tip],
                    wall: WallId(wall as u32),
                });
            }
        }
        complex
    }

    #[test]
    fn a_sheet_that_hangs_on_by_the_edge_alone_keeps_it() {
        let mut complex = fins(0.0);
        // A triangle of its own on the edge that has no length.
        let tip = complex.nodes.push(MidNode {
            point: DVec3::new(1.0, 1.0, 5.0),
            supports: Default::default(),
        });
        complex.triangles.push(MidTriangle {
            nodes: [NodeId(1), NodeId(2), tip],
            wall: WallId(3),
        });
        let mut surface = Surface::new(complex.clone());
        merge_coincident(&mut surface, &Stay);
        assert_eq!(surface.finish(), complex);
    }

    #[test]
    fn an_edge_without_length_goes_even_on_a_junction_and_a_short_one_stays() {
        for (gap, triangles) in [(0.0, 6), (0.1, 9)] {
            let mut surface = Surface::new(fins(gap));
            merge_coincident(&mut surface, &Stay);
            let complex = surface.finish();
            assert_eq!(complex.triangles.len(), triangles, "gap {gap}");
            assert_eq!(complex.euler(), 1);
            assert!(complex.check().is_empty());
        }
    }
}
