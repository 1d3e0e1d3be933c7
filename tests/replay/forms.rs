//! Nominal surfaces for the tests of the whole chain: what a job says of a form, and where its surface lies.
//!
//! The formulas are not the crate's: closed forms where a textbook has one, normals from the gradient of an implicit
//! equation or by differences of the height, all in millimetres. The part's z points out of the glass.

use super::npy;
use super::rigid::{dot, normalised};

/// A form as a job says it, and its surface.
pub struct FormCase {
    pub name: &'static str,
    /// After `form:`.
    pub text: &'static str,
    /// Height over a place, mm.
    height: fn(f64, f64) -> f64,
    /// Gradient of an implicit equation of the surface at a point on it, pointing out of the glass; without it the normal
    /// is taken from differences of the height.
    gradient: Option<fn([f64; 3]) -> [f64; 3]>,
}

impl FormCase {
    /// The point of the surface over (x, y), and its outward normal.
    pub fn at(&self, x: f64, y: f64) -> ([f64; 3], [f64; 3]) {
        let point = [x, y, (self.height)(x, y)];
        let outward = match self.gradient {
            Some(gradient) => gradient(point),
            // Central differences over 20 um: third derivatives of these forms are below 1e-4 /mm², so that the slope is
            // right to 1e-8, and rounding of a height of 10 mm leaves 1e-13.
            None => {
                let h = 0.01;
                let slope =
                    |dx: f64, dy: f64| ((self.height)(x + dx, y + dy) - (self.height)(x - dx, y - dy)) / (2.0 * h);
                [-slope(h, 0.0), -slope(0.0, h), 1.0]
            }
        };
        (point, normalised(outward))
    }

    /// The tool's x axis there: the direction of the azimuth (degrees) laid into the tangent plane.
    pub fn tool_x(&self, x: f64, y: f64, azimuth: f64) -> [f64; 3] {
        let (_, normal) = self.at(x, y);
        let (sine, cosine) = azimuth.to_radians().sin_cos();
        let reference = [cosine, sine, 0.0];
        let along = dot(reference, normal);
        normalised(std::array::from_fn(|i| reference[i] - along * normal[i]))
    }

    /// Data that the form's text names.
    pub fn files(&self) -> Vec<(String, Vec<u8>)> {
        if self.name != "height grid" {
            return Vec::new();
        }
        // 121 x 111 pixels of 1 mm about the origin, +x up, seen from the back: up is +x, right is +y. In um.
        let mut values = Vec::new();
        for row in 0..111 {
            for column in 0..121 {
                let (x, y) = (55.0 - f64::from(row), f64::from(column) - 60.0);
                values.push(1e3 * cubic(x, y));
            }
        }
        vec![("trial/form.npy".to_string(), npy(121, &values))]
    }
}

/// A polynomial of third degree in x and y, which a cubic spline meets exactly; up to 3 mm.
fn cubic(x: f64, y: f64) -> f64 {
    7e-4 * x * x + 3e-4 * x * y - 5e-4 * y * y + 4e-6 * x * x * x - 3e-6 * x * x * y + 2e-6 * y * y * y - 0.01 * x
}

/// Of a sphere about (0, 0, centre): towards the centre of a hollow one, away from it of the other.
fn height_of_sphere(radius: f64, x: f64, y: f64) -> f64 {
    radius.signum() * (radius.abs() - (radius * radius - x * x - y * y).sqrt())
}

/// In the frame of a paraboloid 2 R Z = X² + Y² with R = 600 mm, the segment 250 mm from its axis; on the part the axis
/// lies against -30 degrees.
fn segment() -> ([f64; 3], [[f64; 3]; 3]) {
    let (radius, away) = (600.0, 250.0);
    let slope: f64 = away / radius;
    let length = slope.hypot(1.0);
    let (meridian, across) = ([1.0 / length, 0.0, slope / length], [0.0, 1.0, 0.0]);
    let z = [-slope / length, 0.0, 1.0 / length];
    let (sine, cosine) = (-30_f64).to_radians().sin_cos();
    let mix = |a: f64, b: f64| std::array::from_fn(|i| a * meridian[i] + b * across[i]);
    ([away, 0.0, away * away / (2.0 * radius)], [mix(cosine, -sine), mix(sine, cosine), z])
}

/// The root of X² + Y² = 1200 Z on the line over (x, y) that is nearer to the origin.
fn height_of_segment(x: f64, y: f64) -> f64 {
    let (origin, [a, b, z]) = segment();
    let foot: [f64; 3] = std::array::from_fn(|i| origin[i] + x * a[i] + y * b[i]);
    let (square, linear, constant) = (
        z[0] * z[0] + z[1] * z[1],
        2.0 * (foot[0] * z[0] + foot[1] * z[1]) - 1200.0 * z[2],
        foot[0] * foot[0] + foot[1] * foot[1] - 1200.0 * foot[2],
    );
    // The smaller root, without cancellation.
    2.0 * constant / (-linear + (linear * linear - 4.0 * square * constant).sqrt())
}

