//! The bonnet: an inflated cap that spins about a leaning axis.
//!
//! In: the bonnet's size, its offset, its turn and lean, the exponent of the pressure. Out: the depth rate over the contact.
//! Model: C.-J. Huang, Y. Wang, Y. Lin (2022), robotic bonnet polishing, with the exponent left free.
//!
//! The cap of radius R, pressed in by d, touches the glass in a circle of radius a about the foot of its middle, which is h
//! above it. A point of the contact rubs with the speed of the cap turning rigidly about its axis, laid into the surface; the
//! pressure falls as (1 - r²/a²)^m.
//!
//! In the tool frame the shaft leans towards +x.

use super::influence::InfluenceFunction;
use super::quadrature::Quadrature;
use crate::diagnostics::{Problem, codes};
use crate::job::{Bonnet, BonnetContact, ContactRate, Lean, Precession};
use std::f64::consts::TAU;

/// The offset at which the cap is bent so much that a sphere's geometry does not tell its contact: a tenth of its radius.
const LARGEST_OFFSET: f64 = 0.1;

/// The circle in which a cap touches the glass: its radius and how high the cap's middle stands over it, metres.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ContactCircle {
    pub radius: f64,
    pub height: f64,
}

impl ContactCircle {
    /// Of a cap of `radius`, pressed in by `offset`, on glass of this curvature in 1/m: positive where it is hollow, 0 for a
    /// flat. `None` where the cap does not meet it in a circle: the hollow is narrower than the cap.
    pub fn new(radius: f64, offset: f64, curvature: f64) -> Option<ContactCircle> {
        let (r, h) = (radius, radius - offset);
        let height = if curvature == 0.0 {
            h
        } else {
            let part = 1.0 / curvature.abs();
            // The spheres' middles lie s apart; the circle in which they cut has its plane at this height below the cap's.
            if curvature > 0.0 {
                let s = part - h;
                (part * part - r * r - s * s) / (2.0 * s)
            } else {
                let s = part + h;
                (s * s + r * r - part * part) / (2.0 * s)
            }
        };
        let square = r * r - height * height;
        let meets = curvature * radius < 1.0 && square > 0.0 && height.is_finite();
        meets.then(|| ContactCircle { radius: square.sqrt(), height })
    }
}

/// Pressure and speed over the contact of a bonnet, times a factor.
#[derive(Clone, Debug, PartialEq)]
pub struct Contact {
    circle: ContactCircle,
    exponent: f64,
    /// kp0, preston's coefficient times the pressure in the middle, times the spin in rad/s.
    factor: f64,
    tilt_cosine: f64,
    tilt_sine: f64,
    /// Unit vectors of the leans in the tool frame; their mean removes.
    leans: Vec<[f64; 2]>,
}

impl Contact {
    /// One lean along +x of the tool frame. `wear` is kp0, a plain number; angles in radians, `spin` in rad/s.
    pub fn new(circle: ContactCircle, exponent: f64, wear: f64, tilt: f64, spin: f64) -> Contact {
        let (tilt_sine, tilt_cosine) = libm::sincos(tilt);
        Contact { circle, exponent, factor: wear * spin.abs(), tilt_cosine, tilt_sine, leans: vec![[1.0, 0.0]] }
    }

    /// The mean over so many evenly spread leans, the first along +x.
    pub fn stepped(mut self, positions: usize) -> Contact {
        let lean = |k: usize| {
            let (sin, cos) = libm::sincos(TAU * k as f64 / positions as f64);
            [cos, sin]
        };
        self.leans = (0..positions).map(lean).collect();
        self
    }

    /// Depth rate at a place of the tool frame, m/s.
    pub fn rate(&self, x: f64, y: f64) -> f64 {
        let share = 1.0 - (x * x + y * y) / (self.circle.radius * self.circle.radius);
        if share <= 0.0 {
            return 0.0;
        }
        let (c, lever) = (self.tilt_cosine, self.circle.height * self.tilt_sine);
        let speed = |[lx, ly]: &[f64; 2]| libm::hypot(lever * ly + y * c, x * c + lever * lx);
        let mean = self.leans.iter().map(speed).sum::<f64>() / self.leans.len() as f64;
        self.factor * libm::pow(share, self.exponent) * mean
    }

