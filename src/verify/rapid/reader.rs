//! The reader of RAPID modules: text to [`Module`].
//!
//! In: the bytes of a file. Out: what it says, or the first place where it leaves the subset that polishc can prove. It
//! shares nothing with the emitter: it is written from the language, not from what is emitted.
//!
//! The subset: one `MODULE` with data, `PROC` and `FUNC`; instructions, late-bound calls, assignments, `IF`, `WHILE`,
//! `RETURN`; `MoveL` and `MoveAbsJ` with tool and work object. An expression is
//! `[NOT] term {(OR | XOR) term}` as the RAPID grammar has it, with `NOT` at the beginning only.

use super::lexer::{Fault, Lexer, Token};
use super::syntax::*;

/// Deepest nesting of brackets, `IF` and `WHILE` that is followed; programs need a handful.
const MOST_NESTING: usize = 64;

/// Most operators of one statement; the longest condition of a program has some twenty.
const MOST_OPERATORS: usize = 500;

/// Reads one module.
pub fn read(bytes: &[u8]) -> Result<Module, Fault> {
    let mut reader = Reader { lexer: Lexer::new(bytes), module: Module::default(), depth: 0, operators: 0 };
    reader.module()?;
    Ok(reader.module)
}

/// Reads statements that stand alone, for what a program is expected to say.
pub fn read_statements(text: &str) -> Result<Vec<Statement>, Fault> {
    let mut reader = Reader { lexer: Lexer::new(text.as_bytes()), module: Module::default(), depth: 0, operators: 0 };
    reader.statements(&[])
}

struct Reader<'a> {
    lexer: Lexer<'a>,
    module: Module,
    depth: usize,
    /// Operators of this statement so far.
    operators: usize,
}

type Read<T> = Result<T, Fault>;

impl<'a> Reader<'a> {
    fn fault<T>(&self, message: impl Into<String>) -> Read<T> {
        Err(Fault { line: self.lexer.line(), message: message.into() })
    }

