//! The typed tree: every name resolved, every dimension proved; numbers not yet worked out.
//!
//! In: made by the other files of `check`. Out: what `eval` walks. No name is looked up again after this tree.

use super::types::{SchemaId, Type};
use crate::source::Span;
use crate::syntax::ast::BinaryOp;

/// A value defined at top level (`let`, `param`): an index into `Checked::globals`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct GlobalId(pub usize);

/// An expression whose type is known.
#[derive(Clone, Debug, PartialEq)]
pub struct Typed {
    pub span: Span,
    pub ty: Type,
    pub kind: TypedKind,
}

/// A unit as used: `1 unit = factor` in SI, times the job's wavelength to the power `waves`.
#[derive(Clone, Debug, PartialEq)]
pub struct UnitUse {
    pub text: String,
    pub factor: f64,
    pub waves: i32,
}

#[derive(Clone, Debug, PartialEq)]
pub enum TypedKind {
    /// The number as written, in its unit.
    Number(f64, Option<UnitUse>),
    Bool(bool),
    Text(String),
    /// The whole path of a file, as the file provider resolved it.
    File(String),
    Symbol(String),
    None,
    Global(GlobalId),
    /// A quantity that a later pass finds, by its path without `result.`
    Result(String),
    /// In a `check` line: a field of the record.
    SiblingField(String),
    Record(SchemaId, Vec<FieldValue>),
    /// A copy of the record with these fields changed.
    With(Box<Typed>, Vec<FieldValue>),
    Member(Box<Typed>, String),
    Call(Callee, Vec<Typed>),
    List(Vec<Typed>),
    /// A parameter of the function around it, or the `i` of `for i in …`: an index into the values known there.
    Local(usize),
    /// The element, once for each whole number of the range; the number is the local value `slot`.
    Comprehension {
        element: Box<Typed>,
        slot: usize,
        over: Box<Typed>,
    },
    /// The conditions with their values, and the value when none holds.
    If {
        branches: Vec<(Typed, Typed)>,
        otherwise: Box<Typed>,
    },
    Range(Box<Typed>, Box<Typed>),
    Minus(Box<Typed>),
    Not(Box<Typed>),
    /// The power's exponent, when the operator is `^`, is a plain number.
    Binary(BinaryOp, Box<Typed>, Box<Typed>),
    /// Reported already.
    Failed,
}

/// A field that a record gives.
#[derive(Clone, Debug, PartialEq)]
pub struct FieldValue {
    pub name: String,
    pub name_span: Span,
    pub value: Typed,
}

impl Typed {
    /// What stands where something was wrong and has been reported.
    pub fn failed(span: Span) -> Typed {
        Typed { span, ty: Type::Failed, kind: TypedKind::Failed }
    }
}

/// What is called.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Callee {
    /// A function written in the language: an index into `Checked::globals`.
    Written(GlobalId),
    BuiltIn(Function),
}

/// The functions whose bodies the compiler has. `stdlib/functions.polish` declares and describes them.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Function {
    Tangential,
    Arc,
    Sin,
    Cos,
    Tan,
    Asin,
    Acos,
    Atan2,
    Sqrt,
    Abs,
    Min,
    Max,
    Sum,
    Count,
    Floor,
    Ceil,
    Round,
}

impl Function {
    /// All functions with their names.
    pub const ALL: [(&'static str, Function); 17] = [
        ("tangential", Function::Tangential),
        ("arc", Function::Arc),
        ("sin", Function::Sin),
        ("cos", Function::Cos),
        ("tan", Function::Tan),
        ("asin", Function::Asin),
        ("acos", Function::Acos),
        ("atan2", Function::Atan2),
        ("sqrt", Function::Sqrt),
        ("abs", Function::Abs),
        ("min", Function::Min),
        ("max", Function::Max),
        ("sum", Function::Sum),
        ("count", Function::Count),
        ("floor", Function::Floor),
        ("ceil", Function::Ceil),
        ("round", Function::Round),
    ];

    /// The function of that name.
    pub fn find(name: &str) -> Option<Function> {
        Function::ALL.iter().find(|(n, _)| *n == name).map(|(_, function)| *function)
    }

    /// Its name in the language.
    pub fn name(self) -> &'static str {
        Function::ALL.iter().find(|(_, f)| *f == self).map_or("", |(name, _)| name)
    }
}
