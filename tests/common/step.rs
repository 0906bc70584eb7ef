//! The STEP file of a fixture: as its script makes it, moved, scaled, or with its faces listed in another order.

use super::tools;
use std::path::{Path, PathBuf};
use std::time::Duration;

/// How a solid differs from what its script makes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Variant {
    /// Not at all.
    AsMade,
    /// Turned about a skew axis and shifted.
    Moved,
    /// Every length multiplied.
    Scaled(f64),
    /// The same solid, the faces of each shell listed in another order.
    Reordered,
}

/// Turned by an angle and about an axis that bring no face parallel to a coordinate plane.
pub const MOTION: &str = "Rotate { {1, 2, 3}, {5*s, -7*s, 11*s}, 0.7 } { Volume{:}; }\nTranslate {37*s, -53*s, 71*s} { Volume{:}; }\n";

/// The STEP file of fixture `name`, made by Gmsh unless an earlier run left it under `target/fixtures`.
pub fn step(name: &str, variant: Variant) -> PathBuf {
    let script = tools::root().join(format!("fixtures/gen/{name}.geo"));
    let text =
        std::fs::read_to_string(&script).unwrap_or_else(|e| panic!("{}: {e}", script.display()));
    let save = format!("Save \"{name}.step\";");
    assert!(text.contains(&save), "{}: no line {save}", script.display());
    let (text, scale) = match variant {
        Variant::Moved => (text.replace(&save, &format!("{MOTION}{save}")), 1.0),
        Variant::Scaled(f) => (text, f),
        Variant::AsMade | Variant::Reordered => (text, 1.0),
    };
    let kind = if variant == Variant::Reordered {
        "-reordered"
    } else {
        ""
    };
    let key = fnv1a(format!("{scale}\n{text}").as_bytes());
    let kept = tools::cache().join(format!("{name}-{key:016x}{kind}.step"));
    if kept.is_file() {
        return kept;
    }
    let folder = super::scratch();
    let made = if variant == Variant::Reordered {
        let plain =
            std::fs::read_to_string(step(name, Variant::AsMade)).expect("a STEP file is text");
        let made = folder.path().join("reordered.step");
        std::fs::write(&made, reorder_faces(&plain)).expect("the STEP file can be written");
        made
    } else {
        generate(name, &text, scale, folder.path())
    };
    // Renamed into place: a test running beside this one sees a whole file or none.
    std::fs::rename(&made, &kept).expect("the STEP file can be kept");
    kept
}

/// The STEP file that a script makes in a folder.
pub fn generate(name: &str, text: &str, scale: f64, folder: &Path) -> PathBuf {
    let copy = folder.join(format!("{name}.geo"));
    std::fs::write(&copy, text).expect("the script can be copied");
    let mut command = tools::with_gmsh(tools::gmsh());
    command
        .args([
            "-nopopup",
            "-parse_and_exit",
            "-setnumber",
            "s",
            &scale.to_string(),
        ])
        .arg(&copy);
    let said = tools::run(command, Duration::from_secs(120));
    let made = folder.join(format!("{name}.step"));
    assert!(
        made.is_file() && !said.contains("Error"),
        "{name}.geo made no STEP file:\n{said}"
    );
    made
}

/// The text of a STEP file with the face list of every shell turned round and shifted.
pub fn reorder_faces(text: &str) -> String {
    let word = "CLOSED_SHELL(";
    let mut out = String::with_capacity(text.len());
    let mut rest = text;
    while let Some(at) = rest.find(word) {
        let (before, shell) = rest.split_at(at + word.len());
        out.push_str(before);
        rest = shell;
        // ORIENTED_CLOSED_SHELL names a shell and lists no face.
        if before[..at].ends_with('_') {
            continue;
        }
        let open = rest.find('(').expect("a list of faces");
        let close = open + rest[open..].find(')').expect("its end");
        let mut faces: Vec<&str> = rest[open + 1..close].split(',').map(str::trim).collect();
        faces.reverse();
        let third = faces.len() / 3;
        faces.rotate_left(third);
        out.push_str(&rest[..=open]);
        out.push_str(&faces.join(","));
        rest = &rest[close..];
    }
    out + rest
}

fn fnv1a(bytes: &[u8]) -> u64 {
    bytes.iter().fold(0xcbf2_9ce4_8422_2325, |h, &b| {
        (h ^ u64::from(b)).wrapping_mul(0x0100_0000_01b3)
    })
}
