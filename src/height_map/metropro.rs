//! Zygo MetroPro `.dat` maps, header formats 1, 2 and 3.
//!
//! In: bytes. Out: a [`RawMap`] in metres, with pixel and wavelength where the file says them. The writer makes such
//! files for tests and examples.
//!
//! Source: *MetroPro Reference Guide* (Zygo OMP-0347), chapter "MetroPro data format", as restated by the readers of
//! Gwyddion and prysm. All fields used here are big-endian in all three formats:
//!
//! | byte | field | meaning |
//! | --- | --- | --- |
//! | 0, 4, 6 | magic, format, header size | 881B036F 1 834; 881B0370 2 834; 881B0371 3 4096 |
//! | 52, 54, 56, 60 | intensity width, height, frames, bytes | 16-bit values after the header; skipped |
//! | 68, 70, 72 | phase width, height, bytes | 32-bit values after the intensity |
//! | 164, 168, 176 | scale factor S, wavelength W (m), obliquity O | 32-bit floats |
//! | 184 | lateral resolution (m/pixel) | 0 where it was not calibrated |
//! | 218 | phase resolution | 0: R = 4096; 1: 32768; 2 (formats 2 and 3 only): 131072 |
//! | 232 | sign | 1: "inverted" was set when the data were taken |
//!
//! Height = value * W * S * O / R metres; values from 2147483640 on are invalid. Values run in rows **from the upper
//! left of the picture**, so row 0 is the top.

use super::{Format, RawMap, proved_pixels};
use crate::diagnostics::{Problem, codes};
use crate::job::Quantity;

/// From this value on a phase value means "no data".
pub(super) const INVALID: i32 = 2_147_483_640;

/// Magic number and header size of formats 1, 2, 3.
const FORMATS: [(u32, usize); 3] = [(0x881B_036F, 834), (0x881B_0370, 834), (0x881B_0371, 4096)];

/// Counts a fringe of phase resolution 0, 1, 2.
pub(super) const RESOLUTIONS: [f64; 3] = [4096.0, 32768.0, 131_072.0];

/// Wavelengths of interferometers in metres, from the deep ultraviolet to far beyond the carbon dioxide laser.
pub(super) const WAVELENGTHS: (f64, f64) = (100e-9, 100e-6);
/// Scale factors and obliquities: 0.25 (double pass), 0.5, 1; grazing incidence and high apertures stay within two
/// decades either way.
pub(super) const FACTORS: (f64, f64) = (0.01, 100.0);
/// Pitches of pixels in metres, from below a microscope's to a metre.
pub(super) const PITCHES: (f64, f64) = (1e-9, 1.0);

/// Whether the bytes begin as one of the three formats does.
pub fn is_metropro(bytes: &[u8]) -> bool {
    u32_at(bytes, 0).is_some_and(|magic| FORMATS.iter().any(|(known, _)| *known == magic))
}

/// Reads a map. Sizes are proved against the length of `bytes` before anything is allocated. Fields are `file`.
///
/// # Errors
/// E0503 if header and file do not fit each other, E0504 for values that cannot be, E0501 for too many pixels.
pub fn read(bytes: &[u8], name: &str) -> Result<RawMap, Problem> {
    let magic = u32_at(bytes, 0).unwrap_or(0);
    let Some(index) = FORMATS.iter().position(|(known, _)| *known == magic) else {
        return Err(impossible(name, "its first bytes are not those of a MetroPro map".into()));
    };
    let header_size = FORMATS[index].1;
    if bytes.len() < header_size {
        return Err(sizes(name, format!("ends after {} bytes, inside its header of {header_size} bytes", bytes.len())));
    }
    let header = Header { bytes: &bytes[..header_size], name };
    let (format, size) = (header.int16(4), header.uint32(6));
    if i64::from(format) != index as i64 + 1 || size as usize != header_size {
        return Err(impossible(
            name,
            format!(
                "a header of format {} has {header_size} bytes, but it says format {format} and {size} bytes",
                index + 1
            ),
        ));
    }
    let intensity_bytes = header.intensity_bytes()?;
    let (columns, rows) = (header.side(68, "columns")?, header.side(70, "rows")?);
    let pixels = proved_pixels(columns, rows, name)?;
    let phase_bytes = 4 * pixels as u64;
    if u64::from(header.uint32(72)) != phase_bytes {
        return Err(sizes(
            name,
            format!("says that {columns} x {rows} heights take {} bytes; they take {phase_bytes}", header.uint32(72)),
        ));
    }
    let expected = header_size as u64 + intensity_bytes + phase_bytes;
    if bytes.len() as u64 != expected {
        let how = if (bytes.len() as u64) < expected { "cut short" } else { "longer than its header says" };
        return Err(sizes(name, format!("is {how}: it has {} bytes and should have {expected}", bytes.len())));
    }
    let wavelength = header.within(168, "wavelength", WAVELENGTHS, (" nm", 1e9))?;
    let scale_factor = header.within(164, "interferometric scale factor", FACTORS, ("", 1.0))?;
    let obliquity = header.within(176, "obliquity factor", FACTORS, ("", 1.0))?;
    let lateral = f64::from(header.float32(184));
    let pixel = match lateral {
        0.0 => None,
        _ => Some([header.within(184, "pixel", PITCHES, (" mm", 1e3))?; 2]),
    };
    let height = wavelength * scale_factor * obliquity / header.resolution(index)?;

    // In range: the sum of the three parts is the length of the file.
    let phase = &bytes[bytes.len() - 4 * pixels..];
    let values = phase
        .chunks_exact(4)
        .map(|b| match i32::from_be_bytes([b[0], b[1], b[2], b[3]]) {
            INVALID.. => f64::NAN,
            count => f64::from(count) * height,
        })
        .collect();
    Ok(RawMap {
        in_metres: true,
        pixel,
        wavelength: Some(wavelength),
        quantity: said_by_factor(scale_factor),
        sign_inverted: header.int16(232) != 0,
        ..RawMap::plain(Format::MetroPro, columns as usize, rows as usize, values)
    })
}

