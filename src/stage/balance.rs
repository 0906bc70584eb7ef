//! Balance: the mesh of a curved wall is drawn to lie as much on one side of the mid-surface as on the other.
//!
//! With all nodes on the mid-surface a flat triangle lies wholly on the hollow side of a bend, by up to h²/8R: the mesh has too little area, and all of
//! its inner points err the same way. Here each node is moved to the bulging side by the mean error of the triangles round it, so that errors of both signs
//! are left and none is larger than about half of what it was. The mean of a quadratic over a triangle is that of its values at the middles of
//! the sides; the error of a flat triangle against a smooth surface is one, to leading order.
//!
//! Guarantees: topology, walls and supports untouched; on flat walls nothing moves; no node moves further than a small share of the thickness; no triangle is
//! turned or folded by it. Where no middle is defined, or the mesh is further away than bends account for, nothing is asked.
//! Limits: a rim slides along the normal of its sheet, which leaves a slanted lateral face by the sine of the slant times that shift.
//! Cost: one query a side of a triangle; linear.
//!
//! Where the sheets that meet in a node want different shifts, it takes the least one that suits them all in the least-squares sense, as in placing.

use crate::geom::orient::folded;
use crate::geom::placer::Placer;
use crate::geom::planes;
use crate::model::complex::MidComplex;
use crate::model::ids::{IndexVec, NodeId, TriangleId, WallId};
use glam::DVec3;
use rayon::prelude::*;
use smallvec::SmallVec;

/// A mesh further from the mid-surface than this share of the thickness does not follow it for another reason than the length of its edges: twice what half an
/// edge of half a thickness leaves in a bend as tight as the wall is thick.
const BENT: f64 = 0.1;
/// Shifts are that of the triangles round a node, more only where these meet at a slant, and never more than so many times the largest.
const SLANT: f64 = 2.0;
/// Normals turn by less than this cosine, ten degrees: only slivers would turn more.
const STEADY: f64 = 0.985;

/// How far, and which way, the mid-surface lies from a part of the mesh.
type Way = (DVec3, f64);
/// What is known of the middle of an edge, for each of its walls.
type Ways = SmallVec<[(WallId, Option<Way>); 2]>;

/// Moves the nodes of curved walls.
pub fn balance(complex: MidComplex, placer: &dyn Placer) -> MidComplex {
    let ways = ways(&complex, placer);
    let stars = complex.stars();
    let area: IndexVec<TriangleId, DVec3> = areas(&complex);
    let shifts: Vec<DVec3> = stars
        .as_slice()
        .par_iter()
        .map(|star| shift(star, &ways, &area))
        .collect();
    let mut shifts: IndexVec<NodeId, DVec3> = shifts.into();
    steady(&complex, &area, &mut shifts);
    let before = folded(&complex);
    loop {
        let moved = moved(&complex, &shifts);
        let mut new = folded(&moved);
        new.retain(|t| before.binary_search(t).is_err());
        if new.is_empty() {
            return moved;
        }
        // What has no shift left was folded by its neighbours'.
        let round = new.iter().flat_map(|&t| complex.triangles[t].nodes);
        let ring: Vec<TriangleId> = round.flat_map(|n| stars[n].iter().copied()).collect();
        take_back(&complex, &ring, &mut shifts);
    }
}

fn moved(complex: &MidComplex, shifts: &IndexVec<NodeId, DVec3>) -> MidComplex {
    let mut moved = complex.clone();
    for (node, shift) in moved.nodes.as_mut_slice().iter_mut().zip(shifts) {
        node.point += *shift;
    }
    moved
}

/// No shift for the nodes of these.
fn take_back(complex: &MidComplex, triangles: &[TriangleId], shifts: &mut IndexVec<NodeId, DVec3>) {
    for n in triangles.iter().flat_map(|&t| complex.triangles[t].nodes) {
        shifts[n] = DVec3::ZERO;
    }
}

/// From every triangle to its mid-surface, on average.
fn ways(complex: &MidComplex, placer: &dyn Placer) -> IndexVec<TriangleId, Option<Way>> {
    let edges = complex.edges();
    let at_edges: Vec<Ways> = edges
        .par_iter()
        .map(|edge| {
            let [a, b] = edge.ends.map(|n| complex.nodes[n].point);
            let mut found = Ways::new();
            for wall in edge.triangles.iter().map(|&t| complex.triangles[t].wall) {
                if found.iter().all(|f| f.0 != wall) {
                    found.push((wall, placer.to_middle((a + b) / 2.0, wall)));
                }
            }
            found
        })
        .collect();
    let mut sums: IndexVec<TriangleId, (DVec3, f64, usize)> =
        IndexVec::filled((DVec3::ZERO, 0.0, 0), complex.triangles.len());
    for (edge, found) in edges.iter().zip(&at_edges) {
        for &t in &edge.triangles {
            let wall = complex.triangles[t].wall;
            let way = found.iter().find(|f| f.0 == wall).and_then(|f| f.1);
            if let Some((normal, offset)) = way {
                let (normals, offsets, count) = &mut sums[t];
                *normals += normal;
                *offsets += offset;
                *count += 1;
            }
        }
    }
    let mean = |(t, &(normals, offsets, count)): (TriangleId, &(DVec3, f64, usize))| {
        let wall = complex.triangles[t].wall;
        let offset = offsets / 3.0;
        let centre = complex.corners(&complex.triangles[t]);
        let thickness = placer.thickness(centre.iter().sum::<DVec3>() / 3.0, wall)?;
        let bent = count == 3 && offset.abs() <= BENT * thickness;
        Some((normals.try_normalize().filter(|_| bent)?, offset))
    };
    sums.enumerated().map(mean).collect()
}

fn areas(complex: &MidComplex) -> IndexVec<TriangleId, DVec3> {
    complex
        .triangles
        .iter()
        .map(|t| complex.area_vector(t))
        .collect()
}

/// What the triangles round a node want of it, by area.
fn shift(
    star: &[TriangleId],
    ways: &IndexVec<TriangleId, Option<Way>>,
    area: &IndexVec<TriangleId, DVec3>,
) -> DVec3 {
    let mut most = 0.0f64;
    let wanted: SmallVec<[Way; 8]> = star
        .iter()
        .filter_map(|&t| {
            let (normal, offset) = ways[t]?;
            most = most.max(offset.abs());
            let weight = area[t].length().sqrt();
            Some((normal * weight, offset * weight))
        })
        .collect();
    if most == 0.0 {
        return DVec3::ZERO;
    }
    planes::meet(&wanted).clamp_length_max(SLANT * most)
}

/// Takes the shifts back that turn a triangle; that may turn its neighbour, if that is as small.
fn steady(
    complex: &MidComplex,
    area: &IndexVec<TriangleId, DVec3>,
    shifts: &mut IndexVec<NodeId, DVec3>,
) {
    loop {
        let turned: Vec<TriangleId> = complex
            .triangles
            .as_slice()
            .par_iter()
            .enumerate()
            .filter(|(i, triangle)| {
                let [a, b, c] = triangle.nodes.map(|n| complex.nodes[n].point + shifts[n]);
                let (now, then) = ((b - a).cross(c - a) / 2.0, area[TriangleId(*i as u32)]);
                let moved = triangle.nodes.iter().any(|&n| shifts[n] != DVec3::ZERO);
                moved && now.dot(then) < STEADY * now.length() * then.length()
            })
            .map(|(i, _)| TriangleId(i as u32))
            .collect();
        if turned.is_empty() {
            return;
        }
        take_back(complex, &turned, shifts);
    }
}

#[cfg(test)]
mod tests;
