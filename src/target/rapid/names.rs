//! Names of a RAPID program: what is a legal name, and how everything generated is called.
//!
//! In: the job's target and cell. Out: [`Names`]. All names of modules, routines and global data share one space in a
//! task, so everything generated begins with the main module's name.

use crate::diagnostics::Problem;
use crate::diagnostics::codes::{E0900, E0901, E0902};
use crate::job::{Process, Rapid, RobotCell};
use crate::motion::Purpose;
use crate::target::identifier::not_an_identifier;

/// Longest text that a RAPID `string` holds.
pub const STRING_LENGTH: usize = 80;

/// The longest ending that is put behind the module's name.
const LONGEST_SUFFIX: &str = "_check_frames";

/// Reserved words of RAPID.
const RESERVED: &[&str] = &[
    "alias",
    "and",
    "backward",
    "case",
    "connect",
    "const",
    "default",
    "div",
    "do",
    "else",
    "elseif",
    "endfor",
    "endfunc",
    "endif",
    "endmodule",
    "endproc",
    "endrecord",
    "endtest",
    "endtrap",
    "endwhile",
    "error",
    "exit",
    "false",
    "for",
    "from",
    "func",
    "goto",
    "if",
    "inout",
    "local",
    "mod",
    "module",
    "nostepin",
    "not",
    "noview",
    "or",
    "pers",
    "proc",
    "raise",
    "readonly",
    "record",
    "retry",
    "return",
    "step",
    "sysmodule",
    "test",
    "then",
    "to",
    "trap",
    "true",
    "trynext",
    "undo",
    "var",
    "viewonly",
    "while",
    "with",
    "xor",
];

/// Names that the controller declares and the programs use or rely on: a second declaration would hide or clash.
const PREDEFINED: &[&str] = &[
    "abs",
    "bool",
    "cjointt",
    "confj",
    "confl",
    "cspeedoverride",
    "fine",
    "jointtarget",
    "load",
    "load0",
    "loaddata",
    "main",
    "moveabsj",
    "movej",
    "movel",
    "num",
    "pdispoff",
    "pose",
    "pos",
    "orient",
    "robtarget",
    "setdo",
    "singarea",
    "speeddata",
    "stop",
    "string",
    "tool0",
    "tooldata",
    "tpwrite",
    "unload",
    "velset",
    "waitdi",
    "waittime",
    "wobj0",
    "wobjdata",
    "z0",
    "z1",
    "z5",
    "z10",
    "zonedata",
];

/// How everything in one program is called.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Names {
    /// Name of the main module, and what every generated name begins with. A dry run has one of its own, so that its
    /// files never replace those of the polishing program.
    pub module: String,
    pub tool: String,
    pub object: String,
    /// Folder on the controller, without a closing slash.
    pub folder: String,
}

impl Names {
    /// The names of the program of `purpose` that `rapid` asks for, not yet checked.
    pub fn new(rapid: &Rapid, purpose: Purpose) -> Names {
        let suffix = match purpose {
            Purpose::Polish => "",
            Purpose::DryRun => "_dry",
        };
        Names {
            module: format!("{}{suffix}", rapid.module),
            tool: rapid.tool_name.clone(),
            object: rapid.object_name.clone(),
            folder: rapid.controller.folder.trim_end_matches('/').to_string(),
        }
    }

    /// A name of this program: `Flat340_home`.
    pub fn own(&self, ending: &str) -> String {
        format!("{}_{ending}", self.module)
    }

    /// The module that holds the `index`th chunk of the path, counted from 0.
    pub fn chunk_module(&self, index: usize) -> String {
        self.own(&format!("{:03}", index + 1))
    }

    /// The routine in that module. A module and a routine must not share a name.
    pub fn chunk_routine(&self, index: usize) -> String {
        self.own(&format!("run_{:03}", index + 1))
    }

    /// The joints where the `index`th chunk begins.
    pub fn chunk_start(&self, index: usize) -> String {
        self.own(&format!("from_{:03}", index + 1))
    }

    /// The file that holds `module`.
    pub fn file(&self, module: &str) -> String {
        format!("{module}.mod")
    }

    /// Where the controller finds that file.
    pub fn path(&self, module: &str) -> String {
        format!("{}/{module}.mod", self.folder)
    }

    /// What is wrong with these names for this cell: not an identifier or reserved (`E0900`), used twice (`E0901`), a
    /// folder that does not fit a RAPID string (`E0902`).
    pub fn check(&self, rapid: &Rapid, cell: &RobotCell) -> Vec<Problem> {
        let most = usize::try_from(rapid.controller.name_length).unwrap_or(0);
        let mut problems = Vec::new();
        let mut used: Vec<(String, String)> = Vec::new();
        let own = self.own("").to_ascii_lowercase();
        let mut name = |field: &str, name: &str, most: usize| {
            if let Some(why) = not_a_name(name, most) {
                problems.push(Problem::error(E0900, field, format!("`{name}` cannot be a RAPID name: {why}")).help(
                    "a RAPID name is a letter followed by letters, digits and underscores, and is not a word that \
                         RAPID uses itself",
                ));
                return;
            }
            let lower = name.to_ascii_lowercase();
            if lower.starts_with(&own) {
                problems.push(Problem::error(
                    E0901,
                    field,
                    format!("`{name}` begins with `{}_`, as the names that polishc makes do", self.module),
                ));
            }
            if let Some((_, first)) = used.iter().find(|(other, _)| *other == lower) {
                problems.push(
                    Problem::error(E0901, field, format!("`{name}` is already the name at `{first}`"))
                        .help("RAPID does not tell capitals from small letters, and all names share one space"),
                );
            }
            used.push((lower, field.to_string()));
        };
        name("target.module", &self.module, most.saturating_sub(LONGEST_SUFFIX.len()));
        name("target.tool_name", &self.tool, most);
        name("target.object_name", &self.object, most);
        if let Process::signals(signals) = &cell.process {
            for (i, output) in signals.outputs.iter().enumerate() {
                name(&format!("robot.cell.process.outputs.{i}.name"), &output.name, most);
            }
            for (i, input) in signals.inputs.iter().enumerate() {
                name(&format!("robot.cell.process.inputs.{i}.name"), &input.name, most);
            }
        }
        let longest = self.path(&self.own("0000")).len();
        let plain = |c: char| c.is_ascii_graphic() && c != '"' && c != '\\';
        if longest > STRING_LENGTH || !self.folder.chars().all(plain) || self.folder.is_empty() {
            problems.push(
                Problem::error(
                    E0902,
                    "target.controller.folder",
                    format!("modules cannot be loaded from the folder `{}`", self.folder.escape_default()),
                )
                .note(format!(
                    "a path is a RAPID string: at most {STRING_LENGTH} plain ASCII characters without quotes, \
                     backslashes and blanks; the longest here would have {longest}"
                )),
            );
        }
        problems
    }
}

/// Why `name` is no RAPID name of at most `most` characters, or `None` if it is one.
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
