//! Searches for a few steps that together mend a fold which no single step mends.
//!
//! Round a folded triangle a patch of some rings is cut out, and beam search looks for the shortest row of flips, contractions and moves after which fewer triangles of the
//! patch are folded; on the way there may be as many as at the start or more. The row that is found is then done on the whole surface.
//!
//! Guarantees: as of the single steps (homotopy type, feature curves, supports); what lies outside the patch is not touched, and no triangle there becomes folded.
//! Exceptions: nodes on curves, forks and corners of rims among them, may leave their place by the `nudges` of the effort a step; forks nearer to each other than the walls
//! are thick may become one.
//! Limits: no nodes are added, so a fold for which the patch has too few stays; a row that first makes matters much worse is not found.
//! Cost: `depth` times `width` states, some hundred steps each.
//!
//! Reference: B. T. Lowerre, The HARPY speech recognition system, 1976 (beam search).

use super::cones::Cone;
use super::dust::keeps_together;
use super::rate::{Part, Score};
use super::shape::area_vector;
use super::surface::Surface;
use super::unfold::{Step, apply, mergers, rings, steps};
use crate::geom::placer::Placer;
use crate::model::complex::{MidComplex, MidNode, MidTriangle, ends};
use crate::model::ids::{Id, NodeId, TriangleId};
use glam::DVec3;
use rayon::prelude::*;

/// Rings of the patch. The outermost is only looked at by its neighbours, the next two are judged, nodes within the others may move.
const RINGS: usize = 5;
/// How hard a search tries.
#[derive(Clone, Copy, Debug)]
pub(super) struct Effort {
    /// Rings of triangles that are read: the patch and the stars of its nodes. It tells the efforts apart (`tried`).
    pub reads: usize,
    /// Steps in a row, at most: bounds the cost.
    depth: usize,
    /// States that are followed at a time: bounds the cost.
    width: usize,
    /// How far a node on a curve may be nudged off it, as shares of the thickness.
    nudges: &'static [f64],
    /// How far a curve may give way where its node goes, as a share of the thickness.
    gives: f64,
}

/// Nudges stay at 4 % of R-error, where 10 % is the limit.
pub(super) const GENTLE: Effort = Effort {
    reads: RINGS + 2,
    depth: 4,
    width: 4,
    nudges: &[0.02],
    gives: 0.0,
};
/// The last resort: a solver stops on a fold, not on a curve that is off by a quarter of the thickness over one element.
pub(super) const LAST: Effort = Effort {
    reads: RINGS + 3,
    depth: 6,
    width: 24,
    nudges: &[0.02, 0.08, 0.25],
    gives: 0.25,
};
/// Lengths of single moves, as shares of the way to the neighbours.
const SHARES: [f64; 3] = [0.15, 0.4, 0.7];

/// A patch cut out, with the ids that its nodes and triangles have in the whole.
struct Patch {
    nodes: Vec<NodeId>,
    triangles: Vec<TriangleId>,
    /// #T whether the triangle is judged.
    judged: Vec<bool>,
    /// #N whether steps may change the node's star.
    free: Vec<bool>,
}

#[derive(Clone)]
struct State {
    surface: Surface,
    path: Vec<Step>,
    score: Score,
}

/// Mends a folded triangle by several steps; whether it was mended.
pub(super) fn search(
    surface: &mut Surface,
    t: TriangleId,
    effort: &Effort,
    placer: &dyn Placer,
) -> bool {
    let (patch, local) = cut_out(surface, t);
    let start = patch.part(&local).score();
    let state = State {
        surface: local,
        path: Vec::new(),
        score: start,
    };
    let Some(path) = best_path(&patch, state, start, effort, placer) else {
        return false;
    };
    for step in path {
        apply(surface, &patch.outside(step));
    }
    true
}

