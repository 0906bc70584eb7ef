//! The six-node (quadratic) triangle: position, normal, nearest point, area, volume under it; exact to third order in the element size on a
//! curved face.
//!
//! Parameters: `(u, v)` are the weights of corners 1 and 2, the weight of corner 0 is `1 - u - v`. Mid-side points belong to the sides
//! (0,1), (1,2), (2,0). Normals follow the corners' turn.
//!
//! Guarantees: the nearest point found is never further than that of the start, and lies on the facet, not past its sides.
//! Limits: Newton's method finds a local minimum; for facets that bend through more than a quarter turn it may be another one than
//! the nearest.
//!
//! Shape functions: Zienkiewicz & Taylor, The Finite Element Method, vol. 1, section 8.8.

mod ready;

pub use ready::ReadyFacet;

use super::triangle::nearest_on_segment;
use crate::model::brep::Brep;
use crate::model::ids::{FaceId, FacetId, IndexVec};
use glam::{DVec2, DVec3};

/// Enough for quadratic convergence from any start inside a facet that is not badly bent; more is rounding noise.
const STEPS: usize = 12;
/// Squared step, in parameters, after which Newton's next one is below rounding: it would be of the order of this one's square.
const LAST_STEP: f64 = 1e-18;
/// Relative slack of a comparison of squared distances, far above their rounding.
const ROUNDING: f64 = 1.0 + 1e-9;
/// A curved normal that leaves the flat one by more than this cosine means a folded element: the flat one is the better word then.
const FOLDED_COS: f64 = 0.1;

/// Normals are compared this far apart, in parameters, to tell how a facet bends: its square is far below what six nodes know, and it is far above rounding.
const BEND_STEP: f64 = 1e-3;

/// Parameters of the middle of side `k` (between corners k and k+1).
pub const SIDE_MIDDLE: [(f64, f64); 3] = [(0.5, 0.0), (0.5, 0.5), (0.0, 0.5)];

/// A six-node triangle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct QuadraticTriangle {
    /// Its corners.
    pub corners: [DVec3; 3],
    /// Its mid-side points on sides (0,1), (1,2), (2,0).
    pub mids: [DVec3; 3],
}

/// Coefficients of `p0 + pu u + pv v + puu u² + puv u v + pvv v²`.
#[derive(Clone, Copy, Debug)]
struct Polynomial {
    p0: DVec3,
    pu: DVec3,
    pv: DVec3,
    puu: DVec3,
    puv: DVec3,
    pvv: DVec3,
}

impl Polynomial {
    fn at(&self, w: DVec2) -> DVec3 {
        self.p0
            + (self.pu + self.puu * w.x + self.puv * w.y) * w.x
            + (self.pv + self.pvv * w.y) * w.y
    }
    fn du(&self, w: DVec2) -> DVec3 {
        self.pu + self.puu * (2.0 * w.x) + self.puv * w.y
    }
    fn dv(&self, w: DVec2) -> DVec3 {
        self.pv + self.pvv * (2.0 * w.y) + self.puv * w.x
    }
}

/// The volume between every facet of a boundary and the origin, mm³, of six-node facets: their sum is what they enclose.
pub fn facet_volumes(brep: &Brep) -> impl Iterator<Item = f64> + '_ {
    brep.facets.enumerated().map(|(id, facet)| {
        let (corners, mids) = (brep.corners(id), facet.mids);
        QuadraticTriangle { corners, mids }.volume()
    })
}

/// The facets of every face.
pub fn facets_of_faces(brep: &Brep) -> IndexVec<FaceId, Vec<QuadraticTriangle>> {
    let mut of_face = IndexVec::filled(Vec::new(), brep.faces.len());
    for (id, facet) in brep.facets.enumerated() {
        let (corners, mids) = (brep.corners(id), facet.mids);
        of_face[facet.face].push(QuadraticTriangle { corners, mids });
    }
    of_face
}

