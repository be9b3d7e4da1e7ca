//! Tracked sequences whose pixels are labels: each frame is a section that knows nothing beyond
//! its rectangle.

use std::path::Path;

use glam::{DMat4, DVec2, DVec3};
use rayon::prelude::*;

use super::page::Page;
use super::values::Values;
use super::{Raw, check};
use crate::error::{Error, Result};
use crate::io::metaimage::Frames;
use crate::label_image::{ImagePlacement, LabelImage};
use crate::section::{Findings, Rules, Section, Sections, Warning};
use crate::volume::{Shown, nth, shown};

/// So many pixels beyond the border of a frame repeat it while contours are found, so that these
/// run on over it.
const AROUND: usize = 4;

/// A frame in space.
struct Frame {
    number: usize,
    image: LabelImage,
    corners: [DVec3; 4],
}

/// Reads the frames that are OK.
///
/// # Errors
/// Where they hold no labels, or where it is not known where they lie.
pub fn sections(file: &Path, frames: &Frames, rules: &Rules) -> Result<Sections> {
    let &Frames { ref sequence, size, ref labels } = frames;
    let failed = |what: String| Error::file(file, what);
    if rules.images.axis.is_some() {
        let what = "an axis is chosen for volumes, and this is a sequence of frames";
        return Err(failed(what.to_owned()));
    }
    let facts = sequence.facts(String::new(), size);
    require_labels(size, labels).map_err(|what| {
        failed(format!("{what}; {} of its {} frames are OK", facts.ok, facts.frames))
    })?;
    let chain = sequence.chain().map_err(failed)?;
    let placed = sequence.matrices(&chain);
    let turn = turn(&sequence.orientation, size).map_err(failed)?;
    let pixels = size[0] * size[1];
    let of = |number: usize| labels.get(number * pixels..(number + 1) * pixels).unwrap_or_default();
    let filled: Vec<bool> =
        placed.iter().map(|&(number, _)| of(number).iter().any(|&label| label != 0)).collect();
    let kept: Vec<usize> = match shown(&filled) {
        Shown::Sparse(kept) => kept,
        Shown::Full(kept) => kept.collect(),
    };
    if !filled.contains(&true) {
        return Err(failed("all pixels of its frames are 0, which is outside".to_owned()));
    }
    let every = rules.images.every.max(1);
    let kept: Vec<(usize, DMat4)> = kept.iter().step_by(every).map(|&at| placed[at]).collect();
    require_motion(&kept, chain.world()).map_err(failed)?;
    let frames = kept.into_par_iter().map(|(number, matrix)| {
        frame(number, size, of(number), &(matrix * turn))
            .map_err(|what| failed(format!("frame {number}: {what}")))
    });
    let frames = frames.collect::<Result<Vec<Frame>>>()?;
    let note = format!(
        "a sequence of {} frames, {} of them OK, {} × {} pixels; placed by {chain}; {}{} with \
         labels become sections",
        sequence.count,
        placed.len(),
        size[0],
        size[1],
        if every > 1 { format!("every {} of those, ", nth(every)) } else { String::new() },
        frames.len(),
    );
    let lost = sequence.count - placed.len();
    let mut sections = checked(file, frames, rules)?;
    sections.notes.push(Warning { section: String::new(), what: note });
    if lost > 0 {
        let are = if lost == 1 { "frame is" } else { "frames are" };
        let what = format!("{lost} {are} not OK (the picture, or a transform of {chain})");
        sections.left_out.push(Warning { section: String::new(), what });
    }
    if sequence.orientation.is_empty() {
        let what = "nothing says which way its pictures lie (UltrasoundImageOrientation): taken as \
                    MF";
        super::warn(&mut sections, file, what.to_owned(), rules)?;
    }
    "mm".clone_into(&mut sections.units);
    chain.world().clone_into(&mut sections.frame);
    Ok(sections)
}

