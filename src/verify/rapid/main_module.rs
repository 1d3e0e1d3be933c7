//! The main module of a program against the job: data, and every statement that is not path.
//!
//! In: the module as read. Out: findings, and the [`Frames`](replay::Frames) of tool and work object that the text states, for the
//! replay of the path. What the routines must say stands in [`super::routines`].

use super::declarations::{self, Place};
use super::moves;
use super::routines::{WantedRoutine, wanted_routines};
use super::statements::{Around, compare};
use super::syntax::{Data, DataKind, Expression, Module, Routine};
use super::values::{Scope, shape};
use super::{Findings, Wanted, at};
use crate::diagnostics::codes::{E1002, E1003, E1007, E1009, E1010, E1011, E1012};
use crate::diagnostics::{Code, Problem};
use crate::job;
use crate::motion::Transform;
use crate::verify::replay::{
    self, ORIENTATION_TOLERANCE, angle_between, half_digit, same_number, shortest, single_step,
};
use nalgebra::{Quaternion, Translation3, UnitQuaternion};

/// The frames that the text states, in metres, from its numbers in single precision.
#[derive(Clone, Debug)]
struct Frames {
    world_user: Transform,
    user_object: Transform,
    flange_tool: Transform,
}

/// Compares the main module, which loads `chunks` others.
pub fn check(wanted: &Wanted, file: &str, module: &Module, chunks: usize, findings: &mut Findings) -> replay::Frames {
    let checker = Checker { wanted, file, module, scope_levels: [&module.data] };
    checker.declarations(findings);
    let frames = checker.frames(findings);
    checker.routines(chunks, findings);
    replay::Frames { world_object: frames.world_user * frames.user_object, flange_tool: frames.flange_tool }
}

struct Checker<'a> {
    wanted: &'a Wanted<'a>,
    file: &'a str,
    module: &'a Module,
    scope_levels: [&'a [Data]; 1],
}

