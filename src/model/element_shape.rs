//! Which elements a caller asks for.

use std::fmt;
use std::str::FromStr;

/// A name that belongs to no element shape.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[error("no element shape is called '{0}'")]
pub struct UnknownShape(pub String);

/// Which elements the shell is made of.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub enum ElementShape {
    /// Triangles only.
    #[default]
    Triangle,
    /// Quads wherever two triangles pair well; the fewest triangles.
    Quad,
    /// Quads where they are better than the triangles that they replace.
    Mixed,
}

impl ElementShape {
    /// Every shape with its name on the command line and in reports.
    pub const NAMED: [(&'static str, ElementShape); 3] = [
        ("tri", ElementShape::Triangle),
        ("quad", ElementShape::Quad),
        ("mixed", ElementShape::Mixed),
    ];

    /// Its name.
    pub fn name(self) -> &'static str {
        Self::NAMED
            .iter()
            .find(|(_, shape)| *shape == self)
            .map_or("", |(name, _)| name)
    }
}

impl fmt::Display for ElementShape {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

impl FromStr for ElementShape {
    type Err = UnknownShape;
    fn from_str(text: &str) -> Result<Self, UnknownShape> {
        Self::NAMED
            .iter()
            .find(|(name, _)| *name == text)
            .map(|(_, shape)| *shape)
            .ok_or_else(|| UnknownShape(text.to_owned()))
    }
}

impl serde::Serialize for ElementShape {
    fn serialize<S: serde::Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.serialize_str(self.name())
    }
}