    /// Where the rate of a single lean is greatest: so far from the middle, towards the shaft's lean. The root of
    /// c (1 + 2m) x² + 2 m A x - c a² = 0 with A = h sin(tilt), c = cos(tilt).
    pub fn peak_offset(&self) -> f64 {
        let (a, m, c) = (self.circle.radius, self.exponent, self.tilt_cosine);
        let lever = self.circle.height * self.tilt_sine;
        let root = (m * m * lever * lever + (1.0 + 2.0 * m) * c * c * a * a).sqrt();
        (root - m * lever) / (c * (1.0 + 2.0 * m))
    }

    /// Volume rate, and the root of the smaller second moment about the centroid.
    fn moments(&self) -> (f64, f64) {
        // Around, the rate is a smooth periodic function: with so many places the sum is exact to rounding.
        const AROUND: usize = 64;
        let quadrature = Quadrature::new();
        let moment = |power: &dyn Fn(f64, f64) -> f64| {
            quadrature.integrate(0.0, self.circle.radius, |r| {
                let ring: f64 = (0..AROUND)
                    .map(|k| {
                        let (sin, cos) = libm::sincos(TAU * k as f64 / AROUND as f64);
                        let (x, y) = (r * cos, r * sin);
                        self.rate(x, y) * power(x, y)
                    })
                    .sum();
                r * ring * TAU / AROUND as f64
            })
        };
        let volume = moment(&|_, _| 1.0);
        let (x, y) = (moment(&|x, _| x) / volume, moment(&|_, y| y) / volume);
        let xx = moment(&|x, _| x * x) / volume - x * x;
        let yy = moment(&|_, y| y * y) / volume - y * y;
        let xy = moment(&|x, y| x * y) / volume - x * y;
        let smaller = (xx + yy) / 2.0 - libm::hypot((xx - yy) / 2.0, xy);
        (volume, smaller.sqrt())
    }

    pub(super) fn influence(self) -> InfluenceFunction {
        let (volume, sigma) = self.moments();
        let radius = self.circle.radius;
        InfluenceFunction::of_contact(self, radius, volume, sigma)
    }
}

impl Bonnet {
    /// Angle between spin axis and normal, radians.
    pub fn tilt(&self) -> f64 {
        match &self.precession {
            Precession::upright(_) => 0.0,
            Precession::leaning(leaning) => leaning.tilt.0,
        }
    }

    /// Direction of the tool's x axis on the part: to where the shaft leans first, radians.
    pub fn azimuth(&self) -> f64 {
        match &self.precession {
            Precession::upright(_) => 0.0,
            Precession::leaning(leaning) => match &leaning.azimuth {
                Lean::held(held) => held.at.0,
                Lean::stepped(stepped) => stepped.first.0,
            },
        }
    }

    /// How many leans there are.
    pub fn positions(&self) -> usize {
        match &self.precession {
            Precession::leaning(leaning) => match &leaning.azimuth {
                // The language takes 2 to 16 of them; a mean over less than one is none.
                Lean::stepped(stepped) => usize::try_from(stepped.positions).unwrap_or(0).max(1),
                Lean::held(_) => 1,
            },
            Precession::upright(_) => 1,
        }
    }
}

/// The contact's kp0: stated, or from the greatest rate of a spot on a flat.
pub fn wear(bonnet: &Bonnet, contact: &BonnetContact) -> Option<f64> {
    match &contact.rate {
        ContactRate::wear(wear) => Some(wear.coefficient.0 * wear.greatest_pressure.0),
        ContactRate::spot_peak(peak) => {
            let flat = ContactCircle::new(bonnet.radius.0, bonnet.offset.0, 0.0)?;
            let unit = Contact::new(flat, contact.exponent, 1.0, bonnet.tilt(), bonnet.spin.speed.0);
            Some(peak.rate.0 / unit.rate(unit.peak_offset(), 0.0))
        }
    }
}

/// The influence function of the bonnet on glass of this curvature (1/m, positive where hollow). `at` is its field.
pub(super) fn influence(
    bonnet: &Bonnet,
    contact: &BonnetContact,
    curvature: f64,
    at: &str,
) -> Result<InfluenceFunction, Problem> {
    let made = ContactCircle::new(bonnet.radius.0, bonnet.offset.0, curvature).and_then(|circle| {
        let wear = wear(bonnet, contact).filter(|wear| *wear > 0.0 && wear.is_finite())?;
        let one = Contact::new(circle, contact.exponent, wear, bonnet.tilt(), bonnet.spin.speed.0);
        Some(one.stepped(bonnet.positions()).influence())
    });
    made.ok_or_else(|| {
        Problem::error(codes::E0650, at, "the bonnet's numbers give no rate of removal")
            .help("check `radius`, `offset` and `spin` of the bonnet, and `rate` of the influence function")
    })
}

