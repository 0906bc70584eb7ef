//! The edge length wanted on flat walls, place by place: that of the part, of sheets and faces that the user gave a size of their own, and of narrow sheets.

use crate::geom::placer::Placer;
use crate::medial::Medial;
use crate::model::brep::Brep;
use crate::model::complex::MidComplex;
use crate::model::ids::{FaceId, FacetId, Id, SheetId, WallId};
use crate::model::local_size::LocalSize;
use crate::model::walls::Pairing;
use crate::options::MeshOptions;
use crate::spatial::TriangleBvh;
use crate::stage::sheets::Sheets;
use crate::stage::size::Sizing;
use crate::stage::width;
use glam::DVec3;
use std::collections::{BTreeMap, BTreeSet};

/// Where two sheets of a wall meet both have their say: a node of their common curve is this near to either, in thicknesses.
const BOTH: f64 = 0.1;
/// A face that is no side of a wall (a rim, a fillet) has its say within this many thicknesses of it: sheets end on it, or run on beneath.
const NEAR: f64 = 1.0;
/// The edge lengths wanted on flat walls.
#[derive(Clone, Debug)]
pub(super) struct Targets<'a> {
    brep: &'a Brep,
    /// Where nothing else is said, mm.
    base: f64,
    growth: f64,
    walls: BTreeMap<WallId, OfWall>,
    /// Faces that are no sides of walls, with sizes of their own, mm.
    near: Vec<(TriangleBvh, f64)>,
}

/// What is said of one wall.
#[derive(Clone, Debug, Default)]
struct OfWall {
    /// mm.
    thickness: f64,
    /// Its sheets, where one of them has a size of its own.
    sheets: Vec<(TriangleBvh, Option<f64>)>,
    /// Sizes of faces that are its sides, mm.
    sides: BTreeMap<FaceId, f64>,
    /// Where its sheets are narrow, with the size that gives the wanted rows there, mm.
    narrow: Option<(TriangleBvh, Vec<f64>)>,
}

/// What the targets of a solid are made of.
pub(super) struct Source<'a> {
    pub brep: &'a Brep,
    pub pairing: &'a Pairing,
    pub walls: &'a Medial<'a>,
    /// The untangled mid-surface and its sheets.
    pub complex: &'a MidComplex,
    pub sheets: &'a Sheets,
    /// Sheets of the solids before this one.
    pub sheets_before: usize,
}

impl<'a> Targets<'a> {
    pub fn new(source: &Source<'a>, sizing: &Sizing, options: &MeshOptions) -> Self {
        let mut targets = Self {
            brep: source.brep,
            base: sizing.target,
            growth: sizing.growth,
            walls: BTreeMap::new(),
            near: Vec::new(),
        };
        for wish in &options.sizes {
            targets.wish_for_sheets(source, wish);
            targets.wish_for_faces(source, wish);
        }
        targets.rows(source, options);
        targets
    }

    fn of_wall(&mut self, source: &Source<'_>, wall: WallId) -> &mut OfWall {
        self.walls.entry(wall).or_insert_with(|| OfWall {
            thickness: source.walls.mean_thickness(wall),
            ..OfWall::default()
        })
    }

    fn wish_for_sheets(&mut self, source: &Source<'_>, wish: &LocalSize) {
        let number = |sheet: SheetId| (source.sheets_before + sheet.index() + 1) as u32;
        let complex = source.complex;
        let mut triangles: BTreeMap<SheetId, (WallId, Vec<[DVec3; 3]>)> = BTreeMap::new();
        for (t, triangle) in complex.triangles.enumerated() {
            let (_, of_sheet) = (triangles.entry(source.sheets.of(t)))
                .or_insert_with(|| (triangle.wall, Vec::new()));
            of_sheet.push(complex.corners(triangle));
        }
        let wished: BTreeSet<WallId> = (triangles.iter())
            .filter(|(sheet, _)| wish.sheets.contains(&number(**sheet)))
            .map(|(_, (wall, _))| *wall)
            .collect();
        for (sheet, (wall, triangles)) in &triangles {
            if wished.contains(wall) {
                let size = wish.sheets.contains(&number(*sheet)).then_some(wish.size);
                let bvh = TriangleBvh::new(triangles);
                self.of_wall(source, *wall).sheets.push((bvh, size));
            }
        }
    }

