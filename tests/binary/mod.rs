//! Runs the built program in a folder of its own, and makes the parts that it runs on.

// Each test program uses its own half of this file.
#![allow(dead_code)]

use std::path::{Path, PathBuf};
use std::process::Command;
use std::time::{Duration, Instant};

/// A plate of 100 x 60 x 2 mm, as a gmsh script.
pub const PLATE: &str = "Box(1) = {0, 0, 0, 100, 60, 2};";
/// The plate's diagonal, mm, to four digits.
pub const PLATE_DIAGONAL: &str = "116.6";

/// A folder with a part, and what a run leaves beside it.
pub struct Bench {
    folder: tempfile::TempDir,
    temporary: tempfile::TempDir,
}

/// How a run ended.
pub struct Ended {
    pub status: Option<i32>,
    pub stdout: String,
    pub stderr: String,
    pub took: Duration,
    /// Files in the folder that were not there before.
    pub left: Vec<String>,
    /// What is left in the folder for temporary files.
    pub litter: Vec<String>,
}

/// The gmsh that the tests run.
pub fn gmsh() -> PathBuf {
    std::env::var_os("MIDSHELL_GMSH").map_or_else(|| "gmsh".into(), PathBuf::from)
}

impl Bench {
    pub fn new() -> Self {
        Self {
            folder: tempfile::tempdir().unwrap(),
            temporary: tempfile::tempdir().unwrap(),
        }
    }

    pub fn at(&self, name: &str) -> PathBuf {
        self.folder.path().join(name)
    }

    /// Writes a file into the folder.
    pub fn file(&self, name: &str, content: impl AsRef<[u8]>) -> PathBuf {
        let path = self.at(name);
        std::fs::write(&path, content).unwrap();
        path
    }

    /// Writes a program into the folder. Another process writes it: a descriptor of ours could live on in the child of a test that runs beside this
    /// one, and a file open for writing cannot be run.
    pub fn program(&self, name: &str, script: &str) -> PathBuf {
        let path = self.at(name);
        let status = Command::new("sh")
            .args([
                "-c",
                "printf '#!/bin/sh\\n%s\\n' \"$1\" >\"$0\" && chmod +x \"$0\"",
            ])
            .arg(&path)
            .arg(script)
            .status()
            .unwrap();
        assert!(status.success());
        path
    }

    /// Makes a STEP file from a gmsh script.
    pub fn step(&self, name: &str, script: &str) -> PathBuf {
        let path = self.at(name);
        let work = tempfile::tempdir().unwrap();
        let geo = work.path().join("part.geo");
        let save = format!(
            "SetFactory(\"OpenCASCADE\");\n{script}\nSave \"{}\";\n",
            path.display()
        );
        std::fs::write(&geo, save).unwrap();
        let output = Command::new(gmsh())
            .arg(&geo)
            .arg("-")
            .output()
            .unwrap_or_else(|e| panic!("these tests need gmsh (make test sets it up): {e}"));
        assert!(
            path.metadata().is_ok_and(|m| m.len() > 0),
            "gmsh made no part: {}{}",
            String::from_utf8_lossy(&output.stdout),
            String::from_utf8_lossy(&output.stderr)
        );
        path
    }

    /// The program, ready to be given arguments. It works in the folder and sees the gmsh of the tests only through the environment.
    pub fn midshell(&self) -> Command {
        self.ready(Command::new(env!("CARGO_BIN_EXE_midshell")))
    }

    /// A command in the folder, with a folder of its own for temporary files.
    pub fn ready(&self, mut command: Command) -> Command {
        command
            .current_dir(self.folder.path())
            .env("TMPDIR", self.temporary.path())
            .stdin(std::process::Stdio::null());
        command
    }

    pub fn run(&self, mut command: Command) -> Ended {
        let before = names(self.folder.path());
        let start = Instant::now();
        let output = command.output().unwrap();
        let took = start.elapsed();
        let mut left = names(self.folder.path());
        left.retain(|name| !before.contains(name));
        Ended {
            status: output.status.code(),
            stdout: String::from_utf8(output.stdout).unwrap(),
            stderr: String::from_utf8(output.stderr).unwrap(),
            took,
            left,
            litter: names(self.temporary.path()),
        }
    }

    /// Runs `midshell mesh INPUT -o out.vtu` with more arguments.
    pub fn mesh(&self, input: &Path, more: &[&str]) -> Ended {
        let mut command = self.midshell();
        command
            .arg("mesh")
            .arg(input)
            .args(["-o", "out.vtu"])
            .args(more);
        self.run(command)
    }
}

fn names(folder: &Path) -> Vec<String> {
    let mut names: Vec<String> = std::fs::read_dir(folder)
        .unwrap()
        .map(|e| e.unwrap().file_name().to_string_lossy().into_owned())
        .collect();
    names.sort();
    names
}

impl Ended {
    fn told(&self) -> String {
        format!(
            "status {:?} after {:?}\n--- stdout\n{}\n--- stderr\n{}\n--- left {:?}, litter {:?}",
            self.status, self.took, self.stdout, self.stderr, self.left, self.litter
        )
    }

    /// The run was refused with this status; the message holds every word, a cause and a remedy; nothing is left behind.
    #[track_caller]
    pub fn refused(&self, status: i32, words: &[&str]) {
        let told = self.told();
        assert_eq!(self.status, Some(status), "{told}");
        assert!(self.stderr.starts_with("error: "), "{told}");
        for label in ["\n  cause: ", "\n  remedy: "] {
            let after = self.stderr.split(label).nth(1).unwrap_or_default();
            assert!(after.trim().len() > 10, "{label:?} says nothing\n{told}");
        }
        for word in words {
            assert!(self.stderr.contains(word), "'{word}' is not named\n{told}");
        }
        assert!(!self.stderr.contains("panicked"), "{told}");
        assert_eq!(self.stdout, "", "{told}");
        assert!(self.left.is_empty() && self.litter.is_empty(), "{told}");
    }

    /// The run ended well and left these files.
    #[track_caller]
    pub fn went_well(&self, files: &[&str]) {
        let told = self.told();
        assert_eq!(self.status, Some(0), "{told}");
        assert_eq!(self.stderr, "", "{told}");
        assert_eq!(self.left, files, "{told}");
        assert!(self.litter.is_empty(), "{told}");
    }
}
