//! Which kind of surface a face is, told from its six-node facets alone: plane, cylinder, sphere, cone, torus, or none of these.
//!
//! Each kind is fitted to the nodes, which lie on the CAD surface, from a start that the facets' normals give; the simplest kind that
//! meets all nodes is the answer. A line of normals of a surface of revolution meets its axis (H. Pottmann, T. Randrup, "Rotational and helical surface
//! approximation for reverse engineering", Computing 60, 1998, doi:10.1007/BF02684378); the rest is Levenberg and Marquardt's method.
//!
//! Guarantees: the answer depends neither on the part's size nor on its place.
//! Limits: a surface is what it looks like: a B-spline that bends like a cylinder to within the tolerance is a cylinder, and so is a strip too small to
//! show that it is a torus. Cost: at most some hundred nodes a face.

use super::six_node::{QuadraticTriangle, SIDE_MIDDLE};
use glam::{DVec2, DVec3};
use nalgebra::{DMatrix, DVector, Matrix3, Matrix6, SymmetricEigen, Vector3, Vector6};
use std::fmt;

/// A kind of surface.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum FaceKind {
    /// A plane.
    Plane,
    /// A circular cylinder.
    Cylinder,
    /// A sphere.
    Sphere,
    /// A circular cone.
    Cone,
    /// A torus.
    Torus,
    /// None of these.
    FreeForm,
}

impl FaceKind {
    /// Its name in reports.
    pub fn name(self) -> &'static str {
        match self {
            FaceKind::Plane => "plane",
            FaceKind::Cylinder => "cylinder",
            FaceKind::Sphere => "sphere",
            FaceKind::Cone => "cone",
            FaceKind::Torus => "torus",
            FaceKind::FreeForm => "free-form",
        }
    }
}

