//! The exact mid-surface of every wall, and the faces that rims lie on.
//!
//! A mid-point has equal distance to both sides of its wall. Distances are to the six-node facets of that wall's faces only, so that a
//! neighbour wall never interferes. Beyond the end of a side (under a rib, past a corner) the tangent plane at its last point goes on: with
//! that one rule a plate stays flat under its rib, sheets extend until they meet, and a rim comes to lie on its lateral face. At the inner edge of
//! a step the side does not end: there the distance is that to the edge, and the mid-surface climbs along a parabola.

mod corner;

mod memory;

use crate::geom::placer::Placer;
use crate::geom::planes;
use crate::geom::six_node::{self, ReadyFacet};
use crate::geom::triangle::nearest_on_triangle;
use crate::model::brep::Brep;
use crate::model::complex::Support;
use crate::model::ids::{FaceId, FacetId, IndexVec, VertexId, WallId};
use crate::model::walls::{Aag, Convexity, Pairing};
use crate::spatial::{Hint, TriangleBvh};
use corner::InnerEdges;
use glam::DVec3;
use memory::Memory;
use smallvec::SmallVec;

/// Steps of the placing iteration: it converges quadratically on smooth walls; the rest guards against cycling at edges.
const STEPS: usize = 16;
/// A placed point has moved less than this in its last step, in thicknesses: the next one would be of the order of its square.
const SETTLED: f64 = 1e-7;
/// No point moves further than this in all, in thicknesses: further away is another wall's business.
const LEASH: f64 = 3.0;
/// Nor further beyond the end of its surfaces than this, in thicknesses: sheets that are extended to meet do so within the block where
/// their walls join. One that lies further out may stay where it is.
const REACH: f64 = 1.5;
/// Tangent planes whose unit normals differ by less than this define no middle.
const LEAST_OPPOSITION: f64 = 0.5;

/// A point this near to its foot, in edge lengths, lies on the surface: which way the rest points is rounding.
const ON_SURFACE: f64 = 1e-9;
/// Nodes this near to a common plane, as a share of their largest coordinate, lie in it: CAD files know their own points no better than to 1e-7 mm.
const IN_PLANE: f64 = 1e-9;
/// A six-node facet leaves its flat triangle by at most this many times its sag: the three mid-side shape functions sum up to this.
const BULGE: f64 = 4.0 / 3.0;
/// A foot is plumb within this sine; far above rounding, far below what a wrong facet gives.
const PLUMB: f64 = 1e-6;

/// Where the last searches on one or two surfaces ended.
type Hints = [Option<Hint>; 2];

/// A plane, and which side of it is material: below the normal.
#[derive(Clone, Copy, Debug)]
struct Plane {
    normal: DVec3,
    offset: f64,
}

impl Plane {
    /// Distance of `p` below the plane.
    #[inline]
    fn depth(&self, p: DVec3) -> f64 {
        self.offset - self.normal.dot(p)
    }
}

/// What a placing knows of one of its supports from the steps before.
#[derive(Clone, Copy, Debug, Default)]
struct Known {
    hints: Hints,
    /// The point lies beyond the end by at most this, where that is known.
    beyond: Option<f64>,
}

/// A set of facets with its hierarchy.
#[derive(Clone, Debug, Default)]
struct Surface {
    bvh: TriangleBvh,
    facets: Vec<FacetId>,
    /// Sorted.
    faces: Vec<FaceId>,
    /// The plane of all its facets, if they have one: then its tangent planes need no search.
    plane: Option<Plane>,
    inner_edges: InnerEdges,
}

/// The nearest point of a surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Foot {
    /// Where it is.
    pub point: DVec3,
    /// Outward normal there.
    pub normal: DVec3,
    /// The facet it lies on.
    pub facet: FacetId,
}

impl Foot {
    /// Whether `p` lies straight below the foot: then no other facet near by can be nearer.
    fn is_plumb(&self, p: DVec3) -> bool {
        let d = p - self.point;
        (d - self.normal * d.dot(self.normal)).length_squared()
            <= PLUMB * PLUMB * d.length_squared()
    }

