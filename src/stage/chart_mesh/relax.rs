//! Relaxation: Delaunay triangles and places of the free points in turn.
//!
//! Each free point goes to the mean of its triangles' centroids, weighted by area and density (centroidal patch triangulation, Chen & Xu
//! 2004); points too close go, long edges get one more.

use super::MeshError;
use super::front::Point;
use super::surface::Surface;
use crate::geom::cdt::triangulate_region;
use glam::DVec2;

/// Rounds of triangulating and moving; the gain in the least angle is below a degree beyond these.
const ROUNDS: usize = 9;

/// Rounds after which points are taken away and added: late enough to see the settled density, early enough to settle again.
const REPAIRS: [usize; 3] = [2, 4, 7];

/// An inner edge longer than this many sizes gets a point, and a free end of one shorter goes: the geometric means of 1 and 2, and of
/// 1/2 and 1/sqrt(3).
const LONG: f64 = 1.42;
const SHORT: f64 = 0.55;

/// What the triangulation must respect; corners are counted over fixed points, then free ones.
pub(super) struct Frame<'a> {
    /// Names of the fixed points.
    pub names: &'a [u32],
    /// Boundary edges.
    pub boundary: &'a [[u32; 2]],
    /// Edges inside that stay. Sorted, lower end first.
    pub inner: &'a [[u32; 2]],
}

impl Frame<'_> {
    pub(super) fn triangulate(&self, points: &[Point]) -> Result<Vec<[u32; 3]>, MeshError> {
        let places: Vec<DVec2> = points.iter().map(|p| p.place).collect();
        let mut names = self.names.to_vec();
        // Free points have names of their own, above all node ids.
        names.extend((0..(points.len() - names.len()) as u32).map(|i| u32::MAX - i));
        Ok(triangulate_region(
            &places,
            &names,
            self.boundary,
            self.inner,
        )?)
    }
}

/// Moves, removes and adds free points (those after the frame's), then triangulates.
pub(super) fn relax(
    surface: &Surface,
    frame: &Frame,
    points: &mut Vec<Point>,
) -> Result<Vec<[u32; 3]>, MeshError> {
    let mut triangles = frame.triangulate(points)?;
    for round in 0..ROUNDS {
        if REPAIRS.contains(&round) && repair(surface, frame, points, &triangles) {
            triangles = frame.triangulate(points)?;
        }
        move_free(surface, frame.names.len(), points, &triangles);
        triangles = frame.triangulate(points)?;
    }
    Ok(triangles)
}

/// The triangles round every point.
pub(super) fn rings(count: usize, triangles: &[[u32; 3]]) -> (Vec<u32>, Vec<u32>) {
    let mut start = vec![0u32; count + 1];
    for t in triangles.iter().flatten() {
        start[*t as usize + 1] += 1;
    }
    for i in 0..count {
        start[i + 1] += start[i];
    }
    let mut fill = start.clone();
    let mut ring = vec![0u32; 3 * triangles.len()];
    for (i, t) in triangles.iter().enumerate() {
        for c in t {
            ring[fill[*c as usize] as usize] = i as u32;
            fill[*c as usize] += 1;
        }
    }
    (start, ring)
}

fn move_free(surface: &Surface, fixed: usize, points: &mut [Point], triangles: &[[u32; 3]]) {
    let (start, ring) = rings(points.len(), triangles);
    for i in fixed..points.len() {
        let own = &ring[start[i] as usize..start[i + 1] as usize];
        if own.is_empty() {
            continue;
        }
        let (mut sum, mut total) = (DVec2::ZERO, 0.0);
        for t in own {
            let corners = triangles[*t as usize].map(|c| points[c as usize]);
            let [a, b, c] = corners.map(|p| p.place);
            let size = corners.iter().map(|p| p.size).sum::<f64>() / 3.0;
            let middle = (a + b + c) / 3.0;
            let growth = surface
                .locate(middle)
                .map_or(1.0, |s| surface.growth(s.triangle));
            // Cells of the wanted size ask for size^-4; half the exponent keeps triangles good where sizes grow fast.
            let mass = (b - a).perp_dot(c - a) * growth / size.powi(2);
            sum += mass * middle;
            total += mass;
        }
        let old = points[i].place;
        let target = sum / total;
        // A full step, else half of it, else none.
        for share in [1.0, 0.5] {
            points[i].place = surface.snap.place(old.lerp(target, share));
            let valid = target.is_finite()
                && surface.locate(points[i].place).is_some()
                && own.iter().all(|t| {
                    let [a, b, c] = triangles[*t as usize].map(|c| points[c as usize].place);
                    (b - a).perp_dot(c - a) > 0.0
                });
            if valid {
                break;
            }
            points[i].place = old;
        }
    }
}

/// Takes away points that are too close and adds some where edges are long; tells whether anything changed.
fn repair(
    surface: &Surface,
    frame: &Frame,
    points: &mut Vec<Point>,
    triangles: &[[u32; 3]],
) -> bool {
    let fixed = frame.names.len();
    let mut edges: Vec<([u32; 2], bool)> = Vec::with_capacity(3 * triangles.len());
    for t in triangles {
        for k in 0..3 {
            let (a, b) = (t[k], t[(k + 1) % 3]);
            edges.push(([a.min(b), a.max(b)], false));
        }
    }
    edges.sort_unstable();
    // An edge seen once is on the boundary.
    let inner: Vec<[u32; 2]> = edges
        .chunk_by(|a, b| a.0 == b.0)
        .filter(|run| run.len() == 2)
        .map(|run| run[0].0)
        .collect();
    let mut gone = vec![false; points.len()];
    let mut touched = vec![false; points.len()];
    let mut added = Vec::new();
    // Three or four triangles round a point have angles of 90 degrees and more there.
    let (start, ring) = rings(points.len(), triangles);
    for i in fixed..points.len() {
        let own = &ring[start[i] as usize..start[i + 1] as usize];
        let corners = || own.iter().flat_map(|t| triangles[*t as usize]);
        if own.len() < 5 && corners().all(|c| !touched[c as usize]) {
            gone[i] = true;
            corners().for_each(|c| touched[c as usize] = true);
        }
    }
    for [a, b] in inner {
        let (p, q) = (points[a as usize], points[b as usize]);
        let middle = surface.snap.place((p.place + q.place) / 2.0);
        let Some(spot) = surface.locate(middle) else {
            continue;
        };
        let length = surface.push(spot.triangle, q.place - p.place).length();
        let size = (p.size + q.size) / 2.0;
        let fresh = !touched[a as usize] && !touched[b as usize];
        // One change a neighbourhood and round.
        if fresh && length < SHORT * size && b as usize >= fixed {
            gone[b as usize] = true;
        } else if fresh
            && length > LONG * size
            && frame.inner.binary_search(&[a, b]).is_err()
            && (a as usize >= fixed || b as usize >= fixed)
        {
            added.push(Point {
                place: middle,
                size,
            });
        } else {
            continue;
        }
        touched[a as usize] = true;
        touched[b as usize] = true;
    }
    let changed = !added.is_empty() || gone.contains(&true);
    let mut at = 0;
    points.retain(|_| {
        at += 1;
        !gone[at - 1]
    });
    points.extend(added);
    changed
}
