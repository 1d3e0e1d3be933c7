//! The tool and its influence function, as a job says them.

use super::{Direction, Empty, Material, PixelAt, Positive, Quantity, View};
use crate::units::si::*;
use serde::{Deserialize, Serialize};

#[allow(non_camel_case_types, reason = "family members are spelt as in the job")]
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub enum Tool {
    mrf_wheel(MrfWheel),
    planetary_pad(PlanetaryPad),
    bonnet(Bonnet),
}

#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct MrfWheel {
    pub diameter: Length,
    pub speed: AngularSpeed,
    pub rotation: WheelRotation,
    /// Between the wheel's lowest point (the TCP) and the nominal surface, along the normal.
    pub gap: Length,
    /// Direction of the tool's x axis on the part, from +x towards +y of the part, seen from the tool side.
    pub azimuth: Angle,
    pub influence: Influence,
}

/// Sense of rotation: `forward` drags the fluid along the tool's +x at the contact, `reverse` along -x.
#[allow(non_camel_case_types, reason = "symbols are spelt as in the job")]
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum WheelRotation {
    forward,
    reverse,
}

/// A turn about an axis of the tool.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Turn {
    /// Negative turns against `positive`.
    pub speed: AngularSpeed,
    pub positive: Sense,
    pub seen: Seen,
}

#[allow(non_camel_case_types, reason = "symbols are spelt as in the job")]
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Sense {
    clockwise,
    counterclockwise,
}

/// From where a turn is looked at: from the tool side one sees the glass, from the glass the tool.
#[allow(non_camel_case_types, reason = "symbols are spelt as in the job")]
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Seen {
    from_tool_side,
    from_glass,
}

/// A flat pad that spins on an arm, which orbits about the tool's axis.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct PlanetaryPad {
    pub diameter: Length,
    /// From the axis of the orbit to the middle of the pad.
    pub eccentricity: Length,
    pub orbit: Turn,
    pub spin: Turn,
    pub spin_measured: SpinMeasured,
    pub force: Force,
    /// Direction of the tool's x axis on the part, from +x towards +y of the part, seen from the tool side.
    pub azimuth: Angle,
    pub influence: Influence,
    pub edge: EdgeModel,
}

/// Against what a pad's spin is counted.
#[allow(non_camel_case_types, reason = "symbols are spelt as in the job")]
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum SpinMeasured {
    on_arm,
    absolute,
}

/// What becomes of the pad's pressure where it hangs over the part's edge.
#[allow(non_camel_case_types, reason = "symbols are spelt as in the job")]
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum EdgeModel {
    not_modelled,
    support_ring,
    area,
    linear,
}

/// An inflated spherical cap that spins about a leaning axis.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Bonnet {
    /// Of the cap, cloth included.
    pub radius: Length,
    /// Half angle of the cap, from its pole.
    pub cap: Angle,
    /// How far the cap is pressed in, along the surface normal.
    pub offset: Length,
    pub pressure: Pressure,
    pub spin: Turn,
    pub precession: Precession,
    pub influence: Influence,
}

/// How the spin axis stands on the surface.
#[allow(non_camel_case_types, reason = "family members are spelt as in the job")]
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub enum Precession {
    upright(Empty),
    leaning(Leaning),
}

#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Leaning {
    /// Between spin axis and surface normal.
    pub tilt: Angle,
    pub azimuth: Lean,
}

/// Where the spin axis leans to.
#[allow(non_camel_case_types, reason = "family members are spelt as in the job")]
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub enum Lean {
    held(HeldLean),
    stepped(SteppedLean),
}

#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct HeldLean {
    /// Direction on the part in which the shaft leans, from +x towards +y, seen from the tool side.
    pub at: Angle,
}

/// Evenly spread leans, each for the same part of the time at every place.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SteppedLean {
    pub first: Angle,
    pub positions: i64,
}

#[allow(non_camel_case_types, reason = "family members are spelt as in the job")]
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub enum Influence {
    gaussian(Gaussian),
    measured(Measured),
    preston(Preston),
    bonnet_contact(BonnetContact),
    set(Set),
}

/// Influence functions known at several places of the part, linear in between.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Set {
    pub along: Along,
    /// In rising order of `place`.
    pub at: Vec<InfluenceAt>,
}

/// What the places of a set are counted along.
#[allow(non_camel_case_types, reason = "symbols are spelt as in the job")]
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Along {
    radius,
    x,
    y,
}

#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct InfluenceAt {
    pub place: Length,
    pub influence: Influence,
}

