//! Segmentations (DICOM SEG): frames of voxels that are in a segment or not, or have a segment's
//! number, in millimetres and the patient's frame (DICOM PS3.3, A.51, A.81 and C.8.20). Segments
//! that overlap are in layers of their own.

use std::collections::BTreeMap;
use std::path::Path;

use dicom_core::Tag;
use dicom_core::value::Value;
use dicom_dictionary_std::tags;
use glam::{DMat3, DVec3};

use super::{Object, items, text};
use crate::error::{Error, Result};
use crate::io::images;
use crate::io::structures::Chosen;
use crate::io::text::shortened;
use crate::label::{Label, Material};
use crate::memory;
use crate::plane::Plane;
use crate::section::{Rules, Sections};
use crate::volume::{LabelVolume, Placement};

/// What coordinates are in, by the standard.
const UNITS: &str = "mm";
const FRAME: &str = "LPS";
/// Frames may be off the lattice by this part of the gap between them, or of a pixel.
const OFF: f64 = 0.05;
/// Directions that differ by less are the same.
const TURNED: f64 = 1e-4;

type Checked<T> = std::result::Result<T, String>;

/// What a voxel of a frame says.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Kind {
    /// A bit: whether it is in the frame's segment.
    Binary,
    /// A byte: how much of it is, of this much.
    Fractional(u16),
    /// One or two bytes: the number of its segment.
    Labels,
}

/// A frame: where it is, and of which segment.
struct Frame {
    /// The centre of its first pixel.
    position: DVec3,
    /// The steps to the next pixel of a row, and to the next row.
    steps: [DVec3; 2],
    segment: u32,
}

/// All frames and their pixels.
struct Pixels<'a> {
    kind: Kind,
    bytes: &'a [u8],
    width: usize,
    height: usize,
    bits: usize,
}

/// Reads a segmentation in layers, each as a volume of labels is read.
///
/// # Errors
/// Where pixels are compressed or missing, frames are not on one lattice, or nothing is labelled.
pub fn read(file: &Path, object: &Object, chosen: &Chosen, rules: &Rules) -> Result<Vec<Sections>> {
    let (volumes, doubt) = volumes(file, object).map_err(|error| match error {
        Failure::Damaged(what) => Error::file(file, what),
        Failure::Other(error) => error,
    })?;
    let mut layers = images::layers_of(file, volumes, chosen, rules)?;
    if let (Some(what), Some(first)) = (doubt, layers.first_mut()) {
        crate::io::doubt(first, file, "the pixels", what, rules)?;
    }
    Ok(layers)
}

/// What went wrong.
enum Failure {
    /// Something is wrong with the file.
    Damaged(String),
    Other(Error),
}

impl From<String> for Failure {
    fn from(what: String) -> Self {
        Self::Damaged(what)
    }
}

/// The layers of a segmentation, and what is doubtful about them.
fn volumes(
    file: &Path,
    object: &Object,
) -> std::result::Result<(Vec<LabelVolume>, Option<String>), Failure> {
    let pixels = pixels(object)?;
    let materials = materials(object)?;
    let frames = frames(object, &pixels)?;
    let (placement, count, slices) = lattice(&frames)?;
    let dims = [pixels.width, pixels.height, count];
    let area = pixels.width * pixels.height;
    let voxels = area.checked_mul(count).ok_or("its frames are too many".to_owned())?;
    let mut layers: Vec<Vec<u32>> = Vec::new();
    let mut of_layers: Vec<Vec<u32>> = Vec::new();
    let mut of_segments: BTreeMap<u32, Vec<(usize, usize)>> = BTreeMap::new();
    for (number, (frame, slice)) in frames.iter().zip(slices).enumerate() {
        of_segments.entry(frame.segment).or_default().push((number, slice));
    }
    for (segment, own) in of_segments {
        let is_free = |labels: &Vec<u32>| {
            own.iter().all(|&(frame, slice)| {
                let there = &labels[slice * area..][..area];
                there.iter().enumerate().all(|(at, &label)| {
                    label == 0 || label == segment || pixels.label(frame, at, segment) == 0
                })
            })
        };
        let place = match layers.iter().position(is_free) {
            Some(place) => place,
            None => {
                // The volume and what is made of it.
                memory::require(3 * 4 * (layers.len() as u64 + 1) * voxels as u64, || {
                    let [x, y, z] = dims;
                    format!("{}: a volume of {x} × {y} × {z} voxels", file.display())
                })
                .map_err(Failure::Other)?;
                layers.push(vec![0; voxels]);
                of_layers.push(Vec::new());
                layers.len() - 1
            }
        };
        of_layers[place].push(segment);
        for (frame, slice) in own {
            let there = &mut layers[place][slice * area..][..area];
            for (at, label) in there.iter_mut().enumerate() {
                let own = pixels.label(frame, at, segment);
                if own != 0 {
                    *label = own;
                }
            }
        }
    }
    let is_one = pixels.kind == Kind::Labels;
    let volume = |(labels, own): (Vec<u32>, Vec<u32>)| {
        let mut volume = LabelVolume::new(dims, labels, placement)?;
        let is_own = |material: &&Material| is_one || own.contains(&material.id);
        volume.materials = materials.iter().filter(is_own).cloned().collect();
        (volume.units, volume.frame) = (UNITS.to_owned(), FRAME.to_owned());
        Ok(volume)
    };
    let volumes = layers.into_iter().zip(of_layers).map(volume).collect::<Checked<_>>()?;
    let doubt = match pixels.kind {
        Kind::Fractional(_) => Some(
            "its voxels say how much of them is in a segment: what is at least half in it counts as \
             in it"
                .to_owned(),
        ),
        _ => None,
    };
    Ok((volumes, doubt))
}

