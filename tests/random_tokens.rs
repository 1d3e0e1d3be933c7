//! Random text: whatever is in a file, reading it ends, says a bounded number of things, and never panics.
#![allow(clippy::disallowed_methods, reason = "tests read the tree's own files")]

use polishc::eval::{self, Options};
use polishc::source::{FileId, MemoryFiles};
use polishc::syntax;
use polishc::syntax::ast::{Ast, Block, EntryKind, Expr, ExprKind, ItemKind};
use polishc::syntax::tokens::{TokenKind, tokenize};

/// A row of numbers that looks like chance and is the same each time (Knuth's MMIX multiplier).
struct Chance(u64);

impl Chance {
    fn below(&mut self, limit: usize) -> usize {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 33) as usize % limit
    }
}

const WORDS: &[&str] = &[
    "language",
    "1",
    "use",
    "let",
    "param",
    "fn",
    "schema",
    "family",
    "job",
    "allow",
    "assert",
    "pub",
    "unit",
    "if",
    "then",
    "else",
    "for",
    "in",
    "with",
    "where",
    "usual",
    "because",
    "and",
    "or",
    "not",
    "none",
    "true",
    "result",
    "pitch",
    "tool",
    "raster",
    "mrf_wheel",
    "mm",
    "0.5",
    "1e-10",
    "4 mm",
    "20 deg",
    "3 nm/s",
    "\"text\"",
    "\"",
    "{",
    "}",
    "[",
    "]",
    "(",
    ")",
    ",",
    ":",
    "=",
    "+",
    "-",
    "*",
    "/",
    "^",
    "..",
    "<=",
    "==",
    "->",
    "|",
    "?",
    "%",
    ".",
    ";",
    "///",
    "//",
    "/*",
    "*/",
    "\n",
    "\n",
    "\n    ",
    " ",
    "\t",
    "µ",
    "°",
    "²",
    "&&",
    "||",
    "**",
    "#",
    "'",
    "“",
    "\u{200b}",
    "\r\n",
    "@",
    "$",
    "0,5",
    "1/mm",
];

const LENGTH: usize = 100_000;

fn survives(text: &str) {
    // Of one file at most a thousand mistakes are told.
    let (_, said) = syntax::parse(FileId(0), text);
    assert!(said.len() <= 1000, "{} diagnostics", said.len());
    let files = MemoryFiles([("t.polish".to_string(), text.as_bytes().to_vec())].into_iter().collect());
    let compiled = eval::compile(&files, "t.polish", &Options::default());
    // What the checker says is bounded by the text: a name is unknown once for each time it stands there.
    assert!(compiled.diagnostics.len() <= 1000 + text.len() / 2, "{} diagnostics", compiled.diagnostics.len());
    let end = text.len() as u32;
    for label in compiled.diagnostics.iter().filter_map(|d| d.primary.as_ref()) {
        let place = label.span;
        assert!(place.start <= place.end, "a place that ends before it begins");
        assert!(compiled.sources.name(place.file) != "t.polish" || place.end <= end, "a place outside the file");
        compiled.sources.slice(place);
    }
}

#[test]
fn a_hundred_kilobytes_of_random_tokens() {
    for seed in 0..6 {
        let mut chance = Chance(seed);
        let mut text = String::from(if seed % 2 == 0 { "language 1\n" } else { "" });
        while text.len() < LENGTH {
            text.push_str(WORDS[chance.below(WORDS.len())]);
            if chance.below(3) > 0 {
                text.push(' ');
            }
        }
        survives(&text);
    }
}

#[test]
fn a_hundred_kilobytes_of_random_letters_and_bytes() {
    for seed in 0..4 {
        let mut chance = Chance(1000 + seed);
        let bytes: Vec<u8> = (0..LENGTH).map(|_| chance.below(256) as u8).collect();
        let ascii: Vec<u8> = bytes.iter().map(|byte| 32 + byte % 95).collect();
        survives(&String::from_utf8_lossy(&ascii));
        survives(&String::from_utf8_lossy(&bytes));
        // Bytes that are no text are refused as a whole.
        let files = MemoryFiles([("t.polish".to_string(), bytes)].into_iter().collect());
        assert_eq!(eval::compile(&files, "t.polish", &Options::default()).diagnostics.len(), 1);
    }
}

/// The named entries of a file, those of inner records included.
fn entries(ast: &Ast) -> usize {
    fn expr(expression: &Expr) -> usize {
        match &expression.kind {
            ExprKind::Record { body, .. } => block(body),
            ExprKind::With(base, body) => expr(base) + block(body),
            ExprKind::List(elements, _) => elements.iter().map(expr).sum(),
            _ => 0,
        }
    }
    fn block(body: &Block) -> usize {
        let one = |kind: &EntryKind| match kind {
            EntryKind::Field { value, .. } => 1 + expr(value),
            EntryKind::Expr(_) => 1,
        };
        body.entries.iter().map(|entry| one(&entry.kind)).sum()
    }
    let item = |kind: &ItemKind| match kind {
        ItemKind::Let { value, .. } => 1 + expr(value),
        ItemKind::Job { body, .. } => 1 + block(body),
        _ => 1,
    };
    ast.items.iter().map(|found| item(&found.kind)).sum()
}

#[test]
fn a_deleted_token_of_an_example_costs_few_entries() {
    let (mut tokens, mut lost, mut worst, mut noisy) = (0, 0, 0, 0);
    for path in ["examples/flat_340/flat_340.polish", "examples/flat_340/cell.polish", "examples/first/first.polish"] {
        let text = std::fs::read_to_string(path).expect("an example");
        let whole = entries(&syntax::parse(FileId(0), &text).0);
        for token in tokenize(&text) {
            if matches!(token.kind, TokenKind::Blank | TokenKind::Newline | TokenKind::Comment { .. } | TokenKind::Doc)
            {
                continue;
            }
            let cut = format!("{}{}", &text[..token.start as usize], &text[token.end as usize..]);
            let (ast, said) = syntax::parse(FileId(0), &cut);
            if said.len() > 1 {
                let codes: Vec<&str> = said.iter().map(|d| d.code.as_str()).collect();
                let slice = &text[token.start as usize..token.end as usize];
                println!("{path}: `{slice}` deleted at byte {}: {codes:?}", token.start);
                noisy += 1;
            }
            let gone = whole.saturating_sub(entries(&ast));
            tokens += 1;
            lost += gone;
            worst = worst.max(gone);
        }
    }
    println!("{tokens} tokens deleted, {lost} entries lost, at most {worst} by one token");
    assert_eq!(noisy, 0, "deletions with more than one diagnostic");
    // The figures of these examples when this was written (514 and 50) with a margin for their growth. A deleted name takes
    // what stands under it; the head of a job takes the job.
    assert!(lost <= 600 && worst <= 60, "{lost} entries lost in {tokens} deletions, {worst} by one");
}
