//! A bounding volume hierarchy over triangles: nearest points, rays, inside or outside.
//!
//! Guarantees: every answer is that of a search through all triangles with f64 arithmetic (the hierarchy's f32 boxes are grown until
//! they hold their triangles, so that they can only cost time), ties go to the lowest index, and nothing depends on the
//! shape of the hierarchy or on the number of threads. Triangles with a coordinate that is not finite are never found.
//!
//! This is the only module that names `obvhs`: it builds the hierarchy (PLOC, Meister and Bittner, "Parallel locally-ordered clustering for
//! bounding volume hierarchy construction", 2018, doi:10.1109/TVCG.2017.2669983); the nodes of four boxes made of it (`wide`), and the walk through
//! them, are ours.

mod wide;

use crate::geom::triangle::{Ray, RayHit, nearest_on_triangle};
use glam::{DVec3, Vec3A};
use obvhs::aabb::Aabb;
use obvhs::bvh2::Bvh2;
use obvhs::bvh2::reinsertion::ReinsertionOptimizer;
use obvhs::ploc::{PlocBuilder, PlocSearchDistance, SortPrecision};
use smallvec::SmallVec;
use wide::{Beam, Child, Entry, Probe, WIDTH, Wide};

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

/// The smaller of two numbers that are none of them NaN: one instruction, where `f64::min` takes four.
#[inline]
fn smaller(a: f64, b: f64) -> f64 {
    if a < b { a } else { b }
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

/// A triangle's place in its hierarchy, which only that hierarchy understands; any other number does no harm.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Hint(u32);

impl Hint {
    /// As a number, to be kept where only numbers can be.
    #[inline]
    pub fn number(self) -> u32 {
        self.0
    }

    /// What the number stood for.
    #[inline]
    pub fn numbered(number: u32) -> Self {
        Self(number)
    }
}

/// Entries that wait while a walk goes down: three a level.
type Stack = SmallVec<[Entry; 64]>;

/// A bounding volume hierarchy over triangles.
#[derive(Clone, Debug, Default)]
pub struct TriangleBvh {
    nodes: Vec<Wide>,
    /// What the walk begins with.
    root: Option<Child>,
    /// #T triangles in the order of the leaves.
    triangles: Vec<[DVec3; 3]>,
    /// #T places in the caller's slice.
    indices: Vec<u32>,
    centre: DVec3,
    /// Boxes are in units of the reciprocal: a power of two that makes the largest coordinate at most one.
    scale: f64,
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
        let reach = (high - centre).abs().max((low - centre).abs());
        let scale = power_of_two_below((reach.max_element() + pad).recip());
        let boxes: Vec<Aabb> = finite
            .iter()
            .map(|&i| {
                let [a, b, c] = triangles[i as usize].map(|p| p - centre);
                let low = (a.min(b).min(c) - pad) * scale;
                let high = (a.max(b).max(c) + pad) * scale;
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
        let (nodes, root, order) = widened(&bvh);
        let indices: Vec<u32> = order.iter().map(|&i| finite[i as usize]).collect();
        Self {
            nodes,
            root,
            triangles: indices.iter().map(|&i| triangles[i as usize]).collect(),
            indices,
            centre,
            scale,
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

    #[inline]
    fn probe(&self, p: DVec3) -> Probe {
        Probe::new((p - self.centre) * self.scale)
    }

    /// A squared distance in the units of the boxes.
    #[inline]
    fn limit(&self, squared: f64) -> f32 {
        wide::limit(squared * self.scale * self.scale)
    }

    /// The distance of some triangle that is at most `radius` away, not always the nearest: faster than a search for that.
    pub fn any_within(&self, p: DVec3, radius: f64) -> Option<f64> {
        let q = self.probe(p);
        let limit = radius * radius;
        let bound = self.limit(limit);
        let mut stack = Stack::new();
        let mut next = self.root.map(wide::first);
        while let Some(entry) = next {
            match wide::parts(entry).1.open() {
                Ok(node) => {
                    let (near, count) = self.nodes[node].near(&q, bound);
                    stack.extend(near[..count].iter().rev().copied());
                }
                Err(k) => {
                    let d2 = nearest_on_triangle(self.triangles[k], p).distance_squared(p);
                    if d2 <= limit {
                        return Some(d2.sqrt());
                    }
                }
            }
            next = stack.pop();
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
        let root = self.root?;
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
        let mut bound = self.limit(limit);
        let mut stack = Stack::new();
        let mut next = Some(wide::first(root));
        while let Some(entry) = next {
            let (near, child) = wide::parts(entry);
            next = None;
            if near <= bound {
                match child.open() {
                    Ok(node) => {
                        let (near, count) = self.nodes[node].near(&q, bound);
                        if count > 0 {
                            next = Some(near[0]);
                            stack.extend(near[1..count].iter().rev().copied());
                        }
                    }
                    Err(k) => {
                        let index = self.indices[k];
                        if hint != Some(Hint(k as u32)) && wanted(index as usize) {
                            let point = nearest_on_triangle(self.triangles[k], p);
                            let e2 = point.distance_squared(p);
                            let better = match best {
                                None => e2 <= limit,
                                Some((b2, b, _)) => e2 < b2 || (e2 == b2 && index < b),
                            };
                            if better {
                                best = Some((e2, index, point));
                                limit = e2;
                                bound = self.limit(limit);
                                slot = k as u32;
                            }
                        }
                    }
                }
            }
            if next.is_none() {
                next = stack.pop();
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
            // Outward the way is shorter.
            let direction = direction * (p - self.centre).dot(direction).signum();
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
        let Some(root) = self.root else {
            return;
        };
        if !origin.is_finite() || direction == DVec3::ZERO {
            return;
        }
        let ray = Ray::new(origin, direction);
        let beam = Beam::new((origin - self.centre) * self.scale, direction * self.scale);
        let mut bounds = bounds;
        let mut limits = beam.bounds(bounds);
        let mut stack = Stack::new();
        let mut next = Some(wide::first(root));
        while let Some(entry) = next {
            let (near, child) = wide::parts(entry);
            if near <= limits[1].max(-limits[0]) {
                match child.open() {
                    Ok(node) => {
                        let (ahead, count) = self.nodes[node].ahead(&beam, limits);
                        stack.extend(ahead[..count].iter().rev().copied());
                    }
                    Err(k) => {
                        if let Some(hit) = ray.meets(self.triangles[k])
                            && hit.t >= bounds[0]
                            && hit.t <= bounds[1]
                        {
                            bounds = visit(self.indices[k] as usize, hit);
                            limits = beam.bounds(bounds);
                        }
                    }
                }
            }
            next = stack.pop();
        }
    }
}

/// The hierarchy with four children a node: its nodes, its root, and its triangles in the order of the leaves.
fn widened(bvh: &Bvh2) -> (Vec<Wide>, Option<Child>, Vec<u32>) {
    let (mut nodes, mut order) = (Vec::new(), Vec::new());
    let node = |at: u32| &bvh.nodes[at as usize];
    let is_leaf = |at: u32| node(at).prim_count > 0;
    let area = |at: u32| node(at).aabb().half_area();
    // Nodes to be made, and the places kept for them.
    let mut waiting = Vec::new();
    let mut child = |at: u32, nodes: &mut Vec<Wide>, waiting: &mut Vec<(u32, usize)>| {
        if is_leaf(at) {
            order.push(bvh.primitive_indices[node(at).first_index as usize]);
            return Child::leaf(order.len() - 1);
        }
        nodes.push(Wide::default());
        waiting.push((at, nodes.len() - 1));
        Child::node(nodes.len() - 1)
    };
    let root = (!bvh.nodes.is_empty()).then(|| child(0, &mut nodes, &mut waiting));
    while let Some((at, place)) = waiting.pop() {
        let mut inside: SmallVec<[u32; WIDTH]> = SmallVec::new();
        inside.extend([node(at).first_index, node(at).first_index + 1]);
        while inside.len() < WIDTH {
            // The largest box is opened: it would be entered most often.
            let largest = (0..inside.len())
                .filter(|&k| !is_leaf(inside[k]))
                .max_by(|&j, &k| area(inside[j]).total_cmp(&area(inside[k])));
            let Some(k) = largest else {
                break;
            };
            let first = node(inside[k]).first_index;
            inside[k] = first;
            inside.push(first + 1);
        }
        let boxes: SmallVec<[(Vec3A, Vec3A, Child); WIDTH]> = (inside.iter())
            .map(|&at| {
                let aabb = node(at).aabb();
                (aabb.min, aabb.max, child(at, &mut nodes, &mut waiting))
            })
            .collect();
        nodes[place] = Wide::new(&boxes);
    }
    (nodes, root, order)
}

/// The largest power of two up to a positive number.
fn power_of_two_below(x: f64) -> f64 {
    // Its bits without the mantissa.
    let power = f64::from_bits(x.to_bits() & !((1 << 52) - 1));
    if power > 0.0 && power.is_finite() {
        power
    } else {
        1.0
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
