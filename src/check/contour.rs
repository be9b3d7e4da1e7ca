//! How far the contours are from the surface.

use std::collections::BTreeMap;

use glam::{DVec2, DVec3};
use rayon::prelude::*;
use serde::Serialize;

use crate::error::Result;
use crate::label::Label;
use crate::mesh::Mesh;
use crate::mesh::nearest::Nearest;
use crate::section::{Edge, Section};
use crate::sets::components;

/// Beyond how many voxels a contour vertex counts as far from the surface,
/// and below which width a contour counts as thin.
pub const LIMIT: f64 = 2.0;

/// Contour vertices of one label on one section that have something in common.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Place {
    /// The section's name.
    pub section: String,
    /// The label that the contour bounds.
    pub label: u32,
    /// How many vertices.
    pub vertices: usize,
    /// The largest distance to the label's surface, in voxels; `None` where
    /// the mesh has none.
    pub distance: Option<f64>,
    /// Where that is, in world units.
    pub at: [f64; 3],
}

/// Distances from contour vertices to the surface of the label they bound.
/// A vertex between two materials is asked for both.
#[derive(Debug, Clone, Default, PartialEq, Serialize)]
pub struct Contours {
    /// Vertices that count.
    pub vertices: usize,
    /// The largest distance, in voxels, of all that count.
    pub largest: f64,
    /// The mean distance, in voxels, of all that count.
    pub mean: f64,
    /// Where the vertices beyond [`LIMIT`] are that count.
    pub far: Vec<Place>,
    /// Vertices beyond [`LIMIT`] that do not count, since the contour is
    /// thinner there than the lattice can show: no disc of two voxels' diameter
    /// within the label, or none within one other label, comes within one voxel
    /// of the vertex.
    pub thin: Vec<Place>,
    /// What of each label's contours the surface does not reach.
    #[serde(skip)]
    pub unreached: BTreeMap<Label, Unreached>,
}

/// What of a label's contours its surface does not come near to.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize)]
pub struct Unreached {
    /// Whole contours: connected lines around the label on a section, of which
    /// no vertex is within [`LIMIT`] of the surface.
    pub contours: usize,
    /// How long the edges are whose ends are both farther, in world units.
    pub length: f64,
    /// How much of that is where the contour is thin at both ends.
    pub thin_length: f64,
}

/// Measures all sections; `voxel` in world units.
pub fn contours(sections: &[Section], mesh: &Mesh, voxel: f64) -> Result<Contours> {
    let mut result = Contours::default();
    let mut sum = 0.0;
    for label in labels(sections) {
        let nearest = Nearest::on_border(mesh, label)?;
        let per_section: Vec<Measured> = sections
            .par_iter()
            .map(|section| measure(section, label, nearest.as_ref(), voxel))
            .collect::<Result<_>>()?;
        for measured in per_section {
            result.vertices += measured.vertices;
            sum += measured.sum;
            result.largest = result.largest.max(measured.largest);
            result.far.extend(measured.far);
            result.thin.extend(measured.thin);
            result.unreached.entry(label).or_default().add(measured.unreached);
        }
    }
    result.mean = if result.vertices > 0 { sum / result.vertices as f64 } else { 0.0 };
    Ok(result)
}

fn labels(sections: &[Section]) -> Vec<Label> {
    let mut labels: Vec<Label> = sections.iter().flat_map(Section::labels).collect();
    labels.retain(|label| label.is_material());
    labels.sort();
    labels.dedup();
    labels
}

/// One label on one section.
#[derive(Default)]
struct Measured {
    vertices: usize,
    sum: f64,
    largest: f64,
    far: Option<Place>,
    thin: Option<Place>,
    unreached: Unreached,
}

/// Where a contour vertex is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Reach {
    Near,
    Far,
    /// Far, and the contour is thin.
    Thin,
}

impl Unreached {
    fn add(&mut self, other: Self) {
        self.contours += other.contours;
        self.length += other.length;
        self.thin_length += other.thin_length;
    }