/// What a MetroPro scale factor makes of the fringes: 0.5 the surface that reflected them, 1 the wavefront. Other factors
/// (double passes) say nothing. It is stored in single precision.
pub(super) fn said_by_factor(scale_factor: f64) -> Option<Quantity> {
    let is = |expected: f64| (scale_factor - expected).abs() < 1e-3;
    if is(0.5) { Some(Quantity::surface) } else { is(1.0).then_some(Quantity::wavefront) }
}

/// A header whose length was proved; the offsets used are constants below 834.
struct Header<'a> {
    bytes: &'a [u8],
    name: &'a str,
}

impl Header<'_> {
    fn int16(&self, at: usize) -> i16 {
        i16::from_be_bytes([self.bytes[at], self.bytes[at + 1]])
    }

    fn uint32(&self, at: usize) -> u32 {
        u32_at(self.bytes, at).unwrap_or(0)
    }

    fn float32(&self, at: usize) -> f32 {
        f32::from_bits(self.uint32(at))
    }

    /// A side of the phase picture: positive.
    fn side(&self, at: usize, what: &str) -> Result<u64, Problem> {
        let side = self.int16(at);
        u64::try_from(side)
            .ok()
            .filter(|side| *side > 0)
            .ok_or_else(|| impossible(self.name, format!("it says that its map has {side} {what}")))
    }

    /// Bytes between header and heights: none, or exactly what the frames of intensity take.
    fn intensity_bytes(&self) -> Result<u64, Problem> {
        let stated = u64::from(self.uint32(60));
        if stated == 0 {
            return Ok(0);
        }
        let [width, height, frames] = [self.int16(52), self.int16(54), self.int16(56)];
        let needed = [width, height, frames].iter().try_fold(2_u64, |product, side| {
            u64::try_from(*side).ok().filter(|side| *side > 0).and_then(|side| product.checked_mul(side))
        });
        if needed == Some(stated) {
            return Ok(stated);
        }
        Err(sizes(
            self.name,
            format!(
                "says that {frames} frames of {width} x {height} intensities take {stated} bytes, which they do not"
            ),
        ))
    }

    /// The 32-bit float at `at`, if it can be what it is called. For people it is written in `unit`, of which there are
    /// `scale` in the header's own.
    fn within(
        &self,
        at: usize,
        what: &str,
        (from, to): (f64, f64),
        (unit, scale): (&str, f64),
    ) -> Result<f64, Problem> {
        let value = f64::from(self.float32(at));
        if value >= from && value <= to {
            return Ok(value);
        }
        let shown = |value: f64| {
            let text = format!("{:.6}", value * scale);
            let short = if text.contains('.') { text.trim_end_matches('0').trim_end_matches('.') } else { &text };
            format!("{short}{unit}")
        };
        let [value, from, to] = [value, from, to].map(shown);
        Err(impossible(self.name, format!("its {what} is {value}, which is not within {from} .. {to}")))
    }

    /// Counts a fringe. Resolution 2 came with format 2.
    fn resolution(&self, format_index: usize) -> Result<f64, Problem> {
        let known = if format_index == 0 { 2 } else { 3 };
        let code = self.int16(218);
        let found = usize::try_from(code).ok().filter(|code| *code < known).and_then(|code| RESOLUTIONS.get(code));
        found.copied().ok_or_else(|| {
            impossible(
                self.name,
                format!("its phase resolution is {code}; format {} knows 0 to {}", format_index + 1, known - 1),
            )
        })
    }
}

