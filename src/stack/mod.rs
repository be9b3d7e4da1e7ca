//! Parallel sections, by interpolating distances (*shape-based interpolation*).
//!
//! S. Raya and J. Udupa, Shape-based interpolation of multidimensional objects, IEEE
//! Transactions on Medical Imaging 9, 1990; as in J. Marker, I. Braude, K. Museth, D. Breen,
//! Contour-based surface reconstruction using implicit curve fitting, and distance field
//! filtering and interpolation, Volume Graphics 2006.
//!
//! On every slice each label has the signed distance to its contours, exactly and at every pixel
//! (§2.2, `slices`); creases of it that are far from the contours are smoothed (§2.3,
//! `filter`); and along each column of pixels a cubic spline goes through them that does not
//! overshoot (§2.4, `spline`). The label with the largest value wins, so no gap opens between
//! labels. Where a slice shows nothing of a label that its neighbour shows, the label ends
//! about halfway; so it does beyond the first and the last slice, rounded with that radius.
//!
//! Two slices of a part that do not overlap are not connected, the limit that the paper names.
//! Which parts do not overlap anything of their label (`parts`) and match when they are moved
//! (`matching`) is told; where they are to be linked, the part moves from one slice to the next
//! while it becomes the other (`tube`).
//!
//! ```text
//! sections ─► slices ─► filter ─► spline ─► field ─► grid::assembly ─► Samples
//!                  └► parts ─► matching ─► tube ─┘
//! ```

mod field;
mod filter;
mod links;
mod matching;
mod parts;
mod slices;
mod spline;
mod tube;

use glam::{DVec2, DVec3};

use crate::error::{Remedy, Result};
use crate::grid::assembly::assemble;
use crate::grid::contour::segments;
use crate::grid::frame::Frame;
use crate::grid::lattice::Resolution;
use crate::grid::memory::require_bytes;
use crate::grid::samples::{Lattice, Samples};
use crate::grid::sampling::Starts;
use crate::label::Label;
use crate::method::Linking;
use crate::plane::Bounds;
use crate::progress::Progress;
use crate::section::{Section, reach};
use crate::variational::labels;

use field::{Columns, StackField};
use matching::{Pair, pairs};
use parts::{Part, Parts};
use slices::Slices;
use spline::Spline;
use tube::Tube;

pub use links::{Link, Links};

/// Of a pixel of every slice: its distance and its slope for a label, and besides what is said
/// there, and slopes twice while they are found.
const BYTES_PER_LABEL: u64 = 8;
const BYTES_PER_PIXEL: u64 = 8;

/// How far a part moves at most, if nothing is said, in distances between its two slices.
const FARTHEST: f64 = 2.0;

/// How finely slices are looked at to find what they have in common.
const PIXELS_FOR_OVERLAP: Resolution = Resolution::Voxels(128);

/// What a stack makes.
pub(crate) struct Stacked {
    /// Its samples.
    pub samples: Samples,
    /// The parts that are linked, or would be.
    pub links: Links,
}

/// The samples of a stack in a box whose faces are outside, with links or without.
///
/// # Errors
/// When sections are not a stack: not parallel, fewer than two, or partly unknown; or when their
/// images would not fit into memory.
pub(crate) fn stacked(
    sections: &[Section],
    frame: &Frame,
    linking: Option<Linking>,
    progress: &dyn Progress,
) -> Result<Stacked> {
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
    let linked = Linked::new(&slices, &drawn, linking, progress)?;
    let spline = Spline::new(slices.heights.clone());
    let reaches = reach::reaches(sections);
    let radii = slices.ends().map(|end| 0.5 * reaches[end] / lattice.voxel);
    let mut columns = Vec::with_capacity(materials.len());
    for label in materials {
        let go_on = || progress.go_on();
        columns.push(Columns::new((&slices, &spline), label, &drawn, radii, go_on)?);
        progress.advance(1);
    }
    let field = |own| StackField::new(own, &columns, &linked.tubes, lattice);
    let fields = (0..columns.len()).map(field).collect();
    let contours: Vec<[DVec3; 2]> = sections.iter().flat_map(segments).collect();
    let starts = Starts::along(&contours, &lattice).leaves();
    Ok(Stacked { samples: assemble(fields, starts, lattice, None), links: linked.links })
}

