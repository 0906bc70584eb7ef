//! Unfolds what is still folded in a finished mesh, place by place.
//!
//! A triangle that lies against its neighbours, or has no area, gets the one step that leaves the fewest of its kind round about: its nodes and those beside them are
//! relaxed, an edge there is flipped or contracted, three triangles round a node become one (`cones`), or, where nothing else helps, a small flap folded back from a free border is taken off. Each place is judged for itself: a stubborn one does not keep the others from being mended.
//!
//! Guarantees: homotopy type, pieces and feature curves stay (contraction under the link condition, along curves only where these are straight); ends and forks of curves and
//! corners of rims stay; moved nodes are put onto their supports; nowhere do folds become more, nor needles of folded triangles.
//! Exceptions, where nothing else mends a fold: a needle may be left, and forks nearer to each other than the walls are thick become one.
//! What no single step mends is cut out and filled anew (`refill`), or left to `search`, which tries several in a row.
//! Limits: folds over which the curves themselves cross stay. Cost: linear in the number of folded triangles, some thousand operations each.

use super::cones::{Cone, cones};
use super::dust::keeps_together;
use super::flat::{hinges, remove_flat};
use super::rate::{FLAT, Part, Score};
use super::refill::{READ as READ_BY_REFILL, refill};
use super::search::{GENTLE, LAST, search};
use super::shape::{area_vector, distance_to_segment};
use super::surface::Surface;
use super::tried::Tried;
use crate::geom::orient::orient;
use crate::geom::placer::Placer;
use crate::model::complex::{MidComplex, ends};
use crate::model::ids::{NodeId, TriangleId};
use glam::DVec3;
use rayon::prelude::*;

/// Passes; mending one place may open the way at the next.
const PASSES: usize = 8;
/// Rings of triangles that a step may change, with those whose neighbours it changes.
const RINGS: usize = 4;
/// What [`mend`] reads: those and the triangles beside them, with their nodes' stars.
const READ_BY_MEND: usize = RINGS + 2;
/// A step leaves no triangle worse than this (a needle of 1 : 40), unless there was a worse one.
const LEAST_QUALITY: f64 = 0.05;
/// Where a step leaves as many folds, these must become smaller by this share of the triangle to be mended.
const GAIN: f64 = 0.1;
/// A curve node may go where the curve then passes it by within this share of the new edge: half the sag of a circle of ten edges.
const STRAIGHT: f64 = 0.1;
/// Nor does it show where the curve passes it by within this share of the thickness.
const THIN: f64 = 0.1;
/// Rows of steps are searched for where no more folds than this are left: it takes up to seconds a fold, and with many left the mesh stays doubted.
const FEW: usize = 24;
/// Steps of a relaxation, from one to the number after which a star of nodes has settled; rising.
const RELAXATIONS: [usize; 3] = [1, 3, 8];

/// A complex in which as many folds as possible are gone. Its triangles come out wound sheet by sheet.
pub fn unfold(mut complex: MidComplex, placer: &dyn Placer) -> MidComplex {
    orient(&mut complex, placer);
    let mut surface = Surface::new(complex);
    let pieces = surface.pieces();
    let mut tried = Tried::default();
    for _ in 0..PASSES {
        let before = surface.clone();
        let mut mended = pass(&mut surface, placer, &mut tried, None);
        if surface.pieces() != pieces {
            // One step has parted sheets that met in a curve: only that one is to be left out.
            surface = before;
            mended = pass(&mut surface, placer, &mut tried, Some(pieces));
        }
        if !mended {
            break;
        }
    }
    surface.finish()
}

/// One look at every fold; whether one was mended. Where a number of pieces is given, what changes it is taken back.
fn pass(
    surface: &mut Surface,
    placer: &dyn Placer,
    tried: &mut Tried,
    pieces: Option<usize>,
) -> bool {
    let attempt = |surface: &mut Surface, change: &mut dyn FnMut(&mut Surface) -> bool| {
        let Some(pieces) = pieces else {
            return change(surface);
        };
        let mut changed = surface.clone();
        let taken = change(&mut changed) && changed.pieces() == pieces;
        if taken {
            *surface = changed;
        }
        taken
    };
    // A fold that was pressed flat has become a cap.
    attempt(surface, &mut |s| {
        remove_flat(s, placer);
        true
    });
    let all: Vec<TriangleId> = surface.live_triangles().collect();
    let bad = Part::new(surface, all.clone(), all.len()).bad();
    let mut mended = false;
    for &t in &bad {
        if surface.lives(t) {
            mended |= attempt(surface, &mut |s| {
                tried.unless_in_vain(s, (t, READ_BY_MEND), |s| mend(s, t, placer))
            });
        }
    }
    if !mended {
        for &t in &bad {
            if surface.lives(t) {
                mended |= attempt(surface, &mut |s| {
                    tried.unless_in_vain(s, (t, READ_BY_REFILL), |s| refill(s, t, placer))
                });
            }
        }
    }
    for effort in [&GENTLE, &LAST] {
        if !mended && bad.len() <= FEW {
            for &t in &bad {
                if surface.lives(t) {
                    mended |= attempt(surface, &mut |s| {
                        tried.unless_in_vain(s, (t, effort.reads), |s| search(s, t, effort, placer))
                    });
                }
            }
        }
    }
    mended
}

