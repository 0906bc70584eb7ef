//! Seeds: new points in rows from the boundary inwards.
//!
//! A front of equilateral triangles (Rebay 1993, doi:10.1006/jcph.1993.1097; Remacle et al. 2013, doi:10.1002/nme.4441): every
//! boundary edge proposes the apex of a triangle, every accepted point its six neighbours in the direction of its parent; first come,
//! first served, and none nearer to another than a share of the size. Lengths are measured in space, not in the chart.
//!
//! Or one of squares (packing of parallelograms, Baudouin et al. 2014, doi:10.1007/s00366-013-0332-4): every point proposes its four neighbours along a cross field, and
//! nearness is the greater of the two distances along the field's directions, each by the length wanted that way.

use super::directed::{Directed, Frame};
use super::surface::{Grid, Spot, Surface};
use glam::{DQuat, DVec2};
use std::cmp::Reverse;
use std::collections::BinaryHeap;
use std::f64::consts::FRAC_PI_3;

/// Least distance of a new point from the others, as a share of the size: half-way (in area) between one and two triangles in the gap
/// where fronts meet.
const APART: f64 = 0.72;

/// Most growth of size from one row to the next, either way: neighbouring edge lengths stay within the ratio that angles above 30
/// degrees allow.
pub(super) const GRADING: f64 = 1.4;

/// The same in a front of squares, by the greater of the distances along the field: half-way (in distance) between none and one point in the gap.
const APART_SQUARE: f64 = 0.72;

/// A point of the new mesh.
#[derive(Clone, Copy, Debug)]
pub(super) struct Point {
    /// Where it lies in the chart.
    pub place: DVec2,
    /// Wanted edge length there, mm.
    pub size: f64,
}

/// Points that have not proposed their neighbours yet: the lowest rank first, among equals first come, first served.
#[derive(Default)]
struct Queue {
    heap: BinaryHeap<Reverse<(i32, usize)>>,
    /// Points with the direction from their parent, in the order in which they came.
    come: Vec<(u32, DVec2)>,
}

impl Queue {
    fn push(&mut self, point: u32, direction: DVec2, rank: i32) {
        self.heap.push(Reverse((rank, self.come.len())));
        self.come.push((point, direction));
    }

    fn pop(&mut self) -> Option<(u32, DVec2)> {
        let Reverse((_, i)) = self.heap.pop()?;
        Some(self.come[i])
    }
}

/// Rank of a point by its size over the least of all, two to the doubling: bends come before the flats beside them, so that rows along them are whole.
fn rank(ratio: f64) -> i32 {
    // A hair up, so that rounding cannot put the least itself below.
    (2.0 * ratio.log2() + 1e-6).floor() as i32
}

/// The wanted edge lengths.
pub(super) struct Wanted<'a> {
    /// At a spot, mm.
    pub at: &'a dyn Fn(&Spot) -> f64,
    /// From one row to the next they differ by this factor at most.
    pub growth: f64,
}

/// New points for the inside. `fixed` are the points already there, `edges` the fixed edges (as positions in `fixed`), with a mark whether
/// both sides of the edge are inside; `size` tells the wanted edge length, mm, at a spot. With `squares` these are laid, along a cross field, else equilateral triangles.
/// `None` where they would be more than `most`.
pub(super) fn seeds(
    surface: &Surface,
    fixed: &[Point],
    edges: &[([u32; 2], bool)],
    size: &Wanted,
    squares: Option<&Directed>,
    most: usize,
) -> Option<Vec<Point>> {
    let places: Vec<DVec2> = fixed.iter().map(|p| p.place).collect();
    let typical = edges
        .iter()
        .map(|(e, _)| places[e[0] as usize].distance(places[e[1] as usize]))
        .sum::<f64>()
        / edges.len().max(1) as f64;
    let mut front = Front {
        surface,
        size,
        squares,
        points: fixed.to_vec(),
        grid: Grid::new(&places, typical, 1 << 16),
        edges,
        edge_grid: Grid::new(&places, typical, 1 << 16),
        longest: 0.0,
    };
    for (i, p) in places.iter().enumerate() {
        front.grid.add(i as u32, *p, *p);
    }
    for (i, (e, _)) in edges.iter().enumerate() {
        let (a, b) = (places[e[0] as usize], places[e[1] as usize]);
        let middle = (a + b) / 2.0;
        front.edge_grid.add(i as u32, middle, middle);
        front.longest = front.longest.max(a.distance(b));
    }
    let mut queue = Queue::default();
    if let Some(squares) = squares {
        for (i, p) in places.iter().enumerate() {
            if let Some(spot) = surface.locate(*p) {
                let [u, v] = squares.at(surface, &spot).lengths;
                queue.push(i as u32, DVec2::ZERO, rank(u.min(v) / squares.least()));
            }
        }
    } else {
        for (e, both) in edges {
            front.apex(e[0], e[1], &mut queue);
            if *both {
                front.apex(e[1], e[0], &mut queue);
            }
        }
    }
    while let Some((from, direction)) = queue.pop() {
        match squares {
            Some(squares) => front.beside(from, squares, &mut queue),
            None => front.around(from, direction, &mut queue),
        }
        if front.points.len() > fixed.len() + most {
            return None;
        }
    }
    Some(front.points.split_off(fixed.len()))
}