    /// Of a label on a section, from how far its vertices are, which are
    /// sorted.
    fn new(section: &Section, label: Label, vertices: &[u32], reach: &[Reach]) -> Self {
        let mut own = Self::default();
        let place = |vertex: u32| vertices.binary_search(&vertex).ok();
        let ends = known_edges(section, label).filter_map(|edge| {
            let ends = [place(edge.start)?, place(edge.end)?];
            let [start, end] = [edge.start, edge.end].map(|vertex| section.point(vertex));
            Some((ends, start.distance(end)))
        });
        let mut lines = Vec::new();
        for (ends, length) in ends {
            lines.push(ends.map(|end| end as u32));
            let reach = ends.map(|end| reach[end]);
            own.length += if reach.contains(&Reach::Near) { 0.0 } else { length };
            own.thin_length += if reach == [Reach::Thin; 2] { length } else { 0.0 };
        }
        let contour = components(vertices.len() as u32, lines.into_iter());
        let mut is_reached = vec![false; contour.iter().max().map_or(0, |&last| last as usize + 1)];
        for (&contour, &reach) in contour.iter().zip(reach) {
            is_reached[contour as usize] |= reach == Reach::Near;
        }
        own.contours = is_reached.iter().filter(|&&is_reached| !is_reached).count();
        own
    }
}

fn measure(
    section: &Section,
    label: Label,
    nearest: Option<&Nearest>,
    voxel: f64,
) -> Result<Measured> {
    let vertices = contour_vertices(section, label);
    let points: Vec<DVec3> = vertices.iter().map(|&vertex| section.point(vertex)).collect();
    let distances = match nearest {
        Some(nearest) => nearest.distances(&points)?,
        None => vec![f64::INFINITY; points.len()],
    };
    let mut measured = Measured::default();
    let around = Surroundings::new(section, voxel);
    let mut reach = Vec::with_capacity(vertices.len());
    for ((&vertex, point), distance) in vertices.iter().zip(points).zip(distances) {
        let distance = distance / voxel;
        let far = distance > LIMIT;
        let thin = far && around.is_thin(vertex, label);
        reach.push(if thin {
            Reach::Thin
        } else if far {
            Reach::Far
        } else {
            Reach::Near
        });
        if thin {
            note(&mut measured.thin, section, label, point, distance);
            continue;
        }
        if far {
            note(&mut measured.far, section, label, point, distance);
        }
        if distance.is_finite() {
            measured.vertices += 1;
            measured.sum += distance;
            measured.largest = measured.largest.max(distance);
        }
    }
    measured.unreached = Unreached::new(section, label, &vertices, &reach);
    Ok(measured)
}

/// The edges between a label and something known.
fn known_edges(section: &Section, label: Label) -> impl Iterator<Item = &Edge> {
    section
        .edges()
        .iter()
        .filter(move |edge| edge.left == label || edge.right == label)
        .filter(|edge| edge.left != Label::UNKNOWN && edge.right != Label::UNKNOWN)
}

/// The vertices of these edges, sorted.
fn contour_vertices(section: &Section, label: Label) -> Vec<u32> {
    let mut vertices: Vec<u32> =
        known_edges(section, label).flat_map(|edge| [edge.start, edge.end]).collect();
    vertices.sort_unstable();
    vertices.dedup();
    vertices
}

fn note(place: &mut Option<Place>, section: &Section, label: Label, point: DVec3, distance: f64) {
    let finite = distance.is_finite().then_some(distance);
    let place = place.get_or_insert_with(|| Place {
        section: section.name().to_owned(),
        label: label.0,
        vertices: 0,
        distance: finite,
        at: point.to_array(),
    });
    place.vertices += 1;
    if finite > place.distance {
        (place.distance, place.at) = (finite, point.to_array());
    }
}

/// A section laid out flat, in voxels.
struct Surroundings<'a> {
    section: &'a Section,
    /// The place (0, 0), in world units.
    origin: DVec3,
    /// The sides of a voxel, in world units.
    axes: [DVec3; 2],
    points: Vec<DVec2>,
}

impl<'a> Surroundings<'a> {
    fn new(section: &'a Section, voxel: f64) -> Self {
        let plane = section.plane();
        let [first, second] = plane.tangents().map(|tangent| tangent / voxel);
        let points = (0..section.vertices().len() as u32)
            .map(|vertex| section.point(vertex))
            .map(|point| DVec2::new(point.dot(first), point.dot(second)))
            .collect();
        let origin = -plane.distance(DVec3::ZERO) * plane.unit_normal();
        let axes = plane.tangents().map(|tangent| tangent * voxel);
        Self { section, origin, axes, points }
    }

