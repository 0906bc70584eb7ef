//! Landing: which face ends a sheet, where the labels name one that the mid-surface does not meet.
//!
//! ```text
//!      _____________________
//!                           \  chamfer            The labels of the two sides part on the end face, the middle of the wall runs into the chamfer: the rim lies there.
//!      - - - - - - - - - - - o                    So it is where a lip hangs over the end of a thick wall, and at a narrow ledge along a lateral face.
//!      ______________________|  end face
//! ```
//! A node that lies beyond the end of its face, or whose face runs along the wall, is carried on over the mid-surface, from one thickness inside, to where that leaves
//! the material. That face takes the place of the one it had.
//!
//! Guarantees: a node on its face keeps it; a new face is none of the wall's sides, no further off than the old one could be, and the node placed on it lies on it.
//! Limits: nodes of junctions follow their neighbours on the rim only. Cost: a nearest-point query a node of a rim, and a ray for those that lie off.

use super::{Look, Rims};
use crate::model::complex::{MidComplex, MidNode, Support, Supports, faces};
use crate::model::ids::{FaceId, FacetId, NodeId};
use glam::DVec3;
use rayon::prelude::*;

/// A node lies on its face up to this far beyond the end of it, in thicknesses: far above the sag of flat facets along a curved end.
const OFF: f64 = 0.05;
/// A face whose normal is within this cosine of the wall's runs along it: where they meet is nowhere in particular (15 degrees, as in `geom::planes`).
const ALONG: f64 = 0.966;
/// How far inside the wall the way out begins, in thicknesses: inside of the steepest chamfers.
const INSIDE: f64 = 1.0;
/// Where the mid-surface comes out is at most this far from where the node was, in thicknesses: a lip or a ledge of half of one, and as much again for its end.
const LANDS: f64 = 0.75;

/// Puts nodes of rims that lie off their faces on the faces that the mid-surface meets.
pub(super) fn land(complex: &mut MidComplex, rims: &Rims, look: &Look<'_>) {
    let outwards = rims.outwards(complex);
    let found = |complex: &MidComplex, sheets: fn(usize) -> bool| -> Vec<(NodeId, MidNode)> {
        let ids: Vec<NodeId> = complex.nodes.ids().collect();
        ids.par_iter()
            .filter(|&&n| {
                let supports = &complex.nodes[n].supports;
                let lying = faces(supports).count();
                !rims.along[n].is_empty() && lying > 0 && sheets(supports.len() - lying)
            })
            .filter_map(|&n| {
                let end = outwards[n].try_normalize()?;
                Some((n, landed(&complex.nodes[n], end, look)?))
            })
            .collect()
    };
    let ends = found(complex, |sheets| sheets == 1);
    let changed: Vec<NodeId> = ends.iter().map(|x| x.0).collect();
    for (n, node) in ends {
        complex.nodes[n] = node;
    }
    if changed.is_empty() {
        return;
    }
    for (n, node) in found(complex, |sheets| sheets > 1) {
        let told = rims.along[n].iter().any(|m| {
            changed.binary_search(m).is_ok()
                && faces(&complex.nodes[*m].supports).any(|f| faces(&node.supports).any(|g| f == g))
        });
        if told {
            complex.nodes[n] = node;
        }
    }
}

/// The node on the face that its mid-surfaces meet, if it lies off one of its own.
fn landed(node: &MidNode, outwards: DVec3, look: &Look<'_>) -> Option<MidNode> {
    let mids: Supports = (node.supports.iter().copied())
        .filter(|s| matches!(s, Support::Mid(_)))
        .collect();
    let &Support::Mid(wall) = mids.first()? else {
        return None;
    };
    let lies_on = |p: DVec3, face: FaceId| -> Option<bool> {
        let thickness = look.placer.thickness(p, wall)?;
        let across = look.placer.normal(p, wall)?;
        let near = look
            .bvh
            .nearest_where(p, thickness, |i| look.face(i) == face);
        Some(near.is_some_and(|near| {
            let normal = look.normal(near.index);
            let away = p - near.point;
            let beyond = away - normal * away.dot(normal);
            normal.dot(across).abs() < ALONG && beyond.length() <= OFF * thickness
        }))
    };
    let p = look.placer.place(node.point, &node.supports);
    let off: Supports = faces(&node.supports)
        .filter(|&f| lies_on(p, f) == Some(false))
        .map(Support::Face)
        .collect();
    if off.is_empty() {
        return None;
    }
    let thickness = look.placer.thickness(p, wall)?;
    let inside = look.placer.place(p - outwards * INSIDE * thickness, &mids);
    let way = (look.placer.place(p, &mids) - inside).try_normalize()?;
    let (facet, length) = look.bvh.first_hit(inside, way)?;
    let (face, out) = (look.face(facet), inside + way * length);
    let side = |s: &Support| matches!(*s, Support::Mid(w) if look.is_side(w, face));
    if look.normal(facet).dot(way) <= 0.0
        || out.distance(p) > LANDS * thickness
        || mids.iter().any(side)
    {
        return None;
    }
    let mut supports = node.supports.clone();
    supports.retain(|s| !off.contains(s));
    supports.push(Support::Face(face));
    supports.sort_unstable();
    supports.dedup();
    let point = look.placer.place(out, &supports);
    lies_on(point, face)?.then_some(MidNode { point, supports })
}

