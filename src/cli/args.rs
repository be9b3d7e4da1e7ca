//! The arguments as text.

mod compare_methods;
mod convert;
mod images;
mod online;
mod reading;
mod slice;

use std::path::PathBuf;

use clap::{Args, Parser, Subcommand, ValueEnum};
use glam::DVec3;
use serde::{Serialize, Serializer};

use crate::error::Error;
use crate::field::Device;
use crate::field::hermite::Gradients;
use crate::grid::lattice::Resolution;
use crate::label::Label;
use crate::mesh::decimation::Decimation;
use crate::mesh::delaunay;
use crate::method::{Caps, Mesher};
use crate::model;
use crate::picture::{self, Viewpoint};

pub use compare_methods::CompareMethodsArguments;
pub use convert::ConvertArguments;
pub use images::ImageArguments;
pub use online::{FrameKind, OnlineArguments};
pub use reading::{InputArguments, ReadingArguments};
pub use slice::{AxisName, SliceArguments};

/// Volumes and surfaces from labelled planar cross-sections of any orientation.
#[derive(Debug, Parser)]
#[command(name = "transect", version, about, max_term_width = 100)]
pub struct Arguments {
    #[command(subcommand)]
    pub command: Command,
}

#[derive(Debug, Subcommand)]
pub enum Command {
    /// Turn sections into volumes, surfaces, pictures and a report
    Reconstruct(ReconstructArguments),
    /// Follow sections that come, change and go one by one
    Online(OnlineArguments),
    /// Cut a mesh or a volume of labels with planes into sections
    Slice(SliceArguments),
    /// Make parts of sections unknown, for experiments
    Mask(MaskArguments),
    /// Turn section files of any kind into one of another kind
    Convert(ConvertArguments),
    /// Tell what is in section files, and what is wrong with it
    Inspect(InspectArguments),
    /// Measure how far a mesh or a volume of labels is from a reference, label by label
    Compare(CompareArguments),
    /// Reconstruct sections by every method, and tell what each makes of them
    CompareMethods(CompareMethodsArguments),
    /// Reconstruct sections by a second, exact method, and tell where and by how much results differ
    Crosscheck(CrosscheckArguments),
}

#[derive(Debug, Args)]
pub struct ReconstructArguments {
    /// An output file, its kind by its name: .vdb, .nvdb, .usda (with the .vdb it shows), .ply, .vtp, .vtu, .vtm, .glb, .3mf, .obj, .stl, .off; volumes of labels: .nrrd, .seg.nrrd, .nii, .nii.gz, .mha, .vti; a structure set: .dcm; a picture: .png; a report to read: .html; can be repeated. A surface or volume of labels with {label} or {name} in its name is written once for each material
    #[arg(short, long, required_unless_present = "report", value_name = "FILE")]
    pub output: Vec<PathBuf>,
    #[command(flatten)]
    pub method: MethodArguments,
    /// Make the surface simpler, last of all: until 10% of its triangles are left, or, with a number that has no %, as far as it moves by no more than that in world units
    #[arg(long, value_name = "SHARE%|DISTANCE", value_parser = decimation)]
    pub decimate: Option<Decimation>,
    #[command(flatten)]
    pub threads: ThreadsArgument,
    #[command(flatten)]
    pub volumes: VolumeArguments,
    /// Give volumes of labels the voxels of this image: .nrrd, .nii, .nii.gz, .mha [default: the grid's nodes; of several structures as fine as --resolution on the longest side of all]
    #[arg(long, value_name = "IMAGE")]
    pub like: Option<PathBuf>,
    /// Put the contours of a structure set (.dcm) on the planes of this file: sections of any kind, or the slices of an image [default: those of the sections]
    #[arg(long, value_name = "FILE")]
    pub planes_like: Option<PathBuf>,
    /// With --method skeleton: write the surface with exact coordinates as JSON
    #[arg(long, value_name = "FILE.json")]
    pub exact: Option<PathBuf>,
    /// Write the report as JSON, or, when the name ends in .html, as a page to read, with pictures and the surfaces to turn
    #[arg(long, value_name = "FILE")]
    pub report: Option<PathBuf>,
    #[command(flatten)]
    pub picture: PictureArguments,
    #[command(flatten)]
    pub input: InputArguments,
    /// No progress, no warnings, no table
    #[arg(short, long)]
    pub quiet: bool,
}

