//! Programs made at random: right in their syntax, without any sense, and with blanks wherever a blank may stand.

use std::fmt::Write;

/// Numbers that look random and are the same on every machine (SplitMix64, Steele, Lea and Flood 2014).
pub struct Random(u64);

impl Random {
    pub fn new(seed: u64) -> Random {
        Random(seed)
    }

    pub fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ (z >> 31)
    }

    /// A number below `end`.
    pub fn below(&mut self, end: usize) -> usize {
        (self.next() % end as u64) as usize
    }

    pub fn chance(&mut self, percent: usize) -> bool {
        self.below(100) < percent
    }

    pub fn one_of<'t>(&mut self, words: &[&'t str]) -> &'t str {
        words[self.below(words.len())]
    }
}

/// What may stand between two lexemes.
#[derive(Clone, Copy, PartialEq)]
pub enum Between {
    /// Nothing: the two belong together (`mm^2`).
    Nothing,
    /// Blanks and comments, on one line.
    Line,
    /// The same, with at least one blank.
    Blank,
    /// Also ends of lines.
    Lines,
    /// An end of a line, at least.
    Newline,
}

/// How blanks, ends of lines and comments are chosen.
pub struct Blanks {
    /// Percent of places with something unusual.
    pub wild: usize,
    comments: usize,
    newline: &'static str,
}

impl Blanks {
    pub fn new(random: &mut Random) -> Blanks {
        let newline = if random.chance(20) { "\r\n" } else { "\n" };
        Blanks { wild: [0, 10, 40][random.below(3)], comments: 0, newline }
    }

    fn blank(&mut self, random: &mut Random, out: &mut String) {
        out.push_str(random.one_of(&["", " ", " ", " ", "  ", "    ", "\t", "\u{a0}"]));
    }

    fn comment(&mut self, random: &mut Random, out: &mut String) {
        // `a /` and a comment close to it would be another comment.
        if out.ends_with('/') {
            out.push(' ');
        }
        self.comments += 1;
        let number = self.comments;
        let newline = self.newline;
        let text = match random.below(4) {
            0 => format!("/* c{number} */"),
            1 => format!("/*c{number}{newline}     more {newline}{newline} of it*/"),
            2 => format!("/* c{number} /* inner // */ \" {{ /* }} */*/"),
            _ => format!("/** c{number} **/"),
        };
        out.push_str(&text);
    }

    fn end_line(&mut self, random: &mut Random, out: &mut String) {
        if random.chance(self.wild) {
            // After a unit `mm//s` is taken for a slip.
            if out.ends_with(|c: char| c == '/' || c.is_alphanumeric()) {
                out.push(' ');
            }
            self.comments += 1;
            let slashes = random.one_of(&["//", "// ", "//// ", "//   ", "///", "/// "]);
            let end = random.one_of(&["", " \" */ {", " [(", "   ", "\t"]);
            write!(out, "{slashes}c{}{end}", self.comments).expect("text");
        }
        out.push_str(self.newline);
    }

    /// Puts something between what stands in `out` and what comes.
    pub fn put(&mut self, random: &mut Random, between: Between, out: &mut String) {
        let before = out.len();
        match between {
            Between::Nothing => return,
            Between::Line | Between::Blank => {
                if !random.chance(self.wild) {
                    out.push(' ');
                } else {
                    self.blank(random, out);
                    if random.chance(self.wild) {
                        self.comment(random, out);
                        self.blank(random, out);
                    }
                }
            }
            Between::Lines if !random.chance(self.wild) => return self.put(random, Between::Line, out),
            Between::Lines | Between::Newline => {
                for _ in 0..1 + random.below(3) * random.below(2) {
                    if random.chance(self.wild / 2) {
                        self.blank(random, out);
                        self.comment(random, out);
                    }
                    self.blank(random, out);
                    self.end_line(random, out);
                }
                self.blank(random, out);
                if random.chance(self.wild / 2) {
                    self.comment(random, out);
                    self.blank(random, out);
                }
            }
        }
        if between == Between::Blank && out.len() == before {
            out.push(' ');
        }
    }
}

const NAMES: [&str; 12] =
    ["a", "b", "raster", "line_pitch", "x1", "speed", "edge", "λ_2", "form", "result", "cell", "a_rather_long_name"];
