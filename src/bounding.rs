//! The box in which sections are reconstructed, given or as it follows from them, and what it
//! says.

use std::borrow::Cow;

use crate::error::{Error, Result};
use crate::grid::frame::Frame;
use crate::grid::lattice::Resolution;
use crate::label::Label;
use crate::method::{Hermite, MeanValue, Method, Variational};
use crate::model::Options;
use crate::plane::Bounds;
use crate::section::ends::stopped;
use crate::section::{Section, Sections, reach};

/// Of a given box: products of three are still numbers.
const LARGEST_COORDINATE: f64 = 1e75;

/// What the faces of a box that follows from the sections say.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Faces {
    /// That all is outside: they are kept away from contours.
    Outside,
    /// Nothing.
    Silent,
}

/// The box in which the surface closes, or which it may leave; so far beyond the contours if a
/// margin is given.
///
/// # Errors
/// When there is no contour, or nothing known at all, or for a margin that is no length.
pub(crate) fn bounds_of(sections: &Sections, margin: Option<f64>, faces: Faces) -> Result<Bounds> {
    sections.require_known()?;
    let space = match margin {
        None if faces == Faces::Outside => sections.space_of_cells(),
        None => sections.space(),
        Some(margin) if margin > 0.0 && margin < LARGEST_COORDINATE => {
            reach::bounds(&sections.sections).map(|around| around.grown(margin))
        }
        Some(margin) => {
            let what = format!(
                "the box's margin must be a positive length below {LARGEST_COORDINATE:e}, not \
                 {margin:e}"
            );
            return Err(Error::Option(what));
        }
    };
    let what = "there is nothing to reconstruct: no section has a contour";
    space.ok_or_else(|| Error::Option(what.to_owned()))
}

/// The given box.
///
/// # Errors
/// When it has no size that can be squared, when a contour leaves it, when a section lies in
/// one of its faces, where nothing is on its other side, or as [`bounds_of`].
fn require_within(sections: &Sections, bounds: Bounds) -> Result<Bounds> {
    bounds_of(sections, None, Faces::Silent)?;
    let Bounds { min, max } = bounds;
    let is_finite = min.is_finite() && max.is_finite();
    if !is_finite || min.abs().max(max.abs()).max_element() > LARGEST_COORDINATE {
        let what = format!(
            "the box from {min} to {max}: coordinates must be finite and below \
             {LARGEST_COORDINATE:e}"
        );
        return Err(Error::Option(what));
    }
    for section in &sections.sections {
        let points = || section.segments().flatten();
        let is_in_face = (0..3).any(|axis| {
            [min, max].iter().any(|end| points().all(|point| point[axis] == end[axis]))
        });
        let what = if points().any(|point| point.clamp(min, max) != point) {
            "leaves"
        } else if is_in_face && points().next().is_some() {
            "lies in a face of"
        } else {
            continue;
        };
        return Err(Error::Section {
            section: section.name().to_owned(),
            what: format!("it {what} the box from {min} to {max}: choose a larger box"),
        });
    }
    Ok(bounds)
}

/// The box, given or that of the sections, and the grid over it. That of an open box ends on its
/// faces, and the exact surface has none.
///
/// # Errors
/// As [`require_within`], [`bounds_of`] and [`Lattice::new`](crate::grid::samples::Lattice::new).
pub(crate) fn frame(sections: &Sections, options: &Options) -> Result<Frame> {
    let border = match options.method {
        Method::Variational(Variational { border, .. }) => Some(border),
        Method::MeanValue(MeanValue { border, .. }) => Some(border),
        Method::Hermite(Hermite { border, .. }) => Some(border),
        Method::Stack(_) => Some(Label::OUTSIDE),
        Method::Skeleton(_) => None,
    };
    if let Some(bounds) = options.bounds {
        return Frame::new(require_within(sections, bounds)?, options.resolution);
    }
    let is_outside = matches!(
        options.method,
        Method::MeanValue(MeanValue { border: Label::OUTSIDE, .. })
            | Method::Hermite(Hermite { border: Label::OUTSIDE, .. })
            | Method::Skeleton(_)
    );
    let faces = if is_outside { Faces::Outside } else { Faces::Silent };
    let bounds = bounds_of(sections, options.margin, faces)?;
    match (options.resolution, border) {
        (Resolution::VoxelSize(voxel), Some(Label::OUTSIDE)) => Frame::fixed(bounds, voxel),
        (resolution, _) => Frame::new(bounds, resolution),
    }
}

/// The sections that the cells of a box lie between: in a closed one what stops them, too.
///
/// # Errors
/// As [`stopped`].
pub(crate) fn bordered(
    sections: &[Section],
    bounds: Bounds,
    border: Label,
) -> Result<Cow<'_, [Section]>> {
    if border == Label::OUTSIDE { stopped(sections, bounds) } else { Ok(Cow::from(sections)) }
}

#[cfg(test)]
mod tests {
    use glam::DVec3;

    use super::*;
    use crate::check::shapes::disc;
    use crate::plane::Plane;

    #[test]
    fn a_margin_is_a_length() {
        let plane = Plane { normal: DVec3::Z, offset: 0.0 };
        let sections =
            Sections { sections: vec![disc(plane, 1.0, 8, Label(1))], ..Sections::default() };
        for margin in [0.0, -1.0, f64::NAN, 1e80] {
            let error = bounds_of(&sections, Some(margin), Faces::Silent).unwrap_err().to_string();
            assert!(error.contains("positive length below 1e75"), "{error}");
        }
        let found = bounds_of(&sections, Some(2.0), Faces::Silent).unwrap();
        assert_eq!((found.min.z, found.max.z), (-2.0, 2.0));
        assert!((found.max.x - 3.0).abs() < 1e-9, "{found:?}");
    }
}
