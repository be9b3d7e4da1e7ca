//! Structure sets as results: contours of a solid on slices, in a set that is new or takes over
//! what another one says of the patient, the images and the structures (DICOM PS3.3, A.19).

use std::hash::{BuildHasher, RandomState};
use std::io::{Error, Result, Write};
use std::path::Path;

use dicom_core::value::DataSetSequence;
use dicom_core::{DataElement, PrimitiveValue, Tag, VR};
use dicom_dictionary_std::{tags, uids};
use dicom_object::{FileMetaTableBuilder, InMemDicomObject};
use glam::DVec3;

use super::segmentation::source_images;
use super::{Object, items, open, text};
use crate::label::Material;
use crate::plane::Plane;

/// How far a slice of the template may be from one of ours and be it, in millimetres.
const SAME: f64 = 0.05;

/// The contours of one structure.
#[derive(Debug, Clone, PartialEq)]
pub struct StructureContours {
    /// Its number, name and colour.
    pub material: Material,
    /// Each on one plane, in millimetres and LPS; lines go to holes and back (keyholes).
    pub contours: Vec<Vec<DVec3>>,
}

/// What a set takes over from another one.
#[derive(Debug, Clone)]
pub struct Template {
    object: Object,
    /// The slices with the images that its contours are drawn on.
    slices: Vec<(Plane, Object)>,
}

impl Template {
    /// Reads the set that is taken over from. Of another DICOM file patient, study and frame are
    /// taken over, and of a segmentation the images that it was made on.
    ///
    /// # Errors
    /// As for any DICOM file.
    pub fn read(path: &Path) -> crate::error::Result<Self> {
        let object: Object = open(path)?.into_inner();
        if text(&object, tags::SOP_CLASS_UID).trim_end_matches('\0')
            != uids::RT_STRUCTURE_SET_STORAGE
        {
            let slices = source_images(&object);
            return Ok(Self { object: of_patient(&object), slices });
        }
        let mut slices: Vec<(Plane, Object)> = Vec::new();
        for item in items(&object, tags::ROI_CONTOUR_SEQUENCE) {
            for contour in items(item, tags::CONTOUR_SEQUENCE) {
                let Some(image) = items(contour, tags::CONTOUR_IMAGE_SEQUENCE).first() else {
                    continue;
                };
                let points = super::rtstruct::points(contour).unwrap_or_default();
                let found = super::slices::slices(&[&points], f64::INFINITY).slices;
                let Some(plane) = found.first().map(|slice| slice.plane) else { continue };
                if !slices.iter().any(|(known, _)| is_near(known, &plane)) {
                    slices.push((plane, image.clone()));
                }
            }
        }
        Ok(Self { object, slices })
    }

    fn image(&self, contour: &[DVec3]) -> Option<&Object> {
        let on = |plane: &Plane| contour.iter().all(|&point| plane.distance(point).abs() < SAME);
        self.slices.iter().find(|(plane, _)| on(plane)).map(|(_, image)| image)
    }
}

fn is_near(one: &Plane, other: &Plane) -> bool {
    let [one, other] = [one.unit(), other.unit()];
    one.normal.distance(other.normal) < 1e-6 && (one.offset - other.offset).abs() < SAME
}

