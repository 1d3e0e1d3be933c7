//! The pressure under a pad that hangs over the part's edge.
//!
//! In: the pad's radius, how far its middle lies inside the edge, the part's radius there. Out: what is left of the contact,
//! and by two models the pressure on it: spread evenly (area), or growing evenly towards the edge so that the pad stays in
//! balance on its joint (linear; both as in computer-controlled optical surfacing, e.g. R. A. Jones, Opt. Eng. 25, 785 (1986)).
//! A pad on a joint tips where the linear pressure would have to pull.

use super::quadrature::Quadrature;
use std::f64::consts::PI;

/// The contact of a pad near an edge: a disc of which a part lies on the glass.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct EdgeContact {
    /// Of the pad, metres.
    pub radius: f64,
    /// Of the part's outline, metres; infinite where it is straight.
    pub outline: f64,
}

/// Pressure over the contact, in parts of the pressure of a pad wholly on the glass: `even + slope * x`, x from the pad's middle
/// outwards, metres.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct EdgePressure {
    pub even: f64,
    pub slope: f64,
}

impl EdgeContact {
    /// Part of the pad's face that lies on the glass when its middle lies `inside` the edge (negative: beyond), 0 to 1. For a round
    /// outline the lens of two circles.
    pub fn share(&self, inside: f64) -> f64 {
        let (a, r) = (self.radius, self.outline);
        if inside >= a {
            return 1.0;
        }
        if inside <= -a {
            return 0.0;
        }
        let segment = |radius: f64, cosine: f64| radius * radius * libm::acos(cosine.clamp(-1.0, 1.0));
        if !r.is_finite() {
            // A half plane: the disc less the circular segment beyond the edge.
            let beyond = segment(a, inside / a) - inside * (a * a - inside * inside).max(0.0).sqrt();
            return 1.0 - beyond / (PI * a * a);
        }
        let d = r - inside;
        let product = (-d + a + r) * (d + a - r) * (d - a + r) * (d + a + r);
        let lens = segment(a, (d * d + a * a - r * r) / (2.0 * d * a))
            + segment(r, (d * d + r * r - a * a) / (2.0 * d * r))
            - 0.5 * product.max(0.0).sqrt();
        lens / (PI * a * a)
    }

    /// Force over what is left of the contact.
    pub fn area(&self, inside: f64) -> EdgePressure {
        EdgePressure { even: 1.0 / self.share(inside), slope: 0.0 }
    }

    /// Pressure that grows evenly towards the edge, so that its sum is the force and its moment about the pad's middle nothing.
    pub fn linear(&self, inside: f64) -> EdgePressure {
        if inside >= self.radius {
            return EdgePressure { even: 1.0, slope: 0.0 };
        }
        let [area, first, second] = self.moments(inside);
        let even = PI * self.radius * self.radius / (area - first * first / second);
        EdgePressure { even, slope: -even * first / second }
    }

    /// Area of the contact, and the first and second moment of its distance outwards from the pad's middle.
    fn moments(&self, inside: f64) -> [f64; 3] {
        let (a, r) = (self.radius, self.outline);
        let end = inside.min(a);
        // Half of the chord across at the distance x outwards, on the pad and on the glass.
        let half = |x: f64| {
            let pad = a * a - x * x;
            let glass = if r.is_finite() { r * r - (r - inside + x) * (r - inside + x) } else { f64::INFINITY };
            pad.min(glass).max(0.0).sqrt()
        };
        let mut breaks = vec![-a];
        if r.is_finite() {
            // Where the two circles cut.
            let d = r - inside;
            let cut = (r * r - d * d - a * a) / (2.0 * d);
            if cut > -a && cut < end {
                breaks.push(cut);
            }
        }
        breaks.push(end);
        let quadrature = Quadrature::new();
        [
            quadrature.piecewise(&breaks, |x| 2.0 * half(x)),
            quadrature.piecewise(&breaks, |x| 2.0 * half(x) * x),
            quadrature.piecewise(&breaks, |x| 2.0 * half(x) * x * x),
        ]
    }

    /// The overhang (how far the pad's rim reaches beyond the edge) at which the linear pressure vanishes at the far rim: a pad on
    /// a joint tips beyond. 0.52 of the radius.
    pub fn tipping_overhang(&self) -> f64 {
        let lifts = |overhang: f64| {
            let EdgePressure { even, slope } = self.linear(self.radius - overhang);
            even - slope * self.radius < 0.0
        };
        // Between nothing and half of the pad and more it changes once.
        let (mut low, mut high) = (0.0, self.radius);
        for _ in 0..50 {
            let middle = 0.5 * (low + high);
            if lifts(middle) { high = middle } else { low = middle }
        }
        low
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The pad of 5 mm on a part of 100 mm radius at three overhangs: the lens, and the outer pressure by sums of 20,000 chords in
    /// numpy. (The table of the model's page has 0.947, 0.855, 0.801 and 1.26, 1.80, 2.20.)
    #[test]
    fn pressures_are_those_of_the_table() {
        let contact = EdgeContact { radius: 5e-3, outline: 0.1 };
        for (overhang, share, outer) in
            [(1e-3, 0.946_774, 1.259_52), (2e-3, 0.854_842, 1.795_70), (2.5e-3, 0.800_987, 2.193_92)]
        {
            let inside = 5e-3 - overhang;
            assert!((contact.share(inside) - share).abs() < 1e-6, "{overhang}");
            let EdgePressure { even, slope } = contact.linear(inside);
            assert!((even + slope * inside - outer).abs() < 1e-4, "{overhang}: {}", even + slope * inside);
        }
        assert!((contact.tipping_overhang() / 5e-3 - 0.522).abs() < 6e-4, "{}", contact.tipping_overhang());
    }

    /// Force and moment of the linear pressure, summed over a fine lattice of places: one, and nothing.
    #[test]
    fn the_linear_pressure_is_in_balance() {
        for outline in [0.1, f64::INFINITY] {
            let contact = EdgeContact { radius: 5e-3, outline };
            let inside = 3e-3;
            let EdgePressure { even, slope } = contact.linear(inside);
            let (n, step) = (1000, 1e-5);
            let (mut force, mut moment) = (0.0, 0.0);
            for i in -n / 2..n / 2 {
                for j in -n / 2..n / 2 {
                    let (x, y) = ((f64::from(i) + 0.5) * step, (f64::from(j) + 0.5) * step);
                    let on_glass =
                        if outline.is_finite() { libm::hypot(outline - inside + x, y) <= outline } else { x <= inside };
                    if x * x + y * y <= 25e-6 && on_glass {
                        force += (even + slope * x) * step * step;
                        moment += (even + slope * x) * x * step * step;
                    }
                }
            }
            let full = PI * 25e-6;
            assert!((force / full - 1.0).abs() < 1e-3, "{}", force / full);
            assert!(moment.abs() < 1e-3 * full * 5e-3, "{}", moment / full);
        }
    }

    #[test]
    fn a_wide_round_outline_is_nearly_straight() {
        // Under a pad of 5 mm an outline of 10 m bends by a micrometre: a part in several thousand of the contact.
        let (round, straight) =
            (EdgeContact { radius: 5e-3, outline: 10.0 }, EdgeContact { radius: 5e-3, outline: f64::INFINITY });
        for inside in [-4e-3, -1e-3, 0.0, 2e-3, 4.9e-3] {
            assert!((round.share(inside) - straight.share(inside)).abs() < 5e-4, "{inside}");
        }
        assert_eq!((straight.share(6e-3), straight.share(-6e-3)), (1.0, 0.0));
    }
}
