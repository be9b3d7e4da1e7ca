//! Grids made from what is known at the nodes, one after the other.

use cxx::UniquePtr;

use super::{
    Field, FieldClass, Grid, Quantity, VdbContents, add_volume, describe, labels, library,
    volumes_on,
};
use crate::error::{Error, Remedy, Result};
use crate::ffi::vdb as ffi;
use crate::grid::distance::{HALF_WIDTH, narrow_band};
use crate::grid::labels::LabelGrid;
use crate::grid::volume::{self, Volume};
use crate::label::Label;

/// The largest number that a float of half precision can be.
const LARGEST_HALF: f32 = 65504.0;

/// Where all grids come together.
pub(super) struct Builder<'a> {
    contents: &'a VdbContents<'a>,
    pub volumes: UniquePtr<ffi::Volumes>,
    /// A world unit in units of the file.
    scale: f64,
    /// Whether files store half floats.
    half: bool,
    /// The grids that there are.
    pub fields: Vec<Field>,
    /// The names and triangles of the level sets there are.
    level_sets: Vec<(String, Vec<[u32; 3]>)>,
}

impl<'a> Builder<'a> {
    pub fn new(contents: &'a VdbContents, scale: f64, half: bool) -> Result<Self> {
        let volumes = volumes_on(contents.lattice, scale, half)?;
        Ok(Self { contents, volumes, scale, half, fields: Vec::new(), level_sets: Vec::new() })
    }

    pub fn add(&mut self, grid: &Grid) -> Result<()> {
        let (name, samples) = (grid.name.as_str(), self.contents.samples);
        let within = |label: Label| match grid.label {
            None => label.is_material(),
            Some(own) => label == own,
        };
        match grid.quantity {
            Quantity::Surface => self.add_level_set(name, within),
            Quantity::Density => self.add_density(name, within),
            Quantity::Mask => self.add_volume(name, &mask(&LabelGrid::new(samples), within)),
            Quantity::Label => {
                labels::add_labels(&mut self.volumes, name, &LabelGrid::new(samples))
            }
            Quantity::Indicator => {
                let label = grid.label.unwrap_or(Label::OUTSIDE);
                self.add_volume(name, &volume::indicator(samples, label))
            }
            Quantity::Evidence => {
                let mut evidence = volume::evidence(samples, self.contents.sections);
                let values = evidence.values.iter_mut().chain(&mut evidence.tile_values);
                values.for_each(|value| *value *= self.scale as f32);
                self.add_volume(name, &evidence)
            }
            Quantity::Margin => self.add_volume(name, &volume::margin(samples)),
        }?;
        self.describe(grid)
    }

    /// The distance to the surface of the union of some labels.
    fn add_level_set(&mut self, name: &str, within: impl Fn(Label) -> bool + Sync) -> Result<()> {
        let lattice = self.contents.lattice;
        self.require_half(name, (HALF_WIDTH * self.scale * lattice.voxel) as f32)?;
        let triangles = self.contents.mesh.triangles_around(within);
        if let Some((same, _)) = self.level_sets.iter().find(|(_, other)| *other == triangles) {
            return ffi::add_alias(self.volumes.pin_mut(), same, name).map_err(library);
        }
        let band = narrow_band(lattice, &self.contents.mesh.vertices, &triangles);
        let (leaves, values) = (band.leaves().as_flattened(), band.values());
        ffi::add_level_set(self.volumes.pin_mut(), name, HALF_WIDTH, leaves, values)
            .map_err(library)?;
        self.level_sets.push((name.to_owned(), triangles));
        Ok(())
    }

    fn add_volume(&mut self, name: &str, volume: &Volume<f32>) -> Result<()> {
        let values = volume.values.iter().chain(&volume.tile_values);
        self.require_half(name, values.fold(0.0, |all: f32, value| all.max(value.abs())))?;
        add_volume(&mut self.volumes, name, volume)
    }

    fn add_density(&mut self, name: &str, within: impl Fn(Label) -> bool + Sync) -> Result<()> {
        // The name it has while it is no grid of its own.
        const BASIS: &str = "basis of density";
        self.add_level_set(BASIS, within)?;
        ffi::add_fog(self.volumes.pin_mut(), BASIS, name).map_err(library)?;
        ffi::remove(self.volumes.pin_mut(), BASIS).map_err(library)?;
        self.level_sets.retain(|(name, _)| name != BASIS);
        Ok(())
    }

    /// Refuses what half precision cannot hold.
    fn require_half(&self, name: &str, largest: f32) -> Result<()> {
        if !self.half || largest <= LARGEST_HALF {
            return Ok(());
        }
        let what = format!(
            "the grid {name} has values of {largest}, and half floats end at {LARGEST_HALF}: leave \
             --half out, or use other units of length"
        );
        Err(Error::Option(what).avoidable(Remedy::OtherGrids))
    }

    fn describe(&mut self, grid: &Grid) -> Result<()> {
        let name = grid.name.as_str();
        describe(&mut self.volumes, name, self.contents.units, self.contents.frame, self.scale)?;
        let own = |material: &&crate::label::Material| Some(Label(material.id)) == grid.label;
        if let Some(material) = self.contents.materials.iter().find(own) {
            let [r, g, b] = material.color;
            self.set_text(name, "label", &material.id.to_string())?;
            self.set_text(name, "label_name", &material.name)?;
            self.set_text(name, "label_color", &format!("#{r:02x}{g:02x}{b:02x}"))?;
        }
        let class = match grid.quantity {
            Quantity::Surface => FieldClass::LevelSet,
            Quantity::Density => FieldClass::Fog,
            Quantity::Label => FieldClass::Numbers,
            _ => FieldClass::Values,
        };
        self.fields.push(Field { name: name.to_owned(), class, label: grid.label });
        Ok(())
    }

    fn set_text(&mut self, grid: &str, key: &str, text: &str) -> Result<()> {
        ffi::set_text(self.volumes.pin_mut(), grid, key, text).map_err(library)
    }
}

/// 1 at nodes of some labels, which outside is none of, 0 elsewhere.
fn mask(grid: &LabelGrid, within: impl Fn(Label) -> bool) -> Volume<f32> {
    let Volume { leaves, values, tiles, tile_values, .. } = volume::labels(grid);
    let one = |label: Label| f32::from(u8::from(within(label)));
    let values = values.into_iter().map(one).collect();
    let tiles = tiles.into_iter().zip(tile_values).filter(|&(_, label)| within(label));
    let tiles: Vec<[i32; 3]> = tiles.map(|(tile, _)| tile).collect();
    let tile_values = vec![1.0; tiles.len()];
    Volume { background: 0.0, leaves, values, tiles, tile_values }
}
