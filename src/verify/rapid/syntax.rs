//! What a RAPID module says, as data: the subset that polishc can prove.
//!
//! Made by the reader, read by the comparisons. Moves are kept apart in flat records, because a program has hundreds of
//! thousands of them; everything else is a small tree.

use std::fmt;

/// One module.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Module {
    pub name: String,
    pub data: Vec<Data>,
    pub routines: Vec<Routine>,
    /// All moves of the module, in the order of the text.
    pub moves: Vec<Move>,
    /// Names of tools, work objects and zones that the moves use.
    pub names: Vec<String>,
}

/// A data declaration: `CONST num a:=1;`.
#[derive(Clone, Debug, PartialEq)]
pub struct Data {
    pub kind: DataKind,
    pub of_type: String,
    pub name: String,
    pub value: Option<Expression>,
    pub line: u32,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum DataKind {
    Constant,
    Variable,
    Persistent,
}

/// `PROC` or `FUNC`.
#[derive(Clone, Debug, PartialEq)]
pub struct Routine {
    /// `None` for a procedure.
    pub returns: Option<String>,
    pub name: String,
    /// Type and name of each parameter.
    pub parameters: Vec<(String, String)>,
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
    /// An index into [`Module::moves`].
    Move(usize),
    /// An instruction, or the call of a procedure.
    Instruction(String, Vec<Argument>),
    /// `%"name"%;`
    LateCall(Expression),
    Assign(Expression, Expression),
    /// Conditions with their statements, then those of `ELSE`.
    If(Vec<(Expression, Vec<Statement>)>, Vec<Statement>),
    While(Expression, Vec<Statement>),
    Return(Option<Expression>),
}

/// An argument of an instruction: `value`, `\Switch` or `\Switch:=value`.
#[derive(Clone, Debug, PartialEq)]
pub struct Argument {
    pub switch: Option<String>,
    pub value: Option<Expression>,
}

#[derive(Clone, Debug, PartialEq)]
pub enum Expression {
    Number(f64),
    Text(String),
    /// A name, also with components: `tWheel.tload.mass`. `TRUE` and `FALSE` are names.
    Name(String),
    List(Vec<Expression>),
    Call(String, Vec<Expression>),
    /// `-` or `NOT`, spelt so.
    Unary(&'static str, Box<Expression>),
    Binary(&'static str, Box<Expression>, Box<Expression>),
}

/// A motion instruction, the numbers in single precision as the controller stores them.
#[derive(Clone, Debug, PartialEq)]
pub struct Move {
    pub line: u32,
    pub goal: Goal,
    pub speed: Speed,
    /// `\T`, seconds.
    pub time: Option<Expression>,
    pub zone: Name,
    pub tool: Name,
    pub object: Option<Name>,
}

/// An index into [`Module::names`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Name(pub u16);

/// Where a move goes.
#[derive(Clone, Debug, PartialEq)]
pub enum Goal {
    /// `MoveL` to a robtarget written out.
    Target(Robtarget),
    /// `MoveL` to anything else: a name, or a list with names in it.
    LinearTo(Box<Expression>),
    /// `MoveAbsJ`.
    JointsTo(Box<Expression>),
}

#[derive(Clone, Debug, PartialEq)]
pub enum Speed {
    /// `[v_tcp, v_ori, v_leax, v_reax]` written out.
    Written([f32; 4]),
    Other(Box<Expression>),
}

/// A robtarget whose external axes are unused.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Robtarget {
    pub position: [f32; 3],
    pub quaternion: [f32; 4],
    pub confdata: [f32; 4],
    pub external: [f32; 6],
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
            Expression::List(items) => {
                f.write_str("[")?;
                list(f, items)?;
                f.write_str("]")
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
            What::Instruction(name, arguments) => {
                f.write_str(name)?;
                for (i, argument) in arguments.iter().enumerate() {
                    if argument.switch.is_none() {
                        f.write_str(if i > 0 { "," } else { " " })?;
                    }
                    match (&argument.switch, &argument.value) {
                        (Some(switch), Some(value)) => write!(f, "\\{switch}:={value}")?,
                        (Some(switch), None) => write!(f, "\\{switch}")?,
                        (None, Some(value)) => write!(f, "{value}")?,
                        (None, None) => {}
                    }
                }
                Ok(())
            }
            What::LateCall(name) => write!(f, "%{name}%"),
            What::Assign(target, value) => write!(f, "{target}:={value}"),
            What::If(arms, _) => match arms.first() {
                Some((condition, _)) => write!(f, "IF {condition}"),
                None => f.write_str("IF"),
            },
            What::While(condition, _) => write!(f, "WHILE {condition}"),
            What::Return(Some(value)) => write!(f, "RETURN {value}"),
            What::Return(None) => f.write_str("RETURN"),
        }
    }
}
