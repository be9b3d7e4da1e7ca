//! TIFF, of one page or many: values of grey as labels.

use std::io::Cursor;
use std::path::Path;

use ::tiff::decoder::{Decoder, DecodingResult, Limits};
use ::tiff::tags::{PhotometricInterpretation, Tag};
use ::tiff::{ColorType, TiffError, TiffUnsupportedError};

use super::page::{MOST_PIXELS, Page, Resolution, coloured, damaged, pixels, unpacked};
use crate::error::{Error, Result};
use crate::io::read_bytes;
use crate::io::volume::label;
use crate::terminal::quoted;

type File<'a> = Decoder<Cursor<&'a [u8]>>;

/// A page that is a smaller copy of another one, in `NewSubfileType`.
const SMALLER: u32 = 1;

/// Reads one page after another; `each` gets its number, from 1.
///
/// # Errors
/// Where it is no TIFF, damaged or coloured, where values are no labels, and what `each` says.
pub fn read(file: &Path, mut each: impl FnMut(usize, Page) -> Result<()>) -> Result<()> {
    let bytes = read_bytes(file)?;
    let mut limits = Limits::default();
    limits.decoding_buffer_size = 8 * MOST_PIXELS;
    let mut decoder = Decoder::new(Cursor::new(bytes.as_slice()))
        .map_err(|error| broken(file, &error))?
        .with_limits(limits);
    for number in 1.. {
        let subfile = decoder.find_tag_unsigned(Tag::NewSubfileType).unwrap_or_default();
        if subfile.unwrap_or(0u32) & SMALLER == 0 {
            each(number, page(&mut decoder, file)?)?;
        }
        if !decoder.more_images() {
            break;
        }
        decoder.next_image().map_err(|error| broken(file, &error))?;
    }
    Ok(())
}

fn page(decoder: &mut File, file: &Path) -> Result<Page> {
    let color = decoder.colortype().map_err(|error| broken(file, &error))?;
    let bits = match color {
        ColorType::Gray(bits) => bits,
        ColorType::RGB(_) | ColorType::YCbCr(_) | ColorType::Lab(_) => {
            return Err(coloured(file, "in colour"));
        }
        ColorType::RGBA(_) => return Err(coloured(file, "in colour, and transparent")),
        ColorType::GrayA(_) => return Err(coloured(file, "grey and transparency")),
        ColorType::CMYK(_) | ColorType::CMYKA(_) => {
            return Err(coloured(file, "inks (cyan, magenta, yellow and black)"));
        }
        ColorType::Multiband { num_samples, .. } => {
            return Err(coloured(file, &format!("{num_samples} numbers each")));
        }
        _ => return Err(coloured(file, "of an unusual kind")),
    };
    let (width, height) = decoder.dimensions().map_err(|error| broken(file, &error))?;
    let size = [width, height].map(|side| side as usize);
    let pixels = pixels(file, size)?;
    let photometric = decoder.find_tag_unsigned(Tag::PhotometricInterpretation);
    // The decoder turns such values round, and what is stored is the label.
    let is_inverted = photometric.map_err(|error| broken(file, &error))?
        == Some(PhotometricInterpretation::WhiteIsZero.to_u16());
    let resolution = resolution(decoder);
    let decoded = decoder.read_image().map_err(|error| broken(file, &error))?;
    let values = values(decoded, bits, size, is_inverted).map_err(|(pixel, number)| {
        let place = format!("pixel [{}, {}]", pixel % size[0], pixel / size[0]);
        let what = format!(
            "it holds {number}, and labels are whole numbers from 0: save labels, not measurements"
        );
        Error::input(file, place, what)
    })?;
    if values.len() != pixels {
        return Err(damaged(file, "TIFF", "pixels are missing"));
    }
    let white = 1u32.checked_shl(bits.into()).unwrap_or(0).wrapping_sub(1);
    Ok(Page { size, values, white: Some(white), resolution, palette: Vec::new() })
}

