//! Sliding: nodes of feature curves move along them to where the cells of all their sheets want them.
//!
//! On a narrow strip nothing else can bring the nodes of one side opposite to those of the other. Nodes between corners slide by less than half of the way to their
//! neighbours; all cells at a node, of every sheet, have to be as good as before, or good enough.

use super::cells::{Cells, GOOD, Place};
use super::sheet::Sheet;
use super::smooth::wanted;
use crate::geom::curve_corner::is_within_curve;
use crate::geom::placer::Placer;
use crate::geom::triangle::nearest_on_segment;
use crate::model::complex::{EdgeKind, MidComplex};
use crate::model::ids::{IndexVec, NodeId};
use glam::DVec3;
use smallvec::SmallVec;

/// A node slides no further than this share of the way to its neighbour.
const REACH: f64 = 0.4;
/// Sweeps along all curves before the sheets follow.
const SWEEPS: usize = 3;

/// A node that may slide.
struct Slider {
    node: NodeId,
    /// Its neighbours on the curve.
    beside: [NodeId; 2],
    /// Which node it is in each of its sheets.
    at: SmallVec<[(usize, u32); 3]>,
}

/// All nodes that may slide, in order.
pub(super) struct Curves(Vec<Slider>);

impl Curves {
    /// Nodes between corners, but those of the sheets `spared`.
    pub(super) fn new(complex: &MidComplex, sheets: &[Sheet], spared: &[usize]) -> Self {
        let mut at: IndexVec<NodeId, SmallVec<[(usize, u32); 3]>> =
            IndexVec::filled(SmallVec::new(), complex.nodes.len());
        for (i, sheet) in sheets.iter().enumerate() {
            for (local, n) in sheet.held_nodes() {
                at[n].push((i, local));
            }
        }
        let mut beside: IndexVec<NodeId, SmallVec<[NodeId; 3]>> =
            IndexVec::filled(SmallVec::new(), complex.nodes.len());
        for edge in complex.edges() {
            if complex.kind(&edge) != EdgeKind::Inner {
                let [a, b] = edge.ends;
                beside[a].push(b);
                beside[b].push(a);
            }
        }
        let slider = |(node, beside): (NodeId, &SmallVec<[NodeId; 3]>)| {
            let &[a, b] = beside.as_slice() else {
                return None;
            };
            let moves = at[node].iter().all(|(sheet, _)| !spared.contains(sheet));
            (moves && is_within_curve(complex, node, [a, b])).then(|| Slider {
                node,
                beside: [a, b],
                at: at[node].clone(),
            })
        };
        Self(beside.enumerated().filter_map(slider).collect())
    }

    /// Moves nodes along their curves.
    pub(super) fn slide(&self, complex: &mut MidComplex, all: &mut [Cells], placer: &dyn Placer) {
        for _ in 0..SWEEPS {
            for slider in &self.0 {
                slider.slide(complex, all, placer);
            }
        }
    }
}

impl Slider {
    fn slide(&self, complex: &mut MidComplex, all: &mut [Cells], placer: &dyn Placer) {
        let (mut sum, mut total) = (DVec3::ZERO, 0.0);
        for &(sheet, local) in &self.at {
            let Some((s, t)) = wanted(&all[sheet], local, false) else {
                return;
            };
            sum += s;
            total += t;
        }
        let here = complex.nodes[self.node].point;
        let wish = sum / total;
        let on_curve = (self.beside.iter())
            .map(|&n| nearest_on_segment(here, here.lerp(complex.nodes[n].point, REACH), wish))
            .reduce(|a, b| {
                if b.distance(wish) < a.distance(wish) {
                    b
                } else {
                    a
                }
            })
            .unwrap_or(here);
        let step = on_curve.distance(here);
        let placed = placer.place(on_curve, &complex.nodes[self.node].supports);
        // A place far from the curve is another branch of it.
        let near = placed.is_finite() && placed.distance(on_curve) <= step;
        if step <= 0.0 || !near {
            return;
        }
        let worst = |all: &[Cells]| {
            let each = |&(sheet, local): &(usize, u32)| all[sheet].worst(all[sheet].star(local));
            self.at.iter().map(each).fold(f64::INFINITY, f64::min)
        };
        let mut put = |all: &mut [Cells], p: DVec3| {
            for &(sheet, local) in &self.at {
                let place = all[sheet].place(local);
                all[sheet].put(local, Place { point: p, ..place });
            }
            complex.nodes[self.node].point = p;
        };
        let before = worst(all);
        put(all, placed);
        let after = worst(all);
        if after < before && after < GOOD {
            put(all, here);
        }
    }
}