/// The plane, and every form.
pub const FORMS: &[FormCase] = &[
    FormCase { name: "plane", text: "plane", height: |_, _| 0.0, gradient: Some(|_| [0.0, 0.0, 1.0]) },
    FormCase {
        name: "steep hollow sphere",
        text: "sphere { side: concave, radius: 120 mm }",
        height: |x, y| height_of_sphere(120.0, x, y),
        gradient: Some(|[x, y, z]| [-x, -y, 120.0 - z]),
    },
    FormCase {
        name: "steep convex sphere",
        text: "sphere { side: convex, radius: 120 mm }",
        height: |x, y| height_of_sphere(-120.0, x, y),
        gradient: Some(|[x, y, z]| [x, y, z + 120.0]),
    },
    // c r² + c (1 + k) z² - 2 z = 0 with c = 1/200 mm, k = -1.7.
    FormCase {
        name: "hyperboloid",
        text: "conic { side: concave, radius: 200 mm, conic: -1.7 }",
        height: |x, y| (1.0 - (1.0 + 0.7 * (x * x + y * y) / 4e4).sqrt()) / (-0.7 / 200.0),
        gradient: Some(|[x, y, z]| [-x / 200.0, -y / 200.0, 1.0 + 0.7 * z / 200.0]),
    },
    // Coefficients into the glass: taken away from a hollow paraboloid.
    FormCase {
        name: "even asphere",
        text: "even_asphere { side: concave, radius: 300 mm, conic: -1, sag: positive_into_glass, a4: 2e-7 mm^-3, a6: -3e-11 mm^-5 }",
        height: |x, y| {
            let square = x * x + y * y;
            square / 600.0 - 2e-7 * square.powi(2) + 3e-11 * square.powi(3)
        },
        gradient: None,
    },
    FormCase {
        name: "odd asphere",
        text: "odd_asphere { side: convex, radius: 400 mm, conic: -1, sag: positive_towards_tool, a3: 3e-6 mm^-2, a5: -1e-9 mm^-4 }",
        height: |x, y| {
            let r = x.hypot(y);
            -r.powi(2) / 800.0 + 3e-6 * r.powi(3) - 1e-9 * r.powi(5)
        },
        gradient: None,
    },
    FormCase {
        name: "off-axis paraboloid",
        text: "off_axis { parent: conic { side: concave, radius: 600 mm, conic: -1 }, distance: 250 mm, direction: -30 deg }",
        height: height_of_segment,
        // Of X² + Y² - 1200 Z, seen along the part's axes; the paraboloid's inside is the tool's side.
        gradient: Some(|[x, y, w]| {
            let (origin, axes) = segment();
            let [px, py, _]: [f64; 3] =
                std::array::from_fn(|i| origin[i] + x * axes[0][i] + y * axes[1][i] + w * axes[2][i]);
            let outward = [-2.0 * px, -2.0 * py, 1200.0];
            axes.map(|axis| dot(axis, outward))
        }),
    },
    FormCase {
        name: "XY polynomial",
        text: "xy_polynomial { base: sphere { side: convex, radius: 500 mm }, sag: positive_into_glass, normalisation: 50 mm, \
               terms: [{ x_power: 2, y_power: 0, coefficient: 1.5 mm }, { x_power: 1, y_power: 2, coefficient: -0.4 mm }, \
               { x_power: 0, y_power: 1, coefficient: 0.2 mm }] }",
        height: |x, y| {
            height_of_sphere(-500.0, x, y) - 1.5 * (x / 50.0).powi(2) + 0.4 * (x / 50.0) * (y / 50.0).powi(2)
                - 0.2 * (y / 50.0)
        },
        gradient: None,
    },
    // Fringe 5: r² cos 2t; 8: (3 r² - 2) r sin t; 9: 6 r⁴ - 6 r² + 1, with r over 60 mm.
    FormCase {
        name: "Zernike",
        text: "zernike { base: sphere { side: concave, radius: 400 mm }, sag: positive_towards_tool, radius: 60 mm, order: fringe, \
               coefficients: [0 mm, 0 mm, 0 mm, 0 mm, 0.8 mm, 0 mm, 0 mm, -0.3 mm, 0.1 mm] }",
        height: |x, y| {
            let (u, v) = (x / 60.0, y / 60.0);
            let square = u * u + v * v;
            height_of_sphere(400.0, x, y) + 0.8 * (u * u - v * v) - 0.3 * (3.0 * square - 2.0) * v
                + 0.1 * (6.0 * square * square - 6.0 * square + 1.0)
        },
        gradient: None,
    },
    // Heights into the glass, seen from the back with +x up.
    FormCase {
        name: "height grid",
        text: "height_grid { base: sphere { side: convex, radius: 300 mm }, file: \"form.npy\", sag: positive_into_glass, \
               view: from_back, up: plus_x, pixel: 1 mm, unit: 1 um }",
        height: |x, y| height_of_sphere(-300.0, x, y) - cubic(x, y),
        gradient: None,
    },
];
