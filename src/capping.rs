//! How a solid ends beyond the outermost sections: what the field is made from, and
//! where its samples are cut off.

use std::borrow::Cow;

use crate::error::Result;
use crate::grid::clip::clip;
use crate::grid::samples::Samples;
use crate::label::Label;
use crate::method::Caps;
use crate::plane::{Bounds, Plane};
use crate::section::Section;
use crate::section::ends::ends;
use crate::variational::specks::remove_specks;

/// How much of an end's reach is the solid's: midway to where the box ends, or to the
/// next section if one is there and shows nothing.
const MIDWAY: f64 = 0.5;
/// Without caps the solid goes on beyond the last section by so many voxels: its
/// surface then passes this section's plane, and can be held against it.
const LEDGE: f64 = 0.5;

/// The ends of some sections, capped.
#[derive(Debug)]
pub struct Capping<'a> {
    /// The sections. With flat caps their ends come once more, where the solid ends:
    /// on the way there it is as the last section shows it. Without caps they do not: a
    /// copy asks for walls at a right angle to the last section, and what tapers there
    /// would be bent.
    pub sections: Cow<'a, [Section]>,
    /// Where the solid is cut off, the normals pointing away from it.
    cuts: Vec<Plane>,
}

impl<'a> Capping<'a> {
    /// How sections end, on a grid with voxels of this size. In an open box they do not.
    ///
    /// # Errors
    /// Where contours touch in ways that rounding takes apart.
    pub fn new(sections: &'a [Section], caps: Caps, border: Label, voxel: f64) -> Result<Self> {
        let mut capping = Self { sections: Cow::from(sections), cuts: Vec::new() };
        if caps == Caps::Rounded || border == Label::UNKNOWN {
            return Ok(capping);
        }
        for end in ends(sections) {
            let midway = MIDWAY * end.reach;
            let cut = if caps == Caps::Flat { midway } else { midway.min(LEDGE * voxel) };
            capping.cuts.push(end.beyond(cut));
            if caps == Caps::Flat {
                capping.sections.to_mut().extend(end.repeated(sections, midway)?);
            }
        }
        Ok(capping)
    }

    /// Whether anything is cut off.
    pub fn is_cut(&self) -> bool {
        !self.cuts.is_empty()
    }

    /// Cuts samples off, and removes the pieces that a repeated section alone speaks
    /// for; returns how many there were. `sections` are those without repetition.
    pub fn cut(&self, samples: &mut Samples, sections: &[Section], bounds: Bounds) -> usize {
        clip(samples, &self.cuts);
        let is_repeated = self.sections.len() > sections.len();
        if is_repeated { remove_specks(samples, sections, bounds) } else { 0 }
    }
}
