//! Items, records and schemas: from the entries of a group to the tree.

use super::allowed::Waiting;
use super::ast::{
    Ast, Block, Check, Entry, EntryKind, Expr, ExprKind, Item, ItemKind, Name, Parameter, Schema, SchemaField, UsePath,
};
use super::entries::{Part, RawEntry, is_item_word};
use super::grammar::Rule;
use super::lexemes::{Bracket, LexemeKind, unescape};
use super::written::Written;
use super::{Diagnostic, Reader, Span, Unreadable, codes};
use pest::iterators::Pair;

/// The version of the language that this compiler reads.
const LANGUAGE: u32 = 1;

/// What may stand in a group.
#[derive(Clone, Copy, PartialEq, Eq)]
pub enum Context {
    Record,
    Schema,
    List,
}

/// What the entries of a schema say.
#[derive(Default)]
struct SchemaBody {
    fields: Vec<SchemaField>,
    checks: Vec<Check>,
}

impl<'a> Reader<'a> {
    /// The whole file.
    pub(super) fn file(&mut self) -> Ast {
        let mut ast = Ast::default();
        let groups = self.writer.groups;
        let Some(whole) = groups.first() else { return ast };
        let first = whole.entries.first();
        if first.is_none_or(|entry| self.first_word(entry) != Some("language")) {
            self.say_no_language(first);
        }
        let mut outside = false;
        let mut waiting = Waiting::default();
        for (i, entry) in whole.entries.iter().enumerate() {
            if self.allow_line(entry, &mut waiting) {
                outside = false;
                continue;
            }
            let target = self.entry_span(entry);
            self.allow_in(&mut waiting, target);
            let public = self.first_word(entry) == Some("pub");
            let item = self.word_at(entry, usize::from(public)).filter(|word| is_item_word(word));
            match item {
                None => {
                    // One mistake (a misspelt `job`, a missing bracket) often puts many entries outside.
                    // A lone number before all else is what is left of the language line.
                    let version = i == 0 && self.writer.kind(entry.parts.first()) == Some(LexemeKind::Number);
                    if !entry.damaged && !outside && !version {
                        self.say_outside(entry, public);
                    }
                    outside = !version;
                    self.use_docs_within(entry);
                    ast.items.extend(self.nameless_item(entry));
                }
                Some("language") if i > 0 => {
                    outside = false;
                    let span = self.entry_span(entry);
                    self.say(
                        Diagnostic::error(
                            codes::E0108,
                            span,
                            "the `language` line stands once, at the start of the file",
                        )
                        .help("delete this line"),
                    );
                }
                Some(word) => {
                    outside = false;
                    self.item(entry, word, public, &mut ast);
                }
            }
        }
        self.nothing_to_allow(waiting);
        ast.allows = std::mem::take(&mut self.allows);
        ast.allows.sort_by_key(|allow| allow.span);
        if ast.language.is_some_and(|(version, _)| version != LANGUAGE) {
            ast.items.clear();
            ast.allows.clear();
        }
        ast
    }

    fn say_no_language(&mut self, first: Option<&RawEntry>) {
        let text = self.writer.text;
        let start = text.len() - text.trim_start_matches('\u{feff}').len();
        let mut place = Span::new(self.writer.file, start, start);
        let mut line = format!("language {LANGUAGE}\n");
        // Of `language 1` the number may be left.
        if let Some([number]) = first.map(|entry| entry.parts.as_slice())
            && self.writer.slice(*number) == LANGUAGE.to_string()
        {
            place.start = self.writer.range(*number).0;
            place.end = place.start;
            line = "language ".to_string();
        }
        self.say(
            Diagnostic::error(codes::E0108, place, "the file does not say its language")
                .help(format!("write `language {LANGUAGE}` as the first line"))
                .suggest(place, line),
        );
    }

