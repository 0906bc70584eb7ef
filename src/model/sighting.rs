//! What a face sees when it looks through the material.

use super::ids::FaceId;
use glam::DVec3;

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
}
