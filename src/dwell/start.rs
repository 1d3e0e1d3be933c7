//! Where the solver starts, and whether the path reaches everything that it should.

use super::descent::LinearOperator;
use super::field::Field;
use super::objective::Base;
use super::removal::Removal;
use super::speed::Segments;
use crate::diagnostics::{Problem, codes};

/// Where the solver starts.
pub(super) struct Start {
    /// As long on each segment as the wanted depth around it asks for, against what a unit of slowness removes there.
    pub times: Vec<f64>,
    /// The segments that do at least half of their work inside the clear aperture.
    pub inside: Vec<usize>,
    /// How stiff each time is beside the others: the part of its work that it does inside.
    pub stiffness: Vec<f64>,
}

/// A time that does less than this part of the usual work inside the aperture is taken as that stiff: what it does hardly
/// matters, and a step along it must not become endless. On the published problem 1e-2 to 1e-4 do alike, and ten times as
/// well as none.
const LEAST_STIFFNESS: f64 = 1e-3;

/// A path that is to polish `everywhere` must reach every pixel; one over a region leaves others as they are.
pub(super) fn start(
    operator: &mut Removal,
    field: &Field,
    segments: &Segments,
    depths: &[f64],
    base: Base,
    everywhere: bool,
) -> Result<Start, Problem> {
    let inside = |i: usize| field.weights[i] > 0.0;
    let mut unit = vec![0.0; depths.len()];
    operator.forward(&segments.length, &mut unit);
    let count = (0..unit.len()).filter(|&i| inside(i)).count();
    let mean = (0..unit.len()).filter(|&i| inside(i)).map(|i| unit[i]).sum::<f64>() / count as f64;
    // A pixel that the path reaches with less than a hundredth of the usual strength would need a feed a hundred times
    // slower than its neighbours': the path does not cover it.
    let missed = (0..unit.len()).find(|&i| inside(i) && unit[i] <= 0.01 * mean);
    if let (true, Some(i)) = (everywhere, missed) {
        let [x, y] = field.window.position(i);
        let message = format!("the path does not reach x {:.3} mm, y {:.3} mm in the clear aperture", x * 1e3, y * 1e3);
        return Err(Problem::error(codes::E0704, "path.over", message)
            .help("let `over` reach beyond the clear aperture, and lay the lines closer than the spot is wide"));
    }
    let lowest = (0..depths.len()).filter(|&i| inside(i)).fold(f64::INFINITY, |low, i| low.min(depths[i]));
    let base = match base {
        Base::Fixed(base) => base,
        Base::AtMost(most) => most.min(-lowest),
    };
    let weigh = |values: &dyn Fn(usize) -> f64| (0..depths.len()).map(|i| field.weights[i] * values(i)).collect();
    let (wanted, have): (Vec<f64>, Vec<f64>) = (weigh(&|i| (depths[i] + base).max(0.0)), weigh(&|i| unit[i]));
    let (mut local_wanted, mut local_have) = (vec![0.0; segments.length.len()], vec![0.0; segments.length.len()]);
    operator.transpose(&wanted, &mut local_wanted);
    operator.transpose(&have, &mut local_have);
    let mut work = vec![0.0; segments.length.len()];
    operator.transpose(&field.weights, &mut work);
    let whole = work.iter().fold(0.0f64, |most, w| most.max(*w));
    let times = (0..segments.length.len())
        .map(|i| {
            // Where a segment does less than a millionth of its work inside the aperture the quotient is rounding noise;
            // its time cannot matter, and it gets the shortest.
            if work[i] > 1e-6 * whole { segments.length[i] * local_wanted[i] / local_have[i] } else { 0.0 }
        })
        .collect();
    let stiffness = work.iter().map(|work| (work / whole).max(LEAST_STIFFNESS)).collect();
    Ok(Start { times, inside: (0..work.len()).filter(|&i| work[i] >= 0.5 * whole).collect(), stiffness })
}
