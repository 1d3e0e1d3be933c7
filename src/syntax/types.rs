//! Types and restrictions: from what the grammar found to the tree.

use super::ast::{BinaryOp, Expr, ExprKind, Name, Restriction, Type, TypeKind};
use super::entries::Part;
use super::grammar::Rule;
use super::items::{group_of, name, span};
use super::written::Written;
use super::{Diagnostic, Reader, Span, codes};
use pest::iterators::Pair;

impl Reader<'_> {
    /// A type as it stands after `name:`.
    pub(super) fn type_whole(&mut self, written: &Written, pair: Pair<'_, Rule>) -> Type {
        let whole = span(written, &pair);
        let mut ty = Type { span: whole, kind: TypeKind::Symbols(Vec::new()) };
        for part in pair.into_inner() {
            match part.as_rule() {
                Rule::symbols => {
                    let place = span(written, &part);
                    ty = Type { span: place, kind: TypeKind::Symbols(self.symbols(written, part)) };
                }
                Rule::type_range => ty = self.type_range(written, part),
                Rule::optional => ty = Type { span: whole, kind: TypeKind::Optional(Box::new(ty)) },
                _ => {}
            }
        }
        ty
    }

    /// Each symbol's doc comment stands before it or before the `|` before it.
    fn symbols(&mut self, written: &Written, pair: Pair<'_, Rule>) -> Vec<(Name, String)> {
        let mut symbols = Vec::new();
        let mut doc = String::new();
        for part in pair.into_inner() {
            let place = span(written, &part);
            let own = self.doc_at(place.start);
            if !own.is_empty() {
                doc = own;
            }
            if part.as_rule() == Rule::symbol {
                symbols.push((name(written, &part), std::mem::take(&mut doc)));
            }
        }
        symbols
    }

    fn type_range(&mut self, written: &Written, pair: Pair<'_, Rule>) -> Type {
        let whole = span(written, &pair);
        let mut ends = pair.into_inner().filter(|p| p.as_rule() == Rule::type_product);
        let Some(first) = ends.next() else { return Type { span: whole, kind: TypeKind::Named(String::new()) } };
        let first_type = self.type_product(written, first.clone());
        let Some(second) = ends.next() else { return first_type };
        if first.as_str().trim() != second.as_str().trim() {
            let place = span(written, &second);
            self.say(
                Diagnostic::error(codes::E0107, place, "both ends of a range have the same type")
                    .also(span(written, &first), "the type of the first end")
                    .suggest(place, first.as_str().trim()),
            );
        }
        Type { span: whole, kind: TypeKind::Range(Box::new(first_type)) }
    }

    /// Products and quotients, from left to right.
    pub(super) fn type_product(&mut self, written: &Written, pair: Pair<'_, Rule>) -> Type {
        let mut divide = false;
        let mut product: Option<Type> = None;
        let whole = span(written, &pair);
        for part in pair.into_inner() {
            match part.as_rule() {
                Rule::multiply => divide = false,
                Rule::divide => divide = true,
                _ => {
                    let factor = self.type_power(written, part);
                    product = Some(match product {
                        None => factor,
                        Some(left) => {
                            let span = left.span.to(factor.span);
                            let (left, right) = (Box::new(left), Box::new(factor));
                            let kind =
                                if divide { TypeKind::Quotient(left, right) } else { TypeKind::Product(left, right) };
                            Type { span, kind }
                        }
                    });
                }
            }
        }
        product.unwrap_or(Type { span: whole, kind: TypeKind::Named(String::new()) })
    }

    fn type_power(&mut self, written: &Written, pair: Pair<'_, Rule>) -> Type {
        let whole = span(written, &pair);
        let mut base = Type { span: whole, kind: TypeKind::Named(String::new()) };
        for part in pair.into_inner() {
            let place = span(written, &part);
            match part.as_rule() {
                Rule::type_name => base = Type { span: place, kind: TypeKind::Named(part.as_str().to_string()) },
                Rule::type_product => base = self.type_product(written, part),
                Rule::list => base = self.list_type(written, &part, place),
                Rule::type_exponent => {
                    let mut numbers = part.into_inner().map(|p| self.small(p.as_str(), place));
                    let (above, below) = (numbers.next().unwrap_or(1), numbers.next().unwrap_or(1));
                    if below == 0 {
                        self.say(Diagnostic::error(codes::E0112, place, "an exponent cannot be divided by 0"));
                    }
                    base = Type { span: whole, kind: TypeKind::Power(Box::new(base), above, below.max(1)) };
                }
                _ => {}
            }
        }
        base
    }

    /// A power of a unit or a dimension. Nature needs no more than a few.
    pub(super) fn small(&mut self, digits: &str, place: Span) -> i32 {
        match digits.parse::<i32>() {
            Ok(number) if number.abs() <= 100 => number,
            _ => {
                self.say(
                    Diagnostic::error(codes::E0112, place, format!("`{digits}` is too large for a power"))
                        .note("powers of units and dimensions lie between -100 and 100"),
                );
                1
            }
        }
    }

    /// `[T]` and `[T; 6]`.
    fn list_type(&mut self, written: &Written, pair: &Pair<'_, Rule>, place: Span) -> Type {
        let nothing = Type { span: place, kind: TypeKind::Named(String::new()) };
        let Some(group) = group_of(written, pair) else { return nothing };
        let groups = self.writer.groups;
        let entry = match groups[group].entries.as_slice() {
            [entry] => entry,
            entries => {
                if !entries.iter().any(|entry| entry.damaged) {
                    let diagnostic =
                        Diagnostic::error(codes::E0107, place, "the type of a list is one type in brackets");
                    self.say(diagnostic.help("write `[Length]`, or `[Length; 6]` for a list of six"));
                }
                return nothing;
            }
        };
        let mut said = Vec::new();
        let inner = self.writer.write(entry, false, &mut said);
        self.diagnostics.append(&mut said);
        let read = self.run(entry, &inner, Rule::start_type, |reader, pairs| {
            let (mut ty, mut count) = (None, None);
            for part in pairs {
                match part.as_rule() {
                    Rule::type_whole => ty = Some(reader.type_whole(&inner, part)),
                    Rule::count => {
                        let place = span(&inner, &part);
                        count = part.as_str().parse::<usize>().ok();
                        if count.is_none() {
                            let message = "this number of elements is too large";
                            reader.say(Diagnostic::error(codes::E0112, place, message));
                        }
                    }
                    _ => {}
                }
            }
            Some(Type { span: place, kind: TypeKind::List(Box::new(ty?), count) })
        });
        read.ok().flatten().unwrap_or(nothing)
    }

    /// What stands after `where`.
    pub(super) fn restriction(&mut self, written: &Written, pair: Pair<'_, Rule>) -> Option<Restriction> {
        let inner = pair.into_inner().nth(1)?;
        if inner.as_rule() == Rule::interval {
            return Some(Restriction::Range(self.interval(written, inner)));
        }
        let mut comparisons = Vec::new();
        let mut comparison: Option<(BinaryOp, Span)> = None;
        for part in inner.into_inner() {
            match part.as_rule() {
                Rule::comparison => comparison = Some((comparison_of(part.as_str()), span(written, &part))),
                Rule::arithmetic => {
                    let value = self.expression(written, part);
                    comparisons.extend(comparison.take().map(|(op, place)| (op, place, value)));
                }
                _ => {}
            }
        }
        Some(Restriction::Comparisons(comparisons))
    }

    /// `a .. b`.
    pub(super) fn interval(&mut self, written: &Written, pair: Pair<'_, Rule>) -> Expr {
        let whole = span(written, &pair);
        let mut ends: Vec<Expr> = Vec::new();
        for part in pair.into_inner().filter(|p| p.as_rule() == Rule::arithmetic) {
            ends.push(self.expression(written, part));
        }
        let mut ends = ends.into_iter();
        match (ends.next(), ends.next()) {
            (Some(low), Some(high)) => Expr { span: whole, kind: ExprKind::Range(Box::new(low), Box::new(high)) },
            _ => Expr { span: whole, kind: ExprKind::Missing },
        }
    }

    /// Whether what a part stands for was lost before the grammar saw it.
    pub(super) fn is_lost(&self, part: Option<Part>) -> bool {
        matches!(part, Some(Part::Lexeme(i)) if self.writer.lexemes[i].lost)
    }
}

/// The comparison written so.
pub(super) fn comparison_of(written: &str) -> BinaryOp {
    match written {
        "<" => BinaryOp::Less,
        "<=" => BinaryOp::LessEqual,
        ">" => BinaryOp::Greater,
        ">=" => BinaryOp::GreaterEqual,
        "==" => BinaryOp::Equal,
        _ => BinaryOp::NotEqual,
    }
}
