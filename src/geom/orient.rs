//! Winds the triangles of each sheet one way, and to the side that the wall's normal points to.

use super::placer::Placer;
use crate::model::complex::{EdgeKind, MidComplex};
use crate::model::ids::{IndexVec, TriangleId};
use glam::DVec3;
use rayon::prelude::*;
use smallvec::SmallVec;
use std::collections::VecDeque;

/// Winds each piece of sheet (triangles joined over inner edges) consistently. The side is that of the wall's normal by area, or, where
/// the wall has none, the one that most of the area had before. A one-sided sheet (a Moebius strip) keeps a seam.
pub fn orient(complex: &mut MidComplex, placer: &dyn Placer) {
    let beside = neighbours(complex);
    let areas: IndexVec<TriangleId, (DVec3, Option<DVec3>)> = complex
        .triangles
        .as_slice()
        .par_iter()
        .map(|t| {
            let [a, b, c] = complex.corners(t);
            (
                complex.area_vector(t),
                placer.normal((a + b + c) / 3.0, t.wall),
            )
        })
        .collect::<Vec<_>>()
        .into();
    let mut turned: IndexVec<TriangleId, Option<bool>> = IndexVec::filled(None, areas.len());
    for first in areas.ids() {
        if turned[first].is_some() {
            continue;
        }
        turned[first] = Some(false);
        let mut sheet = Vec::new();
        let mut queue = VecDeque::from([(first, false)]);
        let (mut by_normal, mut by_area) = (0.0, 0.0);
        while let Some((t, turn)) = queue.pop_front() {
            sheet.push(t);
            let sign = if turn { -1.0 } else { 1.0 };
            by_area += sign * areas[t].0.length();
            by_normal += areas[t].1.map_or(0.0, |n| sign * areas[t].0.dot(n));
            for &(next, same) in &beside[t] {
                if turned[next].is_none() {
                    turned[next] = Some(turn != same);
                    queue.push_back((next, turn != same));
                }
            }
        }
        let over = if by_normal != 0.0 {
            by_normal < 0.0
        } else {
            by_area < 0.0
        };
        for t in sheet {
            if turned[t].unwrap_or(false) != over {
                complex.triangles[t].nodes.swap(1, 2);
            }
        }
    }
}

/// For each triangle its neighbours over inner edges, and whether the two run the shared edge the same way (one must turn).
fn neighbours(complex: &MidComplex) -> IndexVec<TriangleId, SmallVec<[(TriangleId, bool); 3]>> {
    let mut beside: IndexVec<TriangleId, SmallVec<[(TriangleId, bool); 3]>> =
        IndexVec::filled(SmallVec::new(), complex.triangles.len());
    for edge in complex.edges() {
        if complex.kind(&edge) != EdgeKind::Inner {
            continue;
        }
        let (s, t) = (edge.triangles[0], edge.triangles[1]);
        let runs = |t: TriangleId| complex.triangles[t].runs(edge.ends);
        let same = runs(s) == runs(t);
        beside[s].push((t, same));
        beside[t].push((s, same));
    }
    beside
}

/// Whether every piece of sheet can be wound one way. Cost: linear in the triangles, but for sorting their edges.
pub fn two_sided(complex: &MidComplex) -> bool {
    let beside = neighbours(complex);
    let mut turned: IndexVec<TriangleId, Option<bool>> =
        IndexVec::filled(None, complex.triangles.len());
    let mut queue = VecDeque::new();
    for first in complex.triangles.ids() {
        if turned[first].is_some() {
            continue;
        }
        turned[first] = Some(false);
        queue.push_back((first, false));
        while let Some((t, turn)) = queue.pop_front() {
            for &(next, same) in &beside[t] {
                match turned[next] {
                    None => {
                        turned[next] = Some(turn != same);
                        queue.push_back((next, turn != same));
                    }
                    Some(found) if found != (turn != same) => return false,
                    Some(_) => {}
                }
            }
        }
    }
    true
}

