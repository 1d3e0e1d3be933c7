//! Tool: what the tool removes where, and how it stands on the surface.
//!
//! In: the job's `tool` and, for a measured influence, the bytes of its map. Out: [`InfluenceFunction`] (removal rate
//! over the tool frame, m/s), the tool's [stance](Azimuth) over a contact point, and the checks of the wheel. Dwell takes
//! the influence function, motion the stand-off and the stance.
//!
//! Tool frame: origin at the tool centre point, **+z into the glass**, x in the direction `azimuth` of the part. It is
//! right-handed, so seen from the tool side (looking along +z) its y axis lies 90 degrees *clockwise* from x: with
//! `azimuth: 0 deg`, tool x is part x and tool y is part **-y**. [`part_to_tool`] says so in the plane,
//! [`Azimuth::axes`] on any surface.

pub mod influence;
mod measured;
mod stance;
mod wheel;

pub use influence::{InfluenceFunction, part_to_tool};
pub use stance::Azimuth;
pub use wheel::{check, check_centre_point, check_fit};
