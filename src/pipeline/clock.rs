//! The clock of the stages: seconds each. Foreign programs are timed where they are started (`import::spent`).

use super::Progress;
use std::time::Instant;

/// Times the stages and tells of them.
pub(super) struct Clock<'a> {
    progress: &'a dyn Progress,
    seconds: Vec<(String, f64)>,
}

impl<'a> Clock<'a> {
    pub(super) fn new(progress: &'a dyn Progress) -> Self {
        Self {
            progress,
            seconds: Vec::new(),
        }
    }

    /// Does `work` under the name of a stage. A stage that runs several times is added up.
    pub(super) fn time<T>(&mut self, stage: &str, work: impl FnOnce() -> T) -> T {
        self.progress.stage(stage);
        let start = Instant::now();
        let result = work();
        let took = start.elapsed().as_secs_f64();
        match self.seconds.iter_mut().find(|s| s.0 == stage) {
            Some(entry) => entry.1 += took,
            None => self.seconds.push((stage.to_owned(), took)),
        }
        result
    }

    pub(super) fn finish(self) -> Vec<(String, f64)> {
        self.seconds
    }
}
