//! The boundary of one solid, as the importer hands it on.

mod joints;

use super::disjoint::Disjoint;
use super::ids::{CurveId, FaceId, FacetId, Id, IndexVec, VertexId};
use glam::DVec3;
use joints::joints;

/// A boundary triangle. Corners run counter-clockwise seen from outside the material.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Facet {
    /// The three corners.
    pub corners: [VertexId; 3],
    /// The mid-side points of sides (0,1), (1,2), (2,0): on the CAD surface, where the source had one.
    pub mids: [DVec3; 3],
    /// The face it tessellates.
    pub face: FaceId,
}

/// A face of the boundary representation.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Face {
    /// The face's number in the file that it came from (unique over the whole file).
    pub tag: i32,
    /// Its name in the file, if any.
    pub name: Option<String>,
    /// The curves that bound it, without repetition.
    pub curves: Vec<CurveId>,
}

/// An edge of the boundary representation: a curve between faces (or a seam inside one).
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Curve {
    /// The curve's number in the file that it came from.
    pub tag: i32,
    /// The faces that meet there: two, or one where the curve is a seam.
    pub faces: Vec<FaceId>,
    /// Its straight pieces, unordered, as sides of facets.
    pub segments: Vec<[VertexId; 2]>,
}

/// The closed boundary of one solid: facets, faces, curves. Lengths in mm.
///
/// `vertices` holds the corners of the tets as well, so that boundary and filling share their ids.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Brep {
    /// The solid's number in the file that it came from.
    pub solid_tag: i32,
    /// #V positions, those on the boundary and those inside.
    pub vertices: IndexVec<VertexId, DVec3>,
    /// The boundary triangles.
    pub facets: IndexVec<FacetId, Facet>,
    /// The faces.
    pub faces: IndexVec<FaceId, Face>,
    /// The curves.
    pub curves: IndexVec<CurveId, Curve>,
}

/// What can be wrong with a [`Brep`].
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum BrepFault {
    /// A facet names a vertex that does not exist, or one vertex twice.
    #[error("facet {0:?} has corners that are missing or equal")]
    BadFacet(FacetId),
    /// A side of a facet has no mate that runs the other way: the boundary is open or not oriented there.
    #[error("side {0:?}-{1:?} of the boundary is used {2} times one way and {3} times the other")]
    OpenSide(VertexId, VertexId, u32, u32),
    /// A coordinate is not a finite number.
    #[error("vertex {0:?} is not finite")]
    NotFinite(VertexId),
}

impl Brep {
    /// The corner positions of a facet.
    #[inline]
    pub fn corners(&self, facet: FacetId) -> [DVec3; 3] {
        self.facets[facet].corners.map(|v| self.vertices[v])
    }

    /// The area of a facet along its outward normal, mm².
    pub fn area_vector(&self, facet: FacetId) -> DVec3 {
        let [a, b, c] = self.corners(facet);
        (b - a).cross(c - a) / 2.0
    }

    /// All violations: facets in range, every side matched by one that runs the other way, finite coordinates.
    pub fn check(&self) -> Vec<BrepFault> {
        let mut faults = Vec::new();
        for (id, p) in self.vertices.enumerated() {
            if !p.is_finite() {
                faults.push(BrepFault::NotFinite(id));
            }
        }
        let mut sides: Vec<(VertexId, VertexId, bool)> = Vec::with_capacity(self.facets.len() * 3);
        for (id, facet) in self.facets.enumerated() {
            let [a, b, c] = facet.corners;
            if a == b
                || b == c
                || c == a
                || facet
                    .corners
                    .iter()
                    .any(|v| v.index() >= self.vertices.len())
            {
                faults.push(BrepFault::BadFacet(id));
                continue;
            }
            for (u, v) in [(a, b), (b, c), (c, a)] {
                sides.push((u.min(v), u.max(v), u < v));
            }
        }
        sides.sort_unstable();
        for run in sides.chunk_by(|a, b| (a.0, a.1) == (b.0, b.1)) {
            let forward = run.iter().filter(|s| s.2).count() as u32;
            let backward = run.len() as u32 - forward;
            if forward != backward {
                faults.push(BrepFault::OpenSide(run[0].0, run[0].1, forward, backward));
            }
        }
        faults
    }

    /// Euler characteristic of the boundary's facets, V - E + F, where the boundary touches itself along a side or at a vertex taken as if it did
    /// not: a side of four facets counts as two, a vertex of two fans as two. A coarse tessellation of a narrow hole has such sides, the hole none.
    pub fn euler(&self) -> i64 {
        let mut fans = Disjoint::new(3 * self.facets.len());
        let mut sides = 3 * self.facets.len() as i64;
        for [one, other] in joints(self) {
            sides -= 1;
            // Sides of two facets run opposite ways.
            fans.join(one.start(), other.end());
            fans.join(one.end(), other.start());
        }
        fans.sets() as i64 - sides + self.facets.len() as i64
    }

    /// Volume enclosed by the flat facets, mm³.
    pub fn volume(&self) -> f64 {
        self.facets
            .ids()
            .map(|f| {
                let [a, b, c] = self.corners(f);
                a.dot(b.cross(c)) / 6.0
            })
            .sum()
    }

    /// Area of the flat facets, mm².
    pub fn area(&self) -> f64 {
        self.facets
            .ids()
            .map(|f| self.area_vector(f).length())
            .sum()
    }

    /// Diagonal of the box around the boundary, mm.
    pub fn diagonal(&self) -> f64 {
        let mut low = DVec3::INFINITY;
        let mut high = DVec3::NEG_INFINITY;
        for facet in &self.facets {
            for v in facet.corners {
                low = low.min(self.vertices[v]);
                high = high.max(self.vertices[v]);
            }
        }
        if self.facets.is_empty() {
            0.0
        } else {
            (high - low).length()
        }
    }
}
