//! Cell groups: cells joined through facets that hold unknown regions.

use crate::complex::{Complex, Facet};
use crate::label::Label;
use crate::sets::components;

/// Whether there is an unknown region on a facet.
pub(super) fn has_unknown(facet: &Facet) -> bool {
    facet.labels.binary_search(&Label::UNKNOWN).is_ok()
}

/// The group of every cell.
pub(super) fn groups(complex: &Complex) -> Vec<u32> {
    let joined = complex.facets().values().filter(|facet| has_unknown(facet));
    let pairs = joined.filter_map(|facet| match facet.cells {
        [Some(front), Some(behind)] => Some([front, behind]),
        _ => None,
    });
    components(complex.cells().end() as u32, pairs)
}
