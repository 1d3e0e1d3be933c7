//! The tree that the parser gives: what was written, with the place of everything, before any meaning.

use crate::source::Span;

/// One file.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Ast {
    /// `language N`, if it was read.
    pub language: Option<(u32, Span)>,
    pub items: Vec<Item>,
    /// `allow CODE because "…"`, wherever they stand, in order of place.
    pub allows: Vec<Allow>,
}

/// `allow W0401 because "the fluid is thick"`: silences a warning in the entry or item after it.
#[derive(Clone, Debug, PartialEq)]
pub struct Allow {
    pub code: Name,
    pub reason: String,
    /// The entry or item after it.
    pub target: Span,
    pub span: Span,
}

/// A word with its place.
#[derive(Clone, Debug, PartialEq)]
pub struct Name {
    pub text: String,
    pub span: Span,
}

/// A top-level item. Its doc comment (`///` lines, joined by newlines) and whether it is `pub` stand beside it.
#[derive(Clone, Debug, PartialEq)]
pub struct Item {
    pub doc: String,
    pub public: bool,
    pub span: Span,
    pub kind: ItemKind,
}

#[derive(Clone, Debug, PartialEq)]
pub enum ItemKind {
    /// `use std.robots.abb.irb6700_200_260` or `use "cell.polish"`.
    Use(UsePath),
    /// `let name: Type = value`.
    Let { name: Name, ty: Option<Type>, value: Expr },
    /// `param name: Type = value where … usual …`; without `= value` it must be given by `--set`.
    Param { name: Name, ty: Type, value: Option<Expr>, restriction: Option<Restriction>, usual: Option<Expr> },
    /// `fn area(d: Length) -> Area = pi / 4 * d^2`. Only stdlib may leave out the body: the compiler has it.
    Function { name: Name, parameters: Vec<Parameter>, result: Type, body: Option<Expr> },
    /// `assert tcp.z > 400 mm because "the guard stands there"`.
    Assert { condition: Expr, reason: String },
    /// `family Path`.
    Family { name: Name },
    /// `schema raster : Path { … }`.
    Schema(Schema),
    /// `job flat_340 { … }`.
    Job { name: Name, body: Block },
    /// `dimension Speed = Length / Time`; a base dimension has no right side. Only stdlib may say it.
    Dimension { name: Name, value: Option<Type> },
    /// `unit mm = 0.001 m` or, for a dimension's SI unit, `unit m: Length`. Only stdlib may say it.
    Unit { name: Name, ty: Option<Type>, value: Option<Expr> },
}

/// `d: Length` of a function.
#[derive(Clone, Debug, PartialEq)]
pub struct Parameter {
    pub name: Name,
    pub ty: Type,
}

#[derive(Clone, Debug, PartialEq)]
pub enum UsePath {
    /// `std.units`, as its words.
    Module(Vec<Name>),
    /// `"cell.polish"`.
    File { path: String, span: Span },
}

#[derive(Clone, Debug, PartialEq)]
pub struct Schema {
    pub name: Name,
    pub family: Option<Name>,
    pub fields: Vec<SchemaField>,
    pub checks: Vec<Check>,
}

/// `check inner_diameter < outer_diameter because "a ring has a hole"`; the reason may be left out.
#[derive(Clone, Debug, PartialEq)]
pub struct Check {
    pub condition: Expr,
    pub reason: Option<String>,
}

#[derive(Clone, Debug, PartialEq)]
pub struct SchemaField {
    pub doc: String,
    pub name: Name,
    pub ty: Type,
    pub default: Option<Expr>,
    pub restriction: Option<Restriction>,
    pub usual: Option<Expr>,
    pub span: Span,
}

/// `where 2 mm .. 30 mm` (a range), or `where > 0 mm and < 90 deg`.
#[derive(Clone, Debug, PartialEq)]
pub enum Restriction {
    Range(Expr),
    Comparisons(Vec<(BinaryOp, Span, Expr)>),
}

