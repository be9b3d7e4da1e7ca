//! All contours of one label.

use glam::DVec3;
use rayon::prelude::*;

use crate::label::Label;
use crate::section::Section;
use crate::segments::{Hint, SegmentTree};

use super::metric::Metric;

/// A label's contours on all sections: the edges between it and another known
/// label.
#[derive(Debug)]
pub struct Outline {
    /// In world units, in the order of the sections' edges.
    segments: Vec<[DVec3; 2]>,
    /// Where those of each section end.
    ends: Vec<usize>,
    metric: Metric,
    /// The same in the squeezed space, to be searched.
    tree: SegmentTree,
}

impl Outline {
    /// Of a label.
    pub fn new(sections: &[Section], label: Label, metric: Metric) -> Self {
        let (mut segments, mut ends) = (Vec::new(), Vec::new());
        for section in sections {
            for edge in section.edges() {
                let sides = [edge.left, edge.right];
                let own = sides.contains(&label) && !sides.contains(&Label::UNKNOWN);
                if own {
                    segments.push([section.point(edge.start), section.point(edge.end)]);
                }
            }
            ends.push(segments.len());
        }
        let squeezed = |segment: &[DVec3; 2]| segment.map(|end| metric.squeezed(end));
        let tree = SegmentTree::new(segments.iter().map(squeezed).collect());
        Self { segments, ends, metric, tree }
    }

    /// The distance from a point to the nearest contour, squeezed; infinite without any.
    pub fn distance(&self, point: DVec3, hint: &mut Hint) -> f64 {
        self.tree.distance(self.metric.squeezed(point), hint)
    }

    /// The same where it is below a limit.
    pub fn distance_below(&self, limit: f64, point: DVec3) -> Option<f64> {
        self.tree.distance_below(limit, self.metric.squeezed(point))
    }

    /// Points along the contours of each section, one for each `spacing` of their length:
    /// shorter edges share one.
    pub fn points(&self, spacing: f64) -> Vec<DVec3> {
        let starts = std::iter::once(&0).chain(&self.ends);
        let sections: Vec<&[[DVec3; 2]]> =
            starts.zip(&self.ends).map(|(&start, &end)| &self.segments[start..end]).collect();
        sections.into_par_iter().flat_map_iter(|own| points_along(own, spacing)).collect()
    }
}

fn points_along(segments: &[[DVec3; 2]], spacing: f64) -> Vec<DVec3> {
    let mut points = Vec::new();
    // Where the next point lies, from the start of the segment.
    let mut next = spacing / 2.0;
    for &[start, end] in segments {
        let length = start.distance(end);
        while next < length {
            points.push(start.lerp(end, next / length));
            next += spacing;
        }
        next -= length;
    }
    points
}

#[cfg(test)]
mod tests {
    use std::f64::consts::TAU;

    use super::*;
    use crate::check::shapes::disc;
    use crate::plane::Plane;

    #[test]
    fn points_are_as_many_as_the_contours_are_long() {
        let plane = Plane { normal: DVec3::new(0.0, 1.0, 1.0), offset: 0.2 };
        // 5,000 edges of 1/800 each: a point for every 50 of them.
        let sections = [disc(plane, 1.0, 5000, Label(2))];
        let metric = Metric::new(&sections);
        for label in [Label(2), Label::OUTSIDE] {
            let points = Outline::new(&sections, label, metric).points(TAU / 100.0);
            assert!((99..=101).contains(&points.len()), "{}", points.len());
        }
        let outline = Outline::new(&sections, Label(2), metric);
        // And many for one edge: the diagonal of a square.
        let square = [disc(plane, 1.0, 4, Label(2))];
        let long = Outline::new(&square, Label(2), metric).points(0.01);
        assert!((long.len() as f64 - 4.0 * 2f64.sqrt() / 0.01).abs() < 2.0);
        assert!(Outline::new(&sections, Label(1), metric).points(0.1).is_empty());
        let mut hint = Default::default();
        assert!(outline.distance(plane.unit_normal() * 0.2 / 2f64.sqrt(), &mut hint) > 0.99);
        // Across it half counts as less.
        let beside = outline.segments[0][0] + 0.5 * plane.unit_normal();
        let squeezed = outline.distance(beside, &mut hint);
        assert!((metric.squeezed(0.5 * plane.unit_normal()).length() - squeezed).abs() < 1e-9);
        assert!(squeezed < 0.4 && outline.distance_below(0.4, beside) == Some(squeezed));
    }
}
