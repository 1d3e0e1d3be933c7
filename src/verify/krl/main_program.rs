//! The main program against the job: data, and every statement that is not path.
//!
//! In: its two files as read. Out: findings, and the [`Frames`] of tool and part that the text states, for the replay of
//! the path. What the routines must say stands in [`super::routines`].

use super::routines::{WantedRoutine, wanted_routines};
use super::statements::compare;
use super::syntax::{Data, DataFile, Routine, Source, Statement};
use super::values::{Scope, components};
use super::{Pair, Wanted};
use crate::diagnostics::codes::{E1001, E1002, E1003, E1009, E1010, E1011};
use crate::diagnostics::{Code, Problem};
use crate::motion::Transform;
use crate::target::krl::{digest_words, not_a_name};
use crate::verify::findings::{Findings, at};
use crate::verify::replay::{
    Frames, ORIENTATION_TOLERANCE, angle_between, half_digit, same_number, shortest, single_step,
};
use nalgebra::{Quaternion, Translation3, UnitQuaternion};

/// Decimals of a joint angle in degrees. What single precision resolves at 170 deg is 1.5e-5.
const JOINT_DECIMALS: i64 = 5;

/// Compares the main program, which calls `parts` others.
pub fn check(
    wanted: &Wanted,
    files: Pair,
    source: &Source,
    data: &DataFile,
    parts: usize,
    findings: &mut Findings,
) -> Frames {
    let routines = wanted_routines(wanted, parts);
    let checker = Checker { wanted, files, scope: Scope { data: &data.data } };
    let name = &wanted.names.module;
    same_name(files.data, data.line, &data.name, name, findings);
    if let Some(main) = source.routines.first() {
        same_name(files.source, main.line, &main.name, name, findings);
    }
    checker.declarations(&data.data, &routines, findings);
    let frames = checker.data(findings);
    checker.routines(source, &routines, findings);
    frames
}

/// The name behind `DEF` and `DEFDAT` must be the file's (KSS message 2051).
pub fn same_name(file: &crate::target::ProgramFile, line: u32, found: &str, wanted: &str, findings: &mut Findings) {
    if !found.eq_ignore_ascii_case(wanted) {
        findings.add(|| {
            let what = format!("the program is called `{found}`, its file asks for `{wanted}`");
            at(&file.name, line, E1002, "target.module", what)
        });
    }
}

/// Refuses data that are declared twice, have a type that the programs do not use, or a value that does not fit, or a name
/// that is no name or in `taken`.
pub fn declarations(wanted: &Wanted, file: &str, scope: Scope, taken: &[&str], findings: &mut Findings) {
    let most = usize::try_from(wanted.krl.controller.name_length).unwrap_or(0);
    let mut names: Vec<(String, u32)> =
        scope.data.iter().map(|one| (one.name.to_ascii_lowercase(), one.line)).collect();
    names.sort();
    for pair in names.windows(2).filter(|pair| pair[0].0 == pair[1].0) {
        let what = format!("`{}` is declared twice", pair[1].0);
        findings.add(|| at(file, pair[1].1, E1001, "target", what));
    }
    for one in scope.data {
        let value = components::of_type(&one.of_type)
            .and_then(|components| one.value.as_ref().and_then(|value| scope.numbers(value, components)));
        if value.is_none() {
            let what = format!("`{}` has no value of its type `{}` that is written out", one.name, one.of_type);
            findings.add(|| at(file, one.line, E1001, "target", what));
        }
        if let Some(why) = not_a_name(&one.name, most) {
            let what = format!("`{}` cannot be declared: {why}", one.name);
            findings.add(|| at(file, one.line, E1001, "target", what));
        }
        if taken.iter().any(|name| name.eq_ignore_ascii_case(&one.name)) {
            let what = format!("`{}` hides a name that the program already uses", one.name);
            findings.add(|| at(file, one.line, E1001, "target", what));
        }
    }
}

