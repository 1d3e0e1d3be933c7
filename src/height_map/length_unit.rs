//! Units of length as instruments spell them.

/// Metres in one of the unit, if it is known. Case is ignored where that leaves one meaning: `MM` is a millimetre, since
/// no instrument measures in megametres.
pub(super) fn metres(unit: &str) -> Option<f64> {
    let unit = unit.trim().to_lowercase();
    Some(match unit.as_str() {
        "m" | "meter" | "meters" | "metre" | "metres" => 1.0,
        "cm" | "centimeter" | "centimeters" | "centimetre" | "centimetres" => 1e-2,
        "mm" | "millimeter" | "millimeters" | "millimetre" | "millimetres" => 1e-3,
        // The micro sign, the Greek letter, and the letter that stands for both where neither could be typed.
        "µm" | "μm" | "um" | "micron" | "microns" | "micrometer" | "micrometers" | "micrometre" | "micrometres" => {
            1e-6
        }
        "nm" | "nanometer" | "nanometers" | "nanometre" | "nanometres" => 1e-9,
        "pm" | "picometer" | "picometers" | "picometre" | "picometres" => 1e-12,
        "å" | "angstrom" | "angstroms" | "ångström" | "ångströms" => 1e-10,
        "in" | "inch" | "inches" => 0.0254,
        _ => return None,
    })
}
