//! Layers that may overlap made one, in which labels exclude each other.

use super::draft::Draft;
use super::overlay::Overlay;
use super::sections::warn;
use super::{Rules, Section, Sections, Warning};
use crate::error::{Error, Result};
use crate::label::Label;
use crate::plane::Plane;

/// Normals of one direction differ by less than this.
const PARALLEL: f64 = 1e-9;

impl Sections {
    /// Layers side by side, for whoever shows or counts them: a plane may have a section of each.
    pub fn side_by_side<'a>(layers: impl IntoIterator<Item = &'a Self>) -> Self {
        let mut all = Self::default();
        for layer in layers {
            all.sections.extend(layer.sections.iter().cloned());
            all.materials.extend(layer.materials.iter().cloned());
            if all.units.is_empty() {
                all.units.clone_from(&layer.units);
            }
            if all.frame.is_empty() {
                all.frame.clone_from(&layer.frame);
            }
            all.up = all.up.or(layer.up);
            all.warnings.extend(layer.warnings.iter().cloned());
            all.left_out.extend(layer.left_out.iter().cloned());
            all.notes.extend(layer.notes.iter().cloned());
            all.off_plane = all.off_plane.max(layer.off_plane);
            all.unknown_occurs |= layer.unknown_occurs;
            let new = layer.files.iter().filter(|file| !all.files.contains(file)).cloned();
            let new: Vec<_> = new.collect();
            all.files.extend(new);
        }
        all.materials.sort_by_key(|material| material.id);
        all
    }

    /// Layers as one set of sections: where materials of two overlap, the earlier layer's is there.
    /// Where a layer has no section on another one's plane, it is taken to show nothing there.
    ///
    /// # Errors
    /// Where sections cannot be laid over each other, and without any layer.
    pub fn partition(layers: Vec<Self>, rules: &Rules) -> Result<Self> {
        let mut whole = Self::side_by_side(&layers);
        let diagonal = whole.bounds().map_or(0.0, |bounds| bounds.diagonal());
        let near = rules.tolerance * diagonal;
        whole.sections.clear();
        let mut merged: Vec<Section> = Vec::new();
        for layer in &layers {
            for section in &layer.sections {
                let known =
                    merged.iter_mut().find(|known| is_one(&known.plane, &section.plane, near));
                match known {
                    Some(known) => *known = over(known, section, diagonal, rules)?,
                    None => {
                        let offset = section.plane.unit().offset;
                        let name = format!("slice at {}", (1e3 * offset).round() / 1e3 + 0.0);
                        merged.push(Section { name, ..section.clone() });
                    }
                }
            }
        }
        for layer in &layers {
            let missing = missing(layer, &merged, near);
            if missing > 0 {
                let name = layer.materials.first().map_or("", |material| &material.name);
                let what = format!(
                    "{name} has no contour on {missing} of the slices between its first and its \
                     last one, on which others have: it is taken to be absent there"
                );
                warn(&mut whole, "", what, rules)?;
            }
        }
        whole.notes.push(Warning {
            section: String::new(),
            what: format!(
                "structures exclude each other, in this order: {}",
                layers
                    .iter()
                    .flat_map(|layer| &layer.materials)
                    .map(|material| material.name.as_str())
                    .collect::<Vec<_>>()
                    .join(", ")
            ),
        });
        let named = std::mem::take(&mut whole.materials);
        let mut whole = whole.with(merged, rules)?;
        whole.name_materials(named);
        match whole.sections.is_empty() {
            true => Err(Error::Option("there is no section: at least one is needed".to_owned())),
            false => Ok(whole),
        }
    }
}

/// Whether two planes are one but for what files round away.
fn is_one(one: &Plane, other: &Plane, near: f64) -> bool {
    let [one, other] = [one.unit(), other.unit()];
    let sign = one.normal.dot(other.normal).signum();
    one.normal.distance(sign * other.normal) < PARALLEL
        && (one.offset - sign * other.offset).abs() <= near
}