impl Checker<'_> {
    fn scope(&self) -> Scope<'_> {
        Scope { levels: &self.scope_levels }
    }

    fn own(&self, ending: &str) -> String {
        self.wanted.names.own(ending)
    }

    /// Names, types and shapes of all data; the constants of start and digest.
    fn declarations(&self, findings: &mut Findings) {
        if !self.module.name.eq_ignore_ascii_case(&self.wanted.names.module) {
            let (found, name) = (&self.module.name, &self.wanted.names.module);
            let what = format!("the module is called `{found}`, the job asks for `{name}`");
            findings.add(|| at(self.file, 1, E1002, "target.module", what));
        }
        declarations::check(self.wanted, self.file, Place::Main, self.module, self.scope(), findings);
        match self.value(&self.own("digest"), "string", shape::STRING, E1009, "target", findings) {
            Some((line, _, texts)) if texts.first() != Some(&self.wanted.digest) => findings.add(|| {
                let what = "the digest is not the one of this job: the program was built from another".to_string();
                at(self.file, line, E1009, "target", what).help("build the job again, and load all its modules")
            }),
            _ => {}
        }
        if self.wanted.waits_for_inputs()
            && let Some((line, found, _)) =
                self.value(&self.own("late"), "bool", shape::BOOL, E1012, "robot.cell.process", findings)
            && found != [0.0]
        {
            let what = format!("`{}` must begin as `FALSE`", self.own("late"));
            findings.add(|| at(self.file, line, E1012, "robot.cell.process", what));
        }
        let home = self.wanted.motion.home.to_vec();
        let safe = &self.wanted.cell.safe_poses;
        let safe = safe.iter().enumerate().map(|(i, pose)| {
            let joints = pose.iter().map(|angle| angle.0).collect();
            (self.own(&format!("safe_{}", i + 1)), "robot.cell.safe_poses", joints)
        });
        let end = self.wanted.motion.runs.last().map(|run| (self.own("end"), "path", run.retract_joints.to_vec()));
        for (name, field, joints) in std::iter::once((self.own("home"), "robot.cell.home", home)).chain(safe).chain(end)
        {
            let Some((line, found, _)) = self.value(&name, "jointtarget", shape::JOINTTARGET, E1003, field, findings)
            else {
                continue;
            };
            if let Err(what) = moves::same_jointtarget(&found, &joints) {
                findings.add(|| at(self.file, line, E1003, field, format!("`{name}`: {what}")));
            }
        }
    }

    /// The value of data that must be there: its line, numbers and texts.
    fn value(
        &self,
        name: &str,
        of_type: &str,
        wanted_shape: &str,
        code: Code,
        field: &str,
        findings: &mut Findings,
    ) -> Option<(u32, Vec<f64>, Vec<String>)> {
        let scope = self.scope();
        let Some(data) = scope.find(name) else {
            findings
                .add(|| at(self.file, 1, code, field, format!("`{of_type} {name}` is not declared in this module")));
            return None;
        };
        let value = data.value.as_ref().and_then(|value| scope.numbers_and_texts(value, wanted_shape));
        match value {
            Some((numbers, texts)) if data.of_type.eq_ignore_ascii_case(of_type) => Some((data.line, numbers, texts)),
            _ => {
                findings.add(|| {
                    at(self.file, data.line, code, field, format!("`{name}` is no `{of_type}` with values written out"))
                });
                None
            }
        }
    }

    /// Tool and work object against the job's. The frames as the text has them, or the job's where the text's are
    /// wrong: then they were reported, and the path is compared apart from them.
    fn frames(&self, findings: &mut Findings) -> Frames {
        let chain = &self.wanted.motion.frames;
        let planned =
            Frames { world_user: chain.world_user, user_object: chain.user_object, flange_tool: chain.flange_tool };
        let before = findings.count;
        let found = match self.wanted.rapid.frames {
            job::Frames::in_program => self.declared_frames(&planned, findings),
            job::Frames::on_controller => self.compared_frames(&planned, findings),
        };
        match found {
            Some(found) if findings.count == before => found,
            _ => planned,
        }
    }

    fn declared_frames(&self, planned: &Frames, findings: &mut Findings) -> Option<Frames> {
        let (tool, object) = (&self.wanted.names.tool, &self.wanted.names.object);
        let tool_data = self.value(tool, "tooldata", shape::TOOLDATA, E1010, "target.tool_name", findings).and_then(
            |(line, n, _)| {
                let differs = Differs { checker: self, name: tool, line, code: E1010 };
                differs.truth("robhold", n[0], true, findings);
                let tframe = differs.pose("tframe", "robot.cell.tcp", &n[1..8], &planned.flange_tool, findings);
                self.load(&differs, &n[8..], findings);
                tframe
            },
        );
        let object_data = self
            .value(object, "wobjdata", shape::WOBJDATA, E1011, "target.object_name", findings)
            .and_then(|(line, n, texts)| {
                let differs = Differs { checker: self, name: object, line, code: E1011 };
                differs.truth("robhold", n[0], false, findings);
                differs.truth("ufprog", n[1], true, findings);
                if texts.iter().any(|unit| !unit.is_empty()) {
                    let unit = &texts[0];
                    findings.add(|| {
                        differs.problem("robot.cell.user", format!("ufmec names the unit `{unit}`, the job has none"))
                    });
                }
                let uframe = differs.pose("uframe", "robot.cell.user", &n[2..9], &planned.world_user, findings);
                let oframe = differs.pose("oframe", "robot.cell.object", &n[9..16], &planned.user_object, findings);
                uframe.zip(oframe)
            });
        let (world_user, user_object) = object_data?;
        Some(Frames { world_user, user_object, flange_tool: tool_data? })
    }

    /// Mass, centre, axes and moments of the load: `n` from the mass on.
    fn load(&self, differs: &Differs, n: &[f64], findings: &mut Findings) {
        let load = &self.wanted.cell.tcp.load;
        differs.number("mass", "robot.cell.tcp.load.mass", "kg", (n[0], load.mass.0), 0.0, findings);
        let centre = [load.centre.x.0, load.centre.y.0, load.centre.z.0];
        differs.position("cog", "robot.cell.tcp.load.centre", &n[1..4], &centre, findings);
        let (axes, moments) = match load.inertia {
            // The job gives the moments along the tool frame's axes.
            Some(inertia) => (self.wanted.motion.frames.flange_tool.rotation, [inertia.x.0, inertia.y.0, inertia.z.0]),
            None => (UnitQuaternion::identity(), [0.0; 3]),
        };
        differs.rotation("aom", "robot.cell.tcp.load.inertia", &n[4..8], &axes, findings);
        for (k, name) in ["ix", "iy", "iz"].iter().enumerate() {
            differs.number(name, "robot.cell.tcp.load.inertia", "kg m^2", (n[8 + k], moments[k]), 0.0, findings);
        }
    }

    /// With frames on the controller: the constants that it is compared with.
    fn compared_frames(&self, planned: &Frames, findings: &mut Findings) -> Option<Frames> {
        for name in [&self.wanted.names.tool, &self.wanted.names.object] {
            if let Some(data) = self.scope().find(name) {
                let what = format!("`{name}` is declared here, the job keeps it on the controller");
                findings.add(|| at(self.file, data.line, E1010, "target.frames", what));
            }
        }
        let mut pose = |ending: &str, field: &str, code: Code, planned: &Transform| {
            let name = self.own(ending);
            let (line, n, _) = self.value(&name, "pose", shape::POSE, code, field, findings)?;
            Differs { checker: self, name: &name, line, code }.pose(ending, field, &n, planned, findings)
        };
        let tframe = pose("tframe", "robot.cell.tcp", E1010, &planned.flange_tool);
        let uframe = pose("uframe", "robot.cell.user", E1011, &planned.world_user);
        let oframe = pose("oframe", "robot.cell.object", E1011, &planned.user_object);
        let load = &self.wanted.cell.tcp.load;
        let (mass, cog) = (self.own("mass"), self.own("cog"));
        let field = "robot.cell.tcp.load.mass";
        if let Some((line, n, _)) = self.value(&mass, "num", shape::NUM, E1010, field, findings) {
            let differs = Differs { checker: self, name: &mass, line, code: E1010 };
            differs.number("mass", field, "kg", (n[0], load.mass.0), 0.0, findings);
        }
        let field = "robot.cell.tcp.load.centre";
        if let Some((line, n, _)) = self.value(&cog, "pos", shape::POS, E1010, field, findings) {
            let differs = Differs { checker: self, name: &cog, line, code: E1010 };
            differs.position("cog", field, &n, &[load.centre.x.0, load.centre.y.0, load.centre.z.0], findings);
        }
        Some(Frames { world_user: uframe?, user_object: oframe?, flange_tool: tframe? })
    }

    /// All routines: each wanted one there once and saying what it must, no other.
    fn routines(&self, chunks: usize, findings: &mut Findings) {
        let wanted = wanted_routines(self.wanted, chunks);
        for routine in &self.module.routines {
            let known = wanted.iter().any(|want| want.name.eq_ignore_ascii_case(&routine.name));
            let twice =
                self.module.routines.iter().filter(|other| other.name.eq_ignore_ascii_case(&routine.name)).count() > 1;
            if !known || twice {
                let what = format!("the job does not ask for the routine `{}`", routine.name);
                findings.add(|| at(self.file, routine.line, E1003, "target", what));
            }
        }
        for want in &wanted {
            let Some(found) = self.module.routines.iter().find(|found| found.name.eq_ignore_ascii_case(&want.name))
            else {
                findings.add(|| at(self.file, 1, E1003, "target", format!("the routine `{}` is missing", want.name)));
                continue;
            };
            self.routine(found, want, findings);
        }
    }

    fn routine(&self, found: &Routine, want: &WantedRoutine, findings: &mut Findings) {
        let same_kind = match (&found.returns, want.function) {
            (Some(of_type), true) => of_type.eq_ignore_ascii_case("bool"),
            (None, false) => true,
            _ => false,
        };
        let same_parameters = found.parameters.len() == want.parameters.len()
            && found.parameters.iter().zip(&want.parameters).all(|((of_type, name), (wanted_type, wanted_name))| {
                of_type.eq_ignore_ascii_case(wanted_type) && name.eq_ignore_ascii_case(wanted_name)
            });
        if !same_kind || !same_parameters {
            let what = format!("the heading of `{}` differs from what the job asks for", found.name);
            findings.add(|| at(self.file, found.line, E1003, "target", what));
        }
        let locals: &[&[Data]] = &[&found.data, &self.module.data];
        let scope = Scope { levels: locals };
        declarations::check(self.wanted, self.file, Place::Routine(found), self.module, scope, findings);
        for data in &found.data {
            if want.flag.is_some_and(|flag| data.name.eq_ignore_ascii_case(flag)) {
                let what = match (data.kind, is_false(data.value.as_ref())) {
                    (DataKind::Variable, true) => continue,
                    (DataKind::Variable, false) => format!("`{}` must begin as `FALSE`", data.name),
                    _ => format!("`{}` must be `VAR`: the program sets it", data.name),
                };
                findings.add(|| at(self.file, data.line, E1003, "target.frames", what));
            }
        }
        if let Some(flag) = want.flag
            && !found.data.iter().any(|data| data.name.eq_ignore_ascii_case(flag))
        {
            let what = format!("`VAR bool {flag}:=FALSE` is missing");
            findings.add(|| at(self.file, found.line, E1003, "target.frames", what));
        }
        let around = Around {
            file: self.file,
            scope,
            moves: &self.module.moves,
            home: &|one, time| moves::home_move(self.wanted, self.module, scope, one, time),
        };
        compare(&around, found.line, &found.body, &want.steps, findings);
    }
}

