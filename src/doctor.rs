//! What the program needs from the machine: which gmsh it would run, whether that runs, and the command that mends what is missing.
//!
//! Guarantees: never hangs (every process gets a time limit) and changes nothing.
//! Limits: only what shows without meshing a part; a gmsh that starts may still fail on a file.

use crate::import::tetwild::{self, find_tetwild};
use crate::import::{INSTALL as GMSH, find_gmsh};
use serde::Serialize;
use std::path::{Path, PathBuf};

/// The oldest gmsh whose MSH 4.1 and HXT mesher we rely on, as (major, minor).
const OLDEST_GMSH: (u32, u32) = (4, 11);

/// What mends a missing or unusable gmsh.
fn install_gmsh() -> String {
    format!("{GMSH}, then name it with --gmsh or MIDSHELL_GMSH")
}

/// One thing that was looked at.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Finding {
    /// What was looked at.
    pub what: String,
    /// What was found.
    pub found: String,
    /// The command or deed that mends it; none where all is well.
    pub remedy: Option<String>,
    /// Whether the program does without it, and only refuses what it would be needed for.
    pub optional: bool,
}

impl Finding {
    fn well(what: &str, found: String) -> Self {
        Self {
            what: what.into(),
            found,
            remedy: None,
            optional: false,
        }
    }
    fn ill(what: &str, found: String, remedy: &str) -> Self {
        Self {
            what: what.into(),
            found,
            remedy: Some(remedy.into()),
            optional: false,
        }
    }
}

/// Looks at everything the program needs. `gmsh` is the command that the user named, if any.
pub fn examine(gmsh: Option<&Path>) -> Vec<Finding> {
    let mut findings = vec![Finding::well(
        "midshell",
        format!("{}, {}", env!("CARGO_PKG_VERSION"), std::env::consts::ARCH),
    )];
    findings.extend(examine_gmsh(gmsh));
    findings.push(examine_tetwild(named_or_found(gmsh).as_deref()));
    findings.push(examine_temporary_folder());
    let cores = std::thread::available_parallelism().map_or(1, usize::from);
    findings.push(Finding::well("cores", cores.to_string()));
    findings
}

fn examine_gmsh(named: Option<&Path>) -> Vec<Finding> {
    let gmsh = match find_gmsh(named) {
        Ok(gmsh) => gmsh,
        Err(error) => return vec![Finding::ill("gmsh", error.to_string(), &error.remedy())],
    };
    let place = Finding::well("gmsh", gmsh.path.display().to_string());
    vec![place, examine_version(&gmsh.version)]
}

fn named_or_found(named: Option<&Path>) -> Option<PathBuf> {
    find_gmsh(named).ok().map(|g| g.path)
}

/// The optional mesher for parts that gmsh cannot fill: where it is missing, the program works, but refuses such parts.
fn examine_tetwild(gmsh: Option<&Path>) -> Finding {
    let what = "fTetWild";
    let finding = match find_tetwild(gmsh) {
        Ok(t) => Finding::well(
            what,
            format!("pytetwild {}, {}", t.version, t.python.display()),
        ),
        Err(error) => {
            let found = format!("{error}: parts that gmsh cannot fill will be refused");
            Finding::ill(what, found, tetwild::INSTALL)
        }
    };
    Finding {
        optional: true,
        ..finding
    }
}

fn examine_version(text: &str) -> Finding {
    let what = "gmsh version";
    match parse_version(text) {
        Some(version) if version >= OLDEST_GMSH => Finding::well(what, text.to_owned()),
        Some(_) => {
            let (major, minor) = OLDEST_GMSH;
            let found = format!("{text}, but {major}.{minor} or later is needed");
            Finding::ill(what, found, &install_gmsh())
        }
        None => {
            let found = format!("it answers '{text}', which is no version");
            Finding::ill(what, found, &install_gmsh())
        }
    }
}

/// Major and minor number of a text such as `4.15.2` or `4.15.2-git`.
fn parse_version(text: &str) -> Option<(u32, u32)> {
    let mut numbers = text.split('.');
    Some((
        numbers.next()?.trim().parse().ok()?,
        numbers.next()?.trim().parse().ok()?,
    ))
}

fn examine_temporary_folder() -> Finding {
    let folder = std::env::temp_dir();
    match tempfile::tempfile_in(&folder) {
        Ok(_) => Finding::well("temporary folder", folder.display().to_string()),
        Err(e) => Finding::ill(
            "temporary folder",
            format!("{}: {e}", folder.display()),
            "point TMPDIR at a folder with room that you may write to",
        ),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_missing_gmsh_is_found_out_and_mended() {
        let findings = examine(Some(Path::new("/nonexistent/gmsh")));
        let ill: Vec<&Finding> = findings
            .iter()
            .filter(|f| f.remedy.is_some() && !f.optional)
            .collect();
        assert_eq!(ill.len(), 1, "{findings:?}");
        assert!(ill[0].found.contains("/nonexistent/gmsh"));
        assert!(ill[0].remedy.as_ref().unwrap().contains("pip install gmsh"));
    }

    #[test]
    fn versions_are_compared_as_numbers() {
        assert_eq!(parse_version("4.15.2-git"), Some((4, 15)));
        assert_eq!(parse_version("hello"), None);
        assert_eq!(examine_version("4.15.2").remedy, None);
        for bad in ["4.8.4", "hello", ""] {
            assert!(examine_version(bad).remedy.is_some(), "{bad}");
        }
    }
}
