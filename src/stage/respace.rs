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

use crate::geom::curve_corner::is_within_curve;
use crate::geom::orient::folded;
use crate::geom::placer::{LengthField, Lengths, Placer};
use crate::model::complex::{
    EdgeKind, MidComplex, MidEdge, MidNode, MidTriangle, Support, Supports, pin,
};
use crate::model::ids::{IndexVec, NodeId, TriangleId};
use glam::DVec3;
use smallvec::SmallVec;
use std::collections::{BTreeMap, BTreeSet};

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
        let closed = self.nodes.first() == self.nodes.last();
        (self.wanted.round() as usize).max(if closed { 3 } else { 1 })
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
        let up = curve.wanted >= target || target < 3.0;
        curve.wanted = if up { target + 1.0 } else { target - 1.0 };
    }
    redivided(&complex, curves, placer)
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

/// Those that are there an odd number of times, sorted.
fn odd_ones(mut all: Vec<u32>) -> Vec<u32> {
    all.sort_unstable();
    (all.chunk_by(|a, b| a == b))
        .filter(|run| run.len() % 2 == 1)
        .map(|run| run[0])
        .collect()
}

/// Columns that add up to the target modulo two, or to as much of it as can be had; earlier columns are preferred.
fn chosen(columns: &[Vec<u32>], mut target: Vec<u32>) -> Vec<usize> {
    // Each vector of the basis by its lowest row, with the columns that it is made of.
    let mut basis: BTreeMap<u32, (Vec<u32>, Vec<u32>)> = BTreeMap::new();
    for (i, column) in columns.iter().enumerate() {
        let (mut vector, mut made_of) = (column.clone(), vec![i as u32]);
        while let Some(&low) = vector.first() {
            match basis.get(&low) {
                Some((v, m)) => {
                    vector = sum(&vector, v);
                    made_of = sum(&made_of, m);
                }
                None => {
                    basis.insert(low, (vector, made_of));
                    break;
                }
            }
        }
    }
    let mut made_of = Vec::new();
    let mut left: Vec<u32> = Vec::new();
    while let Some(&low) = target.first() {
        match basis.get(&low) {
            Some((v, m)) => {
                target = sum(&target, v);
                made_of = sum(&made_of, m);
            }
            None => left.push(target.remove(0)),
        }
    }
    made_of.into_iter().map(|i| i as usize).collect()
}

/// The sum of two sorted sets modulo two.
fn sum(a: &[u32], b: &[u32]) -> Vec<u32> {
    odd_ones([a, b].concat())
}

/// Every curve with as many edges as it is to have.
fn redivided(complex: &MidComplex, mut curves: Vec<Curve>, placer: &dyn Placer) -> MidComplex {
    let before = folded(complex).len();
    let mut stars = complex.stars();
    let mut new = complex.clone();
    let mut gone: BTreeSet<TriangleId> = BTreeSet::new();
    let old: Vec<Vec<DVec3>> = (curves.iter())
        .map(|c| c.nodes.iter().map(|&n| complex.nodes[n].point).collect())
        .collect();
    for curve in &mut curves {
        while curve.count() < curve.target() {
            split(&mut new, &mut stars, curve);
        }
        while curve.count() > curve.target() && contract(&mut new, &mut stars, &mut gone, curve) {}
    }
    let plain = new.clone();
    for (curve, line) in curves.iter().zip(&old) {
        spread(&mut new, line, curve, placer);
    }
    let living = |c: &MidComplex| living(c, &gone);
    if folded(&living(&new)).len() <= before {
        return living(&new);
    }
    // Curve by curve: where nodes fold a triangle they stay as they were.
    let folds: BTreeSet<[u64; 3]> = {
        let spread = living(&new);
        let corners = |t: TriangleId| spread.corners(&spread.triangles[t]);
        (folded(&spread).into_iter())
            .flat_map(corners)
            .map(|p| p.to_array().map(f64::to_bits))
            .collect()
    };
    for curve in &curves {
        let at = |n: &NodeId| new.nodes[*n].point.to_array().map(f64::to_bits);
        if curve.nodes.iter().any(|n| folds.contains(&at(n))) {
            for &n in &curve.nodes {
                new.nodes[n].point = plain.nodes[n].point;
            }
        }
    }
    if folded(&living(&new)).len() <= before {
        living(&new)
    } else {
        living(&plain)
    }
}

