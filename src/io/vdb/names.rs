//! The names of grids, as users give them and as they are in files.

use std::str::FromStr;

use super::Grid;
use crate::error::{Error, Remedy, Result};
use crate::label::Material;

/// What the nodes of a grid hold.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Quantity {
    /// `surface`: the distance to a surface, as a level set.
    Surface,
    /// `density`: how much there is, from 0 to 1, as fog.
    Density,
    /// `mask`: 1 where something is, 0 elsewhere.
    Mask,
    /// `indicator`: a material's indicator.
    Indicator,
    /// `label`: the number of the material.
    Label,
    /// `evidence`: the distance to the nearest known part of a section.
    Evidence,
    /// `margin`: how far the label at a node leads over the second.
    Margin,
}

impl Quantity {
    const ALL: [Self; 7] = [
        Self::Surface,
        Self::Density,
        Self::Mask,
        Self::Indicator,
        Self::Label,
        Self::Evidence,
        Self::Margin,
    ];

    /// As it is in the names of grids.
    pub fn word(self) -> &'static str {
        match self {
            Self::Surface => "surface",
            Self::Density => "density",
            Self::Mask => "mask",
            Self::Indicator => "indicator",
            Self::Label => "label",
            Self::Evidence => "evidence",
            Self::Margin => "margin",
        }
    }

    /// Whether there is one of a single material.
    fn is_of_materials(self) -> bool {
        matches!(self, Self::Surface | Self::Density | Self::Mask | Self::Indicator)
    }

    /// Whether there is one of all materials together.
    fn is_of_all(self) -> bool {
        self != Self::Indicator
    }
}

/// What a grid is of.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Which {
    /// All materials together.
    Union,
    /// A grid for each material, called after its number.
    ByNumber,
    /// A grid for each material, called after its name.
    ByName,
    /// One material, by its number or its name.
    One(String),
}

/// Which grid, or which grids, to write.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct GridName {
    /// What is in it.
    pub quantity: Quantity,
    /// What it is of.
    pub which: Which,
}

/// What is written when nothing else is asked for. Some programs show the first grid of a file
/// only.
const DEFAULT: &str = "surface,density,label,surface_*,density_*";

/// Words for several grids: what a program makes something of, first what it looks for.
const PRESETS: [(&str, &str); 3] = [
    // Its shader of volumes looks for the density, and it has no use for whole numbers.
    ("blender", "density,density_{name},mask_{name}"),
    ("houdini", "surface,surface_{name},density,density_{name},mask_{name},label"),
    ("all", "surface,density,label,mask,surface_*,density_*,mask_*,indicator_*,evidence,margin"),
];

impl GridName {
    /// What is written when nothing else is asked for.
    pub fn default_ones() -> Vec<Self> {
        Self::parse_all(&DEFAULT.split(',').collect::<Vec<_>>()).unwrap_or_default()
    }

    /// The grids that words stand for: names of grids, and `blender`, `houdini`, `all` for those
    /// of use there; none for the ones that are written by default.
    ///
    /// # Errors
    /// When there is no such grid.
    pub fn parse_all<S: AsRef<str>>(words: &[S]) -> Result<Vec<Self>> {
        let mut all = Vec::new();
        for word in words.iter().map(|word| word.as_ref().trim()) {
            match PRESETS.iter().find(|(preset, _)| *preset == word) {
                Some((_, grids)) => {
                    all.extend(grids.split(',').map(str::parse).collect::<Result<Vec<_>>>()?);
                }
                None => all.push(word.parse()?),
            }
        }
        Ok(all)
    }
}

impl FromStr for GridName {
    type Err = Error;

    fn from_str(name: &str) -> Result<Self> {
        let unknown = || {
            Error::Option(format!(
                "there is no grid called {name:?}: the grids are surface, density, mask, label, \
                 evidence, margin, and surface_, density_, mask_ and indicator_ with the number or \
                 name of a material, * for the numbers of all or {{name}} for the names of all; \
                 blender, houdini and all stand for several"
            ))
        };
        let known = |word: &str| {
            Quantity::ALL.into_iter().find(|quantity| quantity.word() == word).ok_or_else(unknown)
        };
        let (quantity, which) = match name.split_once('_') {
            None => (known(name)?, Which::Union),
            Some((_, "")) => return Err(unknown()),
            Some((word, "*" | "{label}")) => (known(word)?, Which::ByNumber),
            Some((word, "{name}")) => (known(word)?, Which::ByName),
            Some((word, label)) => (known(word)?, Which::One(label.to_owned())),
        };
        let is_known = match which {
            Which::Union => quantity.is_of_all(),
            _ => quantity.is_of_materials(),
        };
        if is_known { Ok(Self { quantity, which }) } else { Err(unknown()) }
    }
}

