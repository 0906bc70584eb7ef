//! A cheap look at the input before a process is started for it.
//!
//! Tells apart what is missing, no file, empty, unreadable, of another format, no CAD file in spite of its name, or cut short. It reads a
//! few kilobytes at both ends and never judges the geometry.

use std::fs::File;
use std::io::{Error, ErrorKind, Read, Seek, SeekFrom};
use std::path::Path;

use super::error::ImportError;
use super::facet::FacetFormat;

/// How a file is to be read.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Format {
    Cad(CadFormat),
    Facets(FacetFormat),
}

/// A CAD format that gmsh reads.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum CadFormat {
    Step,
    Iges,
    Brep,
}

impl CadFormat {
    /// The extension by which gmsh knows the format.
    pub(super) fn extension(self) -> &'static str {
        match self {
            Self::Step => "step",
            Self::Iges => "iges",
            Self::Brep => "brep",
        }
    }
}

/// How much is read at either end: headers and closing lines are far shorter, comments before them seldom longer.
const WINDOW: u64 = 64 * 1024;

/// The format of a file that looks like one of that format.
pub(super) fn look_at(path: &Path) -> Result<Format, ImportError> {
    let path_buf = || path.to_path_buf();
    let unreadable = |cause: Error| match cause.kind() {
        ErrorKind::NotFound => ImportError::NotFound { path: path_buf() },
        _ => ImportError::Unreadable {
            path: path_buf(),
            cause,
        },
    };
    let meta = std::fs::metadata(path).map_err(unreadable)?;
    if !meta.is_file() {
        return Err(ImportError::NotAFile { path: path_buf() });
    }
    if meta.len() == 0 {
        return Err(ImportError::Empty { path: path_buf() });
    }
    let extension = path
        .extension()
        .map(|e| e.to_string_lossy().to_ascii_lowercase())
        .unwrap_or_default();
    let format = match extension.as_str() {
        "step" | "stp" | "p21" => CadFormat::Step,
        "iges" | "igs" => CadFormat::Iges,
        "brep" | "brp" => CadFormat::Brep,
        e => {
            return FacetFormat::of_extension(e)
                .map(Format::Facets)
                .ok_or_else(|| ImportError::UnknownFormat {
                    path: path_buf(),
                    extension: extension.clone(),
                });
        }
    };
    let (head, tail) = ends(path, meta.len()).map_err(unreadable)?;
    match fault(format, &head, &tail) {
        None => Ok(Format::Cad(format)),
        Some(reason) => Err(ImportError::NotCad {
            path: path_buf(),
            reason: reason.to_owned(),
        }),
    }
}

fn ends(path: &Path, length: u64) -> Result<(Vec<u8>, Vec<u8>), Error> {
    let mut file = File::open(path)?;
    let mut head = Vec::new();
    file.by_ref().take(WINDOW).read_to_end(&mut head)?;
    file.seek(SeekFrom::Start(length.saturating_sub(WINDOW)))?;
    let mut tail = Vec::new();
    file.take(WINDOW).read_to_end(&mut tail)?;
    Ok((head, tail))
}

fn contains(bytes: &[u8], mark: &str) -> bool {
    bytes
        .windows(mark.len())
        .any(|w| w.eq_ignore_ascii_case(mark.as_bytes()))
}

/// The letter of an IGES line's section: its column 73.
fn iges_section(line: &[u8]) -> Option<u8> {
    line.get(72).copied()
}

fn fault(format: CadFormat, head: &[u8], tail: &[u8]) -> Option<&'static str> {
    match format {
        CadFormat::Step if !contains(head, "ISO-10303-21;") => {
            Some("it does not begin as a STEP file does (ISO-10303-21;)")
        }
        CadFormat::Step if !contains(tail, "END-ISO-10303-21;") => {
            Some("it is cut short: the closing line END-ISO-10303-21; is missing")
        }
        CadFormat::Iges => {
            let mut lines = tail.rsplit(|&b| b == b'\n');
            let last = lines.find(|l| !l.trim_ascii().is_empty())?;
            let first = head.split(|&b| b == b'\n').next()?;
            if !matches!(iges_section(first), Some(b'S' | b'B' | b'C')) {
                Some("it does not begin as an IGES file does (S in column 73)")
            } else if iges_section(last) != Some(b'T') {
                Some("it is cut short: the closing line (T in column 73) is missing")
            } else {
                None
            }
        }
        CadFormat::Brep
            if !contains(head, "DBRep_DrawableShape")
                && !contains(head, "CASCADE Topology")
                && !contains(head, "Open CASCADE") =>
        {
            Some("it does not begin as an OpenCASCADE BREP file does")
        }
        CadFormat::Step | CadFormat::Brep => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn look(name: &str, bytes: &[u8]) -> Result<Format, ImportError> {
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join(name);
        std::fs::write(&path, bytes).unwrap();
        look_at(&path)
    }

    #[test]
    fn a_whole_step_file_passes_in_any_case_of_its_extension() {
        let text = b"ISO-10303-21;\nHEADER;\nENDSEC;\nDATA;\nENDSEC;\nEND-ISO-10303-21;\n";
        for name in ["a.step", "a.STP", "a b'\"c.Step"] {
            assert_eq!(look(name, text).unwrap(), Format::Cad(CadFormat::Step));
        }
    }

    #[test]
    fn every_kind_of_wrong_input_has_its_own_error() {
        assert!(matches!(
            look_at(Path::new("/no/such/part.step")),
            Err(ImportError::NotFound { .. })
        ));
        assert!(matches!(
            look_at(Path::new("/")),
            Err(ImportError::NotAFile { .. })
        ));
        assert!(matches!(
            look("a.step", b""),
            Err(ImportError::Empty { .. })
        ));
        assert!(matches!(
            look("a.docx", b"x"),
            Err(ImportError::UnknownFormat { .. })
        ));
        assert!(matches!(
            look("a", b"x"),
            Err(ImportError::UnknownFormat { .. })
        ));
        assert!(matches!(
            look("a.off", b"OFF"),
            Err(ImportError::UnknownFormat { .. })
        ));
        for (name, text) in [
            ("text.step", "hello"),
            ("cut.step", "ISO-10303-21;\nHEADER;"),
            ("text.igs", "hello"),
            ("text.brep", "hello"),
        ] {
            let error = look(name, text.as_bytes());
            assert!(
                matches!(error, Err(ImportError::NotCad { .. })),
                "{name}: {error:?}"
            );
        }
    }

    #[test]
    fn an_iges_file_begins_with_s_and_ends_with_t_in_column_73() {
        let line = |letter| format!("{:<72}{letter}{:>7}\n", "text", 1);
        let whole = line('S') + &line('G') + &line('T');
        assert_eq!(
            look("a.igs", whole.as_bytes()).unwrap(),
            Format::Cad(CadFormat::Iges)
        );
        let cut = line('S') + &line('G');
        assert!(matches!(
            look("a.igs", cut.as_bytes()),
            Err(ImportError::NotCad { .. })
        ));
    }
}
