//! Harmonic maps: every corner is the weighted mean of its neighbours.

use super::shape::{self, Shape};
use crate::model::patch::Patch;
use crate::solve::{SolveError, SpdSolver};
use glam::DVec2;
use std::f64::consts::TAU;

/// The discrete harmonic map with cotangent weights and given places of some corners (at least one); a linear map of a flat patch is
/// reproduced where the corners given are its whole boundary.
///
/// # Errors
/// The system is singular: a part of the patch has no given corner.
pub fn harmonic(patch: &Patch, given: &[(u32, DVec2)]) -> Result<Vec<DVec2>, SolveError> {
    let entries = shape::laplacian(patch, &shape::shapes(patch));
    solve_given(patch.nodes.len(), &entries, given)
}

/// Solves for the unknowns that are not given, both coordinates with one factor.
pub(super) fn solve_given(
    size: usize,
    entries: &[(u32, u32, f64)],
    given: &[(u32, DVec2)],
) -> Result<Vec<DVec2>, SolveError> {
    let mut places = vec![DVec2::ZERO; size];
    let mut is_given = vec![false; size];
    for &(c, place) in given {
        places[c as usize] = place;
        is_given[c as usize] = true;
    }
    let mut row = vec![u32::MAX; size];
    let mut count = 0;
    for c in 0..size {
        if !is_given[c] {
            row[c] = count;
            count += 1;
        }
    }
    let mut inner = Vec::with_capacity(entries.len());
    let mut right = vec![DVec2::ZERO; count as usize];
    for &(i, j, w) in entries {
        match (is_given[i as usize], is_given[j as usize]) {
            (false, false) => inner.push((row[i as usize], row[j as usize], w)),
            (false, true) => right[row[i as usize] as usize] -= w * places[j as usize],
            _ => {}
        }
    }
    let solver = SpdSolver::factor(count as usize, &inner)?;
    let solved = solver.solve_pairs(&right);
    for c in 0..size {
        if !is_given[c] {
            places[c] = solved[row[c] as usize];
        }
    }
    Ok(places)
}

/// Harmonic map to a disc with cotangent weights.
pub(super) fn cotangent_disc(patch: &Patch, shapes: &[Shape]) -> Result<Vec<DVec2>, SolveError> {
    to_disc(patch, shape::laplacian(patch, shapes))
}

/// Harmonic map to a disc with positive weights: cotangents with a floor.
pub(super) fn positive_disc(patch: &Patch, shapes: &[Shape]) -> Result<Vec<DVec2>, SolveError> {
    let mut sides: Vec<([u32; 2], f64)> = Vec::with_capacity(3 * shapes.len());
    for (c, s) in patch.triangles.iter().zip(shapes) {
        for k in 0..3 {
            let (i, j) = (c[(k + 1) % 3], c[(k + 2) % 3]);
            sides.push(([i.min(j), i.max(j)], s.cot[k] / 2.0));
        }
    }
    sides.sort_by_key(|s| s.0);
    let mut entries = Vec::with_capacity(2 * sides.len());
    for run in sides.chunk_by(|a, b| a.0 == b.0) {
        let [i, j] = run[0].0;
        // The weight of an edge between two equilateral triangles is 0.58: a tenth to ten times that keeps the system well conditioned.
        let w = run.iter().map(|s| s.1).sum::<f64>().clamp(0.05, 5.0);
        entries.extend([(i, i, w), (j, j, w), (i, j, -w), (j, i, -w)]);
    }
    to_disc(patch, entries)
}

/// The longest loop goes to the unit circle by arc length, other loops are filled by a node each.
fn to_disc(patch: &Patch, mut entries: Vec<(u32, u32, f64)>) -> Result<Vec<DVec2>, SolveError> {
    let corners = patch.nodes.len();
    let mut size = corners;
    for hole in patch.loops.iter().skip(1) {
        let centre = size as u32;
        for &c in hole {
            entries.extend([(c, c, 1.0), (centre, centre, 1.0)]);
            entries.extend([(c, centre, -1.0), (centre, c, -1.0)]);
        }
        size += 1;
    }
    let outer = patch.loops.first().map_or(&[][..], |l| l);
    let point = |i: usize| patch.points[outer[i % outer.len()] as usize];
    let steps: Vec<f64> = (0..outer.len())
        .map(|i| point(i).distance(point(i + 1)))
        .collect();
    let total: f64 = steps.iter().sum();
    let mut along = 0.0;
    let mut given = Vec::with_capacity(outer.len());
    for (c, step) in outer.iter().zip(steps) {
        given.push((*c, DVec2::from_angle(TAU * along / total)));
        along += step;
    }
    let mut places = solve_given(size, &entries, &given)?;
    places.truncate(corners);
    Ok(places)
}
