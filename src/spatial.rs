//! A bounding volume hierarchy over triangles: nearest points, rays, inside or outside.
//!
//! Guarantees: every answer is that of a search through all triangles with f64 arithmetic (the hierarchy's f32 boxes are grown until
//! they hold their triangles, so that they can only cost time), ties go to the lowest index, and nothing depends on the
//! shape of the hierarchy or on the number of threads. Triangles with a coordinate that is not finite are never found.
//!
//! This is the only module that names `obvhs`: it builds the hierarchy (PLOC, Meister and Bittner, "Parallel locally-ordered clustering for
//! bounding volume hierarchy construction", 2018, doi:10.1109/TVCG.2017.2669983); the walk through it is ours, in f64.

use crate::geom::triangle::{Ray, RayHit, nearest_on_triangle};
use glam::{DVec3, Vec3A};
use obvhs::aabb::Aabb;
use obvhs::bvh2::leaf_collapser::collapse;
use obvhs::bvh2::reinsertion::ReinsertionOptimizer;
use obvhs::ploc::{PlocBuilder, PlocSearchDistance, SortPrecision};
use smallvec::SmallVec;

/// Few triangles a leaf: an exact test costs more than two boxes.
const LEAF_SIZE: u32 = 2;

/// Boxes are compared with this relative slack, which is far more than the rounding in a squared distance or a slab test.
const SLACK: f64 = 1.0 + 1e-12;

/// The bounds of a ray without an end.
const AHEAD: [f64; 2] = [0.0, f64::INFINITY];

/// A ray that comes nearer to a side of a triangle than this (as a corner weight) may be counted on both sides of it; another
/// ray is then asked whether a point is inside.
const GRAZING: f64 = 1e-9;

/// Directions without rational relation to the axes or to each other, so that no two of them graze the sides of a drawn part.
const PARITY_DIRECTIONS: [DVec3; 7] = [
    DVec3::new(0.5377, 0.2911, 0.7913),
    DVec3::new(-0.6173, 0.7019, 0.3559),
    DVec3::new(0.2213, -0.8837, 0.4127),
    DVec3::new(-0.3511, -0.4649, -0.8123),
    DVec3::new(0.8819, 0.1367, -0.4513),
    DVec3::new(-0.9127, 0.2741, -0.3023),
    DVec3::new(0.1049, 0.9371, -0.3329),
];

#[derive(Clone, Copy, Debug)]
struct Node {
    low: Vec3A,
    high: Vec3A,
    /// First triangle of a leaf, or first of two children.
    first: u32,
    /// Triangles of a leaf; zero for an inner node.
    count: u32,
}

impl Node {
    /// Squared distance from a point to the box, never more than it is; zero inside.
    #[inline]
    fn distance_squared(&self, p: Probe) -> f64 {
        let d = (self.low - p.at).max(p.at - self.high) - p.slack;
        // Squares of f32 would leave its range where lengths do not.
        let d = d.max(Vec3A::ZERO).as_dvec3();
        d.length_squared()
    }

    /// How near to its origin the line is inside the box and within the bounds, negative where its origin is; `None` where it is never.
    #[inline]
    fn span(&self, origin: DVec3, inverse: DVec3, [from, to]: [f64; 2]) -> Option<f64> {
        let (mut near, mut far) = (from, to);
        let (low, high) = (self.low.as_dvec3(), self.high.as_dvec3());
        for k in 0..3 {
            if inverse[k].is_finite() {
                let (t0, t1) = (
                    (low[k] - origin[k]) * inverse[k],
                    (high[k] - origin[k]) * inverse[k],
                );
                near = larger(near, smaller(t0, t1));
                far = smaller(far, larger(t0, t1));
            } else if origin[k] < low[k] || origin[k] > high[k] {
                return None;
            }
        }
        let slack = (SLACK - 1.0) * (near.abs() + far.abs());
        (near <= far + if slack.is_finite() { slack } else { 0.0 }).then_some(larger(near, -far))
    }
}

/// The larger of two numbers that are none of them NaN: one instruction, where `f64::max` takes four.
#[inline]
fn larger(a: f64, b: f64) -> f64 {
    if a > b { a } else { b }
}

/// The smaller of two numbers that are none of them NaN.
#[inline]
fn smaller(a: f64, b: f64) -> f64 {
    if a < b { a } else { b }
}

/// A point in f32, relative to the hierarchy's centre, and what may be lost in taking a box's distance from it.
#[derive(Clone, Copy, Debug)]
struct Probe {
    at: Vec3A,
    slack: Vec3A,
}

