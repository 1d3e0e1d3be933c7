//! Mutations: every field, item, list element and block of every example, changed in the ways that hands slip. Each is
//! one error, at its place, and nothing else is said.
//!
//! The generator reads the tree of the sources and the schemas of stdlib; it knows nothing of what the compiler answers.
//! A change that leaves a right job (an optional field left out, another serial number) must say nothing at all.
#![allow(clippy::disallowed_methods, reason = "tests read the tree's own files")]

use polishc::check::typed::{Typed, TypedKind};
use polishc::check::types::{Field, Limit, SchemaId, Type, Vocabulary};
use polishc::diagnostics::{Diagnostic, Severity};
use polishc::eval::{self, Options};
use polishc::source::{FileId, MemoryFiles, Span};
use polishc::syntax;
use polishc::syntax::ast::{Ast, BinaryOp, Block, Entry, EntryKind, Expr, ExprKind, ItemKind, Name, UnaryOp, UsePath};
use std::collections::BTreeMap;
use std::ops::Range;
use std::sync::Mutex;

/// What a mutation must lead to.
#[derive(Clone, Debug, PartialEq)]
enum Expected {
    /// One error whose primary place lies in these bytes of the mutated file.
    Inside(Range<usize>),
    /// One error inside the bytes, or at a place that uses this name, whose definition the mutation took away.
    InsideOrAtUseOf(Range<usize>, String),
    /// Still a right job: nothing is said, or one warning inside the bytes.
    Right(Range<usize>),
    /// Nothing is said, or one thing inside the bytes: a right job by its types, perhaps not by its numbers.
    RightOrInside(Range<usize>),
}

/// A file with one change.
struct Mutation {
    kind: &'static str,
    file: String,
    text: String,
    expected: Expected,
}

/// The texts of one folder.
struct Project {
    job: String,
    texts: BTreeMap<String, String>,
}

/// Every job of the examples, and of the jobs that other tests share, with the files beside it.
fn projects() -> Vec<Project> {
    let mut folders: Vec<String> = std::fs::read_dir("examples")
        .expect("examples")
        .map(|entry| entry.expect("an entry").path())
        .filter(|path| path.is_dir())
        .map(|path| path.to_string_lossy().replace('\\', "/"))
        .collect();
    folders.push("tests/jobs".into());
    folders.sort();
    let mut projects = Vec::new();
    for folder in folders {
        let mut texts = BTreeMap::new();
        for entry in std::fs::read_dir(&folder).expect("a folder") {
            let path = entry.expect("an entry").path();
            if path.extension().is_some_and(|e| e == "polish") {
                let name = path.file_name().expect("a name").to_string_lossy().into_owned();
                let text = std::fs::read_to_string(&path).expect("text");
                // What a person would give by `--set` stands in the text here, so that the name can be mutated too.
                let text = text.lines().map(given).collect::<Vec<_>>().join("\n") + "\n";
                texts.insert(format!("{folder}/{name}"), text);
            }
        }
        let jobs: Vec<String> = texts.keys().filter(|path| holds_job(&texts[*path])).cloned().collect();
        for job in jobs {
            // The job, and what it takes in.
            let mut own = texts.clone();
            own.retain(|path, _| {
                let name = path.rsplit('/').next().unwrap_or_default();
                *path == job || texts[&job].contains(&format!("use \"{name}\""))
            });
            projects.push(Project { job, texts: own });
        }
    }
    projects
}

fn given(line: &str) -> String {
    let open = line.starts_with("param ") && line.contains(": File") && !line.contains('=');
    if open { format!("{line} = \"given.dat\"") } else { line.to_string() }
}

fn holds_job(text: &str) -> bool {
    text.lines().any(|line| line.starts_with("job "))
}

fn range(span: Span) -> Range<usize> {
    span.start as usize..span.end as usize
}

/// Walks the tree of one file and changes each of its parts.
struct Generator<'a> {
    vocabulary: &'a Vocabulary,
    path: &'a str,
    text: &'a str,
    mutations: Vec<Mutation>,
}

impl<'a> Generator<'a> {
    /// The text with `place` replaced, and where the replacement lies.
    fn replaced(&self, place: &Range<usize>, by: &str) -> (String, Range<usize>) {
        let text = format!("{}{by}{}", &self.text[..place.start], &self.text[place.end..]);
        (text, place.start..place.start + by.len())
    }

