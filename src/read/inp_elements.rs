//! What the names of Abaqus' and CalculiX' element types mean: shape and number of nodes.

/// What an element type is to an audit of shells.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Shape {
    /// A surface element with so many corners and nodes.
    Shell {
        /// Three or four.
        corners: usize,
        /// All nodes, corners first.
        nodes: usize,
    },
    /// A solid with so many nodes.
    Solid {
        /// All nodes.
        nodes: usize,
    },
    /// A line, a point, a connector, or unknown.
    Other,
}

/// Families of surface elements: the name goes on with the number of nodes. The longest that fits counts.
const SURFACES: [&str; 19] = [
    "S", "STRI", "DS", "M3D", "SFM3D", "R3D", "F3D", "CPS", "CPE", "CPEG", "CAX", "CGAX", "DC2D",
    "DCC2D", "DCAX", "DCCAX", "AC2D", "ACAX", "MCL",
];
/// Families of elements with a volume; continuum shells are such.
const SOLIDS: [&str; 8] = ["C3D", "CSS", "DC3D", "DCC3D", "AC3D", "SC", "COH3D", "CCL"];

/// The shape that the name of a type (any case) means.
pub(super) fn shape(name: &str) -> Shape {
    let name = name.trim().to_ascii_uppercase();
    // The one name whose digits run together: a triangle of six nodes and five degrees of freedom each.
    if name.starts_with("STRI65") {
        return Shape::Shell {
            corners: 3,
            nodes: 6,
        };
    }
    if let Some(nodes) = count_after(&name, &SOLIDS).filter(|n| *n >= 4) {
        return Shape::Solid { nodes };
    }
    match count_after(&name, &SURFACES) {
        Some(nodes @ (3 | 6 | 7)) => Shape::Shell { corners: 3, nodes },
        Some(nodes @ (4 | 8 | 9)) => Shape::Shell { corners: 4, nodes },
        _ => Shape::Other,
    }
}

/// The number right behind the longest family that the name begins with; of `S8R5` 8.
fn count_after(name: &str, families: &[&str]) -> Option<usize> {
    let fits = |family: &&&str| {
        let rest = name.strip_prefix(**family);
        rest.is_some_and(|rest| rest.starts_with(|c: char| c.is_ascii_digit()))
    };
    let family = families.iter().filter(fits).max_by_key(|f| f.len())?;
    let digits: String = (name[family.len()..].chars())
        .take_while(char::is_ascii_digit)
        .collect();
    digits.parse().ok()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_of_both_solvers_are_known() {
        let shell = |corners, nodes| Shape::Shell { corners, nodes };
        for (names, want) in [
            (
                "S3 S3R s3rs STRI3 M3D3 R3D3 CPS3 CPE3 CAX3 DS3",
                shell(3, 3),
            ),
            (
                "S4 S4R S4R5 S4RSW M3D4R R3D4 CPS4R CPE4I CAX4P SFM3D4",
                shell(4, 4),
            ),
            ("S6 STRI65 CPS6M M3D6", shell(3, 6)),
            ("S8 S8R S8R5 CPE8R CAX8", shell(4, 8)),
            ("S9R5 M3D9", shell(4, 9)),
            ("C3D4 DC3D4", Shape::Solid { nodes: 4 }),
            ("C3D20R", Shape::Solid { nodes: 20 }),
            ("SC8R", Shape::Solid { nodes: 8 }),
            ("B31 T3D2 MASS SPRINGA SAX1 CONN3D2 DCOUP3D", Shape::Other),
        ] {
            for name in names.split(' ') {
                assert_eq!(shape(name), want, "{name}");
            }
        }
    }
}
