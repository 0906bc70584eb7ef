//! Which rims of the mid-surface go round a small hole, and which of these can be filled.

use super::boundary::{Loop, Skin};
use super::cap::{bent_middle, cap};
use super::walls::{Sheets, absorbed};
use super::{EQUAL, TURN, Taken, Verdict};
use crate::geom::rim_loops::closed_rims;
use crate::model::brep::Facet;
use crate::model::complex::{MidComplex, faces};
use crate::model::ids::{FaceId, FacetId, Id, IndexVec, NodeId, TriangleId, WallId};
use crate::model::removal::{Obstacle, SmallKind};
use crate::model::walls::{Aag, Pairing};
use crate::spatial::TriangleBvh;
use glam::DVec3;
use smallvec::SmallVec;
use std::collections::{BTreeMap, BTreeSet};
use std::f64::consts::{PI, TAU};

/// From this share of a full turn on the faces round a rim may be a bevel within a hole: that of a countersink of 45 degrees is 0.7, the end of a tube has none.
const BEVEL: f64 = 0.3;
/// Ends of a segment are left out by this share of it: where things touch is no crossing.
const ENDS: f64 = 1e-6;

/// A rim of the mid-surface with what the solid has there.
struct Hole {
    ring: Vec<NodeId>,
    /// The faces within it.
    within: BTreeSet<FaceId>,
    loops: Vec<Loop>,
    at: DVec3,
    /// Of the circle that is as long as the longest of its rims, mm.
    diameter: f64,
}

type Stars = IndexVec<NodeId, SmallVec<[TriangleId; 8]>>;

/// Of every hole below the limit (mm) whether it can be filled, in the order of the rims of the complex.
pub(super) fn holes(
    skin: &Skin<'_>,
    aag: &Aag,
    pairing: &Pairing,
    sheets: &Sheets<'_>,
    limit: f64,
) -> Vec<Verdict> {
    let complex = sheets.complex;
    let stars = complex.stars();
    let found: Vec<Hole> = (closed_rims(complex).into_iter())
        .filter_map(|ring| hole(skin, aag, pairing, complex, ring))
        .collect();
    let mut rims_of: BTreeMap<FaceId, usize> = BTreeMap::new();
    for &f in found.iter().flat_map(|f| &f.within) {
        *rims_of.entry(f).or_default() += 1;
    }
    (found.iter())
        .filter(|h| h.diameter < limit * (1.0 - EQUAL))
        // The outside of a small plate turns the other way: no hole at all, and not worth a word.
        .filter(|h| h.loops.iter().all(|l| skin.turning(l, &h.within) > -PI))
        .map(|h| {
            let only = h.within.iter().all(|f| rims_of[f] == 1);
            let taken = match h.loops.len() {
                2 if only => filled(skin, pairing, sheets, &stars, h),
                2 => Err(Obstacle::Rim),
                _ => Err(Obstacle::Open),
            };
            taken.map_err(|why| (SmallKind::Hole, h.at, h.diameter, why))
        })
        .collect()
}

/// The faces that a rim ends on, with those that they hang together with up to the sides of walls, and over bevels; none where these end in no simple loops. A rim that ends in a wall has no faces.
fn hole(
    skin: &Skin<'_>,
    aag: &Aag,
    pairing: &Pairing,
    complex: &MidComplex,
    ring: Vec<NodeId>,
) -> Option<Hole> {
    let lateral = |f: &FaceId| pairing.side[*f].is_none();
    let on = ring.iter().flat_map(|&n| faces(&complex.nodes[n].supports));
    let mut open: Vec<FaceId> = on.filter(lateral).collect();
    let mut within = BTreeSet::new();
    while let Some(f) = open.pop() {
        if within.insert(f) {
            open.extend(aag.arcs_of(f).map(|a| Aag::across(a, f)).filter(lateral));
        }
    }
    let mut loops = skin.loops(&within)?;
    if loops.is_empty() {
        return Some(in_a_wall(complex, ring));
    }
    // A bevel goes with its hole where the rest is a hole still: of two rims, the outer one longer, and no wall of its own, as the end of a funnel has.
    while let Some(bevelled) = loops.iter().find(|l| {
        let turned = skin.turning(l, &within) / TAU;
        (BEVEL..TURN).contains(&turned)
    }) {
        let mut more = within.clone();
        more.extend(skin.across(std::slice::from_ref(bevelled)));
        let mut pairs = pairing.pairs.iter();
        let is_wall = pairs.any(|p| p.faces.iter().all(|f| more.contains(f)));
        let longer = |next: &[Loop]| longest(skin, next) > longest(skin, &loops);
        match skin.loops(&more) {
            Some(next) if !is_wall && next.len() == loops.len() && longer(&next) => {
                (within, loops) = (more, next);
            }
            _ => break,
        }
    }
    let at = loops.iter().map(|l| skin.middle(l)).sum::<DVec3>() / loops.len() as f64;
    Some(Hole {
        diameter: longest(skin, &loops) / PI,
        ring,
        within,
        loops,
        at,
    })
}

/// A rim whose faces are sides of other walls: what it is cannot be told from the solid, only how long it is.
fn in_a_wall(complex: &MidComplex, ring: Vec<NodeId>) -> Hole {
    let points: Vec<DVec3> = ring.iter().map(|&n| complex.nodes[n].point).collect();
    let next = points.iter().cycle().skip(1);
    let length: f64 = points.iter().zip(next).map(|(a, b)| a.distance(*b)).sum();
    Hole {
        at: points.iter().sum::<DVec3>() / points.len() as f64,
        diameter: length / PI,
        within: BTreeSet::new(),
        loops: Vec::new(),
        ring,
    }
}

