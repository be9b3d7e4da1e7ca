//! A picture's values, before it is known whether they are labels.

use std::path::Path;

use crate::error::{Error, Result};
use crate::memory;
use crate::terminal::quoted;

/// No picture has more pixels than this: 8192².
pub const MOST_PIXELS: usize = 1 << 26;

/// A picture, or a page of one.
#[derive(Debug, Clone, PartialEq)]
pub struct Page {
    /// How many pixels a row has, and how many rows there are.
    pub size: [usize; 2],
    /// Row by row, as they are stored.
    pub values: Vec<u32>,
    /// The largest value that such a picture can hold, which is shown as white; none where values
    /// are no greys.
    pub white: Option<u32>,
    /// How far pixels are apart, where the file says it.
    pub resolution: Option<Resolution>,
    /// The colours that values stand for, from 0.
    pub palette: Vec<[u8; 3]>,
}

/// How far pixels in a row, and rows, are apart.
#[derive(Debug, Clone, PartialEq)]
pub struct Resolution {
    /// In this unit.
    pub spacing: [f64; 2],
    /// The unit of length.
    pub unit: String,
}

impl Resolution {
    /// From pixels per unit of length along both directions.
    pub fn per_unit(pixels: [f64; 2], unit: &str) -> Option<Self> {
        let spacing = pixels.map(|pixels| 1.0 / pixels);
        let valid = spacing.iter().all(|spacing| spacing.is_normal() && *spacing > 0.0);
        valid.then(|| Self { spacing, unit: unit.to_owned() })
    }
}

/// What a pixel takes while a picture is read, in bytes: as it is stored, at most, and as a value.
const PIXEL_BYTES: u64 = 12;

/// The number of pixels, where a picture may have so many and they fit into memory.
pub fn pixels(file: &Path, size: [usize; 2]) -> Result<usize> {
    let [width, height] = size;
    let pixels = match width.checked_mul(height) {
        Some(0) => Err(format!("{width} × {height} pixels are no picture: export it again")),
        Some(pixels) if pixels <= MOST_PIXELS => Ok(pixels),
        _ => Err(format!(
            "{width} × {height} pixels are more than the {} million that a picture may have: make \
             it smaller, or its header is damaged",
            MOST_PIXELS / 1_000_000
        )),
    };
    let pixels = pixels.map_err(|what| Error::file(file, what))?;
    memory::require(PIXEL_BYTES * pixels as u64, || format!("reading {}", file.display()))?;
    Ok(pixels)
}

/// What a file is that cannot be decoded, with the decoder's words.
pub fn damaged(file: &Path, kind: &str, error: impl std::fmt::Display) -> Error {
    Error::file(file, format!("it is no {kind}, or damaged ({}): export it again", quoted(error)))
}

/// A picture in colour, or with transparency, has no labels.
pub fn coloured(file: &Path, what: &str) -> Error {
    let what = format!(
        "its pixels are {what}, and colours are no labels: save it in grey, with the label as the \
         value of each pixel, or as PNG with a palette"
    );
    Error::file(file, what)
}

/// Values of fewer bits than a byte, the first in the highest bits; every row begins a byte. Fewer
/// where bytes are missing.
pub fn unpacked(packed: &[u8], bits: usize, [width, height]: [usize; 2], invert: bool) -> Vec<u32> {
    let row = (width * bits).div_ceil(8);
    let mask = (1u32 << bits) - 1;
    let mut values = Vec::with_capacity(width * height);
    for bytes in packed.chunks(row.max(1)).take(height) {
        values.extend((0..width).map_while(|x| {
            let bit = x * bits;
            let value = u32::from(*bytes.get(bit / 8)?) >> (8 - bits - bit % 8) & mask;
            Some(if invert { mask - value } else { value })
        }));
    }
    values
}
