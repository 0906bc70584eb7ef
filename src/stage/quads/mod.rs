//! Quads: the triangles of each sheet become quads of nearly right angles.
//!
//! **In** a complex whose sheets were meshed with the halves of squares, with an even number of triangles each. **Out** the same sheets with other nodes inside, still as
//! triangles, and the edges that halve quads.
//!
//! Sheet by sheet: triangles are paired (a matching: Remacle et al. 2012, "Blossom-Quad", doi:10.1002/nme.3279), single ones carried to one another (`transport`) or joined by a row of new
//! quads (`insert`), nodes
//! brought nearer to four quads each (`valence`), free nodes smoothed (`smooth`), what is still poor mended (`mend`), and nodes put onto the exact mid-surface.
//!
//! **Guarantees.** Feature curves with the number of their nodes, topology and walls stay; nodes of curves slide along them (`slide`), corners stay; nothing is turned over that
//! was not before; the same for any number of threads. A quad that comes out bad is two triangles. **Limits.** How many nodes a curve has is settled before.
//! **Cost.** Smoothing dominates: some fifty sweeps with a search for the nearest point a node.

mod cells;
mod change;
mod insert;
mod matching;
mod mend;
mod operations;
mod paired;
mod sheet;
mod slide;
mod smooth;
mod stretch;
mod transport;
mod usable;
mod valence;

pub use paired::pair_quads;

use crate::geom::orient;
use crate::geom::placer::Placer;
use crate::model::complex::{EdgeKind, MidComplex, MidNode, MidTriangle, Support};
use crate::model::ids::{Id, IndexVec, NodeId, TriangleId};
use cells::Cells;
use glam::DVec3;
use mend::mend;
use rayon::prelude::*;
use sheet::{Facets, Made, Owners, Sheet};
use slide::Curves;
use smooth::{Effort, smooth};
use std::collections::{BTreeMap, BTreeSet};

/// Rounds of moving nodes along curves and smoothing again: what comes after the third is below a hundredth in quality.
const SLIDES: usize = 3;

/// A complex whose triangles are mostly halves of quads.
#[derive(Clone, Debug, PartialEq)]
pub struct Halves {
    /// The triangles.
    pub complex: MidComplex,
    /// Edges between the two halves of a quad, lower node first, sorted.
    pub diagonals: Vec<[NodeId; 2]>,
}

impl Halves {
    /// Another complex made from this one by a few changes, with the diagonals whose ends are still where they were.
    pub fn changed_to(&self, complex: MidComplex) -> Self {
        let bits = |p: DVec3| p.to_array().map(f64::to_bits);
        let at: BTreeMap<[u64; 3], NodeId> = (complex.nodes.enumerated())
            .map(|(id, n)| (bits(n.point), id))
            .collect();
        let edges: BTreeSet<[NodeId; 2]> = (complex.edges().iter())
            .filter(|e| complex.kind(e) == EdgeKind::Inner)
            .map(|e| e.ends)
            .collect();
        let moved = |d: &[NodeId; 2]| {
            let [a, b] = d.map(|n| at.get(&bits(self.complex.nodes[n].point)).copied());
            let (a, b) = (a?, b?);
            Some([a.min(b), a.max(b)]).filter(|e| edges.contains(e))
        };
        let mut diagonals: Vec<[NodeId; 2]> = self.diagonals.iter().filter_map(moved).collect();
        diagonals.sort_unstable();
        Self { complex, diagonals }
    }
}

/// Quads for every sheet.
pub fn quads(complex: MidComplex, placer: &dyn Placer) -> Halves {
    Quadding::new(complex, placer).without(&[]).0
}

/// The same, but sheets in which a quad would be folded over keep their triangles, and the curves round them their nodes. Takes as long again, once or twice.
pub fn unfolded_quads(complex: MidComplex, placer: &dyn Placer) -> Halves {
    let quadding = Quadding::new(complex, placer);
    let mut spared: Vec<usize> = Vec::new();
    loop {
        let (halves, sheet) = quadding.without(&spared);
        let folded: BTreeSet<usize> = (orient::folded(&halves.complex).into_iter())
            .map(|t| sheet[t.index()])
            .filter(|s| !spared.contains(s))
            .collect();
        // What is folded without quads was so before.
        if folded.is_empty() {
            return halves;
        }
        spared.extend(folded);
    }
}

/// A complex of which quads are to be made.
struct Quadding<'a> {
    complex: MidComplex,
    sheets: Vec<Sheet>,
    grounds: Vec<Facets>,
    placer: &'a dyn Placer,
}

impl<'a> Quadding<'a> {
    fn new(mut complex: MidComplex, placer: &'a dyn Placer) -> Self {
        orient::orient(&mut complex, placer);
        let sheets = sheets(&complex);
        Self {
            grounds: sheets.par_iter().map(Sheet::ground).collect(),
            sheets,
            complex,
            placer,
        }
    }

    /// Does something to the cells of every sheet.
    fn each(&self, all: &mut [Cells], work: impl Fn(&Sheet, &mut Cells, &Facets) + Sync) {
        (self.sheets.par_iter().zip(&self.grounds).zip(all))
            .for_each(|((sheet, ground), cells)| work(sheet, cells, ground));
    }

