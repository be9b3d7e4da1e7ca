//! Whether pixels hold labels, or greys of which none was meant.

use std::collections::BTreeMap;

use super::page::Page;

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
        let Page { size: [width, height], values, .. } = page;
        let mut counts = BTreeMap::<u32, Count>::new();
        for (row, pixels) in values.chunks(*width).enumerate() {
            for (x, &value) in pixels.iter().enumerate().filter(|&(_, &value)| value != 0) {
                let is_inner = x > 0
                    && x + 1 < *width
                    && row > 0
                    && row + 1 < *height
                    && [pixels[x - 1], pixels[x + 1]] == [value; 2]
                    && [(row - 1) * width + x, (row + 1) * width + x]
                        .map(|neighbor| values[neighbor])
                        == [value; 2];
                let count = counts.entry(value).or_default();
                count.pixels += 1;
                count.inner += usize::from(is_inner);
            }
            if counts.len() > MOST_VALUES {
                return Err(too_many());
            }
        }
        let may_be_white = counts.keys().all(|&value| page.white == Some(value) || value == WHITE);
        let may_be_white = may_be_white && page.white.is_some();
        Ok(Self { counts, may_be_white })
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
        if thin > THIN && 2 * thin > self.count() {
            return Err(format!(
                "{thin} of its {} values fill no area: it is a grey picture and not one of labels: \
                 segment it first",
                self.count()
            ));
        }
        Ok(())
    }
}

fn too_many() -> String {
    format!(
        "there are more than {MOST_VALUES} different values: it is a grey picture and not one of \
         labels: segment it first"
    )
}
