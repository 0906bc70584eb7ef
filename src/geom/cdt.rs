//! Constrained Delaunay triangulation of a plane region with holes.
//!
//! The one module that knows the triangulation library (`spade`).
//!
//! **Guarantees.** Every given edge is an edge of the result, no point is added, and triangles are counter-clockwise and cover just the
//! region inside the boundary (even-odd rule); otherwise an error says which edge or point is at fault.
//! **Limits.** Points that coincide are refused unless their `name` is the same (the two sides of a slit that lies closed).

use glam::DVec2;
use spade::{ConstrainedDelaunayTriangulation, Point2, Triangulation};
use std::collections::VecDeque;

/// Why a region could not be triangulated.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum CdtError {
    /// A coordinate is not finite, or too small or large for exact predicates.
    #[error("point {0} has no usable coordinates")]
    BadPoint(u32),
    /// Two points with different names lie on one place.
    #[error("points {0} and {1} coincide")]
    Coincident(u32, u32),
    /// An edge crosses another edge or passes through a point.
    #[error("edge {0} to {1} crosses another edge or point")]
    Crossing(u32, u32),
    /// No triangle lies inside the boundary.
    #[error("the boundary of {0} edges encloses nothing")]
    Empty(usize),
}

/// Delaunay triangles (corners as indices into `points`, counter-clockwise) of the region inside the `boundary` edges, which keep the
/// `boundary` and the `inner` edges.
///
/// `names` (as many as `points`) tells which points may coincide: those of equal name; the lowest index then stands for all of them.
///
/// # Errors
/// See [`CdtError`].
pub fn triangulate_region(
    points: &[DVec2],
    names: &[u32],
    boundary: &[[u32; 2]],
    inner: &[[u32; 2]],
) -> Result<Vec<[u32; 3]>, CdtError> {
    let stand_in = merge_coincident(points, names)?;
    // Insertion ids of the library count distinct points in the order given.
    let mut given: Vec<u32> = Vec::with_capacity(points.len());
    let mut handle = vec![u32::MAX; points.len()];
    for i in 0..points.len() {
        if stand_in[i] as usize == i {
            handle[i] = given.len() as u32;
            given.push(i as u32);
        } else {
            handle[i] = handle[stand_in[i] as usize];
        }
    }
    let vertices: Vec<Point2<f64>> = given
        .iter()
        .map(|&i| Point2::new(points[i as usize].x, points[i as usize].y))
        .collect();
    let edge_key = |e: &[u32; 2]| {
        let (a, b) = (handle[e[0] as usize], handle[e[1] as usize]);
        [a.min(b), a.max(b)]
    };
    let mut walls: Vec<[u32; 2]> = boundary.iter().map(edge_key).collect();
    walls.sort_unstable();
    let mut all = walls.clone();
    all.extend(inner.iter().map(edge_key));
    all.retain(|e| e[0] != e[1]);
    all.sort_unstable();
    all.dedup();

    let mut refused = None;
    let cdt = ConstrainedDelaunayTriangulation::<Point2<f64>>::try_bulk_load_cdt(
        vertices,
        all.iter().map(|e| [e[0] as usize, e[1] as usize]).collect(),
        |e| refused = refused.or(Some(e)),
    )
    .map_err(|_| CdtError::BadPoint(0))?;
    let crossing = |e: [u32; 2]| CdtError::Crossing(given[e[0] as usize], given[e[1] as usize]);
    if let Some(e) = refused {
        return Err(crossing([e[0] as u32, e[1] as u32]));
    }
    let vertex = |i: u32| spade::handles::FixedVertexHandle::from_index(i as usize);
    if let Some(lost) = all
        .iter()
        .find(|e| !cdt.exists_constraint(vertex(e[0]), vertex(e[1])))
    {
        return Err(crossing(*lost));
    }

    // Flood from outside; every boundary edge crossed an odd number of times changes sides.
    let outer = cdt.outer_face();
    let mut inside: Vec<Option<bool>> = vec![None; cdt.num_all_faces()];
    inside[outer.index()] = Some(false);
    let mut queue = VecDeque::new();
    let flips = |a: usize, b: usize| {
        let key = [a.min(b) as u32, a.max(b) as u32];
        let run = walls.partition_point(|w| *w <= key) - walls.partition_point(|w| *w < key);
        run % 2 == 1
    };
    for edge in cdt.convex_hull() {
        let face = edge.rev().face();
        let odd = flips(edge.from().index(), edge.to().index());
        if inside[face.index()].is_none() {
            inside[face.index()] = Some(odd);
            queue.push_back(face.fix());
        }
    }
    while let Some(face) = queue.pop_front() {
        let Some(inner_face) = cdt.face(face).as_inner() else {
            continue;
        };
        let here = inside[inner_face.index()].unwrap_or(false);
        for edge in inner_face.adjacent_edges() {
            let next = edge.rev().face();
            if inside[next.index()].is_none() {
                let odd = flips(edge.from().index(), edge.to().index());
                inside[next.index()] = Some(here ^ odd);
                queue.push_back(next.fix());
            }
        }
    }
    let triangles: Vec<[u32; 3]> = cdt
        .inner_faces()
        .filter(|f| inside[f.index()] == Some(true))
        .map(|f| f.vertices().map(|v| given[v.index()]))
        .collect();
    if triangles.is_empty() {
        return Err(CdtError::Empty(boundary.len()));
    }
    Ok(triangles)
}

