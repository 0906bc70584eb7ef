//! How badly a part of a mesh is folded, now and after a step that has not been done.
//!
//! A step changes a few triangles; only these and those that share a side with them are judged anew, the others keep what is known of them.
//!
//! Guarantee: what comes out is to the bit what judging the whole part after the step would give.
//! Cost: linear in the part once, then for each step in the triangles that it changes, with a logarithm of the part's size.

use super::cones::Cone;
use super::refill::Refill;
use super::shape::{area_vector, quality};
use super::surface::Surface;
use super::unfold::Step;
use crate::model::complex::MidTriangle;
use crate::model::ids::{NodeId, TriangleId};
use glam::DVec3;

/// A triangle this low, as a share of its longest side, has no area: far above the rounding of coordinates, far below a poor shape.
pub(super) const FLAT: f64 = 1e-6;

/// How bad a part is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Score {
    /// Triangles that lie against their neighbours or have no area.
    pub folds: usize,
    /// Twice the area that is folded.
    pub folded_area: f64,
    /// The least quality of all.
    pub least: f64,
}

/// A side of a triangle: its ends in order, the triangle, whether it runs from the lower end to the higher.
type Side = (NodeId, NodeId, u32, bool);

/// Some triangles, of which the first `inside` are judged.
pub(super) struct Part {
    ids: Vec<TriangleId>,
    triangles: Vec<MidTriangle>,
    inside: usize,
    /// All sides, sorted.
    sides: Vec<Side>,
    /// Nodes with their triangles, sorted.
    of_node: Vec<(NodeId, u32)>,
    /// #T twice the area, along the normal.
    areas: Vec<DVec3>,
    /// Those inside that are bad, in order.
    bad: Vec<u32>,
    /// Those inside with their qualities, the worst first.
    shapes: Vec<(f64, u32)>,
}

/// Triangles as a step leaves them, sorted by their place in the part.
struct Changes {
    at: Vec<u32>,
    triangles: Vec<MidTriangle>,
    areas: Vec<DVec3>,
    sides: Vec<Side>,
}

impl Part {
    pub fn new(surface: &Surface, ids: Vec<TriangleId>, inside: usize) -> Self {
        let triangles: Vec<MidTriangle> = ids.iter().map(|&t| surface.triangle(t)).collect();
        let mut sides = Vec::with_capacity(3 * triangles.len());
        let mut of_node = Vec::with_capacity(3 * triangles.len());
        for (i, t) in triangles.iter().enumerate() {
            sides.extend(sides_of(t, i as u32));
            of_node.extend(t.nodes.map(|n| (n, i as u32)));
        }
        sides.sort_unstable();
        of_node.sort_unstable();
        let corners = |t: &MidTriangle| t.nodes.map(|n| surface.points[n]);
        let areas = triangles.iter().map(|t| area_vector(corners(t))).collect();
        let mut shapes: Vec<(f64, u32)> = (triangles[..inside].iter().zip(0..))
            .map(|(t, i)| (quality(corners(t)), i))
            .collect();
        shapes.sort_by(|x, y| x.0.total_cmp(&y.0));
        let mut part = Self {
            ids,
            triangles,
            inside,
            sides,
            of_node,
            areas,
            bad: Vec::new(),
            shapes,
        };
        let none = Changes::none();
        part.bad = (0..inside as u32)
            .filter(|&i| part.is_bad(i, &none, &|n| surface.points[n]))
            .collect();
        part
    }

    /// The bad triangles inside.
    pub fn bad(&self) -> Vec<TriangleId> {
        self.bad.iter().map(|&i| self.ids[i as usize]).collect()
    }

    /// The part as it is.
    pub fn score(&self) -> Score {
        Score {
            folds: self.bad.len(),
            folded_area: self.bad.iter().map(|&i| self.area(i).length()).sum(),
            least: self.shapes.first().map_or(f64::INFINITY, |s| s.0),
        }
    }

