//! The influence of a pad near the part's edge.
//!
//! In: the job's pad with its edge model, the part's outline. Out: the influence functions that the removal near the edge is a sum
//! of, their weights at every place of the part, and whether a path keeps the pad from tipping.

use super::edge::{EdgeContact, EdgePressure};
use super::influence::{InfluenceFunction, Radial};
use super::pad::PadMotion;
use super::part_to_tool;
use super::quadrature::Quadrature;
use crate::diagnostics::{Problem, codes};
use crate::job::{Aperture, EdgeModel, PlanetaryPad, Preston};
use std::f64::consts::{PI, TAU};

/// Orders of the orbit's angle that the pressure is told by. What is left out is within half a per cent of the greatest rate for
/// the area model and 3 % for the linear one where the pad of the model's page is about to tip, and within 0.2 % of the volume; the
/// two models differ by more than ten times that.
const ORDERS: usize = 2;

/// Steps of the table over the distance from the edge.
const TABLE_STEPS: usize = 128;

/// A pad near the part's edge: the weights of its parts.
///
/// With the pad's middle at the orbit's angle psi from the outward direction, the pressure is `A(psi) + B(psi) x`, x from the tool's
/// axis outwards. Both are told by their first cosines of psi; averaged over the orbit each cosine makes an influence function of
/// its own, and the place of the tool only its weight.
#[derive(Clone, Debug)]
pub struct PadEdge {
    outline: Aperture,
    contact: EdgeContact,
    linear: bool,
    eccentricity: f64,
    /// From where the pad begins to hang over, down to where it tips: the tool's distance inside the edge.
    from: f64,
    to: f64,
    /// For each step from `from` to `to` the cosine coefficients of A, then those of B times a metre.
    table: Vec<[f64; 2 * (ORDERS + 1)]>,
}

impl PadEdge {
    /// The weights, and the parts that they belong to, the first of which is the pad's removal away from the edge.
    pub(super) fn new(
        pad: &PlanetaryPad,
        preston: &Preston,
        outline: &Aperture,
    ) -> Result<(PadEdge, Vec<InfluenceFunction>), Problem> {
        let motion = PadMotion::of(pad);
        let whole = super::pad::influence(pad, preston)?;
        let contact = EdgeContact { radius: motion.radius, outline: round(outline) };
        let linear = pad.edge == EdgeModel::linear;
        let e = motion.eccentricity;
        let (from, to) = (motion.reach(), motion.radius - contact.tipping_overhang() + e);
        let mut edge =
            PadEdge { outline: outline.clone(), contact, linear, eccentricity: e, from, to, table: Vec::new() };
        edge.table =
            (0..=TABLE_STEPS).map(|k| edge.coefficients(from + (to - from) * k as f64 / TABLE_STEPS as f64)).collect();
        let factor = preston.coefficient.0 * pad.force.0 / (PI * motion.radius * motion.radius);
        let width = whole.sigma_scale();
        let breaks = motion.breaks();
        let quadrature = Quadrature::new();
        let mut parts = Vec::new();
        let mut add = |order: usize, turned: usize, times_s: bool| {
            let radial = Radial::new(&breaks, |s| {
                let angle = motion.contact_angle(s);
                let cosine = |phi: f64| motion.speed(s, phi) * libm::cos(order as f64 * phi);
                let mean = quadrature.integrate(0.0, angle, cosine) / PI;
                factor * mean * if times_s { s } else { 1.0 }
            });
            let senses: &[bool] = if turned == 0 { &[false] } else { &[false, true] };
            for sine in senses {
                let volume = if turned == 0 { TAU * quadrature.piecewise(&breaks, |s| s * radial.at(s)) } else { 0.0 };
                parts.push(InfluenceFunction::of_harmonic(radial.clone(), turned, *sine, volume, width));
            }
        };
        for order in 0..=ORDERS {
            add(order, order, false);
        }
        if linear {
            for order in 0..=ORDERS {
                add(order, order + 1, true);
                if order > 0 {
                    add(order, order - 1, true);
                }
            }
        }
        parts[0] = whole;
        Ok((edge, parts))
    }

    /// Cosine coefficients of A and B for a tool so far inside the edge.
    fn coefficients(&self, inside: f64) -> [f64; 2 * (ORDERS + 1)] {
        const ANGLES: usize = 256;
        let mut out = [0.0; 2 * (ORDERS + 1)];
        for k in 0..ANGLES {
            let psi = PI * (k as f64 + 0.5) / ANGLES as f64;
            let outwards = self.eccentricity * libm::cos(psi);
            let middle = if self.contact.outline.is_finite() {
                let r = self.contact.outline;
                let across = self.eccentricity * libm::sin(psi);
                r - libm::hypot(r - inside + outwards, across)
            } else {
                inside - outwards
            };
            let EdgePressure { even, slope } =
                if self.linear { self.contact.linear(middle) } else { self.contact.area(middle) };
            for order in 0..=ORDERS {
                let share = libm::cos(order as f64 * psi) * if order == 0 { 1.0 } else { 2.0 } / ANGLES as f64;
                out[order] += share * (even - slope * outwards);
                out[ORDERS + 1 + order] += share * slope;
            }
        }
        out
    }

