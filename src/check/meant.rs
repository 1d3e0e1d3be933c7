//! What was meant: the habits of other languages and of the shop floor behind a name that means nothing here.
//!
//! In: a word or an expression that cannot stand where it stands. Out: the mend, as help and as replacement text. Nothing is
//! changed by it: the checker says the same mistake with or without a mend.

use super::load::ModuleId;
use super::typed::{Typed, TypedKind};
use super::types::{Limit, Type};
use super::{Binding, Checker, Place, Want, Wave};
use crate::diagnostics::{Diagnostic, codes};
use crate::source::Span;
use crate::syntax::ast::{BinaryOp, Expr, ExprKind, UnaryOp};
use crate::units::{Dimension, UnitTable};

/// Units spelt out, without the plural `s`.
const SPELT_OUT: [(&str, &str); 33] = [
    ("metre", "m"),
    ("meter", "m"),
    ("centimetre", "cm"),
    ("centimeter", "cm"),
    ("millimetre", "mm"),
    ("millimeter", "mm"),
    ("micrometre", "um"),
    ("micrometer", "um"),
    ("micron", "um"),
    ("nanometre", "nm"),
    ("nanometer", "nm"),
    ("angstrom", "Å"),
    ("in", "inch"),
    ("inche", "inch"),
    ("mil", "thou"),
    ("second", "s"),
    ("sec", "s"),
    ("minute", "min"),
    ("hour", "h"),
    ("hr", "h"),
    ("degree", "deg"),
    ("radian", "rad"),
    ("turn", "rev"),
    ("revolution", "rev"),
    ("percent", "%"),
    ("pct", "%"),
    ("gram", "g"),
    ("kilogram", "kg"),
    ("newton", "N"),
    ("pascal", "Pa"),
    ("hertz", "Hz"),
    ("lambda", "wave"),
    ("wavelength", "wave"),
];

/// Types as other languages call them.
const FOREIGN_TYPES: [(&str, &str); 20] = [
    ("f64", "Number"),
    ("f32", "Number"),
    ("float", "Number"),
    ("double", "Number"),
    ("real", "Number"),
    ("num", "Number"),
    ("i32", "Integer"),
    ("i64", "Integer"),
    ("u32", "Integer"),
    ("usize", "Integer"),
    ("int", "Integer"),
    ("boolean", "Bool"),
    ("string", "Text"),
    ("str", "Text"),
    ("char", "Text"),
    ("path", "File"),
    ("filename", "File"),
    ("scalar", "Number"),
    ("velocity", "Speed"),
    ("distance", "Length"),
];

/// The unit that is meant by a word that is none: `millimeters`, `RPM`, and `s^2` by `s2`.
pub(super) fn unit_meant(table: &UnitTable, word: &str) -> Option<String> {
    let lower = word.to_lowercase();
    let single = lower.strip_suffix('s').unwrap_or(&lower);
    let spelt = SPELT_OUT.iter().find(|(long, _)| *long == lower || *long == single).map(|(_, short)| *short);
    if let Some(short) = spelt.filter(|short| table.unit(short).is_some()) {
        return Some(short.to_string());
    }
    let power = word.strip_suffix(['2', '3', '4']).filter(|base| table.unit(base).is_some())?;
    Some(format!("{power}^{}", &word[power.len()..]))
}

/// The type that is meant by a word that is none: `Number` by `f64`, `Length` by `mm`.
pub(super) fn type_meant(table: &UnitTable, word: &str) -> Option<(String, &'static str)> {
    let lower = word.to_lowercase();
    if let Some((_, ours)) = FOREIGN_TYPES.iter().find(|(theirs, _)| *theirs == lower) {
        return Some((ours.to_string(), "is not a type of this language"));
    }
    let name = table.name(table.unit(word)?.dimension())?;
    Some((name.to_string(), "is a unit; a type is a dimension"))
}

