//! The planetary pad: a flat pad that spins on an arm, which orbits about the tool's axis.
//!
//! In: the pad's size, its two turns, its force. Out: the mean rubbing speed around the axis in closed form, the depth
//! rate of Preston's law and what follows from it. Model: L. Zhao, J. Zhang, L. Gao, Opt. Eng. 61, 045104 (2022), with the
//! orbit average written as an incomplete elliptic integral.
//!
//! A point at the distance s from the tool's axis rubs, while the pad is over it, with
//! v² = W² s² + u² e² - 2 W u s e cos(phi), where phi is the orbit's angle from the point, W the pad's absolute turn, u = W
//! less the orbit's turn, e the eccentricity. The pad is over it for |phi| < phi_0(s).

use super::influence::{InfluenceFunction, Radial};
use super::quadrature::{Quadrature, elliptic_e};
use crate::diagnostics::{Problem, codes};
use crate::job::{PlanetaryPad, Preston, Seen, Sense, SpinMeasured, Turn};
use std::f64::consts::{PI, TAU};

impl Turn {
    /// Counter-clockwise seen from the tool side, radians a second.
    pub fn counterclockwise(&self) -> f64 {
        let turned = match (self.positive, self.seen) {
            (Sense::counterclockwise, Seen::from_tool_side) | (Sense::clockwise, Seen::from_glass) => 1.0,
            (Sense::clockwise, Seen::from_tool_side) | (Sense::counterclockwise, Seen::from_glass) => -1.0,
        };
        turned * self.speed.0
    }
}

/// How a planetary pad moves; lengths in metres, turns in radians a second, counter-clockwise positive.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PadMotion {
    /// Of the pad's face.
    pub radius: f64,
    pub eccentricity: f64,
    pub orbit: f64,
    /// Of the pad against the housing.
    pub turn: f64,
}

impl PadMotion {
    /// Of the job's pad.
    pub fn of(pad: &PlanetaryPad) -> PadMotion {
        let (orbit, spin) = (pad.orbit.counterclockwise(), pad.spin.counterclockwise());
        let turn = match pad.spin_measured {
            SpinMeasured::on_arm => orbit + spin,
            SpinMeasured::absolute => spin,
        };
        PadMotion { radius: pad.diameter.0 / 2.0, eccentricity: pad.eccentricity.0, orbit, turn }
    }

    /// Nothing is rubbed farther than this from the tool's axis.
    pub fn reach(&self) -> f64 {
        self.radius + self.eccentricity
    }

    /// Half of the orbit's angle over which the pad is over a point at the distance `s`: phi_0, 0 to π.
    pub fn contact_angle(&self, s: f64) -> f64 {
        let (a, e) = (self.radius, self.eccentricity);
        if s >= a + e || s < e - a {
            0.0
        } else if s <= a - e {
            PI
        } else {
            libm::acos(((s * s + e * e - a * a) / (2.0 * s * e)).clamp(-1.0, 1.0))
        }
    }

    /// Rubbing speed at the distance `s` while the orbit stands at `phi` from the point, m/s.
    pub fn speed(&self, s: f64, phi: f64) -> f64 {
        let (near, far) = (self.turn * s, (self.turn - self.orbit) * self.eccentricity);
        (near * near + far * far - 2.0 * near * far * libm::cos(phi)).max(0.0).sqrt()
    }

    /// Rubbing speed at the distance `s`, averaged over the orbit with zero where the pad is not: g(s), m/s.
    pub fn mean_speed(&self, s: f64) -> f64 {
        let angle = self.contact_angle(s);
        let (near, far) = (self.turn * s, (self.turn - self.orbit) * self.eccentricity);
        let (a, b) = (near * near + far * far, 2.0 * near * far);
        let sum = a + b.abs();
        if angle == 0.0 || sum == 0.0 {
            return 0.0;
        }
        // Rounding where |W s| = |u e| would take m beyond 1.
        let (q, m) = (2.0 * sum.sqrt(), (2.0 * b.abs() / sum).min(1.0));
        if b >= 0.0 {
            q * (elliptic_e(PI / 2.0, m) - elliptic_e((PI - angle) / 2.0, m)) / PI
        } else {
            q * elliptic_e(angle / 2.0, m) / PI
        }
    }