impl fmt::Display for FaceKind {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

/// A node is met within this share of the face's extent: above what STEP files are off by at their edges, far below any curvature that a wall shows.
const MET: f64 = 2e-4;
/// A node's normal is met within this angle, rad. Six-node facets over a quarter turn are off by five degrees.
const TURNED: f64 = 0.15;
/// Normals of a plane differ by less than this, rad: a narrow fillet may be as flat as its extent allows, yet it turns.
const FLAT_TURN: f64 = 5e-3;
/// Most facets that are looked at.
const FACETS: usize = 48;
/// Steps of the fit; from a good start it settles in five.
const STEPS: usize = 25;

/// A node with its normal, both from the facets.
#[derive(Clone, Copy)]
struct Node {
    point: DVec3,
    normal: DVec3,
}

/// The kind of the face with these facets.
pub fn face_kind(facets: &[QuadraticTriangle]) -> FaceKind {
    let nodes = nodes(facets);
    if nodes.is_empty() {
        return FaceKind::FreeForm;
    }
    if is_plane(&nodes) {
        return FaceKind::Plane;
    }
    let candidates: [(FaceKind, Fit, Option<Vec<f64>>); 4] = [
        (FaceKind::Cylinder, cylinder, cylinder_start(&nodes)),
        (FaceKind::Sphere, sphere, sphere_start(&nodes)),
        (FaceKind::Cone, cone, cone_start(&nodes)),
        (FaceKind::Torus, torus, torus_start(&nodes)),
    ];
    candidates
        .into_iter()
        .find(|(_, fit, start)| {
            start.as_ref().is_some_and(|start| {
                // Fewer nodes than this meet any surface with so many numbers.
                nodes.len() > start.len() + 2 && meets(*fit, &refine(*fit, start, &nodes), &nodes)
            })
        })
        .map_or(FaceKind::FreeForm, |c| c.0)
}

/// Corners and mid-side points of a few facets, moved and scaled into a box of diagonal one round the origin.
fn nodes(facets: &[QuadraticTriangle]) -> Vec<Node> {
    let points = || facets.iter().flat_map(|f| f.corners.iter().chain(&f.mids));
    let low = points().fold(DVec3::INFINITY, |m, &p| m.min(p));
    let high = points().fold(DVec3::NEG_INFINITY, |m, &p| m.max(p));
    let extent = (high - low).length();
    if !(extent.is_finite() && extent > 0.0) {
        return Vec::new();
    }
    let middle = (low + high) / 2.0;
    let stride = facets.len().div_ceil(FACETS);
    facets
        .iter()
        .step_by(stride.max(1))
        .flat_map(|facet| {
            let corners = [DVec2::ZERO, DVec2::X, DVec2::Y];
            let mids = SIDE_MIDDLE.map(|(u, v)| DVec2::new(u, v));
            corners.into_iter().chain(mids).map(|w| Node {
                point: (facet.point(w) - middle) / extent,
                normal: facet.normal(w),
            })
        })
        .filter(|n| n.normal != DVec3::ZERO)
        .collect()
}

fn mean(values: impl Iterator<Item = DVec3>) -> DVec3 {
    let (sum, count) = values.fold((DVec3::ZERO, 0.0), |(s, n), v| (s + v, n + 1.0));
    sum / f64::max(count, 1.0)
}

fn is_plane(nodes: &[Node]) -> bool {
    let normal = mean(nodes.iter().map(|n| n.normal)).normalize_or_zero();
    let middle = mean(nodes.iter().map(|n| n.point));
    nodes.iter().all(|n| {
        (n.point - middle).dot(normal).abs() < MET && n.normal.dot(normal) > FLAT_TURN.cos()
    })
}

/// Signed distance of a point to the surface with these numbers.
type Fit = fn(&[f64], DVec3) -> f64;

fn vector(p: &[f64]) -> DVec3 {
    DVec3::new(p[0], p[1], p[2])
}

/// Height along and distance from an axis through `at`.
fn about_axis(axis: DVec3, at: DVec3, p: DVec3) -> (f64, f64) {
    let (a, q) = (axis.normalize_or_zero(), p - at);
    (q.dot(a), q.cross(a).length())
}

/// Centre, radius.
fn sphere(p: &[f64], at: DVec3) -> f64 {
    at.distance(vector(p)) - p[3]
}

/// Axis, point on it, radius.
fn cylinder(p: &[f64], at: DVec3) -> f64 {
    about_axis(vector(p), vector(&p[3..]), at).1 - p[6]
}

/// Axis, apex, half of the opening angle.
fn cone(p: &[f64], at: DVec3) -> f64 {
    let (height, radius) = about_axis(vector(p), vector(&p[3..]), at);
    radius * p[6].cos() - height * p[6].sin()
}

/// Axis, centre, radius of the ring and of its section.
fn torus(p: &[f64], at: DVec3) -> f64 {
    let (height, radius) = about_axis(vector(p), vector(&p[3..]), at);
    (radius - p[6]).hypot(height) - p[7]
}

/// The centre that points see along their normals, and how far away: least squares of `point = centre + r normal`.
fn centre(pairs: &[(DVec3, DVec3)]) -> Option<(DVec3, f64)> {
    let (p, n) = (
        mean(pairs.iter().map(|x| x.0)),
        mean(pairs.iter().map(|x| x.1)),
    );
    let along: f64 = pairs.iter().map(|x| (x.0 - p).dot(x.1 - n)).sum();
    let spread: f64 = pairs.iter().map(|x| (x.1 - n).length_squared()).sum();
    let r = along / spread;
    r.is_finite().then(|| (p - n * r, r.abs()))
}

fn sphere_start(nodes: &[Node]) -> Option<Vec<f64>> {
    let pairs: Vec<_> = nodes.iter().map(|n| (n.point, n.normal)).collect();
    let (c, r) = centre(&pairs)?;
    Some(vec![c.x, c.y, c.z, r])
}

/// The direction along which vectors vary least.
fn flattest(vectors: impl Iterator<Item = DVec3>) -> Option<DVec3> {
    let mut sum = Matrix3::zeros();
    for v in vectors {
        let v = Vector3::new(v.x, v.y, v.z);
        sum += v * v.transpose();
    }
    let eigen = SymmetricEigen::try_new(sum, f64::EPSILON, 100)?;
    let least = eigen.eigenvalues.imin();
    let v = eigen.eigenvectors.column(least);
    DVec3::new(v[0], v[1], v[2]).try_normalize()
}

fn cylinder_start(nodes: &[Node]) -> Option<Vec<f64>> {
    let a = flattest(nodes.iter().map(|n| n.normal))?;
    let pairs: Vec<_> = nodes
        .iter()
        .map(|n| (n.point.reject_from(a), n.normal.reject_from(a)))
        .collect();
    let (c, r) = centre(&pairs)?;
    Some(vec![a.x, a.y, a.z, c.x, c.y, c.z, r])
}

fn cone_start(nodes: &[Node]) -> Option<Vec<f64>> {
    let m = mean(nodes.iter().map(|n| n.normal));
    let mut a = flattest(nodes.iter().map(|n| n.normal - m))?;
    // Every tangent plane goes through the apex.
    let (mut left, mut right) = (Matrix3::zeros(), Vector3::zeros());
    for n in nodes {
        let v = Vector3::new(n.normal.x, n.normal.y, n.normal.z);
        left += v * v.transpose();
        right += v * n.normal.dot(n.point);
    }
    let apex = left.try_inverse()? * right;
    let apex = DVec3::new(apex[0], apex[1], apex[2]);
    if (mean(nodes.iter().map(|n| n.point)) - apex).dot(a) < 0.0 {
        a = -a;
    }
    let half = m.dot(a).abs().min(1.0).asin();
    Some(vec![a.x, a.y, a.z, apex.x, apex.y, apex.z, half])
}

fn torus_start(nodes: &[Node]) -> Option<Vec<f64>> {
    // All normals meet the axis: their Plücker coordinates lie in one linear complex.
    let mut sum = Matrix6::zeros();
    for n in nodes {
        let (m, l) = (n.point.cross(n.normal), n.normal);
        let v = Vector6::new(m.x, m.y, m.z, l.x, l.y, l.z);
        sum += v * v.transpose();
    }
    let eigen = SymmetricEigen::try_new(sum, f64::EPSILON, 200)?;
    let v = eigen.eigenvectors.column(eigen.eigenvalues.imin());
    let (a, m) = (DVec3::new(v[0], v[1], v[2]), DVec3::new(v[3], v[4], v[5]));
    let origin = a.cross(m) / a.length_squared();
    let a = a.try_normalize()?;
    // In the half-plane through the axis the section is a circle.
    let pairs: Vec<_> = nodes
        .iter()
        .map(|n| {
            let q = n.point - origin;
            let out = q.reject_from(a).normalize_or_zero();
            (
                DVec3::new(q.dot(out), q.dot(a), 0.0),
                DVec3::new(n.normal.dot(out), n.normal.dot(a), 0.0),
            )
        })
        .collect();
    let (c, r) = centre(&pairs)?;
    let o = origin + a * c.y;
    Some(vec![a.x, a.y, a.z, o.x, o.y, o.z, c.x, r])
}

/// Step of numerical derivatives in a box of size one.
const SLIGHT: f64 = 1e-6;

/// Levenberg and Marquardt's method on the distances of the nodes.
fn refine(fit: Fit, start: &[f64], nodes: &[Node]) -> Vec<f64> {
    let sum = |p: &[f64]| nodes.iter().map(|n| fit(p, n.point).powi(2)).sum::<f64>();
    let mut best = start.to_vec();
    let mut error = sum(&best);
    let mut damping = 1e-3;
    for _ in 0..STEPS {
        let residual =
            DVector::from_iterator(nodes.len(), nodes.iter().map(|n| fit(&best, n.point)));
        let slope = DMatrix::from_fn(nodes.len(), best.len(), |i, k| {
            let mut p = best.clone();
            p[k] += SLIGHT;
            (fit(&p, nodes[i].point) - residual[i]) / SLIGHT
        });
        let mut normal = slope.transpose() * &slope;
        // The damping also holds what the distances leave free: the axis' length and the point's place along it.
        let most = normal.diagonal().max();
        for k in 0..best.len() {
            normal[(k, k)] += damping * most;
        }
        let Some(step) = normal
            .cholesky()
            .map(|c| c.solve(&(slope.transpose() * &residual)))
        else {
            break;
        };
        let next: Vec<f64> = best.iter().zip(step.iter()).map(|(p, s)| p - s).collect();
        let found = sum(&next);
        if found < error {
            let settled = error - found < 1e-6 * error;
            (best, error) = (next, found);
            damping = (damping / 10.0).max(1e-12);
            if settled {
                break;
            }
        } else {
            damping *= 10.0;
        }
    }
    best
}

/// Whether the surface meets every node, and turns as the facets do.
fn meets(fit: Fit, numbers: &[f64], nodes: &[Node]) -> bool {
    nodes.iter().all(|n| {
        let at = fit(numbers, n.point);
        let slope = DVec3::from_array(
            [DVec3::X, DVec3::Y, DVec3::Z].map(|e| fit(numbers, n.point + e * SLIGHT) - at),
        );
        at.abs() < MET && slope.normalize_or_zero().dot(n.normal).abs() > TURNED.cos()
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::{FRAC_PI_2, PI, TAU};

    /// Facets of a patch (u, v) -> point, `n` by `n` cells, turned and moved somewhere odd.
    fn patch(n: usize, scale: f64, surface: impl Fn(f64, f64) -> DVec3) -> Vec<QuadraticTriangle> {
        let turn = glam::DQuat::from_axis_angle(DVec3::new(1.0, 2.0, -0.5).normalize(), 0.7);
        let at = |w: DVec2| turn * surface(w.x, w.y) * scale + DVec3::new(31.0, -7.0, 11.0) * scale;
        let mut facets = Vec::new();
        for i in 0..n {
            for j in 0..n {
                let w = |a: usize, b: usize| DVec2::new((i + a) as f64, (j + b) as f64) / n as f64;
                for c in [[w(0, 0), w(1, 0), w(1, 1)], [w(0, 0), w(1, 1), w(0, 1)]] {
                    facets.push(QuadraticTriangle {
                        corners: c.map(at),
                        mids: std::array::from_fn(|k| at((c[k] + c[(k + 1) % 3]) / 2.0)),
                    });
                }
            }
        }
        facets
    }

    fn polar(radius: f64, angle: f64, z: f64) -> DVec3 {
        DVec3::new(radius * angle.cos(), radius * angle.sin(), z)
    }

    #[track_caller]
    fn is(kind: FaceKind, n: usize, surface: impl Fn(f64, f64) -> DVec3) {
        for scale in [1e-3, 1.0, 1e3] {
            assert_eq!(face_kind(&patch(n, scale, &surface)), kind, "scale {scale}");
        }
    }

    #[test]
    fn each_kind_is_known_at_any_size() {
        is(FaceKind::Plane, 2, |u, v| DVec3::new(u, 0.3 * v, 0.0));
        is(FaceKind::Cylinder, 8, |u, v| polar(2.0, TAU * u, 5.0 * v));
        is(FaceKind::Sphere, 6, |u, v| {
            polar((1.2 * v).cos(), 2.0 * u, (1.2 * v).sin())
        });
        is(FaceKind::Cone, 8, |u, v| polar(1.0 + v, TAU * u, 2.0 * v));
        is(FaceKind::Torus, 10, |u, v| {
            let section = TAU * v;
            polar(5.0 + section.cos(), PI * u, section.sin())
        });
    }

    #[test]
    fn fillets_are_no_planes_and_drafts_are_cones() {
        is(FaceKind::Cylinder, 2, |u, v| {
            polar(0.01, FRAC_PI_2 * u, 3.0 * v)
        });
        is(FaceKind::Torus, 6, |u, v| {
            let section = FRAC_PI_2 * v;
            polar(20.0 + section.cos(), FRAC_PI_2 * u, section.sin())
        });
        is(FaceKind::Cone, 6, |u, v| {
            polar(3.0 - 0.05 * v, FRAC_PI_2 * u, v)
        });
    }

    #[test]
    fn what_bends_otherwise_is_free_form() {
        is(FaceKind::FreeForm, 6, |u, v| {
            DVec3::new(u, v, 0.2 * (3.0 * u).sin() * (2.0 * v).cos())
        });
        is(FaceKind::FreeForm, 8, |u, v| {
            DVec3::new(2.0 * (TAU * u).cos(), (TAU * u).sin(), 3.0 * v)
        });
        assert_eq!(face_kind(&[]), FaceKind::FreeForm);
    }
}
