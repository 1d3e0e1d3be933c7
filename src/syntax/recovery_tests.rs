//! Tests of what is said about mistakes, and of what is still read beside them.

use super::ast::{Ast, EntryKind, ItemKind};
use super::tests::{FILES, JOB, entry_paths, is_meaningful, mended, read, show};
use super::tokens::{TokenKind, tokenize};
use crate::diagnostics::{Diagnostic, Severity};
use proptest::prelude::*;

/// Each mistake with all that is said about it, by hand: code, and the text at the primary place.
const MISTAKES: &[(&str, &[(&str, &str)])] = &[
    ("let a = 3 $ 4", &[("E0101", "$")]),
    ("let a = 3 − 4", &[("E0101", "−")]),
    ("let a = “text”", &[("E0101", "“")]),
    ("let a = f(3", &[("E0102", "(")]),
    ("job x {\n    a: { b: 1\n    c: 2\n}\n", &[("E0102", "{")]),
    ("job x {\n    a: 1\n", &[("E0102", "{")]),
    ("job x {\n    a: [1, 2\n    b: 3\n}\n", &[("E0102", "[")]),
    ("let a = 3]", &[("E0103", "]")]),
    ("job x { a: 1 }}", &[("E0103", "}")]),
    ("let a = \"text\nlet b = 3", &[("E0104", "\"text")]),
    ("job x {\n    a: f(\"text)\n    b: 3\n}", &[("E0104", "\"text)")]),
    ("let a = 3 /* x /* y */\njob x {", &[("E0105", "/*")]),
    ("job x {\n    a:\n    b: 3\n}", &[("E0106", ":")]),
    ("job x { a: }", &[("E0106", ":")]),
    ("let a = 3 +", &[("E0107", "")]),
    ("let a = 3 4", &[("E0107", "4")]),
    ("let if = 3", &[("E0107", "if")]),
    ("use a.b.", &[("E0107", "")]),
    ("job x { outer diameter: 3 mm }", &[("E0107", "outer diameter")]),
    ("job x { a: 3; b: 4 }", &[("E0107", ";")]),
    ("let a = 1\nlanguage 1", &[("E0108", "language 1")]),
    ("job x { a: 1,, b: 2 }", &[("E0111", ",")]),
    ("let a = 1.", &[("E0112", "1.")]),
    ("let a = .5 mm", &[("E0112", ".5")]),
    ("let a = 1_000 nm", &[("E0112", "1_000")]),
    ("let a = 1.e3", &[("E0112", "1.e3")]),
    ("let a = 1e999", &[("E0112", "1e999")]),
    ("let a = 1e-999", &[("E0112", "1e-999")]),
    ("let a = 2.4.1", &[("E0112", "2.4.1")]),
    ("let a = 4 mm^999", &[("E0112", "999")]),
    ("let a = 1/mm", &[("E0113", "1/mm")]),
    ("let a = 1e-10 /mm^3", &[("E0113", "1e-10 /mm^3")]),
    ("let a = 1/20 wave", &[("E0113", "1/20 wave")]),
    ("let a = 2 * 1/20 wave", &[("E0113", "1/20 wave")]),
    ("let a = 1.5 kg/m/s^2", &[("E0113", "1.5 kg/m/s^2")]),
    ("let a = 4 mm ^ 2", &[("E0114", "^")]),
    ("let a = 4 mm^n", &[("E0114", "^")]),
    ("let a = 4 mm(3)", &[("E0114", "(3)")]),
    ("let a = 4 mm.x", &[("E0114", ".x")]),
    ("let a = [\n    1\n    - 2\n]", &[("E0115", "-")]),
    ("let a = \"C:\\data\"", &[("E0116", "\\d")]),
    ("fn f(a: Length) = a", &[("E0107", "=")]),
    ("fn f(a) -> Length = a", &[("E0107", ")")]),
    ("fn f a: Length -> Length = a", &[("E0107", "a")]),
    ("let a = if b then c", &[("E0107", "")]),
    ("let a = 1 + if b then c else d", &[("E0107", "if")]),
    ("let a = if b then if c then 1 else 2 else 3", &[("E0107", "if")]),
    ("let a = [1, i for i in 1 .. 3]", &[("E0107", "for i in 1 .. 3")]),
    ("let a = i for i in 1 .. 3", &[("E0107", "for")]),
    ("let a = [i for i in 1 .. 3 if i > 1]", &[("E0107", "if")]),
    ("job x {\n    allow W0401\n    a: 1\n}", &[("E0124", "W0401")]),
    ("job x {\n    allow W0401 because \"\"\n    a: 1\n}", &[("E0124", "W0401")]),
    ("job x {\n    a: 1\n    allow W0401 because \"so\"\n}", &[("E0125", "allow W0401 because \"so\"")]),
    ("allow W0401 because \"so\"", &[("E0125", "allow W0401 because \"so\"")]),
    ("assert a < b", &[("E0124", "assert")]),
    ("job x {\n    assert a < b because \"so\"\n}", &[("E0123", "assert")]),
    ("job x\n{\n    a: 1\n}", &[("E0118", "{")]),
    ("job\nx {\n    a: 1\n}", &[("E0118", "x")]),
    ("job x {\n    a: circle\n        b: 1\n    }\n}", &[("E0118", "")]),
    ("job x {\n    a: circle b: 1 }\n    c: 2\n}", &[("E0118", "")]),
    ("job x { a: 1 b: 2 }", &[("E0119", "b")]),
    ("let a = 1 < 2 < 3", &[("E0120", "<")]),
    ("let a = 1 .. 2 .. 3", &[("E0120", "..")]),
    ("let a = 2^3^4", &[("E0120", "^")]),
    ("job x { a = 3 }", &[("E0121", "=")]),
    ("job x { a 3 mm }", &[("E0121", "a")]),
    ("job { a: 1 }", &[("E0122", "job")]),
    ("job x {\n    : 3\n    b: 2\n}", &[("E0122", ":")]),
    ("wavelength: 633 nm", &[("E0123", "wavelength")]),
    ("flat { a: 1 }", &[("E0123", "flat")]),
    ("job x { let a = 3 }", &[("E0123", "let")]),
    ("job x {\n    a: 1\n    /// nothing\n}", &[("W0101", "///")]),
];

