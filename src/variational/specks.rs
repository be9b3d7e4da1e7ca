//! Pieces and bubbles that no section speaks for: nowhere in them does a section say
//! their label, and no contour of it passes a node of them. They are where the smoothest field
//! happens to swing across zero, and become what is around them.
//!
//! So do *splinters*, parts of a few nodes that come off where a contour is thinner than
//! a voxel, if there is more of their label elsewhere. A part that holds a whole contour
//! is none.

use std::collections::BTreeSet;

use glam::{DVec2, DVec3};

use crate::grid::labels::{LabelGrid, node_in_leaf};
use crate::grid::leaf::LeafOf;
use crate::grid::leaf_grid::{LeafGrid, LeafSet, leaf_of};
use crate::grid::runs::{Neighbors, Run, Runs};
use crate::grid::samples::{LEAF_SIDE, Samples};
use crate::label::Label;
use crate::plane::Bounds;
use crate::section::Section;
use crate::sets::components;

use super::plane_samples::{Region, plane_samples};

/// Samples of sections are so far apart, in voxels.
const SPACING: f64 = 0.5;

/// A part of fewer nodes may be a splinter.
const FEW_NODES: u32 = 4;

/// Removes them; returns how many there were. Such as reach into leaves without
/// values stay.
pub fn remove_specks(samples: &mut Samples, sections: &[Section], bounds: Bounds) -> usize {
    let mut parts = Parts::new(LabelGrid::new(samples));
    parts.keep_what_has_no_values();
    parts.keep_what_sections_say(sections, bounds);
    for (number, run) in parts.runs.runs.iter().enumerate() {
        if !parts.stays[parts.of_run[number] as usize] {
            parts.nodes(number).for_each(|node| yield_node(samples, node, run.label));
        }
    }
    parts.stays.iter().filter(|stays| !**stays).count()
}

/// The connected parts of all labels.
struct Parts {
    labels: LabelGrid,
    runs: Runs<Label>,
    /// The part of each run.
    of_run: Vec<u32>,
    /// Of each part how many nodes it has.
    sizes: Vec<u32>,
    /// Of each part whether it stays.
    stays: Vec<bool>,
}

impl Parts {
    fn new(labels: LabelGrid) -> Self {
        let [x, y, _] = labels.lattice.dims.map(|nodes| nodes as usize);
        let runs = Runs::new([x, y], |row, runs| add_runs(&labels, row, runs));
        let of_run = runs.parts(Neighbors::Six);
        let count = of_run.iter().max().map_or(0, |&last| last as usize + 1);
        let mut sizes = vec![0u32; count];
        for (run, &part) in runs.runs.iter().zip(&of_run) {
            let size = &mut sizes[part as usize];
            *size = size.saturating_add((run.end - run.start) as u32);
        }
        Self { labels, runs, of_run, sizes, stays: vec![false; count] }
    }

    /// The labels of which some part that is no splinter stays.
    fn labels_that_stay(&self) -> BTreeSet<Label> {
        let parts = self.of_run.iter().map(|&part| part as usize);
        (self.runs.runs.iter().zip(parts))
            .filter(|&(_, part)| self.stays[part] && self.sizes[part] >= FEW_NODES)
            .map(|(run, _)| run.label)
            .collect()
    }

    fn nodes(&self, run: usize) -> impl Iterator<Item = [i32; 3]> + use<> {
        let [x, y] = self.runs.row_of(run).map(|at| at as i32);
        let Run { start, end, .. } = self.runs.runs[run];
        (start..end).map(move |z| [x, y, z])
    }

    fn is_tile(&self, node: [i32; 3]) -> bool {
        self.labels.tile(self.labels.lattice.leaf_index(node_in_leaf(node).0)).is_some()
    }

    fn keep_what_has_no_values(&mut self) {
        for run in 0..self.runs.runs.len() {
            let part = self.of_run[run] as usize;
            self.stays[part] = self.stays[part] || self.nodes(run).any(|node| self.is_tile(node));
        }
    }

    /// Looks where parts may go, which is rarely anywhere.
    fn keep_what_sections_say(&mut self, sections: &[Section], bounds: Bounds) {
        let lattice = self.labels.lattice;
        let mut doubtful = LeafSet::new(&LeafGrid::new([0; 3], lattice.dims));
        for run in 0..self.runs.runs.len() {
            if !self.stays[self.of_run[run] as usize] {
                self.nodes(run).for_each(|node| {
                    doubtful.insert(node_in_leaf(node).0);
                });
            }
        }
        let place = |at: DVec3| (at - lattice.origin) / lattice.voxel;
        // A point counts for the node that is nearest to it.
        let origin = lattice.origin - DVec3::splat(lattice.voxel / 2.0);
        let side = LEAF_SIDE as f64 * lattice.voxel;
        let region = Region::Leaves { leaves: &doubtful, origin, side };
        let mut said: Vec<([i32; 3], Label)> = Vec::new();
        for sample in
            plane_samples(sections, (bounds, bounds.middle()), SPACING * lattice.voxel, region)
        {
            said.push((place(sample.at).round().as_ivec3().to_array(), sample.label));
        }
        // And along contours, for what is thinner than the samples are apart.
        for section in sections {
            let is_small = small_contours(section, f64::from(FEW_NODES) * lattice.voxel);
            for (edge, [start, end]) in section.edges().iter().zip(section.segments()) {
                let count = (start.distance(end) / (SPACING * lattice.voxel)).ceil().max(1.0);
                for step in 0..=count as u64 {
                    let at = place(start.lerp(end, step as f64 / count));
                    let node = at.round().as_ivec3().to_array();
                    if !doubtful.has(leaf_of(node)) {
                        continue;
                    }
                    for label in [edge.left, edge.right] {
                        if is_small[edge.start as usize] {
                            self.keep(node, label, 0);
                        }
                        said.push((node, label));
                    }
                }
            }
        }
        said.iter().for_each(|&(node, label)| self.keep(node, label, FEW_NODES));
        let labels = self.labels_that_stay();
        said.retain(|(_, label)| !labels.contains(label));
        said.iter().for_each(|&(node, label)| self.keep(node, label, 0));
    }

