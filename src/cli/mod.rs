//! The command line: arguments, the disk, standard output, exit codes. Nothing else in the crate knows of these.

mod arguments;
mod commands;
mod disk;
pub mod output;

pub use commands::run;
