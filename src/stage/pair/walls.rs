//! Walls: pairs joined where they continue each other smoothly on both sides.
//!
//! A face group pair (FGP) is a connected component of the pair graph, two-coloured. A wall is smaller: the pairs of it whose mid-surface is
//! one sheet. Across a sharp corner one wall ends and another begins, because there the sheets are to be extended until they meet instead of
//! following the nearest face round the corner. Across a step of thickness the wall goes on, with the riser on its side.

use super::risers::{Side, Sides, Step, steps};
use crate::model::brep::Brep;
use crate::model::disjoint::SidedDisjoint;
use crate::model::ids::{FaceId, Id, IndexVec, WallId};
use crate::model::walls::{Aag, Convexity, FacePair, Pairing, Wall};

/// Two pairs on one common face are the same wall where their thickness differs by less than this share and hardly varies: a plate
/// between ribs has many faces on the ribbed side and one thickness.
const SAME_THICKNESS: f64 = 0.01;

/// Sides that turn more than this at an edge turn in a corner.
const CORNER_RAD: f64 = 20.0 * std::f64::consts::PI / 180.0;

/// Colours the pair graph and joins the pairs into walls.
pub(super) fn walls(brep: &Brep, aag: &Aag, mut pairs: Vec<FacePair>) -> Pairing {
    let faces = brep.faces.len();
    let mut of_face: IndexVec<FaceId, Vec<u32>> = IndexVec::filled(Vec::new(), faces);
    for (i, p) in pairs.iter().enumerate() {
        for f in p.faces {
            of_face[f].push(i as u32);
        }
    }
    let mut side = colour(aag, &pairs, &of_face);
    let mut union = SidedDisjoint::new(pairs.iter().map(|p| p.faces.map(|f| vec![f])));
    for [i, j] in corners(aag, &pairs, &of_face) {
        union.keep_apart(i, j);
    }
    // Joins two pairs, face `a` of the one on the same side as face `c` of the other; says whether they are so joined.
    let join = |union: &mut SidedDisjoint<FaceId>, [i, j]: [u32; 2], [a, c]: [FaceId; 2]| {
        let second = |i: u32, f: FaceId| pairs[i as usize].faces[1] == f;
        union.join(i, j, second(i, a) != second(j, c))
    };

    // Pairs over a tangent joint: the other faces must be the same or tangent as well.
    for arc in aag.arcs.iter().filter(|a| a.convexity == Convexity::Smooth) {
        let [a, c] = arc.faces;
        for &i in &of_face[a] {
            let b = other(&pairs[i as usize], a);
            for &j in &of_face[c] {
                let d = other(&pairs[j as usize], c);
                let smooth = b == d
                    || aag
                        .arcs_of(b)
                        .any(|x| x.convexity == Convexity::Smooth && Aag::across(x, b) == d);
                if smooth {
                    join(&mut union, [i, j], [a, c]);
                }
            }
        }
    }
    // Pairs on one common face at one constant thickness.
    for (a, list) in of_face.enumerated() {
        let mut constant: Vec<u32> = list
            .iter()
            .copied()
            .filter(|&i| {
                let [low, mean, high] = pairs[i as usize].thickness;
                high - low < SAME_THICKNESS * mean
            })
            .collect();
        constant.sort_by(|&i, &j| {
            pairs[i as usize].thickness[1]
                .total_cmp(&pairs[j as usize].thickness[1])
                .then(i.cmp(&j))
        });
        for w in constant.windows(2) {
            let (t, u) = (
                pairs[w[0] as usize].thickness[1],
                pairs[w[1] as usize].thickness[1],
            );
            if u - t < SAME_THICKNESS * t {
                join(&mut union, [w[0], w[1]], [a, a]);
            }
        }
    }
    // Pairs before and behind a step.
    let mut risers: Vec<(FaceId, u32, FaceId)> = Vec::new();
    let found = steps(
        brep,
        aag,
        &pairs,
        &of_face,
        &Joined::new(&pairs, &mut union),
    );
    for step in found {
        let [i, j] = step.pairs;
        let [a, c] = step.faces;
        if merge_groups(&mut side, a, c) && join(&mut union, [i, j], [a, c]) {
            let opposite = other(&pairs[i as usize], a);
            let Step {
                risers: own,
                opposite: far,
                ..
            } = step;
            risers.extend(own.into_iter().map(|f| (f, i, a)));
            risers.extend(far.into_iter().map(|f| (f, i, opposite)));
        }
    }
    for &(f, _, like) in &risers {
        side[f] = side[f].or(side[like]);
    }

    part_airs(aag, &Joined::new(&pairs, &mut union), &of_face, &mut side);

    let mut walls: IndexVec<WallId, Wall> = IndexVec::new();
    let mut wall_of_root = vec![None; pairs.len()];
    for i in 0..pairs.len() as u32 {
        let (root, flipped) = union.find(i);
        let wall = *wall_of_root[root as usize].get_or_insert_with(|| walls.push(Wall::default()));
        let [a, b] = pairs[i as usize].faces;
        let w = &mut walls[wall];
        w.sides[usize::from(flipped)].push(a);
        w.sides[usize::from(!flipped)].push(b);
        w.group = side[a].map_or(0, |s| s.0);
        pairs[i as usize].wall = wall;
    }
    for &(f, i, like) in &risers {
        let (_, flipped) = union.find(i);
        let w = &mut walls[pairs[i as usize].wall];
        let second = (pairs[i as usize].faces[1] == like) ^ flipped;
        // A riser that two steps claim for opposite sides belongs to the first of them.
        if !w.sides[usize::from(!second)].contains(&f) {
            w.sides[usize::from(second)].push(f);
        }
    }
    for (id, w) in walls.as_mut_slice().iter_mut().enumerate() {
        for s in &mut w.sides {
            s.sort_unstable();
            s.dedup();
        }
        let own = pairs.iter().filter(|p| p.wall == WallId::new(id));
        let (area, sum) = own.fold((0.0, 0.0), |(a, s), p| {
            (a + p.overlap, s + p.overlap * p.thickness[1])
        });
        w.thickness = sum / area;
    }
    Pairing {
        pairs,
        walls,
        side,
        ..Pairing::default()
    }
}