fn best_path(
    patch: &Patch,
    state: State,
    start: Score,
    effort: &Effort,
    placer: &dyn Placer,
) -> Option<Vec<Step>> {
    let mut beam = vec![state];
    let mut found: Option<State> = None;
    for _ in 0..effort.depth {
        let parts: Vec<Part> = (beam.iter()).map(|s| patch.part(&s.surface)).collect();
        let folds: Vec<(usize, TriangleId)> = (parts.iter().enumerate())
            .flat_map(|(i, part)| part.bad().into_iter().map(move |t| (i, t)))
            .collect();
        let steps: Vec<(usize, Step)> = (folds.par_iter())
            .flat_map_iter(|&(i, t)| {
                let steps = patch.steps(&beam[i].surface, t, effort, placer);
                steps.into_iter().map(move |step| (i, step))
            })
            .collect();
        let mut next: Vec<(Score, usize, Step)> = (steps.into_par_iter())
            .map(|(i, step)| (parts[i].after(&beam[i].surface, &step), i, step))
            .collect();
        // The sort is stable, so the order of the steps decides between equals.
        next.sort_by(|a, b| order(&a.0, &b.0));
        // The same outcome by another way is no other state.
        next.dedup_by(|a, b| order(&a.0, &b.0).is_eq());
        next.truncate(effort.width);
        beam = (next.into_iter())
            .map(|(score, i, step)| {
                let mut state = beam[i].clone();
                apply(&mut state.surface, &step);
                state.path.push(step);
                state.score = score;
                state
            })
            .collect();
        let Some(best) = beam.first() else { break };
        let least = found.as_ref().map_or(start.folds, |f| f.score.folds);
        if best.score.folds < least {
            found = Some(best.clone());
        }
        if best.score.folds == 0 {
            break;
        }
    }
    found.map(|f| f.path)
}

/// Fewer folds first, then smaller ones, then better shapes.
fn order(a: &Score, b: &Score) -> std::cmp::Ordering {
    (a.folds.cmp(&b.folds))
        .then(a.folded_area.total_cmp(&b.folded_area))
        .then(b.least.total_cmp(&a.least))
}

fn cut_out(surface: &Surface, t: TriangleId) -> (Patch, Surface) {
    let triangles = rings(surface, t, RINGS);
    let judged = rings(surface, t, RINGS - 1);
    let inner = rings(surface, t, RINGS - 2);
    let mut nodes: Vec<NodeId> = (triangles.iter())
        .flat_map(|&t| surface.triangle(t).nodes)
        .collect();
    nodes.sort_unstable();
    nodes.dedup();
    let mut complex = MidComplex::default();
    for &n in &nodes {
        complex.nodes.push(MidNode {
            point: surface.points[n],
            supports: surface.supports[n].clone(),
        });
    }
    let number = |n: NodeId| NodeId::new(nodes.partition_point(|m| *m < n));
    for &t in &triangles {
        let MidTriangle { nodes, wall } = surface.triangle(t);
        complex.triangles.push(MidTriangle {
            nodes: nodes.map(number),
            wall,
        });
    }
    let held = |n: &NodeId| (surface.star(*n).iter()).all(|t| inner.binary_search(t).is_ok());
    let patch = Patch {
        free: nodes.iter().map(held).collect(),
        judged: (triangles.iter())
            .map(|t| judged.binary_search(t).is_ok())
            .collect(),
        nodes,
        triangles,
    };
    (patch, Surface::new(complex))
}

impl Patch {
    /// What is left of the patch, the triangles that are judged first.
    fn part(&self, surface: &Surface) -> Part {
        let (mut ids, others): (Vec<TriangleId>, Vec<TriangleId>) =
            (surface.live_triangles()).partition(|t| self.judged[t.index()]);
        let inside = ids.len();
        ids.extend(others);
        Part::new(surface, ids, inside)
    }

    fn is_free(&self, n: NodeId) -> bool {
        self.free[n.index()]
    }

    fn steps(
        &self,
        surface: &Surface,
        t: TriangleId,
        effort: &Effort,
        placer: &dyn Placer,
    ) -> Vec<Step> {
        if !self.judged[t.index()] {
            return Vec::new();
        }
        let mut all = steps(surface, t, placer, &|n| self.is_free(n));
        all.extend(mergers(surface, t, placer));
        let free = |n| self.is_free(n);
        all.extend(single_moves(surface, t, effort, placer, &free));
        if effort.gives > 0.0 {
            all.extend(crushes(surface, t, effort, placer));
        }
        all.retain(|step| match step {
            Step::Move(places) => places.iter().all(|(n, _)| self.is_free(*n)),
            Step::Flip([a, b], [s, u]) => {
                let ends = [*a, *b, surface.apex(*s, *a, *b), surface.apex(*u, *a, *b)];
                ends.iter().all(|n| self.is_free(*n))
            }
            Step::Contract { gone, kept } => self.is_free(*gone) && self.is_free(*kept),
            Step::Cap(cone) => self.is_free(cone.hub) && cone.base.iter().all(|n| self.is_free(*n)),
        });
        all
    }

