//! Expressions: precedence, units, and the forms that could be read in two ways.
//!
//! The grammar gives an expression as a flat row of values and operators; climbing over the levels makes the tree.
//! What binds how is the language's (loosest first): `or`, `and`, `not`, comparison, `..`, `+ -`, `* /`, unary `-`,
//! `^`, then `with`, `.` and call. Comparison, `..` and `^` do not chain.

use super::ast::{BinaryOp, Expr, ExprKind, UnaryOp, Unit};
use super::grammar::Rule;
use super::items::{group_of, name, span};
use super::lexemes::unescape;
use super::types::comparison_of;
use super::written::Written;
use super::{Diagnostic, Reader, Span, codes};
use pest::iterators::{Pair, Pairs};
use std::iter::Peekable;

/// What stands between two operands.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Infix {
    Binary(BinaryOp),
    Range,
}

/// The operators that do not chain with their like.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Single {
    Comparison,
    Range,
    Power,
}

/// An expression and what it looks like from outside; parentheses make everything plain.
struct Operand {
    expr: Expr,
    /// The operator at the top, if it is one that does not chain.
    top: Option<Single>,
    /// What the last value in it is: the left neighbour of the next operator.
    last: Last,
}

/// A value without parentheses around it.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Last {
    Number(Span),
    Quantity(Span),
    Other,
}

/// The levels of the operators that stand before their operand.
const NOT: u8 = 3;
const MINUS: u8 = 8;

