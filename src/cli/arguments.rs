//! What can be said on the command line. The words are stable: scripts and editors rely on them.

use clap::{Args, Parser, Subcommand, ValueEnum};
use std::path::PathBuf;

/// A declarative language and compiler for robotic optical polishing.
#[derive(Debug, Parser)]
#[command(name = "polishc", version, arg_required_else_help = true)]
pub struct Arguments {
    #[command(subcommand)]
    pub command: Command,
    #[command(flatten)]
    pub common: Common,
}

#[derive(Debug, Args)]
pub struct Common {
    /// How diagnostics are written.
    #[arg(long, global = true, value_enum, default_value_t = MessageFormat::Human)]
    pub message_format: MessageFormat,
    /// Whether diagnostics are coloured.
    #[arg(long, global = true, value_enum, default_value_t = Colour::Auto)]
    pub color: Colour,
    /// `warnings`: every warning counts as an error.
    #[arg(long, global = true, value_enum)]
    pub deny: Option<Deny>,
    /// Threads to compute with (default: all cores). The programs are the same for any number.
    #[arg(long, global = true, value_parser = clap::value_parser!(u16).range(1..=1024))]
    pub threads: Option<u16>,
    /// Write the time of each pass to this file as JSON.
    #[arg(long, global = true, value_name = "FILE")]
    pub timings: Option<PathBuf>,
    /// Allow a job to name files outside its project.
    #[arg(long, global = true)]
    pub allow_outside: bool,
    /// Say only what is wrong.
    #[arg(short, long, global = true)]
    pub quiet: bool,
    /// Say what each pass took, too.
    #[arg(short, long, global = true)]
    pub verbose: bool,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum MessageFormat {
    Human,
    Short,
    Json,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum Colour {
    Auto,
    Always,
    Never,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum Deny {
    Warnings,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum For {
    /// The polishing program.
    Polish,
    /// The path lifted along its normals, slow, process off.
    #[value(name = "dry_run")]
    DryRun,
}

/// Intermediate forms that `--emit` writes.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum Emit {
    /// The tree of the job file (`NAME.ast.txt`).
    Ast,
    /// The evaluated job in SI (`NAME.job.json`).
    Job,
    /// Points and normals in the part frame, metres (`NAME.path.npy`, columns x y z nx ny nz).
    Path,
    /// Programmed speed of the move to each point, m/s (`NAME.dwell.npy`).
    Dwell,
    /// Joint angles at each point, radians (`NAME.motion.npy`).
    Motion,
    /// Predicted residual in metres on the error map's grid, rows towards +y (`NAME.residual.npy`).
    Residual,
    /// Residual against machine time: what is to be had (`NAME.pareto.json`, and a table on the screen).
    Pareto,
    /// Power spectral densities of the error map and of the predicted residual (`NAME.psd.json`).
    Psd,
    /// The robot programs too.
    Program,
}

/// Frames that a log can be in.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum LogFrame {
    /// The part frame, which controllers call the object frame.
    #[value(alias = "object")]
    Part,
}

/// Projects that `new` can make.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum Template {
    /// A flat, figured with an MRF wheel on an ABB arm.
    Mrf,
    /// Not there yet.
    Bonnet,
    /// Not there yet.
    Planetary,
    /// Not there yet.
    Swing,
}

impl Template {
    /// As it is written.
    pub fn name(self) -> &'static str {
        match self {
            Template::Mrf => "mrf",
            Template::Bonnet => "bonnet",
            Template::Planetary => "planetary",
            Template::Swing => "swing",
        }
    }
}

