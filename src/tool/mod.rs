//! Tool: what the tool removes where, and how it stands on the surface.
//!
//! In: the job's `tool` and, for a measured influence, the bytes of its map. Out: [`InfluenceFunction`] (removal rate
//! over the tool frame, m/s) and the checks of the wheel. Dwell takes the influence function, motion the stand-off.
//!
//! Tool frame: origin at the tool centre point, **+z into the glass**, x in the direction `azimuth` of the part. It is
//! right-handed, so seen from the tool side (looking along +z) its y axis lies 90 degrees *clockwise* from x: with
//! `azimuth: 0 deg`, tool x is part x and tool y is part **-y**. [`part_to_tool`] is the only place that says so.

pub mod influence;
mod measured;
mod wheel;

pub use influence::{InfluenceFunction, part_to_tool};
pub use wheel::{check, check_fit};