#[derive(Clone, Debug, PartialEq)]
pub struct Type {
    pub span: Span,
    pub kind: TypeKind,
}

#[derive(Clone, Debug, PartialEq)]
pub enum TypeKind {
    /// A dimension, a schema, a family, `Number`, `Integer`, `Bool`, `Text`, `File`, `Criterion`.
    Named(String),
    /// `Length / Time`, `Length * Length`.
    Product(Box<Type>, Box<Type>),
    Quotient(Box<Type>, Box<Type>),
    /// `Length^-3`, `Length^(1/2)`: numerator and denominator.
    Power(Box<Type>, i32, i32),
    /// `[T]`, `[T; 6]`.
    List(Box<Type>, Option<usize>),
    /// `T .. T`.
    Range(Box<Type>),
    /// `T?`.
    Optional(Box<Type>),
    /// `concave | convex`, each with its doc comment. One symbol alone is also a set.
    Symbols(Vec<(Name, String)>),
}

/// `{ … }`: entries in order.
#[derive(Clone, Debug, PartialEq)]
pub struct Block {
    pub entries: Vec<Entry>,
    /// From `{` to `}`.
    pub span: Span,
}

#[derive(Clone, Debug, PartialEq)]
pub struct Entry {
    pub doc: String,
    pub span: Span,
    pub kind: EntryKind,
}

#[derive(Clone, Debug, PartialEq)]
pub enum EntryKind {
    /// `name: value`. `workpiece { … }` is read as the field `workpiece` with the record `workpiece { … }`.
    Field { name: Name, value: Expr },
    /// A bare expression (lines of `require`).
    Expr(Expr),
}

#[derive(Clone, Debug, PartialEq)]
pub struct Expr {
    pub span: Span,
    pub kind: ExprKind,
}

#[derive(Clone, Debug, PartialEq)]
pub enum ExprKind {
    Number(f64),
    /// `4 mm`, `500 mm/s^2`: the number as written, the unit's factors.
    Quantity {
        value: f64,
        unit: Unit,
    },
    Text(String),
    Bool(bool),
    None,
    /// A word: a value, a symbol, a schema without fields. Which one, the checker knows.
    Name(String),
    /// `result.predicted.rms`, `cell.mrf`.
    Member(Box<Expr>, Name),
    /// `name(a, b)`.
    Call(Box<Expr>, Vec<Expr>),
    /// `raster { … }`; without a name, the schema is the field's.
    Record {
        schema: Option<Name>,
        body: Block,
    },
    /// `x with { … }`.
    With(Box<Expr>, Block),
    /// `[a, b]`, and `[1600, 0, 700] mm` with the unit after it.
    List(Vec<Expr>, Option<Unit>),
    /// `[45 deg * i for i in 0 .. 3]`, and `[45 * i for i in 0 .. 3] deg`.
    Comprehension {
        element: Box<Expr>,
        variable: Name,
        over: Box<Expr>,
        unit: Option<Unit>,
    },
    /// `if a then b else if c then d else e`: the conditions with their values, and the last value.
    If {
        branches: Vec<(Expr, Expr)>,
        otherwise: Box<Expr>,
    },
    Range(Box<Expr>, Box<Expr>),
    Unary(UnaryOp, Box<Expr>),
    Binary(BinaryOp, Span, Box<Expr>, Box<Expr>),
    /// What could not be read; a diagnostic was said, nothing more is to be said about it.
    Missing,
}

/// A unit as written: factors with their powers, in order. `mm/s^2` is `[(mm, 1), (s, -2)]`.
#[derive(Clone, Debug, PartialEq)]
pub struct Unit {
    pub factors: Vec<(Name, i32)>,
    pub span: Span,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum UnaryOp {
    Minus,
    Not,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum BinaryOp {
    Add,
    Subtract,
    Multiply,
    Divide,
    Power,
    Less,
    LessEqual,
    Greater,
    GreaterEqual,
    Equal,
    NotEqual,
    And,
    Or,
}
