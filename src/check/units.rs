//! Units as written: what `mm/s^2` means, and what the `unit` items of stdlib declare.

use super::load::ModuleId;
use super::meant::unit_meant;
use super::mismatch::units_that_fit;
use super::similar::nearest;
use super::typed::UnitUse;
use super::{Checker, Place, Want, Wave};
use crate::diagnostics::{Diagnostic, codes};
use crate::syntax::ast::{BinaryOp, Expr, ExprKind, Name, Type as TypeSyntax, UnaryOp, Unit};
use crate::units::{Dimension, Ratio, UnitMeaning};

/// A constant of a `unit` item: the number in SI, its dimension, how many times the wavelength is a factor.
struct Constant {
    value: f64,
    dimension: Dimension,
    waves: i32,
}

/// The unit after a list, and its dimension.
pub(super) type ListUnit = (UnitUse, Dimension);

/// A unit means nothing, and that was said.
pub(super) struct Unknown;

impl Checker<'_> {
    /// The unit after a list, if there is one.
    pub(super) fn unit_of_list(
        &mut self,
        place: Place,
        unit: Option<&Unit>,
        element: Option<&Want>,
    ) -> Result<Option<ListUnit>, Unknown> {
        let Some(unit) = unit else { return Ok(None) };
        let wanted = element.and_then(|want| want.ty.required().dimension());
        self.unit(place, unit, wanted).map(Some).ok_or(Unknown)
    }

    /// A unit's size and dimension; what is wrong is said.
    pub(super) fn unit(
        &mut self,
        place: Place,
        unit: &Unit,
        wanted: Option<Dimension>,
    ) -> Option<(UnitUse, Dimension)> {
        let (mut above, mut below, mut dimension, mut waves) = (1.0, 1.0, Some(Dimension::NUMBER), 0_i32);
        for (name, power) in &unit.factors {
            let Some(meaning) = self.vocabulary.units.unit(&name.text) else {
                self.say_unknown_unit(name, wanted);
                return None;
            };
            let size = match meaning {
                UnitMeaning::Fixed { factor, .. } => factor,
                UnitMeaning::Wavelength { factor } => {
                    if place.wave != Wave::Stated {
                        self.say_no_wavelength(place, name);
                        return None;
                    }
                    waves = waves.saturating_add(*power);
                    factor
                }
            };
            // Numerator and denominator apart: a decimal unit's quotient is then rounded once.
            let raised = libm::pow(size, f64::from(power.unsigned_abs()));
            if *power < 0 {
                below *= raised
            } else {
                above *= raised
            }
            let exponent = Ratio::new(i64::from(*power), 1);
            let part = exponent.and_then(|exponent| meaning.dimension().power(exponent));
            dimension = dimension.zip(part).and_then(|(a, b)| a.times(b));
        }
        let factor: f64 = above / below;
        let sane = factor.is_finite() && factor > 0.0;
        match dimension {
            Some(dimension) if sane => {
                let text = self.sources.slice(unit.span).to_string();
                Some((UnitUse { text, factor, waves }, dimension))
            }
            _ => {
                self.say(Diagnostic::error(codes::E0306, unit.span, "the power of this unit is too large"));
                None
            }
        }
    }

    fn say_no_wavelength(&mut self, place: Place, name: &Name) {
        let message = format!("the unit `{}` needs a wavelength, and none is stated here", name.text);
        let help = match place.wave {
            Wave::NotStated => "state it in the job: `wavelength: 632.8 nm`",
            _ => "use it only inside a job that states its `wavelength`; here write the length: `632.8 nm`",
        };
        self.say(Diagnostic::error(codes::E0218, name.span, message).help(help));
    }

    fn say_unknown_unit(&mut self, name: &Name, wanted: Option<Dimension>) {
        let mut diagnostic = Diagnostic::error(codes::E0210, name.span, format!("there is no unit `{}`", name.text));
        // A unit that would fit here is meant rather than one that would not: `mm` for `MM`, not `mN`.
        let table = &self.vocabulary.units;
        let fits = |unit: &&str| wanted.is_none() || table.unit(unit).map(UnitMeaning::dimension) == wanted;
        if let Some(meant) = unit_meant(table, &name.text) {
            diagnostic = diagnostic.help(format!("write `{meant}`")).suggest(name.span, meant);
        } else if let Some(near) = nearest(&name.text, table.unit_names().filter(fits)) {
            diagnostic = diagnostic.help(format!("did you mean `{near}`?")).suggest(name.span, near);
        }
        if let Some(fitting) = wanted.and_then(units_that_fit) {
            diagnostic = diagnostic.note(format!("units that fit here: {fitting}"));
        }
        // No unit's name has more than six letters.
        if diagnostic.help.is_none() && name.text.chars().count() > 6 {
            diagnostic = diagnostic.help("units are written short, as in `4 mm`, `20 deg`, `3 s`");
        }
        self.say(diagnostic);
    }

    /// A `unit` item of stdlib.
    pub(super) fn declare_unit(
        &mut self,
        module: ModuleId,
        name: &Name,
        ty: Option<&TypeSyntax>,
        value: Option<&Expr>,
    ) {
        let meaning = match (ty, value) {
            (Some(ty), None) => {
                self.resolve_type(module, ty).dimension().map(|dimension| UnitMeaning::Fixed { factor: 1.0, dimension })
            }
            (_, Some(value)) => self.constant(value).and_then(|constant| match constant.waves {
                0 => Some(UnitMeaning::Fixed { factor: constant.value, dimension: constant.dimension }),
                1 => Some(UnitMeaning::Wavelength { factor: constant.value }),
                _ => None,
            }),
            (None, None) => None,
        };
        match meaning {
            Some(meaning) => self.vocabulary.units.add_unit(&name.text, meaning),
            None => self.say_unknown_unit(name, None),
        }
    }

    /// The little that a `unit` item may say: numbers, quantities, `pi`, `wavelength`, `*`, `/`, `-`.
    fn constant(&self, expr: &Expr) -> Option<Constant> {
        let plain = |value| Constant { value, dimension: Dimension::NUMBER, waves: 0 };
        match &expr.kind {
            ExprKind::Number(value) => Some(plain(*value)),
            ExprKind::Name(word) if word == "pi" => Some(plain(std::f64::consts::PI)),
            ExprKind::Name(word) if word == "wavelength" => {
                Some(Constant { value: 1.0, dimension: Dimension::LENGTH, waves: 1 })
            }
            ExprKind::Quantity { value, unit } => {
                let mut constant = plain(*value);
                for (name, power) in &unit.factors {
                    let (factor, waves) = match self.vocabulary.units.unit(&name.text)? {
                        UnitMeaning::Fixed { factor, .. } => (factor, 0),
                        UnitMeaning::Wavelength { factor } => (factor, 1),
                    };
                    let dimension = self.vocabulary.units.unit(&name.text)?.dimension();
                    let exponent = Ratio::new(i64::from(*power), 1)?;
                    // Division keeps a decimal unit the nearest number to its decimal value.
                    constant.value = if *power == -1 {
                        constant.value / factor
                    } else {
                        constant.value * libm::pow(factor, f64::from(*power))
                    };
                    constant.dimension = constant.dimension.times(dimension.power(exponent)?)?;
                    constant.waves += waves * power;
                }
                Some(constant)
            }
            ExprKind::Unary(UnaryOp::Minus, inner) => {
                let inner = self.constant(inner)?;
                Some(Constant { value: -inner.value, ..inner })
            }
            ExprKind::Binary(BinaryOp::Multiply, _, a, b) => {
                let (a, b) = (self.constant(a)?, self.constant(b)?);
                let dimension = a.dimension.times(b.dimension)?;
                Some(Constant { value: a.value * b.value, dimension, waves: a.waves + b.waves })
            }
            ExprKind::Binary(BinaryOp::Divide, _, a, b) => {
                let (a, b) = (self.constant(a)?, self.constant(b)?);
                let dimension = a.dimension.over(b.dimension)?;
                Some(Constant { value: a.value / b.value, dimension, waves: a.waves - b.waves })
            }
            _ => None,
        }
    }
}
