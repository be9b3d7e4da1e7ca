//! DICOM files.

mod rtstruct;
mod segmentation;
mod slices;
mod walk;
mod write;

use std::fs::File;
use std::io::Read;
use std::path::Path;

use dicom_core::Tag;
use dicom_dictionary_std::{tags, uids};
use dicom_object::{DefaultDicomObject, InMemDicomObject, OpenFileOptions};

use self::walk::{Encoding, walk};
use super::structures::Chosen;
use crate::error::{Error, Result};
use crate::section::{Rules, Sections};

pub use write::{StructureContours, Template, write};

/// What stands before the word below, whatever it is.
const PREAMBLE: usize = 128;
const MAGIC: &[u8] = b"DICM";
/// The element that says how long the group of file meta information is, before it.
const GROUP_LENGTH: usize = 12;

/// The data set of a file or of an item of a sequence.
type Object = InMemDicomObject;

/// Whether a file is a DICOM file, by the ending of its name, or else by its content: many of
/// their names end in a number.
pub fn is_dicom(path: &Path) -> bool {
    let ending = path.extension().unwrap_or_default().to_string_lossy().to_lowercase();
    if matches!(ending.as_str(), "dcm" | "dicom") {
        return true;
    }
    let is_file = std::fs::metadata(path).is_ok_and(|about| about.is_file());
    let mut start = [0; PREAMBLE + MAGIC.len()];
    is_file
        && File::open(path).and_then(|mut file| file.read_exact(&mut start)).is_ok()
        && start.ends_with(MAGIC)
}

/// Reads the sections that a file holds, in layers of structures that may overlap.
///
/// # Errors
/// Where the file is damaged or holds something else than contours.
pub fn read(path: &Path, chosen: &Chosen, rules: &Rules) -> Result<Vec<Sections>> {
    let object = open(path)?;
    let class = text(&object, tags::SOP_CLASS_UID);
    let class = class.trim_end_matches('\0');
    if class == uids::RT_STRUCTURE_SET_STORAGE {
        return rtstruct::read(path, &object, chosen, rules);
    }
    if [uids::SEGMENTATION_STORAGE, uids::LABEL_MAP_SEGMENTATION_STORAGE].contains(&class) {
        return segmentation::read(path, &object, chosen, rules);
    }
    let what = match text(&object, tags::MODALITY).as_str() {
        "" => "no modality".to_owned(),
        modality => format!("modality {}", super::text::shortened(modality)),
    };
    Err(Error::file(
        path,
        format!(
            "this DICOM file ({what}) holds no contours: sections are read from structure sets \
             (RTSTRUCT) and segmentations (SEG)"
        ),
    ))
}

/// Reads a whole file.
fn open(path: &Path) -> Result<DefaultDicomObject> {
    let bytes = super::read_bytes(path)?;
    let bytes = with_meta(path, bytes)?;
    let damaged = |start: usize| {
        move |(at, what): (usize, &str)| {
            Error::input(path, format!("byte {}", start + at), format!("{what}: export it again"))
        }
    };
    let start = PREAMBLE + MAGIC.len();
    let explicit = Encoding { explicit: true, big_endian: false };
    // The group says itself how long it is.
    let length = bytes.get(start + GROUP_LENGTH - 4..start + GROUP_LENGTH);
    let length = length.and_then(|length| length.try_into().ok()).map(u32::from_le_bytes);
    let data = length.and_then(|length| (start + GROUP_LENGTH).checked_add(length as usize));
    let data = data
        .filter(|&data| data <= bytes.len())
        .ok_or((GROUP_LENGTH, "the file meta information is longer than the file"))
        .map_err(damaged(start))?;
    let syntax = walk(&bytes[start..data], explicit, tags::TRANSFER_SYNTAX_UID)
        .map_err(damaged(start))?
        .map(|uid| String::from_utf8_lossy(uid).trim_end_matches(['\0', ' ']).to_owned())
        .unwrap_or_default();
    let encoding = match syntax.as_str() {
        uids::IMPLICIT_VR_LITTLE_ENDIAN => Encoding { explicit: false, ..explicit },
        #[expect(deprecated, reason = "old files have it")]
        uids::EXPLICIT_VR_BIG_ENDIAN => Encoding { big_endian: true, ..explicit },
        uids::DEFLATED_EXPLICIT_VR_LITTLE_ENDIAN => {
            let what = "the file is compressed as a whole (deflated): export it without";
            return Err(Error::file(path, what));
        }
        _ => explicit,
    };
    walk(&bytes[data..], encoding, tags::PIXEL_DATA).map_err(damaged(data))?;
    OpenFileOptions::new().from_reader(bytes.as_slice()).map_err(|error| {
        // The library's own words are nested; the innermost say what is wrong.
        let mut cause: &dyn std::error::Error = &error;
        while let Some(source) = cause.source() {
            cause = source;
        }
        let what = super::text::shortened(&cause.to_string());
        Error::file(path, format!("this DICOM file cannot be read ({what}): export it again"))
    })
}

/// The bytes of a file that begins as files should. Some old ones are a bare data set.
fn with_meta(path: &Path, bytes: Vec<u8>) -> Result<Vec<u8>> {
    if bytes.get(PREAMBLE..PREAMBLE + MAGIC.len()) == Some(MAGIC) {
        return Ok(bytes);
    }
    // A data set begins with group 8.
    let (Some([8, 0]), Some(kind)) = (bytes.get(..2), bytes.get(4..6)) else {
        let what = "this is no DICOM file: the word DICM is not at byte 128";
        return Err(Error::file(path, what));
    };
    let syntax = match kind.iter().all(u8::is_ascii_uppercase) {
        true => uids::EXPLICIT_VR_LITTLE_ENDIAN,
        false => uids::IMPLICIT_VR_LITTLE_ENDIAN,
    };
    let padding = if syntax.len() % 2 == 1 { "\0" } else { "" };
    let value = format!("{syntax}{padding}");
    let mut whole = vec![0; PREAMBLE];
    whole.extend(MAGIC);
    whole.extend(b"\x02\0\0\0UL\x04\0");
    whole.extend((8 + value.len() as u32).to_le_bytes());
    whole.extend(b"\x02\0\x10\0UI");
    whole.extend((value.len() as u16).to_le_bytes());
    whole.extend(value.as_bytes());
    whole.extend(bytes);
    Ok(whole)
}

/// The text of an element, without the spaces that fill it up; empty where there is none.
fn text(object: &Object, tag: Tag) -> String {
    let text = object.get(tag).and_then(|element| element.to_str().ok());
    text.map(|text| text.trim_matches(['\0', ' ']).to_owned()).unwrap_or_default()
}

/// The items of a sequence; none where there is none.
fn items(object: &Object, tag: Tag) -> &[Object] {
    object.get(tag).and_then(|element| element.items()).unwrap_or_default()
}
