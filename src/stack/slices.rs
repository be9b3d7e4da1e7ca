//! The slices of a stack, and what they say as images: pixels are as large as voxels, and where
//! a stack lies along an axis they are columns of the lattice.

use glam::{DVec2, DVec3};
use rayon::prelude::*;

use crate::error::{Error, Result};
use crate::grid::samples::Lattice;
use crate::label::Label;
use crate::plane::Bounds;
use crate::section::{Section, Stack};
use crate::segments::{Hint, SegmentTree};
use crate::variational::plane_samples::{Region, plane_samples};

use super::filter::Image;
use super::parts::Part;

/// Fewer have nothing between them.
const FEWEST: usize = 2;
/// Pixels around the lattice, for rounding.
const MARGIN: i32 = 1;

/// Parallel sections that know all of their planes, with images over the same rectangle.
#[derive(Debug)]
pub struct Slices<'a> {
    sections: Vec<&'a Section>,
    /// The numbers of the first and the last.
    ends: [usize; 2],
    /// Along the normal, in voxels; they increase.
    pub heights: Vec<f64>,
    normal: DVec3,
    /// The directions of rows and columns.
    sides: [DVec3; 2],
    /// In world units: the pixel (0, 0) is above it.
    origin: DVec3,
    voxel: f64,
    /// The first pixel, and how many there are, along either side.
    first: [i32; 2],
    count: [usize; 2],
}

/// A place in a stack.
#[derive(Debug, Clone, Copy)]
pub struct Place {
    /// In pixels from the first one.
    pub pixel: DVec2,
    /// In voxels.
    pub height: f64,
}

impl<'a> Slices<'a> {
    /// Of sections, with images over all of a lattice.
    ///
    /// # Errors
    /// When fewer than two are parallel, one is not, something on one is unknown, or two are at
    /// one height.
    pub fn new(sections: &'a [Section], lattice: &Lattice) -> Result<Self> {
        let refuse = |section: &Section, what: &str| {
            let what = format!("{what}: choose another method");
            Err(Error::Section { section: section.name().to_owned(), what })
        };
        if let Some(section) = sections.iter().find(|section| section.is_partial()) {
            return refuse(section, "a part of its plane is unknown, and a stack needs all of it");
        }
        if sections.len() < FEWEST {
            let what = "a stack needs two parallel sections at least: choose another method";
            return Err(Error::Option(what.to_owned()));
        }
        let Some(stack) = Stack::of(sections, FEWEST) else {
            let is_other = |section: &&Section| {
                Stack::of(&[sections[0].clone(), (*section).clone()], FEWEST).is_none()
            };
            let other = sections.iter().find(is_other).unwrap_or(&sections[0]);
            let what = format!(
                "it is not parallel to {}, and a stack has parallel sections",
                sections[0].name()
            );
            return refuse(other, &what);
        };
        let ends = [stack.order[0], stack.order[stack.order.len() - 1]];
        let sections: Vec<&Section> = stack.order.iter().map(|&own| &sections[own]).collect();
        let &Lattice { origin, voxel, .. } = lattice;
        let heights: Vec<f64> =
            stack.heights.iter().map(|height| (height - stack.height(origin)) / voxel).collect();
        if let Some(lower) = heights.windows(2).position(|pair| pair[0] >= pair[1]) {
            return refuse(
                sections[lower],
                &format!("{} lies on the same plane", sections[lower + 1].name()),
            );
        }
        let sides = sections[0].plane().sides();
        let end = lattice.dims.map(|nodes| nodes - 1);
        let corners = (0..8).map(|corner| {
            let node =
                std::array::from_fn(|axis| if corner >> axis & 1 == 1 { end[axis] } else { 0 });
            let place = (lattice.position(node) - origin) / voxel;
            DVec2::new(place.dot(sides[0]), place.dot(sides[1]))
        });
        let start = [DVec2::INFINITY, DVec2::NEG_INFINITY];
        let [low, high] = corners.fold(start, |[low, high], at| [low.min(at), high.max(at)]);
        let first = low.to_array().map(|along| along.round() as i32 - MARGIN);
        let last = high.to_array().map(|along| along.round() as i32 + MARGIN);
        let count = [0, 1].map(|axis| (last[axis] - first[axis]) as usize + 1);
        let normal = stack.direction;
        Ok(Self { sections, ends, heights, normal, sides, origin, voxel, first, count })
    }

    /// The first section and the last, by their indices.
    pub fn ends(&self) -> [usize; 2] {
        self.ends
    }

    /// How many pixels an image has.
    pub fn pixels(&self) -> usize {
        self.count[0] * self.count[1]
    }

    /// The pixels of a row.
    pub fn width(&self) -> usize {
        self.count[0]
    }

    /// Where a point is.
    pub fn place(&self, point: DVec3) -> Place {
        let offset = (point - self.origin) / self.voxel;
        let along = self.sides.map(|side| offset.dot(side));
        let first = DVec2::from_array(self.first.map(f64::from));
        Place { pixel: DVec2::from_array(along) - first, height: offset.dot(self.normal) }
    }

