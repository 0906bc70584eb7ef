//! The command `midshell`.

mod cli;

use clap::Parser;
use cli::args::Cli;
use midshell::exit_class::ExitClass;
use std::process::ExitCode;

fn main() -> ExitCode {
    let cli = match Cli::try_parse() {
        Ok(cli) => cli,
        Err(refusal) => {
            // Help and version are results; everything else is bad usage.
            let class = if refusal.use_stderr() {
                ExitClass::BadUsage
            } else {
                ExitClass::Right
            };
            let _ = refusal.print();
            return ExitCode::from(class.code());
        }
    };
    let class = cli::guard::guard(|| cli::commands::run(&cli)).unwrap_or_else(|complaint| {
        cli::console::message(&complaint.to_string());
        complaint.class
    });
    ExitCode::from(class.code())
}
