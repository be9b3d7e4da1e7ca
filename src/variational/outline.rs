//! All contours of one label.

use glam::DVec3;

use crate::label::Label;
use crate::section::Section;

use super::segments::SegmentTree;

/// A label's contours on all sections: the edges between it and another known
/// label.
#[derive(Debug)]
pub struct Outline {
    /// In world units, in the order of the sections' edges.
    segments: Vec<[DVec3; 2]>,
    /// The same, to be searched.
    pub tree: SegmentTree,
}

impl Outline {
    /// Of a label.
    pub fn new(sections: &[Section], label: Label) -> Self {
        let mut segments = Vec::new();
        for section in sections {
            for edge in section.edges() {
                let sides = [edge.left, edge.right];
                let own = sides.contains(&label) && !sides.contains(&Label::UNKNOWN);
                if own {
                    segments.push([section.point(edge.start), section.point(edge.end)]);
                }
            }
        }
        Self { tree: SegmentTree::new(segments.clone()), segments }
    }

    /// Points along the contours, one for each `spacing` of their length: shorter
    /// edges share one.
    pub fn points(&self, spacing: f64) -> Vec<DVec3> {
        let mut points = Vec::new();
        // Where the next point lies, from the start of the segment.
        let mut next = spacing / 2.0;
        for &[start, end] in &self.segments {
            let length = start.distance(end);
            while next < length {
                points.push(start.lerp(end, next / length));
                next += spacing;
            }
            next -= length;
        }
        points
    }
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
        for label in [Label(2), Label::OUTSIDE] {
            let points = Outline::new(&sections, label).points(TAU / 100.0);
            assert!((99..=101).contains(&points.len()), "{}", points.len());
        }
        let outline = Outline::new(&sections, Label(2));
        // And many for one edge: the diagonal of a square.
        let square = [disc(plane, 1.0, 4, Label(2))];
        let long = Outline::new(&square, Label(2)).points(0.01);
        assert!((long.len() as f64 - 4.0 * 2f64.sqrt() / 0.01).abs() < 2.0);
        assert!(Outline::new(&sections, Label(1)).points(0.1).is_empty());
        let mut hint = Default::default();
        assert!(outline.tree.distance(plane.unit_normal() * 0.2 / 2f64.sqrt(), &mut hint) > 0.99);
    }
}
