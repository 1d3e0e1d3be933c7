//! The passes of one job, in order: each takes what those before it made.
//!
//! In: an evaluated job in a [`Planned`], the files, how far to go. Out: the same with what each pass made, and what is odd
//! about it; or the problems that end the plan.

use super::{Planned, Request, Until, Watch};
use crate::diagnostics::codes as code;
use crate::diagnostics::{Problem, Severity};
use crate::dwell::{self, SpeedSteps};
use crate::eval::Requirement;
use crate::forecast;
use crate::height_map::Grid;
use crate::job::{self, Job, Unchecked};
use crate::metrology::{self, ErrorMap};
use crate::motion::{self, Purpose};
use crate::path;
use crate::report::{self, Met};
use crate::source::FileProvider;
use crate::target;
use crate::tool::{self, InfluenceField};
use crate::verify;
use crate::workpiece;
use crate::workpiece::form::{self, Surface};
use std::collections::BTreeMap;
use std::sync::Arc;

/// Runs the passes of one job, as far as they go.
pub(super) struct Passes<'a> {
    pub files: &'a dyn FileProvider,
    pub request: &'a Request,
    pub watch: &'a dyn Watch,
    pub planned: &'a mut Planned,
    pub said: &'a mut Vec<Problem>,
}

impl Passes<'_> {
    pub fn run(&mut self) -> Result<(), Vec<Problem>> {
        let job = self.planned.job.clone();
        let until = self.request.until;
        let refuse = |problems: Vec<Problem>| {
            if problems.iter().any(|p| p.severity == Severity::Error) { Err(problems) } else { Ok(problems) }
        };
        let mut odd = refuse(workpiece::check(&job.workpiece))?;
        odd.extend(refuse(tool::check(&job.tool, job.robot.as_ref()))?);
        odd.extend(refuse(output_checks(&job, until))?);
        self.said.extend(odd);
        // A look at a plan, a rehearsal or a proof of an older program may speak of a map that is void by now.
        if until == Until::Program && self.request.purpose == Purpose::Polish {
            metrology::run_record::check(&self.request.path, &job, self.files).map_err(one)?;
        }

        let surface: Arc<dyn Surface> = form::surface(&job.workpiece.form, self.files).map_err(one)?.into();
        self.planned.surface = Some(surface.clone());
        let surface = &*surface;
        refuse(workpiece::check_surface(&job.workpiece, surface).into_iter().collect())?;
        let strategy = job.path.strategy();
        let measured = if strategy.needs_measurement() { Some(self.measure(&job, surface)?) } else { None };
        self.watch.pass("path");
        let limits = job.target.as_ref().map(target::limits);
        let setting = path::Setting {
            edge: &job.workpiece.edge,
            clear: &job.workpiece.clear,
            surface,
            most_points: limits.as_ref().map_or(path::MOST_POINTS, |limits| limits.most_points),
            line_points: limits.as_ref().map_or(usize::MAX, |limits| limits.line_points),
            measured: measured
                .as_ref()
                .map(|(error, influence)| path::Measured { error, influence: &influence.parts[0] }),
        };
        let tool_path = path::plan(&job.path, &setting).map_err(one)?;
        let places = (0..tool_path.points.len()).map(|i| [tool_path.points.x[i], tool_path.points.y[i]]);
        self.said.extend(refuse(tool::check_fit(&job.tool, surface, places).into_iter().collect())?);
        path::chord::check(&tool_path, surface, strategy.chord_error()).map_err(one)?;
        self.said.extend(tool_path.region.iter().flat_map(|region| region.warnings()));
        if until == Until::Path {
            self.planned.path = Some(tool_path);
            return Ok(());
        }
        if let (Some(_), Some((error_map, _)), true) = (&tool_path.region, &measured, tool_path.points.is_empty()) {
            if let Some(asked) = &job.figures {
                let figures = metrology::surface_figures(&error_map.grid, &job.workpiece.clear, asked).map_err(one)?;
                self.planned.figures = Some([figures.clone(), figures]);
            }
            self.planned.error_map = Some(error_map.clone());
            self.planned.path = Some(tool_path);
            let results = self.planned.known();
            self.said.extend(self.planned.requirements.iter().filter_map(|wanted| not_met(wanted, &results)));
            return Ok(());
        }
        let (error_map, influence) = match measured {
            Some(measured) => measured,
            None => self.measure(&job, surface)?,
        };
        let places = (0..tool_path.points.len()).map(|i| [tool_path.points.x[i], tool_path.points.y[i]]);
        let near_edge = influence.check_places(&job.tool, &job.workpiece, places);
        self.said.extend(refuse(near_edge)?);

        self.watch.pass("forecast");
        let job::Dwell::corrective(corrective) = &job.dwell;
        let speed_steps = limits.as_ref().map_or(FINEST_SPEEDS, |limits| limits.speed_steps);
        let task = dwell::Task {
            standing: dwell::standing(&tool_path, corrective.acceleration.0, speed_steps),
            path: tool_path,
            line_pitch: strategy.line_pitch(),
            passes: job.path.pass_count(),
            error: &error_map.grid,
            clear: &job.workpiece.clear,
            edge: &job.workpiece.edge,
            surface,
            influence: &influence,
            azimuth: influence.azimuth,
            standoff: job.tool.standoff(),
            dwell: corrective,
            speed_steps,
        };
        self.planned.prospect = forecast::prospect(&task, self.said);
        if self.request.pareto {
            // What it warns of, the solve says again.
            let rows = dwell::pareto(&task, &mut Vec::new()).map_err(one)?;
            self.planned.pareto = Some(report::pareto(&self.planned.name, &rows));
        }
        self.watch.pass("dwell");
        let outcome = dwell::solve(task, self.said).map_err(one)?;
        if limits.is_some() {
            let path = &outcome.timed.path;
            self.said.extend(path::ends::check_last(path, &job.workpiece.edge, influence.radius()));
        }
        let clear = &job.workpiece.clear;
        self.planned.stock = Some(forecast::stock(&outcome.removal, clear, &job.workpiece.form, surface));
        if let Some(uncertainty) = &job.uncertainty {
            self.watch.pass("forecast");
            // What the shop does not know of the gain, several spots say.
            let spots = influence.spread.and_then(|spread| spread.volume);
            let uncertainty = job::Uncertainty { gain: uncertainty.gain.or(spots), ..uncertainty.clone() };
            let mut footprint = dwell::Footprint::over(&influence, influence.azimuth);
            footprint.standoff = job.tool.standoff();
            let run = forecast::Run { outcome: &outcome, footprint: &footprint, surface, clear, dwell: corrective };
            self.planned.expected = forecast::expect(&uncertainty, &run).map_err(one)?;
            self.planned.uncertainty = Some(uncertainty);
        }
        if let Some(limits) = &limits {
            dwell::check_segment_times(
                &outcome.timed,
                job.tool.standoff(),
                corrective,
                &limits.segment_times,
                self.said,
            )
            .map_err(one)?;
        }
        if let Some(asked) = &job.figures {
            let of = |grid: &Grid| metrology::surface_figures(grid, &job.workpiece.clear, asked).map_err(one);
            self.planned.figures = Some([of(&error_map.grid)?, of(&outcome.residual)?]);
        }
        self.planned.dwell = Some(outcome);
        self.planned.error_map = Some(error_map);
        self.planned.influence = Some(influence);
        let (Some(robot), Some(limits)) = (&job.robot, &limits) else { return Ok(()) };
        if until == Until::Dwell {
            return Ok(());
        }

        self.watch.pass("motion");
        let bounds = job.workpiece.edge.bounds();
        let request = motion::Request {
            standoff: job.tool.standoff(),
            azimuth: job.tool.azimuth(),
            tool_ball: job.tool.ball(),
            part: [bounds.min, bounds.max],
            acceleration: corrective.acceleration.0,
            purpose: self.request.purpose,
            room: limits.room,
            speed_steps,
        };
        // Moved, not copied: with five million points a copy is half a gigabyte.
        let timed = self.planned.dwell.as_mut().map(|outcome| std::mem::take(&mut outcome.timed)).unwrap_or_default();
        let checked = motion::plan(timed, robot, &request).map_err(one)?;
        self.planned.motion = Some(checked);
        if until == Until::Motion {
            return Ok(());
        }

        self.watch.pass("target");
        let Some(checked) = &self.planned.motion else { return Ok(()) };
        let draft = target::emit(&self.planned.name, checked, &job)?;
        self.watch.pass("verify");
        let program = verify::verify(draft, checked, &job, surface)?;
        self.planned.program = Some(program);
        Ok(())
    }

    /// What the job's measurements say: the error map on the part, and the influence function.
    fn measure(&mut self, job: &Job, surface: &dyn Surface) -> Result<(ErrorMap, InfluenceField), Vec<Problem>> {
        self.watch.pass("metrology");
        let error_map = metrology::error_map(&job.workpiece, self.files, self.said).map_err(one)?;
        let influence = InfluenceField::new(&job.tool, &job.workpiece, surface, self.files, self.said)?;
        Ok((error_map, influence))
    }
}

