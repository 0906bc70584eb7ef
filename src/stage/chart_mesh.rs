//! Meshing in the chart: good triangles of the wanted size for a patch, its boundary left as it is.
//!
//! **In** a patch, a chart of it without folds, the wanted edge length as a function of place, and what puts nodes on the surface.
//! **Out** new triangles the same way round as the patch's.
//!
//! Seeds in rows from the boundary, constrained Delaunay triangulation in the chart, relaxation, lift by the old triangles, placement on
//! the exact surface, Delaunay flips in space. Lengths are measured in space, so that a stretched chart does no harm.
//!
//! **Guarantees.** All boundary and kept edges are edges of the result, with their nodes and no others on them; same Euler
//! characteristic; no triangle turned against the old surface. Otherwise an error, and the old triangles should stay.
//! **Limits.** Angles are as good as the boundary allows: two boundary edges that meet at 10 degrees make a triangle of 10 degrees; edges of
//! very different lengths side by side, likewise. **Cost.** A dozen Delaunay triangulations of the new points.

mod cross;
mod directed;
mod flip;
mod front;
mod polish;
mod relax;
mod sizes;
mod surface;

use crate::geom::cdt::CdtError;
use crate::geom::placer::{LengthField, Lengths, Placer};
use crate::model::complex::Support;
use crate::model::patch::{Chart, Patch, PatchMesh};
use cross::Cross;
use directed::Directed;
use front::Point;
use glam::{DMat3, DVec3};
use rayon::prelude::*;
use relax::Frame;
use sizes::Sizes;
use surface::Surface;

/// How new nodes are laid.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Pattern {
    /// Equilateral triangles.
    Triangles,
    /// The halves of squares along a cross field, to be paired into quads.
    Squares,
}

/// How new nodes are laid, and how fast their distances grow.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Layout {
    /// Triangles or squares.
    pub pattern: Pattern,
    /// Distances from one row to the next differ by this factor at most.
    pub growth: f64,
}

impl From<Pattern> for Layout {
    fn from(pattern: Pattern) -> Self {
        Self {
            pattern,
            growth: front::GRADING,
        }
    }
}

/// Why a patch keeps its old triangles.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum MeshError {
    /// The chart's boundary crosses itself.
    #[error(transparent)]
    Cdt(#[from] CdtError),
    /// The chart folds.
    #[error("the chart has {0} folded triangles")]
    Folded(usize),
    /// Parts of the chart overlap.
    #[error("the chart has area {chart} but its triangulation {meshed}")]
    Overlap {
        /// Area of the chart, mm^2.
        chart: f64,
        /// Area of the triangles in the chart, mm^2.
        meshed: f64,
    },
    /// Not the same topology as before.
    #[error("the Euler characteristic was {before} and became {after}")]
    Topology {
        /// Of the old triangles.
        before: i64,
        /// Of the new ones.
        after: i64,
    },
    /// A triangle lies against the old surface.
    #[error("new triangle {0} is turned over")]
    Inverted(u32),
    /// The front would make more points than the patch has room for.
    #[error("more than {0} points: lengths in the chart say nothing about those in space")]
    Crowded(usize),
    /// No field of directions can be found.
    #[error("the old triangles are too flat for a cross field")]
    NoCross,
    /// No edge length is known anywhere.
    #[error("no edge length is known anywhere on the patch")]
    NoLength,
}

/// A front makes at most this many times the points that a patch's area and border call for.
const CROWDED: f64 = 4.0;

