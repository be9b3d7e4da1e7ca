//! What must hold of regions on facets. All else is checked exactly, in C++.

use std::collections::{BTreeMap, HashMap};

use glam::DVec3;

use super::{Complex, Facet, FacetEdge};
use crate::label::Label;

/// How much areas may differ, relative to the facet's.
const AREA_TOLERANCE: f64 = 1e-9;

type Check = Result<(), String>;

impl Complex {
    /// The regions' borders close, and their areas add up to the facets'.
    pub(super) fn check_regions(&self) -> Check {
        self.facets.iter().try_for_each(|(id, facet)| self.check_facet(id, facet))
    }

    fn check_facet(&self, id: u32, facet: &Facet) -> Check {
        let Facet { plane, edges, labels, outline, .. } = facet;
        let normal = self.planes[*plane].unit_normal();
        let area = |start: DVec3, end: DVec3| {
            (start - outline[0]).cross(end - outline[0]).dot(normal) / 2.0
        };
        let mut areas: BTreeMap<Label, f64> = labels.iter().map(|&label| (label, 0.0)).collect();
        for (label, start, end) in edges.iter().flat_map(directed) {
            let known = areas.get_mut(&label).map(|sum| *sum += area(start, end));
            ensure(known.is_some(), || format!("facet {id} does not list its label {label}"))?;
        }
        let next = outline.iter().cycle().skip(1);
        let whole: f64 = outline.iter().zip(next).map(|(&start, &end)| area(start, end)).sum();
        let tolerance = AREA_TOLERANCE * whole.abs() + rounding(outline);
        let sum: f64 = areas.values().sum();
        ensure(
            (sum - whole).abs() <= tolerance && areas.values().all(|&a| a >= -tolerance),
            || format!("the regions of facet {id} have the areas {areas:?}, together not {whole}"),
        )?;
        ensure(labels.iter().all(|&label| closes(edges, label)), || {
            format!("the border of a region of facet {id} does not close")
        })
    }
}

fn ensure(holds: bool, message: impl FnOnce() -> String) -> Check {
    if holds { Ok(()) } else { Err(message()) }
}

/// An edge once for each label beside it, the label on its left.
fn directed(edge: &FacetEdge) -> impl Iterator<Item = (Label, DVec3, DVec3)> + use<> {
    let left = (edge.left, edge.start, edge.end);
    let right = edge.right.map(|label| (label, edge.end, edge.start));
    std::iter::once(left).chain(right)
}

/// Whether as many edges of a region end in every point as start there.
fn closes(edges: &[FacetEdge], label: Label) -> bool {
    let mut degrees = HashMap::new();
    let own = edges.iter().flat_map(directed).filter(|&(beside, ..)| beside == label);
    for (_, start, end) in own {
        *degrees.entry(start.to_array().map(f64::to_bits)).or_insert(0) += 1;
        *degrees.entry(end.to_array().map(f64::to_bits)).or_insert(0) -= 1;
    }
    degrees.values().all(|&degree| degree == 0)
}

/// How far off an area can be because corners were rounded.
fn rounding(outline: &[DVec3]) -> f64 {
    let reach = outline.iter().map(|point| point.abs().max_element()).fold(0.0, f64::max);
    let length = outline.iter().map(|point| point.distance(outline[0])).fold(0.0, f64::max);
    64.0 * f64::EPSILON * reach * length
}
