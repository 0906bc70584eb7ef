//! The exact mid-surface of every wall, and the faces that rims lie on.
//!
//! A mid-point has equal distance to both sides of its wall. Distances are to the six-node facets of that wall's faces only, so that a
//! neighbour wall never interferes. Beyond the end of a side (under a rib, past a corner) the tangent plane at its last point goes on: with
//! that one rule a plate stays flat under its rib, sheets extend until they meet, and a rim comes to lie on its lateral face. At the inner edge of
//! a step the side does not end: there the distance is that to the edge, and the mid-surface climbs along a parabola.

mod bevel;
mod corner;
mod divided;
mod edges;
mod facing;
mod flats;
mod ground;
mod held;
mod lines;
mod memory;
mod queries;
mod reach;
mod slant;
mod void;

use crate::geom::planes;
use crate::geom::triangle::nearest_on_triangle;
use crate::model::brep::Brep;
use crate::model::complex::Support;
use crate::model::ids::{FaceId, FacetId, IndexVec, WallId};
use crate::model::walls::{Aag, Convexity, Pairing};
use crate::spatial::{Hint, TriangleBvh};
use corner::InnerEdges;
use edges::OnEdge;
use facing::Roundings;
use flats::Flats;
use glam::DVec3;
use ground::Ground;
pub use held::Held;
pub use lines::{Line, Lines, Piece};
use memory::Memory;
use rayon::prelude::*;
use slant::Slants;
use smallvec::SmallVec;
use std::sync::Arc;

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
/// The ways to two sides that differ by less than this are one way, to rounding. Above it their difference has a middle, however near to the crest where they become one: what is a
/// small distance off the middle there is seen under a small angle.
const LEAST_PARTING: f64 = 0.01;
/// A point this near to its foot, in edge lengths, lies on the surface: which way the rest points is rounding.
const ON_SURFACE: f64 = 1e-9;
/// Nodes this near to a common plane, as a share of their largest coordinate, lie in it: CAD files know their own points no better than to 1e-7 mm.
const IN_PLANE: f64 = 1e-9;
/// A six-node facet leaves its flat triangle by at most this many times its sag: the three mid-side shape functions sum up to this.
const BULGE: f64 = 4.0 / 3.0;
/// The side of a point's own layer is no further than this, in thicknesses: the point is somewhere in the wall, and the wall may be twice as thick as its mean.
const OWN_SIDE: f64 = 2.0;
/// A point this far above its foot is not in the material below it, as a share of that reach: far above what a step of the placing leaves, far below any gap
/// that a mesh size resolves.
const ACROSS_GAP: f64 = 1e-3;
/// Nor is one this far above the plane of its foot, as a share of that reach, wherever over that plane it is: half a thickness.
const FAR_ABOVE: f64 = 0.25;
/// Layers of one wall that lie on each other look the same way, within this cosine.
const SAME_WAY: f64 = 0.5;
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

/// The tangent plane of a support at a point.
#[derive(Clone, Copy, Debug)]
struct Tangent {
    /// Its unit normal, and how far below it the point is, mm.
    plane: (DVec3, f64),
    /// How far beyond the end of the support the point is, mm.
    beyond: f64,
    /// Of a wall, the distance between its sides, mm.
    thickness: f64,
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
    roundings: Roundings,
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
    /// Whether its two sides were one face.
    divided: IndexVec<WallId, bool>,
    /// How far beyond the end of its sides a wall may be carried on, mm.
    reach: IndexVec<WallId, f64>,
    /// Rims may slide from a lateral face onto one that is tangent to it: such faces share one surface.
    rim_surface: IndexVec<FaceId, u32>,
    rims: Vec<Surface>,
    slants: Slants,
    ground: Arc<Ground>,
    typical: f64,
    memory: Memory,
    flats: Flats,
    lines: Arc<Lines>,
}

impl<'a> Medial<'a> {
    /// Builds the hierarchies of all walls and lateral faces.
    pub fn new(brep: &'a Brep, aag: &Aag, pairing: &Pairing) -> Self {
        Self::on(Arc::new(Ground::new(brep)), brep, aag, pairing)
    }

    /// The same for another pairing of the same solid.
    pub fn paired(&self, aag: &Aag, pairing: &Pairing) -> Self {
        let mut new = Self::on(Arc::clone(&self.ground), self.brep, aag, pairing);
        new.let_bevels_stand(self.slants.bevels_stand);
        new.lines = Arc::clone(&self.lines);
        new
    }

