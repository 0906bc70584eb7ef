//! Where facets cut through facets: a side of one with its ends on both sides of another, away from its rim.
//!
//! Guarantee: what only touches is no cut, so that bodies that lie on one another pass. Limits: cuts shallower than the given depth are not seen; of the cuts of one side only the first is told.

use glam::DVec3;
use rayon::prelude::*;

use super::soup::Soup;
use crate::geom::triangle::nearest_on_segment;
use crate::spatial::TriangleBvh;

/// Triangles that a side may meet without being cut: those round its ends lie along it.
const MET: usize = 32;
/// Parameters along a side that differ less are the same place.
const SAME: f64 = 1e-9;

/// A side of one triangle that goes through another.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Cut {
    /// The triangle with the side, and the one that it cuts.
    pub(super) triangles: [u32; 2],
    /// Where.
    pub(super) place: DVec3,
    /// How far the nearer end of the side lies beyond the triangle's plane.
    pub(super) depth: f64,
}

/// Sides that go through triangles by more than `depth`, in the order of the sides' triangles.
pub(super) fn cuts(soup: &Soup, depth: f64) -> Vec<Cut> {
    let corners: Vec<[DVec3; 3]> = (0..soup.triangles.len()).map(|t| soup.corners(t)).collect();
    let bvh = TriangleBvh::new(&corners);
    (0..soup.triangles.len())
        .into_par_iter()
        .flat_map_iter(|t| {
            let tri = soup.triangles[t];
            let bvh = &bvh;
            // Both triangles of a closed side have it: the one that runs up is asked.
            (0..3)
                .map(move |k| [tri[k], tri[(k + 1) % 3]])
                .filter(|[a, b]| a < b)
                .filter_map(move |side| first_cut(soup, bvh, t, side, depth))
        })
        .collect()
}

fn first_cut(soup: &Soup, bvh: &TriangleBvh, t: usize, side: [u32; 2], depth: f64) -> Option<Cut> {
    let [a, b] = side.map(|v| soup.points[v as usize]);
    let mut from = SAME;
    for _ in 0..MET {
        let (u, hit) = bvh.first_hit_between(a, b - a, [from, 1.0 - SAME])?;
        let other = soup.triangles[u];
        if !side.iter().any(|v| other.contains(v)) {
            let [p, q, r] = soup.corners(u);
            let normal = (q - p).cross(r - p).normalize_or_zero();
            let (above, below) = ((a - p).dot(normal), (b - p).dot(normal));
            let least = above.abs().min(below.abs());
            let place = a.lerp(b, hit.t);
            // A side that only meets the rim of the other lies on its neighbour.
            let rim = [(p, q), (q, r), (r, p)]
                .map(|(s, e)| nearest_on_segment(s, e, place).distance(place));
            if above * below < 0.0 && least > depth && rim.iter().all(|d| *d > depth) {
                return Some(Cut {
                    triangles: [t as u32, u as u32],
                    place,
                    depth: least,
                });
            }
        }
        from = hit.t + SAME;
    }
    None
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A triangle in the plane z = 0, and another across it with a side from `low` to `high`.
    fn crossed(low: f64, high: f64) -> Soup {
        Soup {
            points: vec![
                DVec3::ZERO,
                DVec3::X,
                DVec3::Y,
                DVec3::new(0.2, 0.3, low),
                DVec3::new(0.2, 0.3, high),
                DVec3::new(0.21, 0.32, high),
            ],
            triangles: vec![[0, 1, 2], [3, 4, 5]],
        }
    }

    #[test]
    fn a_side_through_a_triangle_is_a_cut_of_known_place_and_depth() {
        let found = cuts(&crossed(-0.5, 2.0), 1e-6);
        assert_eq!(found.len(), 1);
        assert_eq!(found[0].triangles, [1, 0]);
        assert!(found[0].place.distance(DVec3::new(0.2, 0.3, 0.0)) < 1e-12);
        assert!((found[0].depth - 0.5).abs() < 1e-12);
    }

    #[test]
    fn what_touches_or_hardly_enters_is_no_cut() {
        assert!(cuts(&crossed(0.0, 2.0), 1e-6).is_empty());
        assert!(cuts(&crossed(-1e-7, 2.0), 1e-6).is_empty());
        assert!(cuts(&crossed(0.1, 2.0), 1e-6).is_empty());
        // A side that meets the rim.
        let mut rim = crossed(-0.5, 2.0);
        rim.points[3].y = 0.0;
        rim.points[4].y = 0.0;
        assert!(cuts(&rim, 1e-6).is_empty());
    }
}
