//! How images and volumes of labels are read as sections.

use crate::label_image::CurveOptions;

/// What files of images do not say themselves. The default is for files that do.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct ImageRules {
    /// How far pixels and slices are apart in a stack of pictures.
    pub spacing: Option<Spacing>,
    /// The axis whose slices a volume gives; without it the drawn ones.
    pub axis: Option<VolumeAxis>,
    /// Of the slices there are, every so many-th counts, from the first; 0 is 1.
    pub every: usize,
    /// How closely contours follow pixels.
    pub curves: CurveOptions,
}

/// How far pixels and slices of a stack of pictures are apart, in world units.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Spacing {
    /// Pixels in a row, rows, and slices. The last is negative where later slices are nearer to
    /// whoever looks at the pictures.
    All([f64; 3]),
    /// Slices alone; the files say how far pixels are apart.
    Slices(f64),
}

/// An axis of a volume of labels.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum VolumeAxis {
    /// That of the voxels with this number: 0 for the one that runs fastest in the file, to 2.
    Voxels(usize),
    /// The one along which voxels go most nearly as a coordinate does: 0 to 2 for x to z.
    World(usize),
}
