//! OpenVDB files.

use std::ops::RangeInclusive;
use std::path::Path;

use cxx::UniquePtr;

use crate::error::{Error, Result};
use crate::ffi::vdb as ffi;
use crate::grid::samples::{Lattice, Samples};
use crate::grid::volume::Volume;
use crate::label::{Label, Material};
use crate::mesh::Mesh;
use crate::section::Section;

use builder::Builder;

mod builder;
mod difference;
mod labels;
mod names;
mod reading;

pub use difference::{DifferenceContents, write_difference};
pub use names::{GridName, Quantity, Which};
pub use reading::{GridInfo, VdbFile};

/// What programs are told wrote the file.
const CREATOR: &str = concat!("transect ", env!("CARGO_PKG_VERSION"));

/// OpenVDB makes no transforms of voxels below 1.4e-5: these are written this many times larger,
/// as often as it takes.
const ENLARGED: f64 = 1000.0;
/// No voxel is smaller than this in a file.
const LEAST_VOXEL: f64 = 1e-4;
/// The sizes of voxels, in world units, whose squares single precision holds, and the numbers
/// by which they are enlarged.
const VOXELS: RangeInclusive<f64> = 1e-18..=1e18;

/// What is written.
#[derive(Debug, Clone, Copy)]
pub struct VdbContents<'a> {
    /// The nodes of all grids.
    pub lattice: &'a Lattice,
    /// The final surfaces: level sets are the distances to them.
    pub mesh: &'a Mesh,
    /// The indicators, for `label` and `indicator_<label>`.
    pub samples: &'a Samples,
    /// What the samples were made from, for `evidence`.
    pub sections: &'a [Section],
    /// All materials.
    pub materials: &'a [Material],
    /// The unit of length; empty when unknown.
    pub units: &'a str,
    /// The frame of the coordinates; empty when unknown.
    pub frame: &'a str,
    /// Which grids, in which order.
    pub grids: &'a [GridName],
}

/// How a file stores grids.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Storage {
    /// `.vdb`.
    OpenVdb {
        /// Whether floats are of half precision.
        half: bool,
    },
    /// `.nvdb`, whose grids have names and places, and nothing else is said of them.
    NanoVdb,
}

/// What programs make of a grid.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum FieldClass {
    /// Distances to a surface.
    LevelSet,
    /// From 0 to 1.
    Fog,
    /// Other numbers with fractions.
    Values,
    /// Whole numbers.
    Numbers,
}

/// A grid that was written.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Field {
    /// Its name in the file.
    pub name: String,
    /// What it holds.
    pub class: FieldClass,
    /// What it is of, if not of all materials.
    pub label: Option<Label>,
}

/// What was written.
#[derive(Debug, Clone, PartialEq)]
pub struct Written {
    /// The grids in their order.
    pub fields: Vec<Field>,
    /// What a world unit is in units of the file: 1, or more where voxels are too small for
    /// OpenVDB.
    pub scale: f64,
}

/// Writes a file. The same contents make the same bytes.
///
/// # Errors
/// A grid of a material that does not exist, or a file that cannot be
/// written whole; a part of it may then be left at `path`.
pub fn write(path: &Path, contents: &VdbContents, storage: Storage) -> Result<Written> {
    write_layers(path, std::slice::from_ref(contents), storage)
}

/// Writes a file of layers that may overlap, each with grids on nodes of its own. What one grid says
/// of all materials otherwise, `density` for one, is a grid for each layer: `density_<label>` where
/// it has one label, and `density_layer<number>` where it has several.
///
/// # Errors
/// As [`write()`], and without any layer.
pub fn write_layers(path: &Path, layers: &[VdbContents], storage: Storage) -> Result<Written> {
    let Some(first) = layers.first() else {
        return Err(Error::Option("there is nothing to write: no layer is left".to_owned()));
    };
    let all: Vec<Material> = layers.iter().flat_map(|own| own.materials).cloned().collect();
    require_grids(first.grids, &all)?;
    // One for the whole file.
    let scales = layers.iter().map(|own| scale(own.lattice)).collect::<Result<Vec<f64>>>()?;
    let scale = scales.into_iter().fold(1.0, f64::max);
    let half = storage == Storage::OpenVdb { half: true };
    let mut whole = Builder::new(first, scale, half)?;
    for (number, contents) in layers.iter().enumerate() {
        let mut builder = Builder::new(contents, scale, half)?;
        let own = names::of_materials(contents.grids, contents.materials);
        let mut grids = names::resolve(&own, contents.materials)?;
        if layers.len() > 1 {
            apart(&mut grids, number, contents.materials);
        }
        grids.iter().try_for_each(|grid| builder.add(grid))?;
        ffi::adopt(whole.volumes.pin_mut(), &builder.volumes).map_err(library)?;
        whole.fields.append(&mut builder.fields);
    }
    let Builder { mut volumes, fields, .. } = whole;
    describe(&mut volumes, "", first.units, first.frame, scale)?;
    finish(&mut volumes, &all, path, storage)?;
    Ok(Written { fields, scale })
}