    /// Keeps the part of a node, where it has this label and at least so many nodes.
    fn keep(&mut self, node: [i32; 3], label: Label, nodes: u32) {
        let dims = self.labels.lattice.dims;
        if (0..3).any(|axis| !(0..dims[axis]).contains(&node[axis])) {
            return;
        }
        let row = self.runs.row(node[0] as usize * self.runs.dims[1] + node[1] as usize);
        let place = self.runs.runs[row.clone()].partition_point(|run| run.end <= node[2]);
        let run = row.start + place;
        let part = self.of_run[run] as usize;
        if self.runs.runs[run].label == label && self.sizes[part] >= nodes {
            self.stays[part] = true;
        }
    }
}

/// For every vertex of a section whether its contour, all that edges connect it with, is
/// within a box with this diagonal.
fn small_contours(section: &Section, diagonal: f64) -> Vec<bool> {
    let vertices = section.vertices();
    let edges = section.edges().iter().map(|edge| [edge.start, edge.end]);
    let contours = components(vertices.len() as u32, edges);
    let count = contours.iter().max().map_or(0, |&last| last as usize + 1);
    let mut boxes = vec![[DVec2::INFINITY, DVec2::NEG_INFINITY]; count];
    for (&vertex, &contour) in vertices.iter().zip(&contours) {
        let [low, high] = &mut boxes[contour as usize];
        (*low, *high) = (low.min(vertex), high.max(vertex));
    }
    let is_small = |[low, high]: [DVec2; 2]| low.distance(high) <= diagonal;
    contours.into_iter().map(|contour| is_small(boxes[contour as usize])).collect()
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

/// Gives a node to the label that comes next there.
fn yield_node(samples: &mut Samples, node: [i32; 3], label: Label) {
    let (at, index) = node_in_leaf(node);
    let Some(LeafOf { mut materials, .. }) = samples.leaf_mut(at) else { return };
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
    use crate::grid::samples::{Lattice, Values};
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
    fn only_what_a_section_says_stays() {
        let bounds = Bounds { min: DVec3::splat(-1.0), max: DVec3::splat(1.0) };
        let section = |offset: f64, normal: DVec3, radius: f64| {
            disc(Plane { normal, offset }, radius, 60, Label(1))
        };
        let components = |sections: &[Section]| {
            let mut samples = balls();
            let removed = remove_specks(&mut samples, sections, bounds);
            samples.sanity_check().unwrap();
            let surface = dual(&samples, &Silent).unwrap().surface(Label(1));
            (removed, surface.facts(false).unwrap().components)
        };
        // At z = 0 through both balls, but material only within 0.4: the small ball, at
        // 0.6 to 0.8, is denied, and nothing speaks for the bubble.
        assert_eq!(components(&[section(0.0, DVec3::Z, 0.4)]), (2, 1));
        // Material within 0.9: the small ball stays.
        assert_eq!(components(&[section(0.0, DVec3::Z, 0.9)]), (1, 2));
        // A contour at z = 0.3 passes the bubble's border, so it stays.
        let ring = section(0.3, DVec3::Z, 0.1);
        assert_eq!(components(&[section(0.0, DVec3::Z, 0.9), ring]), (0, 3));
    }

    #[test]
    fn a_splinter_goes_unless_it_is_all_there_is() {
        let bounds = Bounds { min: DVec3::splat(-1.0), max: DVec3::splat(1.0) };
        let lattice = Lattice { origin: DVec3::splat(-1.0), voxel: 0.04, dims: [51; 3] };
        let floor = Plane { normal: DVec3::Z, offset: 0.0 };
        // Two nodes at x = 0.72 and 0.76, and a ball or none.
        let parts = |radius: f64, sections: &[Section]| {
            let mut samples = samples(lattice, |node| {
                let at = lattice.position(node);
                let splinter = node == [43, 25, 25] || node == [44, 25, 25];
                let ball = (radius - at.length()) / 0.04;
                vec![if splinter { 0.3 } else { ball.clamp(-4.0, 4.0) as f32 }]
            });
            samples.values = Values::Distances;
            let removed = remove_specks(&mut samples, sections, bounds);
            let surface = dual(&samples, &Silent).unwrap().surface(Label(1));
            (removed, surface.facts(false).unwrap().components)
        };
        // The section says the label there, as part of something large.
        let large = disc(floor, 0.9, 60, Label(1));
        assert_eq!(parts(0.5, std::slice::from_ref(&large)), (1, 1));
        assert_eq!(parts(-1.0, std::slice::from_ref(&large)), (0, 1));
        // Another one has a small contour of its own there.
        let small = disc(Plane { normal: DVec3::X, offset: 0.74 }, 0.01, 12, Label(1));
        assert_eq!(parts(0.5, &[large, small]), (0, 2));
    }
}