    /// A step with the ids of the whole surface.
    fn outside(&self, step: Step) -> Step {
        let node = |n: NodeId| self.nodes[n.index()];
        match step {
            Step::Move(places) => Step::Move(places.iter().map(|(n, p)| (node(*n), *p)).collect()),
            Step::Flip(edge, pair) => {
                Step::Flip(edge.map(node), pair.map(|t| self.triangles[t.index()]))
            }
            Step::Cap(cone) => Step::Cap(Cone {
                hub: node(cone.hub),
                triangles: cone.triangles.map(|t| self.triangles[t.index()]),
                base: cone.base.map(node),
            }),
            Step::Contract { gone, kept } => Step::Contract {
                gone: node(gone),
                kept: node(kept),
            },
        }
    }
}

/// Moves of one node of the triangle or of a triangle beside it: towards each neighbour or away from it on its supports; on a curve a nudge as well.
fn single_moves(
    surface: &Surface,
    t: TriangleId,
    effort: &Effort,
    placer: &dyn Placer,
    may_move: &dyn Fn(NodeId) -> bool,
) -> Vec<Step> {
    let mut moving: Vec<NodeId> = surface.triangle(t).nodes.to_vec();
    let own = surface.triangle(t).nodes;
    for k in 0..3 {
        let (a, b) = (own[k], own[(k + 1) % 3]);
        moving.extend(surface.around(a, b).iter().map(|&s| surface.apex(s, a, b)));
    }
    moving.sort_unstable();
    moving.dedup();
    let mut all = Vec::new();
    for n in moving.into_iter().filter(|n| may_move(*n)) {
        let p = surface.points[n];
        let curve = surface.feature_neighbours(n);
        let slides = match curve.len() {
            0 => true,
            2 => ends(&surface.supports[n]).count() < 2,
            _ => false,
        };
        if slides {
            let near: Vec<NodeId> = if curve.is_empty() {
                surface.neighbours(n).to_vec()
            } else {
                curve.to_vec()
            };
            for m in near {
                for share in SHARES {
                    for sign in [1.0, -0.5] {
                        let to = p + (surface.points[m] - p) * (sign * share);
                        let place = placer.place(to, &surface.supports[n]);
                        if place.is_finite() {
                            all.push(Step::Move(vec![(n, place)]));
                        }
                    }
                }
            }
        }
        let thickness = placer.thickness(p, surface.triangle(t).wall);
        let thickness = thickness.map_or(0.0, f64::abs);
        for way in nudges(surface, t, n)
            .into_iter()
            .filter(|_| thickness > 0.0)
        {
            let nudged = |share: &f64| Step::Move(vec![(n, p + way * share * thickness)]);
            all.extend(effort.nudges.iter().map(nudged));
        }
    }
    all
}

/// Contractions at the triangle, whatever curves the two nodes lie on, as long as these give way by little.
fn crushes(surface: &Surface, t: TriangleId, effort: &Effort, placer: &dyn Placer) -> Vec<Step> {
    let mut edges: Vec<[NodeId; 2]> = (surface.triangle(t).nodes.iter())
        .flat_map(|&n| (surface.neighbours(n).into_iter()).map(move |m| [n.min(m), n.max(m)]))
        .collect();
    edges.sort_unstable();
    edges.dedup();
    let mut all = Vec::new();
    for [a, b] in edges {
        let wall = surface
            .around(a, b)
            .first()
            .map(|&s| surface.triangle(s).wall);
        let thickness = wall.and_then(|w| placer.thickness(surface.points[a], w));
        let least = thickness.map_or(0.0, f64::abs) * effort.gives;
        if surface.length(a, b) > least {
            continue;
        }
        for (gone, kept) in [(a, b), (b, a)] {
            if keeps_together(surface, gone, kept) {
                all.push(Step::Contract { gone, kept });
            }
        }
    }
    all
}

