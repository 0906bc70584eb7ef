//! Finding the `gmsh` command and running it once.
//!
//! Two kinds of command are known: a native program, and the Python script that the `gmsh` wheel installs. The script imports the wheel's
//! module, which loads a shared library; started as it stands it needs the right Python on `PATH` and spends most of its start on
//! NumPy. It is therefore replaced by a short programme for the Python beside it, without NumPy (0.06 s in place of 0.27 s).
//!
//! Guarantees: the user's own gmsh options are not read.

use std::env;
use std::fs::File;
use std::io::Read;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::time::Duration;

use super::error::ImportError;
use super::process::{self, Ended, Limits, Run};
use super::spent::BACKSTOP;

/// Starts the wheel's library without NumPy and without the user's options; on Linux it ends with its parent.
const BOOTSTRAP: &str = "\
import ctypes, sys
try:
    ctypes.CDLL(None).prctl(1, 9)
except Exception:
    pass
sys.modules['numpy'] = None
import gmsh
gmsh.initialize(['gmsh'] + sys.argv[1:], readConfigFiles=False, run=True)
gmsh.finalize()
";

/// Of processor time; by the clock it is long enough for a cold disk, and a gmsh that needs longer to say its version hangs.
const VERSION_LIMIT: Duration = Duration::from_secs(8);

/// A gmsh that starts.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Gmsh {
    /// The command, as it was found.
    pub path: PathBuf,
    /// What it says of itself, such as `4.15.2`.
    pub version: String,
}

impl Gmsh {
    /// The command that starts it, whichever kind it is; arguments of gmsh are to be added.
    pub fn command(&self) -> Command {
        let launcher = Launcher::of(self.path.clone());
        let mut command = Command::new(launcher.program());
        command.args(launcher.first_arguments());
        command
    }
}

/// Finds a gmsh that starts: the explicit path, the variable `MIDSHELL_GMSH`, `.venv/bin/gmsh` in the current folder or one above it,
/// or `gmsh` on `PATH`; the first that exists, in this order. A path that is named and does not exist is an error, never passed over.
pub fn find_gmsh(explicit: Option<&Path>) -> Result<Gmsh, ImportError> {
    let launcher = Launcher::find(explicit)?;
    let folder = tempfile::tempdir().map_err(|cause| ImportError::NoFolder {
        path: env::temp_dir(),
        cause,
    })?;
    let unusable = |lines| ImportError::GmshUnusable {
        gmsh: launcher.path.clone(),
        lines,
    };
    let run = launcher
        .run(
            folder.path(),
            &["--version"],
            Limits {
                time: VERSION_LIMIT,
                memory: None,
            },
        )
        .map_err(|cause| unusable(vec![cause.to_string()]))?;
    let version = run.log.lines().map(str::trim).rfind(|l| is_version(l));
    match (run.ended, version) {
        (Ended::Exit(status), Some(version)) if status.success() => Ok(Gmsh {
            path: launcher.path.clone(),
            version: version.to_owned(),
        }),
        (Ended::TimedOut, _) => Err(unusable(vec![format!(
            "no answer within {} s",
            (VERSION_LIMIT * BACKSTOP).as_secs()
        )])),
        _ => Err(unusable(run.last_words())),
    }
}

fn is_version(text: &str) -> bool {
    text.starts_with(|c: char| c.is_ascii_digit()) && text.contains('.')
}

/// How to install what is missing.
pub const INSTALL: &str = "python3 -m venv .venv && .venv/bin/pip install gmsh==4.15.2";

/// How a found command is started.
#[derive(Clone, Debug)]
pub(super) struct Launcher {
    pub(super) path: PathBuf,
    python: Option<PathBuf>,
}

impl Launcher {
    pub(super) fn find(explicit: Option<&Path>) -> Result<Self, ImportError> {
        let mut looked_at = Vec::new();
        let named = explicit
            .map(Path::to_path_buf)
            .or_else(|| env::var_os("MIDSHELL_GMSH").map(PathBuf::from));
        if let Some(path) = named {
            looked_at.push(path.display().to_string());
            if path.is_file() {
                return Ok(Self::of(absolute(&path)));
            }
            return Err(ImportError::GmshMissing { looked_at });
        }
        let here = env::current_dir().unwrap_or_default();
        let beside = here.ancestors().map(|f| f.join(".venv/bin/gmsh"));
        if let Some(path) = beside.into_iter().find(|p| p.is_file()) {
            return Ok(Self::of(path));
        }
        looked_at.push(format!("{} and above", here.join(".venv/bin").display()));
        if let Some(path) = on_path("gmsh") {
            return Ok(Self::of(path));
        }
        looked_at.push("PATH".to_owned());
        Err(ImportError::GmshMissing { looked_at })
    }

