//! What a section says on a square lattice of its plane.

use glam::{DVec2, DVec3};
use rayon::prelude::*;

use crate::grid::leaf_grid::{LeafSet, node_below};
use crate::label::Label;
use crate::plane::Bounds;
use crate::section::Section;

/// A point of a section whose label is known.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PlaneSample {
    /// Where it is, in world units.
    pub at: DVec3,
    /// The label there.
    pub label: Label,
    /// Whether it is one of those in every second column of every second row.
    pub is_even: bool,
}

/// A section seen from the front, u to the right and v up.
struct Drawing {
    origin: DVec3,
    sides: [DVec3; 2],
    background: Label,
    edges: Vec<DrawnEdge>,
}

/// An edge directed upward.
#[derive(Debug, Clone, Copy)]
struct DrawnEdge {
    low: DVec2,
    high: DVec2,
    /// The labels to its left and right.
    left: Label,
    right: Label,
}

/// Where a row crosses an edge.
#[derive(Debug, Clone, Copy)]
struct Crossing {
    at: f64,
    left: Label,
    right: Label,
}

/// Of so many samples one [is even](PlaneSample::is_even).
pub const SAMPLES_PER_EVEN: f32 = 4.0;
/// Crossings so close, in spacings, may be in a wrong order.
const ROUNDING: f64 = 1e-9;

/// Where samples are wanted.
#[derive(Debug, Clone, Copy)]
pub enum Region<'a> {
    /// In all of the box.
    Everywhere,
    /// In these leaves, which are cubes here.
    Leaves {
        /// The leaves.
        leaves: &'a LeafSet,
        /// Where leaf (0, 0, 0) begins.
        origin: DVec3,
        /// The side of a leaf.
        side: f64,
    },
}

/// The known points in a box of lattices with a spacing in world units on all
/// sections' planes, those in a region; section by section, row by row. Every lattice has a
/// node where its plane is nearest to `center`.
pub fn plane_samples(
    sections: &[Section],
    (bounds, center): (Bounds, DVec3),
    spacing: f64,
    region: Region,
) -> Vec<PlaneSample> {
    let rows: Vec<(usize, i64)> = sections
        .iter()
        .enumerate()
        .flat_map(|(number, section)| {
            rows(section, (bounds, center), spacing).map(move |row| (number, row))
        })
        .collect();
    let drawings: Vec<Drawing> =
        sections.par_iter().map(|section| Drawing::new(section, center)).collect();
    let crossings: Vec<Rows> =
        drawings.par_iter().map(|drawing| Rows::new(drawing, spacing)).collect();
    rows.into_par_iter()
        .flat_map_iter(|(number, row)| {
            let drawing = &drawings[number];
            let mut samples = Vec::new();
            drawing.sample_row(&crossings[number], bounds, spacing, row, region, &mut samples);
            samples
        })
        .collect()
}

/// The numbers of the rows that pass through a box.
fn rows(
    section: &Section,
    (bounds, center): (Bounds, DVec3),
    spacing: f64,
) -> std::ops::Range<i64> {
    let plane = section.plane();
    let [_, up] = plane.sides();
    let origin = origin_near(section, center);
    let heights = plane.polygon_in(bounds).into_iter().map(|corner| (corner - origin).dot(up));
    let ends = heights.fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], height| {
        [low.min(height), high.max(height)]
    });
    if ends[0] > ends[1] {
        return 0..0;
    }
    (ends[0] / spacing).ceil() as i64..(ends[1] / spacing).floor() as i64 + 1
}

/// The point of the plane that is nearest to another one.
fn origin_near(section: &Section, center: DVec3) -> DVec3 {
    let plane = section.plane();
    center - plane.distance(center) * plane.unit_normal()
}

/// Which edges a row crosses: row `first + i` those from `starts[i]` on.
struct Rows {
    first: i64,
    starts: Vec<u32>,
    edges: Vec<u32>,
}

impl Rows {
    fn new(drawing: &Drawing, spacing: f64) -> Self {
        // A row crosses an edge from its low end up to, without, its high end.
        let range = |edge: &DrawnEdge| {
            (edge.low.y / spacing).ceil() as i64..(edge.high.y / spacing).ceil() as i64
        };
        let ranges = || drawing.edges.iter().map(range).filter(|range| !range.is_empty());
        let first = ranges().map(|range| range.start).min().unwrap_or(0);
        let end = ranges().map(|range| range.end).max().unwrap_or(first);
        let mut starts = vec![0u32; (end - first) as usize + 1];
        for row in ranges().flatten() {
            starts[(row - first) as usize + 1] += 1;
        }
        for row in 1..starts.len() {
            starts[row] += starts[row - 1];
        }
        let mut next = starts.clone();
        let mut edges = vec![0; starts.last().map_or(0, |&count| count as usize)];
        for (number, edge) in drawing.edges.iter().enumerate() {
            for row in range(edge) {
                let place = &mut next[(row - first) as usize];
                edges[*place as usize] = number as u32;
                *place += 1;
            }
        }
        Self { first, starts, edges }
    }

