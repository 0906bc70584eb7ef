//! The mesh measured from the solid: has every wall its mesh, and do free edges lie on rims?

use super::sampling::{median, spread};
use super::skin::Skin;
use super::walls::Flat;
use crate::spatial::TriangleBvh;
use glam::DVec3;
use rayon::prelude::*;

/// Two sides of a wall look away from each other within this angle.
const OPPOSITE_DEG: f64 = 30.0;
/// Thicker than so many median thicknesses is no thin wall.
const THICK: f64 = 2.5;
/// A mid-point is covered by mesh nearer than this share of the thickness: of a lost wall the next mesh is half a thickness away or more.
const NEAR: f64 = 0.35;
/// A ray inwards starts behind the facet that it comes from: this share of the diagonal.
const BEHIND: f64 = 1e-5;
/// A free edge is on a rim that is nearer than this share of the thickness: half would be exact for a square rim.
const ON_RIM: f64 = 0.75;
/// A free edge this near to the skin has come to the end of the material, whatever face is there: a sheet inside a wall is half a thickness away.
const AT_SKIN: f64 = 0.1;

/// What was measured.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct Coverage {
    pub cover: f64,
    pub thin_share: f64,
    pub thickness_median: Option<f64>,
    pub free_off: f64,
    pub free_length: f64,
}

/// A sample of the skin.
struct Spot {
    at: DVec3,
    normal: DVec3,
    /// Distance to the opposite side, where there is one.
    thickness: Option<f64>,
}

/// Measures `count` samples of the skin. `free` are the free edges of the mesh.
pub(super) fn measure(
    skin: &Skin,
    flat: &Flat,
    free: &[[DVec3; 2]],
    count: usize,
    seed: u64,
) -> Coverage {
    let samples = spread(&skin.areas(), count, seed);
    let spots: Vec<Spot> = samples
        .par_iter()
        .map(|s| look_across(skin, s.triangle, s.weights))
        .collect();
    let thickness_median = median(spots.iter().filter_map(|s| s.thickness).collect());
    let limit = thickness_median.map_or(0.0, |t| THICK * t);
    let thin = |s: &Spot| s.thickness.filter(|t| *t <= limit);
    let mesh = TriangleBvh::new(&flat.triangles);
    let covered: Vec<Option<bool>> = spots
        .par_iter()
        .map(|s| {
            let t = thin(s)?;
            let middle = s.at - s.normal * (t / 2.0);
            Some(mesh.nearest_within(middle, NEAR * t).is_some())
        })
        .collect();
    let walls = covered.iter().flatten().count();
    let hits = covered.iter().flatten().filter(|c| **c).count();
    let rims: Vec<[DVec3; 3]> = spots
        .iter()
        .filter(|s| thin(s).is_none())
        .map(|s| [s.at; 3])
        .chain(skin.sharp.iter().map(|[a, b]| [*a, *b, *b]))
        .collect();
    let on_rim = |p: DVec3, reach: f64| {
        let Some((piece, weights)) = skin.nearest(p, reach) else {
            return false;
        };
        if skin.above(piece, weights).2.distance(p) < AT_SKIN / ON_RIM * reach {
            return true;
        }
        thin(&look_across(skin, piece, weights)).is_none()
    };
    let (free_off, free_length) = free_edges(free, &rims, &flat.thickness, on_rim);
    Coverage {
        cover: hits as f64 / walls.max(1) as f64,
        thin_share: walls as f64 / spots.len().max(1) as f64,
        thickness_median,
        free_off,
        free_length,
    }
}

fn look_across(skin: &Skin, piece: usize, weights: [f64; 3]) -> Spot {
    let (corners, _, at, normal) = skin.above(piece, weights);
    let [a, b, c] = corners;
    let from = a * weights[0] + b * weights[1] + c * weights[2];
    let inward = -(b - a).cross(c - a).normalize_or_zero();
    let thickness = skin
        .hit(from, inward, BEHIND * skin.diagonal)
        .filter(|hit| -hit.normal.dot(normal) > OPPOSITE_DEG.to_radians().cos())
        .map(|hit| skin.distance(at, hit.face, hit.t));
    Spot {
        at,
        normal,
        thickness,
    }
}

/// Share of the free length that is on no rim, and all of it. A point is on a rim if one of the `rims` is near, or if `on_rim` says so of
/// the skin next to it: samples are too sparse for the narrow rims of a large part.
fn free_edges(
    free: &[[DVec3; 2]],
    rims: &[[DVec3; 3]],
    thickness: &[f64],
    on_rim: impl Fn(DVec3, f64) -> bool + Sync,
) -> (f64, f64) {
    let Some(t) = median(thickness.to_vec()) else {
        return (0.0, 0.0);
    };
    let rims = TriangleBvh::new(rims);
    let off: Vec<f64> = free
        .par_iter()
        .map(|[a, b]| {
            let points = [0.25, 0.5, 0.75].map(|f| a.lerp(*b, f));
            let lost =
                |p: DVec3| rims.nearest_within(p, ON_RIM * t).is_none() && !on_rim(p, ON_RIM * t);
            points.iter().filter(|p| lost(**p)).count() as f64 / 3.0 * a.distance(*b)
        })
        .collect();
    let all: f64 = free.iter().map(|[a, b]| a.distance(*b)).sum();
    let off: f64 = off.iter().sum();
    (if all > 0.0 { off / all } else { 0.0 }, all)
}
