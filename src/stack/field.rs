//! The field of one label in a stack.

use glam::DVec3;
use rayon::prelude::*;

use crate::error::Result;
use crate::grid::assembly::{FAR, NodeField, middle};
use crate::grid::invariant::node_of;
use crate::grid::leaf::LeafNodes;
use crate::grid::leaf_grid::{LeafGrid, NO_SLOT};
use crate::grid::samples::{LEAF_NODES, Lattice};
use crate::label::Label;

use super::slices::{Place, Slices};
use super::spline::Spline;
use super::tube::Tube;

/// How far a label leads or falls behind within a tube and beside it at most, in voxels. That
/// is nearer than samples give a label up.
const MOST_DEPTH: f64 = 7.0;

/// A tube near a place: its label, how deep the place is in it, and whether it owns the column.
type Near = (Label, f64, bool);

/// Half a leaf's diagonal, in halves of a voxel.
const STEPS: i32 = 14;

/// The signed distances to a label's contours on all slices, interpolated.
pub struct Columns<'a> {
    label: Label,
    slices: &'a Slices<'a>,
    spline: &'a Spline,
    /// How far it is rounded beyond the first slice and beyond the last, in voxels.
    radii: [f64; 2],
    /// For every slice and every pixel the distance, and the slope of its column.
    values: Vec<Vec<f32>>,
    slopes: Vec<Vec<f32>>,
}

/// A label's columns among those of all labels, with its tubes.
pub struct StackField<'a> {
    /// Which of all columns are its own.
    own: usize,
    all: &'a [Columns<'a>],
    /// Those between each slice and the next.
    tubes: &'a [Vec<Tube>],
    lattice: Lattice,
    grid: LeafGrid,
}

impl<'a> Columns<'a> {
    /// Of a label; `labels` are those of every slice's pixels.
    ///
    /// # Errors
    /// When it is cancelled.
    pub fn new(
        (slices, spline): (&'a Slices<'a>, &'a Spline),
        label: Label,
        labels: &[Vec<Label>],
        radii: [f64; 2],
        go_on: impl Fn() -> Result<()>,
    ) -> Result<Self> {
        let mut drawn = Vec::with_capacity(labels.len());
        for (slice, labels) in labels.iter().enumerate() {
            go_on()?;
            drawn.push(slices.distances(slice, label, labels).map(|image| image.filtered().values));
        }
        let missing: Vec<Option<Vec<f32>>> = (0..labels.len())
            .map(|slice| {
                let is_all = || labels[slice].contains(&label);
                drawn[slice].is_none().then(|| undrawn(slice, &drawn, &slices.heights, is_all()))
            })
            .collect();
        let both = drawn.into_iter().zip(missing);
        let values: Vec<Vec<f32>> = both.filter_map(|(own, missing)| own.or(missing)).collect();
        go_on()?;
        let slopes = slopes(spline, &values, slices.pixels());
        Ok(Self { label, slices, spline, radii, values, slopes })
    }

    /// The value at a place: of its column, or between the four around it.
    fn value(&self, Place { pixel: at, height }: Place) -> f64 {
        let low = at.floor();
        let part = at - low;
        let span = self.spline.place(height);
        let (width, rows) = (self.slices.width(), self.slices.pixels() / self.slices.width());
        let pixel = |right: usize, up: usize| {
            let x = (low.x.max(0.0) as usize + right).min(width - 1);
            let y = (low.y.max(0.0) as usize + up).min(rows - 1);
            y * width + x
        };
        let column = |right: usize, up: usize| {
            let pixel = pixel(right, up);
            let of =
                |images: &[Vec<f32>]| [0, 1].map(|next| f64::from(images[span.0 + next][pixel]));
            self.spline.value(span, of(&self.values), of(&self.slopes))
        };
        let between = |column: &dyn Fn(usize, usize) -> f64| {
            let mut sum = 0.0;
            for (right, along) in [(0, 1.0 - part.x), (1, part.x)] {
                for (up, across) in [(0, 1.0 - part.y), (1, part.y)] {
                    if along * across > 0.0 {
                        sum += along * across * column(right, up);
                    }
                }
            }
            sum
        };
        let own = between(&column);
        let heights = self.spline.heights();
        let beyond = [heights[0] - height, height - heights[heights.len() - 1]];
        let Some(end) = beyond.iter().position(|&beyond| beyond > 0.0) else { return own };
        let slope = between(&|right, up| {
            f64::from(self.slopes[end * (heights.len() - 1)][pixel(right, up)])
        });
        // Of the solid, inward positive, and outward: away from the stack.
        let sign = if self.label == Label::OUTSIDE { -1.0 } else { 1.0 };
        let narrowing = (sign * if end == 0 { -slope } else { slope }).min(0.0);
        sign * rounded(sign * own + narrowing * beyond[end], beyond[end], self.radii[end])
    }
}

impl<'a> StackField<'a> {
    /// Of the label that has the `own` columns among those of all.
    pub fn new(
        own: usize,
        all: &'a [Columns<'a>],
        tubes: &'a [Vec<Tube>],
        lattice: Lattice,
    ) -> Self {
        Self { own, all, tubes, lattice, grid: LeafGrid::new([0; 3], lattice.dims) }
    }

