//! How thick a lump is that a sheet runs through.
//!
//! A sheet that is carried on into a block, to meet another there, is not midway between two sides any more, and the thickness of its wall says nothing of the material
//! around it. What does is the largest ball in the material that holds the place: the local thickness of T. Hildebrand and P. Rüegsegger, "A new method for the
//! model-independent assessment of thickness in three-dimensional images", J. Microscopy 185 (1997), DOI 10.1046/j.1365-2818.1997.1340694.x. Balls are tried whose centres lie
//! on the normal, for a plate under a block finds the block straight above, and are moved uphill from there.

use crate::model::brep::Brep;
use crate::spatial::TriangleBvh;
use glam::DVec3;

/// Where the largest ball is thicker than the wall by this factor, the place is in a lump: where two walls of one thickness meet, it is thicker by 1.25 at sharp corners and by
/// less than 2 with fillets as wide as the wall.
const LUMP: f64 = 2.0;
/// Centres tried on the normal, to begin with: so many spread over the way through the material,
const SPREAD: u32 = 16;
/// and so many on either side of the place, the first a quarter of the wall's thickness away, each next twice as far.
const NEAR: i32 = 10;
/// Steps uphill, each as long as the last or half as long.
const STEPS: usize = 24;

/// The material of a solid, made ready to be asked for balls.
pub(super) struct Material {
    boundary: TriangleBvh,
}

impl Material {
    pub fn new(brep: &Brep) -> Self {
        let flat: Vec<[DVec3; 3]> = (brep.facets.ids()).map(|f| brep.corners(f)).collect();
        Self {
            boundary: TriangleBvh::new(&flat),
        }
    }

    /// Diameter of the largest ball in the material that holds `at` and is reached from the line through it along the unit vector `normal`, if it is a lump's for a wall of this
    /// thickness.
    pub fn lump(&self, at: DVec3, normal: DVec3, thickness: f64) -> Option<f64> {
        let [ahead, behind] = self.boundary.first_distances(at, normal, f64::INFINITY);
        let across = ahead + behind;
        // A ball on the line is no wider than the way through it, and one beside it seldom.
        if !across.is_finite() || across <= LUMP * thickness {
            return None;
        }
        let near = (0..NEAR).map(|k| 0.25 * thickness * 2f64.powi(k));
        let near = near.flat_map(|off| [off, -off]).chain([0.0]);
        let spread =
            (0..SPREAD).map(|i| (f64::from(i) + 0.5) / f64::from(SPREAD) * across - behind);
        let offsets = near.chain(spread);
        let diameter = offsets
            .filter(|off| (-behind..ahead).contains(off))
            .filter_map(|off| {
                let ball = self.ball(at + normal * off, at)?;
                Some(2.0 * self.grown(ball, at).radius)
            })
            .fold(0.0, f64::max);
        (diameter > LUMP * thickness).then_some(diameter)
    }

    /// The largest ball round `centre`, if it holds `at`.
    fn ball(&self, centre: DVec3, at: DVec3) -> Option<Ball> {
        let near = self.boundary.nearest(centre)?;
        (near.distance >= centre.distance(at)).then_some(Ball {
            centre,
            radius: near.distance,
            touches: near.point,
        })
    }

    /// Moves a ball away from where it touches the boundary, as long as it grows and holds `at`.
    fn grown(&self, mut ball: Ball, at: DVec3) -> Ball {
        let mut step = ball.radius / 2.0;
        for _ in 0..STEPS {
            let Some(away) = (ball.centre - ball.touches).try_normalize() else {
                break;
            };
            match self.ball(ball.centre + away * step, at) {
                Some(next) if next.radius > ball.radius => ball = next,
                _ => step /= 2.0,
            }
        }
        ball
    }
}

/// A ball in the material.
struct Ball {
    centre: DVec3,
    radius: f64,
    /// The point of the boundary nearest to its centre.
    touches: DVec3,
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::test_parts::voxels::{Filled, motion, plate_with_block, tee, thin_parts};

    /// Diameter for a wall 2 thick with this normal, and 0 where there is no lump.
    fn lump(solid: &Filled, at: [f64; 3], normal: DVec3) -> f64 {
        let material = Material::new(&solid.brep);
        let found = material.lump(DVec3::from(at), normal, 2.0);
        found.unwrap_or(0.0)
    }

    #[test]
    fn a_plate_under_a_block_is_as_thick_as_the_largest_ball_that_reaches_down_to_its_middle() {
        // The block is 12 wide and with the plate 12 high: one ball fills it, and reaches the plate's middle up to 11^0.5 from the axis.
        let solid = plate_with_block();
        for off in [0.0, 1.0, 2.0, 3.0] {
            let found = lump(&solid, [30.0 + off, 20.0, 1.0], DVec3::Z);
            assert!((11.5..=12.0 + 1e-9).contains(&found), "{off}: {found}");
        }
        // Nearer to the side of the block the ball is smaller, at the side there is none.
        let beside = lump(&solid, [30.0 + 4.5, 20.0, 1.0], DVec3::Z);
        assert!((4.0..11.5).contains(&beside), "{beside}");
        // Beside the block there is the plate alone.
        assert_eq!(lump(&solid, [20.0, 20.0, 1.0], DVec3::Z), 0.0);
    }

    #[test]
    fn the_other_side_a_motion_and_a_scale_change_nothing() {
        let solid = plate_with_block();
        let at = DVec3::new(31.0, 20.5, 1.0);
        let found = lump(&solid, at.into(), DVec3::Z);
        assert!(found > 8.0);
        // Which of two faces as near a ball is said to touch is left to rounding, and so is the last of its way uphill.
        let same = |a: f64, b: f64| (a - b).abs() < 1e-3 * b;
        let other = lump(&solid, at.into(), DVec3::NEG_Z);
        assert!(same(other, found), "{other} {found}");
        let moved = lump(
            &solid.mapped(motion),
            motion(at).into(),
            motion(DVec3::Z) - motion(DVec3::ZERO),
        );
        assert!(same(moved, found), "{moved} {found}");
        let small = solid.mapped(|p| p * 1e-3);
        let material = Material::new(&small.brep);
        let scaled = material.lump(at * 1e-3, DVec3::Z, 2e-3).unwrap();
        assert!(same(scaled, found * 1e-3), "{scaled} {found}");
    }

    #[test]
    fn a_junction_of_walls_of_one_thickness_is_no_lump() {
        let solid = tee(1);
        for at in [1.0, 1.5, 2.0, 5.0] {
            assert_eq!(lump(&solid, [20.0, 12.0, at], DVec3::Y), 0.0);
        }
        assert_eq!(lump(&solid, [20.0, 12.0, 1.0], DVec3::Z), 0.0);
        for (name, solid, _) in thin_parts() {
            let stages = crate::test_parts::stages::stages(&solid);
            let mesh = super::super::shell(
                &solid.brep,
                &stages.pairing,
                &stages.medial(),
                &stages.complex(),
            );
            let lumps = mesh.elements.iter().any(|e| e.unsure);
            assert_eq!(lumps, name.contains("block"), "{name}");
        }
    }
}
