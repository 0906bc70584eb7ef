//! Steps: walls that the complex shows to lie before and behind a step of thickness.
//!
//! Pairing joins walls over the risers that it knows by their heights. Where a ledge is short, its riser runs on round bosses and along walls elsewhere, or the riser has a
//! mate itself far across a block, it does not. The complex tells: two sheets meet in a crease, and their mid-surfaces are parallel there, one behind the other.
//! The crease then lies nowhere in particular, and what hangs between the two mid-surfaces is in the middle of neither. With the riser on their side the two are one wall.

use crate::geom::placer::Placer;
use crate::model::complex::{EdgeKind, MidComplex, Support};
use crate::model::ids::{FaceId, WallId};
use crate::model::walls::{Aag, Convexity, Pairing};
use std::collections::BTreeMap;

/// Mid-surfaces that turn by less than this, 20 degrees, are parallel: drafts of both sides are less.
const PARALLEL_COS: f64 = 0.94;
/// Greatest ratio of the two thicknesses: beyond it the thin wall ends at a block. Three, and the share that chords of curved facets take.
const GREATEST_RATIO: f64 = 3.15;
/// A step rises by at least this share of the thinner wall: less is draft.
const LEAST_RISE: f64 = 0.05;
/// Share of the common crease along which the walls lie one behind the other.
const MOST: f64 = 0.7;
/// A riser runs along either level for at least this share of the crease.
const ALONG: f64 = 0.25;
/// A face with more than this share of its border with the two levels along the opposite side reaches right across the wall: it ends it.
const ACROSS: f64 = 0.3;

/// Two walls that are one over a step.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Step {
    /// The walls.
    pub walls: [WallId; 2],
    /// Whether the second wall's sides are the other way round.
    pub turned: bool,
    /// Which side of the first wall steps.
    pub side: usize,
    /// The faces that join its two levels.
    pub risers: Vec<FaceId>,
}

/// What the crease of two walls tells, mm: its length, how much of it parts parallel walls, and the same less where the second wall is turned.
#[derive(Clone, Copy, Debug, Default)]
struct Seen {
    all: f64,
    parallel: f64,
    sign: f64,
    thickness: [f64; 2],
}

/// All steps, in order of their walls.
pub(super) fn steps(
    complex: &MidComplex,
    pairing: &Pairing,
    aag: &Aag,
    placer: &dyn Placer,
) -> Vec<Step> {
    let mut creases: BTreeMap<[WallId; 2], Seen> = BTreeMap::new();
    let edges = complex.edges();
    for edge in edges.iter().filter(|e| complex.kind(e) == EdgeKind::Crease) {
        let [s, t] = [0, 1].map(|k| complex.triangles[edge.triangles[k]].wall);
        let walls = [s.min(t), s.max(t)];
        let [a, b] = edge.ends.map(|n| complex.nodes[n].point);
        let (middle, length) = ((a + b) / 2.0, a.distance(b));
        let seen = creases.entry(walls).or_default();
        seen.all += length;
        let [Some(n), Some(m)] = walls.map(|w| placer.normal(middle, w)) else {
            continue;
        };
        let [p, q] = walls.map(|w| placer.place(middle, &[Support::Mid(w)]));
        let thickness = walls.map(|w| placer.thickness(middle, w).unwrap_or(0.0));
        let [low, high] = [
            thickness[0].min(thickness[1]),
            thickness[0].max(thickness[1]),
        ];
        // Further apart than half of the thicker wall they are two layers.
        if n.dot(m).abs() > PARALLEL_COS
            && high <= GREATEST_RATIO * low
            && (p - q).dot(n).abs() < high / 2.0
        {
            seen.parallel += length;
            seen.sign += length * n.dot(m).signum();
            for (sum, t) in seen.thickness.iter_mut().zip(thickness) {
                *sum += length * t;
            }
        }
    }
    let known = |(walls, seen): (&[WallId; 2], &Seen)| {
        if seen.parallel <= MOST * seen.all {
            return None;
        }
        let turned = seen.sign < 0.0;
        let [first, second] = walls.map(|w| &pairing.walls[w].sides);
        (0..2).find_map(|side| {
            let levels = [
                first[side].as_slice(),
                second[side ^ usize::from(turned)].as_slice(),
            ];
            let grounds = [
                first[1 - side].as_slice(),
                second[(1 - side) ^ usize::from(turned)].as_slice(),
            ];
            let [p, q] = seen.thickness;
            let levels = if p <= q {
                levels
            } else {
                [levels[1], levels[0]]
            };
            let risers = between(aag, levels, grounds, seen.all)?;
            Some(Step {
                walls: *walls,
                turned,
                side,
                risers,
            })
        })
    };
    let mut found: Vec<Step> = creases.iter().filter_map(known).collect();
    found.extend(inner(pairing, aag));
    found
}