    fn place(&self, point: DVec3) -> Place {
        self.all[self.own].slices.place(point)
    }

    /// The value at a place: that of the columns, or, where a tube passes, such a one that the
    /// label wins within the tube and nothing changes beside it.
    fn value(&self, place: Place) -> f64 {
        let columns = &self.all[self.own];
        let Some((interval, part)) = columns.spline.place_within(place.height) else {
            return columns.value(place);
        };
        let near = |tube: &Tube| {
            let owns = tube.owns(place.pixel);
            let depth = tube.depth(place.pixel, part).or(owns.then_some(-MOST_DEPTH))?;
            Some((tube.label, depth.clamp(-MOST_DEPTH, MOST_DEPTH), owns))
        };
        let tubes: Vec<Near> = self.tubes[interval].iter().filter_map(near).collect();
        match (tubes.is_empty(), self.all.len()) {
            (true, _) => columns.value(place),
            (_, 1) => self.alone(place, &tubes),
            _ => self.among_others(place, &tubes),
        }
    }

    /// The value of the only label near tubes. Outside has no columns then, and its holes are
    /// where there is nothing.
    fn alone(&self, place: Place, tubes: &[Near]) -> f64 {
        let columns = &self.all[self.own];
        tubes.iter().fold(columns.value(place), |value, &(label, depth, owns)| {
            match (label == columns.label, owns) {
                (true, true) => depth,
                (true, false) => value.max(depth),
                (false, true) => -depth,
                (false, false) => value.min(-depth),
            }
        })
    }

    /// The value of one of several labels near tubes. Tubes of labels that touch are measured
    /// against the same others, so that no gap opens between them.
    fn among_others(&self, place: Place, tubes: &[Near]) -> f64 {
        let is_owned = tubes.iter().any(|&(_, _, owns)| owns);
        // In columns that a tube owns, its part goes on in the tube and nowhere else, and nor do
        // parts beside it that have tubes as well.
        let said = |columns: &Columns| {
            let mut own = tubes.iter().filter(|tube| tube.0 == columns.label).peekable();
            let (has_tube, owns) = (own.peek().is_some(), own.any(|&(_, _, owns)| owns));
            let value = columns.value(place);
            (!owns && (value > 0.0 || !has_tube || !is_owned)).then_some(value)
        };
        let own = &self.all[self.own];
        let mut value = said(own).unwrap_or(f64::NEG_INFINITY);
        let mut depths = tubes.iter().filter(|tube| tube.0 == own.label).peekable();
        if depths.peek().is_none() {
            return value;
        }
        let most = self.all.iter().filter_map(said).reduce(f64::max).unwrap_or(0.0);
        for &(_, depth, _) in depths {
            // As where two labels have one contour in common, they differ by twice the distance.
            value = value.max((most + 2.0 * depth).max((-MOST_DEPTH).min(most - 1.0)));
        }
        value
    }

    fn leaf(&self, leaf: [i32; 3]) -> LeafNodes {
        let value = |node| {
            let point = self.lattice.position(node_of(leaf, node));
            self.value(self.place(point)) as f32
        };
        std::array::from_fn::<f32, LEAF_NODES, _>(value)
    }
}