/// The nearest point of a set of triangles.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Nearest {
    /// Which triangle, by its place in the slice that the hierarchy was built from.
    pub index: usize,
    /// The point on it.
    pub point: DVec3,
    /// How far it is.
    pub distance: f64,
    /// Where the triangle is in the hierarchy, to begin the next search there.
    pub hint: Hint,
}

/// A triangle's place in its hierarchy, which only that hierarchy understands.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Hint(u32);

/// A bounding volume hierarchy over triangles.
#[derive(Clone, Debug, Default)]
pub struct TriangleBvh {
    nodes: Vec<Node>,
    /// #T triangles in the order of the leaves.
    triangles: Vec<[DVec3; 3]>,
    /// #T places in the caller's slice.
    indices: Vec<u32>,
    centre: DVec3,
    /// Largest coordinate of all boxes.
    reach: f32,
}

impl TriangleBvh {
    /// Builds the hierarchy. Any number of triangles, none too.
    pub fn new(triangles: &[[DVec3; 3]]) -> Self {
        let finite: Vec<u32> = (0..triangles.len() as u32)
            .filter(|&i| triangles[i as usize].iter().all(|p| p.is_finite()))
            .collect();
        let (mut low, mut high) = (DVec3::INFINITY, DVec3::NEG_INFINITY);
        for &i in &finite {
            for p in triangles[i as usize] {
                low = low.min(p);
                high = high.max(p);
            }
        }
        if finite.is_empty() {
            return Self::default();
        }
        let centre = (low + high) / 2.0;
        // What `p - centre` may lose, for points of the part's own size.
        let pad = 8.0 * f64::EPSILON * low.abs().max(high.abs()).max_element();
        let boxes: Vec<Aabb> = finite
            .iter()
            .map(|&i| {
                let [a, b, c] = triangles[i as usize].map(|p| p - centre);
                let (low, high) = (a.min(b).min(c) - pad, a.max(b).max(c) + pad);
                Aabb::new(
                    Vec3A::from_array(low.to_array().map(f32_below)),
                    Vec3A::from_array(high.to_array().map(f32_above)),
                )
            })
            .collect();
        let mut bvh = PlocBuilder::with_capacity(boxes.len()).build(
            PlocSearchDistance::Low,
            &boxes,
            (0..boxes.len() as u32).collect(),
            SortPrecision::U64,
            2,
        );
        ReinsertionOptimizer::default().run(&mut bvh, 0.02, None);
        collapse(&mut bvh, LEAF_SIZE, 1.0);
        let indices: Vec<u32> = bvh
            .primitive_indices
            .iter()
            .map(|&i| finite[i as usize])
            .collect();
        let nodes: Vec<Node> = bvh
            .nodes
            .iter()
            .map(|n| Node {
                low: n.aabb().min,
                high: n.aabb().max,
                first: n.first_index,
                count: n.prim_count,
            })
            .collect();
        let reach = nodes.first().map_or(0.0, |n| {
            n.low.abs().max_element().max(n.high.abs().max_element())
        });
        Self {
            nodes,
            reach,
            triangles: indices.iter().map(|&i| triangles[i as usize]).collect(),
            indices,
            centre,
        }
    }

    /// Whether there is no triangle to be found.
    pub fn is_empty(&self) -> bool {
        self.triangles.is_empty()
    }

    /// The nearest point of all triangles; `None` where there is none, or `p` is not finite.
    pub fn nearest(&self, p: DVec3) -> Option<Nearest> {
        self.nearest_where(p, f64::INFINITY, |_| true)
    }

    /// The nearest point that is at most `radius` away.
    pub fn nearest_within(&self, p: DVec3, radius: f64) -> Option<Nearest> {
        self.nearest_where(p, radius, |_| true)
    }

    /// The nearest point, at most `radius` away, of the triangles whose index passes `wanted`, which is asked before a distance is taken: it should
    /// cost less than that, and answer the same whenever it is asked.
    pub fn nearest_where(
        &self,
        p: DVec3,
        radius: f64,
        wanted: impl FnMut(usize) -> bool,
    ) -> Option<Nearest> {
        self.search(p, radius, None, wanted)
    }

    /// The nearest point of all triangles, found faster where the triangle of `hint` (an earlier answer's) is near. The answer does not
    /// depend on the hint.
    #[inline]
    pub fn nearest_from(&self, p: DVec3, hint: Option<Hint>) -> Option<Nearest> {
        self.search(p, f64::INFINITY, hint, |_| true)
    }

