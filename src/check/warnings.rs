//! What a reader should be warned of before trusting a result.

use super::{Check, LabelCheck};
use crate::label::Material;
use crate::section::Warning;

/// By how many degrees more than at the sections a surface leans between them
/// when it looks like beads. True shapes cut by 15 to 24 planes were seen to
/// lean by −1.9° to 1.5° more, smooth reconstructions by up to 17°, the mean-value
/// indicator's by 16° to 42°.
pub const BEADS: f64 = 12.0;
/// And at the sections it leans by no more than this share: a few sections of a
/// small true shape may happen to cut it where it is steep, but not all. Smooth
/// reconstructions were seen to lean by .48 and more, the indicator's by .10 to .38.
pub const STEEP: f64 = 0.4;
/// How many places a warning names.
const NAMED: usize = 3;

impl Check {
    /// What a reader should be warned of, label by label.
    pub fn warnings(&self, materials: &[Material]) -> Vec<Warning> {
        let warn = |label: &LabelCheck| {
            let found = [beads(label), torn(label), afloat(label)];
            let name = name(label.label, materials);
            found.into_iter().flatten().map(move |what| Warning {
                section: String::new(),
                what: format!("{name}: {what}"),
            })
        };
        self.labels.iter().flat_map(warn).collect()
    }
}

fn name(label: u32, materials: &[Material]) -> String {
    let own = materials.iter().find(|material| material.id == label);
    own.map_or_else(
        || format!("label {label}"),
        |material| format!("label {label} ({})", material.name),
    )
}

fn beads(label: &LabelCheck) -> Option<String> {
    let ripple =
        label.ripple.filter(|own| own.angle() > BEADS && own.at_sections < STEEP * own.between)?;
    Some(format!(
        "its surface ripples in step with the sections, like beads or terraces: it leans by \
         {:.0}° against the sections' planes between them and by {:.0}° at them; that is the \
         method's doing and not the sections'",
        ripple.between, ripple.at_sections
    ))
}

fn torn(label: &LabelCheck) -> Option<String> {
    let mut places = Vec::new();
    for passage in &label.passages {
        let [one, other] = &passage.sections;
        places.extend(passage.torn.iter().map(|&at| format!("{} ({one} to {other})", place(at))));
    }
    (!places.is_empty()).then(|| {
        format!(
            "it is torn between neighbouring sections whose regions lie over each other: at {}",
            listed(&places, places.len())
        )
    })
}

fn afloat(label: &LabelCheck) -> Option<String> {
    let count = label.afloat.pieces;
    let places: Vec<String> = label.afloat.largest.iter().map(|piece| place(piece.at)).collect();
    let pieces = if count == 1 { "a piece hangs" } else { "pieces hang" };
    (count > 0).then(|| {
        format!(
            "{pieces} in the air, and no section passes through: near {}",
            listed(&places, count)
        )
    })
}

/// To a ten-thousandth of its greatest coordinate: enough to go there.
fn place(at: [f64; 3]) -> String {
    let size = at.iter().fold(0.0, |size: f64, at| size.max(at.abs()));
    let digits = (4.0 - size.max(f64::MIN_POSITIVE).log10().floor()).clamp(0.0, 12.0);
    let unit = 10f64.powf(digits);
    let [x, y, z] = at.map(|at| (at * unit).round() / unit);
    format!("({x}, {y}, {z})")
}

/// The first of so many.
fn listed(all: &[String], count: usize) -> String {
    let shown = &all[..all.len().min(NAMED)];
    let rest = match count - shown.len() {
        0 => String::new(),
        rest => format!(" and {rest} more"),
    };
    format!("{}{rest}", shown.join(", "))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::check::afloat::{Afloat, Piece};
    use crate::check::contour::Unreached;
    use crate::check::passage::Passage;
    use crate::check::ripple::Ripple;
    use crate::mesh::facts::Facts;

    /// A label with nothing to warn of.
    fn sound() -> LabelCheck {
        let facts = Facts {
            closed: true,
            outward: true,
            volume: 1.0,
            area: 1.0,
            components: 1,
            cavities: 0,
            genus: 0,
            triangles: 4,
            self_intersections: None,
        };
        LabelCheck {
            label: 3,
            facts,
            open_edges: 0,
            open_at_box: true,
            cavalieri: None,
            passages: Vec::new(),
            afloat: Afloat::default(),
            ripple: None,
            unreached: Unreached::default(),
        }
    }

    #[test]
    fn beads_are_told_from_shapes_that_lean() {
        let with = |at_sections, between| {
            let ripple = Some(Ripple { at_sections, between });
            beads(&LabelCheck { ripple, ..sound() })
        };
        assert_eq!(beads(&sound()), None);
        assert_eq!(with(20.0, 20.0 + 0.9 * BEADS), None);
        assert_eq!(with(30.0, 10.0), None);
        assert!(with(4.0, 4.0 + 1.1 * BEADS).is_some());
        assert_eq!(with(1.3 * BEADS, 2.4 * BEADS), None, "more than half as steep at sections");
        assert_eq!(with(14.0, 29.0), None, "a smooth label of five sections");
        assert!(with(19.0, 50.0).is_some(), "an unsmoothed handle");
    }

    #[test]
    fn tears_and_pieces_are_named_by_their_places() {
        assert_eq!((torn(&sound()), afloat(&sound())), (None, None));
        let passage = |torn| {
            let sections = ["7".to_owned(), "8".to_owned()];
            Passage { sections, begin: 1, end: 1, torn }
        };
        let label = LabelCheck { passages: vec![passage(Vec::new())], ..sound() };
        assert_eq!(torn(&label), None, "to begin and end is no tear");
        let label = LabelCheck { passages: vec![passage(vec![[1.0, 2.0, 3.0]; 5])], ..sound() };
        let what = torn(&label).expect("a tear");
        assert!(what.contains("(1, 2, 3) (7 to 8)") && what.ends_with("and 2 more"), "{what}");
        let largest = vec![Piece { volume: 1.0, at: [0.0, 0.25, -1.5] }];
        let afloat =
            afloat(&LabelCheck { afloat: Afloat { pieces: 1, volume: 1.0, largest }, ..sound() });
        assert!(afloat.expect("a piece").ends_with("near (0, 0.25, -1.5)"));
    }
}