    /// Distance of `p` below the tangent plane, positive inside the material.
    #[inline]
    pub fn depth(&self, p: DVec3) -> f64 {
        (self.point - p).dot(self.normal)
    }

    /// The way from `p` to the foot, and its length.
    fn way(&self, p: DVec3) -> (DVec3, f64) {
        let way = self.point - p;
        (way.try_normalize().unwrap_or(self.normal), way.length())
    }

    /// How far beyond the end of the surface `p` lies, along the tangent plane; zero over its inside.
    #[inline]
    fn beyond(&self, p: DVec3) -> f64 {
        let d = p - self.point;
        (d - self.normal * d.dot(self.normal)).length()
    }
}

/// The mid-surfaces of a solid. Built once a pairing; queries are read-only and may run in parallel.
#[derive(Clone, Debug)]
pub struct Medial<'a> {
    brep: &'a Brep,
    sides: IndexVec<WallId, [Surface; 2]>,
    thickness: IndexVec<WallId, f64>,
    /// Rims may slide from a lateral face onto one that is tangent to it: such faces share one surface.
    rim_surface: IndexVec<FaceId, u32>,
    rims: Vec<Surface>,
    facets: IndexVec<FacetId, ReadyFacet>,
    /// The bent ones among the facets that touch each facet.
    bent: IndexVec<FacetId, Vec<FacetId>>,
    /// Normal curvature of each facet, 1/mm, estimated from its corner normals.
    curvature: IndexVec<FacetId, f64>,
    typical: f64,
    memory: Memory,
}

impl<'a> Medial<'a> {
    /// Builds the hierarchies of all walls and lateral faces.
    pub fn new(brep: &'a Brep, aag: &Aag, pairing: &Pairing) -> Self {
        let mut of_face: IndexVec<FaceId, Vec<FacetId>> =
            IndexVec::filled(Vec::new(), brep.faces.len());
        for (id, f) in brep.facets.enumerated() {
            of_face[f.face].push(id);
        }
        let surface = |faces: &mut dyn Iterator<Item = FaceId>| {
            let mut faces: Vec<FaceId> = faces.collect();
            faces.sort_unstable();
            let facets: Vec<FacetId> = faces
                .iter()
                .flat_map(|f| of_face[*f].iter().copied())
                .collect();
            let corners: Vec<[DVec3; 3]> = facets.iter().map(|&f| brep.corners(f)).collect();
            Surface {
                bvh: TriangleBvh::new(&corners),
                plane: common_plane(brep, &facets),
                facets,
                inner_edges: InnerEdges::new(brep, aag, &faces),
                faces,
            }
        };
        let sides = pairing
            .walls
            .iter()
            .map(|w| [0, 1].map(|s| surface(&mut w.sides[s].iter().copied())))
            .collect();
        let mut rim_surface: IndexVec<FaceId, u32> = IndexVec::filled(u32::MAX, brep.faces.len());
        let mut rims = Vec::new();
        for seed in brep.faces.ids() {
            if rim_surface[seed] != u32::MAX {
                continue;
            }
            let id = rims.len() as u32;
            rim_surface[seed] = id;
            let mut members = vec![seed];
            let mut at = 0;
            while pairing.side[seed].is_none() && at < members.len() {
                let f = members[at];
                at += 1;
                for arc in aag.arcs_of(f).filter(|a| a.convexity == Convexity::Smooth) {
                    let g = Aag::across(arc, f);
                    if rim_surface[g] == u32::MAX && pairing.side[g].is_none() {
                        rim_surface[g] = id;
                        members.push(g);
                    }
                }
            }
            rims.push(surface(&mut members.into_iter()));
        }
        let curvature = brep
            .facets
            .enumerated()
            .map(|(id, f)| {
                let p = brep.corners(id);
                let n = [(0.0, 0.0), (1.0, 0.0), (0.0, 1.0)]
                    .map(|(u, v)| six_node::normal(&p, &f.mids, u, v));
                (0..3)
                    .map(|k| {
                        (n[k] - n[(k + 1) % 3]).length()
                            / (p[k] - p[(k + 1) % 3]).length().max(f64::MIN_POSITIVE)
                    })
                    .fold(0.0, f64::max)
            })
            .collect();
        let facets: IndexVec<FacetId, ReadyFacet> = brep
            .facets
            .enumerated()
            .map(|(id, f)| ReadyFacet::new(brep.corners(id), f.mids))
            .collect();
        let bent = bent_neighbours(brep, &facets);
        let thickness: IndexVec<WallId, f64> = pairing.walls.iter().map(|w| w.thickness).collect();
        let typical = thickness.iter().sum::<f64>() / (thickness.len().max(1) as f64);
        Self {
            brep,
            sides,
            thickness,
            rim_surface,
            rims,
            facets,
            bent,
            curvature,
            typical,
            memory: Memory::new(brep.facets.len()),
        }
    }

