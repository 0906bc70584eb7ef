//! The one question that meshing asks of the geometry: where does a node belong?

use crate::model::complex::Support;
use crate::model::ids::WallId;
use glam::DVec3;

/// Wanted edge length, mm, at a point of a wall.
pub type SizeField<'a> = dyn Fn(DVec3, WallId) -> f64 + Sync + 'a;

/// Wanted edge lengths, along an axis and across it, at a point of a wall.
pub type LengthField<'a> = dyn Fn(DVec3, WallId) -> Lengths + Sync + 'a;

/// Wanted edge lengths at a place: where a wall bends one way only, edges along the bend may be longer than those across it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Lengths {
    /// Unit direction of the longer ones; zero where all are equal.
    pub axis: DVec3,
    /// Length along the axis, mm.
    pub along: f64,
    /// Length across it, mm.
    pub across: f64,
}

impl Lengths {
    /// The same length every way.
    pub fn equal(length: f64) -> Self {
        Self {
            axis: DVec3::ZERO,
            along: length,
            across: length,
        }
    }

    /// The length in a direction (of any length), mm: the radius of the ellipse.
    pub fn towards(&self, way: DVec3) -> f64 {
        let cos = way.normalize_or_zero().dot(self.axis);
        let inverse = (cos / self.along).powi(2) + (1.0 - cos * cos) / self.across.powi(2);
        inverse.sqrt().recip()
    }
}

/// Puts points on the surfaces that they must lie on, and tells the wall's thickness there.
///
/// Implemented by the exact mid-surface of the part; tests implement it by closed forms (plane, cylinder, sphere).
pub trait Placer: Sync {
    /// The point near `start` that lies on every one of `supports` (least squares where they do not meet); `start` itself where
    /// the supports say nothing, or hold a place of its own. Never moves a point by more than a few thicknesses.
    fn place(&self, start: DVec3, supports: &[Support]) -> DVec3;

    /// A point nearer to where [`place`](Self::place) would put `start`, at a fraction of the cost: enough while a node still moves.
    fn draw(&self, start: DVec3, supports: &[Support]) -> DVec3 {
        self.place(start, supports)
    }

    /// The unit normal of the wall's mid-surface near `point`, and how far along it `point` would have to go to lie on it, mm.
    fn to_middle(&self, point: DVec3, wall: WallId) -> Option<(DVec3, f64)> {
        let normal = self.normal(point, wall)?;
        let way = self.place(point, &[Support::Mid(wall)]) - point;
        Some((normal, way.dot(normal)))
    }

    /// Unit normal of the wall's mid-surface near `point`, pointing from its second side to its first; `None` where undefined.
    fn normal(&self, point: DVec3, wall: WallId) -> Option<DVec3>;

    /// Thickness of the wall near `point`, mm; `None` where one side is missing.
    fn thickness(&self, point: DVec3, wall: WallId) -> Option<f64>;

    /// How far `point` lies beyond the ends of the wall's sides, mm, the further of the two; zero over both. Surfaces in closed form have no end.
    fn beyond(&self, point: DVec3, wall: WallId) -> f64 {
        let _ = (point, wall);
        0.0
    }

    /// Whether `point`, on or near the wall, lies outside the material by more than rounding and the sag of facets. Surfaces in closed form have no outside.
    fn outside(&self, point: DVec3, wall: WallId) -> bool {
        let _ = (point, wall);
        false
    }

    /// Radius of the tightest curvature of the wall's mid-surface near `point`, mm; infinite where it is flat.
    fn curvature_radius(&self, point: DVec3, wall: WallId) -> f64;

    /// Unit direction in which the wall bends least near `point`, and the radius of its mid-surface that way, mm; `None` where it does not bend as a whole, or nothing is known.
    fn lengthwise(&self, point: DVec3, wall: WallId) -> Option<(DVec3, f64)> {
        let _ = (point, wall);
        None
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lengths_are_radii_of_an_ellipse() {
        let lengths = Lengths {
            axis: DVec3::Z,
            along: 4.0,
            across: 1.0,
        };
        assert_eq!(lengths.towards(DVec3::Z * 7.0), 4.0);
        assert_eq!(lengths.towards(DVec3::X), 1.0);
        let slant = lengths.towards(DVec3::X + DVec3::Z);
        assert!((slant - (2.0f64 / (1.0 + 1.0 / 16.0)).sqrt()).abs() < 1e-12);
        assert!((Lengths::equal(3.0).towards(DVec3::new(1.0, 2.0, 3.0)) - 3.0).abs() < 1e-12);
    }
}
