//! Whether pixels hold labels, or greys of which none was meant.

use std::collections::BTreeMap;

use super::page::Page;
use crate::label_image::LabelImage;

/// A picture with more different values than this is grey.
const MOST_VALUES: usize = 256;
/// Up to so many labels may be thin everywhere.
const THIN: usize = 16;
/// From so many values on between black and white, all of them thin, a mask has soft edges.
const SOFT: usize = 3;
/// What most programs mean by white, whatever a picture could hold.
const WHITE: u32 = 255;

/// The values that occur in pictures, but for 0.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Values {
    counts: BTreeMap<u32, Count>,
    /// Whether each alone may be what the picture shows as white.
    may_be_white: bool,
}

#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
struct Count {
    pixels: usize,
    /// Those with their own value on all four sides.
    inner: usize,
}

impl Values {
    /// Those of a picture.
    ///
    /// # Errors
    /// Where there are too many for labels.
    pub fn new(page: &Page) -> Result<Self, String> {
        let counts = counted(page.size, &page.values, MOST_VALUES).ok_or_else(too_many)?;
        let may_be_white = counts.keys().all(|&value| page.white == Some(value) || value == WHITE);
        let may_be_white = may_be_white && page.white.is_some();
        Ok(Self { counts, may_be_white })
    }

    /// Those of a slice of a volume, which has as many labels as it likes.
    pub fn of_slice(image: &LabelImage) -> Self {
        let counts = counted(image.size(), image.labels(), usize::MAX).unwrap_or_default();
        Self { counts, may_be_white: false }
    }

    /// Those of several pictures.
    pub fn sum(mut self, other: Self) -> Self {
        self.may_be_white = match (self.counts.is_empty(), other.counts.is_empty()) {
            (true, _) => other.may_be_white,
            (_, true) => self.may_be_white,
            _ => self.may_be_white && other.may_be_white,
        };
        for (value, more) in other.counts {
            let count = self.counts.entry(value).or_default();
            count.pixels += more.pixels;
            count.inner += more.inner;
        }
        self
    }

    /// How many there are.
    pub fn count(&self) -> usize {
        self.counts.len()
    }

    /// What white is, where nothing else occurs but black.
    pub fn white(&self) -> Option<u32> {
        match self.counts.keys().collect::<Vec<_>>()[..] {
            [&white] if self.may_be_white && white > 1 => Some(white),
            _ => None,
        }
    }

    /// Makes sure that they are labels: labels have areas, greys change from pixel to pixel.
    ///
    /// # Errors
    /// What they are instead.
    pub fn require_labels(&self) -> Result<(), String> {
        if self.count() > MOST_VALUES {
            return Err(too_many());
        }
        let thin = self.counts.values().filter(|count| count.inner == 0).count();
        let white = self.counts.get(&WHITE).filter(|white| white.inner > 0);
        let between: usize = self.counts.range(..WHITE).map(|(_, count)| count.pixels).sum();
        let is_soft = thin >= SOFT && 10 * thin >= 9 * (self.count() - 1);
        if white.is_some_and(|white| is_soft && between < white.pixels) {
            return Err(format!(
                "its edges are soft: besides black and white there are {thin} greys, all of them in \
                 thin lines alone, which are no labels: turn anti-aliasing off, or make the mask \
                 black and white with a threshold"
            ));
        }
        self.require_areas("picture")
    }

    /// The same, whatever the edges are like and how many values there are.
    ///
    /// # Errors
    /// That they are no labels.
    pub fn require_areas(&self, what: &str) -> Result<(), String> {
        let thin = self.counts.values().filter(|count| count.inner == 0).count();
        if thin > THIN && 2 * thin > self.count() {
            return Err(format!(
                "{thin} of its {} values fill no area: it is a grey {what} and not one of labels: \
                 segment it first",
                self.count()
            ));
        }
        Ok(())
    }
}

/// How often each value but 0 occurs in rows of pixels; `None` where there are more than `most`.
fn counted(
    [width, height]: [usize; 2],
    values: &[u32],
    most: usize,
) -> Option<BTreeMap<u32, Count>> {
    let mut counts = BTreeMap::<u32, Count>::new();
    for (row, pixels) in values.chunks(width.max(1)).enumerate() {
        let mut start = 0;
        for run in pixels.chunk_by(|one, other| one == other) {
            let (value, first) = (run[0], start);
            start += run.len();
            if value == 0 {
                continue;
            }
            let is_inner = |&x: &usize| {
                let beside = [(row.wrapping_sub(1)), row + 1];
                beside.iter().all(|&row| row < height && values[row * width + x] == value)
            };
            let count = counts.entry(value).or_default();
            count.pixels += run.len();
            count.inner += (first + 1..start - 1).filter(is_inner).count();
        }
        if counts.len() > most {
            return None;
        }
    }
    Some(counts)
}

fn too_many() -> String {
    format!(
        "there are more than {MOST_VALUES} different values: it is a grey picture and not one of \
         labels: segment it first"
    )
}
