//! The two streams: results on stdout, everything else on stderr.

use indicatif::{ProgressBar, ProgressStyle};
use midshell::exit_class::ExitClass;
use midshell::pipeline::Progress;
use std::io::{self, IsTerminal, Write};
use std::path::Path;
use std::sync::Mutex;
use std::time::{Duration, Instant};

use super::complaint::Complaint;

/// Puts a result on stdout. A reader that has gone (`| head`) is no failure of ours.
pub fn result(text: &str) -> Result<(), Complaint> {
    let mut out = io::stdout().lock();
    match out.write_all(text.as_bytes()).and_then(|()| out.flush()) {
        Err(e) if e.kind() != io::ErrorKind::BrokenPipe => Err(Complaint {
            class: ExitClass::OutputFailed,
            what: "cannot write to standard output".into(),
            cause: e.to_string(),
            remedy: "see where standard output goes".into(),
        }),
        _ => Ok(()),
    }
}

/// Puts a message for people on stderr. Nothing can be done where even that fails.
pub fn message(text: &str) {
    let mut err = io::stderr().lock();
    let _ = err.write_all(text.as_bytes());
    let _ = err.flush();
}

/// How much is said while a run goes on.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Talk {
    /// Nothing.
    None,
    /// A spinner where stderr is a terminal.
    Spinner,
    /// A line a stage.
    Lines,
}

/// Shows which stage runs.
pub struct Reporter {
    talk: Talk,
    bar: ProgressBar,
    start: Instant,
    current: Mutex<Option<(String, Instant)>>,
}

impl Reporter {
    /// A reporter for a run over `input`.
    pub fn new(input: &Path, quiet: bool, verbose: bool) -> Self {
        let talk = match (quiet, verbose) {
            (true, _) => Talk::None,
            (_, true) => Talk::Lines,
            _ if io::stderr().is_terminal() => Talk::Spinner,
            _ => Talk::None,
        };
        let bar = if talk == Talk::Spinner {
            let bar = ProgressBar::new_spinner();
            if let Ok(style) = ProgressStyle::with_template("{spinner} {prefix}: {msg} ({elapsed})")
            {
                bar.set_style(style);
            }
            let name = input.file_name().unwrap_or(input.as_os_str());
            bar.set_prefix(name.to_string_lossy().into_owned());
            bar.enable_steady_tick(Duration::from_millis(120));
            bar
        } else {
            ProgressBar::hidden()
        };
        Self {
            talk,
            bar,
            start: Instant::now(),
            current: Mutex::new(None),
        }
    }

    /// Ends the display, so that what is printed next stands alone.
    pub fn finish(&self) {
        self.bar.finish_and_clear();
        self.close_line(None);
    }

    /// Prints the line of the stage that has ended and notes the one that begins.
    fn close_line(&self, next: Option<&str>) {
        let now = Instant::now();
        // A poisoned lock means that a stage panicked; its name is still good to show.
        let mut current = self.current.lock().unwrap_or_else(|e| e.into_inner());
        if let (Talk::Lines, Some((name, since))) = (self.talk, current.as_ref()) {
            let (took, at) = (now - *since, now - self.start);
            message(&format!(
                "{:>8.2} s  {name} ({:.2} s)\n",
                at.as_secs_f64(),
                took.as_secs_f64()
            ));
        }
        *current = next.map(|name| (name.to_owned(), now));
    }
}

impl Progress for Reporter {
    fn stage(&self, name: &str) {
        self.bar.set_message(name.to_owned());
        self.close_line(Some(name));
    }
}
