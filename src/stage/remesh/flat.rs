//! Takes away triangles without area.
//!
//! A sheet whose nodes lie on one line has no width: two strands of a junction that were placed on each other, a strip between walls in one plane, a sheet folded onto
//! its own border. No move of its nodes gives it an area, and refinement only makes more of the kind. Two steps take such triangles away whatever they belong to: an
//! edge without length is contracted (`dust`), and a cap, whose apex lies on its longest side, goes by splitting that side where the apex lies and
//! making one node of the two. Inside a sheet the second step is an edge flip; on curves it makes one curve of two.
//!
//! Guarantees: the homotopy type stays (link condition), so does the number of pieces; no node moves, and no side by more than the threshold.
//! Exceptions: where the link condition forbids a step the triangle stays. Cost: near-linear in the triangles that go.

use super::dust::{ONE_PLACE, join_supports, keeps_together, merge_coincident};
use super::shape::area_vector;
use super::surface::{Class, Surface, key};
use crate::geom::placer::Placer;
use crate::model::complex::MidComplex;
use crate::model::disjoint::Disjoint;
use crate::model::ids::{NodeId, TriangleId};
use rayon::prelude::*;
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
    let all: Vec<TriangleId> = surface.live_triangles().collect();
    let caps: Vec<(u64, TriangleId)> = (all.par_iter())
        .filter_map(|&t| Some((cap(surface, t, placer)?.length, t)))
        .collect();
    let mut heap = BinaryHeap::from(caps);
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
                && keeps_together(surface, n, c)
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
pub(super) fn hinges(surface: &Surface, n: NodeId, t: TriangleId) -> bool {
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::model::complex::{MidNode, MidTriangle};
    use crate::model::ids::WallId;
    use crate::stage::test_shapes::Stay;
    use glam::DVec3;

    fn complex(points: &[(f64, f64, f64)], triangles: &[(u32, [u32; 3])]) -> MidComplex {
        let mut complex = MidComplex::default();
        for &(x, y, z) in points {
            complex.nodes.push(MidNode {
                point: DVec3::new(x, y, z),
                supports: Default::default(),
            });
        }
        for &(wall, nodes) in triangles {
            complex.triangles.push(MidTriangle {
                nodes: nodes.map(NodeId),
                wall: WallId(wall),
            });
        }
        complex
    }

    fn flat(complex: &MidComplex) -> usize {
        let area = |t: &MidTriangle| area_vector(t.nodes.map(|n| complex.nodes[n].point)).length();
        complex.triangles.iter().filter(|t| area(t) < 1e-6).count()
    }

    /// A square over the long side of a triangle of this height, which has two triangles on its short sides.
    fn with_cap(height: f64) -> MidComplex {
        complex(
            &[
                (0.0, 0.0, 0.0),
                (2.0, 0.0, 0.0),
                (1.0, height, 0.0),
                (1.0, -1.0, 0.0),
                (1.0, 1.0, 0.0),
            ],
            &[
                (0, [0, 1, 2]),
                (0, [1, 0, 3]),
                (0, [0, 2, 4]),
                (0, [2, 1, 4]),
            ],
        )
    }

    #[test]
    fn a_cap_inside_a_sheet_goes_and_one_with_height_stays() {
        let after = without_flat(with_cap(0.0), &Stay);
        assert_eq!(
            (after.triangles.len(), flat(&after), after.euler()),
            (4, 0, 1)
        );
        assert!(after.check().is_empty());
        assert_eq!(without_flat(with_cap(0.1), &Stay), with_cap(0.1));
    }

    #[test]
    fn two_strands_of_one_junction_become_one() {
        // Nodes of either strand stand between those of the other; the strip between them, wall 2, has no width.
        let (even, odd): (Vec<u32>, Vec<u32>) = ((0..6).collect(), (6..12).collect());
        let mut points: Vec<(f64, f64, f64)> = Vec::new();
        points.extend((0..6).map(|i| (f64::from(i), 0.0, 0.0)));
        points.extend((0..6).map(|i| (f64::from(i) + 0.4, 0.0, 0.0)));
        let mut triangles: Vec<(u32, [u32; 3])> = Vec::new();
        for i in 0..5 {
            triangles.push((2, [even[i], even[i + 1], odd[i]]));
            triangles.push((2, [odd[i], even[i + 1], odd[i + 1]]));
        }
        for (wall, strand, y, z) in [
            (0, &even, 5.0, 0.0),
            (1, &even, 0.0, 5.0),
            (3, &odd, -5.0, 0.0),
            (4, &odd, 0.0, -5.0),
        ] {
            let tip = points.len() as u32;
            points.push((2.5, y, z));
            for w in strand.windows(2) {
                triangles.push((wall, [w[0], w[1], tip]));
            }
        }
        let before = complex(&points, &triangles);
        assert_eq!(flat(&before), 10);
        let after = without_flat(before.clone(), &Stay);
        assert_eq!(flat(&after), 0);
        assert_eq!((after.euler(), after.pieces()), (before.euler(), 1));
        assert!(after.triangles.iter().all(|t| t.wall != WallId(2)));
        let four = after
            .edges()
            .iter()
            .filter(|e| e.triangles.len() == 4)
            .count();
        assert_eq!(
            four, 9,
            "between the nine nodes that both strands reach past"
        );
        assert!(after.check().is_empty());
    }

    #[test]
    fn a_cap_that_alone_holds_two_sheets_together_stays() {
        let before = complex(
            &[
                (0.0, 0.0, 0.0),
                (2.0, 0.0, 0.0),
                (1.0, 0.0, 0.0),
                (0.5, 1.0, 0.0),
                (1.5, 1.0, 0.0),
            ],
            &[(0, [0, 1, 2]), (0, [0, 2, 3]), (0, [2, 1, 4])],
        );
        assert_eq!(without_flat(before.clone(), &Stay), before);
    }

    #[test]
    fn a_pile_of_flat_triangles_comes_to_an_end() {
        // Two caps whose apexes lie past each other: flipped the wrong way round they would go in a circle.
        let before = complex(
            &[
                (0.0, 0.0, 0.0),
                (2.0, 0.0, 0.0),
                (1.0, 0.0, 0.0),
                (3.0, 0.0, 0.0),
                (1.5, 3.0, 0.0),
                (1.5, -3.0, 0.0),
            ],
            &[
                (0, [0, 1, 2]),
                (0, [1, 0, 3]),
                (0, [0, 2, 4]),
                (0, [2, 1, 4]),
                (0, [1, 3, 4]),
                (0, [3, 0, 5]),
            ],
        );
        let after = without_flat(before.clone(), &Stay);
        assert_eq!(
            (flat(&after), after.euler(), after.pieces()),
            (0, before.euler(), 1)
        );
    }
}
