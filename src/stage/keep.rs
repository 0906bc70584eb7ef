//! Keep: the lines beneath edges that the user wants in the mesh become borders between pieces of a wall.
//!
//! ```text
//!      A     e     B            e: an edge between two faces of one side, x: the line beneath it.
//!   _________.__________        The mid-surface knows nothing of e. Its triangles are cut where the nearest face of the side changes
//!                               from A to B, and what the cut parts becomes walls of their own, with the sides of the whole wall.
//!   - - - - -x- - - - - -
//!   _____________________
//! ```
//! Then the line is a curve like any other crease, and the meshing follows it; its nodes lie on the mid-surface and on the plane through the edge that stands on it ([`Lines`]).
//! [`Pieces::joined`] makes the pieces one wall again.
//!
//! **Guarantees.** Homotopy type, rims and junction curves stay; without a wish nothing is changed. Where a side ends before its sheet (at a fillet, under a rib) the line goes straight on to where the
//! sheet ends. **Limits.** Lines have to part their sheet. For one that does not (it ends inside, or leads from a rim to a hole) the other edges of the smaller of its two faces are kept as well; what parts
//! nothing even so is refused. Of an edge whose loop is smaller than the triangles of the mid-surface, which are as large as the wall is thick, there is no line.
//!
//! Cost: some twenty nearest points an edge of the walls in question that changes faces; the rest is linear.

mod corner;
mod cut;
mod part;
#[cfg(test)]
mod tests;

use crate::medial::{Line, Lines, Medial};
use crate::model::brep::Brep;
use crate::model::complex::MidComplex;
use crate::model::ids::{CurveId, FaceId, WallId};
use crate::model::keep::{KeepEdge, KeptEdge};
use crate::model::pieces::Pieces;
use crate::model::walls::{Aag, Pairing};
use cut::{Cut, Cutter};
use glam::DVec3;
use std::collections::{BTreeMap, BTreeSet};

/// Edges of the solid beneath which an edge of the mesh lies, all about as near, as a share of its length: those on the two sides of a wall may be above each other.
const SAME: f64 = 0.02;

/// Why an edge cannot be kept.
#[derive(Clone, Debug, PartialEq)]
pub enum Unkept {
    /// Its faces are not on one side of a wall.
    Outer,
    /// The line beneath parts no sheet, near this place (mm), whatever other edges are kept.
    PartsNothing(DVec3),
}

/// A complex cut along its lines.
#[derive(Clone, Debug)]
pub struct Kept<'a> {
    /// The complex; its creases are the lines too.
    pub complex: MidComplex,
    /// The pairing with walls for the pieces after those of the part.
    pub pairing: Pairing,
    /// What places nodes of pieces.
    pub walls: Medial<'a>,
    /// The wall that each piece is of.
    pub pieces: Pieces,
    /// Which wish each edge of the solid belongs to.
    wishes: BTreeMap<CurveId, KeepEdge>,
}

/// Where a solid's wished edges lie.
#[derive(Clone, Debug, Default)]
struct Wished {
    /// By wall and side, in order.
    of_side: BTreeMap<(WallId, usize), Vec<CurveId>>,
    wishes: BTreeMap<CurveId, KeepEdge>,
}

/// The numbers of the two faces of an edge.
fn numbers(brep: &Brep, curve: CurveId) -> Option<KeepEdge> {
    match brep.curves[curve].faces.as_slice() {
        &[a, b] => Some(KeepEdge {
            faces: [a, b].map(|f| brep.faces[f].tag),
        }),
        _ => None,
    }
}

/// The sides of walls that both faces of an edge are on.
fn sides(brep: &Brep, pairing: &Pairing, curve: CurveId) -> Vec<(WallId, usize)> {
    let faces = &brep.curves[curve].faces;
    let on = |side: &[FaceId]| faces.len() == 2 && faces.iter().all(|f| side.contains(f));
    (pairing.walls.enumerated())
        .flat_map(|(w, wall)| [0, 1].map(|s| (w, s, on(&wall.sides[s]))))
        .filter(|found| found.2)
        .map(|(w, s, _)| (w, s))
        .collect()
}

impl Wished {
    fn new(
        brep: &Brep,
        pairing: &Pairing,
        wishes: &[KeepEdge],
    ) -> Result<Self, (KeepEdge, Unkept)> {
        let mut found = Self::default();
        for &wish in wishes {
            let [a, b] = wish.faces;
            let (mut any, mut inner) = (false, false);
            for curve in brep.curves.ids() {
                let faces = numbers(brep, curve).map(|n| n.faces);
                if faces != Some([a, b]) && faces != Some([b, a]) {
                    continue;
                }
                any = true;
                for side in sides(brep, pairing, curve) {
                    inner = true;
                    let curves = found.of_side.entry(side).or_default();
                    if !curves.contains(&curve) {
                        curves.push(curve);
                    }
                    found.wishes.entry(curve).or_insert(wish);
                }
            }
            // Where there is none it went with a small feature.
            if any && !inner {
                return Err((wish, Unkept::Outer));
            }
        }
        Ok(found)
    }

