//! The influence function: removal rate over the tool frame while the tool stands still.
//!
//! In: peak and width of a Gaussian, a measured spot, or the closed form of a tool. Out: the rate at any place, its volume,
//! its reach, and a sampled stamp in the part frame for convolution. Positive takes glass away.

use super::bonnet::Contact;
use crate::diagnostics::{Problem, codes};
use crate::height_map::{Grid, MOST_PIXELS};
use std::f64::consts::{PI, TAU};

/// A place of the part relative to the tool centre point, turned into the tool frame. `azimuth` is the direction of the
/// tool's x axis on the part, radians from +x towards +y. See the module [`tool`](crate::tool) for the sense of y.
pub fn part_to_tool(dx: f64, dy: f64, azimuth: f64) -> [f64; 2] {
    let (sin, cos) = libm::sincos(azimuth);
    [cos * dx + sin * dy, sin * dx - cos * dy]
}

/// Removal rate of a standing tool.
#[derive(Clone, Debug, PartialEq)]
pub struct InfluenceFunction {
    shape: Shape,
    /// Nothing is removed farther than this from the tool centre point, metres.
    radius: f64,
    volume_rate: f64,
    sigma_scale: f64,
}

#[derive(Clone, Debug, PartialEq)]
enum Shape {
    Gaussian {
        peak: f64,
        sigma: f64,
    },
    /// Rate in m/s over the tool frame; zero outside the picture.
    Measured(Grid),
    /// The same all around.
    Radial(Radial),
    /// Of a bonnet.
    Contact(Contact),
    /// A profile times the cosine or sine of so many times the angle from +x towards +y.
    Harmonic {
        radial: Radial,
        order: usize,
        sine: bool,
    },
}

/// A profile over the distance from the middle, tabulated. Between two breaks the places are low + (high - low) sin²(πt/2)
/// with even steps of t: they crowd at the breaks, where a profile may have kinks and square roots.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Radial {
    /// In rising order.
    breaks: Vec<f64>,
    /// `STEPS` + 1 values for each piece between two breaks.
    values: Vec<f64>,
}

/// Steps of a radial table between two breaks: linear interpolation of a cosine over them is wrong by 1e-6.
const STEPS: usize = 1024;

impl Radial {
    pub fn new(breaks: &[f64], value: impl Fn(f64) -> f64) -> Radial {
        let mut values = Vec::new();
        for pair in breaks.windows(2) {
            for k in 0..=STEPS {
                let sine = libm::sin(0.5 * PI * k as f64 / STEPS as f64);
                values.push(value(pair[0] + (pair[1] - pair[0]) * sine * sine));
            }
        }
        Radial { breaks: breaks.to_vec(), values }
    }

    fn reach(&self) -> f64 {
        self.breaks.last().copied().unwrap_or(0.0)
    }

    /// Zero inside the first break and beyond the last.
    pub fn at(&self, s: f64) -> f64 {
        let piece = self.breaks.partition_point(|b| *b <= s);
        if piece == 0 || piece == self.breaks.len() {
            return 0.0;
        }
        let (low, high) = (self.breaks[piece - 1], self.breaks[piece]);
        let t = libm::asin((((s - low) / (high - low)).clamp(0.0, 1.0)).sqrt()) * 2.0 / PI * STEPS as f64;
        let k = (t as usize).min(STEPS - 1);
        let values = &self.values[(piece - 1) * (STEPS + 1) + k..];
        values[0] + (t - k as f64) * (values[1] - values[0])
    }

    /// The distance beyond which the profile stays below half of its greatest value.
    fn half_width(&self) -> f64 {
        let greatest = self.values.iter().fold(0.0f64, |most, v| most.max(*v));
        let steps = 4096;
        let place = |k: usize| self.reach() * k as f64 / steps as f64;
        (0..=steps).rev().map(place).find(|s| self.at(*s) >= 0.5 * greatest).unwrap_or(0.0)
    }
}

/// Half width at half height of a Gaussian with sigma 1.
const HALF_WIDTH_OF_GAUSSIAN: f64 = 1.177_410_022_515_474_7;