/// A step that may mend.
#[derive(Clone, Debug)]
pub(super) enum Step {
    Move(Vec<(NodeId, DVec3)>),
    Flip([NodeId; 2], [TriangleId; 2]),
    Contract { gone: NodeId, kept: NodeId },
    Cap(Cone),
}

fn mend(surface: &mut Surface, t: TriangleId, placer: &dyn Placer) -> bool {
    let near = rings(surface, t, RINGS);
    let inside = near.len();
    let part = Part::new(surface, with_neighbours(surface, near), inside);
    let before = part.score();
    if before.folds == 0 {
        return false;
    }
    let own = area_vector(surface.corners(t)).length();
    let rated = |steps: Vec<Step>| -> Vec<(Score, Step)> {
        let rate = |step: Step| (part.after(surface, &step), step);
        steps.into_par_iter().map(rate).collect()
    };
    let mut all = rated(steps(surface, t, placer, &|_| true));
    let gentle = best(&all, &|after| {
        let fewer = after.folds < before.folds
            || after.folds == before.folds && after.folded_area < before.folded_area - GAIN * own;
        fewer && after.least >= LEAST_QUALITY.min(before.least)
    });
    let best = gentle.or_else(|| {
        // A solver stops on a fold, not on a needle; what is pressed flat is taken away by the next pass.
        all.extend(rated(mergers(surface, t, placer)));
        best(&all, &|after| {
            after.folds < before.folds
                || after.folds == before.folds
                    && after.folded_area <= before.folded_area - (1.0 - FLAT) * own
        })
    });
    let Some(step) = best else {
        let goes =
            part.score_without(surface, t).folds < before.folds && is_flap(surface, t, placer);
        if goes {
            surface.remove(t);
        }
        return goes;
    };
    apply(surface, &step);
    true
}

/// Does a step.
pub(super) fn apply(surface: &mut Surface, step: &Step) {
    match step {
        Step::Move(places) => {
            for &(n, p) in places {
                surface.points[n] = p;
            }
        }
        &Step::Flip(edge, pair) => surface.flip(edge, pair),
        &Step::Contract { gone, kept } => surface.contract(gone, kept),
        Step::Cap(cone) => surface.cap(cone),
    }
}

/// Of the steps with an outcome that will do, the one that leaves the fewest folds and, of these, the best shapes.
fn best(rated: &[(Score, Step)], will_do: &dyn Fn(&Score) -> bool) -> Option<Step> {
    rated
        .iter()
        .filter(|(after, _)| will_do(after))
        .min_by(|(x, _), (y, _)| (x.folds.cmp(&y.folds)).then(y.least.total_cmp(&x.least)))
        .map(|(_, step)| step.clone())
}

/// Contractions of the triangle's edges that make one of two forks or curves inside one block of material: nearer to each other than the walls there are thick.
pub(super) fn mergers(surface: &Surface, t: TriangleId, placer: &dyn Placer) -> Vec<Step> {
    let nodes = surface.triangle(t).nodes;
    let mut steps = Vec::new();
    for k in 0..3 {
        let (a, b) = (nodes[k], nodes[(k + 1) % 3]);
        let walls = surface.around(a, b);
        let thickness = |t: &TriangleId| {
            let wall = surface.triangle(*t).wall;
            placer.thickness(surface.points[a], wall)
        };
        let near = (walls.iter().map(thickness))
            .all(|d| d.is_some_and(|d| surface.length(a, b) < d.abs()));
        for (gone, kept) in [(a, b), (b, a)] {
            let on_curves = !surface.feature_neighbours(kept).is_empty();
            let rim_corner = ends(&surface.supports[gone]).count() > 1;
            if near && on_curves && !rim_corner && keeps_together(surface, gone, kept) {
                steps.push(Step::Contract { gone, kept });
            }
        }
    }
    steps
}