fn u32_at(bytes: &[u8], at: usize) -> Option<u32> {
    let b = bytes.get(at..at + 4)?;
    Some(u32::from_be_bytes([b[0], b[1], b[2], b[3]]))
}

fn sizes(name: &str, what: String) -> Problem {
    Problem::error(codes::E0503, "file", format!("`{name}` {what}"))
        .help("copy or export the map from the instrument again")
}

fn impossible(name: &str, why: String) -> Problem {
    Problem::error(codes::E0504, "file", format!("`{name}` is not a usable MetroPro map: {why}"))
        .help("export the map from the instrument again")
}

/// What a MetroPro file says beside its heights.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Settings {
    /// 1, 2 or 3.
    pub header_format: u16,
    /// 0, 1, or 2 (not in format 1): 4096, 32768 or 131072 counts a fringe.
    pub phase_resolution: u16,
    /// Metres.
    pub wavelength: f64,
    pub scale_factor: f64,
    pub obliquity: f64,
    /// Metres a pixel; `None` writes 0, "not calibrated".
    pub lateral: Option<f64>,
}

impl Settings {
    /// A Fizeau interferometer with a helium-neon laser, heights of the surface, resolution 1/32768 fringe, newest
    /// format.
    pub fn fizeau(lateral: f64) -> Settings {
        Settings {
            header_format: 3,
            phase_resolution: 1,
            wavelength: 632.8e-9,
            scale_factor: 0.5,
            obliquity: 1.0,
            lateral: Some(lateral),
        }
    }
}

/// Writes heights in metres, row-major from the upper left of the picture, NaN where invalid. Rounded to the nearest
/// count, so that reading gives each height back within half a count. `None` if the settings are not those of a
/// MetroPro file, `heights` does not fill the rows, a side has more than 32767 pixels, or a height does not fit its
/// 32 bits.
pub fn write(columns: usize, heights: &[f64], settings: &Settings) -> Option<Vec<u8>> {
    let index = usize::from(settings.header_format).checked_sub(1)?;
    let (magic, header_size) = *FORMATS.get(index)?;
    let resolution = *RESOLUTIONS.get(usize::from(settings.phase_resolution))?;
    if (index == 0 && settings.phase_resolution == 2) || columns == 0 || !heights.len().is_multiple_of(columns) {
        return None;
    }
    let (width, height) = (i16::try_from(columns).ok()?, i16::try_from(heights.len() / columns).ok()?);
    let mut bytes = vec![0; header_size];
    let mut put = |at: usize, field: &[u8]| bytes[at..at + field.len()].copy_from_slice(field);
    put(0, &magic.to_be_bytes());
    put(4, &settings.header_format.to_be_bytes());
    put(6, &(header_size as u32).to_be_bytes());
    put(68, &width.to_be_bytes());
    put(70, &height.to_be_bytes());
    put(72, &u32::try_from(4 * heights.len()).ok()?.to_be_bytes());
    let float = |value: f64| (value as f32).to_be_bytes();
    put(164, &float(settings.scale_factor));
    put(168, &float(settings.wavelength));
    put(176, &float(settings.obliquity));
    put(184, &float(settings.lateral.unwrap_or(0.0)));
    put(218, &settings.phase_resolution.to_be_bytes());
    // The header holds the factors in single precision: counts are made with what a reader will find there.
    let single = |value: f64| f64::from(value as f32);
    let count = single(settings.wavelength) * single(settings.scale_factor) * single(settings.obliquity) / resolution;
    for height in heights {
        let value = if height.is_nan() { INVALID } else { to_count(height / count)? };
        bytes.extend_from_slice(&value.to_be_bytes());
    }
    Some(bytes)
}

fn to_count(counts: f64) -> Option<i32> {
    let rounded = counts.round();
    (rounded >= f64::from(i32::MIN) && rounded < f64::from(INVALID)).then_some(rounded as i32)
}
