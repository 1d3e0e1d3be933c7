//! What a KRL file says, as data: the subset that polishc can prove.
//!
//! Made by the reader, read by the comparisons. Moves to places are kept apart in flat records, because a program has tens
//! of thousands of them; everything else is a small tree.

use std::fmt;

/// A `.src` file.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Source {
    /// The first is what the file is named after.
    pub routines: Vec<Routine>,
    /// All moves to places, in the order of the text.
    pub moves: Vec<Move>,
}

/// A `.dat` file.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct DataFile {
    pub name: String,
    pub line: u32,
    pub data: Vec<Data>,
}

/// A declaration: `DECL INT a=1`, in a routine without a value.
#[derive(Clone, Debug, PartialEq)]
pub struct Data {
    pub of_type: String,
    pub name: String,
    pub value: Option<Expression>,
    pub line: u32,
}

/// `DEF` or `DEFFCT`.
#[derive(Clone, Debug, PartialEq)]
pub struct Routine {
    pub global: bool,
    /// `None` for a procedure.
    pub returns: Option<String>,
    pub name: String,
    /// Each `:IN`.
    pub parameters: Vec<String>,
    pub data: Vec<Data>,
    pub body: Vec<Statement>,
    pub line: u32,
}

#[derive(Clone, Debug, PartialEq)]
pub struct Statement {
    pub line: u32,
    pub what: What,
}

#[derive(Clone, Debug, PartialEq)]
pub enum What {
    /// An index into [`Source::moves`].
    Move(usize),
    /// `PTP` to joint angles.
    JointMove(Expression),
    /// A procedure with its arguments.
    Call(String, Vec<Expression>),
    Assign(String, Expression),
    If(Expression, Vec<Statement>, Vec<Statement>),
    While(Expression, Vec<Statement>),
    Loop(Vec<Statement>),
    Halt,
    Wait(Expression),
    Return(Option<Expression>),
}

#[derive(Clone, Debug, PartialEq)]
pub enum Expression {
    Number(f64),
    Text(String),
    /// A name with its components and index: `$AXIS_ACT.A1`, `TOOL_DATA[1]`. `TRUE` and `FALSE` are names.
    Name(String),
    /// `#T1`.
    Symbol(String),
    /// `{X 1,Y 2}`, nested too.
    Aggregate(Vec<(String, Expression)>),
    Call(String, Vec<Expression>),
    /// `-` or `NOT`, spelt so.
    Unary(&'static str, Box<Expression>),
    Binary(&'static str, Box<Expression>, Box<Expression>),
}

/// How a move to a place is made.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// `LIN`.
    Lin,
    /// `LIN … C_DIS`.
    LinRounded,
    /// `SLIN` that stands alone.
    Slin,
    /// `SLIN` inside a block.
    BlockSlin,
    /// `SPL`.
    Spl,
}

/// A move to a place, the numbers in single precision as the controller stores them.
#[derive(Clone, Debug, PartialEq)]
pub struct Move {
    pub line: u32,
    pub kind: Kind,
    /// Whether it is the first, and the last, of its `SPLINE` block.
    pub opens: bool,
    pub closes: bool,
    pub goal: Goal,
    /// m/s: what the move itself says, or what `$VEL.CP` was set to before it in the same routine.
    pub speed: Option<f32>,
}

#[derive(Clone, Debug, PartialEq)]
pub enum Goal {
    Written(Target),
    Named(Box<Expression>),
}

/// A place: X, Y, Z in mm, A, B, C in degrees, S and T.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Target {
    pub position: [f32; 3],
    pub angles: [f32; 3],
    pub status: f32,
    pub turn: f32,
}

/// The components of a place, in the order of [`Target`].
pub const TARGET: [&str; 8] = ["X", "Y", "Z", "A", "B", "C", "S", "T"];

impl fmt::Display for Kind {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Kind::Lin => "`LIN`",
            Kind::LinRounded => "`LIN` with `C_DIS`",
            Kind::Slin => "`SLIN` outside a block",
            Kind::BlockSlin => "`SLIN` in a block",
            Kind::Spl => "`SPL`",
        })
    }
}

impl fmt::Display for Expression {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let list = |f: &mut fmt::Formatter<'_>, items: &[Expression]| {
            for (i, item) in items.iter().enumerate() {
                write!(f, "{}{item}", if i > 0 { "," } else { "" })?;
            }
            Ok(())
        };
        // An operand that has operators itself stands in brackets.
        let operand = |f: &mut fmt::Formatter<'_>, inner: &Expression| match inner {
            Expression::Binary(..) => write!(f, "({inner})"),
            _ => write!(f, "{inner}"),
        };
        match self {
            Expression::Number(value) => write!(f, "{value}"),
            Expression::Text(text) => write!(f, "\"{text}\""),
            Expression::Name(name) => f.write_str(name),
            Expression::Symbol(name) => write!(f, "#{name}"),
            Expression::Aggregate(items) => {
                f.write_str("{")?;
                for (i, (label, value)) in items.iter().enumerate() {
                    write!(f, "{}{label} {value}", if i > 0 { "," } else { "" })?;
                }
                f.write_str("}")
            }
            Expression::Call(name, arguments) => {
                write!(f, "{name}(")?;
                list(f, arguments)?;
                f.write_str(")")
            }
            Expression::Unary(operator, inner) => {
                write!(f, "{operator}{}", if *operator == "NOT" { " " } else { "" })?;
                operand(f, inner)
            }
            Expression::Binary(operator, left, right) => {
                let gap = if operator.starts_with(|c: char| c.is_ascii_alphabetic()) { " " } else { "" };
                operand(f, left)?;
                write!(f, "{gap}{operator}{gap}")?;
                operand(f, right)
            }
        }
    }
}

impl fmt::Display for Statement {
    /// The statement's first line, as a person would say which one it is.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match &self.what {
            What::Move(_) => f.write_str("a move"),
            What::JointMove(goal) => write!(f, "PTP {goal}"),
            What::Call(name, arguments) => write!(f, "{}", Expression::Call(name.clone(), arguments.clone())),
            What::Assign(target, value) => write!(f, "{target}={value}"),
            What::If(condition, ..) => write!(f, "IF {condition}"),
            What::While(condition, _) => write!(f, "WHILE {condition}"),
            What::Loop(_) => f.write_str("LOOP"),
            What::Halt => f.write_str("HALT"),
            What::Wait(time) => write!(f, "WAIT SEC {time}"),
            What::Return(Some(value)) => write!(f, "RETURN {value}"),
            What::Return(None) => f.write_str("RETURN"),
        }
    }
}