/// The steps that could mend a triangle and are allowed; of moves only those of nodes that `may_move`.
pub(super) fn steps(
    surface: &Surface,
    t: TriangleId,
    placer: &dyn Placer,
    may_move: &(dyn Fn(NodeId) -> bool + Sync),
) -> Vec<Step> {
    let nodes = surface.triangle(t).nodes;
    let mut wide: Vec<NodeId> = nodes.to_vec();
    wide.extend(nodes.iter().flat_map(|&n| surface.neighbours(n)));
    wide.sort_unstable();
    wide.dedup();
    let mut widest: Vec<NodeId> = (wide.iter()).flat_map(|&n| surface.neighbours(n)).collect();
    widest.sort_unstable();
    widest.dedup();
    let groups: Vec<&[NodeId]> = (wide.chunks(1))
        .chain([&nodes[..], &wide, &widest])
        .collect();
    let moves: Vec<Vec<Step>> = (groups.par_iter().with_max_len(1))
        .map(|moving| relaxed(surface, moving, placer, may_move))
        .collect();
    let mut steps = moves.concat();
    steps.extend(cones(surface, t).into_iter().map(Step::Cap));
    let mut edges: Vec<[NodeId; 2]> = (nodes.iter())
        .flat_map(|&n| (surface.neighbours(n).into_iter()).map(move |m| [n.min(m), n.max(m)]))
        .collect();
    edges.sort_unstable();
    edges.dedup();
    for [a, b] in edges {
        if let &[s, u] = surface.around(a, b).as_slice()
            && surface.triangle(s).wall == surface.triangle(u).wall
        {
            let (c, d) = (surface.apex(s, a, b), surface.apex(u, a, b));
            if c != d && surface.around(c, d).is_empty() {
                steps.push(Step::Flip([a, b], [s, u]));
            }
        }
        for (gone, kept) in [(a, b), (b, a)] {
            if may_go(surface, gone, kept, placer) {
                steps.push(Step::Contract { gone, kept });
            }
        }
    }
    steps
}

/// Whether a triangle is a flap: folded back from a free border onto sheet that goes on without it, and smaller than the wall is thick.
fn is_flap(surface: &Surface, t: TriangleId, placer: &dyn Placer) -> bool {
    let triangle = surface.triangle(t);
    let nodes = triangle.nodes;
    let free = |k: usize| surface.around(nodes[k], nodes[(k + 1) % 3]).len() == 1;
    let free = [free(0), free(1), free(2)];
    let loose = match free.iter().filter(|f| **f).count() {
        // Across from the free side nothing may hang on the triangle alone; at the ends of that side it goes with the side.
        1 => (0..3).all(|k| !free[k] || !hinges(surface, nodes[(k + 2) % 3], t)),
        2 => nodes.iter().any(|&n| surface.star(n).len() == 1),
        _ => false,
    };
    loose
        && placer
            .thickness(surface.points[nodes[0]], triangle.wall)
            .is_some_and(|d| area_vector(surface.corners(t)).length() < 2.0 * d * d)
}

/// Neighbours between which a node may be moved: all of a sheet node, the two on a curve that does not bend much there.
fn between(surface: &Surface, n: NodeId, placer: &dyn Placer) -> Vec<NodeId> {
    match *surface.feature_neighbours(n) {
        [] => surface.neighbours(n).to_vec(),
        [a, b]
            if ends(&surface.supports[n]).count() < 2 && passes_by(surface, n, [a, b], placer) =>
        {
            vec![a, b]
        }
        _ => Vec::new(),
    }
}

fn passes_by(surface: &Surface, n: NodeId, ends: [NodeId; 2], placer: &dyn Placer) -> bool {
    let p = surface.points[n];
    let [a, b] = ends.map(|m| surface.points[m]);
    let sag = distance_to_segment(p, a, b);
    let thin = |t: &TriangleId| placer.thickness(p, surface.triangle(*t).wall);
    sag <= STRAIGHT * a.distance(b)
        || (surface.star(n).first().and_then(thin)).is_some_and(|d| sag <= THIN * d.abs())
}