/// New triangles for a patch.
///
/// # Errors
/// See [`MeshError`].
pub fn triangulate(
    patch: &Patch,
    chart: &Chart,
    layout: impl Into<Layout>,
    lengths: &LengthField,
    placer: &dyn Placer,
) -> Result<PatchMesh, MeshError> {
    let Layout { pattern, growth } = layout.into();
    let folds = chart.check(patch).len();
    if folds > 0 {
        return Err(MeshError::Folded(folds));
    }
    let surface = Surface::new(patch, chart);
    let fixed = FixedParts::new(patch);
    let wanted = |p| lengths(p, patch.wall);
    let sizes = Sizes::new(patch, &|p| wanted(p).across, growth - 1.0);
    let mut points = fixed.points(patch, chart, &sizes);
    points
        .iter_mut()
        .for_each(|p| p.size = surface.snap.value(p.size));
    let squares = match pattern {
        Pattern::Triangles => None,
        Pattern::Squares => {
            let edges = fixed.corner_edges();
            let wanted: Vec<Lengths> = patch.points.par_iter().map(|&p| wanted(p)).collect();
            let cross = Cross::new(&surface, &edges, &wanted).ok_or(MeshError::NoCross)?;
            let squares = Directed::new(patch, cross, &wanted, &edges, growth - 1.0);
            Some(squares.ok_or(MeshError::NoLength)?)
        }
    };
    let most = most_points(patch, points.len(), &|t, area| match &squares {
        Some(squares) => squares.count(t, area),
        // A node has two triangles.
        None => area / (sizes.of(t).powi(2) * 3f64.sqrt() / 2.0),
    });
    let seeds = front::seeds(
        &surface,
        &points,
        &fixed.edges(),
        &front::Wanted {
            at: &|spot| sizes.at(spot),
            growth,
        },
        squares.as_ref(),
        most,
    )
    .ok_or(MeshError::Crowded(most))?;
    points.extend(seeds);
    let names: Vec<u32> = fixed
        .corners
        .iter()
        .map(|&c| patch.nodes[c as usize].0)
        .collect();
    let frame = Frame {
        names: &names,
        boundary: &fixed.boundary,
        inner: &fixed.inner,
    };
    let mut triangles = match pattern {
        Pattern::Triangles => relax::relax(&surface, &frame, &mut points)?,
        Pattern::Squares => frame.triangulate(&points)?,
    };
    check_area(patch, chart, &points, &triangles)?;

    let count = fixed.corners.len();
    let mut positions: Vec<DVec3> = (points.iter().enumerate())
        .map(|(i, p)| match fixed.corners.get(i) {
            Some(&c) => patch.points[c as usize],
            // Free points only ever move to places that have a spot.
            None => (surface.locate(p.place)).map_or(DVec3::NAN, |s| surface.lift(&s)),
        })
        .collect();
    let metrics: Vec<DMat3> = (squares.iter())
        .flat_map(|squares| points.iter().map(move |p| (squares, p.place)))
        .map(|(squares, place)| {
            let frame = surface.locate(place).map(|s| squares.at(&surface, &s));
            frame.map_or(DMat3::IDENTITY, |f| flip::metric(&f))
        })
        .collect();
    // What a flip spoils for a point the next search mends; a third round gains nothing.
    for _ in 0..2 {
        flip::flip(
            &points,
            &positions,
            &metrics,
            count,
            &fixed.inner,
            &mut triangles,
        );
        if pattern == Pattern::Squares {
            break;
        }
        polish::polish(&surface, &mut points, &mut positions, count, &triangles);
    }
    (positions[count..].par_iter_mut())
        .for_each(|p| *p = placer.place(*p, &[Support::Mid(patch.wall)]));
    check_turns(&surface, &points, &positions, &triangles)?;

    let corners = patch.nodes.len() as u32;
    let number = |i: u32| match fixed.corners.get(i as usize) {
        Some(&c) => c,
        None => corners + i - count as u32,
    };
    let mesh = PatchMesh {
        points: positions[count..].to_vec(),
        triangles: triangles.iter().map(|t| t.map(number)).collect(),
    };
    let name = |i: u32| match patch.nodes.get(i as usize) {
        Some(n) => u64::from(n.0),
        None => u64::from(i) << 32,
    };
    let before = euler(patch.triangles.iter().map(|t| t.map(name)));
    let after = euler(mesh.triangles.iter().map(|t| t.map(name)));
    if before != after {
        return Err(MeshError::Topology { before, after });
    }
    Ok(mesh)
}

/// Most points that the inside of a patch can want: a few times what its area holds. Where its triangles are folded, a length in space is far
/// shorter than it looks in the chart, and a front would fill the patch for ever.
fn most_points(patch: &Patch, fixed: usize, held: &dyn Fn([u32; 3], f64) -> f64) -> usize {
    let wanted: f64 = (patch.triangles.iter())
        .map(|t| {
            let [a, b, c] = t.map(|c| patch.points[c as usize]);
            let held = held(*t, (b - a).cross(c - a).length() / 2.0);
            if held.is_finite() { held } else { 1.0 }
        })
        .sum();
    (CROWDED * (wanted + fixed as f64)) as usize
}

/// What stays of a patch, counted anew.
struct FixedParts {
    /// Corners of the patch, sorted.
    corners: Vec<u32>,
    boundary: Vec<[u32; 2]>,
    /// Sorted, lower end first.
    inner: Vec<[u32; 2]>,
}

