//! The formatter: what its look is, and that it never changes more than the look.
//!
//! 20,000 programs are made at random, with blanks, line ends and comments wherever one may stand; the tree's own files
//! are taken apart and put together with other blanks. Of each: formatted, it is right as it is (formatting again changes
//! nothing), its comments are there in their order, and its tree is the tree of the source.
#![allow(clippy::disallowed_methods, clippy::print_stdout, reason = "tests read the tree's own files")]

#[path = "format/generate.rs"]
mod generate;

use generate::{Between, Blanks, Program, Random};
use polishc::diagnostics::Severity;
use polishc::source::FileId;
use polishc::syntax::format::format;
use polishc::syntax::parse;
use polishc::syntax::tokens::{self, TokenKind};
use rayon::prelude::*;
use std::fs;
use std::path::{Path, PathBuf};

/// All `.polish` files under a folder.
fn polish_files(folder: &str) -> Vec<PathBuf> {
    let mut found = Vec::new();
    let mut todo = vec![PathBuf::from(folder)];
    while let Some(path) = todo.pop() {
        if path.is_dir() {
            todo.extend(fs::read_dir(&path).expect("a readable folder").map(|entry| entry.expect("an entry").path()));
        } else if path.extension().is_some_and(|ending| ending == "polish") {
            found.push(path);
        }
    }
    found.sort();
    assert!(!found.is_empty(), "{folder} has .polish files");
    found
}

fn formatted(text: &str) -> String {
    format(FileId(0), text).unwrap_or_else(|mistakes| panic!("{mistakes:?}\n{text}"))
}

/// What we ship is what we ask for.
#[test]
fn stdlib_and_examples_are_formatted() {
    let mut wrong = Vec::new();
    for folder in ["stdlib", "examples"] {
        for path in polish_files(folder) {
            let text = fs::read_to_string(&path).expect("a readable file");
            let new = formatted(&text);
            if new != text {
                if std::env::var_os("FORMAT_UPDATE").is_some() {
                    fs::write(&path, &new).expect("a file that can be written");
                }
                wrong.push(first_difference(&path, &text, &new));
            }
        }
    }
    assert!(wrong.is_empty(), "run `polishc fmt` on:\n{}", wrong.join("\n"));
}

fn first_difference(path: &Path, old: &str, new: &str) -> String {
    let (old, new) = (old.lines().chain([""]), new.lines().chain([""]));
    let lines = old.zip(new).enumerate().find(|(_, (old, new))| old != new);
    match lines {
        Some((at, (old, new))) => format!("{}:{}\n  is  {old}\n  not {new}", path.display(), at + 1),
        None => format!("{}: its end", path.display()),
    }
}

/// A tree as text without places, so that two trees can be compared.
fn tree(text: &str) -> String {
    let (ast, mistakes) = parse(FileId(0), text);
    let errors: Vec<_> = mistakes.iter().filter(|mistake| mistake.severity == Severity::Error).collect();
    assert!(errors.is_empty(), "{errors:?}\n{text}");
    let written = format!("{ast:?}");
    let mut pieces = written.split("Span { file: FileId(0), start: ");
    let first = pieces.next().unwrap_or_default().to_string();
    pieces.fold(first, |tree, piece| tree + piece.split_once('}').expect("the end of a span").1)
}

/// Comments without the blanks at their ends, and all other tokens but commas.
fn comments_and_words(text: &str) -> (Vec<String>, Vec<&str>) {
    let (mut comments, mut words) = (Vec::new(), Vec::new());
    for token in tokens::tokenize(text) {
        let slice = &text[token.start as usize..token.end as usize];
        match token.kind {
            TokenKind::Comment { .. } | TokenKind::Doc => comments.push(slice.replace("\r\n", "\n").trim_end().into()),
            TokenKind::Blank | TokenKind::Newline => {}
            _ if slice == "," => {}
            _ => words.push(slice),
        }
    }
    (comments, words)
}