    fn of(path: PathBuf) -> Self {
        let python = wheel_python(&path);
        Self { path, python }
    }

    fn program(&self) -> &Path {
        self.python.as_ref().unwrap_or(&self.path)
    }

    fn first_arguments(&self) -> &'static [&'static str] {
        if self.python.is_some() {
            &["-c", BOOTSTRAP]
        } else {
            &[]
        }
    }

    /// Runs gmsh in `folder`; what it writes goes through `folder/gmsh.log`.
    pub(super) fn run(
        &self,
        folder: &Path,
        arguments: &[&str],
        limits: Limits,
    ) -> std::io::Result<Run> {
        let all = [self.first_arguments(), arguments].concat();
        let environment = [("GMSH_HOME", folder)];
        process::run(
            self.program(),
            &all,
            &environment,
            folder,
            "gmsh.log",
            limits,
        )
    }
}

pub(super) fn absolute(path: &Path) -> PathBuf {
    std::path::absolute(path).unwrap_or_else(|_| path.to_path_buf())
}

/// The first file of this name in the folders of `PATH`, as an absolute path: what is found is started from another folder.
pub(super) fn on_path(name: &str) -> Option<PathBuf> {
    let path = env::var_os("PATH")?;
    env::split_paths(&path)
        .map(|folder| absolute(&folder.join(name)))
        .find(|p| p.is_file())
}

/// The Python that runs the command, where the command is the wheel's script.
fn wheel_python(command: &Path) -> Option<PathBuf> {
    // The script is some hundred bytes; a program is not read whole to find that out.
    let mut head = Vec::new();
    File::open(command)
        .ok()?
        .take(4096)
        .read_to_end(&mut head)
        .ok()?;
    let head = String::from_utf8(head).ok()?;
    let shebang = head.strip_prefix("#!")?.lines().next()?.trim();
    if !shebang.contains("python") || !head.contains("import gmsh") {
        return None;
    }
    // A wheel's script may ask for any `python`, which on PATH is seldom the one that has the module.
    let beside = [Some(command.to_path_buf()), command.canonicalize().ok()];
    let beside = beside.into_iter().flatten().flat_map(|c| {
        ["python3", "python"].map(|name| c.parent().unwrap_or(Path::new("")).join(name))
    });
    let from_shebang = Path::new(shebang.split_whitespace().next()?);
    if !from_shebang.ends_with("env") && from_shebang.is_file() {
        return Some(from_shebang.to_path_buf());
    }
    beside
        .into_iter()
        .find(|p| p.is_file())
        .or_else(|| on_path("python3"))
        .or_else(|| on_path("python"))
}

/// The version that a run's log names, as in `[Gmsh 4.15.2, 1 node, max. 1 thread]`.
pub(super) fn version_in(log: &str) -> Option<String> {
    let rest = log.split_once("[Gmsh ")?.1;
    let version = rest.split([',', ']']).next()?;
    is_version(version).then(|| version.to_owned())
}

