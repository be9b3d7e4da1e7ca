//! Real sections at full resolution: closed surfaces that agree with them.

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

const CSL: [&str; 9] = [
    "Abdomen",
    "Elephant",
    "Heart-25-even-better",
    "ParallelEight",
    "SideBishop",
    "Vetebrae",
    "eight_15",
    "eight_20",
    "hand_ok",
];
const CONTOUR: [&str; 4] = ["liver", "mousebrain", "mug", "ringc"];

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
    for name in CSL {
        let file = format!("csl/{name}.csl");
        let Some((model, check)) = reconstruct(&file) else { return };
        assert_sound(&model, &check, &file);
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
    for name in CONTOUR {
        let file = format!("contour/{name}.contour");
        let Some((model, check)) = reconstruct(&file) else { return };
        assert_sound(&model, &check, &file);
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
