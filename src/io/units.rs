//! Units of length by their names.

/// The unit where none is given, or one that is not known: millimetres, as in medicine.
pub const ASSUMED: f64 = 1e-3;

/// Names and signs, and what they are in metres.
const UNITS: [(&[&str], f64); 8] = [
    (&["nm", "nanometer", "nanometre"], 1e-9),
    (&["um", "\u{b5}m", "\u{3bc}m", "micron", "micrometer", "micrometre"], 1e-6),
    (&["mm", "millimeter", "millimetre"], 1e-3),
    (&["cm", "centimeter", "centimetre"], 1e-2),
    (&["m", "meter", "metre"], 1.0),
    (&["km", "kilometer", "kilometre"], 1e3),
    (&["in", "inch", "inche"], 0.0254),
    (&["ft", "foot", "feet"], 0.3048),
];

/// A unit in metres.
pub fn metres(name: &str) -> f64 {
    let name = name.trim().to_lowercase();
    let one = name.strip_suffix('s').unwrap_or(&name);
    let known = UNITS.iter().find(|(names, _)| names.contains(&one));
    known.map_or(ASSUMED, |&(_, metres)| metres)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn units_go_by_many_names() {
        let names = ["mm", "Millimetres", " cm", "m", "\u{3bc}m", "inches", "feet", "km"];
        let found = names.map(metres);
        assert_eq!(found, [1e-3, 1e-3, 1e-2, 1.0, 1e-6, 0.0254, 0.3048, 1e3]);
        assert_eq!(["", "pixel", "s"].map(metres), [ASSUMED; 3]);
    }
}
