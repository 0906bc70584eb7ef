//! Takes away triangles without area.
//!
//! A sheet whose nodes lie on one line has no width: two strands of a junction that were placed on each other, a strip between walls in one plane, a sheet folded onto
//! its own border. No move of its nodes gives it an area, and refinement only makes more of the kind. Two steps take such triangles away whatever they belong to: an
//! edge without length is contracted (`dust`), and a cap, whose apex lies on its longest side, goes by splitting that side where the apex lies and
//! making one node of the two. Inside a sheet the second step is an edge flip; on curves it makes one curve of two.
//!
//! Guarantees: the homotopy type stays (link condition), so does the number of pieces; no node moves, and no side by more than the threshold.
//! Exceptions: where the link condition forbids a step the triangle stays. Cost: near-linear in the triangles that go.

use super::dust::{ONE_PLACE, cuts_off, join_supports, merge_coincident};
use super::shape::area_vector;
use super::surface::{Class, Surface, key};
use crate::geom::placer::Placer;
use crate::model::complex::MidComplex;
use crate::model::disjoint::Disjoint;
use crate::model::ids::{NodeId, TriangleId};
use std::collections::BinaryHeap;

/// Rounds of contracting edges and taking caps; either makes work for the other.
const ROUNDS: usize = 8;
/// Steps for each triangle that is flat at the start: a pile of flat triangles needs some for each layer, more than this would be a circle.
const STEPS: usize = 20;

/// A complex without the triangles that have no area, as far as they can go.
pub fn without_flat(complex: MidComplex, placer: &dyn Placer) -> MidComplex {
    let mut surface = Surface::new(complex);
    remove_flat(&mut surface, placer);
    surface.finish()
}

/// Takes away all triangles without area that can go.
pub(super) fn remove_flat(surface: &mut Surface, placer: &dyn Placer) {
    for _ in 0..ROUNDS {
        merge_coincident(surface, placer);
        if take_caps(surface, placer) == 0 {
            break;
        }
    }
}

/// Takes caps, that of the longest side first: so no side that went comes back, and a pile of flat triangles comes to an end. How many.
fn take_caps(surface: &mut Surface, placer: &dyn Placer) -> usize {
    let mut heap: BinaryHeap<(u64, TriangleId)> = (surface.live_triangles())
        .filter_map(|t| Some((cap(surface, t, placer)?.length, t)))
        .collect();
    let mut left = STEPS * heap.len();
    let mut taken = 0;
    while let Some((length, t)) = heap.pop() {
        let Some(flat) = cap(surface, t, placer).filter(|c| c.length == length) else {
            continue;
        };
        if left == 0 {
            break;
        }
        left -= 1;
        let Some(touched) = take(surface, &flat, placer) else {
            continue;
        };
        taken += 1;
        for t in touched {
            heap.extend(cap(surface, t, placer).map(|c| (c.length, t)));
        }
    }
    taken
}

/// A triangle whose apex lies on its longest side.
struct Cap {
    side: [NodeId; 2],
    apex: NodeId,
    /// Key of the side's length.
    length: u64,
}

fn cap(surface: &Surface, t: TriangleId, placer: &dyn Placer) -> Option<Cap> {
    if !surface.lives(t) {
        return None;
    }
    let triangle = surface.triangle(t);
    let nodes = triangle.nodes;
    let (longest, side) = [0, 1, 2]
        .map(|k| [nodes[k], nodes[(k + 1) % 3]])
        .into_iter()
        .map(|e| (surface.length(e[0], e[1]), e))
        .max_by(|x, y| x.0.total_cmp(&y.0))?;
    let height = area_vector(surface.corners(t)).length() / longest;
    // The first test spares most triangles the query.
    if height.is_nan() || height > ONE_PLACE * longest {
        return None;
    }
    let thickness = placer.thickness(surface.points[side[0]], triangle.wall);
    let flat = thickness.is_none_or(|thickness| height <= ONE_PLACE * thickness.abs());
    flat.then(|| Cap {
        side,
        apex: surface.apex(t, side[0], side[1]),
        length: key(longest),
    })
}

/// Splits the side at the apex; the triangles that this made, or `None` where it may not be.
fn take(surface: &mut Surface, cap: &Cap, placer: &dyn Placer) -> Option<Vec<TriangleId>> {
    let ([a, b], c) = (cap.side, cap.apex);
    let ring = surface.around(a, b);
    let others = ring
        .iter()
        .map(|&t| surface.apex(t, a, b))
        .filter(|&d| d != c);
    // With an edge from the apex to another one, two edges would fall together.
    if others.into_iter().any(|d| !surface.around(c, d).is_empty()) {
        for n in [a, b] {
            // A node that the two triangles and one more go all round is not needed.
            if surface.star(n).len() == 3
                && surface.neighbours(n).len() == 3
                && super::contract::keeps_homotopy(surface, n, c)
                && !cuts_off(surface, n, c)
            {
                surface.contract(n, c);
                return Some(surface.star(c).to_vec());
            }
        }
        return None;
    }
    // On a rim the cap goes without a rest: it may be all that holds its two neighbours together.
    if ring.len() == 1 && hinges(surface, c, ring[0]) {
        return None;
    }
    let supports = surface.supports[a]
        .iter()
        .filter(|s| surface.supports[b].contains(s))
        .copied()
        .collect();
    let m = surface.split([a, b], surface.points[c], supports, Class::Corner);
    join_supports(surface, m, c, placer);
    surface.contract(m, c);
    Some(surface.star(c).to_vec())
}

/// Whether the triangles at a node hang together by edges only as long as `t` is one of them.
fn hinges(surface: &Surface, n: NodeId, t: TriangleId) -> bool {
    let outer = surface.neighbours(n);
    let mut link = Disjoint::new(outer.len());
    let mut left = Disjoint::new(outer.len());
    for &s in surface.star(n) {
        let ends = surface.triangle(s).nodes.map(|m| outer.binary_search(&m));
        if let [Ok(a), Ok(b), _] | [Ok(a), _, Ok(b)] | [_, Ok(a), Ok(b)] = ends {
            link.join(a as u32, b as u32);
            if s != t {
                left.join(a as u32, b as u32);
            }
        }
    }
    left.sets() > link.sets()
}
