use super::*;
use crate::section::Loop;

const BLOBS: Blobs = Blobs { fraction: 0.3, size: 0.2, seed: 5 };

/// A square of side 2 in a slanted plane's own directions, and one of label 2
/// in it.
fn slanted() -> Section {
    let plane = Plane { normal: DVec3::new(1.0, -2.0, 4.0), offset: 3.0 };
    let [u, v] = plane.sides();
    let center = plane.normal * (3.0 / 21.0);
    let square = |label: u32, half: f64, hole_of| {
        let corners = [[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]];
        let points = corners.map(|[x, y]| center + half * (x * u + y * v)).to_vec();
        Loop { points, label: Label(label), hole_of }
    };
    let loops = [square(1, 1.0, None), square(1, 0.5, Some(0)), square(2, 0.5, None)];
    Section::from_loops("slanted", plane, &loops, 3.0, &Rules::default()).expect("squares").0
}

fn flat(z: f64) -> Section {
    let plane = Plane { normal: DVec3::Z, offset: z };
    let points = [[0.0, 0.0], [8.0, 0.0], [8.0, 4.0], [0.0, 4.0]];
    let points = points.map(|[x, y]| DVec3::new(x, y, z)).to_vec();
    let polygon = Loop { points, label: Label(1), hole_of: None };
    Section::from_loops("flat", plane, &[polygon], 9.0, &Rules::default()).expect("a square").0
}

fn sections(all: Vec<Section>) -> Sections {
    Sections::new(all, &Rules::default()).expect("sections")
}

fn masked(all: Vec<Section>, blobs: Option<Blobs>, frame: Option<[f64; 2]>) -> Vec<Section> {
    mask(sections(all), &Mask { blobs, frame }).expect("a mask").sections
}

/// The area of bounded regions of a label.
fn area(section: &Section, label: Label) -> f64 {
    let regions = section.regions().expect("regions");
    let own = regions.iter().filter(|region| region.label == label && region.outer.is_some());
    own.map(|region| region.area).sum()
}

#[test]
fn blobs_cover_their_part_of_every_rectangle() {
    for fraction in [0.1, 0.4, 0.9] {
        for seed in [1, 2] {
            let blobs = Blobs { fraction, seed, ..BLOBS };
            let found = masked(vec![slanted(), flat(0.0), flat(1.0)], Some(blobs), None);
            for (section, whole) in found.iter().zip([4.0, 32.0, 32.0]) {
                let covered = area(section, Label::UNKNOWN);
                let rest = area(section, Label(1)) + area(section, Label(2));
                assert!((covered / whole - fraction).abs() < 1e-3, "{covered} of {whole}");
                assert!((covered + rest - whole).abs() < 1e-9);
                assert_eq!(section.background(), Label::OUTSIDE);
            }
        }
    }
}

#[test]
fn blobs_depend_on_the_seed_and_the_section_alone() {
    let all = || vec![flat(0.0), flat(1.0)];
    let first = masked(all(), Some(BLOBS), None);
    assert_eq!(first, masked(all(), Some(BLOBS), None));
    assert_ne!(first[0].vertices(), first[1].vertices());
    let other = masked(all(), Some(Blobs { seed: 6, ..BLOBS }), None);
    assert_ne!(first[0].vertices(), other[0].vertices());
}

#[test]
fn a_frame_is_centred_and_all_beyond_is_unknown() {
    let found = masked(vec![flat(0.0)], None, Some([4.0, 10.0])).remove(0);
    assert_eq!(found.background(), Label::UNKNOWN);
    assert_eq!(area(&found, Label(1)), 16.0);
    // The frame's 4 × 10 less the 4 × 4 of material.
    assert_eq!(area(&found, Label::OUTSIDE), 24.0);
    let bounds = sections(vec![found]).bounds().expect("contours");
    assert_eq!((bounds.min.to_array(), bounds.max.to_array()), ([2.0, -3.0, 0.0], [6.0, 7.0, 0.0]));
}

#[test]
fn a_frame_on_a_bare_plane_is_near_the_middle_of_all() {
    let plane = Plane { normal: DVec3::new(0.0, 0.0, 2.0), offset: 20.0 };
    let bare = Section::from_loops("bare", plane, &[], 0.0, &Rules::default()).expect("a plane").0;
    let found = masked(vec![flat(0.0), bare], Some(BLOBS), Some([2.0, 2.0])).remove(1);
    assert_eq!(found.vertices()[0].to_array(), [3.0, 1.0]);
    assert_eq!(area(&found, Label::OUTSIDE), 4.0);
}

#[test]
fn what_was_unknown_stays_so_and_names_stay() {
    let mut all = sections(vec![slanted().relabelled(|label| match label {
        Label(2) => Label::UNKNOWN,
        label => label,
    })]);
    all.units = "mm".to_owned();
    all.frame = "LPS".to_owned();
    all.materials[0].name = "liver".to_owned();
    let known = all.materials.clone();
    let found = mask(all, &Mask { blobs: Some(BLOBS), frame: None }).expect("a mask");
    // What is unknown is the inner square, of area 1, and blobs of area 1.2.
    let covered = area(&found.sections[0], Label::UNKNOWN);
    assert!((1.2..2.2).contains(&covered), "{covered}");
    assert_eq!((found.units.as_str(), found.frame.as_str()), ("mm", "LPS"));
    assert_eq!(found.materials, known);
    assert_eq!(found.sections[0].name(), "slanted");
}

#[test]
fn numbers_out_of_range_are_refused() {
    let refused = |blobs, frame| {
        let result = mask(sections(vec![flat(0.0)]), &Mask { blobs, frame });
        assert!(matches!(result, Err(Error::Option(_))));
    };
    for fraction in [0.0, 1.0, -0.5, f64::NAN] {
        refused(Some(Blobs { fraction, ..BLOBS }), None);
    }
    refused(Some(Blobs { size: 0.001, ..BLOBS }), None);
    refused(None, Some([1.0, 0.0]));
    refused(None, Some([f64::INFINITY, 1.0]));
}
