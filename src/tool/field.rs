//! The influence of a tool over the part: what it removes may depend on where it stands.
//!
//! In: the job's `tool`, `workpiece` and surface. Out: an [`InfluenceField`]: a few influence functions and the weight of each at
//! every place of the part. Dwell takes it.

use super::influence::InfluenceFunction;
use super::measured::MeasuredSpots;
use super::pad_edge::PadEdge;
use super::spread::Spread;
use super::{bonnet, conditions, measured, pad, pad_edge};
use crate::diagnostics::{Problem, codes};
use crate::job::{Along, EdgeModel, Influence, Set, Tool, TurnsWith, Workpiece};
use crate::source::FileProvider;
use crate::workpiece::form::Surface;

/// What the tool removes wherever it stands: a tool standing at the part's (x, y) removes
/// `sum_k weight_k(x, y) * parts[k].rate(dx, dy)`, with `(dx, dy)` in the tool frame.
#[derive(Clone, Debug)]
pub struct InfluenceField {
    /// At least one. Where there are several, the first is what removes in the middle of the part; a part may be negative.
    pub parts: Vec<InfluenceFunction>,
    /// Direction of the tool frame's x axis on the part, radians from +x towards +y: the tool's azimuth, or 0 where spots lie on
    /// the part always alike.
    pub azimuth: f64,
    /// How well measured spots agree, of the set's worst.
    pub spread: Option<Spread>,
    weights: Weights,
}

#[derive(Clone, Debug)]
enum Weights {
    /// One part, whose weight is 1.
    Even,
    /// One part a place, in rising order; linear in between, the last one beyond.
    Along(Along, Vec<f64>),
    /// Of a pad near the edge.
    Edge(PadEdge),
}

impl From<InfluenceFunction> for InfluenceField {
    /// The same everywhere, in a tool frame along the part's x axis.
    fn from(function: InfluenceFunction) -> InfluenceField {
        InfluenceField { parts: vec![function], azimuth: 0.0, spread: None, weights: Weights::Even }
    }
}

/// One influence function with what belongs to it.
struct Single {
    function: InfluenceFunction,
    turns: bool,
    spread: Option<Spread>,
}

impl InfluenceField {
    /// What the job's tool removes. `files` is asked only for measured spots. What is odd but usable is said to `warnings`.
    /// Fields are `tool.…`.
    ///
    /// # Errors
    /// E0620 to E0624, E0656, E0657 and those of a map for spots, E0650 for numbers that give no rate, E0651 for an influence
    /// function that is not one of this tool, E0654 and E0655 for spots taken otherwise, E0658 for a set that cannot be.
    pub fn new(
        tool: &Tool,
        workpiece: &Workpiece,
        surface: &dyn Surface,
        files: &dyn FileProvider,
        warnings: &mut Vec<Problem>,
    ) -> Result<InfluenceField, Vec<Problem>> {
        if let Influence::set(set) = tool.influence() {
            return of_set(set, tool, workpiece, surface, files, warnings);
        }
        if models_the_edge(tool) {
            let (Influence::preston(preston), Tool::planetary_pad(pad)) = (tool.influence(), tool) else {
                let message = "the models of the edge reckon with the pad's pressure, which only `preston` tells";
                return Err(one(Problem::error(codes::E0651, "tool.edge", message)
                    .help("write `edge: not_modelled` or `edge: support_ring`, or `influence: preston { … }`")));
            };
            let (edge, parts) = PadEdge::new(pad, preston, &workpiece.edge).map_err(one)?;
            return Ok(InfluenceField { parts, azimuth: tool.azimuth(), spread: None, weights: Weights::Edge(edge) });
        }
        let single = single(tool.influence(), "tool.influence", tool, workpiece, surface, files, warnings)?;
        let azimuth = if single.turns { tool.azimuth() } else { 0.0 };
        Ok(InfluenceField { azimuth, spread: single.spread, ..single.function.into() })
    }

    /// Whether it is the same everywhere: one part, whose weight is 1.
    pub fn is_uniform(&self) -> bool {
        matches!(self.weights, Weights::Even)
    }

