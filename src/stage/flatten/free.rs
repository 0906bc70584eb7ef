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

/// Most local-global steps.
const STEPS: usize = 20;

/// Energy a unit of doubled area at which a chart is isometric enough: lengths are off by some 2 % in the mean, which sizes are corrected for.
const ENOUGH: f64 = 1e-3;

/// Relative gain in energy below which a step is the last.
const GAIN: f64 = 1e-3;

/// Where triangles laid down from one side and from the other are turned against each other by more, in radians, turns say nothing of a chart: the patch is strongly curved both ways.
const GAP: f64 = 1.0;

/// A map of least change of lengths.
pub(super) fn isometric(patch: &Patch, shapes: &[Shape]) -> Result<Vec<DVec2>, SolveError> {
    let laid = unrolled(patch, shapes);
    if let Some(laid) = &laid
        && laid.fits
        && turned(patch, shapes, &laid.places).1 <= ENOUGH * size(shapes)
    {
        return Ok(laid.places.clone());
    }
    let laplacian = shape::laplacian(patch, shapes);
    let fit = Fit::new(patch, shapes, &laplacian)?;
    let start = match laid {
        Some(laid) if laid.gap <= GAP => fit.places(DVec2::ZERO, &laid.turns),
        _ => shape::scaled(patch, conformal(patch, &laplacian)?, patch.area()),
    };
    Ok(local_global(&fit, start))
}

/// Triangles laid down one beside the other, from the first one outwards.
struct Laid {
    places: Vec<DVec2>,
    /// How each triangle is turned, as the image of the x axis.
    turns: Vec<DVec2>,
    /// Whether they fit together well, as they do for a developable patch.
    fits: bool,
    /// Largest turn of a triangle against a neighbour, rad.
    gap: f64,
}

/// Lays triangles down; `None` where they do not hang together. Spares the twice as large system of the conformal map.
fn unrolled(patch: &Patch, shapes: &[Shape]) -> Option<Laid> {
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
    let (mut misfit, mut area, mut gap) = (0.0, 0.0, 0.0f64);
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
            if let Some((u, j)) = *next {
                let j = j as usize;
                let other = &shapes[u as usize].flat;
                let here = shape.flat[(k + 1) % 3] - shape.flat[k];
                // The neighbour runs along the common edge the other way.
                let there = other[j] - other[(j + 1) % 3];
                let own = DVec2::new(there.dot(here), there.perp_dot(here));
                let own = turn.rotate(own).normalize_or(DVec2::X);
                match turns[u as usize] {
                    Some(before) => gap = gap.max(before.angle_to(own).abs()),
                    None => {
                        turns[u as usize] = Some(own);
                        queue.push_back(u);
                    }
                }
            }
        }
    }
    let whole = places.iter().all(|p| p.is_finite());
    whole.then_some(Laid {
        places,
        turns: turns.into_iter().collect::<Option<_>>()?,
        fits: misfit <= MISFIT * area,
        gap,
    })
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

/// The places that fit given turns of the triangles best: the same matrix for all turns.
struct Fit<'a> {
    patch: &'a Patch,
    shapes: &'a [Shape],
    solver: SpdSolver,
}

impl<'a> Fit<'a> {
    fn new(
        patch: &'a Patch,
        shapes: &'a [Shape],
        laplacian: &[(u32, u32, f64)],
    ) -> Result<Self, SolveError> {
        // Corner 0 stays: the energy does not change when all move together.
        let inner: Vec<(u32, u32, f64)> = laplacian
            .iter()
            .filter(|e| e.0 > 0 && e.1 > 0)
            .map(|&(i, j, w)| (i - 1, j - 1, w))
            .collect();
        Ok(Self {
            solver: SpdSolver::factor(patch.nodes.len() - 1, &inner)?,
            patch,
            shapes,
        })
    }

    /// The places, the first of them given.
    fn places(&self, first: DVec2, turns: &[DVec2]) -> Vec<DVec2> {
        let mut right = vec![DVec2::ZERO; self.patch.nodes.len()];
        for ((c, s), turn) in triangles(self.patch, self.shapes).zip(turns) {
            for k in 0..3 {
                let (i, j) = ((k + 1) % 3, (k + 2) % 3);
                let wanted = turn.rotate(s.flat[j] - s.flat[i]);
                right[c[j] as usize] += s.cot[k] / 2.0 * wanted;
                right[c[i] as usize] -= s.cot[k] / 2.0 * wanted;
            }
        }
        let rest = self.solver.solve_pairs(&right[1..]);
        std::iter::once(first)
            .chain(rest.into_iter().map(|p| first + p))
            .collect()
    }
}

/// Triangles with the shapes of their corners.
fn triangles<'a>(
    patch: &'a Patch,
    shapes: &'a [Shape],
) -> impl Iterator<Item = (&'a [u32; 3], &'a Shape)> {
    patch.triangles.iter().zip(shapes)
}

/// Twice the area.
fn size(shapes: &[Shape]) -> f64 {
    shapes.iter().map(|s| s.flat[1].x * s.flat[2].y).sum()
}

/// The turns of the triangles that fit these places best, and the energy that is left.
fn turned(patch: &Patch, shapes: &[Shape], places: &[DVec2]) -> (Vec<DVec2>, f64) {
    let mut energy = 0.0;
    let turns = triangles(patch, shapes).map(|(c, s)| {
        let sides = [0, 1, 2].map(|k| {
            let (i, j) = ((k + 1) % 3, (k + 2) % 3);
            let now = places[c[j] as usize] - places[c[i] as usize];
            (s.cot[k], s.flat[j] - s.flat[i], now)
        });
        let (mut dot, mut cross) = (0.0, 0.0);
        for (cot, rest, now) in sides {
            dot += cot * rest.dot(now);
            cross += cot * rest.perp_dot(now);
        }
        let turn = DVec2::new(dot, cross).normalize_or(DVec2::X);
        for (cot, rest, now) in sides {
            energy += cot * (now - turn.rotate(rest)).length_squared();
        }
        turn
    });
    (turns.collect(), energy)
}

/// Alternates between the best turn of every triangle and the places that fit the turned triangles best.
fn local_global(fit: &Fit, mut places: Vec<DVec2>) -> Vec<DVec2> {
    let enough = ENOUGH * size(fit.shapes);
    let anchor = places[0];
    places.iter_mut().for_each(|p| *p -= anchor);
    let mut before = f64::INFINITY;
    for _ in 0..STEPS {
        let (turns, energy) = turned(fit.patch, fit.shapes, &places);
        if energy <= enough || before - energy < GAIN * before {
            break;
        }
        before = energy;
        places = fit.places(DVec2::ZERO, &turns);
    }
    places
}
