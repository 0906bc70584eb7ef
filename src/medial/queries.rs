//! What stages ask of the medial surfaces: places, normals, thickness, bends.

use super::{Held, Known, LEAST_OPPOSITION, Medial, STEPS};
use crate::geom::placer::Placer;
use crate::model::complex::{Support, pin};
use crate::model::ids::WallId;
use glam::DVec3;

/// The mid-surface of a step bends this near to its inner edge, in thicknesses: the parabola ends within one, and as far again sizes grow.
const STEP_REACH: f64 = 2.0;

/// Radii of concentric arcs differ by the thickness; by more than this many times that arcs are not concentric.
const CONCENTRIC: f64 = 1.5;

/// A wall bends one way or the other where its radius is less than a million thicknesses.
const NO_BEND: f64 = 1e-6;

impl Medial<'_> {
    /// Radius with which the mid-surface climbs at a step near `point`, mm; infinite where there is none within reach.
    pub fn step_radius(&self, point: DVec3, wall: WallId) -> f64 {
        let reach = STEP_REACH * self.thickness[wall];
        let [a, b] = (self.sides[wall].each_ref()).map(|s| s.inner_edges.radius(point, reach));
        a.min(b)
    }
}

impl Placer for Medial<'_> {
    fn place(&self, start: DVec3, supports: &[Support]) -> DVec3 {
        if pin(supports).is_some() {
            return start;
        }
        let (p, sure) = self.converge(start, supports, STEPS);
        self.held(start, p, sure, supports)
    }

    fn draw(&self, start: DVec3, supports: &[Support]) -> DVec3 {
        if pin(supports).is_some() {
            return start;
        }
        let (p, sure) = self.converge(start, supports, 1);
        self.held(start, p, sure, supports)
    }

    fn to_middle(&self, point: DVec3, wall: WallId) -> Option<(DVec3, f64)> {
        let support = Support::Mid(wall);
        let near = self.plane(point, support, &mut Known::default(), f64::INFINITY);
        near.map(|tangent| tangent.plane)
    }

    fn normal(&self, point: DVec3, wall: WallId) -> Option<DVec3> {
        if let Some([a, b]) = self.planes(wall) {
            return (a.normal - b.normal).try_normalize();
        }
        let [a, b] = self.feet(point, wall)?;
        if let Some(tangent) = self.straight_on(point, wall, [a, b]) {
            return Some(tangent.plane.0);
        }
        let across = a.normal - b.normal;
        if across.length() > LEAST_OPPOSITION {
            return across.try_normalize();
        }
        (a.way(point).0 - b.way(point).0).try_normalize()
    }

    fn thickness(&self, point: DVec3, wall: WallId) -> Option<f64> {
        if let Some([a, b]) = self.planes(wall) {
            return Some(a.depth(point) + b.depth(point));
        }
        let [a, b] = self.feet(point, wall)?;
        if let Some(tangent) = self.straight_on(point, wall, [a, b]) {
            return Some(tangent.thickness);
        }
        Some(a.depth(point) + b.depth(point))
    }

    fn beyond(&self, point: DVec3, wall: WallId) -> f64 {
        self.feet(point, wall)
            .map_or(f64::INFINITY, |[a, b]| a.beyond(point).max(b.beyond(point)))
    }

    fn outside(&self, point: DVec3, wall: WallId) -> bool {
        Held::new(self).leaves(point, wall)
    }

    fn curvature_radius(&self, point: DVec3, wall: WallId) -> f64 {
        if self.planes(wall).is_some() {
            return f64::INFINITY;
        }
        let Some([a, b]) = self.feet(point, wall) else {
            return f64::INFINITY;
        };
        if self.straight_on(point, wall, [a, b]).is_some() {
            return f64::INFINITY;
        }
        let curvatures = [a, b].map(|f| self.ground.curvature[f.facet]);
        middle_radius(curvatures, self.thickness[wall]).min(self.step_radius(point, wall))
    }

    fn lengthwise(&self, point: DVec3, wall: WallId) -> Option<(DVec3, f64)> {
        if self.planes(wall).is_some() {
            return None;
        }
        let [a, b] = self.feet(point, wall)?;
        let [k, l] = [a, b].map(|f| self.ground.bends[f.facet]);
        // Where not one side bulges and the other is hollow, as in a bend, it is the thickness that changes.
        if k.most * l.most >= 0.0 {
            return None;
        }
        let (foot, bend) = if k.most.abs() >= l.most.abs() {
            (a, k)
        } else {
            (b, l)
        };
        let axis = bend.way.cross(foot.normal).try_normalize()?;
        let radius = middle_radius([k.least, l.least], self.thickness[wall]);
        // Rounding makes a flat facet bend a little, some way.
        (bend.most.abs() * self.thickness[wall] > NO_BEND).then_some((axis, radius))
    }
}

/// Radius of the middle between two sides of these curvatures (1/mm, above zero where the side bulges), mm.
fn middle_radius([k, l]: [f64; 2], thickness: f64) -> f64 {
    let (r, s) = (1.0 / k.abs(), 1.0 / l.abs());
    if k * l > 0.0 {
        // Both bulge, or both are hollow: the middle bends less, but the thickness changes by as much, and wants as short edges.
        2.0 / (k + l).abs()
    } else if (r - s).abs() <= CONCENTRIC * thickness {
        // The middle of two concentric arcs.
        (r + s) / 2.0
    } else {
        // Where one side is flat, or much flatter than that, the other's word counts for half.
        2.0 * r.min(s)
    }
}
