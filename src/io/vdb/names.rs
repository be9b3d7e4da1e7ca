//! The names of grids, as users give them.

use std::str::FromStr;

use super::Grid;
use crate::error::{Error, Result};
use crate::label::{Label, Material};

/// Which materials a grid is written for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Which {
    /// One grid for each.
    All,
    /// A grid for one.
    One(Label),
}

/// Which grid, or which grids, to write.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum GridName {
    /// `surface`: the distance to the surface of all materials' union.
    Surface,
    /// `density`: how much of anything there is, from 0 to 1.
    Density,
    /// `label`: the number of the material.
    Label,
    /// `surface_<label>`, or `surface_*`: the distance to a material's surface.
    SurfaceOf(Which),
    /// `indicator_<label>`, or `indicator_*`: a material's indicator.
    IndicatorOf(Which),
    /// `evidence`: the distance to the nearest known part of a section.
    Evidence,
    /// `margin`: how far the label at a node leads over the second.
    Margin,
}

impl GridName {
    /// What is written when nothing else is asked for. Some programs show the
    /// first grid of a file only.
    pub const DEFAULT: [Self; 4] =
        [Self::Surface, Self::Density, Self::Label, Self::SurfaceOf(Which::All)];
}

impl FromStr for GridName {
    type Err = Error;

    fn from_str(name: &str) -> Result<Self> {
        let unknown = || {
            Error::Option(format!(
                "there is no grid called {name:?}: the grids are surface, density, label, \
                 evidence, margin, surface_<label> and indicator_<label>, with * for every label"
            ))
        };
        let which = |label: &str| match label {
            "*" => Ok(Which::All),
            _ => match label.parse().map(Label) {
                Ok(label) if label.is_material() => Ok(Which::One(label)),
                _ => Err(unknown()),
            },
        };
        match name {
            "surface" => Ok(Self::Surface),
            "density" => Ok(Self::Density),
            "label" => Ok(Self::Label),
            "evidence" => Ok(Self::Evidence),
            "margin" => Ok(Self::Margin),
            _ => match name.split_once('_') {
                Some(("surface", label)) => Ok(Self::SurfaceOf(which(label)?)),
                Some(("indicator", label)) => Ok(Self::IndicatorOf(which(label)?)),
                _ => Err(unknown()),
            },
        }
    }
}

/// The grids that names stand for, each once.
pub(super) fn resolve(names: &[GridName], materials: &[Material]) -> Result<Vec<Grid>> {
    let mut grids = Vec::new();
    for name in names {
        match *name {
            GridName::Surface => grids.push(Grid::Surface),
            GridName::Density => grids.push(Grid::Density),
            GridName::Label => grids.push(Grid::Label),
            GridName::Evidence => grids.push(Grid::Evidence),
            GridName::Margin => grids.push(Grid::Margin),
            GridName::SurfaceOf(which) => {
                grids.extend(labels(which, materials)?.into_iter().map(Grid::SurfaceOf));
            }
            GridName::IndicatorOf(which) => {
                grids.extend(labels(which, materials)?.into_iter().map(Grid::IndicatorOf));
            }
        }
    }
    let mut distinct = Vec::with_capacity(grids.len());
    for grid in grids {
        if !distinct.contains(&grid) {
            distinct.push(grid);
        }
    }
    Ok(distinct)
}

fn labels(which: Which, materials: &[Material]) -> Result<Vec<Label>> {
    let all = materials.iter().map(|material| Label(material.id));
    match which {
        Which::All => Ok(all.collect()),
        Which::One(label) if all.clone().any(|known| known == label) => Ok(vec![label]),
        Which::One(label) => {
            let known: Vec<String> = all.map(|known| known.to_string()).collect();
            Err(Error::Option(format!(
                "there is no grid for label {label}: the labels are {}",
                known.join(", ")
            )))
        }
    }
}