    /// A pixel of a slice in space.
    fn point(&self, slice: usize, pixel: [i32; 2]) -> DVec3 {
        self.point_at(slice, DVec2::from_array(pixel.map(f64::from)))
    }

    /// The same of any place on a slice, in pixels.
    pub fn point_at(&self, slice: usize, pixel: DVec2) -> DVec3 {
        let DVec2 { x, y } = pixel + DVec2::from_array(self.first.map(f64::from));
        let along = x * self.sides[0] + y * self.sides[1];
        self.origin + self.voxel * (along + self.heights[slice] * self.normal)
    }

    /// What a slice is called.
    pub fn name(&self, slice: usize) -> &str {
        self.sections[slice].name()
    }

    /// A voxel's side in world units.
    pub fn voxel(&self) -> f64 {
        self.voxel
    }

    /// What a slice says at every pixel.
    pub fn labels(&self, slice: usize) -> Vec<Label> {
        let section = self.sections[slice];
        let mut labels = vec![section.background(); self.pixels()];
        let last = self.count.map(|count| count as i32 - 1);
        let corners =
            [[0, 0], [last[0], 0], [0, last[1]], last].map(|pixel| self.point(slice, pixel));
        let Some(bounds) = Bounds::around(corners) else { return labels };
        let bounds = Bounds { min: bounds.min - self.voxel, max: bounds.max + self.voxel };
        let space = (bounds, self.origin);
        let section = std::slice::from_ref(section);
        for sample in plane_samples(section, space, self.voxel, Region::Everywhere) {
            let [x, y] = self.place(sample.at).pixel.round().to_array().map(|at| at as i64);
            let is_here =
                (0..self.count[0] as i64).contains(&x) && (0..self.count[1] as i64).contains(&y);
            if is_here {
                labels[y as usize * self.count[0] + x as usize] = sample.label;
            }
        }
        labels
    }

    /// How far every pixel of a slice is from the contours of a label, in pixels: positive where
    /// it is. `None` without contours.
    pub fn distances(&self, slice: usize, label: Label, labels: &[Label]) -> Option<Image> {
        let section = self.sections[slice];
        let edges = section.edges().iter().filter(|edge| [edge.left, edge.right].contains(&label));
        let segments: Vec<[DVec3; 2]> =
            edges.map(|edge| [edge.start, edge.end].map(|end| section.point(end))).collect();
        if segments.is_empty() {
            return None;
        }
        let tree = SegmentTree::new(segments);
        let row = |(y, labels): (usize, &[Label])| {
            let mut hint = Hint::default();
            let distance = |(x, &own): (usize, &Label)| {
                let point = self.point(slice, [x as i32, y as i32]);
                let distance = (tree.distance(point, &mut hint) / self.voxel) as f32;
                if own == label { distance } else { -distance }
            };
            labels.iter().enumerate().map(distance).collect::<Vec<f32>>()
        };
        let rows = labels.par_chunks(self.count[0]).enumerate().flat_map_iter(row);
        Some(Image { width: self.count[0], values: rows.collect() })
    }

    /// How far pixels of a rectangle are from the contours of a part of a slice alone, smoothed
    /// as distances on the slice are. `None` without contours.
    pub fn distances_of(
        &self,
        slice: usize,
        part: &Part,
        first: [i32; 2],
        [width, height]: [usize; 2],
    ) -> Option<Image> {
        let section = self.sections[slice];
        let edges = section.edges().iter();
        let edges = edges.filter(|edge| [edge.left, edge.right].contains(&part.label));
        let segments = edges.map(|edge| [edge.start, edge.end].map(|end| section.point(end)));
        // A contour passes between pixels of its part and others.
        let is_own = |[start, end]: &[DVec3; 2]| {
            let [x, y] = self.place(0.5 * (start + end)).pixel.round().to_array();
            let [x, y] = [x as i32, y as i32];
            (-1..=1).any(|up| (-1..=1).any(|right| part.has([x + right, y + up])))
        };
        let segments: Vec<[DVec3; 2]> = segments.filter(is_own).collect();
        if segments.is_empty() {
            return None;
        }
        let tree = SegmentTree::new(segments);
        let row = |up: usize| {
            let mut hint = Hint::default();
            let distance = |right: usize| {
                let pixel = [first[0] + right as i32, first[1] + up as i32];
                let distance = tree.distance(self.point(slice, pixel), &mut hint) / self.voxel;
                (if part.has(pixel) { distance } else { -distance }) as f32
            };
            (0..width).map(distance).collect::<Vec<f32>>()
        };
        let values = (0..height).into_par_iter().flat_map_iter(row).collect();
        let longest = self.count[0].max(self.count[1]);
        Some(Image { width, values }.filtered_as(longest))
    }
}
