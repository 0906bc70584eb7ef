//! The shape of single triangles: cotangents for the maps, stretches for judging them.

use crate::model::patch::{Chart, Patch};
use glam::{DMat2, DVec2};

/// A triangle laid flat by itself.
#[derive(Clone, Copy, Debug)]
pub(super) struct Shape {
    /// Cotangent of the angle at each corner.
    pub cot: [f64; 3],
    /// Places of its corners, mm.
    pub flat: [DVec2; 3],
}

/// The shapes of a patch's triangles.
pub(super) fn shapes(patch: &Patch) -> Vec<Shape> {
    (0..patch.triangles.len())
        .map(|t| {
            let p = patch.triangle_points(t);
            let (u, v) = (p[1] - p[0], p[2] - p[0]);
            let longest = u.length().max(v.length()).max((v - u).length());
            // A needle has no angles; a floor for its height keeps the weights finite and the energy convex (all three share it).
            let doubled = u.cross(v).length().max(1e-9 * longest * longest);
            let doubled = doubled.max(f64::MIN_POSITIVE);
            let cot = [0, 1, 2].map(|k| {
                let (a, b) = (p[(k + 1) % 3] - p[k], p[(k + 2) % 3] - p[k]);
                a.dot(b) / doubled
            });
            let base = u.length().max(f64::MIN_POSITIVE);
            let flat = [
                DVec2::ZERO,
                DVec2::new(base, 0.0),
                DVec2::new(u.dot(v) / base, doubled / base),
            ];
            Shape { cot, flat }
        })
        .collect()
}

/// Entries of the cotangent Laplacian: positive semidefinite whatever the triangles, since it is the Dirichlet energy of linear elements.
pub(super) fn laplacian(patch: &Patch, shapes: &[Shape]) -> Vec<(u32, u32, f64)> {
    let mut entries = Vec::with_capacity(12 * shapes.len());
    for (c, s) in patch.triangles.iter().zip(shapes) {
        for k in 0..3 {
            let (i, j, w) = (c[(k + 1) % 3], c[(k + 2) % 3], s.cot[k] / 2.0);
            entries.extend([(i, i, w), (j, j, w), (i, j, -w), (j, i, -w)]);
        }
    }
    entries
}

/// The places scaled about the origin to a signed area of `area`; unchanged where that is not possible.
pub(super) fn scaled(patch: &Patch, mut places: Vec<DVec2>, area: f64) -> Vec<DVec2> {
    let now: f64 = patch
        .triangles
        .iter()
        .map(|t| {
            let [a, b, c] = t.map(|i| places[i as usize]);
            (b - a).perp_dot(c - a) / 2.0
        })
        .sum();
    if now > 0.0 {
        let factor = (area / now).sqrt();
        places.iter_mut().for_each(|p| *p *= factor);
    }
    places
}

/// How a chart's triangle is stretched on its way back to the patch.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Stretch {
    /// Largest length in space of a unit length in the chart.
    pub long: f64,
    /// Smallest one.
    pub short: f64,
}

/// The stretch of one triangle; infinite where it has no area in the chart.
pub fn stretch(patch: &Patch, chart: &Chart, triangle: usize) -> Stretch {
    let [a, b, c] = patch.triangles[triangle].map(|i| chart.places[i as usize]);
    let p = patch.triangle_points(triangle);
    let plane = DMat2::from_cols(b - a, c - a);
    if plane.determinant() == 0.0 {
        return Stretch {
            long: f64::INFINITY,
            short: 0.0,
        };
    }
    let back = plane.inverse();
    let (u, v) = (p[1] - p[0], p[2] - p[0]);
    let x = u * back.x_axis.x + v * back.x_axis.y;
    let y = u * back.y_axis.x + v * back.y_axis.y;
    let (xx, xy, yy) = (x.dot(x), x.dot(y), y.dot(y));
    let (mean, half) = ((xx + yy) / 2.0, ((xx - yy) / 2.0).hypot(xy));
    Stretch {
        long: (mean + half).sqrt(),
        short: (mean - half).max(0.0).sqrt(),
    }
}
