//! polishc: a declarative language and compiler for robotic optical polishing.
//!
//! A `.polish` job goes in; a robot program that has been read back and proved comes out.
//! The passes run in one direction, each noun is a plain data type:
//!
//! ```text
//! text ─ syntax ▶ Ast ─ check ▶ Typed ─ eval ▶ Job ─ path ▶ ToolPath ─ dwell ▶ TimedPath
//!                                                                              │
//! files ◀ write ─ Verified<Program> ◀ verify ─ Draft<Program> ◀ target ─ Checked<Motion> ◀ motion
//! ```
//!
//! Inside, every number is SI (`f64`, metres, radians, seconds, kilograms); units exist in text only.
//! Nothing below `cli` touches the disk, the clock, the environment or standard output.

pub mod check;
#[cfg(feature = "cli")]
pub mod cli;
pub mod diagnostics;
pub mod doc;
pub mod dwell;
pub mod eval;
pub mod forecast;
mod fourier;
pub mod height_map;
pub mod job;
pub mod metrology;
pub mod motion;
pub mod path;
pub mod report;
pub mod session;
pub mod simulate;
pub mod source;
pub mod syntax;
pub mod target;
pub mod tool;
pub mod units;
pub mod verify;
pub mod workpiece;