    /// The weight of each part for a tool standing at the part's `(x, y)`, metres; `out` is as long as `parts`.
    pub fn weights(&self, x: f64, y: f64, out: &mut [f64]) {
        match &self.weights {
            Weights::Even => out.fill(1.0),
            Weights::Edge(edge) => edge.weights(x, y, self.azimuth, out),
            Weights::Along(along, places) => {
                let place = coordinate(*along, x, y);
                out.fill(0.0);
                let after = places.partition_point(|p| *p <= place);
                match (after.checked_sub(1).and_then(|k| places.get(k)), places.get(after)) {
                    (Some(low), Some(high)) => {
                        let share = (place - low) / (high - low);
                        out[after - 1] = 1.0 - share;
                        out[after] = share;
                    }
                    (None, _) => out[0] = 1.0,
                    (_, None) => out[places.len() - 1] = 1.0,
                }
            }
        }
    }

    /// Nothing is removed farther than this from the tool centre point, metres.
    pub fn radius(&self) -> f64 {
        self.parts.iter().fold(0.0, |most, part| part.radius().max(most))
    }

    /// The least width of all parts, metres: grids that resolve it resolve all.
    pub fn sigma_scale(&self) -> f64 {
        self.parts.iter().fold(f64::INFINITY, |least, part| part.sigma_scale().min(least))
    }

    /// Whether the tool may stand at the places of a path (x, y in metres): E0658 where a set does not reach, E0653 where a pad
    /// tips over the edge, W0601 where the removal near the edge is not known.
    pub fn check_places(
        &self,
        tool: &Tool,
        workpiece: &Workpiece,
        places: impl Iterator<Item = [f64; 2]> + Clone,
    ) -> Vec<Problem> {
        let mut found: Vec<Problem> = match tool {
            Tool::planetary_pad(pad) => pad_edge::check(pad, &workpiece.edge, places.clone()).into_iter().collect(),
            Tool::mrf_wheel(_) | Tool::bonnet(_) => Vec::new(),
        };
        let Weights::Along(along, known) = &self.weights else { return found };
        let (Some(first), Some(last)) = (known.first(), known.last()) else { return found };
        let beyond = |place: f64| (first - place).max(place - last);
        let (farthest, place) = places
            .map(|[x, y]| coordinate(*along, x, y))
            .map(|place| (beyond(place), place))
            .fold((0.0, 0.0), |worst, here| if here.0 > worst.0 { here } else { worst });
        if farthest <= self.radius() {
            return found;
        }
        let what = match along {
            Along::radius => "radius",
            Along::x => "x",
            Along::y => "y",
        };
        let message = format!(
            "the path goes to {what} {:.3} mm, and the influence functions of the set are known from {:.3} mm to {:.3} mm",
            place * 1e3,
            first * 1e3,
            last * 1e3
        );
        found.push(
            Problem::error(codes::E0658, "tool.influence.at", message)
                .note("the last one holds for a spot's radius beyond its place, and no farther")
                .help(format!("measure one at {what} {:.1} mm", place * 1e3)),
        );
        found
    }
}

/// Whether the pressure under the job's pad depends on the edge.
fn models_the_edge(tool: &Tool) -> bool {
    matches!(tool, Tool::planetary_pad(pad) if matches!(pad.edge, EdgeModel::area | EdgeModel::linear))
}

fn one(problem: Problem) -> Vec<Problem> {
    vec![problem]
}

/// One influence function, whatever its kind but a set.
fn single(
    influence: &Influence,
    at: &str,
    tool: &Tool,
    workpiece: &Workpiece,
    surface: &dyn Surface,
    files: &dyn FileProvider,
    warnings: &mut Vec<Problem>,
) -> Result<Single, Vec<Problem>> {
    let turning = |function| Ok(Single { function, turns: true, spread: None });
    match (influence, tool) {
        (Influence::gaussian(g), _) => {
            let function = InfluenceFunction::gaussian(g.peak.0, g.sigma.0, g.diameter.0)
                .map_err(|problem| one(problem.within(at)))?;
            warnings.extend(super::influence::check_cut(g.sigma.0, g.diameter.0, &function, at));
            turning(function)
        }
        (Influence::measured(spots), _) => {
            let differs = conditions::check(spots, tool, &workpiece.material.name, at);
            if !differs.is_empty() {
                return Err(differs);
            }
            let MeasuredSpots { function, spread } = measured::read(spots, at, files, warnings).map_err(one)?;
            let turns = spots.turns_with == TurnsWith::tool;
            let function = match tool {
                Tool::bonnet(bonnet) if turns => {
                    function.stepped(bonnet.positions()).map_err(|problem| one(problem.within(at)))?
                }
                _ => function,
            };
            Ok(Single { function, turns, spread })
        }
        (Influence::preston(preston), Tool::planetary_pad(pad)) => turning(pad::influence(pad, preston).map_err(one)?),
        (Influence::preston(_), _) => Err(one(not_of("preston", "planetary_pad", tool, at))),
        (Influence::bonnet_contact(contact), Tool::bonnet(bonnet)) => {
            let curvature = middle_curvature(surface, &workpiece.clear, at).map_err(one)?;
            turning(bonnet::influence(bonnet, contact, curvature, at).map_err(one)?)
        }
        (Influence::bonnet_contact(_), _) => Err(one(not_of("bonnet_contact", "bonnet", tool, at))),
        (Influence::set(_), _) => {
            Err(one(Problem::error(codes::E0658, at, "a set of influence functions stands inside another set")
                .help("list all of them in one set")))
        }
    }
}

