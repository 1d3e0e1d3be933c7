//! The description: `main.xml` as a list of paths and texts.
//!
//! Entities and document types are refused: no instrument writes them, and they can make a short text endless.

use crate::diagnostics::Problem;
use crate::height_map::refusals::{container, impossible, sizes};
use crate::height_map::{MOST_PIXELS, text};
use quick_xml::Reader;
use quick_xml::events::Event;
use std::collections::BTreeMap;

/// How deep elements may stand in each other; the standard's own are six deep.
const DEEPEST: usize = 32;

/// Stands in a text for what was not read there: no number and no path has it, so that a shortened one is not taken for whole.
const LEFT_OUT: char = '\u{FFFD}';

/// Longest name of an element, bytes: the standard's longest has 18. Names of open elements are joined for every element, so that
/// long ones would fill the memory.
const LONGEST_NAME: usize = 100;

fn own_name(element: &str, name: &str) -> Result<String, Problem> {
    if element.len() > LONGEST_NAME {
        return Err(container(name, "has a `main.xml` with names that no instrument writes"));
    }
    Ok(element.to_string())
}

/// Adds to an element's text, or marks that more stands there than is read.
fn take(content: &mut String, words: &str) {
    if content.len() + words.len() <= LONGEST {
        content.push_str(words);
    } else if !content.ends_with(LEFT_OUT) {
        content.push(LEFT_OUT);
    }
}

/// Longest text of an element that is kept; a path in the archive, a checksum, a number.
const LONGEST: usize = 1000;

/// Most elements that are kept beside the heights; the standard knows about sixty.
const MOST_ELEMENTS: usize = 10_000;

/// Texts by the path of their element below the root: `Record1/Axes/CX/Increment`.
pub(super) struct Description {
    texts: BTreeMap<String, String>,
    /// The heights of a file that says them as text.
    pub heights: Vec<f64>,
}

impl Description {
    pub fn of(bytes: &[u8], name: &str) -> Result<Description, Problem> {
        let damaged = || container(name, "has a `main.xml` that is no XML");
        let text = text::decode(bytes).ok_or_else(damaged)?;
        let mut reader = Reader::from_str(&text);
        let mut found = Description { texts: BTreeMap::new(), heights: Vec::new() };
        // Names of the elements that are open, the root first.
        let mut open: Vec<String> = Vec::new();
        let mut content = String::new();
        let mut finished = false;
        loop {
            match reader.read_event().map_err(|_| damaged())? {
                Event::Start(element) => {
                    if open.len() == DEEPEST {
                        return Err(container(name, "has a `main.xml` with elements within elements without end"));
                    }
                    open.push(own_name(element.local_name().as_ref(), name)?);
                    content.clear();
                }
                Event::Empty(element) => {
                    open.push(own_name(element.local_name().as_ref(), name)?);
                    found.keep(&open, "", name)?;
                    open.pop();
                }
                Event::Text(words) => {
                    let words = words.into_inner();
                    take(&mut content, &words);
                }
                Event::CData(words) => {
                    let words = words.into_inner();
                    take(&mut content, &words);
                }
                Event::End(_) => {
                    found.keep(&open, &content, name)?;
                    content.clear();
                    open.pop();
                    finished |= open.is_empty();
                }
                Event::DocType(_) => {
                    return Err(container(name, "has a `main.xml` with a document type, which may define anything"));
                }
                // The five of XML itself stand in remarks of people; what an entity stands for is never read.
                Event::GeneralRef(entity) => {
                    let entity = entity.into_inner();
                    if !matches!(&entity[..], "lt" | "gt" | "amp" | "quot" | "apos") && !entity.starts_with('#') {
                        return Err(container(name, "has a `main.xml` with entities of its own"));
                    }
                    content.push(LEFT_OUT);
                }
                Event::Comment(_) | Event::Decl(_) | Event::PI(_) => {}
                Event::Eof => break,
            }
        }
        if !finished || !open.is_empty() {
            return Err(sizes(name, "has a `main.xml` that ends too soon"));
        }
        Ok(found)
    }

    fn keep(&mut self, open: &[String], content: &str, name: &str) -> Result<(), Problem> {
        let path = open[1..].join("/");
        if path == "Record3/DataList/Datum" {
            if self.heights.len() as u64 == MOST_PIXELS {
                return Err(sizes(name, format!("has more heights than the {MOST_PIXELS} that are read")));
            }
            // Incremental axes before the height may leave their places empty: `;;1.5e-7`.
            let word = content.rsplit(';').next().unwrap_or("").trim();
            let height = text::number(word).or_else(|| text::is_no_data(word).then_some(f64::NAN));
            let Some(height) = height else {
                let count = self.heights.len() + 1;
                return Err(impossible(name, format!("has `{}` for its height {count}", text::shown(word))));
            };
            self.heights.push(height);
            return Ok(());
        }
        if self.texts.len() == MOST_ELEMENTS {
            return Err(container(name, "has a `main.xml` with more elements than a description has"));
        }
        // Of elements that may stand several times, remarks and the like, the first is kept; none of them is asked for.
        self.texts.entry(path).or_insert_with(|| content.trim().to_string());
        Ok(())
    }

    /// Whether there is such an element.
    pub fn has(&self, path: &str) -> bool {
        self.texts.contains_key(path)
    }

    /// The text of an element, if it has one.
    pub fn text(&self, path: &str) -> Option<&str> {
        self.texts.get(path).map(String::as_str).filter(|text| !text.is_empty())
    }

    /// The number in an element, if there is one. E0504 for what is none.
    pub fn number(&self, path: &str, name: &str) -> Result<Option<f64>, Problem> {
        let Some(word) = self.text(path) else { return Ok(None) };
        match text::number(word) {
            Some(number) => Ok(Some(number)),
            None => Err(impossible(name, format!("says `{}` for `{path}`, which is no number", text::shown(word)))),
        }
    }
}