impl Pixels<'_> {
    /// The label of a pixel of a frame of a segment, or 0.
    fn label(&self, frame: usize, at: usize, segment: u32) -> u32 {
        let number = frame * self.width * self.height + at;
        match (self.kind, self.bits) {
            (Kind::Binary, 1) if self.bytes[number / 8] >> (number % 8) & 1 == 1 => segment,
            (Kind::Binary, 8) if self.bytes[number] != 0 => segment,
            (Kind::Fractional(most), _) if u16::from(self.bytes[number]) * 2 >= most => segment,
            (Kind::Labels, 8) => u32::from(self.bytes[number]),
            (Kind::Labels, _) => {
                u32::from(u16::from_le_bytes([self.bytes[2 * number], self.bytes[2 * number + 1]]))
            }
            _ => 0,
        }
    }
}

fn pixels(object: &Object) -> Checked<Pixels<'_>> {
    let number = |tag: Tag, what: &str| {
        let number = object.get(tag).and_then(|element| element.to_int::<u32>().ok());
        number.ok_or_else(|| format!("it has no {what}: export it again"))
    };
    let width = number(tags::COLUMNS, "number of columns")? as usize;
    let height = number(tags::ROWS, "number of rows")? as usize;
    let bits = number(tags::BITS_ALLOCATED, "number of bits")? as usize;
    let kind = match text(object, tags::SEGMENTATION_TYPE).as_str() {
        "BINARY" => Kind::Binary,
        "FRACTIONAL" => {
            let most = number(tags::MAXIMUM_FRACTIONAL_VALUE, "largest fraction")?;
            Kind::Fractional(u16::try_from(most).unwrap_or(u16::MAX).max(1))
        }
        "LABELMAP" => Kind::Labels,
        other => {
            let other = shortened(other);
            return Err(format!("a segmentation of type {other:?} is not known: export it anew"));
        }
    };
    let is_known = match kind {
        Kind::Binary => matches!(bits, 1 | 8),
        Kind::Fractional(_) => bits == 8,
        Kind::Labels => matches!(bits, 8 | 16),
    };
    if !is_known || width == 0 || height == 0 {
        return Err(format!("frames of {width} × {height} pixels of {bits} bits are none"));
    }
    let Some(element) = object.get(tags::PIXEL_DATA) else {
        return Err("it has no pixels: export it again".to_owned());
    };
    let bytes = match element.value() {
        Value::Primitive(dicom_core::PrimitiveValue::U8(bytes)) => bytes.as_slice(),
        Value::Primitive(dicom_core::PrimitiveValue::Empty) => &[],
        Value::PixelSequence(_) => {
            return Err("its pixels are compressed: export it without compression".to_owned());
        }
        _ => return Err("its pixels are no bytes: export it as little endian".to_owned()),
    };
    Ok(Pixels { kind, bytes, width, height, bits })
}

