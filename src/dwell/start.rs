//! Where the solver starts, and whether the path reaches everything that it should.

use super::field::Field;
use super::least_squares::{Base, LinearOperator};
use super::removal::Removal;
use super::speed::Segments;
use crate::diagnostics::{Problem, codes};

/// Times to start from: as long on each segment as the wanted depth around it asks for, against what a unit of
/// slowness removes there. Beside them, the segments that do at least half of their work inside the clear aperture.
pub(super) fn start(
    operator: &mut Removal,
    field: &Field,
    segments: &Segments,
    depths: &[f64],
    base: Base,
) -> Result<(Vec<f64>, Vec<usize>), Problem> {
    let inside = |i: usize| field.weights[i] > 0.0;
    let mut unit = vec![0.0; depths.len()];
    operator.forward(&segments.length, &mut unit);
    let count = (0..unit.len()).filter(|&i| inside(i)).count();
    let mean = (0..unit.len()).filter(|&i| inside(i)).map(|i| unit[i]).sum::<f64>() / count as f64;
    // A pixel that the path reaches with less than a hundredth of the usual strength would need a feed a hundred times
    // slower than its neighbours': the path does not cover it.
    if let Some(i) = (0..unit.len()).find(|&i| inside(i) && unit[i] <= 0.01 * mean) {
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
    let start = (0..segments.length.len())
        .map(|i| {
            // Where a segment does less than a millionth of its work inside the aperture the quotient is rounding noise;
            // its time cannot matter, and it gets the shortest.
            if work[i] > 1e-6 * whole { segments.length[i] * local_wanted[i] / local_have[i] } else { 0.0 }
        })
        .collect();
    Ok((start, (0..work.len()).filter(|&i| work[i] >= 0.5 * whole).collect()))
}