/// The data `name` of a type: its line and numbers. That they are missing or of another type is a finding.
pub fn value(
    file: &str,
    scope: Scope,
    (name, of_type): (&str, &str),
    (code, field): (Code, &str),
    findings: &mut Findings,
) -> Option<(u32, Vec<f64>)> {
    let Some(data) = scope.find(name) else {
        findings.add(|| at(file, 1, code, field, format!("`{of_type} {name}` is not declared in this file")));
        return None;
    };
    let components = components::of_type(of_type)?;
    let numbers = data.value.as_ref().and_then(|value| scope.numbers(value, components));
    match numbers {
        Some(numbers) if data.of_type.eq_ignore_ascii_case(of_type) => Some((data.line, numbers)),
        _ => {
            let what = format!("`{name}` is no `{of_type}` with values written out");
            findings.add(|| at(file, data.line, code, field, what));
            None
        }
    }
}

/// Joint angles in degrees against joints in radians.
pub fn same_joints(found: &[f64], joints: &[f64]) -> Result<(), String> {
    for (j, (found, wanted)) in found.iter().zip(joints).enumerate() {
        let wanted = wanted * (180.0 / std::f64::consts::PI);
        // Written so that an angle that is no number differs.
        let same = (found - wanted).abs() <= half_digit(JOINT_DECIMALS) + single_step(wanted);
        if !same {
            let (found, wanted) = (shortest(*found), shortest(wanted));
            return Err(format!("joint {} stands at {found} deg where {wanted} deg is planned", j + 1));
        }
    }
    Ok(())
}

/// R = Rz(A) Ry(B) Rx(C), degrees.
pub fn rotation(abc: [f64; 3]) -> UnitQuaternion<f64> {
    let [(sa, ca), (sb, cb), (sc, cc)] = abc.map(|angle| libm::sincos(angle * (std::f64::consts::PI / 360.0)));
    let q = |w, x, y, z| UnitQuaternion::new_unchecked(Quaternion::new(w, x, y, z));
    q(ca, 0.0, 0.0, sa) * q(cb, 0.0, sb, 0.0) * q(cc, sc, 0.0, 0.0)
}

struct Checker<'a> {
    wanted: &'a Wanted<'a>,
    files: Pair<'a>,
    scope: Scope<'a>,
}