    /// Adds the other edges of the smaller of an edge's faces, as far as they lie within the same sides; says whether there are any.
    fn go_round(&mut self, brep: &Brep, aag: &Aag, pairing: &Pairing, curve: CurveId) -> bool {
        let smaller = (brep.curves[curve].faces.iter())
            .min_by(|a, b| aag.area[**a].total_cmp(&aag.area[**b]).then(a.cmp(b)));
        let Some(&smaller) = smaller else {
            return false;
        };
        let on = sides(brep, pairing, curve);
        let mut more = false;
        for &other in &brep.faces[smaller].curves {
            let Some(wish) = numbers(brep, other) else {
                continue;
            };
            for side in sides(brep, pairing, other) {
                let curves = self.of_side.entry(side).or_default();
                if on.contains(&side) && !curves.contains(&other) {
                    curves.push(other);
                    self.wishes.entry(other).or_insert(wish);
                    more = true;
                }
            }
        }
        self.of_side.retain(|_, curves| !curves.is_empty());
        more
    }

    /// All edges by wall.
    fn of_wall(&self) -> BTreeMap<WallId, Vec<CurveId>> {
        let mut all: BTreeMap<WallId, Vec<CurveId>> = BTreeMap::new();
        for ((wall, _), curves) in &self.of_side {
            all.entry(*wall).or_default().extend(curves);
        }
        all
    }
}

/// Cuts an untangled complex along the lines beneath the wished edges; `None` where the solid has none of them.
pub fn keep<'a>(
    complex: &MidComplex,
    brep: &'a Brep,
    aag: &Aag,
    pairing: &Pairing,
    medial: &Medial<'a>,
    wishes: &[KeepEdge],
) -> Result<Option<Kept<'a>>, (KeepEdge, Unkept)> {
    let mut wished = Wished::new(brep, pairing, wishes)?;
    if wished.of_side.is_empty() {
        return Ok(None);
    }
    let (mut complex, lines) = loop {
        let cuts = (wished.of_side.iter())
            .flat_map(|(&(wall, side), curves)| Cut::all(brep, medial, wall, side, curves))
            .collect();
        let mut cutter = Cutter::new(complex.clone(), brep, medial, cuts);
        cutter.cut();
        let (complex, mut lines) = cutter.finish();
        let idle = part::idle(&complex, &mut lines);
        let Some(&(curve, at)) = idle.first() else {
            break (complex, lines);
        };
        let mut more = false;
        for (curve, _) in idle {
            more |= wished.go_round(brep, aag, pairing, curve);
        }
        if !more && let Some(wish) = wished.wishes.get(&curve) {
            return Err((*wish, Unkept::PartsNothing(at)));
        }
    };
    let of_wall = wished.of_wall();
    let mut pairing = pairing.clone();
    let (pieces, beside) = part::pieces(&mut complex, &lines, &mut pairing);
    let of = (of_wall.iter()).map(|(&wall, curves)| (wall, Line::new(brep, curves)));
    let walls =
        (medial.paired(aag, &pairing)).cut_along(Lines::new(of.collect(), pieces.clone(), beside));
    part::place(&mut complex, &lines, &walls);
    Ok(Some(Kept {
        complex,
        pairing,
        walls,
        pieces,
        wishes: wished.wishes,
    }))
}

impl Kept<'_> {
    /// What a complex made of this one, its pieces still apart, has of the wished edges.
    pub fn standing(&self, complex: &MidComplex) -> Vec<KeptEdge> {
        let mut found: BTreeMap<KeepEdge, KeptEdge> = (self.wishes.values())
            .map(|wish| {
                let kept = KeptEdge {
                    faces: wish.faces,
                    edges: 0,
                    length: 0.0,
                };
                (*wish, kept)
            })
            .collect();
        for (edge, length) in self.walls.lines().along(complex) {
            let least = edge.values().copied().fold(f64::INFINITY, f64::min);
            let here = edge.iter().filter(|on| *on.1 <= least + SAME * length);
            let wishes: BTreeSet<KeepEdge> = here
                .filter_map(|on| self.wishes.get(on.0).copied())
                .collect();
            for wish in wishes {
                if let Some(kept) = found.get_mut(&wish) {
                    kept.edges += 1;
                    kept.length += length;
                }
            }
        }
        found.into_values().collect()
    }
}