/// All values as labels, or the first that is none with its place.
fn values(
    decoded: DecodingResult,
    bits: u8,
    size: [usize; 2],
    is_inverted: bool,
) -> std::result::Result<Vec<u32>, (usize, f64)> {
    let invert = |value: u64| match is_inverted {
        true => (u64::MAX >> (64 - u32::from(bits.clamp(1, 64)))).saturating_sub(value),
        false => value,
    };
    match decoded {
        DecodingResult::U8(bytes) if bits < 8 => {
            Ok(unpacked(&bytes, bits.into(), size, is_inverted))
        }
        DecodingResult::U8(all) => labels(all, |value| invert(value.into()) as f64),
        DecodingResult::U16(all) => labels(all, |value| invert(value.into()) as f64),
        DecodingResult::U32(all) => labels(all, |value| invert(value.into()) as f64),
        // What is rounded here is too large for a label anyway.
        DecodingResult::U64(all) => labels(all, |value| invert(value) as f64),
        DecodingResult::I8(all) => labels(all, f64::from),
        DecodingResult::I16(all) => labels(all, f64::from),
        DecodingResult::I32(all) => labels(all, f64::from),
        DecodingResult::I64(all) => labels(all, |value| value as f64),
        DecodingResult::F16(all) => labels(all, |value| value.to_f64()),
        DecodingResult::F32(all) => labels(all, |value| match is_inverted {
            true => 1.0 - f64::from(value),
            false => value.into(),
        }),
        DecodingResult::F64(all) => {
            labels(all, |value| if is_inverted { 1.0 - value } else { value })
        }
    }
}

fn labels<T: Copy>(
    values: Vec<T>,
    number: impl Fn(T) -> f64,
) -> std::result::Result<Vec<u32>, (usize, f64)> {
    let labels = values.into_iter().map(number).enumerate();
    labels.map(|(pixel, number)| label(number).ok_or((pixel, number))).collect()
}

/// How far pixels are apart: in inches or centimetres, or in the unit that ImageJ names.
fn resolution(decoder: &mut File) -> Option<Resolution> {
    let unit: Option<u16> = decoder.find_tag_unsigned(Tag::ResolutionUnit).ok().flatten();
    let [x, y] =
        [Tag::XResolution, Tag::YResolution].map(|tag| decoder.get_tag_f64(tag).unwrap_or(0.0));
    match unit.unwrap_or(2) {
        2 => Resolution::per_unit([x / 25.4, y / 25.4], "mm"),
        3 => Resolution::per_unit([x / 10.0, y / 10.0], "mm"),
        _ => {
            let about = decoder.get_tag_ascii_string(Tag::ImageDescription).ok()?;
            let unit = about.lines().find_map(|line| line.strip_prefix("unit="))?.trim();
            let unit = if ["micron", "\\u00B5m", "µm"].contains(&unit) { "um" } else { unit };
            Resolution::per_unit([x, y], unit).filter(|_| unit != "pixel")
        }
    }
}

/// Why a file cannot be decoded.
fn broken(file: &Path, error: &TiffError) -> Error {
    match error {
        TiffError::UnsupportedError(TiffUnsupportedError::InterpretationWithBits(
            PhotometricInterpretation::RGBPalette,
            _,
        )) => {
            let what = "its pixels are indices into a palette, which are read from PNG alone: save \
                        it as PNG, or in grey with the label as the value of each pixel";
            Error::file(file, what)
        }
        TiffError::UnsupportedError(what) => Error::file(
            file,
            format!(
                "TIFF of this kind is not read ({}): save it in grey, uncompressed, as LZW or as \
                 Deflate",
                quoted(what)
            ),
        ),
        TiffError::LimitsExceeded => {
            Error::file(file, "it is larger than a picture may be, or its header is damaged")
        }
        other => damaged(file, "TIFF", other),
    }
}
