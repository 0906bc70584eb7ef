//! The foreign programs that the tests run, and what to say when one is missing.

use super::seen::Seen;
use std::path::{Path, PathBuf};
use std::process::Command;

fn root() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

/// The Python that has the readers: `MIDSHELL_PYTHON`, or that of `.venv`.
fn python() -> PathBuf {
    let python = match std::env::var_os("MIDSHELL_PYTHON") {
        Some(named) => PathBuf::from(named),
        None => root().join(".venv/bin/python3"),
    };
    assert!(
        python.exists(),
        "no Python at {}: `make test` sets one up, or set MIDSHELL_PYTHON to one with the packages of tests/python/requirements.txt",
        python.display()
    );
    python
}

/// What `reader` of tests/python/read_back.py sees in each file.
pub fn read_back(reader: &str, files: &[PathBuf]) -> Vec<Seen> {
    let output = Command::new(python())
        .arg(root().join("tests/python/read_back.py"))
        .arg(reader)
        .args(files)
        .output()
        .expect("Python starts");
    let text = String::from_utf8_lossy(&output.stdout);
    assert!(
        output.status.success(),
        "{reader} failed:\n{text}\n{}",
        String::from_utf8_lossy(&output.stderr)
    );
    let last = text.trim_end().lines().last().unwrap_or_default();
    serde_json::from_str(last).unwrap_or_else(|e| panic!("{reader} answered {text}: {e}"))
}

/// Whether CalculiX is there. It may only be missing where `MIDSHELL_SKIP_CCX` says so.
pub fn has_calculix() -> bool {
    if Command::new("ccx").arg("-v").output().is_ok() {
        return true;
    }
    assert!(
        std::env::var_os("MIDSHELL_SKIP_CCX").is_some(),
        "CalculiX (`ccx`) is missing: install the Debian package calculix-ccx, or set MIDSHELL_SKIP_CCX to go without"
    );
    eprintln!("skipped: CalculiX is missing and MIDSHELL_SKIP_CCX is set");
    false
}

/// Runs a deck; returns the `.dat` file's text. Any error or warning of CalculiX fails the test.
pub fn calculix(deck: &[u8]) -> String {
    let folder = tempfile::tempdir().expect("a temporary folder");
    std::fs::write(folder.path().join("deck.inp"), deck).expect("the deck is written");
    let output = Command::new("ccx")
        .arg("deck")
        .current_dir(folder.path())
        .env("OMP_NUM_THREADS", "1")
        .output()
        .expect("ccx starts");
    let text = String::from_utf8_lossy(&output.stdout);
    let complaint = text.contains("*ERROR") || text.contains("*WARNING");
    assert!(output.status.success() && !complaint, "CalculiX:\n{text}");
    std::fs::read_to_string(folder.path().join("deck.dat")).expect("CalculiX leaves results")
}

/// The rows of numbers of a `.dat` table whose title has `words` in it.
pub fn table(dat: &str, words: &str) -> Vec<Vec<f64>> {
    let mut rows = Vec::new();
    let mut inside = false;
    for line in dat.lines().filter(|line| !line.trim().is_empty()) {
        let row: Result<Vec<f64>, _> = line.split_whitespace().map(str::parse).collect();
        match row {
            Ok(row) if inside => rows.push(row),
            Ok(_) => {}
            Err(_) => inside = line.contains(words),
        }
    }
    rows
}
