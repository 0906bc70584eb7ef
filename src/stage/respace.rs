//! Respace: nodes of feature curves as evenly as wanted, and so many that every sheet can be all quads.
//!
//! A curve whose edges are all about as long as wanted gets the number of edges that fits its length best, all equally long: opposite sides of a rectangle are then divided
//! alike. One that was divided more finely for a reason (a tight arc, a narrow place) keeps its number.
//!
//! A sheet has as many triangles as sides on its boundary, counted modulo two, however it is meshed inside; where that would be odd, a boundary curve gets one edge more or
//! less. A curve shared by several sheets changes all of them: which curves are to change is a linear system over Z/2, one equation a sheet, one unknown a curve; curves of
//! many nodes are preferred, where one more is hardly seen.
//!
//! **In** a meshed complex. **Out** the same with other nodes on its feature curves.
//! **Guarantees.** Topology, walls and corners stay, and edges between nodes with places of their own; no triangle is folded by it; the same result for any number of threads.
//! **Limits.** A sheet whose parity no curve can change stays odd (a closed sheet never is), as may one where an edge cannot be contracted without a fold.
//! **Cost.** O(n log n) for the edges; elimination over the sheets.

mod divide;
mod parity;

use crate::geom::curve_corner::is_within_curve;
use crate::geom::placer::{LengthField, Lengths, Placer};
use crate::model::complex::{EdgeKind, MidComplex, MidEdge, Support, pin};
use crate::model::ids::{IndexVec, NodeId, TriangleId};
use glam::DVec3;
use parity::{chosen, odd_ones};
use std::collections::BTreeMap;

/// Edges of a curve between these shares of the wanted length are as long as wanted: what a remesher leaves between splitting and contracting, and a little more.
const AS_WANTED: [f64; 2] = [0.5, 1.6];

/// A curve is straight where its edges turn by less than this cosine, five degrees, from the first.
const STRAIGHT_COS: f64 = 0.996;

/// A feature curve between corners.
struct Curve {
    /// Its nodes in order; of a closed one the first comes again as the last.
    nodes: Vec<NodeId>,
    /// The sheets that have it an odd number of times on their boundary, sorted.
    sheets: Vec<u32>,
    /// Its length in wanted edge lengths; where it is divided otherwise, its number of edges.
    wanted: f64,
    /// Whether all its edges are to be equally long.
    even: bool,
}

impl Curve {
    /// How many edges it has.
    fn count(&self) -> usize {
        self.nodes.len() - 1
    }

    /// Whether it is an edge between two nodes with places of their own, and stays one.
    fn is_pinned(&self, complex: &MidComplex) -> bool {
        let pinned = |n: &NodeId| pin(&complex.nodes[*n].supports).is_some();
        self.count() == 1 && self.nodes.iter().all(pinned)
    }

    /// How many it is to have.
    fn target(&self) -> usize {
        (self.wanted.round() as usize).max(if self.is_closed() { 3 } else { 1 })
    }

    fn is_closed(&self) -> bool {
        self.nodes.first() == self.nodes.last()
    }
}

/// The complex with its curves divided anew.
pub fn respace(complex: MidComplex, lengths: &LengthField, placer: &dyn Placer) -> MidComplex {
    let edges = complex.edges();
    let sheet = complex.sheets(&edges);
    let mut curves = curves(&complex, &edges, &sheet);
    // Between two nodes with places of their own nothing is divided.
    curves.retain(|c| !c.is_pinned(&complex));
    let mut odd: Vec<u32> = sheet.iter().map(|t| t.0).collect();
    for curve in &mut curves {
        curve.want(&complex, lengths);
        if curve.target().abs_diff(curve.count()) % 2 == 1 {
            odd.extend(&curve.sheets);
        }
    }
    // Long curves first; among equals the order of their nodes.
    curves.sort_by(|a, b| (b.target(), &a.nodes).cmp(&(a.target(), &b.nodes)));
    let columns: Vec<Vec<u32>> = curves.iter().map(|c| c.sheets.clone()).collect();
    for i in chosen(&columns, odd_ones(odd)) {
        let curve = &mut curves[i];
        let target = curve.target() as f64;
        // To the other side of what would fit best, but not to fewer edges than two.
        let least = if curve.is_closed() { 4.0 } else { 3.0 };
        let up = curve.wanted >= target || target < least;
        curve.wanted = if up { target + 1.0 } else { target - 1.0 };
    }
    divide::redivided(&complex, curves, placer)
}

