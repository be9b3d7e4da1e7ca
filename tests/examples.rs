//! The examples of the documentation: what they show is what they are for.

use std::path::Path;

use transect::change::Change;
use transect::check::Check;
use transect::context::Context;
use transect::grid::lattice::Resolution;
use transect::io::read_all;
use transect::mask::{Blobs, Mask, mask};
use transect::method::{MeanValue, Method};
use transect::model::{Model, Options};
use transect::section::{Rules, Sections};

fn read(names: &[&str]) -> Sections {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("examples");
    let paths: Vec<_> = names.iter().map(|name| folder.join(name)).collect();
    let strict = Rules { strict: true, ..Rules::default() };
    read_all(&paths, &strict).expect("the examples raise no doubts")
}

/// `spacing` is that of the triangulation of unknown regions.
fn reconstruct(sections: Sections, voxels: u32, spacing: Option<f64>) -> Check {
    by(Method::MeanValue(MeanValue { spacing, ..MeanValue::default() }), sections, voxels)
}

fn by(method: Method, sections: Sections, voxels: u32) -> Check {
    let resolution = Resolution::Voxels(voxels);
    let mut model = Model::new(Options { method, resolution, ..Options::default() });
    let mut context = Context::default();
    model.apply(Change::Add(sections), &mut context).expect("it reconstructs");
    let check = model.check(&mut context).expect("it can be checked");
    assert!(check.is_sound());
    check
}

/// For every label the pieces that it has, cavities not counted.
fn pieces(check: &Check) -> Vec<usize> {
    check.labels.iter().map(|label| label.facts.components - label.facts.cavities).collect()
}

#[test]
fn a_patch_joins_two_stripes() {
    let raw = Method::MeanValue(MeanValue { smooth: 0.0, ..MeanValue::default() });
    for method in [Method::default(), raw] {
        let apart = by(method, read(&["stripes.json"]), 64);
        assert_eq!(pieces(&apart), [2]);
        let joined = by(method, read(&["stripes.json", "patch.json"]), 64);
        assert_eq!(pieces(&joined), [1]);
        assert_eq!(joined.labels[0].facts.genus, 0);
    }
}

#[test]
fn a_sweep_of_crossing_frames_is_one_stomach() {
    let swept = reconstruct(read(&["sweep.json"]), 64, None);
    assert_eq!(pieces(&swept), [1]);
    assert_eq!(swept.labels[0].facts.genus, 0);
    assert!(swept.dice.min > Some(0.98), "{:?}", swept.dice.min);
    // All but the frames' rectangles.
    assert!(swept.dice.sections.iter().all(|section| section.unknown > 0.5));
}

#[test]
fn the_phantom_keeps_its_organs() {
    // The kidneys are two.
    let clean = reconstruct(read(&["phantom.json"]), 64, None);
    assert_eq!(pieces(&clean), [1, 1, 1, 1, 2, 1, 1]);
}

#[test]
fn a_noisy_scan_keeps_its_organs() {
    let blobs = Some(Blobs { fraction: 0.2, size: 0.4, seed: 1 });
    let noisy = mask(read(&["phantom.json"]), &Mask { blobs, frame: None }).expect("a mask");
    let noisy = reconstruct(noisy, 48, Some(20.0));
    assert_eq!(pieces(&noisy), [1, 1, 1, 1, 2, 1, 1]);
    assert!(noisy.dice.mean > Some(0.95), "{:?}", noisy.dice.mean);
}
