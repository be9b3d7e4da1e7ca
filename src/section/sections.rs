//! Sections together: coincident planes, materials, what files share.

use super::draft::Draft;
use super::overlay::Overlay;
use super::{Findings, Rules, Section, Sections, Warning, reach};
use crate::direction;
use crate::error::{Error, Remedy, Result};
use crate::label::{Label, Material};
use crate::plane::{Bounds, Plane};

/// How far the tips of two unit vectors of one direction may lie apart.
const SAME_DIRECTION: f64 = 1e-6;

impl Sections {
    /// Sections of distinct planes. Those of one plane are merged, with a
    /// warning, where they agree, and so are those of nearly one plane where each draws
    /// what the other lacks.
    ///
    /// # Errors
    /// Where there is none, and where two sections of one plane disagree.
    pub fn new(sections: Vec<Section>, rules: &Rules) -> Result<Self> {
        let mut sections = Self::default().with(sections, rules)?.require_any()?;
        sections.align(rules)?;
        Ok(sections)
    }

    /// The same with more sections. Those of one plane are merged, with a warning, where they
    /// agree.
    ///
    /// # Errors
    /// Where two sections of one plane disagree.
    pub(crate) fn with(
        mut self,
        sections: impl IntoIterator<Item = Section>,
        rules: &Rules,
    ) -> Result<Self> {
        for section in sections {
            self.push(section, rules)?;
        }
        self.unite_frames(rules)?;
        self.unite_drawings(rules)?;
        self.complete_materials();
        Ok(self)
    }

    fn require_any(self) -> Result<Self> {
        match self.sections.is_empty() {
            true => Err(Error::Option("there is no section: at least one is needed".to_owned())),
            false => Ok(self),
        }
    }

    /// The sections of several files as one. Names of sections get the name of
    /// their file in front.
    ///
    /// # Errors
    /// As [`Sections::new`], and where units, frames or directions up differ.
    pub fn join(parts: Vec<Self>, rules: &Rules) -> Result<Self> {
        let mut whole = Self::default();
        for mut part in parts {
            let file = part.files.first().and_then(|file| file.file_name());
            if let Some(file) = file.map(|file| file.to_string_lossy().into_owned()) {
                part.begin_names(&format!("{file}:"));
            }
            let sections = std::mem::take(&mut part.sections);
            whole.learn(part, rules)?;
            for section in sections {
                whole.push(section, rules)?;
            }
        }
        whole.unite_frames(rules)?;
        whole.unite_drawings(rules)?;
        whole.complete_materials();
        whole.require_any()
    }

    /// All vertices' box; `None` when there are no contours.
    pub fn bounds(&self) -> Option<Bounds> {
        reach::bounds(&self.sections)
    }

    /// The material of a label.
    pub fn material(&self, label: Label) -> Option<&Material> {
        let found = self.materials.binary_search_by_key(&label.0, |material| material.id);
        found.ok().map(|i| &self.materials[i])
    }

    /// Adds what was found while sections were made.
    pub fn note(&mut self, findings: Findings) {
        self.warnings.extend(findings.warnings);
        self.left_out.extend(findings.left_out);
        self.off_plane = self.off_plane.max(findings.off_plane);
        if findings.snapped > 0 {
            let what = format!(
                "vertices less than {:.3e} from others, from edges or from an extent, and put \
                 there: {}",
                findings.snapping, findings.snapped
            );
            self.notes.push(Warning { section: String::new(), what });
        }
    }

    /// Names materials as a file does; keeps those that occur.
    pub fn name_materials(&mut self, materials: Vec<Material>) {
        self.materials = materials;
        self.complete_materials();
    }

    /// Learns what other sections' files say besides the sections.
    ///
    /// # Errors
    /// Where units, frames or directions up differ.
    pub(crate) fn learn(&mut self, mut part: Self, rules: &Rules) -> Result<()> {
        same("unit", &mut self.units, &part.units, &part)?;
        same("frame", &mut self.frame, &part.frame, &part)?;
        self.stand(&part)?;
        for material in std::mem::take(&mut part.materials) {
            self.add_material(material, rules)?;
        }
        self.warnings.append(&mut part.warnings);
        self.left_out.append(&mut part.left_out);
        self.notes.append(&mut part.notes);
        self.off_plane = self.off_plane.max(part.off_plane);
        self.unknown_occurs |= part.unknown_occurs;
        self.files.append(&mut part.files);
        Ok(())
    }

