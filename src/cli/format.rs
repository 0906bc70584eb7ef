//! Which format an output gets: its extension decides; `--format` picks the dialect where an extension has several, and names the format of outputs
//! whose extension says nothing.

use super::complaint::Complaint;
use midshell::export::Format;
use std::path::Path;

/// The format of an output.
pub fn format_of(output: &Path, wish: Option<&str>) -> Result<Format, Complaint> {
    let what = || format!("cannot write {}", output.display());
    let wish = match wish.map(|name| (name, Format::from_name(name))) {
        Some((name, None)) => {
            let cause = format!("no format is called '{name}'");
            return Err(Complaint::usage(
                what(),
                cause,
                format!("choose one of: {}", names()),
            ));
        }
        Some((_, format)) => format,
        None => None,
    };
    let extension = output
        .extension()
        .map(|e| e.to_string_lossy().into_owned())
        .unwrap_or_default();
    match (Format::from_extension(&extension), wish) {
        (Some(usual), Some(wish)) if wish.extension() == usual.extension() => Ok(wish),
        (Some(usual), _) => Ok(usual),
        (None, Some(wish)) => Ok(wish),
        (None, None) => Err(Complaint::usage(
            what(),
            format!("no format has the extension '{extension}'"),
            format!(
                "end its name with one of {}, or name the format with --format",
                extensions()
            ),
        )),
    }
}

/// The names of all formats, for people.
pub fn names() -> String {
    Format::ALL.map(Format::name).join(", ")
}

fn extensions() -> String {
    let mut list = Format::ALL.map(|f| format!(".{}", f.extension())).to_vec();
    list.sort();
    list.dedup();
    list.join(", ")
}

#[cfg(test)]
mod tests {
    use super::*;

    fn found(output: &str, wish: Option<&str>) -> Option<Format> {
        format_of(Path::new(output), wish).ok()
    }

    #[test]
    fn the_extension_decides_and_the_wish_picks_the_dialect() {
        assert_eq!(found("a.vtu", None), Some(Format::Vtu));
        assert_eq!(found("a.INP", None), Some(Format::Calculix));
        assert_eq!(found("a.inp", Some("abaqus")), Some(Format::Abaqus));
        assert_eq!(found("a.vtu", Some("abaqus")), Some(Format::Vtu));
        assert_eq!(found("/dev/full", Some("vtu")), Some(Format::Vtu));
        assert_eq!(found("a", None), None);
        assert_eq!(found("a.xyz", None), None);
        assert_eq!(found("a.vtu", Some("nonsense")), None);
    }
}
