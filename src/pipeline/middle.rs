//! The mid-surfaces of a solid's walls as the stages after the choice of walls ask for them: as what places nodes, and for the edge length wanted at a place.

use super::targets::Targets;
use crate::geom::placer::{Lengths, Placer};
use crate::medial::{Held, Medial};
use crate::model::complex::MidComplex;
use crate::model::ids::WallId;
use crate::model::pieces::Pieces;
use crate::stage::size::Sizing;
use glam::{DVec3, FloatExt};
use rayon::prelude::*;

/// Edges of quads that follow a bend, as a share of those of triangles.
const SQUARE_AT_BENDS: f64 = 0.75;
/// The same across a bend along which edges are longer: these never lie quite along, and what they leave the wall by for that must fit in.
const LONG_AT_BENDS: f64 = 0.55;
/// Edges along a bend may be so many times as long as those across it; with 2.5 the fixtures' bends leave the middle by 0.5 to 1 % of the thickness, with 4 rows beside each
/// other no longer fit, and one quad in ten is warped.
const LONGEST: f64 = 2.0;
/// Edges are longer along a bend where it alone asks for edges shorter than this share of the wanted length: in gentler ones little is gained.
const TIGHT: f64 = 0.5;
/// What an edge along leaves the wall by comes on top of what one across does: of the share that is allowed it takes one in so many.
const SLIGHT: f64 = 8.0;

/// The mid-surfaces, held in the material where sheets would leave it otherwise.
#[derive(Clone, Debug)]
pub(super) struct Middle<'a> {
    /// The mid-surfaces as such.
    pub walls: &'a Medial<'a>,
    held: Option<Held<'a>>,
    targets: Option<&'a Targets<'a>>,
    /// The pieces that walls were cut into, the last cut first.
    pieces: &'a [&'a Pieces],
}

impl<'a> Middle<'a> {
    /// `leaves`: sheets would leave the material.
    pub fn new(walls: &'a Medial<'a>, leaves: bool) -> Self {
        Self {
            walls,
            held: leaves.then(|| Held::new(walls)),
            targets: None,
            pieces: &[],
        }
    }

    /// The same with wanted lengths that differ from place to place; `pieces` where the walls are pieces (of pieces) of those that the lengths are told for.
    pub fn aiming(self, targets: &'a Targets<'a>, pieces: &'a [&'a Pieces]) -> Self {
        Self {
            targets: Some(targets),
            pieces,
            ..self
        }
    }

    /// What places nodes.
    pub fn placer(&self) -> &dyn Placer {
        match &self.held {
            Some(held) => held,
            None => self.walls,
        }
    }

    /// The edge length wanted at a place on a wall, mm.
    pub fn field(&self, sizing: &Sizing) -> impl Fn(DVec3, WallId) -> f64 + Sync {
        move |p, w| self.wanted(sizing, p, w).0
    }

    /// The edge length wanted at a place on a wall, and the one that would be wanted there if nothing bent, mm.
    pub fn wanted(&self, sizing: &Sizing, p: DVec3, w: WallId) -> (f64, f64) {
        let walls = self.walls;
        let target = self.targets.map_or(sizing.target, |targets| {
            let whole = self.pieces.iter().fold(w, |w, cut| cut.whole(w));
            targets.at(walls, p, whole, w)
        });
        let sizing = Sizing { target, ..*sizing };
        let thickness = walls.mean_thickness(w);
        let bend = sizing.at(walls.curvature_radius(p, w), thickness);
        let size = bend.min(sizing.at_step(walls.step_radius(p, w), thickness));
        (size, target)
    }

    /// The edge lengths wanted for quads at a place on a wall: along a bend longer than across it.
    pub fn lengths(&self, sizing: &Sizing) -> impl Fn(DVec3, WallId) -> Lengths + Sync {
        let walls = self.walls;
        move |p, w| {
            let (size, target) = self.wanted(sizing, p, w);
            // Where the wall bends, a square has to be smaller than a triangle to leave it as little: its diagonal is longer.
            let across = |share: f64| {
                let share = share.lerp(1.0, (size / target).clamp(0.0, 1.0));
                (size * share).max(sizing.least.min(target))
            };
            let thickness = walls.mean_thickness(w);
            let along = |(axis, radius)| {
                let sizing = Sizing { target, ..*sizing };
                let most = sizing
                    .at(radius / SLIGHT, thickness)
                    .min(sizing.at_step(walls.step_radius(p, w), thickness));
                let across = across(LONG_AT_BENDS);
                let along = LONGEST * across;
                (size < TIGHT * target && along <= most).then_some(Lengths {
                    axis,
                    along,
                    across,
                })
            };
            (walls.lengthwise(p, w))
                .and_then(along)
                .unwrap_or_else(|| Lengths::equal(across(SQUARE_AT_BENDS)))
        }
    }

    /// Of every triangle the area, mm², and the edge length wanted in its middle, mm.
    pub fn asked(&self, complex: &MidComplex, sizing: &Sizing) -> Vec<(f64, f64)> {
        let field = self.field(sizing);
        (complex.triangles.as_slice().par_iter())
            .map(|t| {
                let [a, b, c] = complex.corners(t);
                (
                    complex.area_vector(t).length(),
                    field((a + b + c) / 3.0, t.wall),
                )
            })
            .collect()
    }
}
