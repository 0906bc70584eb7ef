//! Defeature: small holes are filled and small features flattened, on the boundary that distances are taken to and on the mid-surface at once.
//!
//! The faces within a hole or of a feature exist no longer for all that follows: the faces round them are carried on over the gap by facets of their own, so that the mid-surface, the
//! thickness, sizes and the audit see a solid that never had it. Nodes, pairs and walls of everything else stay as they are, and the solid that was read is not touched: without the limits all is as before.
//! A hole is a closed rim of the mid-surface whose faces lead from one side of a wall to the other, each time to a loop that turns full circle on its side; a feature is what hangs on one side by one such loop.
//!
//! Guarantees: a boundary that is closed if it was, with the Euler characteristic of a solid without its holes (two more a hole); the mid-surface's grows by one a hole; what stays though it is small enough is told
//! with the reason. Limits: a hole that ends in more than one wall stays; the disc over it is as fair as the surface round its rim says, which knows nothing further away.
//! Cost: linear in the facets within what is small, but for one look at all facets a hole.
//!
//! After the virtual topology of F. Wang et al., Mid-surface mesh abstraction for thin-walled structures based on virtual topology (2025): faces are changed, never the geometry.

mod boundary;
mod cap;
mod features;
mod holes;
mod walls;

use crate::model::brep::{Brep, Facet};
use crate::model::complex::{MidComplex, MidNode, MidTriangle, Support, Supports};
use crate::model::ids::{FaceId, FacetId, NodeId, WallId};
use crate::model::removal::{Left, Obstacle, Removal, SmallKind, SmallLimits};
use crate::model::walls::{Aag, Pairing};
use boundary::Skin;
use glam::DVec3;
use std::cmp::Ordering;
use std::collections::{BTreeMap, BTreeSet};
use walls::{Endings, Sheets};

/// A rim that turns by less than this share of a full turn goes round the end of a wall: the disc that closes it would have to bend by the rest. A cone's top is one from 53 degrees
/// of half its angle, a dome's from 37 degrees off its pole.
const TURN: f64 = 0.8;
/// Sizes that differ by less than this share are equal: rounding, so that what has just the size of the limit stays.
const EQUAL: f64 = 1e-6;

/// A solid without what is small, and its mid-surface.
#[derive(Clone, Debug, PartialEq)]
#[must_use]
pub struct Defeatured {
    /// The boundary; faces that are gone have no facets, curves that are gone no segments.
    pub brep: Brep,
    /// Pairs and walls without the faces that are gone.
    pub pairing: Pairing,
    /// The mid-surface, not placed yet.
    pub complex: MidComplex,
    /// What was taken out.
    pub removed: Vec<Removal>,
    /// What is small enough and stays.
    pub left: Vec<Left>,
}

/// What taking something out means.
#[derive(Clone, Debug, Default)]
struct Taken {
    kind: SmallKind,
    at: DVec3,
    size: f64,
    height: f64,
    faces: BTreeSet<FaceId>,
    /// The facets that close the sides.
    caps: Vec<Facet>,
    /// Sides of facets whose mid-side points move.
    lips: Vec<(FacetId, usize, DVec3)>,
    /// The rim of the mid-surface that is filled, and the wall that goes on there.
    ring: Option<(Vec<NodeId>, WallId)>,
    /// What becomes of walls that end.
    walls: Endings,
}

/// What can be taken out, or kind, place, size and why it stays.
type Verdict = Result<Taken, (SmallKind, DVec3, f64, Obstacle)>;

/// Fills the holes of a solid that are below their limit.
pub fn fill_holes(
    brep: &Brep,
    aag: &Aag,
    pairing: &Pairing,
    complex: &MidComplex,
    limits: &SmallLimits,
) -> Defeatured {
    let skin = Skin::new(brep);
    let sheets = Sheets::new(complex);
    let verdicts = limits.hole.map_or_else(Vec::new, |limit| {
        holes::holes(&skin, aag, pairing, &sheets, limit)
    });
    applied(brep, pairing, complex, verdicts)
}

/// Flattens the features of a solid that are below their limit.
pub fn flatten_features(
    brep: &Brep,
    aag: &Aag,
    pairing: &Pairing,
    complex: &MidComplex,
    limits: &SmallLimits,
) -> Defeatured {
    let skin = Skin::new(brep);
    let sheets = Sheets::new(complex);
    let verdicts = limits.feature.map_or_else(Vec::new, |limit| {
        features::features(&skin, aag, pairing, &sheets, limit)
    });
    applied(brep, pairing, complex, verdicts)
}