    fn wish_for_faces(&mut self, source: &Source<'_>, wish: &LocalSize) {
        let brep = source.brep;
        let faces = brep.faces.enumerated();
        for (face, _) in faces.filter(|(_, f)| wish.faces.contains(&f.tag)) {
            let is_side = |sides: &[Vec<FaceId>; 2]| sides.iter().any(|s| s.contains(&face));
            let walls: Vec<WallId> = (source.pairing.walls.enumerated())
                .filter(|(_, wall)| is_side(&wall.sides))
                .map(|(id, _)| id)
                .collect();
            for &wall in &walls {
                let sides = &mut self.of_wall(source, wall).sides;
                let size = sides.entry(face).or_insert(wish.size);
                *size = size.min(wish.size);
            }
            if walls.is_empty() {
                let facets: Vec<FacetId> = (brep.facets.enumerated())
                    .filter(|(_, f)| f.face == face)
                    .map(|(id, _)| id)
                    .collect();
                let corners: Vec<[DVec3; 3]> = facets.iter().map(|&f| brep.corners(f)).collect();
                self.near.push((TriangleBvh::new(&corners), wish.size));
            }
        }
    }

    /// Narrow sheets, as far as they need a smaller size for the wanted rows of elements.
    fn rows(&mut self, source: &Source<'_>, options: &MeshOptions) {
        let rows = f64::from(options.rows);
        if options.rows < 2 {
            return;
        }
        let complex = source.complex;
        let largest = self.largest(options);
        let found = width::narrow(complex, &|_| rows * largest);
        let mut of_wall: BTreeMap<WallId, (Vec<[DVec3; 3]>, Vec<f64>)> = BTreeMap::new();
        for (t, width) in found {
            let triangle = &complex.triangles[t];
            let corners = complex.corners(triangle);
            let place = corners.iter().sum::<DVec3>() / 3.0;
            // An element shorter than the wall is thick is no shell; at knife edges the wall's mean counts, or there would be no end.
            let mean = source.walls.mean_thickness(triangle.wall);
            let here = source.walls.thickness(place, triangle.wall);
            let thickness = mean.max(here.unwrap_or(mean));
            let least = thickness.max(options.size_min.unwrap_or(0.0));
            // As many as find room.
            let fit = rows.min((width / least).floor());
            let size = width / fit;
            if fit >= 2.0 {
                let (triangles, sizes) = of_wall.entry(triangle.wall).or_default();
                triangles.push(corners);
                sizes.push(size);
            }
        }
        for (wall, (triangles, sizes)) in of_wall {
            let narrow = (TriangleBvh::new(&triangles), sizes);
            self.of_wall(source, wall).narrow = Some(narrow);
        }
    }

    /// The largest size wanted anywhere, mm.
    fn largest(&self, options: &MeshOptions) -> f64 {
        let local = options.sizes.iter().map(|wish| wish.size);
        local.fold(self.base, f64::max)
    }

    /// The edge length wanted at a place where nothing bends, mm, on a wall that `walls` may know as a piece of it.
    pub fn at(&self, walls: &Medial<'_>, p: DVec3, wall: WallId, piece: WallId) -> f64 {
        let near = (self.near.iter())
            .filter(|(bvh, _)| {
                let reach = NEAR * walls.mean_thickness(piece);
                bvh.any_within(p, reach).is_some()
            })
            .fold(f64::INFINITY, |least, (_, size)| least.min(*size));
        let Some(of_wall) = self.walls.get(&wall) else {
            return if near.is_finite() { near } else { self.base };
        };
        let side = self.side_size(of_wall, walls, p, piece);
        let wished = of_wall.sheet_size(p).min(side).min(near);
        let size = if wished.is_finite() {
            wished
        } else {
            self.base
        };
        size.min(of_wall.row_size(p, self.growth))
    }

    /// What the faces on either side ask for, mm; infinite where nothing is said.
    fn side_size(&self, of_wall: &OfWall, walls: &Medial<'_>, p: DVec3, piece: WallId) -> f64 {
        if of_wall.sides.is_empty() {
            return f64::INFINITY;
        }
        let feet = walls.feet(p, piece).into_iter().flatten();
        feet.filter_map(|foot| of_wall.sides.get(&self.brep.facets[foot.facet].face))
            .fold(f64::INFINITY, |least, size| least.min(*size))
    }
}

impl OfWall {
    /// What sheets ask for, mm; infinite where nothing is said.
    fn sheet_size(&self, p: DVec3) -> f64 {
        let away: Vec<(f64, Option<f64>)> = (self.sheets.iter())
            .filter_map(|(bvh, size)| Some((bvh.nearest(p)?.distance, *size)))
            .collect();
        let least = away.iter().map(|a| a.0).fold(f64::INFINITY, f64::min);
        let here = |a: &&(f64, Option<f64>)| a.0 <= least + BOTH * self.thickness;
        (away.iter().filter(here))
            .filter_map(|a| a.1)
            .fold(f64::INFINITY, f64::min)
    }

    /// What narrow sheets ask for, mm.
    fn row_size(&self, p: DVec3, growth: f64) -> f64 {
        let near = (self.narrow.as_ref()).and_then(|(bvh, sizes)| {
            let near = bvh.nearest(p)?;
            Some(sizes[near.index] + growth * near.distance)
        });
        near.unwrap_or(f64::INFINITY)
    }
}
