//! What the program needs from the machine: which gmsh it would run, whether that runs, and the command that mends what is missing.
//!
//! Guarantees: never hangs (every process gets a time limit) and changes nothing.
//! Limits: only what shows without meshing a part; a gmsh that starts may still fail on a file.

use serde::Serialize;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

/// Environment variable that names the gmsh command.
pub const GMSH_VARIABLE: &str = "MIDSHELL_GMSH";
/// Longest that gmsh may take to say its version: a cold start of the Python wheel takes a second or two.
const VERSION_LIMIT: Duration = Duration::from_secs(20);
/// The oldest gmsh whose MSH 4.1 and HXT mesher we rely on, as (major, minor).
const OLDEST_GMSH: (u32, u32) = (4, 9);

const INSTALL_GMSH: &str = "python3 -m venv .venv && . .venv/bin/activate && pip install gmsh==4.15.2 (or apt-get install gmsh)";
const INSTALL_LIBRARIES: &str =
    "apt-get install libglu1-mesa libgl1 libxrender1 libxcursor1 libxft2 libxinerama1 libgomp1";

/// One thing that was looked at.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Finding {
    /// What was looked at.
    pub what: String,
    /// What was found.
    pub found: String,
    /// The command or deed that mends it; none where all is well.
    pub remedy: Option<String>,
}

