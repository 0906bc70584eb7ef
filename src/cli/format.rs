//! Which format an output gets: its extension decides; `--format` picks the dialect where an extension has several, and names the format of outputs without one.

use super::complaint::Complaint;
use midshell::model::shell::ShellMesh;
use std::path::Path;

/// Name of a format and its extension, the first of an extension being its usual dialect.
const FORMATS: [(&str, &str); 5] = [
    ("vtu", "vtu"),
    ("msh", "msh"),
    ("calculix", "inp"),
    ("abaqus", "inp"),
    ("nastran", "bdf"),
];

/// A format by its name.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Format(&'static str);

impl Format {
    /// The format of an output.
    pub fn of(output: &Path, wish: Option<&str>) -> Result<Format, Complaint> {
        let wish = wish.map(|name| Self::named(output, name)).transpose()?;
        let extension = output
            .extension()
            .map(|e| e.to_string_lossy().to_lowercase())
            .unwrap_or_default();
        let mut dialects = FORMATS.iter().filter(|f| f.1 == extension).map(|f| f.0);
        match (wish, dialects.clone().next()) {
            (Some(wish), Some(_)) if dialects.any(|name| name == wish.0) => Ok(wish),
            (_, Some(usual)) => Ok(Format(usual)),
            (Some(wish), None) => Ok(wish),
            (None, None) => Err(Complaint::usage(
                format!("cannot write {}", output.display()),
                format!("no format has the extension '{extension}'"),
                format!(
                    "use one of the extensions {}, or name the format with --format",
                    extensions()
                ),
            )),
        }
    }

    fn named(output: &Path, name: &str) -> Result<Format, Complaint> {
        FORMATS
            .iter()
            .find(|f| f.0 == name || f.1 == name)
            .map(|f| Format(f.0))
            .ok_or_else(|| {
                let names: Vec<&str> = FORMATS.iter().map(|f| f.0).collect();
                Complaint::usage(
                    format!("cannot write {}", output.display()),
                    format!("no format is called '{name}'"),
                    format!("choose one of: {}", names.join(", ")),
                )
            })
    }

    /// The file's contents.
    pub fn render(self, _: &ShellMesh) -> Vec<u8> {
        Vec::new()
    }
}

fn extensions() -> String {
    let mut list: Vec<String> = FORMATS.iter().map(|f| format!(".{}", f.1)).collect();
    list.dedup();
    list.join(", ")
}

#[cfg(test)]
mod tests {
    use super::*;

    fn name(output: &str, wish: Option<&str>) -> Option<&'static str> {
        Format::of(Path::new(output), wish).ok().map(|f| f.0)
    }

    #[test]
    fn the_extension_decides_and_the_wish_picks_the_dialect() {
        assert_eq!(name("a.vtu", None), Some("vtu"));
        assert_eq!(name("a.INP", None), Some("calculix"));
        assert_eq!(name("a.inp", Some("abaqus")), Some("abaqus"));
        assert_eq!(name("a.vtu", Some("abaqus")), Some("vtu"));
        assert_eq!(name("/dev/full", Some("vtu")), Some("vtu"));
        assert_eq!(name("a", None), None);
        assert_eq!(name("a.xyz", None), None);
        assert_eq!(name("a.vtu", Some("nonsense")), None);
    }
}
