//! The borders between the known and the unknown parts of a plane, in a tree of
//! boxes.

use glam::{DVec2, DVec3};

use crate::label::Label;
use crate::section::Section;

/// Edges in a box of the tree that is not divided.
const FEW: usize = 4;

/// A segment of a border, in the plane's own coordinates.
type Segment = [DVec2; 2];

/// Where a plane stops being known.
pub struct Borders {
    /// Unit vectors in the plane.
    axes: [DVec3; 2],
    known_far_away: bool,
    segments: Vec<Segment>,
    /// The first holds all segments.
    boxes: Vec<Node>,
}

/// A box around consecutive segments. What follows it in the tree is its first
/// half, if it is divided.
struct Node {
    min: DVec2,
    max: DVec2,
    first: u32,
    count: u32,
    /// The second half, or 0 for a box that is not divided.
    second: u32,
}

impl Borders {
    /// Of a section: its edges with *unknown* on one side.
    pub fn new(section: &Section) -> Self {
        let axes = section.plane().tangents();
        let place = |vertex| flat(axes, section.point(vertex));
        let segments: Vec<Segment> = section
            .edges()
            .iter()
            .filter(|edge| (edge.left == Label::UNKNOWN) != (edge.right == Label::UNKNOWN))
            .map(|edge| [place(edge.start), place(edge.end)])
            .collect();
        let known_far_away = section.background() != Label::UNKNOWN;
        let mut borders = Self { axes, known_far_away, segments, boxes: Vec::new() };
        if !borders.segments.is_empty() {
            borders.divide(0, borders.segments.len());
        }
        borders
    }

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.segments.is_empty()
    }

    /// Whether the plane is known at infinity.
    pub fn is_known_far_away(&self) -> bool {
        self.known_far_away
    }

    /// The distance from a point's foot on the plane to what is known there,
    /// when it is below a limit.
    pub fn distance(&self, point: DVec3, limit: f64) -> Option<f64> {
        let foot = flat(self.axes, point);
        if self.is_known(foot) {
            return (limit > 0.0).then_some(0.0);
        }
        let square = self.nearest(foot, limit * limit)?;
        Some(square.sqrt())
    }

    /// Makes the box of some segments and of their halves; says which it is.
    fn divide(&mut self, first: usize, count: usize) -> u32 {
        let own = &mut self.segments[first..first + count];
        let min = own.iter().flatten().fold(DVec2::INFINITY, |min, end| min.min(*end));
        let max = own.iter().flatten().fold(DVec2::NEG_INFINITY, |max, end| max.max(*end));
        let number = self.boxes.len() as u32;
        let (from, length) = (first as u32, count as u32);
        self.boxes.push(Node { min, max, first: from, count: length, second: 0 });
        if count > FEW {
            let axis = usize::from(max.y - min.y > max.x - min.x);
            let middle = |segment: &Segment| segment[0][axis] + segment[1][axis];
            own.sort_by(|one, other| middle(one).total_cmp(&middle(other)));
            self.divide(first, count / 2);
            let second = self.divide(first + count / 2, count - count / 2);
            self.boxes[number as usize].second = second;
        }
        number
    }

    /// Whether a point of the plane is in a known region: every border between
    /// it and infinity, along x, changes that. An end on the ray counts as above
    /// it.
    fn is_known(&self, at: DVec2) -> bool {
        let mut known = self.known_far_away;
        let passes = |node: &Node| node.min.y <= at.y && at.y < node.max.y && at.x < node.max.x;
        self.visit(passes, |&[start, end]| {
            if (start.y <= at.y) != (end.y <= at.y) {
                let x = start.x + (at.y - start.y) / (end.y - start.y) * (end.x - start.x);
                known ^= x > at.x;
            }
        });
        known
    }

    /// Visits the segments in all boxes, and boxes in them, that are passed.
    fn visit(&self, passes: impl Fn(&Node) -> bool, mut segment: impl FnMut(&Segment)) {
        let mut waiting = vec![0u32];
        while let Some(number) = waiting.pop() {
            let node = &self.boxes[number as usize];
            if !passes(node) {
                continue;
            }
            if node.second == 0 {
                self.segments_of(node).iter().for_each(&mut segment);
            } else {
                waiting.extend([number + 1, node.second]);
            }
        }
    }

    /// The squared distance to the nearest segment, when it is below a limit.
    fn nearest(&self, at: DVec2, limit: f64) -> Option<f64> {
        let mut nearest = limit;
        let mut waiting = vec![(self.boxes[0].gap(at), 0u32)];
        while let Some((gap, number)) = waiting.pop() {
            if gap >= nearest {
                continue;
            }
            let node = &self.boxes[number as usize];
            if node.second == 0 {
                let squares = self.segments_of(node).iter().map(|&segment| square(at, segment));
                nearest = squares.fold(nearest, f64::min);
                continue;
            }
            // The nearer half is looked at first.
            let mut halves =
                [number + 1, node.second].map(|half| (self.boxes[half as usize].gap(at), half));
            halves.sort_by(|one, other| other.0.total_cmp(&one.0));
            waiting.extend(halves);
        }
        (nearest < limit).then_some(nearest)
    }

    fn segments_of(&self, node: &Node) -> &[Segment] {
        &self.segments[node.first as usize..][..node.count as usize]
    }
}

impl Node {
    /// The squared distance from a point to the box.
    fn gap(&self, at: DVec2) -> f64 {
        (at - at.clamp(self.min, self.max)).length_squared()
    }
}

fn flat([first, second]: [DVec3; 2], point: DVec3) -> DVec2 {
    DVec2::new(point.dot(first), point.dot(second))
}

/// The squared distance from a point to a segment.
fn square(at: DVec2, [start, end]: Segment) -> f64 {
    let (along, offset) = (end - start, at - start);
    let fraction = (offset.dot(along) / along.length_squared()).clamp(0.0, 1.0);
    (offset - fraction * along).length_squared()
}