impl Reader<'_> {
    /// The tree of an `expression` or `arithmetic` of the grammar.
    pub(super) fn expression(&mut self, written: &Written, pair: Pair<'_, Rule>) -> Expr {
        let whole = span(written, &pair);
        let mut row = pair.into_inner().peekable();
        if row.peek().is_some_and(|first| first.as_rule() == Rule::if_word) {
            return Expr { span: whole, kind: self.conditional(written, row) };
        }
        self.climb(written, &mut row, 0).expr
    }

    /// `if a then b else if c then d else e`, its chain in a loop: it may be long.
    fn conditional(&mut self, written: &Written, row: Peekable<Pairs<'_, Rule>>) -> ExprKind {
        let mut values: Vec<Expr> = Vec::new();
        for part in row.filter(|part| part.as_rule() == Rule::branch) {
            values.push(self.expression(written, part));
        }
        let Some(otherwise) = values.pop() else { return ExprKind::Missing };
        let mut branches = Vec::with_capacity(values.len() / 2);
        let mut values = values.into_iter();
        while let (Some(condition), Some(value)) = (values.next(), values.next()) {
            branches.push((condition, value));
        }
        ExprKind::If { branches, otherwise: Box::new(otherwise) }
    }

    /// Reads operators that bind at least as tight as `level`.
    fn climb(&mut self, written: &Written, row: &mut Peekable<Pairs<'_, Rule>>, level: u8) -> Operand {
        let mut left = self.prefixed(written, row);
        while let Some((own, op)) = row.peek().and_then(infix) {
            if own < level {
                break;
            }
            let Some(pair) = row.next() else { break };
            let right = self.climb(written, row, own + 1);
            left = self.join(left, op, span(written, &pair), right);
        }
        left
    }

    fn prefixed(&mut self, written: &Written, row: &mut Peekable<Pairs<'_, Rule>>) -> Operand {
        let Some(first) = row.next() else {
            // The grammar gives no row without a value.
            return Operand {
                expr: Expr { span: written.end(), kind: ExprKind::Missing },
                top: None,
                last: Last::Other,
            };
        };
        let place = span(written, &first);
        let (op, level) = match first.as_rule() {
            Rule::minus => (UnaryOp::Minus, MINUS + 1),
            Rule::not => (UnaryOp::Not, NOT + 1),
            _ => return self.operand(written, first, row),
        };
        let inner = self.climb(written, row, level);
        let expr = Expr { span: place.to(inner.expr.span), kind: ExprKind::Unary(op, Box::new(inner.expr)) };
        // `-2^3` is a power seen from outside, so that `-2^3^4` does not slip through.
        Operand { expr, top: inner.top.filter(|top| *top == Single::Power), last: inner.last }
    }

    /// A value and all that follows it closely: `.name`, `(…)`, `with { … }`.
    fn operand(&mut self, written: &Written, pair: Pair<'_, Rule>, row: &mut Peekable<Pairs<'_, Rule>>) -> Operand {
        let mut expr = self.primary(written, pair.clone());
        let literal = pair.as_rule() == Rule::literal;
        let mut last = match expr.kind {
            ExprKind::Number(_) if literal => Last::Number(expr.span),
            ExprKind::Quantity { .. } if literal => Last::Quantity(expr.span),
            _ => Last::Other,
        };
        while let Some(after) = row.next_if(|p| matches!(p.as_rule(), Rule::member | Rule::call | Rule::with)) {
            let place = span(written, &after);
            let whole = expr.span.to(place);
            if matches!(last, Last::Quantity(_) | Last::Number(_)) && after.as_rule() != Rule::with {
                let what = if after.as_rule() == Rule::call { "called" } else { "asked for a field" };
                self.say(
                    Diagnostic::error(codes::E0114, place, format!("a number cannot be {what}"))
                        .also(expr.span, "the number")
                        .help("put an operator or a comma between the two"),
                );
                expr = Expr { span: whole, kind: ExprKind::Missing };
            }
            last = Last::Other;
            if expr.kind != ExprKind::Missing {
                expr = Expr { span: whole, kind: self.followed(written, expr, after) };
            }
        }
        Operand { expr, top: None, last }
    }

    fn followed(&mut self, written: &Written, expr: Expr, after: Pair<'_, Rule>) -> ExprKind {
        let rule = after.as_rule();
        let mut inner = after.into_inner();
        match rule {
            Rule::member => match inner.find(|p| p.as_rule() == Rule::path_word) {
                Some(field) => ExprKind::Member(Box::new(expr), name(written, &field)),
                None => ExprKind::Missing,
            },
            Rule::call => {
                let mut arguments = Vec::new();
                for argument in inner.filter(|p| p.as_rule() == Rule::expression) {
                    arguments.push(self.expression(written, argument));
                }
                ExprKind::Call(Box::new(expr), arguments)
            }
            _ => match inner.find(|p| p.as_rule() == Rule::block).and_then(|p| group_of(written, &p)) {
                Some(group) => ExprKind::With(Box::new(expr), self.block(group)),
                None => ExprKind::Missing,
            },
        }
    }

    fn primary(&mut self, written: &Written, pair: Pair<'_, Rule>) -> Expr {
        let place = span(written, &pair);
        let start = pair.as_span().start();
        let rule = pair.as_rule();
        let text = pair.as_str();
        let kind = match rule {
            Rule::literal => self.literal(written, pair),
            Rule::text if self.is_lost(written.part_at(start)) => ExprKind::Missing,
            Rule::text => ExprKind::Text(unescape(text)),
            Rule::block => match group_of(written, &pair) {
                Some(group) => ExprKind::Record { schema: None, body: self.block(group) },
                None => ExprKind::Missing,
            },
            Rule::list_value => {
                let (mut group, mut unit) = (None, None);
                for part in pair.into_inner() {
                    match part.as_rule() {
                        Rule::list => group = group_of(written, &part),
                        _ => unit = Some(self.unit(written, part)),
                    }
                }
                match group {
                    Some(group) => self.list(group, unit),
                    None => ExprKind::Missing,
                }
            }
            Rule::parenthesised => match pair.into_inner().find(|p| p.as_rule() == Rule::expression) {
                Some(inner) => self.expression(written, inner).kind,
                None => ExprKind::Missing,
            },
            _ => {
                let mut parts = pair.into_inner();
                let Some(word) = parts.next() else { return Expr { span: place, kind: ExprKind::Missing } };
                match (parts.next().and_then(|p| group_of(written, &p)), word.as_str()) {
                    (Some(group), _) => {
                        ExprKind::Record { schema: Some(name(written, &word)), body: self.block(group) }
                    }
                    (None, "true") => ExprKind::Bool(true),
                    (None, "false") => ExprKind::Bool(false),
                    (None, "none") => ExprKind::None,
                    (None, word) => ExprKind::Name(word.to_string()),
                }
            }
        };
        Expr { span: place, kind }
    }

    fn literal(&mut self, written: &Written, pair: Pair<'_, Rule>) -> ExprKind {
        let mut parts = pair.into_inner();
        let Some(number) = parts.next() else { return ExprKind::Missing };
        let unit = parts.next().map(|p| self.unit(written, p));
        let value = number.as_str().parse::<f64>();
        match (value, unit) {
            _ if self.is_lost(written.part_at(number.as_span().start())) => ExprKind::Missing,
            (Ok(value), Some(unit)) => ExprKind::Quantity { value, unit },
            (Ok(value), None) => ExprKind::Number(value),
            (Err(_), _) => ExprKind::Missing,
        }
    }

    fn unit(&mut self, written: &Written, pair: Pair<'_, Rule>) -> Unit {
        let whole = span(written, &pair);
        let mut sign = 1;
        let mut factors = Vec::new();
        for part in pair.into_inner() {
            if part.as_rule() == Rule::per {
                sign = -1;
                continue;
            }
            let mut inner = part.into_inner();
            let Some(word) = inner.next() else { continue };
            let power = inner.next().map_or(1, |p| {
                let place = span(written, &p);
                self.small(p.as_str(), place)
            });
            factors.push((name(written, &word), sign * power));
        }
        Unit { factors, span: whole }
    }

    /// Joins two operands, unless that could be read in two ways.
    fn join(&mut self, left: Operand, op: Infix, place: Span, right: Operand) -> Operand {
        let whole = left.expr.span.to(right.expr.span);
        let missing = Operand { expr: Expr { span: whole, kind: ExprKind::Missing }, top: None, last: Last::Other };
        if left.expr.kind == ExprKind::Missing || right.expr.kind == ExprKind::Missing {
            return missing;
        }
        if op == Infix::Binary(BinaryOp::Divide) && self.is_doubtful_division(&left, place, &right) {
            return missing;
        }
        if op == Infix::Binary(BinaryOp::Power)
            && let Last::Quantity(literal) = left.last
        {
            // The mend says what was meant, so it is read that way.
            self.say(
                Diagnostic::error(codes::E0114, place, "a number with a unit is raised to a power without parentheses")
                    .note("a unit takes its power close to it and whole, as in `mm^2`")
                    .help(format!("write `({})` and then the power", self.source(literal)))
                    .suggest(literal, format!("({})", self.source(literal))),
            );
        }
        let single = single(op);
        if single.is_some() && (left.top == single || right.top == single) {
            if let Some(first) = self.lost_side(&left) {
                let operator = self.source(first).to_string();
                self.say(
                    Diagnostic::error(codes::E0107, first, format!("`{operator}` has no value after it on its line"))
                        .note("an entry goes on in the next line after an operator")
                        .help("write what it is compared with"),
                );
                return missing;
            }
            let (what, help) = match single {
                Some(Single::Power) => ("powers", "say with parentheses which one is meant: `a^(b^c)` or `(a^b)^c`"),
                Some(Single::Range) => ("ranges", "a range has two ends: `a .. b`"),
                _ => ("comparisons", "join two comparisons by `and`"),
            };
            self.say(Diagnostic::error(codes::E0120, place, format!("{what} do not chain")).help(help));
            return missing;
        }
        let (lower, upper) = (Box::new(left.expr), Box::new(right.expr));
        let kind = match op {
            Infix::Binary(op) => ExprKind::Binary(op, place, lower, upper),
            Infix::Range => ExprKind::Range(lower, upper),
        };
        Operand { expr: Expr { span: whole, kind }, top: single, last: right.last }
    }

    /// The comparison at the end of a line that has taken the next line for its right side.
    fn lost_side(&self, left: &Operand) -> Option<Span> {
        let ExprKind::Binary(_, operator, _, right) = &left.expr.kind else { return None };
        let between = Span { start: operator.end, end: right.span.start, ..*operator };
        (left.top == Some(Single::Comparison) && self.source(between).contains('\n')).then_some(*operator)
    }

    /// `1/mm`, `1/20 wave`, `kg/m/s`: said.
    fn is_doubtful_division(&mut self, left: &Operand, slash: Span, right: &Operand) -> bool {
        let close = slash.end == right.expr.span.start;
        let word = unit_word(&right.expr);
        match (left.last, word, right.last) {
            (Last::Number(number), Some(power), _) if close => {
                let unit = self.negative(right.expr.span, power);
                let (digits, name) = (self.source(number), self.source(right.expr.span));
                self.say(
                    Diagnostic::error(codes::E0113, number.to(right.expr.span), "a unit cannot begin with `/`")
                        .help(format!("write `{digits} {unit}`, or `{digits} / {name}` to divide by a value `{name}`"))
                        .suggest(number.to(right.expr.span), format!("{digits} {unit}")),
                );
                true
            }
            (Last::Quantity(quantity), Some(power), _) if close && quantity.end == slash.start => {
                let unit = self.negative(right.expr.span, power);
                let written = self.source(quantity).to_string();
                // One denominator stands there already; both go over the line as negative powers.
                let mended = match written.split_once('/') {
                    Some((above, below)) => {
                        let below = match below.split_once('^') {
                            Some((word, power)) => format!("{word}^-{power}"),
                            None => format!("{below}^-1"),
                        };
                        format!("{above}*{below}*{unit}")
                    }
                    None => format!("{written}*{unit}"),
                };
                self.say(
                    Diagnostic::error(codes::E0113, quantity.to(right.expr.span), "a unit has at most one `/`")
                        .help(format!("write `{mended}`"))
                        .suggest(quantity.to(right.expr.span), mended.as_str()),
                );
                true
            }
            (Last::Number(number), _, _) => {
                let ExprKind::Quantity { unit, .. } = &right.expr.kind else { return false };
                let Last::Quantity(_) = right.last else { return false };
                let below = Span { end: unit.span.start, ..right.expr.span };
                let (above, below, unit) = (self.source(number), self.source(below).trim_end(), self.source(unit.span));
                let whole = number.to(right.expr.span);
                let inverse = self.source(right.expr.span);
                self.say(
                    Diagnostic::error(
                        codes::E0113,
                        whole,
                        "the unit could belong to the fraction or to its lower part",
                    )
                    .help(format!("write `{above} {unit} / {below}`, or `{above} / ({inverse})`"))
                    .suggest(whole, format!("{above} {unit} / {below}")),
                );
                true
            }
            _ => false,
        }
    }

    /// The unit factor at `place`, its power `power`, written as a denominator without `/`.
    fn negative(&self, place: Span, power: Option<i32>) -> String {
        let word = self.source(place);
        let word = word.split('^').next().unwrap_or(word).trim_end();
        format!("{word}^{}", -power.unwrap_or(1))
    }

    fn source(&self, place: Span) -> &str {
        &self.writer.text[place.start as usize..place.end as usize]
    }
}