/// Pairs that meet in a corner of the mid-surface: a sharp edge on its one side, and another face on its other. They may be joined the other way round, as the
/// skins of a wing are over its nose; then the sheet would run round the corner at the trailing edge as if it were smooth.
fn corners(aag: &Aag, pairs: &[FacePair], of_face: &IndexVec<FaceId, Vec<u32>>) -> Vec<[u32; 2]> {
    let mut found = Vec::new();
    for arc in (aag.arcs.iter()).filter(|a| a.turn_rad.abs() > CORNER_RAD) {
        let [a, c] = arc.faces;
        for &i in &of_face[a] {
            let b = other(&pairs[i as usize], a);
            for &j in &of_face[c] {
                let d = other(&pairs[j as usize], c);
                let bends_along = aag.arcs_of(b).any(|x| {
                    Aag::across(x, b) == d
                        && x.turn_rad * arc.turn_rad < 0.0
                        && x.turn_rad.abs() > CORNER_RAD
                });
                if bends_along {
                    found.push([i, j]);
                }
            }
        }
    }
    found
}

/// The mate of `face` in `pair`.
pub(super) fn other(pair: &FacePair, face: FaceId) -> FaceId {
    if pair.faces[0] == face {
        pair.faces[1]
    } else {
        pair.faces[0]
    }
}

/// Groups and colours: breadth first from the largest faces. A face that an odd cycle would give both colours keeps its first.
fn colour(
    aag: &Aag,
    pairs: &[FacePair],
    of_face: &IndexVec<FaceId, Vec<u32>>,
) -> IndexVec<FaceId, Option<(u32, u8)>> {
    let mut side = IndexVec::filled(None, of_face.len());
    let mut order: Vec<FaceId> = of_face
        .enumerated()
        .filter(|(_, l)| !l.is_empty())
        .map(|(f, _)| f)
        .collect();
    order.sort_by(|&f, &g| aag.area[g].total_cmp(&aag.area[f]).then(f.cmp(&g)));
    let mut group = 0;
    for seed in order {
        if side[seed].is_some() {
            continue;
        }
        side[seed] = Some((group, 0));
        let mut queue = std::collections::VecDeque::from([(seed, 0u8)]);
        while let Some((f, s)) = queue.pop_front() {
            for &i in &of_face[f] {
                let g = other(&pairs[i as usize], f);
                if side[g].is_none() {
                    side[g] = Some((group, 1 - s));
                    queue.push_back((g, 1 - s));
                }
            }
        }
        group += 1;
    }
    side
}