    /// The next token, left in place.
    fn peek(&mut self) -> Read<Token<'a>> {
        self.lexer.skip()?;
        let mut ahead = self.lexer;
        ahead.next_token()
    }

    fn next(&mut self) -> Read<Token<'a>> {
        self.lexer.next_token()
    }

    /// Whether the word `keyword` comes next; it is left in place.
    fn at(&mut self, keyword: &str) -> Read<bool> {
        Ok(matches!(self.peek()?, Token::Word(word) if word.eq_ignore_ascii_case(keyword)))
    }

    fn take_word(&mut self, keyword: &str) -> Read<bool> {
        let found = self.at(keyword)?;
        if found {
            self.next()?;
        }
        Ok(found)
    }

    fn expect_word(&mut self, keyword: &str) -> Read<()> {
        if self.take_word(keyword)? {
            return Ok(());
        }
        let found = self.peek()?;
        self.fault(format!("`{keyword}` is missing before {}", describe(found)))
    }

    fn take_symbol(&mut self, symbol: &str) -> Read<bool> {
        let found = matches!(self.peek()?, Token::Symbol(s) if s == symbol);
        if found {
            self.next()?;
        }
        Ok(found)
    }

    fn expect_symbol(&mut self, symbol: &str) -> Read<()> {
        if self.take_symbol(symbol)? {
            return Ok(());
        }
        let found = self.peek()?;
        self.fault(format!("`{symbol}` is missing before {}", describe(found)))
    }

    fn name(&mut self) -> Read<&'a str> {
        match self.next()? {
            Token::Word(word) => Ok(word),
            other => self.fault(format!("a name is missing before {}", describe(other))),
        }
    }

    fn deeper(&mut self) -> Read<()> {
        self.depth += 1;
        if self.depth > MOST_NESTING {
            return self.fault(format!("more than {MOST_NESTING} levels are nested"));
        }
        Ok(())
    }

    fn binary(&mut self, operator: &'static str, left: Expression, right: Expression) -> Read<Expression> {
        self.operators += 1;
        if self.operators > MOST_OPERATORS {
            return self.fault(format!("one statement has more than {MOST_OPERATORS} operators"));
        }
        Ok(Expression::Binary(operator, Box::new(left), Box::new(right)))
    }

    fn module(&mut self) -> Read<()> {
        self.expect_word("MODULE")?;
        self.module.name = self.name()?.to_string();
        loop {
            if self.take_word("ENDMODULE")? {
                break;
            }
            if self.at("PROC")? || self.at("FUNC")? {
                let routine = self.routine()?;
                self.module.routines.push(routine);
            } else if let Some(data) = self.data()? {
                if !self.module.routines.is_empty() {
                    return self.fault("data must be declared before the first routine");
                }
                self.module.data.push(data);
            } else {
                let found = self.peek()?;
                return self.fault(format!(
                    "{} has no place here; a module holds data, `PROC` and `FUNC`, and ends with `ENDMODULE`",
                    describe(found)
                ));
            }
        }
        match self.next()? {
            Token::End => Ok(()),
            other => self.fault(format!("{} stands after `ENDMODULE`", describe(other))),
        }
    }

    /// A data declaration, if one comes next.
    fn data(&mut self) -> Read<Option<Data>> {
        let kind = if self.take_word("CONST")? {
            DataKind::Constant
        } else if self.take_word("VAR")? {
            DataKind::Variable
        } else if self.take_word("PERS")? {
            DataKind::Persistent
        } else {
            return Ok(None);
        };
        let line = self.lexer.line();
        self.operators = 0;
        let of_type = self.name()?.to_string();
        let name = self.name()?.to_string();
        let value = if self.take_symbol(":=")? { Some(self.expression()?) } else { None };
        self.expect_symbol(";")?;
        Ok(Some(Data { kind, of_type, name, value, line }))
    }

    fn routine(&mut self) -> Read<Routine> {
        let function = !self.take_word("PROC")?;
        if function {
            self.expect_word("FUNC")?;
        }
        let returns = if function { Some(self.name()?.to_string()) } else { None };
        let line = self.lexer.line();
        let name = self.name()?.to_string();
        self.expect_symbol("(")?;
        let mut parameters = Vec::new();
        if !self.take_symbol(")")? {
            loop {
                let of_type = self.name()?.to_string();
                parameters.push((of_type, self.name()?.to_string()));
                if self.take_symbol(")")? {
                    break;
                }
                self.expect_symbol(",")?;
            }
        }
        let mut data = Vec::new();
        while let Some(one) = self.data()? {
            data.push(one);
        }
        let end = if function { "ENDFUNC" } else { "ENDPROC" };
        let body = self.statements(&[end])?;
        self.expect_word(end)?;
        Ok(Routine { returns, name, parameters, data, body, line })
    }

    /// Statements up to one of the words `ends`, which is left in place; without any, up to the end of the text.
    fn statements(&mut self, ends: &[&str]) -> Read<Vec<Statement>> {
        self.deeper()?;
        let mut found = Vec::new();
        loop {
            let first = self.lexer.skip()?;
            let line = self.lexer.line();
            self.operators = 0;
            if first == b'%' {
                self.next()?;
                let name = self.expression()?;
                self.expect_symbol("%")?;
                self.expect_symbol(";")?;
                found.push(Statement { line, what: What::LateCall(name) });
                continue;
            }
            if !first.is_ascii_alphabetic() {
                if first == 0 && ends.is_empty() {
                    break;
                }
                let token = self.peek()?;
                return self.fault(format!("{} stands where a statement should begin", describe(token)));
            }
            let before = self.lexer;
            let word = self.lexer.word();
            // Moves first: nearly every statement is one.
            if word.eq_ignore_ascii_case("MoveL") || word.eq_ignore_ascii_case("MoveAbsJ") {
                let one = self.one_move(line, word.len() == 5)?;
                self.module.moves.push(one);
                found.push(Statement { line, what: What::Move(self.module.moves.len() - 1) });
                continue;
            }
            if ends.iter().any(|end| word.eq_ignore_ascii_case(end)) {
                self.lexer = before;
                break;
            }
            let what = self.statement(word)?;
            found.push(Statement { line, what });
        }
        self.depth -= 1;
        Ok(found)
    }

    /// The statement whose first word was just read.
    fn statement(&mut self, word: &'a str) -> Read<What> {
        match word.to_ascii_uppercase().as_str() {
            "IF" => return self.if_statement(),
            "WHILE" => {
                let condition = self.expression()?;
                self.expect_word("DO")?;
                let body = self.statements(&["ENDWHILE"])?;
                self.expect_word("ENDWHILE")?;
                return Ok(What::While(condition, body));
            }
            "RETURN" => {
                let value = if self.take_symbol(";")? { None } else { Some(self.expression()?) };
                if value.is_some() {
                    self.expect_symbol(";")?;
                }
                return Ok(What::Return(value));
            }
            word @ ("MOVEJ" | "MOVEC" | "FOR" | "TEST" | "GOTO" | "ERROR" | "UNDO" | "CONNECT" | "RAISE" | "RETRY"
            | "TRYNEXT" | "CONST" | "VAR" | "PERS" | "LOCAL" | "BACKWARD" | "TRAP") => {
                return self.fault(format!("this compiler cannot prove what `{word}` does to the path"));
            }
            _ => {}
        }
        // An assignment's target may have components.
        let mut target = word.to_string();
        while self.take_symbol(".")? {
            target.push('.');
            target.push_str(self.name()?);
        }
        if self.take_symbol(":=")? {
            let value = self.expression()?;
            self.expect_symbol(";")?;
            return Ok(What::Assign(Expression::Name(target), value));
        }
        if target.len() != word.len() {
            return self.fault(format!("`{target}` is not an instruction"));
        }
        let arguments = self.arguments()?;
        Ok(What::Instruction(target, arguments))
    }

    fn if_statement(&mut self) -> Read<What> {
        let mut arms = Vec::new();
        let mut otherwise = Vec::new();
        loop {
            let condition = self.expression()?;
            self.expect_word("THEN")?;
            let body = self.statements(&["ELSEIF", "ELSE", "ENDIF"])?;
            arms.push((condition, body));
            if self.take_word("ELSEIF")? {
                continue;
            }
            if self.take_word("ELSE")? {
                otherwise = self.statements(&["ENDIF"])?;
            }
            self.expect_word("ENDIF")?;
            return Ok(What::If(arms, otherwise));
        }
    }

    /// Arguments of an instruction, up to and with the `;`.
    fn arguments(&mut self) -> Read<Vec<Argument>> {
        let mut found = Vec::new();
        if self.take_symbol(";")? {
            return Ok(found);
        }
        loop {
            if self.lexer.skip()? != b'\\' {
                found.push(Argument { switch: None, value: Some(self.expression()?) });
            }
            while self.take_symbol("\\")? {
                let switch = Some(self.name()?.to_string());
                let value = if self.take_symbol(":=")? { Some(self.expression()?) } else { None };
                found.push(Argument { switch, value });
            }
            if self.take_symbol(";")? {
                return Ok(found);
            }
            self.expect_symbol(",")?;
        }
    }

    /// A move whose first word was just read: goal, speed, zone, tool, work object.
    fn one_move(&mut self, line: u32, linear: bool) -> Read<Move> {
        let goal = match (linear, self.robtarget()?) {
            (true, Some(target)) => Goal::Target(target),
            (true, None) => Goal::LinearTo(Box::new(self.expression()?)),
            (false, None) => Goal::JointsTo(Box::new(self.expression()?)),
            (false, Some(_)) => return self.fault("`MoveAbsJ` goes to joint angles, and this is a robtarget"),
        };
        self.comma()?;
        let speed = match self.numbers::<4>()? {
            Some(speed) => Speed::Written(speed),
            None => Speed::Other(Box::new(self.expression()?)),
        };
        let mut time = None;
        if self.lexer.take(b'\\')? {
            let switch = self.name()?;
            if !switch.eq_ignore_ascii_case("T") {
                return self.fault(format!("this compiler cannot prove what `\\{switch}` does to the path"));
            }
            self.expect_symbol(":=")?;
            time = Some(self.expression()?);
        }
        self.comma()?;
        let zone = self.interned()?;
        self.comma()?;
        let tool = self.interned()?;
        let mut object = None;
        if self.lexer.take(b'\\')? {
            let switch = self.name()?;
            if !switch.eq_ignore_ascii_case("WObj") {
                return self.fault(format!("this compiler cannot prove what `\\{switch}` does to the path"));
            }
            self.expect_symbol(":=")?;
            object = Some(self.interned()?);
        }
        if !self.lexer.take(b';')? {
            self.expect_symbol(";")?;
        }
        Ok(Move { line, goal, speed, time, zone, tool, object })
    }

    fn comma(&mut self) -> Read<()> {
        if self.lexer.take(b',')? { Ok(()) } else { self.expect_symbol(",") }
    }

    /// A name that many moves share, kept once.
    fn interned(&mut self) -> Read<Name> {
        if !self.lexer.skip()?.is_ascii_alphabetic() {
            let found = self.peek()?;
            return self.fault(format!("a name is missing before {}", describe(found)));
        }
        let word = self.lexer.word();
        let names = &mut self.module.names;
        // Few names are in use, so that looking through them is quicker than a map.
        let at = names.iter().position(|name| name == word).unwrap_or_else(|| {
            names.push(word.to_string());
            names.len() - 1
        });
        match u16::try_from(at) {
            Ok(at) => Ok(Name(at)),
            Err(_) => self.fault("the moves use too many names"),
        }
    }

    /// A list of exactly `N` written numbers, if one comes next; otherwise nothing is taken.
    fn numbers<const N: usize>(&mut self) -> Read<Option<[f32; N]>> {
        let before = self.lexer;
        let mut found = [0.0; N];
        if !self.lexer.take(b'[')? {
            return Ok(None);
        }
        for (i, place) in found.iter_mut().enumerate() {
            if i > 0 && !self.lexer.take(b',')? {
                self.lexer = before;
                return Ok(None);
            }
            match self.lexer.take_number()? {
                // Single precision, as the controller stores it.
                Some(value) => *place = value as f32,
                None => {
                    self.lexer = before;
                    return Ok(None);
                }
            }
        }
        if !self.lexer.take(b']')? {
            self.lexer = before;
            return Ok(None);
        }
        Ok(Some(found))
    }

    /// A robtarget of written numbers, if one comes next; otherwise nothing is taken.
    fn robtarget(&mut self) -> Read<Option<Robtarget>> {
        let before = self.lexer;
        let found = self.robtarget_parts()?;
        if found.is_none() {
            self.lexer = before;
        }
        Ok(found)
    }

    fn robtarget_parts(&mut self) -> Read<Option<Robtarget>> {
        if !self.lexer.take(b'[')? {
            return Ok(None);
        }
        let Some(position) = self.numbers::<3>()? else { return Ok(None) };
        if !self.lexer.take(b',')? {
            return Ok(None);
        }
        let Some(quaternion) = self.numbers::<4>()? else { return Ok(None) };
        if !self.lexer.take(b',')? {
            return Ok(None);
        }
        let Some(confdata) = self.numbers::<4>()? else { return Ok(None) };
        if !self.lexer.take(b',')? {
            return Ok(None);
        }
        let Some(external) = self.numbers::<6>()? else { return Ok(None) };
        if !self.lexer.take(b']')? {
            return Ok(None);
        }
        Ok(Some(Robtarget { position, quaternion, confdata, external }))
    }

    fn expression(&mut self) -> Read<Expression> {
        self.deeper()?;
        let negated = self.take_word("NOT")?;
        let mut left = self.logical_term()?;
        if negated {
            left = Expression::Unary("NOT", Box::new(left));
        }
        loop {
            let operator = if self.take_word("OR")? {
                "OR"
            } else if self.take_word("XOR")? {
                "XOR"
            } else {
                self.depth -= 1;
                return Ok(left);
            };
            let right = self.logical_term()?;
            left = self.binary(operator, left, right)?;
        }
    }

    fn logical_term(&mut self) -> Read<Expression> {
        let mut left = self.relation()?;
        while self.take_word("AND")? {
            let right = self.relation()?;
            left = self.binary("AND", left, right)?;
        }
        Ok(left)
    }

    fn relation(&mut self) -> Read<Expression> {
        let left = self.sum()?;
        for operator in ["<>", "<=", ">=", "=", "<", ">"] {
            if self.take_symbol(operator)? {
                let right = self.sum()?;
                return self.binary(operator, left, right);
            }
        }
        Ok(left)
    }

    fn sum(&mut self) -> Read<Expression> {
        let mut left = self.product()?;
        loop {
            let operator = if self.take_symbol("+")? {
                "+"
            } else if self.take_symbol("-")? {
                "-"
            } else {
                return Ok(left);
            };
            let right = self.product()?;
            left = self.binary(operator, left, right)?;
        }
    }

    fn product(&mut self) -> Read<Expression> {
        let mut left = self.primary()?;
        loop {
            let operator = if self.take_symbol("*")? {
                "*"
            } else if self.take_symbol("/")? {
                "/"
            } else {
                return Ok(left);
            };
            let right = self.primary()?;
            left = self.binary(operator, left, right)?;
        }
    }

    fn primary(&mut self) -> Read<Expression> {
        match self.next()? {
            Token::Number(value) => Ok(Expression::Number(value)),
            Token::Text(text) => Ok(Expression::Text(text.to_string())),
            Token::Symbol(sign @ ("-" | "+")) => {
                self.deeper()?;
                let inner = self.primary()?;
                self.depth -= 1;
                Ok(match (sign, inner) {
                    ("+", inner) => inner,
                    (_, Expression::Number(value)) => Expression::Number(-value),
                    (_, inner) => Expression::Unary("-", Box::new(inner)),
                })
            }
            Token::Symbol("(") => {
                let inner = self.expression()?;
                self.expect_symbol(")")?;
                Ok(inner)
            }
            Token::Symbol("[") => {
                let mut items = Vec::new();
                loop {
                    items.push(self.expression()?);
                    if self.take_symbol("]")? {
                        return Ok(Expression::List(items));
                    }
                    self.expect_symbol(",")?;
                }
            }
            Token::Word(word) => {
                if self.take_symbol("(")? {
                    let mut arguments = Vec::new();
                    if !self.take_symbol(")")? {
                        loop {
                            arguments.push(self.expression()?);
                            if self.take_symbol(")")? {
                                break;
                            }
                            self.expect_symbol(",")?;
                        }
                    }
                    return Ok(Expression::Call(word.to_string(), arguments));
                }
                let mut name = word.to_string();
                while self.take_symbol(".")? {
                    name.push('.');
                    name.push_str(self.name()?);
                }
                Ok(Expression::Name(name))
            }
            other => self.fault(format!("a value is missing before {}", describe(other))),
        }
    }
}

/// A token for a message.
fn describe(token: Token<'_>) -> String {
    match token {
        Token::Word(word) => format!("`{word}`"),
        Token::Number(value) => format!("the number {value}"),
        Token::Text(text) => format!("the text \"{text}\""),
        Token::Symbol(symbol) => format!("`{symbol}`"),
        Token::End => "the end of the text".into(),
    }
}