    fn push(&mut self, kind: &'static str, text: String, expected: Expected) {
        self.mutations.push(Mutation { kind, file: self.path.to_string(), text, expected });
    }

    /// `place` replaced; the error must lie in `around`, which holds `place` and is given in bytes of the old text.
    fn replace(&mut self, kind: &'static str, place: &Range<usize>, by: &str, around: &Range<usize>) {
        let (text, _) = self.replaced(place, by);
        let grown = around.start..(around.end + by.len()) - (place.end - place.start);
        self.push(kind, text, Expected::Inside(grown));
    }

    fn slice(&self, span: Span) -> &'a str {
        &self.text[range(span)]
    }

    /// The bytes of an entry with the comma or the newline that ends it.
    fn with_end(&self, place: &Range<usize>) -> Range<usize> {
        let rest = &self.text[place.end..];
        let blanks = rest.len() - rest.trim_start_matches(' ').len();
        let end = match rest[blanks..].chars().next() {
            Some(',') => place.end + blanks + 1,
            _ => place.end,
        };
        place.start..end
    }

    /// One letter changed, left out, doubled.
    fn misspellings(&self, word: &str) -> Vec<(&'static str, String)> {
        let letters: Vec<char> = word.chars().collect();
        let middle = letters.len() / 2;
        let with = |kind, new: Vec<char>| (kind, new.into_iter().collect::<String>());
        let mut changed = letters.clone();
        changed[middle] = if letters[middle] == 'q' { 'z' } else { 'q' };
        let mut doubled = letters.clone();
        doubled.insert(middle, letters[middle]);
        let mut words = vec![with("misspelt: a letter changed", changed), with("misspelt: a letter doubled", doubled)];
        if letters.len() > 1 {
            let mut short = letters.clone();
            short.remove(middle);
            words.push(with("misspelt: a letter left out", short));
        }
        words.retain(|(_, new)| new != word);
        words
    }

    fn file(&mut self, ast: &Ast) {
        for item in &ast.items {
            let whole = range(item.span);

            match &item.kind {
                ItemKind::Use(used) => {
                    let brought = match used {
                        UsePath::Module(words) => words.last().expect("a word").text.clone(),
                        UsePath::File { path, .. } => {
                            let stem = path.rsplit('/').next().unwrap_or(path);
                            stem.trim_end_matches(".polish").to_string()
                        }
                    };
                    self.lost("item dropped", &whole, "", &brought);
                    self.doubled_line("item doubled", &whole);
                    match used {
                        UsePath::Module(words) => {
                            for word in words {
                                self.misspell(word.span, &range(words[0].span.to(words[words.len() - 1].span)));
                            }
                        }
                        UsePath::File { path, span } => {
                            let place = range(*span);
                            for (kind, new) in self.misspellings(path) {
                                self.replace(kind, &place, &format!("\"{new}\""), &place);
                            }
                            self.replace("quotes forgotten", &place, path, &whole);
                        }
                    }
                    self.keyword(&whole, "use", Some(&brought));
                }
                ItemKind::Let { name, value, .. } => {
                    self.named_item(&whole, name);
                    self.value(value, None, &range(value.span));
                    self.keyword(&(name.span.start as usize - 4..whole.end), "let", Some(&name.text));
                }
                ItemKind::Param { name, value, .. } => {
                    self.named_item(&whole, name);
                    if let Some(value) = value {
                        self.value(value, None, &range(value.span));
                    }
                    self.keyword(&whole, "param", Some(&name.text));
                }
                ItemKind::Job { name, body } => {
                    let job = self.vocabulary.find_schema("job").expect("the schema of jobs");
                    self.keyword(&whole, "job", None);
                    self.doubled_line("item doubled", &whole);
                    // The name is the job's own: any other is as good.
                    self.block(body, Some(job), &range(name.span));
                }
                _ => {}
            }
        }
    }

    /// What others use by `name` is gone.
    fn lost(&mut self, kind: &'static str, place: &Range<usize>, by: &str, name: &str) {
        let (text, at) = self.replaced(place, by);
        self.push(kind, text, Expected::InsideOrAtUseOf(at, name.to_string()));
    }

    fn doubled_line(&mut self, kind: &'static str, place: &Range<usize>) {
        let again = format!("{0}\n{0}", &self.text[place.clone()]);
        let (text, at) = self.replaced(place, &again);
        let second = at.start + (place.end - place.start) + 1;
        self.push(kind, text, Expected::Inside(second..at.end));
    }

    fn named_item(&mut self, whole: &Range<usize>, name: &Name) {
        // Its doc comment goes with it.
        let mut start = whole.start;
        while let Some(line) = self.text[..start].strip_suffix('\n').and_then(|above| above.rfind('\n'))
            && self.text[line + 1..start].starts_with("///")
        {
            start = line + 1;
        }
        self.lost("item dropped", &(start..whole.end), "", &name.text);
        self.doubled_line("item doubled", whole);
        for (kind, new) in self.misspellings(&name.text) {
            self.lost(kind, &range(name.span), &new, &name.text);
        }
    }

    fn keyword(&mut self, whole: &Range<usize>, word: &str, brought: Option<&str>) {
        let place = whole.start..whole.start + word.len();
        assert_eq!(&self.text[place.clone()], word);
        let line = self.text[whole.start..].find('\n').map_or(whole.end, |at| whole.start + at);
        for (kind, new) in self.misspellings(word) {
            match brought {
                Some(name) => {
                    let (text, _) = self.replaced(&place, &new);
                    let around = whole.start..line + new.len() - word.len();
                    self.push(kind, text, Expected::InsideOrAtUseOf(around, name.to_string()));
                }
                None => self.replace(kind, &place, &new, &(whole.start..line)),
            }
        }
    }

    fn misspell(&mut self, place: Span, around: &Range<usize>) {
        for (kind, new) in self.misspellings(self.slice(place)) {
            self.replace(kind, &range(place), &new, around);
        }
    }

    /// A unit with a slip in it. What is then another unit of the same dimension, `m` for `mm`, is a right job as far as
    /// names and types can tell: at most a warning that the value is unusual.
    fn misspelt_unit(&mut self, place: Span, around: &Range<usize>) {
        let old = self.vocabulary.units.unit(self.slice(place)).map(|unit| unit.dimension());
        for (kind, new) in self.misspellings(self.slice(place)) {
            match self.vocabulary.units.unit(&new) {
                Some(unit) if Some(unit.dimension()) == old => {
                    let (text, _) = self.replaced(&range(place), &new);
                    let grown = around.start..(around.end + new.len()) - range(place).len();
                    self.push("another unit of the same dimension", text, Expected::RightOrInside(grown));
                }
                _ => self.replace(kind, &range(place), &new, around),
            }
        }
    }

    /// A block's entries and its brackets. `head` is what a missing field is reported at.
    fn block(&mut self, block: &Block, schema: Option<SchemaId>, head: &Range<usize>) {
        let (open, close) = (block.span.start as usize, block.span.end as usize - 1);
        let said = head.start..open + 1;
        // An unclosed bracket is reported at the opener; a missing opener where it is missed or at what it leaves over. Of
        // several brackets that one line opens or closes, nobody can tell which is the one.
        let line = line_start(self.text, open);
        let openers = if self.text[open..close].contains('\n') { open } else { line };
        let line_end = line_end(self.text, close);
        self.push("bracket dropped", self.replaced(&(close..close + 1), "").0, Expected::Inside(openers..open + 1));
        self.push("bracket dropped", self.replaced(&(open..open + 1), "").0, Expected::Inside(line..close));
        self.push("bracket doubled", self.replaced(&(close..close + 1), "}}").0, Expected::Inside(close..line_end + 1));
        self.push("bracket doubled", self.replaced(&(open..open + 1), "{{").0, Expected::Inside(line..open + 2));
        for entry in &block.entries {
            match &entry.kind {
                EntryKind::Field { name, value } if schema.is_some() || name.text == "require" => {
                    self.field(entry, name, value, schema, &said);
                }
                EntryKind::Field { .. } => {}
                EntryKind::Expr(expr) => self.condition(expr),
            }
        }
    }

    fn field(&mut self, entry: &Entry, name: &Name, value: &Expr, schema: Option<SchemaId>, said: &Range<usize>) {
        let vocabulary = self.vocabulary;
        let field = schema.and_then(|schema| vocabulary.schema(schema).field(&name.text));
        let (whole, called) = (range(entry.span), range(name.span));
        let short = name.span == value.span || value.span.start == name.span.start;
        // Left out, twice.
        let without = self.with_end(&whole);
        let (text, _) = self.replaced(&without, "");
        let states_wave = name.text == "wavelength" && self.text.contains(" wave ");
        match field {
            // `wave` needs it: said where it is used.
            _ if states_wave => self.push("field dropped", text, Expected::InsideOrAtUseOf(0..0, "wave".into())),
            Some(field) if field.is_required() => self.push("field dropped", text, Expected::Inside(said.clone())),
            _ => self.push("field dropped", text, Expected::Right(said.clone())),
        }
        self.doubled_line("field doubled", &whole);
        for (kind, new) in self.misspellings(&name.text) {
            // In the short form `workpiece { … }` the one word is both names.
            let (text, at) = self.replaced(&called, &new);
            self.push(kind, text, Expected::Inside(at));
        }
        if short {
            if let ExprKind::Record { schema: Some(_), body } = &value.kind {
                let inner = vocabulary.find_schema(&name.text);
                self.block(body, inner, &called);
                if name.text != "require" {
                    self.emptied(body, inner, &called);
                }
            }
            return;
        }
        // The slips around the colon.
        let colon = called.end..called.end + self.text[called.end..].find(':').expect("a colon") + 1;
        let line = whole.start..whole.end;
        match &value.kind {
            // `load { … }` is the short form.
            ExprKind::Record { schema: None, .. } if is_short_form(vocabulary, field, name) => {
                self.push("colon dropped", self.replaced(&colon, " ").0, Expected::Right(0..0));
            }
            _ => self.replace("colon dropped", &colon, " ", &line),
        }
        self.replace("`=` for `:`", &colon, " =", &line);
        self.replace("value dropped", &range(value.span), "", &line);
        self.replace("name dropped", &(called.start..colon.end), "", &(said.start..whole.end));
        self.value(value, field, &line);
    }

    /// `frame { … }` with nothing in it.
    fn emptied(&mut self, body: &Block, schema: Option<SchemaId>, head: &Range<usize>) {
        let Some(schema) = schema else { return };
        let required = self.vocabulary.schema(schema).fields.iter().any(Field::is_required);
        let (text, _) = self.replaced(&range(body.span), "{}");
        let said = head.start..body.span.start as usize + 1;
        self.push("block emptied", text, if required { Expected::Inside(said) } else { Expected::Right(said) });
    }

    /// A value, of the field's type if that is known. `line` is the field around it.
    fn value(&mut self, value: &Expr, field: Option<&'a Field>, line: &Range<usize>) {
        self.typed(value, field.map(|field| field.ty.required()), field, line);
    }

    fn typed(&mut self, value: &Expr, ty: Option<&'a Type>, field: Option<&'a Field>, line: &Range<usize>) {
        let place = range(value.span);
        let known = ty.is_some();
        match &value.kind {
            ExprKind::Number(_) => {
                if known {
                    self.replace("unit on a plain number", &place, &format!("{} mm", self.slice(value.span)), &place);
                    self.replace("text for a number", &place, "\"seven\"", &place);
                }
                self.outside_limits(value, field);
            }
            ExprKind::Quantity { unit, .. } => {
                let unit_text = self.slice(unit.span);
                let number = &self.text[place.start..unit.span.start as usize];
                self.misspelt_unit(unit.span, &place);
                if !known {
                    return;
                }
                if unit_text == "%" {
                    self.replace("wrong dimension", &range(unit.span), "kg", &place);
                } else {
                    self.replace("plain number", &place, number.trim_end(), &place);
                    let other = if unit_text.starts_with("kg") { "mm" } else { "kg" };
                    self.replace("wrong dimension", &range(unit.span), other, &place);
                    for wrong in relatives(unit_text) {
                        self.replace("wrong unit of the family", &range(unit.span), &wrong, &place);
                    }
                }
                self.replace("text for a quantity", &place, &format!("\"{}\"", self.slice(value.span)), &place);
                self.outside_limits(value, field);
            }
            ExprKind::Unary(UnaryOp::Minus, inner) => {
                // The place of a negative number is the whole of it.
                let before = self.mutations.len();
                self.typed(inner, ty, None, line);
                for mutation in &mut self.mutations[before..] {
                    if let Expected::Inside(place) | Expected::RightOrInside(place) = &mut mutation.expected {
                        place.start = place.start.min(value.span.start as usize);
                    }
                }
            }
            ExprKind::Text(text) => {
                self.replace("symbol for a text", &place, "some_word", &place);
                self.replace("number for a text", &place, "7", &place);
                self.replace("quotes forgotten", &place, text, line);
                let open = self.replaced(&(place.end - 1..place.end), "").0;
                self.push("quote dropped", open, Expected::Inside(place.start..line_end(self.text, place.start)));
            }
            ExprKind::Name(word) => {
                self.misspell(value.span, &place);
                if known {
                    let quoted = format!("\"{word}\"");
                    match ty {
                        // A file's name in quotes is a file's name.
                        Some(Type::File | Type::Text) => {
                            let (text, at) = self.replaced(&place, &quoted);
                            self.push("text for a word", text, Expected::Right(at));
                        }
                        _ => self.replace("text for a word", &place, &quoted, &place),
                    }
                    self.replace("number for a word", &place, "7", &place);
                }
            }
            ExprKind::Member(base, name) => {
                self.misspell(base.span, &place);
                self.misspell(name.span, &place);
                self.replace("member dropped", &place, self.slice(base.span), &place);
            }
            ExprKind::Range(from, to) => {
                let element = match ty {
                    Some(Type::Range(element)) => Some(&**element),
                    _ => None,
                };
                self.typed(from, element, None, line);
                self.typed(to, element, None, line);
                if known {
                    let swapped = format!("{} .. {}", self.slice(to.span), self.slice(from.span));
                    self.replace("range upside down", &place, &swapped, &place);
                    self.replace("end of a range dropped", &place, self.slice(from.span), &place);
                    let dots = from.span.end as usize..to.span.start as usize;
                    self.replace("`to` for `..`", &dots, " to ", line);
                    self.replace("end of a range left out", &(dots.end..place.end), "", line);
                }
            }
            ExprKind::List(elements, _) => self.list(value, elements, ty, field, line),
            ExprKind::Record { schema, body } => {
                let wanted = match (schema, ty) {
                    (Some(name), _) => self.vocabulary.find_schema(&name.text),
                    (None, Some(Type::Schema(schema))) => Some(*schema),
                    _ => None,
                };
                let open = body.span.start as usize;
                let head = schema.as_ref().map_or(open..open + 1, |name| range(name.span));
                if let Some(name) = schema {
                    self.misspell(name.span, &range(name.span));
                    // The kind is said where a family has several; a field of one schema needs no name.
                    let (text, _) = self.replaced(&(head.start..open), "");
                    match ty {
                        Some(Type::Schema(_)) => self.push("kind dropped", text, Expected::Right(0..0)),
                        _ => self.push("kind dropped", text, Expected::Inside(line.start..head.start + 1)),
                    }
                    if known {
                        let other = if name.text == "circle" { "raster" } else { "circle" };
                        self.replace("wrong kind", &head, other, &head);
                    }
                }
                self.emptied(body, wanted, &head);
                if known {
                    self.replace("number for a record", &place, "7", &place);
                }
                self.block(body, wanted, &head);
            }
            ExprKind::With(base, body) => {
                self.typed(base, None, None, line);
                let schema = match ty {
                    Some(Type::Schema(schema)) => Some(*schema),
                    _ => None,
                };
                // What `with` leaves out, the record before it has.
                let before = self.mutations.len();
                self.block(body, schema, &range(base.span));
                let kept = self.mutations.split_off(before).into_iter().filter(|m| m.kind != "field dropped");
                self.mutations.extend(kept);
            }
            ExprKind::Binary(_, _, a, b) => {
                self.typed(a, None, None, line);
                self.typed(b, None, None, line);
            }
            _ => {}
        }
    }

    fn list(
        &mut self,
        value: &Expr,
        elements: &[Expr],
        ty: Option<&'a Type>,
        field: Option<&'a Field>,
        line: &Range<usize>,
    ) {
        let place = range(value.span);
        let (element, length) = match ty {
            Some(Type::List(element, length)) => (Some(&**element), *length),
            _ => (None, None),
        };
        let symbols = matches!(element, Some(Type::Symbols(_)));
        for expr in elements {
            let whole = range(expr.span);
            let without = self.with_end(&whole);
            let (text, _) = self.replaced(&without, "");
            if let Some(Type::List(..)) = ty {
                let shorter =
                    if length.is_some() { Expected::Inside(place.clone()) } else { Expected::Right(place.clone()) };
                self.push("element dropped", text, shorter);
                let twice = format!("{0}, {0}", self.slice(expr.span));
                let (text, at) = self.replaced(&whole, &twice);
                let longer = place.start..place.end + at.len() - whole.len();
                // A set holds a word once; a list of values may repeat one.
                let expected =
                    if length.is_some() || symbols { Expected::Inside(longer) } else { Expected::Right(longer) };
                self.push("element doubled", text, expected);
                let commas = if without.end > whole.end { "," } else { ",," };
                self.replace("comma doubled", &(whole.end..whole.end), commas, line);
            }
            // The list's limits speak of each element.
            self.typed(expr, element, if matches!(element, Some(Type::List(..))) { None } else { field }, line);
        }
        if let (Some(first), Some(last)) = (elements.first(), elements.last()) {
            let inner = &self.text[first.span.start as usize..last.span.end as usize];
            if known_list(ty) && elements.len() == 1 {
                self.replace("list brackets dropped", &place, inner, &place);
            }
            let close = self.text[..place.end].rfind(']').expect("a closer");
            let open = place.start..place.start + 1;
            self.push("bracket dropped", self.replaced(&(close..close + 1), "").0, Expected::Inside(open.clone()));
            self.push("bracket dropped", self.replaced(&open, "").0, Expected::Inside(line.start..close));
        }
    }

    /// Beyond the field's `where`, or else beyond its `usual`.
    fn outside_limits(&mut self, value: &Expr, field: Option<&Field>) {
        let Some(field) = field else { return };
        let (place, text) = (range(value.span), self.slice(value.span));
        let digits = text.len() - text.trim_start_matches(|c: char| c.is_ascii_digit() || c == '.').len();
        let unit = text[digits..].trim();
        let size = match &value.kind {
            ExprKind::Quantity { unit, .. } if unit.factors.iter().all(|(name, _)| fixed(self.vocabulary, name)) => {
                size_of(self.vocabulary, &unit.factors)
            }
            ExprKind::Number(_) => 1.0,
            _ => return,
        };
        for number in ["-123456789000", "123456789000"] {
            let si = number.parse::<f64>().expect("a number") * size;
            let allowed = |limit: &Option<Limit>| limit.as_ref().is_none_or(|limit| keeps(limit, si));
            let new = format!("{number} {unit}");
            let (changed, at) = self.replaced(&place, new.trim_end());
            if !allowed(&field.restriction) {
                self.push("value outside its limits", changed, Expected::Inside(at));
            } else if !allowed(&field.usual) {
                self.push("value that is unusual", changed, Expected::RightOrInside(at));
            }
        }
    }

    /// A line of `require`.
    fn condition(&mut self, expr: &Expr) {
        let ExprKind::Binary(operator, at, left, right) = &expr.kind else { return };
        let place = range(expr.span);
        if !matches!(
            operator,
            BinaryOp::Less | BinaryOp::LessEqual | BinaryOp::Greater | BinaryOp::GreaterEqual | BinaryOp::Equal
        ) {
            return;
        }
        let mut results: Vec<Name> = Vec::new();
        let mut inner: &Expr = left;
        while let ExprKind::Member(base, name) = &inner.kind {
            results.push(name.clone());
            inner = base;
        }
        for name in &results {
            self.misspell(name.span, &place);
        }
        self.misspell(inner.span, &place);
        self.replace("operator dropped", &range(*at), "", &place);
        self.replace("`=` for a comparison", &range(*at), "=", &place);
        self.replace("side dropped", &range(right.span), "", &place);
        self.replace("condition without its comparison", &place, self.slice(left.span), &place);
        let (text, _) = self.replaced(&self.with_end(&place), "");
        self.push("condition dropped", text, Expected::Right(0..0));
        if let ExprKind::Quantity { unit, .. } = &right.kind {
            let number = self.text[right.span.start as usize..unit.span.start as usize].trim_end();
            self.replace("plain number", &range(right.span), number, &place);
            let other = if self.slice(unit.span) == "kg" { "mm" } else { "kg" };
            self.replace("wrong dimension", &range(unit.span), other, &place);
            self.misspelt_unit(unit.span, &place);
        }
    }
}

