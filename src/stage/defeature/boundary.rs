//! Where a set of faces ends: its boundary as loops of facet sides, how long they are, and how much they turn.

use crate::model::brep::Brep;
use crate::model::ids::{FaceId, FacetId, IndexVec, VertexId};
use glam::{DVec3, DVec4};
use smallvec::SmallVec;
use std::collections::{BTreeMap, BTreeSet};
use std::f64::consts::PI;

/// A mid-side point this near to the middle of its side, as a share of its length, makes no arc: rounding.
const STRAIGHT: f64 = 1e-9;

/// The boundary of a solid, ready to be asked what hangs together.
pub(super) struct Skin<'a> {
    pub brep: &'a Brep,
    /// The facets of every face.
    pub of_face: IndexVec<FaceId, Vec<FacetId>>,
    /// The facets round every vertex.
    around: IndexVec<VertexId, SmallVec<[FacetId; 8]>>,
}

/// A side between a facet of the set and one outside it, as the former runs.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Side {
    pub from: VertexId,
    pub to: VertexId,
    /// Its mid-side point.
    pub mid: DVec3,
    /// The facet outside the set, and which of its sides it is.
    pub outer: (FacetId, usize),
}

/// A closed chain of sides, each beginning where the one before ends.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Loop {
    pub sides: Vec<Side>,
}

impl<'a> Skin<'a> {
    pub fn new(brep: &'a Brep) -> Self {
        let mut of_face = IndexVec::filled(Vec::new(), brep.faces.len());
        let mut around = IndexVec::filled(SmallVec::new(), brep.vertices.len());
        for (id, facet) in brep.facets.enumerated() {
            of_face[facet.face].push(id);
            for v in facet.corners {
                around[v].push(id);
            }
        }
        Self {
            brep,
            of_face,
            around,
        }
    }

    /// The loops that bound a set of faces, in the order of their least vertices; none where the boundary is no set of simple loops.
    pub fn loops(&self, set: &BTreeSet<FaceId>) -> Option<Vec<Loop>> {
        let mut next: BTreeMap<VertexId, Side> = BTreeMap::new();
        for &id in set.iter().flat_map(|&f| &self.of_face[f]) {
            let facet = self.brep.facets[id];
            for k in 0..3 {
                let (from, to) = (facet.corners[k], facet.corners[(k + 1) % 3]);
                let Some(outer) = self.outside(set, to, from) else {
                    continue;
                };
                let mid = facet.mids[k];
                let side = Side {
                    from,
                    to,
                    mid,
                    outer,
                };
                if next.insert(from, side).is_some() {
                    return None;
                }
            }
        }
        let mut loops = Vec::new();
        while let Some((&first, _)) = next.first_key_value() {
            let (mut sides, mut at) = (Vec::new(), first);
            loop {
                let side = next.remove(&at)?;
                at = side.to;
                sides.push(side);
                if at == first {
                    break;
                }
            }
            loops.push(Loop { sides });
        }
        Some(loops)
    }

    /// The facet outside the set that runs from one vertex straight to the other, and which of its sides that is.
    fn outside(
        &self,
        set: &BTreeSet<FaceId>,
        from: VertexId,
        to: VertexId,
    ) -> Option<(FacetId, usize)> {
        (self.around[from].iter())
            .filter(|&&f| !set.contains(&self.brep.facets[f].face))
            .find_map(|&f| {
                let c = self.brep.facets[f].corners;
                let side = (0..3).find(|&k| [c[k], c[(k + 1) % 3]] == [from, to]);
                Some((f, side?))
            })
    }

    /// Faces across the loops, each once.
    pub fn across(&self, loops: &[Loop]) -> BTreeSet<FaceId> {
        let sides = loops.iter().flat_map(|l| &l.sides);
        sides.map(|s| self.brep.facets[s.outer.0].face).collect()
    }

    /// Length of a loop along the arcs through its mid-side points, mm: exact where the rim is of arcs and straight lines.
    pub fn length(&self, of: &Loop) -> f64 {
        let arc = |s: &Side| {
            let (a, b) = (self.brep.vertices[s.from], self.brep.vertices[s.to]);
            let (chord, sag) = (a.distance(b), s.mid.distance((a + b) / 2.0));
            if sag <= STRAIGHT * chord {
                return chord;
            }
            let radius = (chord * chord / 4.0 + sag * sag) / (2.0 * sag);
            4.0 * radius * (2.0 * sag / chord).atan()
        };
        of.sides.iter().map(arc).sum()
    }

    /// How far a loop turns on the surface outside the set, rad, seen from the set: a full turn round a hole in a plane or in the side of a tube, none at the end of a tube, a full turn
    /// back round the outside of a plate. By the theorem of Gauss and Bonnet what lacks to a full turn is what a surface that closes the loop has to bend by.
    pub fn turning(&self, of: &Loop, set: &BTreeSet<FaceId>) -> f64 {
        let angle = |v: VertexId| -> f64 {
            let outside = |f: &&FacetId| !set.contains(&self.brep.facets[**f].face);
            let around = self.around[v].iter().filter(outside);
            around.map(|&f| corner_angle(self.brep, f, v)).sum()
        };
        of.sides.iter().map(|s| angle(s.from) - PI).sum()
    }

    /// Outward unit normals of the surface outside the set at the starts of the loop's sides; none where it has none.
    pub fn normals(&self, of: &Loop, set: &BTreeSet<FaceId>) -> Option<Vec<DVec3>> {
        let normal = |v: VertexId| {
            let outside = |f: &&FacetId| !set.contains(&self.brep.facets[**f].face);
            let around = self.around[v].iter().filter(outside);
            let sum: DVec3 = around
                .map(|&f| self.corner_normal(f, v) * corner_angle(self.brep, f, v))
                .sum();
            sum.try_normalize()
        };
        of.sides.iter().map(|s| normal(s.from)).collect()
    }

    fn corner_normal(&self, facet: FacetId, v: VertexId) -> DVec3 {
        let f = self.brep.facets[facet];
        let (u, w) = match f.corners.iter().position(|&c| c == v) {
            Some(1) => (1.0, 0.0),
            Some(2) => (0.0, 1.0),
            _ => (0.0, 0.0),
        };
        crate::geom::six_node::normal(&self.brep.corners(facet), &f.mids, u, w)
    }

    /// Middle of a loop's line, mm.
    pub fn middle(&self, of: &Loop) -> DVec3 {
        let weighed = of.sides.iter().map(|s| {
            let [a, b] = [s.from, s.to].map(|v| self.brep.vertices[v]);
            (a + b).extend(2.0) * a.distance(b)
        });
        let sum: DVec4 = weighed.sum();
        sum.truncate() / sum.w
    }
}

/// Angle of a facet's flat triangle at one of its corners, rad.
fn corner_angle(brep: &Brep, facet: FacetId, v: VertexId) -> f64 {
    let corners = brep.facets[facet].corners;
    let Some(k) = corners.iter().position(|&c| c == v) else {
        return 0.0;
    };
    let [p, a, b] = [0, 1, 2].map(|i| brep.vertices[corners[(k + i) % 3]]);
    (a - p).angle_between(b - p)
}
