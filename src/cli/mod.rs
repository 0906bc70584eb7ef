//! The command line: it reads arguments, calls the library and shows what comes back. It holds no algorithm and no default value.

pub mod args;
pub mod audit;
pub mod commands;
pub mod complaint;
pub mod console;
pub mod format;
pub mod guard;
pub mod profile;
pub mod sizes;
