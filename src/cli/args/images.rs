//! The arguments about images and volumes of labels that are read as sections.

use std::path::PathBuf;

use clap::{Args, ValueEnum};
use serde::Serialize;

use super::positive;
use crate::error::{Error, Result};
use crate::io::images::is_image;
use crate::io::volume::is_volume;
use crate::label_image::CurveOptions;
use crate::section::{ImageRules, Spacing, VolumeAxis};

#[derive(Debug, Clone, Args, Serialize)]
#[serde(rename_all = "kebab-case")]
pub struct ImageArguments {
    /// How far pixels in a row, rows, and slices of a stack of pictures are apart, in world units; DZ alone where the pictures say the rest. DZ is negative where later slices are nearer to whoever looks at them
    #[serde(skip_serializing_if = "Option::is_none", serialize_with = "as_given")]
    #[arg(long, value_name = "DX,DY,DZ|DZ", allow_hyphen_values = true, value_parser = spacing)]
    pub spacing_xyz: Option<Spacing>,
    /// Take the slices across this axis of a volume of labels: an axis of its voxels (i, j, k), or the one nearest to a coordinate's [default: where slices are drawn; in a full volume the one with the longest step]
    #[serde(skip_serializing_if = "Option::is_none")]
    #[arg(long, value_enum)]
    pub axis: Option<VolumeAxisName>,
    /// Take every Nth slice alone of a volume of labels or a stack of pictures, from the first that shows something
    #[serde(skip_serializing_if = "Option::is_none")]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..))]
    pub every: Option<u32>,
    /// Where a contour misses the border of pixels by more than this, in pixels, it follows it more closely, as far as --curve-support lets it [default: 0.75]
    #[serde(skip_serializing_if = "Option::is_none")]
    #[arg(long, value_name = "PIXELS", value_parser = positive)]
    pub curve_tolerance: Option<f64>,
    /// How far each piece of a contour reaches at least, in pixels; farther is smoother. Corners and thin parts are spared [default: 24]
    #[serde(skip_serializing_if = "Option::is_none")]
    #[arg(long, value_name = "PIXELS", value_parser = positive)]
    pub curve_support: Option<f64>,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum VolumeAxisName {
    I,
    J,
    K,
    X,
    Y,
    Z,
}

impl ImageArguments {
    /// Refuses what is about other files than there are.
    pub fn require_use(&self, files: &[PathBuf]) -> Result<()> {
        let has_pictures = files.iter().any(|file| file.is_dir() || is_image(file));
        let has_volume = files.iter().any(|file| is_volume(file));
        let refused = |what: &str| Err(Error::Option(what.to_owned()));
        if self.spacing_xyz.is_some() && !has_pictures {
            return refused(
                "--spacing-xyz is about stacks of pictures, and none is read: leave it out",
            );
        }
        if self.axis.is_some() && !has_volume {
            return refused("--axis is about volumes of labels, and none is read: leave it out");
        }
        if self.every.is_some() && !has_pictures && !has_volume {
            return refused(
                "--every is about volumes of labels and stacks of pictures, and none is read: \
                 leave it out",
            );
        }
        let curves = [("tolerance", self.curve_tolerance), ("support", self.curve_support)];
        let given = curves.iter().find(|(_, own)| own.is_some());
        if let Some((name, _)) = given.filter(|_| !has_pictures && !has_volume) {
            return refused(&format!(
                "--curve-{name} is about volumes of labels and stacks of pictures, and none is \
                 read: leave it out"
            ));
        }
        Ok(())
    }

    pub fn rules(&self) -> ImageRules {
        let axis = self.axis.map(|axis| match axis {
            VolumeAxisName::I => VolumeAxis::Voxels(0),
            VolumeAxisName::J => VolumeAxis::Voxels(1),
            VolumeAxisName::K => VolumeAxis::Voxels(2),
            VolumeAxisName::X => VolumeAxis::World(0),
            VolumeAxisName::Y => VolumeAxis::World(1),
            VolumeAxisName::Z => VolumeAxis::World(2),
        });
        let curves = CurveOptions::default();
        ImageRules {
            spacing: self.spacing_xyz,
            axis,
            every: self.every.map_or(1, |every| every as usize),
            curves: CurveOptions {
                tolerance: self.curve_tolerance.unwrap_or(curves.tolerance),
                support: self.curve_support.unwrap_or(curves.support),
            },
        }
    }
}

fn spacing(text: &str) -> std::result::Result<Spacing, String> {
    let numbers = text.split(',').map(|number| number.trim().parse::<f64>());
    let numbers = numbers.collect::<std::result::Result<Vec<f64>, _>>().unwrap_or_default();
    let is_apart = |z: f64| z.is_normal();
    match numbers[..] {
        [x, y, z] if x.is_normal() && x > 0.0 && y.is_normal() && y > 0.0 && is_apart(z) => {
            Ok(Spacing::All([x, y, z]))
        }
        [z] if is_apart(z) => Ok(Spacing::Slices(z)),
        _ => Err("DX,DY,DZ or DZ is needed: DX and DY are positive, DZ is not 0".to_owned()),
    }
}

fn as_given<S: serde::Serializer>(
    spacing: &Option<Spacing>,
    serializer: S,
) -> std::result::Result<S::Ok, S::Error> {
    match spacing {
        None => serializer.serialize_none(),
        Some(Spacing::All(all)) => all.serialize(serializer),
        Some(Spacing::Slices(z)) => serializer.serialize_f64(*z),
    }
}
