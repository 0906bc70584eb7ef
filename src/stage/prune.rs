//! Prune: takes away sheets that stand for no wall.
//!
//! Where labels of two walls interleave (in fillets, in the block where walls join) the collapse keeps fins: small sheets that hang on to others by a junction and
//! end in a free border. Placed on their wall they double a sheet that is there already, or hang beyond the ends of both sides. Nor is there ever a third
//! sheet where a wall meets nothing but itself: its mid-surface is one. Such a sheet goes
//! if it can be folded back from its free border to its junctions without a rest, so that the homotopy type cannot change.
//!
//! Guarantees: homotopy type kept (elementary collapses only; J. H. C. Whitehead, Simplicial spaces, nuclei and m-groups, Proc. LMS 45 (1939),
//! doi:10.1112/plms/s2-45.1.243); every sheet goes whole or stays whole; positions untouched. Supports follow: a node lies on the walls of the triangles
//! that it has left, and on faces only while it is on a rim.
//! Cost: one nearest-point query a triangle of the small sheets, in parallel; the rest is linear.

use crate::geom::placer::Placer;
use crate::model::complex::{MidComplex, MidEdge};
use crate::model::disjoint::Disjoint;
use crate::model::ids::{Id, IndexVec, NodeId, TriangleId};
use crate::spatial::TriangleBvh;
use glam::DVec3;
use rayon::prelude::*;
use std::collections::BTreeMap;

/// Rounds: sheets that come together when a fin has gone are looked at once more.
const ROUNDS: usize = 6;
/// A sheet of this many squared thicknesses or more is no fin; what is wrong with it is not for this stage.
const LARGEST: f64 = 40.0;
/// A triangle this near to another sheet of its wall doubles it, in thicknesses. Sheets of one wall lie on one mid-surface: only facets keep them apart.
const DOUBLED: f64 = 0.1;
/// A triangle further than this beyond the ends of a side lies over no wall, in thicknesses.
const BEYOND: f64 = 0.25;
/// A triangle that leans further than this (cosine) from its wall's mid-surface is no part of it: 60 degrees.
const LEAN: f64 = 0.5;
/// A triangle lower than this, in thicknesses, has no area to stand for anything: what placing leaves of a distance is far below, what is drawn far above.
const FLAT: f64 = 0.005;
/// A sheet goes where this share of its area stands for no wall.
const IDLE_SHARE: f64 = 0.8;

/// What was taken away.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct PruneStats {
    /// Sheets.
    pub sheets: usize,
    /// Triangles.
    pub triangles: usize,
}

/// Takes away the sheets that stand for no wall.
pub fn prune(mut complex: MidComplex, placer: &dyn Placer) -> (MidComplex, PruneStats) {
    let mut stats = PruneStats::default();
    for _ in 0..ROUNDS {
        let mut cells = Cells::new(&complex);
        let before = stats;
        for sheet in idle_sheets(&complex, &cells.edges, placer) {
            if cells.fold_back(&sheet) {
                stats.sheets += 1;
                stats.triangles += sheet.len();
            }
        }
        if stats == before {
            break;
        }
        complex = cells.rest(&complex);
    }
    (complex, stats)
}

