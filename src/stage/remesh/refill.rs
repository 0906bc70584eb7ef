//! Cuts a folded place out of its sheet and fills the hole anew.
//!
//! Where many small triangles lie crumpled on each other no step at one of them helps. The sheet round the fold, a disc of a few rings inside one wall, is replaced by other triangles on
//! the same border: Delaunay ones in the plane of the border with the nodes inside that have room there, or the least bent ones with none. The smallest disc and the filling
//! that leave the fewest folds are taken.
//!
//! Guarantees: a disc takes the place of a disc with the same border, so homotopy type, feature curves and all other sheets stay; no edge comes twice; folds become fewer; nodes
//! inside lie on their supports; edges leave the mid-surface by no more than `OFF` of the thickness or what those before did.
//! Limits: a border that is itself folded over has no filling without folds. Cost: some twenty fillings a fold.

use super::fill::{delaunay, least_bent};
use super::rate::{Part, Score};
use super::shape::area_vector;
use super::surface::Surface;
use super::unfold::{with_neighbours, with_ring};
use crate::geom::placer::Placer;
use crate::model::ids::{NodeId, TriangleId};
use glam::DVec3;

/// Discs reach so many triangles from the fold: three rings of nodes.
const REACH: usize = 9;
/// Rings of triangles that are read: the largest disc, a ring that is judged, its neighbours and their stars.
pub(super) const READ: usize = REACH + 3;
/// Longer borders are not filled: more than what three rings have, and it bounds the cost.
const LONGEST: usize = 60;
/// How far the middle of a new edge may lie from the mid-surface, as a share of the thickness: an R-error of half of the limit.
const OFF: f64 = 0.025;
/// Steps of the nodes inside to the middle of their neighbours, after which a small disc has settled.
const RELAXATIONS: usize = 4;
/// A filling whose worst triangle is below this (a needle of 1 : 40) is taken only if none without is found.
const LEAST_QUALITY: f64 = 0.05;

/// A disc of one wall.
struct Disc {
    /// Sorted.
    triangles: Vec<TriangleId>,
    /// The border, as the triangles run.
    border: Vec<NodeId>,
    /// The nodes inside, sorted.
    inner: Vec<NodeId>,
}

/// Triangles in the place of others, and the nodes that move with them.
#[derive(Clone, Debug)]
pub(super) struct Refill {
    /// Those that go, sorted; no fewer than come.
    pub old: Vec<TriangleId>,
    pub new: Vec<[NodeId; 3]>,
    /// Sorted.
    pub places: Vec<(NodeId, DVec3)>,
}

/// Fills the sheet round a folded triangle anew; whether that left fewer folds.
pub(super) fn refill(surface: &mut Surface, t: TriangleId, placer: &dyn Placer) -> bool {
    let mut found: Option<(Score, Refill)> = None;
    let mut disc = vec![t];
    for _ in 0..REACH {
        if let Some(disc) = Disc::new(surface, &disc) {
            let judged = with_ring(surface, &disc.triangles);
            let inside = judged.len();
            let part = Part::new(surface, with_neighbours(surface, judged), inside);
            let before = part.score();
            for filling in fillings(surface, &disc, placer) {
                let after = part.refilled(surface, &filling);
                let sound = after.folds == 0 && after.least >= LEAST_QUALITY.min(before.least);
                let better = match &found {
                    None => after.folds < before.folds,
                    Some((best, _)) => {
                        after.folds < before.folds
                            && (after.folds, -after.least) < (best.folds, -best.least)
                    }
                };
                if better {
                    found = Some((after, filling));
                }
                if sound {
                    return found.is_some_and(|(_, filling)| put(surface, &filling));
                }
            }
        }
        let grown = grown(surface, &disc);
        if grown.len() == disc.len() {
            break;
        }
        disc = grown;
    }
    found.is_some_and(|(_, filling)| put(surface, &filling))
}

