//! The connected parts of slices, and which of them overlap nothing of their label on the
//! next slice.

use glam::DVec2;
use rayon::prelude::*;

use crate::label::Label;
use crate::sets::components;

/// A connected part of a label on a slice: its pixels touch, if only at corners.
#[derive(Debug, Clone)]
pub struct Part {
    /// Its label.
    pub label: Label,
    /// The first pixel of the rectangle around it.
    pub first: [i32; 2],
    /// How many pixels that has along either side.
    pub size: [usize; 2],
    /// Which pixels of the rectangle are its own, row by row.
    mask: Vec<bool>,
    /// How many pixels it has.
    pub area: usize,
    /// Their middle.
    pub middle: DVec2,
}

impl Part {
    fn new(label: Label, pixels: &[[i32; 2]]) -> Self {
        let start = ([i32::MAX; 2], [i32::MIN; 2]);
        let (first, last) = pixels.iter().fold(start, |(low, high), pixel| {
            let each = |pick: fn(i32, i32) -> i32, ends: [i32; 2]| {
                [pick(ends[0], pixel[0]), pick(ends[1], pixel[1])]
            };
            (each(i32::min, low), each(i32::max, high))
        });
        let size = [0, 1].map(|axis| (last[axis] - first[axis]) as usize + 1);
        let mut mask = vec![false; size[0] * size[1]];
        for [x, y] in pixels {
            mask[(y - first[1]) as usize * size[0] + (x - first[0]) as usize] = true;
        }
        let at = |pixel: &[i32; 2]| DVec2::from_array(pixel.map(f64::from));
        let middle = pixels.iter().map(at).sum::<DVec2>() / pixels.len() as f64;
        Self { label, first, size, mask, area: pixels.len(), middle }
    }

    /// Whether a pixel is its own.
    pub fn has(&self, [x, y]: [i32; 2]) -> bool {
        let (x, y) =
            (i64::from(x) - i64::from(self.first[0]), i64::from(y) - i64::from(self.first[1]));
        let [width, height] = self.size.map(|size| size as i64);
        (0..width).contains(&x)
            && (0..height).contains(&y)
            && self.mask[y as usize * self.size[0] + x as usize]
    }

    /// How many of its pixels, moved, are those of another part.
    pub fn common(&self, other: &Self, [right, up]: [i32; 2]) -> usize {
        let rows = self.mask.chunks(self.size[0]).zip(self.first[1]..);
        let of_row = |(row, y): (&[bool], i32)| {
            let own = row.iter().zip(self.first[0]..).filter(|(is_own, _)| **is_own);
            own.filter(|(_, x)| other.has([x + right, y + up])).count()
        };
        rows.map(of_row).sum()
    }
}

/// The slices' connected parts, pixel by pixel.
pub struct Parts<'a> {
    width: usize,
    labels: &'a [Vec<Label>],
    numbers: Vec<Vec<u32>>,
}

impl<'a> Parts<'a> {
    /// Of every slice, by its pixels' labels.
    pub fn new(labels: &'a [Vec<Label>], width: usize) -> Self {
        let numbers = labels.par_iter().map(|labels| numbers(labels, width)).collect();
        Self { width, labels, numbers }
    }

    /// The parts of a slice that overlap nothing of their label on another one. Parts at the
    /// rectangle's border may go on beyond, and are none of them.
    pub fn loose(&self, slice: usize, other: usize) -> Vec<Part> {
        let (labels, others) = (&self.labels[slice], &self.labels[other]);
        let numbers = &self.numbers[slice];
        let count = numbers.iter().max().map_or(0, |&last| last as usize + 1);
        let mut is_loose = vec![true; count];
        let (width, rows) = (self.width, labels.len() / self.width);
        for (pixel, &number) in numbers.iter().enumerate() {
            let [x, y] = [pixel % width, pixel / width];
            let at_border = x == 0 || y == 0 || x + 1 == width || y + 1 == rows;
            if at_border || others[pixel] == labels[pixel] {
                is_loose[number as usize] = false;
            }
        }
        let mut pixels: Vec<Vec<[i32; 2]>> = vec![Vec::new(); count];
        for (pixel, &number) in numbers.iter().enumerate() {
            if is_loose[number as usize] {
                pixels[number as usize].push([(pixel % width) as i32, (pixel / width) as i32]);
            }
        }
        let label = |[x, y]: [i32; 2]| labels[y as usize * width + x as usize];
        let own = pixels.iter().filter(|pixels| !pixels.is_empty());
        own.map(|pixels| Part::new(label(pixels[0]), pixels)).collect()
    }
}

/// The number of every pixel's part.
fn numbers(labels: &[Label], width: usize) -> Vec<u32> {
    let pairs = (0..labels.len()).flat_map(|pixel| {
        let (x, above) = (pixel % width, pixel + width);
        let next = [
            (x + 1 < width).then_some(pixel + 1),
            Some(above),
            (x + 1 < width).then_some(above + 1),
            (x > 0).then(|| above - 1),
        ];
        let is_same = move |&next: &usize| labels.get(next) == Some(&labels[pixel]);
        next.into_iter().flatten().filter(is_same).map(move |next| [pixel as u32, next as u32])
    });
    components(labels.len() as u32, pairs)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn image(rows: &[&str]) -> Vec<Label> {
        rows.iter().flat_map(|row| row.bytes().map(|byte| Label(u32::from(byte - b'0')))).collect()
    }

    #[test]
    fn parts_that_overlap_nothing_of_their_label_are_loose() {
        let below = image(&["0000000", "0100220", "0010220", "0000000", "0003300", "0000000"]);
        let above = image(&["0000000", "0200020", "0010200", "0000000", "0000000", "0000000"]);
        let images = [below, above];
        let parts = Parts::new(&images, 7);
        // Label 1 lies over itself at a corner and label 2 does: what is left is label 3.
        let loose = parts.loose(0, 1);
        assert_eq!(loose.len(), 1);
        assert_eq!((loose[0].label, loose[0].first, loose[0].area), (Label(3), [3, 4], 2));
        assert_eq!(loose[0].middle, DVec2::new(3.5, 4.0));
        // The other way round there is a pixel of label 2.
        let loose = parts.loose(1, 0);
        assert_eq!((loose.len(), loose[0].label, loose[0].first), (1, Label(2), [1, 1]));
    }

    #[test]
    fn what_goes_on_beyond_the_border_is_not_loose() {
        let images = [image(&["000", "110", "000"]), image(&["000", "000", "000"])];
        assert!(Parts::new(&images, 3).loose(0, 1).is_empty());
    }

    #[test]
    fn common_pixels_are_counted_after_the_move() {
        let images = [
            image(&["00000000", "01100000", "01000000", "00000000"]),
            image(&["00000000", "00000110", "00000110", "00000000"]),
        ];
        let parts = Parts::new(&images, 8);
        let [one, other] = [parts.loose(0, 1), parts.loose(1, 0)].map(|mut own| own.remove(0));
        assert_eq!(one.common(&other, [4, 0]), 3);
        assert_eq!(one.common(&other, [3, 0]), 1);
        assert_eq!(one.common(&other, [0, 0]), 0);
    }
}