/// The small sheets that stand for no wall, the smallest first. Of two that double each other both are told; the first that goes saves the other one
/// in the next round, so at most one of every such pair is told.
fn idle_sheets(
    complex: &MidComplex,
    edges: &[MidEdge],
    placer: &dyn Placer,
) -> Vec<Vec<TriangleId>> {
    let mut sets = Disjoint::new(complex.triangles.len());
    for edge in edges.iter().filter(|e| e.triangles.len() == 2) {
        sets.join(edge.triangles[0].0, edge.triangles[1].0);
    }
    let sheet: IndexVec<TriangleId, u32> =
        complex.triangles.ids().map(|t| sets.find(t.0)).collect();
    let corners: Vec<[DVec3; 3]> = complex
        .triangles
        .iter()
        .map(|t| complex.corners(t))
        .collect();
    let mut of_sheet: BTreeMap<u32, Vec<TriangleId>> = BTreeMap::new();
    for t in complex.triangles.ids() {
        of_sheet.entry(sheet[t]).or_default().push(t);
    }
    let area = |t: TriangleId| {
        let [a, b, c] = corners[t.index()];
        (b - a).cross(c - a).length() / 2.0
    };
    let thickness = |t: TriangleId| {
        let [a, b, c] = corners[t.index()];
        placer
            .thickness((a + b + c) / 3.0, complex.triangles[t].wall)
            .unwrap_or(0.0)
            .abs()
    };
    let size_of: BTreeMap<u32, f64> = (of_sheet.iter())
        .map(|(&s, list)| (s, list.iter().map(|&t| area(t)).sum()))
        .collect();
    let surplus = surplus(complex, edges, &sheet, &size_of);
    let mut small: Vec<(f64, Vec<TriangleId>)> = of_sheet
        .into_iter()
        .filter_map(|(s, list)| {
            let small = |&t: &TriangleId| {
                let thickness = thickness(t);
                size_of[&s] < LARGEST * thickness * thickness
            };
            let fin = surplus.contains_key(&s) || list.par_iter().any(small);
            fin.then_some((size_of[&s], list))
        })
        .collect();
    small.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
    if small.is_empty() {
        return Vec::new();
    }
    let bvh = TriangleBvh::new(&corners);
    let doubles = |t: TriangleId| -> Option<u32> {
        let [a, b, c] = corners[t.index()];
        let wall = complex.triangles[t].wall;
        bvh.nearest_where((a + b + c) / 3.0, DOUBLED * thickness(t), |i| {
            let other = TriangleId::new(i);
            complex.triangles[other].wall == wall && sheet[other] != sheet[t]
        })
        .map(|near| sheet[TriangleId::new(near.index)])
    };
    let nowhere = |t: TriangleId| {
        let [a, b, c] = corners[t.index()];
        let (middle, wall) = ((a + b + c) / 3.0, complex.triangles[t].wall);
        let normal = (b - a).cross(c - a).normalize_or_zero();
        placer.beyond(middle, wall) > BEYOND * thickness(t)
            || placer
                .normal(middle, wall)
                .is_some_and(|n| n.dot(normal).abs() < LEAN)
    };
    let parts = parting(complex, edges, &sheet);
    let flat = |t: TriangleId| {
        if parts.binary_search(&sheet[t]).is_ok() {
            return false;
        }
        let [a, b, c] = corners[t.index()];
        let longest = a.distance(b).max(b.distance(c)).max(c.distance(a));
        2.0 * area(t) <= FLAT * thickness(t) * longest
    };
    let judged: Vec<(f64, Vec<u32>)> = small
        .par_iter()
        .map(|(size, list)| {
            if let Some(others) = surplus.get(&sheet[list[0]]) {
                return (*size, others.clone());
            }
            let mut idle = 0.0;
            let mut others = Vec::new();
            for &t in list {
                let double = doubles(t);
                if double.is_some() || flat(t) || nowhere(t) {
                    idle += area(t);
                }
                others.extend(double);
            }
            others.sort_unstable();
            others.dedup();
            (idle, others)
        })
        .collect();
    let mut told: Vec<Vec<TriangleId>> = Vec::new();
    let mut gone: Vec<u32> = Vec::new();
    for ((size, list), (idle, others)) in small.into_iter().zip(judged) {
        // What has no area stands for nothing, though none of it is beside a wall.
        let is_idle = idle > IDLE_SHARE * size || list.iter().all(|&t| flat(t));
        if is_idle && !others.iter().any(|o| gone.contains(o)) {
            gone.push(sheet[list[0]]);
            told.push(list);
        }
    }
    told
}

/// Sheets at whose border another wall meets a third one, sorted. Where such a sheet has no width it is a strip between two strands of one junction: without it
/// the walls would come apart.
fn parting(complex: &MidComplex, edges: &[MidEdge], sheet: &IndexVec<TriangleId, u32>) -> Vec<u32> {
    let wall = |t: TriangleId| complex.triangles[t].wall;
    let mut found: Vec<u32> = edges
        .iter()
        .filter(|e| e.triangles.len() == 3)
        .flat_map(|e| {
            (0..3).filter_map(move |k| {
                let [own, next, last] = [0, 1, 2].map(|i| e.triangles[(k + i) % 3]);
                (wall(next) != wall(last)).then(|| sheet[own])
            })
        })
        .collect();
    found.sort_unstable();
    found.dedup();
    found
}

/// Sheets that meet nothing but others of their own wall at junctions, and a larger one among these; with all that they meet.
fn surplus(
    complex: &MidComplex,
    edges: &[MidEdge],
    sheet: &IndexVec<TriangleId, u32>,
    size_of: &BTreeMap<u32, f64>,
) -> BTreeMap<u32, Vec<u32>> {
    let mut met: BTreeMap<u32, Option<Vec<u32>>> = BTreeMap::new();
    for edge in edges.iter().filter(|e| e.triangles.len() > 2) {
        let wall = |t: TriangleId| complex.triangles[t].wall;
        let own = edge.triangles.windows(2).all(|t| wall(t[0]) == wall(t[1]));
        for t in &edge.triangles {
            let met = met.entry(sheet[*t]).or_insert_with(|| Some(Vec::new()));
            if own {
                let others = edge.triangles.iter().map(|s| sheet[*s]);
                met.iter_mut()
                    .for_each(|m| m.extend(others.clone().filter(|o| *o != sheet[*t])));
            } else {
                *met = None;
            }
        }
    }
    met.into_iter()
        .filter_map(|(s, others)| {
            let mut others = others?;
            others.sort_unstable();
            others.dedup();
            let larger = others.iter().any(|o| size_of[o] > size_of[&s]);
            larger.then_some((s, others))
        })
        .collect()
}