/// One record of data against the job, component by component.
struct Differs<'a> {
    checker: &'a Checker<'a>,
    name: &'a str,
    line: u32,
    code: Code,
}

impl Differs<'_> {
    fn problem(&self, field: &str, what: String) -> Problem {
        at(self.checker.file, self.line, self.code, field, format!("`{}`: {what}", self.name))
    }

    fn truth(&self, component: &str, found: f64, wanted: bool, findings: &mut Findings) {
        if (found == 1.0) != wanted {
            let wanted = if wanted { "TRUE" } else { "FALSE" };
            findings.add(|| self.problem("target", format!("{component} must be `{wanted}`")));
        }
    }

    /// A number against the job's, within `allowed` or what single precision cannot tell apart.
    fn number(
        &self,
        component: &str,
        field: &str,
        unit: &str,
        (found, wanted): (f64, f64),
        allowed: f64,
        findings: &mut Findings,
    ) {
        // Written so that a number that is none differs.
        if !((found - wanted).abs() <= allowed || same_number(found, wanted)) {
            findings.add(|| {
                let (found, wanted) = (shortest(found), shortest(wanted));
                self.problem(field, format!("{component} is {found} {unit}, the job has {wanted} {unit}"))
            });
        }
    }

    /// A position in the text's millimetres against one in metres.
    fn position(&self, component: &str, field: &str, found: &[f64], wanted: &[f64; 3], findings: &mut Findings) {
        let half_digit = half_digit(self.checker.wanted.rapid.controller.position_decimals);
        for (k, axis) in ["x", "y", "z"].iter().enumerate() {
            let name = format!("{component}.{axis}");
            let pair = (found[k], wanted[k] * 1e3);
            self.number(&name, field, "mm", pair, half_digit + single_step(pair.1), findings);
        }
    }

    fn rotation(
        &self,
        component: &str,
        field: &str,
        found: &[f64],
        wanted: &UnitQuaternion<f64>,
        findings: &mut Findings,
    ) -> Option<UnitQuaternion<f64>> {
        let q = [found[0], found[1], found[2], found[3]];
        if let Err(what) = moves::unit_length(q) {
            findings.add(|| Problem { code: E1007, ..self.problem(field, format!("{component}: {what}")) });
            return None;
        }
        let rotation = UnitQuaternion::from_quaternion(Quaternion::new(q[0], q[1], q[2], q[3]));
        let angle = angle_between(&rotation, wanted);
        let aligned = angle <= ORIENTATION_TOLERANCE;
        if !aligned {
            findings.add(|| {
                let degrees = angle.to_degrees();
                self.problem(field, format!("{component} is turned by {degrees:.4} deg from where the job has it"))
            });
        }
        Some(rotation)
    }

    /// A pose of seven numbers; the transform that it states.
    fn pose(
        &self,
        component: &str,
        field: &str,
        found: &[f64],
        wanted: &Transform,
        findings: &mut Findings,
    ) -> Option<Transform> {
        // The controller stores single precision.
        let found: Vec<f64> = found.iter().map(|v| f64::from(*v as f32)).collect();
        let t = wanted.translation.vector;
        self.position(&format!("{component}.trans"), field, &found[..3], &[t.x, t.y, t.z], findings);
        let rotation = self.rotation(&format!("{component}.rot"), field, &found[3..7], &wanted.rotation, findings)?;
        let [x, y, z] = [found[0], found[1], found[2]].map(|v| v * 1e-3);
        Some(Transform::from_parts(Translation3::new(x, y, z), rotation))
    }
}

/// Whether a value is written `FALSE`.
fn is_false(value: Option<&Expression>) -> bool {
    matches!(value, Some(Expression::Name(name)) if name.eq_ignore_ascii_case("FALSE"))
}