impl Look<'_> {
    /// Outward unit normal of a flat facet.
    fn normal(&self, facet: usize) -> DVec3 {
        self.brep
            .area_vector(FacetId(facet as u32))
            .normalize_or_zero()
    }
}

#[cfg(test)]
mod tests {
    use super::super::meeting::MeetingEdges;
    use super::*;
    use crate::geom::placer::Placer;
    use crate::model::ids::WallId;
    use crate::model::walls::{Pairing, Wall};
    use crate::spatial::TriangleBvh;
    use crate::stage::adjacency::adjacency;
    use crate::test_parts::brep;

    const BOTTOM: u32 = 0;
    const END: u32 = 1;
    const CHAMFER: u32 = 2;
    const TOP: u32 = 3;

    /// The middle z = 1 of a plate two thick, its end x = 20 and a chamfer that leans by 45 degrees.
    struct Chamfered;
    impl Placer for Chamfered {
        fn place(&self, start: DVec3, supports: &[Support]) -> DVec3 {
            let mut p = start;
            for support in supports {
                match *support {
                    Support::Mid(_) => p.z = 1.0,
                    Support::Face(FaceId(CHAMFER)) => p.x = 20.8 - p.z,
                    _ => p.x = 20.0,
                }
            }
            p
        }
        fn normal(&self, _: DVec3, _: WallId) -> Option<DVec3> {
            Some(DVec3::Z)
        }
        fn thickness(&self, _: DVec3, _: WallId) -> Option<f64> {
            Some(2.0)
        }
        fn curvature_radius(&self, _: DVec3, _: WallId) -> f64 {
            f64::INFINITY
        }
    }

    /// Where a node ends that lies on the end face of a plate whose chamfer takes in `leg` of the thickness, with the faces of the upper side.
    fn landed_at(leg: f64, upper: &[u32]) -> Option<MidNode> {
        let profile = [
            (0.0, 0.0),
            (20.0, 0.0),
            (20.0, 2.0 - leg),
            (20.0 - leg, 2.0),
            (0.0, 2.0),
        ];
        let points = [0.0, 8.0]
            .into_iter()
            .flat_map(|y| profile.map(|(x, z)| DVec3::new(x, y, z)))
            .collect();
        let mut polygons: Vec<(Vec<usize>, u32)> = (0..5)
            .map(|i| (vec![i, i + 5, (i + 1) % 5 + 5, (i + 1) % 5], i as u32))
            .collect();
        polygons.push(((0..5).collect(), 5));
        polygons.push(((5..10).rev().collect(), 6));
        let solid = brep(points, &polygons, |a, b| (a + b) / 2.0);
        let corners: Vec<[DVec3; 3]> = solid.facets.ids().map(|f| solid.corners(f)).collect();
        let mut pairing = Pairing::default();
        pairing.walls.push(Wall {
            sides: [
                upper.iter().copied().map(FaceId).collect(),
                vec![FaceId(BOTTOM)],
            ],
            thickness: 2.0,
            group: 0,
        });
        let look = Look {
            brep: &solid,
            pairing: &pairing,
            placer: &Chamfered,
            bvh: TriangleBvh::new(&corners),
            meeting: MeetingEdges::new(&solid, &adjacency(&solid), &pairing),
        };
        let node = MidNode {
            point: DVec3::new(20.0, 4.0, 1.0),
            supports: [Support::Mid(WallId(0)), Support::Face(FaceId(END))]
                .into_iter()
                .collect(),
        };
        landed(&node, DVec3::X, &look)
    }

    #[test]
    fn a_rim_lies_on_the_chamfer_that_the_middle_meets_and_else_on_the_end_face() {
        let node = landed_at(1.2, &[TOP]).unwrap();
        assert!(node.point.distance(DVec3::new(19.8, 4.0, 1.0)) < 1e-12);
        let faces: Vec<FaceId> = faces(&node.supports).collect();
        assert_eq!(faces, [FaceId(CHAMFER)]);
        // A chamfer of less than half of the thickness leaves the rim where it is.
        assert_eq!(landed_at(0.8, &[TOP]), None);
        // Nor does one that is a side itself take it: the middle bends and goes on to the end face.
        assert_eq!(landed_at(1.2, &[CHAMFER, TOP]), None);
    }
}
