//! Volumes of labels, or of distances to them, as files.

use std::io::{Result, Write};
use std::path::Path;

use glam::{DMat3, DVec3};

use crate::io::{metaimage, nifti, nrrd, vtk};
use crate::label::Material;
use crate::volume::Placement;

/// A kind of file for volumes.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum VolumeKind {
    /// NRRD, packed, with the names and colours that 3D Slicer reads.
    Nrrd,
    /// A segmentation of 3D Slicer, the same; layers may overlap.
    SegNrrd,
    /// NIfTI-1; packed or not.
    Nifti {
        /// Whether by gzip.
        packed: bool,
    },
    /// MetaImage, packed.
    MetaImage,
    /// VTK's image, for ParaView.
    Vti,
}

impl VolumeKind {
    /// From the ending of a file's name, in either case.
    pub fn of(path: &Path) -> Option<Self> {
        let name = path.file_name()?.to_string_lossy().to_lowercase();
        let kinds = [
            (".seg.nrrd", Self::SegNrrd),
            (".nrrd", Self::Nrrd),
            (".nii", Self::Nifti { packed: false }),
            (".nii.gz", Self::Nifti { packed: true }),
            (".mha", Self::MetaImage),
            (".vti", Self::Vti),
        ];
        kinds.into_iter().find(|(ending, _)| name.ends_with(ending)).map(|(_, kind)| kind)
    }

    /// Whether numbers need not be labels.
    pub fn has_distances(self) -> bool {
        self != Self::SegNrrd
    }

    /// Whether a voxel can be in several layers.
    pub fn has_layers(self) -> bool {
        self == Self::SegNrrd
    }
}

/// Where the voxels of a file are.
#[derive(Debug, Clone, PartialEq)]
pub struct Voxels {
    /// How many along each axis.
    pub dims: [usize; 3],
    /// Where their centres are.
    pub placement: Placement,
    /// The unit of length; empty when unknown.
    pub units: String,
    /// The frame of the coordinates; empty when unknown.
    pub frame: String,
}

/// Voxels that each have one number.
#[derive(Debug, Clone, PartialEq)]
pub struct VoxelLayer {
    /// The materials that are in it.
    pub materials: Vec<Material>,
    /// The numbers; the first axis runs fastest.
    pub numbers: Numbers,
}

/// What voxels are about.
#[derive(Debug, Clone, PartialEq)]
pub enum Numbers {
    /// The label of each.
    Labels(Vec<u32>),
    /// How far each is from a surface, in world units, less than zero inside.
    Distances(Vec<f32>),
}

impl Numbers {
    /// How many there are.
    pub fn len(&self) -> usize {
        match self {
            Self::Labels(labels) => labels.len(),
            Self::Distances(distances) => distances.len(),
        }
    }

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// The labels; none where numbers are distances.
    pub(in crate::io) fn labels(&self) -> &[u32] {
        match self {
            Self::Labels(labels) => labels,
            Self::Distances(_) => &[],
        }
    }
}

/// The types of numbers in files.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(in crate::io) enum Type {
    U8,
    U16,
    U32,
    F32,
}

impl Type {
    /// The smallest one that holds what layers have: bytes of one label.
    pub fn of(layers: &[VoxelLayer]) -> Self {
        if layers.iter().any(|layer| matches!(layer.numbers, Numbers::Distances(_))) {
            return Self::F32;
        }
        let labels = layers.iter().flat_map(|layer| &layer.materials).map(|material| material.id);
        match labels.max().unwrap_or(0) {
            0..=0xff => Self::U8,
            0x100..=0xffff => Self::U16,
            _ => Self::U32,
        }
    }

    /// How many bytes a number has.
    pub fn size(self) -> usize {
        match self {
            Self::U8 => 1,
            Self::U16 => 2,
            Self::U32 | Self::F32 => 4,
        }
    }

