//! Curvature: the second fundamental form of a surface.
//!
//! In: a [`SurfacePoint`]. Out: its [`Curvature`], seen from the tool: positive where the surface is hollow (concave),
//! the centre of curvature then lying on the tool's side.
//!
//! With p, q the slopes, r, s, t the second derivatives and W² = 1 + p² + q², the first form is E = 1 + p², F = pq,
//! G = 1 + q², the second L = r/W, M = s/W, N = t/W (do Carmo, Differential Geometry of Curves and Surfaces, section
//! 3-3, for the graph of a function).

use super::SurfacePoint;

/// First and second fundamental form at one place.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Curvature {
    first: [f64; 3],
    second: [f64; 3],
}

/// A principal curvature with its direction.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PrincipalCurvature {
    /// One over metres, positive where hollow.
    pub curvature: f64,
    /// Unit vector of the part frame, in the tangent plane.
    pub direction: [f64; 3],
}

impl SurfacePoint {
    /// The curvature here.
    pub fn curvature(&self) -> Curvature {
        let [p, q] = self.slope;
        let w = (1.0 + p * p + q * q).sqrt();
        Curvature { first: [1.0 + p * p, p * q, 1.0 + q * q], second: self.second.map(|d| d / w) }
    }

    /// The largest magnitude of a normal curvature, one over metres.
    pub fn sharpest(&self) -> f64 {
        let [low, high] = self.curvature().principal_values();
        low.abs().max(high.abs())
    }

    /// Least and greatest curvature with their directions, which are perpendicular. At an umbilic, where all directions
    /// are alike, the directions are those nearest to x and y.
    pub fn principal(&self) -> [PrincipalCurvature; 2] {
        let curvature = self.curvature();
        let [low, high] = curvature.principal_values();
        let ([e, f, g], [l, m, n]) = (curvature.first, curvature.second);
        // (L - k E, M - k F; M - k F, N - k G) (dx, dy) = 0: the longer row gives the direction.
        let direction = |k: f64| {
            let (a, b, c) = (l - k * e, m - k * f, n - k * g);
            if libm::hypot(a, b) >= libm::hypot(b, c) { [-b, a] } else { [c, -b] }
        };
        // Apart by less than rounding: every direction is as good.
        let umbilic = high - low <= 1e-12 * (high.abs() + low.abs());
        let along = if umbilic { [1.0, 0.0] } else { direction(low) };
        let along = self.lifted(along);
        let n = self.normal();
        let across =
            [n[1] * along[2] - n[2] * along[1], n[2] * along[0] - n[0] * along[2], n[0] * along[1] - n[1] * along[0]];
        [
            PrincipalCurvature { curvature: low, direction: along },
            PrincipalCurvature { curvature: high, direction: across },
        ]
    }

    /// The unit tangent over the direction `[dx, dy]` of the xy plane.
    fn lifted(&self, [dx, dy]: [f64; 2]) -> [f64; 3] {
        let dz = self.slope[0] * dx + self.slope[1] * dy;
        let length = (dx * dx + dy * dy + dz * dz).sqrt();
        if length > 0.0 { [dx / length, dy / length, dz / length] } else { [1.0, 0.0, 0.0] }
    }
}

impl Curvature {
    /// Half the sum of the principal curvatures, one over metres.
    pub fn mean(&self) -> f64 {
        let ([e, f, g], [l, m, n]) = (self.first, self.second);
        (e * n - 2.0 * f * m + g * l) / (2.0 * (e * g - f * f))
    }

    /// Their product, one over square metres.
    pub fn gaussian(&self) -> f64 {
        let ([e, f, g], [l, m, n]) = (self.first, self.second);
        (l * n - m * m) / (e * g - f * f)
    }

    /// Least and greatest normal curvature, one over metres.
    pub fn principal_values(&self) -> [f64; 2] {
        let mean = self.mean();
        // Zero for an umbilic, where rounding may leave it negative.
        let half = (mean * mean - self.gaussian()).max(0.0).sqrt();
        [mean - half, mean + half]
    }

    /// Normal curvature along the direction over `[dx, dy]` of the xy plane, one over metres.
    pub fn along(&self, [dx, dy]: [f64; 2]) -> f64 {
        let form = |[a, b, c]: [f64; 3]| a * dx * dx + 2.0 * b * dx * dy + c * dy * dy;
        form(self.second) / form(self.first)
    }
}

#[cfg(test)]
mod tests {
    use super::super::examples::of;
    use crate::job::{Conic, Form, Side, Sphere};
    use crate::units::si::Length;

    fn near(found: f64, expected: f64) {
        assert!((found - expected).abs() < 1e-9 * expected.abs().max(1.0), "{found}, expected {expected}");
    }

    #[test]
    fn a_sphere_is_equally_hollow_everywhere() {
        for (side, sign) in [(Side::concave, 1.0), (Side::convex, -1.0)] {
            let sphere = of(Form::sphere(Sphere { side, radius: Length(0.25) }));
            for (x, y) in [(0.0, 0.0), (0.1, 0.0), (-0.1, 0.15)] {
                let point = sphere.at(x, y).expect("on the sphere");
                let curvature = point.curvature();
                near(curvature.mean(), sign * 4.0);
                near(curvature.gaussian(), 16.0);
                near(curvature.along([0.3, -0.7]), sign * 4.0);
                near(point.sharpest(), 4.0);
            }
        }
    }

    /// Paraboloid z = r²/2R: along the meridian 1 / (R (1 + m²)^(3/2)), across it 1 / (R (1 + m²)^(1/2)), m = r/R the
    /// slope (the meridian's own curvature, and that of the circle of latitude by Meusnier).
    #[test]
    fn a_paraboloid_is_flatter_along_its_meridian() {
        let form = Form::conic(Conic { side: Side::concave, radius: Length(0.5), conic: -1.0 });
        let point = of(form).at(0.3, 0.4).expect("everywhere");
        // r = 0.5, slope 1.
        let [low, high] = point.principal();
        near(low.curvature, 2.0 / 8.0_f64.sqrt());
        near(high.curvature, 2.0 / 2.0_f64.sqrt());
        // The meridian climbs at 45 degrees along (0.6, 0.8).
        let root = 0.5_f64.sqrt();
        let meridian = [0.6 * root, 0.8 * root, root];
        let dot = |a: [f64; 3], b: [f64; 3]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
        near(dot(low.direction, meridian).abs(), 1.0);
        near(dot(low.direction, high.direction), 0.0);
        near(dot(high.direction, point.normal()), 0.0);
        near(point.curvature().along([0.6, 0.8]), low.curvature);
        near(point.curvature().along([-0.8, 0.6]), high.curvature);
    }
}