impl QuadraticTriangle {
    /// Whether the mid-side points bend it by no more than `tolerance` out of the straight.
    pub fn is_flat(&self, tolerance: f64) -> bool {
        (0..3).all(|k| self.sag(k) <= tolerance)
    }

    /// How far the mid-side point of side `k` is from the middle of its ends.
    pub fn sag(&self, k: usize) -> f64 {
        let middle = (self.corners[k] + self.corners[(k + 1) % 3]) / 2.0;
        (self.mids[k] - middle).length()
    }

    /// The point at parameters `w`.
    pub fn point(&self, w: DVec2) -> DVec3 {
        self.polynomial().at(w)
    }

    /// The unit normal at parameters `w`; that of the flat triangle where the facet is degenerate, zero where this is too.
    pub fn normal(&self, w: DVec2) -> DVec3 {
        unit_normal(&self.polynomial(), &self.corners, w)
    }

    /// How much the facet bends along a unit tangent at parameters `w`, 1/mm: positive where it bulges outwards; zero where the facet is degenerate.
    pub fn bend(&self, w: DVec2, along: DVec3) -> f64 {
        let q = self.polynomial();
        let (du, dv) = (q.du(w), q.dv(w));
        let (a, b, c) = (du.dot(du), du.dot(dv), dv.dot(dv));
        let (e, f) = (du.dot(along), dv.dot(along));
        let step = DVec2::new(c * e - b * f, a * f - b * e).normalize_or_zero() * BEND_STEP;
        let [(p, n), (r, m)] = [w - step, w + step].map(|w| (self.point(w), self.normal(w)));
        let passed = (r - p).dot(along);
        if passed > 0.0 {
            (m - n).dot(along) / passed
        } else {
            0.0
        }
    }

    /// Volume between the facet and the origin, positive where the normal points away from it. Exact: the integrand has degree 4.
    pub fn volume(&self) -> f64 {
        self.integral(|p, n| p.dot(n)) / 6.0
    }

    /// Area, to fourth order in the element size.
    pub fn area(&self) -> f64 {
        self.integral(|_, n| n.length()) / 2.0
    }

    /// Integral over the parameters of a function of the point and the normal there, which is as long as the parameters are stretched.
    fn integral(&self, f: impl Fn(DVec3, DVec3) -> f64) -> f64 {
        // Six-point rule of degree 4 (Dunavant 1985, doi:10.1002/nme.1620210612).
        const RULE: [(f64, f64); 2] = [
            (0.445_948_490_915_965, 0.223_381_589_678_011),
            (0.091_576_213_509_771, 0.109_951_743_655_322),
        ];
        let q = self.polynomial();
        let mut sum = 0.0;
        for (a, weight) in RULE {
            let b = 1.0 - 2.0 * a;
            for w in [DVec2::new(a, a), DVec2::new(a, b), DVec2::new(b, a)] {
                sum += weight * f(q.at(w), q.du(w).cross(q.dv(w)));
            }
        }
        sum
    }

    /// Parameters of the point that is nearest to `p`, from a start inside the triangle.
    pub fn nearest(&self, p: DVec3, start: DVec2) -> DVec2 {
        let sags = [0, 1, 2].map(|k| self.sag(k));
        let any = f64::INFINITY;
        nearest_parameters(&self.polynomial(), &self.corners, &sags, p, start, any)
    }

    fn polynomial(&self) -> Polynomial {
        let [a, b, c] = self.corners;
        let [ab, bc, ca] = self.mids;
        Polynomial {
            p0: a,
            pu: -3.0 * a - b + 4.0 * ab,
            pv: -3.0 * a - c + 4.0 * ca,
            puu: 2.0 * a + 2.0 * b - 4.0 * ab,
            puv: 4.0 * a - 4.0 * ab + 4.0 * bc - 4.0 * ca,
            pvv: 2.0 * a + 2.0 * c - 4.0 * ca,
        }
    }
}

