//! Units of length by their names.

use crate::section::{Rules, Sections, Warning};

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

/// The signs of all units.
pub fn signs() -> [&'static str; UNITS.len()] {
    UNITS.map(|(names, _)| names[0])
}

/// A unit in metres.
pub fn metres(name: &str) -> f64 {
    known(name).map_or(ASSUMED, |(_, metres)| metres)
}

/// The sign of a unit, and what it is in metres, if it is one of these.
pub fn known(name: &str) -> Option<(&'static str, f64)> {
    let name = name.trim().to_lowercase();
    let one = name.strip_suffix('s').unwrap_or(&name);
    let known = UNITS.iter().find(|(names, _)| names.contains(&one));
    known.map(|&(names, metres)| (names[0], metres))
}

/// Gives sections of a file the unit that is asked for, with a note where the file says another.
pub(super) fn measure(sections: &mut Sections, rules: &Rules) {
    let Some(unit) = rules.unit else { return };
    let own = std::mem::replace(&mut sections.units, unit.to_owned());
    if !own.is_empty() && known(&own).is_none_or(|(sign, _)| sign != unit) {
        let what = format!("lengths are taken for {unit}, as was asked for; the file says {own:?}");
        sections.notes.push(Warning { section: String::new(), what });
    }
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
        assert_eq!(known("Inches"), Some(("in", 0.0254)));
    }

    #[test]
    fn the_unit_that_is_asked_for_counts_and_another_one_is_noted() {
        let rules = Rules { unit: Some("cm"), ..Rules::default() };
        for (own, notes) in [("", 0), ("centimetres", 0), ("mm", 1), ("pixel", 1)] {
            let mut sections = Sections { units: own.to_owned(), ..Sections::default() };
            measure(&mut sections, &rules);
            assert_eq!((sections.units.as_str(), sections.notes.len()), ("cm", notes), "{own}");
            let mut kept = Sections { units: own.to_owned(), ..Sections::default() };
            measure(&mut kept, &Rules::default());
            assert_eq!((kept.units.as_str(), kept.notes.len()), (own, 0));
        }
    }
}