fn places<'a>(text: &'a str, said: &[Diagnostic]) -> Vec<(&'static str, &'a str)> {
    said.iter()
        .map(|d| {
            let span = d.primary.as_ref().expect("a place").span;
            (d.code.as_str(), &text[span.start as usize..span.end as usize])
        })
        .collect()
}

fn errors(said: &[Diagnostic]) -> usize {
    said.iter().filter(|d| d.severity == Severity::Error).count()
}

#[test]
fn one_mistake_is_one_diagnostic_at_its_place() {
    for (mistake, expected) in MISTAKES {
        let text = format!("language 1\n{mistake}\n");
        let (_, said) = read(&text);
        let said = places(&text, &said);
        assert_eq!(said, *expected, "{mistake}");
    }
}

#[test]
fn a_mend_mends() {
    let mut mended_count = 0;
    for (mistake, _) in MISTAKES {
        let text = format!("language 1\n{mistake}\n");
        let (_, said) = read(&text);
        if said.iter().all(|d| d.suggestions.is_empty()) {
            continue;
        }
        mended_count += 1;
        let after = mended(&text, &said);
        let again: Vec<String> = read(&after).1.iter().map(|d| show(&after, d)).collect();
        assert_eq!(again, Vec::<String>::new(), "{after}");
    }
    assert!(mended_count > 20, "only {mended_count} mends");
}

#[test]
fn mends_say_what_was_meant() {
    for (mistake, meant) in [
        ("let a = 1/mm", "let a = 1 mm^-1"),
        ("let a = 1e-10 /mm^3", "let a = 1e-10 mm^-3"),
        ("let a = 1/20 wave", "let a = 1 wave / 20"),
        ("let a = 3 kg/m^2/s", "let a = 3 kg*m^-2*s^-1"),
        ("let a = 4 mm ^ 2", "let a = (4 mm) ^ 2"),
        ("let a = 1. mm + .5 mm", "let a = 1.0 mm + 0.5 mm"),
        ("let a = “text”", "let a = \"text\""),
        ("job x { a = 3, b 4 mm c: 5 }", "job x { a: 3, b: 4 mm, c: 5 }"),
        ("job x { outer diameter: 3 mm }", "job x { outer_diameter: 3 mm }"),
        ("job x\n{\n}", "job x {\n}"),
        ("job\n\n  x {\n}", "job x {\n}"),
        ("let a = 2 × 3 − 1", "let a = 2 * 3 - 1"),
    ] {
        let text = format!("language 1\n{mistake}\n");
        assert_eq!(mended(&text, &read(&text).1), format!("language 1\n{meant}\n"));
    }
}

