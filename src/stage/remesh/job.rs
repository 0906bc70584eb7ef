//! What all steps of a remeshing share.

use super::guide::{GuideId, Guides};
use super::shape::area_vector;
use super::sizes::Asked;
use super::surface::{Class, Surface};
use super::{RemeshOptions, RemeshStats};
use crate::geom::placer::Placer;
use crate::model::complex::{Support, Supports, ends};
use crate::model::ids::{IndexVec, NodeId, TriangleId, WallId};
use glam::DVec3;
use rayon::prelude::*;

/// Cosine of the angle to the mean normal round about up to which a triangle goes on smoothly with its neighbours: 60 degrees, the largest turn of one operation.
const AGREES: f64 = 0.5;

/// Edge length as a function of place and wall.
pub(super) type SizeField<'a> = &'a (dyn Fn(DVec3, WallId) -> f64 + Sync);

/// A remeshing under way.
pub(super) struct Job<'a> {
    pub surface: Surface,
    pub guides: Guides,
    pub placer: &'a dyn Placer,
    pub options: &'a RemeshOptions,
    /// #N wanted edge length.
    pub size: IndexVec<NodeId, f64>,
    /// #N what the size field said last, at nodes that were there then.
    pub asked: IndexVec<NodeId, Asked>,
    pub stats: RemeshStats,
}

impl Job<'_> {
    /// Wanted length of an edge.
    #[inline]
    pub fn wanted(&self, a: NodeId, b: NodeId) -> f64 {
        0.5 * (self.size[a] + self.size[b])
    }

    /// Length of an edge over its wanted length.
    #[inline]
    pub fn ratio(&self, a: NodeId, b: NodeId) -> f64 {
        self.surface.length(a, b) / self.wanted(a, b)
    }

    /// Takes the normals of the mid-surface under all triangles anew; where a wall has none there, the mean of the triangles round about.
    pub fn refresh_references(&mut self) {
        let surface = &self.surface;
        let placer = self.placer;
        let middle = |t: TriangleId| {
            let [a, b, c] = surface.corners(t);
            (a + b + c) / 3.0
        };
        let live: Vec<TriangleId> = surface.live_triangles().collect();
        // A normal depends on the place alone: where that stayed, so does the normal.
        let normals: Vec<(TriangleId, DVec3, DVec3)> = live
            .into_par_iter()
            .map(|t| (t, middle(t)))
            .filter(|&(t, at)| surface.referred[t] != at)
            .map(|(t, at)| {
                let wall = surface.triangle(t).wall;
                match placer.normal(at, wall) {
                    Some(normal) if !only_the_wall_turns(surface, t, normal) => (t, normal, at),
                    Some(_) => (t, mean_normal(surface, t), DVec3::NAN),
                    None => (t, mean_normal(surface, t), DVec3::NAN),
                }
            })
            .collect();
        for (t, normal, at) in normals {
            self.surface.reference[t] = normal;
            self.surface.referred[t] = at;
        }
    }

    /// Puts every node onto its supports, as far towards them as no triangle turns over.
    pub fn place_all(&mut self) {
        let nodes: Vec<NodeId> = self.surface.live_nodes().collect();
        let (surface, placer) = (&self.surface, self.placer);
        let places: Vec<DVec3> = nodes
            .par_iter()
            .map(|&n| placer.place(surface.points[n], &surface.supports[n]))
            .collect();
        self.stats.unplaced = 0;
        for (&n, place) in nodes.iter().zip(places) {
            let from = self.surface.points[n];
            if place == from || !place.is_finite() {
                continue;
            }
            let before = self.surface.quality_now(n);
            // A node that is crowded keeps part of the way: halves down to an eighth, then it waits for a better mesh.
            let step = [1.0, 0.5, 0.25, 0.125].into_iter().find(|&f| {
                let quality = self.surface.quality_at(n, from.lerp(place, f), before);
                quality.is_some_and(|q| q >= 0.5 * before.min(0.4))
            });
            match step {
                Some(f) => self.surface.points[n] = from.lerp(place, f),
                None => self.stats.unplaced += 1,
            }
            if step.is_some_and(|f| f < 1.0) {
                self.stats.unplaced += 1;
            }
        }
    }

    /// The supports of a new node in the middle of edge `a`-`b`.
    pub fn middle_supports(&self, a: NodeId, b: NodeId) -> Supports {
        let ring = self.surface.around(a, b);
        let mut supports: Supports = ring
            .iter()
            .map(|&t| Support::Mid(self.surface.triangle(t).wall))
            .collect();
        if ring.len() == 1 {
            let ends_of = |n: NodeId| ends(&self.surface.supports[n]);
            let common: Supports = ends_of(a)
                .filter(|s| self.surface.supports[b].contains(s))
                .collect();
            if common.is_empty() {
                let middle = 0.5 * (self.surface.points[a] + self.surface.points[b]);
                let nearest = ends_of(a).chain(ends_of(b)).min_by(|s, t| {
                    let moved = |f: Support| {
                        let on = [supports[0], f];
                        self.placer.place(middle, &on).distance(middle)
                    };
                    moved(*s).total_cmp(&moved(*t)).then(s.cmp(t))
                });
                supports.extend(nearest);
            } else {
                supports.extend(common);
            }
        }
        supports.sort_unstable();
        supports.dedup();
        supports
    }

    /// Mean normal of the surface round a node.
    pub fn normal_at(&self, n: NodeId) -> DVec3 {
        let surface = &self.surface;
        surface
            .star(n)
            .iter()
            .map(|&t| {
                let area = area_vector(surface.corners(t)).length();
                surface.reference[t] * area
            })
            .sum::<DVec3>()
            .normalize_or_zero()
    }

    /// Adds a node on an edge, in all books. The guide arc length is wanted for feature edges.
    pub fn split_edge(
        &mut self,
        [a, b]: [NodeId; 2],
        point: DVec3,
        supports: Supports,
        spot: Option<(GuideId, f64)>,
    ) -> NodeId {
        let feature = self.surface.is_feature(&self.surface.around(a, b));
        let class = if feature { Class::Curve } else { Class::Sheet };
        let size = self.wanted(a, b);
        let m = self.surface.split([a, b], point, supports, class);
        let spot = spot.map(|(guide, at)| super::guide::Spot { guide, at });
        self.guides.push(spot);
        self.size.push(size);
        m
    }

    /// Removes a node, in all books.
    pub fn contract_edge(&mut self, gone: NodeId, kept: NodeId) {
        self.surface.contract(gone, kept);
        self.guides.remove(gone);
    }
}

/// Whether a triangle lies against its wall's normal but with all that lies round about: in a lump the nearest places of the two sides change, and with them the
/// normal, where the sheet goes on smoothly. Turned to such a normal, sound triangles become folds.
fn only_the_wall_turns(surface: &Surface, t: TriangleId, normal: DVec3) -> bool {
    let own = area_vector(surface.corners(t));
    own.dot(normal) < 0.0 && own.normalize_or_zero().dot(mean_normal(surface, t)) > AGREES
}

/// Mean normal of the triangles of the same wall round a triangle; zero where they cancel out.
fn mean_normal(surface: &Surface, t: TriangleId) -> DVec3 {
    let wall = surface.triangle(t).wall;
    let nodes = surface.triangle(t).nodes.into_iter();
    let round = nodes.flat_map(|n| surface.star(n).iter());
    let own = round.filter(|&&s| surface.triangle(s).wall == wall);
    own.map(|&s| area_vector(surface.corners(s)))
        .sum::<DVec3>()
        .normalize_or_zero()
}