/// W0640 where there is nothing to polish, and yet a requirement does not hold.
fn not_met(wanted: &Requirement, results: &BTreeMap<String, f64>) -> Option<Problem> {
    let found = report::requirement(wanted, results);
    (found.met == Met::No).then(|| {
        let message = format!(
            "there is nothing to polish, but the job requires `{}`, and the map has {}",
            found.text, found.value
        );
        Problem::warning(code::W0640, "path.above", message)
            .help("lower `above` and `tolerance` until they select what the requirement asks for")
    })
}

fn one(problem: Problem) -> Vec<Problem> {
    vec![problem]
}

/// What a job that asks for a program must have.
fn output_checks(job: &Job, until: Until) -> Vec<Problem> {
    let mut problems = Vec::new();
    if until < Until::Motion {
        return problems;
    }
    match (&job.robot, &job.target) {
        (None, None) => {}
        (Some(_), None) => problems.push(
            Problem::error(code::E1103, "robot", "the job names a robot and no target to write a program for")
                .help("add `target: rapid { … }`, or take `robot` out to plan as far as dwell"),
        ),
        (None, Some(_)) => problems.push(
            Problem::error(code::E1103, "target", "the job names a target and no robot")
                .help("add `robot: … with { cell: … }`, or take `target` out to plan as far as dwell"),
        ),
        (Some(_), Some(_)) => {
            let listed: Vec<&str> = job.unchecked.iter().flatten().map(|u| u.name()).collect();
            let missing: Vec<&str> = Unchecked::ALL.iter().map(|u| u.name()).filter(|w| !listed.contains(w)).collect();
            if !missing.is_empty() {
                problems.push(
                    Problem::error(
                        code::E1104,
                        "unchecked",
                        format!("`unchecked` does not name {}, which this compiler does not check", missing.join(", ")),
                    )
                    .note("only the tool tip is checked against the part; every report repeats the list")
                    .help("write `unchecked: [arm, cell, cable, fixture]` once somebody has looked at them"),
                );
            }
        }
    }
    problems
}

/// Programmed speeds without a target: the digits of a single-precision number, which is what the finest controller keeps.
const FINEST_SPEEDS: SpeedSteps = SpeedSteps::Digits(7);
