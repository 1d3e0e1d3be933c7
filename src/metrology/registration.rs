//! Registration: marks of the part say where a picture lies on it.
//!
//! In: where the marks lie on the part, and where the declared orientation puts what the picture shows of them. Out: the
//! similarity (scale, rotation, shift) from the declared frame to the part frame, by least squares, with what it leaves.
//!
//! With places as complex numbers, `a` declared and `b` on the part, both about their means, the best `b = z a` has
//! `z = sum(conj(a) b) / sum(|a|²)`: its magnitude is the scale, its argument the rotation. For a picture that was mirrored
//! without the job's saying so `conj(a)` takes the place of `a`: both are tried, and the mirror image must not fit. (S.
//! Umeyama, "Least-squares estimation of transformation parameters between two point patterns", IEEE Trans. PAMI 13, 1991.)

use super::resample::Similarity;
use crate::diagnostics::{Problem, codes};
use crate::job::{Direction, Fiducial, HeightMap, View};

/// Largest rotation beside the declared one. A part that is laid by eye on a mark lies within a few degrees; from 45 on
/// another `up` would be nearer.
const MOST_ROTATION: f64 = 15.0;

/// Largest departure of the found scale from the stated pixel. The zoom of an interferometer is calibrated to a per cent or
/// two; more is another zoom, another binning, or another part.
const MOST_SCALE: f64 = 0.05;

/// The mirror image fits better by far when it leaves less than this part of what the declared view leaves.
const BY_FAR: f64 = 0.2;

/// How a picture lies on the part, by its marks.
#[derive(Clone, Debug, PartialEq)]
pub struct Registered {
    /// From the frame that `up`, `view`, `centre` and `pixel` declare to the part frame.
    pub similarity: Similarity,
    /// The rotation beside the declared one, radians.
    pub turned: f64,
    /// Distances between marks and fit, metres: root mean square and largest.
    pub residual_rms: f64,
    pub residual_max: f64,
    pub marks: usize,
}

/// A fit, and what it leaves of each mark.
struct Fit {
    similarity: Similarity,
    residuals: Vec<f64>,
}

impl Fit {
    /// From `a` to `b`.
    fn new(a: &[[f64; 2]], b: &[[f64; 2]]) -> Fit {
        let n = a.len() as f64;
        let mean = |p: &[[f64; 2]]| [0, 1].map(|k| p.iter().map(|at| at[k]).sum::<f64>() / n);
        let (ma, mb) = (mean(a), mean(b));
        let (mut re, mut im, mut square) = (0.0, 0.0, 0.0);
        for (a, b) in a.iter().zip(b) {
            let ([ax, ay], [bx, by]) = ([a[0] - ma[0], a[1] - ma[1]], [b[0] - mb[0], b[1] - mb[1]]);
            re += ax * bx + ay * by;
            im += ax * by - ay * bx;
            square += ax * ax + ay * ay;
        }
        let scale = libm::hypot(re, im) / square;
        let turned = Similarity { scale, rotation: libm::atan2(im, re), shift: [0.0; 2] };
        let there = turned.apply(ma);
        let similarity = Similarity { shift: [mb[0] - there[0], mb[1] - there[1]], ..turned };
        let residual = |(a, b): (&[f64; 2], &[f64; 2])| {
            let at = similarity.apply(*a);
            libm::hypot(at[0] - b[0], at[1] - b[1])
        };
        Fit { similarity, residuals: a.iter().zip(b).map(residual).collect() }
    }

    fn largest(&self) -> f64 {
        self.residuals.iter().fold(0.0, |most: f64, r| most.max(*r))
    }
}