const FIELDS: [&str; 10] = ["a", "at", "diameter", "in", "if", "use", "job", "where", "a_rather_long_name", "µ"];
const UNITS: [&str; 7] = ["mm", "%", "mm/s", "Pa*s", "mm^-1", "kg*m^2/s^2", "µm"];

/// A file. Every word is put behind what may stand before it.
pub struct Program<'a> {
    random: &'a mut Random,
    blanks: Blanks,
    pub text: String,
    /// The next word begins an element of a list.
    list_start: bool,
}

impl<'a> Program<'a> {
    pub fn new(random: &'a mut Random) -> Program<'a> {
        let blanks = Blanks::new(random);
        Program { random, blanks, text: String::new(), list_start: false }
    }

    /// Makes a file of a few items.
    pub fn make(mut self) -> String {
        if self.random.chance(5) {
            self.text.push('\u{feff}');
        }
        if self.random.chance(20) {
            self.blanks.put(self.random, Between::Newline, &mut self.text);
        }
        self.word(Between::Nothing, "language");
        self.word(Between::Blank, "1");
        for _ in 0..1 + self.random.below(6) {
            self.blanks.put(self.random, Between::Newline, &mut self.text);
            self.item();
        }
        let end = if self.random.chance(20) { Between::Lines } else { Between::Newline };
        self.blanks.put(self.random, end, &mut self.text);
        self.text
    }

    fn word(&mut self, between: Between, word: &str) {
        let before = self.text.len();
        self.blanks.put(self.random, between, &mut self.text);
        // Two words or numbers close together would be one.
        let joins = |c: char| c == '_' || c.is_alphanumeric() || c == '"';
        if before == self.text.len()
            && between != Between::Nothing
            && self.text.ends_with(joins)
            && word.starts_with(joins)
        {
            self.text.push(' ');
        }
        self.text.push_str(word);
        self.list_start = false;
    }

    fn doc(&mut self) {
        if self.random.chance(25) {
            for _ in 0..1 + self.random.below(2) {
                self.blanks.comments += 1;
                let newline = self.blanks.newline;
                write!(self.text, "/// d{}{newline}   ", self.blanks.comments).expect("text");
            }
        }
    }

    fn because(&mut self) {
        self.word(Between::Lines, "because");
        self.word(Between::Lines, "\"it // is so\"");
    }

    fn function(&mut self, name: &str) {
        self.word(Between::Nothing, "fn");
        self.word(Between::Blank, name);
        self.word(Between::Line, "(");
        let count = self.random.below(3);
        for i in 0..count {
            if i > 0 {
                self.word(Between::Lines, ",");
            }
            self.word(Between::Lines, ["d", "e"][i]);
            self.word(Between::Line, ":");
            self.product(Between::Lines);
        }
        if count > 0 && self.random.chance(20) {
            self.word(Between::Lines, ",");
        }
        self.word(Between::Lines, ")");
        self.word(Between::Lines, "->");
        self.ty(1);
        self.word(Between::Lines, "=");
        self.value(2, Between::Lines);
    }

    /// `if … then … else …`, with a chain now and then.
    fn choice(&mut self, between: Between) {
        self.word(between, "if");
        self.comparison(1, Between::Lines);
        self.word(Between::Lines, "then");
        self.arithmetic(1, Between::Lines);
        self.word(Between::Lines, "else");
        match self.random.chance(25) {
            true => self.choice(Between::Lines),
            false => self.arithmetic(1, Between::Lines),
        }
    }

    fn item(&mut self) {
        if self.random.chance(10) {
            self.word(Between::Nothing, "allow");
            self.word(Between::Blank, "W0401");
            self.because();
            self.blanks.put(self.random, Between::Newline, &mut self.text);
        }
        self.doc();
        if self.random.chance(10) {
            self.word(Between::Nothing, "assert");
            self.comparison(2, Between::Blank);
            self.because();
            return;
        }
        if self.random.chance(30) {
            self.word(Between::Nothing, "pub");
            self.text.push(' ');
        }
        let name = self.random.one_of(&NAMES);
        match self.random.below(10) {
            9 => self.function(name),
            0 => {
                self.word(Between::Nothing, "use");
                self.word(Between::Blank, "std");
                for _ in 0..1 + self.random.below(3) {
                    self.word(Between::Line, ".");
                    self.word(Between::Lines, "part");
                }
            }
            1 => {
                self.word(Between::Nothing, "use");
                self.word(Between::Line, "\"a \\\" // b.polish\"");
            }
            2 | 3 => {
                self.word(Between::Nothing, "let");
                self.word(Between::Blank, name);
                if self.random.chance(40) {
                    self.word(Between::Line, ":");
                    self.ty(2);
                }
                self.word(Between::Lines, "=");
                self.value(3, Between::Lines);
            }
            4 => {
                self.word(Between::Nothing, "param");
                self.word(Between::Blank, name);
                self.word(Between::Line, ":");
                self.ty(2);
                if self.random.chance(60) {
                    self.word(Between::Lines, "=");
                    self.arithmetic(2, Between::Lines);
                }
                self.limits(true, false);
            }
            5 => {
                self.word(Between::Nothing, "family");
                self.word(Between::Blank, name);
            }
            6 => {
                self.word(Between::Nothing, "dimension");
                self.word(Between::Blank, name);
                if self.random.chance(70) {
                    self.word(Between::Lines, "=");
                    self.product(Between::Lines);
                }
            }
            7 => {
                self.word(Between::Nothing, "schema");
                self.word(Between::Blank, name);
                if self.random.chance(50) {
                    self.word(Between::Line, ":");
                    self.word(Between::Lines, "Family");
                }
                self.group(Between::Line, "{", "}", 5, |program, _| program.schema_entry());
            }
            _ => {
                self.word(Between::Nothing, "job");
                self.word(Between::Blank, name);
                self.record(4);
            }
        }
    }

    /// Entries between brackets, with commas and ends of lines between them. `entry` is told whether it begins a line.
    fn group(
        &mut self,
        between: Between,
        open: &str,
        close: &str,
        most: usize,
        mut entry: impl FnMut(&mut Self, bool),
    ) {
        self.word(between, open);
        let count = self.random.below(most + 1);
        // On one line, mostly; or a line an entry.
        let lines = self.random.chance(50);
        let inner = if lines { Between::Newline } else { Between::Lines };
        self.blanks.put(self.random, inner, &mut self.text);
        for i in 0..count {
            if i > 0 {
                let comma = !lines || self.random.chance(20);
                if comma {
                    self.word(Between::Line, ",");
                }
                let between = if comma { Between::Lines } else { Between::Newline };
                self.blanks.put(self.random, between, &mut self.text);
            }
            if self.text.ends_with('\n') {
                self.doc();
            }
            entry(self, true);
        }
        if count > 0 && self.random.chance(15) {
            self.word(Between::Line, ",");
        }
        self.word(inner, close);
    }

    fn record(&mut self, depth: usize) {
        self.group(Between::Line, "{", "}", 4, |program, _| program.entry(depth.saturating_sub(1)));
    }

    fn entry(&mut self, depth: usize) {
        match self.random.below(10) {
            0 if depth > 0 => {
                self.word(Between::Nothing, "workpiece");
                self.record(depth);
            }
            1 => self.comparison(depth, Between::Nothing),
            _ => {
                let name = self.random.one_of(&FIELDS);
                self.word(Between::Nothing, name);
                self.word(Between::Line, ":");
                self.value(depth, Between::Lines);
            }
        }
    }

    fn schema_entry(&mut self) {
        if self.random.chance(15) {
            self.word(Between::Nothing, "check");
            self.comparison(2, Between::Blank);
            if self.random.chance(50) {
                self.because();
            }
            return;
        }
        let name = self.random.one_of(&FIELDS);
        self.word(Between::Nothing, name);
        self.word(Between::Line, ":");
        self.ty(2);
        if self.random.chance(30) {
            self.word(Between::Lines, "=");
            self.value(2, Between::Lines);
        }
        self.limits(true, true);
    }

    fn limits(&mut self, restricted: bool, usual: bool) {
        if restricted && self.random.chance(40) {
            self.word(Between::Lines, "where");
            if self.random.chance(50) {
                self.range(1, Between::Lines);
            } else {
                for i in 0..1 + self.random.below(2) {
                    if i > 0 {
                        self.word(Between::Lines, "and");
                    }
                    let operator = self.random.one_of(&["<", "<=", ">", ">="]);
                    self.word(Between::Lines, operator);
                    self.arithmetic(1, Between::Lines);
                }
            }
        }
        if usual && self.random.chance(40) {
            self.word(Between::Lines, "usual");
            self.range(1, Between::Lines);
        }
    }

    fn range(&mut self, depth: usize, between: Between) {
        self.arithmetic(depth, between);
        // `4..5` would be one bad number.
        self.word(Between::Blank, "..");
        self.text.push(' ');
        self.arithmetic(depth, Between::Lines);
    }

    fn ty(&mut self, depth: usize) {
        match self.random.below(6) {
            0 => {
                if self.random.chance(50) {
                    self.symbol_doc();
                    self.word(Between::Lines, "|");
                }
                self.word(Between::Lines, "one");
                for other in ["two", "three"] {
                    self.symbol_doc();
                    self.word(Between::Lines, "|");
                    self.word(Between::Lines, other);
                }
            }
            1 if depth > 0 => {
                self.word(Between::Lines, "[");
                self.text.push(' ');
                self.ty_inside(depth - 1);
                if self.random.chance(40) {
                    self.word(Between::Line, ";");
                    self.word(Between::Line, "6");
                }
                self.word(Between::Line, "]");
            }
            2 => {
                self.word(Between::Lines, "Length");
                self.word(Between::Blank, "..");
                self.word(Between::Line, "Length");
            }
            _ => self.product(Between::Lines),
        }
        if self.random.chance(20) {
            self.word(Between::Line, "?");
        }
    }

    /// A doc comment of a symbol, on a line of its own.
    fn symbol_doc(&mut self) {
        if self.random.chance(30) {
            self.blanks.put(self.random, Between::Newline, &mut self.text);
            self.blanks.comments += 1;
            let newline = self.blanks.newline;
            write!(self.text, "/// s{}{newline}", self.blanks.comments).expect("text");
        }
    }

    fn ty_inside(&mut self, depth: usize) {
        if depth > 0 && self.random.chance(30) { self.ty(depth) } else { self.product(Between::Line) }
    }

    fn product(&mut self, between: Between) {
        self.word(between, "Length");
        self.power_of_type();
        for _ in 0..self.random.below(3) {
            let operator = self.random.one_of(&["*", "/"]);
            self.word(Between::Blank, operator);
            self.text.push(' ');
            self.word(Between::Line, "Time");
            self.power_of_type();
        }
    }

    fn power_of_type(&mut self) {
        if self.random.chance(25) {
            self.word(Between::Line, "^");
            let power = self.random.one_of(&["2", "-3", "(1/2)", "(-3/4)"]);
            self.word(Between::Line, power);
        }
    }

    fn value(&mut self, depth: usize, between: Between) {
        match self.random.below(10) {
            9 => self.choice(between),
            0 | 1 if depth > 0 => {
                let name = self.random.one_of(&NAMES);
                self.word(between, name);
                if self.random.chance(30) {
                    self.word(Between::Line, ".");
                    self.word(Between::Lines, "in");
                    self.word(Between::Lines, "with");
                }
                self.record(depth - 1);
            }
            2 if depth > 0 => {
                self.blanks.put(self.random, Between::Line, &mut self.text);
                self.record(depth - 1);
            }
            3 | 4 if depth > 0 => self.list(depth - 1, between),
            5 => self.range(depth, between),
            6 => self.comparison(depth, between),
            7 => self.word(between, "\"a // text { \\\\\""),
            _ => self.arithmetic(depth, between),
        }
    }

    fn list(&mut self, depth: usize, between: Between) {
        if self.random.chance(20) {
            self.word(between, "[");
            self.list_start = true;
            self.arithmetic(depth.min(2), Between::Lines);
            self.word(Between::Lines, "for");
            self.word(Between::Lines, "i");
            self.word(Between::Lines, "in");
            self.range(0, Between::Lines);
            self.word(Between::Lines, "]");
            return;
        }
        self.group(between, "[", "]", 5, |program, _| {
            program.list_start = true;
            match program.random.below(5) {
                0 if depth > 0 => program.record_element(depth),
                1 if depth > 0 => program.list(depth - 1, Between::Nothing),
                _ => program.arithmetic(depth.min(2), Between::Nothing),
            }
        });
        if self.random.chance(40) {
            let unit = self.random.one_of(&UNITS);
            self.word(Between::Line, unit);
            if self.random.chance(10) {
                // Close to the unit it would be the unit's power.
                self.word(Between::Blank, "^");
                self.word(Between::Line, "2");
            }
        }
    }

    fn record_element(&mut self, depth: usize) {
        if self.random.chance(50) {
            let name = self.random.one_of(&NAMES);
            self.word(Between::Nothing, name);
        }
        self.group(Between::Nothing, "{", "}", 3, |program, _| program.entry(depth - 1));
    }

    fn comparison(&mut self, depth: usize, between: Between) {
        if self.random.chance(20) {
            self.word(between, "not");
            self.word(Between::Line, "(");
            self.comparison(depth.saturating_sub(1), Between::Lines);
            self.word(Between::Lines, ")");
            return;
        }
        self.arithmetic(depth, between);
        let operator = self.random.one_of(&["<", "<=", ">", ">=", "==", "!="]);
        self.word(Between::Lines, operator);
        self.arithmetic(depth, Between::Lines);
        if depth > 0 && self.random.chance(25) {
            let operator = self.random.one_of(&["and", "or"]);
            self.word(Between::Lines, operator);
            self.comparison(depth - 1, Between::Lines);
        }
    }

    fn arithmetic(&mut self, depth: usize, between: Between) {
        self.operand(depth, between);
        for _ in 0..self.random.below(3) {
            match self.random.below(4) {
                // At the start of a line these would begin another entry.
                0 => {
                    let operator = self.random.one_of(&["+", "-"]);
                    self.word(Between::Line, operator);
                    self.operand(depth, Between::Lines);
                }
                1 | 2 => {
                    // Close together, `4 mm*a` would be a unit.
                    self.word(Between::Blank, "*");
                    self.text.push(' ');
                    self.operand(depth, Between::Lines);
                }
                _ => {
                    self.word(Between::Blank, "/");
                    self.text.push(' ');
                    // `1 / 20 mm` could be read in two ways.
                    let right = self.random.one_of(&["speed", "2", "(b)"]);
                    self.word(Between::Lines, right);
                }
            }
        }
    }

    fn operand(&mut self, depth: usize, mut between: Between) {
        if self.random.chance(15) {
            // In a list, a line that begins with `-` and a blank is an error.
            let first = self.list_start;
            self.word(between, "-");
            between = if first { Between::Nothing } else { Between::Line };
        }
        match self.random.below(8) {
            0 | 1 => {
                let number = self.random.one_of(&["4", "0.50", "1e-10", "632.8"]);
                self.word(between, number);
                let unit = self.random.one_of(&UNITS);
                self.word(Between::Line, unit);
            }
            2 => {
                let number = self.random.one_of(&["4", "0.50", "2"]);
                self.word(between, number);
            }
            3 if depth > 0 => {
                self.word(between, "(");
                match self.random.chance(20) {
                    true => self.choice(Between::Lines),
                    false => self.arithmetic(depth - 1, Between::Lines),
                }
                self.word(Between::Lines, ")");
            }
            4 if depth > 0 => {
                self.word(between, "max");
                self.word(Between::Line, "(");
                for i in 0..1 + self.random.below(3) {
                    if i > 0 {
                        self.word(Between::Lines, ",");
                    }
                    self.arithmetic(depth - 1, Between::Lines);
                }
                if self.random.chance(20) {
                    self.word(Between::Lines, ",");
                }
                self.word(Between::Lines, ")");
            }
            5 => {
                let base = self.random.one_of(&["a", "2", "(4 mm)"]);
                self.word(between, base);
                self.word(Between::Line, "^");
                let exponent = self.random.one_of(&["2", "-2", "(1 / 2)", "(b)", "c"]);
                self.word(Between::Lines, exponent);
            }
            6 => {
                self.word(between, "result");
                self.word(Between::Line, ".");
                self.word(Between::Lines, "where");
            }
            _ => {
                let name = self.random.one_of(&NAMES);
                self.word(between, name);
            }
        }
    }
}
