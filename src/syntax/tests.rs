//! Tests of the whole parser. Tests of one step stand beside it.

use super::ast::*;
use super::parse;
use crate::diagnostics::Diagnostic;
use crate::source::FileId;

const JOB: &str = include_str!("../../tests/syntax/flat_340.polish");

fn read(text: &str) -> (Ast, Vec<Diagnostic>) {
    parse(FileId(0), text)
}

fn codes(text: &str) -> Vec<&'static str> {
    read(text).1.iter().map(|d| d.code.as_str()).collect()
}

fn show(text: &str, d: &Diagnostic) -> String {
    let p = d.primary.as_ref().unwrap().span;
    format!("{} {} @{}..{} `{}`", d.code, d.message, p.start, p.end, &text[p.start as usize..p.end as usize])
}

#[test]
fn the_example_job_is_read_without_a_word() {
    let (ast, said) = read(JOB);
    let said: Vec<String> = said.iter().map(|d| show(JOB, d)).collect();
    assert_eq!(said, Vec::<String>::new());
    println!("{ast:#?}");
}

#[test]
fn others() {
    for (n, text) in [
        ("asphere_400", include_str!("../../tests/syntax/asphere_400.polish")),
        ("k9", include_str!("../../tests/syntax/k9_200.polish")),
        ("sphere_200", include_str!("../../tests/syntax/sphere_200.polish")),
        ("spot", include_str!("../../tests/syntax/spot_test.polish")),
        ("cell", include_str!("../../tests/syntax/cell.polish")),
        ("schemas", include_str!("../../tests/syntax/schemas.polish")),
    ] {
        println!("== {n}");
        for d in read(text).1 {
            println!("{}", show(text, &d));
        }
    }
}
