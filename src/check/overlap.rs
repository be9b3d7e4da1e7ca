//! How well a section and the mesh's cut by its plane cover each other.

use std::collections::BTreeMap;
use std::ops::Range;

use glam::{DVec2, DVec3};
use serde::Serialize;

use crate::label::Label;
use crate::mesh::Mesh;
use crate::mesh::cut::Cut;
use crate::plane::Plane;
use crate::section::{Edge, Here, Section};

/// Pixels of one label on the section, on the mesh's cut, and on both.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize)]
pub struct Counts {
    /// Pixels on the section.
    pub section: u64,
    /// Pixels on the cut.
    pub mesh: u64,
    /// Pixels on both.
    pub both: u64,
}

impl Counts {
    /// 2 |A ∩ B| / (|A| + |B|), Dice's coefficient; `None` when both are
    /// empty.
    pub fn dice(&self) -> Option<f64> {
        let sum = self.section + self.mesh;
        (sum > 0).then(|| 2.0 * self.both as f64 / sum as f64)
    }

    /// Of several labels together.
    pub fn pooled<'a>(counts: impl IntoIterator<Item = &'a Self>) -> Self {
        counts.into_iter().fold(Self::default(), |sum, counts| Self {
            section: sum.section + counts.section,
            mesh: sum.mesh + counts.mesh,
            both: sum.both + counts.both,
        })
    }
}

/// Rasterises a section and the cut of the mesh by its plane with square
/// pixels (world units on a side), and counts each material's. A pixel has the
/// label of its centre. Where the section is unknown nothing counts.
pub fn overlap(section: &Section, mesh: &Mesh, pixel: f64) -> BTreeMap<Label, Counts> {
    let frame = Frame::new(section.plane(), pixel);
    let points: Vec<DVec3> =
        (0..section.vertices().len() as u32).map(|vertex| section.point(vertex)).collect();
    let Cut { points: cut_points, edges: cut_edges } = mesh.cut(section.plane());
    let mut rows = Rows::new();
    rows.add(Source::Section, section.edges(), &frame.place(&points));
    rows.add(Source::Mesh, &cut_edges, &frame.place(&cut_points));
    count(&rows, section.background())
}

/// Coordinates on a plane in pixels, counter-clockwise about its normal.
pub(super) struct Frame {
    /// Of the length of one over a pixel's.
    pub axes: [DVec3; 2],
}

impl Frame {
    pub(super) fn new(plane: &Plane, pixel: f64) -> Self {
        Self { axes: plane.tangents().map(|tangent| tangent / pixel) }
    }

    pub(super) fn place(&self, points: &[DVec3]) -> Vec<DVec2> {
        let [first, second] = self.axes;
        points.iter().map(|point| DVec2::new(point.dot(first), point.dot(second))).collect()
    }
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Source {
    Section,
    Mesh,
}

/// Along a row the label changes at a pixel.
#[derive(Debug, Clone, Copy)]
struct Change {
    /// The first pixel whose centre lies beyond.
    pixel: i64,
    source: Source,
    from: Label,
    to: Label,
}

/// Changes by row; the centre of pixel (i, j) is at (i + ½, j + ½).
pub(super) struct Rows {
    changes: BTreeMap<i64, Vec<Change>>,
}

impl Rows {
    pub(super) fn new() -> Self {
        Self { changes: BTreeMap::new() }
    }

    /// The rows whose centres lie in the half-open interval from an edge's
    /// lower to its higher end: a vertex on a row counts as above it, for all
    /// edges alike, so that what closes, closes on every row.
    pub(super) fn add(&mut self, source: Source, edges: &[Edge], points: &[DVec2]) {
        for edge in edges {
            let (start, end) = (points[edge.start as usize], points[edge.end as usize]);
            let upward = start.y < end.y;
            // Left of an upward edge is before it along the row.
            let (low, high, from, to) = if upward {
                (start, end, edge.left, edge.right)
            } else {
                (end, start, edge.right, edge.left)
            };
            for row in first_centre(low.y)..first_centre(high.y) {
                let fraction = (row as f64 + 0.5 - low.y) / (high.y - low.y);
                let pixel = first_centre(low.x + fraction * (high.x - low.x));
                self.changes.entry(row).or_default().push(Change { pixel, source, from, to });
            }
        }
    }

    /// The first row with a change, and how many rows there are to the last.
    pub(super) fn extent(&self) -> (i32, usize) {
        let ends = (self.changes.first_key_value(), self.changes.last_key_value());
        let (Some((&first, _)), Some((&last, _))) = ends else { return (0, 0) };
        (first as i32, (last - first) as usize + 1)
    }

