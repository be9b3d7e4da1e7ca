//! Contours with fewer points: those of a section, and of a surface on its plane.

use glam::{DVec2, DVec3};

use crate::label::Label;
use crate::label_image::Contours;
use crate::mesh::cut::Cut;
use crate::section::{Edge, Section};

/// A plane with two perpendicular directions of length 1 in it, as people look at it.
#[derive(Debug, Clone, Copy)]
pub struct Sheet {
    /// A place on it.
    pub origin: DVec3,
    /// To the right and up.
    pub axes: [DVec3; 2],
    /// Whether its plane's normal points away from who looks at it.
    pub turned: bool,
}

impl Sheet {
    pub fn flat(&self, point: DVec3) -> DVec2 {
        let offset = point - self.origin;
        DVec2::from(self.axes.map(|axis| offset.dot(axis)))
    }

    pub fn space(&self, point: DVec2) -> DVec3 {
        self.origin + point.x * self.axes[0] + point.y * self.axes[1]
    }

    /// A section's contours.
    pub fn contours(&self, section: &Section) -> Contours {
        let points = (0..section.vertices().len() as u32).map(|vertex| section.point(vertex));
        self.drawn(points, section.edges())
    }

    /// What a surface looks like on the plane.
    pub fn cut(&self, cut: &Cut) -> Contours {
        self.drawn(cut.points.iter().copied(), &cut.edges)
    }

    fn drawn(&self, points: impl Iterator<Item = DVec3>, edges: &[Edge]) -> Contours {
        let side = |edge: &Edge| match self.turned {
            true => Edge { left: edge.right, right: edge.left, ..*edge },
            false => *edge,
        };
        Contours {
            points: points.map(|point| self.flat(point)).collect(),
            edges: edges.iter().map(side).collect(),
        }
    }
}

/// Contours with no more points than `most`, as long as `farthest` allows it: within a tolerance
/// that begins with `tolerance` and is doubled.
pub fn simplified(contours: &Contours, tolerance: f64, farthest: f64, most: usize) -> Contours {
    let mut tolerance = tolerance;
    loop {
        let simple = contours.simplified(tolerance);
        tolerance *= 2.0;
        if simple.edges.len() <= most || tolerance > farthest {
            return simple;
        }
    }
}

/// The closed walks around a label: along each the label is on the left. A place where several meet
/// is passed as often.
pub fn walks(contours: &Contours, label: Label) -> Vec<Vec<u32>> {
    let around = contours.edges.iter().filter_map(|edge| match label {
        _ if edge.left == edge.right => None,
        _ if edge.left == label => Some([edge.start, edge.end]),
        _ if edge.right == label => Some([edge.end, edge.start]),
        _ => None,
    });
    let around: Vec<[u32; 2]> = around.collect();
    let mut out: Vec<Vec<usize>> = vec![Vec::new(); contours.points.len()];
    for (number, [start, _]) in around.iter().enumerate().rev() {
        out[*start as usize].push(number);
    }
    let mut is_done = vec![false; around.len()];
    let mut walks = Vec::new();
    for first in 0..around.len() {
        let (mut walk, mut next) = (Vec::new(), Some(first));
        while let Some(number) = next.filter(|&number| !is_done[number]) {
            is_done[number] = true;
            let [start, end] = around[number];
            walk.push(start);
            let going = &mut out[end as usize];
            while going.last().is_some_and(|&last| is_done[last]) {
                going.pop();
            }
            next = going.last().copied();
        }
        if !walk.is_empty() {
            walks.push(walk);
        }
    }
    walks
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Two squares that touch in a corner, the first one's material left of its edges.
    fn touching() -> Contours {
        let points = [[0., 0.], [1., 0.], [1., 1.], [0., 1.], [2., 1.], [2., 2.], [1., 2.]];
        let edge =
            |[start, end]: [u32; 2]| Edge { start, end, left: Label(1), right: Label::OUTSIDE };
        let ends = [[0, 1], [1, 2], [2, 3], [3, 0], [2, 4], [4, 5], [5, 6], [6, 2]];
        Contours { points: points.map(DVec2::from).to_vec(), edges: ends.map(edge).to_vec() }
    }

    fn area(contours: &Contours, walk: &[u32]) -> f64 {
        let at = |place: usize| contours.points[walk[place % walk.len()] as usize];
        (0..walk.len()).map(|place| at(place).perp_dot(at(place + 1)) / 2.0).sum()
    }

    #[test]
    fn walks_close_and_have_the_label_on_their_left() {
        let contours = touching();
        for (label, area_of_all) in [(Label(1), 2.0), (Label::OUTSIDE, -2.0), (Label(2), 0.0)] {
            let walks = walks(&contours, label);
            let edges: usize = walks.iter().map(Vec::len).sum();
            assert_eq!(edges, if area_of_all == 0.0 { 0 } else { 8 }, "each edge once");
            let sum: f64 = walks.iter().map(|walk| area(&contours, walk)).sum();
            assert_eq!(sum, area_of_all);
        }
    }

    #[test]
    fn points_become_fewer_until_the_farthest() {
        let count = 1000u32;
        let angle = |step: u32| std::f64::consts::TAU * f64::from(step) / f64::from(count);
        let points = (0..count).map(|step| DVec2::from_angle(angle(step))).collect();
        let edges = (0..count).map(|start| Edge {
            start,
            end: (start + 1) % count,
            left: Label(1),
            right: Label::OUTSIDE,
        });
        let circle = Contours { points, edges: edges.collect() };
        let simple = simplified(&circle, 1e-6, 0.1, 40);
        assert!(simple.edges.len() <= 40, "{}", simple.edges.len());
        // A chord of 0.1 in depth spans 0.9: never fewer than seven.
        assert!(simplified(&circle, 1e-6, 1e-4, 40).edges.len() > 40);
    }
}
