//! Eval: from checked text to the Job.
