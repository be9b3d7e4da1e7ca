//! What a reader should be warned of before trusting a result.

use super::pieces::Tear;
use super::{Check, LabelCheck, SectionCheck};
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
/// Below this Dice's coefficient a section is not what the surface shows there.
const POOR: f64 = 0.9;
/// Below this, in the mean over its sections, a label has vanished but for dust.
const DUST: f64 = 0.1;
/// How many places a warning names.
const NAMED: usize = 3;

impl Check {
    /// What a reader should be warned of, label by label.
    pub fn warnings(&self, materials: &[Material]) -> Vec<Warning> {
        let warn = |label: &LabelCheck| {
            let found =
                [beads(label), torn(label), apart(label), out_of_place(label), afloat(label)];
            let name = name(label.label, materials);
            found.into_iter().flatten().map(move |what| Warning {
                section: String::new(),
                what: format!("{name}: {what}"),
            })
        };
        let own = self.labels.iter().flat_map(warn);
        self.vanished(materials).into_iter().chain(own).chain(self.poor()).collect()
    }

    /// The materials that are drawn and of which nothing came out, or nothing but dust.
    pub fn vanished(&self, materials: &[Material]) -> Vec<Warning> {
        let warn = |label: &LabelCheck| {
            let name = name(label.label, materials);
            if label.facts.triangles > 0 {
                let mean = self.mean_dice(label.label).filter(|&mean| mean < DUST)?;
                let what = format!(
                    "{name} is drawn and next to nothing of it came out (a Dice of {mean:.2} in \
                     the mean over the sections that show it): is it too thin for {}?",
                    self.finer()
                );
                return Some(Warning { section: String::new(), what });
            }
            let why = match label.unreached.thin_length {
                0.0 => "what is around it wins everywhere".to_owned(),
                _ => format!("it is too thin for {}", self.finer()),
            };
            let what = format!("{name} is drawn and nothing of it came out: {why}");
            Some(Warning { section: String::new(), what })
        };
        self.labels.iter().filter_map(warn).collect()
    }

    /// A label's mean over the sections on which it is, or the result has it.
    fn mean_dice(&self, label: u32) -> Option<f64> {
        let sections = self.dice.sections.iter();
        let own: Vec<f64> = sections.filter_map(|section| *section.labels.get(&label)?).collect();
        (!own.is_empty()).then(|| own.iter().sum::<f64>() / own.len() as f64)
    }

    /// The sections that the surface does not show.
    fn poor(&self) -> Option<Warning> {
        let poor = |own: &&SectionCheck| own.dice.is_some_and(|dice| dice < POOR);
        let count = self.dice.sections.iter().filter(poor).count();
        let by_dice = |one: &&SectionCheck, other: &&SectionCheck| {
            one.dice.unwrap_or(1.0).total_cmp(&other.dice.unwrap_or(1.0))
        };
        let worst = self.dice.sections.iter().filter(poor).min_by(by_dice)?;
        let is_thin = self.labels.iter().any(|label| label.unreached.thin_length > 0.0)
            || !self.contours.thin.is_empty();
        let why = match is_thin {
            true => format!("parts are too thin for {}", self.finer()),
            false => format!(
                "voxels of {} are too large for it, the method does not follow what is drawn \
                 there, or sections that cross contradict each other (`transect inspect` says \
                 where)",
                digits(self.voxel)
            ),
        };
        let (dice, all) = (worst.dice.unwrap_or_default(), self.dice.sections.len());
        let section = &worst.section;
        Some(Warning {
            section: String::new(),
            what: format!(
                "{count} of {all} sections are not what the surface shows on their planes (a Dice \
                 of {dice:.2} on section {section}): {why}"
            ),
        })
    }