/// See [`QuadraticTriangle::normal`].
fn unit_normal(q: &Polynomial, corners: &[DVec3; 3], w: DVec2) -> DVec3 {
    let flat = (corners[1] - corners[0]).cross(corners[2] - corners[0]);
    let n = q.du(w).cross(q.dv(w));
    if n.dot(flat) > FOLDED_COS * n.length() * flat.length() {
        n.normalize_or_zero()
    } else {
        flat.normalize_or_zero()
    }
}

/// See [`QuadraticTriangle::nearest`]. `sags`: how far each side's mid-side point lies off its middle. What is further than the square root of `most` need
/// not be the nearest.
fn nearest_parameters(
    q: &Polynomial,
    corners: &[DVec3; 3],
    sags: &[f64; 3],
    p: DVec3,
    start: DVec2,
    most: f64,
) -> DVec2 {
    let distance = |w: DVec2| q.at(w).distance_squared(p);
    let mut best = (distance(start), start);
    if let Some(w) = newton(q, p, start) {
        let d = distance(w);
        if d <= best.0 {
            return w;
        }
    }
    // The way leads out of the triangle: the nearest point is on one of its sides.
    let corner = [DVec2::ZERO, DVec2::X, DVec2::Y];
    for k in 0..3 {
        // No point of a side is further from its chord than its sag, so that a chord far off leaves the side out.
        let chord = nearest_on_segment(corners[k], corners[(k + 1) % 3], p).distance(p);
        let least = chord - sags[k];
        if least > 0.0 && least * least > best.0.min(most) * ROUNDING {
            continue;
        }
        let (a, b) = (corner[k], corner[(k + 1) % 3]);
        let along = (start - a).dot(b - a) / (b - a).length_squared();
        let w = a + (b - a) * newton_on_side(q, p, a, b, along.clamp(0.0, 1.0));
        for w in [w, a] {
            let d = distance(w);
            if d < best.0 {
                best = (d, w);
            }
        }
    }
    best.1
}

/// Newton's method for the nearest point; `None` where it leaves the triangle or does not settle.
fn newton(q: &Polynomial, p: DVec3, start: DVec2) -> Option<DVec2> {
    let mut w = start;
    for _ in 0..STEPS {
        let (r, du, dv) = (q.at(w) - p, q.du(w), q.dv(w));
        let gradient = DVec2::new(r.dot(du), r.dot(dv));
        let (guu, guv, gvv) = (du.dot(du), du.dot(dv), dv.dot(dv));
        let (huu, huv, hvv) = (
            guu + 2.0 * r.dot(q.puu),
            guv + r.dot(q.puv),
            gvv + 2.0 * r.dot(q.pvv),
        );
        // Where the full Hessian is not positive definite, Gauss and Newton's part of it still goes downhill.
        let full = huu * hvv - huv * huv;
        let gauss = guu * gvv - guv * guv;
        let quadratic = full > 1e-3 * gauss && huu > 0.0;
        let (uu, uv, vv, det) = if quadratic {
            (huu, huv, hvv, full)
        } else {
            (guu, guv, gvv, gauss)
        };
        if det <= 0.0 {
            return None;
        }
        let step = DVec2::new(
            vv * gradient.x - uv * gradient.y,
            uu * gradient.y - uv * gradient.x,
        ) / det;
        w -= step;
        if !(w.x >= -0.5 && w.y >= -0.5 && w.x + w.y <= 1.5) {
            return None;
        }
        let moved = step.length_squared();
        if moved < 1e-28 || (quadratic && moved < LAST_STEP) {
            break;
        }
    }
    (w.x >= 0.0 && w.y >= 0.0 && w.x + w.y <= 1.0).then_some(w)
}