    fn item(&mut self, entry: &RawEntry, word: &str, public: bool, ast: &mut Ast) {
        let doc = self.entry_doc(entry);
        let span = self.entry_span(entry);
        let mut said = Vec::new();
        let written = self.writer.write(entry, false, &mut said);
        self.diagnostics.append(&mut said);
        let kind = match self.run(entry, &written, Rule::start_item, |reader, mut pairs| {
            let item = pairs.find(|pair| pair.as_rule() != Rule::public)?;
            reader.item_kind(&written, item, ast)
        }) {
            Ok(kind) => kind,
            Err(Unreadable) => self.salvage_item(entry, word),
        };
        ast.items.extend(kind.map(|kind| Item { doc, public, span, kind }));
    }

    fn item_kind(&mut self, written: &Written, item: Pair<'_, Rule>, ast: &mut Ast) -> Option<ItemKind> {
        let rule = item.as_rule();
        let whole = span(written, &item);
        let mut parts = item.into_inner();
        let keyword = span(written, &parts.next()?);
        let mut next = parts.next();
        Some(match rule {
            Rule::language_line => {
                self.language(next?.as_str(), whole, ast);
                return None;
            }
            Rule::use_item => {
                let what = next?;
                if self.is_lost(written.part_at(what.as_span().start())) {
                    return None;
                }
                ItemKind::Use(match what.as_rule() {
                    Rule::text => UsePath::File { path: unescape(what.as_str()), span: span(written, &what) },
                    _ => UsePath::Module(
                        what.into_inner()
                            .filter(|p| p.as_rule() == Rule::path_word)
                            .map(|p| name(written, &p))
                            .collect(),
                    ),
                })
            }
            Rule::let_item => {
                let (mut ty, mut value) = (None, None);
                for part in parts {
                    match part.as_rule() {
                        Rule::type_whole => ty = Some(self.type_whole(written, part)),
                        Rule::expression => value = Some(self.expression(written, part)),
                        _ => {}
                    }
                }
                ItemKind::Let { name: name(written, &next?), ty, value: value? }
            }
            Rule::param_item => {
                let (mut ty, mut value, mut restriction, mut usual) = (None, None, None, None);
                for part in parts {
                    match part.as_rule() {
                        Rule::type_whole => ty = Some(self.type_whole(written, part)),
                        Rule::expression => value = Some(self.expression(written, part)),
                        Rule::where_clause => restriction = self.restriction(written, part),
                        Rule::usual_clause => usual = self.usual(written, part),
                        _ => {}
                    }
                }
                ItemKind::Param { name: name(written, &next?), ty: ty?, value, restriction, usual }
            }
            Rule::fn_item => {
                let (mut parameters, mut result, mut body) = (Vec::new(), None, None);
                for part in parts {
                    match part.as_rule() {
                        Rule::parameter => parameters.extend(self.parameter(written, part)),
                        Rule::type_whole => result = Some(self.type_whole(written, part)),
                        Rule::expression => body = Some(self.expression(written, part)),
                        _ => {}
                    }
                }
                ItemKind::Function { name: name(written, &next?), parameters, result: result?, body }
            }
            Rule::assert_item => {
                let condition = self.expression(written, next?);
                let reason = parts.next().and_then(|part| self.reason(written, part));
                if reason.is_none() {
                    let help = "write what it means for the shop: `assert … because \"…\"`";
                    self.say(Diagnostic::error(codes::E0124, keyword, "this `assert` gives no reason").help(help));
                }
                ItemKind::Assert { condition, reason: reason.unwrap_or_default() }
            }
            Rule::family_item => ItemKind::Family { name: name(written, &next?) },
            Rule::dimension_item => {
                let value = parts.find(|p| p.as_rule() == Rule::type_product).map(|p| self.type_product(written, p));
                ItemKind::Dimension { name: name(written, &next?), value }
            }
            Rule::unit_item => {
                let (mut ty, mut value) = (None, None);
                for part in parts {
                    match part.as_rule() {
                        Rule::type_product => ty = Some(self.type_product(written, part)),
                        Rule::arithmetic => value = Some(self.expression(written, part)),
                        _ => {}
                    }
                }
                ItemKind::Unit { name: name(written, &next?), ty, value }
            }
            Rule::schema_item | Rule::job_item => {
                let job = rule == Rule::job_item;
                let called = match next.take_if(|p| p.as_rule() == Rule::name) {
                    Some(pair) => name(written, &pair),
                    None => self.nameless(keyword, if job { "job" } else { "schema" }),
                };
                let rest: Vec<_> = next.into_iter().chain(parts).collect();
                let family = rest.iter().find(|p| p.as_rule() == Rule::family_name).map(|p| name(written, p));
                let block = rest.iter().find(|p| p.as_rule() == Rule::block)?;
                let group = group_of(written, block)?;
                if job {
                    ItemKind::Job { name: called, body: self.block(group) }
                } else {
                    let SchemaBody { fields, checks } = self.schema_body(group);
                    ItemKind::Schema(Schema { name: called, family, fields, checks })
                }
            }
            _ => return None,
        })
    }