    /// The word for it among four, of these types.
    pub fn word(self, [u8, u16, u32, f32]: [&'static str; 4]) -> &'static str {
        match self {
            Self::U8 => u8,
            Self::U16 => u16,
            Self::U32 => u32,
            Self::F32 => f32,
        }
    }
}

/// Writes a volume: one layer, or several where the kind [has them](VolumeKind::has_layers).
///
/// # Errors
/// What the writer says, and where a number does not fit into the format.
pub fn write_volume(
    kind: VolumeKind,
    voxels: &Voxels,
    layers: &[VoxelLayer],
    out: &mut dyn Write,
) -> Result<()> {
    let has_distances =
        layers.iter().any(|layer| Type::of(std::slice::from_ref(layer)) == Type::F32);
    match (kind, layers) {
        _ if has_distances && !kind.has_distances() => {
            Err(std::io::Error::other("this kind of file has room for labels alone"))
        }
        (VolumeKind::SegNrrd, _) | (VolumeKind::Nrrd, [_]) => nrrd::write(voxels, layers, out),
        (VolumeKind::Nifti { packed }, [only]) => nifti::write(voxels, only, packed, out),
        (VolumeKind::MetaImage, [only]) => metaimage::write(voxels, only, out),
        (VolumeKind::Vti, [only]) => vtk::write_image(voxels, only, out),
        _ => Err(std::io::Error::other("this kind of file has room for one layer")),
    }
}

/// Writes numbers of a type, little endian.
pub(in crate::io) fn write_numbers(
    numbers: &Numbers,
    kind: Type,
    out: &mut dyn Write,
) -> Result<()> {
    match numbers {
        Numbers::Labels(labels) => write_labels(labels.iter().copied(), kind, out),
        Numbers::Distances(distances) => {
            write_bytes(distances.iter().map(|distance| distance.to_le_bytes()), 4, out)
        }
    }
}

/// Writes labels as numbers of a type, little endian.
pub(in crate::io) fn write_labels(
    labels: impl Iterator<Item = u32>,
    kind: Type,
    out: &mut dyn Write,
) -> Result<()> {
    write_bytes(labels.map(u32::to_le_bytes), kind.size(), out)
}

/// Writes the first bytes of numbers.
fn write_bytes(
    numbers: impl Iterator<Item = [u8; 4]>,
    size: usize,
    out: &mut dyn Write,
) -> Result<()> {
    // Not a call for every voxel.
    let mut buffer = Vec::with_capacity(1 << 16);
    for bytes in numbers {
        buffer.extend_from_slice(&bytes[..size]);
        if buffer.len() >= (1 << 16) - 4 {
            out.write_all(&buffer)?;
            buffer.clear();
        }
    }
    out.write_all(&buffer)
}

/// The same voxels in another frame, of those that differ by the directions of their axes; as they
/// are where either is unknown or something else.
pub(crate) fn in_frame(placement: Placement, from: &str, to: &str) -> Placement {
    let turn = turn(from, to).unwrap_or(DVec3::ONE);
    let matrix = DMat3::from_diagonal(turn);
    Placement { origin: turn * placement.origin, steps: matrix * placement.steps }
}

/// The factors of coordinates from one frame to another, where both are known: LPS and the like,
/// whose letters say where each axis goes.
pub(crate) fn turn(from: &str, to: &str) -> Option<DVec3> {
    let axes = |frame: &str| -> Option<[f64; 3]> {
        let mut letters = frame.chars().map(|letter| letter.to_ascii_uppercase());
        let mut sign = |positive: char, negative: char| match letters.next() {
            Some(letter) if letter == positive => Some(1.0),
            Some(letter) if letter == negative => Some(-1.0),
            _ => None,
        };
        let signs = [sign('L', 'R')?, sign('P', 'A')?, sign('S', 'I')?];
        letters.next().is_none().then_some(signs)
    };
    let (from, to) = (axes(from)?, axes(to)?);
    Some(DVec3::from(from) * DVec3::from(to))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn frames_differ_by_signs() {
        assert_eq!(turn("LPS", "RAS"), Some(DVec3::new(-1.0, -1.0, 1.0)));
        assert_eq!(turn("LAS", "LPS"), Some(DVec3::new(1.0, -1.0, 1.0)));
        assert_eq!(turn("LPS", "LPS"), Some(DVec3::ONE));
        assert_eq!(turn("", "LPS"), None);
        assert_eq!(turn("SLP", "LPS"), None);
        let placement = Placement { origin: DVec3::ONE, steps: DMat3::IDENTITY };
        let moved = in_frame(placement, "LPS", "RAS");
        assert_eq!(moved.origin, DVec3::new(-1.0, -1.0, 1.0));
        assert_eq!(moved.steps.col(1), DVec3::NEG_Y);
        assert_eq!(in_frame(placement, "", "RAS"), placement);
    }

    #[test]
    fn the_kind_follows_from_the_name() {
        let of = |name: &str| VolumeKind::of(Path::new(name));
        assert_eq!(of("a.SEG.nrrd"), Some(VolumeKind::SegNrrd));
        assert_eq!(of("a.nrrd"), Some(VolumeKind::Nrrd));
        assert_eq!(of("b/a.nii.gz"), Some(VolumeKind::Nifti { packed: true }));
        assert_eq!(of("a.gz"), None);
    }
}