/// An influence function that another tool has.
fn not_of(influence: &str, of: &str, tool: &Tool, at: &str) -> Problem {
    let message = format!("`{influence}` tells the removal of a `{of}`, and the job's tool is a {}", tool.name());
    Problem::error(codes::E0651, at, message).help("measure a spot: `measured { … }`, or describe it: `gaussian { … }`")
}

fn coordinate(along: Along, x: f64, y: f64) -> f64 {
    match along {
        Along::radius => libm::hypot(x, y),
        Along::x => x,
        Along::y => y,
    }
}

fn of_set(
    set: &Set,
    tool: &Tool,
    workpiece: &Workpiece,
    surface: &dyn Surface,
    files: &dyn FileProvider,
    warnings: &mut Vec<Problem>,
) -> Result<InfluenceField, Vec<Problem>> {
    let refuse =
        |field: String, message: String, help: &str| Err(vec![Problem::error(codes::E0658, field, message).help(help)]);
    if set.at.len() < 2 {
        let message = format!("a set has two influence functions at least, and this one has {}", set.at.len());
        return refuse("tool.influence.at".into(), message, "list more places, or write the one without `set`");
    }
    let places: Vec<f64> = set.at.iter().map(|at| at.place.0).collect();
    if let Some(i) = (1..places.len()).find(|i| !(places[*i] > places[*i - 1])) {
        let message =
            format!("the places of a set rise, and {:.3} mm follows on {:.3} mm", places[i] * 1e3, places[i - 1] * 1e3);
        return refuse(format!("tool.influence.at.{i}.place"), message, "list them in rising order, each place once");
    }
    if models_the_edge(tool) {
        let message = "a set says where the removal changes, and so does the model of the edge: one of them can hold";
        return refuse("tool.edge".into(), message.into(), "write `edge: support_ring` or `edge: not_modelled`");
    }
    let mut parts = Vec::new();
    let mut spread: Option<Spread> = None;
    let mut turns = Vec::new();
    for (i, member) in set.at.iter().enumerate() {
        let at = format!("tool.influence.at.{i}.influence");
        let single = single(&member.influence, &at, tool, workpiece, surface, files, warnings)?;
        parts.push(single.function);
        turns.push(single.turns);
        let wider = |a: Spread, b: Spread| if b.volume > a.volume { b } else { a };
        spread = match (spread, single.spread) {
            (Some(a), Some(b)) => Some(wider(a, b)),
            (a, b) => a.or(b),
        };
    }
    if let Some(i) = turns.iter().position(|turn| *turn != turns[0]) {
        let message = "some influence functions of the set turn with the tool and some do not";
        let field = format!("tool.influence.at.{i}.influence.turns_with");
        return refuse(field, message.into(), "give all of them the same `turns_with`");
    }
    let azimuth = if turns[0] { tool.azimuth() } else { 0.0 };
    Ok(InfluenceField { parts, azimuth, spread, weights: Weights::Along(set.along, places) })
}

/// The curvature by which a bonnet's contact is told on a curved part, 1/m: the mean of both principal ones in the middle of the
/// clear aperture. E0650 where the form does not exist there. Fields are `at`.
fn middle_curvature(surface: &dyn Surface, clear: &crate::job::Aperture, at: &str) -> Result<f64, Problem> {
    if surface.is_plane() {
        return Ok(0.0);
    }
    let [x, y] = clear.centre();
    let Some(point) = surface.at(x, y) else {
        let message =
            "the form does not exist in the middle of the clear aperture, where the bonnet's contact is reckoned";
        return Err(Problem::error(codes::E0650, at, message).help("measure a spot: `measured { … }`"));
    };
    let [low, high] = point.curvature().principal_values();
    Ok(0.5 * (low + high))
}