/// Makes sure that pixels are labels.
fn require_labels(size: [usize; 2], labels: &[u32]) -> std::result::Result<(), String> {
    let values = |values: &[u32]| {
        let page = Page {
            size,
            values: values.to_vec(),
            white: None,
            resolution: None,
            palette: Vec::new(),
        };
        Values::new(&page)
    };
    let all: Vec<_> = labels.par_chunks(size[0] * size[1]).map(values).collect();
    let all = all.into_iter().collect::<std::result::Result<Vec<_>, _>>();
    let words = |what| format!("it holds no labels: {what}");
    let all = all.map_err(words)?.into_iter().reduce(Values::sum).unwrap_or_default();
    all.require_labels().map_err(words)
}

/// From the pixels of a file to those that transforms are about, whose x goes to the marked side
/// of the probe and whose y goes away from it (MF), by the letters of a sequence: where its own x
/// and y go.
fn turn(orientation: &str, size: [usize; 2]) -> std::result::Result<DMat4, String> {
    let last = size.map(|count| count as f64 - 1.0);
    let mut turn = DMat4::IDENTITY;
    let letters = match orientation {
        "" | "XX" | "XXX" => "MF",
        known => known,
    };
    let letters: Vec<char> = letters.chars().collect();
    // Of pictures the third letter, across them, says nothing.
    let (first, second) = match letters[..] {
        [first, second] | [first, second, 'A' | 'D'] => (first, second),
        _ => ('?', '?'),
    };
    for (axis, letter) in [first, second].into_iter().enumerate() {
        let (row, sign) = match letter {
            'M' => (0, 1.0),
            'U' => (0, -1.0),
            'F' => (1, 1.0),
            'N' => (1, -1.0),
            _ => (2, 0.0),
        };
        turn.col_mut(axis)[axis] = 0.0;
        turn.col_mut(axis)[row] = sign;
        turn.w_axis[row] = if sign < 0.0 { last[axis] } else { 0.0 };
    }
    match turn.determinant().abs() == 1.0 {
        true => Ok(turn),
        false => Err(format!(
            "UltrasoundImageOrientation is {orientation:?}: of pictures it is M or U, and F or N \
             (as MF or UNA), whichever first"
        )),
    }
}

/// Frames that lie in one place show nothing of a solid.
fn require_motion(placed: &[(usize, DMat4)], world: &str) -> std::result::Result<(), String> {
    match placed {
        [first, .., last] if placed.iter().all(|(_, matrix)| *matrix == first.1) => Err(format!(
            "frames {} to {} lie in one place in {world}: what moves the probe is missing",
            first.0, last.0
        )),
        _ => Ok(()),
    }
}

fn frame(
    number: usize,
    size: [usize; 2],
    labels: &[u32],
    matrix: &DMat4,
) -> std::result::Result<Frame, String> {
    let place = |x: f64, y: f64| matrix.transform_point3(DVec3::new(x, y, 0.0));
    let steps = [DVec3::X, DVec3::Y].map(|step| matrix.transform_vector3(step));
    let placement = ImagePlacement { origin: place(0.0, 0.0), steps };
    let image = LabelImage::new(size, labels.to_vec(), placement)?.extended(AROUND);
    let end = DVec2::new(size[0] as f64, size[1] as f64) - 0.5;
    let corners = [[-0.5, -0.5], [end.x, -0.5], [end.x, end.y], [-0.5, end.y]];
    Ok(Frame { number, image, corners: corners.map(|[x, y]| place(x, y)) })
}

fn checked(file: &Path, frames: Vec<Frame>, rules: &Rules) -> Result<Sections> {
    let raw = |frame: Frame| Raw {
        name: format!("frame {}", frame.number),
        place: "its pixels".to_owned(),
        content: frame,
    };
    let raw: Vec<Raw<Frame>> = frames.into_iter().map(raw).collect();
    check(file, &raw, rules, |raw| within(&raw.name, &raw.content, rules))
}

fn within(name: &str, frame: &Frame, rules: &Rules) -> Result<(Section, Findings)> {
    let (section, findings) = frame.image.section(name, rules)?;
    let diagonal = frame.corners[0].distance(frame.corners[2]);
    // What runs on over the border is no more than that.
    let calm = Rules { strict: false, ..*rules };
    let (section, _) = section.within(&frame.corners, &[], diagonal, &calm)?;
    Ok((section, findings))
}
