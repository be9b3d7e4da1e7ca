//! A section from loops that a program has at hand, rather than a file.

use glam::DVec3;

use super::{Findings, Loop, Rules, Section};
use crate::error::Result;
use crate::label::Label;
use crate::plane::Plane;

/// Loops on a plane, on the way to a section.
///
/// ```
/// use transect::{DVec3, Label, Plane, Rules, Section};
///
/// let plane = Plane { normal: DVec3::Z, offset: 2.0 };
/// let square = |half: f64| {
///     [[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]]
///         .map(|[x, y]| DVec3::new(half * x, half * y, 2.0))
/// };
/// let (section, findings) = Section::builder("a frame", plane)
///     .region(Label(1), square(2.0))
///     .hole(square(1.0))
///     .within(square(3.0))
///     .build(&Rules::default())?;
/// // Beyond the frame nothing is known.
/// assert_eq!(section.labels(), [Label::OUTSIDE, Label(1), Label::UNKNOWN]);
/// assert!(findings.warnings.is_empty());
/// # Ok::<(), transect::Error>(())
/// ```
#[derive(Debug, Clone)]
pub struct SectionBuilder {
    name: String,
    plane: Plane,
    loops: Vec<Loop>,
    extent: Option<Vec<DVec3>>,
}

impl Section {
    /// A section without loops, so far; outside everywhere.
    pub fn builder(name: impl Into<String>, plane: Plane) -> SectionBuilder {
        SectionBuilder { name: name.into(), plane, loops: Vec::new(), extent: None }
    }
}

impl SectionBuilder {
    /// Adds a polygon, given by its corners on the plane, with a label inside. Of polygons
    /// inside one another the rules say which wins.
    #[must_use]
    pub fn region(mut self, label: Label, points: impl IntoIterator<Item = DVec3>) -> Self {
        self.loops.push(Loop { points: points.into_iter().collect(), label, hole_of: None });
        self
    }

    /// Takes a polygon away from the region before.
    #[must_use]
    pub fn hole(mut self, points: impl IntoIterator<Item = DVec3>) -> Self {
        let region = self.loops.iter().rposition(|own| own.hole_of.is_none());
        let label = region.map_or(Label::OUTSIDE, |region| self.loops[region].label);
        // A hole of itself is refused.
        let (points, own) = (points.into_iter().collect(), self.loops.len());
        self.loops.push(Loop { points, label, hole_of: Some(region.unwrap_or(own)) });
        self
    }

    /// Nothing is known beyond a polygon.
    #[must_use]
    pub fn within(mut self, extent: impl IntoIterator<Item = DVec3>) -> Self {
        self.extent = Some(extent.into_iter().collect());
        self
    }

    /// The section, and what was doubtful about it.
    ///
    /// # Errors
    /// As [`Section::from_loops`] and [`Section::within`]. Points may be off the plane by the
    /// rules' share of what all of them span.
    pub fn build(self, rules: &Rules) -> Result<(Section, Findings)> {
        let Self { name, plane, loops, extent } = self;
        let points = loops.iter().flat_map(|own| &own.points).chain(extent.iter().flatten());
        let ends = points.fold(None, |ends: Option<[DVec3; 2]>, &point| {
            let [low, high] = ends.unwrap_or([point; 2]);
            Some([low.min(point), high.max(point)])
        });
        let diagonal = ends.map_or(0.0, |[low, high]| low.distance(high));
        let (section, mut findings) = Section::from_loops(&name, plane, &loops, diagonal, rules)?;
        let Some(extent) = extent else { return Ok((section, findings)) };
        let (section, more) = section.within(&extent, &loops, diagonal, rules)?;
        findings.append(more);
        Ok((section, findings))
    }
}
