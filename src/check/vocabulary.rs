//! The vocabulary as declared: dimensions, units, families, schemas, and the names of each file.
//!
//! In: the items of all files. Out: [`Vocabulary`](super::types::Vocabulary) and the scopes. Names first, then the types of fields, then the
//! expressions in schemas (defaults, limits, checks), since each may use what stands anywhere before it in this order.

use super::load::ModuleId;
use super::names::BUILT_IN_TYPES;
use super::types::{Check, Family, Field, Limit, Schema, SchemaId, Symbol, Type};
use super::{Binding, Checker, Place, Want};
use crate::diagnostics::{Diagnostic, codes};
use crate::source::Span;
use crate::syntax::ast::{
    BinaryOp, Expr, Item, ItemKind, Name, Restriction, Schema as SchemaSyntax, Type as TypeSyntax, TypeKind,
};
use crate::units::{Dimension, Ratio};
use std::collections::BTreeMap;
use std::sync::Arc;

impl<'a> Checker<'a> {
    /// Names of all files, then the types of all fields.
    pub(super) fn declare(&mut self) {
        let all = self.modules;
        self.each_item(|checker, module, item| checker.declare_measure(module, item));
        self.each_item(|checker, module, item| match &item.kind {
            ItemKind::Family { name } => checker.declare_family(module, item, name),
            ItemKind::Let { .. } | ItemKind::Param { .. } | ItemKind::Function { .. } => {
                checker.declare_global(module, item);
            }
            _ => {}
        });
        let mut schemas: Vec<(SchemaId, ModuleId, &'a SchemaSyntax)> = Vec::new();
        self.each_item(|checker, module, item| {
            if let ItemKind::Schema(schema) = &item.kind
                && let Some(id) = checker.declare_schema(module, item, schema)
            {
                schemas.push((id, module, schema));
            }
        });
        for (index, module) in all.iter().enumerate() {
            for used in &module.uses {
                self.declare_use(ModuleId(index), used);
            }
        }
        for (id, module, schema) in schemas {
            let mut fields: Vec<Field> = Vec::new();
            for field in &schema.fields {
                if let Some(first) = fields.iter().find(|f| f.name == field.name.text) {
                    let message = format!("the schema `{}` has two fields `{}`", schema.name.text, field.name.text);
                    let first = first.span;
                    self.say(Diagnostic::error(codes::E0206, field.name.span, message).also(first, "the first one"));
                    continue;
                }
                let ty = self.resolve_type(module, &field.ty);
                fields.push(Field {
                    name: field.name.text.clone(),
                    doc: field.doc.clone(),
                    span: field.name.span,
                    type_text: match self.sources.slice(field.ty.span) {
                        // Symbols with doc comments take several lines.
                        text if text.contains('\n') => self.vocabulary.type_text(&ty),
                        text => text.to_string(),
                    },
                    ty,
                    default: None,
                    default_text: field.default.as_ref().map(|value| self.sources.slice(value.span).to_string()),
                    restriction: None,
                    usual: None,
                });
            }
            self.vocabulary.schemas[id.0].fields = fields;
        }
    }

    fn each_item(&mut self, mut act: impl FnMut(&mut Checker<'a>, ModuleId, &'a Item)) {
        let modules = self.modules;
        // stdlib stands behind the job's files, but its names must be known first.
        for library in [true, false] {
            for (index, module) in modules.iter().enumerate().filter(|(_, m)| m.library.is_some() == library) {
                for item in &module.ast.items {
                    act(self, ModuleId(index), item);
                }
            }
        }
    }

    pub(super) fn is_library(&self, module: ModuleId) -> bool {
        self.modules[module.0].library.is_some()
    }

    fn is_core(&self, module: ModuleId) -> bool {
        self.modules[module.0].library.is_some_and(|file| file.core)
    }

    fn declare_measure(&mut self, module: ModuleId, item: &'a Item) {
        let (word, name) = match &item.kind {
            ItemKind::Dimension { name, .. } => ("dimension", name),
            ItemKind::Unit { name, .. } => ("unit", name),
            _ => return,
        };
        if !self.is_library(module) {
            let message = format!("a job's files cannot declare a {word}; `{}` is one", name.text);
            let help = "write the value in units that exist, or give it a name with `let`";
            self.say(Diagnostic::error(codes::E0211, item.span, message).help(help));
            return;
        }
        match &item.kind {
            ItemKind::Dimension { name, value: None } => {
                if let Some(dimension) = Dimension::base(&name.text) {
                    self.vocabulary.units.add_dimension(&name.text, dimension);
                }
            }
            ItemKind::Dimension { name, value: Some(value) } => {
                if let Some(dimension) = self.resolve_type(module, value).dimension() {
                    self.vocabulary.units.add_dimension(&name.text, dimension);
                }
            }
            ItemKind::Unit { name, ty, value } => self.declare_unit(module, name, ty.as_ref(), value.as_ref()),
            _ => {}
        }
    }

    fn taken_type(&self, module: ModuleId, name: &Name) -> Option<(Option<Span>, &'static str)> {
        if BUILT_IN_TYPES.contains(&name.text.as_str()) || self.vocabulary.units.dimension(&name.text).is_some() {
            return Some((None, "a type of the language"));
        }
        for (scope, whose) in [(&self.core, "a word of stdlib"), (&self.scopes[module.0], "defined before")] {
            let schema = scope.schemas.get(&name.text).map(|id| self.vocabulary.schema(*id).span);
            let family = scope.families.get(&name.text).map(|id| self.vocabulary.family(*id).span);
            if let Some(span) = schema.or(family) {
                return Some((Some(span), whose));
            }
        }
        None
    }

    /// Whether `name` is free for a schema or family; says so if not.
    fn type_is_free(&mut self, module: ModuleId, name: &Name) -> bool {
        let Some((first, whose)) = self.taken_type(module, name) else { return true };
        let mut diagnostic = Diagnostic::error(codes::E0206, name.span, format!("the name `{}` is {whose}", name.text))
            .help("choose another name");
        if let Some(first) = first {
            diagnostic = diagnostic.also(first, "defined here");
        }
        self.say(diagnostic);
        false
    }

    /// Whether another family has a member of this name: each family's members are looked up first where it is
    /// expected, so `frame_centre` may be a map's centre and a spot's origin.
    fn is_member_beside(&self, module: ModuleId, schema: &SchemaSyntax) -> bool {
        let Some(family) = &schema.family else { return false };
        let other =
            [&self.scopes[module.0], &self.core].into_iter().find_map(|scope| scope.schemas.get(&schema.name.text));
        let other = other.and_then(|id| self.vocabulary.schema(*id).family);
        other.is_some_and(|other| self.vocabulary.family(other).name != family.text)
    }

    fn declare_family(&mut self, module: ModuleId, item: &Item, name: &Name) {
        if !self.type_is_free(module, name) {
            return;
        }
        let id = super::FamilyId(self.vocabulary.families.len());
        let library = self.is_library(module);
        self.vocabulary.families.push(Family {
            name: name.text.clone(),
            doc: item.doc.clone(),
            span: name.span,
            library,
            members: Vec::new(),
        });
        let scope = if self.is_core(module) { &mut self.core } else { &mut self.scopes[module.0] };
        scope.families.insert(name.text.clone(), id);
    }

    fn declare_schema(&mut self, module: ModuleId, item: &Item, schema: &SchemaSyntax) -> Option<SchemaId> {
        if !self.is_member_beside(module, schema) && !self.type_is_free(module, &schema.name) {
            return None;
        }
        let id = SchemaId(self.vocabulary.schemas.len());
        let library = self.is_library(module);
        let mut family = None;
        if let Some(name) = &schema.family {
            let scope = &self.scopes[module.0].families;
            match scope.get(&name.text).or_else(|| self.core.families.get(&name.text)).copied() {
                None => self.say_unknown_type(module, name.span, &name.text),
                Some(found) if self.vocabulary.family(found).library && !library => {
                    let message = format!("a job cannot add `{}` to the family `{}`", schema.name.text, name.text);
                    let members = super::types::listed_or(&self.vocabulary.members(found));
                    self.say(
                        Diagnostic::error(codes::E0219, name.span, message)
                            .note("the compiler works out what each member does to the glass, so it must know them all")
                            .help(format!("use {members}")),
                    );
                }
                Some(found) => {
                    family = Some(found);
                    self.vocabulary.families[found.0].members.push(id);
                }
            }
        }
        self.vocabulary.schemas.push(Schema {
            name: schema.name.text.clone(),
            doc: item.doc.clone(),
            span: schema.name.span,
            family,
            library,
            fields: Vec::new(),
            checks: Vec::new(),
        });
        let scope = if self.is_core(module) { &mut self.core } else { &mut self.scopes[module.0] };
        scope.schemas.entry(schema.name.text.clone()).or_insert(id);
        Some(id)
    }

    fn declare_use(&mut self, module: ModuleId, used: &super::load::Use) {
        let Some(brought) = used.module else {
            self.bind_value(module, &used.name, Binding::Failed);
            return;
        };
        if used.whole {
            self.bind_value(module, &used.name, Binding::Module(brought));
            return;
        }
        let inside = &self.scopes[brought.0];
        let value = inside.values.get(&used.name.text).map(|(binding, _)| *binding);
        let schema = inside.schemas.get(&used.name.text).copied();
        if let Some(binding) = value {
            self.bind_value(module, &used.name, binding);
        }
        if let Some(schema) = schema {
            self.scopes[module.0].schemas.insert(used.name.text.clone(), schema);
        }
    }

    /// Gives a name in a file its meaning; says so if the name is taken.
    pub(super) fn bind_value(&mut self, module: ModuleId, name: &Name, binding: Binding) {
        let function = matches!(binding, Binding::Global(id) if self.globals[id.0].is_function());
        if self.is_built_in(module, &name.text, function) {
            let message = format!("the name `{}` is a word of the language", name.text);
            self.say(Diagnostic::error(codes::E0206, name.span, message).help("choose another name"));
            return;
        }
        if self.is_core(module) {
            self.core.values.insert(name.text.clone(), (binding, name.span));
        }
        if let Some((_, first)) = self.scopes[module.0].values.get(&name.text) {
            let first = *first;
            let message = format!("the name `{}` is defined twice in this file", name.text);
            self.say(
                Diagnostic::error(codes::E0206, name.span, message)
                    .also(first, "the first one")
                    .help("choose another name"),
            );
            return;
        }
        self.scopes[module.0].values.insert(name.text.clone(), (binding, name.span));
    }

    /// The type that is written; what is wrong in it is said.
    pub(super) fn resolve_type(&mut self, module: ModuleId, ty: &TypeSyntax) -> Type {
        match &ty.kind {
            TypeKind::Named(name) => self.resolve_named_type(module, name, ty.span),
            TypeKind::Product(a, b) => self.combined(module, ty.span, a, b, Dimension::times),
            TypeKind::Quotient(a, b) => self.combined(module, ty.span, a, b, Dimension::over),
            TypeKind::Power(base, numerator, denominator) => {
                let found = self.resolve_type(module, base);
                let exponent = Ratio::new(i64::from(*numerator), i64::from(*denominator));
                match (found, exponent) {
                    (Type::Failed, _) => Type::Failed,
                    (Type::Quantity(dimension), Some(exponent)) => {
                        self.quantity_or_too_large(ty.span, dimension.power(exponent))
                    }
                    _ => self.not_a_dimension(ty.span),
                }
            }
            TypeKind::List(element, length) => Type::List(Box::new(self.resolve_type(module, element)), *length),
            TypeKind::Range(element) => Type::Range(Box::new(self.resolve_type(module, element))),
            TypeKind::Optional(inner) => Type::Optional(Box::new(self.resolve_type(module, inner))),
            TypeKind::Symbols(symbols) => Type::Symbols(Arc::new(
                symbols.iter().map(|(name, doc)| Symbol { name: name.text.clone(), doc: doc.clone() }).collect(),
            )),
        }
    }

    fn combined(
        &mut self,
        module: ModuleId,
        span: Span,
        a: &TypeSyntax,
        b: &TypeSyntax,
        combine: fn(Dimension, Dimension) -> Option<Dimension>,
    ) -> Type {
        match (self.resolve_type(module, a), self.resolve_type(module, b)) {
            (Type::Failed, _) | (_, Type::Failed) => Type::Failed,
            (Type::Quantity(a), Type::Quantity(b)) => self.quantity_or_too_large(span, combine(a, b)),
            _ => self.not_a_dimension(span),
        }
    }

    fn quantity_or_too_large(&mut self, span: Span, dimension: Option<Dimension>) -> Type {
        match dimension {
            Some(dimension) => Type::Quantity(dimension),
            None => {
                self.say(Diagnostic::error(codes::E0306, span, "the power of this dimension is too large"));
                Type::Failed
            }
        }
    }

    fn not_a_dimension(&mut self, span: Span) -> Type {
        let message = "only dimensions can be multiplied, divided or raised to a power in a type";
        self.say(Diagnostic::error(codes::E0202, span, message));
        Type::Failed
    }

    fn resolve_named_type(&mut self, module: ModuleId, name: &str, span: Span) -> Type {
        match name {
            "Integer" => return Type::Integer,
            "Bool" => return Type::Bool,
            "Text" => return Type::Text,
            "File" => return Type::File,
            "Date" => return Type::Date,
            // Of a function of stdlib whose typing rule is the compiler's: a number of any dimension.
            "Quantity" if self.is_library(module) => return Type::Failed,
            _ => {}
        }
        if let Some(dimension) = self.vocabulary.units.dimension(name) {
            return Type::Quantity(dimension);
        }
        for scope in [&self.scopes[module.0], &self.core] {
            if let Some(family) = scope.families.get(name) {
                return Type::Family(*family);
            }
            if let Some(schema) = scope.schemas.get(name) {
                return Type::Schema(*schema);
            }
        }
        self.say_unknown_type(module, span, name);
        Type::Failed
    }

    /// Defaults, limits and checks of all schemas.
    pub(super) fn check_schemas(&mut self) {
        let mut all: Vec<(ModuleId, &'a SchemaSyntax)> = Vec::new();
        self.each_item(|_, module, item| {
            if let ItemKind::Schema(schema) = &item.kind {
                all.push((module, schema));
            }
        });
        // A schema that was refused has no id; the one found under its place is its own.
        let ids: BTreeMap<Span, SchemaId> =
            self.vocabulary.schemas.iter().enumerate().map(|(i, s)| (s.span, SchemaId(i))).collect();
        for (module, syntax) in all {
            let Some(id) = ids.get(&syntax.name.span).copied() else { continue };
            let place = Place::outside_job(module);
            for index in 0..self.vocabulary.schemas[id.0].fields.len() {
                let field = &self.vocabulary.schemas[id.0].fields[index];
                let (ty, what, span) = (field.ty.clone(), format!("`{}`", field.name), field.span);
                let Some(written) = syntax.fields.iter().find(|f| f.name.span == span) else { continue };
                let default = written.default.as_ref().map(|value| self.wanted(place, value, ty.clone(), what.clone()));
                let element = ty.element().clone();
                let restriction = written.restriction.as_ref().map(|limit| self.limit(place, limit, &element, &what));
                let usual = written
                    .usual
                    .as_ref()
                    .map(|range| self.limit(place, &Restriction::Range(range.clone()), &element, &what));
                let field = &mut self.vocabulary.schemas[id.0].fields[index];
                (field.default, field.restriction, field.usual) = (default, restriction, usual);
            }
            let place = Place { siblings: Some(id), ..place };
            for line in &syntax.checks {
                let text = self.sources.slice(line.condition.span).to_string();
                let condition = self.wanted(place, &line.condition, Type::Bool, "a `check` line".into());
                let reason = line.reason.clone();
                self.vocabulary.schemas[id.0].checks.push(Check { condition, text, reason });
            }
        }
    }

    /// `where` or `usual`, checked against the type of what it limits.
    pub(super) fn limit(&mut self, place: Place, limit: &Restriction, element: &Type, what: &str) -> Limit {
        match limit {
            Restriction::Range(range) => {
                let want = Want {
                    ty: Type::Range(Box::new(element.clone())),
                    what: format!("the limit of {what}"),
                    unit: None,
                };
                let checked = self.expression(place, range, Some(&want));
                let text = self.sources.slice(range.span).to_string();
                let bounds = match checked.kind {
                    super::typed::TypedKind::Range(from, to) => {
                        vec![(BinaryOp::GreaterEqual, *from), (BinaryOp::LessEqual, *to)]
                    }
                    _ => Vec::new(),
                };
                Limit { text, is_range: true, bounds }
            }
            Restriction::Comparisons(comparisons) => {
                let mut text = Vec::new();
                let mut kept = Vec::new();
                for (operator, _, bound) in comparisons {
                    text.push(format!("{} {}", symbol(*operator), self.sources.slice(bound.span)));
                    let checked = self.wanted(place, bound, element.clone(), format!("the limit of {what}"));
                    kept.push((*operator, checked));
                }
                Limit { text: text.join(" and "), is_range: false, bounds: kept }
            }
        }
    }

    /// An expression of a wanted type.
    pub(super) fn wanted(&mut self, place: Place, expr: &Expr, ty: Type, what: String) -> super::Typed {
        self.expression(place, expr, Some(&Want { ty, what, unit: None }))
    }
}

/// The operator as written.
pub(crate) fn symbol(operator: BinaryOp) -> &'static str {
    match operator {
        BinaryOp::Add => "+",
        BinaryOp::Subtract => "-",
        BinaryOp::Multiply => "*",
        BinaryOp::Divide => "/",
        BinaryOp::Power => "^",
        BinaryOp::Less => "<",
        BinaryOp::LessEqual => "<=",
        BinaryOp::Greater => ">",
        BinaryOp::GreaterEqual => ">=",
        BinaryOp::Equal => "==",
        BinaryOp::NotEqual => "!=",
        BinaryOp::And => "and",
        BinaryOp::Or => "or",
    }
}
