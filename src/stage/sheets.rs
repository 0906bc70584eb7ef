//! Sheets: the number of every sheet, the same before a part is meshed and after.
//!
//! **In** the untangled mid-surface, which no size has touched. **Out** its sheets by number, the largest first, and the numbers of the sheets of any complex or mesh made of it: a sheet there has
//! the number of the one that most of its area lies on.
//!
//! **Guarantees.** The same numbers for any sizes and any number of threads. Crumbs of sheets, which cleaning takes away, are the smallest, so that no other number hangs on them.
//! **Limits.** Of sheets of one size the first in the complex comes first, which a part drawn anew may change. Where meshing parts a sheet in two, its lesser part comes after all others; where it
//! takes one away that is no crumb, those after it move up.

use crate::model::complex::MidComplex;
use crate::model::ids::{ElementId, Id, IndexVec, SheetId, TriangleId, WallId};
use crate::model::shell::ShellMesh;
use crate::spatial::TriangleBvh;
use glam::DVec3;
use rayon::prelude::*;
use std::collections::BTreeMap;

/// Areas that differ by less than this share are equal: symmetric ribs differ by rounding.
const EQUAL: f64 = 1e-6;

/// The sheets of an untangled mid-surface.
#[derive(Clone, Debug)]
pub struct Sheets {
    /// For every triangle its sheet.
    of: IndexVec<TriangleId, SheetId>,
    /// How many there are.
    count: usize,
    /// The triangles of each wall, and their sheets.
    places: BTreeMap<WallId, (TriangleBvh, Vec<SheetId>)>,
}

/// A sheet of another complex: its wall, and places on it with the area that each stands for, mm².
pub struct Piece {
    /// The wall that it is the middle of.
    pub wall: WallId,
    /// Places and areas.
    pub samples: Vec<(DVec3, f64)>,
}

impl Piece {
    /// Its area, mm².
    pub fn area(&self) -> f64 {
        self.samples.iter().map(|s| s.1).sum()
    }

    /// Its centre of area.
    pub fn centre(&self) -> DVec3 {
        let weighted: DVec3 = self.samples.iter().map(|(p, area)| *p * *area).sum();
        weighted / self.area().max(f64::MIN_POSITIVE)
    }
}

impl Sheets {
    /// Numbers the sheets of a complex.
    pub fn new(complex: &MidComplex) -> Self {
        let first_of = complex.sheets(&complex.edges());
        let mut area: BTreeMap<TriangleId, f64> = BTreeMap::new();
        for (t, triangle) in complex.triangles.enumerated() {
            *area.entry(first_of[t]).or_default() += complex.area_vector(triangle).length();
        }
        let rank = largest_first(area.into_iter().collect());
        let of: IndexVec<TriangleId, SheetId> = first_of.iter().map(|first| rank[first]).collect();
        let mut corners: BTreeMap<WallId, (Vec<[DVec3; 3]>, Vec<SheetId>)> = BTreeMap::new();
        for (t, triangle) in complex.triangles.enumerated() {
            let (triangles, sheets) = corners.entry(triangle.wall).or_default();
            triangles.push(complex.corners(triangle));
            sheets.push(of[t]);
        }
        let places = (corners.into_iter())
            .map(|(wall, (triangles, sheets))| (wall, (TriangleBvh::new(&triangles), sheets)))
            .collect();
        Self {
            of,
            count: rank.len(),
            places,
        }
    }

    /// How many there are, crumbs too.
    pub fn count(&self) -> usize {
        self.count
    }

    /// The sheet of a triangle of the complex that they were numbered on.
    pub fn of(&self, triangle: TriangleId) -> SheetId {
        self.of[triangle]
    }

    /// The sheets of a complex made of the same mid-surface, in the order of their numbers.
    pub fn of_complex(&self, complex: &MidComplex) -> Vec<Piece> {
        let first_of = complex.sheets(&complex.edges());
        let mut all: BTreeMap<TriangleId, Piece> = BTreeMap::new();
        for (t, triangle) in complex.triangles.enumerated() {
            let [a, b, c] = complex.corners(triangle);
            let area = complex.area_vector(triangle).length();
            let sheet = all.entry(first_of[t]).or_insert_with(|| Piece {
                wall: triangle.wall,
                samples: Vec::new(),
            });
            sheet.samples.push(((a + b + c) / 3.0, area));
        }
        let all: Vec<Piece> = all.into_values().collect();
        let mut ranked: Vec<(usize, Piece)> = self.ranks(&all).into_iter().zip(all).collect();
        ranked.sort_by_key(|r| r.0);
        ranked.into_iter().map(|r| r.1).collect()
    }