impl InfluenceFunction {
    /// `peak * exp(-r²/2σ²)` for `r <= diameter/2`, zero outside; m/s, m, m. E0620 if one of them is not positive; its field is
    /// the name.
    pub fn gaussian(peak: f64, sigma: f64, diameter: f64) -> Result<InfluenceFunction, Problem> {
        for (name, value, unit, scale) in
            [("peak", peak, "nm/s", 1e9), ("sigma", sigma, "mm", 1e3), ("diameter", diameter, "mm", 1e3)]
        {
            if !(value > 0.0 && value.is_finite()) {
                let message = format!("`{name}` is {:.3} {unit}; it must be positive", value * scale);
                return Err(Problem::error(codes::E0620, name, message));
            }
        }
        // Over the disc of radius D/2, with u = r²/2σ² running to U = D²/8σ²: the volume is 2πσ² peak (1 - exp(-U)),
        // the mean of r² is 2σ² (1 - U exp(-U) / (1 - exp(-U))), and each axis has half of that.
        let u = diameter * diameter / (8.0 * sigma * sigma);
        let (inside, rim) = (-libm::expm1(-u), libm::exp(-u));
        Ok(InfluenceFunction {
            shape: Shape::Gaussian { peak, sigma },
            radius: diameter / 2.0,
            volume_rate: TAU * sigma * sigma * peak * inside,
            sigma_scale: sigma * (1.0 - u * rim / inside).sqrt(),
        })
    }

    /// From a map of rates (m/s, tool frame) that ends at `radius`, with its volume rate and width.
    pub(super) fn of_map(rates: Grid, radius: f64, volume_rate: f64, sigma_scale: f64) -> InfluenceFunction {
        InfluenceFunction { shape: Shape::Measured(rates), radius, volume_rate, sigma_scale }
    }

    /// The same all around, with its volume rate. `sigma` is the root of its second moment along one axis; the width that
    /// grids must resolve is that of a Gaussian as narrow as its half height, where this is less (a sharp middle on a wide
    /// foot).
    pub(super) fn of_radial(radial: Radial, volume_rate: f64, sigma: f64) -> InfluenceFunction {
        let sigma_scale = sigma.min(radial.half_width() / HALF_WIDTH_OF_GAUSSIAN);
        InfluenceFunction { radius: radial.reach(), shape: Shape::Radial(radial), volume_rate, sigma_scale }
    }

    /// Of a bonnet's contact, with its radius, volume rate and width.
    pub(super) fn of_contact(contact: Contact, radius: f64, volume_rate: f64, sigma_scale: f64) -> InfluenceFunction {
        InfluenceFunction { shape: Shape::Contact(contact), radius, volume_rate, sigma_scale }
    }

    /// Times the cosine or sine of so many times the angle: a part of a field, negative in places, of `width`.
    pub(super) fn of_harmonic(
        radial: Radial,
        order: usize,
        sine: bool,
        volume_rate: f64,
        width: f64,
    ) -> InfluenceFunction {
        let radius = radial.reach();
        InfluenceFunction { shape: Shape::Harmonic { radial, order, sine }, radius, volume_rate, sigma_scale: width }
    }

    /// The mean over so many evenly spread turns about the tool's axis, on square pixels as fine as the finer side of the map's;
    /// a function that is no map, or a single turn, is itself.
    ///
    /// # Errors
    /// E0547 if these are more pixels than a map may have, which takes pixels many times longer than wide.
    pub(super) fn stepped(self, positions: usize) -> Result<InfluenceFunction, Problem> {
        let Shape::Measured(grid) = &self.shape else { return Ok(self) };
        if positions < 2 {
            return Ok(self);
        }
        let turns: Vec<(f64, f64)> = (0..positions).map(|k| libm::sincos(TAU * k as f64 / positions as f64)).collect();
        let [fine, coarse] = [grid.pixel[0].min(grid.pixel[1]), grid.pixel[0].max(grid.pixel[1])];
        let side = 2.0 * (self.radius / fine).ceil() + 1.0;
        if side * side > MOST_PIXELS as f64 {
            let message = format!(
                "turned about the tool's axis, the spot needs {side:.0} x {side:.0} pixels as fine as the finer side of its map's, \
                 {:.4} mm x {:.4} mm; at most {MOST_PIXELS} pixels are worked with",
                fine * 1e3,
                coarse * 1e3
            );
            return Err(Problem::error(codes::E0547, "spots", message)
                .help("measure the spot with pixels that are nearly square, or bin the map along their short side"));
        }
        let mut mean = self.stamp(fine, 0.0);
        for i in 0..mean.values.len() {
            let [x, y] = mean.position(i / mean.columns, i % mean.columns);
            let sum: f64 = turns.iter().map(|(s, c)| self.rate(c * x + s * y, c * y - s * x)).sum();
            mean.values[i] = sum / positions as f64;
        }
        Ok(InfluenceFunction { shape: Shape::Measured(mean), ..self })
    }