    fn edges(&self, row: i64) -> &[u32] {
        let place = row - self.first;
        if place < 0 || place as usize + 1 >= self.starts.len() {
            return &[];
        }
        let [start, end] = [0, 1].map(|next| self.starts[place as usize + next] as usize);
        &self.edges[start..end]
    }
}

impl Drawing {
    fn new(section: &Section, center: DVec3) -> Self {
        let origin = origin_near(section, center);
        let sides = section.plane().sides();
        let place = |vertex: u32| {
            let point = section.point(vertex) - origin;
            DVec2::new(point.dot(sides[0]), point.dot(sides[1]))
        };
        let edges = section.edges().iter().map(|edge| {
            let (start, end) = (place(edge.start), place(edge.end));
            if start.y <= end.y {
                DrawnEdge { low: start, high: end, left: edge.left, right: edge.right }
            } else {
                DrawnEdge { low: end, high: start, left: edge.right, right: edge.left }
            }
        });
        Self { origin, sides, background: section.background(), edges: edges.collect() }
    }

    fn sample_row(
        &self,
        rows: &Rows,
        bounds: Bounds,
        spacing: f64,
        row: i64,
        region: Region,
        samples: &mut Vec<PlaneSample>,
    ) {
        let v = row as f64 * spacing;
        let start = self.origin + v * self.sides[1];
        let Some([from, to]) = part_in(bounds, start, self.sides[0]) else { return };
        let mut crossings: Vec<Crossing> = rows
            .edges(row)
            .iter()
            .map(|&number| {
                let DrawnEdge { low, high, left, right } = self.edges[number as usize];
                let part = (v - low.y) / (high.y - low.y);
                Crossing { at: low.x + part * (high.x - low.x), left, right }
            })
            .collect();
        crossings.sort_by(|one, other| one.at.total_cmp(&other.at));
        chain(&mut crossings, self.background, ROUNDING * spacing);
        let mut label = self.background;
        let mut crossings = crossings.into_iter().peekable();
        let end = (to / spacing).floor() as i64 + 1;
        let mut column = (from / spacing).ceil() as i64;
        while column < end {
            let (is_wanted, next) = region.run(start, spacing * self.sides[0], column);
            let run = column..next.min(end);
            column = run.end;
            for column in run.take_while(|_| is_wanted) {
                let u = column as f64 * spacing;
                while let Some(crossing) = crossings.next_if(|crossing| crossing.at <= u) {
                    label = crossing.right;
                }
                if label != Label::UNKNOWN {
                    let is_even = row % 2 == 0 && column % 2 == 0;
                    samples.push(PlaneSample { at: start + u * self.sides[0], label, is_even });
                }
            }
        }
    }
}

impl Region<'_> {
    /// Whether point `number` of a row is wanted, and the next one that may differ.
    fn run(self, start: DVec3, step: DVec3, number: i64) -> (bool, i64) {
        let Region::Leaves { leaves, origin, side } = self else { return (true, i64::MAX) };
        let (start, step) = ((start - origin) / side, step / side);
        let leaf = start + number as f64 * step;
        let leaf = node_below(leaf.to_array());
        // Up to the face of the leaf that the row comes to first.
        let mut count = f64::INFINITY;
        for axis in 0..3 {
            let face = f64::from(leaf[axis] + i32::from(step[axis] > 0.0));
            if step[axis] != 0.0 {
                count = count.min((face - start[axis]) / step[axis] - number as f64);
            }
        }
        let count = if count < 1e9 { count.ceil().max(1.0) as i64 } else { 1_000_000_000 };
        (leaves.has(leaf), number + count)
    }
}

/// Where contours touch, rounding can change the order in which a row crosses them,
/// and all the rest of it would have the label of the wrong one. So of crossings that
/// are close to each other that one comes next which begins with the label that is
/// reached.
fn chain(crossings: &mut [Crossing], background: Label, close: f64) {
    let mut label = background;
    for next in 0..crossings.len() {
        let limit = crossings[next].at + close;
        let candidates = (next..crossings.len()).take_while(|&one| crossings[one].at <= limit);
        if let Some(fitting) = candidates.into_iter().find(|&one| crossings[one].left == label) {
            crossings[next..=fitting].rotate_right(1);
        }
        label = crossings[next].right;
    }
}