    /// The part without a triangle.
    pub fn score_without(&self, surface: &Surface, t: TriangleId) -> Score {
        let at = self.ids.iter().position(|&s| s == t);
        let changed = at.map(|i| {
            let MidTriangle { nodes, wall } = self.triangles[i];
            let nodes = [nodes[0], nodes[0], nodes[2]];
            (i as u32, MidTriangle { nodes, wall })
        });
        self.rate(changed.into_iter().collect(), &|n| surface.points[n])
    }

    /// The part after a step.
    pub fn after(&self, surface: &Surface, step: &Step) -> Score {
        match step {
            Step::Move(places) => {
                let mut moved: Vec<(NodeId, DVec3)> = places.clone();
                moved.sort_by_key(|m| m.0);
                let mut at: Vec<u32> = moved.iter().flat_map(|m| self.star(m.0)).collect();
                at.sort_unstable();
                at.dedup();
                let same = |i: u32| (i, self.triangles[i as usize]);
                self.rate(at.into_iter().map(same).collect(), &|n| match moved
                    .binary_search_by_key(&n, |m| m.0)
                {
                    Ok(k) => moved[k].1,
                    Err(_) => surface.points[n],
                })
            }
            Step::Flip(edge, pair) => {
                let new = surface.flipped(*edge, *pair);
                let mut changed: Vec<(u32, MidTriangle)> = (pair.iter().zip(new))
                    .filter_map(|(t, nodes)| {
                        let i = self.ids.iter().position(|s| s == t)?;
                        let wall = self.triangles[i].wall;
                        Some((i as u32, MidTriangle { nodes, wall }))
                    })
                    .collect();
                changed.sort_unstable_by_key(|c| c.0);
                self.rate(changed, &|n| surface.points[n])
            }
            Step::Cap(cone) => self.rate(self.capped(cone), &|n| surface.points[n]),
            Step::Contract { gone, kept } => {
                let changed = self.star(*gone).map(|i| {
                    let MidTriangle { nodes, wall } = self.triangles[i as usize];
                    let nodes = nodes.map(|n| if n == *gone { *kept } else { n });
                    (i, MidTriangle { nodes, wall })
                });
                self.rate(changed.collect(), &|n| surface.points[n])
            }
        }
    }

    /// The part with a piece of it filled anew.
    pub fn refilled(&self, surface: &Surface, filling: &Refill) -> Score {
        let mut changed: Vec<(u32, MidTriangle)> = (filling.old.iter().enumerate())
            .filter_map(|(k, t)| {
                let i = self.ids.iter().position(|s| s == t)?;
                let MidTriangle { nodes, wall } = self.triangles[i];
                let nodes = filling.new.get(k).copied().unwrap_or([nodes[0]; 3]);
                Some((i as u32, MidTriangle { nodes, wall }))
            })
            .collect();
        changed.sort_unstable_by_key(|c| c.0);
        self.rate(
            changed,
            &|n| match filling.places.binary_search_by_key(&n, |p| p.0) {
                Ok(k) => filling.places[k].1,
                Err(_) => surface.points[n],
            },
        )
    }

    /// A cone with its first triangle for base and the others gone.
    fn capped(&self, cone: &Cone) -> Vec<(u32, MidTriangle)> {
        let mut changed: Vec<(u32, MidTriangle)> = (cone.triangles.iter().enumerate())
            .filter_map(|(k, t)| {
                let i = self.ids.iter().position(|s| s == t)?;
                let wall = self.triangles[i].wall;
                let nodes = if k == 0 { cone.base } else { [cone.hub; 3] };
                Some((i as u32, MidTriangle { nodes, wall }))
            })
            .collect();
        changed.sort_unstable_by_key(|c| c.0);
        changed
    }