#[test]
fn the_language_line_comes_first_and_is_known() {
    let codes = |text: &str| read(text).1.iter().map(|d| d.code.as_str()).collect::<Vec<_>>();
    assert_eq!(codes(""), ["E0108"]);
    assert_eq!(codes("let a = 1\n"), ["E0108"]);
    assert_eq!(codes("\u{feff}// a comment\n/* and one */ language 1\r\nlet a = 1\r\n"), [] as [&str; 0]);
    assert_eq!(codes("language\n"), ["E0107"]);
    // A newer file may hold anything: only its age is told.
    let (ast, said) = read("language 2\nfoo bar baz ((\n");
    assert_eq!(said.iter().map(|d| d.code.as_str()).collect::<Vec<_>>(), ["E0109"]);
    assert_eq!((ast.language.map(|(number, _)| number), ast.items.len()), (Some(2), 0));
    let text = "let a = 1\n";
    let after = mended(text, &read(text).1);
    assert_eq!(after, "language 1\nlet a = 1\n");
}

#[test]
fn one_item_does_not_hurt_the_next() {
    let text = "language 1\njob x {\n    a: [1, (2\n    b: { c: 3\n\nlet d = 4\n";
    let (ast, said) = read(text);
    assert_eq!(places(text, &said), [("E0102", "(")]);
    assert!(matches!(&ast.items[..], [job, d] if matches!(job.kind, ItemKind::Job { .. })
        && matches!(&d.kind, ItemKind::Let { name, .. } if name.text == "d")));
}

#[test]
fn mistakes_in_inner_records_are_told_beside_a_broken_head() {
    let text = "language 1\njob x {\n    a: b c { d: 1/mm, e: }\n    f: 2\n}\n";
    let (ast, said) = read(text);
    assert_eq!(places(text, &said), [("E0107", "c"), ("E0113", "1/mm"), ("E0106", ":")]);
    let Some(ItemKind::Job { body, .. }) = ast.items.first().map(|item| &item.kind) else { panic!("a job") };
    let names: Vec<_> = body
        .entries
        .iter()
        .filter_map(|entry| match &entry.kind {
            EntryKind::Field { name, .. } => Some(name.text.as_str()),
            EntryKind::Expr(_) => None,
        })
        .collect();
    assert_eq!(names, ["a", "f"]);
}

/// The example with each of its tokens changed in turn; the change gives the text in place of the token.
fn each_token(change: impl Fn(&str) -> String, mut see: impl FnMut(&str, &str, Ast, Vec<Diagnostic>)) -> usize {
    let mut count = 0;
    for token in tokenize(JOB).into_iter().filter(|token| is_meaningful(token.kind)) {
        let (start, end) = (token.start as usize, token.end as usize);
        let text = format!("{}{}{}", &JOB[..start], change(&JOB[start..end]), &JOB[end..]);
        let (ast, said) = read(&text);
        see(&JOB[start..end], &text, ast, said);
        count += 1;
    }
    count
}

#[test]
fn a_deleted_token_is_one_diagnostic_and_loses_little() {
    let whole = entry_paths(&read(JOB).0);
    let (mut lost, mut silent) = (0, 0);
    let count = each_token(
        |_| String::new(),
        |token, text, ast, said| {
            let said: Vec<String> = said.iter().map(|d| show(text, d)).collect();
            assert!(said.len() <= 1, "`{token}` deleted: {said:#?}");
            silent += usize::from(said.is_empty());
            let left = entry_paths(&ast);
            let gone: usize =
                whole.iter().map(|(path, n)| n.saturating_sub(left.get(path).copied().unwrap_or(0))).sum();
            // The entry that was hit is not counted.
            lost += gone.saturating_sub(1);
        },
    );
    assert_eq!(count, 403, "tokens of the example");
    // Bounds against getting worse. What is lost stood below a deleted name (`edge`, `tool`, `stages` …), so that its
    // path is no longer known, or below `after:`, whose value was deleted and which takes the record after it.
    assert!(lost <= 155, "{lost} good entries lost");
    // What stays silent is another correct file: a number without its unit, a shorter path, a shorter list.
    assert!(silent <= 93, "{silent} deletions said nothing");
}