/// The part of a line in a box, by two parameters.
fn part_in(bounds: Bounds, start: DVec3, along: DVec3) -> Option<[f64; 2]> {
    let mut part = [f64::NEG_INFINITY, f64::INFINITY];
    for axis in 0..3 {
        let (low, high) = (bounds.min[axis] - start[axis], bounds.max[axis] - start[axis]);
        if along[axis] == 0.0 {
            if low > 0.0 || high < 0.0 {
                return None;
            }
            continue;
        }
        let ends = [low / along[axis], high / along[axis]];
        part = [part[0].max(ends[0].min(ends[1])), part[1].min(ends[0].max(ends[1]))];
    }
    (part[0] <= part[1]).then_some(part)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::check::shapes::disc;
    use crate::grid::leaf_grid::LeafGrid;
    use crate::plane::Plane;

    #[test]
    fn samples_know_inside_from_outside() {
        let bounds = Bounds { min: DVec3::splat(-1.0), max: DVec3::splat(1.0) };
        for normal in [DVec3::Z, DVec3::new(0.3, -2.0, 0.4), DVec3::new(-1.0, 1.0, 1.0)] {
            let plane = Plane { normal, offset: 0.1 };
            let section = disc(plane, 0.5, 400, Label(3));
            let center = 0.1 / normal.length() * plane.unit_normal();
            let samples =
                plane_samples(&[section], (bounds, DVec3::ZERO), 0.02, Region::Everywhere);
            let area = crate::plane::polygon_area(&plane.polygon_in(bounds)) / (0.02 * 0.02);
            assert!((samples.len() as f64 / area - 1.0).abs() < 0.03, "{}", samples.len());
            for sample in samples {
                assert!(plane.distance(sample.at).abs() < 1e-12);
                let radius = sample.at.distance(center);
                if (radius - 0.5).abs() > 1e-3 {
                    assert_eq!(sample.label == Label(3), radius < 0.5, "{radius}");
                }
            }
        }
    }

    #[test]
    fn where_contours_touch_a_row_goes_on_with_the_right_label() {
        // From outside through something unknown into the label and out of it again; the
        // way in comes first by rounding.
        let crossing = |at, left, right| Crossing { at, left, right };
        let [outside, label] = [Label::OUTSIDE, Label(1)];
        let right = [
            crossing(-0.5, outside, Label::UNKNOWN),
            crossing(1.0, Label::UNKNOWN, outside),
            crossing(1.0 - 1e-16, outside, label),
            crossing(3.0, label, outside),
        ];
        let mut found = [right[0], right[2], right[1], right[3]];
        chain(&mut found, outside, 1e-9);
        let labels = |crossings: [Crossing; 4]| crossings.map(|one| [one.left, one.right]);
        assert_eq!(labels(found), labels(right));
        // Farther apart the order counts.
        let mut found = [right[0], crossing(0.9, outside, label), right[1], right[3]];
        chain(&mut found, outside, 1e-9);
        assert_eq!(found[1].at, 0.9);
    }

    #[test]
    fn nothing_is_said_of_what_is_unknown() {
        let bounds = Bounds { min: DVec3::splat(-1.0), max: DVec3::splat(1.0) };
        let plane = Plane { normal: DVec3::Z, offset: 0.0 };
        let section = disc(plane, 0.5, 400, Label(3));
        let unknown = section.relabelled(|label| match label {
            Label::OUTSIDE => Label::UNKNOWN,
            other => other,
        });
        let samples = plane_samples(&[unknown], (bounds, DVec3::ZERO), 0.05, Region::Everywhere);
        assert!(samples.iter().all(|one| one.label == Label(3)));
        // The disc: π 0.5² over 0.05² is 314.
        assert!((300..330).contains(&samples.len()), "{}", samples.len());
    }

    #[test]
    fn in_leaves_are_those_of_all_samples_that_lie_there() {
        let bounds = Bounds { min: DVec3::splat(-1.0), max: DVec3::splat(1.0) };
        let grid = LeafGrid::new([-64; 3], [64; 3]);
        let mut leaves = LeafSet::new(&grid);
        for leaf in grid.all_places().filter(|[x, y, z]| (3 * x + 5 * y + 7 * z) % 4 == 1) {
            leaves.insert(leaf);
        }
        // No sample lies where leaves meet, but for roundings of the shifted origin.
        let (origin, side) = (DVec3::new(0.013, -0.0171, 0.0057), 0.171);
        for normal in [DVec3::Z, DVec3::NEG_X, DVec3::new(0.3, -2.0, 0.4), DVec3::ONE] {
            let section = disc(Plane { normal, offset: 0.1 }, 0.5, 400, Label(3));
            let space = (bounds, DVec3::new(0.001, 0.2, -0.1));
            let samples =
                |region| plane_samples(std::slice::from_ref(&section), space, 0.02, region);
            let mut expected = samples(Region::Everywhere);
            expected.retain(|one| {
                let leaf = ((one.at - origin) / side).floor().to_array();
                leaves.has(leaf.map(|along| along as i32))
            });
            assert!(expected.len() > 500 && expected.len() < 5000, "{}", expected.len());
            assert_eq!(samples(Region::Leaves { leaves: &leaves, origin, side }), expected);
        }
    }
}
