//! Mistakes: each said once, in order, with its mend.
