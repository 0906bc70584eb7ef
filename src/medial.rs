//! The exact mid-surface of every wall, and the faces that rims lie on.
//!
//! A mid-point has equal distance to both sides of its wall. Distances are to the six-node facets of that wall's faces only, so that a
//! neighbour wall never interferes. Beyond the end of a side (under a rib, past a corner) the tangent plane at its last point goes on: with
//! that one rule a plate stays flat under its rib, sheets extend until they meet, and a rim comes to lie on its lateral face. At the inner edge of
//! a step the side does not end: there the distance is that to the edge, and the mid-surface climbs along a parabola.

mod corner;

use crate::geom::placer::Placer;
use crate::geom::planes;
use crate::geom::six_node::{self, nearest_on_quadratic};
use crate::geom::triangle::nearest_on_triangle;
use crate::model::brep::Brep;
use crate::model::complex::Support;
use crate::model::ids::{FaceId, FacetId, IndexVec, VertexId, WallId};
use crate::model::walls::{Aag, Convexity, Pairing};
use crate::spatial::TriangleBvh;
use corner::InnerEdges;
use glam::DVec3;

/// Steps of the placing iteration: it converges quadratically on smooth walls; the rest guards against cycling at edges.
const STEPS: usize = 16;
/// A placed point has moved less than this in its last step, in thicknesses.
const SETTLED: f64 = 1e-9;
/// No point moves further than this in all, in thicknesses: further away is another wall's business.
const LEASH: f64 = 3.0;
/// Nor further beyond the end of its surfaces than this, in thicknesses: sheets that are extended to meet do so within the block where
/// their walls join. One that lies further out may stay where it is.
const REACH: f64 = 1.5;
/// Two sides whose normals are nearer to parallel than this sum of unit normals define no middle.
const LEAST_OPPOSITION: f64 = 0.5;

/// A facet whose mid-side points lie off its sides by less than this share of their length is flat.
const FLAT: f64 = 1e-9;
/// A foot is plumb within this sine; far above rounding, far below what a wrong facet gives.
const PLUMB: f64 = 1e-6;

/// A set of facets with its hierarchy.
#[derive(Clone, Debug, Default)]
struct Surface {
    bvh: TriangleBvh,
    facets: Vec<FacetId>,
    /// Sorted.
    faces: Vec<FaceId>,
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
    /// How far each facet's mid-side points lie off its sides, mm; zero where it is flat to rounding.
    sag: IndexVec<FacetId, f64>,
    /// Facets at every vertex.
    stars: IndexVec<VertexId, Vec<FacetId>>,
    /// Normal curvature of each facet, 1/mm, estimated from its corner normals.
    curvature: IndexVec<FacetId, f64>,
    typical: f64,
}

