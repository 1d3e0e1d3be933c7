//! The language from text to Job, with files in memory: a shop's library, values worked out by hand, and mistakes.
#![allow(clippy::disallowed_methods, reason = "tests may use the platform's mathematics")]

#[path = "language/mod.rs"]
mod language;
