//! Parallel sections, by interpolating distances (*shape-based interpolation*).
//!
//! S. Raya and J. Udupa, Shape-based interpolation of multidimensional objects, IEEE
//! Transactions on Medical Imaging 9, 1990; as in J. Marker, I. Braude, K. Museth, D. Breen,
//! Contour-based surface reconstruction using implicit curve fitting, and distance field
//! filtering and interpolation, Volume Graphics 2006.
//!
//! On every slice each label has the signed distance to its contours, exactly and at every pixel
//! (§2.2, [`slices`]); creases of it that are far from the contours are smoothed (§2.3,
//! [`filter`]); and along each column of pixels a cubic spline goes through them that does not
//! overshoot (§2.4, [`spline`]). The label with the largest value wins, so no gap opens between
//! labels. Where a slice shows nothing of a label that its neighbour shows, the label ends
//! about halfway; so it does beyond the first and the last slice, rounded with that radius.
//!
//! Two slices of a part that do not overlap are not connected, the limit that the paper names.
//!
//! ```text
//! sections ─► slices ─► filter ─► spline ─► field ─► grid::assembly ─► Samples
//! ```

mod field;
mod filter;
mod slices;
mod spline;

use glam::DVec3;

use crate::error::{Remedy, Result};
use crate::grid::assembly::assemble;
use crate::grid::contour::segments;
use crate::grid::frame::Frame;
use crate::grid::memory::require_bytes;
use crate::grid::samples::Samples;
use crate::grid::sampling::Starts;
use crate::label::Label;
use crate::progress::Progress;
use crate::section::{Section, reach};
use crate::variational::labels;

use field::StackField;
use slices::Slices;
use spline::Spline;

/// Of a pixel of every slice: its distance and its slope for a label, and besides what is said
/// there, and slopes twice while they are found.
const BYTES_PER_LABEL: u64 = 8;
const BYTES_PER_PIXEL: u64 = 8;

/// The samples of a stack in a box whose faces are outside.
///
/// # Errors
/// When sections are not a stack: not parallel, fewer than two, or partly unknown; or when their
/// images would not fit into memory.
pub(crate) fn stacked(
    sections: &[Section],
    frame: &Frame,
    progress: &dyn Progress,
) -> Result<Samples> {
    let lattice = frame.lattice;
    let slices = Slices::new(sections, &lattice)?;
    let materials = labels(sections);
    let count = slices.heights.len();
    let images = (BYTES_PER_LABEL * materials.len() as u64 + BYTES_PER_PIXEL) * count as u64;
    require_bytes(images.saturating_mul(slices.pixels() as u64), Remedy::CoarserLattice, || {
        format!("images of {count} slices for each of {} labels", materials.len())
    })?;
    progress.begin("field", materials.len() as u64);
    let drawn: Vec<Vec<Label>> = (0..count).map(|slice| slices.labels(slice)).collect();
    let spline = Spline::new(slices.heights.clone());
    let reaches = reach::reaches(sections);
    let radii = slices.ends().map(|end| 0.5 * reaches[end] / lattice.voxel);
    let mut fields = Vec::with_capacity(materials.len());
    for label in materials {
        let go_on = || progress.go_on();
        fields.push(StackField::new((&slices, &spline), label, &drawn, lattice, radii, go_on)?);
        progress.advance(1);
    }
    let contours: Vec<[DVec3; 2]> = sections.iter().flat_map(segments).collect();
    let starts = Starts::along(&contours, &lattice).leaves();
    Ok(assemble(fields, starts, lattice, None))
}
