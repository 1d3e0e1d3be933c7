//! What data of a program may be declared: names, kinds, types, values.
//!
//! In: the data of a module or a routine, and what else the program calls by name. Out: findings. The comparisons of
//! statements look at names, so a name must mean the same wherever it stands: nothing may hide what the program or the
//! controller calls so. They also put values in the place of names, so a value must be the one that is written: only
//! constants, and variables that nothing sets: every statement of the program is compared.

use super::syntax::{Data, DataKind, Module, Routine};
use super::values::{Scope, shape};
use super::{Findings, Wanted, at};
use crate::diagnostics::codes::{E1001, E1010};
use crate::job::Process;
use crate::target::rapid::not_a_name;

/// Where the data are declared.
#[derive(Clone, Copy)]
pub enum Place<'a> {
    /// In the main module.
    Main,
    /// In a routine of the main module.
    Routine(&'a Routine),
    /// In a module of the path, which may declare where it begins under the name given.
    Chunk { module: &'a Module, start: &'a str },
    /// In the routine of such a module.
    ChunkRoutine { module: &'a Module, routine: &'a Routine, start: &'a str },
}

impl<'a> Place<'a> {
    fn data(self, main: &'a Module) -> &'a [Data] {
        match self {
            Place::Main => &main.data,
            Place::Routine(routine) | Place::ChunkRoutine { routine, .. } => &routine.data,
            Place::Chunk { module, .. } => &module.data,
        }
    }
}

/// Refuses data of `place` that are declared twice, hide another name, may change while the program runs, have a type
/// that the programs do not use, or a value that does not fit. `main` is the main module.
pub fn check(wanted: &Wanted, file: &str, place: Place, main: &Module, scope: Scope, findings: &mut Findings) {
    let data = place.data(main);
    // Sorted, so that many data are checked quickly.
    let mut names: Vec<(String, u32)> = data.iter().map(|one| (one.name.to_ascii_lowercase(), one.line)).collect();
    names.sort();
    for pair in names.windows(2).filter(|pair| pair[0].0 == pair[1].0) {
        let what = format!("`{}` is declared twice", pair[1].0);
        findings.add(|| at(file, pair[1].1, E1001, "target", what));
    }
    for one in data {
        let Some(wanted) = shape::of_type(&one.of_type) else {
            let what = format!("this compiler does not know data of the type `{}`", one.of_type);
            findings.add(|| at(file, one.line, E1001, "target", what));
            continue;
        };
        let fits = match &one.value {
            Some(value) => scope.numbers(value, wanted).is_some(),
            None => one.kind == DataKind::Variable,
        };
        if !fits {
            let what = format!(
                "`{}` has no value of its type `{}` that is known before the program runs",
                one.name, one.of_type
            );
            findings.add(|| at(file, one.line, E1001, "target", what));
        }
    }
    for one in data {
        if let Some(what) = name_problem(wanted, place, main, one) {
            findings.add(|| at(file, one.line, E1001, "target", what));
        }
        if let Some(what) = kind_problem(wanted, place, one) {
            let code = if is_frame(wanted, one) { E1010 } else { E1001 };
            findings.add(|| at(file, one.line, code, "target", what));
        }
    }
}

/// Whether `data` are the tool or the work object.
fn is_frame(wanted: &Wanted, data: &Data) -> bool {
    [&wanted.names.tool, &wanted.names.object].iter().any(|name| name.eq_ignore_ascii_case(&data.name))
}

/// Why `data` cannot be called so in `place`.
fn name_problem(wanted: &Wanted, place: Place, main: &Module, data: &Data) -> Option<String> {
    let most = usize::try_from(wanted.rapid.controller.name_length).unwrap_or(0);
    if let Some(why) = not_a_name(&data.name, most) {
        return Some(format!("`{}` cannot be declared: {why}", data.name));
    }
    let same = |name: &str| name.eq_ignore_ascii_case(&data.name);
    let of_data = |data: &[Data]| data.iter().any(|other| same(&other.name));
    let routines = |module: &Module| module.routines.iter().any(|routine| same(&routine.name));
    let parameters = |routine: &Routine| routine.parameters.iter().any(|(_, name)| same(name));
    let elsewhere = routines(main)
        || match place {
            Place::Main => false,
            Place::Routine(routine) => of_data(&main.data) || is_frame(wanted, data) || parameters(routine),
            Place::Chunk { module, .. } => of_data(&main.data) || is_frame(wanted, data) || routines(module),
            Place::ChunkRoutine { module, .. } => {
                of_data(&main.data) || is_frame(wanted, data) || routines(module) || of_data(&module.data)
            }
        };
    if elsewhere {
        return Some(format!("`{}` hides a name that the program already uses", data.name));
    }
    if let Process::signals(signals) = &wanted.cell.process {
        let mut names = signals.outputs.iter().map(|s| &s.name).chain(signals.inputs.iter().map(|s| &s.name));
        if names.any(|name| same(name)) {
            return Some(format!("`{}` hides a signal of the job", data.name));
        }
    }
    // The program's own names: modules, routines and data of it that may not be in memory yet.
    let m = wanted.names.module.to_ascii_lowercase();
    let lower = data.name.to_ascii_lowercase();
    let known = match place {
        Place::Main => lower.strip_prefix(&format!("{m}_")).is_some_and(|ending| {
            ["digest", "home", "end", "late", "tframe", "uframe", "oframe", "mass", "cog"].contains(&ending)
                || ending.starts_with("safe_")
        }),
        Place::Routine(_) => false,
        Place::Chunk { start, .. } | Place::ChunkRoutine { start, .. } => same(start),
    };
    (is_own(wanted, data) && !known)
        .then(|| format!("`{}` is one of the names that the program keeps for itself", data.name))
}

/// Whether the name is one that the program gives: the module's, or one that begins with it.
fn is_own(wanted: &Wanted, data: &Data) -> bool {
    let module = wanted.names.module.to_ascii_lowercase();
    data.name.to_ascii_lowercase().strip_prefix(&module).is_some_and(|rest| rest.is_empty() || rest.starts_with('_'))
}

/// Why `data` of `place` may not be of the kind that they are.
fn kind_problem(wanted: &Wanted, place: Place, data: &Data) -> Option<String> {
    let late = matches!(place, Place::Main) && data.name.eq_ignore_ascii_case(&wanted.names.own("late"));
    let module = matches!(place, Place::Main | Place::Chunk { .. });
    match data.kind {
        // Motion instructions take no other kind.
        _ if matches!(place, Place::Main) && is_frame(wanted, data) => (data.kind != DataKind::Persistent)
            .then(|| format!("`{}` must be `PERS`, as motion instructions ask", data.name)),
        _ if late => {
            (data.kind != DataKind::Variable).then(|| format!("`{}` must be `VAR`: the program sets it", data.name))
        }
        DataKind::Constant => None,
        // A literal may have moved to a variable that no statement of the program sets; the program's own data may not.
        DataKind::Variable if !module || !is_own(wanted, data) => None,
        _ => Some(format!("`{}` must be `CONST`, so that nothing changes it before it is used", data.name)),
    }
}
