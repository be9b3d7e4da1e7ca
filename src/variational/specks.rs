//! Pieces and bubbles that no section's plane passes through: nothing speaks for
//! them, and they are where the smoothest field happens to swing across zero far
//! from all contours. They become what is around them.

use crate::grid::labels::{LabelGrid, node_in_leaf};
use crate::grid::runs::{Neighbors, Run, Runs};
use crate::grid::samples::{LEAF_SIDE, Lattice, Leaf, Samples};
use crate::label::Label;
use crate::section::Section;

/// Removes them; returns how many there were. Such as reach into leaves without
/// values stay.
pub fn remove_specks(samples: &mut Samples, sections: &[Section]) -> usize {
    let labels = LabelGrid::new(samples);
    let lattice = samples.lattice;
    let [x, y, _] = lattice.dims.map(|nodes| nodes as usize);
    let runs = Runs::new([x, y], |row, runs| add_runs(&labels, row, runs));
    let parts = runs.parts(Neighbors::Six);
    let count = parts.iter().max().map_or(0, |&last| last as usize + 1);
    let mut stays = vec![false; count];
    for (number, run) in runs.runs.iter().enumerate() {
        let stays = &mut stays[parts[number] as usize];
        *stays = *stays || is_passed(run, runs.row_of(number), &lattice, sections);
    }
    for (number, run) in runs.runs.iter().enumerate() {
        let row = runs.row_of(number).map(|at| at as i32);
        let stays = &mut stays[parts[number] as usize];
        *stays = *stays || !nodes(row, run).all(|node| has_values(&labels, node));
    }
    for (number, run) in runs.runs.iter().enumerate() {
        if !stays[parts[number] as usize] {
            let row = runs.row_of(number).map(|at| at as i32);
            nodes(row, run).for_each(|node| yield_node(samples, node, run.label));
        }
    }
    stays.into_iter().filter(|stays| !stays).count()
}

/// The runs of a row, of all labels.
fn add_runs(labels: &LabelGrid, [x, y]: [usize; 2], runs: &mut Vec<Run<Label>>) {
    let (first, end) = (runs.len(), labels.lattice.dims[2]);
    let mut add = |start: i32, after: i32, label: Label| match runs[first..].last() {
        Some(last) if last.label == label => {
            let last = runs.len() - 1;
            runs[last].end = after;
        }
        _ => runs.push(Run { start, end: after, label }),
    };
    let side = LEAF_SIDE as i32;
    for start in (0..end).step_by(LEAF_SIDE) {
        let node = [x as i32, y as i32, start];
        let leaf = labels.lattice.leaf_index(node_in_leaf(node).0);
        if let Some(label) = labels.tile(leaf) {
            add(start, end.min(start + side), label);
            continue;
        }
        for z in start..end.min(start + side) {
            add(z, z + 1, labels.at([node[0], node[1], z]));
        }
    }
}

fn nodes([x, y]: [i32; 2], run: &Run<Label>) -> impl Iterator<Item = [i32; 3]> {
    (run.start..run.end).map(move |z| [x, y, z])
}

fn has_values(labels: &LabelGrid, node: [i32; 3]) -> bool {
    labels.tile(labels.lattice.leaf_index(node_in_leaf(node).0)).is_none()
}

/// Whether the plane of a section passes a run within a voxel, or the run reaches
/// the border of the lattice.
fn is_passed(run: &Run<Label>, row: [usize; 2], lattice: &Lattice, sections: &[Section]) -> bool {
    if run.start == 0 || run.end == lattice.dims[2] {
        return true;
    }
    let [x, y] = row.map(|at| at as i32);
    let ends = [run.start, run.end - 1].map(|z| lattice.position([x, y, z]));
    sections.iter().any(|section| {
        let [low, high] = ends.map(|end| section.plane().distance(end));
        low.min(high) <= lattice.voxel && low.max(high) >= -lattice.voxel
    })
}

/// Gives a node to the label that comes next there.
fn yield_node(samples: &mut Samples, node: [i32; 3], label: Label) {
    let (at, index) = node_in_leaf(node);
    let Ok(place) = samples.leaves.binary_search_by_key(&at, |leaf| leaf.at) else { return };
    let Leaf { materials, .. } = &mut samples.leaves[place];
    let own = materials.iter().position(|one| one.label == label);
    let others = materials.iter().enumerate().filter(|(_, one)| one.label != label);
    let next = others.max_by(|a, b| a.1.values[index].total_cmp(&b.1.values[index]));
    match (own, next.map(|(next, _)| next)) {
        (Some(own), Some(next)) => {
            let [a, b] = [own, next].map(|one| materials[one].values[index]);
            (materials[own].values[index], materials[next].values[index]) = (b, a);
        }
        // Beside a single material *outside* is implied.
        (Some(one), None) | (None, Some(one)) => {
            let value = &mut materials[one].values[index];
            *value = -*value;
        }
        (None, None) => {}
    }
}

#[cfg(test)]
mod tests {
    use glam::DVec3;

    use super::*;
    use crate::check::shapes::disc;
    use crate::grid::samples::Values;
    use crate::mesh::dual;
    use crate::mesh::shapes::samples;
    use crate::plane::Plane;
    use crate::progress::Silent;

    /// A ball around the origin with a bubble in it at z = 0.3, and a small ball at
    /// x = 0.7; label 1.
    fn balls() -> Samples {
        let lattice = Lattice { origin: DVec3::splat(-1.0), voxel: 0.04, dims: [51; 3] };
        let mut samples = samples(lattice, |node| {
            let at = lattice.position(node);
            let ball = |center: DVec3, radius: f64| (radius - at.distance(center)) / 0.04;
            let bubble = ball(0.3 * DVec3::Z, 0.1);
            let large = ball(DVec3::ZERO, 0.5).min(-bubble);
            vec![large.max(ball(0.7 * DVec3::X, 0.1)) as f32]
        });
        samples.values = Values::Distances;
        samples
    }

    #[test]
    fn only_what_a_plane_passes_stays() {
        let section =
            |offset: f64, normal: DVec3| disc(Plane { normal, offset }, 0.4, 60, Label(1));
        let components = |sections: &[Section]| {
            let mut samples = balls();
            let removed = remove_specks(&mut samples, sections);
            samples.sanity_check().unwrap();
            let surface = dual(&samples, &Silent).unwrap().surface(Label(1));
            (removed, surface.facts(false).unwrap().components)
        };
        // At z = 0 through both balls, at z = 0.3 through the bubble alone, at x = −0.2
        // through the large ball alone.
        assert_eq!(components(&[section(0.0, DVec3::Z)]), (1, 2));
        assert_eq!(components(&[section(0.0, DVec3::Z), section(0.3, DVec3::Z)]), (0, 3));
        assert_eq!(components(&[section(-0.2, DVec3::X)]), (2, 1));
    }
}