/// The complex without these triangles, and without nodes that no triangle has.
fn living(complex: &MidComplex, gone: &BTreeSet<TriangleId>) -> MidComplex {
    let mut used = IndexVec::<NodeId, bool>::filled(false, complex.nodes.len());
    let kept: Vec<MidTriangle> = (complex.triangles.enumerated())
        .filter(|(t, _)| !gone.contains(t))
        .map(|(_, t)| *t)
        .collect();
    for n in kept.iter().flat_map(|t| t.nodes) {
        used[n] = true;
    }
    let mut new = MidComplex::default();
    let names: IndexVec<NodeId, Option<NodeId>> = (complex.nodes.enumerated())
        .map(|(id, node)| used[id].then(|| new.nodes.push(node.clone())))
        .collect();
    for t in kept {
        let nodes = t.nodes.map(|n| names[n].unwrap_or(n));
        new.triangles.push(MidTriangle { nodes, ..t });
    }
    new
}

/// The living triangles at each node.
type Stars = IndexVec<NodeId, SmallVec<[TriangleId; 8]>>;

/// Splits the longest edge of a curve.
fn split(complex: &mut MidComplex, stars: &mut Stars, curve: &mut Curve) {
    let length = |i: usize| {
        let [a, b] = [i, i + 1].map(|i| complex.nodes[curve.nodes[i]].point);
        a.distance(b)
    };
    let longest = (1..curve.count()).fold(0, |best, i| {
        // Of equal ones rounding must not decide.
        if length(i) > length(best) * (1.0 + 1e-9) {
            i
        } else {
            best
        }
    });
    let [a, b] = [curve.nodes[longest], curve.nodes[longest + 1]];
    let both = [a, b].map(|n| complex.nodes[n].clone());
    let mut supports: Supports = (both[0].supports.iter().copied())
        .filter(|s| both[1].supports.contains(s))
        .collect();
    let at: Vec<TriangleId> = (stars[a].iter().copied())
        .filter(|&t| complex.triangles[t].nodes.contains(&b))
        .collect();
    for &t in &at {
        supports.push(Support::Mid(complex.triangles[t].wall));
    }
    supports.sort_unstable();
    supports.dedup();
    let middle = complex.nodes.push(MidNode {
        point: (both[0].point + both[1].point) / 2.0,
        supports,
    });
    stars.push(SmallVec::new());
    for t in at {
        let mut other = complex.triangles[t];
        let swap = |n: NodeId, gone: NodeId| if n == gone { middle } else { n };
        other.nodes = other.nodes.map(|n| swap(n, a));
        complex.triangles[t].nodes = complex.triangles[t].nodes.map(|n| swap(n, b));
        let id = complex.triangles.push(other);
        stars[b].retain(|s| *s != t);
        stars[middle].extend([t, id]);
        for n in other.nodes.into_iter().filter(|n| *n != middle) {
            stars[n].push(id);
        }
    }
    curve.nodes.insert(longest + 1, middle);
}