impl<'a> Medial<'a> {
    /// Builds the hierarchies of all walls and lateral faces.
    pub fn new(brep: &'a Brep, aag: &Aag, pairing: &Pairing) -> Self {
        let mut of_face: IndexVec<FaceId, Vec<FacetId>> =
            IndexVec::filled(Vec::new(), brep.faces.len());
        for (id, f) in brep.facets.enumerated() {
            of_face[f.face].push(id);
        }
        let mut stars: IndexVec<VertexId, Vec<FacetId>> =
            IndexVec::filled(Vec::new(), brep.vertices.len());
        for (id, f) in brep.facets.enumerated() {
            for v in f.corners {
                stars[v].push(id);
            }
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
        let sag = brep
            .facets
            .enumerated()
            .map(|(id, f)| {
                let p = brep.corners(id);
                let off = |k: usize| f.mids[k].distance((p[k] + p[(k + 1) % 3]) / 2.0);
                let most = off(0).max(off(1)).max(off(2));
                if most > FLAT * p[0].distance(p[1]) {
                    most
                } else {
                    0.0
                }
            })
            .collect();
        let thickness: IndexVec<WallId, f64> = pairing.walls.iter().map(|w| w.thickness).collect();
        let typical = thickness.iter().sum::<f64>() / (thickness.len().max(1) as f64);
        Self {
            brep,
            sides,
            thickness,
            rim_surface,
            rims,
            sag,
            stars,
            curvature,
            typical,
        }
    }

    fn foot(&self, surface: &Surface, p: DVec3) -> Option<Foot> {
        let near = surface.bvh.nearest(p)?;
        let best = self.foot_on(surface.facets[near.index], p);
        if best.is_plumb(p) {
            return Some(best);
        }
        // On a curved side the nearest flat facet need not be the nearest curved one: neighbours that are about as near are asked too.
        let reach = near.distance + self.sag[best.facet];
        let corners = self.brep.facets[best.facet].corners;
        let mut nearest = best;
        for &f in corners.iter().flat_map(|&v| &self.stars[v]) {
            let bent = self.sag[f] > 0.0 && f != best.facet;
            if bent
                && surface
                    .faces
                    .binary_search(&self.brep.facets[f].face)
                    .is_ok()
                && nearest_on_triangle(self.brep.corners(f), p).distance(p) <= reach + self.sag[f]
            {
                let foot = self.foot_on(f, p);
                if foot.point.distance_squared(p) < nearest.point.distance_squared(p) {
                    nearest = foot;
                }
            }
        }
        Some(nearest)
    }

    fn foot_on(&self, facet: FacetId, p: DVec3) -> Foot {
        let (point, normal) =
            nearest_on_quadratic(self.brep.corners(facet), self.brep.facets[facet].mids, p);
        Foot {
            point,
            normal,
            facet,
        }
    }

    /// The nearest points on the two sides of a wall.
    pub fn feet(&self, p: DVec3, wall: WallId) -> Option<[Foot; 2]> {
        let [a, b] = &self.sides[wall];
        let (first, second) = (self.foot(a, p)?, self.foot(b, p)?);
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

    /// The tangent plane of what a point must lie on, and how far beyond its end the point is.
    fn plane(&self, p: DVec3, support: Support) -> Option<((DVec3, f64), f64)> {
        match support {
            Support::Mid(wall) => {
                let [a, b] = self.feet(p, wall)?;
                let across = a.normal - b.normal;
                let length = across.length();
                let beyond = a.beyond(p).min(b.beyond(p));
                (length > LEAST_OPPOSITION).then(|| {
                    let plane = (across / length, (a.depth(p) - b.depth(p)) / length);
                    (plane, beyond)
                })
            }
            Support::Face(face) => {
                let foot = self.foot(&self.rims[self.rim_surface[face] as usize], p)?;
                Some(((foot.normal, foot.depth(p)), foot.beyond(p)))
            }
        }
    }
}

impl Placer for Medial<'_> {
    fn place(&self, start: DVec3, supports: &[Support]) -> DVec3 {
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
        let mut planes: smallvec::SmallVec<[(DVec3, f64); 4]> = smallvec::SmallVec::new();
        let mut allowed = None;
        for _ in 0..STEPS {
            planes.clear();
            let mut beyond = 0.0f64;
            for (plane, end) in supports.iter().filter_map(|&s| self.plane(p, s)) {
                planes.push(plane);
                beyond = beyond.max(end);
            }
            if beyond > *allowed.get_or_insert(beyond.max(REACH * scale)) {
                return start;
            }
            let step = planes::meet(&planes).clamp_length_max(scale);
            p += step;
            if (p - start).length() > LEASH * scale {
                return start + (p - start).clamp_length_max(LEASH * scale);
            }
            if step.length() < SETTLED * scale {
                break;
            }
        }
        p
    }

    fn normal(&self, point: DVec3, wall: WallId) -> Option<DVec3> {
        let [a, b] = self.feet(point, wall)?;
        (a.normal - b.normal).try_normalize()
    }

    fn thickness(&self, point: DVec3, wall: WallId) -> Option<f64> {
        let [a, b] = self.feet(point, wall)?;
        Some(a.depth(point) + b.depth(point))
    }

    fn beyond(&self, point: DVec3, wall: WallId) -> f64 {
        self.feet(point, wall)
            .map_or(f64::INFINITY, |[a, b]| a.beyond(point).max(b.beyond(point)))
    }

    fn curvature_radius(&self, point: DVec3, wall: WallId) -> f64 {
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

#[cfg(test)]
mod tests;
