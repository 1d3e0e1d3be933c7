//! `allow CODE because "…"`: which warning is silenced, where, and why.
//!
//! In: the entries of a group, one after the other. Out: [`Allow`]s, each with the entry that it stands before. They
//! belong to no entry of the tree: whoever has all warnings of a compilation compares places (`session.rs`).

use super::ast::Allow;
use super::entries::RawEntry;
use super::grammar::Rule;
use super::items::name;
use super::lexemes::LexemeKind;
use super::{Diagnostic, Reader, Span, codes};

/// The `allow` lines that wait for their entry.
#[derive(Default)]
pub(super) struct Waiting(Vec<Allow>);

impl Reader<'_> {
    /// Whether the entry is an `allow` line; then it waits for the entry after it.
    pub(super) fn allow_line(&mut self, entry: &RawEntry, waiting: &mut Waiting) -> bool {
        let written_so = matches!(
            self.writer.kind(entry.parts.get(1)),
            Some(LexemeKind::Word | LexemeKind::Keyword | LexemeKind::Text | LexemeKind::Number)
        );
        if self.word_at(entry, 0) != Some("allow") || !written_so {
            return false;
        }
        self.carried_doc = self.entry_doc(entry);
        let whole = self.entry_span(entry);
        let mut said = Vec::new();
        let written = self.writer.write(entry, false, &mut said);
        self.diagnostics.append(&mut said);
        let read = self.run(entry, &written, Rule::start_allow, |reader, mut pairs| {
            let code = pairs.find(|pair| pair.as_rule() == Rule::code).map(|pair| name(&written, &pair))?;
            let reason = pairs.find(|pair| pair.as_rule() == Rule::reason).and_then(|p| reader.reason(&written, p));
            if reason.is_none() {
                let help = format!("write why it is right here: `allow {} because \"…\"`", code.text);
                reader.say(Diagnostic::error(codes::E0124, code.span, "this `allow` gives no reason").help(help));
            }
            let reason = reason.unwrap_or_default();
            Some(Allow { code, reason, target: whole, span: whole })
        });
        waiting.0.extend(read.ok().flatten());
        true
    }

    /// The entry that the waiting lines stand before.
    pub(super) fn allow_in(&mut self, waiting: &mut Waiting, target: Span) {
        self.allows.extend(waiting.0.drain(..).map(|allow| Allow { target, ..allow }));
    }

    /// The group ends.
    pub(super) fn nothing_to_allow(&mut self, waiting: Waiting) {
        self.carried_doc.clear();
        for allow in waiting.0 {
            self.say(
                Diagnostic::error(codes::E0125, allow.span, "nothing stands after this `allow`")
                    .help("write it on the line before the field or the item that is warned of"),
            );
        }
    }
}