/// Whether the text reads as a number with or without a unit: `50 mm`.
fn is_quantity(table: &UnitTable, text: &str) -> bool {
    let text = text.trim();
    let digits = text.len() - text.trim_start_matches(|c: char| c.is_ascii_digit() || matches!(c, '.' | '-')).len();
    let (number, unit) = (&text[..digits], text[digits..].trim());
    let known = |word: &str| table.unit(word.split('^').next().unwrap_or(word)).is_some();
    number.parse::<f64>().is_ok() && (unit.is_empty() || unit.split(['/', '*']).all(known))
}

/// Units in which the same number would keep to the limits, at most three; `written` is the unit that does not.
pub fn units_that_keep(
    table: &UnitTable,
    dimension: Dimension,
    (number, written): (f64, &str),
    mut keeps: impl FnMut(f64) -> bool,
) -> Vec<String> {
    const ABOVE: [&str; 4] = ["nm", "um", "mm", "m"];
    const BELOW: [&str; 2] = ["s", "min"];
    let size = |unit: &str| match table.unit(unit) {
        Some(crate::units::UnitMeaning::Fixed { factor, .. }) => Some(factor),
        _ => None,
    };
    let mut candidates: Vec<(String, f64)> =
        crate::units::format::units_of(dimension).iter().map(|unit| (unit.text.to_string(), unit.factor)).collect();
    if dimension == Dimension::whole(1, 0, -1, 0) {
        for (above, below) in ABOVE.iter().flat_map(|above| BELOW.iter().map(move |below| (above, below))) {
            candidates.extend(size(above).zip(size(below)).map(|(a, b)| (format!("{above}/{below}"), a / b)));
        }
    }
    let mut units: Vec<String> = Vec::new();
    for (unit, factor) in candidates {
        if keeps(number * factor) && !units.contains(&unit) {
            units.push(unit);
        }
    }
    // A slip changes one part of a unit: `um/min` is nearer to `mm/min` than `nm/s` is.
    let below = |unit: &str| unit.split_once('/').map(|(_, below)| below.to_string());
    units.sort_by_key(|unit| below(unit) != below(written));
    units.truncate(3);
    units
}