    /// Up is up in all files that say what it is.
    fn stand(&mut self, part: &Self) -> Result<()> {
        let differ = match [self.up, part.up].map(|up| up.and_then(direction::unit)) {
            [Some(known), Some(new)] => known.distance(new) > SAME_DIRECTION,
            _ => false,
        };
        if differ {
            let what = "\"up\" is not that of the files before: make them the same";
            return Err(Error::Option(format!("{}: {what}", part.first_file())));
        }
        self.up = self.up.or(part.up);
        Ok(())
    }

    /// The first of the files, for errors.
    fn first_file(&self) -> String {
        let nameless = || "the new sections".to_owned();
        self.files.first().map_or_else(nameless, |file| file.display().to_string())
    }

    /// Puts something in front of all sections' names.
    pub(crate) fn begin_names(&mut self, prefix: &str) {
        let full = |name: &mut String| name.insert_str(0, prefix);
        self.sections.iter_mut().for_each(|section| full(&mut section.name));
        let told = self.warnings.iter_mut().chain(&mut self.left_out).chain(&mut self.notes);
        told.for_each(|warning| full(&mut warning.section));
    }

    fn add_material(&mut self, material: Material, rules: &Rules) -> Result<()> {
        let Some(known) = self.materials.iter().find(|known| known.id == material.id) else {
            self.materials.push(material);
            return Ok(());
        };
        if known.name == material.name {
            return Ok(());
        }
        let begin = format!("label {} is called ", known.id);
        let what =
            format!("{begin}{:?} and {:?}: the first name is kept", known.name, material.name);
        // Once is enough for a label, however many sections come over time.
        if !rules.strict && self.warnings.iter().any(|warning| warning.what.starts_with(&begin)) {
            return Ok(());
        }
        warn(self, "", what, rules)
    }

    /// Adds a section, or merges it with the one that has its plane.
    fn push(&mut self, section: Section, rules: &Rules) -> Result<()> {
        let same = |known: &Section| coincide(&known.plane, &section.plane);
        let Some(place) = self.sections.iter().position(same) else {
            self.sections.push(section);
            return Ok(());
        };
        let diagonal = self.bounds().map_or(0.0, |bounds| bounds.diagonal());
        let known = &self.sections[place];
        let merged = merge(known, &section, diagonal, rules)?;
        let what =
            format!("lies on the plane of section {} and agrees with it: merged", known.name);
        self.left_out.push(Warning { section: section.name.clone(), what: what.clone() });
        self.sections[place] = merged;
        warn(self, &section.name, what, rules)
    }

    /// Every material that occurs has a name and a colour, and no other.
    fn complete_materials(&mut self) {
        let mut labels: Vec<Label> = self.sections.iter().flat_map(Section::labels).collect();
        labels.sort();
        labels.dedup();
        labels.retain(|label| label.is_material());
        let known = std::mem::take(&mut self.materials);
        let named = |label: &Label| known.iter().find(|material| material.id == label.0).cloned();
        self.materials = labels
            .iter()
            .map(|label| named(label).unwrap_or_else(|| Material::numbered(*label)))
            .collect();
    }
}

pub(super) fn warn(
    sections: &mut Sections,
    section: &str,
    what: String,
    rules: &Rules,
) -> Result<()> {
    if rules.strict {
        let error = Error::Section { section: section.to_owned(), what };
        return Err(error.avoidable(Remedy::NotStrict));
    }
    sections.warnings.push(Warning { section: section.to_owned(), what });
    Ok(())
}