/// Gives the grids of one layer of several names that no other layer has.
fn apart(grids: &mut Vec<Grid>, number: usize, materials: &[Material]) {
    if let [only] = materials {
        // What is of all of it, and of its only label besides.
        let label = Some(Label(only.id));
        let named: Vec<Quantity> =
            grids.iter().filter(|grid| grid.label == label).map(|grid| grid.quantity).collect();
        grids.retain(|grid| grid.label.is_some() || !named.contains(&grid.quantity));
    }
    for grid in grids.iter_mut().filter(|grid| grid.label.is_none()) {
        grid.name += &match materials {
            [only] => format!("_{}", only.id),
            _ => format!("_layer{}", number + 1),
        };
    }
}

/// What a world unit is in units of a file: 1, or more where voxels are too small for OpenVDB.
fn scale(lattice: &Lattice) -> Result<f64> {
    if !VOXELS.contains(&lattice.voxel) {
        let what = format!(
            "voxels of {:e} are beyond what the single precision of .vdb files can hold: use other \
             units of length",
            lattice.voxel
        );
        return Err(Error::Option(what));
    }
    let mut scale = 1.0;
    while scale * lattice.voxel < LEAST_VOXEL {
        scale *= ENLARGED;
    }
    Ok(scale)
}

/// Whether `.nvdb` files can be written: that needs NanoVDB when transect is built.
pub fn has_nano() -> bool {
    ffi::has_nano()
}

/// Makes sure that there are all grids of these names, before any work is done.
///
/// # Errors
/// A grid of a material that does not exist.
pub fn require_grids(grids: &[GridName], materials: &[Material]) -> Result<()> {
    names::resolve(grids, materials).map(|_| ())
}

/// Says of the file what its labels mean, and writes it.
fn finish(
    volumes: &mut UniquePtr<ffi::Volumes>,
    materials: &[Material],
    path: &Path,
    storage: Storage,
) -> Result<()> {
    let name =
        path.to_str().ok_or_else(|| Error::file(path, "its name is not UTF-8; rename it"))?;
    let materials = serde_json::to_string(materials)
        .map_err(|error| Error::Bug { stage: "VDB", what: error.to_string() })?;
    ffi::set_text(volumes.pin_mut(), "", "labels", &materials).map_err(library)?;
    let written = match storage {
        Storage::OpenVdb { .. } => ffi::write(volumes, name),
        Storage::NanoVdb => ffi::write_nano(volumes, name),
    };
    written.map_err(|exception| {
        Error::file(path, format!("cannot be written: {}", exception.what()))
    })?;
    // What the system could not store turns up here at the latest.
    let synced =
        std::fs::OpenOptions::new().write(true).open(path).and_then(|file| file.sync_all());
    synced.map_err(|error| Error::file(path, format!("cannot be written: {error}")))
}

/// No grids yet on the nodes of a lattice, a world unit being so many units of the file.
fn volumes_on(lattice: &Lattice, scale: f64, half: bool) -> Result<UniquePtr<ffi::Volumes>> {
    let origin = (scale * lattice.origin).to_array();
    ffi::new_volumes(scale * lattice.voxel, origin, half).map_err(library)
}

/// Says of a grid, or of the file, who made it, where it is and how much larger.
fn describe(
    volumes: &mut UniquePtr<ffi::Volumes>,
    grid: &str,
    units: &str,
    frame: &str,
    scale: f64,
) -> Result<()> {
    let scale = if scale == 1.0 { String::new() } else { scale.to_string() };
    for (key, text) in [("creator", CREATOR), ("units", units), ("frame", frame), ("scale", &scale)]
    {
        if !text.is_empty() {
            ffi::set_text(volumes.pin_mut(), grid, key, text).map_err(library)?;
        }
    }
    Ok(())
}

/// One grid to be written.
#[derive(Debug, Clone, PartialEq, Eq)]
struct Grid {
    quantity: Quantity,
    /// What it is of, if not of all materials.
    label: Option<Label>,
    name: String,
}

impl Grid {
    fn of_all(quantity: Quantity) -> Self {
        Self { quantity, label: None, name: quantity.word().to_owned() }
    }

    /// Of a material that is called so.
    fn of(quantity: Quantity, material: &Material, word: &str) -> Self {
        let name = format!("{}_{word}", quantity.word());
        Self { quantity, label: Some(Label(material.id)), name }
    }
}

fn add_volume(
    volumes: &mut UniquePtr<ffi::Volumes>,
    name: &str,
    Volume { background, leaves, values, tiles, tile_values }: &Volume<f32>,
) -> Result<()> {
    let (leaves, tiles) = (leaves.as_flattened(), tiles.as_flattened());
    ffi::add_values(volumes.pin_mut(), name, *background, leaves, values, tiles, tile_values)
        .map_err(library)
}

fn library(exception: cxx::Exception) -> Error {
    Error::library("VDB", &exception)
}

#[cfg(test)]
mod tests;
