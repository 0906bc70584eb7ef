//! How a run ended, as a number that scripts can branch on: the one table behind `--help`, the README and the process status.

use serde::Serialize;

/// How a run ended. The variants are in order of their codes.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum ExitClass {
    /// The result is written and its own audit found nothing against it; or an audited mesh has nothing against it.
    Right,
    /// The result is written, but its own audit doubts it; or an audited mesh breaks the criteria, hangs together badly, or does not fit its solid.
    Doubted,
    /// The command line asks for something that cannot be.
    BadUsage,
    /// The input, a CAD file or facets (STL, OBJ, PLY), cannot be read or is not a closed solid; or a mesh cannot be read or has no shells.
    BadInput,
    /// The solid has no thin wall: there is nothing to put a shell on.
    NoThinWall,
    /// A tool that the run needs is missing, failed or ran out of time.
    ToolFailed,
    /// An output cannot be written.
    OutputFailed,
    /// The program itself is at fault.
    Internal,
}

impl ExitClass {
    /// Every class, in order of the codes.
    pub const ALL: [ExitClass; 8] = [
        ExitClass::Right,
        ExitClass::Doubted,
        ExitClass::BadUsage,
        ExitClass::BadInput,
        ExitClass::NoThinWall,
        ExitClass::ToolFailed,
        ExitClass::OutputFailed,
        ExitClass::Internal,
    ];

    /// The status that the process ends with. 70 is `EX_SOFTWARE` of `sysexits.h`.
    pub fn code(self) -> u8 {
        match self {
            ExitClass::Right => 0,
            ExitClass::Doubted => 1,
            ExitClass::BadUsage => 2,
            ExitClass::BadInput => 3,
            ExitClass::NoThinWall => 4,
            ExitClass::ToolFailed => 5,
            ExitClass::OutputFailed => 6,
            ExitClass::Internal => 70,
        }
    }

    /// One line for people.
    pub fn meaning(self) -> &'static str {
        match self {
            ExitClass::Right => {
                "the result is written, and right by its own audit, or an audited mesh is sound"
            }
            ExitClass::Doubted => {
                "the result is written, but doubted by its own audit, or an audited mesh is not sound"
            }
            ExitClass::BadUsage => "bad usage",
            ExitClass::BadInput => {
                "the input cannot be read, is no closed solid (CAD file, facets), or has no shells (mesh)"
            }
            ExitClass::NoThinWall => "no thin wall found",
            ExitClass::ToolFailed => {
                "a tool (gmsh, fTetWild) is missing, failed or ran out of time"
            }
            ExitClass::OutputFailed => "an output cannot be written",
            ExitClass::Internal => "internal error: a bug, please report it",
        }
    }

    /// Whether result files are left behind.
    pub fn leaves_result(self) -> bool {
        matches!(self, ExitClass::Right | ExitClass::Doubted)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn codes_are_distinct_and_in_order() {
        let codes: Vec<u8> = ExitClass::ALL.iter().map(|c| c.code()).collect();
        assert!(codes.windows(2).all(|w| w[0] < w[1]), "{codes:?}");
        assert!(ExitClass::ALL.windows(2).all(|w| w[0] < w[1]));
    }
}