/// All that must be true of any file that is right in its syntax.
fn assert_kept(text: &str) {
    let new = formatted(text);
    let again = formatted(&new);
    assert!(new == again, "formatting twice differs\n--- source\n{text}\n--- once\n{new}\n--- twice\n{again}");
    assert!(tree(text) == tree(&new), "the tree differs\n--- source\n{text}\n--- formatted\n{new}");
    assert_eq!(comments_and_words(text), comments_and_words(&new), "--- source\n{text}\n--- formatted\n{new}");
    let (mut blank, mut code) = (true, String::new());
    for token in tokens::tokenize(&new) {
        let slice = &new[token.start as usize..token.end as usize];
        // What stands in a comment is the author's.
        code.push_str(if matches!(token.kind, TokenKind::Comment { .. } | TokenKind::Doc) { "//" } else { slice });
    }
    for line in code.split_inclusive('\n') {
        let line = line.strip_suffix('\n').unwrap_or_else(|| panic!("the last line has no end\n{new}"));
        let line = line.strip_suffix('\r').unwrap_or(line);
        assert!(line.trim_end() == line, "blanks end `{line}`\n{new}");
        assert!(!line.contains('\t'), "{new}");
        assert!(!(blank && line.is_empty()), "two blank lines, or one at the start\n{new}");
        blank = line.is_empty();
    }
    assert!(!blank, "the file ends with a blank line\n{new}");
}

#[test]
fn programs_made_at_random_keep_their_tree_and_their_comments() {
    const PROGRAMS: u64 = 20_000;
    let made: Vec<usize> = (0..PROGRAMS)
        .into_par_iter()
        .map(|seed| {
            let text = Program::new(&mut Random::new(seed)).make();
            assert_kept(&text);
            comments_and_words(&text).0.len()
        })
        .collect();
    let comments: usize = made.iter().sum();
    println!("{PROGRAMS} programs with {comments} comments");
    // A generator that makes no comments would prove nothing about them.
    assert!(comments > 100_000, "{comments}");
}

/// The text with other blanks between its tokens: none that carry meaning (close together or not, one line or two).
fn shaken(text: &str, random: &mut Random) -> String {
    let mut blanks = Blanks::new(random);
    let mut out = String::new();
    let tokens = tokens::tokenize(text);
    let mut depth: Vec<&str> = Vec::new();
    for (i, token) in tokens.iter().enumerate() {
        let slice = &text[token.start as usize..token.end as usize];
        match slice {
            "(" | "[" | "{" => depth.push(slice),
            ")" | "]" | "}" => drop(depth.pop()),
            _ => {}
        }
        let last = i.checked_sub(1).map(|last| &tokens[last]);
        let after_comment = last.is_some_and(|last| matches!(last.kind, TokenKind::Comment { .. } | TokenKind::Doc));
        match token.kind {
            // The line end after `// …` is that comment's own.
            TokenKind::Newline if after_comment => out.push('\n'),
            TokenKind::Newline => blanks.put(random, Between::Newline, &mut out),
            // A number's unit stands on its line.
            TokenKind::Blank if depth.last() == Some(&"(") && last.is_none_or(|t| t.kind != TokenKind::Number) => {
                blanks.put(random, Between::Lines, &mut out);
            }
            TokenKind::Blank if last.is_some_and(|last| last.kind != TokenKind::Newline) => {
                blanks.put(random, Between::Blank, &mut out);
            }
            TokenKind::Blank => out.push_str(random.one_of(&["", " ", "       ", "\t"])),
            _ => out.push_str(slice),
        }
    }
    out
}