/// What neighbours of a stack have in common of their materials' area, in a box: twice that over
/// the sum of both areas, label by label and all neighbours pooled. 1 where there is nothing.
///
/// # Errors
/// As [`stacked`].
pub(crate) fn overlap(sections: &[Section], bounds: Bounds) -> Result<f64> {
    let slices = Slices::new(sections, &Lattice::new(bounds, PIXELS_FOR_OVERLAP)?)?;
    let drawn: Vec<Vec<Label>> =
        (0..slices.heights.len()).map(|slice| slices.labels(slice)).collect();
    let area = |labels: &[Label]| labels.iter().filter(|label| label.is_material()).count();
    let in_common = |[one, other]: [&[Label]; 2]| {
        let both = one.iter().zip(other);
        both.filter(|(one, other)| one == other && one.is_material()).count()
    };
    let pairs = drawn.windows(2).map(|pair| [&*pair[0], &*pair[1]]);
    let [common, areas] = pairs.fold([0, 0], |[common, areas], pair| {
        [common + in_common(pair), areas + area(pair[0]) + area(pair[1])]
    });
    Ok(if areas == 0 { 1.0 } else { 2.0 * common as f64 / areas as f64 })
}

/// The links of a stack.
struct Linked {
    links: Links,
    /// For every slice those to the next one; none where parts are not to be linked.
    tubes: Vec<Vec<Tube>>,
}

impl Linked {
    fn new(
        slices: &Slices,
        drawn: &[Vec<Label>],
        linking: Option<Linking>,
        progress: &dyn Progress,
    ) -> Result<Self> {
        let connected = linking.is_some();
        let farthest = linking.and_then(|linking| linking.farthest);
        let parts = Parts::new(drawn, slices.width());
        let mut own = Self { links: Links { connected, found: Vec::new() }, tubes: Vec::new() };
        for lower in 0..drawn.len() - 1 {
            progress.go_on()?;
            let farthest = farthest.map_or_else(
                || FARTHEST * (slices.heights[lower + 1] - slices.heights[lower]),
                |farthest| farthest / slices.voxel(),
            );
            let (links, tubes) = between(slices, &parts, lower, farthest).into_iter().unzip();
            own.links.found.extend::<Vec<Link>>(links);
            own.tubes.push(if connected { tubes } else { Vec::new() });
        }
        Ok(own)
    }
}

/// The links from a slice to the next one, of parts that move by less than so many pixels.
fn between(slices: &Slices, parts: &Parts, lower: usize, farthest: f64) -> Vec<(Link, Tube)> {
    let [below, above] = [parts.loose(lower, lower + 1), parts.loose(lower + 1, lower)];
    let mut labels: Vec<Label> = below.iter().map(|part| part.label).collect();
    labels.sort_unstable();
    labels.dedup();
    let of_label = |label: Label| {
        let own = |parts: &[Part]| {
            parts.iter().filter(|part| part.label == label).cloned().collect::<Vec<Part>>()
        };
        let [below, above] = [own(&below), own(&above)];
        let link = |pair: &Pair| {
            let both = [&below[pair.from], &above[pair.to]];
            let tube = Tube::new(slices, lower, both, pair)?;
            Some((told(slices, lower, both[0], pair), tube))
        };
        pairs(&below, &above, farthest).iter().filter_map(link).collect::<Vec<_>>()
    };
    labels.into_iter().flat_map(of_label).collect()
}

fn told(slices: &Slices, lower: usize, part: &Part, pair: &Pair) -> Link {
    let step = DVec2::from_array(pair.step.map(f64::from));
    let [at, moved] = [part.middle, part.middle + step].map(|pixel| slices.point_at(lower, pixel));
    Link {
        label: part.label.0,
        sections: [lower, lower + 1].map(|slice| slices.name(slice).to_owned()),
        at: at.to_array(),
        translation: (moved - at).to_array(),
        length: at.distance(moved),
        overlap: pair.overlap,
    }
}
