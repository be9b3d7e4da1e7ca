//! Where the voxels of an image are, whatever is in them.

use std::path::Path;

use super::write::Voxels;
use crate::error::{Error, Result};
use crate::io::{metaimage, nifti, nrrd};

/// The kinds of files of [`read_voxels`].
const KINDS: &str = ".nrrd, .nhdr, .nii, .nii.gz, .mha, .mhd";

/// Reads where the voxels of an image are.
///
/// # Errors
/// Where the file cannot be read, is damaged, or has not three axes.
pub fn read_voxels(path: &Path) -> Result<Voxels> {
    let name = path.file_name().unwrap_or_default().to_string_lossy().to_lowercase();
    let ends = |endings: &[&str]| endings.iter().any(|ending| name.ends_with(ending));
    let read = if ends(&[".nrrd", ".nhdr"]) {
        nrrd::read_voxels
    } else if ends(&[".nii", ".nii.gz"]) {
        nifti::read_voxels
    } else if ends(&[".mha", ".mhd"]) {
        metaimage::read_voxels
    } else {
        let what = format!("this kind of file is not known: voxels can be like those of {KINDS}");
        return Err(Error::file(path, what));
    };
    let bytes = crate::io::read_bytes(path)?;
    let voxels = read(&bytes).map_err(|what| Error::input(path, "the header", what))?;
    let count = voxels.dims.iter().try_fold(1usize, |all, &count| all.checked_mul(count));
    let steps = voxels.placement.steps;
    let spans = steps.determinant().abs().is_normal() && voxels.placement.origin.is_finite();
    if count.is_none_or(|count| count == 0) || !spans {
        let what = "its voxels span no volume: correct its sizes and directions";
        return Err(Error::input(path, "the header", what));
    }
    Ok(voxels)
}
