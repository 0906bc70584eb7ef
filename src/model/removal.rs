//! Small holes and raised or sunk features that the user wants out of the mesh: what was taken out, what had to stay, and why.

use glam::DVec3;
use serde::Serialize;

/// Below what size the mesh does without something, mm. None: nothing is taken out.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct SmallLimits {
    /// Diameter of the circle that is as long as a hole's rim.
    pub hole: Option<f64>,
    /// Extent of a feature along the wall, and its height.
    pub feature: Option<f64>,
}

impl SmallLimits {
    /// The limits that there are, with what they limit.
    pub fn named(&self) -> impl Iterator<Item = (&'static str, f64)> {
        let all = [("hole diameter", self.hole), ("feature size", self.feature)];
        all.into_iter()
            .filter_map(|(name, limit)| Some((name, limit?)))
    }

    /// Whether nothing is to be taken out.
    pub fn are_none(&self) -> bool {
        self.hole.is_none() && self.feature.is_none()
    }
}

/// What a removal was.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum SmallKind {
    /// A hole through a wall.
    #[default]
    Hole,
    /// What stands out of one side of a wall or is sunk into it.
    Feature,
}

/// Something small that the solid has and the mesh has not.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Removal {
    /// What it was.
    pub kind: SmallKind,
    /// The solid that has it, by its number in the file.
    pub solid: i32,
    /// Its middle, mm: of its rims on the sides of the wall.
    pub at: DVec3,
    /// Of a hole the diameter of a circle as long as its rim, the larger of both sides; of a feature its extent along the wall, mm.
    pub size: f64,
    /// How high a feature stands out, or how deep it is sunk in, mm; of a hole the thickness of the wall.
    pub height: f64,
    /// Tags of the faces that the mesh does without.
    pub faces: Vec<i32>,
    /// The number that the sheet which goes on there has in mesh files.
    pub sheet: Option<usize>,
}

/// Something small enough that had to stay.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Left {
    /// What it is.
    pub kind: SmallKind,
    /// The solid that has it, by its number in the file.
    pub solid: i32,
    /// Its middle, mm.
    pub at: DVec3,
    /// As for [`Removal::size`], mm.
    pub size: f64,
    /// Why.
    pub why: Obstacle,
}

/// Why something small stays.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, thiserror::Error)]
#[serde(rename_all = "snake_case")]
pub enum Obstacle {
    /// The faces within it end in other walls too.
    #[error("it does not open into the two sides of one wall alone")]
    Open,
    /// The sheet does not go on flat over it: the end of a tube, the top of a cone.
    #[error("it is the end of a wall, not a hole in one")]
    End,
    /// Another part of the solid runs through it.
    #[error("something runs through it")]
    Obstructed,
    /// The rim of the mid-surface there is no simple ring of one sheet.
    #[error("the mid-surface has no rim of a single sheet there")]
    Rim,
    /// Its opening could not be closed.
    #[error("its rim is too crooked to be closed")]
    Crooked,
    /// Sheets of its own stand on the wall.
    #[error("walls of its own stand there that cannot be left out")]
    Walls,
    /// All that was to be taken out together would have changed the part in other ways too.
    #[error("taken out with the others it would change more than itself")]
    Together,
}
