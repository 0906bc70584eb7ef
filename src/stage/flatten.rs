//! Charts: a patch is laid flat, so that it can be meshed in the plane.
//!
//! **In** a patch that a plane can hold (a disc, with holes or without). **Out** a chart without folds and with little distortion, or an
//! error: then cut the patch.
//!
//! Tried in this order:
//! 1. *plane*: projection to the mean plane, where that keeps the area;
//! 2. *free*: triangles unrolled one beside the other, or else the least squares conformal map (Levy et al. 2002, doi:10.1145/566654.566590), then local-global steps towards an isometry
//!    (Liu et al. 2008, doi:10.1111/j.1467-8659.2008.01290.x): a developable patch keeps all lengths;
//! 3. *disc*: discrete harmonic map (Pinkall & Polthier 1993, doi:10.1080/10586458.1993.10504266) of the longest loop to a circle, holes
//!    filled by one virtual node each; where an obtuse triangle folds it, the same with positive weights, which cannot fold
//!    (Tutte 1963, doi:10.1112/plms/s3-13.1.743; Floater 1997, doi:10.1016/S0167-8396(96)00031-3).
//!
//! **Guarantees.** [`Chart::check`] is empty: one to one near every point. **Limits.** Far parts of a free chart may overlap; whoever
//! triangulates it sees that as crossing boundary edges. **Cost.** One or two sparse Cholesky factorisations of the size of the patch.

mod free;
mod harmonic;
mod shape;

pub use harmonic::harmonic;
pub use shape::{Stretch, stretch};

use crate::geom::snap::Snap;
use crate::model::patch::{Chart, ChartKind, Patch};
use crate::solve::SolveError;
use glam::{DVec2, DVec3};

/// Longest over shortest stretch of a triangle beyond which meshing in the plane no longer gives good triangles in space: a triangle with
/// three equal sides becomes one with edge ratio 2.
const ANISOTROPY: f64 = 2.0;

/// Growth of area, either way, beyond which sizes in the chart are not trusted.
const AREA_GROWTH: f64 = 4.0;

/// Share of the patch's area that may be distorted more: slivers of the old triangulation tell nothing about the surface.
const SLIVER_SHARE: f64 = 0.01;

/// Share of the area that a projection may lose: tilts up to about 8 degrees, lengths right to 1 %.
const PLANE_LOSS: f64 = 0.01;

/// Why a patch has no chart.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum FlattenError {
    /// It is closed or has a handle.
    #[error(
        "a patch of Euler characteristic {euler} with {loops} boundary loops does not fit in a plane"
    )]
    Topology {
        /// Euler characteristic.
        euler: i64,
        /// Boundary loops.
        loops: usize,
    },
    /// It has no area.
    #[error("a patch of {0} triangles has no area")]
    NoArea(usize),
    /// Every map folds.
    #[error("{folds} of {triangles} triangles fold in every chart")]
    Folds {
        /// Folded triangles in the last chart.
        folds: usize,
        /// All triangles.
        triangles: usize,
    },
    /// Maps without folds are too distorted.
    #[error("a share of {share} of the area is too distorted")]
    Distorted {
        /// Share of the area.
        share: f64,
    },
    /// The linear system failed.
    #[error(transparent)]
    Solve(#[from] SolveError),
}