impl Checker<'_> {
    fn own(&self, ending: &str) -> String {
        self.wanted.names.own(ending)
    }

    fn data_file(&self) -> &str {
        &self.files.data.name
    }

    /// Data beside the program's own may hold literals; they must not hide anything.
    fn declarations(&self, data: &[Data], routines: &[WantedRoutine], findings: &mut Findings) {
        let locals = routines.iter().flat_map(|routine| routine.data.iter().map(|(_, name)| *name));
        let taken: Vec<&str> = routines.iter().map(|routine| routine.name.as_str()).chain(locals).collect();
        declarations(self.wanted, self.data_file(), self.scope, &taken, findings);
        let known = |ending: &str| {
            ["d1", "d2", "d3", "d4", "home", "end", "root", "tool", "base", "load"].contains(&ending)
                || ending.starts_with("safe")
        };
        let prefix = self.own("").to_ascii_lowercase();
        for one in data {
            if one.name.to_ascii_lowercase().strip_prefix(&prefix).is_some_and(|ending| !known(ending)) {
                let what = format!("`{}` is one of the names that the program keeps for itself", one.name);
                findings.add(|| at(self.data_file(), one.line, E1001, "target", what));
            }
        }
    }

    /// The program's data against the job. The frames as the text has them, or the job's where the text's are wrong: then
    /// they were reported, and the path is compared apart from them.
    fn data(&self, findings: &mut Findings) -> Frames {
        let (motion, cell) = (self.wanted.motion, self.wanted.cell);
        for (k, word) in digest_words(&self.wanted.digest).into_iter().enumerate() {
            let name = self.own(&format!("d{}", k + 1));
            let found = value(self.data_file(), self.scope, (&name, "INT"), (E1009, "target"), findings);
            if let Some((line, numbers)) = found
                && numbers != [f64::from(word)]
            {
                findings.add(|| {
                    let what = format!("`{name}` is not the digest of this job: the program was built from another");
                    at(self.data_file(), line, E1009, "target", what)
                        .help("build the job again, and load all its files")
                });
            }
        }
        let home = motion.home.to_vec();
        let safe = cell.safe_poses.iter().enumerate().map(|(i, pose)| {
            let joints: Vec<f64> = pose.iter().map(|angle| angle.0).collect();
            (self.own(&format!("safe{}", i + 1)), "robot.cell.safe_poses", joints)
        });
        let end = motion.runs.last().map(|run| (self.own("end"), "path", run.retract_joints.to_vec()));
        for (name, field, joints) in std::iter::once((self.own("home"), "robot.cell.home", home)).chain(safe).chain(end)
        {
            let found = value(self.data_file(), self.scope, (&name, "AXIS"), (E1003, field), findings);
            if let Some((line, numbers)) = found
                && let Err(what) = same_joints(&numbers, &joints)
            {
                findings.add(|| at(self.data_file(), line, E1003, field, format!("`{name}`: {what}")));
            }
        }
        let chain = &motion.frames;
        let world_object = chain.world_user * chain.user_object;
        let before = findings.count;
        self.frame("root", "robot.cell.base", E1011, &chain.world_base, findings);
        let tool = self.frame("tool", "robot.cell.tcp", E1010, &chain.flange_tool, findings);
        let base = self.frame("base", "robot.cell.object", E1011, &world_object, findings);
        let found = tool.zip(base).filter(|_| findings.count == before);
        self.load(findings);
        match found {
            Some((flange_tool, world_object)) => Frames { world_object, flange_tool },
            None => Frames { world_object, flange_tool: chain.flange_tool },
        }
    }

    /// A frame of the data; what it states.
    fn frame(
        &self,
        ending: &str,
        field: &str,
        code: Code,
        planned: &Transform,
        findings: &mut Findings,
    ) -> Option<Transform> {
        let name = self.own(ending);
        let (line, numbers) = value(self.data_file(), self.scope, (&name, "FRAME"), (code, field), findings)?;
        let differs = Differs { checker: self, name: &name, line, code };
        differs.frame("", field, &numbers, planned, findings)
    }

    fn load(&self, findings: &mut Findings) {
        let name = self.own("load");
        let field = "robot.cell.tcp.load";
        let Some((line, n)) = value(self.data_file(), self.scope, (&name, "LOAD"), (E1010, field), findings) else {
            return;
        };
        let differs = Differs { checker: self, name: &name, line, code: E1010 };
        let load = &self.wanted.cell.tcp.load;
        differs.number("M", "robot.cell.tcp.load.mass", "kg", (n[0], load.mass.0), 0.0, findings);
        // The job gives the moments along the tool frame's axes; without them the load is a point.
        let (axes, moments) = match load.inertia {
            Some(inertia) => (self.wanted.motion.frames.flange_tool.rotation, [inertia.x.0, inertia.y.0, inertia.z.0]),
            None => (UnitQuaternion::identity(), [0.0; 3]),
        };
        let centre = Translation3::new(load.centre.x.0, load.centre.y.0, load.centre.z.0);
        let wanted = Transform::from_parts(centre, axes);
        differs.frame("CM.", "robot.cell.tcp.load.centre", &n[1..7], &wanted, findings);
        for (k, component) in ["J.X", "J.Y", "J.Z"].into_iter().enumerate() {
            let pair = (n[7 + k], moments[k]);
            differs.number(component, "robot.cell.tcp.load.inertia", "kg m^2", pair, 0.0, findings);
        }
    }

    /// All routines: each wanted one there once and saying what it must, no other.
    fn routines(&self, source: &Source, wanted: &[WantedRoutine], findings: &mut Findings) {
        let file = &self.files.source.name;
        for routine in &source.routines {
            let known = wanted.iter().any(|want| want.name.eq_ignore_ascii_case(&routine.name));
            let count = source.routines.iter().filter(|other| other.name.eq_ignore_ascii_case(&routine.name)).count();
            if !known || count > 1 {
                let what = format!("the job does not ask for the routine `{}`", routine.name);
                findings.add(|| at(file, routine.line, E1003, "target", what));
            }
        }
        for want in wanted {
            match source.routines.iter().find(|found| found.name.eq_ignore_ascii_case(&want.name)) {
                Some(found) => self.routine(found, want, findings),
                None => {
                    findings.add(|| at(file, 1, E1003, "target", format!("the routine `{}` is missing", want.name)));
                }
            }
        }
    }

    fn routine(&self, found: &Routine, want: &WantedRoutine, findings: &mut Findings) {
        let file = &self.files.source.name;
        heading(file, found, want, findings);
        let body: Vec<&Statement> = found.body.iter().collect();
        compare(file, self.scope, found.line, &body, &want.steps, findings);
    }
}