    /// The nearest point of a surface; `hint`: where the last search ended, only to make this one faster.
    fn foot(&self, surface: &Surface, p: DVec3, hint: &mut Option<Hint>) -> Option<Foot> {
        let near = surface.bvh.nearest_from(p, *hint)?;
        *hint = Some(near.hint);
        let id = surface.facets[near.index];
        let best = self.foot_on(id, p, near.point);
        let neighbours = &self.bent[id];
        if neighbours.is_empty() || best.is_plumb(p) {
            return Some(best);
        }
        let facet = &self.facets[id];
        let mut distance = best.point.distance(p);
        let [a, b, _] = facet.corners();
        if distance <= ON_SURFACE * a.distance(b) {
            return Some(best);
        }
        // On a curved side the nearest flat facet need not be the nearest curved one: neighbours that are about as near are asked too.
        let reach = near.distance + facet.sag();
        let mut nearest = best;
        for &f in neighbours {
            let other = &self.facets[f];
            let face = self.brep.facets[f].face;
            if surface.faces.binary_search(&face).is_err() {
                continue;
            }
            let flat = nearest_on_triangle(other.corners(), p);
            let away = flat.distance(p);
            if away <= reach + other.sag() && away - BULGE * other.sag() <= distance {
                let foot = self.foot_on(f, p, flat);
                if foot.point.distance_squared(p) < nearest.point.distance_squared(p) {
                    nearest = foot;
                    distance = foot.point.distance(p);
                }
            }
        }
        Some(nearest)
    }

    /// `flat`: the nearest point of the facet's flat triangle.
    fn foot_on(&self, facet: FacetId, p: DVec3, flat: DVec3) -> Foot {
        let (point, normal) = self.facets[facet].nearest(p, flat);
        Foot {
            point,
            normal,
            facet,
        }
    }

    /// The nearest points on the two sides of a wall.
    pub fn feet(&self, p: DVec3, wall: WallId) -> Option<[Foot; 2]> {
        let find = || self.feet_from(p, wall, &mut Hints::default());
        self.memory.feet(p, wall, find)
    }

    fn feet_from(&self, p: DVec3, wall: WallId, hints: &mut Hints) -> Option<[Foot; 2]> {
        let [a, b] = &self.sides[wall];
        let [first, second] = hints;
        let (first, second) = (self.foot(a, p, first)?, self.foot(b, p, second)?);
        Some([
            a.inner_edges.rounded(self.brep, first, p),
            b.inner_edges.rounded(self.brep, second, p),
        ])
    }

    /// Distance to the first side less distance to the second: zero at a mid-point.
    pub fn difference(&self, p: DVec3, wall: WallId) -> Option<f64> {
        let [a, b] = self.feet(p, wall)?;
        Some((a.point - p).length() - (b.point - p).length())
    }

    /// Mean thickness of a wall, mm.
    pub fn mean_thickness(&self, wall: WallId) -> f64 {
        self.thickness[wall]
    }

    /// The planes of the two sides of a wall, where both are flat.
    fn planes(&self, wall: WallId) -> Option<[Plane; 2]> {
        let [a, b] = &self.sides[wall];
        Some([a.plane?, b.plane?])
    }

