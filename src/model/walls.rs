//! What the faces are to one another: adjacency, pairs, walls, roles.

use super::ids::{CurveId, FaceId, IndexVec, WallId};
use serde::Serialize;

/// How two faces meet along a curve.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Convexity {
    /// Less material than half of the space round the curve: an outer corner.
    Convex,
    /// More material than half of the space: an inner corner.
    Concave,
    /// The faces are tangent.
    Smooth,
}

/// An arc of the attributed adjacency graph: two different faces along one curve.
#[derive(Clone, Debug, PartialEq)]
pub struct Arc {
    /// The two faces, the lower id first.
    pub faces: [FaceId; 2],
    /// Where they meet.
    pub curve: CurveId,
    /// Length of the curve, mm.
    pub length: f64,
    /// Angle between the outward normals, length-weighted mean along the curve, rad; positive where convex, negative where concave.
    pub turn_rad: f64,
    /// `turn_rad` in words.
    pub convexity: Convexity,
}

/// Attributed adjacency graph of a solid's faces.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Aag {
    /// All arcs, sorted by faces and curve.
    pub arcs: Vec<Arc>,
    /// Indices into `arcs` for each face.
    pub of_face: IndexVec<FaceId, Vec<u32>>,
    /// Area of each face, mm².
    pub area: IndexVec<FaceId, f64>,
    /// Length of each face's boundary, mm; seams do not count.
    pub perimeter: IndexVec<FaceId, f64>,
}

impl Aag {
    /// The arcs of a face.
    pub fn arcs_of(&self, face: FaceId) -> impl Iterator<Item = &Arc> {
        self.of_face[face].iter().map(|&i| &self.arcs[i as usize])
    }
    /// The face on the other side of an arc of `face`.
    pub fn across(arc: &Arc, face: FaceId) -> FaceId {
        if arc.faces[0] == face {
            arc.faces[1]
        } else {
            arc.faces[0]
        }
    }
}

/// Two faces that see each other across a wall.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct FacePair {
    /// The two faces, the lower id first.
    pub faces: [FaceId; 2],
    /// Area seen from either side, mean of both directions, mm².
    pub overlap: f64,
    /// Least, mean and greatest distance over the samples, mm.
    pub thickness: [f64; 3],
    /// The wall that the pair belongs to.
    pub wall: WallId,
}

/// A wall: face pairs that continue each other smoothly on both sides.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Wall {
    /// The faces on either side, sorted.
    pub sides: [Vec<FaceId>; 2],
    /// Area-weighted mean thickness, mm.
    pub thickness: f64,
    /// Number of the face group pair (connected component of the pair graph) that it belongs to.
    pub group: u32,
}

/// A peak of the thickness histogram.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ThicknessPeak {
    /// Thickness, mm.
    pub thickness: f64,
    /// Share of the paired area within the peak.
    pub share: f64,
}

/// All pairs and walls of a solid.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Pairing {
    /// Sorted by faces.
    pub pairs: Vec<FacePair>,
    /// The walls.
    pub walls: IndexVec<WallId, Wall>,
    /// Face group and side (0 or 1) of every wall face; `None` for the others.
    pub side: IndexVec<FaceId, Option<(u32, u8)>>,
    /// Peaks of the thickness histogram, greatest share first.
    pub peaks: Vec<ThicknessPeak>,
    /// Histogram that the peaks are read from: (thickness, paired area) a bin, ascending.
    pub histogram: Vec<(f64, f64)>,
}

/// What is wrong with a [`Pairing`].
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum PairingFault {
    /// A pair of a face with itself, or out of order.
    #[error("pair {0:?}-{1:?} is not of two faces in order")]
    BadPair(FaceId, FaceId),
    /// A wall has a face on both of its sides.
    #[error("face {1:?} is on both sides of wall {0:?}")]
    BothSides(WallId, FaceId),
}

impl Pairing {
    /// The pair of two faces, if they form one.
    pub fn pair(&self, a: FaceId, b: FaceId) -> Option<&FacePair> {
        let key = [a.min(b), a.max(b)];
        self.pairs
            .binary_search_by(|p| p.faces.cmp(&key))
            .ok()
            .map(|i| &self.pairs[i])
    }

    /// Whether two wall faces lie on opposite sides of a wall: paired, or of opposite colour in one face group.
    pub fn opposing(&self, a: FaceId, b: FaceId) -> bool {
        if a == b {
            return false;
        }
        match (self.side[a], self.side[b]) {
            (Some((g, s)), Some((h, r))) if g == h && s != r => true,
            _ => self.pair(a, b).is_some(),
        }
    }

    /// All violations.
    pub fn check(&self) -> Vec<PairingFault> {
        let mut faults: Vec<_> = self
            .pairs
            .iter()
            .filter(|p| p.faces[0] >= p.faces[1])
            .map(|p| PairingFault::BadPair(p.faces[0], p.faces[1]))
            .collect();
        for (id, wall) in self.walls.enumerated() {
            faults.extend(
                wall.sides[0]
                    .iter()
                    .filter(|f| wall.sides[1].binary_search(f).is_ok())
                    .map(|&f| PairingFault::BothSides(id, f)),
            );
        }
        faults
    }
}

/// What a face is to the walls.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Role {
    /// One side of a wall.
    WallSide,
    /// Joins the two sides of a wall at its rim or round a hole.
    Lateral,
    /// Fillet or chamfer between walls on the same side.
    Blend,
    /// None of these: part of a lump.
    Lump,
}