/// Names and colours of segments.
fn materials(object: &Object) -> Checked<Vec<Material>> {
    let mut all: Vec<Material> = Vec::new();
    for item in items(object, tags::SEGMENT_SEQUENCE) {
        let number = item.get(tags::SEGMENT_NUMBER).and_then(|own| own.to_int::<u32>().ok());
        // The background of a map of labels is 0, and nothing else may be.
        let Some(number) = number.filter(|&number| number > 0) else { continue };
        if all.iter().any(|own| own.id == number) {
            return Err(format!("two of its segments have the number {number}: export it again"));
        }
        let plain = Material::numbered(Label(number));
        let name = text(item, tags::SEGMENT_LABEL);
        let color = item.get(tags::RECOMMENDED_DISPLAY_CIE_LAB_VALUE);
        let color = color.and_then(|element| element.to_multi_int::<u16>().ok());
        let color = color.and_then(|values| <[u16; 3]>::try_from(values).ok());
        all.push(Material {
            id: number,
            name: if name.is_empty() { plain.name } else { name },
            color: color.map_or(plain.color, from_lab),
        });
    }
    Ok(all)
}

/// A colour as the standard writes it (PS3.3, C.10.7.1.1): CIE L*a*b* under D50 in 16 bits each.
fn from_lab(values: [u16; 3]) -> [u8; 3] {
    let [l, a, b] = values.map(|value| f64::from(value) / 65535.0);
    let (l, a, b) = (100.0 * l, 255.0 * a - 128.0, 255.0 * b - 128.0);
    let middle = (l + 16.0) / 116.0;
    let linear = |f: f64| match f > 6.0 / 29.0 {
        true => f.powi(3),
        false => 3.0 * (6.0f64 / 29.0).powi(2) * (f - 4.0 / 29.0),
    };
    let xyz = DVec3::new(
        0.9642 * linear(middle + a / 500.0),
        linear(middle),
        0.8249 * linear(middle - b / 200.0),
    );
    // To linear sRGB, the white point moved from D50 to D65 (Bradford).
    let rows = [
        DVec3::new(3.133_856_1, -1.616_866_7, -0.490_614_6),
        DVec3::new(-0.978_768_4, 1.916_141_5, 0.033_454_0),
        DVec3::new(0.071_945_3, -0.228_991_4, 1.405_242_7),
    ];
    rows.map(|row| {
        let light = row.dot(xyz).clamp(0.0, 1.0);
        let coded = match light <= 0.003_130_8 {
            true => 12.92 * light,
            false => 1.055 * light.powf(1.0 / 2.4) - 0.055,
        };
        (255.0 * coded).round() as u8
    })
}

/// A functional group of a frame, its own or that of all.
fn group<'a>(own: &'a Object, shared: Option<&'a Object>, tag: Tag) -> Option<&'a Object> {
    let first = |groups: &'a Object| items(groups, tag).first();
    first(own).or_else(|| shared.and_then(first))
}

/// Where frames are; as many as there are pixels of.
fn frames(object: &Object, pixels: &Pixels) -> Checked<Vec<Frame>> {
    let own = items(object, tags::PER_FRAME_FUNCTIONAL_GROUPS_SEQUENCE);
    let shared = items(object, tags::SHARED_FUNCTIONAL_GROUPS_SEQUENCE).first();
    let count = object.get(tags::NUMBER_OF_FRAMES).and_then(|own| own.to_int::<usize>().ok());
    let count = count.unwrap_or(1);
    if own.len() != count || count == 0 {
        return Err(format!(
            "it has {count} frames and says of {} where they are: export it again",
            own.len()
        ));
    }
    let size = pixels.width * pixels.height;
    let needed = size.checked_mul(count).and_then(|all| all.checked_mul(pixels.bits));
    if needed.is_none_or(|bits| bits.div_ceil(8) > pixels.bytes.len()) {
        return Err(format!(
            "{count} frames of {} × {} pixels do not fit into its {} bytes: the file is truncated, \
             or its sizes are wrong",
            pixels.width,
            pixels.height,
            pixels.bytes.len()
        ));
    }
    let frame = |(number, groups): (usize, &Object)| {
        let numbers = |sequence: Tag, tag: Tag, what: &str, count: usize| {
            let found = group(groups, shared, sequence).and_then(|group| group.get(tag));
            let found = found.and_then(|element| element.to_multi_float64().ok());
            found
                .filter(|own| own.len() == count && own.iter().all(|number| number.is_finite()))
                .ok_or_else(|| format!("frame {} has no {what}: export it again", number + 1))
        };
        let position = numbers(
            tags::PLANE_POSITION_SEQUENCE,
            tags::IMAGE_POSITION_PATIENT,
            "position in the patient",
            3,
        )?;
        let directions = numbers(
            tags::PLANE_ORIENTATION_SEQUENCE,
            tags::IMAGE_ORIENTATION_PATIENT,
            "orientation in the patient",
            6,
        )?;
        let spacing =
            numbers(tags::PIXEL_MEASURES_SEQUENCE, tags::PIXEL_SPACING, "size of pixels", 2)?;
        let segment = match pixels.kind {
            Kind::Labels => 0,
            _ => group(groups, shared, tags::SEGMENT_IDENTIFICATION_SEQUENCE)
                .and_then(|group| group.get(tags::REFERENCED_SEGMENT_NUMBER))
                .and_then(|number| number.to_int::<u32>().ok())
                .filter(|&number| (1..=u32::from(u16::MAX)).contains(&number))
                .ok_or_else(|| format!("frame {} is of no segment: export it again", number + 1))?,
        };
        // The first number is between rows, which go down along the second direction.
        let steps = [
            spacing[1] * DVec3::from_slice(&directions[..3]),
            spacing[0] * DVec3::from_slice(&directions[3..]),
        ];
        Ok(Frame { position: DVec3::from_slice(&position), steps, segment })
    };
    own.iter().enumerate().map(frame).collect()
}

