use glam::DVec3;

use super::*;
use crate::field::{self, Boundaries};
use crate::grid::evidence::Evidence;
use crate::oracle::Oracle;
use crate::plane::Plane;
use crate::progress::Silent;
use crate::section::{Loop, Section};

/// The part of z = `height` between two corners, as label 1.
fn rectangle(height: f64, [x, y]: [[f64; 2]; 2]) -> Section {
    let plane = Plane { normal: DVec3::Z, offset: height };
    let corners = [[x[0], y[0]], [x[1], y[0]], [x[1], y[1]], [x[0], y[1]]];
    let points = corners.map(|[x, y]| DVec3::new(x, y, height)).to_vec();
    let own = Loop { points, label: Label(1), hole_of: None };
    let name = format!("z = {height}");
    Section::from_loops(&name, plane, &[own], 1.0, &Rules::default()).unwrap().0
}

fn options(voxels: u32) -> Options {
    Options {
        resolution: Resolution::Voxels(voxels),
        device: Device::Cpu,
        points: 5000,
        delaunay: None,
        ..Options::default()
    }
}

fn check(sections: Vec<Section>, voxels: u32) -> Findings {
    let rules = Rules::default();
    let sections = Sections::new(sections, &rules).unwrap();
    crosscheck(sections, &rules, &options(voxels), None, &mut Stages::default(), &Silent).unwrap()
}

#[test]
fn a_prism_is_joined_by_both() {
    let square = [[-0.5, 0.5]; 2];
    let findings = check(vec![rectangle(-0.1, square), rectangle(0.1, square)], 160);
    let found = &findings.report.found;
    findings.verdict().unwrap();
    let points = found.points.as_ref().unwrap();
    assert!(points.must_agree > 100, "{}", points.must_agree);
    // Between the planes, and the two slabs beyond.
    assert_eq!((found.pairing.cells, found.pairing.differ), (3, 0));
    assert_eq!(found.pairing.differences, []);
    // The box's walls are farther from the squares than half of the gap between them, so everywhere
    // between and beyond the nearest section comes first. The box ends as far beyond the sections, so each cap
    // is as high as half of the gap.
    let expected = 2.0 * 0.2;
    let voxel = findings.report.voxel;
    let label = &found.agreement.labels[1];
    assert_eq!(label.label, 1);
    let volume = label.skeleton as f64 * voxel.powi(3);
    // By counting nodes, of which there is one more than voxels are long.
    assert!((volume / expected - 1.0).abs() < 0.04, "{volume} {expected}");
    let solid = &found.labels[0].skeleton;
    assert!(solid.closed && (solid.volume / expected - 1.0).abs() < 1e-9, "{solid:?}");
    assert_eq!((found.labels[0].dual.components, found.labels[0].dual.genus), (1, Some(0)));
}

#[test]
fn a_narrow_overlap_is_joined_by_the_skeleton_alone() {
    // The projections share a strip a tenth as wide as the planes are apart. In
    // the middle of it, half of what is seen on either plane is outside, and so
    // are the walls of the box: the mean-value field says outside.
    let one = rectangle(-0.5, [[-1.0, 0.05], [-0.6, 0.6]]);
    let other = rectangle(0.5, [[-0.05, 1.0], [-0.6, 0.6]]);
    let findings = check(vec![one, other], 96);
    let pairing = &findings.report.found.pairing;
    assert_eq!(pairing.differ, 1);
    let label = pairing.differences.iter().filter(|found| found.label == 1);
    let [found] = label.collect::<Vec<_>>()[..] else { panic!("{pairing:?}") };
    assert_eq!(found.joined_by, Reconstruction::Skeleton);
    assert_eq!(found.sections, ["z = -0.5", "z = 0.5"]);
    let heights = found.regions.map(|region| region.at[2]);
    assert!((heights[0] * heights[1] + 0.25).abs() < 0.05, "one on either plane: {heights:?}");
    let labels = &findings.report.found.labels[0];
    assert_eq!((labels.dual.components, labels.skeleton.components), (2, 1));
    // The strip is where they differ.
    let part = &findings.report.found.parts[0];
    assert_eq!((part.field, part.skeleton), (0, 1));
    let share = findings.report.found.agreement.share;
    // Measured: 0.9556.
    assert!(share > 0.95 && share < 0.96, "{share}");
    assert_eq!(findings.differing.len(), findings.depths.len());
}