/// For every point the lowest point that lies on the same place.
fn merge_coincident(points: &[DVec2], names: &[u32]) -> Result<Vec<u32>, CdtError> {
    // Zero and minus zero are one place.
    let key = |p: DVec2| ((p.x + 0.0).to_bits(), (p.y + 0.0).to_bits());
    let mut order: Vec<u32> = (0..points.len() as u32).collect();
    for &i in &order {
        let p = points[i as usize];
        for c in [p.x, p.y] {
            if spade::validate_coordinate(c).is_err() {
                return Err(CdtError::BadPoint(i));
            }
        }
    }
    order.sort_unstable_by_key(|&i| (key(points[i as usize]), i));
    let mut stand_in: Vec<u32> = (0..points.len() as u32).collect();
    for run in order.chunk_by(|&a, &b| key(points[a as usize]) == key(points[b as usize])) {
        for &i in &run[1..] {
            if names[i as usize] != names[run[0] as usize] {
                return Err(CdtError::Coincident(run[0], i));
            }
            stand_in[i as usize] = run[0];
        }
    }
    Ok(stand_in)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn ring(indices: std::ops::Range<u32>) -> Vec<[u32; 2]> {
        let (first, last) = (indices.start, indices.end);
        indices
            .map(|i| [i, if i + 1 == last { first } else { i + 1 }])
            .collect()
    }

    fn square(half: f64) -> Vec<DVec2> {
        vec![
            DVec2::new(-half, -half),
            DVec2::new(half, -half),
            DVec2::new(half, half),
            DVec2::new(-half, half),
        ]
    }

    fn area(points: &[DVec2], triangles: &[[u32; 3]]) -> f64 {
        triangles
            .iter()
            .map(|t| {
                let [a, b, c] = t.map(|i| points[i as usize]);
                let doubled = (b - a).perp_dot(c - a);
                assert!(doubled > 0.0, "clockwise");
                doubled / 2.0
            })
            .sum()
    }

    fn own_names(points: &[DVec2]) -> Vec<u32> {
        (0..points.len() as u32).collect()
    }

    #[test]
    fn a_square_with_a_square_hole_has_the_area_between() {
        let mut points = square(2.0);
        points.extend(square(1.0));
        let mut edges = ring(0..4);
        edges.extend(ring(4..8));
        let t = triangulate_region(&points, &own_names(&points), &edges, &[]).unwrap();
        assert_eq!(t.len(), 8);
        assert!((area(&points, &t) - 12.0).abs() < 1e-12);
    }

    #[test]
    fn an_inner_edge_is_kept_and_does_not_change_sides() {
        let mut points = square(1.0);
        points.extend([DVec2::new(-0.9, -0.05), DVec2::new(0.9, 0.05)]);
        points.extend([DVec2::new(0.0, -0.2), DVec2::new(0.0, 0.2)]);
        let t = triangulate_region(&points, &own_names(&points), &ring(0..4), &[[4, 5]]).unwrap();
        assert!((area(&points, &t) - 4.0).abs() < 1e-12);
        let with_edge = t.iter().filter(|t| t.contains(&4) && t.contains(&5));
        assert_eq!(with_edge.count(), 2);
    }

    #[test]
    fn a_closed_slit_changes_nothing() {
        // Square with a slit from the right side's middle to the centre, both sides of it listed.
        let mut points = square(1.0);
        points.extend([DVec2::new(1.0, 0.0), DVec2::ZERO, DVec2::new(1.0, 0.0)]);
        let edges = [[0, 1], [1, 4], [4, 5], [5, 6], [6, 2], [2, 3], [3, 0]];
        let t = triangulate_region(&points, &[0, 1, 2, 3, 4, 5, 4], &edges, &[]).unwrap();
        assert!((area(&points, &t) - 4.0).abs() < 1e-12);
        assert!(t.iter().flatten().all(|&i| i != 6));
        assert_eq!(
            triangulate_region(&points, &own_names(&points), &edges, &[]),
            Err(CdtError::Coincident(4, 6))
        );
    }

    #[test]
    fn crossing_edges_and_points_on_edges_are_refused() {
        let points = [
            DVec2::new(0.0, 0.0),
            DVec2::new(1.0, 1.0),
            DVec2::new(1.0, 0.0),
            DVec2::new(0.0, 1.0),
        ];
        let r = triangulate_region(&points, &own_names(&points), &ring(0..4), &[]);
        assert!(matches!(r, Err(CdtError::Crossing(..))), "{r:?}");
        let mut points = square(1.0);
        points.push(DVec2::new(1.0, 0.0));
        let r = triangulate_region(&points, &own_names(&points), &ring(0..4), &[]);
        assert!(matches!(r, Err(CdtError::Crossing(..))), "{r:?}");
    }

    #[test]
    fn points_that_are_not_finite_are_refused() {
        let mut points = square(1.0);
        points[2].x = f64::NAN;
        let r = triangulate_region(&points, &own_names(&points), &ring(0..4), &[]);
        assert_eq!(r, Err(CdtError::BadPoint(2)));
    }
}