/// Steps within walls whose levels are one already, in a round-about way, without the risers between them.
fn inner(pairing: &Pairing, aag: &Aag) -> Vec<Step> {
    let mut found = Vec::new();
    for (w, wall) in pairing.walls.enumerated() {
        // Thickness over each face of the wall, mm: sums of area times thickness, and of area.
        let mut over: BTreeMap<FaceId, [f64; 2]> = BTreeMap::new();
        for pair in pairing.pairs.iter().filter(|p| p.wall == w) {
            for f in pair.faces {
                let sums = over.entry(f).or_default();
                sums[0] += pair.overlap * pair.thickness[1];
                sums[1] += pair.overlap;
            }
        }
        for side in 0..2 {
            let (level, ground) = (&wall.sides[side], &wall.sides[1 - side]);
            let mut risers: Vec<FaceId> = level
                .iter()
                .flat_map(|&f| aag.arcs_of(f).map(move |a| Aag::across(a, f)))
                .filter(|&f| !on(level, f) && !on(ground, f) && pairing.side[f].is_none())
                .filter(|&f| {
                    let mut along = [0.0; 2];
                    let mut thick = [[0.0; 2]; 2];
                    let mut across = 0.0;
                    for arc in aag.arcs_of(f) {
                        let g = Aag::across(arc, f);
                        if on(ground, g) {
                            across += arc.length;
                        }
                        let end = match arc.convexity {
                            Convexity::Concave => 0,
                            Convexity::Convex => 1,
                            Convexity::Smooth => continue,
                        };
                        if let Some([sum, area]) = over.get(&g).filter(|_| on(level, g)) {
                            along[end] += arc.length;
                            thick[end][0] += arc.length * sum / area;
                            thick[end][1] += arc.length;
                        }
                    }
                    let [up, high] = along;
                    let [t, u] = thick.map(|[sum, length]| sum / length);
                    up.min(high) >= ALONG * (up + high)
                        && up > 0.0
                        && across <= ACROSS * (up + high)
                        && u >= t * (1.0 + LEAST_RISE)
                        && u <= t * GREATEST_RATIO
                })
                .collect();
            risers.sort_unstable();
            risers.dedup();
            if !risers.is_empty() {
                found.push(Step {
                    walls: [w; 2],
                    turned: false,
                    side,
                    risers,
                });
            }
        }
    }
    found
}

fn on(faces: &[FaceId], f: FaceId) -> bool {
    faces.binary_search(&f).is_ok()
}

/// The riser from the lower level up to the higher one over one ground, if there is one.
fn between(
    aag: &Aag,
    [low, high]: [&[FaceId]; 2],
    grounds: [&[FaceId]; 2],
    crease: f64,
) -> Option<Vec<FaceId>> {
    let continued = |&f: &FaceId| {
        let smooth = |a: &&crate::model::walls::Arc| a.convexity == Convexity::Smooth;
        on(grounds[1], f)
            || aag
                .arcs_of(f)
                .filter(smooth)
                .any(|a| on(grounds[1], Aag::across(a, f)))
    };
    if !grounds[0].iter().any(continued) {
        return None;
    }
    // From the lower level a riser rises at an inner corner, to the higher one it leads over an outer one.
    let border = |f: FaceId, faces: &[FaceId], not: Option<Convexity>| -> f64 {
        aag.arcs_of(f)
            .filter(|a| Some(a.convexity) != not && on(faces, Aag::across(a, f)))
            .map(|a| a.length)
            .sum()
    };
    let mut found: Vec<FaceId> = low
        .iter()
        .flat_map(|&f| aag.arcs_of(f).map(move |a| Aag::across(a, f)))
        .filter(|&f| {
            let own = [low, high].iter().any(|l| on(l, f));
            let ground = grounds.iter().any(|g| on(g, f));
            let up = border(f, low, Some(Convexity::Convex));
            let over = border(f, high, Some(Convexity::Concave));
            let across = border(f, grounds[0], None).max(border(f, grounds[1], None));
            !own && !ground && up.min(over) >= ALONG * crease && across <= ACROSS * (up + over)
        })
        .collect();
    found.sort_unstable();
    found.dedup();
    (!found.is_empty()).then_some(found)
}

#[cfg(test)]
mod tests;
