//! Questions to one flat triangle in space: the nearest point, and where a ray goes through.
//!
//! Guarantees: answers are finite for finite input, slivers and points included; a ray never slips between two triangles that share
//! a side, because the side's test gives both of them the same number with opposite sign.
//!
//! References: Woop, Benthin and Wald, "Watertight ray/triangle intersection", JCGT 2 (1), 2013.

use glam::DVec3;

/// Triangles flatter than this (height over base) are taken as their sides: the normal of a flatter one is rounding noise, and
/// the error made by leaving the inside out is at most half of that height.
const SLIVER: f64 = 1e-10;

/// The point of the segment that is nearest to `p`.
#[inline]
pub fn nearest_on_segment(a: DVec3, b: DVec3, p: DVec3) -> DVec3 {
    let d = b - a;
    let along = (p - a).dot(d);
    let length2 = d.length_squared();
    if along <= 0.0 || length2 == 0.0 {
        a
    } else if along >= length2 {
        b
    } else {
        a + d * (along / length2)
    }
}

/// The point of the triangle that is nearest to `p`.
#[inline]
pub fn nearest_on_triangle([a, b, c]: [DVec3; 3], p: DVec3) -> DVec3 {
    let (ab, bc, ca) = (b - a, c - b, a - c);
    let normal = ab.cross(-ca);
    let n2 = normal.length_squared();
    let longest2 = ab
        .length_squared()
        .max(bc.length_squared())
        .max(ca.length_squared());
    if n2 > SLIVER * SLIVER * longest2 * longest2
        && normal.dot(ab.cross(p - a)) >= 0.0
        && normal.dot(bc.cross(p - b)) >= 0.0
        && normal.dot(ca.cross(p - c)) >= 0.0
    {
        return p - normal * (normal.dot(p - a) / n2);
    }
    let mut best = nearest_on_segment(a, b, p);
    let mut d2 = best.distance_squared(p);
    for (u, v) in [(b, c), (c, a)] {
        let q = nearest_on_segment(u, v, p);
        let e2 = q.distance_squared(p);
        if e2 < d2 {
            (best, d2) = (q, e2);
        }
    }
    best
}

/// Where a ray meets a triangle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RayHit {
    /// Distance along the ray, in units of its direction's length; may be negative.
    pub t: f64,
    /// Weights of the three corners: non-negative, sum one.
    pub weights: [f64; 3],
    /// Whether the ray runs against the normal (it comes from the front side).
    pub front: bool,
}

/// A ray made ready for many triangles.
#[derive(Clone, Copy, Debug)]
pub struct Ray {
    /// Where it starts.
    pub origin: DVec3,
    /// Where it goes; any length but zero.
    pub direction: DVec3,
    axes: [usize; 3],
    shear: DVec3,
}

impl Ray {
    /// A ray from `origin` along `direction` (any length but zero).
    pub fn new(origin: DVec3, direction: DVec3) -> Self {
        let size = direction.abs();
        let kz = if size.x >= size.y && size.x >= size.z {
            0
        } else if size.y >= size.z {
            1
        } else {
            2
        };
        let (mut kx, mut ky) = ((kz + 1) % 3, (kz + 2) % 3);
        // Keeps the winding, so that the sign of the determinant tells the side.
        if direction[kz] < 0.0 {
            std::mem::swap(&mut kx, &mut ky);
        }
        let dz = direction[kz];
        Self {
            origin,
            direction,
            axes: [kx, ky, kz],
            shear: DVec3::new(direction[kx] / dz, direction[ky] / dz, 1.0 / dz),
        }
    }

    /// Where the whole line meets the triangle; `None` past its sides, and where the triangle is seen edge-on.
    #[inline]
    pub fn meets(&self, corners: [DVec3; 3]) -> Option<RayHit> {
        // With the axes known to the compiler no coordinate is picked at run time.
        match self.axes {
            [1, 2, 0] => self.meets_along::<1, 2, 0>(corners),
            [2, 1, 0] => self.meets_along::<2, 1, 0>(corners),
            [2, 0, 1] => self.meets_along::<2, 0, 1>(corners),
            [0, 2, 1] => self.meets_along::<0, 2, 1>(corners),
            [0, 1, 2] => self.meets_along::<0, 1, 2>(corners),
            _ => self.meets_along::<1, 0, 2>(corners),
        }
    }