    /// The triangles at a node, in order.
    fn star(&self, n: NodeId) -> impl Iterator<Item = u32> + '_ {
        let from = self.of_node.partition_point(|x| x.0 < n);
        let run = self.of_node[from..].iter().take_while(move |x| x.0 == n);
        run.map(|x| x.1)
    }

    /// The score with some triangles changed, these sorted and none twice.
    fn rate(&self, changed: Vec<(u32, MidTriangle)>, at: &dyn Fn(NodeId) -> DVec3) -> Score {
        let mut changes = Changes::none();
        for (i, t) in changed {
            changes.sides.extend(sides_of(&t, i));
            changes.areas.push(area_vector(t.nodes.map(at)));
            changes.at.push(i);
            changes.triangles.push(t);
        }
        let mut touched = changes.at.clone();
        for &i in &changes.at {
            for side in sides_of(&self.triangles[i as usize], i) {
                touched.extend(self.along(side).map(|s| s.2));
            }
        }
        for &side in &changes.sides {
            touched.extend(self.along(side).map(|s| s.2));
        }
        touched.retain(|&i| (i as usize) < self.inside);
        touched.sort_unstable();
        touched.dedup();
        let mut bad: Vec<u32> = (self.bad.iter().copied())
            .filter(|i| touched.binary_search(i).is_err())
            .collect();
        bad.extend((touched.into_iter()).filter(|&i| self.is_bad(i, &changes, at)));
        bad.sort_unstable();
        let area = |i: u32| match changes.at.binary_search(&i) {
            Ok(k) => changes.areas[k],
            Err(_) => self.area(i),
        };
        let kept = (self.shapes.iter()).find(|s| changes.at.binary_search(&s.1).is_err());
        let new = (changes.at.iter().zip(&changes.triangles))
            .filter(|&(&i, t)| (i as usize) < self.inside && !is_gone(t))
            .map(|(_, t)| quality(t.nodes.map(at)));
        Score {
            folds: bad.len(),
            folded_area: bad.iter().map(|&i| area(i).length()).sum(),
            least: new.fold(kept.map_or(f64::INFINITY, |s| s.0), f64::min),
        }
    }

    fn area(&self, i: u32) -> DVec3 {
        self.areas[i as usize]
    }

    /// All sides with the ends of this one.
    fn along(&self, (a, b, ..): Side) -> impl Iterator<Item = &Side> + '_ {
        let from = self.sides.partition_point(|s| (s.0, s.1) < (a, b));
        (self.sides[from..].iter()).take_while(move |s| (s.0, s.1) == (a, b))
    }

    /// Whether a triangle has no area or lies against all its neighbours in the sheet taken together.
    fn is_bad(&self, i: u32, changes: &Changes, at: &dyn Fn(NodeId) -> DVec3) -> bool {
        let found = |i: u32| match changes.at.binary_search(&i) {
            Ok(k) => (changes.triangles[k], changes.areas[k]),
            Err(_) => (self.triangles[i as usize], self.area(i)),
        };
        let (t, area) = found(i);
        if is_gone(&t) {
            return false;
        }
        let [a, b, c] = t.nodes.map(at);
        let longest = a
            .distance_squared(b)
            .max(b.distance_squared(c))
            .max(c.distance_squared(a));
        if area.length() <= FLAT * longest {
            return true;
        }
        let mut own: Vec<Side> = sides_of(&t, i).collect();
        own.sort_unstable();
        let mut around = DVec3::ZERO;
        for side in own {
            let others = (self.along(side).copied())
                .filter(|s| changes.at.binary_search(&s.2).is_err())
                .chain((changes.sides.iter().copied()).filter(|s| (s.0, s.1) == (side.0, side.1)))
                .filter(|s| s.2 != i);
            let mut others = others.map(|s| (s.3, found(s.2)));
            if let (Some((forward, (other, area))), None) = (others.next(), others.next())
                && other.wall == t.wall
                && forward != side.3
            {
                around += area;
            }
        }
        area.dot(around) < 0.0
    }
}

impl Changes {
    fn none() -> Self {
        Self {
            at: Vec::new(),
            triangles: Vec::new(),
            areas: Vec::new(),
            sides: Vec::new(),
        }
    }
}

/// Whether a contraction has taken the triangle.
fn is_gone(t: &MidTriangle) -> bool {
    let [a, b, c] = t.nodes;
    a == b || b == c || c == a
}

