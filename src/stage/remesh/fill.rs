//! Triangles for a loop of nodes: the least bent ones, or the Delaunay ones in its plane.
//!
//! Guarantee: what comes out is a disc whose border is the loop, wound as the loop runs.
//! Limits: the plane of a loop that crosses itself there has no triangles; the least bent ones may then lie on each other.
//! Cost: cubic in the length of the loop for the least bent ones.
//!
//! Reference: P. Liepa, Filling holes in meshes, SGP 2003, doi:10.2312/SGP/SGP03/200-205 (dynamic programme over worst dihedral angle, then area).

use super::shape::area_vector;
use crate::geom::cdt::triangulate_region;
use glam::{DVec2, DVec3};

/// How bad a filling is: its sharpest bend (1 less its cosine), then its area.
type Weight = (f64, f64);

/// The filling of a loop of points without nodes inside that bends least; corners as places in the loop. `beside[k]`: the normal of what lies beyond side `k`, where the
/// sheet goes on there.
pub(super) fn least_bent(points: &[DVec3], beside: &[Option<DVec3>]) -> Vec<[usize; 3]> {
    let count = points.len();
    if count < 3 {
        return Vec::new();
    }
    // For each span of the loop the weight of its filling, the apex over its chord, and that triangle's normal.
    let mut weight: Vec<Weight> = vec![(0.0, 0.0); count * count];
    let mut apex = vec![0; count * count];
    let mut normal: Vec<Option<DVec3>> = vec![None; count * count];
    for i in 0..count {
        normal[i * count + (i + 1) % count] = beside[i];
    }
    for width in 2..count {
        for i in 0..count - width {
            let j = i + width;
            let mut least: Option<(Weight, usize, DVec3)> = None;
            for k in i + 1..j {
                let area = area_vector([points[i], points[k], points[j]]);
                let own = area.normalize_or_zero();
                let (left, right) = (i * count + k, k * count + j);
                // The last chord is a side of the loop itself.
                let last = (i == 0 && j + 1 == count).then_some(beside[j]).flatten();
                let bend = [normal[left], normal[right], last]
                    .into_iter()
                    .flatten()
                    .map(|n| 1.0 - n.dot(own))
                    .fold(weight[left].0.max(weight[right].0), f64::max);
                let new = (bend, weight[left].1 + weight[right].1 + area.length());
                let better = |w: &Weight| new.0.total_cmp(&w.0).then(new.1.total_cmp(&w.1));
                if least.as_ref().is_none_or(|l| better(&l.0).is_lt()) {
                    least = Some((new, k, own));
                }
            }
            if let Some((w, k, own)) = least {
                weight[i * count + j] = w;
                apex[i * count + j] = k;
                normal[i * count + j] = Some(own);
            }
        }
    }
    let mut triangles = Vec::with_capacity(count - 2);
    let mut spans = vec![(0, count - 1)];
    while let Some((i, j)) = spans.pop() {
        if j > i + 1 {
            let k = apex[i * count + j];
            triangles.push([i, k, j]);
            spans.extend([(i, k), (k, j)]);
        }
    }
    triangles
}

/// The Delaunay triangles in the plane of a loop, with as many of the inner points as have room there; corners as places in the loop and then in the list of inner points.
pub(super) fn delaunay(points: &[DVec3], inner: &[DVec3]) -> Option<Vec<[usize; 3]>> {
    let count = points.len();
    let side = |k: usize| (points[k], points[(k + 1) % count]);
    let origin = points[0];
    let normal: DVec3 = (0..count)
        .map(|k| (side(k).0 - origin).cross(side(k).1 - origin))
        .sum();
    let (x, y) = normal.try_normalize()?.any_orthonormal_pair();
    let plane = |p: &DVec3| DVec2::new((*p - origin).dot(x), (*p - origin).dot(y));
    let mut flat: Vec<DVec2> = points.iter().map(plane).collect();
    let length: f64 = (0..count)
        .map(|k| flat[k].distance(flat[(k + 1) % count]))
        .sum();
    let room = ROOM * length / count as f64;
    let outline = flat.clone();
    let mut kept: Vec<usize> = (0..count).collect();
    for (i, p) in inner.iter().map(plane).enumerate() {
        let far = |q: &DVec2| q.distance(p) > room;
        if is_inside(&outline, p) && flat.iter().all(far) && clear(&outline, p) > room {
            flat.push(p);
            kept.push(count + i);
        }
    }
    let names: Vec<u32> = (0..flat.len() as u32).collect();
    let border: Vec<[u32; 2]> = (0..count)
        .map(|k| [k as u32, ((k + 1) % count) as u32])
        .collect();
    let triangles = triangulate_region(&flat, &names, &border, &[]).ok()?;
    let expected = count + 2 * (flat.len() - count) - 2;
    (triangles.len() == expected).then(|| {
        (triangles.iter())
            .map(|t| t.map(|n| kept[n as usize]))
            .collect()
    })
}

