//! Unfolds what is still folded in a finished mesh, place by place.
//!
//! A triangle that lies against its neighbours, or has no area, gets the one step that leaves the fewest of its kind round about: its nodes and those beside them are
//! relaxed, one of its edges is flipped or contracted. Each place is judged for itself: a stubborn one does not keep the others from being mended.
//!
//! Guarantees: homotopy type and feature curves stay (contraction under the link condition, along curves only where these are straight); ends and forks of curves and
//! corners of rims stay; moved nodes are put onto their supports; nowhere do folds become more, nor needles of folded triangles.
//! Limits: folds over which the curves themselves cross stay. Cost: linear in the number of folded triangles, some thousand operations each.

use super::contract::keeps_homotopy;
use super::shape::{area_vector, distance_to_segment, quality};
use super::surface::Surface;
use crate::geom::orient::orient;
use crate::geom::placer::Placer;
use crate::model::complex::{MidComplex, MidTriangle, faces};
use crate::model::ids::{NodeId, TriangleId};
use glam::DVec3;

/// Passes; mending one place may open the way at the next.
const PASSES: usize = 8;
/// Rings of triangles that a step may change, with those whose neighbours it changes.
const RINGS: usize = 3;
/// A triangle this low, as a share of its longest side, has no area: far above the rounding of coordinates, far below a poor shape.
const FLAT: f64 = 1e-6;
/// A step leaves no triangle worse than this (a needle of 1 : 40), unless there was a worse one.
const LEAST_QUALITY: f64 = 0.05;
/// Where a step leaves as many folds, these must become smaller by this share.
const GAIN: f64 = 0.9;
/// A curve node may go where the curve then passes it by within this share of the new edge: half the sag of a circle of ten edges.
const STRAIGHT: f64 = 0.1;
/// Steps of a relaxation, the number after which a star of nodes has settled.
const RELAXATIONS: [usize; 3] = [1, 3, 8];

/// A complex in which as many folds as possible are gone. Its triangles come out wound sheet by sheet.
pub fn unfold(mut complex: MidComplex, placer: &dyn Placer) -> MidComplex {
    orient(&mut complex, placer);
    let mut surface = Surface::new(complex);
    for _ in 0..PASSES {
        let all: Vec<TriangleId> = surface.live_triangles().collect();
        let bad = Part::new(&surface, all.clone(), all.len()).bad(&surface);
        let mut mended = false;
        for t in bad {
            if surface.lives(t) {
                mended |= mend(&mut surface, t, placer);
            }
        }
        if !mended {
            break;
        }
    }
    surface.finish()
}

/// A step that may mend.
#[derive(Clone, Debug)]
enum Step {
    Move(Vec<(NodeId, DVec3)>),
    Flip([NodeId; 2], [TriangleId; 2]),
    Contract { gone: NodeId, kept: NodeId },
}

/// How bad a part is.
#[derive(Clone, Copy, Debug)]
struct Score {
    folds: usize,
    area: f64,
    least: f64,
}

fn mend(surface: &mut Surface, t: TriangleId, placer: &dyn Placer) -> bool {
    let near = rings(surface, t, RINGS);
    let inside = near.len();
    let part = Part::new(surface, with_neighbours(surface, near), inside);
    let before = part.score(surface);
    if before.folds == 0 {
        return false;
    }
    let best = steps(surface, t, placer)
        .into_iter()
        .map(|step| (part.after(surface, &step), step))
        .filter(|(after, _)| {
            let fewer = after.folds < before.folds
                || after.folds == before.folds && after.area < GAIN * before.area;
            fewer && after.least >= LEAST_QUALITY.min(before.least)
        })
        .min_by(|(x, _), (y, _)| {
            (x.folds.cmp(&y.folds)).then(y.least.total_cmp(&x.least))
        });
    let Some((_, step)) = best else {
        return false;
    };
    match step {
        Step::Move(places) => {
            for (n, p) in places {
                surface.points[n] = p;
            }
        }
        Step::Flip(edge, pair) => surface.flip(edge, pair),
        Step::Contract { gone, kept } => surface.contract(gone, kept),
    }
    true
}

