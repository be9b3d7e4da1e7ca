//! OpenVDB files.

use std::ops::RangeInclusive;
use std::path::Path;

use cxx::UniquePtr;

use crate::error::{Error, Result};
use crate::ffi::vdb as ffi;
use crate::grid::distance::{HALF_WIDTH, narrow_band};
use crate::grid::labels::LabelGrid;
use crate::grid::samples::{Lattice, Samples};
use crate::grid::volume::{self, Volume};
use crate::label::{Label, Material};
use crate::mesh::Mesh;
use crate::section::Section;

mod difference;
mod labels;
mod names;
mod reading;

pub use difference::{DifferenceContents, write_difference};
pub use names::{GridName, Which};
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

/// Writes a file. The same contents make the same bytes.
///
/// # Errors
/// A grid of a material that does not exist, or a file that cannot be
/// written whole; a part of it may then be left at `path`.
pub fn write(path: &Path, contents: &VdbContents) -> Result<()> {
    let mut builder = Builder::new(contents, String::new())?;
    let wanted = names::resolve(contents.grids, contents.materials)?;
    wanted.into_iter().try_for_each(|grid| builder.add(grid))?;
    let (scale, volumes) = (builder.scale, &mut builder.volumes);
    describe(volumes, "", contents.units, contents.frame, scale)?;
    finish(&mut builder.volumes, contents.materials, path)
}

/// Writes a file of layers that may overlap, each with grids on nodes of its own. What one grid says
/// of all materials otherwise, `density` for one, is a grid for each layer: `density_<label>` where
/// it has one label, and `density_layer<number>` where it has several.
///
/// # Errors
/// As [`write()`].
pub fn write_layers(path: &Path, layers: &[VdbContents]) -> Result<()> {
    let (Some(first), true) = (layers.first(), layers.len() > 1) else {
        return layers.first().map_or(Ok(()), |only| write(path, only));
    };
    let all: Vec<Material> = layers.iter().flat_map(|own| own.materials).cloned().collect();
    require_grids(first.grids, &all)?;
    let mut whole = Builder::new(first, String::new())?;
    for (number, contents) in layers.iter().enumerate() {
        let suffix = match contents.materials {
            [only] => format!("_{}", only.id),
            _ => format!("_layer{}", number + 1),
        };
        let is_own = |label: Label| contents.materials.iter().any(|one| one.id == label.0);
        let mut builder = Builder::new(contents, suffix)?;
        let of = |grid: &GridName| match *grid {
            GridName::SurfaceOf(Which::One(label)) | GridName::IndicatorOf(Which::One(label)) => {
                is_own(label)
            }
            _ => true,
        };
        let grids: Vec<GridName> = contents.grids.iter().copied().filter(of).collect();
        let wanted = names::resolve(&grids, contents.materials)?;
        wanted.into_iter().try_for_each(|grid| builder.add(grid))?;
        ffi::adopt(whole.volumes.pin_mut(), &builder.volumes).map_err(library)?;
    }
    describe(&mut whole.volumes, "", first.units, first.frame, 1.0)?;
    finish(&mut whole.volumes, &all, path)
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
) -> Result<()> {
    let name =
        path.to_str().ok_or_else(|| Error::file(path, "its name is not UTF-8; rename it"))?;
    let materials = serde_json::to_string(materials)
        .map_err(|error| Error::Bug { stage: "VDB", what: error.to_string() })?;
    ffi::set_text(volumes.pin_mut(), "", "labels", &materials).map_err(library)?;
    ffi::write(volumes, name).map_err(|exception| {
        Error::file(path, format!("cannot be written: {}", exception.what()))
    })?;
    // What the system could not store turns up here at the latest.
    let synced =
        std::fs::OpenOptions::new().write(true).open(path).and_then(|file| file.sync_all());
    synced.map_err(|error| Error::file(path, format!("cannot be written: {error}")))
}

/// No grids yet on the nodes of a lattice, and what a world unit is in units of the file.
fn volumes_on(lattice: &Lattice) -> Result<(UniquePtr<ffi::Volumes>, f64)> {
    let scale = scale(lattice)?;
    let origin = (scale * lattice.origin).to_array();
    let volumes = ffi::new_volumes(scale * lattice.voxel, origin).map_err(library)?;
    Ok((volumes, scale))
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
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Grid {
    Surface,
    Density,
    Label,
    SurfaceOf(Label),
    IndicatorOf(Label),
    Evidence,
    Margin,
}

impl Grid {
    fn name(self) -> String {
        match self {
            Self::Surface => "surface".to_owned(),
            Self::Density => "density".to_owned(),
            Self::Label => "label".to_owned(),
            Self::SurfaceOf(label) => format!("surface_{label}"),
            Self::IndicatorOf(label) => format!("indicator_{label}"),
            Self::Evidence => "evidence".to_owned(),
            Self::Margin => "margin".to_owned(),
        }
    }

    fn label(self) -> Option<Label> {
        match self {
            Self::SurfaceOf(label) | Self::IndicatorOf(label) => Some(label),
            Self::Surface | Self::Density | Self::Label | Self::Evidence | Self::Margin => None,
        }
    }
}

/// Where all grids come together.
struct Builder<'a> {
    contents: &'a VdbContents<'a>,
    volumes: UniquePtr<ffi::Volumes>,
    /// A world unit in units of the file.
    scale: f64,
    /// What follows the names of grids that are of all materials.
    suffix: String,
    /// The names of grids that there are.
    names: Vec<String>,
    /// The names and triangles of the level sets there are.
    level_sets: Vec<(String, Vec<[u32; 3]>)>,
}

