//! Faces that meet themselves in a corner: one part a side.

use super::parted;
use crate::geom::six_node;
use crate::model::brep::Brep;
use crate::model::disjoint::Disjoint;
use crate::model::ids::{FaceId, FacetId, VertexId};
use glam::DVec3;
use std::cmp::Reverse;
use std::collections::{BTreeMap, BTreeSet, BinaryHeap};

/// A face that turns more than this at a side of its facets turns in a corner there.
const CORNER_RAD: f64 = 20.0 * std::f64::consts::PI / 180.0;
/// And where the facets themselves bend by less than this share of it: those that divide a small hole in four bend as much as they turn.
const WITHIN: f64 = 0.5;

/// A common side of two facets of one face.
struct Side {
    ends: [VertexId; 2],
    facets: [FacetId; 2],
    /// Angle between the outward normals there, rad, without its sign.
    turn: f64,
}

/// The boundary with every face in two that meets itself in a corner, as the skin of a wing does at its trailing edge; `None` where there is no such face.
///
/// A facet goes with the side of the corner that is nearer on the face, so that the border lies midway. A corner that ends within the face does not part it.
/// Cost: a sort of the facets' sides; where faces are parted, a heap of their facets.
pub fn divide_at_corners(brep: &Brep) -> Option<Brep> {
    let sides = own_sides(brep);
    let is_corner =
        |s: &Side| s.turn > CORNER_RAD && s.facets.iter().all(|&f| bend(brep, f) < WITHIN * s.turn);
    let corners: Vec<usize> = (0..sides.len()).filter(|&i| is_corner(&sides[i])).collect();
    let seeds = seeds(&sides, &corners);
    if seeds.is_empty() {
        return None;
    }
    let faces: BTreeSet<FaceId> = seeds.iter().map(|s| brep.facets[s.0].face).collect();
    let is_corner: BTreeSet<[VertexId; 2]> = corners.iter().map(|&i| sides[i].ends).collect();
    let nearest = nearest(brep, &sides, &is_corner, &seeds);
    let facets: Vec<FacetId> = (brep.facets.enumerated())
        .filter(|(_, f)| faces.contains(&f.face))
        .map(|(id, _)| id)
        .collect();
    // What no seed reaches, beyond a pinched vertex, stays with the face itself.
    let region: Vec<u32> = (facets.iter())
        .map(|f| nearest.get(f).copied().unwrap_or(u32::MAX))
        .collect();
    parted(brep, &facets, &region)
}

/// Sides with a facet of one face on either hand, sorted by their ends.
fn own_sides(brep: &Brep) -> Vec<Side> {
    let mut all: Vec<([VertexId; 2], FacetId, usize)> = Vec::with_capacity(3 * brep.facets.len());
    for (id, f) in brep.facets.enumerated() {
        for k in 0..3 {
            let (a, b) = (f.corners[k], f.corners[(k + 1) % 3]);
            all.push(([a.min(b), a.max(b)], id, k));
        }
    }
    all.sort_unstable();
    (all.chunk_by(|a, b| a.0 == b.0))
        .filter_map(|run| match *run {
            [(ends, f, j), (_, g, k)] if brep.facets[f].face == brep.facets[g].face => Some(Side {
                ends,
                facets: [f, g],
                turn: six_node::turn(brep, (f, j), (g, k)).abs(),
            }),
            _ => None,
        })
        .collect()
}

/// Largest angle between the normals at the middles of a facet's sides, rad.
fn bend(brep: &Brep, facet: FacetId) -> f64 {
    let normals = six_node::SIDE_MIDDLE
        .map(|(u, v)| six_node::normal(&brep.corners(facet), &brep.facets[facet].mids, u, v));
    (0..3)
        .map(|k| normals[k].angle_between(normals[(k + 1) % 3]))
        .fold(0.0, f64::max)
}

/// The facets at corners, with a number for each hand of each corner: those round its vertices that hang together without it. A hand that has corners with several others
/// is a strip of a bend that coarse facets follow.
fn seeds(sides: &[Side], corners: &[usize]) -> Vec<(FacetId, u32)> {
    let at: BTreeSet<VertexId> = corners.iter().flat_map(|&i| sides[i].ends).collect();
    let round: Vec<&Side> = (sides.iter().enumerate())
        .filter(|(i, s)| corners.binary_search(i).is_err() && s.ends.iter().any(|v| at.contains(v)))
        .map(|(_, s)| s)
        .collect();
    let facets: BTreeSet<FacetId> = (round.iter().map(|s| s.facets))
        .chain(corners.iter().map(|&i| sides[i].facets))
        .flatten()
        .collect();
    let place: BTreeMap<FacetId, u32> = facets.iter().copied().zip(0..).collect();
    let mut hands = Disjoint::new(facets.len());
    for side in round {
        let [a, b] = side.facets.map(|f| place[&f]);
        hands.join(a, b);
    }
    let pairs: Vec<[(FacetId, u32); 2]> = (corners.iter())
        .map(|&i| sides[i].facets.map(|f| (f, hands.find(place[&f]))))
        .collect();
    let mut across: BTreeMap<u32, BTreeSet<u32>> = BTreeMap::new();
    for &[(_, a), (_, b)] in &pairs {
        across.entry(a).or_default().insert(b);
        across.entry(b).or_default().insert(a);
    }
    let parts = |[a, b]: [u32; 2]| a != b && across[&a].len() == 1 && across[&b].len() == 1;
    let mut seeds: Vec<(FacetId, u32)> = (pairs.into_iter())
        .filter(|pair| parts(pair.map(|(_, hand)| hand)))
        .flatten()
        .collect();
    seeds.sort_unstable();
    seeds.dedup();
    seeds
}

/// The number of the seed nearest to each facet, along the middles of facets and not over corners.
fn nearest(
    brep: &Brep,
    sides: &[Side],
    corners: &BTreeSet<[VertexId; 2]>,
    seeds: &[(FacetId, u32)],
) -> BTreeMap<FacetId, u32> {
    let faces: BTreeSet<FaceId> = seeds.iter().map(|s| brep.facets[s.0].face).collect();
    let mut beside: BTreeMap<FacetId, Vec<FacetId>> = BTreeMap::new();
    for side in sides {
        let [f, g] = side.facets;
        if faces.contains(&brep.facets[f].face) && !corners.contains(&side.ends) {
            beside.entry(f).or_default().push(g);
            beside.entry(g).or_default().push(f);
        }
    }
    let middle = |f: FacetId| brep.corners(f).iter().sum::<DVec3>() / 3.0;
    // Distances are not negative, so that their bits are in their order.
    let mut heap: BinaryHeap<Reverse<(u64, u32, FacetId)>> =
        seeds.iter().map(|&(f, s)| Reverse((0, s, f))).collect();
    let mut found = BTreeMap::new();
    while let Some(Reverse((far, seed, facet))) = heap.pop() {
        if found.contains_key(&facet) {
            continue;
        }
        found.insert(facet, seed);
        for &next in beside.get(&facet).into_iter().flatten() {
            let far = f64::from_bits(far) + middle(facet).distance(middle(next));
            heap.push(Reverse((far.to_bits(), seed, next)));
        }
    }
    found
}