/// A chart of the patch, or why it needs cutting.
///
/// # Errors
/// See [`FlattenError`].
pub fn flatten(patch: &Patch) -> Result<Chart, FlattenError> {
    if !patch.is_planar_graph() {
        return Err(FlattenError::Topology {
            euler: patch.euler(),
            loops: patch.loops.len(),
        });
    }
    let area = patch.area();
    if !(area > 0.0 && area.is_finite()) {
        return Err(FlattenError::NoArea(patch.triangles.len()));
    }
    let snap = Snap::for_size(area.sqrt());
    let snapped = |places: Vec<DVec2>| places.into_iter().map(|p| snap.place(p)).collect();
    if let Some(places) = plane(patch, area) {
        let chart = Chart {
            places: snapped(places),
            kind: ChartKind::Plane,
        };
        if chart.check(patch).is_empty() {
            return Ok(chart);
        }
    }
    let shapes = shape::shapes(patch);
    let mut failure = FlattenError::NoArea(patch.triangles.len());
    type Map = fn(&Patch, &[shape::Shape]) -> Result<Vec<DVec2>, SolveError>;
    let maps: [(ChartKind, Map); 3] = [
        (ChartKind::Free, free::isometric),
        (ChartKind::Disc, harmonic::cotangent_disc),
        (ChartKind::Disc, harmonic::positive_disc),
    ];
    for (kind, map) in maps {
        let places = match map(patch, &shapes) {
            Ok(places) => shape::scaled(patch, places, area),
            Err(e) => {
                failure = e.into();
                continue;
            }
        };
        let mut chart = Chart { places, kind };
        unfold(patch, &mut chart);
        chart.places = snapped(chart.places);
        let folds = chart.check(patch).len();
        if folds > 0 {
            let triangles = patch.triangles.len();
            failure = FlattenError::Folds { folds, triangles };
            continue;
        }
        let share = distorted_share(patch, &chart);
        if share <= SLIVER_SHARE {
            return Ok(chart);
        }
        failure = FlattenError::Distorted { share };
    }
    Err(failure)
}

/// Projection to the mean plane, if it keeps the area.
fn plane(patch: &Patch, area: f64) -> Option<Vec<DVec2>> {
    let sum: DVec3 = (0..patch.triangles.len())
        .map(|t| {
            let [a, b, c] = patch.triangle_points(t);
            (b - a).cross(c - a) / 2.0
        })
        .sum();
    if sum.length() < (1.0 - PLANE_LOSS) * area {
        return None;
    }
    // A frame of the patch's own, so that the chart does not depend on how the part lies in space.
    let normal = sum.normalize();
    let first = patch.boundary().next().unwrap_or_default();
    let [origin, end] = first.map(|c| patch.points[c as usize]);
    let x = (end - origin)
        .reject_from_normalized(normal)
        .try_normalize()?;
    // Right-handed about the normal, so that triangles stay counter-clockwise.
    let y = normal.cross(x);
    let flat = |p: &DVec3| DVec2::new((*p - origin).dot(x), (*p - origin).dot(y));
    Some(patch.points.iter().map(flat).collect())
}

/// Moves corners of folded triangles to the middle of their neighbours: slivers fold from rounding alone.
fn unfold(patch: &Patch, chart: &mut Chart) {
    let mut is_boundary = vec![false; patch.nodes.len()];
    patch
        .boundary()
        .for_each(|e| is_boundary[e[0] as usize] = true);
    // A fold that a few rounds do not open is one of the map, not of a sliver.
    for _ in 0..5 {
        let mut moving: Vec<u32> = chart
            .check(patch)
            .iter()
            .filter_map(|f| match f {
                crate::model::patch::ChartFault::Fold { triangle, .. } => Some(*triangle),
                _ => None,
            })
            .flat_map(|t| patch.triangles[t as usize])
            .filter(|&c| !is_boundary[c as usize])
            .collect();
        if moving.is_empty() {
            return;
        }
        moving.sort_unstable();
        moving.dedup();
        let mut sums = vec![(DVec2::ZERO, 0.0); moving.len()];
        for t in &patch.triangles {
            for k in 0..3 {
                if let Ok(i) = moving.binary_search(&t[k]) {
                    for other in [t[(k + 1) % 3], t[(k + 2) % 3]] {
                        sums[i].0 += chart.places[other as usize];
                        sums[i].1 += 1.0;
                    }
                }
            }
        }
        for (c, (sum, count)) in moving.iter().zip(sums) {
            chart.places[*c as usize] = sum / count;
        }
    }
}

/// Share of the patch's area where the chart is too distorted.
fn distorted_share(patch: &Patch, chart: &Chart) -> f64 {
    let (mut bad, mut all) = (0.0, 0.0);
    for t in 0..patch.triangles.len() {
        let [a, b, c] = patch.triangle_points(t);
        let area = (b - a).cross(c - a).length();
        let s = stretch(patch, chart, t);
        let growth = s.long * s.short;
        let good =
            s.long <= ANISOTROPY * s.short && (1.0 / AREA_GROWTH..=AREA_GROWTH).contains(&growth);
        all += area;
        bad += if good { 0.0 } else { area };
    }
    bad / all
}

#[cfg(test)]
mod tests;