#[test]
fn the_trees_own_files_keep_their_tree_and_their_comments_however_they_are_blanked() {
    let folders = ["stdlib", "examples", "tests/jobs", "tests/library", "tests/ui"];
    let mut files = 0;
    for path in folders.iter().flat_map(|folder| polish_files(folder)) {
        let text = fs::read_to_string(&path).expect("a readable file");
        // The files of tests/ui are there for their mistakes; those of meaning have none in their syntax.
        if format(FileId(0), &text).is_err() {
            continue;
        }
        assert_kept(&text);
        for seed in 0..20 {
            let shaken = shaken(&text, &mut Random::new(seed));
            assert_kept(&shaken);
        }
        files += 1;
    }
    println!("{files} files");
    assert!(files > 50, "{files}");
}

/// What the look is, one rule each: (source, formatted), both after a line `language 1`.
#[test]
fn the_look() {
    let rules: &[(&str, &str)] = &[
        // Blanks around operators, none inside round and square brackets, one inside curly ones.
        ("let a=2*pi+(b-c)/d", "let a = 2 * pi + (b - c) / d\n"),
        ("let a = [ 1,2 , -3 ] mm", "let a = [1, 2, -3] mm\n"),
        ("let a = f ( - b , c ,)", "let a = f(-b, c)\n"),
        ("let a = b {c:1,d:{}}", "let a = b { c: 1, d: {} }\n"),
        // A unit is close together and one blank from its number; a division is not a unit.
        ("let a = 500mm/s^2", "let a = 500 mm/s^2\n"),
        ("let a = 5%", "let a = 5 %\n"),
        ("let a = 10 mm / s", "let a = 10 mm / s\n"),
        // A power is close together, except where it would become the unit's.
        ("let a = b ^ -2", "let a = b^-2\n"),
        ("let a = (4 mm) ^ (1 / 2)", "let a = (4 mm)^(1/2)\n"),
        ("let a = [4] mm ^ 2", "let a = [4] mm ^ 2\n"),
        ("dimension A=Length ^(1/2)/Time", "dimension A = Length^(1/2) / Time\n"),
        // Only the colon before a family has a blank before it.
        ("pub schema a:B{c : [Length;3]? where>0 mm}", "pub schema a : B { c: [Length; 3]? where > 0 mm }\n"),
        // Brackets that stood on one line do; others end their lines; entries keep their lines.
        ("job a { b: 1, c: 2\nd: 3, }", "job a {\n    b: 1, c: 2\n    d: 3\n}\n"),
        // What takes several lines has them alone; a list of one record holds it close.
        ("let a = [b, {\nc: 1\n}, d]", "let a = [\n    b\n    {\n        c: 1\n    }\n    d\n]\n"),
        ("let a = [{\nc: 1 }]", "let a = [{\n    c: 1\n}]\n"),
        ("let a = b with {\nc: 1 }", "let a = b with {\n    c: 1\n}\n"),
        // An entry that goes on is deeper; in round brackets one step from the bracket's line.
        ("let a = b *\nc", "let a = b *\n    c\n"),
        ("let a = f(\nb,\nc\n)", "let a = f(\n    b,\n    c\n)\n"),
        // At most one blank line, none inside brackets' ends.
        ("\n\n\nlet a = 1\n\n\nlet b = {\n\nc: 1\n\n}\n\n", "\nlet a = 1\n\nlet b = {\n    c: 1\n}\n"),
        // Items each have a line.
        ("let a = 1, let b = 2", "let a = 1\nlet b = 2\n"),
        // Comments stay on their lines; those of their own stand as deep as what follows them.
        (
            "job a { // of a\n// of b\nb: 1,   // of 1\n// end\n}",
            "job a { // of a\n    // of b\n    b: 1   // of 1\n    // end\n}\n",
        ),
        ("let a = [ /* x */ 1 /* y */, 2 ]", "let a = [/* x */ 1 /* y */, 2]\n"),
        ("job a { b: 1 }// end", "job a { b: 1 } // end\n"),
        // Documentation of a symbol stands before its bar.
        (
            "schema a {\nb: /// x\n| c\n/// y\n| d }",
            "schema a {\n    b:\n        /// x\n        | c\n        /// y\n        | d\n}\n",
        ),
        // A file keeps the ends of lines that it has.
        ("let a=1\r\nlet b=2\r\n", "let a = 1\r\nlet b = 2\r\n"),
    ];
    for (source, expected) in rules {
        let newline = if source.contains("\r\n") { "\r\n" } else { "\n" };
        let head = format!("language 1{newline}");
        let whole = formatted(&format!("{head}{source}"));
        assert_eq!(whole.strip_prefix(&head).expect("the first line"), *expected, "{source}");
    }
}