/// Moves of the nodes towards the middle of their neighbours, one after each of the numbers of steps.
fn relaxed(
    surface: &Surface,
    moving: &[NodeId],
    placer: &dyn Placer,
    may_move: &(dyn Fn(NodeId) -> bool + Sync),
) -> Vec<Step> {
    let free: Vec<(NodeId, Vec<NodeId>)> = moving
        .iter()
        .map(|&n| (n, between(surface, n, placer)))
        .filter(|(_, near)| !near.is_empty())
        .collect();
    if free.is_empty() || !free.iter().all(|(n, _)| may_move(*n)) {
        return Vec::new();
    }
    let mut places: Vec<DVec3> = free.iter().map(|&(n, _)| surface.points[n]).collect();
    let mut moves = Vec::with_capacity(RELAXATIONS.len());
    let mut done = 0;
    for count in RELAXATIONS {
        for _ in done..count {
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
        done = count;
        let settled: Vec<(NodeId, DVec3)> = free
            .iter()
            .zip(&places)
            .map(|((n, _), p)| (*n, placer.place(*p, &surface.supports[*n])))
            .collect();
        if settled.iter().all(|(_, p)| p.is_finite()) {
            moves.push(Step::Move(settled));
        }
    }
    moves
}

fn may_go(surface: &Surface, gone: NodeId, kept: NodeId, placer: &dyn Placer) -> bool {
    let near = surface.feature_neighbours(gone);
    let strata = match *near {
        [] => true,
        // The loose end of a curve.
        [a] => a == kept,
        [a, b] if a == kept || b == kept => {
            let far = if a == kept { b } else { a };
            ends(&surface.supports[gone]).count() < 2
                && passes_by(surface, gone, [kept, far], placer)
                && !surface.feature_neighbours(kept).contains(&far)
        }
        _ => false,
    };
    strata && keeps_together(surface, gone, kept)
}

/// The triangles within some rings of a triangle, sorted.
pub(super) fn rings(surface: &Surface, t: TriangleId, count: usize) -> Vec<TriangleId> {
    let mut all = vec![t];
    for _ in 0..count {
        all = with_ring(surface, &all);
    }
    all
}

pub(super) fn with_ring(surface: &Surface, triangles: &[TriangleId]) -> Vec<TriangleId> {
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
pub(super) fn with_neighbours(
    surface: &Surface,
    mut triangles: Vec<TriangleId>,
) -> Vec<TriangleId> {
    let more = with_ring(surface, &triangles);
    let inside = triangles.len();
    for t in more {
        if triangles[..inside].binary_search(&t).is_err() {
            triangles.push(t);
        }
    }
    triangles
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geom::orient::folded;
    use crate::model::ids::WallId;
    use crate::stage::test_shapes::{Stay, sheet};

    fn plate() -> MidComplex {
        sheet(6, 6, |u, v| DVec3::new(6.0 * u, 6.0 * v, 0.0))
    }

    /// The node of the plate nearest to a place.
    fn at(complex: &MidComplex, x: f64, y: f64) -> NodeId {
        let place = DVec3::new(x, y, 0.0);
        let away = |n: &NodeId| complex.nodes[*n].point.distance(place);
        (complex.nodes.ids())
            .min_by(|a, b| away(a).total_cmp(&away(b)))
            .unwrap()
    }

    #[test]
    fn a_node_drawn_across_its_neighbours_comes_back() {
        let mut complex = plate();
        let n = at(&complex, 3.0, 3.0);
        complex.nodes[n].point.x += 1.7;
        assert!(!folded(&complex).is_empty());
        let (euler, count) = (complex.euler(), complex.triangles.len());
        let mended = unfold(complex, &Stay);
        assert!(folded(&mended).is_empty());
        assert_eq!((mended.euler(), mended.pieces()), (euler, 1));
        assert_eq!(mended.triangles.len(), count);
        assert!(mended.check().is_empty());
    }

    #[test]
    fn two_nodes_that_have_changed_places_are_parted() {
        let mut complex = plate();
        let (n, m) = (at(&complex, 2.0, 3.0), at(&complex, 4.0, 3.0));
        let p = complex.nodes[n].point;
        complex.nodes[n].point = complex.nodes[m].point;
        complex.nodes[m].point = p;
        assert!(folded(&complex).len() > 1);
        let mended = unfold(complex, &Stay);
        assert!(folded(&mended).is_empty());
        assert_eq!((mended.euler(), mended.pieces()), (1, 1));
    }

    #[test]
    fn a_sound_plate_stays() {
        let complex = plate();
        assert_eq!(unfold(complex.clone(), &Stay).nodes, complex.nodes);
    }

    #[test]
    fn a_corner_of_the_border_is_never_moved_nor_taken() {
        let mut complex = plate();
        // The ends of the border's curves are corners here: faces 0 and 1 meet there.
        for (x, y) in [(0.0, 0.0), (6.0, 0.0), (0.0, 6.0), (6.0, 6.0)] {
            let n = at(&complex, x, y);
            complex.nodes[n].supports = (0..2)
                .map(|f| crate::model::complex::Support::Face(crate::model::ids::FaceId(f)))
                .collect();
        }
        let n = at(&complex, 1.0, 1.0);
        complex.nodes[n].point += DVec3::new(1.6, 0.3, 0.0);
        let mended = unfold(complex, &Stay);
        assert!(folded(&mended).is_empty());
        for (x, y) in [(0.0, 0.0), (6.0, 0.0), (0.0, 6.0), (6.0, 6.0)] {
            let n = at(&mended, x, y);
            assert_eq!(mended.nodes[n].point, DVec3::new(x, y, 0.0));
        }
        assert_eq!(mended.triangles.as_slice()[0].wall, WallId(0));
    }
}
