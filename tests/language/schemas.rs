//! Schemas and structs.