/// Newton's method for the nearest point of the side from `a` to `b`, as a fraction of it.
fn newton_on_side(q: &Polynomial, p: DVec3, a: DVec2, b: DVec2, start: f64) -> f64 {
    let d = b - a;
    let bend = 2.0 * (q.puu * (d.x * d.x) + q.puv * (d.x * d.y) + q.pvv * (d.y * d.y));
    let mut s = start;
    for _ in 0..STEPS {
        let w = a + d * s;
        let (r, t) = (q.at(w) - p, q.du(w) * d.x + q.dv(w) * d.y);
        let (speed, full) = (t.dot(t), t.dot(t) + r.dot(bend));
        let quadratic = full > 1e-3 * speed;
        let slope = if quadratic { full } else { speed };
        if slope <= 0.0 {
            break;
        }
        let next = (s - r.dot(t) / slope).clamp(0.0, 1.0);
        let moved = (next - s).abs();
        s = next;
        if moved < 1e-14 || (quadratic && moved * moved < LAST_STEP) {
            break;
        }
    }
    s
}

/// Unit normal at (u, v): see [`QuadraticTriangle::normal`].
#[inline]
pub fn normal(corners: &[DVec3; 3], mids: &[DVec3; 3], u: f64, v: f64) -> DVec3 {
    let (corners, mids) = (*corners, *mids);
    QuadraticTriangle { corners, mids }.normal(DVec2::new(u, v))
}

/// The nearest point of a six-node triangle to `p` and the unit normal there.
pub fn nearest_on_quadratic(corners: [DVec3; 3], mids: [DVec3; 3], p: DVec3) -> (DVec3, DVec3) {
    let facet = QuadraticTriangle { corners, mids };
    let flat = crate::geom::triangle::nearest_on_triangle(corners, p);
    let w = facet.nearest(p, flat_parameters(corners, flat));
    (facet.point(w), facet.normal(w))
}

/// Parameters of a point of the flat triangle.
pub fn flat_parameters([a, b, c]: [DVec3; 3], p: DVec3) -> DVec2 {
    let (e1, e2, r) = (b - a, c - a, p - a);
    let (d11, d12, d22) = (e1.dot(e1), e1.dot(e2), e2.dot(e2));
    let (r1, r2) = (r.dot(e1), r.dot(e2));
    let det = d11 * d22 - d12 * d12;
    if det <= 0.0 {
        return DVec2::splat(1.0 / 3.0);
    }
    let u = ((d22 * r1 - d12 * r2) / det).clamp(0.0, 1.0);
    let v = ((d11 * r2 - d12 * r1) / det).clamp(0.0, 1.0 - u);
    DVec2::new(u, v)
}

