//! Directed sizes over a patch: at its old corners an edge length for either direction of the cross field, grown from the short ones outwards, linear in between.
//!
//! Beside a bend rows stay as long along it as they are in it, while they widen: lengths grow each in its own direction.

use super::cross::Cross;
use super::surface::{Spot, Surface};
use crate::geom::placer::Lengths;
use crate::model::patch::Patch;
use glam::DVec3;
use std::cmp::Reverse;
use std::collections::BinaryHeap;

/// An edge runs along a direction of the cross within this cosine, 25 degrees.
const ALONG: f64 = 0.9;

/// The two directions of a cross with the edge lengths wanted along them.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Frame {
    /// Unit vectors at right angles.
    pub ways: [DVec3; 2],
    /// Edge length along each, mm.
    pub lengths: [f64; 2],
}

impl Frame {
    /// How long a vector is, the greater of its two parts, in wanted lengths.
    pub(super) fn measure(&self, vector: DVec3) -> f64 {
        let part = |i: usize| vector.dot(self.ways[i]).abs() / self.lengths[i];
        part(0).max(part(1))
    }

    /// Which of its directions is that one (or its reverse), the nearer of the two.
    fn which(&self, way: DVec3) -> usize {
        let [u, v] = self.ways.map(|w| w.dot(way).abs());
        usize::from(v > u)
    }
}

/// Wanted edge lengths along a cross field.
pub(super) struct Directed<'a> {
    patch: &'a Patch,
    cross: Cross,
    least: f64,
    /// #C the field's directions and the lengths along them.
    corners: Vec<Frame>,
}

impl<'a> Directed<'a> {
    /// `wanted` at every corner; `edges` are there already (corners of the patch), and where they are shorter than asked for, so are those beside them.
    /// Lengths grow by `growth`, length per length, at most. `None` where there is no length for anything.
    pub(super) fn new(
        patch: &'a Patch,
        cross: Cross,
        wanted: &[Lengths],
        edges: &[[u32; 2]],
        growth: f64,
    ) -> Option<Self> {
        let mut corners: Vec<Frame> = (wanted.iter().enumerate())
            .map(|(c, wanted)| {
                let ways = cross.ways(c);
                let lengths = ways.map(|w| match wanted.towards(w) {
                    length if length > 0.0 => length,
                    _ => f64::INFINITY,
                });
                Frame { ways, lengths }
            })
            .collect();
        let raw: Vec<[f64; 2]> = corners.iter().map(|f| f.lengths).collect();
        for &[a, b] in edges {
            let step = patch.points[b as usize] - patch.points[a as usize];
            for c in [a, b] {
                let frame = &mut corners[c as usize];
                let k = frame.which(step);
                // Beside an edge the ratio stays that is wanted there; at a slant to it there is none.
                let ratio = raw[c as usize][1 - k] / raw[c as usize][k];
                let slant = frame.ways[k].dot(step).abs() < ALONG * step.length();
                let ratio = if slant || !ratio.is_finite() {
                    1.0
                } else {
                    ratio
                };
                for (i, length) in [(k, step.length()), (1 - k, step.length() * ratio)] {
                    frame.lengths[i] = frame.lengths[i].min(length);
                }
            }
        }
        grow(patch, &mut corners, growth);
        let known = corners
            .iter()
            .all(|f| f.lengths.iter().all(|l| l.is_finite()));
        known.then_some(Self {
            patch,
            cross,
            least: (corners.iter().flat_map(|f| f.lengths)).fold(f64::INFINITY, f64::min),
            corners,
        })
    }

    /// The directions and lengths at a spot.
    pub(super) fn at(&self, surface: &Surface, spot: &Spot) -> Frame {
        let along = self.cross.at(surface, spot);
        let across = surface.flat_normal(spot.triangle).cross(along);
        let ways = [along, across];
        let mut lengths = [0.0; 2];
        let corners = self.patch.triangles[spot.triangle as usize];
        for (&c, weight) in corners.iter().zip(spot.weights) {
            let corner = &self.corners[c as usize];
            let k = corner.which(along);
            lengths[0] += corner.lengths[k] * weight;
            lengths[1] += corner.lengths[1 - k] * weight;
        }
        Frame {
            ways,
            lengths: lengths.map(|l| surface.snap.value(l)),
        }
    }

    /// The least length anywhere, mm.
    pub(super) fn least(&self) -> f64 {
        self.least
    }

    /// How many squares an old triangle holds, by the mean lengths of its corners.
    pub(super) fn count(&self, triangle: [u32; 3], area: f64) -> f64 {
        let square = |c: u32| self.corners[c as usize].lengths.iter().product::<f64>();
        3.0 * area / triangle.map(square).iter().sum::<f64>()
    }
}