impl Curve {
    /// Whether it is not straight.
    fn bends(&self, complex: &MidComplex) -> bool {
        let ways = self.nodes.windows(2).map(|pair| {
            let [p, q] = [pair[0], pair[1]].map(|n| complex.nodes[n].point);
            (q - p).normalize_or_zero()
        });
        let ways: Vec<DVec3> = ways.collect();
        ways.iter().any(|w| w.dot(ways[0]) < STRAIGHT_COS)
    }

    /// Finds how many edges it is to have.
    fn want(&mut self, complex: &MidComplex, lengths: &LengthField) {
        let wall = |n: NodeId| {
            let mid = |s: &Support| match s {
                Support::Mid(wall) => Some(*wall),
                _ => None,
            };
            complex.nodes[n].supports.iter().find_map(mid)
        };
        let (mut sum, mut plain) = (0.0, true);
        for pair in self.nodes.windows(2) {
            let [p, q] = [pair[0], pair[1]].map(|n| complex.nodes[n].point);
            let wanted =
                wall(pair[0]).map_or(Lengths::equal(f64::NAN), |w| lengths((p + q) / 2.0, w));
            // It was divided as if all lengths were those across.
            let ratio = p.distance(q) / wanted.across;
            sum += p.distance(q) / wanted.towards(q - p);
            plain &= ratio > AS_WANTED[0] && ratio < AS_WANTED[1];
        }
        self.even = plain;
        let count = self.count() as f64;
        self.wanted = match plain {
            // A bend is divided as finely as it needs.
            true if self.bends(complex) => sum.max(count),
            true => sum,
            false => count,
        };
    }
}