/// The heading of a routine and what it declares.
pub fn heading(file: &str, found: &Routine, want: &WantedRoutine, findings: &mut Findings) {
    let same_type = match (&found.returns, want.returns) {
        (Some(a), Some(b)) => a.eq_ignore_ascii_case(b),
        (None, None) => true,
        _ => false,
    };
    let same_parameters = found.parameters.len() == want.parameters.len()
        && found.parameters.iter().zip(want.parameters).all(|(a, b)| a.eq_ignore_ascii_case(b));
    if !same_type || !same_parameters || found.global != want.global {
        let what = format!("the heading of `{}` differs from what the job asks for", found.name);
        findings.add(|| at(file, found.line, E1003, "target", what));
    }
    let is = |data: &Data, (of_type, name): &(&str, &str)| {
        data.of_type.eq_ignore_ascii_case(of_type) && data.name.eq_ignore_ascii_case(name)
    };
    for one in &found.data {
        if !want.data.iter().any(|wanted| is(one, wanted)) {
            let what = format!("`{}` does not declare `{} {}` in the job's program", found.name, one.of_type, one.name);
            findings.add(|| at(file, one.line, E1001, "target", what));
        }
    }
    for (of_type, name) in want.data {
        match found.data.iter().filter(|one| is(one, &(of_type, name))).count() {
            1 => {}
            0 => {
                let what = format!("`{of_type} {name}` is not declared in `{}`", found.name);
                findings.add(|| at(file, found.line, E1003, "target", what));
            }
            _ => {
                let what = format!("`{name}` is declared twice");
                findings.add(|| at(file, found.line, E1001, "target", what));
            }
        }
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
        at(self.checker.data_file(), self.line, self.code, field, format!("`{}`: {what}", self.name))
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

    /// A frame of six numbers; the transform that it states.
    fn frame(
        &self,
        component: &str,
        field: &str,
        found: &[f64],
        wanted: &Transform,
        findings: &mut Findings,
    ) -> Option<Transform> {
        // The controller stores single precision.
        let found: Vec<f64> = found.iter().map(|v| f64::from(*v as f32)).collect();
        let half_digit = half_digit(self.checker.wanted.krl.controller.position_decimals);
        let t = wanted.translation.vector;
        for (k, (axis, wanted)) in ["X", "Y", "Z"].into_iter().zip([t.x, t.y, t.z]).enumerate() {
            let pair = (found[k], wanted * 1e3);
            self.number(&format!("{component}{axis}"), field, "mm", pair, half_digit + single_step(pair.1), findings);
        }
        let turned = rotation([found[3], found[4], found[5]]);
        let angle = angle_between(&turned, &wanted.rotation);
        let aligned = angle <= ORIENTATION_TOLERANCE;
        if !aligned {
            findings.add(|| {
                let degrees = angle.to_degrees();
                self.problem(
                    field,
                    format!("{component}A, B, C are turned by {degrees:.4} deg from where the job has it"),
                )
            });
        }
        let [x, y, z] = [found[0], found[1], found[2]].map(|v| v * 1e-3);
        aligned.then(|| Transform::from_parts(Translation3::new(x, y, z), turned))
    }
}
