//! PNG: values of grey, or indices into a palette, as labels.

use std::io::Cursor;
use std::path::Path;

use ::png::{BitDepth, ColorType, Decoder, Info, PixelDimensions, Transformations, Unit};

use super::page::{Page, Resolution, coloured, damaged, pixels, unpacked};
use crate::error::{Error, Result};
use crate::io::read_bytes;

/// Deflate makes no more bytes than this of one.
const DEFLATE: usize = 1032;

/// Reads the picture of a file.
///
/// # Errors
/// Where it is no PNG, damaged, animated, or coloured.
pub fn read(file: &Path) -> Result<Page> {
    let bytes = read_bytes(file)?;
    let bad = |error| damaged(file, "PNG", error);
    let mut decoder = Decoder::new(Cursor::new(&bytes));
    decoder.set_transformations(Transformations::IDENTITY);
    decoder.set_ignore_text_chunk(true);
    decoder.set_ignore_iccp_chunk(true);
    let mut reader = decoder.read_info().map_err(bad)?;
    let info = reader.info();
    let size = [info.width, info.height].map(|side| side as usize);
    let (depth, is_palette) = (info.bit_depth, info.color_type == ColorType::Indexed);
    match info.color_type {
        ColorType::Grayscale | ColorType::Indexed => (),
        ColorType::Rgb => return Err(coloured(file, "red, green and blue")),
        ColorType::Rgba => return Err(coloured(file, "red, green, blue and transparency")),
        ColorType::GrayscaleAlpha => return Err(coloured(file, "grey and transparency")),
    }
    if info.animation_control.is_some() {
        let what = "it is animated, and a slice is one picture: save each as a file of its own";
        return Err(Error::file(file, what));
    }
    let (resolution, palette) = (resolution(info), palette(info));
    let pixels = pixels(file, size)?;
    let needed = reader.output_buffer_size().unwrap_or(usize::MAX);
    if bytes.len().saturating_mul(DEFLATE) < needed {
        let what = format!(
            "{} compressed bytes cannot hold {needed}: the file is truncated, or its header damaged",
            bytes.len()
        );
        return Err(Error::file(file, what));
    }
    let mut packed = vec![0; needed];
    reader.next_frame(&mut packed).map_err(bad)?;
    let values = match depth {
        BitDepth::Sixteen => {
            let pairs = packed.as_chunks::<2>().0;
            pairs.iter().map(|&pair| u32::from(u16::from_be_bytes(pair))).collect()
        }
        BitDepth::Eight => packed.iter().map(|&value| u32::from(value)).collect(),
        depth => unpacked(&packed, depth as usize, size, false),
    };
    debug_assert_eq!(values.len(), pixels);
    let white = (!is_palette).then_some((1u32 << depth as u32) - 1);
    Ok(Page { size, values, white, resolution, palette })
}

fn resolution(info: &Info) -> Option<Resolution> {
    match info.pixel_dims {
        Some(PixelDimensions { xppu, yppu, unit: Unit::Meter }) => {
            Resolution::per_unit([xppu, yppu].map(|pixels| f64::from(pixels) / 1000.0), "mm")
        }
        _ => None,
    }
}

fn palette(info: &Info) -> Vec<[u8; 3]> {
    let bytes = info.palette.as_deref().filter(|_| info.color_type == ColorType::Indexed);
    bytes.map_or_else(Vec::new, |bytes| bytes.as_chunks::<3>().0.to_vec())
}