    fn parameter(&mut self, written: &Written, pair: Pair<'_, Rule>) -> Option<Parameter> {
        let (mut called, mut ty) = (None, None);
        for part in pair.into_inner() {
            match part.as_rule() {
                Rule::name => called = Some(name(written, &part)),
                Rule::type_whole => ty = Some(self.type_whole(written, part)),
                _ => {}
            }
        }
        Some(Parameter { name: called?, ty: ty? })
    }

    /// `because "…"`; nothing if the text says nothing.
    pub(super) fn reason(&mut self, written: &Written, pair: Pair<'_, Rule>) -> Option<String> {
        let text = pair.into_inner().nth(1)?;
        let lost = self.is_lost(written.part_at(text.as_span().start()));
        let reason = unescape(text.as_str());
        (lost || !reason.trim().is_empty()).then_some(reason)
    }

    fn nameless(&mut self, keyword: Span, what: &str) -> Name {
        let gap = Span { start: keyword.end, ..keyword };
        self.say(
            Diagnostic::error(codes::E0122, keyword, format!("this `{what}` has no name"))
                .help(format!("write `{what} its_name`, on one line")),
        );
        Name { text: String::new(), span: gap }
    }

    fn language(&mut self, version: &str, span: Span, ast: &mut Ast) {
        let number = version.parse::<u32>().unwrap_or(u32::MAX);
        if number != LANGUAGE {
            self.say(
                Diagnostic::error(codes::E0109, span, format!("this compiler does not know language {version}"))
                    .note(format!("it reads language {LANGUAGE}"))
                    .help("use a newer compiler for a newer language"),
            );
        }
        ast.language = Some((number, span));
    }

    /// Of an item that cannot be read, what others refer to: a job's content, the name of a value.
    fn salvage_item(&mut self, entry: &RawEntry, word: &str) -> Option<ItemKind> {
        self.use_docs_within(entry);
        let first = usize::from(self.first_word(entry) == Some("pub"));
        let called = self.word_at(entry, first + 1).map(|text| {
            let (start, end) = self.writer.range(entry.parts[first + 1]);
            Name { text: text.to_string(), span: Span { file: self.writer.file, start, end } }
        })?;
        match word {
            "let" | "param" | "fn" => {
                let span = Span { start: called.span.end, ..called.span };
                self.visit(entry, Context::Record);
                Some(ItemKind::Let { name: called, ty: None, value: Expr { span, kind: ExprKind::Missing } })
            }
            "job" => match *entry.parts.last()? {
                Part::Group(g) if self.writer.groups[g].bracket == Bracket::Curly => {
                    Some(ItemKind::Job { name: called, body: self.block(g) })
                }
                _ => None,
            },
            _ => None,
        }
    }

