//! Reach: rims that stop short of the lateral face are carried on to it.
//!
//! Where a rim is rounded, no label opposes another near it, and the collapse eats up to the first tets that lie between the two sides: the sheet ends in a ragged
//! border a little inside the material. Its nodes take the nearest face ahead that is no side of a wall there as a support; placing then moves the rim onto it.
//!
//! Where the two sides of a wall meet, its rim lies on their edge, and the nodes take that edge.
//!
//! A rim that lies off the face that it was given goes to the one that its mid-surface meets.
//!
//! Guarantees: topology untouched; supports are added only to nodes of rims without a face, and only where such an edge or a face that is no side of a wall
//! is within reach; positions change only where a rim dives into another wall and where it changes its face. A border further inside ends at a lump, and stays.
//! Cost: one nearest-point query a bare rim node.

mod landing;
mod meeting;

use crate::geom::placer::Placer;
use crate::model::brep::Brep;
use crate::model::complex::{EdgeKind, MidComplex, MidNode, Support, ends};
use crate::model::ids::{FaceId, FacetId, IndexVec, NodeId, TriangleId, WallId};
use crate::model::walls::{Aag, Pairing};
use crate::spatial::TriangleBvh;
use glam::DVec3;
use meeting::MeetingEdges;
use rayon::prelude::*;
use smallvec::SmallVec;

/// How far a rim may be from its face, in thicknesses: a full rounding ends half of one beyond the sides, and a ragged border is as far again inside.
const REACH: f64 = 1.5;
/// How far it may be from an edge where the sides of its wall meet: a slim wedge is eaten away where it is thinner than the tets.
const EDGE_REACH: f64 = 3.0;
/// A wall does not reach a place that is further than this beyond the end of one of its sides, or where it would be so much thicker, in thicknesses.
const PAST: f64 = 0.5;
/// A face is ahead of a rim within this cosine of where the sheet ends there: one that is beside the wall cannot end it.
const AHEAD: f64 = 0.5;
/// Faces that are looked at for each node: at the corner of a rim two fillets of the sides and two of the ends meet.
const LOOKS: usize = 4;
/// A rim that dives has at most this many nodes without a face: a longer border ends at a lump.
const LONGEST_DIVE: usize = 12;
/// Rounds in which neighbours on the rim even out where outwards is: a ragged border looks every way.
const ROUNDS: usize = 4;

/// Gives bare nodes of rims the lateral face near them.
pub fn reach_rims(
    mut complex: MidComplex,
    brep: &Brep,
    aag: &Aag,
    pairing: &Pairing,
    placer: &dyn Placer,
) -> MidComplex {
    let rims = Rims::new(&complex);
    let bare: Vec<NodeId> = complex
        .nodes
        .ids()
        .filter(|&n| !rims.along[n].is_empty() && walls_only(&complex, n))
        .collect();
    let ragged = !bare.is_empty();
    let outwards = rims.outwards(&complex);
    let corners: Vec<[DVec3; 3]> = brep.facets.ids().map(|f| brep.corners(f)).collect();
    let bvh = TriangleBvh::new(&corners);
    let meeting = MeetingEdges::new(brep, aag, pairing);
    let look = Look {
        brep,
        pairing,
        placer,
        bvh,
        meeting,
    };
    let found: Vec<Option<Support>> = bare
        .par_iter()
        .map(|&n| look.ahead(&complex.nodes[n], outwards[n].normalize_or_zero()))
        .collect();
    for (&n, end) in bare.iter().zip(&found) {
        complex.nodes[n].supports.extend(*end);
    }
    let bare: Vec<NodeId> = (bare.into_iter().zip(found))
        .filter(|(_, end)| end.is_none())
        .map(|x| x.0)
        .collect();
    // A ragged border looks every way: what its neighbours on the rim have found, a node need only have somewhere ahead.
    look.share(&mut complex, &rims, &bare, &outwards);
    // Or it is folded over itself, and only a row further in tells where the sheet lies.
    let outwards = rims.outwards_from(&complex, &further_in(&complex));
    look.share(&mut complex, &rims, &bare, &outwards);
    turn_corners(&mut complex, &rims, &look);
    if ragged {
        dive(&mut complex, &rims, placer);
    }
    landing::land(&mut complex, &rims, &look);
    complex
}

/// What lies ahead of the nodes of rims.
struct Look<'a> {
    brep: &'a Brep,
    pairing: &'a Pairing,
    placer: &'a dyn Placer,
    bvh: TriangleBvh,
    meeting: MeetingEdges,
}