fn put(surface: &mut Surface, filling: &Refill) -> bool {
    surface.refill(&filling.old, &filling.new);
    for &(n, p) in &filling.places {
        surface.points[n] = p;
    }
    true
}

/// The triangle across a side inside the sheet.
fn across(surface: &Surface, t: TriangleId, a: NodeId, b: NodeId) -> Option<TriangleId> {
    let ring = surface.around(a, b);
    let other = ring.iter().copied().find(|s| *s != t)?;
    let same = surface.triangle(other).wall == surface.triangle(t).wall;
    (ring.len() == 2 && same).then_some(other)
}

/// The triangles and those beside them in the sheet, sorted.
fn grown(surface: &Surface, disc: &[TriangleId]) -> Vec<TriangleId> {
    let mut all = disc.to_vec();
    for &t in disc {
        let n = surface.triangle(t).nodes;
        all.extend((0..3).filter_map(|k| across(surface, t, n[k], n[(k + 1) % 3])));
    }
    all.sort_unstable();
    all.dedup();
    all
}

impl Disc {
    /// The triangles as a disc, if they are one.
    fn new(surface: &Surface, triangles: &[TriangleId]) -> Option<Self> {
        let mut sides: Vec<[NodeId; 2]> = Vec::new();
        let mut inner: Vec<NodeId> = Vec::new();
        for &t in triangles {
            let n = surface.triangle(t).nodes;
            inner.extend(n);
            for k in 0..3 {
                let (a, b) = (n[k], n[(k + 1) % 3]);
                let inside =
                    across(surface, t, a, b).is_some_and(|s| triangles.binary_search(&s).is_ok());
                if !inside {
                    sides.push([a, b]);
                }
            }
        }
        sides.sort_unstable();
        inner.sort_unstable();
        inner.dedup();
        if sides.len() > LONGEST || sides.windows(2).any(|s| s[0][0] == s[1][0]) {
            return None;
        }
        let first = sides.first()?[0];
        let mut border = vec![first];
        let mut at = first;
        loop {
            let k = sides.binary_search_by_key(&at, |s| s[0]).ok()?;
            at = sides[k][1];
            if at == first {
                break;
            }
            if border.len() == sides.len() {
                return None;
            }
            border.push(at);
        }
        inner.retain(|n| sides.binary_search_by_key(n, |s| s[0]).is_err());
        let euler = triangles.len() + 2 == border.len() + 2 * inner.len();
        let alone = |n: &NodeId| {
            let mut star = surface.star(*n).iter();
            star.all(|t| triangles.binary_search(t).is_ok())
        };
        let is_disc = border.len() == sides.len() && euler && inner.iter().all(alone);
        is_disc.then(|| Self {
            triangles: triangles.to_vec(),
            border,
            inner,
        })
    }
}

/// The fillings of a disc that may take its place.
fn fillings(surface: &Surface, disc: &Disc, placer: &dyn Placer) -> Vec<Refill> {
    let place = |n: &NodeId| surface.points[*n];
    let border: Vec<DVec3> = disc.border.iter().map(place).collect();
    let inner: Vec<DVec3> = disc.inner.iter().map(place).collect();
    let named = |triangles: Vec<[usize; 3]>| -> Vec<[NodeId; 3]> {
        let count = border.len();
        let node = |i: usize| match i.checked_sub(count) {
            None => disc.border[i],
            Some(i) => disc.inner[i],
        };
        triangles.into_iter().map(|t| t.map(node)).collect()
    };
    let mut all: Vec<Vec<[NodeId; 3]>> = Vec::new();
    all.extend(delaunay(&border, &inner).map(named));
    if !inner.is_empty() {
        all.extend(delaunay(&border, &[]).map(named));
    }
    all.push(named(least_bent(&border, &beside(surface, disc))));
    let allowed = allowance(surface, disc, placer);
    all.into_iter()
        .filter(|new| new.len() <= disc.triangles.len() && is_new(surface, disc, new))
        .flat_map(|new| {
            let stay = Refill {
                old: disc.triangles.clone(),
                new,
                places: Vec::new(),
            };
            let relaxed = relaxed(surface, disc, &stay, placer);
            [Some(stay), relaxed].into_iter().flatten()
        })
        .filter(|filling| follows(surface, disc, filling, allowed, placer))
        .collect()
}

