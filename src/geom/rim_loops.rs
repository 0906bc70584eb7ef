//! Closed rims: the free edges round holes and round whole sheets, and whether what they lie on leaves them open.
//!
//! A rim inside a lump may be given surfaces that meet in one line, or in none: the wall that is carried on to it stands across the hole's own wall, or beside it. Put onto them, a
//! ring of nodes runs to and fro along that line, and the hole is shut: its triangles have no area.

use super::placer::Placer;
use crate::model::complex::{MidComplex, Support, Supports};
use crate::model::ids::{Id, IndexVec, NodeId};
use glam::DVec3;
use nalgebra::{Matrix3, SymmetricEigen};
use smallvec::SmallVec;

/// A rim is shut where it is slenderer than it was by this factor: one that lands on its hole's wall may become smaller, but not slender.
const SHUT: f64 = 0.25;

/// All rims that are simple rings: their nodes in order, each ring from its first node, in the order of these.
pub fn closed_rims(complex: &MidComplex) -> Vec<Vec<NodeId>> {
    let edges = complex.edges();
    let free = edges.iter().filter(|e| e.triangles.len() == 1);
    rings_of(complex.nodes.len(), free.map(|e| e.ends))
}

/// The simple rings among edges of `count` nodes: their nodes in order, each ring from its first node, in the order of these.
pub fn rings_of(count: usize, edges: impl IntoIterator<Item = [NodeId; 2]>) -> Vec<Vec<NodeId>> {
    let mut beside: IndexVec<NodeId, SmallVec<[NodeId; 2]>> =
        IndexVec::filled(SmallVec::new(), count);
    for [a, b] in edges {
        beside[a].push(b);
        beside[b].push(a);
    }
    let mut seen: IndexVec<NodeId, bool> = IndexVec::filled(false, count);
    let mut rings = Vec::new();
    for first in (0..count).map(NodeId::new) {
        if seen[first] || beside[first].len() != 2 {
            continue;
        }
        let mut ring = vec![first];
        let (mut before, mut at) = (first, beside[first][0]);
        while at != first && beside[at].len() == 2 {
            ring.push(at);
            let next = if beside[at][0] == before {
                beside[at][1]
            } else {
                beside[at][0]
            };
            (before, at) = (at, next);
        }
        for &n in &ring {
            seen[n] = true;
        }
        if at == first {
            rings.push(ring);
        }
    }
    rings
}

/// Middle of a ring and its root mean square breadths along its first and its second principal axis, mm; sides count by their length.
pub fn breadths(ring: &[DVec3]) -> (DVec3, [f64; 2]) {
    let sides = || {
        let next = ring.iter().cycle().skip(1);
        let sides = ring.iter().zip(next);
        sides.map(|(a, b)| ((*a + *b) / 2.0, a.distance(*b)))
    };
    let length: f64 = sides().map(|(_, l)| l).sum();
    if length.is_nan() || length <= 0.0 {
        return (ring.first().copied().unwrap_or_default(), [0.0; 2]);
    }
    let middle = sides().map(|(m, l)| m * l).sum::<DVec3>() / length;
    let mut spread = Matrix3::zeros();
    for (m, l) in sides() {
        let d = (m - middle).to_array();
        spread += Matrix3::from_fn(|i, j| d[i] * d[j] * l / length);
    }
    let eigen = SymmetricEigen::new(spread);
    let mut along = eigen.eigenvalues.as_slice().to_vec();
    along.sort_unstable_by(|a, b| b.total_cmp(a));
    (middle, [along[0], along[1]].map(|x| x.max(0.0).sqrt()))
}

/// The second breadth over the first: one for a circle, zero for a ring on a line or in a point.
fn slenderness(ring: &[DVec3]) -> f64 {
    let (_, [long, short]) = breadths(ring);
    if long > 0.0 { short / long } else { 0.0 }
}