/// Two sections of one plane, the first one's materials over the second one's.
fn over(first: &Section, second: &Section, diagonal: f64, rules: &Rules) -> Result<Section> {
    let second = second.onto(first.plane);
    let mut draft = Draft::new(&first.name, first.plane, diagonal, rules)?;
    let overlay = Overlay::new(&mut draft, [first, &second])?;
    Ok(overlay.section(&draft, |[first, second]| {
        let unknown = first == Label::UNKNOWN || second == Label::UNKNOWN;
        match [first, second].into_iter().find(|label| label.is_material()) {
            Some(material) => material,
            None if unknown => Label::UNKNOWN,
            None => Label::OUTSIDE,
        }
    }))
}

/// On how many planes of others a layer has no section, between its first and last ones that are
/// parallel to them.
fn missing(layer: &Sections, all: &[Section], near: f64) -> usize {
    let is_missing = |plane: &Plane| {
        let plane = plane.unit();
        let parallel =
            layer.sections.iter().map(|section| section.plane.unit()).filter_map(|own| {
                let sign = own.normal.dot(plane.normal).signum();
                let is_parallel = own.normal.distance(sign * plane.normal) < PARALLEL;
                is_parallel.then_some(sign * own.offset)
            });
        let offsets: Vec<f64> = parallel.collect();
        let below = offsets.iter().any(|&offset| offset < plane.offset);
        let above = offsets.iter().any(|&offset| offset > plane.offset);
        below && above && offsets.iter().all(|offset| (offset - plane.offset).abs() > near)
    };
    all.iter().filter(|section| is_missing(&section.plane)).count()
}

#[cfg(test)]
mod tests {
    use glam::DVec3;

    use super::*;
    use crate::label::Material;

    /// Squares of a label on planes of these heights.
    fn layer(label: u32, half: f64, heights: &[f64]) -> Sections {
        let rules = Rules::default();
        let sections = heights.iter().map(|&z| {
            let corners = [[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]];
            let corners = corners.map(|[x, y]| DVec3::new(half * x, half * y, z));
            let plane = Plane { normal: DVec3::Z, offset: z };
            let built = Section::builder(format!("{label} at {z}"), plane);
            built.region(Label(label), corners).build(&rules).unwrap().0
        });
        let mut sections = Sections::new(sections.collect(), &rules).unwrap();
        let material = Material { name: format!("m{label}"), ..Material::numbered(Label(label)) };
        sections.name_materials(vec![material]);
        sections
    }

    fn areas(sections: &Sections, label: u32) -> Vec<f64> {
        let of = |section: &Section| {
            let regions = section.regions().unwrap();
            let own = regions.iter().filter(|region| region.label == Label(label));
            own.map(|region| region.area).sum::<f64>()
        };
        sections.sections.iter().map(of).collect()
    }

    #[test]
    fn the_earlier_layer_wins() {
        let rules = Rules::default();
        // The second lies a rounding error beside the first.
        let [small, large] = [layer(7, 1.0, &[0.0, 1.0]), layer(2, 2.0, &[0.0, 1.0 + 1e-9, 2.0])];
        let whole = Sections::partition(vec![small.clone(), large.clone()], &rules).unwrap();
        assert_eq!(areas(&whole, 7), [4.0, 4.0, 0.0]);
        assert_eq!(areas(&whole, 2), [12.0, 12.0, 16.0]);
        let names: Vec<&str> = whole.materials.iter().map(|one| one.name.as_str()).collect();
        assert_eq!(names, ["m2", "m7"]);
        assert!(whole.notes[0].what.ends_with("order: m7, m2"), "{:?}", whole.notes);
        // The other way round nothing of the small one is left.
        let whole = Sections::partition(vec![large, small], &rules).unwrap();
        assert_eq!(areas(&whole, 7), [0.0; 3]);
    }

    #[test]
    fn slices_that_a_layer_lacks_are_told() {
        let layers = vec![layer(1, 2.0, &[0.0, 1.0, 2.0]), layer(2, 1.0, &[0.0, 2.0])];
        let whole = Sections::partition(layers, &Rules::default()).unwrap();
        assert!(whole.warnings[0].what.starts_with("m2 has no contour on 1 of"), "{whole:?}");
    }
}
