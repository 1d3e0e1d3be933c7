//! Syntax: text to tree. Parsing never fails; see `parse`.
pub mod ast;