fn applied(
    brep: &Brep,
    pairing: &Pairing,
    complex: &MidComplex,
    verdicts: Vec<Verdict>,
) -> Defeatured {
    let (mut taken, mut left): (Vec<Taken>, Vec<Left>) = (Vec::new(), Vec::new());
    for verdict in verdicts {
        match verdict {
            Ok(one) => taken.push(one),
            Err((kind, at, size, why)) => left.push(Left {
                kind,
                solid: brep.solid_tag,
                at,
                size,
                why,
            }),
        }
    }
    // Found in the order of nodes, told in that of places.
    let by_place = |a: DVec3, b: DVec3| {
        let axes = a.to_array().into_iter().zip(b.to_array());
        axes.map(|(a, b)| a.total_cmp(&b))
            .fold(Ordering::Equal, Ordering::then)
    };
    taken.sort_by(|a, b| by_place(a.at, b.at));
    left.sort_by(|a, b| by_place(a.at, b.at));
    let gone: BTreeSet<FaceId> = taken.iter().flat_map(|t| t.faces.iter().copied()).collect();
    let removal = |t: &Taken| Removal {
        kind: t.kind,
        solid: brep.solid_tag,
        at: t.at,
        size: t.size,
        height: t.height,
        faces: t.faces.iter().map(|&f| brep.faces[f].tag).collect(),
        sheet: None,
    };
    Defeatured {
        brep: without_faces(brep, &gone, &taken),
        pairing: without_sides(pairing, &gone),
        complex: carried_on(complex, &taken),
        removed: taken.iter().map(removal).collect(),
        left,
    }
}

/// The boundary without some faces, closed.
fn without_faces(brep: &Brep, gone: &BTreeSet<FaceId>, taken: &[Taken]) -> Brep {
    let mut facets = brep.facets.clone();
    for &(facet, side, mid) in taken.iter().flat_map(|t| &t.lips) {
        facets[facet].mids[side] = mid;
    }
    let mut new = Brep {
        facets: (facets.iter().copied())
            .filter(|f| !gone.contains(&f.face))
            .chain(taken.iter().flat_map(|t| t.caps.iter().copied()))
            .collect(),
        ..brep.clone()
    };
    for (id, curve) in brep.curves.enumerated() {
        if curve.faces.iter().any(|f| gone.contains(f)) {
            new.curves[id].segments.clear();
            new.curves[id].faces.clear();
            for &f in &curve.faces {
                new.faces[f].curves.retain(|&c| c != id);
            }
        }
    }
    new
}

fn without_sides(pairing: &Pairing, gone: &BTreeSet<FaceId>) -> Pairing {
    let mut new = pairing.clone();
    new.pairs
        .retain(|p| !p.faces.iter().any(|f| gone.contains(f)));
    for side in new.walls.iter_mut().flat_map(|w| &mut w.sides) {
        side.retain(|f| !gone.contains(f));
    }
    for &f in gone {
        new.side[f] = None;
    }
    new
}

/// The mid-surface with rims filled by fans of triangles, and sheets of walls that end carried on as those round them, or left out.
fn carried_on(complex: &MidComplex, taken: &[Taken]) -> MidComplex {
    let mut new = complex.clone();
    let endings: BTreeMap<WallId, Option<WallId>> =
        taken.iter().flat_map(|t| t.walls.iter().copied()).collect();
    new.triangles = (complex.triangles.iter())
        .filter_map(|t| {
            let wall = endings.get(&t.wall).copied().unwrap_or(Some(t.wall))?;
            Some(MidTriangle { wall, ..*t })
        })
        .collect();
    let stars = complex.stars();
    for (ring, wall) in taken.iter().filter_map(|t| t.ring.as_ref()) {
        let points = ring.iter().map(|&n| complex.nodes[n].point);
        let centre = new.nodes.push(MidNode {
            point: points.sum::<DVec3>() / ring.len() as f64,
            supports: Supports::new(),
        });
        for (k, &a) in ring.iter().enumerate() {
            let b = ring[(k + 1) % ring.len()];
            new.nodes[a]
                .supports
                .retain(|s| matches!(s, Support::Mid(_)));
            // Wound as the triangle across: that has the edge the other way.
            let forth = stars[a].iter().any(|&t| complex.triangles[t].runs([a, b]));
            let [a, b] = if forth { [b, a] } else { [a, b] };
            new.triangles.push(MidTriangle {
                nodes: [a, b, centre],
                wall: *wall,
            });
        }
    }
    new.support_by_walls();
    new.without_orphans()
}

#[cfg(test)]
mod tests;