#[test]
fn a_doubled_token_and_a_stray_closer_are_one_diagnostic() {
    for change in [|token: &str| format!("{token} {token}"), |token: &str| format!("{token} )")] {
        each_token(change, |token, text, _, said| {
            let said: Vec<String> = said.iter().map(|d| show(text, d)).collect();
            assert_eq!(said.len(), 1, "`{token}`: {said:#?}");
        });
    }
}

#[test]
fn every_mend_of_a_damaged_example_mends_it() {
    each_token(
        |_| String::new(),
        |token, text, _, said| {
            if errors(&said) == 1 && said.iter().any(|d| !d.suggestions.is_empty()) {
                let after = mended(text, &said);
                let again: Vec<String> = read(&after).1.iter().map(|d| show(&after, d)).collect();
                assert_eq!(again, Vec::<String>::new(), "`{token}` deleted, mended: {said:#?}");
            }
        },
    );
}

#[test]
fn nesting_without_end_is_one_clear_error() {
    for open in ["[", "(", "{", "a: {", "f(", "[{(", "-", "not ", "- - ", "a.b", "x with { y: "] {
        let text = format!("language 1\nlet a = {}", open.repeat(100_000));
        let (_, said) = read(&text);
        assert!(errors(&said) <= 2, "{open}: {}", said.len());
    }
    let text = format!("language 1\nlet a = {}1{}\nlet b = 1/mm\n", "[".repeat(100_000), "]".repeat(100_000));
    let (_, said) = read(&text);
    assert_eq!(said.iter().map(|d| d.code.as_str()).collect::<Vec<_>>(), ["E0110", "E0113"]);
    assert_eq!(said[0].message, "brackets stand more than 64 deep in each other");
    let long = format!("language 1\nlet a = 1{}\n", " + 1".repeat(100_000));
    assert_eq!(read(&long).1.iter().map(|d| d.code.as_str()).collect::<Vec<_>>(), ["E0110"]);
    let comments = "/*".repeat(100_000);
    assert_eq!(read(&format!("language 1\n{comments}")).1.len(), 1);
}

#[test]
fn a_chain_that_is_just_short_enough_can_be_taken_apart() {
    let text = format!("language 1\nlet a = {}x{}\n", "[".repeat(60), " + 1]".repeat(60));
    assert_eq!(read(&text).1, []);
    let text = format!("language 1\nlet a = {}1{}\n", "- ".repeat(250), " + 1".repeat(250));
    assert_eq!(read(&text).1, []);
    // The deepest that the limits allow, in the 2 MiB of a test's thread.
    for (open, close) in [("(", ")"), ("f(", ")"), ("x { a: ", "}"), ("[", "]"), ("x with { a: [", "]}")] {
        let deep = 64 / open.matches(['(', '{', '[']).count();
        let text = format!("language 1\nlet a = {}1{}\n", open.repeat(deep), close.repeat(deep));
        assert_eq!(read(&text).1, [], "{open}");
    }
}

#[test]
fn a_megabyte_of_anything_is_read() {
    // Numerical Recipes' linear congruence: the same bytes each time.
    let mut state = 1u32;
    let mut byte = || {
        state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        (state >> 24) as u8
    };
    let bytes: Vec<u8> = (0..1 << 20).map(|_| byte()).collect();
    let (_, said) = read(&String::from_utf8_lossy(&bytes));
    assert!(said.len() <= 1000);
    let printable: String = (0..1 << 20).map(|_| char::from(32 + byte() % 95)).collect();
    read(&printable);
    read(&format!("language 1\nlet a = f({printable}"));
    // Without what swallows the rest of a line or of the file.
    read(&printable.replace(['"', '/'], "\n"));
    for repeated in ["a:", "a: b ", "1,", "x\n", "/// d\n", "{}", "}", "a: [b\n", " a: {\n", "\"", "a.", "/*", "1/"] {
        read(&format!("language 1\njob x {{\n{}", repeated.repeat((1 << 17) / repeated.len())));
    }
}