/// The grids that names stand for, each once.
pub(super) fn resolve(names: &[GridName], materials: &[Material]) -> Result<Vec<Grid>> {
    let mut grids: Vec<Grid> = Vec::new();
    for GridName { quantity, which } in names {
        let numbered =
            |material: &Material| Grid::of(*quantity, material, &material.id.to_string());
        let named = |material: &Material| Grid::of(*quantity, material, &material.word());
        let wanted = match which {
            Which::Union => vec![Grid::of_all(*quantity)],
            Which::ByNumber => materials.iter().map(numbered).collect(),
            Which::ByName => materials.iter().map(named).collect(),
            Which::One(word) => {
                let material = find(word, materials)?;
                let is_number = word.parse() == Ok(material.id);
                vec![if is_number { numbered(material) } else { named(material) }]
            }
        };
        for grid in wanted {
            match grids.iter().find(|known| known.name == grid.name) {
                None => grids.push(grid),
                Some(same) if *same == grid => {}
                Some(Grid { label, .. }) => {
                    let labels = [*label, grid.label];
                    let [one, other] = labels.map(|label| label.map_or(0, |label| label.0));
                    let what = format!(
                        "labels {one} and {other} would both be the grid {}: call grids by numbers",
                        grid.name
                    );
                    return Err(Error::Option(what).avoidable(Remedy::OtherGrids));
                }
            }
        }
    }
    Ok(grids)
}

/// The material of a number or a name, where a number goes before a name.
fn find<'a>(word: &str, materials: &'a [Material]) -> Result<&'a Material> {
    let by_number = materials.iter().find(|material| word.parse() == Ok(material.id));
    let mut by_name = materials.iter().filter(|one| one.name == word || one.word() == word);
    by_number.or_else(|| by_name.next()).ok_or_else(|| {
        let known = materials.iter().map(|material| format!("{} ({})", material.id, material.name));
        let known: Vec<String> = known.collect();
        Error::Option(format!(
            "there is no grid for label {word}: the labels are {}",
            known.join(", ")
        ))
    })
}

/// The names that are of one material of these, or of none in particular.
pub(super) fn of_materials(names: &[GridName], materials: &[Material]) -> Vec<GridName> {
    let is_own = |grid: &&GridName| match &grid.which {
        Which::One(word) => find(word, materials).is_ok(),
        _ => true,
    };
    names.iter().filter(is_own).cloned().collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn materials() -> Vec<Material> {
        let material = |id, name: &str| Material { id, name: name.to_owned(), color: [0; 3] };
        vec![material(3, "Left lung"), material(7, "3")]
    }

    fn resolved(names: &str) -> Result<Vec<(String, Option<u32>)>> {
        let names = GridName::parse_all(&names.split(',').collect::<Vec<_>>())?;
        let grids = resolve(&names, &materials())?;
        Ok(grids.into_iter().map(|grid| (grid.name, grid.label.map(|label| label.0))).collect())
    }

    fn named(all: &[(&str, Option<u32>)]) -> Result<Vec<(String, Option<u32>)>> {
        Ok(all.iter().map(|(name, label)| ((*name).to_owned(), *label)).collect())
    }

    #[test]
    fn grids_are_by_number_or_by_name() {
        let both = named(&[("surface_3", Some(3)), ("surface_7", Some(7))]);
        assert_eq!(resolved("surface_*"), both);
        assert_eq!(resolved("surface_{label},surface_3, surface_7"), both);
        for word in ["Left lung", "Left_lung"] {
            let of_name = named(&[("density_Left_lung", Some(3)), ("label", None)]);
            assert_eq!(resolved(&format!("density_{word},label")), of_name);
        }
        // A number goes before a name.
        assert_eq!(resolved("mask_3"), named(&[("mask_3", Some(3))]));
        assert_eq!(
            resolved("mask_{name}"),
            named(&[("mask_Left_lung", Some(3)), ("mask_3", Some(7))])
        );
    }

    #[test]
    fn what_is_not_there_is_refused_and_no_two_grids_share_a_name() {
        for wrong in ["Surface", "label_3", "indicator", "surface_", "evidence_*", ""] {
            let error = resolved(wrong).unwrap_err().to_string();
            assert!(error.contains(&format!("{wrong:?}")), "{error}");
        }
        let error = resolved("surface_Kidney").unwrap_err().to_string();
        assert!(error.contains("3 (Left lung), 7 (3)"), "{error}");
        let error = resolved("mask_*,mask_{name}").unwrap_err().to_string();
        assert!(error.contains("labels 3 and 7 would both be the grid mask_3"), "{error}");
    }

    #[test]
    fn presets_have_no_whole_numbers_where_these_are_of_no_use() {
        let blender = resolved("blender").unwrap();
        assert_eq!(blender[0].0, "density");
        assert!(blender.iter().all(|(name, _)| name != "label"), "{blender:?}");
        assert!(resolved("all").unwrap().len() > resolved("houdini").unwrap().len());
        assert_eq!(GridName::default_ones().len(), 5);
    }
}