/// Whether field and schema share a name.
fn is_short_form(vocabulary: &Vocabulary, field: Option<&Field>, name: &Name) -> bool {
    matches!(field.map(|field| field.ty.required()), Some(Type::Schema(schema)) if vocabulary.schema(*schema).name == name.text)
}

fn known_list(ty: Option<&Type>) -> bool {
    matches!(ty, Some(Type::List(..)))
}

fn line_start(text: &str, at: usize) -> usize {
    text[..at].rfind('\n').map_or(0, |newline| newline + 1)
}

fn line_end(text: &str, from: usize) -> usize {
    text[from..].find('\n').map_or(text.len(), |at| from + at)
}

/// Units of the same family as the dimension is written, and of another dimension: `mm/s` for `mm/s^2`.
fn relatives(unit: &str) -> Vec<String> {
    let mut others = vec![format!("{unit}*{}", unit.split(['/', '*', '^']).next().unwrap_or(unit))];
    match unit.split_once('/') {
        Some((above, "s")) => others.extend([above.to_string(), format!("{above}/s^2")]),
        Some((above, _)) => others.extend([above.to_string(), format!("{above}/s")]),
        None if unit == "rpm" => others.push("Hz".to_string()),
        None => others.push(format!("{unit}/h")),
    }
    others.retain(|other| !other.contains("**"));
    // A unit has one `/`, at its end.
    others.into_iter().map(|other| in_order(&other)).collect()
}

