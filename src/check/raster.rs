//! Sections as pixels, and the regions that pixels show.

use std::collections::{BTreeMap, BTreeSet};

use glam::DVec3;

use super::overlap::{Frame, Rows, Source};
use crate::grid::runs::{Neighbors, Run, Runs};
use crate::label::Label;
use crate::mesh::cut::Cut;
use crate::plane::Plane;
use crate::section::{Edge, Section};

/// The materials of a section in square pixels; a pixel has the label of its
/// centre.
pub struct Raster {
    plane: Plane,
    /// What the pixels' coordinates count from.
    origin: DVec3,
    /// The sides of a pixel.
    sides: [DVec3; 2],
    /// The number of the first row.
    first: i32,
    runs: Runs<Label>,
    /// The region of each run.
    region_of: Vec<u32>,
}

/// A connected part of one label in a raster.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Region {
    /// Its label.
    pub label: Label,
    /// How many pixels it has.
    pub pixels: u64,
    /// The middle of its longest row.
    pub at: DVec3,
}

/// Pixels that two rasters have in common.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Common {
    /// How many.
    pub pixels: u64,
    /// The length of their longest row.
    longest: i32,
    /// Its middle.
    pub at: DVec3,
}

impl Common {
    fn add(&mut self, length: i32, middle: impl Fn() -> DVec3) {
        self.pixels += length as u64;
        if length > self.longest {
            (self.longest, self.at) = (length, middle());
        }
    }
}

impl Raster {
    /// Of a section; `origin`, `direction` and `pixel` say where the pixels
    /// are, so that those of parallel sections lie upon each other.
    pub fn new(section: &Section, direction: DVec3, origin: DVec3, pixel: f64) -> Self {
        let points = (0..section.vertices().len() as u32).map(|vertex| section.point(vertex));
        let points: Vec<DVec3> = points.collect();
        let is_turned = section.plane().normal.dot(direction) < 0.0;
        let edges = seen(section.edges(), is_turned);
        let upward = Plane { normal: direction, offset: 0.0 };
        let blank = Self {
            plane: *section.plane(),
            origin,
            sides: upward.tangents().map(|tangent| pixel * tangent),
            first: 0,
            runs: Runs::new([1, 0], |_, _| {}),
            region_of: Vec::new(),
        };
        blank.drawn(&edges, &points, section.background())
    }

    /// Of a mesh's cut by the same plane, as seen from where its normal points, in the same pixels.
    pub fn of_cut(&self, cut: &Cut) -> Self {
        let blank = Self { runs: Runs::new([1, 0], |_, _| {}), region_of: Vec::new(), ..*self };
        blank.drawn(&cut.edges, &cut.points, Label::OUTSIDE)
    }

    fn drawn(mut self, edges: &[Edge], points: &[DVec3], background: Label) -> Self {
        let points: Vec<DVec3> = points.iter().map(|&point| point - self.origin).collect();
        let axes = self.sides.map(|side| side / side.length_squared());
        let mut rows = Rows::new();
        rows.add(Source::Section, edges, &Frame { axes }.place(&points));
        let (first, dims) = rows.extent();
        self.first = first;
        self.runs = Runs::new([1, dims], |[_, row], runs| {
            let spans = rows.spans(i64::from(first) + row as i64, background);
            runs.extend(spans.into_iter().map(|(label, pixels)| Run {
                start: pixels.start,
                end: pixels.end,
                label,
            }));
        });
        self.region_of = self.runs.parts(Neighbors::All);
        self
    }

    /// The same with regions that are joined by sides of pixels, and not by corners alone.
    pub fn joined_by_sides(mut self) -> Self {
        self.region_of = self.runs.parts(Neighbors::Six);
        self
    }

    /// The side of a pixel.
    pub fn pixel(&self) -> f64 {
        self.sides[0].length()
    }