/// Fits the marks of `map`. `declared(column, row)` is the place, metres, where the declared orientation puts a pixel of
/// the picture. Fields are `fiducials…`, or the field that the marks speak against.
///
/// # Errors
/// E0530 for marks that cannot decide, E0531 for marks that do not fit, E0532 for a mirrored picture, E0533 for another
/// rotation than declared, E0534 for another scale.
pub(super) fn register(
    map: &HeightMap,
    fiducials: &[Fiducial],
    pixel: [f64; 2],
    declared: impl Fn([f64; 2]) -> [f64; 2],
) -> Result<Registered, Problem> {
    let Some(asked) = &map.fiducials else {
        return Err(Problem::error(codes::E0530, "fiducials", "the map names no marks"));
    };
    let marks = &asked.marks;
    let (mut seen, mut known): (Vec<[f64; 2]>, Vec<[f64; 2]>) = (Vec::new(), Vec::new());
    for (i, mark) in marks.iter().enumerate() {
        let field = format!("fiducials.marks.{i}.name");
        let Some(fiducial) = fiducials.iter().find(|fiducial| fiducial.name == mark.name) else {
            let names: Vec<String> = fiducials.iter().map(|fiducial| format!("`{}`", fiducial.name)).collect();
            let problem =
                Problem::error(codes::E0530, field, format!("the part has no mark that is called `{}`", mark.name));
            return Err(problem.help(match names.as_slice() {
                [] => "say where the part's marks are: `fiducials: [fiducial { name: …, at: place { x: …, y: … } }, …]` in \
                       `workpiece`"
                    .to_string(),
                names => format!("`workpiece.fiducials` has {}", names.join(", ")),
            }));
        };
        if marks[..i].iter().any(|other| other.name == mark.name) {
            let message = format!("the mark `{}` is seen twice", mark.name);
            return Err(Problem::error(codes::E0530, field, message).help("give every mark one place in the picture"));
        }
        if fiducials.iter().filter(|fiducial| fiducial.name == mark.name).count() > 1 {
            let message = format!("the part has two marks that are called `{}`", mark.name);
            return Err(Problem::error(codes::E0530, field, message).help("give every mark of the part its own name"));
        }
        seen.push(declared([mark.column, mark.row]));
        known.push([fiducial.at.x.0, fiducial.at.y.0]);
    }
    if marks.len() < 3 {
        let count = ["no mark is", "one mark is", "two marks are"][marks.len()];
        return Err(Problem::error(
            codes::E0530,
            "fiducials",
            format!("{count} seen; a map needs three to be placed by"),
        )
        .note("two marks fit exactly whatever they say, and do not show whether the picture is mirrored")
        .help("add a third mark that does not lie on the line of the other two"));
    }
    let fit = Fit::new(&seen, &known);
    // The other view: left and right of the picture exchanged, which in the declared frame is a reflection about any line.
    let mirrored = Fit::new(&seen.iter().map(|[x, y]| [-x, *y]).collect::<Vec<_>>(), &known);
    let (left, other, within) = (fit.largest(), mirrored.largest(), asked.within.0);
    // Where the marks coincide, scale and residuals are none.
    if !fit.similarity.scale.is_finite() {
        return Err(Problem::error(codes::E0530, "fiducials", "all marks lie at one place of the picture")
            .help("give the column and the row of each mark as the picture shows them"));
    }
    if left > within && (other <= within || other < BY_FAR * left) {
        let (says, is) = match map.view {
            View::from_tool_side => ("from_tool_side", "from_back"),
            View::from_back => ("from_back", "from_tool_side"),
        };
        let message = format!(
            "the picture is mirrored: the marks fit to {:.3} mm with `view: {is}` and to {:.3} mm with `view: {says}`, which \
             the job says",
            other * 1e3,
            left * 1e3
        );
        return Err(Problem::error(codes::E0532, "view", message)
            .help(format!("say `view: {is}` (and check `up`), unless the marks' names were exchanged")));
    }
    if left > within {
        let worst = (0..marks.len()).max_by(|a, b| fit.residuals[*a].total_cmp(&fit.residuals[*b])).unwrap_or(0);
        let message = format!(
            "the marks do not fit the part: `{}` lies {:.3} mm from where the others put it; {:.3} mm are allowed",
            marks[worst].name,
            left * 1e3,
            within * 1e3
        );
        return Err(Problem::error(codes::E0531, "fiducials", message).help(format!(
            "look the marks up again in the picture and on the part; `within: {:.3} mm` would take them as they are",
            (left * 1e6).ceil() / 1e3
        )));
    }
    if other <= within {
        let message = format!(
            "the marks lie too nearly on a line to show whether the picture is mirrored: the mirror image fits to {:.3} mm as \
             well",
            other * 1e3
        );
        return Err(Problem::error(codes::E0530, "fiducials", message)
            .help("add a mark away from that line, or ask for a closer fit by `within`"));
    }
    let declared_turn = -map.rotated.map_or(0.0, |angle| angle.0);
    let turned = libm::remainder(fit.similarity.rotation - declared_turn, 2.0 * std::f64::consts::PI);
    let degrees = turned.to_degrees();
    if degrees.abs() > MOST_ROTATION {
        let message = format!(
            "the marks say that the part stands turned by {:.1} deg from what `up` and `rotated` say; up to {MOST_ROTATION} \
             deg are taken for the way in which it was laid down",
            -degrees
        );
        let quarters = (degrees / 90.0).round();
        let help = if (degrees - 90.0 * quarters).abs() <= MOST_ROTATION {
            format!("`up: {}` would fit", name(quarter_turned(map.up, quarters as i32)))
        } else {
            // A turn beyond half a revolution is the same as one the other way.
            let whole = libm::remainder(-fit.similarity.rotation, 2.0 * std::f64::consts::PI).to_degrees();
            format!("`rotated: {whole:.1} deg` would fit")
        };
        return Err(Problem::error(codes::E0533, "up", message).help(help));
    }
    let scale = fit.similarity.scale;
    if !((scale - 1.0).abs() <= MOST_SCALE) {
        let message = format!(
            "the marks say that a pixel has {:.6} mm x {:.6} mm, {:+.1} % against what is stated",
            pixel[0] * scale * 1e3,
            pixel[1] * scale * 1e3,
            (scale - 1.0) * 100.0
        );
        return Err(Problem::error(codes::E0534, "pixel", message).help(format!(
            "find out which is right, the size of a pixel or the places of the marks; up to {:.0} % are taken for the \
             calibration of the instrument",
            MOST_SCALE * 100.0
        )));
    }
    let squares: f64 = fit.residuals.iter().map(|r| r * r).sum();
    Ok(Registered {
        similarity: fit.similarity,
        turned,
        residual_rms: (squares / marks.len() as f64).sqrt(),
        residual_max: left,
        marks: marks.len(),
    })
}

/// The axis that lies `quarters` quarter turns from `direction`, from +x towards +y.
pub(super) fn quarter_turned(direction: Direction, quarters: i32) -> Direction {
    const ROUND: [Direction; 4] = [Direction::plus_x, Direction::plus_y, Direction::minus_x, Direction::minus_y];
    let now = ROUND.iter().position(|d| *d == direction).unwrap_or(0) as i32;
    ROUND[(now + quarters).rem_euclid(4) as usize]
}

fn name(direction: Direction) -> &'static str {
    match direction {
        Direction::plus_x => "plus_x",
        Direction::minus_x => "minus_x",
        Direction::plus_y => "plus_y",
        Direction::minus_y => "minus_y",
    }
}