/// `mm/s*mm` is written `mm*mm/s`.
fn in_order(unit: &str) -> String {
    match unit.split_once('/') {
        Some((above, rest)) => match rest.split_once('*') {
            Some((below, more)) => format!("{above}*{more}/{below}"),
            None => unit.to_string(),
        },
        None => unit.to_string(),
    }
}

fn fixed(vocabulary: &Vocabulary, name: &Name) -> bool {
    matches!(vocabulary.units.unit(&name.text), Some(polishc::units::UnitMeaning::Fixed { .. }))
}

fn size_of(vocabulary: &Vocabulary, factors: &[(Name, i32)]) -> f64 {
    factors.iter().fold(1.0, |size, (name, power)| match vocabulary.units.unit(&name.text) {
        Some(polishc::units::UnitMeaning::Fixed { factor, .. }) => size * libm::pow(factor, f64::from(*power)),
        _ => size,
    })
}

/// Whether a number in SI keeps to a limit of a schema.
fn keeps(limit: &Limit, value: f64) -> bool {
    limit.bounds.iter().all(|(operator, bound)| {
        let Some(bound) = constant(bound) else { return true };
        match operator {
            BinaryOp::Less => value < bound,
            BinaryOp::LessEqual => value <= bound,
            BinaryOp::Greater => value > bound,
            _ => value >= bound,
        }
    })
}

