//! The table of functions is stdlib's.

use crate::{between, keep, read};
use std::path::Path;

/// Signature and first sentence of every function.
fn table(text: &str) -> String {
    let mut out = String::from("\n| function | is |\n| --- | --- |\n");
    let mut doc: Vec<&str> = Vec::new();
    for line in text.lines() {
        if let Some(words) = line.strip_prefix("///") {
            doc.push(words.trim());
        } else {
            if let Some(rest) = line.strip_prefix("fn ") {
                let signature = rest.split(" = ").next().unwrap_or(rest);
                let words: Vec<&str> = doc.iter().copied().take_while(|line| !line.is_empty()).collect();
                out.push_str(&format!("| `{signature}` | {} |\n", words.join(" ")));
            }
            doc.clear();
        }
    }
    out + "\n"
}

#[test]
fn the_table_of_functions_is_that_of_stdlib() {
    let path = Path::new("docs/reference/expressions.md");
    let functions = table(&read(Path::new("stdlib/functions.polish")));
    let page = between(&read(path), "<!-- made from stdlib/functions.polish -->\n", "<!-- end -->", &functions);
    keep(path, &page, "the table of functions");
}