    /// The sheets in quads but these, and the sheet of every triangle.
    fn without(&self, spared: &[usize]) -> (Halves, Vec<usize>) {
        let (complex, sheets, placer) = (&self.complex, &self.sheets, self.placer);
        let mut all: Vec<Cells> = (sheets.par_iter().zip(&self.grounds))
            .map(|(sheet, ground)| sheet.quadded(ground))
            .collect();
        let mut slid = complex.clone();
        let curves = Curves::new(complex, sheets, spared);
        for _ in 0..SLIDES {
            curves.slide(&mut slid, &mut all, placer);
            self.each(&mut all, |_, cells, ground| {
                smooth(cells, ground, Effort::Brief)
            });
        }
        self.each(&mut all, |sheet, cells, ground| {
            smooth(cells, ground, Effort::Whole);
            if mend(cells, ground) {
                smooth(cells, ground, Effort::Whole);
            }
            sheet.place(cells, placer);
        });
        let made: Vec<Option<Made>> = (sheets.par_iter().zip(&all))
            .enumerate()
            .map(|(i, (sheet, cells))| match spared.contains(&i) {
                true => None,
                false => sheet.halved(cells),
            })
            .collect();
        let new = assembled(&slid, sheets, &made);
        let same = new.complex.check().is_empty()
            && new.complex.euler() == complex.euler()
            && new.complex.pieces() == complex.pieces();
        let count = |(i, sheet): (usize, &Sheet)| match &made[i] {
            Some(made) if same => made.triangles.len(),
            _ => sheet.source.len(),
        };
        let owner = (sheets.iter().enumerate()).flat_map(|s| std::iter::repeat_n(s.0, count(s)));
        if same {
            (new, owner.collect())
        } else {
            let none: Vec<Option<Made>> = sheets.iter().map(|_| None).collect();
            (assembled(complex, sheets, &none), owner.collect())
        }
    }
}

/// The sheets of a complex, in the order of their first triangles.
fn sheets(complex: &MidComplex) -> Vec<Sheet> {
    let edges = complex.edges();
    let sheet = complex.sheets(&edges);
    let mut members: IndexVec<TriangleId, Vec<TriangleId>> =
        IndexVec::filled(Vec::new(), complex.triangles.len());
    for t in complex.triangles.ids() {
        members[sheet[t]].push(t);
    }
    // A node that several sheets have stays, even where they only touch.
    let mut owners: IndexVec<NodeId, Owners> = IndexVec::filled(Owners::new(), complex.nodes.len());
    let mut held: IndexVec<NodeId, bool> = IndexVec::filled(false, complex.nodes.len());
    for (t, triangle) in complex.triangles.enumerated() {
        let piece = sheet[t].0;
        for n in triangle.nodes {
            if !owners[n].contains(&piece) {
                owners[n].push(piece);
            }
            held[n] |= owners[n].len() > 1;
            let own = Support::Mid(triangle.wall);
            held[n] |= complex.nodes[n].supports.iter().any(|s| *s != own);
        }
    }
    let kept: BTreeSet<[NodeId; 2]> = (edges.iter())
        .filter(|e| complex.kind(e) != EdgeKind::Inner || sheet::is_fold(complex, e))
        .map(|e| e.ends)
        .collect();
    for n in kept.iter().flatten() {
        held[*n] = true;
    }
    (members.iter().filter(|m| !m.is_empty()))
        .map(|m| Sheet::new(complex, m, &held, &owners, &kept))
        .collect()
}

/// The complex with the sheets that were made; of the others the old triangles.
fn assembled(complex: &MidComplex, sheets: &[Sheet], made: &[Option<Made>]) -> Halves {
    let mut used = IndexVec::<NodeId, bool>::filled(false, complex.nodes.len());
    for (sheet, made) in sheets.iter().zip(made) {
        match made {
            Some(made) => made
                .triangles
                .iter()
                .flatten()
                .filter_map(|&c| sheet.held_node(c))
                .for_each(|n| used[n] = true),
            None => (sheet.source.iter())
                .flat_map(|&t| complex.triangles[t].nodes)
                .for_each(|n| used[n] = true),
        }
    }
    let mut new = MidComplex::default();
    let old: IndexVec<NodeId, Option<NodeId>> = (complex.nodes.enumerated())
        .map(|(id, node)| used[id].then(|| new.nodes.push(node.clone())))
        .collect();
    let mut diagonals = Vec::new();
    for (sheet, made) in sheets.iter().zip(made) {
        let wall = sheet.wall;
        let Some(made) = made else {
            for &t in &sheet.source {
                let nodes = complex.triangles[t].nodes;
                let nodes = nodes.map(|n| old[n].unwrap_or(NodeId(u32::MAX)));
                new.triangles.push(MidTriangle { nodes, wall });
            }
            continue;
        };
        let mut own: Vec<NodeId> = Vec::with_capacity(made.points.len());
        for (c, &point) in made.points.iter().enumerate() {
            let supports = [Support::Mid(wall)].into_iter().collect();
            own.push(match sheet.held_node(c as u32) {
                Some(n) => old[n].unwrap_or(NodeId(u32::MAX)),
                None if made.lives[c] => new.nodes.push(MidNode { point, supports }),
                None => NodeId(u32::MAX),
            });
        }
        let named = |c: u32| own[c as usize];
        for t in &made.triangles {
            let nodes = t.map(named);
            new.triangles.push(MidTriangle { nodes, wall });
        }
        diagonals.extend(made.diagonals.iter().map(|d| {
            let [a, b] = d.map(named);
            [a.min(b), a.max(b)]
        }));
    }
    diagonals.sort_unstable();
    Halves {
        complex: new,
        diagonals,
    }
}

#[cfg(test)]
mod test_grid;
#[cfg(test)]
mod tests;
