//! Where a section speaks: within its extent, and not under a mask.

use glam::{DVec2, DVec3};

use super::draft::Draft;
use super::loops::{crossings, odd};
use super::overlay::Overlay;
use super::subdivision::{Curves, Windings, times};
use super::{Findings, Loop, Rules, Section};
use crate::error::Result;
use crate::label::Label;

/// The label that stands for the inside of an extent, and for a mask.
pub(crate) const COVERED: Label = Label(1);
/// How many loops a warning names.
const NAMED: usize = 8;

impl Section {
    /// This section within an extent: a polygon on its plane, beyond which all
    /// is unknown. Vertices that are nearly on it are put there. `loops` is what the section was made of, where it was:
    /// warnings name those that reach beyond.
    ///
    /// # Errors
    /// Where the extent has fewer than three points or no area, crosses itself
    /// or is off the plane.
    pub fn within(
        &self,
        extent: &[DVec3],
        loops: &[Loop],
        diagonal: f64,
        rules: &Rules,
    ) -> Result<(Self, Findings)> {
        let mut draft = Draft::new(&self.name, self.plane, diagonal, rules)?;
        let extent = project(&mut draft, extent)?;
        let inside = enclosed(&mut draft, &extent)?;
        let overlay = Overlay::new(&mut draft, [self, &inside])?;
        for label in self.labels().into_iter().filter(|&label| rules.meaning(label).is_material()) {
            let beyond = overlay.part(&draft, |[here, inside]| here == label && inside != COVERED);
            let Some((area, place)) = beyond else { continue };
            let named = name_loops(&strays(&draft, &extent, loops, label)?);
            draft.warn(format!(
                "label {label}{named} reaches beyond its extent (area {area:.3e}, near {place}): \
                 that part is left out"
            ))?;
        }
        let section =
            overlay.section(
                &draft,
                |[label, inside]| {
                    if inside == COVERED { label } else { Label::UNKNOWN }
                },
            );
        Ok((section, draft.findings))
    }

    /// This section without what lies under a mask on the same plane: that is
    /// unknown. The mask has the label [`COVERED`] where it covers.
    pub(crate) fn without(&self, mask: &Self) -> Result<Self> {
        let rules = Rules::default();
        let mut draft = Draft::new(&self.name, self.plane, 0.0, &rules)?;
        let overlay = Overlay::new(&mut draft, [self, mask])?;
        Ok(overlay.section(
            &draft,
            |[label, mask]| {
                if mask == COVERED { Label::UNKNOWN } else { label }
            },
        ))
    }
}

fn project(draft: &mut Draft, extent: &[DVec3]) -> Result<Vec<DVec2>> {
    if extent.len() < 3 {
        return Err(draft.error(format!(
            "its extent has {} points: a polygon needs three; add them or leave the extent out",
            extent.len()
        )));
    }
    let project = |(i, &point)| draft.project(point, || format!("vertex {i} of its extent"));
    extent.iter().enumerate().map(project).collect()
}

/// The inside of an extent, as a section of its own.
fn enclosed(draft: &mut Draft, extent: &[DVec2]) -> Result<Section> {
    let mut curves = Curves::default();
    curves.polygon(0, extent);
    let subdivision = curves.subdivide(draft)?;
    let windings = subdivision.windings();
    let around: Vec<i32> = windings.iter().map(|windings| times(windings, 0)).collect();
    if around.iter().all(|&times| times == 0) {
        return Err(draft.error("its extent encloses no area: correct it or leave it out"));
    }
    if let Some(&place) = crossings(&subdivision, &windings, 0).first() {
        return Err(draft.error(format!(
            "its extent crosses itself at {}: correct the order of its points",
            draft.place(place)
        )));
    }
    let label = |&times: &i32| if times == 0 { Label::OUTSIDE } else { COVERED };
    let labels: Vec<Label> = around.iter().map(label).collect();
    Ok(subdivision.section(draft, &labels))
}

/// The loops of a label that enclose something beyond the extent.
fn strays(draft: &Draft, extent: &[DVec2], loops: &[Loop], label: Label) -> Result<Vec<usize>> {
    let mut curves = Curves::default();
    let own = |polygon: &Loop| polygon.label == label && polygon.hole_of.is_none();
    for (number, polygon) in loops.iter().enumerate().filter(|(_, polygon)| own(polygon)) {
        let points: Vec<DVec2> =
            polygon.points.iter().map(|&point| draft.plane.project(point)).collect();
        curves.polygon(number, &points);
    }
    curves.polygon(loops.len(), extent);
    curves.fixed = Some(loops.len() as u32);
    let beyond = |windings: &&Windings| times(windings, loops.len() as u32) == 0;
    // What is snapped has been counted.
    let windings = curves.subdivide(&mut draft.clone())?.windings();
    let inside = windings.iter().filter(beyond).flatten().filter(|&&(_, times)| odd(times));
    let mut strays: Vec<usize> = inside.map(|&(curve, _)| curve as usize).collect();
    strays.sort_unstable();
    strays.dedup();
    Ok(strays)
}

/// Loops by number, in brackets; nothing for none.
fn name_loops(numbers: &[usize]) -> String {
    let shown: Vec<String> = numbers.iter().take(NAMED).map(ToString::to_string).collect();
    let rest = numbers.len() - shown.len();
    let rest = if rest > 0 { format!(" and {rest} more") } else { String::new() };
    match numbers {
        [] => String::new(),
        [number] => format!(" (loop {number})"),
        _ => format!(" (loops {}{rest})", shown.join(", ")),
    }
}