    /// `flat_340 { … }` without its first word: most files have one such item, the job.
    fn nameless_item(&mut self, entry: &RawEntry) -> Option<Item> {
        let groups = self.writer.groups;
        let text = self.word_at(entry, 0)?.to_string();
        let (word, Part::Group(group)) = (*entry.parts.first()?, *entry.parts.get(1)?) else { return None };
        if entry.damaged || entry.parts.len() > 2 || groups[group].bracket != Bracket::Curly {
            return None;
        }
        let (start, end) = self.writer.range(word);
        let called = Name { text, span: Span { file: self.writer.file, start, end } };
        let kind = ItemKind::Job { name: called, body: self.block(group) };
        Some(Item { doc: String::new(), public: false, span: self.entry_span(entry), kind })
    }

    /// The entries of `{ … }` as a record.
    pub(super) fn block(&mut self, group: usize) -> Block {
        let groups = self.writer.groups;
        let group = &groups[group];
        let span = Span { file: self.writer.file, start: group.start, end: group.end };
        let mut entries = Vec::with_capacity(group.entries.len());
        let mut waiting = Waiting::default();
        for entry in &group.entries {
            if self.allow_line(entry, &mut waiting) {
                continue;
            }
            let target = self.entry_span(entry);
            self.allow_in(&mut waiting, target);
            entries.extend(self.entry(entry));
        }
        self.nothing_to_allow(waiting);
        Block { entries, span }
    }

    fn entry(&mut self, entry: &RawEntry) -> Option<Entry> {
        let doc = self.entry_doc(entry);
        let whole = self.entry_span(entry);
        if self.misplaced_item(entry) {
            return None;
        }
        let mut said = Vec::new();
        let written = self.writer.write(entry, true, &mut said);
        self.diagnostics.append(&mut said);
        if self.writer.kind(entry.parts.first()) == Some(LexemeKind::Colon) {
            self.say_nameless(entry);
            self.use_docs_within(entry);
            self.visit(entry, Context::Record);
            return None;
        }
        let read = self.run(entry, &written, Rule::start_entry, |reader, mut pairs| {
            let pair = pairs.next()?;
            if pair.as_rule() != Rule::field {
                let value = reader.expression(&written, pair);
                if matches!(value.kind, ExprKind::Record { schema: None, .. }) {
                    reader.say_nameless(entry);
                    return None;
                }
                return Some(shorthand(value));
            }
            let mut parts = pair.into_inner();
            let called = parts.next().map(|p| name(&written, &p));
            let colon = parts.next().map(|p| span(&written, &p));
            let value = match parts.next() {
                Some(value) => reader.expression(&written, value),
                None => reader.valueless(entry, called.as_ref(), colon.unwrap_or(whole)),
            };
            Some(EntryKind::Field { name: called?, value })
        });
        let kind = match read {
            Ok(kind) => kind?,
            Err(Unreadable) => {
                self.visit(entry, Context::Record);
                self.salvage_field(entry)?
            }
        };
        Some(Entry { doc, span: whole, kind })
    }

    /// `: 4 mm` or `{ … }` alone where a field is expected.
    fn say_nameless(&mut self, entry: &RawEntry) {
        let start = self.entry_span(entry).start;
        let place = Span { file: self.writer.file, start, end: start + 1 };
        if !entry.damaged {
            self.say(Diagnostic::error(codes::E0122, place, "this field has no name").help("write its name before it"));
        }
    }

    fn valueless(&mut self, entry: &RawEntry, called: Option<&Name>, colon: Span) -> Expr {
        let gap = Span { start: colon.end, ..colon };
        if !entry.damaged {
            let called = called.map_or("", |name| name.text.as_str());
            self.say(
                Diagnostic::error(codes::E0106, colon, format!("`{called}` has no value"))
                    .help("write a value after `:`, or delete the field"),
            );
        }
        Expr { span: gap, kind: ExprKind::Missing }
    }

