//! Polygons: the geometry of straight-sided outlines.
//!
//! In: vertices, counter-clockwise or clockwise, metres. Out: distance, area, chords; the sides run from each vertex to the
//! next and from the last to the first. The outline must be simple (see [`crossing`]).

/// Distance from `p` to the nearest point of the outline, positive inside, negative outside; and that point.
pub fn distance(vertices: &[[f64; 2]], p: [f64; 2]) -> (f64, [f64; 2]) {
    let mut nearest = (f64::INFINITY, p);
    let mut inside = false;
    for (a, b) in sides(vertices) {
        let foot = foot(a, b, p);
        let square = (p[0] - foot[0]) * (p[0] - foot[0]) + (p[1] - foot[1]) * (p[1] - foot[1]);
        if square < nearest.0 {
            nearest = (square, foot);
        }
        // A ray along +x crosses the side; the half-open comparison counts a vertex once.
        if (a[1] > p[1]) != (b[1] > p[1]) && p[0] < a[0] + (p[1] - a[1]) / (b[1] - a[1]) * (b[0] - a[0]) {
            inside = !inside;
        }
    }
    let length = nearest.0.sqrt();
    (if inside { length } else { -length }, nearest.1)
}

/// All sides.
pub fn sides(vertices: &[[f64; 2]]) -> impl Iterator<Item = ([f64; 2], [f64; 2])> + '_ {
    (0..vertices.len()).map(|i| (vertices[i], vertices[(i + 1) % vertices.len()]))
}

/// The point of the side that is nearest to `p`.
fn foot(a: [f64; 2], b: [f64; 2], p: [f64; 2]) -> [f64; 2] {
    let (dx, dy) = (b[0] - a[0], b[1] - a[1]);
    let square = dx * dx + dy * dy;
    let along = ((p[0] - a[0]) * dx + (p[1] - a[1]) * dy) / square;
    let t = if square > 0.0 { along.clamp(0.0, 1.0) } else { 0.0 };
    [a[0] + t * dx, a[1] + t * dy]
}

/// Area, positive for counter-clockwise vertices.
pub fn signed_area(vertices: &[[f64; 2]]) -> f64 {
    // About the first vertex, so that an outline far from the origin loses no digits.
    let [x, y] = vertices.first().copied().unwrap_or_default();
    sides(vertices).map(|(a, b)| ((a[0] - x) * (b[1] - y) - (b[0] - x) * (a[1] - y)) / 2.0).sum()
}

/// Intervals `[from, to]` of `t` in which the line `through + t direction` runs inside, in order. A line along a side
/// counts as inside where it touches the inside on either hand.
pub fn chords(vertices: &[[f64; 2]], through: [f64; 2], direction: [f64; 2]) -> Vec<[f64; 2]> {
    let across = |p: [f64; 2]| (p[0] - through[0]) * direction[1] - (p[1] - through[1]) * direction[0];
    let along = |p: [f64; 2]| (p[0] - through[0]) * direction[0] + (p[1] - through[1]) * direction[1];
    let mut cuts: Vec<f64> = Vec::new();
    for (a, b) in sides(vertices) {
        let (sa, sb) = (across(a), across(b));
        // Half-open as in `distance`: every simple outline is cut an even number of times.
        if (sa > 0.0) != (sb > 0.0) {
            let t = sa / (sa - sb);
            let (ta, tb) = (along(a), along(b));
            cuts.push(ta + t * (tb - ta));
        }
    }
    cuts.sort_by(f64::total_cmp);
    cuts.chunks_exact(2).map(|pair| [pair[0], pair[1]]).filter(|[from, to]| to > from).collect()
}

/// Two sides that cross or touch although they are no neighbours, by their first vertices (from 0); or neighbours that
/// fold back on one another.
pub fn crossing(vertices: &[[f64; 2]]) -> Option<[usize; 2]> {
    let n = vertices.len();
    let side = |i: usize| (vertices[i], vertices[(i + 1) % n]);
    for i in 0..n {
        for j in i + 1..n {
            let ((a, b), (c, d)) = (side(i), side(j));
            let neighbours = j == i + 1 || (i == 0 && j == n - 1);
            if neighbours {
                // They share a vertex; they must not run back over one another.
                let (shared, one, other) = if j == i + 1 { (b, a, d) } else { (a, b, c) };
                let (u, v) = ([one[0] - shared[0], one[1] - shared[1]], [other[0] - shared[0], other[1] - shared[1]]);
                if u[0] * v[1] - u[1] * v[0] == 0.0 && u[0] * v[0] + u[1] * v[1] > 0.0 {
                    return Some([i, j]);
                }
            } else if touch(a, b, c, d) {
                return Some([i, j]);
            }
        }
    }
    None
}

/// Whether two sides have a point in common.
fn touch(a: [f64; 2], b: [f64; 2], c: [f64; 2], d: [f64; 2]) -> bool {
    let turn = |a: [f64; 2], b: [f64; 2], p: [f64; 2]| (b[0] - a[0]) * (p[1] - a[1]) - (b[1] - a[1]) * (p[0] - a[0]);
    let between =
        |a: [f64; 2], b: [f64; 2], p: [f64; 2]| (0..2).all(|i| p[i] >= a[i].min(b[i]) && p[i] <= a[i].max(b[i]));
    let (ta, tb, tc, td) = (turn(c, d, a), turn(c, d, b), turn(a, b, c), turn(a, b, d));
    if (ta > 0.0) != (tb > 0.0) && (tc > 0.0) != (td > 0.0) && ta != 0.0 && tb != 0.0 && tc != 0.0 && td != 0.0 {
        return true;
    }
    (ta == 0.0 && between(c, d, a))
        || (tb == 0.0 && between(c, d, b))
        || (tc == 0.0 && between(a, b, c))
        || (td == 0.0 && between(a, b, d))
}

/// The outline moved outwards by `by` at every side.
pub fn grown(vertices: &[[f64; 2]], by: f64) -> Vec<[f64; 2]> {
    let n = vertices.len();
    let sign = if signed_area(vertices) >= 0.0 { 1.0 } else { -1.0 };
    let outward = |i: usize| {
        let (a, b) = (vertices[i % n], vertices[(i + 1) % n]);
        let (dx, dy) = (b[0] - a[0], b[1] - a[1]);
        let length = libm::hypot(dx, dy);
        [sign * dy / length, -sign * dx / length]
    };
    (0..n)
        .map(|i| {
            let (m, k) = (outward(i + n - 1), outward(i));
            // Both sides move out by `by`: the vertex goes along the sum of their normals.
            let scale = by / (1.0 + m[0] * k[0] + m[1] * k[1]).max(1e-3);
            [vertices[i][0] + scale * (m[0] + k[0]), vertices[i][1] + scale * (m[1] + k[1])]
        })
        .collect()
}