/// Whether an expression looks like one factor of a unit: a word, or a word with a whole power.
fn unit_word(expr: &Expr) -> Option<Option<i32>> {
    match &expr.kind {
        ExprKind::Name(_) => Some(None),
        ExprKind::Binary(BinaryOp::Power, _, word, power) => match (&word.kind, &power.kind) {
            (ExprKind::Name(_), ExprKind::Number(power)) if power.fract() == 0.0 && power.abs() <= 100.0 => {
                Some(Some(*power as i32))
            }
            _ => None,
        },
        _ => None,
    }
}

fn single(op: Infix) -> Option<Single> {
    use BinaryOp as B;
    match op {
        Infix::Range => Some(Single::Range),
        Infix::Binary(B::Less | B::LessEqual | B::Greater | B::GreaterEqual | B::Equal | B::NotEqual) => {
            Some(Single::Comparison)
        }
        Infix::Binary(B::Power) => Some(Single::Power),
        Infix::Binary(_) => None,
    }
}

/// The level of an operator between operands and what it is.
fn infix(pair: &Pair<'_, Rule>) -> Option<(u8, Infix)> {
    let (level, op) = match pair.as_rule() {
        Rule::range => return Some((5, Infix::Range)),
        Rule::or => (1, BinaryOp::Or),
        Rule::and => (2, BinaryOp::And),
        Rule::comparison => (4, comparison_of(pair.as_str())),
        Rule::add => (6, BinaryOp::Add),
        Rule::subtract => (6, BinaryOp::Subtract),
        Rule::multiply => (7, BinaryOp::Multiply),
        Rule::divide => (7, BinaryOp::Divide),
        Rule::power => (9, BinaryOp::Power),
        _ => return None,
    };
    Some((level, Infix::Binary(op)))
}