/// What is in files of volumes.
#[derive(Debug, Clone, Args)]
pub struct VolumeArguments {
    /// Grids of a .vdb or .nvdb file, separated by commas: surface, density, mask, label, evidence, margin; surface_, density_, mask_ or indicator_ with a label's number or name, * for the numbers of all or {name} for their names; or blender, houdini, all for those of use there
    #[arg(
        long,
        value_name = "NAME,...",
        value_delimiter = ',',
        default_value = "surface,density,label,surface_*,density_*"
    )]
    pub grids: Vec<String>,
    /// Store the floats of a .vdb file in half precision, which takes half the space
    #[arg(long)]
    pub half: bool,
    /// What the voxels of other volumes hold: the label, or the signed distance to the label's surface, in world units and negative inside, with {label} or {name} in the file's name, else to that of all together
    #[arg(long, value_enum, default_value_t)]
    pub voxels: VoxelsName,
}

/// What voxels hold.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, ValueEnum)]
pub enum VoxelsName {
    #[default]
    Labels,
    Distances,
}

/// How a model is derived from its sections.
#[derive(Debug, Clone, Args, Serialize)]
#[serde(rename_all = "kebab-case")]
pub struct MethodArguments {
    /// How space between the sections is filled: variational is the smoothest field through the contours, mvc the mean-value indicator, hermite interpolates distances with their gradients, skeleton the nearest section, exactly, stack interpolates distances between parallel sections; auto chooses variational or stack by what the sections are, and says why
    #[arg(long, value_enum, default_value_t = MethodName::Variational)]
    pub method: MethodName,
    #[command(flatten)]
    #[serde(flatten)]
    pub grid: GridArguments,
    /// With --method mvc: how much ripples between sections are smoothed away, contours fixed: up to this many typical distances between sections; 0 keeps them [default: 1]
    #[arg(long, value_name = "STRENGTH", value_parser = strength)]
    pub smooth: Option<f64>,
    /// With --method mvc: how finely unknown regions are completed, with hermite how finely all of the sections is triangulated: the length of a triangle's side, in world units; with hermite no more than the default [default: 1/16 of what is drawn; with hermite 1/32]
    #[arg(long, value_name = "H", value_parser = positive)]
    pub spacing: Option<f64>,
    /// With --method hermite: the gradients of distances away from contours: none at all, those of the distance itself, the nearest contour's normal within its plane, or the surface's normal there [default: normals]
    #[arg(long, value_enum)]
    pub gradients: Option<GradientsName>,
    /// With --method hermite: whether finely cut regions count as much as others of their size (even), or less, as in the paper (uneven) [default: uneven]
    #[arg(long, value_enum)]
    pub density: Option<DensityName>,
    #[command(flatten)]
    #[serde(flatten)]
    pub meshing: MeshingArguments,
    /// What is on the faces of the box: outside closes every surface in it, unknown lets materials leave it [default: outside]
    #[serde(rename = "box")]
    #[arg(long = "box", value_name = "LABEL", value_enum)]
    pub border: Option<BorderName>,
    /// How a solid ends beyond the outermost sections: rounded as its field is, flat half a spacing beyond them, or on them (none). With --box unknown: flat closes surfaces in the box's faces, none leaves them open there [default: rounded; with --box unknown: none]
    #[arg(long, value_enum)]
    pub caps: Option<CapsName>,
    /// Where the field is evaluated: auto takes a real GPU when there is one; gpu takes a software adapter too [default: auto]
    #[arg(long, value_enum)]
    pub device: Option<DeviceName>,
    /// With --method skeleton: make the surface fair, contours fixed, with edges of this length in world units [default: 0.65 % of the box, whatever the resolution]
    #[serde(serialize_with = "length_or_none")]
    #[arg(long, value_name = "LENGTH", num_args = 0..=1, value_parser = positive)]
    pub fair: Option<Option<f64>>,
    /// With --method stack: connect parts that overlap nothing of their label on the next section with parts there that match when they are moved, by up to this distance in world units [default: twice the distance between the two sections]
    #[serde(serialize_with = "length_or_none")]
    #[arg(long, value_name = "DISTANCE", num_args = 0..=1, value_parser = positive)]
    pub link: Option<Option<f64>>,
}

/// Whether something is done, and with what length where that is given.
fn length_or_none<S: Serializer>(
    given: &Option<Option<f64>>,
    serializer: S,
) -> Result<S::Ok, S::Error> {
    match given {
        None => serializer.serialize_none(),
        Some(None) => serializer.serialize_bool(true),
        Some(Some(length)) => serializer.serialize_f64(*length),
    }
}

