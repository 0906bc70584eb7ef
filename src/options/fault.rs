//! What can be wrong with the choices of a run, and what to do about it.

use super::{GROWTH, MIN_PER_TURN, MOST_ROWS};
use crate::model::element_shape::{ElementShape, UnknownShape};
use crate::model::keep::KeepEdge;
use crate::model::length_unit::{LengthUnit, UnknownUnit};
use crate::model::profile::ProfileFault;
use crate::model::washer::{BareHole, WasherFault};

/// What can be wrong with the options.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum OptionFault {
    /// A length that is zero, negative, infinite or no number.
    #[error("the element size is {0}, but it must be a length above zero (in mm)")]
    Size(f64),
    /// A bound of the element size that is no length; the option's name comes first.
    #[error("{0} is {1}, but it must be a length above zero (in mm)")]
    Bound(&'static str, f64),
    /// The least element size is above the largest.
    #[error("the least element size, {min} mm, is above the largest, {max} mm")]
    Bounds {
        /// Least size, mm.
        min: f64,
        /// Largest size, mm.
        max: f64,
    },
    /// A size that the bounds do not allow.
    #[error("{what} is {size} mm, but the bounds allow {}", between(*.min, *.max))]
    OutOfBounds {
        /// Which size: the option, or where in a file it stands.
        what: String,
        /// The size, mm.
        size: f64,
        /// Least size allowed, mm; zero where there is no bound.
        min: f64,
        /// Largest size allowed, mm; infinite where there is no bound.
        max: f64,
    },
    /// Edges that may not grow, or grow so fast that no good element fits between.
    #[error("neighbouring edges may differ by a factor of {0}, but it must lie between {least} and {most}", least = GROWTH[0], most = GROWTH[1])]
    Growth(f64),
    /// No rows of elements, or more than any sheet needs.
    #[error("{0} rows of elements across a sheet, but there must be 1 to {MOST_ROWS}")]
    Rows(u32),
    /// The wanted elements are larger than the part.
    #[error(
        "{what}: the element size {size} mm is larger than the part, which measures {part:.1} mm corner to corner"
    )]
    SizeBeyondPart {
        /// Which size: the option, or where in a file it stands.
        what: String,
        /// The size asked for, mm.
        size: f64,
        /// Diagonal of the part's box, mm.
        part: f64,
    },
    /// A size is wanted on a sheet that the part does not have.
    #[error("{origin}: there is no sheet {sheet}; the part has {}", sheets_to(*.sheets))]
    NoSheet {
        /// Where the wish stands.
        origin: String,
        /// The sheet that it names.
        sheet: u32,
        /// How many sheets there are.
        sheets: usize,
    },
    /// A size is wanted on a face that the part does not have.
    #[error("{origin}: there is no face {face}; the part has the faces {}", ranges(.faces))]
    NoFace {
        /// Where the wish stands.
        origin: String,
        /// The face that it names.
        face: i32,
        /// The numbers of the part's faces, ascending.
        faces: Vec<i32>,
    },
    /// An edge is to be kept between two faces that have none.
    #[error("--keep-edge {wish}: the two faces share no edge; face {face} has edges with the faces {}", ranges(.near), face = wish.faces[0])]
    NoEdge {
        /// The wish.
        wish: KeepEdge,
        /// The faces that share an edge with the first, ascending.
        near: Vec<i32>,
    },
    /// An edge is to be kept that lies within no side of a wall.
    #[error(
        "--keep-edge {0}: the edge lies within no side of a wall: it is a rim, or walls meet there, so that the mesh has a line beneath it or ends there anyway"
    )]
    OuterEdge(KeepEdge),
    /// An edge is to be kept beneath which a line would end inside its sheet.
    #[error("--keep-edge {wish}: the line beneath ends inside its sheet, near ({:.1}, {:.1}, {:.1})", at[0], at[1], at[2])]
    PartsNothing {
        /// The wish.
        wish: KeepEdge,
        /// A place on the line, mm.
        at: [f64; 3],
    },
    /// A least size of holes or features that is zero, negative, infinite or no number.
    #[error("the least {0} is {1}, but it must be a length above zero (in mm)")]
    Small(&'static str, f64),
    /// All holes or features would be small.
    #[error(
        "the least {0} {1} mm is larger than the part, which measures {2:.1} mm corner to corner"
    )]
    SmallBeyondPart(&'static str, f64, f64),
    /// Too few elements a turn.
    #[error("{0} elements in a full turn: a turn takes at least {MIN_PER_TURN}, and a number")]
    SizeCurvature(f64),
    /// A time limit of zero.
    #[error("the time limit is zero: nothing can be done in no time")]
    TimeLimit,
    /// An element shape that we do not know.
    #[error(transparent)]
    Shape(#[from] UnknownShape),
    /// A unit that we do not know.
    #[error(transparent)]
    Unit(#[from] UnknownUnit),
    /// Washers that mean nothing.
    #[error(transparent)]
    Washer(#[from] WasherFault),
    /// Washers in a mesh of triangles.
    #[error("washers are rings of quads, but the elements are to be triangles")]
    WasherShape,
    /// The width asked for is more than there is room for round these holes.
    #[error("a washer is wider than the room for it\n{}", lines(.0))]
    WasherRoom(Vec<BareHole>),
    /// Criteria that mean nothing.
    #[error(transparent)]
    Profile(#[from] ProfileFault),
}

impl OptionFault {
    /// What the user can do about it.
    pub fn remedy(&self) -> String {
        match self {
            OptionFault::Size(_) => {
                "give a length such as --size 5, or leave --size out: then the part decides".into()
            }
            OptionFault::Bound(name, _) => {
                format!("give a length such as {name} 5, or leave {name} out")
            }
            OptionFault::Bounds { min, max } => {
                format!("exchange them (--size-min {max} --size-max {min}), or leave one out")
            }
            OptionFault::OutOfBounds { .. } => {
                "give a size within the bounds, or others with --size-min and --size-max".into()
            }
            OptionFault::Growth(_) => {
                "give a factor such as --growth 1.2, or leave it out".into()
            }
            OptionFault::Rows(_) => {
                "give a number such as --rows 3; 1 asks for nothing beyond the size".into()
            }
            OptionFault::SizeBeyondPart { part, .. } => format!(
                "give a size below {part:.1} mm (is the file in the unit that you expect?), or leave it out: then the part decides"
            ),
            OptionFault::NoSheet { .. } => {
                "name a sheet by the number that 'midshell inspect', the field 'sheet' of a VTU file or the set SHEET_n of a deck shows".into()
            }
            OptionFault::NoFace { .. } => {
                "name a face by the number that 'midshell inspect' and the fields 'source_face_a' and 'source_face_b' of a VTU file show".into()
            }
            OptionFault::NoEdge { .. } => {
                "name two faces that lie side by side, by the numbers that 'midshell inspect' shows".into()
            }
            OptionFault::OuterEdge(_) => {
                "leave it out, or name two faces that 'midshell inspect' lists on the same side of one wall".into()
            }
            OptionFault::PartsNothing { .. } => {
                "keep edges too that lead on from there to a rim, to a junction or back".into()
            }
            OptionFault::Small(..) => {
                "give a length such as --min-hole 5 or --min-feature 2, or leave it out: then nothing is taken out".into()
            }
            OptionFault::SmallBeyondPart(.., part) => format!(
                "give a length below {part:.1} mm (is the file in the unit that you expect?), or leave it out: then nothing is taken out"
            ),
            OptionFault::SizeCurvature(_) => {
                "give a number such as --size-curvature 24, or leave it out".into()
            }
            OptionFault::TimeLimit => {
                "give the seconds of processor time that reading and filling the part may take, such as --time-limit 300".into()
            }
            OptionFault::Shape(_) => {
                let names: Vec<&str> = ElementShape::NAMED.iter().map(|n| n.0).collect();
                format!("choose one of: {}", names.join(", "))
            }
            OptionFault::Washer(fault) => fault.remedy().into(),
            OptionFault::WasherShape => "add --element quad, or --element mixed".into(),
            OptionFault::WasherRoom(_) => "give a smaller --washer-width, or leave it out: then each washer is as wide as it can be; or fewer rings, or a range --washer-holes without these holes".into(),
            OptionFault::Profile(_) => {
                "mend the criteria, or choose a profile that comes with the program".into()
            }
            OptionFault::Unit(_) => {
                let names: Vec<&str> = LengthUnit::NAMED.iter().map(|n| n.0).collect();
                format!("choose one of: {}", names.join(", "))
            }
        }
    }
}

/// Holes that an error tells one by one: enough to see what they have in common.
const TOLD: usize = 10;

fn lines(holes: &[BareHole]) -> String {
    let told = holes.iter().take(TOLD).map(ToString::to_string);
    let more = holes.len().checked_sub(TOLD).filter(|n| *n > 0);
    let more = more.map(|n| format!("and holes more: {n}"));
    told.chain(more).collect::<Vec<_>>().join("\n")
}

/// Which lengths lie between two bounds, mm.
fn between(min: f64, max: f64) -> String {
    match (min > 0.0, max.is_finite()) {
        (true, true) => format!("{min} to {max} mm"),
        (true, false) => format!("{min} mm and more"),
        _ => format!("{max} mm at most"),
    }
}

/// How many sheets there are, by their numbers.
fn sheets_to(count: usize) -> String {
    match count {
        1 => "one sheet, number 1".to_owned(),
        n => format!("sheets 1 to {n}"),
    }
}

/// Ascending numbers, runs of them as from-to.
fn ranges(numbers: &[i32]) -> String {
    let runs = numbers.chunk_by(|a, b| a + 1 == *b);
    let texts: Vec<String> = runs
        .map(|run| match *run {
            [one] => one.to_string(),
            [first, .., last] => format!("{first} to {last}"),
            [] => String::new(),
        })
        .collect();
    texts.join(", ")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_not_there_is_told_with_what_is() {
        let origin = || "sizes.toml, line 4".to_owned();
        let sheet = OptionFault::NoSheet {
            origin: origin(),
            sheet: 9,
            sheets: 3,
        };
        assert_eq!(
            sheet.to_string(),
            "sizes.toml, line 4: there is no sheet 9; the part has sheets 1 to 3"
        );
        let face = OptionFault::NoFace {
            origin: origin(),
            face: 9,
            faces: vec![1, 2, 3, 5, 7, 8],
        };
        assert!(face.to_string().ends_with("the faces 1 to 3, 5, 7 to 8"));
        let edge = OptionFault::NoEdge {
            wish: KeepEdge { faces: [4, 9] },
            near: vec![1, 2, 6],
        };
        assert_eq!(
            edge.to_string(),
            "--keep-edge 4-9: the two faces share no edge; face 4 has edges with the faces 1 to 2, 6"
        );
        let idle = OptionFault::PartsNothing {
            wish: KeepEdge { faces: [4, 9] },
            at: [1.0, 2.04, 3.0],
        };
        assert!(idle.to_string().ends_with("near (1.0, 2.0, 3.0)"));
    }
}
