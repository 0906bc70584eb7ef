//! Small things that stand out of one side of a wall or are sunk into it: logos, embossings, pockets, bosses. Each hangs on its side by one loop alone.

use super::boundary::{Loop, Skin};
use super::walls::{Endings, Sheets, absorbed};
use super::{EQUAL, TURN, Taken, Verdict};
use crate::model::ids::{FaceId, Id, VertexId, WallId};
use crate::model::removal::{Obstacle, SmallKind};
use crate::model::walls::{Aag, Pairing};
use glam::DVec3;
use std::cmp::Reverse;
use std::collections::BTreeSet;
use std::f64::consts::TAU;

/// What hangs on a side by one loop.
struct Feature {
    ground: FaceId,
    rim: Loop,
    faces: BTreeSet<FaceId>,
    at: DVec3,
    extent: f64,
    height: f64,
}

/// Of every feature below the limit (mm) whether it can be flattened, the largest first.
pub(super) fn features(
    skin: &Skin<'_>,
    aag: &Aag,
    pairing: &Pairing,
    sheets: &Sheets<'_>,
    limit: f64,
) -> Vec<Verdict> {
    let small: Vec<bool> = (skin.brep.faces.ids())
        .map(|f| extent_of(skin, f) < limit * 3f64.sqrt())
        .collect();
    let mut found: Vec<Feature> = Vec::new();
    for ground in (skin.brep.faces.ids()).filter(|&f| pairing.side[f].is_some()) {
        let rims = skin.loops(&BTreeSet::from([ground])).unwrap_or_default();
        // A single rim is the outer one.
        for rim in rims.iter().filter(|_| rims.len() > 1) {
            found.extend(feature(skin, aag, &small, ground, rim).filter(|f| {
                let size = f.extent.max(f.height);
                size < limit * (1.0 - EQUAL)
            }));
        }
    }
    // What stands on a feature goes with it.
    found.sort_by_key(|f| Reverse(f.faces.len()));
    let mut seen: BTreeSet<FaceId> = BTreeSet::new();
    found.retain(|f| {
        let new = !seen.contains(&f.ground) && f.faces.is_disjoint(&seen);
        if new {
            seen.extend(&f.faces);
        }
        new
    });
    verdicts(skin, pairing, sheets, &found)
}

/// Diagonal of the box round a face, mm: of what lies within a circle and a height below a limit at most √3 of that.
fn extent_of(skin: &Skin<'_>, face: FaceId) -> f64 {
    let facets = skin.of_face[face].iter();
    let points = facets.flat_map(|&f| skin.brep.corners(f));
    let none = [DVec3::INFINITY, DVec3::NEG_INFINITY];
    let [low, high] = points.fold(none, |[l, h], p| [l.min(p), h.max(p)]);
    (high - low).max(DVec3::ZERO).length()
}

/// What hangs on the ground by this rim of it alone, if all of its faces are small and it is a disc.
fn feature(
    skin: &Skin<'_>,
    aag: &Aag,
    small: &[bool],
    ground: FaceId,
    rim: &Loop,
) -> Option<Feature> {
    let mut open: Vec<FaceId> = skin.across(std::slice::from_ref(rim)).into_iter().collect();
    let mut faces = BTreeSet::new();
    while let Some(f) = open.pop() {
        if !small[f.index()] {
            return None;
        }
        if faces.insert(f) {
            let beside = aag.arcs_of(f).map(|a| Aag::across(a, f));
            open.extend(beside.filter(|&g| g != ground));
        }
    }
    let [rim] = <[Loop; 1]>::try_from(skin.loops(&faces)?).ok()?;
    if euler(skin, &faces) != 1 || skin.turning(&rim, &faces) < TURN * TAU {
        return None;
    }
    let up = (skin.normals(&rim, &faces)?.iter().sum::<DVec3>()).try_normalize()?;
    let at = skin.middle(&rim);
    let facets = faces.iter().flat_map(|&f| &skin.of_face[f]);
    let away = facets
        .flat_map(|&f| skin.brep.corners(f))
        .map(|p| ((p - at).reject_from(up).length(), (p - at).dot(up).abs()));
    let (radius, height) = away.fold((0.0, 0.0), |(r, h): (f64, f64), (a, b)| {
        (r.max(a), h.max(b))
    });
    Some(Feature {
        ground,
        rim,
        faces,
        at,
        extent: 2.0 * radius,
        height,
    })
}

/// Euler characteristic of a set of faces.
fn euler(skin: &Skin<'_>, faces: &BTreeSet<FaceId>) -> i64 {
    let (mut vertices, mut sides) = (BTreeSet::<VertexId>::new(), BTreeSet::new());
    let mut facets = 0;
    for &f in faces.iter().flat_map(|&f| &skin.of_face[f]) {
        let c = skin.brep.facets[f].corners;
        facets += 1;
        vertices.extend(c);
        sides.extend([0, 1, 2].map(|k| {
            let (a, b) = (c[k], c[(k + 1) % 3]);
            [a.min(b), a.max(b)]
        }));
    }
    vertices.len() as i64 - sides.len() as i64 + facets
}

/// Of features that may share walls (a bump on one side, its hollow on the other) those that can go together.
fn verdicts(
    skin: &Skin<'_>,
    pairing: &Pairing,
    sheets: &Sheets<'_>,
    found: &[Feature],
) -> Vec<Verdict> {
    let mut goes: Vec<bool> = vec![true; found.len()];
    loop {
        let going = found.iter().zip(&goes).filter(|(_, goes)| **goes);
        let gone: BTreeSet<FaceId> = going.flat_map(|(f, _)| f.faces.iter().copied()).collect();
        let walls: Vec<Option<Endings>> = (found.iter().zip(&goes))
            .map(|(f, goes)| goes.then(|| walls_of(pairing, sheets, &gone, f)).flatten())
            .collect();
        let now: Vec<bool> = walls.iter().map(Option::is_some).collect();
        if now == goes {
            let all = found.iter().zip(walls);
            return all.map(|(f, walls)| verdict(skin, f, walls)).collect();
        }
        goes = now;
    }
}

/// The walls that go with a feature, each with the wall of the ground: none where sheets of theirs can neither lie in it nor be left out.
fn walls_of(
    pairing: &Pairing,
    sheets: &Sheets<'_>,
    gone: &BTreeSet<FaceId>,
    feature: &Feature,
) -> Option<Endings> {
    let on_ground = |w: &WallId| {
        let sides = pairing.walls[*w].sides.iter();
        sides
            .into_iter()
            .any(|s| s.binary_search(&feature.ground).is_ok())
    };
    // The ground may be a side of several walls: the one that takes all that lies across.
    let mut walls = pairing.walls.ids().filter(on_ground);
    walls.find_map(|wall| absorbed(pairing, sheets, gone, &feature.faces, wall, &[]))
}

fn verdict(skin: &Skin<'_>, f: &Feature, walls: Option<Endings>) -> Verdict {
    let taken = || {
        let mut taken = Taken {
            kind: SmallKind::Feature,
            at: f.at,
            size: f.extent,
            height: f.height,
            faces: f.faces.clone(),
            walls: walls.ok_or(Obstacle::Walls)?,
            ..Taken::default()
        };
        taken.close(skin, &f.rim)?;
        Ok(taken)
    };
    taken().map_err(|why| (SmallKind::Feature, f.at, f.extent, why))
}