/// The steps that could mend a triangle and are allowed.
fn steps(surface: &Surface, t: TriangleId, placer: &dyn Placer) -> Vec<Step> {
    let nodes = surface.triangle(t).nodes;
    let mut steps = Vec::new();
    let mut wide: Vec<NodeId> = nodes.to_vec();
    wide.extend(nodes.iter().flat_map(|&n| surface.neighbours(n)));
    wide.sort_unstable();
    wide.dedup();
    for moving in [&nodes[..1], &nodes[1..2], &nodes[2..], &nodes[..], &wide] {
        for count in RELAXATIONS {
            steps.extend(relaxed(surface, moving, count, placer).map(Step::Move));
        }
    }
    for k in 0..3 {
        let (a, b) = (nodes[k], nodes[(k + 1) % 3]);
        if let &[s, u] = surface.around(a, b).as_slice()
            && surface.triangle(s).wall == surface.triangle(u).wall
        {
            let (c, d) = (surface.apex(s, a, b), surface.apex(u, a, b));
            if c != d && surface.around(c, d).is_empty() {
                steps.push(Step::Flip([a, b], [s, u]));
            }
        }
        for (gone, kept) in [(a, b), (b, a)] {
            if may_go(surface, gone, kept) {
                steps.push(Step::Contract { gone, kept });
            }
        }
    }
    steps
}

/// Neighbours between which a node may be moved: all of a sheet node, the two on a curve that does not bend much there.
fn between(surface: &Surface, n: NodeId) -> Vec<NodeId> {
    match *surface.feature_neighbours(n) {
        [] => surface.neighbours(n).to_vec(),
        [a, b] if faces(&surface.supports[n]).count() < 2 && passes_by(surface, n, a, b) => {
            vec![a, b]
        }
        _ => Vec::new(),
    }
}

fn passes_by(surface: &Surface, n: NodeId, a: NodeId, b: NodeId) -> bool {
    let [p, a, b] = [n, a, b].map(|m| surface.points[m]);
    distance_to_segment(p, a, b) <= STRAIGHT * a.distance(b)
}

/// Where the nodes come to lie after so many steps towards the middle of their neighbours.
fn relaxed(
    surface: &Surface,
    moving: &[NodeId],
    count: usize,
    placer: &dyn Placer,
) -> Option<Vec<(NodeId, DVec3)>> {
    let free: Vec<(NodeId, Vec<NodeId>)> = moving
        .iter()
        .map(|&n| (n, between(surface, n)))
        .filter(|(_, near)| !near.is_empty())
        .collect();
    let mut places: Vec<DVec3> = free.iter().map(|&(n, _)| surface.points[n]).collect();
    for _ in 0..count {
        for i in 0..free.len() {
            let (n, near) = &free[i];
            let at = |m: &NodeId| {
                let own = free.iter().position(|(f, _)| f == m);
                own.map_or(surface.points[*m], |k| places[k])
            };
            let middle = near.iter().map(at).sum::<DVec3>() / near.len() as f64;
            places[i] = placer.draw(middle, &surface.supports[*n]);
        }
    }
    let settled: Vec<(NodeId, DVec3)> = free
        .iter()
        .zip(places)
        .map(|((n, _), p)| (*n, placer.place(p, &surface.supports[*n])))
        .collect();
    let sound = !settled.is_empty() && settled.iter().all(|(_, p)| p.is_finite());
    sound.then_some(settled)
}

fn may_go(surface: &Surface, gone: NodeId, kept: NodeId) -> bool {
    let near = surface.feature_neighbours(gone);
    let strata = match *near {
        [] => true,
        [a, b] if a == kept || b == kept => {
            let far = if a == kept { b } else { a };
            faces(&surface.supports[gone]).count() < 2
                && passes_by(surface, gone, kept, far)
                && !surface.feature_neighbours(kept).contains(&far)
        }
        _ => false,
    };
    strata && keeps_homotopy(surface, gone, kept)
}

/// The triangles within some rings of a triangle, sorted.
fn rings(surface: &Surface, t: TriangleId, count: usize) -> Vec<TriangleId> {
    let mut all = vec![t];
    for _ in 0..count {
        all = with_ring(surface, &all);
    }
    all
}

fn with_ring(surface: &Surface, triangles: &[TriangleId]) -> Vec<TriangleId> {
    let mut nodes: Vec<NodeId> = (triangles.iter())
        .flat_map(|&t| surface.triangle(t).nodes)
        .collect();
    nodes.sort_unstable();
    nodes.dedup();
    let mut all: Vec<TriangleId> = (nodes.iter())
        .flat_map(|&n| surface.star(n).iter().copied())
        .collect();
    all.sort_unstable();
    all.dedup();
    all
}

