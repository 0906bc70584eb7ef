//! The mid-surface held inside the material.
//!
//! Where the two sides of a wall end, their tangent planes go on, so that sheets meet within the block where walls join. In a hub, a boss or between the round ends
//! of slots there may be no block to meet in: what goes on leaves the material. A node that would come to lie outside is put onto the nearest place of the boundary.
//!
//! Guarantee: no placed node is further outside than [`LEAK`]. Limit: elements between such nodes may still cut a corner of the boundary.
//! Cost: a search of the near boundary and a ray a placing.

use super::Medial;
use crate::geom::placer::Placer;
use crate::model::complex::{MidComplex, Support, pin};
use crate::model::ids::WallId;
use glam::DVec3;
use rayon::prelude::*;

/// A point this little outside, in thicknesses, is on the boundary: far above rounding and what six-node facets miss of a face, far below what is seen of a mesh.
const LEAK: f64 = 0.01;

/// Places points as the medial surfaces do, but never outside the material.
#[derive(Clone, Debug)]
pub struct Held<'a> {
    medial: &'a Medial<'a>,
}

impl<'a> Held<'a> {
    /// Holds what these surfaces place.
    pub fn new(medial: &'a Medial<'a>) -> Self {
        Self { medial }
    }

    /// Share of the area of a complex whose triangles have their middles outside the material.
    pub fn outside(&self, complex: &MidComplex) -> f64 {
        let areas: Vec<(f64, bool)> = complex
            .triangles
            .as_slice()
            .par_iter()
            .map(|t| {
                let [a, b, c] = complex.corners(t);
                let middle = (a + b + c) / 3.0;
                let area = complex.area_vector(t).length();
                (area, self.leaves(middle, t.wall))
            })
            .collect();
        let sum = |only: bool| -> f64 { areas.iter().filter(|a| a.1 || !only).map(|a| a.0).sum() };
        sum(true) / sum(false).max(f64::MIN_POSITIVE)
    }

    /// Whether a place on a wall would be put back.
    pub(super) fn leaves(&self, p: DVec3, wall: WallId) -> bool {
        self.held(p, &[Support::Mid(wall)]) != p
    }

    /// Thickness of the thinnest wall among the supports, of a typical one where there is none, mm.
    fn thinnest(&self, supports: &[Support]) -> f64 {
        let of = |support: &Support| match support {
            Support::Mid(w) => self.medial.thickness[*w],
            Support::Face(_) | Support::Edge(_) | Support::Pin(_) => f64::INFINITY,
        };
        let thinnest = supports.iter().map(of).fold(f64::INFINITY, f64::min);
        if thinnest.is_finite() {
            thinnest
        } else {
            self.medial.typical
        }
    }

    /// The point itself, or the nearest place of the boundary if it lies outside.
    fn held(&self, p: DVec3, supports: &[Support]) -> DVec3 {
        if pin(supports).is_some() {
            return p;
        }
        let skin = &self.medial.ground.material.skin;
        let tolerance = LEAK * self.thinnest(supports);
        if skin.bvh.any_within(p, tolerance).is_some() || skin.bvh.inside(p) {
            return p;
        }
        match self.medial.foot(skin, p, &mut None) {
            // Straight below a foot is the material under the bulge of a curved facet.
            Some(foot)
                if foot.point.distance(p) > tolerance
                    && !(foot.is_plumb(p) && foot.depth(p) > -tolerance) =>
            {
                foot.point
            }
            _ => p,
        }
    }
}