impl Look<'_> {
    /// Nodes without an end get one that a neighbour on the rim has and that is ahead of them too, and hand it on.
    fn share(
        &self,
        complex: &mut MidComplex,
        rims: &Rims,
        bare: &[NodeId],
        outwards: &IndexVec<NodeId, DVec3>,
    ) {
        loop {
            let told: Vec<(NodeId, Support)> = bare
                .par_iter()
                .filter(|&&n| walls_only(complex, n))
                .filter_map(|&n| {
                    let own = outwards[n].normalize_or_zero();
                    let beside = rims.along[n].iter();
                    let end = beside
                        .flat_map(|&m| ends(&complex.nodes[m].supports))
                        .find(|&end| self.is_ahead(&complex.nodes[n], own, end))?;
                    Some((n, end))
                })
                .collect();
            if told.is_empty() {
                return;
            }
            for (n, end) in told {
                complex.nodes[n].supports.push(end);
            }
        }
    }

    /// What the rim of a bare node lies on; `outwards`: where the sheet ends.
    fn ahead(&self, node: &MidNode, outwards: DVec3) -> Option<Support> {
        let (p, wall) = (node.point, only_wall(node)?);
        let is_ahead = |way: DVec3| outwards.dot(way) > AHEAD * way.length();
        if let Some((end, point)) = self.end_of_sides(p, wall)
            && is_ahead(point - p)
        {
            return Some(end);
        }
        let thickness = self.placer.thickness(p, wall)?;
        // Faces that are nearest but not ahead: the fillets beside a wall.
        let mut beside: SmallVec<[FaceId; LOOKS]> = SmallVec::new();
        for _ in 0..LOOKS {
            let near = self.bvh.nearest_where(p, REACH * thickness, |i| {
                let face = self.face(i);
                !beside.contains(&face) && !self.is_side(wall, face)
            })?;
            let face = self.face(near.index);
            if is_ahead(near.point - p) {
                let lateral = is_lateral(self.pairing, self.placer, face, near.point);
                return lateral.then_some(Support::Face(face));
            }
            beside.push(face);
        }
        None
    }

    /// Whether this end, on which the rim lies next to the node, is ahead of the node too.
    fn is_ahead(&self, node: &MidNode, outwards: DVec3, end: Support) -> bool {
        let Some(wall) = only_wall(node) else {
            return false;
        };
        let p = node.point;
        let end = match end {
            Support::Mid(_) | Support::Pin(_) => None,
            Support::Edge(_) => self.end_of_sides(p, wall).map(|end| end.1),
            Support::Face(face) if self.is_side(wall, face) => {
                self.end_of_sides(p, wall).map(|end| end.1)
            }
            Support::Face(face) => {
                let thickness = self.placer.thickness(p, wall).unwrap_or(0.0);
                let near = (self.bvh).nearest_where(p, REACH * thickness, |i| self.face(i) == face);
                near.map(|n| n.point)
            }
        };
        end.is_some_and(|q| outwards.dot(q - p) > 0.0)
    }

    /// Where the two sides of the wall meet near a place.
    fn end_of_sides(&self, p: DVec3, wall: WallId) -> Option<(Support, DVec3)> {
        let mean = self.pairing.walls.get(wall)?.thickness;
        self.meeting.nearest(p, wall, EDGE_REACH * mean)
    }

    fn face(&self, facet: usize) -> FaceId {
        self.brep.facets[FacetId(facet as u32)].face
    }

    fn is_side(&self, wall: WallId, face: FaceId) -> bool {
        let sides = self.pairing.walls.get(wall).map(|w| &w.sides);
        sides.is_some_and(|s| s.iter().any(|s| s.binary_search(&face).is_ok()))
    }
}

/// The wall of a node that lies on one wall and on no face.
fn only_wall(node: &MidNode) -> Option<WallId> {
    match node.supports.as_slice() {
        &[Support::Mid(wall)] => Some(wall),
        _ => None,
    }
}

/// The middle of the nodes round a node, without those of an edge.
fn further_in(complex: &MidComplex) -> impl Fn(NodeId, [NodeId; 2]) -> DVec3 {
    let stars = complex.stars();
    move |c, edge| {
        let round = stars[c].iter().flat_map(|&t| complex.triangles[t].nodes);
        let (sum, count) = (round.filter(|n| !edge.contains(n)))
            .fold((DVec3::ZERO, 0.0), |(s, k), n| {
                (s + complex.nodes[n].point, k + 1.0)
            });
        sum / count
    }
}

