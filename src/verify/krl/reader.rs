//! The reader of KRL files: text to [`Source`] and [`DataFile`].
//!
//! In: the bytes of a file. Out: what it says, or the first place where it leaves the subset that polishc can prove. It
//! shares nothing with the emitter: it is written from the language, not from what is emitted.
//!
//! The subset: `DEF` and `DEFFCT` with `:IN` parameters; calls, assignments, `IF`, `WHILE`, `LOOP`, `HALT`, `WAIT SEC`,
//! `RETURN`; `PTP` to joints; `LIN`, `SLIN`, and `SPLINE` blocks of `SPL` and `SLIN` to whole places (a component left out
//! keeps what it was, which no reader knows). In KRL `AND` and `OR` bind tighter than comparisons: a comparison beside
//! them must stand in brackets, so that nobody reads it otherwise.

use super::lexer::{Fault, Lexer, Token};
use super::syntax::*;

/// Deepest nesting of brackets and blocks that is followed; programs need a handful.
const MOST_NESTING: usize = 64;

/// Most operators of one statement; the longest condition of a program has some twenty.
const MOST_OPERATORS: usize = 500;

/// Statements of KRL that could move the robot or change the flow in ways that are not followed.
const UNPROVABLE: &[&str] = &[
    "CIRC",
    "CIRC_REL",
    "LIN_REL",
    "PTP_REL",
    "PTP_SPLINE",
    "SPTP",
    "SCIRC",
    "SWITCH",
    "FOR",
    "REPEAT",
    "GOTO",
    "EXIT",
    "INTERRUPT",
    "TRIGGER",
    "BRAKE",
    "RESUME",
    "CONTINUE",
    "PULSE",
    "ANOUT",
    "ANIN",
    "DIGIN",
    "SIGNAL",
    "STRUC",
    "ENUM",
    "EXT",
    "EXTFCT",
    "IMPORT",
    "CWRITE",
    "CONST_VEL",
    "TIME_BLOCK",
    "CCOMP",
    "CHANNEL",
    "CONFIRM",
    "DECL",
    "GLOBAL",
];

/// Reads a `.src` file.
pub fn read_source(bytes: &[u8]) -> Result<Source, Fault> {
    let mut reader = Reader::new(bytes);
    reader.head()?;
    loop {
        if let Token::End = reader.peek()? {
            break;
        }
        let routine = reader.routine()?;
        reader.source.routines.push(routine);
        reader.blank_lines()?;
    }
    if reader.source.routines.is_empty() {
        return reader.fault("the file has no `DEF`");
    }
    Ok(reader.source)
}

/// Reads a `.dat` file.
pub fn read_data(bytes: &[u8]) -> Result<DataFile, Fault> {
    let mut reader = Reader::new(bytes);
    reader.head()?;
    reader.expect_word("DEFDAT")?;
    let line = reader.lexer.line();
    let mut file = DataFile { name: reader.name()?.to_string(), line, data: Vec::new() };
    reader.end_of_line()?;
    loop {
        reader.blank_lines()?;
        if reader.take_word("ENDDAT")? {
            break;
        }
        let declared = reader.declaration(true)?;
        file.data.extend(declared);
    }
    reader.blank_lines()?;
    match reader.peek()? {
        Token::End => Ok(file),
        other => reader.fault(format!("{} stands after `ENDDAT`", describe(other))),
    }
}

/// Reads statements that stand alone, for what a program is expected to say.
pub fn read_statements(text: &str) -> Result<Vec<Statement>, Fault> {
    Reader::new(text.as_bytes()).statements(&[])
}

struct Reader<'a> {
    lexer: Lexer<'a>,
    source: Source,
    depth: usize,
    /// Operators of this statement so far.
    operators: usize,
    /// What `$VEL.CP` was set to in this routine; `None` where that is not known.
    speed: Option<f32>,
}

type Read<T> = Result<T, Fault>;

