//! Contours of results on planes, for structure sets.

use glam::DVec3;

use crate::error::{Error, Result};
use crate::io::dicom::StructureContours;
use crate::io::units::metres;
use crate::io::volume::write::turn;
use crate::label::{Label, Material};
use crate::mesh::Mesh;
use crate::model::Model;
use crate::plane::Plane;
use crate::section::{Section, Sections};
use crate::slice::slice;

/// Planes that differ by less, as a part of the diagonal of all contours, are one slice: each
/// structure's were fitted to its own contours.
const ONE: f64 = 1e-4;
/// What is beside a mesh by this part of its diagonal is on it but for rounding.
const BESIDE: f64 = 1e-9;

/// The planes of all sections, each once.
pub fn planes_of(models: &[&Model]) -> Vec<Plane> {
    let all = Sections::side_by_side(models.iter().map(|model| model.sections()));
    let Some(bounds) = all.bounds() else { return Vec::new() };
    let (middle, near) = (bounds.middle(), ONE * bounds.diagonal());
    let is_one = |one: &Plane, other: &Plane| {
        let sign = one.normal.dot(other.normal).signum();
        one.unit_normal().distance(sign * other.unit_normal()) < ONE
            && (one.distance(middle) - sign * other.distance(middle)).abs() <= near
    };
    let mut planes: Vec<Plane> = Vec::new();
    for plane in all.sections.iter().map(Section::plane) {
        if !planes.iter().any(|known| is_one(known, plane)) {
            planes.push(*plane);
        }
    }
    planes
}

/// The contours of every material on planes, which are in world units like the models; in
/// millimetres and LPS. What is of an unknown unit or frame is taken to be in these.
///
/// # Errors
/// Where a model has no sections, and where its frame cannot be turned into LPS.
pub fn structure_contours(models: &[&Model], planes: &[Plane]) -> Result<Vec<StructureContours>> {
    let mut found = Vec::new();
    for model in models {
        let sections = model.sections();
        let nothing = || Error::Option("there is nothing to write: no section is left".to_owned());
        let derived = model.derived().ok_or_else(nothing)?;
        let sign = match (sections.frame.as_str(), turn(&sections.frame, "LPS")) {
            (_, Some(sign)) => sign,
            ("", None) => DVec3::ONE,
            (frame, None) => {
                let what = format!(
                    "structure sets are in LPS, and the sections in {frame:?}: convert them first"
                );
                return Err(Error::Option(what));
            }
        };
        let millimetres = 1e3 * metres(&sections.units);
        for material in &sections.materials {
            let label = Label(material.id);
            let surface = derived.mesh.surface(label).into_mesh(label);
            let mut contours: Vec<Vec<DVec3>> = Vec::new();
            if !surface.triangles.is_empty() {
                for section in slice(&surface, &reaching(planes, &surface))? {
                    let place = |&vertex: &u32| millimetres * sign * section.point(vertex);
                    let own = section.regions()?;
                    let own = own.iter().filter(|region| region.label == label);
                    let walks = own.flat_map(|region| region.outer.iter().chain(&region.holes));
                    contours.extend(walks.map(|walk| walk.iter().map(place).collect()));
                }
            }
            found.push(StructureContours { material: Material::clone(material), contours });
        }
    }
    Ok(found)
}

/// Those of some planes that reach a mesh: images may have far more slices than that.
fn reaching(planes: &[Plane], mesh: &Mesh) -> Vec<Plane> {
    let Some(bounds) = mesh.bounds() else { return Vec::new() };
    let half = 0.5 * bounds.size() + BESIDE * bounds.diagonal();
    let reaches = |plane: &&Plane| {
        plane.distance(bounds.middle()).abs() <= plane.unit_normal().abs().dot(half)
    };
    planes.iter().filter(reaches).copied().collect()
}
