//! The field's surface against one that the user brings.

use serde::Serialize;

use super::gap::{Gap, Measured, gap};
use super::solids::Solid;
use crate::compare::{self, Comparison, compare};
use crate::error::{Error, Result};
use crate::label::Label;
use crate::mesh::Mesh;
use crate::progress::Progress;

/// A mesh of the user's.
#[derive(Debug, Clone)]
pub struct Other {
    /// Its file.
    pub file: String,
    /// Its triangles.
    pub mesh: Mesh,
}

/// How our surface and another differ; several materials count as one.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Against {
    /// The other's file.
    pub file: String,
    /// What the other's surface is like.
    pub solid: Solid,
    /// From ours to the other and back, in voxels; none where one has no
    /// triangle.
    pub gap: Option<Gap>,
    /// As `transect compare` says, the other being the reference; none where
    /// one of the two encloses no volume.
    pub comparison: Option<Comparison>,
    /// Why there is no comparison.
    pub refused: Option<String>,
}

/// Compares our surface with another one.
///
/// # Errors
/// When measuring fails.
pub fn against(ours: &Mesh, other: &Other, voxel: f64, progress: &dyn Progress) -> Result<Against> {
    let surface = |mesh: &Mesh| Measured::new(mesh.surface_of(Label::is_material));
    let gap = match (surface(ours)?, surface(&other.mesh)?) {
        (Some(one), Some(other)) => Some(gap(&one, &other, voxel)?.0),
        _ => None,
    };
    let (comparison, refused) =
        match compare(ours, &other.mesh, &compare::Options::default(), progress) {
            Ok(comparison) => (Some(comparison), None),
            Err(Error::Option(why)) => (None, Some(why)),
            Err(error) => return Err(error),
        };
    let solid = Solid::within(&other.mesh, Label::is_material)?;
    Ok(Against { file: other.file.clone(), solid, gap, comparison, refused })
}
