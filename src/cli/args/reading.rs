//! The arguments about how files of sections are read.

use std::path::PathBuf;

use clap::{Args, ValueEnum};
use serde::Serialize;

use super::ImageArguments;
use crate::error::Error;
use crate::io::structures::{Chosen, several};
use crate::io::{is_layered, read_layers, units};
use crate::label::Label;
use crate::section::{Overlap, Rules, Sections};

#[derive(Debug, Args)]
pub struct InputArguments {
    /// Section files: .csl, .contour, .json, .jser, .obj (polylines), .vtp (lines); a structure set or segmentation (DICOM RTSTRUCT, SEG); volumes of labels: .nrrd, .nhdr, .nii, .nii.gz, .mha, .mhd; or stacks of pictures whose pixels are labels: .png, .tif, or a folder of them
    #[arg(required = true, value_name = "SECTIONS")]
    pub sections: Vec<PathBuf>,
    #[command(flatten)]
    pub reading: ReadingArguments,
    #[command(flatten)]
    pub structures: StructureArguments,
}

#[derive(Debug, Args)]
pub struct StructureArguments {
    /// Read these structures of a structure set alone, by name or number [default: all, each a solid of its own]
    #[arg(long, value_name = "NAME,...", value_delimiter = ',')]
    pub structures: Vec<String>,
    /// Let the structures of a structure set exclude each other: where two overlap, what is in both belongs to the one named first here; those not named follow, the smallest first
    #[arg(long, value_name = "NAME,...", num_args = 0.., require_equals = true, value_delimiter = ',')]
    pub partition: Option<Vec<String>>,
}

impl StructureArguments {
    fn chosen(&self) -> Chosen {
        Chosen { names: self.structures.clone(), partition: self.partition.clone() }
    }

    /// Refuses what is about other files than there are.
    fn require_use(&self, files: &[PathBuf]) -> crate::error::Result<()> {
        let given = [
            ("--structures", !self.structures.is_empty()),
            ("--partition", self.partition.is_some()),
        ];
        match given.into_iter().find(|(_, is_given)| *is_given) {
            Some((option, _)) if !files.iter().any(|file| is_layered(file)) => {
                Err(Error::Option(format!(
                    "{option} is about structure sets (DICOM) and segmentations in layers, and none is \
                     read: leave it out"
                )))
            }
            _ => Ok(()),
        }
    }
}

impl InputArguments {
    /// Sections in which labels exclude each other.
    pub fn read(&self) -> crate::error::Result<Sections> {
        let mut layers = self.read_layers()?;
        match (layers.pop(), layers.is_empty()) {
            (Some(only), true) => Ok(only),
            (last, _) => Err(several(&self.sections, layers.len() + usize::from(last.is_some()))),
        }
    }

    /// The same in layers, which may overlap.
    pub fn read_layers(&self) -> crate::error::Result<Vec<Sections>> {
        self.reading.images.require_use(&self.sections)?;
        self.structures.require_use(&self.sections)?;
        read_layers(&self.sections, &self.structures.chosen(), &self.reading.rules())
    }
}

#[derive(Debug, Clone, Args, Serialize)]
#[serde(rename_all = "kebab-case")]
pub struct ReadingArguments {
    /// Turn every warning into an error
    #[arg(long)]
    pub strict: bool,
    /// Who wins where loops of different labels overlap, instead of an error
    #[arg(long, value_enum)]
    pub overlap: Option<OverlapName>,
    /// The label that means unknown in these files; 0 leaves only materials known
    #[arg(long, value_name = "ID", value_parser = clap::value_parser!(u32).range(..i64::from(u32::MAX)))]
    pub unknown_label: Option<u32>,
    /// Vertices and edges of a section that are nearer to one another than this, in world units, are the same; 0 takes every drawing as it is [default: 1e-8 of the diagonal of a file's vertices]
    #[serde(skip_serializing_if = "Option::is_none")]
    #[arg(long, value_name = "LENGTH", value_parser = length)]
    pub tolerance: Option<f64>,
    /// The unit of all lengths in these files, as mm, cm, m, um, in: what .glb, .3mf and .dcm go by [default: what the files say; where they say nothing, millimetres]
    #[serde(skip_serializing_if = "Option::is_none")]
    #[arg(long, value_name = "UNIT", value_parser = unit)]
    pub unit: Option<&'static str>,
    #[command(flatten)]
    #[serde(flatten)]
    pub images: ImageArguments,
}

impl ReadingArguments {
    pub fn rules(&self) -> Rules {
        let overlap = self.overlap.map(|name| match name {
            OverlapName::First => Overlap::First,
            OverlapName::Last => Overlap::Last,
            OverlapName::Smallest => Overlap::Smallest,
        });
        let unknown = self.unknown_label.map(Label);
        let images = self.images.rules();
        let (snapping, unit, strict) = (self.tolerance, self.unit, self.strict);
        Rules { overlap, unknown, snapping, unit, strict, images, ..Rules::default() }
    }
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum OverlapName {
    First,
    Last,
    Smallest,
}

fn length(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(number) if number.is_finite() && number >= 0.0 => Ok(number),
        _ => Err("a length of 0 or more is needed".to_owned()),
    }
}

/// A unit of length by one of its names.
fn unit(text: &str) -> Result<&'static str, String> {
    let known = units::known(text).map(|(sign, _)| sign);
    known.ok_or_else(|| format!("a unit of length is needed: {}", units::signs().join(", ")))
}