    /// The region at a place, as seen along the pixels' direction, and its label.
    pub fn region_at(&self, place: DVec3) -> Option<(u32, Label)> {
        let [x, y] = self
            .sides
            .map(|side| ((place - self.origin).dot(side) / side.length_squared()).floor() as i64);
        let row = usize::try_from(y - i64::from(self.first)).ok();
        let own = self.runs.row(row.filter(|&row| row < self.runs.dims[1])?);
        let runs = &self.runs.runs[own.clone()];
        let at = runs.partition_point(|run| i64::from(run.end) <= x);
        let run = runs.get(at).filter(|run| i64::from(run.start) <= x)?;
        Some((self.region_of[own.start + at], run.label))
    }

    /// The pairs of labels that have pixels next to each other, if only at corners.
    pub fn neighbors(&self) -> BTreeSet<[Label; 2]> {
        let mut found = BTreeSet::new();
        for row in 0..self.runs.dims[1] {
            let own = &self.runs.runs[self.runs.row(row)];
            let next = match row + 1 < self.runs.dims[1] {
                true => &self.runs.runs[self.runs.row(row + 1)],
                false => &[],
            };
            for one in own {
                let others = own.iter().chain(next);
                let near = others.filter(|other| other.start <= one.end && one.start <= other.end);
                let different = near.filter(|other| other.label != one.label);
                found.extend(
                    different.map(|other| [one.label.min(other.label), one.label.max(other.label)]),
                );
            }
        }
        found
    }

    /// What every region has in common with every label of another raster in the same pixels: how
    /// many of them, and the middle of their longest row.
    pub fn common(&self, other: &Self) -> BTreeMap<(u32, Label), Common> {
        let mut found: BTreeMap<(u32, Label), Common> = BTreeMap::new();
        for row in 0..self.runs.dims[1] {
            let there = i64::from(self.first) + row as i64 - i64::from(other.first);
            let there = usize::try_from(there).ok().filter(|&there| there < other.runs.dims[1]);
            let Some(there) = there else { continue };
            for own in self.runs.row(row) {
                let run = self.runs.runs[own];
                for two in &other.runs.runs[other.runs.row(there)] {
                    let (start, end) = (run.start.max(two.start), run.end.min(two.end));
                    if start < end {
                        let common = found.entry((self.region_of[own], two.label)).or_default();
                        common.add(end - start, || self.center(row, start.midpoint(end)));
                    }
                }
            }
        }
        found
    }

    /// The regions, by number.
    pub fn regions(&self) -> Vec<Region> {
        let count = self.region_of.iter().max().map_or(0, |&last| last as usize + 1);
        let mut pixels = vec![0; count];
        let mut longest = vec![usize::MAX; count];
        for (index, (run, &region)) in self.runs.runs.iter().zip(&self.region_of).enumerate() {
            pixels[region as usize] += run.len();
            let best = &mut longest[region as usize];
            if *best == usize::MAX || run.len() > self.runs.runs[*best].len() {
                *best = index;
            }
        }
        let region = |(index, pixels): (usize, u64)| {
            let run = &self.runs.runs[index];
            let at = self.center(self.runs.row_of(index)[1], run.start.midpoint(run.end));
            Region { label: run.label, pixels, at }
        };
        longest.into_iter().zip(pixels).map(region).collect()
    }

    /// The centre of every pixel, with the number of its region and its label.
    pub fn pixels(&self) -> impl Iterator<Item = (u32, Label, DVec3)> {
        (0..self.runs.dims[1]).flat_map(move |row| {
            self.runs.row(row).flat_map(move |index| {
                let Run { start, end, label } = self.runs.runs[index];
                let region = self.region_of[index];
                (start..end).map(move |pixel| (region, label, self.center(row, pixel)))
            })
        })
    }

    fn center(&self, row: usize, pixel: i32) -> DVec3 {
        let [x, y] = [pixel, self.first + row as i32].map(|at| f64::from(at) + 0.5);
        let point = self.origin + x * self.sides[0] + y * self.sides[1];
        point - self.plane.distance(point) * self.plane.unit_normal()
    }