/// Triangles that lie against all their neighbours in the sheet taken together: folded over, whatever the wall's normal is there. The sheets have to be wound
/// one way.
pub fn folded(complex: &MidComplex) -> Vec<TriangleId> {
    let area = |t: TriangleId| complex.area_vector(&complex.triangles[t]);
    let mut around = IndexVec::filled(DVec3::ZERO, complex.triangles.len());
    for edge in complex.edges() {
        if complex.kind(&edge) == EdgeKind::Inner {
            let (s, t) = (edge.triangles[0], edge.triangles[1]);
            around[s] += area(t);
            around[t] += area(s);
        }
    }
    (complex.triangles.ids())
        .filter(|&t| around[t].dot(area(t)) < 0.0)
        .collect()
}

/// Those of the triangles whose normal is turned from their wall's, in the same order.
pub fn turned(
    complex: &MidComplex,
    triangles: &[TriangleId],
    placer: &dyn Placer,
) -> Vec<TriangleId> {
    triangles
        .par_iter()
        .copied()
        .filter(|&t| {
            let triangle = &complex.triangles[t];
            let [a, b, c] = complex.corners(triangle);
            placer
                .normal((a + b + c) / 3.0, triangle.wall)
                .is_some_and(|n| complex.area_vector(triangle).dot(n) < 0.0)
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::model::complex::{MidNode, MidTriangle};
    use crate::model::ids::{NodeId, WallId};

    /// A fan of six triangles whose hub lies at `x`; the ring has radius 1.
    fn fan(x: f64) -> MidComplex {
        let mut complex = MidComplex::default();
        let mut node = |x: f64, y: f64| {
            complex.nodes.push(MidNode {
                point: DVec3::new(x, y, 0.0),
                supports: Default::default(),
            });
        };
        node(x, 0.0);
        for k in 0..6 {
            let (sin, cos) = (f64::from(k) * std::f64::consts::FRAC_PI_3 + 0.5).sin_cos();
            node(cos, sin);
        }
        for k in 0..6u32 {
            complex.triangles.push(MidTriangle {
                nodes: [0, k + 1, (k + 1) % 6 + 1].map(NodeId),
                wall: WallId(0),
            });
        }
        complex
    }

    #[test]
    fn a_triangle_behind_the_hub_is_folded_over_and_none_in_a_star() {
        assert!(folded(&fan(0.3)).is_empty());
        // Beyond the ring the triangle of the edge that was passed lies the other way round.
        let passed = folded(&fan(1.2));
        assert_eq!(passed.len(), 1, "{passed:?}");
    }

    /// A ring of so many quads, each as two triangles; its ends joined straight or turned over.
    fn ring(quads: u32, over: bool) -> MidComplex {
        let mut complex = MidComplex::default();
        for k in 0..quads {
            let (sin, cos) = (f64::from(k) * std::f64::consts::TAU / f64::from(quads)).sin_cos();
            for z in [0.0, 1.0] {
                complex.nodes.push(MidNode {
                    point: DVec3::new(cos, sin, z),
                    supports: Default::default(),
                });
            }
        }
        for k in 0..quads {
            let [a, b] = [2 * k, 2 * k + 1];
            let [mut c, mut d] = [2 * ((k + 1) % quads), 2 * ((k + 1) % quads) + 1];
            if over && k + 1 == quads {
                (c, d) = (d, c);
            }
            for nodes in [[a, c, d], [a, d, b]] {
                complex.triangles.push(MidTriangle {
                    nodes: nodes.map(NodeId),
                    wall: WallId(0),
                });
            }
        }
        complex
    }

    #[test]
    fn a_ring_has_two_sides_and_a_moebius_band_has_one() {
        assert!(two_sided(&ring(8, false)));
        assert!(!two_sided(&ring(8, true)));
        let mut wound_at_random = ring(8, false);
        wound_at_random.triangles[TriangleId(3)].nodes.swap(0, 1);
        assert!(two_sided(&wound_at_random));
    }
}
