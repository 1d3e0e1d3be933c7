//! The RAPID emitter.
#![allow(clippy::disallowed_methods, reason = "tests may use the platform's mathematics")]

mod program;

use polishc::motion::Purpose;
use polishc::target::{self, Program};
use program::{job_with, plan, raster};
use serde_json::json;

fn text(program: &Program) -> String {
    let mut out = String::new();
    for file in &program.files {
        out.push_str(&format!("=== {}\n", file.name));
        out.push_str(&String::from_utf8(file.bytes.clone()).expect("ASCII").replace("\r\n", "\n"));
    }
    out
}

#[test]
fn a_small_program() {
    let job = job_with(&[("/target/rapid/controller/module_points", json!(6))]);
    let motion = plan(&job, raster(3, 3), Purpose::Polish);
    let (draft, warnings) = target::emit("flat_340", &motion, &job).expect("a program");
    assert_eq!(warnings, []);
    insta::assert_snapshot!(text(&draft.0));
}