    /// Whether the contour of `label` is thin at a vertex: no disc of
    /// [`LIMIT`] voxels' diameter that lies within `label`, or none that lies
    /// within one other label, comes within one voxel of the vertex. This is
    /// so at slivers, narrow gaps and small specks and holes, and at the tips
    /// of spikes of less than 60°, but not at other corners. What is unknown may
    /// be either.
    fn is_thin(&self, vertex: u32, label: Label) -> bool {
        const DIRECTIONS: u32 = 32;
        let radius = LIMIT / 2.0;
        let at = self.points[vertex as usize];
        let near = self.edges_within(at, 2.0 * radius + 1.0);
        let (mut fits_inside, mut fits_beside) = (false, false);
        for step in 0..=4 {
            let reach = radius + f64::from(step) / 4.0;
            for direction in 0..DIRECTIONS {
                let angle = std::f64::consts::TAU * f64::from(direction) / f64::from(DIRECTIONS);
                let centre = at + reach * DVec2::from_angle(angle);
                // A little less than the radius: along a straight contour the
                // disc touches it.
                if near.iter().all(|&edge| distance(centre, edge) > radius - 1e-3) {
                    let found = self.label_at(centre);
                    fits_inside |= found == label || found == Label::UNKNOWN;
                    fits_beside |= found != label;
                }
            }
        }
        !(fits_inside && fits_beside)
    }

    /// The edges between two known labels that come near to a point.
    fn edges_within(&self, at: DVec2, reach: f64) -> Vec<[DVec2; 2]> {
        let known = self.ends().filter(|(_, labels)| !labels.contains(&Label::UNKNOWN));
        known.map(|(ends, _)| ends).filter(|&ends| distance(at, ends) <= reach).collect()
    }

    /// The ends of every edge, with its labels left and right.
    fn ends(&self) -> impl Iterator<Item = ([DVec2; 2], [Label; 2])> {
        self.section.edges().iter().map(|edge| {
            let ends = [edge.start, edge.end].map(|vertex| self.points[vertex as usize]);
            (ends, [edge.left, edge.right])
        })
    }

    /// The label at a point.
    fn label_at(&self, at: DVec2) -> Label {
        let [first, second] = self.axes;
        let point = self.origin + at.x * first + at.y * second;
        self.section.label_at(self.section.plane().project(point))
    }
}

