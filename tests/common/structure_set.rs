//! Structure sets (DICOM RTSTRUCT) of tests' own making.

#![allow(dead_code)] // every test uses a part of it

use std::f64::consts::TAU;

use dicom_core::value::DataSetSequence;
use dicom_core::{DataElement, PrimitiveValue, Tag, VR};
use dicom_dictionary_std::{tags, uids};
use dicom_object::{FileMetaTableBuilder, InMemDicomObject};
use glam::DVec3;

/// A contour: its kind, its points and what it says of their number.
pub struct Contour {
    pub kind: &'static str,
    pub points: Vec<DVec3>,
}

/// A structure: number, name and contours.
pub struct Structure {
    pub number: u32,
    pub name: &'static str,
    pub contours: Vec<Contour>,
}

/// A closed contour.
pub fn closed(points: Vec<DVec3>) -> Contour {
    Contour { kind: "CLOSED_PLANAR", points }
}

/// A circle about a point, on a plane that two directions of length one span.
pub fn circle(center: DVec3, radius: f64, [a, b]: [DVec3; 2]) -> Vec<DVec3> {
    let angles = (0..72).map(|i| f64::from(i) * TAU / 72.0);
    angles.map(|angle| center + radius * (angle.cos() * a + angle.sin() * b)).collect()
}

pub fn text(tag: Tag, vr: VR, text: impl Into<String>) -> DataElement<InMemDicomObject> {
    DataElement::new(tag, vr, PrimitiveValue::from(text.into()))
}

pub fn sequence(tag: Tag, items: Vec<InMemDicomObject>) -> DataElement<InMemDicomObject> {
    DataElement::new(tag, VR::SQ, DataSetSequence::from(items))
}

pub fn object(elements: Vec<DataElement<InMemDicomObject>>) -> InMemDicomObject {
    InMemDicomObject::from_element_iter(elements)
}

fn contour(contour: &Contour) -> InMemDicomObject {
    let numbers = contour.points.iter().flat_map(|point| point.to_array());
    let numbers: Vec<String> = numbers.map(|number| format!("{number:.4}")).collect();
    object(vec![
        text(tags::CONTOUR_GEOMETRIC_TYPE, VR::CS, contour.kind),
        text(tags::NUMBER_OF_CONTOUR_POINTS, VR::IS, contour.points.len().to_string()),
        text(tags::CONTOUR_DATA, VR::DS, numbers.join("\\")),
    ])
}

/// The bytes of a structure set, in one of the transfer syntaxes.
pub fn structure_set(structures: &[Structure], syntax: &str) -> Vec<u8> {
    let names = structures.iter().map(|structure| {
        object(vec![
            text(tags::ROI_NUMBER, VR::IS, structure.number.to_string()),
            text(tags::ROI_NAME, VR::LO, structure.name),
        ])
    });
    let contours = structures.iter().map(|structure| {
        let mut item = object(vec![
            text(tags::ROI_DISPLAY_COLOR, VR::IS, format!("200\\{}\\30", structure.number)),
            text(tags::REFERENCED_ROI_NUMBER, VR::IS, structure.number.to_string()),
        ]);
        if !structure.contours.is_empty() {
            let own = structure.contours.iter().map(contour).collect();
            item.put(sequence(tags::CONTOUR_SEQUENCE, own));
        }
        item
    });
    let set = object(vec![
        text(tags::SOP_CLASS_UID, VR::UI, uids::RT_STRUCTURE_SET_STORAGE),
        text(tags::SOP_INSTANCE_UID, VR::UI, "2.25.1"),
        text(tags::MODALITY, VR::CS, "RTSTRUCT"),
        sequence(tags::STRUCTURE_SET_ROI_SEQUENCE, names.collect()),
        sequence(tags::ROI_CONTOUR_SEQUENCE, contours.collect()),
    ]);
    let meta = FileMetaTableBuilder::new().transfer_syntax(syntax);
    let file = set.with_meta(meta).expect("the set says what it is");
    let mut bytes = Vec::new();
    file.write_all(&mut bytes).expect("memory");
    bytes
}
