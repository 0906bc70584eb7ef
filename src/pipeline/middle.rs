//! The mid-surfaces of a solid's walls as the stages after the choice of walls ask for them: as what places nodes, and for the edge length wanted at a place.

use crate::geom::placer::Placer;
use crate::medial::{Held, Medial};
use crate::model::complex::MidComplex;
use crate::model::ids::WallId;
use crate::stage::size::Sizing;
use glam::DVec3;
use rayon::prelude::*;

/// The mid-surfaces, held in the material where sheets would leave it otherwise.
#[derive(Clone, Debug)]
pub(super) struct Middle<'a> {
    /// The mid-surfaces as such.
    pub walls: &'a Medial<'a>,
    held: Option<Held<'a>>,
}

impl<'a> Middle<'a> {
    /// `leaves`: sheets would leave the material.
    pub fn new(walls: &'a Medial<'a>, leaves: bool) -> Self {
        Self {
            walls,
            held: leaves.then(|| Held::new(walls)),
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
        let walls = self.walls;
        move |p, w| {
            let thickness = walls.mean_thickness(w);
            let bend = sizing.at(walls.curvature_radius(p, w), thickness);
            bend.min(sizing.at_step(walls.step_radius(p, w), thickness))
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