/// Columns: who puts one blank too many asks for one; what is longer than the place asked for sticks out.
#[test]
fn columns_are_kept_put_right_and_not_made() {
    let rules: &[(&str, &str)] = &[
        ("a: 1\nlong: 2\n", "a: 1\nlong: 2\n"),
        ("a:    1\nlong: 2\n", "a:    1\nlong: 2\n"),
        // No wider than needed, and a line that was added joins.
        ("a:        1\nlong: 2\nb: 3\n", "a:    1\nlong: 2\nb:    3\n"),
        ("a:    1\nlong: 2\nmuch_longer: 3\n", "a:    1\nlong: 2\nmuch_longer: 3\n"),
        // A comment between two lines does not part them.
        ("a:    1\n// of long\nlong: 2\nb: 3\n", "a:    1\n// of long\nlong: 2\nb:    3\n"),
        // A blank line and a record of several lines part two columns.
        ("a:    1\nlong: 2\n\nb: 3\n", "a:    1\nlong: 2\n\nb: 3\n"),
        ("a:  1\nlong: {\n    c: 1\n}\n", "a: 1\nlong: {\n    c: 1\n}\n"),
        // Requirements by their comparisons; rows of a table by their cells, if all are alike.
        ("a.b        <= 1\na.longer >= 2\n", "a.b      <= 1\na.longer >= 2\n"),
        ("p: q { x: 1,   y: 2 }\np: q { x: 100, y: 2 }\n", "p: q { x: 1,   y: 2 }\np: q { x: 100, y: 2 }\n"),
        ("a: 1,   b: 2\nc: 100\n", "a: 1, b: 2\nc: 100\n"),
        // Comments that stood under each other.
        ("a:1   // x\nbc: 2 // y\n", "a: 1  // x\nbc: 2 // y\n"),
    ];
    let job = |body: &str| {
        let indented = body.lines().map(|line| if line.is_empty() { "\n".into() } else { format!("    {line}\n") });
        format!("language 1\njob a {{\n{}}}\n", indented.collect::<String>())
    };
    for (source, expected) in rules {
        assert_eq!(formatted(&job(source)), job(expected), "{source}");
    }
}

/// A file with a mistake in its syntax is refused, with the mistake; one with a warning is not.
#[test]
fn mistakes_are_refused() {
    for text in
        ["", "language 1\njob a {", "language 1\nlet a = 1/mm\n", "let a = 1\n", "language 1\nlet a = [1,, 2]\n"]
    {
        let mistakes = format(FileId(0), text).expect_err(text);
        assert!(!mistakes.is_empty() && mistakes.iter().all(|mistake| mistake.severity == Severity::Error), "{text}");
    }
    assert_eq!(formatted("language 1\n/// of nothing"), "language 1\n/// of nothing\n");
}

/// The comparison of trees sees what it is to see.
#[test]
fn trees_differ_where_meaning_does() {
    for (a, b) in [("1", "2"), ("1 mm", "1 um"), ("b / c", "b * c"), ("[1]", "1"), ("\"a b\"", "\"a  b\"")] {
        let file = |value: &str| format!("language 1\nlet a = {value}\n");
        assert!(tree(&file(a)) != tree(&file(b)), "{a} {b}");
        assert!(tree(&file(a)) == tree(&file(&format!("   {a}  // c"))), "{a}");
    }
}