/// Normals of the sheet beyond the border.
fn beside(surface: &Surface, disc: &Disc) -> Vec<Option<DVec3>> {
    let count = disc.border.len();
    let beyond = |k: usize| {
        let (a, b) = (disc.border[k], disc.border[(k + 1) % count]);
        let ring = surface.around(a, b);
        let own = ring
            .iter()
            .find(|t| disc.triangles.binary_search(t).is_ok())?;
        let other = across(surface, *own, a, b)?;
        Some(area_vector(surface.corners(other)).normalize_or_zero())
    };
    (0..count).map(beyond).collect()
}

/// Inner edges of a filling, sorted.
fn edges(disc: &Disc, new: &[[NodeId; 3]]) -> Vec<[NodeId; 2]> {
    let count = disc.border.len();
    let ordered = |a: NodeId, b: NodeId| [a.min(b), a.max(b)];
    let mut border: Vec<[NodeId; 2]> = (0..count)
        .map(|k| ordered(disc.border[k], disc.border[(k + 1) % count]))
        .collect();
    border.sort_unstable();
    let mut all: Vec<[NodeId; 2]> = (new.iter())
        .flat_map(|t| (0..3).map(|k| ordered(t[k], t[(k + 1) % 3])))
        .filter(|e| border.binary_search(e).is_err())
        .collect();
    all.sort_unstable();
    all.dedup();
    all
}

/// Whether no inner edge of a filling is there already outside the disc.
fn is_new(surface: &Surface, disc: &Disc, new: &[[NodeId; 3]]) -> bool {
    let inside = |t: &TriangleId| disc.triangles.binary_search(t).is_ok();
    (edges(disc, new).iter()).all(|e| surface.around(e[0], e[1]).iter().all(inside))
}

/// How far the middle of an edge lies from the mid-surface, over the thickness; zero where nothing is known.
fn off(surface: &Surface, disc: &Disc, [p, q]: [DVec3; 2], placer: &dyn Placer) -> f64 {
    let wall = surface.triangle(disc.triangles[0]).wall;
    let middle = 0.5 * (p + q);
    let (way, thickness) = (
        placer.to_middle(middle, wall),
        placer.thickness(middle, wall),
    );
    match (way, thickness) {
        (Some((_, way)), Some(d)) if d != 0.0 => (way / d).abs(),
        _ => 0.0,
    }
}

/// What may be left of the mid-surface: no more than before.
fn allowance(surface: &Surface, disc: &Disc, placer: &dyn Placer) -> f64 {
    let old: Vec<[NodeId; 3]> = (disc.triangles.iter())
        .map(|&t| surface.triangle(t).nodes)
        .collect();
    (edges(disc, &old).into_iter())
        .map(|e| off(surface, disc, e.map(|n| surface.points[n]), placer))
        .fold(OFF, f64::max)
}

fn follows(
    surface: &Surface,
    disc: &Disc,
    filling: &Refill,
    allowed: f64,
    placer: &dyn Placer,
) -> bool {
    let at = |n: NodeId| match filling.places.binary_search_by_key(&n, |p| p.0) {
        Ok(k) => filling.places[k].1,
        Err(_) => surface.points[n],
    };
    (edges(disc, &filling.new).into_iter())
        .all(|e| off(surface, disc, e.map(at), placer) <= allowed)
}

