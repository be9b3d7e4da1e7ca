//! Smoothing of a surface with the contours fixed (Bermano §4.6), by the energy of
//! the variational field.
//!
//! The mean-value indicator meets every section at a right angle, which makes beads
//! between parallel sections. They are as long as the sections are apart, so what
//! takes them away is a filter of that length, and no number of steps of a fixed
//! kernel: the field of a label minimises
//!
//! ```text
//! Σ ‖Hess f‖²  +  λ Σ (f − g)²  +  10 Σ_contours f²  +  10 Σ_planes max(0, m − σ f)²
//! ```
//!
//! where g is the signed distance to the surface as it was and λ = (voxel / ℓ)⁴
//! (`anchor`); the last two sums hold the sections. What is longer
//! than ℓ stays, shorter waves go unless a contour asks for them. ℓ is given in
//! distances between sections, so that it depends neither on the voxels nor on the
//! unit of the sections.

use glam::DVec3;
use rayon::prelude::*;

use crate::error::Result;
use crate::grid::evidence::Evidence;
use crate::grid::frame::Frame;
use crate::grid::samples::Samples;
use crate::label::Label;
use crate::mesh::{Mesh, dual};
use crate::method::Variational;
use crate::progress::{Progress, Silent};
use crate::section::Section;

use super::anchor::Original;
use super::backend::Backend;
use super::cpu::Cpu;
use super::label_field::Scene;
use super::{Effort, Kept, Solved, Space, scene, solve};

/// Points of the surface whose distance to the sections is taken, about.
const POINTS: usize = 20_000;
/// Between planes that are h apart distances to the nearest are spread evenly from
/// 0 to h / 2: half of them are below h / 4.
const SPACING_OF_MEDIAN: f64 = 4.0;

/// What is kept of smoothing for the next time.
#[derive(Debug)]
pub struct KeptSmoothing {
    /// ℓ, in world units.
    length: f64,
    fields: Kept,
}

/// Smooths samples: what is shorter than `strength` typical distances between
/// sections vanishes. With 0 they stay as they are. Pieces and bubbles that no section
/// speaks for are removed. What was `kept` saves work, and with `keeps` something is.
///
/// # Errors
/// When the surface has no area, or a backend fails; then nothing is kept.
pub fn smoothed(
    samples: &Samples,
    sections: &[Section],
    frame: &Frame,
    strength: f64,
    (keeps, kept): (bool, &mut Option<KeptSmoothing>),
    progress: &dyn Progress,
) -> Result<Solved> {
    let as_it_is = || Solved {
        samples: samples.clone(),
        effort: Effort::default(),
        specks: 0,
        device: Cpu::new().name(),
    };
    if strength == 0.0 {
        return Ok(as_it_is());
    }
    let mesh = dual(samples, &Silent)?;
    let length = strength * rounded(typical_spacing(&mesh, sections));
    if length == 0.0 {
        return Ok(as_it_is());
    }
    let original =
        Original { mesh: &mesh, length, open: samples.open, finest: samples.lattice.voxel };
    let mut fields = kept.take_if(|kept| kept.length == length).map(|kept| kept.fields);
    let solved = smoothed_mesh(samples, original, sections, frame, (keeps, &mut fields), progress)?;
    *kept = fields.map(|fields| KeptSmoothing { length, fields });
    Ok(solved)
}

/// The samples of a smoothed mesh.
fn smoothed_mesh(
    samples: &Samples,
    original: Original,
    sections: &[Section],
    frame: &Frame,
    (keeps, kept): (bool, &mut Option<Kept>),
    progress: &dyn Progress,
) -> Result<Solved> {
    let space = Space::new(frame, frame.bounds)?;
    let border = if samples.open.is_some() { Label::UNKNOWN } else { Label::OUTSIDE };
    let method = Variational { border, ..Variational::default() };
    let backend = Cpu::new();
    let scene =
        Scene { original: Some(original), ..scene(sections, &space, &method, &backend, progress) };
    solve(scene, (keeps, kept), "smoothing")
}

/// A spacing among those that are a quarter of a doubling apart: it does not change with
/// every section, nor does then what is smoothed far from it.
fn rounded(spacing: f64) -> f64 {
    if spacing > 0.0 { ((4.0 * spacing.log2()).round() / 4.0).exp2() } else { 0.0 }
}

/// How far sections are apart where the surface is, in world units: by the median
/// distance of its points to the nearest known part of a section. 0 without any.
fn typical_spacing(mesh: &Mesh, sections: &[Section]) -> f64 {
    let evidence = Evidence::new(sections);
    let step = mesh.vertices.len().div_ceil(POINTS).max(1);
    let distance = |&point: &DVec3| evidence.near(point, 0.0).distance(point);
    let mut distances: Vec<f64> =
        mesh.vertices.par_iter().step_by(step).filter_map(distance).collect();
    if distances.is_empty() {
        return 0.0;
    }
    let half = distances.len() / 2;
    let (_, median, _) = distances.select_nth_unstable_by(half, f64::total_cmp);
    SPACING_OF_MEDIAN * *median
}

#[cfg(test)]
mod tests;
