//! Gmsh and Python: where they are, and running them (or the binary) with a time limit.

use std::io::Read;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::sync::OnceLock;
use std::time::{Duration, Instant};

/// The root of the repository.
pub fn root() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

/// `target/fixtures`: solids made once and kept.
pub fn cache() -> PathBuf {
    let tmp = Path::new(env!("CARGO_TARGET_TMPDIR"));
    let folder = tmp.parent().unwrap_or(tmp).join("fixtures");
    std::fs::create_dir_all(&folder).expect("target/fixtures can be made");
    folder
}

/// The Gmsh command: `MIDSHELL_GMSH`, else `.venv/bin/gmsh` of the repository, else on the PATH.
pub fn gmsh() -> &'static Path {
    static FOUND: OnceLock<PathBuf> = OnceLock::new();
    FOUND.get_or_init(|| {
        let named = std::env::var_os("MIDSHELL_GMSH").map(PathBuf::from);
        let ours = root().join(".venv/bin/gmsh");
        let path = std::env::var_os("PATH").unwrap_or_default();
        named
            .into_iter()
            .chain([ours])
            .chain(std::env::split_paths(&path).map(|p| p.join("gmsh")))
            .find(|p| p.is_file())
            .unwrap_or_else(|| {
                panic!(
                    "no gmsh found (MIDSHELL_GMSH, .venv/bin/gmsh, PATH): `make test` sets it up"
                )
            })
    })
}

/// A command with the found Gmsh first on its PATH: the script of the Gmsh wheel asks `env` for the `python` beside it.
pub fn with_gmsh(program: impl AsRef<std::ffi::OsStr>) -> Command {
    let path = std::env::var_os("PATH").unwrap_or_default();
    let beside = gmsh().parent().map(Path::to_path_buf);
    let joined =
        std::env::join_paths(beside.into_iter().chain(std::env::split_paths(&path))).expect("PATH");
    let mut command = Command::new(program);
    command.env("PATH", joined).env("MIDSHELL_GMSH", gmsh());
    command
}

/// One of the scripts of tests/python, run by `MIDSHELL_PYTHON` or by the Python beside Gmsh.
pub fn python(script: &str) -> Command {
    let named = std::env::var_os("MIDSHELL_PYTHON").map(PathBuf::from);
    let beside = gmsh().with_file_name("python3");
    let python = named
        .or(beside.is_file().then_some(beside))
        .unwrap_or_else(|| PathBuf::from("python3"));
    let mut command = with_gmsh(python);
    // Many tests run at once: threads of the linear algebra under numpy would only fight over the cores.
    command
        .env("OMP_NUM_THREADS", "1")
        .env("OPENBLAS_NUM_THREADS", "1")
        .env("PYTHONDONTWRITEBYTECODE", "1");
    command.arg(root().join("tests/python").join(script));
    command
}

/// Runs a command to its end; its standard output. Panics with what it said when it fails or outlasts `limit`.
pub fn run(command: Command, limit: Duration) -> String {
    run_to(command, limit, &[0])
}

/// The same, where it may exit with any status of `fine`.
pub fn run_to(mut command: Command, limit: Duration, fine: &[i32]) -> String {
    let shown = format!("{command:?}");
    let shown = shown
        .split_once("\" \"")
        .map_or(shown.clone(), |(_, rest)| format!("\"{rest}"));
    let mut child = command
        .stdin(Stdio::null())
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap_or_else(|e| {
            panic!("cannot start {shown}: {e}; `make test` sets up what is missing")
        });
    // Both pipes are read while it runs, so that neither can fill up and block it.
    let mut out = child.stdout.take().expect("piped");
    let mut err = child.stderr.take().expect("piped");
    let read_out = std::thread::spawn(move || {
        let mut text = Vec::new();
        let _ = out.read_to_end(&mut text);
        text
    });
    let read_err = std::thread::spawn(move || {
        let mut text = Vec::new();
        let _ = err.read_to_end(&mut text);
        text
    });
    let began = Instant::now();
    let status = loop {
        if let Some(status) = child.try_wait().expect("a child's status") {
            break status;
        }
        if began.elapsed() > limit {
            let _ = child.kill();
            let _ = child.wait();
            panic!("{shown}: still running after {} s", limit.as_secs());
        }
        std::thread::sleep(Duration::from_millis(10));
    };
    let out = String::from_utf8_lossy(&read_out.join().unwrap_or_default()).into_owned();
    let err = String::from_utf8_lossy(&read_err.join().unwrap_or_default()).into_owned();
    let fine = status.code().is_some_and(|code| fine.contains(&code));
    assert!(fine, "{shown}: {status}\n{out}\n{err}");
    out
}