fn constant(typed: &Typed) -> Option<f64> {
    match &typed.kind {
        TypedKind::Number(value, unit) => Some(value * unit.as_ref().map_or(1.0, |unit| unit.factor)),
        TypedKind::Minus(inner) => constant(inner).map(|value| -value),
        _ => None,
    }
}

/// What is wrong with the answer to a mutation, if anything.
fn judge(project: &Project, mutation: &Mutation) -> Option<String> {
    let mut texts = project.texts.clone();
    texts.insert(mutation.file.clone(), mutation.text.clone());
    let files = MemoryFiles(texts.into_iter().map(|(path, text)| (path, text.into_bytes())).collect());
    let compiled = eval::compile(&files, &project.job, &Options::default());
    let said: Vec<String> = compiled
        .diagnostics
        .iter()
        .map(|d| {
            let place = d.primary.as_ref().map_or_else(String::new, |label| {
                let (line, column) = compiled.sources.line_column(label.span.file, label.span.start as usize);
                let text: String = compiled.sources.slice(label.span).chars().take(30).collect();
                format!("{}:{line}:{column} `{text}`", compiled.sources.name(label.span.file))
            });
            format!("{} {place} {}", d.code, d.message)
        })
        .collect();
    let inside = |d: &Diagnostic, place: &Range<usize>| {
        d.primary.as_ref().is_some_and(|label| {
            compiled.sources.name(label.span.file) == mutation.file
                && place.start <= label.span.start as usize
                && label.span.end as usize <= place.end.max(place.start)
        })
    };
    let uses = |d: &Diagnostic, name: &str| {
        d.primary.as_ref().is_some_and(|label| compiled.sources.slice(label.span).contains(name))
    };
    let good = match (&mutation.expected, compiled.diagnostics.as_slice()) {
        (Expected::Inside(place), [one]) => one.severity == Severity::Error && inside(one, place),
        (Expected::InsideOrAtUseOf(place, name), [one]) => {
            one.severity == Severity::Error && (inside(one, place) || uses(one, name))
        }
        (Expected::Right(_) | Expected::RightOrInside(_), []) => true,
        (Expected::RightOrInside(place), [one]) => inside(one, place),
        (Expected::Right(place), [one]) => one.severity == Severity::Warning && inside(one, place),
        _ => false,
    };
    if good {
        return None;
    }
    let change = changed_line(&project.texts[&mutation.file], &mutation.text);
    Some(format!(
        "{} of {}, {}: expected {:?}\n    {}",
        mutation.kind,
        mutation.file,
        change,
        mutation.expected,
        if said.is_empty() { "(nothing is said)".to_string() } else { said.join("\n    ") }
    ))
}