/// Unit directions of nudges: along the sides of the triangle, and square to these in its plane.
fn nudges(surface: &Surface, t: TriangleId, n: NodeId) -> Vec<DVec3> {
    if surface.feature_neighbours(n).is_empty() {
        return Vec::new();
    }
    let p = surface.corners(t);
    let normal = area_vector(p).normalize_or_zero();
    (0..3)
        .flat_map(|k| {
            let side = (p[(k + 1) % 3] - p[k]).normalize_or_zero();
            let across = normal.cross(side);
            [side, -side, across, -across]
        })
        .filter(|d| *d != DVec3::ZERO)
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geom::orient::folded;
    use crate::model::complex::Support;
    use crate::model::ids::WallId;
    use crate::stage::test_shapes::{Stay, sheet};

    /// Walls of thickness 1 wherever asked.
    struct Thick;

    impl Placer for Thick {
        fn place(&self, start: DVec3, _: &[Support]) -> DVec3 {
            start
        }
        fn normal(&self, _: DVec3, _: WallId) -> Option<DVec3> {
            None
        }
        fn thickness(&self, _: DVec3, _: WallId) -> Option<f64> {
            Some(1.0)
        }
        fn curvature_radius(&self, _: DVec3, _: WallId) -> f64 {
            f64::INFINITY
        }
    }

    /// A plate of 16 by 16 in which the nodes of a row have changed places in pairs.
    fn crossed() -> MidComplex {
        let mut complex = sheet(16, 16, |u, v| DVec3::new(16.0 * u, 16.0 * v, 0.0));
        let at = |complex: &MidComplex, x: f64, y: f64| {
            let is = |n: &NodeId| complex.nodes[*n].point.distance(DVec3::new(x, y, 0.0)) < 1e-9;
            complex.nodes.ids().find(is).unwrap()
        };
        let (n, m) = (at(&complex, 7.0, 8.0), at(&complex, 9.0, 8.0));
        let p = complex.nodes[n].point;
        complex.nodes[n].point = complex.nodes[m].point;
        complex.nodes[m].point = p;
        complex
    }

    #[test]
    fn crossed_nodes_are_parted_and_what_is_far_stays() {
        let before = crossed();
        let bad = folded(&before);
        assert!(bad.len() > 1);
        let mut surface = Surface::new(before.clone());
        assert!(search(&mut surface, bad[0], &GENTLE, &Thick));
        let far: Vec<NodeId> = (before.nodes.enumerated())
            .filter(|(_, n)| (n.point - DVec3::new(8.0, 8.0, 0.0)).abs().max_element() > 6.0)
            .map(|x| x.0)
            .collect();
        assert!(far.len() > 50);
        assert!(
            far.iter()
                .all(|&n| surface.points[n] == before.nodes[n].point)
        );
        let after = surface.finish();
        assert!(folded(&after).len() < bad.len());
        assert_eq!((after.euler(), after.pieces()), (before.euler(), 1));
        assert!(after.check().is_empty());
    }

    #[test]
    fn nothing_is_done_where_nothing_is_folded() {
        let before = sheet(8, 8, |u, v| DVec3::new(8.0 * u, 8.0 * v, 0.0));
        let mut surface = Surface::new(before.clone());
        assert!(!search(&mut surface, TriangleId(60), &LAST, &Thick));
        assert_eq!(surface.finish(), before);
    }

    /// Two curves of three walls each along x, `width` apart, with a strip of wall 0 between them.
    fn two_curves(width: f64) -> MidComplex {
        let mut complex = MidComplex::default();
        for i in 0..5 {
            for (y, z) in [
                (0.0, 0.0),
                (width, 0.0),
                (-3.0, 3.0),
                (-3.0, -3.0),
                (3.0, 3.0),
                (3.0, -3.0),
            ] {
                complex.nodes.push(MidNode {
                    point: DVec3::new(f64::from(i), y, z),
                    supports: Default::default(),
                });
            }
        }
        for i in 0..4 {
            for (wall, a, b) in [(0, 0, 1), (1, 0, 2), (2, 0, 3), (3, 1, 4), (4, 1, 5)] {
                let [p, q, r, s] = [6 * i + a, 6 * i + b, 6 * i + 6 + a, 6 * i + 6 + b].map(NodeId);
                for nodes in [[p, q, s], [p, s, r]] {
                    complex.triangles.push(MidTriangle {
                        nodes,
                        wall: WallId(wall),
                    });
                }
            }
        }
        complex
    }

    #[test]
    fn curves_nearer_than_the_walls_are_thick_may_become_one_and_others_not() {
        let across = |width: f64, placer: &dyn Placer| {
            let surface = Surface::new(two_curves(width));
            let strip = (surface.live_triangles())
                .filter(|&t| surface.triangle(t).wall == WallId(0))
                .nth(3);
            mergers(&surface, strip.unwrap(), placer)
                .into_iter()
                .filter(|step| {
                    matches!(step, Step::Contract { gone, kept }
                        if surface.points[*gone].x == surface.points[*kept].x)
                })
                .count()
        };
        assert_eq!(across(0.5, &Thick), 2, "either way round");
        assert_eq!(across(1.5, &Thick), 0);
        // Without a thickness nothing says what is near.
        assert_eq!(across(0.5, &Stay), 0);
    }
}