/// Preston's law: depth a time = coefficient * pressure * speed.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Preston {
    pub coefficient: PerPressure,
}

/// Preston's law under a bonnet: pressure falls from the middle of the contact as (1 - r²/a²)^exponent.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct BonnetContact {
    pub exponent: f64,
    pub rate: ContactRate,
}

/// What fixes the rate of a bonnet's contact.
#[allow(non_camel_case_types, reason = "family members are spelt as in the job")]
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub enum ContactRate {
    spot_peak(SpotPeak),
    wear(Wear),
}

#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SpotPeak {
    /// Greatest removal rate of a spot polished at one lean, on a flat.
    pub rate: Speed,
}

#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Wear {
    pub coefficient: PerPressure,
    /// In the middle of the contact.
    pub greatest_pressure: Pressure,
}

/// peak * exp(-r²/2σ²) for r <= diameter/2, zero outside.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Gaussian {
    /// Removal rate at the centre: a height a time.
    pub peak: Speed,
    pub sigma: Length,
    pub diameter: Length,
}

/// Measured maps of the depth that spots of known dwell removed, in the tool frame.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Measured {
    pub spots: Vec<Spot>,
    pub quantity: Quantity,
    /// `high`: glass stands high where the value is positive, so a spot reads negative; `low`: removal reads positive.
    pub positive: Positive,
    pub view: View,
    /// Axis of the *tool frame* that points up in the picture; of the part, for spots that do not turn with the tool.
    pub up: Direction,
    pub pixel: Option<Length>,
    pub unit: Option<Length>,
    /// Pixels farther than this from the origin are outside the spot: they give the baseline that is taken off.
    pub radius: Length,
    pub turns_with: TurnsWith,
    /// Where the fluid of a wheel flows in the picture: checked against `rotation`, `up` and `view`.
    pub flow_in_map: Option<InPicture>,
    pub taken: Conditions,
    pub ageing: Option<Ageing>,
}

/// One spot.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Spot {
    /// The map with the spot; the map of its depth alone, where `before` is left out.
    pub file: String,
    /// The map of the same place before it.
    pub before: Option<String>,
    /// Time that the spot was polished.
    pub dwell: Time,
    /// Where the tool centre point stood in the picture.
    pub origin: Origin,
    /// What the process clock read when the spot was made.
    pub clock: Option<Time>,
}

/// With what a spot turns on the part.
#[allow(non_camel_case_types, reason = "symbols are spelt as in the job")]
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum TurnsWith {
    tool,
    nothing,
}

/// A direction of a picture as one looks at it.
#[allow(non_camel_case_types, reason = "symbols are spelt as in the job")]
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum InPicture {
    up,
    down,
    left,
    right,
}

/// How old spots may be, on a clock of the process.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Ageing {
    /// What the clock reads when the run starts.
    pub now: Time,
    /// Age of the youngest spot at most.
    pub at_most: Time,
}

/// The conditions that spots were taken under.
#[allow(non_camel_case_types, reason = "family members are spelt as in the job")]
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub enum Conditions {
    mrf_conditions(MrfConditions),
    pad_conditions(PadConditions),
    bonnet_conditions(BonnetConditions),
}

#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct MrfConditions {
    pub diameter: Length,
    pub speed: AngularSpeed,
    pub rotation: WheelRotation,
    pub gap: Length,
    pub material: Material,
}

#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct PadConditions {
    pub diameter: Length,
    pub eccentricity: Length,
    pub orbit: Turn,
    pub spin: Turn,
    pub spin_measured: SpinMeasured,
    pub force: Force,
    pub material: Material,
}

#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct BonnetConditions {
    pub radius: Length,
    pub offset: Length,
    pub pressure: Pressure,
    /// Without its sense, which the removal does not know.
    pub speed: AngularSpeed,
    pub tilt: Angle,
    pub material: Material,
}

/// Where the tool centre point stood in a spot's picture. There is no default: a wrong origin shifts all removal.
#[allow(non_camel_case_types, reason = "family members are spelt as in the job")]
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub enum Origin {
    frame_centre(Empty),
    /// The deepest pixel.
    peak(Empty),
    /// The centre of the removed volume.
    centroid(Empty),
    peak_near(PeakNear),
    centroid_near(CentroidNear),
    pixel_at(PixelAt),
}

/// The deepest pixel within the spot's radius of this one.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct PeakNear {
    pub column: f64,
    pub row: f64,
}

/// The centre of the volume removed within the spot's radius of this pixel.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct CentroidNear {
    pub column: f64,
    pub row: f64,
}
