//! The mesh measured from the solid: has every wall its mesh, and do free edges lie on rims?

use super::places::{Finding, near_keys, node_key};
use super::sampling::{median, spread};
use super::skin::Skin;
use super::walls::Flat;
use crate::model::ids::{ElementId, NodeId};
use crate::model::shell::{Element, ShellMesh};
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
/// A free edge is on a rim that is nearer than this share of its own thickness: half would be exact for a square rim.
const ON_RIM: f64 = 0.75;
/// A free edge this near to the skin has come to the end of the material, whatever face is there: a sheet inside a wall is half a thickness away.
const AT_SKIN: f64 = 0.1;

/// Samples without mesh that are nearer to each other than so many times their spacing are of one place: neighbours in a strip are at most about two apart.
const SAME_PLACE: f64 = 3.0;

/// What was measured.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct Coverage {
    pub cover: f64,
    pub thin_share: f64,
    pub thickness_median: Option<f64>,
    pub free_off: f64,
    pub free_length: f64,
    /// Samples of walls without mesh, at their mid-points.
    pub bare: Vec<Finding>,
    /// Free edges on no rim.
    pub off_rim: Vec<Finding>,
}

/// A sample of the skin.
struct Spot {
    at: DVec3,
    normal: DVec3,
    /// Distance to the opposite side, where there is one.
    thickness: Option<f64>,
    /// Tags of its face and of that on the opposite side.
    faces: [i32; 2],
}

/// Measures `count` samples of the skin. `free` are the free edges of the mesh, with their elements.
pub(super) fn measure(
    skin: &Skin,
    mesh: &ShellMesh,
    flat: &Flat,
    free: &[([NodeId; 2], ElementId)],
    count: usize,
    seed: u64,
) -> Coverage {
    let areas = skin.areas();
    let samples = spread(&areas, count, seed);
    let spots: Vec<Spot> = samples
        .par_iter()
        .map(|s| look_across(skin, s.triangle, s.weights))
        .collect();
    let thickness_median = median(spots.iter().filter_map(|s| s.thickness).collect());
    let limit = thickness_median.map_or(0.0, |t| THICK * t);
    let thin = |s: &Spot| s.thickness.filter(|t| *t <= limit);
    let triangles = TriangleBvh::new(&flat.triangles);
    let covered: Vec<Option<bool>> = spots
        .par_iter()
        .map(|s| {
            let t = thin(s)?;
            let middle = s.at - s.normal * (t / 2.0);
            Some(triangles.nearest_within(middle, NEAR * t).is_some())
        })
        .collect();
    let walls = covered.iter().flatten().count();
    let hits = covered.iter().flatten().filter(|c| **c).count();
    let spacing = (areas.iter().sum::<f64>() / spots.len().max(1) as f64).sqrt();
    let bare = spots
        .iter()
        .zip(&covered)
        .filter(|(_, covered)| **covered == Some(false))
        .map(|(s, _)| bare(s, SAME_PLACE * spacing))
        .collect();
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
    // How far the sheet could go on from here before it leaves the material.
    let ahead = |p: DVec3, direction: DVec3| {
        let inside = skin.holds(p, 0.0);
        let hit = inside.then(|| skin.hit(p, direction, 0.0)).flatten();
        hit.map_or(0.0, |hit| hit.t)
    };
    let usual = thickness_median.unwrap_or(0.0);
    let (off_rim, free_length) = free_edges(mesh, free, &rims, usual, on_rim, ahead);
    let off = off_rim.iter().fold(0.0, |sum, f| sum + f.weight);
    Coverage {
        cover: hits as f64 / walls.max(1) as f64,
        thin_share: walls as f64 / spots.len().max(1) as f64,
        thickness_median,
        free_off: if free_length > 0.0 {
            off / free_length
        } else {
            0.0
        },
        free_length,
        bare,
        off_rim,
    }
}