impl Finding {
    fn well(what: &str, found: String) -> Self {
        Self {
            what: what.into(),
            found,
            remedy: None,
        }
    }
    fn ill(what: &str, found: String, remedy: &str) -> Self {
        Self {
            what: what.into(),
            found,
            remedy: Some(remedy.into()),
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
    findings.push(examine_temporary_folder());
    let cores = std::thread::available_parallelism().map_or(1, usize::from);
    findings.push(Finding::well("cores", cores.to_string()));
    findings
}

fn examine_gmsh(named: Option<&Path>) -> Vec<Finding> {
    let what = "gmsh";
    let path_variable = std::env::var_os("PATH").unwrap_or_default();
    let variable = std::env::var_os(GMSH_VARIABLE).map(PathBuf::from);
    let Some((command, why)) = locate(named, variable.as_deref(), &path_variable) else {
        let found = format!("no gmsh on the PATH, and {GMSH_VARIABLE} is not set");
        return vec![Finding::ill(what, found, INSTALL_GMSH)];
    };
    let place = Finding::well(what, format!("{} ({why})", command.display()));
    let version = match ask_version(&command) {
        Ok(text) => match parse_version(&text) {
            Some(version) if version >= OLDEST_GMSH => Finding::well("gmsh version", text),
            Some(_) => {
                let (major, minor) = OLDEST_GMSH;
                let found = format!("{text}, but {major}.{minor} or later is needed");
                Finding::ill("gmsh version", found, INSTALL_GMSH)
            }
            None => {
                let found = format!("it answers '{text}', which is no version");
                Finding::ill("gmsh version", found, INSTALL_GMSH)
            }
        },
        Err(complaint) => {
            let remedy = remedy_for(&complaint);
            Finding::ill("gmsh version", complaint, &remedy)
        }
    };
    vec![place, version]
}

/// The gmsh command and the reason for choosing it: named by the user, then the variable, then the first on the PATH.
pub fn locate(
    named: Option<&Path>,
    variable: Option<&Path>,
    path_variable: &std::ffi::OsStr,
) -> Option<(PathBuf, &'static str)> {
    if let Some(command) = named {
        return Some((command.to_owned(), "named on the command line"));
    }
    if let Some(command) = variable.filter(|v| !v.as_os_str().is_empty()) {
        return Some((command.to_owned(), GMSH_VARIABLE));
    }
    std::env::split_paths(path_variable)
        .filter(|folder| !folder.as_os_str().is_empty())
        .map(|folder| folder.join("gmsh"))
        .find(|candidate| candidate.is_file())
        .map(|command| (command, "on the PATH"))
}

/// What `gmsh --version` says (it says so on stderr), or what went wrong.
fn ask_version(command: &Path) -> Result<String, String> {
    let mut child = Command::new(command)
        .arg("--version")
        .stdin(Stdio::null())
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .map_err(|e| format!("cannot be started: {e}"))?;
    let start = Instant::now();
    // The version is a line: it fits in the pipes, so nobody has to read while we wait.
    loop {
        match child.try_wait() {
            Ok(Some(_)) => break,
            Ok(None) if start.elapsed() < VERSION_LIMIT => {
                std::thread::sleep(Duration::from_millis(10));
            }
            Ok(None) => {
                let _ = child.kill();
                let _ = child.wait();
                return Err(format!("no answer in {} s", VERSION_LIMIT.as_secs()));
            }
            Err(e) => return Err(format!("cannot be waited for: {e}")),
        }
    }
    let output = child
        .wait_with_output()
        .map_err(|e| format!("cannot be read: {e}"))?;
    let text = |bytes: &[u8]| String::from_utf8_lossy(bytes).trim().to_owned();
    let (out, err) = (text(&output.stdout), text(&output.stderr));
    let last = |t: &str| t.lines().last().unwrap_or_default().trim().to_owned();
    if output.status.success() {
        Ok(last(if out.is_empty() { &err } else { &out }))
    } else {
        let said = last(if err.is_empty() { &out } else { &err });
        Err(format!("it ended with {}: {said}", output.status))
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

/// The deed that mends a gmsh that does not start.
fn remedy_for(complaint: &str) -> String {
    if complaint.contains(".so") {
        INSTALL_LIBRARIES.into()
    } else if complaint.contains("No module named") {
        "the gmsh script runs with a python that lacks the gmsh module: activate its environment (. .venv/bin/activate)".into()
    } else if complaint.contains("env:") || complaint.contains("python") {
        "the gmsh script finds no python: activate its environment (. .venv/bin/activate)".into()
    } else {
        INSTALL_GMSH.into()
    }
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
    use std::ffi::OsStr;

    #[test]
    fn the_named_gmsh_goes_before_the_variable_and_that_before_the_path() {
        let folder = tempfile::tempdir().unwrap();
        std::fs::write(folder.path().join("gmsh"), "").unwrap();
        let path = folder.path().as_os_str();
        let (a, b) = (Path::new("/a/gmsh"), Path::new("/b/gmsh"));
        assert_eq!(locate(Some(a), Some(b), path).unwrap().0, a);
        assert_eq!(locate(None, Some(b), path).unwrap().0, b);
        let found = locate(None, Some(Path::new("")), path).unwrap();
        assert_eq!(found, (folder.path().join("gmsh"), "on the PATH"));
        assert_eq!(locate(None, None, OsStr::new("")), None);
    }

    #[test]
    fn a_missing_gmsh_is_found_out_and_mended() {
        let findings = examine(Some(Path::new("/nonexistent/gmsh")));
        let ill: Vec<&Finding> = findings.iter().filter(|f| f.remedy.is_some()).collect();
        assert_eq!(ill.len(), 1, "{findings:?}");
        assert!(ill[0].found.contains("cannot be started"));
        assert!(ill[0].remedy.as_ref().unwrap().contains("pip install gmsh"));
    }

    #[test]
    fn versions_are_compared_as_numbers() {
        assert_eq!(parse_version("4.15.2-git"), Some((4, 15)));
        assert!(parse_version("4.8.4").unwrap() < OLDEST_GMSH);
        assert!(parse_version("4.15.2").unwrap() > OLDEST_GMSH);
        assert_eq!(parse_version("hello"), None);
    }

    #[test]
    fn each_complaint_has_its_own_remedy() {
        let library = "OSError: libGLU.so.1: cannot open shared object file";
        assert!(remedy_for(library).contains("libglu1-mesa"));
        assert!(remedy_for("ModuleNotFoundError: No module named 'gmsh'").contains("activate"));
        assert!(remedy_for("env: 'python': No such file or directory").contains("activate"));
        assert!(remedy_for("it ended with signal 9").contains("pip install gmsh"));
    }
}