    /// `name:` of an entry that cannot be read: so nobody says that the field is missing.
    fn salvage_field(&mut self, entry: &RawEntry) -> Option<EntryKind> {
        self.use_docs_within(entry);
        let (&first, &second) = (entry.parts.first()?, entry.parts.get(1)?);
        if self.writer.kind(Some(&first)) != Some(LexemeKind::Word)
            || self.writer.kind(Some(&second)) != Some(LexemeKind::Colon)
        {
            return None;
        }
        let (start, end) = self.writer.range(first);
        let file = self.writer.file;
        let called = Name { text: self.writer.slice(first).to_string(), span: Span { file, start, end } };
        let value_start = self.writer.range(second).1;
        let value =
            Expr { span: Span { file, start: value_start, end: self.entry_span(entry).end }, kind: ExprKind::Missing };
        Some(EntryKind::Field { name: called, value })
    }

    /// Reads the groups of an entry that itself cannot be read, for the mistakes in them.
    pub(super) fn visit(&mut self, entry: &RawEntry, context: Context) {
        let groups = self.writer.groups;
        for part in &entry.parts {
            let Part::Group(g) = *part else { continue };
            match (groups[g].bracket, context) {
                (Bracket::Curly, Context::Schema) => drop(self.schema_body(g)),
                (Bracket::Curly, _) => drop(self.block(g)),
                // In a schema the list is a type, whose mistakes the type's reader would tell.
                (_, Context::Schema) => {}
                (_, _) => drop(self.list(g, None)),
            }
        }
    }

    fn schema_body(&mut self, group: usize) -> SchemaBody {
        let groups = self.writer.groups;
        let mut body = SchemaBody::default();
        for entry in &groups[group].entries {
            let doc = self.entry_doc(entry);
            let whole = self.entry_span(entry);
            if self.misplaced_item(entry) {
                continue;
            }
            let mut said = Vec::new();
            let check = self.first_word(entry) == Some("check");
            let written = self.writer.write(entry, !check, &mut said);
            self.diagnostics.append(&mut said);
            let read = self.run(entry, &written, Rule::start_schema, |reader, mut pairs| {
                let pair = pairs.next()?;
                if pair.as_rule() == Rule::check_line {
                    let (mut condition, mut reason) = (None, None);
                    for part in pair.into_inner() {
                        match part.as_rule() {
                            Rule::expression => condition = Some(reader.expression(&written, part)),
                            Rule::reason => reason = reader.reason(&written, part),
                            _ => {}
                        }
                    }
                    body.checks.extend(condition.map(|condition| Check { condition, reason }));
                } else {
                    body.fields.extend(reader.schema_field(&written, pair, doc, whole));
                }
                Some(())
            });
            if read.is_err() {
                self.visit(entry, Context::Schema);
            }
        }
        body
    }

    fn schema_field(
        &mut self,
        written: &Written,
        pair: Pair<'_, Rule>,
        doc: String,
        whole: Span,
    ) -> Option<SchemaField> {
        let mut parts = pair.into_inner();
        let called = name(written, &parts.next()?);
        let (mut ty, mut default, mut restriction, mut usual) = (None, None, None, None);
        for part in parts {
            match part.as_rule() {
                Rule::type_whole => ty = Some(self.type_whole(written, part)),
                Rule::expression => default = Some(self.expression(written, part)),
                Rule::where_clause => restriction = self.restriction(written, part),
                Rule::usual_clause => usual = self.usual(written, part),
                _ => {}
            }
        }
        Some(SchemaField { doc, name: called, ty: ty?, default, restriction, usual, span: whole })
    }

    fn usual(&mut self, written: &Written, pair: Pair<'_, Rule>) -> Option<Expr> {
        pair.into_inner().nth(1).map(|interval| self.interval(written, interval))
    }

    /// `let x = 3` within a record.
    fn misplaced_item(&mut self, entry: &RawEntry) -> bool {
        let Some(word) = self.first_word(entry).filter(|word| is_item_word(word)) else { return false };
        if !matches!(self.writer.kind(entry.parts.get(1)), Some(LexemeKind::Word | LexemeKind::Text)) {
            return false;
        }
        let (start, end) = self.writer.range(entry.parts[0]);
        let place = Span { file: self.writer.file, start, end };
        if !entry.damaged {
            self.say(
                Diagnostic::error(codes::E0123, place, format!("`{word}` stands inside a record"))
                    .note("items stand at the top level of a file, fields `name: value` in a record")
                    .help(match word {
                        "assert" => "move it out; inside a schema write `check`, inside a job `require`",
                        _ => "move it out, or write a `:` if it is meant as a field",
                    }),
            );
        }
        self.use_docs_within(entry);
        true
    }

