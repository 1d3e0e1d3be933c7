//! Blocks of code in a page.

use std::ops::Range;

/// A fenced block.
#[derive(Clone, Debug)]
pub struct Block {
    /// First word of the mark: the language.
    pub language: String,
    /// Its other words, each with what stands in its parentheses.
    pub words: Vec<(String, String)>,
    /// The block's lines, without those of the fence.
    pub text: String,
    /// Where `text` stands in the page.
    pub range: Range<usize>,
    /// Line of the fence, from 1.
    pub line: usize,
}

impl Block {
    /// What stands in the parentheses of a word of the mark; empty without them.
    pub fn word(&self, word: &str) -> Option<&str> {
        self.words.iter().find(|(name, _)| name == word).map(|(_, value)| value.as_str())
    }
}

/// The blocks of a page, in order. A fence may be indented, as in a list; then so are its lines.
pub fn blocks(page: &str) -> Vec<Block> {
    let mut found = Vec::new();
    let mut open: Option<(usize, &str, usize, usize)> = None;
    let mut at = 0;
    for (i, line) in page.split_inclusive('\n').enumerate() {
        let bare = line.trim_end();
        let indent = bare.len() - bare.trim_start().len();
        let start = at;
        at += line.len();
        match open {
            None => {
                if let Some(mark) = bare.trim_start().strip_prefix("```") {
                    open = Some((indent, mark, i + 1, at));
                }
            }
            Some((indent, mark, line, from)) if bare.trim_start() == "```" => {
                let text: Vec<&str> =
                    page[from..start].lines().map(|line| line.get(indent..).unwrap_or("").trim_end()).collect();
                let mut words = split(mark).into_iter();
                let language = words.next().map_or_else(String::new, |(word, _)| word);
                let mut text = text.join("\n");
                text.push('\n');
                found.push(Block { language, words: words.collect(), text, range: from..start, line });
                open = None;
            }
            Some(_) => {}
        }
    }
    assert!(open.is_none(), "a block of code is not closed");
    found
}

/// `polish,fragment(a.b),plan` as its words.
fn split(mark: &str) -> Vec<(String, String)> {
    mark.split(',')
        .map(|word| match word.trim().split_once('(') {
            Some((name, rest)) => (name.to_string(), rest.trim_end_matches(')').to_string()),
            None => (word.trim().to_string(), String::new()),
        })
        .collect()
}