    /// The tangent plane of what a point must lie on, and how far beyond its end the point is; where the surface is flat and the end within
    /// `room`, only some bound on that.
    fn plane(
        &self,
        p: DVec3,
        support: Support,
        known: &mut Known,
        room: f64,
    ) -> Option<((DVec3, f64), f64)> {
        match support {
            Support::Mid(wall) => {
                if let Some([a, b]) = self.planes(wall)
                    && let Some(beyond) = within(&self.sides[wall][0], a, p, known, room)
                {
                    return middle([a.normal, b.normal], [a.depth(p), b.depth(p)], beyond);
                }
                let [a, b] = self.feet_from(p, wall, &mut known.hints)?;
                let beyond = a.beyond(p).min(b.beyond(p));
                middle([a.normal, b.normal], [a.depth(p), b.depth(p)], beyond).or_else(|| {
                    // At the crest of a rounded rim both sides face the same way: their distances still have a middle.
                    let ((u, to_a), (v, to_b)) = (a.way(p), b.way(p));
                    middle([u, v], [to_a, to_b], beyond)
                })
            }
            Support::Face(face) => {
                let rim = &self.rims[self.rim_surface[face] as usize];
                if let Some(plane) = rim.plane
                    && let Some(beyond) = within(rim, plane, p, known, room)
                {
                    return Some(((plane.normal, plane.depth(p)), beyond));
                }
                let foot = self.foot(rim, p, &mut known.hints[0])?;
                Some(((foot.normal, foot.depth(p)), foot.beyond(p)))
            }
        }
    }

    /// Newton's steps towards the supports, `steps` at most.
    fn converge(&self, start: DVec3, supports: &[Support], steps: usize) -> DVec3 {
        let walls = supports.iter().filter_map(|s| {
            if let Support::Mid(w) = s {
                Some(self.thickness[*w])
            } else {
                None
            }
        });
        let scale = walls.fold(0.0, f64::max);
        let scale = if scale > 0.0 { scale } else { self.typical };
        let mut p = start;
        let mut planes: SmallVec<[(DVec3, f64); 4]> = SmallVec::new();
        let mut known: SmallVec<[Known; 4]> = smallvec::smallvec![Known::default(); supports.len()];
        let mut allowed = None;
        for _ in 0..steps {
            planes.clear();
            let mut beyond = 0.0f64;
            let room = allowed.unwrap_or(REACH * scale);
            for (&support, known) in supports.iter().zip(&mut known) {
                if let Some((plane, end)) = self.plane(p, support, known, room) {
                    planes.push(plane);
                    beyond = beyond.max(end);
                }
            }
            if beyond > *allowed.get_or_insert(beyond.max(REACH * scale)) {
                return start;
            }
            let step = planes::meet(&planes).clamp_length_max(scale);
            p += step;
            for bound in known.iter_mut().filter_map(|k| k.beyond.as_mut()) {
                *bound += step.length();
            }
            if (p - start).length() > LEASH * scale {
                return start + (p - start).clamp_length_max(LEASH * scale);
            }
            if step.length() < SETTLED * scale {
                break;
            }
        }
        p
    }
}

/// The middle between two tangent planes, if they oppose each other.
fn middle(normals: [DVec3; 2], depths: [f64; 2], beyond: f64) -> Option<((DVec3, f64), f64)> {
    let across = normals[0] - normals[1];
    let length = across.length();
    (length > LEAST_OPPOSITION).then(|| {
        let plane = (across / length, (depths[0] - depths[1]) / length);
        (plane, beyond)
    })
}

/// A bound on how far beyond the end of a flat surface the point is, if there is one up to `room`.
fn within(surface: &Surface, plane: Plane, p: DVec3, known: &mut Known, room: f64) -> Option<f64> {
    if known.beyond.is_none_or(|d| d > room) {
        let below = p + plane.normal * plane.depth(p);
        known.beyond = surface.bvh.any_within(below, room);
    }
    known.beyond
}