#[derive(Debug, Subcommand)]
pub enum Command {
    /// Make a project that builds, with its data.
    New {
        /// Its folder, which must not exist yet or be empty; the job is named after it.
        #[arg(value_name = "DIR")]
        folder: PathBuf,
        /// What it begins with.
        #[arg(long, value_enum, default_value_t = Template::Mrf)]
        template: Template,
    },
    /// Check jobs: names, types, files, plan, motion and program, all in memory; nothing is written.
    Check {
        #[arg(required = true, value_name = "FILE")]
        files: Vec<PathBuf>,
        /// Stop after names, types and dimensions.
        #[arg(long)]
        fast: bool,
        /// Give a param its value.
        #[arg(long, value_name = "NAME=VALUE")]
        set: Vec<String>,
    },
    /// Write the robot programs of a job, all or nothing.
    Build {
        file: PathBuf,
        /// Folder for what is written (default: out/NAME).
        #[arg(short, value_name = "DIR")]
        output: Option<PathBuf>,
        /// Build only this job of the file.
        #[arg(long, value_name = "NAME")]
        job: Option<String>,
        /// Give a param its value.
        #[arg(long, value_name = "NAME=VALUE")]
        set: Vec<String>,
        /// What the program is for.
        #[arg(long = "for", value_enum, default_value_t = For::Polish)]
        purpose: For,
        /// Write these intermediate forms instead of programs.
        #[arg(long, value_enum, value_delimiter = ',', value_name = "FORM,…")]
        emit: Vec<Emit>,
    },
    /// Predict what a job's program leaves on the part, from its text; or an edited program, or a run by its log.
    Simulate {
        file: PathBuf,
        /// The files of a program, ours or edited, instead of the one that the job makes.
        #[arg(long, value_name = "PROGRAM", num_args = 1.., conflicts_with = "log")]
        program: Vec<PathBuf>,
        /// What a controller or a tracker wrote down of a run.
        #[arg(long, value_name = "LOG")]
        log: Option<PathBuf>,
        /// The frame of the log's positions, where the log does not say it.
        #[arg(long, value_enum, requires = "log")]
        frame: Option<LogFrame>,
        /// Folder for the predicted maps and `simulate.json`; without it nothing is written.
        #[arg(short, value_name = "DIR")]
        output: Option<PathBuf>,
        /// Which job of the file, where it holds several.
        #[arg(long, value_name = "NAME")]
        job: Option<String>,
        /// Give a param its value.
        #[arg(long, value_name = "NAME=VALUE")]
        set: Vec<String>,
    },
    /// Plan a job with several values of its params, and show what each is predicted to give.
    Sweep {
        file: PathBuf,
        /// A param and the values to try; several params give all combinations.
        #[arg(long, required = true, value_name = "NAME=VALUE,…")]
        over: Vec<String>,
        /// Only this job of the file.
        #[arg(long, value_name = "NAME")]
        job: Option<String>,
        /// Give another param its value.
        #[arg(long, value_name = "NAME=VALUE")]
        set: Vec<String>,
    },
    /// Read a robot program, ours or edited, and compare it with the job.
    Verify {
        /// The program's files: the main module and its chunks, in any order.
        #[arg(required = true, value_name = "PROGRAM")]
        programs: Vec<PathBuf>,
        /// The job it must do.
        #[arg(long = "job", value_name = "FILE")]
        file: PathBuf,
        /// Which job of the file, where it holds several.
        #[arg(long, value_name = "NAME")]
        name: Option<String>,
        /// Give a param its value.
        #[arg(long, value_name = "NAME=VALUE")]
        set: Vec<String>,
        /// What the program is for.
        #[arg(long = "for", value_enum, default_value_t = For::Polish)]
        purpose: For,
    },
    /// Say what is in a height map, a profile or the log of a run.
    Inspect {
        #[arg(required = true, value_name = "DATA")]
        files: Vec<PathBuf>,
        /// As JSON, one object a line.
        #[arg(long)]
        json: bool,
        /// The height that the value 1 means, where the file does not say it (`nm`, `um`, `mm`, `m`).
        #[arg(long, value_name = "UNIT")]
        unit: Option<String>,
        /// Side of one pixel, where the file does not say it (`0.5mm`).
        #[arg(long, value_name = "LENGTH")]
        pixel: Option<String>,
    },
    /// Show a job as it stands: every value, and who said it.
    Show {
        file: PathBuf,
        /// Only what the job does not say, with the reasons of the defaults.
        #[arg(long)]
        defaults: bool,
        /// Show only this job of the file.
        #[arg(long, value_name = "NAME")]
        job: Option<String>,
        /// Give a param its value.
        #[arg(long, value_name = "NAME=VALUE")]
        set: Vec<String>,
    },
    /// Put files into the one look: all of them or none. Comments, and where lines end, stay.
    Fmt {
        #[arg(required = true, value_name = "FILE")]
        files: Vec<PathBuf>,
        /// Write nothing; say which files would change, with exit status 1 if one would.
        #[arg(long)]
        check: bool,
    },
    /// Tell what a word of the vocabulary means: a schema, a family, a field, a unit, a value of stdlib.
    Doc {
        /// The word. Without it, all words are listed.
        name: Option<String>,
        /// Write the whole vocabulary as a page, `index.html`.
        #[arg(long, conflicts_with = "name")]
        html: bool,
        /// Folder for the page (default: out/doc).
        #[arg(short, value_name = "DIR", requires = "html")]
        output: Option<PathBuf>,
    },
    /// Explain a diagnostic's code.
    Explain { code: String },
    /// Print the completions of a shell, to be put where it looks for them.
    Completions {
        #[arg(value_enum)]
        shell: clap_complete::Shell,
    },
}
