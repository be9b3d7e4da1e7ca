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
        let axes = to_millimetres(sections)?;
        for material in &sections.materials {
            let label = Label(material.id);
            let surface = derived.mesh.surface(label).into_mesh(label);
            let cut = match surface.triangles.is_empty() {
                true => Vec::new(),
                false => slice(&surface, &reaching(planes, &surface))?,
            };
            found.push(structure(material, &cut, axes)?);
        }
    }
    Ok(found)
}

/// The contours of sections as they are drawn, likewise.
///
/// # Errors
/// Where their frame cannot be turned into LPS, and where a material reaches to infinity.
pub fn drawn_contours(sections: &Sections) -> Result<Vec<StructureContours>> {
    let axes = to_millimetres(sections)?;
    if let Some(own) = sections.sections.iter().find(|own| own.background().is_material()) {
        let what = "a material that reaches to infinity has no contour: give the section an extent";
        return Err(Error::Section { section: own.name().to_owned(), what: what.to_owned() });
    }
    let of = |material: &Material| structure(material, &sections.sections, axes);
    sections.materials.iter().map(of).collect()
}

/// The factors that make coordinates millimetres in LPS.
fn to_millimetres(sections: &Sections) -> Result<DVec3> {
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
    Ok(1e3 * metres(&sections.units) * sign)
}

/// The contours of a material on sections.
fn structure(material: &Material, sections: &[Section], axes: DVec3) -> Result<StructureContours> {
    let mut contours: Vec<Vec<DVec3>> = Vec::new();
    for section in sections {
        let place = |&vertex: &u32| axes * section.point(vertex);
        let walk = |walk: &Vec<u32>| walk.iter().map(place).collect::<Vec<_>>();
        for region in section.regions()?.iter().filter(|own| own.label == Label(material.id)) {
            let Some(outer) = &region.outer else { continue };
            contours.push(keyhole(walk(outer), region.holes.iter().map(walk)));
        }
    }
    Ok(StructureContours { material: material.clone(), contours })
}

/// The boundary of a region as one line, which goes to each hole and back on the same way, where it
/// is nearest: programs that know of no holes fill none so (DICOM PS3.3, C.8.8.6.3).
fn keyhole(outer: Vec<DVec3>, holes: impl Iterator<Item = Vec<DVec3>>) -> Vec<DVec3> {
    let mut walk = outer;
    for hole in holes {
        let mut nearest = (f64::INFINITY, 0, 0);
        for (here, from) in walk.iter().enumerate() {
            for (there, to) in hole.iter().enumerate() {
                let distance = from.distance_squared(*to);
                if distance < nearest.0 {
                    nearest = (distance, here, there);
                }
            }
        }
        let (distance, here, there) = nearest;
        let around = hole[there..].iter().chain(&hole[..there]).copied();
        // Where they touch there is no way to go.
        let back = (distance > 0.0).then(|| [hole[there], walk[here]]);
        let back = back.into_iter().flatten().chain((distance == 0.0).then(|| walk[here]));
        let around: Vec<DVec3> = around.skip(usize::from(distance == 0.0)).chain(back).collect();
        walk.splice(here + 1..here + 1, around);
    }
    walk
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

#[cfg(test)]
mod tests {
    use super::*;

    fn walk(corners: &[[f64; 2]]) -> Vec<DVec3> {
        corners.iter().map(|&[x, y]| DVec3::new(x, y, 5.0)).collect()
    }

    fn area(walk: &[DVec3]) -> f64 {
        let next = walk.iter().cycle().skip(1);
        walk.iter().zip(next).map(|(one, next)| 0.5 * one.cross(*next).z).sum()
    }

    #[test]
    fn one_line_goes_around_all_holes() {
        let outer = walk(&[[0.0, 0.0], [10.0, 0.0], [10.0, 10.0], [0.0, 10.0]]);
        let near = walk(&[[1.0, 1.0], [1.0, 3.0], [3.0, 3.0], [3.0, 1.0]]);
        let behind = walk(&[[4.0, 4.0], [4.0, 5.0], [5.0, 4.0]]);
        let touching = walk(&[[10.0, 10.0], [8.0, 9.0], [9.0, 8.5]]);
        let holes = [near, behind, touching];
        let wanted = area(&outer) + holes.iter().map(|hole| area(hole)).sum::<f64>();
        let found = keyhole(outer.clone(), holes.iter().cloned());
        assert!((area(&found) - wanted).abs() < 1e-12, "{} {wanted}", area(&found));
        // Every corner, and four more where the line goes away and comes back, but for the corner
        // that touches.
        assert_eq!(found.len(), 4 + (4 + 2) + (3 + 2) + 3);
        assert!(found.windows(2).all(|pair| pair[0] != pair[1]));
        // The second hole is reached from the first, which is nearer than the outer boundary.
        let to = found.iter().position(|at| *at == holes[1][0]).expect("the hole");
        assert_eq!(found[to - 1], holes[0][2]);
        assert_eq!(keyhole(outer.clone(), std::iter::empty()), outer);
    }
}
