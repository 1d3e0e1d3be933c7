//! The command line: arguments, the disk, standard output, exit codes. Nothing else in the crate knows of these.

mod arguments;
mod commands;
mod disk;
mod doc;
mod figures;
mod fmt;
mod new;
pub mod output;
mod show;
mod simulate;
mod sweep;
mod terminal;

pub use commands::run;

/// The whole command line, for man pages and completions.
pub fn command() -> clap::Command {
    <arguments::Arguments as clap::CommandFactory>::command()
}