impl<'a> Builder<'a> {
    fn new(contents: &'a VdbContents, suffix: String) -> Result<Self> {
        let (volumes, scale) = volumes_on(contents.lattice)?;
        let (names, level_sets) = Default::default();
        Ok(Self { contents, volumes, scale, suffix, names, level_sets })
    }

    fn name(&self, grid: Grid) -> String {
        match grid.label() {
            None => format!("{}{}", grid.name(), self.suffix),
            Some(_) => grid.name(),
        }
    }

    fn add(&mut self, grid: Grid) -> Result<()> {
        let (name, samples) = (self.name(grid), self.contents.samples);
        if self.names.contains(&name) {
            return Ok(()); // the surface of a layer's only label
        }
        self.names.push(name.clone());
        match grid {
            Grid::Surface => self.add_level_set(&name, Label::is_material),
            Grid::SurfaceOf(label) => self.add_level_set(&name, |within| within == label),
            Grid::Density => self.add_density(&name),
            Grid::Label => labels::add_labels(&mut self.volumes, &name, &LabelGrid::new(samples)),
            Grid::IndicatorOf(label) => self.add_volume(&name, &volume::indicator(samples, label)),
            Grid::Evidence => {
                let mut evidence = volume::evidence(samples, self.contents.sections);
                let values = evidence.values.iter_mut().chain(&mut evidence.tile_values);
                values.for_each(|value| *value *= self.scale as f32);
                self.add_volume(&name, &evidence)
            }
            Grid::Margin => self.add_volume(&name, &volume::margin(samples)),
        }?;
        self.describe(grid)
    }

    /// The distance to the surface of the union of some labels.
    fn add_level_set(&mut self, name: &str, within: impl Fn(Label) -> bool + Sync) -> Result<()> {
        let triangles = self.contents.mesh.triangles_around(within);
        if let Some((same, _)) = self.level_sets.iter().find(|(_, other)| *other == triangles) {
            return ffi::add_alias(self.volumes.pin_mut(), same, name).map_err(library);
        }
        let band = narrow_band(self.contents.lattice, &self.contents.mesh.vertices, &triangles);
        let (leaves, values) = (band.leaves().as_flattened(), band.values());
        ffi::add_level_set(self.volumes.pin_mut(), name, HALF_WIDTH, leaves, values)
            .map_err(library)?;
        self.level_sets.push((name.to_owned(), triangles));
        Ok(())
    }

    fn add_volume(&mut self, name: &str, volume: &Volume<f32>) -> Result<()> {
        add_volume(&mut self.volumes, name, volume)
    }

    fn add_density(&mut self, name: &str) -> Result<()> {
        // The name it has while it is no grid of its own.
        const BASIS: &str = "basis of density";
        self.add_level_set(BASIS, Label::is_material)?;
        ffi::add_fog(self.volumes.pin_mut(), BASIS, name).map_err(library)?;
        ffi::remove(self.volumes.pin_mut(), BASIS).map_err(library)?;
        self.level_sets.retain(|(name, _)| name != BASIS);
        Ok(())
    }

    fn describe(&mut self, grid: Grid) -> Result<()> {
        let name = self.name(grid);
        describe(&mut self.volumes, &name, self.contents.units, self.contents.frame, self.scale)?;
        let own = |material: &&Material| Some(Label(material.id)) == grid.label();
        if let Some(material) = self.contents.materials.iter().find(own) {
            let [r, g, b] = material.color;
            self.set_text(&name, "label", &material.id.to_string())?;
            self.set_text(&name, "label_name", &material.name)?;
            self.set_text(&name, "label_color", &format!("#{r:02x}{g:02x}{b:02x}"))?;
        }
        Ok(())
    }

    fn set_text(&mut self, grid: &str, key: &str, text: &str) -> Result<()> {
        ffi::set_text(self.volumes.pin_mut(), grid, key, text).map_err(library)
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
