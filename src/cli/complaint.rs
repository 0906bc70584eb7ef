//! What the user reads when a run has no result: what failed, why, and what to do about it.

use midshell::exit_class::ExitClass;
use midshell::export::WriteError;
use midshell::options::OptionFault;
use midshell::pipeline::PipelineError;
use std::error::Error;
use std::fmt;
use std::path::Path;

/// A failure as the user sees it.
#[derive(Clone, Debug, PartialEq)]
pub struct Complaint {
    /// How the process ends.
    pub class: ExitClass,
    /// What failed, with the file that it failed on.
    pub what: String,
    /// Why.
    pub cause: String,
    /// What to do about it.
    pub remedy: String,
}

impl Complaint {
    /// Bad usage.
    pub fn usage(
        what: impl Into<String>,
        cause: impl Into<String>,
        remedy: impl Into<String>,
    ) -> Self {
        Self {
            class: ExitClass::BadUsage,
            what: what.into(),
            cause: cause.into(),
            remedy: remedy.into(),
        }
    }

    /// The library could not do what it was asked to do (`verb`) with a part.
    pub fn pipeline(verb: &str, input: &Path, error: &PipelineError) -> Self {
        Self {
            class: error.exit_class(),
            what: format!("cannot {verb} {}", input.display()),
            cause: chain(error),
            remedy: error.remedy(),
        }
    }

    /// The options are wrong whatever the part is.
    pub fn options(verb: &str, input: &Path, fault: &OptionFault) -> Self {
        let what = format!("cannot {verb} {}", input.display());
        Self::usage(what, chain(fault), fault.remedy())
    }

    /// The outputs cannot be written.
    pub fn output(input: &Path, error: &WriteError) -> Self {
        Self {
            class: ExitClass::OutputFailed,
            what: format!("cannot deliver the result of {}", input.display()),
            cause: chain(error),
            remedy: "name a file in a folder that exists, that you may write to and that has room; nothing of this run is left behind".into(),
        }
    }

    /// A panic: our fault.
    pub fn bug(message: &str) -> Self {
        Self {
            class: ExitClass::Internal,
            what: "midshell has a bug".into(),
            cause: message.into(),
            remedy: "please report it with the part and the command line; a different --size may get round it".into(),
        }
    }
}

/// An error with everything that caused it. Some messages repeat their source already: nothing is said twice.
fn chain(error: &dyn Error) -> String {
    let mut text = error.to_string();
    let mut next = error.source();
    while let Some(cause) = next {
        let cause_text = cause.to_string();
        if !text.contains(&cause_text) {
            text.push_str(": ");
            text.push_str(&cause_text);
        }
        next = cause.source();
    }
    text
}

impl fmt::Display for Complaint {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(f, "error: {}", self.what)?;
        let mut lines = self.cause.trim().lines();
        writeln!(f, "  cause: {}", lines.next().unwrap_or("unknown"))?;
        for line in lines {
            writeln!(f, "         {line}")?;
        }
        writeln!(f, "  remedy: {}", self.remedy.trim())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[derive(Debug, thiserror::Error)]
    #[error("the file is damaged")]
    struct Outer(#[source] std::num::ParseIntError);

    #[test]
    fn a_complaint_names_failure_cause_and_remedy() {
        let complaint =
            Complaint::usage("cannot mesh a.step", "line one\nline two", "try b.step\n");
        assert_eq!(
            complaint.to_string(),
            "error: cannot mesh a.step\n  cause: line one\n         line two\n  remedy: try b.step\n"
        );
    }

    #[test]
    fn the_whole_chain_of_causes_is_told_once() {
        let inner = "x".parse::<i32>().unwrap_err();
        let text = chain(&Outer(inner.clone()));
        assert_eq!(text, format!("the file is damaged: {inner}"));
    }
}