/// Which cells of the complex are left.
struct Cells {
    edges: Vec<MidEdge>,
    edges_of: IndexVec<TriangleId, [usize; 3]>,
    lives: IndexVec<TriangleId, bool>,
    /// Living triangles at every edge.
    valence: Vec<usize>,
    edge_lives: Vec<bool>,
    /// Living edges at every node.
    degree: IndexVec<NodeId, usize>,
}

impl Cells {
    fn new(complex: &MidComplex) -> Self {
        let edges = complex.edges();
        let mut edges_of = IndexVec::filled([usize::MAX; 3], complex.triangles.len());
        let mut degree = IndexVec::filled(0, complex.nodes.len());
        for (i, edge) in edges.iter().enumerate() {
            for &t in &edge.triangles {
                if let Some(slot) = edges_of[t].iter_mut().find(|e| **e == usize::MAX) {
                    *slot = i;
                }
            }
            for n in edge.ends {
                degree[n] += 1;
            }
        }
        Self {
            valence: edges.iter().map(|e| e.triangles.len()).collect(),
            edge_lives: vec![true; edges.len()],
            lives: IndexVec::filled(true, complex.triangles.len()),
            edges,
            edges_of,
            degree,
        }
    }

    /// Collapses a sheet from its free border; whether it went without a rest. If not, nothing has changed.
    fn fold_back(&mut self, sheet: &[TriangleId]) -> bool {
        let mut open: Vec<TriangleId> = sheet.to_vec();
        let (mut taken, mut cut) = (Vec::new(), Vec::new());
        while let Some(t) = open.pop() {
            if !self.lives[t] {
                continue;
            }
            let free = self.edges_of[t]
                .into_iter()
                .find(|&e| self.edge_lives[e] && self.valence[e] == 1);
            let Some(free) = free else {
                continue;
            };
            self.lives[t] = false;
            taken.push(t);
            for e in self.edges_of[t] {
                self.valence[e] -= 1;
                open.extend(
                    self.edges[e]
                        .triangles
                        .iter()
                        .filter(|&&s| self.lives[s] && sheet.binary_search(&s).is_ok()),
                );
            }
            self.cut(free, &mut cut);
        }
        let mut bare: Vec<usize> = taken
            .iter()
            .flat_map(|&t| self.edges_of[t])
            .filter(|&e| self.edge_lives[e] && self.valence[e] == 0)
            .collect();
        bare.sort_unstable();
        bare.dedup();
        // Whiskers go from their free ends.
        loop {
            let before = bare.len();
            bare.retain(|&e| {
                let loose = self.edges[e].ends.iter().any(|&n| self.degree[n] == 1);
                if loose {
                    self.cut(e, &mut cut);
                }
                !loose
            });
            if bare.len() == before {
                break;
            }
        }
        let whole = bare.is_empty() && taken.len() == sheet.len();
        // The last triangles of a complex are never a fin.
        if whole && self.lives.iter().any(|&l| l) {
            return true;
        }
        for t in taken {
            self.lives[t] = true;
            for e in self.edges_of[t] {
                self.valence[e] += 1;
            }
        }
        for e in cut {
            self.edge_lives[e] = true;
            for n in self.edges[e].ends {
                self.degree[n] += 1;
            }
        }
        false
    }

    fn cut(&mut self, edge: usize, cut: &mut Vec<usize>) {
        self.edge_lives[edge] = false;
        for n in self.edges[edge].ends {
            self.degree[n] -= 1;
        }
        cut.push(edge);
    }

    /// The complex of what is left.
    fn rest(&self, complex: &MidComplex) -> MidComplex {
        let mut left = MidComplex::default();
        let mut on_rim = IndexVec::filled(false, complex.nodes.len());
        for (i, edge) in self.edges.iter().enumerate() {
            if self.edge_lives[i] && self.valence[i] == 1 {
                for n in edge.ends {
                    on_rim[n] = true;
                }
            }
        }
        let mut new_id: IndexVec<NodeId, Option<NodeId>> =
            IndexVec::filled(None, complex.nodes.len());
        for (n, node) in complex.nodes.enumerated() {
            if self.degree[n] == 0 {
                continue;
            }
            let mut node = node.clone();
            if !on_rim[n] {
                node.supports.clear();
            }
            new_id[n] = Some(left.nodes.push(node));
        }
        for (t, triangle) in complex.triangles.enumerated() {
            let [Some(a), Some(b), Some(c)] = triangle.nodes.map(|n| new_id[n]) else {
                continue;
            };
            if !self.lives[t] {
                continue;
            }
            let mut triangle = *triangle;
            triangle.nodes = [a, b, c];
            left.triangles.push(triangle);
        }
        left.support_by_walls();
        left
    }
}

#[cfg(test)]
mod tests;