/// The filling with its inner nodes in the middle of their neighbours, on their supports.
fn relaxed(
    surface: &Surface,
    disc: &Disc,
    filling: &Refill,
    placer: &dyn Placer,
) -> Option<Refill> {
    let edges = edges(disc, &filling.new);
    let mut places: Vec<(NodeId, DVec3)> = Vec::new();
    let mut near: Vec<Vec<NodeId>> = Vec::new();
    for &n in &disc.inner {
        let others = edges.iter().filter(|e| e.contains(&n));
        let others: Vec<NodeId> = others
            .map(|e| if e[0] == n { e[1] } else { e[0] })
            .collect();
        if !others.is_empty() {
            places.push((n, surface.points[n]));
            near.push(others);
        }
    }
    if places.is_empty() {
        return None;
    }
    for _ in 0..RELAXATIONS {
        for i in 0..places.len() {
            let at = |m: &NodeId| match places.binary_search_by_key(m, |p| p.0) {
                Ok(k) => places[k].1,
                Err(_) => surface.points[*m],
            };
            let middle = near[i].iter().map(at).sum::<DVec3>() / near[i].len() as f64;
            places[i].1 = placer.draw(middle, &surface.supports[places[i].0]);
        }
    }
    for (n, p) in &mut places {
        *p = placer.place(*p, &surface.supports[*n]);
    }
    let sound = places.iter().all(|(_, p)| p.is_finite());
    sound.then(|| Refill {
        places,
        ..filling.clone()
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geom::orient::folded;
    use crate::model::complex::MidComplex;
    use crate::stage::test_shapes::{Stay, sheet};

    /// A plate of 12 by 12 of which some nodes lie far across their neighbours.
    fn crumpled() -> MidComplex {
        let mut complex = sheet(12, 12, |u, v| DVec3::new(12.0 * u, 12.0 * v, 0.0));
        for node in complex.nodes.as_mut_slice() {
            let off = node.point - DVec3::new(6.0, 6.0, 0.0);
            if off.abs().max_element() < 1.5 {
                node.point = DVec3::new(6.0, 6.0, 0.0) - off * 1.3;
            }
        }
        complex
    }

    #[test]
    fn a_crumpled_place_is_filled_anew_and_what_is_far_stays() {
        let before = crumpled();
        let bad = folded(&before);
        assert!(!bad.is_empty());
        let mut surface = Surface::new(before.clone());
        assert!(refill(&mut surface, bad[0], &Stay));
        let after = surface.finish();
        assert!(folded(&after).is_empty());
        assert!(after.check().is_empty());
        assert_eq!((after.euler(), after.pieces()), (1, 1));
        let area = |c: &MidComplex| -> f64 {
            let corners = |t: [NodeId; 3]| t.map(|n| c.nodes[n].point);
            let twice = c
                .triangles
                .iter()
                .map(|t| area_vector(corners(t.nodes)).length());
            twice.sum::<f64>() / 2.0
        };
        assert!((area(&after) - 144.0).abs() < 1e-9);
    }

    #[test]
    fn a_sound_place_stays() {
        let before = sheet(6, 6, |u, v| DVec3::new(u, v, 0.0));
        let mut surface = Surface::new(before.clone());
        assert!(!refill(&mut surface, TriangleId(30), &Stay));
        assert_eq!(surface.finish(), before);
    }

    #[test]
    fn triangles_round_a_hole_or_on_two_walls_are_no_disc() {
        let mut complex = sheet(6, 6, |u, v| DVec3::new(u, v, 0.0));
        let surface = Surface::new(complex.clone());
        let all: Vec<TriangleId> = surface.live_triangles().collect();
        assert!(Disc::new(&surface, &all).is_some());
        let ring: Vec<TriangleId> = (all.iter().copied())
            .filter(|t| !(30..34).contains(&t.0))
            .collect();
        assert!(Disc::new(&surface, &ring).is_none());
        complex.triangles[TriangleId(30)].wall.0 = 1;
        let surface = Surface::new(complex);
        assert!(grown(&surface, &[TriangleId(30)]).len() == 1);
        assert!(Disc::new(&surface, &all).is_none());
    }
}
