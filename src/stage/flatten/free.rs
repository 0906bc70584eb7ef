//! Maps with a free boundary: conformal first, then as isometric as can be.

use super::harmonic::solve_given;
use super::shape::{self, Shape};
use crate::geom::snap::Snap;
use crate::model::patch::Patch;
use crate::solve::{SolveError, SpdSolver};
use glam::DVec2;
use std::collections::VecDeque;

/// Change of length by which an unrolled triangle may miss its place, and share of the area that may miss by more: local-global steps
/// take so much away within their number.
const MISFIT: f64 = 0.05;

/// Most local-global steps; the chart need not be the optimum, only without folds and nearly isometric.
const STEPS: usize = 20;

/// Relative gain in energy below which a step is the last.
const GAIN: f64 = 1e-3;

/// A map of least change of lengths.
pub(super) fn isometric(patch: &Patch, shapes: &[Shape]) -> Result<Vec<DVec2>, SolveError> {
    let laplacian = shape::laplacian(patch, shapes);
    let start = match unrolled(patch, shapes) {
        Some(places) => places,
        None => conformal(patch, &laplacian)?,
    };
    let start = shape::scaled(patch, start, patch.area());
    local_global(patch, shapes, &laplacian, start)
}

/// Triangles laid down one beside the other, from the first one outwards; `None` unless they fit together well, as they do for a
/// developable patch. Spares the twice as large system of the conformal map.
fn unrolled(patch: &Patch, shapes: &[Shape]) -> Option<Vec<DVec2>> {
    let mut sides: Vec<([u32; 2], u32, u8)> = Vec::with_capacity(3 * shapes.len());
    for (t, c) in patch.triangles.iter().enumerate() {
        for k in 0..3 {
            let (a, b) = (c[k], c[(k + 1) % 3]);
            sides.push(([a.min(b), a.max(b)], t as u32, k as u8));
        }
    }
    sides.sort_unstable();
    let mut across = vec![[None; 3]; shapes.len()];
    for pair in sides.windows(2) {
        let ((e, t, k), (f, u, j)) = (pair[0], pair[1]);
        if e == f {
            across[t as usize][k as usize] = Some((u, j));
            across[u as usize][j as usize] = Some((t, k));
        }
    }
    let mut places = vec![DVec2::NAN; patch.nodes.len()];
    // Turns are handed on from triangle to triangle: got from the places instead, errors would grow geometrically.
    let mut turns: Vec<Option<DVec2>> = vec![None; shapes.len()];
    let mut queue = VecDeque::from([0u32]);
    turns[0] = Some(DVec2::X);
    places[patch.triangles.first()?[0] as usize] = DVec2::ZERO;
    let (mut misfit, mut area) = (0.0, 0.0);
    while let Some(t) = queue.pop_front() {
        let (corners, shape) = (patch.triangles[t as usize], &shapes[t as usize]);
        let turn = turns[t as usize]?;
        let known = (0..3).find(|&k| places[corners[k] as usize].is_finite())?;
        let mut fits = true;
        for k in 0..3 {
            let wanted =
                places[corners[known] as usize] + turn.rotate(shape.flat[k] - shape.flat[known]);
            let place = &mut places[corners[k] as usize];
            if place.is_nan() {
                *place = wanted;
            }
            fits &= place.distance(wanted) <= MISFIT * shape.flat[1].x.max(shape.flat[2].length());
        }
        let own = shape.flat[1].perp_dot(shape.flat[2]);
        area += own;
        misfit += if fits { 0.0 } else { own };
        for (k, next) in across[t as usize].iter().enumerate() {
            if let Some((u, j)) = *next
                && turns[u as usize].is_none()
            {
                let j = j as usize;
                let other = &shapes[u as usize].flat;
                let here = shape.flat[(k + 1) % 3] - shape.flat[k];
                // The neighbour runs along the common edge the other way.
                let there = other[j] - other[(j + 1) % 3];
                let own = DVec2::new(there.dot(here), there.perp_dot(here));
                turns[u as usize] = Some(turn.rotate(own).normalize_or(DVec2::X));
                queue.push_back(u);
            }
        }
    }
    (misfit <= MISFIT * area && places.iter().all(|p| p.is_finite())).then_some(places)
}