/// Where a rim on a face goes over into one where the sides meet, the node between lies on both: else the corner is cut off.
fn turn_corners(complex: &mut MidComplex, rims: &Rims, look: &Look<'_>) {
    let corners: Vec<(NodeId, Support)> = (complex.nodes.enumerated())
        .filter_map(|(n, node)| {
            let mut own = ends(&node.supports);
            let (Some(face @ Support::Face(_)), None) = (own.next(), own.next()) else {
                return None;
            };
            let &Support::Mid(wall) = node.supports.first()? else {
                return None;
            };
            let p = node.point;
            // An edge between them, or a side itself where they are smooth over it.
            let (meeting, _) = look.end_of_sides(p, wall).filter(|end| end.0 != face)?;
            let meets = |&m: &NodeId| ends(&complex.nodes[m].supports).any(|s| s == meeting);
            rims.along[n].iter().any(meets).then_some((n, meeting))
        })
        .collect();
    for (n, meeting) in corners {
        complex.nodes[n].supports.push(meeting);
    }
}

/// Where a rim dives into another wall no face is left beside it: from its last node on a face it goes straight on to the junction.
fn dive(complex: &mut MidComplex, rims: &Rims, placer: &dyn Placer) {
    let has_end = |complex: &MidComplex, n: NodeId| ends(&complex.nodes[n].supports).count() > 0;
    let ends: Vec<NodeId> = complex
        .nodes
        .ids()
        .filter(|&n| {
            rims.along[n].len() == 1 && complex.nodes[n].supports.len() > 1 && !has_end(complex, n)
        })
        .collect();
    for end in ends {
        let mut chain = vec![end, rims.along[end][0]];
        while let [.., before, last] = chain[..]
            && walls_only(complex, last)
            && chain.len() <= LONGEST_DIVE
        {
            let Some(&next) = rims.along[last].iter().find(|&&n| n != before) else {
                break;
            };
            chain.push(next);
        }
        let last = chain[chain.len() - 1];
        let (from, to) = (complex.nodes[last].point, complex.nodes[end].point);
        let thickness = complex.nodes[end].supports.iter().filter_map(|s| match s {
            Support::Mid(w) => placer.thickness(to, *w),
            Support::Face(_) | Support::Edge(_) | Support::Pin(_) => None,
        });
        let thickest = thickness.fold(0.0, f64::max);
        let foot = placer.place(from, &complex.nodes[end].supports);
        // A full thickness deep is the middle of the thickest wall, with as much again for the fillet at its foot.
        if !has_end(complex, last)
            || foot.distance(to) > REACH * thickest
            || foot.distance(from) > REACH * thickest
        {
            continue;
        }
        let steps = (chain.len() - 1) as f64;
        for (i, &n) in chain[..chain.len() - 1].iter().enumerate() {
            complex.nodes[n].point = foot.lerp(from, i as f64 / steps);
        }
    }
}

/// Whether a face is the side of no wall that reaches a place: one face may be the side of a wall and, further on, the lateral face of a flange.
fn is_lateral(pairing: &Pairing, placer: &dyn Placer, face: FaceId, at: DVec3) -> bool {
    pairing.walls.enumerated().all(|(w, wall)| {
        let side = wall.sides.iter().any(|s| s.binary_search(&face).is_ok());
        let wide = placer
            .thickness(at, w)
            .is_none_or(|t| t > wall.thickness * (1.0 + PAST));
        !side || wide || placer.beyond(at, w) > PAST * wall.thickness
    })
}

/// Whether a node lies on one wall and on no face.
fn walls_only(complex: &MidComplex, n: NodeId) -> bool {
    only_wall(&complex.nodes[n]).is_some()
}

struct Rims {
    edges: Vec<([NodeId; 2], TriangleId)>,
    along: IndexVec<NodeId, SmallVec<[NodeId; 2]>>,
}

impl Rims {
    fn new(complex: &MidComplex) -> Self {
        let mut rims = Self {
            edges: Vec::new(),
            along: IndexVec::filled(SmallVec::new(), complex.nodes.len()),
        };
        for edge in complex.edges() {
            if complex.kind(&edge) == EdgeKind::Rim {
                let [a, b] = edge.ends;
                rims.along[a].push(b);
                rims.along[b].push(a);
                rims.edges.push((edge.ends, edge.triangles[0]));
            }
        }
        rims
    }

    /// Where the sheet ends, seen from every node of a rim: away from the triangles there, evened out along the rim.
    fn outwards(&self, complex: &MidComplex) -> IndexVec<NodeId, DVec3> {
        self.outwards_from(complex, &|c, _| complex.nodes[c].point)
    }