/// Lets the short lengths spread: Dijkstra over corners and directions.
fn grow(patch: &Patch, corners: &mut [Frame], growth: f64) {
    let mut near: Vec<Vec<u32>> = vec![Vec::new(); corners.len()];
    for t in &patch.triangles {
        for k in 0..3 {
            near[t[k] as usize].extend([t[(k + 1) % 3], t[(k + 2) % 3]]);
        }
    }
    // Lengths are positive, so that their bits have their order.
    let mut heap: BinaryHeap<Reverse<(u64, u32, usize)>> = (corners.iter().zip(0..))
        .flat_map(|(f, c)| [(f.lengths[0], c, 0), (f.lengths[1], c, 1)])
        .filter(|(l, ..)| l.is_finite())
        .map(|(l, c, k)| Reverse((l.to_bits(), c, k)))
        .collect();
    while let Some(Reverse((bits, c, k))) = heap.pop() {
        let from = corners[c as usize];
        if bits != from.lengths[k].to_bits() {
            continue;
        }
        for &d in &near[c as usize] {
            let length = patch.points[c as usize].distance(patch.points[d as usize]);
            let most = from.lengths[k] + growth * length;
            let to = &mut corners[d as usize];
            let j = to.which(from.ways[k]);
            if most < to.lengths[j] {
                to.lengths[j] = most;
                heap.push(Reverse((most.to_bits(), d, j)));
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::model::ids::PatchId;
    use crate::model::patch::Chart;
    use crate::stage::flatten::flatten;
    use crate::stage::patch::patches;
    use crate::stage::test_shapes as shapes;

    /// A plate of 20 by 10, with squares of side 1.
    fn plate() -> (Patch, Chart) {
        let complex = shapes::sheet(20, 10, |u, v| DVec3::new(20.0 * u, 10.0 * v, 0.0));
        let patch = patches(&complex)[PatchId(0)].clone();
        let chart = flatten(&patch).unwrap();
        (patch, chart)
    }

    /// What a field wants at every corner.
    fn all(patch: &Patch, field: impl Fn(DVec3) -> Lengths) -> Vec<Lengths> {
        patch.points.iter().map(|&p| field(p)).collect()
    }

    /// Frames at the corners: lengths along x and along y.
    fn lengths(directed: &Directed, x: f64) -> Vec<[f64; 2]> {
        let at = |(f, p): (&Frame, &DVec3)| {
            let k = f.which(DVec3::X);
            ((p.x - x).abs() < 1e-9).then(|| [f.lengths[k], f.lengths[1 - k]])
        };
        let all = directed.corners.iter().zip(&directed.patch.points);
        all.filter_map(at).collect()
    }

    #[test]
    fn each_length_grows_in_its_own_direction() {
        let (patch, chart) = plate();
        let surface = Surface::new(&patch, &chart);
        let edges: Vec<[u32; 2]> = patch.boundary().collect();
        let cross = Cross::new(&surface, &edges, &[]).unwrap();
        // A bend along y at x = 0.
        let field = |p: DVec3| {
            if p.x > 0.5 {
                return Lengths::equal(2.0);
            }
            Lengths {
                axis: DVec3::Y,
                along: 1.6,
                across: 0.4,
            }
        };
        let directed = Directed::new(&patch, cross, &all(&patch, field), &[], 0.25).unwrap();
        for i in 0..=20 {
            let x = f64::from(i);
            let wanted = [0.4, 1.6].map(|l| (l + 0.25 * x).min(2.0));
            for found in lengths(&directed, x) {
                for k in 0..2 {
                    assert!((found[k] - wanted[k]).abs() < 1e-9, "{x}: {found:?}");
                }
            }
        }
        let spot = surface.locate(chart.places[0]).unwrap();
        let frame = directed.at(&surface, &spot);
        let diagonal = frame.measure(patch.points[0] + DVec3::new(0.4, 0.8, 0.0) - patch.points[0]);
        assert!(diagonal > 0.0 && frame.ways[0].dot(frame.ways[1]).abs() < 1e-12);
    }

    #[test]
    fn short_edges_on_the_boundary_make_short_ones_beside_them() {
        let (patch, chart) = plate();
        let surface = Surface::new(&patch, &chart);
        let edges: Vec<[u32; 2]> = patch.boundary().collect();
        let cross = Cross::new(&surface, &edges, &[]).unwrap();
        // The boundary's edges are 1 long.
        let directed = Directed::new(
            &patch,
            cross.clone(),
            &all(&patch, |_| Lengths::equal(3.0)),
            &edges,
            0.25,
        )
        .unwrap();
        for found in lengths(&directed, 10.0) {
            assert!(found.iter().all(|l| *l >= 1.0 - 1e-9 && *l <= 2.25 + 1e-9));
        }
        assert!((lengths(&directed, 0.0)[0][0] - 1.0).abs() < 1e-9);
        // Where lengths along y may be four times those along x, beside the rims along x they are.
        let long = |_: DVec3| Lengths {
            axis: DVec3::Y,
            along: 8.0,
            across: 2.0,
        };
        let directed = Directed::new(&patch, cross, &all(&patch, long), &edges, 1e9).unwrap();
        let rim = lengths(&directed, 10.0);
        assert!(
            rim.iter()
                .any(|l| (l[0] - 1.0).abs() < 1e-9 && (l[1] - 4.0).abs() < 1e-9)
        );
    }

    #[test]
    fn without_any_length_there_is_none() {
        let (patch, chart) = plate();
        let surface = Surface::new(&patch, &chart);
        let cross = Cross::new(&surface, &[], &[]).unwrap();
        assert!(
            Directed::new(
                &patch,
                cross,
                &all(&patch, |_| Lengths::equal(f64::NAN)),
                &[],
                0.25
            )
            .is_none()
        );
    }
}