/// The planes of frames, and the images that they were made on, as far as the file says it.
pub fn source_images(object: &Object) -> Vec<(Plane, Object)> {
    let shared = items(object, tags::SHARED_FUNCTIONAL_GROUPS_SEQUENCE).first();
    let of_frame = |groups: &Object| {
        let numbers = |sequence: Tag, tag: Tag| {
            group(groups, shared, sequence)?
                .get(tag)
                .and_then(|element| element.to_multi_float64().ok())
        };
        let at = numbers(tags::PLANE_POSITION_SEQUENCE, tags::IMAGE_POSITION_PATIENT)?;
        let directions =
            numbers(tags::PLANE_ORIENTATION_SEQUENCE, tags::IMAGE_ORIENTATION_PATIENT)?;
        let (&[x, y, z], &[a, b, c, d, e, f]) = (at.as_slice(), directions.as_slice()) else {
            return None;
        };
        let normal = DVec3::new(a, b, c).cross(DVec3::new(d, e, f)).try_normalize()?;
        let plane = Plane { normal, offset: normal.dot(DVec3::new(x, y, z)) };
        let derivation = group(groups, shared, tags::DERIVATION_IMAGE_SEQUENCE)?;
        let source = items(derivation, tags::SOURCE_IMAGE_SEQUENCE).first()?;
        let named = [tags::REFERENCED_SOP_CLASS_UID, tags::REFERENCED_SOP_INSTANCE_UID];
        let named = named.map(|tag| source.get(tag).cloned());
        let [Some(class), Some(instance)] = named else { return None };
        Some((plane, Object::from_element_iter([class, instance])))
    };
    let mut found: Vec<(Plane, Object)> = Vec::new();
    for groups in items(object, tags::PER_FRAME_FUNCTIONAL_GROUPS_SEQUENCE) {
        if let Some((plane, image)) = of_frame(groups)
            && found.iter().all(|(known, _)| *known != plane)
        {
            found.push((plane, image));
        }
    }
    found
}