/// Takes one node of a curve away, that with the shortest edges first; whether one could go.
fn contract(
    complex: &mut MidComplex,
    stars: &mut Stars,
    gone: &mut BTreeSet<TriangleId>,
    curve: &mut Curve,
) -> bool {
    let point = |n: NodeId| complex.nodes[n].point;
    let mut inner: Vec<usize> = (1..curve.count()).collect();
    let around = |i: &usize| {
        let [a, b, c] = [i - 1, *i, i + 1].map(|i| point(curve.nodes[i]));
        a.distance(b) + b.distance(c)
    };
    inner.sort_by(|a, b| around(a).total_cmp(&around(b)).then(a.cmp(b)));
    for i in inner {
        let node = curve.nodes[i];
        for to in [curve.nodes[i - 1], curve.nodes[i + 1]] {
            if !may_go(complex, stars, node, to) {
                continue;
            }
            for t in std::mem::take(&mut stars[node]) {
                let nodes = complex.triangles[t].nodes;
                if nodes.contains(&to) {
                    gone.insert(t);
                    nodes.iter().for_each(|&n| stars[n].retain(|s| *s != t));
                } else {
                    complex.triangles[t].nodes = nodes.map(|n| if n == node { to } else { n });
                    stars[to].push(t);
                }
            }
            curve.nodes.remove(i);
            return true;
        }
    }
    false
}

/// Whether a node may be drawn into a neighbour: the link condition holds, and no triangle turns over.
fn may_go(complex: &MidComplex, stars: &Stars, node: NodeId, to: NodeId) -> bool {
    let others = |n: NodeId| -> BTreeSet<NodeId> {
        let corners = stars[n].iter().flat_map(|&t| complex.triangles[t].nodes);
        corners.filter(|m| *m != n).collect()
    };
    let apexes: BTreeSet<NodeId> = (stars[node].iter())
        .filter(|&&t| complex.triangles[t].nodes.contains(&to))
        .flat_map(|&t| complex.triangles[t].nodes)
        .filter(|n| *n != node && *n != to)
        .collect();
    let common: BTreeSet<NodeId> = others(node).intersection(&others(to)).copied().collect();
    common == apexes
        && stars[node].iter().all(|&t| {
            let triangle = &complex.triangles[t];
            let nodes = triangle.nodes.map(|n| if n == node { to } else { n });
            let moved = MidTriangle { nodes, ..*triangle };
            triangle.nodes.contains(&to)
                || complex
                    .area_vector(&moved)
                    .dot(complex.area_vector(triangle))
                    > 0.0
        })
}

/// Nodes of a curve moved along it: all edges equally long, or as they were but for the difference in their number.
fn spread(new: &mut MidComplex, line: &[DVec3], curve: &Curve, placer: &dyn Placer) {
    let old = line.len() - 1;
    if !curve.even && old == curve.count() {
        return;
    }
    // How far along the curve each of its old nodes lies.
    let mut along = vec![0.0];
    for pair in line.windows(2) {
        let step = if curve.even {
            pair[0].distance(pair[1])
        } else {
            1.0
        };
        along.push(along[along.len() - 1] + step);
    }
    let whole = along[old];
    for (j, &n) in curve.nodes.iter().enumerate().take(curve.count()).skip(1) {
        let far = whole * j as f64 / curve.count() as f64;
        let i = (along.partition_point(|&a| a <= far) - 1).min(old - 1);
        let share = (far - along[i]) / (along[i + 1] - along[i]);
        let start = line[i].lerp(line[i + 1], share);
        let placed = placer.place(start, &new.nodes[n].supports);
        // A place far off is another branch of the surface.
        let near = placed.is_finite() && placed.distance(start) < line[i].distance(line[i + 1]);
        new.nodes[n].point = if near { placed } else { start };
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::model::ids::PinId;
    use crate::stage::test_shapes::{self as shapes, Stay};

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

    #[test]
    fn columns_add_up_to_the_target_where_they_can() {
        // Two sheets, both odd: a shared curve mends both at once.
        assert_eq!(chosen(&[vec![0, 1], vec![0]], vec![0, 1]), [0]);
        // Only the first is odd, and its own curve comes later.
        assert_eq!(chosen(&[vec![0, 1], vec![0]], vec![0]), [1]);
        assert_eq!(chosen(&[vec![0, 1], vec![0]], vec![1]), [0, 1]);
        // Nothing reaches sheet 2; the rest is mended.
        assert_eq!(chosen(&[vec![0]], vec![0, 2]), [0]);
    }
}