/// A sample without mesh; those within `reach` of each other are of one place.
fn bare(spot: &Spot, reach: f64) -> Finding {
    let at = spot.at - spot.normal * (spot.thickness.unwrap_or(0.0) / 2.0);
    Finding {
        at,
        value: 1.0,
        weight: 1.0,
        faces: spot.faces.to_vec(),
        elements: Vec::new(),
        keys: near_keys(at, reach),
    }
}

fn look_across(skin: &Skin, piece: usize, weights: [f64; 3]) -> Spot {
    let (corners, face, at, normal) = skin.above(piece, weights);
    let [a, b, c] = corners;
    let from = a * weights[0] + b * weights[1] + c * weights[2];
    let inward = -(b - a).cross(c - a).normalize_or_zero();
    let across = skin
        .hit(from, inward, BEHIND * skin.diagonal)
        .filter(|hit| -hit.normal.dot(normal) > OPPOSITE_DEG.to_radians().cos());
    let opposite = across.as_ref().map_or(0, |hit| skin.tag(hit.face));
    Spot {
        at,
        normal,
        thickness: across.map(|hit| skin.distance(at, hit.face, hit.t)),
        faces: [skin.tag(face), opposite],
    }
}

/// The free edges that are on no rim, weighted by the length that is not, and the length of all. A point is on a rim if one of the `rims` is near, or if
/// `on_rim` says so of the skin next to it (samples are too sparse for the narrow rims of a large part), or if the material ends just `ahead` of it, within
/// what counts as near for its own thickness or the `usual` one: where a wall tapers off, its own says nothing.
fn free_edges(
    mesh: &ShellMesh,
    free: &[([NodeId; 2], ElementId)],
    rims: &[[DVec3; 3]],
    usual: f64,
    on_rim: impl Fn(DVec3, f64) -> bool + Sync,
    ahead: impl Fn(DVec3, DVec3) -> f64 + Sync,
) -> (Vec<Finding>, f64) {
    let rims = TriangleBvh::new(rims);
    let ends = |e: &[NodeId; 2]| Some([*mesh.nodes.get(e[0])?, *mesh.nodes.get(e[1])?]);
    let looked: Vec<(f64, Option<Finding>)> = free
        .par_iter()
        .filter_map(|(edge, id)| {
            let [a, b] = ends(edge)?;
            let element = &mesh.elements[*id];
            let length = a.distance(b);
            let reach = ON_RIM * element.mean_thickness();
            let outwards = outwards(mesh, element, [a, b]);
            let lost = |p: DVec3| {
                rims.nearest_within(p, reach).is_none()
                    && !on_rim(p, reach)
                    && ahead(p, outwards) > reach.max(ON_RIM * usual)
            };
            let points = [0.25, 0.5, 0.75].map(|f| a.lerp(b, f));
            let off = points.iter().filter(|p| lost(**p)).count() as f64 / 3.0;
            let finding = Finding {
                at: points[1],
                value: off * length,
                weight: off * length,
                faces: element.source_faces.to_vec(),
                elements: vec![*id],
                keys: edge.map(node_key).to_vec(),
            };
            Some((length, (off > 0.0).then_some(finding)))
        })
        .collect();
    let length = looked.iter().map(|l| l.0).sum();
    (looked.into_iter().filter_map(|l| l.1).collect(), length)
}

/// The direction in the plane of an element that leads over one of its edges.
fn outwards(mesh: &ShellMesh, element: &Element, [a, b]: [DVec3; 2]) -> DVec3 {
    let corners = element.corners.as_slice();
    let points = corners.iter().filter_map(|n| mesh.nodes.get(*n));
    let centre = points.fold(DVec3::ZERO, |sum, p| sum + *p) / corners.len() as f64;
    let across = (a + b) / 2.0 - centre;
    across
        .reject_from(b - a)
        .try_normalize()
        .unwrap_or_else(|| across.normalize_or(DVec3::X))
}