/// Least squares conformal map: Dirichlet energy less area, two corners given, distance between them kept.
fn conformal(patch: &Patch, laplacian: &[(u32, u32, f64)]) -> Result<Vec<DVec2>, SolveError> {
    let n = patch.nodes.len() as u32;
    let mut entries = Vec::with_capacity(2 * laplacian.len());
    for &(i, j, w) in laplacian {
        entries.extend([(i, j, w), (n + i, n + j, w)]);
    }
    // The area of the image is half the sum of (x_i y_j - x_j y_i) over the boundary edges.
    for [i, j] in patch.boundary() {
        entries.extend([(i, n + j, -0.5), (n + j, i, -0.5)]);
        entries.extend([(j, n + i, 0.5), (n + i, j, 0.5)]);
    }
    let (a, b) = far_corners(patch);
    let length = patch.points[a as usize].distance(patch.points[b as usize]);
    let given = [
        (a, DVec2::ZERO),
        (b, DVec2::new(length, 0.0)),
        (n + a, DVec2::ZERO),
        (n + b, DVec2::ZERO),
    ];
    let both = solve_given(2 * n as usize, &entries, &given)?;
    let (x, y) = both.split_at(n as usize);
    Ok(x.iter().zip(y).map(|(x, y)| DVec2::new(x.x, y.x)).collect())
}

/// Two boundary corners far apart.
fn far_corners(patch: &Patch) -> (u32, u32) {
    let outer = patch.loops.first().map_or(&[][..], |l| l);
    let snap = Snap::for_size(patch.area().sqrt());
    let farthest = |from: u32| {
        let p = patch.points[from as usize];
        let by = |c: &&u32| snap.value(patch.points[**c as usize].distance(p));
        outer
            .iter()
            .max_by(|a, b| by(a).total_cmp(&by(b)))
            .copied()
            .unwrap_or(from)
    };
    let a = farthest(outer.first().copied().unwrap_or_default());
    (a, farthest(a))
}

/// Alternates between the best turn of every triangle and the places that fit the turned triangles best.
fn local_global(
    patch: &Patch,
    shapes: &[Shape],
    laplacian: &[(u32, u32, f64)],
    mut places: Vec<DVec2>,
) -> Result<Vec<DVec2>, SolveError> {
    // Corner 0 stays at the origin: the energy does not change when all move together.
    let inner: Vec<(u32, u32, f64)> = laplacian
        .iter()
        .filter(|e| e.0 > 0 && e.1 > 0)
        .map(|&(i, j, w)| (i - 1, j - 1, w))
        .collect();
    let solver = SpdSolver::factor(places.len() - 1, &inner)?;
    let anchor = places[0];
    places.iter_mut().for_each(|p| *p -= anchor);
    let size: f64 = shapes.iter().map(|s| s.flat[1].x * s.flat[2].y).sum();
    let mut before = f64::INFINITY;
    for _ in 0..STEPS {
        let mut right = vec![DVec2::ZERO; places.len()];
        let mut energy = 0.0;
        for (c, s) in patch.triangles.iter().zip(shapes) {
            let (mut dot, mut cross) = (0.0, 0.0);
            for k in 0..3 {
                let (i, j) = ((k + 1) % 3, (k + 2) % 3);
                let rest = s.flat[j] - s.flat[i];
                let now = places[c[j] as usize] - places[c[i] as usize];
                dot += s.cot[k] * rest.dot(now);
                cross += s.cot[k] * rest.perp_dot(now);
            }
            let turn = DVec2::new(dot, cross).normalize_or(DVec2::X);
            for k in 0..3 {
                let (i, j) = ((k + 1) % 3, (k + 2) % 3);
                let wanted = turn.rotate(s.flat[j] - s.flat[i]);
                let now = places[c[j] as usize] - places[c[i] as usize];
                energy += s.cot[k] * (now - wanted).length_squared();
                right[c[j] as usize] += s.cot[k] / 2.0 * wanted;
                right[c[i] as usize] -= s.cot[k] / 2.0 * wanted;
            }
        }
        // Lengths right to 1e-9 are right.
        if energy <= 1e-18 * size || before - energy < GAIN * before {
            break;
        }
        before = energy;
        let x = solver.solve(&right[1..].iter().map(|r| r.x).collect::<Vec<_>>());
        let y = solver.solve(&right[1..].iter().map(|r| r.y).collect::<Vec<_>>());
        for (place, (x, y)) in places[1..].iter_mut().zip(x.into_iter().zip(y)) {
            *place = DVec2::new(x, y);
        }
    }
    Ok(places)
}