/// What files must have in common, when they say it.
fn same(what: &str, known: &mut String, new: &str, part: &Sections) -> Result<()> {
    if known.is_empty() {
        new.clone_into(known);
    } else if !new.is_empty() && known != new {
        return Err(Error::Option(format!(
            "{}: the {what} is {new:?}, that of the files before is {known:?}: convert one",
            part.first_file()
        )));
    }
    Ok(())
}

/// One section of two on the same plane; what one does not know, the other may.
pub(super) fn merge(
    known: &Section,
    new: &Section,
    diagonal: f64,
    rules: &Rules,
) -> Result<Section> {
    let new = new.onto(known.plane);
    let mut draft = Draft::new(&known.name, known.plane, diagonal, rules)?;
    let overlay = Overlay::new(&mut draft, [known, &new])?;
    if let Some((area, place)) = overlay.conflict(&draft) {
        // The face beyond all contours has no area of its own.
        let how_much = match area > 0.0 {
            true => format!("on an area of {area:.3e}, most near {place}"),
            false => "beyond all contours".to_owned(),
        };
        let what = format!(
            "lies on the plane of section {} but disagrees with it {how_much}: remove one of them",
            known.name
        );
        return Err(Error::Section { section: new.name, what });
    }
    Ok(overlay.section(
        &draft,
        |[first, second]| {
            if first == Label::UNKNOWN { second } else { first }
        },
    ))
}

/// Whether two planes are the same set of points, decided exactly: all minors
/// of their (normal, offset) vanish.
pub(crate) fn coincide(a: &Plane, b: &Plane) -> bool {
    let [a, b] = [a, b].map(|plane| [plane.normal.x, plane.normal.y, plane.normal.z, plane.offset]);
    let minor = |i: usize, j: usize| product(a[i], b[j]) == product(a[j], b[i]);
    minor(0, 1) && minor(0, 2) && minor(0, 3) && minor(1, 2) && minor(1, 3) && minor(2, 3)
}

/// The exact product of two finite doubles: an odd integer (or 0) and the power
/// of two it is multiplied by.
pub(super) fn product(a: f64, b: f64) -> (i128, i32) {
    let [(a, p), (b, q)] = [a, b].map(parts);
    let mantissa = i128::from(a) * i128::from(b);
    if mantissa == 0 {
        return (0, 0);
    }
    let zeros = mantissa.trailing_zeros();
    (mantissa >> zeros, p + q + zeros as i32)
}

/// A finite double as mantissa and exponent (IEEE 754 binary64).
fn parts(value: f64) -> (i64, i32) {
    let bits = value.to_bits();
    let exponent = ((bits >> 52) & 0x7ff) as i32;
    let fraction = (bits & ((1 << 52) - 1)) as i64;
    let (mantissa, exponent) =
        if exponent == 0 { (fraction, -1074) } else { (fraction | 1 << 52, exponent - 1075) };
    (if value.is_sign_negative() { -mantissa } else { mantissa }, exponent)
}

#[cfg(test)]
mod tests {
    use glam::DVec3;

    use super::*;

    fn plane(normal: [f64; 3], offset: f64) -> Plane {
        Plane { normal: DVec3::from_array(normal), offset }
    }

    #[test]
    fn planes_coincide_exactly() {
        let first = plane([1.0, 2.0, 3.0], 4.0);
        // 0.3 is not three times the double 0.1.
        assert!(!coincide(&first, &plane([-0.1, -0.2, -0.3], -0.4)));
        assert!(coincide(&first, &plane([-2.0, -4.0, -6.0], -8.0)));
        assert!(!coincide(&first, &plane([1.0, 2.0, 3.0], -4.0)));
        assert!(!coincide(&first, &plane([1.0, 2.0, 3.0 + 4.5e-16], 4.0)));
        assert!(coincide(&plane([0.0, 0.0, 1.0], 0.0), &plane([0.0, -0.0, -7.0], 0.0)));
        assert!(!coincide(&plane([0.0, 0.0, 1.0], 0.0), &plane([0.0, 0.0, 1.0], 5e-324)));
        let tiny = 2.0f64.powi(-600);
        assert!(coincide(&first, &plane([tiny, 2.0 * tiny, 3.0 * tiny], 4.0 * tiny)));
    }
}