    /// The same; `inside(c, edge)` tells where the sheet lies that has node `c` across an edge of the rim.
    fn outwards_from(
        &self,
        complex: &MidComplex,
        inside: &dyn Fn(NodeId, [NodeId; 2]) -> DVec3,
    ) -> IndexVec<NodeId, DVec3> {
        let p = |n: NodeId| complex.nodes[n].point;
        let mut outwards = IndexVec::filled(DVec3::ZERO, complex.nodes.len());
        for &([a, b], t) in &self.edges {
            let nodes = complex.triangles[t].nodes;
            let Some(c) = nodes.into_iter().find(|&n| n != a && n != b) else {
                continue;
            };
            let along = (p(b) - p(a)).normalize_or_zero();
            let inner = inside(c, [a, b]) - p(a);
            // As long as the edge: long edges know better. Flat triangles, whose height is rounding, know nothing.
            let away = (along * inner.dot(along) - inner).clamp_length_max(p(a).distance(p(b)));
            outwards[a] += away;
            outwards[b] += away;
        }
        for _ in 0..ROUNDS {
            let before = outwards.clone();
            for (n, list) in self.along.enumerated() {
                for &m in list {
                    outwards[n] += before[m];
                }
            }
        }
        outwards
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::model::complex::MidTriangle;
    use crate::model::ids::CurveId;
    use crate::model::walls::Wall;
    use crate::test_parts::{box_brep, slim_wedge};

    /// The middle plane z = 1 of a plate two thick.
    struct Middle;
    impl Placer for Middle {
        fn place(&self, start: DVec3, _: &[Support]) -> DVec3 {
            start
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

    /// A strip in the middle plane of a plate 30 x 20 x 2 whose border along y = `border` is ragged.
    fn ragged(border: f64) -> MidComplex {
        let mut complex = MidComplex::default();
        let supports = [Support::Mid(WallId(0))];
        let mut row = |y: f64, rag: f64| -> Vec<NodeId> {
            (0..9)
                .map(|i| {
                    let point =
                        DVec3::new(3.0 * f64::from(i) + 3.0, y - rag * f64::from(i % 2), 1.0);
                    complex.nodes.push(MidNode {
                        point,
                        supports: supports.iter().copied().collect(),
                    })
                })
                .collect()
        };
        let (low, high) = (row(10.0, 0.0), row(border, 0.7));
        for i in 0..8 {
            for nodes in [
                [low[i], low[i + 1], high[i + 1]],
                [low[i], high[i + 1], high[i]],
            ] {
                complex.triangles.push(MidTriangle {
                    nodes,
                    wall: WallId(0),
                });
            }
        }
        complex
    }

    fn reached(border: f64) -> Vec<usize> {
        let brep = box_brep(DVec3::new(30.0, 20.0, 2.0));
        let flat = |z: f64| -> Vec<FaceId> {
            let lies = |f: &FacetId| brep.corners(*f).iter().all(|p| p.z == z);
            brep.facets
                .ids()
                .find(lies)
                .map(|f| brep.facets[f].face)
                .into_iter()
                .collect()
        };
        let aag = crate::stage::adjacency::adjacency(&brep);
        let mut pairing = Pairing::default();
        pairing.walls.push(Wall {
            sides: [flat(2.0), flat(0.0)],
            thickness: 2.0,
            group: 0,
        });
        let complex = reach_rims(ragged(border), &brep, &aag, &pairing, &Middle);
        (complex.nodes.iter())
            .enumerate()
            .filter(|(_, n)| n.supports.len() > 1)
            .map(|x| x.0)
            .collect()
    }

    /// Two planes: the middle of a plate at z = 0, three thick, and that of a rib at y = 0.
    struct RibOnPlate;
    impl Placer for RibOnPlate {
        fn place(&self, start: DVec3, supports: &[Support]) -> DVec3 {
            let mut p = start;
            for support in supports {
                match support {
                    Support::Mid(WallId(0)) => p.z = 0.0,
                    Support::Mid(_) => p.y = 0.0,
                    _ => p.x = 10.0,
                }
            }
            p
        }
        fn normal(&self, _: DVec3, _: WallId) -> Option<DVec3> {
            None
        }
        fn thickness(&self, _: DVec3, _: WallId) -> Option<f64> {
            Some(3.0)
        }
        fn curvature_radius(&self, _: DVec3, _: WallId) -> f64 {
            f64::INFINITY
        }
    }

    #[test]
    fn a_rim_that_dives_into_a_plate_goes_straight_on() {
        // The rim of a rib comes down at x = 10, has lost its face at z = 1.5, and draws back to x = 8.8 at the junction.
        let rim = [
            (10.0, 6.0),
            (10.0, 3.0),
            (10.0, 1.8),
            (9.4, 0.9),
            (8.8, 0.0),
        ];
        let mut complex = MidComplex::default();
        let mut chain = Vec::new();
        for (k, (x, z)) in rim.into_iter().enumerate() {
            let mut supports = vec![Support::Mid(WallId(1))];
            if k < 3 {
                supports.push(Support::Face(FaceId(7)));
            }
            if k == 4 {
                supports.insert(0, Support::Mid(WallId(0)));
            }
            chain.push(complex.nodes.push(MidNode {
                point: DVec3::new(x, 0.0, z),
                supports: supports.into_iter().collect(),
            }));
        }
        let rims = {
            let mut along = IndexVec::filled(SmallVec::new(), complex.nodes.len());
            for pair in chain.windows(2) {
                along[pair[0]].push(pair[1]);
                along[pair[1]].push(pair[0]);
            }
            along[chain[0]].push(chain[0]);
            Rims {
                edges: Vec::new(),
                along,
            }
        };
        let before = complex.clone();
        dive(&mut complex, &rims, &RibOnPlate);
        assert!(
            complex.nodes[chain[4]]
                .point
                .distance(DVec3::new(10.0, 0.0, 0.0))
                < 1e-12
        );
        assert!(
            complex.nodes[chain[3]]
                .point
                .distance(DVec3::new(10.0, 0.0, 0.9))
                < 1e-12
        );
        assert_eq!(complex.nodes[chain[2]], before.nodes[chain[2]]);
        // A rim that ends far from its last face ends at a lump, and stays.
        let mut far = before.clone();
        far.nodes[chain[4]].point.x = 2.0;
        let kept = far.clone();
        dive(&mut far, &rims, &RibOnPlate);
        assert_eq!(far, kept);
    }

    #[test]
    fn at_a_slim_edge_the_rim_takes_the_edge_and_its_corner_both() {
        // A wedge 20 long and 3 high along y, faces 0 and 1 its sides, 3 and 4 its ends; its middle ends at x = 1.5, four thirds of a mean thickness early.
        let solid = slim_wedge();
        let mut pairing = Pairing::default();
        pairing.walls.push(Wall {
            sides: [vec![FaceId(0)], vec![FaceId(1)]],
            thickness: 1.5,
            group: 0,
        });
        let mut complex = MidComplex::default();
        let (mid, end) = (Support::Mid(WallId(0)), Support::Face(FaceId(3)));
        let row = |complex: &mut MidComplex, x: f64| -> Vec<NodeId> {
            (0..5)
                .map(|i| {
                    complex.nodes.push(MidNode {
                        point: DVec3::new(x, 2.0 * f64::from(i), 0.075 * x),
                        supports: if i == 0 {
                            [mid, end].into_iter().collect()
                        } else {
                            [mid].into_iter().collect()
                        },
                    })
                })
                .collect()
        };
        let (rim, inner) = (row(&mut complex, 1.5), row(&mut complex, 5.0));
        for i in 0..4 {
            for nodes in [
                [rim[i], inner[i], inner[i + 1]],
                [rim[i], inner[i + 1], rim[i + 1]],
            ] {
                complex.triangles.push(MidTriangle {
                    nodes,
                    wall: WallId(0),
                });
            }
        }
        let aag = crate::stage::adjacency::adjacency(&solid);
        let reached = reach_rims(complex, &solid, &aag, &pairing, &Middle);
        let edge = Support::Edge(CurveId(0));
        assert_eq!(reached.nodes[rim[0]].supports.as_slice(), [mid, end, edge]);
        for &n in &rim[1..4] {
            assert_eq!(reached.nodes[n].supports.as_slice(), [mid, edge]);
        }
        assert!(
            inner
                .iter()
                .all(|&n| !reached.nodes[n].supports.contains(&edge))
        );
    }

    #[test]
    fn a_ragged_rim_near_its_face_takes_it_and_one_far_inside_does_not() {
        // Nodes 9 to 17 are the border; those at the short ends look along x too, and 3 mm off is as far as they reach.
        let near = reached(18.5);
        assert!((10..=16).all(|n| near.contains(&n)), "{near:?}");
        let far = reached(15.0);
        assert!((10..=16).all(|n| !far.contains(&n)), "{far:?}");
    }
}