    fn probe(&self, p: DVec3) -> Probe {
        let at = (p - self.centre).as_vec3a();
        // Rounding of the point, and of a difference between it and a box: a unit in the last place (2^-24) each of some coordinate of theirs.
        let slack = 2.0 * f32::EPSILON * self.reach.max(at.abs().max_element());
        if slack.is_finite() {
            Probe {
                at,
                slack: Vec3A::splat(slack),
            }
        } else {
            Probe {
                at: Vec3A::ZERO,
                slack: Vec3A::INFINITY,
            }
        }
    }

    /// The distance of some triangle that is at most `radius` away, not always the nearest: faster than a search for that.
    pub fn any_within(&self, p: DVec3, radius: f64) -> Option<f64> {
        let q = self.probe(p);
        let limit = radius * radius;
        let root = self.nodes.first()?;
        let mut stack: SmallVec<[(f64, u32); 64]> = SmallVec::new();
        stack.push((root.distance_squared(q), 0));
        while let Some((_, at)) = stack.pop() {
            let node = &self.nodes[at as usize];
            for k in node.first..node.first + node.count {
                let d2 = nearest_on_triangle(self.triangles[k as usize], p).distance_squared(p);
                if d2 <= limit {
                    return Some(d2.sqrt());
                }
            }
            if node.count == 0 {
                let near = |i: u32| (self.nodes[i as usize].distance_squared(q), i);
                let (a, b) = (near(node.first), near(node.first + 1));
                let (near, far) = if a.0 <= b.0 { (a, b) } else { (b, a) };
                stack.extend([far, near].into_iter().filter(|c| c.0 <= limit * SLACK));
            }
        }
        None
    }

    #[inline]
    fn search(
        &self,
        p: DVec3,
        radius: f64,
        hint: Option<Hint>,
        mut wanted: impl FnMut(usize) -> bool,
    ) -> Option<Nearest> {
        let q = self.probe(p);
        let root = self.nodes.first()?;
        if !p.is_finite() || radius.is_nan() || radius < 0.0 {
            return None;
        }
        let mut best: Option<(f64, u32, DVec3)> = None;
        let mut limit = radius * radius;
        let mut slot = 0;
        if let Some(Hint(k)) = hint
            && let Some(triangle) = self.triangles.get(k as usize)
        {
            let point = nearest_on_triangle(*triangle, p);
            limit = point.distance_squared(p);
            best = Some((limit, self.indices[k as usize], point));
            slot = k;
        }
        let mut stack: SmallVec<[(f64, u32); 64]> = SmallVec::new();
        stack.push((root.distance_squared(q), 0));
        while let Some((d2, at)) = stack.pop() {
            if d2 > limit * SLACK {
                continue;
            }
            let node = &self.nodes[at as usize];
            if node.count == 0 {
                let near = |i: u32| (self.nodes[i as usize].distance_squared(q), i);
                let (a, b) = (near(node.first), near(node.first + 1));
                // The nearer child last, so that it is looked at first.
                let (near, far) = if a.0 <= b.0 { (a, b) } else { (b, a) };
                for child in [far, near] {
                    if child.0 <= limit * SLACK {
                        stack.push(child);
                    }
                }
                continue;
            }
            for k in node.first..node.first + node.count {
                if hint == Some(Hint(k)) {
                    continue;
                }
                let index = self.indices[k as usize];
                if !wanted(index as usize) {
                    continue;
                }
                let point = nearest_on_triangle(self.triangles[k as usize], p);
                let e2 = point.distance_squared(p);
                let better = match best {
                    None => e2 <= limit,
                    Some((b2, b, _)) => e2 < b2 || (e2 == b2 && index < b),
                };
                if better {
                    best = Some((e2, index, point));
                    limit = e2;
                    slot = k;
                }
            }
        }
        best.map(|(d2, index, point)| Nearest {
            index: index as usize,
            point,
            distance: d2.sqrt(),
            hint: Hint(slot),
        })
    }

    /// The first triangle that the ray meets, front or back, and how far along it is in units of the direction's length.
    pub fn first_hit(&self, origin: DVec3, direction: DVec3) -> Option<(usize, f64)> {
        self.first_hit_beyond(origin, direction, 0.0)
            .map(|(index, hit)| (index, hit.t))
    }

    /// The first triangle that the ray meets at `least` or further, in units of the direction's length.
    pub fn first_hit_beyond(
        &self,
        origin: DVec3,
        direction: DVec3,
        least: f64,
    ) -> Option<(usize, RayHit)> {
        self.first_hit_between(origin, direction, [least, f64::INFINITY])
    }