/// The lattice of all frames, how many slices it has, and which one each frame is.
fn lattice(frames: &[Frame]) -> Checked<(Placement, usize, Vec<usize>)> {
    let [row, column] = frames[0].steps;
    let is_turned = |frame: &Frame| {
        let apart = |one: DVec3, other: DVec3| one.distance(other) > TURNED * one.length();
        apart(row, frame.steps[0]) || apart(column, frame.steps[1])
    };
    if let Some(other) = frames.iter().position(is_turned) {
        return Err(format!(
            "frame {} lies in another direction, or has other pixels, than the first: export \
             segmentations of one direction",
            other + 1
        ));
    }
    let pixel = row.length().min(column.length());
    let normal = row.cross(column).try_normalize();
    let normal = normal.ok_or("its rows and columns span no plane: export it again")?;
    let heights: Vec<f64> =
        frames.iter().map(|frame| normal.dot(frame.position - frames[0].position)).collect();
    let mut sorted = heights.clone();
    sorted.sort_by(f64::total_cmp);
    let gaps = sorted.windows(2).map(|pair| pair[1] - pair[0]);
    let gap = gaps.filter(|&gap| gap > OFF * pixel).fold(f64::INFINITY, f64::min);
    let (low, high) = (sorted[0], sorted[sorted.len() - 1]);
    let origin = |height: f64| {
        let at = heights.iter().position(|&own| own == height).unwrap_or(0);
        frames[at].position
    };
    if gap.is_infinite() {
        // One slice, whose thickness matters to nobody.
        let steps = DMat3::from_cols(row, column, pixel * normal);
        return Ok((Placement { origin: frames[0].position, steps }, 1, vec![0; frames.len()]));
    }
    let count = ((high - low) / gap).round();
    if count > 1e6 {
        return Err("its frames are too far from each other: export it again".to_owned());
    }
    // Slices may be shifted along each other, as with a tilted gantry.
    let step = (origin(high) - origin(low)) / count;
    let mut slices = Vec::with_capacity(frames.len());
    for (number, (frame, height)) in frames.iter().zip(&heights).enumerate() {
        let slice = ((height - low) / (high - low) * count).round();
        let off = frame.position.distance(origin(low) + slice * step);
        if off > OFF * (high - low) / count {
            return Err(format!(
                "frame {} is {off:.3} {UNITS} off the slices of the others, which are {:.3} {UNITS} \
                 apart: export a segmentation of even slices",
                number + 1,
                (high - low) / count
            ));
        }
        slices.push(slice as usize);
    }
    let steps = DMat3::from_cols(row, column, step);
    Ok((Placement { origin: origin(low), steps }, count as usize + 1, slices))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn colours_come_back() {
        // L*a*b* of sRGB's corners under D50, as colour tables give them.
        let coded = |lab: [f64; 3]| {
            let [l, a, b] = lab;
            let scaled = [l / 100.0, (a + 128.0) / 255.0, (b + 128.0) / 255.0];
            scaled.map(|value| (65535.0 * value).round() as u16)
        };
        for (lab, rgb) in [
            ([100.0, 0.0, 0.0], [255, 255, 255]),
            ([0.0, 0.0, 0.0], [0, 0, 0]),
            ([54.29, 80.81, 69.89], [255, 0, 0]),
            ([87.82, -79.29, 80.99], [0, 255, 0]),
            ([29.57, 68.30, -112.03], [0, 0, 255]),
        ] {
            let found = from_lab(coded(lab));
            let off =
                found.iter().zip(rgb).map(|(one, other): (&u8, u8)| one.abs_diff(other)).max();
            assert!(off <= Some(1), "{found:?} {rgb:?}");
        }
    }

    fn frame(height: f64, shift: f64) -> Frame {
        let position = DVec3::new(5.0 + shift, -3.0, height);
        Frame { position, steps: [0.5 * DVec3::X, 0.7 * DVec3::Y], segment: 1 }
    }

    #[test]
    fn frames_in_any_order_are_on_a_lattice() {
        let frames = [frame(6.0, 0.0), frame(0.0, 0.0), frame(2.0, 0.0), frame(6.0, 0.0)];
        let (placement, count, slices) = lattice(&frames).unwrap();
        assert_eq!((count, slices), (4, vec![3, 0, 1, 3]));
        assert_eq!(placement.origin, DVec3::new(5.0, -3.0, 0.0));
        assert!(placement.steps.z_axis.distance(2.0 * DVec3::Z) < 1e-12);
        // Shifted along each other, all by as much.
        let (placement, ..) = lattice(&[frame(0.0, 0.0), frame(2.0, 0.3)]).unwrap();
        assert!(placement.steps.z_axis.distance(DVec3::new(0.3, 0.0, 2.0)) < 1e-12);
        for wrong in [
            [frame(0.0, 0.0), frame(2.0, 0.0), frame(4.9, 0.0)],
            [frame(0.0, 0.0), frame(2.0, 0.4), frame(4.0, 0.0)],
        ] {
            assert!(lattice(&wrong).unwrap_err().contains("off the slices"));
        }
        let (_, count, slices) = lattice(&[frame(1.0, 0.0), frame(1.0, 0.0)]).unwrap();
        assert_eq!((count, slices), (1, vec![0, 0]));
    }
}
