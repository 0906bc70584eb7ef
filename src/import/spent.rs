//! How much of a limit of time a process has used up, and how much all processes of one import together.
//!
//! What counts is processor time: by the clock, a machine that is busy with other things would refuse parts that it fills when it is not. A process that
//! waits for ever uses none, so the clock counts as well, for a part.
//!
//! Limits: only Linux tells the processor time of another process (`/proc`); elsewhere the clock counts in full. What a process spent between the
//! last look and its end is not seen; that is a fiftieth of a second.

use std::cell::Cell;
use std::time::{Duration, Instant};

/// By the clock a process may take this many times its limit of processor time: on a machine with four times as many processes as cores it still has its share.
pub(super) const BACKSTOP: u32 = 4;

/// Looks at one process and all that it started.
pub(super) struct Meter {
    process: u32,
    start: Instant,
    processor: Option<Duration>,
}

impl Meter {
    /// Begins now.
    pub(super) fn of(process: u32) -> Self {
        Self {
            process,
            start: Instant::now(),
            processor: None,
        }
    }

    /// What the process has spent up to now.
    pub(super) fn read(&mut self) -> Duration {
        // Where a grandchild ended unseen the sum shrinks: what was spent stays spent.
        self.processor = processor_time(self.process).max(self.processor);
        self.spent()
    }

    /// What it had spent at the last look, and the clock since.
    pub(super) fn spent(&self) -> Duration {
        counted(self.processor, self.start.elapsed())
    }
}

fn counted(processor: Option<Duration>, clock: Duration) -> Duration {
    processor.map_or(clock, |p| p.max(clock / BACKSTOP))
}

/// Processor time of a process, of what it waited for and of what it started and still runs; none where the system does not tell.
fn processor_time(process: u32) -> Option<Duration> {
    let folder = format!("/proc/{process}");
    let own = in_stat(&std::fs::read_to_string(format!("{folder}/stat")).ok()?)?;
    let tasks = std::fs::read_dir(format!("{folder}/task")).ok();
    let children = tasks
        .into_iter()
        .flatten()
        .flatten()
        .filter_map(|task| std::fs::read_to_string(task.path().join("children")).ok());
    let children: Duration = children
        .flat_map(|line| {
            let ids = line.split_whitespace().filter_map(|id| id.parse().ok());
            ids.filter_map(processor_time).collect::<Vec<_>>()
        })
        .sum();
    Some(own + children)
}

/// The four times of `/proc/PID/stat`: in user and system mode, its own and of the children that it waited for.
fn in_stat(stat: &str) -> Option<Duration> {
    /// Linux tells these times in hundredths of a second, whatever its clock is.
    const TICKS: u64 = 100;
    // The name stands in brackets and may hold anything. The times are fields 14 to 17, the first behind the name is field 3.
    let (_, behind) = stat.rsplit_once(')')?;
    let mut fields = behind.split_whitespace().skip(11);
    let mut ticks = 0_u64;
    for _ in 0..4 {
        // Times of children are signed there, though never negative.
        ticks = ticks.checked_add(fields.next()?.parse().ok()?)?;
    }
    Some(Duration::from_millis(ticks * (1000 / TICKS)))
}

/// The time of one import, which all its processes share.
pub(super) struct Budget {
    limit: Duration,
    spent: Cell<Duration>,
}

impl Budget {
    pub(super) fn new(limit: Duration) -> Self {
        Self {
            limit,
            spent: Cell::new(Duration::ZERO),
        }
    }

    /// Takes off what a process spent.
    pub(super) fn charge(&self, spent: Duration) {
        self.spent.set(self.spent.get() + spent);
    }

    /// What is left of all.
    pub(super) fn left(&self) -> Duration {
        self.left_of(1.0)
    }

    /// What is left of this share of all.
    pub(super) fn left_of(&self, share: f64) -> Duration {
        self.limit.mul_f64(share).saturating_sub(self.spent.get())
    }
}

#[cfg(test)]
#[path = "spent_tests.rs"]
mod tests;