#[test]
fn disagreement_is_found_at_the_distance_where_it_is() {
    let findings = check(
        vec![
            rectangle(-0.5, [[-1.0, 0.05], [-0.6, 0.6]]),
            rectangle(0.5, [[-0.05, 1.0], [-0.6, 0.6]]),
        ],
        96,
    );
    let agreement = &findings.report.found.agreement;
    assert_eq!(agreement.bins[0].share, 1.0, "at the sections");
    assert!(agreement.share < 0.96, "{}", agreement.share);
    let sum: u64 = agreement.bins.iter().map(|bin| bin.nodes).sum();
    assert_eq!(sum, agreement.nodes);
    let dims = findings.report.nodes.map(|nodes| nodes as u64 - 2);
    assert_eq!(sum, dims.iter().product::<u64>());
    let differing = agreement.nodes - agreement.agree;
    assert_eq!(differing, findings.differing.len() as u64);
    let labels: u64 = agreement.labels.iter().map(|label| label.both).sum();
    assert_eq!(labels, agreement.agree);
}

#[test]
fn a_wrong_reference_is_a_violation() {
    // The oracle of other sections than the field's: a smaller square.
    let square = |side: f64| [[-side, side]; 2];
    let sections = |side| vec![rectangle(-0.1, square(side)), rectangle(0.1, square(side))];
    let findings = check(sections(0.5), 64);
    let derived = derived(&findings.model).unwrap();
    let cells = derived.complex.as_ref().unwrap();
    let boundaries = Boundaries::new(cells, 1e-4, None).unwrap();
    let field = field::new(&boundaries, Device::Cpu).unwrap();
    let (own, wrong) = (&findings.model.sections().sections, sections(0.2));
    let bounds = cells.bounds();
    let asked = |sections: &[Section]| {
        let oracle = Oracle::new(sections, bounds, Label::OUTSIDE).unwrap();
        let judges = certain::Judges {
            complex: cells,
            boundaries: &boundaries,
            field: field.as_ref(),
            oracle: &oracle,
            sections,
        };
        // Right above the section, off the smaller square.
        certain::points(&judges, &[DVec3::new(0.35, 0.0, 0.101)], (0, 0), &Silent).unwrap()
    };
    assert_eq!(asked(own).violations, 0);
    let found = asked(&wrong);
    assert_eq!((found.violations, found.nodes), (1, 1));
    let violation = &found.first[0];
    assert_eq!((violation.field, violation.skeleton), (1, 0));
    assert_eq!(violation.section.as_deref(), Some("z = 0.1"));
    assert!(violation.rho < 0.02 && violation.alpha > 10.0, "{violation:?}");
    assert!(f64::from(violation.value) < -0.9 && violation.reference < -0.9, "{violation:?}");
    let mut findings = findings;
    findings.report.found.points = Some(found);
    let error = findings.verdict().unwrap_err().to_string();
    assert!(error.contains("0.101") && error.contains("bug"), "{error}");
}

#[test]
fn evidence_is_the_distance_to_the_sections() {
    let findings = check(vec![rectangle(-0.5, [[-0.5, 0.5]; 2])], 32);
    let evidence = Evidence::new(&findings.model.sections().sections);
    let (again, differing) = agreement::agreement(&findings.pair, &evidence, &Silent);
    assert_eq!(again, findings.report.found.agreement);
    assert_eq!(differing, findings.differing);
    // One plane in the middle of a box: nothing is farther than half of it.
    let margin = 0.05 * 2f64.sqrt();
    let farthest = again.bins.last().unwrap().from * findings.report.voxel;
    assert!(farthest <= margin, "{farthest}");
}
