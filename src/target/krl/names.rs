//! Names of a KRL program: what is a legal name, and how everything generated is called.
//!
//! In: the job's target. Out: [`Names`]. All programs of a controller share one space of names whatever folder they lie
//! in, so everything generated begins with the main program's name.

use crate::diagnostics::Problem;
use crate::diagnostics::codes::E0900;
use crate::job::Krl;
use crate::motion::Purpose;
use crate::target::identifier::not_an_identifier;

/// What a dry run puts behind the name.
const DRY_RUN: &str = "_dry";

/// The longest ending that is put behind the name after that: `_inputs`, `_frames`, `_safe99`.
const LONGEST_ENDING: usize = 7;

/// Reserved words of KRL.
const RESERVED: &[&str] = &[
    "and",
    "anin",
    "anout",
    "b_and",
    "b_exor",
    "b_not",
    "b_or",
    "brake",
    "case",
    "ccomp",
    "channel",
    "circ",
    "circ_rel",
    "confirm",
    "const",
    "const_vel",
    "continue",
    "decl",
    "def",
    "default",
    "defdat",
    "deffct",
    "delay",
    "digin",
    "distance",
    "do",
    "else",
    "end",
    "enddat",
    "endfct",
    "endfold",
    "endfor",
    "endif",
    "endloop",
    "endspline",
    "endswitch",
    "endwhile",
    "enum",
    "exit",
    "exor",
    "ext",
    "extfct",
    "false",
    "fold",
    "for",
    "global",
    "goto",
    "halt",
    "if",
    "import",
    "interrupt",
    "is",
    "lin",
    "lin_rel",
    "loop",
    "maximum",
    "minimum",
    "not",
    "off",
    "on",
    "onstart",
    "or",
    "path",
    "prio",
    "ptp",
    "ptp_rel",
    "ptp_spline",
    "public",
    "pulse",
    "repeat",
    "resume",
    "return",
    "scirc",
    "sec",
    "signal",
    "slin",
    "spl",
    "spline",
    "sptp",
    "struc",
    "switch",
    "sync",
    "then",
    "time_block",
    "to",
    "trigger",
    "true",
    "until",
    "wait",
    "when",
    "while",
    "with",
];

/// Names that the controller declares and the programs use: a second declaration would hide or clash.
const PREDEFINED: &[&str] = &[
    "abs",
    "axis",
    "bas",
    "base_data",
    "bool",
    "char",
    "e6axis",
    "e6pos",
    "frame",
    "initmov",
    "int",
    "ir_stopm",
    "load",
    "load_data",
    "main",
    "msgnotify",
    "pos",
    "real",
    "tool_data",
    "vel_ptp",
];

/// How everything in one program is called.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Names {
    /// Name of the main program, and what every generated name begins with. A dry run has one of its own, so that its
    /// files never replace those of the polishing program.
    pub module: String,
}

impl Names {
    /// The names of the program of `purpose` that `krl` asks for, not yet checked.
    pub fn new(krl: &Krl, purpose: Purpose) -> Names {
        let ending = match purpose {
            Purpose::Polish => "",
            Purpose::DryRun => DRY_RUN,
        };
        Names { module: format!("{}{ending}", krl.module) }
    }

    /// A name of this program: `Sphere200_home`.
    pub fn own(&self, ending: &str) -> String {
        format!("{}_{ending}", self.module)
    }

    /// The sub-program that holds the `index`th part of the path, counted from 0.
    pub fn sub_program(&self, index: usize) -> String {
        self.own(&format!("{:03}", index + 1))
    }

    /// What is wrong with the job's name (`E0900`).
    pub fn check(krl: &Krl) -> Vec<Problem> {
        let most = usize::try_from(krl.controller.name_length).unwrap_or(0);
        let room = most.saturating_sub(LONGEST_ENDING + DRY_RUN.len());
        let Some(why) = not_a_name(&krl.module, room) else { return Vec::new() };
        vec![
            Problem::error(E0900, "target.module", format!("`{}` cannot be a KRL name: {why}", krl.module))
                .note(format!(
                    "a KRL name has at most {most} characters, of which the compiler puts up to {} behind this one",
                    most.saturating_sub(room)
                ))
                .help(
                    "a KRL name is a letter followed by letters, digits and underscores, and is not a word that KRL uses \
                     itself",
                ),
        ]
    }
}

/// Why `name` is no KRL name of at most `most` characters, or `None` if it is one.
pub fn not_a_name(name: &str, most: usize) -> Option<String> {
    if let Some(why) = not_an_identifier(name, most) {
        return Some(why);
    }
    let lower = name.to_ascii_lowercase();
    if RESERVED.contains(&lower.as_str()) {
        return Some("it is a reserved word".into());
    }
    if PREDEFINED.contains(&lower.as_str()) {
        return Some("the controller declares that name itself".into());
    }
    None
}