/// Gives the group of `c` to that of `a`, with `a` and `c` in one colour; says whether they are.
fn merge_groups(side: &mut IndexVec<FaceId, Option<(u32, u8)>>, a: FaceId, c: FaceId) -> bool {
    let (Some((g, s)), Some((h, r))) = (side[a], side[c]) else {
        return false;
    };
    if g == h {
        return s == r;
    }
    for (group, colour) in side.as_mut_slice().iter_mut().flatten() {
        if *group == h {
            (*group, *colour) = (g, *colour ^ s ^ r);
        }
    }
    true
}

/// Gives faces that look into one air groups of their own where the colours oppose them.
///
/// Three walls that meet in a Y part three regions of air, which two colours cannot keep apart: two faces beside the same air may get both. Where such faces
/// meet in an inner corner, or in a fillet, the smaller of them leaves its group; what it is paired with stays opposed to it as a pair.
fn part_airs(
    aag: &Aag,
    joined: &Joined<'_>,
    of_face: &IndexVec<FaceId, Vec<u32>>,
    side: &mut IndexVec<FaceId, Option<(u32, u8)>>,
) {
    let mut corners: Vec<[FaceId; 2]> = (aag.arcs.iter())
        .filter(|a| a.convexity == Convexity::Concave)
        .map(|a| a.faces)
        .collect();
    for (fillet, _) in side.enumerated().filter(|(_, s)| s.is_none()) {
        let beside: Vec<FaceId> = (aag.arcs_of(fillet))
            .filter(|a| a.convexity == Convexity::Smooth)
            .map(|a| Aag::across(a, fillet))
            .collect();
        for (i, &a) in beside.iter().enumerate() {
            corners.extend(beside[i + 1..].iter().map(|&b| [a.min(b), a.max(b)]));
        }
    }
    corners.sort_unstable();
    corners.dedup();
    // The sides of walls that a face lies on.
    let on = |f: FaceId| {
        of_face[f].iter().map(move |&i| {
            let on = joined.side(i, f);
            (on.set, on.second)
        })
    };
    let mut groups = side.iter().flatten().map(|s| s.0 + 1).max().unwrap_or(0);
    for [a, b] in corners {
        let (Some((g, s)), Some((h, r))) = (side[a], side[b]) else {
            continue;
        };
        let one_wall = on(a).any(|(set, second)| on(b).any(|other| other == (set, !second)));
        if g == h && s != r && !one_wall {
            let smaller = if aag.area[a] < aag.area[b] { a } else { b };
            side[smaller] = Some((groups, 0));
            groups += 1;
        }
    }
}

/// The pairs with what they are joined to.
struct Joined<'a> {
    pairs: &'a [FacePair],
    /// The set of each pair, and whether it lies in it the other way round.
    sets: Vec<(u32, bool)>,
    /// The faces on the two sides of each set, at its first pair.
    sides: Vec<[Vec<FaceId>; 2]>,
}

impl<'a> Joined<'a> {
    fn new(pairs: &'a [FacePair], union: &mut SidedDisjoint<FaceId>) -> Self {
        let sets: Vec<(u32, bool)> = (0..pairs.len() as u32).map(|i| union.find(i)).collect();
        let sides = (sets.iter().zip(0..))
            .map(|(set, i)| match set.0 == i {
                true => union.sides(i).clone(),
                false => Default::default(),
            })
            .collect();
        Self { pairs, sets, sides }
    }
}

impl Sides for Joined<'_> {
    fn side(&self, pair: u32, face: FaceId) -> Side {
        let (set, flipped) = self.sets[pair as usize];
        Side {
            set,
            second: (self.pairs[pair as usize].faces[1] == face) ^ flipped,
        }
    }

    fn faces(&self, side: Side) -> &[FaceId] {
        &self.sides[side.set as usize][usize::from(side.second)]
    }
}
