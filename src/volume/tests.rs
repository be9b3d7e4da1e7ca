use std::collections::BTreeMap;

use glam::{DMat3, DVec3};

use super::*;
use crate::mesh::cut::Cut;
use crate::plane::Plane;

fn volume(dims: [usize; 3], label: impl Fn([usize; 3]) -> u32) -> LabelVolume {
    let [x, y, z] = dims;
    let all = (0..z).flat_map(|k| (0..y).flat_map(move |j| (0..x).map(move |i| [i, j, k])));
    let placement = Placement { origin: DVec3::ZERO, steps: DMat3::IDENTITY };
    LabelVolume::new(dims, all.map(label).collect(), placement).unwrap()
}

/// The area of every label but outside, by the shoelace formula.
fn areas(cut: &Cut, normal: DVec3) -> BTreeMap<u32, f64> {
    let mut areas = BTreeMap::new();
    for edge in &cut.edges {
        let [start, end] = [edge.start, edge.end].map(|point| cut.points[point as usize]);
        let swept = start.cross(end).dot(normal.normalize()) / 2.0;
        *areas.entry(edge.left.0).or_default() += swept;
        *areas.entry(edge.right.0).or_default() -= swept;
    }
    areas.remove(&0);
    areas
}

#[test]
fn shares_are_trilinear_and_equal_ones_go_to_the_smaller_label() {
    let volume = volume([2, 1, 1], |[i, _, _]| [5, 3][i]);
    let at = |x: f64| DVec3::new(x, 0.0, 0.0);
    assert_eq!(volume.share(at(0.25), 5), 0.75);
    assert_eq!(volume.winner(at(0.25)), 5);
    assert_eq!(volume.winner(at(0.5)), 3);
    assert_eq!(volume.winner(at(1.25)), 3);
    // Half a voxel beyond the last centre is the border to outside.
    assert_eq!(volume.winner(at(1.75)), 0);
    assert_eq!(volume.share(at(0.0) - DVec3::Y * 0.25, 5), 0.75);
}

#[test]
fn a_full_volume_ends_half_a_voxel_beyond_its_centres() {
    let volume = volume([6, 4, 5], |_| 1);
    let bounds = volume.bounds().unwrap();
    assert_eq!((bounds.min, bounds.max), (DVec3::splat(-0.5), DVec3::new(5.5, 3.5, 4.5)));
    let cut = volume.cut(&Plane { normal: DVec3::Z, offset: 2.2 });
    // 6 × 4; at the four corners shares fall off in two directions at once
    // and round them.
    let area = areas(&cut, DVec3::Z)[&1];
    assert!((23.5..24.0).contains(&area), "{area}");
    // The normal turned round, the same area.
    let turned = areas(&volume.cut(&Plane { normal: DVec3::NEG_Z, offset: -2.2 }), DVec3::NEG_Z);
    assert!((turned[&1] - area).abs() < 0.1, "{turned:?}");
}

#[test]
fn a_plane_beyond_the_materials_is_outside() {
    let volume = volume([4, 4, 4], |[_, _, k]| u32::from(k == 1));
    for offset in [-3.0, 0.49, 1.51, 2.5, 100.0] {
        let plane = Plane { normal: DVec3::Z, offset };
        assert_eq!(volume.cut(&plane), Cut::default(), "{offset}");
    }
    assert!(!volume.cut(&Plane { normal: DVec3::Z, offset: 0.51 }).edges.is_empty());
}

#[test]
fn four_labels_meet_in_junctions_and_share_the_plane() {
    let volume = volume([20, 20, 3], |[i, j, _]| 1 + u32::from(i > 9) + 2 * u32::from(j > 9));
    // At height 1 in the middle, (9.5, 9.5), and within the volume elsewhere.
    let plane = Plane { normal: DVec3::new(0.05, -0.02, 1.0), offset: 1.285 };
    let cut = volume.cut(&plane);
    let areas = areas(&cut, plane.normal);
    // A quarter of 20 × 20 each, on a tilted plane larger by 1/cos.
    let quarter = 100.0 * plane.normal.length();
    for (label, area) in &areas {
        assert!((area / quarter - 1.0).abs() < 0.01, "{label}: {area} of {quarter}");
    }
    assert_eq!(areas.len(), 4);
    let mut around: BTreeMap<u32, Vec<u32>> = BTreeMap::new();
    for edge in &cut.edges {
        for end in [edge.start, edge.end] {
            around.entry(end).or_default().extend([edge.left.0, edge.right.0]);
        }
    }
    for labels in around.values_mut() {
        labels.sort_unstable();
        labels.dedup();
    }
    let inner = around.values().filter(|labels| labels.len() == 3 && labels[0] != 0);
    // Four labels meet in two junctions of three.
    assert_eq!(inner.count(), 2);
}

#[test]
fn what_spans_no_volume_is_refused() {
    let new = |count: usize, steps: DMat3| {
        LabelVolume::new([2, 2, 2], vec![1; count], Placement { origin: DVec3::ZERO, steps })
    };
    assert!(new(7, DMat3::IDENTITY).unwrap_err().contains("7 labels"));
    let flat = DMat3::from_cols(DVec3::X, DVec3::Y, DVec3::X + DVec3::Y);
    for steps in [flat, DMat3::ZERO, DMat3::IDENTITY * f64::NAN] {
        assert!(new(8, steps).unwrap_err().contains("no volume"));
    }
    // Small is not flat.
    assert!(new(8, DMat3::IDENTITY * 1e-6).is_ok());
}

#[test]
fn materials_are_listed() {
    let volume = volume([3, 2, 1], |[i, j, _]| [[0, 9, 9], [4, 0, 9]][j][i]);
    assert_eq!(volume.labels(), [Label(4), Label(9)]);
    assert_eq!(volume.occupied, Some([[0, 0, 0], [2, 1, 0]]));
}