    fn say_outside(&mut self, entry: &RawEntry, public: bool) {
        let Some(&part) = entry.parts.get(usize::from(public)).or(entry.parts.first()) else { return };
        let (start, end) = self.writer.range(part);
        let end = if matches!(part, Part::Group(_)) { start + 1 } else { end };
        let place = Span { file: self.writer.file, start, end };
        let field = self.writer.kind(entry.parts.get(1)) == Some(LexemeKind::Colon);
        let message = match field {
            true => format!("the field `{}` stands outside any item", self.short(part)),
            false => format!("`{}` begins no item", self.short(part)),
        };
        let items = "items begin with `use`, `let`, `param`, `fn`, `assert`, `family`, `schema` or `job`";
        let diagnostic = Diagnostic::error(codes::E0123, place, message).note(items);
        let headless = matches!(entry.parts.as_slice(), [Part::Lexeme(_), Part::Group(_)]);
        let word = self.short(part);
        let gives = self.writer.kind(entry.parts.get(1)) == Some(LexemeKind::Operator)
            && entry.parts.get(1).is_some_and(|part| self.writer.slice(*part) == "=");
        if let Some(ours) = super::slips::item_meant(&word).filter(|_| !field && entry.parts.len() > 1) {
            self.say(diagnostic.help(format!("write `{ours}`")).suggest(place, ours));
            return;
        }
        if gives && self.writer.kind(Some(&part)) == Some(LexemeKind::Word) {
            let gap = Span { end: start, ..place };
            self.say(diagnostic.help(format!("a value is given a name by `let {word} = …`")).suggest(gap, "let "));
            return;
        }
        self.say(if field {
            diagnostic.help("put it inside `job name { … }`")
        } else if headless {
            diagnostic
                .help(format!("write `job {} {{ … }}`", self.short(part)))
                .suggest(Span { end: start, ..place }, "job ")
        } else {
            diagnostic
        });
    }

    fn first_word(&self, entry: &RawEntry) -> Option<&'a str> {
        self.word_at(entry, 0)
    }

    /// The word at a place of the entry, unless a `:` makes it the name of a field.
    pub(super) fn word_at(&self, entry: &RawEntry, at: usize) -> Option<&'a str> {
        let part = entry.parts.get(at)?;
        let word = self.writer.kind(Some(part)) == Some(LexemeKind::Word);
        let field = at == 0 && self.writer.kind(entry.parts.get(1)) == Some(LexemeKind::Colon);
        (word && !field).then(|| self.writer.slice(*part))
    }
}

/// `workpiece { … }` is short for `workpiece: workpiece { … }`.
fn shorthand(value: Expr) -> EntryKind {
    match &value.kind {
        ExprKind::Record { schema: Some(schema), .. } if schema.span.start == value.span.start => {
            EntryKind::Field { name: schema.clone(), value }
        }
        _ => EntryKind::Expr(value),
    }
}

pub(super) fn span(written: &Written, pair: &Pair<'_, Rule>) -> Span {
    let place = pair.as_span();
    // A rule that may end with something optional takes the blanks before what did not come.
    let length = pair.as_str().trim_end_matches([' ', '\n']).len();
    written.span(place.start(), place.start() + length)
}

pub(super) fn name(written: &Written, pair: &Pair<'_, Rule>) -> Name {
    Name { text: pair.as_str().to_string(), span: span(written, pair) }
}

/// The group that stands as `{}` or `[]` in the text.
pub(super) fn group_of(written: &Written, pair: &Pair<'_, Rule>) -> Option<usize> {
    match written.part_at(pair.as_span().start()) {
        Some(Part::Group(g)) => Some(g),
        _ => None,
    }
}
