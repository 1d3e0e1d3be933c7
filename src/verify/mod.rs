//! Verify: reads a program's text with a reader of its own and proves that it does what the job asks.
//!
//! In: the text alone, and the job's plan. Out: `Verified<Program>`, or what differs, in terms of the part.

pub mod rapid;

/// A proof that the text was read back and compared. Only this module can make one.
#[derive(Clone, Debug)]
pub struct Verified<T>(T);

impl<T> std::ops::Deref for Verified<T> {
    type Target = T;
    fn deref(&self) -> &T {
        &self.0
    }
}
