//! Layers made voxels, for volumes of labels and of distances.

use glam::{DMat3, DVec3};

use crate::error::{Error, Result};
use crate::grid::lattice::Resolution;
use crate::io::volume::write::{Numbers, VoxelLayer, Voxels, in_frame, turn};
use crate::label::Label;
use crate::memory;
use crate::model::{Derived, Model};
use crate::plane::Bounds;
use crate::volume::{Placement, distances, fill};

/// Bytes that a voxel of a layer takes while it is made and written.
const BYTES: u64 = 5;

/// Where the voxels of a result are when nothing else is asked for: on the nodes of the grid; of
/// several layers in a box around the grids of all, as fine as the resolution asks for on its
/// longest side.
///
/// # Errors
/// Where a model has no sections, or there are more voxels than anybody could count.
pub fn own_voxels(models: &[&Model]) -> Result<Voxels> {
    let Some(first) = models.first() else { return Err(nothing()) };
    let lattice = |model: &&Model| Ok(derived(model)?.samples.lattice);
    let lattices = models.iter().map(lattice).collect::<Result<Vec<_>>>()?;
    let sections = first.sections();
    let (units, frame) = (sections.units.clone(), sections.frame.clone());
    let (origin, voxel, dims) = match lattices[..] {
        [only] => (only.origin, only.voxel, only.dims.map(|count| count.max(0) as usize)),
        _ => {
            let ends = lattices.iter().flat_map(|own| [own.origin, own.position(own.dims)]);
            let Bounds { min, max } = Bounds::around(ends).ok_or_else(nothing)?;
            let voxel = match first.options().resolution {
                Resolution::VoxelSize(size) => size,
                Resolution::Voxels(count) => (max - min).max_element() / f64::from(count.max(1)),
            };
            let dims = ((max - min) / voxel).ceil().to_array().map(|count| count as usize);
            (min + 0.5 * voxel, voxel, dims)
        }
    };
    let placement = Placement { origin, steps: DMat3::from_diagonal(DVec3::splat(voxel)) };
    Ok(Voxels { dims, placement, units, frame })
}

/// Voxels like those of an image, which may be in another frame.
///
/// # Errors
/// Where its unit or frame is another one that coordinates cannot be turned into.
pub fn require_like(voxels: &Voxels, units: &str, frame: &str) -> Result<()> {
    let differ = |what: &str, own: &str, like: &str| {
        Err(Error::Option(format!(
            "--like: the {what} of the image is {like:?}, that of the sections {own:?}: convert one"
        )))
    };
    let both = |own: &str, like: &str| !own.is_empty() && !like.is_empty() && own != like;
    if both(units, &voxels.units) {
        return differ("unit", units, &voxels.units);
    }
    if both(frame, &voxels.frame) && turn(frame, &voxels.frame).is_none() {
        return differ("frame", frame, &voxels.frame);
    }
    Ok(())
}

/// The labels of voxels, layer by layer; of one label alone where that is wanted.
///
/// # Errors
/// Where a model has no sections, and where voxels would not fit into memory.
pub fn voxel_layers(
    models: &[&Model],
    voxels: &Voxels,
    only: Option<Label>,
) -> Result<Vec<VoxelLayer>> {
    let is_own = |id: u32| only.is_none_or(|label| label.0 == id);
    let wanted = models
        .iter()
        .filter(|model| model.sections().materials.iter().any(|material| is_own(material.id)));
    let wanted: Vec<&&Model> = wanted.collect();
    require_memory(voxels, BYTES * wanted.len() as u64)?;
    let layer = |model: &&Model| -> Result<VoxelLayer> {
        let sections = model.sections();
        let placement = in_frame(voxels.placement, &voxels.frame, &sections.frame);
        let mut labels = fill(&derived(model)?.mesh, voxels.dims, &placement);
        if only.is_some() {
            labels.iter_mut().filter(|label| !is_own(**label)).for_each(|label| *label = 0);
        }
        let materials = sections.materials.iter().filter(|material| is_own(material.id));
        let numbers = Numbers::Labels(labels);
        Ok(VoxelLayer { materials: materials.cloned().collect(), numbers })
    };
    wanted.into_iter().map(layer).collect()
}

/// The distances from the centres of voxels to the surface of a label, or of all materials
/// together, in world units and less than zero inside; infinite where there is no surface.
///
/// # Errors
/// As [`voxel_layers`], and for all materials of several layers.
pub fn voxel_distances(
    models: &[&Model],
    voxels: &Voxels,
    only: Option<Label>,
) -> Result<VoxelLayer> {
    let has = |model: &&&Model| match only {
        None => true,
        Some(label) => model.sections().materials.iter().any(|own| own.id == label.0),
    };
    let [model] = models.iter().filter(has).collect::<Vec<_>>()[..] else {
        let what = "the distances of several structures are a file for each: name it by {label} or \
                    {name}";
        return Err(Error::Option(what.to_owned()));
    };
    let is_own = |label: Label| match only {
        None => label.is_material(),
        Some(own) => label == own,
    };
    require_memory(voxels, BYTES + size_of::<f32>() as u64)?;
    let (sections, mesh) = (model.sections(), &derived(model)?.mesh);
    let placement = in_frame(voxels.placement, &voxels.frame, &sections.frame);
    let labels = fill(mesh, voxels.dims, &placement);
    let distances = distances(mesh, is_own, &labels, voxels.dims, &placement)?;
    let materials = sections.materials.iter().filter(|material| is_own(Label(material.id)));
    let numbers = Numbers::Distances(distances);
    Ok(VoxelLayer { materials: materials.cloned().collect(), numbers })
}

/// Refuses more voxels than memory has room for, of so many bytes each.
fn require_memory(voxels: &Voxels, bytes: u64) -> Result<()> {
    let count = voxels.dims.iter().try_fold(1u64, |all, &count| all.checked_mul(count as u64));
    let needed = count.and_then(|count| count.checked_mul(bytes)).unwrap_or(u64::MAX);
    memory::require(needed, || {
        let [x, y, z] = voxels.dims;
        format!("a volume of {x} × {y} × {z} voxels")
    })
}

fn derived(model: &Model) -> Result<&Derived> {
    model.derived().ok_or_else(nothing)
}

fn nothing() -> Error {
    Error::Option("there is nothing to write: no section is left".to_owned())
}
