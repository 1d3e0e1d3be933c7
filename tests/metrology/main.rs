//! Maps from bytes to the part, spots from bytes to influence functions, and the geometry of the part.
#![allow(clippy::disallowed_methods, reason = "tests may use the platform's mathematics")]
#![allow(clippy::unwrap_used, clippy::print_stdout, reason = "a test may panic, and says what it skips")]

mod figures;
mod files;
mod formats;
mod hostile;
mod influence;
mod maps;
mod placing;
mod reading;
mod results;
mod samples;
mod spots;
mod workpiece;