    /// The weights for a tool at the part's (x, y) whose x axis points along `azimuth`. Beyond where the pad tips they are those of
    /// the tipping pad; [`check`] refuses such a path.
    pub(super) fn weights(&self, x: f64, y: f64, azimuth: f64, out: &mut [f64]) {
        out.fill(0.0);
        let inside = self.outline.distance(x, y);
        if inside >= self.from {
            out[0] = 1.0;
            return;
        }
        let step = ((self.from - inside) / (self.from - self.to)).clamp(0.0, 1.0) * TABLE_STEPS as f64;
        let k = (step as usize).min(TABLE_STEPS - 1);
        let share = step - k as f64;
        let value = |i: usize| self.table[k][i] + share * (self.table[k + 1][i] - self.table[k][i]);
        let [nx, ny] = self.outwards(x, y);
        let [tx, ty] = part_to_tool(nx, ny, azimuth);
        let angle = libm::atan2(ty, tx);
        let mut next = 0;
        let mut add = |turned: usize, weight: f64| {
            out[next] += weight * libm::cos(turned as f64 * angle);
            next += 1;
            if turned > 0 {
                out[next] += weight * libm::sin(turned as f64 * angle);
                next += 1;
            }
        };
        for order in 0..=ORDERS {
            add(order, value(order));
        }
        if self.linear {
            // s cos(g) cos(kg) = s/2 (cos((k+1) g) + cos((k-1) g)), g the point's angle from the outward direction.
            for order in 0..=ORDERS {
                let weight = value(ORDERS + 1 + order);
                if order == 0 {
                    add(1, weight);
                } else {
                    add(order + 1, 0.5 * weight);
                    add(order - 1, 0.5 * weight);
                }
            }
        }
    }

    /// Unit vector to the outside: against which the distance from the edge grows.
    fn outwards(&self, x: f64, y: f64) -> [f64; 2] {
        // Over a micrometre: a thousandth of what the pad's pressure changes over.
        const STEP: f64 = 1e-6;
        let slope = |dx: f64, dy: f64| self.outline.distance(x - dx, y - dy) - self.outline.distance(x + dx, y + dy);
        let (gx, gy) = (slope(STEP, 0.0), slope(0.0, STEP));
        let length = libm::hypot(gx, gy);
        if length > 0.0 { [gx / length, gy / length] } else { [1.0, 0.0] }
    }
}

/// The radius of a round outline; any other counts as straight, since a pad is small beside it.
fn round(outline: &Aperture) -> f64 {
    match outline {
        Aperture::circle(circle) => circle.diameter.0 / 2.0,
        Aperture::annulus(annulus) => annulus.outer_diameter.0 / 2.0,
        _ => f64::INFINITY,
    }
}

/// Whether the pad may stand at the places of a path: E0653 where it tips over the edge, W0601 where it hangs over it. The worst place
/// is said.
pub(super) fn check(pad: &PlanetaryPad, outline: &Aperture, places: impl Iterator<Item = [f64; 2]>) -> Option<Problem> {
    if pad.edge == EdgeModel::support_ring {
        return None;
    }
    let (radius, e) = (pad.diameter.0 / 2.0, pad.eccentricity.0);
    let contact = EdgeContact { radius, outline: round(outline) };
    let (inside, [x, y]) = places
        .map(|[x, y]| (outline.distance(x, y), [x, y]))
        .fold((f64::INFINITY, [0.0; 2]), |least, here| if here.0 < least.0 { here } else { least });
    let overhang = radius + e - inside;
    if !(overhang > 0.0) {
        return None;
    }
    let most = contact.tipping_overhang();
    let message = format!(
        "at x {:.3} mm, y {:.3} mm the pad hangs {:.3} mm over the part's edge on its orbit",
        x * 1e3,
        y * 1e3,
        overhang * 1e3
    );
    let least = radius + e - most;
    if overhang > most {
        return Some(
            Problem::error(codes::E0653, "path.over", message)
                .note(format!(
                    "a pad of {:.3} mm radius on a joint tips from {:.3} mm on: the pressure of its far rim would have to pull",
                    radius * 1e3,
                    most * 1e3
                ))
                .help(format!(
                    "keep the tool's axis at least {:.2} mm inside the edge, or carry the pad by a ring: `edge: support_ring`",
                    (least * 1e5).ceil() / 100.0
                )),
        );
    }
    let model = match pad.edge {
        EdgeModel::not_modelled => "as if the part went on",
        EdgeModel::area => "with the force spread evenly over the contact",
        EdgeModel::linear | EdgeModel::support_ring => "with a pressure that grows evenly towards the edge",
    };
    Some(
        Problem::warning(codes::W0601, "tool.edge", message)
            .note(format!(
                "within {:.3} mm of the edge the removal is predicted {model}, and unverified: the models differ there",
                2.0 * (radius + e) * 1e3
            ))
            .help("measure the edge after a first run before it counts"),
    )
}

