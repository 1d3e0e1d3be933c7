//! The grammar of the book is `grammar/polish.pest`, written for readers.
//!
//! `~` becomes a blank; marks that only steer the machine (`@{`, `${`, `_{`, look-ahead for the end of a word) go; a rule
//! that is one mark or one word stands where it is used.

use crate::{between, keep, read};
use std::collections::BTreeMap;
use std::path::Path;

/// Rules that a reader needs no name for, since the page says what they are in words.
const IN_WORDS: &[&str] = &["WHITESPACE", "plain_word", "word", "word_char", "keyword", "number", "text", "count"];

#[derive(Clone, Debug, PartialEq)]
enum Token {
    Text(String),
    Name(String),
    Mark(char),
}

fn tokens(body: &str) -> Vec<Token> {
    let mut found = Vec::new();
    let mut rest = body.trim_start();
    while let Some(c) = rest.chars().next() {
        let length = match c {
            '"' => {
                let mut end = 1;
                while !rest[end..].starts_with('"') {
                    end += if rest[end..].starts_with('\\') { 2 } else { 1 };
                }
                found.push(Token::Text(rest[1..end].to_string()));
                end + 1
            }
            c if c.is_alphanumeric() || c == '_' => {
                let name: String = rest.chars().take_while(|c| c.is_alphanumeric() || *c == '_').collect();
                let length = name.len();
                found.push(Token::Name(name));
                length
            }
            c => {
                found.push(Token::Mark(c));
                c.len_utf8()
            }
        };
        rest = rest[length..].trim_start();
    }
    found
}

/// Without look-ahead: `!x`, `!(…)`, and the ends of input.
fn plain(tokens: Vec<Token>) -> Vec<Token> {
    let mut kept: Vec<Token> = Vec::new();
    let mut all = tokens.into_iter().peekable();
    while let Some(token) = all.next() {
        match token {
            Token::Mark('!') => match all.next() {
                Some(Token::Mark('(')) => {
                    let mut depth = 1;
                    while depth > 0 {
                        match all.next() {
                            Some(Token::Mark('(')) => depth += 1,
                            Some(Token::Mark(')')) => depth -= 1,
                            Some(_) => {}
                            None => break,
                        }
                    }
                }
                _ => continue,
            },
            Token::Mark('~' | '^') => {}
            // A blank that may stand between a number and its unit says nothing to a reader.
            Token::Text(text) if text == " " => drop(all.next()),
            Token::Name(name) if name == "SOI" || name == "EOI" => {}
            other => kept.push(other),
        }
    }
    kept
}

/// The rules with the heading of their part of the file.
fn rules(text: &str) -> Vec<(String, String, Vec<Token>)> {
    let mut part = String::new();
    let mut found = Vec::new();
    for line in text.lines() {
        if let Some(title) = line.strip_prefix("// ---- ") {
            part = title.to_string();
        }
        let Some((name, body)) = line.split_once(" = ").filter(|_| !line.starts_with("//")) else { continue };
        let from = body.find('{').expect("a body") + 1;
        let to = body.rfind('}').expect("its end");
        found.push((part.clone(), name.trim().to_string(), plain(tokens(&body[from..to]))));
    }
    found
}

fn words(tokens: &[Token], inline: &BTreeMap<String, String>) -> String {
    let mut out = String::new();
    for token in tokens {
        let text = match token {
            Token::Text(text) => format!("\"{text}\""),
            Token::Name(name) => inline.get(name).cloned().unwrap_or_else(|| name.clone()),
            Token::Mark(c) => c.to_string(),
        };
        let tight = out.is_empty() || out.ends_with('(') || matches!(text.as_str(), ")" | "?" | "*" | "+");
        if !tight {
            out.push(' ');
        }
        out.push_str(&text);
    }
    out
}

/// The grammar for readers.
pub fn shown(text: &str) -> String {
    let rules = rules(text);
    // One word or one mark stands for itself; the brackets of an inner record or list are opaque.
    let mut inline: BTreeMap<String, String> = rules
        .iter()
        .filter(|(_, _, body)| matches!(body.as_slice(), [Token::Text(_)]))
        .map(|(_, name, body)| (name.clone(), words(body, &BTreeMap::new())))
        .collect();
    inline.extend([("block", "{}"), ("list", "[]"), ("ASCII_DIGIT", "digit")].map(|(a, b)| (a.into(), b.into())));
    let mut out = String::new();
    let mut part = "";
    for (of, name, body) in &rules {
        if inline.contains_key(name) || IN_WORDS.contains(&name.as_str()) {
            continue;
        }
        if part != of {
            if !out.is_empty() {
                out.push('\n');
            }
            out.push_str(&format!("; {of}\n"));
            part = of;
        }
        out.push_str(&format!("{name} = {}\n", words(body, &inline)));
    }
    out
}

#[test]
fn the_grammar_of_the_book_is_the_grammar() {
    let path = Path::new("docs/reference/grammar.md");
    let grammar = shown(&read(Path::new("grammar/polish.pest")));
    keep(path, &between(&read(path), "```text\n", "```", &grammar), "the grammar");
}

#[test]
fn rules_are_written_for_readers() {
    let text =
        "// ---- items\n\nuse_item = { use_word ~ (text | module_path)? }\nuse_word = @{ \"use\" ~ !word_char }\n";
    assert_eq!(shown(text), "; items\nuse_item = \"use\" (text | module_path)?\n");
}