impl FixedParts {
    fn new(patch: &Patch) -> Self {
        let mut corners: Vec<u32> = patch.boundary().map(|e| e[0]).collect();
        corners.extend(&patch.kept_corners);
        corners.sort_unstable();
        corners.dedup();
        let place = |c: u32| corners.partition_point(|x| *x < c) as u32;
        let boundary = patch.boundary().map(|e| e.map(place)).collect();
        // Corners are sorted, so the lower end stays first and the order stays.
        let inner = patch.kept_edges.iter().map(|e| e.map(place)).collect();
        Self {
            corners,
            boundary,
            inner,
        }
    }

    /// All fixed edges, as corners of the patch.
    fn corner_edges(&self) -> Vec<[u32; 2]> {
        (self.boundary.iter().chain(&self.inner))
            .map(|e| e.map(|i| self.corners[i as usize]))
            .collect()
    }

    /// All fixed edges with whether the inside is on both sides.
    fn edges(&self) -> Vec<([u32; 2], bool)> {
        let outer = self.boundary.iter().map(|e| (*e, false));
        outer.chain(self.inner.iter().map(|e| (*e, true))).collect()
    }

    /// The fixed points; their size is the mean length of the fixed edges there.
    fn points(&self, patch: &Patch, chart: &Chart, sizes: &Sizes) -> Vec<Point> {
        let mut sums = vec![(0.0, 0.0); self.corners.len()];
        let at = |i: u32| patch.points[self.corners[i as usize] as usize];
        for [a, b] in self.boundary.iter().chain(&self.inner) {
            let length = at(*a).distance(at(*b));
            for i in [a, b] {
                sums[*i as usize].0 += length;
                sums[*i as usize].1 += 1.0;
            }
        }
        (self.corners.iter().zip(sums))
            .map(|(&c, (sum, count))| Point {
                place: chart.places[c as usize],
                size: if count > 0.0 {
                    sum / count
                } else {
                    sizes.corner(c)
                },
            })
            .collect()
    }
}

/// A chart that overlaps itself without crossing edges covers less area than its triangles have.
fn check_area(
    patch: &Patch,
    chart: &Chart,
    points: &[Point],
    triangles: &[[u32; 3]],
) -> Result<(), MeshError> {
    let doubled = |[a, b, c]: [glam::DVec2; 3]| (b - a).perp_dot(c - a);
    let all = |sum: f64| sum / 2.0;
    let old = all((patch.triangles.iter())
        .map(|t| doubled(t.map(|c| chart.places[c as usize])))
        .sum());
    let new = all((triangles.iter())
        .map(|t| doubled(t.map(|c| points[c as usize].place)))
        .sum());
    // Both sum the same region exactly; rounding grows with the count only.
    if (old - new).abs() > 1e-9 * old {
        return Err(MeshError::Overlap {
            chart: old,
            meshed: new,
        });
    }
    Ok(())
}

/// No new triangle may look the other way than the old surface under it.
fn check_turns(
    surface: &Surface,
    points: &[Point],
    positions: &[DVec3],
    triangles: &[[u32; 3]],
) -> Result<(), MeshError> {
    for (i, t) in triangles.iter().enumerate() {
        let [a, b, c] = t.map(|k| positions[k as usize]);
        let normal = (b - a).cross(c - a);
        let [u, v, w] = t.map(|k| points[k as usize].place);
        let old = surface
            .locate((u + v + w) / 3.0)
            .map(|s| surface.normal(&s));
        let forward = old.is_none_or(|n| n.dot(normal) > 0.0);
        if !(forward && normal.is_finite() && normal.length() > 0.0) {
            return Err(MeshError::Inverted(i as u32));
        }
    }
    Ok(())
}

/// V - E + F of triangles with named corners.
fn euler(triangles: impl Iterator<Item = [u64; 3]>) -> i64 {
    let (mut corners, mut edges, mut faces) = (Vec::new(), Vec::new(), 0);
    for t in triangles {
        faces += 1;
        corners.extend(t);
        edges.extend((0..3).map(|k| {
            let (a, b) = (t[k], t[(k + 1) % 3]);
            (a.min(b), a.max(b))
        }));
    }
    corners.sort_unstable();
    corners.dedup();
    edges.sort_unstable();
    edges.dedup();
    corners.len() as i64 - edges.len() as i64 + faces
}

#[cfg(test)]
mod tests;
