//! A look at the system's book-keeping: the most memory that a run held at a time.
//!
//! Limits: Linux alone tells both; elsewhere nothing is said. A process that uses this as a library may have had its peak, or a larger child, before the run.

use serde::Serialize;
use std::fmt;

/// Peaks of resident memory, bytes; none where the system does not tell.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
pub struct PeakMemory {
    /// Of this process.
    pub own_bytes: Option<u64>,
    /// Of the largest process that it waited for: gmsh, or what stood in for it.
    pub child_bytes: Option<u64>,
}

/// The peaks up to now.
pub(super) fn peak() -> PeakMemory {
    PeakMemory {
        own_bytes: std::fs::read_to_string("/proc/self/status")
            .ok()
            .and_then(|status| high_water(&status)),
        child_bytes: children(),
    }
}

/// The line `VmHWM` of `/proc/self/status`, in bytes. (What `getrusage` says of a process itself holds that of its parent before it began.)
fn high_water(status: &str) -> Option<u64> {
    let line = status.lines().find_map(|l| l.strip_prefix("VmHWM:"))?;
    let kib: u64 = line.trim().strip_suffix("kB")?.trim().parse().ok()?;
    Some(1024 * kib)
}

#[cfg(target_os = "linux")]
fn children() -> Option<u64> {
    use nix::sys::resource::{UsageWho, getrusage};
    let usage = getrusage(UsageWho::RUSAGE_CHILDREN).ok()?;
    // In KiB on this system; 0 where there was no child.
    let kib = u64::try_from(usage.max_rss()).ok()?;
    (kib > 0).then_some(1024 * kib)
}

#[cfg(not(target_os = "linux"))]
fn children() -> Option<u64> {
    None
}

impl fmt::Display for PeakMemory {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let text = |bytes: Option<u64>| match bytes {
            Some(bytes) => format!("{:.0} MiB", bytes as f64 / f64::from(1 << 20)),
            None => "unknown".to_owned(),
        };
        let (own, child) = (text(self.own_bytes), text(self.child_bytes));
        write!(f, "{own}, largest child process {child}")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_line_is_read_and_nothing_else_is() {
        assert_eq!(
            high_water("Name:\tx\nVmPeak:\t 9 kB\nVmHWM:\t  2048 kB\n"),
            Some(2 << 20)
        );
        assert_eq!(high_water("VmHWM: many kB"), None);
        assert_eq!(high_water(""), None);
        let peak = PeakMemory {
            own_bytes: Some(3 << 20),
            child_bytes: None,
        };
        assert_eq!(peak.to_string(), "3 MiB, largest child process unknown");
    }

    #[cfg(target_os = "linux")]
    #[test]
    fn what_was_held_shows() {
        let held = std::hint::black_box(vec![1_u8; 64 << 20]);
        let own = peak().own_bytes.unwrap();
        assert!(own > held.len() as u64 && own < 1 << 40, "{own}");
    }
}