#[derive(Debug, Clone, Copy, Args, Serialize)]
#[serde(rename_all = "kebab-case")]
pub struct GridArguments {
    /// Voxels on the longest side of the box [default: 256]
    #[arg(long, value_name = "N", conflicts_with = "voxel_size",
          value_parser = clap::value_parser!(u32).range(4..))]
    pub resolution: Option<u32>,
    /// The side of a voxel, in world units. Wherever the box is, nodes are at odd multiples of its half, unless the box is given, open or smaller than 64 of them
    #[arg(long, value_name = "H", value_parser = positive)]
    pub voxel_size: Option<f64>,
    /// How far the box reaches beyond the contours, in world units [default: a spacing beyond the last section of a stack; to the sides a twentieth of the contours' diagonal, or with mvc, hermite and skeleton three quarters of the widest gap between sections]
    #[arg(long, value_name = "LENGTH", value_parser = positive)]
    pub margin: Option<f64>,
}

impl GridArguments {
    pub fn resolution(self) -> Resolution {
        match (self.voxel_size, self.resolution) {
            (Some(size), _) => Resolution::VoxelSize(size),
            (None, Some(voxels)) => Resolution::Voxels(voxels),
            (None, None) => model::Options::default().resolution,
        }
    }
}

#[derive(Debug, Clone, Args, Serialize)]
#[serde(rename_all = "kebab-case")]
pub struct MeshingArguments {
    /// How the surface is made from the grid: dual contouring, or Delaunay refinement, which is slower and makes well-shaped triangles
    #[arg(long, value_enum, default_value_t = MesherName::Dual)]
    pub mesher: MesherName,
    /// With the delaunay mesher: the smallest angle of triangles, except along junction curves [default: 30]
    #[arg(long, value_name = "DEG", value_parser = angle)]
    pub facet_angle: Option<f64>,
    /// With the delaunay mesher: the largest circumradius of triangles, in voxels [default: 2]
    #[arg(long, value_name = "V", value_parser = positive)]
    pub facet_size: Option<f64>,
    /// With the delaunay mesher: how far triangles may be from the surface, in voxels [default: 0.1]
    #[arg(long, value_name = "V", value_parser = positive)]
    pub facet_distance: Option<f64>,
}

impl MeshingArguments {
    pub fn mesher(&self) -> crate::error::Result<Mesher> {
        let own = [self.facet_angle, self.facet_size, self.facet_distance];
        match self.mesher {
            MesherName::Dual if own.iter().any(Option::is_some) => Err(Error::Option(
                "--facet-angle, --facet-size and --facet-distance need --mesher delaunay"
                    .to_owned(),
            )),
            MesherName::Dual => Ok(Mesher::Dual),
            MesherName::Delaunay => {
                let default = delaunay::Options::default();
                Ok(Mesher::Delaunay(delaunay::Options {
                    angle: self.facet_angle.unwrap_or(default.angle),
                    size: self.facet_size.unwrap_or(default.size),
                    distance: self.facet_distance.unwrap_or(default.distance),
                }))
            }
        }
    }
}

#[derive(Debug, Clone, Args)]
pub struct PictureArguments {
    /// Where a picture is taken from: front, back, left, right, top, bottom, several of them as front-left-top, an axis (-y), or the direction X,Y,Z towards the viewer [default: what shows most]
    #[arg(long, value_name = "DIRECTION", allow_hyphen_values = true)]
    pub view: Option<Viewpoint>,
    /// What is up in a picture, and becomes y in a .glb and .usda: an axis (z, -y) or a direction X,Y,Z [default: what the sections call up, else z]
    #[arg(long, value_name = "DIRECTION", allow_hyphen_values = true,
          value_parser = picture::parse_direction)]
    pub up: Option<DVec3>,
    /// Width and height of a picture in pixels, as W,H or WxH [default: 1600,1200]
    #[arg(long, value_name = "W,H", value_parser = picture_size)]
    pub size: Option<[u32; 2]>,
    /// Draw these materials alone, by number or name, with their contours
    #[arg(long, value_name = "LABEL,...", value_delimiter = ',')]
    pub labels: Vec<String>,
}

impl PictureArguments {
    /// Whether any is given that is about pictures alone.
    pub fn is_of_picture(&self) -> bool {
        let Self { view, up: _, size, labels } = self;
        view.is_some() || size.is_some() || !labels.is_empty()
    }
}

#[derive(Debug, Args)]
pub struct ThreadsArgument {
    /// Threads, no more than there are processors [default: as many]
    #[arg(long = "threads", value_name = "N",
          value_parser = clap::value_parser!(u32).range(1..))]
    pub count: Option<u32>,
}