/// Writes a structure set. Contours are `CLOSED_PLANAR`; coordinates are rounded to a ten-thousandth
/// of a millimetre.
///
/// # Errors
/// What the writer says.
pub fn write(
    structures: &[StructureContours],
    template: Option<&Template>,
    out: &mut dyn Write,
) -> Result<()> {
    let mut set = template.map_or_else(fresh, |template| template.object.clone());
    // Names may have letters that the template's set of characters lacks.
    set.convert_to_utf8();
    let frame = text(&set, tags::FRAME_OF_REFERENCE_UID);
    let frame = match (frame.is_empty(), items(&set, tags::REFERENCED_FRAME_OF_REFERENCE_SEQUENCE))
    {
        (true, [first, ..]) => text(first, tags::FRAME_OF_REFERENCE_UID),
        _ => frame,
    };
    let known = items(&set, tags::STRUCTURE_SET_ROI_SEQUENCE).to_vec();
    let observed = items(&set, tags::RTROI_OBSERVATIONS_SEQUENCE).to_vec();
    let of = |all: &[Object], tag: Tag, number: u32| {
        all.iter().find(|item| text(item, tag).parse() == Ok(number)).cloned()
    };
    let (mut rois, mut contours, mut observations) = (Vec::new(), Vec::new(), Vec::new());
    for (place, structure) in structures.iter().enumerate() {
        let Material { id, name, color } = &structure.material;
        let mut roi = of(&known, tags::ROI_NUMBER, *id).unwrap_or_else(Object::new_empty);
        put(&mut roi, tags::ROI_NUMBER, VR::IS, id.to_string());
        put(&mut roi, tags::REFERENCED_FRAME_OF_REFERENCE_UID, VR::UI, frame.clone());
        put(&mut roi, tags::ROI_NAME, VR::LO, shortened(name));
        put(&mut roi, tags::ROI_GENERATION_ALGORITHM, VR::CS, "SEMIAUTOMATIC".to_owned());
        rois.push(roi);
        let mut own = Object::new_empty();
        put(&mut own, tags::ROI_DISPLAY_COLOR, VR::IS, color.map(|own| own.to_string()).join("\\"));
        let drawn = structure.contours.iter().enumerate();
        let drawn = drawn.map(|(number, points)| contour(number + 1, points, template)).collect();
        put_items(&mut own, tags::CONTOUR_SEQUENCE, drawn);
        put(&mut own, tags::REFERENCED_ROI_NUMBER, VR::IS, id.to_string());
        contours.push(own);
        let mut observation =
            of(&observed, tags::REFERENCED_ROI_NUMBER, *id).unwrap_or_else(|| {
                let mut new = Object::new_empty();
                put(&mut new, tags::RTROI_INTERPRETED_TYPE, VR::CS, String::new());
                put(&mut new, tags::ROI_INTERPRETER, VR::PN, String::new());
                new
            });
        put(&mut observation, tags::OBSERVATION_NUMBER, VR::IS, (place + 1).to_string());
        put(&mut observation, tags::REFERENCED_ROI_NUMBER, VR::IS, id.to_string());
        observations.push(observation);
    }
    put_items(&mut set, tags::STRUCTURE_SET_ROI_SEQUENCE, rois);
    put_items(&mut set, tags::ROI_CONTOUR_SEQUENCE, contours);
    put_items(&mut set, tags::RTROI_OBSERVATIONS_SEQUENCE, observations);
    put(&mut set, tags::SOP_CLASS_UID, VR::UI, uids::RT_STRUCTURE_SET_STORAGE.to_owned());
    put(&mut set, tags::SOP_INSTANCE_UID, VR::UI, uid());
    put(&mut set, tags::MODALITY, VR::CS, "RTSTRUCT".to_owned());
    // Nobody approved what is new.
    put(&mut set, tags::APPROVAL_STATUS, VR::CS, "UNAPPROVED".to_owned());
    for tag in [tags::REVIEW_DATE, tags::REVIEW_TIME, tags::REVIEWER_NAME] {
        set.remove_element(tag);
    }
    let meta = FileMetaTableBuilder::new().transfer_syntax(uids::EXPLICIT_VR_LITTLE_ENDIAN);
    let file = set.with_meta(meta).map_err(Error::other)?;
    file.write_all(out).map_err(Error::other)
}

fn contour(number: usize, points: &[DVec3], template: Option<&Template>) -> Object {
    let mut item = Object::new_empty();
    if let Some(image) = template.and_then(|template| template.image(points)) {
        put_items(&mut item, tags::CONTOUR_IMAGE_SEQUENCE, vec![image.clone()]);
    }
    put(&mut item, tags::CONTOUR_GEOMETRIC_TYPE, VR::CS, "CLOSED_PLANAR".to_owned());
    put(&mut item, tags::NUMBER_OF_CONTOUR_POINTS, VR::IS, points.len().to_string());
    put(&mut item, tags::CONTOUR_NUMBER, VR::IS, number.to_string());
    let numbers = points.iter().flat_map(|point| point.to_array());
    let numbers: Vec<String> = numbers.map(|number| format!("{:.4}", number + 0.0)).collect();
    put(&mut item, tags::CONTOUR_DATA, VR::DS, numbers.join("\\"));
    item
}