/// All feature curves.
fn curves(
    complex: &MidComplex,
    edges: &[MidEdge],
    sheet: &IndexVec<TriangleId, TriangleId>,
) -> Vec<Curve> {
    let features: Vec<(&MidEdge, Vec<u32>)> = (edges.iter())
        .filter(|e| complex.kind(e) != EdgeKind::Inner)
        .map(|e| {
            (
                e,
                odd_ones(e.triangles.iter().map(|&t| sheet[t].0).collect()),
            )
        })
        .collect();
    let mut at: BTreeMap<NodeId, Vec<usize>> = BTreeMap::new();
    for (i, (edge, _)) in features.iter().enumerate() {
        for n in edge.ends {
            at.entry(n).or_default().push(i);
        }
    }
    let far = |i: usize, n: NodeId| {
        let [a, b] = features[i].0.ends;
        if a == n { b } else { a }
    };
    // The other edge of the curve at a node within it.
    let onward = |i: usize, n: NodeId| -> Option<usize> {
        let &[j, k] = at[&n].as_slice() else {
            return None;
        };
        let other = if i == j { k } else { j };
        let within = is_within_curve(complex, n, [far(i, n), far(other, n)]);
        (within && features[i].1 == features[other].1).then_some(other)
    };
    let mut seen = vec![false; features.len()];
    let mut all = Vec::new();
    for first in 0..features.len() {
        if seen[first] {
            continue;
        }
        // Back to the beginning, or once round.
        let (mut i, mut n) = (first, features[first].0.ends[0]);
        while let Some(next) = onward(i, n) {
            (i, n) = (next, far(next, n));
            if i == first {
                break;
            }
        }
        let mut nodes = vec![n];
        loop {
            seen[i] = true;
            n = far(i, n);
            nodes.push(n);
            match onward(i, n) {
                Some(next) if !seen[next] => i = next,
                _ => break,
            }
        }
        all.push(Curve {
            nodes,
            sheets: features[first].1.clone(),
            wanted: 0.0,
            even: false,
        });
    }
    all
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::model::complex::MidNode;
    use crate::model::ids::PinId;
    use crate::stage::test_shapes::{self as shapes, Stay};
    use std::collections::BTreeSet;

    fn odd_sheets(complex: &MidComplex) -> usize {
        let edges = complex.edges();
        let sheet = complex.sheets(&edges);
        odd_ones(sheet.iter().map(|t| t.0).collect()).len()
    }

    /// A strip with one triangle cut off a corner.
    fn odd_plate() -> MidComplex {
        let mut plate = shapes::sheet(6, 4, |u, v| DVec3::new(6.0 * u, 4.0 * v, 0.0));
        let most = plate.triangles.len() - 1;
        plate.triangles = plate.triangles.iter().take(most).copied().collect();
        plate
    }

    fn free_lengths(complex: &MidComplex) -> Vec<f64> {
        let edges = complex.edges();
        let free = edges.iter().filter(|e| complex.kind(e) == EdgeKind::Rim);
        free.map(|e| {
            complex.nodes[e.ends[0]]
                .point
                .distance(complex.nodes[e.ends[1]].point)
        })
        .collect()
    }

    fn area(complex: &MidComplex) -> f64 {
        let areas = complex.triangles.iter().map(|t| complex.area_vector(t).z);
        assert!(areas.clone().all(|a| a > 0.0));
        areas.sum()
    }

    #[test]
    fn an_odd_plate_gets_one_edge_more_or_less() {
        let plate = odd_plate();
        assert_eq!(odd_sheets(&plate), 1);
        let even = respace(plate.clone(), &|_, _| Lengths::equal(1.0), &Stay);
        assert_eq!(odd_sheets(&even), 0);
        assert_eq!(even.check(), vec![]);
        assert_eq!(even.euler(), plate.euler());
        assert_eq!(
            free_lengths(&even)
                .len()
                .abs_diff(free_lengths(&plate).len()),
            1
        );
        assert!((area(&even) - area(&plate)).abs() < 1e-12);
    }

    #[test]
    fn sides_are_divided_as_their_length_wants() {
        // Edges of 1 where 0.8 or 1.5 are wanted: sides of 6 and 4.
        let plate = shapes::sheet(6, 4, |u, v| DVec3::new(6.0 * u, 4.0 * v, 0.0));
        for (size, counts) in [(0.8, [8, 5]), (1.5, [4, 3])] {
            let new = respace(plate.clone(), &|_, _| Lengths::equal(size), &Stay);
            assert_eq!(new.check(), vec![]);
            assert_eq!((new.euler(), odd_sheets(&new)), (1, 0));
            assert!((area(&new) - 24.0).abs() < 1e-12);
            let wanted = [6.0 / counts[0] as f64, 4.0 / counts[1] as f64];
            let lengths = free_lengths(&new);
            assert_eq!(lengths.len(), 2 * (counts[0] + counts[1]));
            for l in lengths {
                assert!(wanted.iter().any(|w| (l - w).abs() < 1e-12), "{l}");
            }
        }
    }

    #[test]
    fn what_is_divided_as_wanted_stays_as_it_is() {
        let plate = shapes::sheet(6, 4, |u, v| DVec3::new(6.0 * u, 4.0 * v, 0.0));
        let same = respace(plate.clone(), &|_, _| Lengths::equal(1.0), &Stay);
        assert_eq!(same.triangles, plate.triangles);
        let moved = same.nodes.iter().zip(&plate.nodes);
        assert!(
            moved
                .map(|(a, b)| a.point.distance(b.point))
                .all(|d| d < 1e-12)
        );
        // Finer than wanted for a reason that is not seen here: only its parity could change.
        let fine = respace(plate.clone(), &|_, _| Lengths::equal(5.0), &Stay);
        assert_eq!(fine, plate);
    }

    #[test]
    fn edges_between_places_of_their_own_stay() {
        // The plate is odd, and one node of its longest side is all that may go or come.
        let mut plate = odd_plate();
        let free: BTreeSet<NodeId> = (plate.edges().iter())
            .filter(|e| plate.kind(e) == EdgeKind::Rim)
            .flat_map(|e| e.ends)
            .collect();
        let on = |n: &NodeId, x: f64| plate.nodes[*n].point == DVec3::new(x, 0.0, 0.0);
        let pinned: Vec<NodeId> = (free.into_iter())
            .filter(|n| !on(n, 3.0) && !on(n, 4.0))
            .collect();
        for (i, &n) in pinned.iter().enumerate() {
            plate.nodes[n].supports.push(Support::Pin(PinId(i as u32)));
        }
        for size in [0.3, 1.0, 4.0] {
            let even = respace(plate.clone(), &|_, _| Lengths::equal(size), &Stay);
            assert_eq!((odd_sheets(&even), even.euler()), (0, plate.euler()));
            for &n in &pinned {
                let same = |m: &&MidNode| m.supports == plate.nodes[n].supports;
                let kept = even.nodes.iter().find(same).unwrap();
                assert_eq!(kept.point, plate.nodes[n].point);
            }
        }
    }
}