impl Checker<'_> {
    /// A text without its quotes where a text or a file is expected: `part: FS50-01`, `file: maps/flat.dat`.
    pub(super) fn unquoted(&mut self, place: Place, expr: &Expr, want: Option<&Want>) -> Option<Typed> {
        let want = want?;
        if !matches!(want.ty.required(), Type::Text | Type::File) || !self.is_unquoted(place, expr) {
            return None;
        }
        let text = self.sources.slice(expr.span).to_string();
        let message = format!("{} expects {}, and this has no quotes", want.what, self.vocabulary.in_words(&want.ty));
        let mended = format!("\"{text}\"");
        let diagnostic = Diagnostic::error(codes::E0301, expr.span, message).help(format!("write `{mended}`"));
        self.say(diagnostic.suggest(expr.span, mended));
        Some(Typed::failed(expr.span))
    }

    /// Whether an expression is made of words and signs, and its first word is no value.
    fn is_unquoted(&self, place: Place, expr: &Expr) -> bool {
        fn first(expr: &Expr) -> Option<&str> {
            match &expr.kind {
                ExprKind::Name(word) => Some(word),
                ExprKind::Member(base, _) => first(base),
                ExprKind::Binary(_, _, a, b) => first(a).filter(|_| plain(b)),
                _ => None,
            }
        }
        fn plain(expr: &Expr) -> bool {
            match &expr.kind {
                ExprKind::Name(_) | ExprKind::Number(_) | ExprKind::Quantity { .. } => true,
                ExprKind::Member(base, _) => plain(base),
                ExprKind::Binary(_, _, a, b) => plain(a) && plain(b),
                ExprKind::Unary(UnaryOp::Minus, inner) => plain(inner),
                _ => false,
            }
        }
        let Some(word) = first(expr) else { return false };
        let known =
            self.is_value(place.module, word) || word == "result" || self.schema_named(place.module, word).is_some();
        let one_line = !self.sources.slice(expr.span).contains('\n');
        !known && one_line && !self.may_be_broken(place.module) && self.near_value(place, word).is_none()
    }

    fn is_value(&self, module: ModuleId, word: &str) -> bool {
        self.locals.iter().any(|local| local.name == word)
            || [&self.scopes[module.0], &self.core].iter().any(|scope| scope.values.contains_key(word))
    }

    /// A value of this file with a name near to the word.
    fn near_value(&self, place: Place, word: &str) -> Option<&str> {
        let values = self.scopes[place.module.0].values.keys().map(String::as_str);
        super::similar::nearest(word, values)
    }

    /// `10 mm / s`, `500 mm / s^2`: blanks inside a unit. Said, if the word is no value.
    pub(super) fn spaced_unit(&mut self, place: Place, operator: BinaryOp, left: &Expr, right: &Expr) -> Option<Typed> {
        let word = match &right.kind {
            ExprKind::Name(word) => word,
            ExprKind::Binary(BinaryOp::Power, _, base, _) => match &base.kind {
                ExprKind::Name(word) => word,
                _ => return None,
            },
            _ => return None,
        };
        let ExprKind::Quantity { unit, .. } = &left.kind else { return None };
        let sign = match operator {
            BinaryOp::Multiply => "*",
            BinaryOp::Divide => "/",
            _ => return None,
        };
        if self.is_value(place.module, word) || self.vocabulary.units.unit(word).is_none() {
            return None;
        }
        let gap = Span { start: left.span.end, end: right.span.start, ..left.span };
        let mended = format!("{}{sign}{}", self.sources.slice(left.span), self.sources.slice(right.span));
        let message = format!("there is no value `{word}`, and a unit has no blanks inside it");
        let mut diagnostic = Diagnostic::error(codes::E0201, right.span, message).help(format!("write `{mended}`"));
        // A second `/` would not be a unit.
        if !self.sources.slice(unit.span).contains('/') {
            diagnostic = diagnostic.suggest(gap, sign);
        }
        self.say(diagnostic);
        Some(Typed::failed(left.span.to(right.span)))
    }

    /// What a word that names no value most likely meant, added to what is said of it.
    pub(super) fn with_meaning(&self, place: Place, word: &str, span: Span, diagnostic: Diagnostic) -> Diagnostic {
        let scope = &self.scopes[place.module.0];
        let modules = scope.values.iter().filter_map(|(name, (binding, _))| match binding {
            Binding::Module(module) => Some((name, *module)),
            _ => None,
        });
        for (name, module) in modules {
            if self.public_values(module).iter().any(|value| value == word) {
                let meant = format!("{name}.{word}");
                return diagnostic.help(format!("did you mean `{meant}`?")).suggest(span, meant);
            }
        }
        let result = self.core.schemas.get("result").map(|schema| self.vocabulary.schema(*schema));
        if place.results && result.is_some_and(|result| result.field(word).is_some()) {
            return diagnostic
                .help(format!("a result begins with `result`: `result.{word}`"))
                .suggest(Span { end: span.start, ..span }, "result.");
        }
        if matches!(word, "wavelength" | "lambda") && place.wave != Wave::OutsideJob {
            return diagnostic.help("the wavelength is a unit: `1 wave / 20` is a twentieth of it");
        }
        let field = self.vocabulary.schemas.iter().any(|schema| schema.field(word).is_some());
        if field && place.wave != Wave::OutsideJob {
            return diagnostic.help(format!(
                "`{word}` is a field, and a field is no value: give it a name with `let`, and use the name"
            ));
        }
        diagnostic
    }

    /// The mend of a value of a wrong type, where there is one.
    pub(super) fn with_mend(&self, diagnostic: Diagnostic, found: &Typed, expr: &Expr, want: &Want) -> Diagnostic {
        let text = self.sources.slice(expr.span);
        let literal = matches!(expr.kind, ExprKind::Number(_) | ExprKind::Quantity { .. });
        match (&found.ty, want.ty.required()) {
            (Type::Quantity(_), Type::Text | Type::File) if literal => {
                let mended = format!("\"{text}\"");
                diagnostic.help(format!("write `{mended}`")).suggest(expr.span, mended)
            }
            (Type::Text, Type::Quantity(_) | Type::Integer)
                if matches!(found.kind, TypedKind::Text(_))
                    && is_quantity(&self.vocabulary.units, text.trim_matches('"')) =>
            {
                let mended = text.trim_matches('"').trim().to_string();
                diagnostic.help(format!("write `{mended}`")).suggest(expr.span, mended)
            }
            (Type::Bool, Type::Symbols(symbols)) => {
                let word = match found.kind {
                    TypedKind::Bool(true) => "on",
                    TypedKind::Bool(false) => "off",
                    _ => return diagnostic,
                };
                match symbols.iter().any(|symbol| symbol.name == word) {
                    true => diagnostic.help(format!("write `{word}`")).suggest(expr.span, word),
                    false => diagnostic,
                }
            }
            (Type::Quantity(_) | Type::Integer, Type::Range(_)) => match &expr.kind {
                ExprKind::Binary(BinaryOp::Subtract, at, _, _) => {
                    diagnostic.help("a range is written with `..`, not with `-`").suggest(*at, "..")
                }
                _ => diagnostic.help(format!("write both ends: `{text} .. …`")),
            },
            (Type::List(_, Some(2)), Type::Range(_)) => match &expr.kind {
                ExprKind::List(ends, None) => {
                    let [a, b] = [&ends[0], &ends[1]].map(|end| self.sources.slice(end.span));
                    let mended = format!("{a} .. {b}");
                    diagnostic.help(format!("write `{mended}`")).suggest(expr.span, mended)
                }
                _ => diagnostic,
            },
            _ => diagnostic,
        }
    }

    /// A list of plain numbers where quantities are expected: one mistake, not one for each number.
    pub(super) fn plain_list(&mut self, elements: &[Expr], want: &Want, span: Span) -> Option<Typed> {
        let dimension = want.ty.required().dimension().filter(|dimension| !dimension.is_number())?;
        let plain = |expr: &Expr| match &expr.kind {
            ExprKind::Number(_) => true,
            ExprKind::Unary(UnaryOp::Minus, inner) => matches!(inner.kind, ExprKind::Number(_)),
            _ => false,
        };
        if elements.len() < 2 || !elements.iter().all(plain) {
            return None;
        }
        let words = self.vocabulary.units.in_words(dimension);
        let message = format!("{} expects {words} each, found plain numbers", want.what);
        let mut diagnostic = Diagnostic::error(codes::E0302, span, message);
        if let Some(fitting) = super::mismatch::units_that_fit(dimension) {
            diagnostic = diagnostic.note(format!("units that fit: {fitting}"));
        }
        let unit = want.unit.as_deref().or(crate::units::format::usual_unit(dimension));
        let unit = unit.map_or_else(|| dimension.si_unit(), str::to_string);
        let end = Span { start: span.end, ..span };
        self.say(
            diagnostic
                .help(format!("a unit after the list belongs to each: `[…] {unit}`"))
                .suggest(end, format!(" {unit}")),
        );
        Some(Typed::failed(span))
    }

    /// A call of a schema: `circle(62 mm)`.
    pub(super) fn with_schema_called(
        &self,
        module: ModuleId,
        word: &str,
        arguments: &[Expr],
        span: Span,
        diagnostic: Diagnostic,
    ) -> Diagnostic {
        let Some(schema) = self.schema_named(module, word) else { return diagnostic };
        let required: Vec<&str> =
            self.vocabulary.schema(schema).fields.iter().filter(|f| f.is_required()).map(|f| f.name.as_str()).collect();
        match (required.as_slice(), arguments) {
            ([field], [argument]) => {
                let mended = format!("{word} {{ {field}: {} }}", self.sources.slice(argument.span));
                diagnostic.help(format!("`{word}` is a record: `{mended}`")).suggest(span, mended)
            }
            ([], _) => diagnostic.help(format!("`{word}` is a record: `{word} {{ … }}`")),
            (fields, _) => {
                let fields = fields.iter().map(|field| format!("{field}: …")).collect::<Vec<_>>().join(", ");
                diagnostic.help(format!("`{word}` is a record: `{word} {{ {fields} }}`"))
            }
        }
    }
}

/// Whether a number without `%` was meant in parts of a hundred: `90` where a limit says `<= 100 %`.
pub fn was_percent(limit: &Limit) -> bool {
    limit.text.contains('%')
}