/// The last lines of a log that speak of an error; where none does, its last lines.
pub(super) fn error_lines(log: &str) -> Vec<String> {
    const MOST: usize = 4;
    const MARKS: [&str; 9] = [
        "Error",
        "PLC",
        "intersect",
        "Found two",
        "Fatal",
        "fault",
        "corruption",
        "alloc",
        "shared",
    ];
    // What gmsh says around its errors: the traceback of its Python module, and a summary that only counts them.
    let tells_nothing = |line: &str| {
        let text = line
            .trim_start_matches("Error")
            .trim_start_matches([' ', ':']);
        let counts = ["warning", "warnings", "error", "errors"];
        let mut words = text.split_whitespace();
        line.contains("logger.getLastError")
            || text.starts_with("----")
            || text.contains("full log for details")
            || text.ends_with("error summary")
            || (words.next().is_some_and(|w| w.parse::<u32>().is_ok())
                && words.next().is_some_and(|w| counts.contains(&w)))
    };
    let lines: Vec<&str> = log
        .lines()
        .map(str::trim)
        .filter(|l| !l.is_empty() && !tells_nothing(l))
        .collect();
    let mut chosen: Vec<&str> = lines
        .iter()
        .copied()
        .filter(|l| !l.starts_with("Info") && MARKS.iter().any(|m| l.contains(m)))
        .collect();
    if chosen.is_empty() {
        chosen = lines;
    }
    chosen.dedup();
    let first = chosen.len().saturating_sub(MOST);
    chosen[first..]
        .iter()
        .map(|l| l.chars().take(200).collect())
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::time::Instant;

    #[test]
    fn the_version_is_read_from_the_first_line_of_a_log() {
        let log = "Info    : Running 'gmsh a.geo -' [Gmsh 4.15.2, 1 node, max. 1 thread]\nInfo";
        assert_eq!(version_in(log).unwrap(), "4.15.2");
        assert_eq!(version_in("nothing"), None);
    }

    #[test]
    fn error_lines_prefer_errors_and_fall_back_to_the_end() {
        let log =
            "Info: a\nError   : HXT 3D mesh failed\nPLC Error:  A segment\nInfo: b\nInfo: c\n";
        assert_eq!(
            error_lines(log),
            ["Error   : HXT 3D mesh failed", "PLC Error:  A segment"]
        );
        let summary = "Error   : PLC\nError   : Mesh generation error summary\nError   : -----\nError   :     1 error\nError   : Check the full log for details\n";
        assert_eq!(error_lines(summary), ["Error   : PLC"]);
        assert_eq!(
            error_lines("1\n2\n3\n4\n5\n6\n").len(),
            4,
            "only the last lines"
        );
    }

    #[test]
    fn a_named_gmsh_that_is_missing_is_an_error() {
        let error = find_gmsh(Some(Path::new("/no/such/gmsh"))).unwrap_err();
        assert!(matches!(error, ImportError::GmshMissing { .. }));
        assert!(error.to_string().contains("/no/such/gmsh"));
    }

    #[cfg(unix)]
    fn fake(folder: &Path, script: &str) -> PathBuf {
        use std::os::unix::fs::PermissionsExt;
        let path = folder.join("gmsh");
        std::fs::write(&path, script).unwrap();
        std::fs::set_permissions(&path, std::fs::Permissions::from_mode(0o755)).unwrap();
        path
    }

    #[cfg(unix)]
    #[test]
    fn a_gmsh_that_hangs_is_killed_with_its_children() {
        let folder = tempfile::tempdir().unwrap();
        let path = fake(
            folder.path(),
            "#!/bin/sh\nsleep 300 &\necho child $!\nwait\n",
        );
        let start = Instant::now();
        let run = Launcher::of(path)
            .run(
                folder.path(),
                &[],
                Limits {
                    time: Duration::from_millis(300),
                    memory: None,
                },
            )
            .unwrap();
        assert!(matches!(run.ended, Ended::TimedOut));
        let child: u32 = run
            .log
            .trim()
            .strip_prefix("child ")
            .unwrap()
            .parse()
            .unwrap();
        // A killed process may stay for a moment until init reaps it.
        let gone = || {
            let stat = std::fs::read_to_string(format!("/proc/{child}/stat")).unwrap_or_default();
            stat.is_empty() || stat.contains(") Z ")
        };
        while !gone() {
            assert!(start.elapsed() < Duration::from_secs(20), "it lives on");
            std::thread::sleep(Duration::from_millis(10));
        }
    }

    #[cfg(unix)]
    #[test]
    fn a_gmsh_that_is_killed_says_by_which_signal() {
        let folder = tempfile::tempdir().unwrap();
        let path = fake(folder.path(), "#!/bin/sh\nkill -9 $$\n");
        let error = find_gmsh(Some(&path)).unwrap_err();
        assert!(error.to_string().contains("signal: 9"), "{error}");
    }

    #[cfg(unix)]
    #[test]
    fn a_gmsh_that_does_not_start_is_told_from_one_that_is_missing() {
        let folder = tempfile::tempdir().unwrap();
        let path = fake(
            folder.path(),
            "#!/bin/sh\necho 'error while loading shared libraries: libGLU.so.1'\nexit 127\n",
        );
        let error = find_gmsh(Some(&path)).unwrap_err();
        assert!(
            matches!(error, ImportError::GmshUnusable { .. }),
            "{error:?}"
        );
        assert!(error.remedy().contains("apt-get"), "{}", error.remedy());
    }
}