struct Front<'a> {
    surface: &'a Surface<'a>,
    size: &'a Wanted<'a>,
    squares: Option<&'a Directed<'a>>,
    points: Vec<Point>,
    grid: Grid,
    edges: &'a [([u32; 2], bool)],
    edge_grid: Grid,
    longest: f64,
}

impl Front<'_> {
    /// Proposes the apex of the triangle on the left of an edge.
    fn apex(&mut self, a: u32, b: u32, queue: &mut Queue) {
        let (p, q) = (self.points[a as usize].place, self.points[b as usize].place);
        // Snapped first: a half of the grid's width plus noise would round either way.
        let middle = self.surface.snap.place((p + q) / 2.0);
        // A little to the left, so that the triangle found is on this side.
        let inside = middle + 1e-3 * (q - p).perp();
        let Some(spot) = self.surface.locate(inside) else {
            return;
        };
        let along = self.surface.push(spot.triangle, q - p);
        let length = along.length();
        let wanted = self.size.graded(&spot, length);
        let height = (wanted * wanted - length * length / 4.0)
            .max(length * length / 4.0)
            .sqrt();
        let up = self.surface.flat_normal(spot.triangle).cross(along) / length;
        let step = self.surface.pull(spot.triangle, up * height);
        self.propose(middle + step, length, q - p, queue);
    }

    /// Proposes the six neighbours of a point.
    fn around(&mut self, from: u32, direction: DVec2, queue: &mut Queue) {
        let Point { place, size } = self.points[from as usize];
        let Some(spot) = self.surface.locate(place) else {
            return;
        };
        let normal = self.surface.flat_normal(spot.triangle);
        let along = self
            .surface
            .push(spot.triangle, direction)
            .normalize_or_zero();
        for k in 0..6 {
            let way = DQuat::from_axis_angle(normal, FRAC_PI_3 * k as f64) * along;
            let step = self.surface.pull(spot.triangle, way * size);
            self.propose(place + step, size, step, queue);
        }
    }

    /// Proposes the four neighbours of a point along the cross field.
    fn beside(&mut self, from: u32, squares: &Directed, queue: &mut Queue) {
        let place = self.points[from as usize].place;
        let Some(spot) = self.surface.locate(place) else {
            return;
        };
        let Frame { ways, lengths } = squares.at(self.surface, &spot);
        let steps = [0, 1].map(|i| (ways[i] * lengths[i], lengths[i]));
        for (way, size) in steps.into_iter().chain(steps.map(|(w, l)| (-w, l))) {
            let step = self.surface.pull(spot.triangle, way);
            self.propose(place + step, size, step, queue);
        }
    }

    /// Takes a point unless it lies outside or near to another point or edge.
    fn propose(&mut self, place: DVec2, parent: f64, direction: DVec2, queue: &mut Queue) {
        let place = self.surface.snap.place(place);
        let Some(spot) = self.surface.locate(place) else {
            return;
        };
        let shrink = self.surface.shortest(spot.triangle);
        let vector = |i: u32| {
            let step = self.points[i as usize].place - place;
            self.surface.push(spot.triangle, step)
        };
        let (size, crowded) = match self.squares {
            None => {
                let mut size = self.size.graded(&spot, parent);
                let reach = size / shrink;
                for i in self.grid.near(place, reach) {
                    // A step of one size changes it by the grading at most.
                    let most = self.points[i as usize].size
                        + (self.size.growth - 1.0) * vector(i).length();
                    size = size.min(most);
                }
                let size = self.surface.snap.value(size);
                let mut near = self.grid.near(place, APART * reach);
                (size, near.any(|i| vector(i).length() < APART * size))
            }
            Some(squares) => {
                let frame = squares.at(self.surface, &spot);
                // The corner of a square is further off than its sides.
                let [u, v] = frame.lengths;
                let corner = APART_SQUARE * u.hypot(v) / shrink;
                let close = |i: u32| frame.measure(vector(i)) < APART_SQUARE;
                (u.min(v), self.grid.near(place, corner).any(close))
            }
        };
        if crowded {
            return;
        }
        let sees_obtusely = |i: u32| {
            let (e, _) = self.edges[i as usize];
            let (a, b) = (vector(e[0]), vector(e[1]));
            a.dot(b) < -1e-9 * a.length() * b.length()
        };
        if self
            .edge_grid
            .near(place, 0.51 * self.longest)
            .any(sees_obtusely)
        {
            return;
        }
        let id = self.points.len() as u32;
        self.points.push(Point { place, size });
        self.grid.add(id, place, place);
        let rank = (self.squares).map_or(0, |squares| rank(size / squares.least()));
        queue.push(id, direction, rank);
    }
}

impl Wanted<'_> {
    /// The wanted size, not too far from the neighbouring one; that one where no size is told.
    fn graded(&self, spot: &Spot, near: f64) -> f64 {
        let wanted = (self.at)(spot);
        if wanted.is_finite() && wanted > 0.0 {
            wanted.clamp(near / self.growth, near * self.growth)
        } else {
            near
        }
    }
}