impl<'a> Reader<'a> {
    fn new(bytes: &'a [u8]) -> Reader<'a> {
        Reader { lexer: Lexer::new(bytes), source: Source::default(), depth: 0, operators: 0, speed: None }
    }

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

    /// The end of the statement: of the line, or of the text.
    fn end_of_line(&mut self) -> Read<()> {
        match self.peek()? {
            Token::EndOfLine => self.next().map(|_| ()),
            Token::End => Ok(()),
            other => self.fault(format!("{} stands where the line should end", describe(other))),
        }
    }

    fn blank_lines(&mut self) -> Read<()> {
        while self.peek()? == Token::EndOfLine {
            self.next()?;
        }
        Ok(())
    }

    /// Lines that begin with `&`, for the control's file manager, and blank ones.
    fn head(&mut self) -> Read<()> {
        loop {
            self.blank_lines()?;
            if self.peek()? != Token::Symbol("&") {
                return Ok(());
            }
            self.lexer.skip_line()?;
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

    /// A declaration of one or more names of a type. In a data file each may have a value.
    fn declaration(&mut self, in_data_file: bool) -> Read<Vec<Data>> {
        self.operators = 0;
        self.take_word("DECL")?;
        let line = self.lexer.line();
        let of_type = self.name()?;
        if ["GLOBAL", "CONST", "PUBLIC"].iter().any(|word| word.eq_ignore_ascii_case(of_type)) {
            return self.fault(format!("this compiler cannot prove what other programs do to `{of_type}` data"));
        }
        if UNPROVABLE.iter().any(|word| word.eq_ignore_ascii_case(of_type)) {
            return self.fault(format!("`{of_type}` stands where data should be declared"));
        }
        let of_type = of_type.to_string();
        let mut found = Vec::new();
        loop {
            let name = self.name()?.to_string();
            let value = if in_data_file && self.take_symbol("=")? { Some(self.expression()?) } else { None };
            found.push(Data { of_type: of_type.clone(), name, value, line });
            if !self.take_symbol(",")? {
                break;
            }
        }
        self.end_of_line()?;
        Ok(found)
    }

    /// Whether a line that begins so declares data: `DECL …`, or a type with a name behind it.
    fn declares(&mut self) -> Read<bool> {
        const TYPES: &[&str] = &["INT", "REAL", "BOOL", "CHAR", "AXIS", "E6AXIS", "FRAME", "POS", "E6POS", "LOAD"];
        let Token::Word(word) = self.peek()? else { return Ok(false) };
        if word.eq_ignore_ascii_case("DECL") {
            return Ok(true);
        }
        if !TYPES.iter().any(|of_type| of_type.eq_ignore_ascii_case(word)) {
            return Ok(false);
        }
        let mut ahead = self.lexer;
        ahead.next_token()?;
        Ok(matches!(ahead.next_token()?, Token::Word(_)))
    }

    fn routine(&mut self) -> Read<Routine> {
        let global = self.take_word("GLOBAL")?;
        let function = !self.take_word("DEF")?;
        if function {
            self.expect_word("DEFFCT")?;
        }
        let line = self.lexer.line();
        let returns = if function { Some(self.name()?.to_string()) } else { None };
        let name = self.name()?.to_string();
        self.expect_symbol("(")?;
        let mut parameters = Vec::new();
        if !self.take_symbol(")")? {
            loop {
                parameters.push(self.name()?.to_string());
                self.expect_symbol(":")?;
                if !self.take_word("IN")? {
                    return self.fault("this compiler cannot prove what a parameter that is not `:IN` does");
                }
                if self.take_symbol(")")? {
                    break;
                }
                self.expect_symbol(",")?;
            }
        }
        self.end_of_line()?;
        self.speed = None;
        let mut data = Vec::new();
        self.blank_lines()?;
        while self.declares()? {
            data.extend(self.declaration(false)?);
            self.blank_lines()?;
        }
        let end = if function { "ENDFCT" } else { "END" };
        let body = self.statements(&[end])?;
        self.expect_word(end)?;
        self.end_of_line()?;
        Ok(Routine { global, returns, name, parameters, data, body, line })
    }

    /// Statements up to one of the words `ends`, which is left in place; without any, up to the end of the text.
    fn statements(&mut self, ends: &[&str]) -> Read<Vec<Statement>> {
        self.deeper()?;
        let mut found = Vec::new();
        loop {
            let first = self.lexer.skip()?;
            let line = self.lexer.line();
            self.operators = 0;
            if first == b'\n' {
                self.next()?;
                continue;
            }
            if first == 0 && ends.is_empty() {
                break;
            }
            if !(first.is_ascii_alphabetic() || first == b'$' || first == b'_') {
                let token = self.peek()?;
                return self.fault(format!("{} stands where a statement should begin", describe(token)));
            }
            let before = self.lexer;
            let word = self.lexer.word();
            if ends.iter().any(|end| word.eq_ignore_ascii_case(end)) {
                self.lexer = before;
                break;
            }
            if word.eq_ignore_ascii_case("SPLINE") {
                self.block(&mut found)?;
                continue;
            }
            let what = self.statement(word, line)?;
            found.push(Statement { line, what });
        }
        self.depth -= 1;
        Ok(found)
    }

    /// A `SPLINE` block, whose first word was just read: nothing but segments may stand in one (KSS message 2359).
    fn block(&mut self, found: &mut Vec<Statement>) -> Read<()> {
        self.end_of_line()?;
        let first = self.source.moves.len();
        loop {
            if self.lexer.skip()? == b'\n' {
                self.next()?;
                continue;
            }
            let line = self.lexer.line();
            let Token::Word(word) = self.next()? else {
                return self.fault("this has no place in a `SPLINE` block");
            };
            if word.eq_ignore_ascii_case("SPL") || word.eq_ignore_ascii_case("SLIN") {
                let kind = if word.len() == 3 { Kind::Spl } else { Kind::BlockSlin };
                found.push(self.one_move(kind, line)?);
            } else if word.eq_ignore_ascii_case("ENDSPLINE") {
                break;
            } else {
                return self
                    .fault(format!("`{word}` has no place in a `SPLINE` block, which holds `SPL` and `SLIN` only"));
            }
        }
        self.end_of_line()?;
        let Some([opens, ..]) = self.source.moves.get_mut(first..) else {
            return self.fault("a `SPLINE` block has no segment");
        };
        opens.opens = true;
        if let Some(last) = self.source.moves.last_mut() {
            last.closes = true;
        }
        Ok(())
    }

    /// The statement whose first word was just read.
    fn statement(&mut self, word: &'a str, line: u32) -> Read<What> {
        let upper = word.to_ascii_uppercase();
        match upper.as_str() {
            "LIN" | "SLIN" => {
                let kind = if word.len() == 3 { Kind::Lin } else { Kind::Slin };
                return self.one_move(kind, line).map(|statement| statement.what);
            }
            "SPL" => return self.fault("`SPL` has its place in a `SPLINE` block only"),
            "PTP" => {
                let goal = self.expression()?;
                if let Token::Word(word) = self.peek()? {
                    return self.fault(format!("this compiler cannot prove what `{word}` does to a joint move"));
                }
                self.end_of_line()?;
                return Ok(What::JointMove(goal));
            }
            "IF" => {
                let condition = self.expression()?;
                self.expect_word("THEN")?;
                self.end_of_line()?;
                let body = self.statements(&["ELSE", "ENDIF"])?;
                let mut otherwise = Vec::new();
                if self.take_word("ELSE")? {
                    self.end_of_line()?;
                    otherwise = self.statements(&["ENDIF"])?;
                }
                self.expect_word("ENDIF")?;
                self.end_of_line()?;
                return Ok(What::If(condition, body, otherwise));
            }
            "WHILE" => {
                let condition = self.expression()?;
                self.end_of_line()?;
                let body = self.statements(&["ENDWHILE"])?;
                self.expect_word("ENDWHILE")?;
                self.end_of_line()?;
                return Ok(What::While(condition, body));
            }
            "LOOP" => {
                self.end_of_line()?;
                let body = self.statements(&["ENDLOOP"])?;
                self.expect_word("ENDLOOP")?;
                self.end_of_line()?;
                return Ok(What::Loop(body));
            }
            "HALT" => {
                self.end_of_line()?;
                return Ok(What::Halt);
            }
            "WAIT" => {
                if !self.take_word("SEC")? {
                    return self.fault("this compiler knows `WAIT SEC` and no other wait");
                }
                let time = self.expression()?;
                self.end_of_line()?;
                return Ok(What::Wait(time));
            }
            "RETURN" => {
                let value = match self.peek()? {
                    Token::EndOfLine | Token::End => None,
                    _ => Some(self.expression()?),
                };
                self.end_of_line()?;
                return Ok(What::Return(value));
            }
            word if UNPROVABLE.contains(&word) => {
                return self.fault(format!("this compiler cannot prove what `{word}` does to the path"));
            }
            _ => {}
        }
        if self.take_symbol("(")? {
            let arguments = self.arguments()?;
            self.end_of_line()?;
            // A routine may set the speed.
            self.speed = None;
            return Ok(What::Call(word.to_string(), arguments));
        }
        let target = self.components(word)?;
        if !self.take_symbol("=")? {
            return self.fault(format!("`{target}` is not a statement"));
        }
        let value = self.expression()?;
        self.end_of_line()?;
        if target.eq_ignore_ascii_case("$VEL.CP") {
            self.speed = match value {
                Expression::Number(speed) => Some(speed as f32),
                _ => return self.fault("`$VEL.CP` must be set to a number that is written out"),
            };
        } else if target.eq_ignore_ascii_case("$VEL") {
            self.speed = None;
        }
        Ok(What::Assign(target, value))
    }

    /// A move to a place, whose first word was just read: goal, `WITH $VEL.CP=…`, `C_DIS`.
    fn one_move(&mut self, kind: Kind, line: u32) -> Read<Statement> {
        let goal = match self.target()? {
            Some(target) => Goal::Written(target),
            None => Goal::Named(Box::new(self.expression()?)),
        };
        let (mut kind, mut speed) = (kind, self.speed);
        let first = self.lexer.skip()?;
        if first != b'\n' && first != 0 {
            let word = self.name()?;
            if word.eq_ignore_ascii_case("WITH") && kind != Kind::Lin {
                let mut variable = self.name()?.to_string();
                while self.lexer.take(b'.')? {
                    variable.push('.');
                    variable.push_str(self.name()?);
                }
                if !variable.eq_ignore_ascii_case("$VEL.CP") {
                    return self.fault(format!("this compiler cannot prove what `WITH {variable}` does to the path"));
                }
                self.expect_symbol("=")?;
                speed = match self.lexer.take_number()? {
                    Some(value) => Some(value as f32),
                    None => return self.fault("the speed behind `WITH` must be a number that is written out"),
                };
            } else if word.eq_ignore_ascii_case("C_DIS") && kind == Kind::Lin {
                kind = Kind::LinRounded;
            } else if matches!(kind, Kind::Spl | Kind::BlockSlin) {
                return self.fault(format!("`{word}` has no place in a `SPLINE` block"));
            } else {
                return self.fault(format!("this compiler cannot prove what `{word}` does to the path"));
            }
        }
        self.end_of_line()?;
        self.source.moves.push(Move { line, kind, opens: false, closes: false, goal, speed });
        Ok(Statement { line, what: What::Move(self.source.moves.len() - 1) })
    }

    /// A place of written numbers, if one comes next; otherwise nothing is taken. Its components may stand in any order, and
    /// behind a type (`{POS: X 1,…}`); all must be there.
    fn target(&mut self) -> Read<Option<Target>> {
        let before = self.lexer;
        if !self.lexer.take(b'{')? {
            return Ok(None);
        }
        let mut values = [f32::NAN; 8];
        let mut seen = 0_u8;
        loop {
            if !self.lexer.skip()?.is_ascii_alphabetic() {
                break;
            }
            let label = self.lexer.word();
            if self.lexer.take(b':')? {
                continue;
            }
            let Some(k) = TARGET.iter().position(|component| component.eq_ignore_ascii_case(label)) else { break };
            let Some(value) = self.lexer.take_number()? else { break };
            if seen & (1 << k) != 0 {
                return self.fault(format!("the place says `{label}` twice"));
            }
            seen |= 1 << k;
            // Single precision, as the controller stores it.
            values[k] = value as f32;
            if self.lexer.take(b'}')? {
                if let Some(k) = (0..8).find(|k| seen & (1 << k) == 0) {
                    let component = TARGET[k];
                    return self.fault(format!("the place does not say `{component}`, which would stay what it was"));
                }
                let [x, y, z, a, b, c, status, turn] = values;
                return Ok(Some(Target { position: [x, y, z], angles: [a, b, c], status, turn }));
            }
            if !self.lexer.take(b',')? {
                break;
            }
        }
        self.lexer = before;
        Ok(None)
    }

    /// Arguments of a call, up to and with the `)`.
    fn arguments(&mut self) -> Read<Vec<Expression>> {
        let mut found = Vec::new();
        if self.take_symbol(")")? {
            return Ok(found);
        }
        loop {
            found.push(self.expression()?);
            if self.take_symbol(")")? {
                return Ok(found);
            }
            self.expect_symbol(",")?;
        }
    }

    /// The name that begins with `word`, with components and whole-number indices.
    fn components(&mut self, word: &str) -> Read<String> {
        let mut name = word.to_string();
        loop {
            if self.take_symbol(".")? {
                name.push('.');
                name.push_str(self.name()?);
            } else if self.take_symbol("[")? {
                match self.lexer.take_number()? {
                    Some(index) if index.fract() == 0.0 && (0.0..1e6).contains(&index) => {
                        name.push_str(&format!("[{index}]"));
                    }
                    _ => return self.fault("an index must be a whole number that is written out"),
                }
                self.expect_symbol("]")?;
            } else {
                return Ok(name);
            }
        }
    }

    /// A comparison of what `AND` and `OR` join, or that alone.
    fn expression(&mut self) -> Read<Expression> {
        self.deeper()?;
        let (left, joined) = self.logical()?;
        for operator in ["==", "<>", "<=", ">=", "<", ">"] {
            if self.take_symbol(operator)? {
                let (right, joined_too) = self.logical()?;
                if joined || joined_too {
                    return self.fault("a comparison beside `AND` or `OR` must stand in brackets");
                }
                self.depth -= 1;
                return self.binary(operator, left, right);
            }
        }
        self.depth -= 1;
        Ok(left)
    }

    /// Terms joined by `OR`, those by `AND`; and whether anything was joined without brackets.
    fn logical(&mut self) -> Read<(Expression, bool)> {
        let (mut left, mut joined) = self.conjunction()?;
        loop {
            let operator = if self.take_word("OR")? {
                "OR"
            } else if self.take_word("EXOR")? {
                "EXOR"
            } else {
                return Ok((left, joined));
            };
            let (right, _) = self.conjunction()?;
            left = self.binary(operator, left, right)?;
            joined = true;
        }
    }

    fn conjunction(&mut self) -> Read<(Expression, bool)> {
        let mut left = self.sum()?;
        let mut joined = false;
        while self.take_word("AND")? {
            let right = self.sum()?;
            left = self.binary("AND", left, right)?;
            joined = true;
        }
        Ok((left, joined))
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
            Token::Symbol("#") => Ok(Expression::Symbol(self.name()?.to_string())),
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
            Token::Symbol("{") => self.aggregate(),
            Token::Word(word) if word.eq_ignore_ascii_case("NOT") => {
                self.deeper()?;
                let inner = self.primary()?;
                self.depth -= 1;
                Ok(Expression::Unary("NOT", Box::new(inner)))
            }
            Token::Word(word) => {
                if self.take_symbol("(")? {
                    return Ok(Expression::Call(word.to_string(), self.arguments()?));
                }
                Ok(Expression::Name(self.components(word)?))
            }
            other => self.fault(format!("a value is missing before {}", describe(other))),
        }
    }

    /// `{X 1,Y 2}`, whose bracket was just read; a type may stand first.
    fn aggregate(&mut self) -> Read<Expression> {
        self.deeper()?;
        let mut items = Vec::new();
        loop {
            let mut label = self.name()?;
            if items.is_empty() && self.take_symbol(":")? {
                label = self.name()?;
            }
            items.push((label.to_string(), self.expression()?));
            if self.take_symbol("}")? {
                self.depth -= 1;
                return Ok(Expression::Aggregate(items));
            }
            self.expect_symbol(",")?;
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
        Token::EndOfLine => "the end of the line".into(),
        Token::End => "the end of the text".into(),
    }
}
