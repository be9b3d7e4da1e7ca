use glam::DMat3;

use super::*;
use crate::section::Rules;
use crate::volume::Placement;

const SIDE: usize = 24;

/// A ball of the first label in a shell of the second.
fn solid([i, j, k]: [usize; 3]) -> u32 {
    let from = DVec3::new(i as f64, j as f64, k as f64) - DVec3::new(11.0, 12.0, 11.5);
    match from.length() {
        r if r < 5.0 => 1,
        r if r < 9.3 => 2,
        _ => 0,
    }
}

fn volume(steps: DMat3, label: impl Fn([usize; 3]) -> u32) -> LabelVolume {
    let voxel = |index| [index % SIDE, index / SIDE % SIDE, index / SIDE / SIDE];
    let labels = (0..SIDE.pow(3)).map(|index| label(voxel(index))).collect();
    let placement = Placement { origin: DVec3::new(1.0, 2.0, 3.0), steps };
    LabelVolume::new([SIDE; 3], labels, placement).expect("a volume")
}

fn names(volume: &LabelVolume, rules: ImageRules) -> Vec<String> {
    let slices = volume.slices(&rules).expect("slices");
    assert_eq!(slices.left_out, None);
    slices.images.into_iter().map(|(name, _)| name).collect()
}

#[test]
fn slices_are_where_they_are_drawn() {
    for axis in 0..3 {
        let volume = volume(DMat3::IDENTITY, |voxel| match voxel[axis] % 5 {
            2 => solid(voxel),
            _ => 0,
        });
        let (name, coordinate) = (AXES[axis], ['x', 'y', 'z'][axis]);
        let expected = [7, 12, 17]
            .map(|index| format!("{name} = {index} ({coordinate} = {})", index + axis + 1));
        let mut found = names(&volume, ImageRules::default());
        // The ball's first slice is the second, not the middle.
        found.retain(|name| !name.starts_with(&format!("{} = 2 ", AXES[axis])));
        assert_eq!(found, expected);
    }
}

#[test]
fn slices_of_two_axes_do_not_draw_on_each_other() {
    // What is drawn across i is smaller, so that k's contours must go through its lines.
    let is_drawn = |[i, j, k]: [usize; 3]| k % 4 == 2 || (i % 6 == 5 && (6..18).contains(&j));
    let volume = volume(DMat3::IDENTITY, |voxel| match is_drawn(voxel) {
        true => solid(voxel),
        false => 0,
    });
    let slices = volume.slices(&ImageRules::default()).expect("slices");
    assert_eq!(slices.left_out, None);
    let axis = |axis: char| slices.images.iter().filter(move |(name, _)| name.starts_with(axis));
    let numbers: Vec<usize> = "ijk".chars().map(|name| axis(name).count()).collect();
    assert_eq!(numbers, [3, 0, 4], "{}", slices.found);
    for (name, image) in axis('k') {
        let (section, _) = image.section(name, &Rules::default()).expect("a section");
        let plane = section.plane();
        let z = plane.offset / plane.normal.z;
        for [i, j] in [[11, 12], [5, 5], [5, 12], [17, 19], [20, 12], [11, 1]] {
            let at = glam::DVec2::new(i as f64 + 1.0, j as f64 + 2.0);
            let expected = solid([i, j, (z - 3.0).round() as usize]);
            assert_eq!(section.label_at(at).0, expected, "{name} {i} {j}");
        }
    }
}

#[test]
fn a_full_volume_gives_slices_across_its_longest_step() {
    let steps = DMat3::from_diagonal(DVec3::new(1.0, 2.0, 1.0));
    let volume = volume(steps, solid);
    let all = names(&volume, ImageRules::default());
    assert_eq!((all.len(), all[0].as_str()), (19, "j = 3 (y = 8)"));
    let every = names(&volume, ImageRules { every: 4, ..ImageRules::default() });
    assert_eq!(every, all.iter().step_by(4).cloned().collect::<Vec<_>>());
    let axis = Some(VolumeAxis::World(0));
    assert_eq!(names(&volume, ImageRules { axis, every: 100, ..ImageRules::default() }).len(), 1);
    assert_eq!(nth(1) + &nth(12) + &nth(23), "1st12th23rd");
}

#[test]
fn empty_slices_between_two_solids_are_outside() {
    let volume = volume(DMat3::IDENTITY, |[i, j, k]| {
        u32::from((3..20).contains(&i) && (3..20).contains(&j) && !(8..15).contains(&k))
    });
    let slices = volume.slices(&ImageRules::default()).expect("slices");
    assert_eq!(slices.images.len(), SIDE);
    assert_eq!(slices.images.iter().filter(|(_, image)| image.is_empty()).count(), 7);
}

#[test]
fn what_is_on_no_drawn_slice_is_told() {
    let volume = volume(DMat3::IDENTITY, |voxel @ [i, j, k]| match voxel {
        [1, 1, 1] => 3,
        _ if k % 4 == 2 || i % 6 == 5 => solid(voxel),
        _ => j as u32 / SIDE as u32,
    });
    let slices = volume.slices(&ImageRules::default()).expect("slices");
    assert_eq!(slices.left_out, Some((1, [1, 1, 1])));
}
