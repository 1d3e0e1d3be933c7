//! Lists: `[a, b]`, and `[… for i in 1 .. 4]`.

use super::ast::{Expr, ExprKind, Name, Unit};
use super::grammar::Rule;
use super::items::{Context, name, span};
use super::written::Written;
use super::{Diagnostic, Reader, Span, codes};
use pest::iterators::Pair;

/// What stands after an element: `for i in 1 .. 4`.
struct For {
    place: Span,
    variable: Name,
    over: Expr,
}

impl Reader<'_> {
    /// What stands in the brackets of a list, with the unit behind them.
    pub(super) fn list(&mut self, group: usize, unit: Option<Unit>) -> ExprKind {
        let groups = self.writer.groups;
        let mut elements: Vec<Expr> = Vec::with_capacity(groups[group].entries.len());
        let mut repeated: Option<For> = None;
        let mut waiting = super::allowed::Waiting::default();
        for entry in &groups[group].entries {
            let whole = self.entry_span(entry);
            if self.allow_line(entry, &mut waiting) {
                continue;
            }
            self.allow_in(&mut waiting, whole);
            self.entry_doc(entry);
            let missing = Expr { span: whole, kind: ExprKind::Missing };
            let mut said = Vec::new();
            let written = self.writer.write(entry, false, &mut said);
            self.diagnostics.append(&mut said);
            let mut clause = None;
            let read = self.run(entry, &written, Rule::start_element, |reader, mut pairs| {
                let element = reader.expression(&written, pairs.next()?);
                clause = pairs.find(|p| p.as_rule() == Rule::for_clause).and_then(|p| reader.for_clause(&written, p));
                Some(element)
            });
            if read.is_err() {
                self.visit(entry, Context::List);
            }
            repeated = repeated.or(clause);
            elements.push(read.ok().flatten().unwrap_or(missing));
        }
        self.nothing_to_allow(waiting);
        match repeated {
            None => ExprKind::List(elements, unit),
            Some(For { variable, over, .. }) if elements.len() == 1 => {
                let element = Box::new(elements.remove(0));
                ExprKind::Comprehension { element, variable, over: Box::new(over), unit }
            }
            Some(For { place, .. }) => {
                self.say(
                    Diagnostic::error(codes::E0107, place, "a list with `for` holds one element and nothing else")
                        .help("write the others as a list of their own"),
                );
                ExprKind::Missing
            }
        }
    }

    fn for_clause(&mut self, written: &Written, pair: Pair<'_, Rule>) -> Option<For> {
        let place = span(written, &pair);
        let (mut variable, mut over) = (None, None);
        for part in pair.into_inner() {
            match part.as_rule() {
                Rule::name => variable = Some(name(written, &part)),
                Rule::expression => over = Some(self.expression(written, part)),
                _ => {}
            }
        }
        Some(For { place, variable: variable?, over: over? })
    }
}