/// What is wrong with the bonnet's numbers (E0650). Fields are `tool.…`.
pub(super) fn numbers(bonnet: &Bonnet) -> Vec<Problem> {
    let mut problems = Vec::new();
    let mut refuse = |name: &str, message: String, help: String| {
        problems.push(Problem::error(codes::E0650, format!("tool.{name}"), message).help(help));
    };
    let (radius, offset) = (bonnet.radius.0, bonnet.offset.0);
    if !(radius > 0.0 && radius.is_finite()) {
        let message = format!("the bonnet's `radius` is {:.3} mm; it must be positive", radius * 1e3);
        refuse("radius", message, "measure the cap, cloth included".into());
        return problems;
    }
    if !(offset > 0.0 && offset < LARGEST_OFFSET * radius) {
        let message = format!(
            "the bonnet's `offset` is {:.3} mm; for a cap of {:.3} mm radius it must be positive and below a tenth of that, {:.3} mm",
            offset * 1e3,
            radius * 1e3,
            LARGEST_OFFSET * radius * 1e3
        );
        refuse("offset", message, "an offset is a few tenths of a millimetre: check the unit".into());
        return problems;
    }
    if !(bonnet.spin.speed.0 != 0.0 && bonnet.spin.speed.0.is_finite()) {
        refuse("spin", "the bonnet does not spin, so nothing is removed".into(), "give `spin` a speed".into());
    }
    let Some(circle) = ContactCircle::new(radius, offset, 0.0) else { return problems };
    // The half angle under which the contact is seen from the middle of the cap.
    let contact = libm::asin(circle.radius / radius);
    let tilt = bonnet.tilt();
    if matches!(bonnet.precession, Precession::leaning(_)) && !(tilt > contact) {
        let message = format!(
            "with a `tilt` of {:.3} deg the pole of the cap, which stands still, lies inside the contact of {:.3} mm radius",
            tilt.to_degrees(),
            circle.radius * 1e3
        );
        let help =
            format!("tilt by more than {:.1} deg, or press in less", (contact.to_degrees() * 10.0).ceil() / 10.0);
        refuse("precession.tilt", message, help);
    }
    if tilt + contact > bonnet.cap.0 {
        let message = format!(
            "the contact reaches {:.3} deg from the cap's pole, and the cap ends at {:.3} deg",
            (tilt + contact).to_degrees(),
            bonnet.cap.0.to_degrees()
        );
        refuse("cap", message, "tilt less, press in less, or take a cap that reaches farther".into());
    }
    problems
}

/// The contact of a cap in a hollow grows without bound as their radii come together. For k times the cap's radius R and a small
/// offset d its radius a has a² = 2 d R k / (k - 1), so that a part of R changes a by k / 2(k - 1) times that part: as much at k = 2
/// (half as much on a flat), three times as much at k = 1.2, where the geometry tells nothing any more.
const LEAST_HOLLOW: f64 = 1.2;
const DOUBTFUL_HOLLOW: f64 = 2.0;

/// E0631 where the glass is hollow (the place, and one over the radius there) with less than 1.2 times the cap's radius,
/// W0604 below twice.
pub(super) fn fit(bonnet: &Bonnet, (place, sharpest): ([f64; 2], f64)) -> Option<Problem> {
    let radius = bonnet.radius.0;
    if sharpest * DOUBTFUL_HOLLOW * radius < 1.0 {
        return None;
    }
    let message = format!(
        "the bonnet of {:.3} mm radius works at x {:.3} mm, y {:.3} mm in a hollow of {:.3} mm radius, {:.2} times its own",
        radius * 1e3,
        place[0] * 1e3,
        place[1] * 1e3,
        1e3 / sharpest,
        1.0 / (sharpest * radius)
    );
    // Rounded down to a tenth of a millimetre, so that it fits.
    let smaller =
        |times: f64| format!("take a bonnet of at most {:.1} mm radius", (1e4 / (sharpest * times)).floor() / 10.0);
    Some(if sharpest * LEAST_HOLLOW * radius >= 1.0 {
        Problem::error(codes::E0631, "tool.radius", message)
            .note("below 1.2 times a per cent of the cap's radius changes the width of the contact by more than three")
            .help(smaller(LEAST_HOLLOW))
    } else {
        Problem::warning(codes::W0604, "tool.radius", message)
            .note("below twice a per cent of the cap's radius changes the width of the contact by more than one")
            .help(smaller(DOUBTFUL_HOLLOW))
    })
}
