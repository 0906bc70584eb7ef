//! Parity: every sheet gets an even number of triangles, so that it can be all quads.
//!
//! A sheet has as many triangles as sides on its boundary, counted modulo two, however it is meshed inside; where that is odd, a boundary curve gets one node more. A
//! curve shared by several sheets changes all of them: which curves are to change is a linear system over Z/2, one equation a sheet, one unknown a curve; curves of
//! many nodes are preferred, where one more is hardly seen.
//!
//! **In** a meshed complex. **Out** the same with a few more nodes on its feature curves, whose other nodes have moved over along them.
//! **Guarantees.** Topology, walls and corners stay; no triangle is folded by it; the same result for any number of threads.
//! **Limits.** A sheet whose parity no curve can change stays odd (a closed sheet never is).
//! **Cost.** O(n log n) for the edges; elimination over the sheets.

use crate::geom::orient::folded;
use crate::geom::placer::Placer;
use crate::model::complex::{EdgeKind, MidComplex, MidEdge, MidNode, Support, Supports, ends};
use crate::model::disjoint::Disjoint;
use crate::model::ids::{IndexVec, NodeId, TriangleId};
use glam::DVec3;
use std::collections::{BTreeMap, BTreeSet};

/// A curve has a corner where it turns more than this: nodes do not move past one.
const CORNER_RAD: f64 = 35.0 * std::f64::consts::PI / 180.0;

/// A feature curve between corners.
struct Curve {
    /// Its nodes in order; of a closed one the first comes again as the last.
    nodes: Vec<NodeId>,
    /// The sheets that have it an odd number of times on their boundary, sorted.
    sheets: Vec<u32>,
}

/// The complex with as few more nodes on curves as make the triangles of every sheet even in number.
pub fn make_even(complex: MidComplex, placer: &dyn Placer) -> MidComplex {
    let edges = complex.edges();
    let sheet = sheets(&complex, &edges);
    let mut odd = BTreeSet::new();
    for t in complex.triangles.ids() {
        let s = sheet[t];
        if !odd.remove(&s) {
            odd.insert(s);
        }
    }
    if odd.is_empty() {
        return complex;
    }
    let mut curves = curves(&complex, &edges, &sheet);
    // Long curves first; among equals the order of their nodes.
    curves.sort_by(|a, b| (b.nodes.len(), &a.nodes).cmp(&(a.nodes.len(), &b.nodes)));
    let columns: Vec<Vec<u32>> = curves.iter().map(|c| c.sheets.clone()).collect();
    let chosen = chosen(&columns, odd.into_iter().collect());
    let chosen: Vec<&Curve> = chosen.iter().map(|&i| &curves[i]).collect();
    refined(&complex, &chosen, placer)
}

/// The lowest triangle of the sheet of every triangle: pieces that hang together over inner edges.
fn sheets(complex: &MidComplex, edges: &[MidEdge]) -> IndexVec<TriangleId, u32> {
    let mut pieces = Disjoint::new(complex.triangles.len());
    for edge in edges.iter().filter(|e| complex.kind(e) == EdgeKind::Inner) {
        pieces.join(edge.triangles[0].0, edge.triangles[1].0);
    }
    (complex.triangles.ids())
        .map(|t| pieces.find(t.0))
        .collect()
}