    /// How many pixels regions have in common with those of another section
    /// that have the same label: by their numbers here and there.
    pub fn overlaps(&self, other: &Self) -> BTreeMap<[u32; 2], u64> {
        let mut pixels = BTreeMap::new();
        for row in 0..self.runs.dims[1] {
            let there = i64::from(self.first) + row as i64 - i64::from(other.first);
            let Ok(there) = usize::try_from(there) else { continue };
            if there >= other.runs.dims[1] {
                break;
            }
            let both =
                self.runs.touching(self.runs.row(row), &other.runs, other.runs.row(there), 0);
            for [own, others] in both {
                let (one, two) = (self.runs.runs[own as usize], other.runs.runs[others as usize]);
                let common = (one.end.min(two.end) - one.start.max(two.start)) as u64;
                let regions = [self.region_of[own as usize], other.region_of[others as usize]];
                *pixels.entry(regions).or_default() += common;
            }
        }
        pixels
    }
}

/// Edges as seen from where their plane's normal points, or from behind.
fn seen(edges: &[Edge], from_behind: bool) -> Vec<Edge> {
    let turned = |edge: &Edge| match from_behind {
        true => Edge { left: edge.right, right: edge.left, ..*edge },
        false => *edge,
    };
    edges.iter().map(turned).collect()
}

#[cfg(test)]
mod tests {
    use glam::DVec2;

    use super::*;
    use crate::check::shapes::{disc, section};

    /// A square of side 4 with a corner at (x, 0) at a height.
    fn square(x: f64, height: f64, normal: DVec3) -> Section {
        let offset = height * normal.z;
        let corners = [[0.0, 0.0], [4.0, 0.0], [4.0, 4.0], [0.0, 4.0]];
        let plane = Plane { normal, offset };
        let [first, second] = plane.tangents();
        let place = |[a, b]: [f64; 2]| {
            let point = DVec3::new(x + a, b, 0.0);
            DVec2::new(point.dot(first), point.dot(second))
        };
        let mut corners = corners.map(place).to_vec();
        if normal.z < 0.0 {
            corners.reverse();
        }
        section(plane, &corners, Label(2))
    }

    fn raster(section: &Section) -> Raster {
        Raster::new(section, DVec3::Z, DVec3::new(0.01, 0.01, 0.0), 0.5)
    }

    #[test]
    fn squares_above_each_other_overlap_whatever_their_normals() {
        let below = raster(&square(0.0, 1.0, DVec3::Z));
        for normal in [DVec3::Z, -DVec3::Z] {
            let above = raster(&square(1.0, 2.0, normal));
            let [region] = above.regions()[..] else { panic!("one square") };
            assert_eq!((region.label, region.pixels), (Label(2), 64));
            assert!((region.at.z - 2.0).abs() < 1e-12);
            // 3 × 4 units of 2 × 2 pixels are in both.
            assert_eq!(below.overlaps(&above), BTreeMap::from([([0, 0], 48)]));
            let inside = |(_, _, point): (u32, Label, DVec3)| {
                (1.0..5.0).contains(&point.x) && (0.0..4.0).contains(&point.y)
            };
            assert_eq!(above.pixels().filter(|&pixel| inside(pixel)).count(), 64);
        }
        assert!(below.overlaps(&raster(&square(5.0, 2.0, DVec3::Z))).is_empty());
    }

    #[test]
    fn a_slanted_disc_has_its_area_in_pixels() {
        let plane = Plane { normal: DVec3::new(1.0, -2.0, 2.0), offset: 3.0 };
        let raster =
            Raster::new(&disc(plane, 2.0, 400, Label(1)), plane.unit_normal(), DVec3::ONE, 0.05);
        let area = 0.0025 * raster.regions()[0].pixels as f64;
        assert!((area / (4.0 * std::f64::consts::PI) - 1.0).abs() < 0.01, "{area}");
        assert!(raster.pixels().all(|(_, _, point)| plane.distance(point).abs() < 1e-12));
    }
}