    #[inline]
    fn meets_along<const X: usize, const Y: usize, const Z: usize>(
        &self,
        corners: [DVec3; 3],
    ) -> Option<RayHit> {
        let [a, b, c] = corners.map(|p| {
            let q = p - self.origin;
            DVec3::new(
                q[X] - self.shear.x * q[Z],
                q[Y] - self.shear.y * q[Z],
                q[Z] * self.shear.z,
            )
        });
        let u = c.x * b.y - c.y * b.x;
        let v = a.x * c.y - a.y * c.x;
        let w = b.x * a.y - b.y * a.x;
        if (u < 0.0 || v < 0.0 || w < 0.0) && (u > 0.0 || v > 0.0 || w > 0.0) {
            return None;
        }
        let det = u + v + w;
        if det == 0.0 {
            return None;
        }
        let weights = [u / det, v / det, w / det];
        let t = weights[0] * a.z + weights[1] * b.z + weights[2] * c.z;
        t.is_finite().then_some(RayHit {
            t,
            weights,
            front: det > 0.0,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const T: [DVec3; 3] = [
        DVec3::ZERO,
        DVec3::new(4.0, 0.0, 0.0),
        DVec3::new(0.0, 3.0, 0.0),
    ];

    #[test]
    fn nearest_over_the_inside_the_sides_and_the_corners() {
        for (p, q) in [
            (DVec3::new(1.0, 1.0, 5.0), DVec3::new(1.0, 1.0, 0.0)),
            (DVec3::new(2.0, -7.0, 1.0), DVec3::new(2.0, 0.0, 0.0)),
            (DVec3::new(-1.0, -1.0, -1.0), DVec3::ZERO),
            (DVec3::new(9.0, -1.0, 0.0), DVec3::new(4.0, 0.0, 0.0)),
            (
                DVec3::new(2.0 + 3.0, 1.5 + 4.0, 2.0),
                DVec3::new(2.0, 1.5, 0.0),
            ),
        ] {
            assert!((nearest_on_triangle(T, p) - q).length() < 1e-14, "{p}");
        }
    }

    #[test]
    fn slivers_and_points_have_a_nearest_point() {
        let a = DVec3::new(1.0, 2.0, 3.0);
        assert_eq!(nearest_on_triangle([a; 3], DVec3::ZERO), a);
        let line = [
            DVec3::ZERO,
            DVec3::new(2.0, 0.0, 0.0),
            DVec3::new(1.0, 1e-14, 0.0),
        ];
        let q = nearest_on_triangle(line, DVec3::new(0.5, 1.0, 0.0));
        assert!((q - DVec3::new(0.5, 0.0, 0.0)).length() < 1e-13);
    }

    #[test]
    fn a_ray_knows_the_distance_the_side_and_misses() {
        let down = Ray::new(DVec3::new(1.0, 1.0, 6.0), DVec3::new(0.0, 0.0, -2.0));
        let hit = down.meets(T).unwrap();
        assert!((hit.t - 3.0).abs() < 1e-15 && hit.front);
        assert!(!down.meets([T[0], T[2], T[1]]).unwrap().front);
        let up = Ray::new(DVec3::new(1.0, 1.0, 6.0), DVec3::Z);
        assert!((up.meets(T).unwrap().t + 6.0).abs() < 1e-15);
        assert!(
            Ray::new(DVec3::new(3.0, 3.0, 1.0), -DVec3::Z)
                .meets(T)
                .is_none()
        );
        assert!(Ray::new(DVec3::ZERO, DVec3::X).meets(T).is_none());
    }

    #[test]
    fn no_ray_slips_through_a_shared_side() {
        let (a, b) = (DVec3::new(0.1, 0.7, 0.3), DVec3::new(0.9, -0.2, 0.45));
        let (c, d) = (DVec3::new(-1.0, -1.0, 0.2), DVec3::new(1.3, 1.1, 0.1));
        let from = DVec3::new(0.33, 0.21, -5.0);
        for i in 1..1000 {
            let on_side = a + (b - a) * (f64::from(i) / 1000.0);
            let ray = Ray::new(from, on_side - from);
            assert!(ray.meets([a, b, c]).is_some() || ray.meets([b, a, d]).is_some());
        }
    }
}
