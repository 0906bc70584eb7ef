//! Kinks: where the mid-surface of one wall turns at a line, its triangles are cut there.
//!
//! ```text
//!   ________________
//!                   |______      e: inner edge of a step, k: kink
//!   - - - - - - k   e            From k to below e the middle climbs along a parabola, beyond k it is flat: at k its normal jumps.
//!                `-._ _ _ _
//!   _______________________
//! ```
//! Beyond a riser the nearest place of a side jumps from the inner edge to the level behind the outer one. A mesh whose triangles cross that line smears the kink over
//! an element on either side. So the faces of a side are parted at outer edges into levels, a riser going with the level below it; wherever the nearest levels of
//! the two ends of an edge differ, the edge is cut at the jump, and the pieces become walls of their own. Then the kink is a curve like any other crease: its nodes
//! lie where the two mid-surfaces meet, and the meshing follows it. [`Pieces::joined`] makes the pieces one wall again.
//!
//! Round the end of an inner edge, as at the corner of a pocket, a kink is an arc. A chord that comes near to that end is split at its middle; the edges from there
//! cross the arc and are cut in turn.
//!
//! Guarantees: homotopy type, rims and junction curves stay; without kinks nothing is changed. Limits: kinks of less than 15 degrees are left, since
//! two planes so near to parallel define no line; so are pieces smaller than a squared thickness.
//!
//! Cost: linear in the triangles of walls with steps, and some thirty nearest points a cut edge, as many again an edge of a kink.

mod cut;
mod levels;
#[cfg(test)]
mod tests;

use crate::medial::Medial;
use crate::model::brep::Brep;
use crate::model::complex::MidComplex;
use crate::model::disjoint::Disjoint;
use crate::model::ids::{Id, IndexVec, NodeId, TriangleId, WallId};
use crate::model::pieces::Pieces;
use crate::model::walls::{Aag, Pairing, Wall};
use cut::Cutter;
use levels::{Class, Levels};
use std::collections::BTreeMap;

/// Pieces smaller than this many squared thicknesses are noise of the labels, not parts of a wall.
const ISLAND: f64 = 1.0;
/// Rounds of taking islands away: one may lie in another.
const ROUNDS: usize = 4;

/// A complex cut at its kinks.
#[derive(Clone, Debug)]
pub struct Kinked {
    /// The complex; its creases are the kinks too.
    pub complex: MidComplex,
    /// The pairing with walls for the pieces after those of the part.
    pub pairing: Pairing,
    /// The wall that each piece is of.
    pub pieces: Pieces,
}

/// Cuts a placed complex at the kinks within its walls; `None` where it has none.
pub fn kinks(
    complex: &MidComplex,
    brep: &Brep,
    aag: &Aag,
    pairing: &Pairing,
    medial: &Medial<'_>,
) -> Option<Kinked> {
    let levels: BTreeMap<WallId, Levels> = (pairing.walls.enumerated())
        .filter_map(|(w, wall)| Some((w, Levels::new(aag, wall)?)))
        .collect();
    let mut cutter = Cutter::new(complex.clone(), brep, medial, levels);
    if !cutter.part() {
        return None;
    }
    cutter.cut();
    let mut labels = cutter.labels();
    let (complex, levels) = cutter.finish();
    absorb(&complex, &mut labels, medial);
    let mut used: BTreeMap<WallId, Vec<Class>> = BTreeMap::new();
    for (t, label) in labels.enumerated() {
        if let Some(class) = *label {
            used.entry(complex.triangles[t].wall)
                .or_default()
                .push(class);
        }
    }
    let mut pairing = pairing.clone();
    let (mut names, mut pieces) = (BTreeMap::new(), Pieces::default());
    for (w, mut classes) in used {
        classes.sort_unstable();
        classes.dedup();
        if classes.len() < 2 {
            continue;
        }
        let wall = pairing.walls[w].clone();
        let sides = levels[&w].sides(aag, &wall, &classes);
        for (class, sides) in classes.into_iter().zip(sides) {
            let thickness = thickness(&pairing, &sides).unwrap_or(wall.thickness);
            let id = pairing.walls.push(Wall {
                sides,
                thickness,
                group: wall.group,
            });
            names.insert((w, class), id);
            pieces.add(id, w);
        }
        // Nothing lies on the whole wall any more, and its facets are those of its pieces.
        pairing.walls[w].sides = [Vec::new(), Vec::new()];
    }
    if pieces.is_empty() {
        return None;
    }
    let mut complex = complex;
    for (t, label) in labels.enumerated() {
        let triangle = &mut complex.triangles.as_mut_slice()[t.index()];
        if let Some(&id) = label.and_then(|class| names.get(&(triangle.wall, class))) {
            triangle.wall = id;
        }
    }
    complex.support_by_walls();
    Some(Kinked {
        complex,
        pairing,
        pieces,
    })
}

/// Mean thickness of the pairs between two sides, if there are any.
fn thickness(pairing: &Pairing, sides: &[Vec<crate::model::ids::FaceId>; 2]) -> Option<f64> {
    let on = |s: usize, f| sides[s].binary_search(&f).is_ok();
    let (mut sum, mut area) = (0.0, 0.0);
    for p in &pairing.pairs {
        let [a, b] = p.faces;
        if (on(0, a) && on(1, b)) || (on(1, a) && on(0, b)) {
            sum += p.overlap * p.thickness[1];
            area += p.overlap;
        }
    }
    (area > 0.0).then(|| sum / area)
}

/// Gives every island to the piece of its wall that it has the longest border with.
fn absorb(
    complex: &MidComplex,
    labels: &mut IndexVec<TriangleId, Option<Class>>,
    medial: &Medial<'_>,
) {
    let point = |n: NodeId| complex.nodes[n].point;
    let edges = complex.edges();
    for _ in 0..ROUNDS {
        let mut pieces = Disjoint::new(complex.triangles.len());
        let inner = edges.iter().filter_map(|e| match e.triangles.as_slice() {
            &[s, t] if complex.triangles[s].wall == complex.triangles[t].wall => {
                let [a, b] = e.ends.map(point);
                Some(([s, t], a.distance(b)))
            }
            _ => None,
        });
        let inner: Vec<([TriangleId; 2], f64)> = inner.collect();
        for ([s, t], _) in &inner {
            if labels[*s] == labels[*t] {
                pieces.join(s.0, t.0);
            }
        }
        let mut area: BTreeMap<u32, f64> = BTreeMap::new();
        for (id, t) in complex.triangles.enumerated() {
            *area.entry(pieces.find(id.0)).or_default() += complex.area_vector(t).length();
        }
        let mut borders: BTreeMap<u32, BTreeMap<Option<Class>, f64>> = BTreeMap::new();
        for &([s, t], length) in &inner {
            for (from, to) in [(s, t), (t, s)] {
                let piece = pieces.find(from.0);
                let thickness = medial.mean_thickness(complex.triangles[from].wall);
                let small = area[&piece] < ISLAND * thickness * thickness;
                if labels[from] != labels[to] && small {
                    let list = borders.entry(piece).or_default();
                    *list.entry(labels[to]).or_default() += length;
                }
            }
        }
        if borders.is_empty() {
            break;
        }
        for id in complex.triangles.ids() {
            let longest = borders.get(&pieces.find(id.0)).and_then(|list| {
                list.iter()
                    .max_by(|a, b| a.1.total_cmp(b.1).then(b.0.cmp(a.0)))
            });
            if let Some((&label, _)) = longest {
                labels.as_mut_slice()[id.index()] = label;
            }
        }
    }
}