/// Signed angle between the outward normals of two facets at their common side (the facet, which of its sides), rad: positive where the solid is convex there.
pub fn turn(brep: &Brep, first: (FacetId, usize), second: (FacetId, usize)) -> f64 {
    let side_normal = |(facet, k): (FacetId, usize)| {
        let (u, v) = SIDE_MIDDLE[k];
        normal(&brep.corners(facet), &brep.facets[facet].mids, u, v)
    };
    let (n, m) = (side_normal(first), side_normal(second));
    let (facet, k) = first;
    let corners = brep.facets[facet].corners;
    let (a, b) = (corners[k], corners[(k + 1) % 3]);
    let along = (brep.vertices[b] - brep.vertices[a]).normalize_or_zero();
    n.cross(m).dot(along).atan2(n.dot(m))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geom::random::Pcg;

    /// An eighth of a unit sphere's facet, `half` radians in half-width.
    fn on_sphere(half: f64) -> QuadraticTriangle {
        let corner = |turn: f64| {
            let (s, c) = half.sin_cos();
            DVec3::new(s * turn.cos(), s * turn.sin(), c)
        };
        let corners = [0.0, 1.0, 2.0].map(|k| corner(k * std::f64::consts::TAU / 3.0));
        let mid = |a: DVec3, b: DVec3| (a + b).normalize();
        QuadraticTriangle {
            corners,
            mids: [
                mid(corners[0], corners[1]),
                mid(corners[1], corners[2]),
                mid(corners[2], corners[0]),
            ],
        }
    }

    #[test]
    fn passes_through_its_six_points_and_its_normal_looks_outward() {
        let f = on_sphere(0.3);
        let half = 0.5;
        for (w, p) in [
            (DVec2::ZERO, f.corners[0]),
            (DVec2::X, f.corners[1]),
            (DVec2::Y, f.corners[2]),
            (DVec2::new(half, 0.0), f.mids[0]),
            (DVec2::new(half, half), f.mids[1]),
            (DVec2::new(0.0, half), f.mids[2]),
        ] {
            assert!((f.point(w) - p).length() < 1e-15);
        }
        assert!(f.normal(DVec2::splat(1.0 / 3.0)).distance(DVec3::Z) < 1e-12);
        assert!(!f.is_flat(1e-3) && f.is_flat(0.1));
    }

    #[test]
    fn distance_to_a_sphere_is_far_better_than_the_flat_one() {
        // The interpolation error of a quadratic facet goes with the fourth power of its width, at 0.1 rad about 1e-5.
        let f = on_sphere(0.1);
        for p in [
            DVec3::new(0.01, 0.02, 1.3),
            DVec3::new(0.0, -0.03, 0.7),
            DVec3::new(0.05, 0.0, 1.0),
        ] {
            let (q, n) = nearest_on_quadratic(f.corners, f.mids, p);
            assert!(((q - p).length() - (p.length() - 1.0).abs()).abs() < 1e-5);
            assert!((q - p.normalize()).length() < 1e-3, "{q}");
            assert!(n.dot(p.normalize()) > 0.9999);
            let flat = crate::geom::triangle::nearest_on_triangle(f.corners, p);
            assert!(((flat - p).length() - (p.length() - 1.0).abs()).abs() > 1e-3);
        }
    }

    #[test]
    fn no_point_of_the_facet_is_nearer() {
        let mut rng = Pcg::new(11);
        for half in [0.05, 0.4, 0.7] {
            let mut f = on_sphere(half);
            f.mids[1] += DVec3::new(0.03, -0.02, 0.05) * half;
            for _ in 0..300 {
                let p = (DVec3::new(rng.unit(), rng.unit(), rng.unit()) - 0.5) * 2.0 * half
                    + DVec3::Z * (1.0 + half);
                let (q, _) = nearest_on_quadratic(f.corners, f.mids, p);
                let mut least = f64::INFINITY;
                let n = 60;
                for i in 0..=n {
                    for j in 0..=n - i {
                        let w = DVec2::new(f64::from(i), f64::from(j)) / f64::from(n);
                        least = least.min(f.point(w).distance(p));
                    }
                }
                assert!(q.distance(p) <= least + 1e-12, "{p} at {half}");
            }
        }
    }

    #[test]
    fn flat_and_degenerate_facets() {
        let corners = [DVec3::ZERO, DVec3::X * 2.0, DVec3::Y * 2.0];
        let mids = [DVec3::X, DVec3::new(1.0, 1.0, 0.0), DVec3::Y];
        let (q, n) = nearest_on_quadratic(corners, mids, DVec3::new(0.3, 0.4, -5.0));
        assert!(q.distance(DVec3::new(0.3, 0.4, 0.0)) < 1e-14 && n.distance(DVec3::Z) < 1e-15);
        let (q, _) = nearest_on_quadratic(corners, mids, DVec3::new(3.0, 3.0, 1.0));
        assert!(q.distance(mids[1]) < 1e-14);
        let (q, n) = nearest_on_quadratic([DVec3::ONE; 3], [DVec3::ONE; 3], DVec3::ZERO);
        assert_eq!((q, n), (DVec3::ONE, DVec3::ZERO));
    }

    fn ball_sum(corners: [DVec3; 3], depth: u32, of: &dyn Fn(&QuadraticTriangle) -> f64) -> f64 {
        let mids: [DVec3; 3] =
            std::array::from_fn(|k| (corners[k] + corners[(k + 1) % 3]).normalize());
        let ([a, b, c], [ab, bc, ca]) = (corners, mids);
        if depth == 0 {
            return of(&QuadraticTriangle { corners, mids });
        }
        [[a, ab, ca], [ab, b, bc], [ca, bc, c], [ab, bc, ca]]
            .map(|t| ball_sum(t, depth - 1, of))
            .iter()
            .sum()
    }

    #[test]
    fn area_of_a_cap_is_far_better_than_that_of_the_flat_facet() {
        // 64 facets over an octant.
        let octant = |depth| {
            ball_sum(
                [DVec3::X, DVec3::Y, DVec3::Z],
                depth,
                &QuadraticTriangle::area,
            )
        };
        let exact = std::f64::consts::FRAC_PI_2;
        assert!(
            (octant(3) / exact - 1.0).abs() < 1e-3,
            "{}",
            octant(3) / exact
        );
        let corners = [DVec3::ZERO, DVec3::X, DVec3::Y];
        let mids = std::array::from_fn(|k| (corners[k] + corners[(k + 1) % 3]) / 2.0);
        assert!((QuadraticTriangle { corners, mids }.area() - 0.5).abs() < 1e-14);
    }

    #[test]
    fn volume_is_exact_for_flat_facets_and_of_fourth_order_for_a_ball() {
        let corners = [DVec3::X, DVec3::Y, DVec3::Z];
        let mids = std::array::from_fn(|k| (corners[k] + corners[(k + 1) % 3]) / 2.0);
        let pyramid = QuadraticTriangle { corners, mids };
        assert!((pyramid.volume() - 1.0 / 6.0).abs() < 1e-14);
        let error = |depth| {
            1.0 - ball_sum(corners, depth, &QuadraticTriangle::volume) * 6.0 / std::f64::consts::PI
        };
        let (coarse, fine) = (error(2), error(3));
        assert!(
            fine < 2e-4 && (10.0..22.0).contains(&(coarse / fine)),
            "{coarse} {fine}"
        );
    }

    #[test]
    fn normals_on_a_cylinder_are_radial_to_third_order() {
        let on = |a: f64, z: f64| DVec3::new(a.cos(), a.sin(), z);
        let h = 0.2;
        let corners = [on(0.0, 0.0), on(h, 0.0), on(0.0, h)];
        let mids = [on(h / 2.0, 0.0), on(h / 2.0, h / 2.0), on(0.0, h / 2.0)];
        for (u, v) in SIDE_MIDDLE {
            let p = QuadraticTriangle { corners, mids }.point(DVec2::new(u, v));
            let radial = DVec3::new(p.x, p.y, 0.0).normalize();
            assert!(normal(&corners, &mids, u, v).dot(radial) > 1.0 - 1e-5);
        }
        let flat = (corners[1] - corners[0])
            .cross(corners[2] - corners[0])
            .normalize();
        assert!(
            flat.dot(DVec3::X) < 1.0 - 1e-3,
            "the flat triangle is visibly worse"
        );
    }

    #[test]
    fn a_facet_bends_as_the_cylinder_that_it_is_drawn_on() {
        // A strip of 15 degrees of a cylinder of radius 5 about z; a facet knows the bend to a few percent.
        let at = |turn: f64, z: f64| DVec3::new(5.0 * turn.cos(), 5.0 * turn.sin(), z);
        let turn = 15f64.to_radians();
        let facet = QuadraticTriangle {
            corners: [at(0.0, 0.0), at(turn, 0.0), at(0.0, 1.0)],
            mids: [at(turn / 2.0, 0.0), at(turn / 2.0, 0.5), at(0.0, 0.5)],
        };
        for w in [DVec2::ZERO, DVec2::new(0.3, 0.3), DVec2::X] {
            let normal = facet.normal(w);
            let round = DVec3::Z.cross(normal);
            assert!((facet.bend(w, round) * 5.0 - 1.0).abs() < 0.03);
            assert!(facet.bend(w, DVec3::Z).abs() * 5.0 < 0.03);
        }
        let inwards = QuadraticTriangle {
            corners: [facet.corners[0], facet.corners[2], facet.corners[1]],
            mids: [facet.mids[2], facet.mids[1], facet.mids[0]],
        };
        let round = DVec3::Z.cross(facet.normal(DVec2::X));
        assert!((inwards.bend(DVec2::Y, round) * 5.0 + 1.0).abs() < 0.03);
    }
}
