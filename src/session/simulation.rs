//! Simulation: what a job's plan, its program or a run of it leaves on the part.
//!
//! In: a [`Compilation`] and what to simulate. Out: a [`Simulation`] of its job, whose oddities are told as the
//! compilation's.

use super::{Compilation, Planned, in_text, no_program};
use crate::diagnostics::{Diagnostic, Problem, codes, render};
use crate::dwell::Outcome;
use crate::job;
use crate::report::{self, SimulationResult};
use crate::simulate::as_run::{AsRun, At};
use crate::simulate::contact::Contact;
use crate::simulate::log::{self, Frame};
use crate::simulate::{self, Difference, SAME, Scene};
use crate::target::Program;
use crate::verify;

/// What is to be simulated.
pub enum Of<'a> {
    /// The job's own program; its plan, where it names no robot.
    Job,
    /// A program from a disk.
    Program(&'a Program),
    /// A run: the log's name and bytes, and the frame that the command line states.
    Run { name: &'a str, bytes: &'a [u8], frame: Option<Frame> },
}

/// What was simulated.
pub struct Simulation {
    pub outcome: Outcome,
    pub result: SimulationResult,
}

/// Simulates the job of `done`, which must have been compiled to its motion, or to dwell where it has no robot.
/// `None` if something is wrong; `done` then says what.
pub fn simulate(done: &mut Compilation, of: &Of) -> Option<Simulation> {
    let planned = done.jobs.first()?;
    let mut said = Vec::new();
    let simulation = match simulation(planned, of, &mut said) {
        Ok(simulation) => Some(simulation),
        Err(problems) => {
            said.extend(problems);
            None
        }
    };
    let place = |mut problem: Problem| {
        // A log is no field of the job: there is no line to show.
        problem.field = problem.field.filter(|field| field != "log");
        in_text(problem, &planned.origins, &done.sources)
    };
    let found: Vec<Diagnostic> = said.into_iter().map(place).collect();
    let warnings: Vec<String> = found.iter().map(|d| format!("{}: {}", d.code, d.message)).collect();
    done.diagnostics.extend(found);
    render::sort(&mut done.diagnostics);
    simulation.map(|mut simulation| {
        simulation.result.warnings = warnings;
        simulation
    })
}

fn simulation(planned: &Planned, of: &Of, said: &mut Vec<Problem>) -> Result<Simulation, Vec<Problem>> {
    let (Some(plan), Some(map), Some(influence), Some(surface), Some(timed)) =
        (&planned.dwell, &planned.error_map, &planned.influence, &planned.surface, planned.timed())
    else {
        return Err(planned.nothing().map(|_| no_program()).into_iter().collect());
    };
    let job = &planned.job;
    let job::Dwell::corrective(dwell) = &job.dwell;
    let strategy = job.path.strategy();
    let scene = Scene {
        workpiece: &job.workpiece,
        surface: &**surface,
        error: &map.grid,
        influence,
        standoff: job.tool.standoff(),
        dwell,
        line_pitch: strategy.line_pitch(),
        landing: strategy.landing(),
        travel: job.robot.as_ref().and_then(|robot| robot.cell.as_ref()).map(|cell| cell.travel.height.0),
    };
    let mut found = Found { word: "plan", program: None, run: None };
    let outcome = match of {
        Of::Job => match &planned.program {
            Some(program) => {
                found.word = "program";
                program_of(planned, program, &scene, &mut found)?
            }
            None => plan.clone(),
        },
        Of::Program(program) => {
            found.word = "program";
            program_of(planned, program, &scene, &mut found)?
        }
        Of::Run { name, bytes, frame } => {
            found.word = "run";
            let log = log::read(bytes, name).map_err(|p| vec![p])?;
            if let Some(problem) = no_frame(&log, name, *frame) {
                return Err(vec![problem]);
            }
            let (outcome, run) = simulate::run(&log, timed, &scene).map_err(|p| vec![p])?;
            said.extend(warnings_of_run(&run));
            found.run = Some(run);
            outcome
        }
    };
    let difference = simulate::difference(&plan.removal, &outcome.removal);
    if difference.share > SAME {
        match of {
            Of::Job => return Err(vec![simulate::not_as_planned(&difference)]),
            Of::Program(_) => said.push(otherwise("the program", &difference)),
            Of::Run { .. } => said.push(otherwise("the run", &difference)),
        }
    }
    if let Some(too_fast) = found.program.as_ref().map(|contact| contact.too_fast).filter(|count| *count > 0) {
        let message =
            format!("{too_fast} moves ask for a speed that the stated acceleration does not reach on their length");
        said.push(Problem::warning(codes::W1301, "dwell.acceleration", message));
    }
    let against = (found.word != "plan").then_some(&difference);
    let result = report::simulation(
        &planned.name,
        job,
        found.word,
        (&outcome, &plan.figures),
        against,
        found.program.as_ref(),
        found.run.as_ref(),
        &planned.requirements,
    );
    Ok(Simulation { outcome, result })
}

