//! What a surface encloses, and how large it is.

use super::columns::{Columns, Grid};
use crate::error::{Error, Result};
use crate::label::Label;
use crate::mesh::{Mesh, Surface};
use crate::plane::Bounds;

/// A solid by its surface.
pub(super) struct Solid {
    /// What it is called in warnings.
    pub name: String,
    pub surface: Surface,
    pub bounds: Bounds,
    /// Whether all of the surface is closed and faces outward.
    is_outward: bool,
    /// Cubic world units.
    pub volume: f64,
    /// Square world units.
    pub area: f64,
}

impl Solid {
    /// All materials of a mesh as one.
    pub fn of_materials(mesh: &Mesh, name: &str, warnings: &mut Vec<String>) -> Result<Self> {
        Self::of_surface(mesh.surface_of(Label::is_material), name, warnings)
    }

    /// What a surface encloses; a warning where that is doubtful.
    pub fn of_surface(surface: Surface, name: &str, warnings: &mut Vec<String>) -> Result<Self> {
        let bounds = bounds(&surface, name)?;
        let facts = surface.facts(false)?;
        if !facts.closed {
            warnings.push(format!(
                "the {name} is not closed, or its triangles do not agree on which side is out: \
                 its volume is doubtful"
            ));
        } else if !facts.outward {
            warnings.push(format!(
                "the {name} faces inward in part: what it encloses counts as inside all the same"
            ));
        }
        let (volume, area, is_outward) = (facts.volume.abs(), facts.area, facts.outward);
        Ok(Self { name: name.to_owned(), surface, bounds, is_outward, volume, area })
    }

    /// Voxels of so much volume within their boundary.
    pub fn of_voxels(surface: Surface, volume: f64, name: &str) -> Result<Self> {
        let (bounds, area) = (bounds(&surface, name)?, surface.area());
        Ok(Self { name: name.to_owned(), surface, bounds, is_outward: true, volume, area })
    }

    /// What of a grid lies inside. Where the surface says no volume, the grid does.
    pub fn columns(&mut self, grid: &Grid, warnings: &mut Vec<String>) -> Columns {
        let (name, columns) = (&self.name, grid.columns(&self.surface));
        if columns.odd > 0 {
            warnings.push(format!(
                "{} of {} lines through the {name} leave it more or less often than they enter: \
                 it is not closed there",
                columns.odd,
                grid.count(),
            ));
        }
        let inside = columns.inside();
        if columns.overlapping > 0 {
            warnings.push(format!(
                "the {name} overlaps itself in {:.2} % of its volume, which counts once; areas and \
                 distances are of all of its surface",
                100.0 * columns.overlapping as f64 / inside as f64
            ));
        }
        if columns.overlapping > 0 || !self.is_outward {
            self.volume = grid.volume(inside);
        }
        columns
    }
}

fn bounds(surface: &Surface, name: &str) -> Result<Bounds> {
    let bounds = Bounds::around(surface.vertices.iter().copied());
    let nothing = || format!("the {name} has no surface: there is nothing to compare");
    bounds.ok_or_else(|| Error::Option(nothing()))
}
