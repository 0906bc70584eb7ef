//! The smooth surface that facets stand for: where the middle of a side would lie on it.
//!
//! A corner's normal is the mean of the facets of one face round it, by their angles there; the middle of a side lies where the cubic through
//! both corners and perpendicular to their normals has its middle (A. Vlachos, J. Peters, C. Boyd, J. Mitchell, Curved PN triangles, I3D 2001,
//! doi:10.1145/364338.364387). On a circle of n chords that is the arc's middle to within 40 / n^4 of the radius.
//!
//! Guarantees: on flat faces the middle is that of the straight side, to rounding; both triangles at a side have the same one.
//! Limits: beside a border the face's last chord counts alone, so that its middle bulges half as much as it should.

use glam::DVec3;

use super::segment::Segmented;
use super::soup::Soup;

/// A facet's normal has a part in a corner's where they are within this angle of each other (cosine of 40 degrees).
const SMOOTH_COS: f64 = 0.766;
/// Two faces that meet at less than this (cosine of 25 degrees) are one surface for the middle of their common side.
const TANGENT_COS: f64 = 0.906;
/// No middle is further from the straight side than this share of it: that of a third of a circle is 0.14.
const MOST: f64 = 0.15;

/// What a triangle at a side knows of the surface: the normals at the side's ends, and its own.
#[derive(Clone, Copy, Debug)]
pub(super) struct Bulge {
    pub(super) ends: [DVec3; 2],
    pub(super) facet: DVec3,
}

/// #T normals at the corners.
pub(super) fn corner_normals(
    soup: &Soup,
    faces: &Segmented,
    around: &[Vec<u32>],
) -> Vec<[DVec3; 3]> {
    let angle = |t: usize, v: u32| {
        let tri = soup.triangles[t];
        let k = tri.iter().position(|&w| w == v).unwrap_or(0);
        let p = |k: usize| soup.points[tri[k % 3] as usize];
        let angle = (p(k + 1) - p(k)).angle_between(p(k + 2) - p(k));
        if angle.is_finite() { angle } else { 0.0 }
    };
    (0..soup.triangles.len())
        .map(|t| {
            soup.triangles[t].map(|v| {
                let own = faces.normal[t];
                let sum: DVec3 = around[v as usize]
                    .iter()
                    .map(|&u| u as usize)
                    .filter(|&u| {
                        faces.region[u] == faces.region[t] && faces.normal[u].dot(own) > SMOOTH_COS
                    })
                    .map(|u| faces.normal[u] * angle(u, v))
                    .sum();
                sum.normalize_or(own)
            })
        })
        .collect()
}

/// The middle of the side from `a` to `b` on the surface that the triangles at it tell of.
pub(super) fn bulge(a: DVec3, b: DVec3, at: &[Bulge]) -> DVec3 {
    let straight = a.midpoint(b);
    let side = b - a;
    let own = |f: &Bulge| {
        let [n, m] = f.ends;
        if n.dot(f.facet) < SMOOTH_COS || m.dot(f.facet) < SMOOTH_COS {
            return DVec3::ZERO;
        }
        (m * side.dot(m) - n * side.dot(n)) / 8.0
    };
    let offset = match at {
        [f] => own(f),
        [f, g] if f.facet.dot(g.facet) > TANGENT_COS => (own(f) + own(g)) / 2.0,
        // Each face asks for an offset along its own normal; across a corner both are met at once.
        [f, g] => {
            let (p, q) = (own(f), own(g));
            let (n, m) = (f.facet, g.facet);
            let (s, t, c) = (p.dot(n), q.dot(m), n.dot(m));
            let d = 1.0 - c * c;
            if d > 0.1 {
                (n * (s - t * c) + m * (t - s * c)) / d
            } else {
                DVec3::ZERO
            }
        }
        _ => DVec3::ZERO,
    };
    if offset.is_finite() && offset.length() <= MOST * side.length() {
        straight + offset
    } else {
        straight
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_middle_of_a_chord_lies_on_the_circle() {
        for n in [12.0, 24.0] {
            let half: f64 = std::f64::consts::PI / n;
            let [a, b] = [-half, half].map(|x| DVec3::new(x.cos(), x.sin(), 0.0));
            let one = Bulge {
                ends: [a, b],
                facet: DVec3::X,
            };
            let cap = Bulge {
                ends: [DVec3::Z; 2],
                facet: DVec3::Z,
            };
            for at in [vec![one], vec![one, one], vec![one, cap]] {
                let radius = bulge(a, b, &at).length();
                assert!((radius - 1.0).abs() < 40.0 / f64::powi(n, 4), "{radius}");
            }
            let flat = Bulge {
                ends: [DVec3::X; 2],
                facet: DVec3::X,
            };
            assert!(bulge(a, b, &[flat]).distance(a.midpoint(b)) < 1e-15);
        }
    }
}