    /// Where the mean speed has a kink, a root or a place of rest: between these it is smooth. From 0, or from where the pad
    /// begins to reach, to the reach.
    pub fn breaks(&self) -> Vec<f64> {
        let (a, e) = (self.radius, self.eccentricity);
        let mut breaks = vec![(e - a).max(0.0), (a - e).abs(), a + e];
        // Where the two speeds cancel the point rests once in each orbit.
        if self.turn != 0.0 {
            breaks.push(((self.turn - self.orbit) * e / self.turn).abs());
        }
        let (first, last) = (breaks[0], a + e);
        breaks.retain(|s| *s >= first && *s <= last);
        breaks.sort_by(f64::total_cmp);
        breaks.dedup_by(|b, a| *b - *a <= 1e-9 * last);
        breaks
    }

    /// The integral of 2 π s g(s): times Preston's coefficient and the pressure it is the volume rate. m³/s
    pub fn swept(&self) -> f64 {
        TAU * Quadrature::new().piecewise(&self.breaks(), |s| s * self.mean_speed(s))
    }

    /// Root of the second moment of the rate along one axis, metres.
    pub fn sigma(&self) -> f64 {
        let quadrature = Quadrature::new();
        let volume = quadrature.piecewise(&self.breaks(), |s| self.mean_speed(s) * s);
        (quadrature.piecewise(&self.breaks(), |s| self.mean_speed(s) * s * s * s) / (2.0 * volume)).sqrt()
    }

    /// What the tool removes of a ripple of this period, against what it removes of an even layer: the Hankel transform of
    /// the rate over its volume. 1 for long periods.
    pub fn transfer(&self, period: f64) -> f64 {
        let quadrature = Quadrature::new();
        let wave = |s: f64| libm::j0(TAU * s / period);
        let part = quadrature.piecewise(&self.breaks(), |s| self.mean_speed(s) * s * wave(s));
        part / quadrature.piecewise(&self.breaks(), |s| self.mean_speed(s) * s)
    }
}

/// The influence function of the pad: Preston's coefficient times force over face times mean speed.
pub(super) fn influence(pad: &PlanetaryPad, preston: &Preston) -> Result<InfluenceFunction, Problem> {
    let motion = PadMotion::of(pad);
    let factor = preston.coefficient.0 * pad.force.0 / (PI * motion.radius * motion.radius);
    let swept = motion.swept();
    if !(swept > 0.0 && swept.is_finite() && factor > 0.0 && factor.is_finite()) {
        let message = "the pad does not move: its two turns leave every point of the glass at rest under it";
        return Err(Problem::error(codes::E0650, "tool.spin", message)
            .help("give `spin` a speed; with `spin_measured: on_arm` the orbit counts as well"));
    }
    let radial = Radial::new(&motion.breaks(), |s| factor * motion.mean_speed(s));
    Ok(InfluenceFunction::of_radial(radial, factor * swept, motion.sigma()))
}

/// What is wrong with the pad's numbers (E0650). Fields are `tool.…`.
pub(super) fn numbers(pad: &PlanetaryPad) -> Vec<Problem> {
    let mut problems = Vec::new();
    let mut refuse = |name: &str, message: String, why: &str| {
        problems.push(Problem::error(codes::E0650, format!("tool.{name}"), message).note(why));
    };
    let positive = |value: f64| value > 0.0 && value.is_finite();
    if !positive(pad.diameter.0) {
        let message = format!("the pad's `diameter` is {:.3} mm; it must be positive", pad.diameter.0 * 1e3);
        refuse("diameter", message, "a pad has a size");
    }
    if !(pad.eccentricity.0 >= 0.0 && pad.eccentricity.0.is_finite()) {
        let message =
            format!("the pad's `eccentricity` is {:.3} mm; it must not be negative", pad.eccentricity.0 * 1e3);
        refuse("eccentricity", message, "it is a distance");
    }
    if !positive(pad.force.0) {
        let message = format!("the pad's `force` is {:.3} N; it must be positive", pad.force.0);
        refuse("force", message, "without a force nothing is rubbed off");
    }
    for (name, turn) in [("orbit", &pad.orbit), ("spin", &pad.spin)] {
        if !turn.speed.0.is_finite() {
            refuse(name, format!("the pad's `{name}` has no finite speed"), "a turn has a speed");
        }
    }
    if pad.eccentricity.0 > 0.0 && pad.orbit.speed.0 == 0.0 {
        let message = "the orbit stands still, and the pad sits off its axis".to_string();
        refuse(
            "orbit",
            message,
            "the removal is that of the pad on its whole orbit; a pad that only spins has `eccentricity: 0 mm`",
        );
    }
    problems
}
