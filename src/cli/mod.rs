//! The command line: arguments, the disk, standard output, exit codes. Nothing else in the crate knows of these.

mod arguments;
mod commands;
mod disk;
mod fmt;
pub mod output;
mod terminal;

pub use commands::run;