/// All feature curves that change the parity of a sheet.
fn curves(
    complex: &MidComplex,
    edges: &[MidEdge],
    sheet: &IndexVec<TriangleId, u32>,
) -> Vec<Curve> {
    let features: Vec<(&MidEdge, Vec<u32>)> = (edges.iter())
        .filter(|e| complex.kind(e) != EdgeKind::Inner)
        .map(|e| (e, odd_ones(e.triangles.iter().map(|&t| sheet[t]).collect())))
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
        let p = |n: NodeId| complex.nodes[n].point;
        let turn = (p(n) - p(far(i, n))).angle_between(p(far(other, n)) - p(n));
        let within = ends(&complex.nodes[n].supports).count() < 2 && turn < CORNER_RAD;
        (within && features[i].1 == features[other].1).then_some(other)
    };
    let mut seen = vec![false; features.len()];
    let mut all = Vec::new();
    for first in 0..features.len() {
        if seen[first] || features[first].1.is_empty() {
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

/// Every curve with one node more.
fn refined(complex: &MidComplex, curves: &[&Curve], placer: &dyn Placer) -> MidComplex {
    let before = folded(complex).len();
    let mut new = complex.clone();
    // How each curve is refined: nodes spread over all of it, or a node in the middle of one edge.
    let mut added: Vec<NodeId> = Vec::new();
    for curve in curves {
        added.push(split(&mut new, curve));
    }
    let plain = new.clone();
    for (curve, &middle) in curves.iter().zip(&added) {
        spread(&mut new, complex, curve, middle, placer);
    }
    if folded(&new).len() <= before {
        return new;
    }
    // Curve by curve: what folds a triangle stays with its one new node.
    let folds: BTreeSet<NodeId> = (folded(&new).iter())
        .flat_map(|&t| new.triangles[t].nodes)
        .collect();
    for (curve, &middle) in curves.iter().zip(&added) {
        if curve.nodes.iter().any(|n| folds.contains(n)) || folds.contains(&middle) {
            for &n in curve.nodes.iter().chain([&middle]) {
                new.nodes[n].point = plain.nodes[n].point;
            }
        }
    }
    if folded(&new).len() <= before {
        new
    } else {
        plain
    }
}

/// Splits the edge in the middle of a curve.
fn split(complex: &mut MidComplex, curve: &Curve) -> NodeId {
    let m = (curve.nodes.len() - 2) / 2;
    let [a, b] = [curve.nodes[m], curve.nodes[m + 1]];
    let both = [a, b].map(|n| complex.nodes[n].clone());
    let mut supports: Supports = (both[0].supports.iter().copied())
        .filter(|s| both[1].supports.contains(s))
        .collect();
    let at: Vec<TriangleId> = (complex.triangles.enumerated())
        .filter(|(_, t)| t.nodes.contains(&a) && t.nodes.contains(&b))
        .map(|(id, _)| id)
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
    for t in at {
        let mut other = complex.triangles[t];
        let swap = |n: NodeId, gone: NodeId| if n == gone { middle } else { n };
        other.nodes = other.nodes.map(|n| swap(n, a));
        complex.triangles[t].nodes = complex.triangles[t].nodes.map(|n| swap(n, b));
        complex.triangles.push(other);
    }
    middle
}

/// Nodes of a curve moved along it, so that one more has room.
fn spread(
    new: &mut MidComplex,
    old: &MidComplex,
    curve: &Curve,
    middle: NodeId,
    placer: &dyn Placer,
) {
    let count = curve.nodes.len() - 1;
    let at = |t: f64| -> DVec3 {
        let i = (t as usize).min(count - 1);
        let [a, b] = [i, i + 1].map(|i| old.nodes[curve.nodes[i]].point);
        a.lerp(b, t - i as f64)
    };
    let mut order = curve.nodes.clone();
    order.insert((curve.nodes.len() - 2) / 2 + 1, middle);
    for (j, &n) in order.iter().enumerate().take(order.len() - 1).skip(1) {
        let start = at(j as f64 * count as f64 / (count + 1) as f64);
        let placed = placer.place(start, &new.nodes[n].supports);
        let room = start.distance(old.nodes[curve.nodes[j.min(count) - 1]].point)
            + start.distance(old.nodes[curve.nodes[j.min(count)]].point);
        // A place far off is another branch of the surface.
        let near = placed.is_finite() && placed.distance(start) < room / 2.0;
        new.nodes[n].point = if near { placed } else { start };
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::stage::test_shapes::{self as shapes, Stay};

    fn odd_sheets(complex: &MidComplex) -> usize {
        let edges = complex.edges();
        let sheet = sheets(complex, &edges);
        odd_ones(sheet.iter().copied().collect()).len()
    }

    /// A strip with one triangle cut off a corner.
    fn odd_plate() -> MidComplex {
        let mut plate = shapes::sheet(6, 4, |u, v| DVec3::new(6.0 * u, 4.0 * v, 0.0));
        let most = plate.triangles.len() - 1;
        plate.triangles = plate.triangles.iter().take(most).copied().collect();
        plate
    }

    #[test]
    fn an_odd_plate_gets_one_node_more_on_its_longest_side() {
        let plate = odd_plate();
        assert_eq!(odd_sheets(&plate), 1);
        let even = make_even(plate.clone(), &Stay);
        assert_eq!(odd_sheets(&even), 0);
        assert_eq!(even.check(), vec![]);
        assert_eq!(even.nodes.len(), plate.nodes.len() + 1);
        assert_eq!(even.triangles.len(), plate.triangles.len() + 1);
        assert_eq!(even.euler(), plate.euler());
        let area = |c: &MidComplex| -> f64 {
            let areas = c.triangles.iter().map(|t| c.area_vector(t).z);
            assert!(areas.clone().all(|a| a > 0.0));
            areas.sum()
        };
        assert!((area(&even) - area(&plate)).abs() < 1e-12);
        // Six edges of 1 became seven of 6/7.
        let edges = even.edges();
        let lengths = (edges.iter())
            .filter(|e| even.kind(e) == EdgeKind::Rim)
            .map(|e| {
                even.nodes[e.ends[0]]
                    .point
                    .distance(even.nodes[e.ends[1]].point)
            });
        let short = lengths.filter(|l| (l - 6.0 / 7.0).abs() < 1e-12).count();
        assert_eq!(short, 7);
    }

    #[test]
    fn an_even_complex_stays_as_it_is() {
        let plate = shapes::sheet(6, 4, |u, v| DVec3::new(6.0 * u, 4.0 * v, 0.0));
        assert_eq!(make_even(plate.clone(), &Stay), plate);
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