    /// The place of each piece in the order of the numbers.
    fn ranks(&self, pieces: &[Piece]) -> Vec<usize> {
        let lies_on: Vec<(usize, f64)> = (pieces.par_iter())
            .map(|c| (self.lies_on(c), c.area()))
            .collect();
        let mut largest: BTreeMap<usize, usize> = BTreeMap::new();
        for (i, (sheet, area)) in lies_on.iter().enumerate() {
            let best = largest.entry(*sheet).or_insert(i);
            if *area > lies_on[*best].1 {
                *best = i;
            }
        }
        let mut order: Vec<usize> = (0..pieces.len()).collect();
        order.sort_by_key(|&i| {
            let sheet = lies_on[i].0;
            (largest[&sheet] != i, sheet, i)
        });
        let mut ranks = vec![0; order.len()];
        for (rank, i) in order.into_iter().enumerate() {
            ranks[i] = rank;
        }
        ranks
    }

    /// The sheet that most of a piece's area lies on; one behind the last where its wall has none.
    fn lies_on(&self, piece: &Piece) -> usize {
        let Some((bvh, sheets)) = self.places.get(&piece.wall) else {
            return self.count;
        };
        let mut areas: BTreeMap<SheetId, f64> = BTreeMap::new();
        for &(p, area) in &piece.samples {
            if let Some(near) = bvh.nearest(p) {
                *areas.entry(sheets[near.index]).or_default() += area;
            }
        }
        // Of equal ones the first.
        let most =
            areas.into_iter().fold(
                None,
                |best: Option<(SheetId, f64)>, (sheet, area)| match best {
                    Some((_, most)) if most >= area => best,
                    _ => Some((sheet, area)),
                },
            );
        most.map_or(self.count, |(sheet, _)| sheet.index())
    }

    /// A mesh with its sheets, and the elements with them, in the order of the numbers.
    #[must_use]
    pub fn in_order(&self, mut mesh: ShellMesh) -> ShellMesh {
        let mut pieces: Vec<Piece> = (mesh.sheets.iter())
            .map(|sheet| Piece {
                wall: sheet.wall,
                samples: Vec::new(),
            })
            .collect();
        for e in &mesh.elements {
            let corners = e.corners.as_slice();
            let centre: DVec3 = corners.iter().map(|&n| mesh.nodes[n]).sum();
            let place = centre / corners.len() as f64;
            let area = mesh.doubled_area(e).length() / 2.0;
            pieces[e.sheet.index()].samples.push((place, area));
        }
        let ranks = self.ranks(&pieces);
        let mut elements: Vec<ElementId> = mesh.elements.ids().collect();
        elements.sort_by_key(|&e| ranks[mesh.elements[e].sheet.index()]);
        mesh.elements = (elements.into_iter())
            .map(|e| {
                let mut element = mesh.elements[e].clone();
                element.sheet = SheetId::new(ranks[element.sheet.index()]);
                element
            })
            .collect();
        let mut sheets: Vec<SheetId> = mesh.sheets.ids().collect();
        sheets.sort_by_key(|s| ranks[s.index()]);
        mesh.sheets = (sheets.into_iter())
            .map(|s| mesh.sheets[s].clone())
            .collect();
        mesh
    }
}

/// The number of each sheet, counted from zero, the largest first; equal ones in the order of their first triangles.
fn largest_first(mut area: Vec<(TriangleId, f64)>) -> BTreeMap<TriangleId, SheetId> {
    area.sort_by(|a, b| b.1.total_cmp(&a.1).then(a.0.cmp(&b.0)));
    let equal = |a: &(TriangleId, f64), b: &(TriangleId, f64)| b.1 >= (1.0 - EQUAL) * a.1;
    for run in area.chunk_by_mut(equal) {
        run.sort_by_key(|s| s.0);
    }
    (area.into_iter().enumerate())
        .map(|(rank, (first, _))| (first, SheetId::new(rank)))
        .collect()
}

#[cfg(test)]
mod tests;
