//! Smoothing and resampling: a way from hexagon to hexagon becomes a smooth curve with evenly spaced points.
//!
//! The nodes' coordinates are averaged with a Gaussian over the node number (paper, equation 4), whose weights are divided by their
//! sum: without that the whole path shrinks towards the origin by 0.9 %. Then points are laid at equal arc lengths.

/// A place, in the unit of the caller.
pub type Place = [f64; 2];

/// What stands beyond the ends of a path while it is smoothed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Ends {
    /// The path reflected in its end node, `x(-t) = 2 x(0) - x(t)`: end nodes stay where they are.
    Reflected,
    /// Nothing: the window is cut off and divided by what is left of it. Draws the ends of a straight path in by half a node.
    CutOff,
}

/// The weights of a Gaussian window of `2 half + 1` nodes, in order; their sum is one. `sigma` counts nodes.
pub fn weights(sigma: f64, half: usize) -> Vec<f64> {
    if half == 0 || !(sigma > 0.0) {
        return vec![1.0];
    }
    let raw = |t: f64| libm::exp(-t * t / (2.0 * sigma * sigma));
    let weights: Vec<f64> = (0..=2 * half).map(|i| raw(i as f64 - half as f64)).collect();
    let sum: f64 = weights.iter().sum();
    weights.into_iter().map(|weight| weight / sum).collect()
}

/// Half of the window: the whole numbers below three sigmas. Beyond, a Gaussian has 0.3 % of its weight.
pub fn half_window(sigma: f64) -> usize {
    (3.0 * sigma).ceil().max(1.0) as usize - 1
}

/// Averages the nodes with `weights`, an odd number of them. A path shorter than the window is
/// reflected in both ends in turn.
pub fn smooth(nodes: &[Place], weights: &[f64], ends: Ends) -> Vec<Place> {
    let half = (weights.len() / 2) as isize;
    let last = nodes.len() as isize - 1;
    if last < 1 {
        return nodes.to_vec();
    }
    let node = |i: isize| match ends {
        Ends::CutOff => (0..=last).contains(&i).then(|| nodes[i as usize]),
        Ends::Reflected => Some(reflected(nodes, i)),
    };
    let average = |i: isize| {
        let (mut sum, mut weight_sum) = ([0.0; 2], 0.0);
        for (k, weight) in weights.iter().enumerate() {
            if let Some([x, y]) = node(i + k as isize - half) {
                sum[0] += weight * x;
                sum[1] += weight * y;
                weight_sum += weight;
            }
        }
        [sum[0] / weight_sum, sum[1] / weight_sum]
    };
    (0..=last).map(average).collect()
}

/// Node `i` of a path of two nodes or more that is continued beyond its ends by its own reflection in them.
fn reflected(nodes: &[Place], mut i: isize) -> Place {
    let last = nodes.len() as isize - 1;
    let (mut offset, mut sign) = ([0.0; 2], 1.0);
    while !(0..=last).contains(&i) {
        let (end, image) = if i < 0 { (nodes[0], -i) } else { (nodes[last as usize], 2 * last - i) };
        offset = [offset[0] + 2.0 * sign * end[0], offset[1] + 2.0 * sign * end[1]];
        (i, sign) = (image, -sign);
    }
    let [x, y] = nodes[i as usize];
    [offset[0] + sign * x, offset[1] + sign * y]
}

/// Length of a path along its nodes.
pub fn length(nodes: &[Place]) -> f64 {
    nodes.windows(2).map(|pair| libm::hypot(pair[1][0] - pair[0][0], pair[1][1] - pair[0][1])).sum()
}

/// Points at equal distances along the nodes, first and last node among them: the whole number of steps that comes nearest to
/// `step`, at least one. Nodes in one place count once.
pub fn resample(nodes: &[Place], step: f64) -> Vec<Place> {
    let whole = length(nodes);
    let (Some(first), Some(last)) = (nodes.first(), nodes.last()) else { return Vec::new() };
    if !(whole > 0.0) {
        return vec![*first];
    }
    let count = (whole / step).round().max(1.0) as usize;
    let mut points = Vec::with_capacity(count + 1);
    points.push(*first);
    let (mut segment, mut before) = (0, 0.0);
    let along = |segment: usize| length(&nodes[segment..segment + 2]);
    let mut here = along(0);
    for i in 1..count {
        let at = whole * i as f64 / count as f64;
        while before + here < at && segment + 2 < nodes.len() {
            before += here;
            segment += 1;
            here = along(segment);
        }
        let part = if here > 0.0 { ((at - before) / here).clamp(0.0, 1.0) } else { 0.0 };
        let (a, b) = (nodes[segment], nodes[segment + 1]);
        points.push([a[0] + part * (b[0] - a[0]), a[1] + part * (b[1] - a[1])]);
    }
    points.push(*last);
    points
}

/// By how much a path turns at each of its nodes, radians: 0 straight on (and at its ends), pi back.
pub fn turns(nodes: &[Place]) -> Vec<f64> {
    let mut turns = vec![0.0; nodes.len()];
    for (turn, three) in turns.iter_mut().skip(1).zip(nodes.windows(3)) {
        let (u, v) = (between(three[0], three[1]), between(three[1], three[2]));
        let (cross, dot) = (u[0] * v[1] - u[1] * v[0], u[0] * v[0] + u[1] * v[1]);
        *turn = libm::atan2(cross.abs(), dot);
    }
    turns
}

fn between(a: Place, b: Place) -> Place {
    [b[0] - a[0], b[1] - a[1]]
}