/// The triangles, then all that touch them.
fn with_neighbours(surface: &Surface, mut triangles: Vec<TriangleId>) -> Vec<TriangleId> {
    let more = with_ring(surface, &triangles);
    let inside = triangles.len();
    for t in more {
        if triangles[..inside].binary_search(&t).is_err() {
            triangles.push(t);
        }
    }
    triangles
}

/// Some triangles, of which the first `inside` are judged.
struct Part {
    ids: Vec<TriangleId>,
    triangles: Vec<MidTriangle>,
    inside: usize,
}

impl Part {
    fn new(surface: &Surface, ids: Vec<TriangleId>, inside: usize) -> Self {
        let triangles = ids.iter().map(|&t| surface.triangle(t)).collect();
        Self {
            ids,
            triangles,
            inside,
        }
    }

    fn bad(&self, surface: &Surface) -> Vec<TriangleId> {
        judge(&self.triangles, &|n| surface.points[n])
            .into_iter()
            .zip(&self.ids)
            .filter(|(bad, _)| *bad)
            .map(|(_, &t)| t)
            .collect()
    }

    fn score(&self, surface: &Surface) -> Score {
        self.rate(&self.triangles, &|n| surface.points[n])
    }

    fn after(&self, surface: &Surface, step: &Step) -> Score {
        let mut triangles = self.triangles.clone();
        match step {
            Step::Move(places) => {
                return self.rate(&triangles, &|n| {
                    let moved = places.iter().find(|(m, _)| *m == n);
                    moved.map_or(surface.points[n], |m| m.1)
                });
            }
            Step::Flip(edge, pair) => {
                let new = surface.flipped(*edge, *pair);
                for (t, nodes) in pair.iter().zip(new) {
                    if let Some(at) = self.ids.iter().position(|s| s == t) {
                        triangles[at].nodes = nodes;
                    }
                }
            }
            Step::Contract { gone, kept } => {
                for t in &mut triangles {
                    t.nodes = t.nodes.map(|n| if n == *gone { *kept } else { n });
                }
            }
        }
        self.rate(&triangles, &|n| surface.points[n])
    }

    fn rate(&self, triangles: &[MidTriangle], at: &dyn Fn(NodeId) -> DVec3) -> Score {
        let mut score = Score {
            folds: 0,
            area: 0.0,
            least: f64::INFINITY,
        };
        let bad = judge(triangles, at);
        for (t, bad) in triangles[..self.inside].iter().zip(bad) {
            if is_gone(t) {
                continue;
            }
            let p = t.nodes.map(at);
            score.least = score.least.min(quality(p));
            if bad {
                score.folds += 1;
                score.area += area_vector(p).length();
            }
        }
        score
    }
}

/// Whether a contraction has taken the triangle.
fn is_gone(t: &MidTriangle) -> bool {
    let [a, b, c] = t.nodes;
    a == b || b == c || c == a
}

/// Which triangles have no area or lie against all their neighbours in the sheet taken together.
fn judge(triangles: &[MidTriangle], at: &dyn Fn(NodeId) -> DVec3) -> Vec<bool> {
    let mut sides: Vec<(NodeId, NodeId, usize, bool)> = Vec::with_capacity(3 * triangles.len());
    let mut areas = Vec::with_capacity(triangles.len());
    for (i, t) in triangles.iter().enumerate() {
        areas.push(area_vector(t.nodes.map(at)));
        if is_gone(t) {
            continue;
        }
        for k in 0..3 {
            let (a, b) = (t.nodes[k], t.nodes[(k + 1) % 3]);
            sides.push((a.min(b), a.max(b), i, a < b));
        }
    }
    sides.sort_unstable();
    let mut around = vec![DVec3::ZERO; triangles.len()];
    for run in sides.chunk_by(|a, b| (a.0, a.1) == (b.0, b.1)) {
        if let [a, b] = run
            && triangles[a.2].wall == triangles[b.2].wall
            && a.3 != b.3
        {
            around[a.2] += areas[b.2];
            around[b.2] += areas[a.2];
        }
    }
    (triangles.iter().enumerate())
        .map(|(i, t)| {
            let [a, b, c] = t.nodes.map(at);
            let longest = a.distance_squared(b).max(b.distance_squared(c)).max(c.distance_squared(a));
            !is_gone(t)
                && (areas[i].length() <= FLAT * longest || areas[i].dot(around[i]) < 0.0)
        })
        .collect()
}
