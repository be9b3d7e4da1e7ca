//! Cell groups: cells joined through faces that hold unknown regions.

use crate::arrangement::{Arrangement, Face, components};
use crate::label::Label;

/// Whether there is an unknown region on a face.
pub(super) fn has_unknown(face: &Face) -> bool {
    face.labels.binary_search(&Label::UNKNOWN).is_ok()
}

/// The group of every cell.
pub(super) fn groups(arrangement: &Arrangement) -> Vec<u32> {
    let joined = arrangement.faces().iter().filter(|face| has_unknown(face));
    let pairs = joined.filter_map(|face| match face.cells {
        [Some(front), Some(behind)] => Some([front, behind]),
        _ => None,
    });
    components(arrangement.cells().len() as u32, pairs)
}