    /// The pixels of materials in a row, where there is one source and it has
    /// this label far away.
    pub(super) fn spans(&self, row: i64, background: Label) -> Vec<(Label, Range<i32>)> {
        let mut changes = self.changes.get(&row).cloned().unwrap_or_default();
        changes.sort_by_key(|change| change.pixel);
        let mut here = Here::new(background);
        let mut spans: Vec<(Label, Range<i32>)> = Vec::new();
        for (place, change) in changes.iter().enumerate() {
            here.change(change.from, change.to);
            let next = changes.get(place + 1).map_or(change.pixel, |next| next.pixel);
            let (label, pixels) = (here.label(), change.pixel as i32..next as i32);
            match spans.last_mut() {
                _ if pixels.is_empty() || !label.is_material() => {}
                Some((last, known)) if *last == label && known.end == pixels.start => {
                    known.end = pixels.end;
                }
                _ => spans.push((label, pixels)),
            }
        }
        spans
    }
}

/// The first pixel whose centre is not before `at`.
fn first_centre(at: f64) -> i64 {
    (at - 0.5).ceil() as i64
}

fn count(rows: &Rows, background: Label) -> BTreeMap<Label, Counts> {
    let mut counts: BTreeMap<Label, Counts> = BTreeMap::new();
    for changes in rows.changes.values() {
        let mut changes = changes.clone();
        changes.sort_by_key(|change| change.pixel);
        let (mut section, mut mesh) = (Here::new(background), Here::new(Label::OUTSIDE));
        for (place, change) in changes.iter().enumerate() {
            match change.source {
                Source::Section => section.change(change.from, change.to),
                Source::Mesh => mesh.change(change.from, change.to),
            }
            let next = changes.get(place + 1).map_or(change.pixel, |next| next.pixel);
            let pixels = (next - change.pixel) as u64;
            if pixels > 0 && section.label() != Label::UNKNOWN {
                add(&mut counts, section.label(), mesh.label(), pixels);
            }
        }
    }
    counts.retain(|label, _| label.is_material());
    counts
}

fn add(counts: &mut BTreeMap<Label, Counts>, section: Label, mesh: Label, pixels: u64) {
    counts.entry(section).or_default().section += pixels;
    counts.entry(mesh).or_default().mesh += pixels;
    if section == mesh {
        counts.entry(section).or_default().both += pixels;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    use crate::check::shapes::polygon;
    use crate::mesh::shapes::solid;

    fn square(half: f64, center: DVec2) -> Vec<DVec2> {
        [[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]]
            .map(|corner| center + half * DVec2::from_array(corner))
            .to_vec()
    }

    #[test]
    fn squares_side_by_side_overlap_in_part() {
        // A section square [0, 4]² and a "cut" square [2, 6] × [0, 4] of
        // pixels: 16 each and 8 together.
        let mut rows = Rows::new();
        for (source, x) in [(Source::Section, 2.0), (Source::Mesh, 4.0)] {
            let points = square(2.0, DVec2::new(x, 2.0));
            let edges = polygon(4, Label(1));
            rows.add(source, &edges, &points);
        }
        let counts = count(&rows, Label::OUTSIDE)[&Label(1)];
        assert_eq!(counts, Counts { section: 16, mesh: 16, both: 8 });
        assert_eq!(counts.dice(), Some(0.5));
        assert_eq!(Counts::default().dice(), None);
    }

    #[test]
    fn vertices_on_rows_and_slanted_edges_lose_nothing() {
        // A diamond with corners at pixel centres: the half-open rule gives
        // it, for half-diagonal 4, rows of 0, 2, 4, 6, 8, 6, 4, 2 pixels: 32,
        // its area.
        let at = DVec2::splat(0.5);
        let corners = [[4.0, 0.0], [0.0, 4.0], [-4.0, 0.0], [0.0, -4.0]];
        let points: Vec<DVec2> = corners.map(|corner| at + DVec2::from_array(corner)).to_vec();
        let mut rows = Rows::new();
        rows.add(Source::Section, &polygon(4, Label(2)), &points);
        assert_eq!(count(&rows, Label::OUTSIDE)[&Label(2)].section, 32);
    }

    #[test]
    fn nothing_counts_where_the_section_is_unknown() {
        // Known only on [0, 4]², which is material; the cut covers more.
        let mut rows = Rows::new();
        let inside: Vec<Edge> = polygon(4, Label(1))
            .into_iter()
            .map(|edge| Edge { right: Label::UNKNOWN, ..edge })
            .collect();
        rows.add(Source::Section, &inside, &square(2.0, DVec2::splat(2.0)));
        rows.add(Source::Mesh, &polygon(4, Label(1)), &square(4.0, DVec2::splat(2.0)));
        let counts = count(&rows, Label::UNKNOWN)[&Label(1)];
        assert_eq!(counts, Counts { section: 16, mesh: 16, both: 16 });
    }

    #[test]
    fn a_ball_agrees_with_its_own_section_and_not_with_another() {
        let ball = solid(61, 1.0, |point| 0.8 - point.length());
        let plane = Plane { normal: DVec3::new(1.0, 2.0, 2.0), offset: 0.9 };
        let radius = (0.64f64 - 0.09).sqrt();
        for (scale, least, most) in [(1.0, 0.995, 1.0), (0.5, 0.39, 0.41)] {
            let section = crate::check::shapes::disc(plane, scale * radius, 300, Label(1));
            let dice = overlap(&section, &ball, 0.01)[&Label(1)].dice().unwrap();
            // A disc of half the radius: 2 · ¼ / (1 + ¼) = 0.4.
            assert!((least..=most).contains(&dice), "{dice}");
        }
    }
}