fn soup() -> impl Strategy<Value = String> {
    let word = prop::sample::select(vec![
        "language 1\n",
        "job x {",
        "let a =",
        "use ",
        "schema s : F {",
        "a:",
        "\n",
        "\n    ",
        " ",
        "{",
        "}",
        "[",
        "]",
        "(",
        ")",
        ",",
        ";",
        "with {",
        "where >",
        "usual",
        "1",
        "4 mm",
        "1/mm",
        "1.",
        ".5",
        "^",
        "-",
        "- ",
        "not",
        "..",
        "\"t\"",
        "\"",
        "/*",
        "*/",
        "// c\n",
        "/// d\n",
        "|",
        "?",
        ".",
        "b",
        "if",
        "for",
        "=",
        "==",
        "<=",
        "§",
        "µm",
        "\\",
        "\r\n",
        "%",
        "pub ",
    ]);
    prop::collection::vec(word, 0..60).prop_map(|words| words.concat())
}

proptest! {
    #![proptest_config(ProptestConfig { failure_persistence: None, cases: 600, ..ProptestConfig::default() })]

    #[test]
    fn any_text_is_read(text in any::<String>()) {
        read(&text);
    }

    #[test]
    fn any_soup_of_tokens_is_read_and_told_in_order(text in soup()) {
        let (ast, said) = read(&text);
        let mut last = 0;
        for d in &said {
            let span = d.primary.as_ref().expect("a place").span;
            prop_assert!(span.start <= span.end && span.end as usize <= text.len());
            prop_assert!(text.is_char_boundary(span.start as usize) && text.is_char_boundary(span.end as usize));
            prop_assert!(last <= span.start);
            last = span.start;
            for s in &d.suggestions {
                prop_assert!(text.is_char_boundary(s.span.start as usize) && text.is_char_boundary(s.span.end as usize));
            }
            // No rule of the grammar and no type of this program is named to people.
            prop_assert!(!d.message.contains("_item") && !d.message.contains("Rule") && !d.message.contains("EOI"));
        }
        super::tests::walk(&ast, &mut |expr| {
            assert!(expr.span.start <= expr.span.end && expr.span.end as usize <= text.len());
        });
    }

    #[test]
    fn tokens_are_the_text(text in prop_oneof![any::<String>(), soup()]) {
        let tokens = tokenize(&text);
        let mut at = 0;
        for token in &tokens {
            prop_assert_eq!(token.start, at);
            prop_assert!(token.end > token.start);
            prop_assert!(text.is_char_boundary(token.end as usize));
            at = token.end;
        }
        prop_assert_eq!(at as usize, text.len());
    }

    #[test]
    fn a_piece_cut_out_of_the_example_does_no_harm(start in 0usize..2800, length in 0usize..200) {
        let from = JOB.floor_char_boundary(start.min(JOB.len()));
        let to = JOB.floor_char_boundary((start + length).min(JOB.len()));
        read(&format!("{}{}", &JOB[..from], &JOB[to..]));
    }
}

#[test]
fn tokens_are_of_the_kinds_that_the_language_says() {
    fn kinds(text: &str) -> Vec<(TokenKind, &str)> {
        tokenize(text).into_iter().map(|t| (t.kind, &text[t.start as usize..t.end as usize])).collect()
    }
    use TokenKind as K;
    assert_eq!(kinds("1e-10"), [(K::Number, "1e-10")]);
    assert_eq!(kinds("1..2"), [(K::Number, "1"), (K::Punctuation, ".."), (K::Number, "2")]);
    assert_eq!(kinds("4em"), [(K::Number, "4"), (K::Word, "em")]);
    assert_eq!(kinds("1."), [(K::BadNumber, "1.")]);
    assert_eq!(kinds(".5"), [(K::BadNumber, ".5")]);
    assert_eq!(kinds("x.5")[0], (K::Word, "x"));
    assert_eq!(kinds("////")[0], (K::Comment { closed: true }, "////"));
    assert_eq!(kinds("///")[0], (K::Doc, "///"));
    assert_eq!(kinds("/* /* */ */")[0], (K::Comment { closed: true }, "/* /* */ */"));
    assert_eq!(kinds("\"a\\\"b\""), [(K::Text { closed: true }, "\"a\\\"b\"")]);
    assert_eq!(kinds("µm"), [(K::Word, "µm")]);
    assert_eq!(kinds("#$§"), [(K::Unknown, "#$§")]);
    for file in FILES {
        assert!(tokenize(file.1).iter().all(|token| token.kind != K::Unknown), "{}", file.0);
    }
}