/// A set of the patient, study and frame of reference that another file is of.
fn of_patient(other: &Object) -> Object {
    let mut set = fresh();
    for tag in [
        tags::SPECIFIC_CHARACTER_SET,
        tags::STUDY_DATE,
        tags::STUDY_TIME,
        tags::ACCESSION_NUMBER,
        tags::REFERRING_PHYSICIAN_NAME,
        tags::PATIENT_NAME,
        tags::PATIENT_ID,
        tags::PATIENT_BIRTH_DATE,
        tags::PATIENT_SEX,
        tags::STUDY_ID,
        tags::STUDY_INSTANCE_UID,
        tags::FRAME_OF_REFERENCE_UID,
    ] {
        if let Some(element) = other.get(tag) {
            set.put(element.clone());
        }
    }
    refer(&mut set);
    set
}

/// Says which frame of reference coordinates are in.
fn refer(set: &mut Object) {
    let mut frame = Object::new_empty();
    let own = text(set, tags::FRAME_OF_REFERENCE_UID);
    put(&mut frame, tags::FRAME_OF_REFERENCE_UID, VR::UI, own);
    put_items(set, tags::REFERENCED_FRAME_OF_REFERENCE_SEQUENCE, vec![frame]);
}

/// A set that refers to no images.
fn fresh() -> Object {
    let mut set = Object::new_empty();
    put(&mut set, tags::SPECIFIC_CHARACTER_SET, VR::CS, "ISO_IR 192".to_owned());
    for (tag, kind) in [
        (tags::STUDY_DATE, VR::DA),
        (tags::STUDY_TIME, VR::TM),
        (tags::ACCESSION_NUMBER, VR::SH),
        (tags::MANUFACTURER, VR::LO),
        (tags::REFERRING_PHYSICIAN_NAME, VR::PN),
        (tags::PATIENT_NAME, VR::PN),
        (tags::PATIENT_ID, VR::LO),
        (tags::PATIENT_BIRTH_DATE, VR::DA),
        (tags::PATIENT_SEX, VR::CS),
        (tags::STUDY_ID, VR::SH),
        (tags::SERIES_NUMBER, VR::IS),
        (tags::OPERATORS_NAME, VR::PN),
        (tags::STRUCTURE_SET_DATE, VR::DA),
        (tags::STRUCTURE_SET_TIME, VR::TM),
    ] {
        put(&mut set, tag, kind, String::new());
    }
    for tag in [tags::STUDY_INSTANCE_UID, tags::SERIES_INSTANCE_UID, tags::FRAME_OF_REFERENCE_UID] {
        put(&mut set, tag, VR::UI, uid());
    }
    put(&mut set, tags::STRUCTURE_SET_LABEL, VR::SH, "transect".to_owned());
    refer(&mut set);
    set
}

/// A new identifier: 2.25 and a random number of 128 bits (DICOM PS3.5, B.2).
fn uid() -> String {
    // Hashers are seeded by the system.
    let random = || u128::from(RandomState::new().hash_one(0));
    format!("2.25.{}", random() << 64 | random())
}

/// A name of as many characters as DICOM has room for, none of which separates values.
fn shortened(name: &str) -> String {
    name.replace(|own: char| own.is_control() || own == '\\', " ").chars().take(64).collect()
}

fn put(object: &mut InMemDicomObject, tag: Tag, kind: VR, text: String) {
    object.put(DataElement::new(tag, kind, PrimitiveValue::from(text)));
}

fn put_items(object: &mut InMemDicomObject, tag: Tag, items: Vec<Object>) {
    object.put(DataElement::new(tag, VR::SQ, DataSetSequence::from(items)));
}
