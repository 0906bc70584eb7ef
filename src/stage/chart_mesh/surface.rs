//! The old triangles as a surface over the chart: where a place in the chart lies in space, and how lengths change.

use crate::geom::snap::Snap;
use crate::model::patch::{Chart, Patch};
use glam::{DMat2, DVec2, DVec3};

/// A place in the chart, by the old triangle that holds it.
#[derive(Clone, Copy, Debug)]
pub(super) struct Spot {
    pub triangle: u32,
    pub weights: [f64; 3],
}

/// A place with all weights above this lies so far inside a triangle that it lies in no other: far above the rounding of weights in slivers.
const INSIDE: f64 = 0.01;

/// Derivatives of the position by the chart's two coordinates in one old triangle.
#[derive(Clone, Copy, Debug)]
struct Slope {
    x: DVec3,
    y: DVec3,
}

/// A grid over the chart for point location, with the slopes of every old triangle.
pub(super) struct Surface<'a> {
    pub patch: &'a Patch,
    /// #T places of the corners.
    corners: Vec<[DVec2; 3]>,
    slopes: Vec<Slope>,
    /// #C normals, not of unit length.
    pub normals: Vec<DVec3>,
    grid: Grid,
    /// The grid that all places in the chart lie on.
    pub snap: Snap,
}

/// Items in the cells of a regular grid over a box in the plane.
pub(super) struct Grid {
    low: DVec2,
    cell: f64,
    columns: usize,
    rows: usize,
    items: Vec<Vec<u32>>,
}

impl Grid {
    /// A grid of cells of about `cell`, coarser where there would be more than four cells for each of `count` items.
    pub(super) fn new(places: &[DVec2], cell: f64, count: usize) -> Self {
        let low = places
            .iter()
            .copied()
            .reduce(DVec2::min)
            .unwrap_or_default();
        let high = places
            .iter()
            .copied()
            .reduce(DVec2::max)
            .unwrap_or_default();
        let extent = high - low;
        let most = 4.0 * count.max(16) as f64;
        let longest = extent.max_element().max(f64::MIN_POSITIVE);
        let cell = cell
            .max((extent.x * extent.y / most).sqrt())
            .max(longest / most);
        let cell = if cell.is_finite() { cell } else { longest };
        let columns = (extent.x / cell) as usize + 1;
        let rows = (extent.y / cell) as usize + 1;
        Self {
            low,
            cell,
            columns,
            rows,
            items: vec![Vec::new(); columns * rows],
        }
    }

    fn range(&self, low: DVec2, high: DVec2) -> [usize; 4] {
        let at = |x: f64, most: usize| ((x / self.cell).max(0.0) as usize).min(most - 1);
        let (a, b) = (low - self.low, high - self.low);
        [
            at(a.x, self.columns),
            at(b.x, self.columns),
            at(a.y, self.rows),
            at(b.y, self.rows),
        ]
    }

    /// Adds an item to every cell that the box touches.
    pub(super) fn add(&mut self, item: u32, low: DVec2, high: DVec2) {
        let [x0, x1, y0, y1] = self.range(low, high);
        for y in y0..=y1 {
            for x in x0..=x1 {
                self.items[y * self.columns + x].push(item);
            }
        }
    }

    /// Items in cells within `radius` of a place (an item in several cells comes several times).
    pub(super) fn near(&self, place: DVec2, radius: f64) -> impl Iterator<Item = u32> + '_ {
        let reach = DVec2::splat(radius);
        let [x0, x1, y0, y1] = self.range(place - reach, place + reach);
        (y0..=y1).flat_map(move |y| {
            self.items[y * self.columns + x0..=y * self.columns + x1]
                .iter()
                .flatten()
                .copied()
        })
    }
}