/// The first line that differs.
fn changed_line(old: &str, new: &str) -> String {
    let pair = old.lines().zip(new.lines()).enumerate().find(|(_, (a, b))| a != b);
    pair.map_or_else(
        || "at the end".into(),
        |(at, (a, b))| format!("line {}: `{}` => `{}`", at + 1, a.trim(), b.trim()),
    )
}

#[test]
fn every_mutation_of_every_example_is_one_error_at_its_place() {
    let library = eval::library();
    let mut counts: BTreeMap<&'static str, usize> = BTreeMap::new();
    let mut work: Vec<(usize, Mutation)> = Vec::new();
    let projects = projects();
    let mut seen: Vec<&String> = Vec::new();
    for (index, project) in projects.iter().enumerate() {
        for (path, text) in &project.texts {
            // A file that several jobs use is mutated once; another job's file is not this job's.
            if seen.contains(&text) || path != &project.job && holds_job(text) {
                continue;
            }
            seen.push(text);
            let (ast, mistakes) = syntax::parse(FileId(0), text);
            assert!(mistakes.is_empty(), "{path}: {mistakes:?}");
            let mut generator = Generator { vocabulary: &library.vocabulary, path, text, mutations: Vec::new() };
            generator.file(&ast);
            for mutation in generator.mutations {
                *counts.entry(mutation.kind).or_default() += 1;
                work.push((index, mutation));
            }
        }
    }
    let total = work.len();
    let wrong: Mutex<BTreeMap<usize, String>> = Mutex::new(BTreeMap::new());
    let next = std::sync::atomic::AtomicUsize::new(0);
    std::thread::scope(|scope| {
        for _ in 0..std::thread::available_parallelism().map_or(1, usize::from) {
            scope.spawn(|| {
                loop {
                    let at = next.fetch_add(1, std::sync::atomic::Ordering::Relaxed);
                    let Some((project, mutation)) = work.get(at) else { return };
                    if let Some(complaint) = judge(&projects[*project], mutation) {
                        wrong.lock().expect("no panic").insert(at, complaint);
                    }
                }
            });
        }
    });
    let wrong = wrong.into_inner().expect("no panic");
    println!("{total} mutations of {} files, {} answered otherwise than they must", seen.len(), wrong.len());
    for (kind, count) in &counts {
        println!("{count:6} {kind}");
    }
    assert!(wrong.is_empty(), "{}", wrong.values().map(String::as_str).collect::<Vec<_>>().join("\n"));
    assert!(total > 2000, "only {total} mutations");
}