/// From a point to a segment.
fn distance(point: DVec2, [start, end]: [DVec2; 2]) -> f64 {
    let (along, offset) = (end - start, point - start);
    let fraction = (offset.dot(along) / along.length_squared()).clamp(0.0, 1.0);
    (offset - fraction * along).length()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::check::shapes::{disc, section};
    use crate::mesh::shapes::solid;
    use crate::plane::Plane;

    const FLOOR: Plane = Plane { normal: DVec3::Z, offset: 0.0 };

    /// Which corners of a polygon are thin, for voxels of side 1.
    fn thin_corners(corners: &[[f64; 2]]) -> Vec<bool> {
        let corners: Vec<DVec2> = corners.iter().map(|&corner| corner.into()).collect();
        let section = section(FLOOR, &corners, Label(1));
        let around = Surroundings::new(&section, 1.0);
        (0..corners.len() as u32).map(|vertex| around.is_thin(vertex, Label(1))).collect()
    }

    #[test]
    fn squares_are_thin_below_two_voxels() {
        let square =
            |side: f64| thin_corners(&[[0.0, 0.0], [side, 0.0], [side, side], [0.0, side]]);
        assert_eq!(square(2.5), [false; 4]);
        assert_eq!(square(1.8), [true; 4]);
        // Rays through its tips enter and leave it at once.
        assert_eq!(thin_corners(&[[0.0, 0.0], [1.8, 1.2], [1.4, 1.4], [1.3, 1.3]]), [true; 4]);
    }

    #[test]
    fn a_sliver_and_a_spike_are_thin_and_what_they_grow_from_is_not() {
        // A square of side 8 with a sliver one voxel wide at its right end.
        let thin = thin_corners(&[
            [0.0, 0.0],
            [8.0, 0.0],
            [8.0, 4.0],
            [14.0, 4.0],
            [14.0, 5.0],
            [8.0, 5.0],
            [8.0, 8.0],
            [0.0, 8.0],
        ]);
        assert_eq!(thin, [false, false, false, true, true, false, false, false]);
        let spike = thin_corners(&[[0.0, 0.0], [20.0, 0.0], [10.0, 30.0]]);
        assert_eq!(spike, [false, false, true]);
    }

    #[test]
    fn a_slot_is_a_thin_gap() {
        // A slot one voxel wide, open at the top, in a square of side 9.
        let thin = thin_corners(&[
            [0.0, 0.0],
            [9.0, 0.0],
            [9.0, 9.0],
            [5.0, 9.0],
            [5.0, 4.0],
            [4.0, 4.0],
            [4.0, 9.0],
            [0.0, 9.0],
        ]);
        assert_eq!(thin, [false, false, false, false, true, true, false, false]);
    }

    #[test]
    fn what_is_unknown_makes_nothing_thin() {
        // A strip one voxel wide, beyond whose lower side nothing is known.
        let corners = [[0.0, 0.0], [20.0, 0.0], [20.0, 1.0], [0.0, 1.0]].map(DVec2::from);
        let mut section = section(FLOOR, &corners, Label(1));
        assert!((0..4).all(|vertex| Surroundings::new(&section, 1.0).is_thin(vertex, Label(1))));
        section.vertices.extend([[25.0, -9.0], [-5.0, -9.0]].map(DVec2::from));
        section.edges[0].right = Label::UNKNOWN;
        let around = [[1, 4], [4, 5], [5, 0]];
        section.edges.extend(around.map(|[start, end]| crate::section::Edge {
            start,
            end,
            left: Label::OUTSIDE,
            right: Label::UNKNOWN,
        }));
        let known = Surroundings::new(&section, 1.0);
        assert!(!known.is_thin(2, Label(1)) && !known.is_thin(3, Label(1)));
    }

    #[test]
    fn contours_on_a_ball_are_near_and_others_are_as_far_as_they_are() {
        let ball = solid(61, 1.0, |point| 0.8 - point.length());
        let voxel = 2.0 / 60.0;
        let on = contours(&[disc(FLOOR, 0.8, 100, Label(1))], &ball, voxel).unwrap();
        assert_eq!((on.vertices, on.far.len(), on.thin.len()), (100, 0, 0));
        assert!(on.largest < 0.1 && on.mean <= on.largest, "{on:?}");
        let within = contours(&[disc(FLOOR, 0.6, 100, Label(1))], &ball, voxel).unwrap();
        assert!((within.largest - 0.2 / voxel).abs() < 0.1 && within.mean > 5.9);
        assert_eq!((within.far[0].vertices, within.far[0].label), (100, 1));
    }

    #[test]
    fn a_speck_is_listed_and_a_label_without_surface_too() {
        let ball = solid(31, 1.0, |point| 0.8 - point.length());
        let voxel = 2.0 / 30.0;
        let speck = disc(FLOOR, 0.9 * voxel, 12, Label(1));
        let found = contours(&[speck], &ball, voxel).unwrap();
        assert_eq!((found.vertices, found.far.len(), found.thin[0].vertices), (0, 0, 12));
        let absent = disc(FLOOR, 0.5, 12, Label(7));
        let found = contours(&[absent], &ball, voxel).unwrap();
        assert_eq!((found.far[0].distance, found.far[0].vertices), (None, 12));
        // The outline of a regular polygon of 12 corners.
        let around = 24.0 * (std::f64::consts::PI / 12.0).sin();
        let lost = found.unreached[&Label(7)];
        assert!((lost.length - 0.5 * around).abs() < 1e-12);
        assert_eq!((lost.contours, lost.thin_length), (1, 0.0));
    }

    #[test]
    fn what_the_surface_does_not_reach_is_told_by_its_length() {
        // On a section of a ball of radius 0.8 a polygon with two corners on the
        // ball and two far from it, which are thin no more than those, and a speck
        // beside that is lost as a whole, thin all over.
        let ball = solid(31, 1.0, |point| 0.8 - point.length());
        let voxel = 2.0 / 30.0;
        let corners = [[0.8, 0.0], [3.0, -0.5], [3.0, 0.5], [0.0, 0.8]].map(DVec2::from);
        let mut both = section(FLOOR, &corners, Label(1));
        let speck = disc(FLOOR, 0.9 * voxel, 12, Label(1));
        both.vertices.extend(speck.vertices.iter().map(|vertex| vertex + DVec2::new(-2.0, 0.0)));
        both.edges.extend(speck.edges.iter().map(|edge| Edge {
            start: edge.start + 4,
            end: edge.end + 4,
            ..*edge
        }));
        let lost = contours(&[both], &ball, voxel).unwrap().unreached[&Label(1)];
        let outline = 24.0 * (std::f64::consts::PI / 12.0).sin() * 0.9 * voxel;
        // Only the side between the two far corners has both ends out of reach.
        assert!((lost.length - (1.0 + outline)).abs() < 1e-9, "{lost:?}");
        assert!((lost.thin_length - outline).abs() < 1e-9, "{lost:?}");
        assert_eq!(lost.contours, 1);
    }
}
