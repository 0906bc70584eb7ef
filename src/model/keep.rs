//! Edges of the solid that the mesh keeps as lines of element edges, though they lie inside a sheet.

use serde::{Serialize, Serializer};
use std::fmt;
use std::str::FromStr;

/// The wish that all edges between two faces stay in the mesh. As text `A-B`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct KeepEdge {
    /// The two faces by their numbers in the file that the part came from.
    pub faces: [i32; 2],
}

/// A text that names no two faces.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("not the numbers of two different faces, such as 3-7")]
pub struct NoFacePair;

impl FromStr for KeepEdge {
    type Err = NoFacePair;

    fn from_str(text: &str) -> Result<Self, NoFacePair> {
        let number = |part: &str| part.trim().parse::<i32>().ok().filter(|n| *n > 0);
        let (a, b) = text.split_once('-').ok_or(NoFacePair)?;
        match (number(a), number(b)) {
            (Some(a), Some(b)) if a != b => Ok(Self { faces: [a, b] }),
            _ => Err(NoFacePair),
        }
    }
}

impl fmt::Display for KeepEdge {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let [a, b] = self.faces;
        write!(f, "{a}-{b}")
    }
}

impl Serialize for KeepEdge {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.collect_str(self)
    }
}

/// What the mesh has of edges that were to be kept.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct KeptEdge {
    /// The numbers of the two faces.
    pub faces: [i32; 2],
    /// How many element edges lie beneath.
    pub edges: usize,
    /// How long these are together, mm.
    pub length: f64,
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn two_different_numbers_above_zero_name_edges_and_nothing_else_does() {
        assert_eq!("3-7".parse(), Ok(KeepEdge { faces: [3, 7] }));
        assert_eq!(" 12 - 4".parse(), Ok(KeepEdge { faces: [12, 4] }));
        for bad in [
            "",
            "3",
            "3-",
            "-7",
            "3-3",
            "0-1",
            "3--7",
            "3-7-9",
            "a-b",
            "3,7",
            "99999999999-1",
        ] {
            assert_eq!(bad.parse::<KeepEdge>(), Err(NoFacePair), "{bad}");
        }
        assert_eq!(KeepEdge { faces: [3, 7] }.to_string(), "3-7");
    }
}
