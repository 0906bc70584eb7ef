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
                    _ => (t, mean_normal(surface, t, true), DVec3::NAN),
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
    // Its own word counts for nothing here: a large fold would vouch for itself.
    let others = || mean_normal(surface, t, false);
    own.dot(normal) < 0.0 && own.normalize_or_zero().dot(others()) > AGREES
}

/// Mean normal of the triangles of the same wall round a triangle, with or without itself; zero where they cancel out.
fn mean_normal(surface: &Surface, t: TriangleId, with_itself: bool) -> DVec3 {
    let wall = surface.triangle(t).wall;
    let nodes = surface.triangle(t).nodes.into_iter();
    let round = nodes.flat_map(|n| surface.star(n).iter());
    round
        .filter(|&&s| surface.triangle(s).wall == wall && (with_itself || s != t))
        .map(|&s| area_vector(surface.corners(s)))
        .sum::<DVec3>()
        .normalize_or_zero()
}

#[cfg(test)]
mod tests {
    use super::super::{remesh, start};
    use super::*;
    use crate::geom::orient::folded;
    use crate::model::complex::MidComplex;
    use crate::stage::test_shapes::sheet;

    /// The plane z = 0 of a wall whose normal is turned within a disc.
    struct TurnedIn {
        middle: DVec3,
        radius: f64,
    }

    impl Placer for TurnedIn {
        fn place(&self, start: DVec3, _: &[Support]) -> DVec3 {
            DVec3::new(start.x, start.y, 0.0)
        }
        fn normal(&self, p: DVec3, _: WallId) -> Option<DVec3> {
            let turned = p.distance(self.middle) < self.radius;
            Some(if turned { -DVec3::Z } else { DVec3::Z })
        }
        fn thickness(&self, _: DVec3, _: WallId) -> Option<f64> {
            Some(1.0)
        }
        fn curvature_radius(&self, _: DVec3, _: WallId) -> f64 {
            f64::INFINITY
        }
    }

    fn plate() -> MidComplex {
        sheet(6, 6, |u, v| DVec3::new(12.0 * u, 12.0 * v, 0.0))
    }

    #[test]
    fn a_wall_that_turns_where_the_sheet_goes_on_makes_no_fold() {
        let placer = TurnedIn {
            middle: DVec3::new(5.0, 6.5, 0.0),
            radius: 2.5,
        };
        let options = RemeshOptions::default();
        let (made, _) = remesh(plate(), &|_, _| 0.7, &placer, &options);
        assert!(made.triangles.len() > 400);
        assert!(folded(&made).is_empty());
        let areas = made.triangles.iter().map(|t| {
            let [a, b, c] = t.nodes.map(|n| made.nodes[n].point);
            (b - a).cross(c - a).z / 2.0
        });
        let (sum, least) = areas.fold((0.0, f64::INFINITY), |(s, l): (f64, f64), a| {
            (s + a, l.min(a))
        });
        assert!((sum - 144.0).abs() < 1e-9 && least > 0.0, "{sum} {least}");
    }

    #[test]
    fn a_triangle_that_is_folded_over_is_still_held_against_its_wall() {
        let placer = TurnedIn {
            middle: DVec3::ZERO,
            radius: 0.0,
        };
        let mut complex = plate();
        // A node inside drawn far across its neighbours.
        let moved = (complex.nodes.ids())
            .find(|n| complex.nodes[*n].point.distance(DVec3::new(6.0, 6.0, 0.0)) < 1e-9);
        let moved = moved.unwrap();
        complex.nodes[moved].point = DVec3::new(9.5, 6.3, 0.0);
        let options = RemeshOptions::default();
        let mut job = start(complex, &placer, &options);
        job.refresh_references();
        let against = |t: &TriangleId| area_vector(job.surface.corners(*t)).z < 0.0;
        let folds: Vec<TriangleId> = job.surface.live_triangles().filter(against).collect();
        assert!(!folds.is_empty());
        for t in folds {
            assert_eq!(job.surface.reference[t], DVec3::Z);
        }
    }
}
