//! Searches for a few steps that together mend a fold which no single step mends.
//!
//! Round a folded triangle a patch of some rings is cut out, and beam search looks for the shortest row of flips, contractions and moves after which fewer triangles of the
//! patch are folded; on the way there may be as many as at the start or more. The row that is found is then done on the whole surface.
//!
//! Guarantees: as of the single steps (homotopy type, feature curves, supports); what lies outside the patch is not touched, and no triangle there becomes folded.
//! Exception: nodes that no step may move otherwise (forks, corners of rims) may leave their place by `NUDGE` of the thickness.
//! Cost: `DEPTH` times `WIDTH` states, some hundred steps each.
//!
//! Reference: B. T. Lowerre, The HARPY speech recognition system, 1976 (beam search).

use super::shape::area_vector;
use super::surface::Surface;
use super::unfold::{Part, Score, Step, apply, mergers, rings, steps};
use crate::geom::placer::Placer;
use crate::model::complex::{MidComplex, MidNode, MidTriangle, faces};
use crate::model::ids::{Id, NodeId, TriangleId};
use glam::DVec3;

/// Rings of the patch. The outermost is only looked at by its neighbours, the next two are judged, nodes within the others may move.
const RINGS: usize = 5;
/// Steps in a row: a knot of one place comes apart in two or three; more of them is another place's business.
const DEPTH: usize = 5;
/// States that are followed at a time: with three, half of what six mend stays folded.
const WIDTH: usize = 6;
/// How far a node without freedom may go, as a share of the thickness: a tenth of what an R-error of 10 % allows.
const NUDGE: f64 = 0.02;
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
pub(super) fn search(surface: &mut Surface, t: TriangleId, placer: &dyn Placer) -> bool {
    let (patch, local) = cut_out(surface, t);
    let start = patch.part(&local).score(&local);
    let state = State {
        surface: local,
        path: Vec::new(),
        score: start,
    };
    let Some(path) = best_path(&patch, state, start, placer) else {
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
    placer: &dyn Placer,
) -> Option<Vec<Step>> {
    let mut beam = vec![state];
    let mut found: Option<State> = None;
    for _ in 0..DEPTH {
        let mut next: Vec<(Score, usize, Step)> = Vec::new();
        for (i, state) in beam.iter().enumerate() {
            let part = patch.part(&state.surface);
            for t in part.bad(&state.surface) {
                for step in patch.steps(&state.surface, t, placer) {
                    next.push((part.after(&state.surface, &step), i, step));
                }
            }
        }
        // The sort is stable, so the order of the steps decides between equals.
        next.sort_by(|a, b| order(&a.0, &b.0));
        // The same outcome by another way is no other state.
        next.dedup_by(|a, b| order(&a.0, &b.0).is_eq());
        next.truncate(WIDTH);
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
        .then(a.folded_area().total_cmp(&b.folded_area()))
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

    fn steps(&self, surface: &Surface, t: TriangleId, placer: &dyn Placer) -> Vec<Step> {
        if !self.judged[t.index()] {
            return Vec::new();
        }
        let mut all = steps(surface, t, placer);
        all.extend(mergers(surface, t, placer));
        all.extend(single_moves(surface, t, placer));
        all.retain(|step| match step {
            Step::Move(places) => places.iter().all(|(n, _)| self.is_free(*n)),
            Step::Flip([a, b], [s, u]) => {
                let ends = [*a, *b, surface.apex(*s, *a, *b), surface.apex(*u, *a, *b)];
                ends.iter().all(|n| self.is_free(*n))
            }
            Step::Contract { gone, kept } => self.is_free(*gone) && self.is_free(*kept),
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
            Step::Contract { gone, kept } => Step::Contract {
                gone: node(gone),
                kept: node(kept),
            },
        }
    }
}

/// Moves of one node of the triangle or of a triangle beside it: towards each neighbour or away from it on its supports, or, where it has no freedom, by a nudge.
fn single_moves(surface: &Surface, t: TriangleId, placer: &dyn Placer) -> Vec<Step> {
    let mut moving: Vec<NodeId> = surface.triangle(t).nodes.to_vec();
    let own = surface.triangle(t).nodes;
    for k in 0..3 {
        let (a, b) = (own[k], own[(k + 1) % 3]);
        moving.extend(surface.around(a, b).iter().map(|&s| surface.apex(s, a, b)));
    }
    moving.sort_unstable();
    moving.dedup();
    let mut all = Vec::new();
    for n in moving {
        let p = surface.points[n];
        let curve = surface.feature_neighbours(n);
        let slides = match curve.len() {
            0 => true,
            2 => faces(&surface.supports[n]).count() < 2,
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
        let reach = NUDGE * thickness.map_or(0.0, f64::abs);
        for way in nudges(surface, t, n).into_iter().filter(|_| reach > 0.0) {
            all.push(Step::Move(vec![(n, p + way * reach)]));
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