    /// The first triangle that the ray meets no nearer than the first and no further than the second of two bounds, in units of the direction's length.
    pub fn first_hit_between(
        &self,
        origin: DVec3,
        direction: DVec3,
        bounds: [f64; 2],
    ) -> Option<(usize, RayHit)> {
        let mut best: Option<(usize, RayHit)> = None;
        self.along(origin, direction, bounds, |index, hit| {
            let better = match &best {
                None => true,
                Some((b, old)) => hit.t < old.t || (hit.t == old.t && index < *b),
            };
            if better {
                best = Some((index, hit));
            }
            [bounds[0], best.map_or(f64::INFINITY, |(_, hit)| hit.t)]
        });
        best
    }

    /// All triangles that the ray meets, in order of distance (ties by index).
    pub fn all_hits(&self, origin: DVec3, direction: DVec3) -> Vec<(usize, RayHit)> {
        let mut hits = Vec::new();
        self.along(origin, direction, AHEAD, |index, hit| {
            hits.push((index, hit));
            AHEAD
        });
        hits.sort_unstable_by(|a, b| a.1.t.total_cmp(&b.1.t).then(a.0.cmp(&b.0)));
        hits
    }

    /// Whether the point lies inside the closed surface that the triangles make, by the parity of crossings of a ray. A ray that
    /// grazes a side is replaced by another; where all graze, most of them decide. Points on the surface go either way.
    pub fn inside(&self, p: DVec3) -> bool {
        let mut votes = 0;
        for direction in PARITY_DIRECTIONS {
            let (mut crossings, mut sure) = (0, true);
            self.along(p, direction, AHEAD, |_, hit| {
                crossings += 1;
                sure &= hit.weights.iter().all(|&w| w > GRAZING);
                AHEAD
            });
            let odd = crossings % 2 == 1;
            if sure {
                return odd;
            }
            votes += if odd { 1 } else { -1 };
        }
        votes > 0
    }

    /// How far it is to the first triangles that the ray and its opposite meet, in units of the direction's length; infinite where there is none up to `most`.
    pub fn first_distances(&self, origin: DVec3, direction: DVec3, most: f64) -> [f64; 2] {
        let (mut ahead, mut behind) = (f64::INFINITY, f64::INFINITY);
        // One walk for both: the hits that count are those between the nearest on either side.
        self.along(origin, direction, [-most, most], |_, hit| {
            if hit.t >= 0.0 {
                ahead = smaller(ahead, hit.t);
            }
            if hit.t <= 0.0 {
                behind = smaller(behind, -hit.t);
            }
            [-smaller(behind, most), smaller(ahead, most)]
        });
        [ahead, behind]
    }

    /// Gives all hits within the bounds to `visit`, which answers with bounds for the rest of the walk.
    fn along(
        &self,
        origin: DVec3,
        direction: DVec3,
        bounds: [f64; 2],
        mut visit: impl FnMut(usize, RayHit) -> [f64; 2],
    ) {
        if self.nodes.is_empty() || !origin.is_finite() || direction == DVec3::ZERO {
            return;
        }
        let ray = Ray::new(origin, direction);
        let (from, inverse) = (origin - self.centre, direction.recip());
        let mut bounds = bounds;
        let mut stack: SmallVec<[(f64, u32); 64]> = SmallVec::new();
        if let Some(t) = self.nodes[0].span(from, inverse, bounds) {
            stack.push((t, 0));
        }
        while let Some((t, at)) = stack.pop() {
            if t - (SLACK - 1.0) * t.abs() > larger(bounds[1], -bounds[0]) {
                continue;
            }
            let node = &self.nodes[at as usize];
            if node.count == 0 {
                let span = |i: u32| {
                    let t = self.nodes[i as usize].span(from, inverse, bounds);
                    t.map(|t| (t, i))
                };
                match (span(node.first), span(node.first + 1)) {
                    (Some(a), Some(b)) => stack.extend(if a.0 <= b.0 { [b, a] } else { [a, b] }),
                    (Some(a), None) | (None, Some(a)) => stack.push(a),
                    (None, None) => {}
                }
                continue;
            }
            for k in node.first..node.first + node.count {
                if let Some(hit) = ray.meets(self.triangles[k as usize])
                    && hit.t >= bounds[0]
                    && hit.t <= bounds[1]
                {
                    bounds = visit(self.indices[k as usize] as usize, hit);
                }
            }
        }
    }
}

/// A box's lower bound: an f32 that is below `x`.
fn f32_below(x: f64) -> f32 {
    (x as f32).next_down()
}

/// A box's upper bound: an f32 that is above `x`.
fn f32_above(x: f64) -> f32 {
    (x as f32).next_up()
}

#[cfg(test)]
mod tests;
