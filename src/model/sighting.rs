//! What a face sees when it looks through the material.

use super::ids::FaceId;
use glam::DVec3;

/// A wall is wider than this in one direction at least: the diagonal of a cube is not, √2 and a little for rounding.
const LEAST_LENGTH: f64 = 1.42;
/// Of a bar the thinner direction is the wall's. Its two directions differ by more than this, the eight directions' error.
const BAR: f64 = 1.1;
/// A lump is a wall across where it is this much longer than thick in any direction: more than the directions' error.
const LUMP_LENGTH: f64 = 1.05;

/// A look whose far side turns from its own by more than this sees no wall: wedges to 30 degrees are walls.
pub const ANTIPARALLEL_COS: f64 = 0.866_025_403_784_438_6;

/// One look through the material.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sighting {
    /// The face that looks.
    pub from: FaceId,
    /// Where it stands.
    pub point: DVec3,
    /// Where it looks: the inward unit normal.
    pub inward: DVec3,
    /// Area that this look stands for, mm².
    pub area: f64,
    /// Face seen across a wall and its distance, mm; `None` where the far side is not antiparallel.
    pub across: Option<(FaceId, f64)>,
    /// How far the wall goes on round the mid-point of this look; zero where it sees none.
    pub extent: Extent,
}

/// Least widths of a wall round one point of its middle, in thicknesses there, up to two, by what ends it; and the greatest.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Extent {
    /// Between two free ends: the section of a bar, of a web between two holes.
    pub bar: f64,
    /// Between material of another thickness at both ends: the bottom of a groove.
    pub neck: f64,
    /// Between a free end and other material, or further than was looked: a rib, a flange.
    pub rib: f64,
    /// The greatest in any direction.
    pub most: f64,
}

impl Extent {
    /// A wall whose ends are out of reach.
    pub const WIDE: Self = Self {
        bar: 2.0,
        neck: 2.0,
        rib: 2.0,
        most: 2.0,
    };

    /// Whether a wall of this extent is wide enough.
    pub fn is_wide(&self, least: &LeastExtent) -> bool {
        self.most > least.most
            && self.rib > least.rib
            && self.neck > least.neck
            && self.bar > least.bar
    }
}

/// What a wall's extent must exceed to be a wall.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LeastExtent {
    rib: f64,
    neck: f64,
    bar: f64,
    most: f64,
}

impl LeastExtent {
    /// Of walls, given their least width in thicknesses. A rib may be narrow, since it has a free end. A neck may not, it is part of the thicker wall; nor may a bar, it
    /// is a wall in the other direction, except where plates perforated so densely are wanted.
    pub fn of_walls(least_width: f64) -> Self {
        Self {
            rib: least_width,
            neck: least_width.max(1.0),
            bar: BAR.min(2.0 * BAR * least_width),
            most: LEAST_LENGTH,
        }
    }

    /// Of walls and of the lumps between them: the thick floor round a hub and the lug that is as thick as long, which have no broader wall that they are part of.
    pub fn of_lumps(least_width: f64) -> Self {
        Self {
            rib: least_width,
            neck: least_width,
            bar: BAR * least_width,
            most: LUMP_LENGTH,
        }
    }
}