#[derive(Debug, Args)]
#[command(group(clap::ArgGroup::new("parts").required(true).multiple(true)))]
pub struct MaskArguments {
    /// Random blobs that cover this part, between 0 and 1, of the rectangle around every section's contours
    #[arg(long, value_name = "FRACTION", group = "parts", value_parser = fraction)]
    pub blobs: Option<f64>,
    /// The size of blobs, relative to the rectangle's longer side
    #[arg(long, value_name = "PART", default_value_t = 0.2, requires = "blobs",
          value_parser = blob_size)]
    pub blob_size: f64,
    /// What the blobs are drawn from
    #[arg(long, value_name = "S", default_value_t = 0)]
    pub seed: u64,
    /// All beyond a frame of this width and height around the middle of every section's contours; width is measured along x where the plane allows
    #[arg(long, value_name = "W,H", group = "parts", value_parser = two_lengths)]
    pub extent: Option<[f64; 2]>,
    /// The section file to write: .json
    #[arg(short, long, value_name = "FILE.json")]
    pub output: PathBuf,
    #[command(flatten)]
    pub input: InputArguments,
    /// No warnings
    #[arg(short, long)]
    pub quiet: bool,
}

#[derive(Debug, Args)]
pub struct InspectArguments {
    /// Print JSON
    #[arg(long)]
    pub json: bool,
    #[command(flatten)]
    pub input: InputArguments,
}

#[derive(Debug, Args)]
pub struct CompareArguments {
    /// A closed mesh: .ply, .obj, .stl, .off; or a volume of labels: .nrrd, .seg.nrrd, .nhdr, .nii, .nii.gz, .mha, .mhd
    #[arg(value_name = "SOLID")]
    pub solid: PathBuf,
    /// What it is held against: either kind
    #[arg(value_name = "REFERENCE")]
    pub reference: PathBuf,
    /// Tell what part of the surfaces is no farther apart than this (surface Dice), in the reference's unit
    #[arg(long, value_name = "LENGTH", value_parser = positive)]
    pub tolerance: Option<f64>,
    /// Print JSON
    #[arg(long)]
    pub json: bool,
    /// No progress
    #[arg(short, long)]
    pub quiet: bool,
}

#[derive(Debug, Args)]
pub struct CrosscheckArguments {
    /// An output file, its kind by its name; can be repeated. .vdb: both labels, and how far from each node that differs they agree; .png: the field's surface coloured by its distance from the exact one
    #[arg(short, long, value_name = "FILE")]
    pub output: Vec<PathBuf>,
    /// Write the report as JSON
    #[arg(long, value_name = "FILE.json")]
    pub report: Option<PathBuf>,
    /// Print the report as JSON
    #[arg(long)]
    pub json: bool,
    /// Which field is held against the exact reconstruction; where the two must agree is known of mvc alone
    #[arg(long, value_enum, default_value_t = FieldName::Mvc)]
    pub method: FieldName,
    /// A mesh to hold our surface against: .ply, .obj, .stl, .off
    #[arg(long, value_name = "MESH")]
    pub against: Option<PathBuf>,
    /// Which meshers make the field's surface: dual always does, delaunay is held against it and is slow
    #[arg(
        long,
        value_enum,
        value_name = "NAME,...",
        value_delimiter = ',',
        default_value = "dual,delaunay"
    )]
    pub meshers: Vec<MesherName>,
    /// Random points at which both methods are asked
    #[arg(long, value_name = "N", default_value_t = 100_000,
          value_parser = clap::value_parser!(u32).range(..=100_000_000))]
    pub points: u32,
    /// What they are drawn from
    #[arg(long, value_name = "S", default_value_t = 0)]
    pub seed: u64,
    #[command(flatten)]
    pub grid: GridArguments,
    /// With --method mvc: how finely unknown regions are completed: the length of a triangle's side, in world units [default: 1/16 of the box]
    #[arg(long, value_name = "H", value_parser = positive)]
    pub spacing: Option<f64>,
    /// What is on the faces of the box: outside closes every surface in it, unknown lets materials leave it
    #[arg(long = "box", value_name = "LABEL", value_enum, default_value_t = BorderName::Outside)]
    pub border: BorderName,
    /// Where the field is evaluated: auto takes a real GPU when there is one; gpu takes a software adapter too
    #[arg(long, value_enum, default_value_t = DeviceName::Auto)]
    pub device: DeviceName,
    #[command(flatten)]
    pub threads: ThreadsArgument,
    #[command(flatten)]
    pub input: InputArguments,
    /// No progress, no warnings, no table
    #[arg(short, long)]
    pub quiet: bool,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum MethodName {
    Auto,
    Variational,
    Mvc,
    Hermite,
    Skeleton,
    Stack,
}

