//! The proof of KRL programs: hand edits that matter are caught and named, hand edits that do not are accepted.
#![allow(clippy::disallowed_methods, reason = "tests may use the platform's mathematics")]

mod program;

use polishc::diagnostics::Problem;
use polishc::job::Job;
use polishc::motion::{Checked, Motion, Purpose};
use polishc::target::{self, Program};
use polishc::verify;
use program::{curved, krl_job_with, plan, raster};
use serde_json::json;

struct Built {
    job: Job,
    motion: Checked<Motion>,
    program: Program,
}

/// A program and what it came from.
fn build(changes: &[(&str, serde_json::Value)], lines: usize, points: usize, purpose: Purpose) -> Built {
    let job = krl_job_with(changes);
    let motion = plan(&job, curved(raster(lines, points)), purpose);
    let draft = target::emit("flat_340", &motion, &job).unwrap_or_else(|p| panic!("{p:?}"));
    Built { job, motion, program: draft.0 }
}

fn check(built: &Built, program: &Program) -> Vec<Problem> {
    verify::check(program, &built.motion, &built.job)
}

fn verifies(built: &Built) {
    let found = check(built, &built.program);
    assert_eq!(found, [], "the emitted program must verify");
}

#[test]
fn emitted_programs_verify() {
    verifies(&build(&[("/target/krl/controller/file_lines", json!(100))], 6, 11, Purpose::Polish));
    verifies(&build(&[], 2, 5, Purpose::DryRun));
}