impl Placer for Held<'_> {
    fn place(&self, start: DVec3, supports: &[Support]) -> DVec3 {
        self.held(self.medial.place(start, supports), supports)
    }

    fn draw(&self, start: DVec3, supports: &[Support]) -> DVec3 {
        self.held(self.medial.draw(start, supports), supports)
    }

    fn to_middle(&self, point: DVec3, wall: WallId) -> Option<(DVec3, f64)> {
        self.medial.to_middle(point, wall)
    }

    fn normal(&self, point: DVec3, wall: WallId) -> Option<DVec3> {
        self.medial.normal(point, wall)
    }

    fn thickness(&self, point: DVec3, wall: WallId) -> Option<f64> {
        self.medial.thickness(point, wall)
    }

    fn beyond(&self, point: DVec3, wall: WallId) -> f64 {
        self.medial.beyond(point, wall)
    }

    fn outside(&self, point: DVec3, wall: WallId) -> bool {
        self.leaves(point, wall)
    }

    fn curvature_radius(&self, point: DVec3, wall: WallId) -> f64 {
        self.medial.curvature_radius(point, wall)
    }

    fn lengthwise(&self, point: DVec3, wall: WallId) -> Option<(DVec3, f64)> {
        self.medial.lengthwise(point, wall)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::stage::adjacency::adjacency;
    use crate::stage::pair::{PairOptions, pair, sight};
    use crate::test_parts::stages::stages;
    use crate::test_parts::tube_brep;
    use crate::test_parts::voxels::{plate, tee};

    #[test]
    fn a_sheet_that_would_leave_the_plate_stays_at_its_boundary() {
        let solid = plate(1);
        let stages = stages(&solid);
        let medial = stages.medial();
        let held = Held::new(&medial);
        // A rim on one end face, beyond the end of the other.
        let end = solid.face(|p| p.x == 40.0);
        let rim = [Support::Mid(WallId(0)), Support::Face(end)];
        let beyond = DVec3::new(39.5, 26.0, 1.3);
        let near = |p: DVec3, x: f64, y: f64, z: f64| p.distance(DVec3::new(x, y, z)) < 1e-9;
        // Unheld it goes on.
        assert!(near(medial.place(beyond, &rim), 40.0, 26.0, 1.0));
        for placed in [held.place(beyond, &rim), held.draw(beyond, &rim)] {
            assert!(near(placed, 40.0, 24.0, 1.0), "{placed}");
        }
        // Nothing pulls at it: then it is only held.
        let free = held.place(DVec3::new(20.0, 12.0, 5.0), &[]);
        assert!(free.distance(DVec3::new(20.0, 12.0, 2.0)) < 1e-9, "{free}");
    }

    #[test]
    fn what_lies_in_the_material_or_on_its_boundary_is_placed_as_ever() {
        let solid = tee(1);
        let stages = stages(&solid);
        let medial = stages.medial();
        let held = Held::new(&medial);
        let end = solid.face(|p| p.x == 40.0);
        let walls: Vec<WallId> = stages.pairing.walls.ids().collect();
        for p in [
            DVec3::new(3.0, 5.0, 0.4),
            DVec3::new(12.0, 12.2, 1.4),
            DVec3::new(20.0, 11.5, 1.9),
        ] {
            for supports in [
                &[Support::Mid(walls[0])][..],
                &[Support::Mid(walls[1])],
                &[Support::Mid(walls[0]), Support::Mid(walls[1])],
            ] {
                let free = medial.place(p, supports);
                let inside = free.cmpge(DVec3::ZERO).all() && free.z <= 2.0;
                assert!(!inside || held.place(p, supports) == free, "{p} {free}");
            }
        }
        let rim = [Support::Mid(WallId(0)), Support::Face(end)];
        let p = DVec3::new(39.5, 4.0, 0.7);
        assert_eq!(held.place(p, &rim), medial.place(p, &rim));
    }

    #[test]
    fn the_bulge_of_curved_facets_is_material() {
        // Flat facets of ten degrees leave a circle of 10 by 0.04, twice the leak of a wall of 2.
        let brep = tube_brep(10.0, 8.0, 30.0, 36);
        let aag = adjacency(&brep);
        let pairing = pair(&brep, &aag, &sight(&brep), &PairOptions::default());
        let medial = Medial::new(&brep, &aag, &pairing);
        let held = Held::new(&medial);
        for degrees in [5.0f64, 2.0, 12.5] {
            let (sin, cos) = degrees.to_radians().sin_cos();
            let at = |r: f64| DVec3::new(r * cos, r * sin, 11.0);
            let inside = at(9.99);
            assert_eq!(held.place(inside, &[]), inside, "{degrees}");
            let back = held.place(at(10.5), &[]);
            assert!(
                (back.truncate().length() - 10.0).abs() < 3e-3,
                "{degrees}: {back}"
            );
        }
    }
}
