//! Running one foreign program to its end or to a limit of time, with a limit on its memory.
//!
//! Guarantees: the program is killed, with all that it started, when its time is over. Time is processor time, so that a busy machine does not change
//! the result, or a [`BACKSTOP`](super::spent::BACKSTOP)th of that on the clock where this is more. What it writes goes through a file, so that no pipe fills up.
//! Limits: the memory limit and the killing of what the program itself started need a Unix. Where the system has no `/proc` only a process's own limit
//! knows processor time, and the clock counts in full.

use std::fs::File;
use std::io::Read;
use std::path::Path;
use std::process::{Child, Command, ExitStatus, Stdio};
use std::time::Duration;

use super::gmsh::error_lines;
use super::spent::Meter;

/// What a run may use.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Limits {
    /// Of processor time, of the program and all that it starts; [`BACKSTOP`](super::spent::BACKSTOP) times as long by the clock.
    pub(super) time: Duration,
    /// Address space, bytes (Unix only); unlimited where none is given.
    pub(super) memory: Option<u64>,
}

/// How a run ended.
#[derive(Clone, Copy, Debug)]
pub(super) enum Ended {
    Exit(ExitStatus),
    TimedOut,
}

/// A run that ended: how, and all that it wrote.
#[derive(Debug)]
pub(super) struct Run {
    pub(super) ended: Ended,
    /// The time that counts towards a limit.
    pub(super) spent: Duration,
    pub(super) log: String,
}

impl Run {
    /// What is to be said of a run that failed: its last lines of error, and how it ended where they do not tell.
    pub(super) fn last_words(&self) -> Vec<String> {
        let mut lines = error_lines(&self.log);
        if let Ended::Exit(status) = self.ended
            && (status.code().is_none() || lines.is_empty())
        {
            lines.push(format!("it ended with {status}"));
        }
        lines
    }
}

/// A command for `program` that keeps the limits by itself, even where this process dies without killing its child.
fn limited(program: &Path, limits: Limits) -> Command {
    if !cfg!(unix) {
        return Command::new(program);
    }
    // Two seconds more than the limit, so that the watching process comes first. The softer of both tells its signal from that of a lack of memory.
    let seconds = limits.time.as_secs() + 2;
    let hard = seconds + 5;
    let mut script = format!("ulimit -c 0; ulimit -S -t {seconds}; ulimit -H -t {hard};");
    if let Some(bytes) = limits.memory {
        script += &format!("ulimit -v {};", bytes / 1024);
    }
    let mut shell = Command::new("/bin/sh");
    shell
        .arg("-c")
        .arg(script + "exec \"$@\"")
        .arg("sh")
        .arg(program);
    shell
}

/// Runs a program in `folder`; what it writes goes through `folder/log`.
pub(super) fn run(
    program: &Path,
    arguments: &[&str],
    environment: &[(&str, &Path)],
    folder: &Path,
    log: &str,
    limits: Limits,
) -> std::io::Result<Run> {
    let log_path = folder.join(log);
    let log = File::create(&log_path)?;
    let mut command = limited(program, limits);
    command
        .args(arguments)
        .current_dir(folder)
        .envs(environment.iter().copied())
        .env("PYTHONDONTWRITEBYTECODE", "1")
        .stdin(Stdio::null())
        .stdout(log.try_clone()?)
        .stderr(log);
    #[cfg(unix)]
    std::os::unix::process::CommandExt::process_group(&mut command, 0);
    let mut child = KilledOnDrop(command.spawn()?);
    let (ended, spent) = child.wait(limits.time)?;
    drop(child);
    let mut bytes = Vec::new();
    File::open(&log_path)?.read_to_end(&mut bytes)?;
    Ok(Run {
        ended,
        spent,
        log: String::from_utf8_lossy(&bytes).into_owned(),
    })
}

/// A child that does not outlive this value.
struct KilledOnDrop(Child);

impl KilledOnDrop {
    fn wait(&mut self, limit: Duration) -> std::io::Result<(Ended, Duration)> {
        let mut meter = Meter::of(self.0.id());
        let mut pause = Duration::from_millis(2);
        loop {
            if let Some(status) = self.0.try_wait()? {
                let ended = if over_its_own_limit(status) {
                    Ended::TimedOut
                } else {
                    Ended::Exit(status)
                };
                return Ok((ended, meter.spent()));
            }
            let left = limit.saturating_sub(meter.read());
            if left.is_zero() {
                return Ok((Ended::TimedOut, limit));
            }
            std::thread::sleep(pause.min(left));
            pause = (pause * 2).min(Duration::from_millis(20));
        }
    }
}

/// Whether the system ended it for its processor time: then this process was too slow to see it, or cannot.
fn over_its_own_limit(status: ExitStatus) -> bool {
    /// `SIGXCPU`, which has this number on Linux, the BSDs and macOS.
    #[cfg(unix)]
    const SIGXCPU: i32 = 24;
    #[cfg(unix)]
    return std::os::unix::process::ExitStatusExt::signal(&status) == Some(SIGXCPU);
    #[cfg(not(unix))]
    return false;
}

impl Drop for KilledOnDrop {
    fn drop(&mut self) {
        if matches!(self.0.try_wait(), Ok(Some(_))) {
            return;
        }
        // The group first: a wrapper script's own children would live on otherwise.
        if cfg!(unix) {
            let _ = Command::new("/bin/sh")
                .arg("-c")
                .arg("kill -s KILL -- -\"$1\" 2>/dev/null")
                .arg("sh")
                .arg(self.0.id().to_string())
                .status();
        }
        let _ = self.0.kill();
        let _ = self.0.wait();
    }
}
