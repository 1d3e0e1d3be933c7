//! Tool: what the tool removes where, and how it stands on the surface.
//!
//! In: the job's `tool` and, for a measured influence, the bytes of its maps. Out: the [`InfluenceField`] (removal rates over
//! the tool frame, m/s, and where on the part which of them hold), the tool's [stance](Azimuth) over a contact point, and the
//! checks of its body. Dwell takes the field, motion the stand-off, the [`Ball`] and the stance.
//!
//! A tool is a file: [`wheel`], [`pad`], [`bonnet`]; what they all have is in [`body`].
//!
//! Tool frame: origin at the tool centre point, **+z into the glass**, x in the direction `azimuth` of the part. It is
//! right-handed, so seen from the tool side (looking along +z) its y axis lies 90 degrees *clockwise* from x: with
//! `azimuth: 0 deg`, tool x is part x and tool y is part **-y**. [`part_to_tool`] says so in the plane,
//! [`Azimuth::axes`] on any surface.

mod body;
pub mod bonnet;
mod conditions;
pub mod edge;
mod field;
pub mod influence;
pub mod measured;
pub mod pad;
mod pad_edge;
mod quadrature;
pub mod spread;
mod stance;
mod wheel;

pub use body::{Ball, check, check_fit};
pub use field::InfluenceField;
pub use influence::{InfluenceFunction, part_to_tool};
pub use spread::Spread;
pub use stance::Azimuth;
