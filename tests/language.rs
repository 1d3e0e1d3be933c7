//! The language from text to Job, with files in memory: a shop's library, values worked out by hand, and mistakes.

#[path = "language/mod.rs"]
mod language;
