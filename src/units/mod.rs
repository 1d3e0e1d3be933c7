//! Units and dimensions. See si.rs for the SI newtypes.
pub mod si;