/// What was looked at, beside the outcome.
struct Found {
    word: &'static str,
    program: Option<Contact>,
    run: Option<AsRun>,
}

fn program_of(planned: &Planned, program: &Program, scene: &Scene, found: &mut Found) -> Result<Outcome, Vec<Problem>> {
    let Some(motion) = &planned.motion else { return Err(vec![crate::target::no_target()]) };
    let trace = verify::trace(program, motion, &planned.job, scene.surface)?;
    let (outcome, contact) = simulate::program(&trace, scene).map_err(|p| vec![p])?;
    found.program = Some(contact);
    Ok(outcome)
}

fn no_frame(log: &log::Log, name: &str, frame: Option<Frame>) -> Option<Problem> {
    if frame.or(log.frame).is_some() {
        return None;
    }
    let message = match &log.frame_name {
        Some(theirs) => {
            format!("the log `{name}` is in the frame `{}`, which says nothing here", theirs.escape_default())
        }
        None => format!("the log `{name}` does not say which frame its positions are in"),
    };
    Some(Problem::error(codes::E1305, "log", message).help(
        "say `--frame part` if they are in the part frame (a controller's object frame); bring them there if not",
    ))
}

fn otherwise(what: &str, difference: &Difference) -> Problem {
    let [x, y] = difference.place.map(|v| v * 1e3 + 0.0);
    let side = if difference.most > 0.0 { "more" } else { "less" };
    let message = format!(
        "{what} removes up to {:.2} nm {side} than planned ({:.1} % of the largest removal), at x {x:.3} mm, y {y:.3} mm",
        difference.most.abs() * 1e9,
        difference.share * 100.0
    );
    Problem::warning(codes::W1300, "dwell", message)
}

fn warnings_of_run(run: &AsRun) -> Vec<Problem> {
    let mut said = Vec::new();
    let place = |[x, y]: [f64; 2]| format!("x {:.3} mm, y {:.3} mm", x * 1e3 + 0.0, y * 1e3 + 0.0);
    let longest = |all: &[At]| {
        all.iter().copied().fold(None, |most: Option<At>, at| match most {
            Some(most) if most.value >= at.value => Some(most),
            _ => Some(at),
        })
    };
    // A thousandth of the path is the first and last piece that a log misses when it begins and ends with the run.
    if run.missing > 1e-3 || !run.holes.is_empty() {
        let mut message =
            format!("the log tells nothing of {:.1} % of the path over the clear aperture", run.missing * 100.0);
        if let Some(hole) = longest(&run.holes) {
            let many =
                if run.holes.len() > 1 { format!(", the longest of {} holes", run.holes.len()) } else { String::new() };
            message += &format!(
                "; after {} there are no samples for {:.2} s, while the machine went on{many}",
                place(hole.place),
                hole.value
            );
        }
        said.push(Problem::warning(codes::W1302, "log", message));
    }
    if let Some(stop) = longest(&run.stops) {
        let many =
            if run.stops.len() > 1 { format!(", the longest of {} stops", run.stops.len()) } else { String::new() };
        let message = format!(
            "the machine stood over the part at {} for {:.1} s longer than planned{many}",
            place(stop.place),
            stop.value
        );
        said.push(Problem::warning(codes::W1303, "log", message));
    }
    said
}
