//! A six-node facet made ready for many nearest-point questions: its polynomial, its flat normal and how far it bends.
//!
//! Guarantee: the answers of [`super::nearest_on_quadratic`] to rounding; a flat facet's are those of its flat triangle.

use super::{Polynomial, flat_parameters, nearest_parameters, unit_normal};
use glam::DVec3;

/// A facet whose mid-side points lie off the middles of its sides by less than this share of their length is flat.
const FLAT: f64 = 1e-9;

/// Far above the rounding of a distance, far below any that tells facets apart, relative.
const ROUNDING: f64 = 1.0 + 1e-9;

/// A six-node facet with what every nearest-point question needs.
#[derive(Clone, Copy, Debug)]
pub struct ReadyFacet {
    corners: [DVec3; 3],
    curved: Polynomial,
    flat_normal: DVec3,
    sags: [f64; 3],
    sag: f64,
    /// A ball that holds the flat triangle.
    middle: DVec3,
    radius: f64,
}

impl ReadyFacet {
    /// Of corners and mid-side points on sides (0,1), (1,2), (2,0).
    pub fn new(corners: [DVec3; 3], mids: [DVec3; 3]) -> Self {
        let facet = super::QuadraticTriangle { corners, mids };
        let sags = [0, 1, 2].map(|k| facet.sag(k));
        let most = sags[0].max(sags[1]).max(sags[2]);
        let bends = most > FLAT * corners[0].distance(corners[1]);
        let middle = (corners[0] + corners[1] + corners[2]) / 3.0;
        let radius = corners.iter().map(|c| c.distance(middle));
        Self {
            corners,
            curved: facet.polynomial(),
            flat_normal: (corners[1] - corners[0])
                .cross(corners[2] - corners[0])
                .normalize_or_zero(),
            sags,
            sag: if bends { most } else { 0.0 },
            middle,
            radius: radius.fold(0.0, f64::max) * ROUNDING,
        }
    }

    /// Its corners.
    #[inline]
    pub fn corners(&self) -> [DVec3; 3] {
        self.corners
    }

    /// Unit normal of its flat triangle.
    #[inline]
    pub fn flat_normal(&self) -> DVec3 {
        self.flat_normal
    }

    /// How far its mid-side points lie off the middles of its sides; zero where it is flat to rounding.
    #[inline]
    pub fn sag(&self) -> f64 {
        self.sag
    }

    /// A lower bound on the distance of `p` from its flat triangle; may be negative.
    #[inline]
    pub fn least_distance(&self, p: DVec3) -> f64 {
        self.middle.distance(p) / ROUNDING - self.radius
    }

    /// The nearest point to `p` and the unit normal there. `flat`: the nearest point of its flat triangle.
    #[inline]
    pub fn nearest(&self, p: DVec3, flat: DVec3) -> (DVec3, DVec3) {
        self.nearest_within(p, flat, f64::INFINITY)
    }

    /// The same, but where the nearest point is further away than the square root of `most` it may be any other that is.
    #[inline]
    pub fn nearest_within(&self, p: DVec3, flat: DVec3, most: f64) -> (DVec3, DVec3) {
        if self.sag == 0.0 {
            return (flat, self.flat_normal);
        }
        let start = flat_parameters(self.corners, flat);
        let w = nearest_parameters(&self.curved, &self.corners, &self.sags, p, start, most);
        (
            self.curved.at(w),
            unit_normal(&self.curved, &self.corners, w),
        )
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geom::random::Pcg;
    use crate::geom::six_node::{QuadraticTriangle, nearest_on_quadratic};
    use crate::geom::triangle::nearest_on_triangle;
    use glam::DVec2;

    #[test]
    fn a_ready_facet_answers_as_its_six_nodes_do_and_no_point_of_it_is_nearer() {
        let mut rng = Pcg::new(5);
        let mut point = || DVec3::new(rng.unit(), rng.unit(), rng.unit()) - 0.5;
        for bend in [0.0, 1e-12, 0.02, 0.2] {
            for _ in 0..100 {
                let corners = [point(), point(), point()];
                let mids: [DVec3; 3] = std::array::from_fn(|k| {
                    (corners[k] + corners[(k + 1) % 3]) / 2.0 + point() * bend
                });
                let p = point() * 3.0;
                let flat = nearest_on_triangle(corners, p);
                let ready = ReadyFacet::new(corners, mids);
                let (q, n) = ready.nearest(p, flat);
                let least = ready.least_distance(p);
                assert!(least <= flat.distance(p) && least > p.length() - 3.0);
                let (r, m) = nearest_on_quadratic(corners, mids, p);
                assert!(q.distance(r) < 1e-8 && n.distance(m) < 1e-6, "{q} {r}");
                if bend > 0.1 {
                    continue;
                }
                let facet = QuadraticTriangle { corners, mids };
                let steps = 20;
                for i in 0..=steps {
                    for j in 0..=steps - i {
                        let w = DVec2::new(f64::from(i), f64::from(j)) / f64::from(steps);
                        let least = facet.point(w).distance(p);
                        assert!(q.distance(p) <= least + 1e-9 || bend > 0.01, "{p}");
                    }
                }
            }
        }
    }
}