    /// The same for walls that are cut along lines.
    pub fn cut_along(self, lines: Lines) -> Self {
        let lines = Arc::new(lines);
        Self { lines, ..self }
    }

    /// The lines that walls are cut along.
    pub fn lines(&self) -> &Lines {
        &self.lines
    }

    fn on(ground: Arc<Ground>, brep: &'a Brep, aag: &Aag, pairing: &Pairing) -> Self {
        let surface = |faces: &[FaceId]| {
            let mut faces = faces.to_vec();
            faces.sort_unstable();
            let facets: Vec<FacetId> = faces
                .iter()
                .flat_map(|f| ground.of_face[*f].iter().copied())
                .collect();
            let corners: Vec<[DVec3; 3]> = facets.iter().map(|&f| brep.corners(f)).collect();
            Surface {
                bvh: TriangleBvh::new(&corners),
                plane: common_plane(brep, &facets),
                facets,
                inner_edges: InnerEdges::new(brep, aag, &faces),
                roundings: Roundings::new(aag, pairing, &faces),
                faces,
            }
        };
        let sides: IndexVec<WallId, [Surface; 2]> = (pairing.walls.as_slice().par_iter())
            .map(|w| [0, 1].map(|s| surface(&w.sides[s])))
            .collect::<Vec<_>>()
            .into();
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
            rims.push(members);
        }
        let rims: Vec<Surface> = rims.par_iter().map(|faces| surface(faces)).collect();
        let thickness: IndexVec<WallId, f64> = pairing.walls.iter().map(|w| w.thickness).collect();
        let divided = (pairing.walls.iter())
            .map(|w| divided::was_one_face(brep, w))
            .collect();
        let reach = pairing
            .walls
            .iter()
            .map(|w| REACH * w.thickness + reach::blends(aag, pairing, w).min(REACH * w.thickness))
            .collect();
        let typical = thickness.iter().sum::<f64>() / (thickness.len().max(1) as f64);
        let flats = Flats::new(brep, &sides);
        let mut medial = Self {
            brep,
            sides,
            thickness,
            divided,
            reach,
            rim_surface,
            rims,
            slants: Slants::default(),
            ground,
            typical,
            memory: Memory::new(brep.facets.len()),
            flats,
            lines: Arc::default(),
        };
        medial.slants = Slants::new(&medial, brep, aag, pairing);
        medial
    }

    /// Whether rims go on above bevels, as far as the end face. So they do until the sheets are untangled: cut back from either side, a raw sheet narrower than the wall is thick
    /// would have no width left.
    pub fn let_bevels_stand(&mut self, stand: bool) {
        self.slants.bevels_stand = stand;
    }

    /// The nearest point of a surface; `hint`: where the last search ended, only to make this one faster.
    fn foot(&self, surface: &Surface, p: DVec3, hint: &mut Option<Hint>) -> Option<Foot> {
        let near = surface.bvh.nearest_from(p, *hint)?;
        *hint = Some(near.hint);
        let id = surface.facets[near.index];
        let best = self.foot_on(id, p, near.point);
        let neighbours = &self.ground.bent[id];
        if neighbours.is_empty() || best.is_plumb(p) {
            return Some(best);
        }
        let facet = &self.ground.facets[id];
        let mut distance = best.point.distance(p);
        let [a, b, _] = facet.corners();
        if distance <= ON_SURFACE * a.distance(b) {
            return Some(best);
        }
        // On a curved side the nearest flat facet need not be the nearest curved one: neighbours that are about as near are asked too.
        let reach = near.distance + facet.sag();
        let mut nearest = best;
        for &f in neighbours {
            let other = &self.ground.facets[f];
            // Of its flat triangle no point is nearer than that of the ball round it.
            if other.least_distance(p) > reach + other.sag() {
                continue;
            }
            let face = self.brep.facets[f].face;
            if surface.faces.binary_search(&face).is_err() {
                continue;
            }
            let flat = nearest_on_triangle(other.corners(), p);
            let away = flat.distance(p);
            if away <= reach + other.sag() && away - BULGE * other.sag() <= distance {
                let least = nearest.point.distance_squared(p);
                let (point, normal) = other.nearest_within(p, flat, least);
                if point.distance_squared(p) < least {
                    let foot = Foot {
                        point,
                        normal,
                        facet: f,
                    };
                    nearest = foot;
                    distance = foot.point.distance(p);
                }
            }
        }
        Some(nearest)
    }

    /// `flat`: the nearest point of the facet's flat triangle.
    fn foot_on(&self, facet: FacetId, p: DVec3, flat: DVec3) -> Foot {
        let (point, normal) = self.ground.facets[facet].nearest(p, flat);
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
        let mut first = self.side_foot(wall, 0, p, first)?;
        let mut second = self.side_foot(wall, 1, p, second)?;
        let reach = OWN_SIDE * self.thickness[wall];
        // A foot across a gap lies behind the other side's; one that a step overshot lies before it.
        let [to_first, to_second] = [first, second].map(|foot| foot.point.distance(p));
        if to_first > to_second {
            first = self.own(a, first, p, [reach, 2.0 * reach + to_second]);
        } else {
            second = self.own(b, second, p, [reach, 2.0 * reach + to_first]);
        }
        let feet = self.facing([a, b], [first, second], p, wall);
        Some([
            a.inner_edges.rounded(self.brep, feet[0], p),
            b.inner_edges.rounded(self.brep, feet[1], p),
        ])
    }

    /// The foot itself, unless the point lies straight above it, or far above its plane: then it was found across a gap, on another layer of the same wall (a hem, a spiral, ribs closer
    /// than they are thick, the turns of a thread), and the nearest place of this layer is meant, if there is one within reach that looks the same way. From beside the wall, under
    /// the gap, its reach is the `longer` one.
    fn own(&self, side: &Surface, foot: Foot, p: DVec3, [reach, longer]: [f64; 2]) -> Foot {
        let above = -foot.depth(p) / reach;
        if side.plane.is_some() || above < ACROSS_GAP {
            return foot;
        }
        let reach = match foot.is_plumb(p) {
            true => reach,
            false if above > FAR_ABOVE => longer,
            false => return foot,
        };
        let below = |i: usize| {
            let corners = self.ground.facets[side.facets[i]].corners();
            let across = (corners[1] - corners[0]).cross(corners[2] - corners[0]);
            across.dot(corners[0] - p) > 0.0 && across.dot(foot.normal) > SAME_WAY * across.length()
        };
        side.bvh
            .nearest_where(p, reach, below)
            .map_or(foot, |near| {
                self.foot_on(side.facets[near.index], p, near.point)
            })
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

    /// The tangent plane of what a point must lie on; where the surface is flat and the end within
    /// `room`, only some bound on that.
    fn plane(&self, p: DVec3, support: Support, known: &mut Known, room: f64) -> Option<Tangent> {
        match support {
            Support::Mid(wall) => {
                if let Some([a, b]) = self.planes(wall)
                    && let Some(beyond) = within(&self.sides[wall][0], a, p, known, room)
                {
                    return middle([a.normal, b.normal], [a.depth(p), b.depth(p)], beyond);
                }
                let [a, b] = self.feet_from(p, wall, &mut known.hints)?;
                if let Some(tangent) = self.straight_on(p, wall, [a, b]) {
                    return Some(tangent);
                }
                let beyond = a.beyond(p).min(b.beyond(p));
                middle([a.normal, b.normal], [a.depth(p), b.depth(p)], beyond).or_else(|| {
                    // At the crest of a rounded rim both sides face the same way: their distances still have a middle.
                    let ((u, to_a), (v, to_b)) = (a.way(p), b.way(p));
                    middle_if([u, v], [to_a, to_b], beyond, LEAST_PARTING)
                })
            }
            Support::Face(face) => {
                let rim = &self.rims[self.rim_surface[face] as usize];
                if let Some(plane) = rim.plane
                    && let Some(beyond) = within(rim, plane, p, known, room)
                {
                    return Some(Tangent {
                        plane: (plane.normal, plane.depth(p)),
                        beyond,
                        thickness: 0.0,
                    });
                }
                let foot = self.foot(rim, p, &mut known.hints[0])?;
                Some(Tangent {
                    plane: (foot.normal, foot.depth(p)),
                    beyond: foot.beyond(p),
                    thickness: 0.0,
                })
            }
            // The plane of an edge depends on that of the wall; what is pinned is not asked for.
            Support::Edge(_) | Support::Pin(_) => None,
        }
    }

    /// Newton's steps towards the supports, `steps` at most; and whether that is sure: the last place lies over a side of a wall, or no place was found within reach.
    fn converge(&self, start: DVec3, supports: &[Support], steps: usize) -> (DVec3, bool) {
        let walls = supports.iter().filter_map(|s| {
            if let Support::Mid(w) = s {
                Some(self.thickness[*w])
            } else {
                None
            }
        });
        let scale = walls.fold(0.0, f64::max);
        let scale = if scale > 0.0 { scale } else { self.typical };
        let reach = supports.iter().filter_map(|s| match s {
            Support::Mid(w) => Some(self.reach[*w]),
            Support::Face(_) | Support::Edge(_) | Support::Pin(_) => None,
        });
        let reach = reach.fold(REACH * scale, f64::max);
        let mut p = start;
        let mut planes: SmallVec<[(DVec3, f64); 4]> = SmallVec::new();
        let mut mids: SmallVec<[(WallId, DVec3, f64); 4]> = SmallVec::new();
        let mut rims: SmallVec<[(usize, FaceId); 4]> = SmallVec::new();
        let mut edges: SmallVec<[OnEdge; 1]> = SmallVec::new();
        let mut known: SmallVec<[Known; 4]> = smallvec::smallvec![Known::default(); supports.len()];
        let mut allowed = None;
        let mut over = false;
        for _ in 0..steps {
            planes.clear();
            mids.clear();
            rims.clear();
            edges.clear();
            let mut beyond = 0.0f64;
            over = false;
            let room = allowed.unwrap_or(reach);
            for (&support, known) in supports.iter().zip(&mut known) {
                if let Some(tangent) = self.plane(p, support, known, room) {
                    match support {
                        Support::Mid(w) => {
                            over |= tangent.beyond <= void::NEAR * self.thickness[w];
                            mids.push((w, tangent.plane.0, tangent.thickness));
                        }
                        Support::Face(f) => rims.push((planes.len(), f)),
                        Support::Edge(_) | Support::Pin(_) => {}
                    }
                    planes.push(tangent.plane);
                    beyond = beyond.max(tangent.beyond);
                } else if let Support::Edge(curve) = support {
                    edges.extend(self.ground.edges.nearest(p, curve));
                }
            }
            planes.extend(edges.iter().map(|edge| edge.across(&mids)));
            planes.extend(self.lines.planes(p, &mids));
            for &(i, face) in &rims {
                let surface = self.rim_surface[face] as usize;
                planes[i].1 -= self.slants.inset(surface, planes[i].0, &mids);
            }
            if beyond > *allowed.get_or_insert(beyond.max(reach)) {
                return (start, true);
            }
            let step = planes::meet(&planes).clamp_length_max(scale);
            p += step;
            for bound in known.iter_mut().filter_map(|k| k.beyond.as_mut()) {
                *bound += step.length();
            }
            if (p - start).length() > LEASH * scale {
                let leashed = (p - start).clamp_length_max(LEASH * scale);
                return (start + leashed, true);
            }
            if step.length() < SETTLED * scale {
                break;
            }
        }
        (p, over)
    }
}

/// The middle between two tangent planes, if they oppose each other.
fn middle(normals: [DVec3; 2], depths: [f64; 2], beyond: f64) -> Option<Tangent> {
    middle_if(normals, depths, beyond, LEAST_OPPOSITION)
}

/// The same for unit vectors that differ by more than `least`.
fn middle_if(normals: [DVec3; 2], depths: [f64; 2], beyond: f64, least: f64) -> Option<Tangent> {
    let across = normals[0] - normals[1];
    let length = across.length();
    (length > least).then(|| Tangent {
        plane: (across / length, (depths[0] - depths[1]) / length),
        beyond,
        thickness: depths[0] + depths[1],
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
    let normal = facets
        .iter()
        .map(|&f| brep.area_vector(f))
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
    let one_way = facets
        .iter()
        .all(|&f| brep.area_vector(f).dot(normal) >= 0.0);
    (one_way && high - low <= IN_PLANE * size).then(|| Plane {
        normal,
        offset: (low + high) / 2.0,
    })
}

#[cfg(test)]
mod tests;
