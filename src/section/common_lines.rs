//! Vertices that are nearly on the line in which another plane meets theirs are put there, as
//! far as doubles can name its points: on lines along a kept axis. Planes that stand upright on
//! each other, as those of scans, have such lines.

use super::draft::{Draft, snapping};
use super::sections::product;
use super::{Rules, Sections, Warning};
use crate::error::Result;
use crate::plane::Plane;

impl Sections {
    /// Moves vertices by less than the tolerance ([`Rules::snapping`]) onto the planes of other
    /// sections; a note says how many.
    ///
    /// # Errors
    /// Where contours touch in ways that rounding takes apart.
    pub(super) fn align(&mut self, rules: &Rules) -> Result<()> {
        let diagonal = self.bounds().map_or(0.0, |bounds| bounds.diagonal());
        let tolerance = snapping(rules, diagonal);
        let planes: Vec<Plane> = self.sections.iter().map(|section| section.plane).collect();
        let mut moved = 0;
        for section in &mut self.sections {
            let mut aligned = section.clone();
            let before = moved;
            for (axis, value) in planes.iter().filter_map(|other| line(&section.plane, other)) {
                let length = stretch(&section.plane, axis);
                for vertex in &mut aligned.vertices {
                    let distance = (vertex[axis] - value).abs();
                    if distance > 0.0 && distance * length <= tolerance {
                        vertex[axis] = value;
                        moved += 1;
                    }
                }
            }
            if moved > before {
                let mut draft = Draft::new(&section.name, section.plane, diagonal, rules)?;
                *section = aligned.settled(&mut draft)?;
            }
        }
        if moved > 0 {
            let what = format!(
                "vertices less than {tolerance:.3e} from lines where planes meet, and put there: {moved}"
            );
            self.notes.push(Warning { section: String::new(), what });
        }
        Ok(())
    }
}

/// The kept coordinate that all points of a plane's common line with another have, and which it
/// is; none where the line is not along a kept axis.
fn line(own: &Plane, other: &Plane) -> Option<(usize, f64)> {
    let dropped = own.dropped_axis();
    // The other's equation, with the dropped coordinate solved for by the own.
    let eliminated = |axis: usize| {
        let terms = [other.normal[axis], other.normal[dropped]];
        let factors = [own.normal[dropped], own.normal[axis]];
        let vanishes = product(terms[0], factors[0]) == product(terms[1], factors[1]);
        (!vanishes).then(|| terms[0] * factors[0] - terms[1] * factors[1])
    };
    let (axis, factor) = match own.kept_axes().map(eliminated) {
        [Some(factor), None] => (0, factor),
        [None, Some(factor)] => (1, factor),
        _ => return None,
    };
    let rest = other.offset * own.normal[dropped] - other.normal[dropped] * own.offset;
    let value = rest / factor + 0.0; // no -0
    value.is_finite().then_some((axis, value))
}

/// How much longer a step along a kept axis is on the plane.
fn stretch(plane: &Plane, axis: usize) -> f64 {
    let dropped = plane.normal[plane.dropped_axis()];
    (plane.normal[plane.kept_axes()[axis]] / dropped).hypot(1.0)
}