impl<'a> Surface<'a> {
    /// The surface of a chart without folds.
    pub(super) fn new(patch: &'a Patch, chart: &'a Chart) -> Self {
        let count = patch.triangles.len();
        let mut grid = Grid::new(&chart.places, 0.0, count);
        let mut slopes = Vec::with_capacity(count);
        let mut corners = Vec::with_capacity(count);
        let mut normals = vec![DVec3::ZERO; patch.nodes.len()];
        for (i, t) in patch.triangles.iter().enumerate() {
            let [a, b, c] = t.map(|k| chart.places[k as usize]);
            grid.add(i as u32, a.min(b).min(c), a.max(b).max(c));
            corners.push([a, b, c]);
            let back = DMat2::from_cols(b - a, c - a).inverse();
            let p = patch.triangle_points(i);
            let (u, v) = (p[1] - p[0], p[2] - p[0]);
            slopes.push(Slope {
                x: u * back.x_axis.x + v * back.x_axis.y,
                y: u * back.y_axis.x + v * back.y_axis.y,
            });
            for k in t {
                normals[*k as usize] += u.cross(v);
            }
        }
        Self {
            patch,
            corners,
            slopes,
            normals,
            grid,
            snap: Snap::for_size(patch.area().sqrt()),
        }
    }

    /// The old triangle at a place, `None` outside the chart.
    pub(super) fn locate(&self, place: DVec2) -> Option<Spot> {
        let mut best: Option<(f64, Spot)> = None;
        for triangle in self.grid.near(place, 0.0) {
            let [a, b, c] = self.corners[triangle as usize];
            let all = (b - a).perp_dot(c - a);
            let weights = [
                (b - place).perp_dot(c - place) / all,
                (c - place).perp_dot(a - place) / all,
                (a - place).perp_dot(b - place) / all,
            ];
            let least = weights[0].min(weights[1]).min(weights[2]);
            if least > INSIDE {
                return Some(Spot { triangle, weights });
            }
            if best.is_none_or(|(l, _)| least > l) {
                best = Some((least, Spot { triangle, weights }));
            }
        }
        // Rounding must not open a gap between neighbours.
        best.filter(|(least, _)| *least >= -1e-9).map(|(_, s)| s)
    }

    /// Position in space, mm.
    pub(super) fn lift(&self, spot: &Spot) -> DVec3 {
        let p = self.patch.triangle_points(spot.triangle as usize);
        p[0] * spot.weights[0] + p[1] * spot.weights[1] + p[2] * spot.weights[2]
    }

    /// Normal of the old surface (not of unit length), smooth over its corners.
    pub(super) fn normal(&self, spot: &Spot) -> DVec3 {
        let [a, b, c] =
            self.patch.triangles[spot.triangle as usize].map(|k| self.normals[k as usize]);
        a * spot.weights[0] + b * spot.weights[1] + c * spot.weights[2]
    }

    /// The vector in space of a step in the chart.
    pub(super) fn push(&self, triangle: u32, step: DVec2) -> DVec3 {
        let s = &self.slopes[triangle as usize];
        s.x * step.x + s.y * step.y
    }

    /// The step in the chart whose vector in space is nearest to `vector`.
    pub(super) fn pull(&self, triangle: u32, vector: DVec3) -> DVec2 {
        let s = &self.slopes[triangle as usize];
        let metric = DMat2::from_cols(
            DVec2::new(s.x.dot(s.x), s.x.dot(s.y)),
            DVec2::new(s.x.dot(s.y), s.y.dot(s.y)),
        );
        metric.inverse() * DVec2::new(s.x.dot(vector), s.y.dot(vector))
    }

    /// Unit normal of an old triangle.
    pub(super) fn flat_normal(&self, triangle: u32) -> DVec3 {
        let s = &self.slopes[triangle as usize];
        s.x.cross(s.y).normalize_or(DVec3::Z)
    }

    /// Area in space of a unit area in the chart.
    pub(super) fn growth(&self, triangle: u32) -> f64 {
        let s = &self.slopes[triangle as usize];
        s.x.cross(s.y).length()
    }

    /// Least length in space of a unit length in the chart.
    pub(super) fn shortest(&self, triangle: u32) -> f64 {
        let s = &self.slopes[triangle as usize];
        let (xx, xy, yy) = (s.x.dot(s.x), s.x.dot(s.y), s.y.dot(s.y));
        let least = (xx + yy) / 2.0 - ((xx - yy) / 2.0).hypot(xy);
        least.max(0.0).sqrt()
    }
}
