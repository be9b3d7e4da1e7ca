//! Drawn sections at full resolution: closed surfaces that agree with them, and volumes with
//! those of solids that are known.

mod common;

use std::collections::HashMap;

use common::data;
use transect::change::Change;
use transect::check::Check;
use transect::context::Context;
use transect::io::read_sections;
use transect::label::Label;
use transect::mesh::Mesh;
use transect::model::{Model, Options};

const LOOPS: [&str; 11] = [
    "vessel.csl",
    "bone.csl",
    "csl/Abdomen.csl",
    "csl/Elephant.csl",
    "csl/Heart-25-even-better.csl",
    "csl/ParallelEight.csl",
    "csl/SideBishop.csl",
    "csl/Vetebrae.csl",
    "csl/eight_15.csl",
    "csl/eight_20.csl",
    "csl/hand_ok.csl",
];
const GRAPHS: [&str; 6] = [
    "organ.contour",
    "knot.contour",
    "contour/liver.contour",
    "contour/mousebrain.contour",
    "contour/mug.contour",
    "contour/ringc.contour",
];

/// Reconstructs with default options.
fn reconstruct(file: &str) -> Option<(Model, Check)> {
    let path = data(file)?;
    let mut context = Context::default();
    let sections = read_sections(&path, &context.rules).expect("the file can be read");
    let mut model = Model::new(Options::default());
    model.apply(Change::Add(sections), &mut context).expect("it reconstructs");
    let check = model.check(&mut context).expect("it can be checked");
    Some((model, check))
}

/// Every directed edge of a label's boundary has exactly one opposite, counted
/// here without the code under test.
fn assert_closed(mesh: &Mesh, label: Label, file: &str) {
    let mut edges: HashMap<[u32; 2], [u32; 2]> = HashMap::new();
    for (&[a, b, c], &[back, front]) in mesh.triangles.iter().zip(&mesh.sides) {
        if back != label && front != label {
            continue;
        }
        for [start, end] in [[a, b], [b, c], [c, a]] {
            let way = usize::from((start < end) == (back == label));
            edges.entry([start.min(end), start.max(end)]).or_default()[way] += 1;
        }
    }
    let bad = edges.values().filter(|&&ways| ways != [1, 1]).count();
    assert_eq!(bad, 0, "{file}: label {label} has {bad} bad edges");
}

/// The volume behind a label's triangles, by the divergence theorem.
fn volume(mesh: &Mesh, label: Label) -> f64 {
    let origin = mesh.vertices[0];
    let signed = |(&[a, b, c], &[back, front]): (&[u32; 3], &[Label; 2])| {
        let [a, b, c] = [a, b, c].map(|corner| mesh.vertices[corner as usize] - origin);
        let six = a.dot(b.cross(c));
        if back == label {
            six
        } else if front == label {
            -six
        } else {
            0.0
        }
    };
    mesh.triangles.iter().zip(&mesh.sides).map(signed).sum::<f64>() / 6.0
}

fn assert_sound(model: &Model, check: &Check, file: &str) {
    let mesh = &model.derived().expect("something was derived").mesh;
    assert!(check.is_sound(), "{file}");
    let mut outside = check.box_volume;
    for label in &check.labels {
        assert_closed(mesh, Label(label.label), file);
        let own = volume(mesh, Label(label.label));
        assert!(own > 0.0, "{file}: label {} has volume {own}", label.label);
        let difference = (own - label.facts.volume).abs();
        assert!(difference < 1e-9 * check.box_volume, "{file}: {difference}");
        outside -= own;
    }
    let difference = (outside - check.outside_volume).abs();
    assert!(difference < 1e-9 * check.box_volume, "{file}: {difference}");
}

#[test]
fn loops_come_back_on_their_sections() {
    for file in LOOPS {
        let Some((model, check)) = reconstruct(file) else { continue };
        assert_sound(&model, &check, file);
        let (dice, far) = (&check.dice, &check.contours.far);
        println!(
            "{file}: Dice mean {:.4?}, least {:.4?}; contours at most {:.2} voxels off, {} thin",
            dice.mean,
            dice.min,
            check.contours.largest,
            check.contours.thin.len()
        );
        // Vertebrae have parts of a few voxels on their smaller sections.
        assert!(dice.mean >= Some(0.98), "{file}: mean Dice {:?}", dice.mean);
        assert!(dice.min >= Some(0.95), "{file}: least Dice {:?}", dice.min);
        assert!(far.is_empty(), "{file}: {far:?}");
    }
}

#[test]
fn planar_graphs_come_back_with_all_their_labels() {
    for file in GRAPHS {
        let Some((model, check)) = reconstruct(file) else { continue };
        assert_sound(&model, &check, file);
        let mut labels: Vec<u32> = model
            .sections()
            .sections
            .iter()
            .flat_map(|section| section.labels())
            .filter(|label| label.is_material())
            .map(|label| label.0)
            .collect();
        labels.sort_unstable();
        labels.dedup();
        let found: Vec<u32> = check.labels.iter().map(|label| label.label).collect();
        assert_eq!(found, labels, "{file}");
    }
}

/// The volumes of our own solids, and how far off they may be. Measured: at most 0.022, 0.005,
/// 0.020, 0.015 and, where the frames leave out most of the tumour, 0.117.
#[test]
fn volumes_of_known_solids_come_back() {
    let truth = std::fs::read(data("truth.json").expect("it is ours")).expect("truth");
    let truth: HashMap<String, Vec<f64>> = serde_json::from_slice(&truth).expect("volumes");
    for (file, solid, most) in [
        ("vessel.csl", "vessel", 0.03),
        ("bone.csl", "bone", 0.01),
        ("organ.contour", "organ", 0.03),
        ("knot.contour", "knot", 0.02),
        ("frames.json", "organ", 0.15),
    ] {
        let (model, check) = reconstruct(file).expect("it is ours");
        assert_sound(&model, &check, file);
        let volumes: Vec<f64> = check.labels.iter().map(|label| label.facts.volume).collect();
        assert_eq!(volumes.len(), truth[solid].len(), "{file}");
        for (volume, truth) in volumes.iter().zip(&truth[solid]) {
            let off = volume / truth - 1.0;
            println!("{file}: {volume:.0} of {truth:.0} mm³, {:+.2} %", 100.0 * off);
            assert!(off.abs() < most, "{file}: {volume} of {truth}");
        }
    }
}