    /// Removal rate at `(x, y)` of the tool frame, m/s.
    pub fn rate(&self, x: f64, y: f64) -> f64 {
        if x * x + y * y > self.radius * self.radius {
            return 0.0;
        }
        match &self.shape {
            Shape::Gaussian { peak, sigma } => peak * libm::exp(-(x * x + y * y) / (2.0 * sigma * sigma)),
            Shape::Measured(grid) => grid.interpolate(x, y).unwrap_or(0.0),
            Shape::Radial(radial) => radial.at(libm::hypot(x, y)),
            Shape::Contact(contact) => contact.rate(x, y),
            Shape::Harmonic { radial, order, sine } => {
                let angle = *order as f64 * libm::atan2(y, x);
                radial.at(libm::hypot(x, y)) * if *sine { libm::sin(angle) } else { libm::cos(angle) }
            }
        }
    }

    /// Nothing is removed farther than this from the tool centre point, metres.
    pub fn radius(&self) -> f64 {
        self.radius
    }

    /// Volume removed in a second, m³/s: the integral of [`rate`](Self::rate).
    pub fn volume_rate(&self) -> f64 {
        self.volume_rate
    }

    /// Root of the smaller principal second moment about the spot's centroid, metres: for a Gaussian its sigma (a
    /// little less where the cut takes the tails). Grids that resolve it resolve the spot in every direction.
    pub fn sigma_scale(&self) -> f64 {
        self.sigma_scale
    }

    /// The rate sampled on square pixels of side `pixel` in the part frame, centred on the tool centre point, for a tool
    /// whose x axis points along `azimuth`. Odd numbers of rows and columns, the middle pixel at (0, 0), wide enough to
    /// hold the whole reach. Point values, m/s: times `pixel²` they sum to the volume rate as far as `pixel` resolves
    /// the spot.
    pub fn stamp(&self, pixel: f64, azimuth: f64) -> Grid {
        let half = (self.radius / pixel).ceil() as usize;
        let side = 2 * half + 1;
        let origin = -(half as f64) * pixel;
        let mut grid = Grid { columns: side, rows: side, pixel: [pixel; 2], origin: [origin; 2], values: Vec::new() };
        grid.values = (0..side * side)
            .map(|i| {
                let [dx, dy] = grid.position(i / side, i % side);
                let [x, y] = part_to_tool(dx, dy, azimuth);
                self.rate(x, y)
            })
            .collect();
        grid
    }
}

/// The width of what removes is the sigma that the job states only if little of the Gaussian is cut away: where it is less than nine
/// tenths of it, the spot takes less than four fifths of the glass that its sigma promises.
const LEAST_WIDTH: f64 = 0.9;

/// W0600 if the diameter cuts so much of a Gaussian that its sigma is not its width. `at` is the field of the influence function.
pub(super) fn check_cut(sigma: f64, diameter: f64, function: &InfluenceFunction, at: &str) -> Option<Problem> {
    if function.sigma_scale() >= LEAST_WIDTH * sigma {
        return None;
    }
    let message = format!(
        "the diameter cuts the Gaussian {:.2} sigma from its middle: what is left is as wide as one of {:.3} mm sigma, not {:.3} mm",
        diameter / (2.0 * sigma),
        function.sigma_scale() * 1e3,
        sigma * 1e3
    );
    // 2.4 sigma to either side keeps 90 % of the width.
    Some(
        Problem::warning(codes::W0600, format!("{at}.diameter"), message)
            .note("was a radius written for a diameter, or a half width for a sigma?")
            .help(format!(
                "a Gaussian of this sigma needs a diameter of at least {:.2} mm",
                (4.8 * sigma * 1e5).ceil() / 100.0
            )),
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_turned_spot_takes_no_more_pixels_than_a_map() {
        // A spot of 5 mm radius on three rows of pixels 5 mm long, so wide; all around it as fine as they are wide.
        let turned = |wide: f64| {
            let grid = Grid { columns: 3, rows: 3, pixel: [wide, 5e-3], origin: [-wide, -5e-3], values: vec![1e-9; 9] };
            InfluenceFunction::of_map(grid, 5e-3, 1e-14, 1e-3).stepped(3)
        };
        // 2 x 500 pixels and the middle one, each way.
        let Ok(InfluenceFunction { shape: Shape::Measured(mean), .. }) = turned(10e-6) else { panic!("a map") };
        assert_eq!((mean.columns, mean.rows), (1001, 1001));
        // 10,001 each way are a hundred million.
        let problem = turned(1e-6).expect_err("too many");
        assert_eq!((problem.code, problem.field.as_deref()), (codes::E0547, Some("spots")));
        assert!(problem.message.contains("10001 x 10001"), "{}", problem.message);
    }
}