/// The sides of a triangle; of one that is gone there are none.
fn sides_of(t: &MidTriangle, i: u32) -> impl Iterator<Item = Side> + use<> {
    let (nodes, count) = (t.nodes, if is_gone(t) { 0 } else { 3 });
    (0..count).map(move |k| {
        let (a, b) = (nodes[k], nodes[(k + 1) % 3]);
        (a.min(b), a.max(b), i, a < b)
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geom::orient::folded;
    use crate::model::complex::MidComplex;
    use crate::stage::remesh::unfold::{apply, rings, steps};
    use crate::stage::test_shapes::{Stay, sheet};

    /// A bent plate of 12 by 12 with some nodes put where they fold it.
    fn folded_plate() -> MidComplex {
        let mut complex = sheet(12, 12, |u, v| {
            DVec3::new(12.0 * u, 12.0 * v, (4.0 * u).sin())
        });
        for (k, shift) in [(70, 1.7), (73, -1.4), (85, 2.1), (40, 1.2)] {
            complex.nodes[NodeId(k)].point.x += shift;
        }
        // One more in a triangle that is folded already, so that three go round it.
        let t = folded(&complex)[0];
        let MidTriangle {
            nodes: [a, b, c],
            wall,
        } = complex.triangles[t];
        let hub = complex.nodes.push(complex.nodes[a].clone());
        complex.nodes[hub].point += DVec3::new(0.13, 0.3, 0.1);
        complex.triangles[t].nodes = [hub, a, b];
        for nodes in [[hub, b, c], [hub, c, a]] {
            complex.triangles.push(MidTriangle { nodes, wall });
        }
        complex
    }

    /// The score of all triangles of a surface.
    fn whole(surface: &Surface) -> Score {
        let all: Vec<TriangleId> = surface.live_triangles().collect();
        let count = all.len();
        Part::new(surface, all, count).score()
    }

    #[test]
    fn what_is_bad_is_what_is_folded() {
        let complex = folded_plate();
        let surface = Surface::new(complex.clone());
        let all: Vec<TriangleId> = surface.live_triangles().collect();
        let count = all.len();
        let bad = Part::new(&surface, all, count).bad();
        assert!(bad.len() > 4);
        assert_eq!(bad, folded(&complex));
    }

    #[test]
    fn a_step_foretold_is_the_step_done() {
        let surface = Surface::new(folded_plate());
        let all: Vec<TriangleId> = surface.live_triangles().collect();
        let count = all.len();
        let part = Part::new(&surface, all, count);
        let mut kinds = [0; 4];
        for t in part.bad() {
            for step in steps(&surface, t, &Stay, &|_| true) {
                let mut done = surface.clone();
                apply(&mut done, &step);
                assert_eq!(part.after(&surface, &step), whole(&done), "{step:?}");
                kinds[match step {
                    Step::Move(_) => 0,
                    Step::Flip(..) => 1,
                    Step::Contract { .. } => 2,
                    Step::Cap(_) => 3,
                }] += 1;
            }
        }
        assert!(
            kinds[..3].iter().all(|k| *k > 4) && kinds[3] > 0,
            "{kinds:?}"
        );
    }

    #[test]
    fn a_triangle_taken_away_is_foretold_too() {
        let surface = Surface::new(folded_plate());
        let all: Vec<TriangleId> = surface.live_triangles().collect();
        let count = all.len();
        let part = Part::new(&surface, all, count);
        for t in part.bad() {
            let mut done = surface.clone();
            done.remove(t);
            assert_eq!(part.score_without(&surface, t), whole(&done));
        }
    }

    #[test]
    fn only_what_is_inside_counts() {
        let surface = Surface::new(folded_plate());
        let t = TriangleId(0);
        let near = rings(&surface, t, 1);
        let mut ids = near.clone();
        ids.extend(rings(&surface, t, 30).iter().filter(|t| !near.contains(t)));
        let part = Part::new(&surface, ids, near.len());
        assert_eq!((part.score().folds, part.bad().len()), (0, 0));
        assert!(whole(&surface).folds > 0);
    }
}
