//! Size files: element sizes of single sheets and faces as TOML.
//!
//! ```toml
//! [[size]]
//! sheet = 3         # as `midshell inspect`, the field `sheet` of a VTU file and the set SHEET_3 of a deck have it
//! size = 2.0        # mm
//!
//! [[size]]
//! face = [12, 14]   # faces of the CAD file
//! size = 1.5
//! ```
//!
//! `sheet` and `face` take a number or a list of numbers; gmsh, which reads CAD files, passes no names of faces on. Where several wishes hold in one place the shortest length counts.
//! What is written wrongly is refused with the line; whether the part has such sheets and faces is known only when it is read.

use crate::model::local_size::LocalSize;
use crate::toml_text::{self, Spanned};
use serde::Deserialize;

/// Why a size file is refused.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum SizeFileError {
    /// It is no TOML, or has a key or a value that means nothing.
    #[error("{0}")]
    Toml(String),
    /// There is no wish in it.
    #[error("there is no [[size]] in it")]
    Empty,
    /// A wish without sheet and face.
    #[error("line {0}: a size without a sheet or a face that it holds for")]
    Nowhere(usize),
    /// A size that is no length.
    #[error("line {line}: the size is {size}, but it must be a length above zero (in mm)")]
    NoLength {
        /// From 1.
        line: usize,
        /// What stands there.
        size: f64,
    },
    /// A sheet number below one.
    #[error("line {line}: sheet {sheet}, but sheets are numbered from 1")]
    NoSheet {
        /// From 1.
        line: usize,
        /// What stands there.
        sheet: i64,
    },
}

impl SizeFileError {
    /// What the user can do.
    pub fn remedy(&self) -> String {
        match self {
            SizeFileError::NoLength { .. } => "give a length in mm, such as size = 2.5".into(),
            SizeFileError::NoSheet { .. } => {
                "give a number that 'midshell inspect' shows, such as sheet = 1".into()
            }
            SizeFileError::Toml(_) | SizeFileError::Empty | SizeFileError::Nowhere(_) => {
                "write [[size]], then sheet = N or face = N (or [N, M]) and size = LENGTH, one to a line"
                    .into()
            }
        }
    }
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct File {
    #[serde(default)]
    size: Vec<Spanned<Wish>>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Wish {
    #[serde(default)]
    sheet: Option<Spanned<Many<i64>>>,
    #[serde(default)]
    face: Option<Many<i32>>,
    size: Spanned<f64>,
}

/// One or a list.
#[derive(Deserialize)]
#[serde(untagged, expecting = "a number or a list of numbers")]
enum Many<T> {
    One(T),
    List(Vec<T>),
}

impl<T> Many<T> {
    fn into_vec(self) -> Vec<T> {
        match self {
            Many::One(one) => vec![one],
            Many::List(list) => list,
        }
    }
}

/// Reads a size file; `name` is what messages call it.
pub fn parse(text: &str, name: &str) -> Result<Vec<LocalSize>, SizeFileError> {
    let file: File = toml_text::parse(text).map_err(SizeFileError::Toml)?;
    if file.size.is_empty() {
        return Err(SizeFileError::Empty);
    }
    (file.size.into_iter())
        .map(|wish| {
            let line = toml_text::line(text, &wish);
            let wish = wish.into_inner();
            let mut local = LocalSize {
                size: *wish.size.get_ref(),
                origin: format!("{name}, line {line}"),
                ..LocalSize::default()
            };
            if !(local.size.is_finite() && local.size > 0.0) {
                let line = toml_text::line(text, &wish.size);
                let size = local.size;
                return Err(SizeFileError::NoLength { line, size });
            }
            if let Some(sheets) = wish.sheet {
                let line = toml_text::line(text, &sheets);
                for sheet in sheets.into_inner().into_vec() {
                    let number = u32::try_from(sheet).ok().filter(|&n| n > 0);
                    (local.sheets).push(number.ok_or(SizeFileError::NoSheet { line, sheet })?);
                }
            }
            local.faces = wish.face.map_or(Vec::new(), Many::into_vec);
            if local.sheets.is_empty() && local.faces.is_empty() {
                return Err(SizeFileError::Nowhere(line));
            }
            Ok(local)
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn one_or_several_sheets_and_faces() {
        let text =
            "[[size]]\nsheet = 3\nsize = 2\n\n[[size]]\nsheet = [1, 2]\nface = [12]\nsize = 1.5\n";
        let found = parse(text, "f.toml").unwrap();
        let want = [
            LocalSize {
                sheets: vec![3],
                size: 2.0,
                origin: "f.toml, line 1".into(),
                ..LocalSize::default()
            },
            LocalSize {
                sheets: vec![1, 2],
                faces: vec![12],
                size: 1.5,
                origin: "f.toml, line 5".into(),
            },
        ];
        assert_eq!(found, want);
        let inline = parse("size = [{ face = 4, size = 1 }]", "f").unwrap();
        assert_eq!(inline[0].faces, [4]);
    }

    #[test]
    fn what_is_written_wrongly_is_told_with_its_line() {
        for (text, words) in [
            (
                "[[size]]\nshet = 3\nsize = 2",
                &["line 2", "shet", "sheet"][..],
            ),
            ("[[size]]\nsheet = 3", &["line 1", "size"]),
            ("[[size]]\nsheet = 3\nsize = 'x'", &["line 3"]),
            ("[[size]]\nsheet = 3.5\nsize = 2", &["line 2", "number"]),
            (
                "[[size]]\nface = 'rib'\nsize = 2",
                &["line 2", "a number or a list of numbers"],
            ),
            ("[[sizes]]\nsheet = 3\nsize = 2", &["sizes", "size"]),
            ("[[size]]\nsheet = 3\nsize = -1", &["line 3", "-1"]),
            ("[[size]]\nsheet = 3\nsize = nan", &["line 3", "NaN"]),
            ("[[size]]\nsheet = 3\nsize = inf", &["line 3", "inf"]),
            ("[[size]]\nsheet = 0\nsize = 1", &["line 2", "from 1"]),
            ("[[size]]\nsheet = -2\nsize = 1", &["line 2", "-2"]),
            ("\n[[size]]\nsize = 1", &["line 2", "without a sheet"]),
            (
                "[[size]]\nsheet = []\nsize = 1",
                &["line 1", "without a sheet"],
            ),
            ("", &["no [[size]]"]),
            ("[[size]", &["line 1"]),
        ] {
            let error = parse(text, "x").unwrap_err();
            for word in words {
                assert!(error.to_string().contains(word), "{text}: {error}");
            }
            assert!(error.remedy().len() > 10);
        }
    }
}