    /// What to do about a coarse grid.
    fn finer(&self) -> String {
        format!(
            "voxels of {}: choose smaller ones (--voxel-size, --resolution)",
            digits(self.voxel)
        )
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

/// What is in pieces that its sections show in one.
fn apart(label: &LabelCheck) -> Option<String> {
    let pieces = label.pieces.as_ref().filter(|pieces| !pieces.torn.is_empty())?;
    let tear = |tear: &Tear| {
        let on = match &tear.sections[..] {
            [one, other] => format!("between sections {one} and {other}"),
            own => format!("on section {}", own.join(", ")),
        };
        format!("{on} near {}", place(tear.at))
    };
    let places: Vec<String> = pieces.torn.iter().map(tear).collect();
    let begin = match (pieces.found, pieces.shown) {
        (found, shown) if found > shown => {
            let show = if shown == 1 { "one".to_owned() } else { shown.to_string() };
            format!("it comes out in {found} pieces where its sections show {show}")
        }
        _ => "it is torn where its sections show one piece".to_owned(),
    };
    Some(format!("{begin}: it is apart {}", listed(&places, places.len())))
}

fn out_of_place(label: &LabelCheck) -> Option<String> {
    let found = &label.pieces.as_ref()?.out_of_place;
    let own = |tear: &Tear| match &tear.sections[..] {
        [before, own, after] => format!("{own} (between {before} and {after})"),
        own => own.join(", "),
    };
    let mut sections: Vec<String> = found.iter().map(own).collect();
    sections.dedup();
    (!sections.is_empty()).then(|| {
        format!(
            "it ends before a section and begins behind it at the same place, and what is drawn on \
             that one hangs together with neither: is it out of place? Section {}",
            listed(&sections, sections.len())
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
    let [x, y, z] = at.map(|at| rounded(at, size));
    format!("({x}, {y}, {z})")
}

/// A length to a ten-thousandth of it.
fn digits(length: f64) -> f64 {
    rounded(length, length)
}

/// To a ten-thousandth of a size.
fn rounded(value: f64, size: f64) -> f64 {
    let digits = (4.0 - size.max(f64::MIN_POSITIVE).log10().floor()).clamp(0.0, 12.0);
    let unit = 10f64.powf(digits);
    (value * unit).round() / unit
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
    use crate::check::Agreement;
    use crate::check::afloat::{Afloat, Piece};
    use crate::check::contour::{Contours, Unreached};
    use crate::check::passage::Passage;
    use crate::check::pieces::Pieces;
    use crate::check::ripple::Ripple;
    use crate::check::support::Support;
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
            pieces: None,
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

    /// What is found of labels, and sections with these shares.
    fn check_of(labels: Vec<LabelCheck>, dice: &[Option<f64>]) -> Check {
        let section = |(number, &dice): (usize, &Option<f64>)| SectionCheck {
            section: number.to_string(),
            dice,
            unknown: 0.0,
            labels: Default::default(),
        };
        let sections = dice.iter().enumerate().map(section).collect();
        Check {
            voxel: 0.25,
            dice: Agreement { mean: None, min: None, sections },
            contours: Contours::default(),
            stack: None,
            labels,
            support: Support::default(),
            outside_volume: 1.0,
            box_volume: 2.0,
        }
    }

    #[test]
    fn what_vanished_and_what_is_not_shown_is_told() {
        let facts = Facts { triangles: 0, ..sound().facts };
        let gone = LabelCheck { facts, ..sound() };
        let unreached = Unreached { contours: 2, length: 1.0, thin_length: 1.0 };
        let thin = LabelCheck { unreached, label: 5, ..gone.clone() };
        let found = check_of(vec![sound(), gone, thin], &[Some(1.0), None]).warnings(&[]);
        let [gone, thin] = &found[..] else { panic!("{found:?}") };
        assert!(gone.what.starts_with("label 3 is drawn and nothing"), "{}", gone.what);
        assert!(thin.what.contains("label 5") && thin.what.contains("voxels of 0.25: choose"));
        let dice = [Some(0.95), Some(0.4), None, Some(0.85)];
        let found = check_of(vec![sound()], &dice).warnings(&[]);
        let [poor] = &found[..] else { panic!("{found:?}") };
        assert!(
            poor.what.starts_with("2 of 4 sections") && poor.what.contains("0.40 on section 1")
        );
    }

    #[test]
    fn dust_is_as_good_as_nothing() {
        for (dice, is_told) in [(0.02, true), (0.5, false)] {
            let mut check = check_of(vec![sound()], &[Some(dice), None]);
            check.dice.sections[0].labels.insert(3, Some(dice));
            let found = check.vanished(&[]);
            assert_eq!(!found.is_empty(), is_told, "{found:?}");
            assert!(found.iter().all(|own| own.what.contains("next to nothing")));
        }
    }

    #[test]
    fn what_is_apart_and_what_is_out_of_place_is_named() {
        let tear = |names: &[&str]| Tear {
            sections: names.iter().map(|&name| name.to_owned()).collect(),
            at: [1.0, 2.0, 3.0],
        };
        let with = |found, shown, torn: &[Tear], out_of_place: &[Tear]| LabelCheck {
            pieces: Some(Pieces {
                found,
                shown,
                torn: torn.to_vec(),
                out_of_place: out_of_place.to_vec(),
            }),
            ..sound()
        };
        assert_eq!(apart(&with(2, 2, &[], &[])), None);
        let what = apart(&with(3, 1, &[tear(&["a"]), tear(&["b", "c"])], &[])).expect("tears");
        let words = [
            "in 3 pieces where its sections show one",
            "on section a near (1, 2, 3)",
            "between sections b and c",
        ];
        assert!(words.iter().all(|word| what.contains(word)), "{what}");
        let what = out_of_place(&with(3, 3, &[], &[tear(&["a", "b", "c"])])).expect("one");
        assert!(what.ends_with("Section b (between a and c)"), "{what}");
        assert_eq!(out_of_place(&sound()), None);
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