fn longest(skin: &Skin<'_>, loops: &[Loop]) -> f64 {
    loops.iter().map(|l| skin.length(l)).fold(0.0, f64::max)
}

/// What filling the hole takes, or why it cannot be.
fn filled(
    skin: &Skin<'_>,
    pairing: &Pairing,
    sheets: &Sheets<'_>,
    stars: &Stars,
    hole: &Hole,
) -> Result<Taken, Obstacle> {
    let [a, b] = hole.loops.as_slice() else {
        return Err(Obstacle::Open);
    };
    let within = &hole.within;
    if [a, b].iter().any(|l| skin.turning(l, within) < TURN * TAU) {
        return Err(Obstacle::End);
    }
    let wall = wall_between(skin, pairing, [a, b]).ok_or(Obstacle::Open)?;
    let mut ring = hole.ring.clone();
    ring.sort_unstable();
    let walls = absorbed(pairing, sheets, within, within, wall, &ring).ok_or(Obstacle::Walls)?;
    let of_sheet = |t: &TriangleId| {
        let own = sheets.complex.triangles[*t].wall;
        own == wall || walls.contains(&(own, Some(wall)))
    };
    let mut round = hole.ring.iter().flat_map(|&n| &stars[n]);
    if !round.all(of_sheet) {
        return Err(Obstacle::Rim);
    }
    let mut taken = Taken {
        kind: SmallKind::Hole,
        at: hole.at,
        size: hole.diameter,
        height: pairing.walls[wall].thickness,
        faces: within.clone(),
        ring: Some((hole.ring.clone(), wall)),
        walls,
        ..Taken::default()
    };
    for l in [a, b] {
        taken.close(skin, l)?;
    }
    if obstructed(skin, within, &taken.caps) {
        return Err(Obstacle::Obstructed);
    }
    Ok(taken)
}

/// The wall whose two sides the loops lie on.
fn wall_between(skin: &Skin<'_>, pairing: &Pairing, loops: [&Loop; 2]) -> Option<WallId> {
    let across = loops.map(|l| skin.across(std::slice::from_ref(l)));
    let on = |wall: WallId, k: usize, side: usize| {
        let side = &pairing.walls[wall].sides[side];
        across[k].iter().all(|f| side.binary_search(f).is_ok())
    };
    let between = |w: &WallId| (on(*w, 0, 0) && on(*w, 1, 1)) || (on(*w, 0, 1) && on(*w, 1, 0));
    pairing.walls.ids().find(between)
}

impl Taken {
    /// Adds what closes a loop of its faces' boundary.
    pub(super) fn close(&mut self, skin: &Skin<'_>, of: &Loop) -> Result<(), Obstacle> {
        // Of several faces along the rim the cap is the one's that has the most of it, the lowest of equals.
        let mut shares: BTreeMap<FaceId, usize> = BTreeMap::new();
        for side in &of.sides {
            *shares
                .entry(skin.brep.facets[side.outer.0].face)
                .or_default() += 1;
        }
        let face = shares
            .into_iter()
            .max_by_key(|&(f, n)| (n, std::cmp::Reverse(f)));
        let (face, _) = face.ok_or(Obstacle::Crooked)?;
        let cap = cap(skin, of, &self.faces, face).ok_or(Obstacle::Crooked)?;
        if cap.is_empty() {
            // Of a hole as coarse as two arcs the two lips are one side of the facets when nothing is between them.
            let normals = skin.normals(of, &self.faces).ok_or(Obstacle::Crooked)?;
            if let ([one, other], [n, m]) = (of.sides.as_slice(), normals.as_slice()) {
                let ends = [one.from, one.to].map(|v| skin.brep.vertices[v]);
                let mid = bent_middle(ends, [*n, *m]);
                self.lips
                    .extend([one, other].map(|s| (s.outer.0, s.outer.1, mid)));
            }
        }
        self.caps.extend(cap);
        Ok(())
    }
}

/// Whether other facets of the solid cross the caps.
fn obstructed(skin: &Skin<'_>, within: &BTreeSet<FaceId>, caps: &[Facet]) -> bool {
    let place = |v| skin.brep.vertices[v];
    let flat: Vec<[DVec3; 3]> = caps.iter().map(|c| c.corners.map(place)).collect();
    if flat.is_empty() {
        return false;
    }
    let points = || flat.iter().flatten();
    let low = points().fold(DVec3::INFINITY, |l, &p| l.min(p));
    let high = points().fold(DVec3::NEG_INFINITY, |h, &p| h.max(p));
    let caps = TriangleBvh::new(&flat);
    let crosses = |a: DVec3, b: DVec3| {
        if a.max(b).cmplt(low).any() || a.min(b).cmpgt(high).any() {
            return false;
        }
        let (way, length) = ((b - a).normalize_or_zero(), a.distance(b));
        let [least, most] = [ENDS, 1.0 - ENDS].map(|share| share * length);
        (caps.first_hit_beyond(a, way, least)).is_some_and(|(_, hit)| hit.t < most)
    };
    (0..skin.brep.facets.len()).map(FacetId::new).any(|f| {
        let facet = skin.brep.facets[f];
        let [a, b, c] = facet.corners.map(place);
        !within.contains(&facet.face) && (crosses(a, b) || crosses(b, c) || crosses(c, a))
    })
}