/// The plane that all nodes of the facets lie in, if there is one.
fn common_plane(brep: &Brep, facets: &[FacetId]) -> Option<Plane> {
    let area = |f: FacetId| {
        let [a, b, c] = brep.corners(f);
        (b - a).cross(c - a)
    };
    let normal = facets
        .iter()
        .map(|&f| area(f))
        .sum::<DVec3>()
        .try_normalize()?;
    let nodes = || {
        facets.iter().flat_map(|&f| {
            let mids = brep.facets[f].mids;
            brep.corners(f).into_iter().chain(mids)
        })
    };
    let (mut low, mut high) = (f64::INFINITY, f64::NEG_INFINITY);
    for p in nodes() {
        let along = normal.dot(p);
        low = low.min(along);
        high = high.max(along);
    }
    let size = nodes().map(|p| p.abs().max_element()).fold(0.0, f64::max);
    let one_way = facets.iter().all(|&f| area(f).dot(normal) >= 0.0);
    (one_way && high - low <= IN_PLANE * size).then(|| Plane {
        normal,
        offset: (low + high) / 2.0,
    })
}

impl Placer for Medial<'_> {
    fn place(&self, start: DVec3, supports: &[Support]) -> DVec3 {
        self.converge(start, supports, STEPS)
    }

    fn draw(&self, start: DVec3, supports: &[Support]) -> DVec3 {
        self.converge(start, supports, 1)
    }

    fn normal(&self, point: DVec3, wall: WallId) -> Option<DVec3> {
        if let Some([a, b]) = self.planes(wall) {
            return (a.normal - b.normal).try_normalize();
        }
        let [a, b] = self.feet(point, wall)?;
        let across = a.normal - b.normal;
        if across.length() > LEAST_OPPOSITION {
            return across.try_normalize();
        }
        (a.way(point).0 - b.way(point).0).try_normalize()
    }

    fn thickness(&self, point: DVec3, wall: WallId) -> Option<f64> {
        if let Some([a, b]) = self.planes(wall) {
            return Some(a.depth(point) + b.depth(point));
        }
        let [a, b] = self.feet(point, wall)?;
        Some(a.depth(point) + b.depth(point))
    }

    fn beyond(&self, point: DVec3, wall: WallId) -> f64 {
        self.feet(point, wall)
            .map_or(f64::INFINITY, |[a, b]| a.beyond(point).max(b.beyond(point)))
    }

    fn curvature_radius(&self, point: DVec3, wall: WallId) -> f64 {
        if self.planes(wall).is_some() {
            return f64::INFINITY;
        }
        // Beyond the parabola round a step's inner edge the sheet is as it was; one thickness away it is over in any case.
        let step = self.sides[wall]
            .iter()
            .map(|s| s.inner_edges.radius(point, self.thickness[wall]))
            .fold(f64::INFINITY, f64::min);
        if step.is_finite() {
            return step;
        }
        let Some([a, b]) = self.feet(point, wall) else {
            return f64::INFINITY;
        };
        let radius = |f: &Foot| 1.0 / self.curvature[f.facet];
        // The middle of two concentric arcs; where one side is flat, the other's word counts for half.
        let (r, s) = (radius(&a), radius(&b));
        if r.is_finite() && s.is_finite() {
            (r + s) / 2.0
        } else {
            2.0 * r.min(s)
        }
    }
}

/// The bent facets that share a corner with each facet, each once.
fn bent_neighbours(
    brep: &Brep,
    facets: &IndexVec<FacetId, ReadyFacet>,
) -> IndexVec<FacetId, Vec<FacetId>> {
    let mut at: IndexVec<VertexId, Vec<FacetId>> =
        IndexVec::filled(Vec::new(), brep.vertices.len());
    for (id, f) in brep.facets.enumerated() {
        if facets[id].sag() > 0.0 {
            for v in f.corners {
                at[v].push(id);
            }
        }
    }
    brep.facets
        .enumerated()
        .map(|(id, f)| {
            let mut near: Vec<FacetId> = Vec::new();
            for &other in f.corners.iter().flat_map(|&v| &at[v]) {
                if other != id && !near.contains(&other) {
                    near.push(other);
                }
            }
            near
        })
        .collect()
}

#[cfg(test)]
mod tests;