/// How deep a place is in a solid that ends beyond a slice: its edge is rounded with a radius,
/// and so far beyond is its end. `depth` is how deep it is within the slice.
fn rounded(depth: f64, beyond: f64, radius: f64) -> f64 {
    radius - (radius - depth).max(0.0).hypot(beyond)
}

/// What a slice without contours of a label says: the label ends, or begins, about halfway to the next
/// slices that have some, and earlier toward its edge there.
fn undrawn(slice: usize, drawn: &[Option<Vec<f32>>], heights: &[f64], is_all: bool) -> Vec<f32> {
    let sign = if is_all { 1.0 } else { -1.0 };
    let pixels = drawn.iter().flatten().next().map_or(0, Vec::len);
    let below = (0..slice).rev().find(|&other| drawn[other].is_some());
    let above = (slice + 1..drawn.len()).find(|&other| drawn[other].is_some());
    let next: Vec<(&Vec<f32>, f32)> = [below, above]
        .into_iter()
        .flatten()
        .filter_map(|other| {
            let half = 0.5 * (heights[slice] - heights[other]).abs();
            Some((drawn[other].as_ref()?, half as f32))
        })
        .collect();
    let distance = |pixel: usize| {
        next.iter().map(|(image, half)| image[pixel].abs().max(*half)).fold(f32::INFINITY, f32::min)
    };
    (0..pixels).into_par_iter().map(|pixel| sign * distance(pixel)).collect()
}

/// The slopes of all columns, as images.
fn slopes(spline: &Spline, values: &[Vec<f32>], pixels: usize) -> Vec<Vec<f32>> {
    const CHUNK: usize = 1024;
    let count = values.len();
    let of_chunk = |start: usize| {
        let end = pixels.min(start + CHUNK);
        let (mut column, mut own) = (vec![0.0; count], vec![0.0; count]);
        let mut found = vec![0.0; count * (end - start)];
        for pixel in start..end {
            column.iter_mut().zip(values).for_each(|(own, image)| *own = image[pixel].into());
            spline.slopes(&column, &mut own);
            for (slice, slope) in own.iter().enumerate() {
                found[slice * (end - start) + pixel - start] = *slope as f32;
            }
        }
        found
    };
    let starts: Vec<usize> = (0..pixels).step_by(CHUNK).collect();
    let chunks: Vec<Vec<f32>> = starts.into_par_iter().map(of_chunk).collect();
    let image = |slice: usize| {
        let part = |chunk: &Vec<f32>| {
            let size = chunk.len() / count;
            chunk[slice * size..(slice + 1) * size].to_vec()
        };
        chunks.iter().flat_map(part).collect()
    };
    (0..count).into_par_iter().map(image).collect()
}

impl NodeField for StackField<'_> {
    fn label(&self) -> Label {
        self.all[self.own].label
    }

    fn rough(&self, node: [i32; 3]) -> f32 {
        self.value(self.place(self.lattice.position(node))) as f32
    }

    /// Along the stack values change faster than distances do, the more the closer its slices
    /// are: all heights of the leaf are looked at in its middle.
    fn may_be_in(&self, leaf: [i32; 3]) -> bool {
        let Place { pixel, height } = self.place(self.lattice.position(middle(leaf)));
        (-STEPS..=STEPS).any(|step| {
            let height = height + 0.5 * f64::from(step);
            self.value(Place { pixel, height }) as f32 > FAR
        })
    }

    fn ensure(&mut self, leaves: Vec<[i32; 3]>) {
        let is_missing = |&leaf: &[i32; 3]| self.grid.slot(leaf) == NO_SLOT;
        let missing: Vec<[i32; 3]> = leaves.into_iter().filter(is_missing).collect();
        let values: Vec<LeafNodes> = missing.par_iter().map(|&leaf| self.leaf(leaf)).collect();
        for (leaf, values) in missing.into_iter().zip(values) {
            self.grid.insert(leaf, &values);
        }
    }

    fn grid(&self) -> &LeafGrid {
        &self.grid
    }

    fn grid_mut(&mut self) -> &mut LeafGrid {
        &mut self.grid
    }

    fn into_grid(self) -> LeafGrid {
        self.grid
    }

    fn has(&self, _node: [i32; 3]) -> bool {
        true
    }
}