#[cfg(test)]
#[allow(clippy::disallowed_methods, reason = "tests may use the platform's mathematics")]
mod tests {
    use super::*;
    use crate::job::{Circle, Influence, Seen, Sense, SpinMeasured, Turn};
    use crate::units::si::*;

    /// The pad of the model's page: 10 mm, eccentricity 4 mm, 90 and -250 rpm on the arm, 30 N; a part of 200 mm.
    fn pad(edge: EdgeModel) -> PlanetaryPad {
        let turn = |rpm: f64| Turn {
            speed: AngularSpeed(rpm * TAU / 60.0),
            positive: Sense::counterclockwise,
            seen: Seen::from_tool_side,
        };
        PlanetaryPad {
            diameter: Length(10e-3),
            eccentricity: Length(4e-3),
            orbit: turn(90.0),
            spin: turn(-250.0),
            spin_measured: SpinMeasured::on_arm,
            force: Force(30.0),
            azimuth: Angle(0.0),
            influence: Influence::preston(Preston { coefficient: PerPressure(1e-13) }),
            edge,
        }
    }

    fn outline() -> Aperture {
        Aperture::circle(Circle { diameter: Length(0.2), centre: None })
    }

    /// The removal near the edge against a sum over the orbit, in which each phase has the pressure of its own place.
    #[test]
    fn the_parts_sum_to_the_pressure_of_every_phase() {
        let contact = EdgeContact { radius: 5e-3, outline: 0.1 };
        // What the orders leave out grows with the overhang; the bounds are those that the module states, in parts of the peak.
        for (model, overhang, bound) in [
            (EdgeModel::area, 1e-3, 2e-3),
            (EdgeModel::area, 2.6e-3, 7e-3),
            (EdgeModel::linear, 1e-3, 7e-3),
            (EdgeModel::linear, 2.6e-3, 3e-2),
        ] {
            let pad = pad(model);
            let Influence::preston(preston) = &pad.influence else { panic!("preston") };
            let (edge, parts) = PadEdge::new(&pad, preston, &outline()).expect("a pad that turns");
            let motion = PadMotion::of(&pad);
            let (direction, azimuth) = (0.7_f64, 0.3);
            let distance = 0.1 - (9e-3 - overhang);
            let stands = [distance * direction.cos(), distance * direction.sin()];
            let mut weights = vec![0.0; parts.len()];
            edge.weights(stands[0], stands[1], azimuth, &mut weights);
            let peak = parts[0].rate(1e-3, 0.0);
            let factor = 1e-13 * 30.0 / (PI * 25e-6);
            // Each phase: its angle, where the pad's middle is, and the pressure there.
            let count = 3600;
            let phases: Vec<(f64, [f64; 2], EdgePressure)> = (0..count)
                .map(|p| {
                    let phase = TAU * (f64::from(p) + 0.5) / f64::from(count);
                    let middle = [4e-3 * phase.cos(), 4e-3 * phase.sin()];
                    let inside = 0.1 - (stands[0] + middle[0]).hypot(stands[1] + middle[1]);
                    let linear = model == EdgeModel::linear;
                    (phase, middle, if linear { contact.linear(inside) } else { contact.area(inside) })
                })
                .collect();
            let (mut found_volume, mut expected_volume, mut worst) = (0.0_f64, 0.0_f64, 0.0_f64);
            for i in -8..=8 {
                for j in -8..=8 {
                    let (dx, dy) = (f64::from(i) * 1.05e-3, f64::from(j) * 1.05e-3);
                    if (stands[0] + dx).hypot(stands[1] + dy) > 0.1 {
                        continue;
                    }
                    let [x, y] = part_to_tool(dx, dy, azimuth);
                    let found: f64 = parts.iter().zip(&weights).map(|(part, weight)| weight * part.rate(x, y)).sum();
                    let mut expected = 0.0;
                    for (phase, [cx, cy], EdgePressure { even, slope }) in &phases {
                        if (dx - cx).hypot(dy - cy) < 5e-3 {
                            let outwards = (dx - cx) * direction.cos() + (dy - cy) * direction.sin();
                            let speed = motion.speed(dx.hypot(dy), phase - dy.atan2(dx));
                            expected += factor * speed * (even + slope * outwards) / f64::from(count);
                        }
                    }
                    worst = worst.max((found - expected).abs() / peak);
                    found_volume += found;
                    expected_volume += expected;
                }
            }
            assert!(worst < bound, "{model:?}, {overhang}: {worst} of the peak");
            let volume = found_volume / expected_volume - 1.0;
            assert!(volume.abs() < 5e-3, "{model:?}, {overhang}: {volume} of the volume");
        }
    }

    #[test]
    fn away_from_the_edge_the_pad_is_itself() {
        let pad = pad(EdgeModel::linear);
        let Influence::preston(preston) = &pad.influence else { panic!("preston") };
        let (edge, parts) = PadEdge::new(&pad, preston, &outline()).expect("a pad that turns");
        let mut weights = vec![f64::NAN; parts.len()];
        edge.weights(0.0, 0.0905, 0.0, &mut weights);
        assert!(weights[0] == 1.0 && weights[1..].iter().all(|weight| *weight == 0.0), "{weights:?}");
    }
}