/// Points inside stay this far from each other and from the loop, as a share of its mean side: half of that of well shaped triangles.
const ROOM: f64 = 0.4;

fn is_inside(outline: &[DVec2], p: DVec2) -> bool {
    let mut inside = false;
    for (k, a) in outline.iter().enumerate() {
        let b = outline[(k + 1) % outline.len()];
        if (a.y > p.y) != (b.y > p.y) && p.x < a.x + (b.x - a.x) * (p.y - a.y) / (b.y - a.y) {
            inside = !inside;
        }
    }
    inside
}

/// Distance of a point from the loop.
fn clear(outline: &[DVec2], p: DVec2) -> f64 {
    let away = |(k, a): (usize, &DVec2)| {
        let d = outline[(k + 1) % outline.len()] - *a;
        let along = ((p - *a).dot(d) / d.length_squared()).clamp(0.0, 1.0);
        p.distance(*a + d * along)
    };
    outline
        .iter()
        .enumerate()
        .map(away)
        .fold(f64::INFINITY, f64::min)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn area(points: &[DVec3], triangles: &[[usize; 3]]) -> DVec3 {
        (triangles.iter())
            .map(|t| area_vector(t.map(|n| points[n])) / 2.0)
            .sum()
    }

    /// An L of six corners, of area 3.
    fn angle() -> Vec<DVec3> {
        [(0, 0), (2, 0), (2, 1), (1, 1), (1, 2), (0, 2)]
            .map(|(x, y)| DVec3::new(f64::from(x), f64::from(y), 0.0))
            .to_vec()
    }

    #[test]
    fn both_fill_an_angle_and_turn_no_triangle() {
        let points = angle();
        let bent = least_bent(&points, &[Some(DVec3::Z); 6]);
        let flat = delaunay(&points, &[]).unwrap();
        for triangles in [bent, flat] {
            assert_eq!(triangles.len(), 4);
            assert!((area(&points, &triangles) - DVec3::Z * 3.0).length() < 1e-12);
            let up = |t: &[usize; 3]| area_vector(t.map(|n| points[n])).z > 0.0;
            assert!(triangles.iter().all(up));
        }
    }

    #[test]
    fn a_ridge_is_filled_along_itself() {
        // A roof: the ridge from (1, 0) to (1, 4) is the one chord that bends no slope.
        let corner = |x: f64, y: f64, z: f64| DVec3::new(x, y, z);
        let front = [
            corner(0.0, 0.0, 0.0),
            corner(1.0, 0.0, 0.5),
            corner(2.0, 0.0, 0.0),
        ];
        let back = [
            corner(2.0, 4.0, 0.0),
            corner(1.0, 4.0, 0.5),
            corner(0.0, 4.0, 0.0),
        ];
        let points = [front, back].concat();
        let left = DVec3::new(-0.5, 0.0, 1.0).normalize();
        let right = DVec3::new(0.5, 0.0, 1.0).normalize();
        let beside = [None, None, Some(right), None, None, Some(left)];
        let triangles = least_bent(&points, &beside);
        let ridge = (triangles.iter()).filter(|t| t.contains(&1) && t.contains(&4));
        assert_eq!(ridge.count(), 2, "{triangles:?}");
    }

    #[test]
    fn points_inside_are_taken_where_they_have_room() {
        let points: Vec<DVec3> = angle().iter().map(|p| *p * 4.0).collect();
        let inner = [
            DVec3::new(2.2, 2.2, 0.0),
            DVec3::new(2.3, 2.2, 0.0),
            DVec3::new(7.0, 7.0, 0.0),
        ];
        let triangles = delaunay(&points, &inner).unwrap();
        let used = |n: usize| triangles.iter().any(|t| t.contains(&n));
        assert_eq!([used(6), used(7), used(8)], [true, false, false]);
        assert_eq!(triangles.len(), 6);
    }

    #[test]
    fn a_loop_that_crosses_itself_has_no_triangles_in_its_plane() {
        let mut points = angle();
        points.swap(2, 4);
        assert!(delaunay(&points, &[]).is_none());
    }
}