/// Takes from the nodes of each closed rim that is shut now, and was open with the nodes at `before`, the one support that shuts it, and puts them from there onto the others.
pub fn open_shut(complex: &mut MidComplex, before: &IndexVec<NodeId, DVec3>, placer: &dyn Placer) {
    for ring in closed_rims(complex) {
        let then: Vec<DVec3> = ring.iter().map(|&n| before[n]).collect();
        let now: Vec<DVec3> = ring.iter().map(|&n| complex.nodes[n].point).collect();
        let least = SHUT * slenderness(&then);
        if slenderness(&now) >= least {
            continue;
        }
        let mut shutting: Vec<Support> = (ring.iter())
            .flat_map(|&n| complex.nodes[n].supports.iter().copied())
            .collect();
        shutting.sort_unstable();
        shutting.dedup();
        let without = |s: Support| {
            let others = |n: NodeId| -> Supports {
                let all = complex.nodes[n].supports.iter().copied();
                all.filter(|&x| x != s).collect()
            };
            let points: Vec<DVec3> = (ring.iter().zip(&then))
                .map(|(&n, &start)| {
                    let p = placer.place(start, &others(n));
                    if p.is_finite() { p } else { start }
                })
                .collect();
            (slenderness(&points), s, points)
        };
        let best = shutting
            .into_iter()
            .map(without)
            .max_by(|a, b| a.0.total_cmp(&b.0).then(b.1.cmp(&a.1)));
        let Some((_, support, points)) = best.filter(|b| b.0 >= least) else {
            continue;
        };
        for (&n, p) in ring.iter().zip(points) {
            complex.nodes[n].point = p;
            complex.nodes[n].supports.retain(|s| *s != support);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::model::complex::{MidNode, MidTriangle};
    use crate::model::ids::{FaceId, WallId};

    /// Wall 0 is the plane z = 0, face 0 the plane y = 0, face 1 says nothing.
    struct Planes;

    impl Placer for Planes {
        fn place(&self, mut p: DVec3, supports: &[Support]) -> DVec3 {
            for s in supports {
                match s {
                    Support::Mid(_) => p.z = 0.0,
                    Support::Face(FaceId(0)) => p.y = 0.0,
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

    /// A flat ring of triangles round a hole of radius 1, out to radius 3, in the plane through `u` and `v`; nodes of the hole lie on wall 0 and this face.
    fn annulus(u: DVec3, v: DVec3, face: u32) -> MidComplex {
        let count = 8;
        let mut complex = MidComplex::default();
        for radius in [1.0, 3.0] {
            for k in 0..count {
                let angle = std::f64::consts::TAU * f64::from(k) / f64::from(count);
                let mut supports = Supports::from_slice(&[Support::Mid(WallId(0))]);
                if radius < 2.0 {
                    supports.push(Support::Face(FaceId(face)));
                }
                complex.nodes.push(MidNode {
                    point: (u * angle.cos() + v * angle.sin()) * radius,
                    supports,
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
        complex
    }

    fn points(complex: &MidComplex) -> IndexVec<NodeId, DVec3> {
        complex.nodes.iter().map(|n| n.point).collect()
    }

    fn placed(complex: &MidComplex) -> MidComplex {
        let mut complex = complex.clone();
        for n in complex.nodes.as_mut_slice() {
            n.point = Planes.place(n.point, &n.supports);
        }
        complex
    }

    #[test]
    fn rings_are_found_and_measured() {
        let rings = closed_rims(&annulus(DVec3::X, DVec3::Y, 0));
        assert_eq!(rings.iter().map(Vec::len).collect::<Vec<_>>(), [8, 8]);
        let square = [[0.0, 0.0], [2.0, 0.0], [2.0, 1.0], [0.0, 1.0]];
        let ring: Vec<DVec3> = square.map(|[x, y]| DVec3::new(x, y, 7.0)).to_vec();
        let (middle, [long, short]) = breadths(&ring);
        assert!(middle.distance(DVec3::new(1.0, 0.5, 7.0)) < 1e-12);
        // Middles of the sides: two of length 1 at one from the middle, two of length 2 at a half.
        assert!((long - (2.0f64 / 6.0).sqrt()).abs() < 1e-12);
        assert!((short - (1.0f64 / 6.0).sqrt()).abs() < 1e-12);
        assert_eq!(breadths(&[DVec3::ONE; 3]), (DVec3::ONE, [0.0; 2]));
    }

    #[test]
    fn a_rim_that_two_planes_shut_leaves_the_one_across() {
        // The hole stands upright in the plane of face 0; the wall lies flat and would press it to a line.
        let upright = annulus(DVec3::X, DVec3::Z, 0);
        let mut opened = placed(&upright);
        let flat: Vec<DVec3> = (0..8).map(|n| opened.nodes[NodeId(n)].point).collect();
        assert!(breadths(&flat).1[1] < 1e-12);
        open_shut(&mut opened, &points(&upright), &Planes);
        for n in (0..8).map(NodeId) {
            assert_eq!(
                opened.nodes[n].supports.as_slice(),
                [Support::Face(FaceId(0))]
            );
            assert!(opened.nodes[n].point.distance(upright.nodes[n].point) < 1e-12);
        }
        // And the other way round: the hole lies in the wall, and the face stands across it.
        let lying = annulus(DVec3::X, DVec3::Y, 0);
        let mut opened = placed(&lying);
        open_shut(&mut opened, &points(&lying), &Planes);
        let supports = |n: u32| opened.nodes[NodeId(n)].supports.clone();
        assert!((0..8).all(|n| supports(n).as_slice() == [Support::Mid(WallId(0))]));
    }

    #[test]
    fn a_rim_that_stays_open_keeps_its_supports() {
        let lying = annulus(DVec3::X, DVec3::Y, 1);
        let mut same = placed(&lying);
        open_shut(&mut same, &points(&lying), &Planes);
        assert_eq!(same, lying);
    }
}