impl MethodName {
    /// As it is given.
    pub fn name(self) -> &'static str {
        match self {
            Self::Auto => "auto",
            Self::Variational => "variational",
            Self::Mvc => "mvc",
            Self::Hermite => "hermite",
            Self::Skeleton => "skeleton",
            Self::Stack => "stack",
        }
    }
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum GradientsName {
    None,
    Distance,
    InPlane,
    Normals,
}

impl From<GradientsName> for Gradients {
    fn from(name: GradientsName) -> Self {
        match name {
            GradientsName::None => Self::None,
            GradientsName::Distance => Self::Distance,
            GradientsName::InPlane => Self::InPlane,
            GradientsName::Normals => Self::Normals,
        }
    }
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum DensityName {
    Even,
    Uneven,
}

impl From<DensityName> for bool {
    fn from(name: DensityName) -> Self {
        name == DensityName::Even
    }
}

/// The methods that make a field on a grid.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum FieldName {
    Mvc,
    Variational,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum MesherName {
    Dual,
    Delaunay,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum BorderName {
    Outside,
    Unknown,
}

impl From<BorderName> for Label {
    fn from(name: BorderName) -> Self {
        match name {
            BorderName::Outside => Self::OUTSIDE,
            BorderName::Unknown => Self::UNKNOWN,
        }
    }
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum CapsName {
    Rounded,
    Flat,
    None,
}

impl From<CapsName> for Caps {
    fn from(name: CapsName) -> Self {
        match name {
            CapsName::Rounded => Self::Rounded,
            CapsName::Flat => Self::Flat,
            CapsName::None => Self::None,
        }
    }
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum DeviceName {
    Auto,
    Cpu,
    Gpu,
}

impl From<DeviceName> for Device {
    fn from(name: DeviceName) -> Self {
        match name {
            DeviceName::Auto => Self::Auto,
            DeviceName::Cpu => Self::Cpu,
            DeviceName::Gpu => Self::Gpu,
        }
    }
}

fn positive(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(number) if number.is_finite() && number > 0.0 => Ok(number),
        _ => Err("a positive number is needed".to_owned()),
    }
}

/// A share of triangles has a `%`, a distance has not.
fn decimation(text: &str) -> Result<Decimation, String> {
    let needed = "a share of triangles above 0% and up to 100%, as 10%, or a positive distance in \
                  world units is needed";
    let number = |text: &str| positive(text).map_err(|_| needed.to_owned());
    match text.strip_suffix('%') {
        Some(share) => match number(share.trim_end())? {
            share if share <= 100.0 => Ok(Decimation::Share(share / 100.0)),
            _ => Err(needed.to_owned()),
        },
        None => number(text).map(Decimation::Distance),
    }
}

fn strength(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(number) if (0.0..=100.0).contains(&number) => Ok(number),
        _ => Err("a number from 0 to 100 is needed".to_owned()),
    }
}

fn fraction(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(number) if number > 0.0 && number < 1.0 => Ok(number),
        _ => Err("a number between 0 and 1 is needed".to_owned()),
    }
}

fn blob_size(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(number) if (0.02..=1.0).contains(&number) => Ok(number),
        _ => Err("a number from 0.02 to 1 is needed".to_owned()),
    }
}

fn two_lengths(text: &str) -> Result<[f64; 2], String> {
    let lengths: Vec<f64> =
        text.split(',').map(|length| positive(length.trim())).collect::<Result<_, _>>()?;
    lengths.try_into().map_err(|_| "two lengths W,H are needed".to_owned())
}

fn picture_size(text: &str) -> Result<[u32; 2], String> {
    let sides = text.split([',', 'x']).map(|side| side.trim().parse::<u32>().ok());
    let size: Option<[u32; 2]> =
        sides.collect::<Option<Vec<_>>>().and_then(|sides| sides.try_into().ok());
    let [width, height] = size.ok_or("a width and a height in pixels, W,H, are needed")?;
    let (least, most) = (picture::SIDES.start(), picture::SIDES.end());
    if ![width, height].iter().all(|side| picture::SIDES.contains(side)) {
        return Err(format!("both sides must be from {least} to {most} pixels"));
    }
    if u64::from(width) * u64::from(height) > picture::MOST_PIXELS {
        let most = picture::MOST_PIXELS / 1_000_000;
        return Err(format!("a picture may have up to {most} million pixels"));
    }
    Ok([width, height])
}

fn angle(text: &str) -> Result<f64, String> {
    positive(text)
        .ok()
        .filter(|&angle| angle <= 30.0)
        .ok_or_else(|| "an angle above 0 and up to 30 degrees is needed".to_owned())
}
