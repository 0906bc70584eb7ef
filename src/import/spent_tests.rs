use super::super::process::{Ended, Limits, Run, run};
use super::*;
use std::path::Path;

#[test]
fn waiting_counts_a_quarter_and_working_counts_whole() {
    let s = Duration::from_secs;
    assert_eq!(counted(Some(s(3)), s(4)), s(3));
    assert_eq!(counted(Some(s(3)), s(40)), s(10));
    assert_eq!(counted(Some(s(9)), s(4)), s(9), "several threads");
    assert_eq!(counted(None, s(4)), s(4), "nothing is known but the clock");
}

#[test]
fn the_times_are_found_behind_any_name() {
    let stat = "71 (a) b) 3) S 1 71 71 0 -1 4194304 100 0 0 0 250 50 4 1 20 0 1 0 1 2 3";
    assert_eq!(in_stat(stat), Some(Duration::from_millis(3050)));
    assert_eq!(in_stat("71 (sh) S 1 71"), None);
    assert_eq!(in_stat(""), None);
}

#[test]
fn a_budget_gives_no_more_than_it_has() {
    let budget = Budget::new(Duration::from_secs(10));
    budget.charge(Duration::from_secs(4));
    assert_eq!(budget.left(), Duration::from_secs(6));
    assert_eq!(budget.left_of(0.5), Duration::from_secs(1));
    budget.charge(Duration::from_secs(9));
    assert_eq!(budget.left(), Duration::ZERO);
}

#[cfg(unix)]
fn shell(script: &str, limit: Duration) -> (Run, Duration) {
    let folder = tempfile::tempdir().unwrap();
    let limits = Limits {
        time: limit,
        memory: None,
    };
    let start = Instant::now();
    let sh = Path::new("/bin/sh");
    let run = run(sh, &["-c", script], &[], folder.path(), "log", limits).unwrap();
    (run, start.elapsed())
}

#[cfg(target_os = "linux")]
#[test]
fn one_that_works_is_stopped_by_its_processor_time_and_one_that_waits_by_the_clock() {
    let limit = Duration::from_millis(500);
    // In itself, and in a child that it waits for.
    for spin in ["while :; do :; done", "(while :; do :; done); exit 0"] {
        let (run, took) = shell(spin, limit);
        assert!(matches!(run.ended, Ended::TimedOut));
        assert!(took >= limit && run.spent == limit, "{took:?}");
    }
    let (run, took) = shell("sleep 60", limit);
    assert!(matches!(run.ended, Ended::TimedOut));
    assert!(
        took >= limit * BACKSTOP,
        "the clock alone came first: {took:?}"
    );
    assert!(took < Duration::from_secs(30), "{took:?}");
}

#[cfg(target_os = "linux")]
#[test]
fn one_that_waits_longer_than_its_limit_but_works_less_ends_well() {
    let (run, took) = shell("sleep 1; echo done", Duration::from_millis(600));
    assert!(matches!(run.ended, Ended::Exit(s) if s.success()));
    assert!(
        took >= Duration::from_secs(1) && run.spent < took / 2,
        "{:?}",
        run.spent
    );
    assert_eq!(run.log, "done\n");
}

#[cfg(unix)]
#[test]
fn one_that_its_own_limit_stops_is_out_of_time_and_one_that_is_killed_is_not() {
    let (run, _) = shell("kill -s XCPU $$", Duration::from_secs(5));
    assert!(matches!(run.ended, Ended::TimedOut));
    let (run, _) = shell("kill -s KILL $$", Duration::from_secs(5));
    assert!(matches!(run.ended, Ended::Exit(s) if !s.success()));
}
