//! What the corners see of the cells on both sides, again and again.

use glam::DVec3;
use rayon::prelude::*;

use super::{Completion, Free};
use crate::complex::Complex;
use crate::error::Result;
use crate::field::boundaries::Boundary;
use crate::field::cpu::{Instructions, Job};
use crate::field::packing::{PackedCell, Part};
use crate::field::ramps::Ramps;

/// The linear system of the free corners.
pub(super) struct Sweeper<'a> {
    free: &'a [Free],
    /// For each free corner its weight of every label that does not change
    /// from sweep to sweep.
    known: Vec<f64>,
    views: Vec<View>,
    cells: Vec<Option<(PackedCell, Vec<Ramps>)>>,
    instructions: Instructions,
}

/// The free corners on one face, looking into one of its cells.
struct View {
    cell: u32,
    /// The face, as an index into the cell's.
    face: u32,
    /// Indices of free corners.
    corners: Vec<u32>,
    points: Vec<DVec3>,
}

impl<'a> Sweeper<'a> {
    pub fn new(
        complex: &'a Complex,
        clearance: f64,
        completion: &Completion,
        free: &'a [Free],
    ) -> Result<Self> {
        let views = views(complex, completion, free);
        let mut seen = vec![false; complex.cells().end()];
        views.iter().for_each(|view| seen[view.cell as usize] = true);
        let boundary = |cell: usize| Boundary {
            complex,
            completion,
            clearance,
            labels: completion.labels(),
            facets: &complex.cells()[cell as u32].facets,
        };
        let cells = seen
            .into_par_iter()
            .enumerate()
            .map(|(cell, seen)| seen.then(|| PackedCell::with_ramps(&boundary(cell))).transpose())
            .collect::<Result<_>>()?;
        let known = free.iter().flat_map(|free| free.weights.iter().copied()).collect();
        let mut sweeper = Self { free, known, views, cells, instructions: Instructions::detect() };
        let mut known = std::mem::take(&mut sweeper.known);
        sweeper.look(Part::KnownBut, &mut known);
        sweeper.known = known;
        Ok(sweeper)
    }

    /// For every free corner the mean of what it sees; none where it sees nothing that has
    /// shares.
    pub fn sweep(&mut self, completion: &Completion) -> Vec<f32> {
        self.cells.par_iter_mut().flatten().for_each(|(cell, ramps)| {
            cell.set_slopes(ramps, completion);
        });
        let mut weights = self.known.clone();
        self.look(Part::UnknownBut, &mut weights);
        let mean = |weights: &[f64]| -> Vec<f32> {
            // Rounding can make a share that is zero a little less.
            let weights = weights.iter().map(|weight| weight.max(0.0));
            let total: f64 = weights.clone().sum();
            let total = if total > 0.0 { total } else { 1.0 };
            weights.map(|weight| (weight / total) as f32).collect()
        };
        weights.chunks_exact(completion.labels.len()).flat_map(mean).collect()
    }

    /// Adds what every free corner sees of a part of its cells, in 1/world
    /// units.
    fn look(&self, part: impl Fn(u32) -> Part + Sync, weights: &mut [f64]) {
        let Some(labels) = weights.len().checked_div(self.free.len()) else { return };
        let seen: Vec<(f64, Vec<f32>)> =
            self.views.par_iter().map(|view| self.view(view, part(view.face), labels)).collect();
        // In the order of the views, whatever the threads.
        for (view, (scale, values)) in self.views.iter().zip(seen) {
            for (&corner, values) in view.corners.iter().zip(values.chunks_exact(labels)) {
                let own = &mut weights[corner as usize * labels..][..labels];
                own.iter_mut()
                    .zip(values)
                    .for_each(|(sum, &value)| *sum += scale * f64::from(value));
            }
        }
    }

    /// The kernel's weights lack a half, and are in the cell's units.
    fn view(&self, view: &View, part: Part, labels: usize) -> (f64, Vec<f32>) {
        let mut values = vec![0.0; view.points.len() * labels];
        let Some((cell, _)) = &self.cells[view.cell as usize] else { return (0.0, values) };
        if cell.labels.len() == 1 {
            values.fill(1.0);
            return (1.0, values);
        }
        Job { cell, part, points: &view.points, values: &mut values }.weigh(self.instructions);
        (cell.scale / 2.0, values)
    }
}

fn views(complex: &Complex, completion: &Completion, free: &[Free]) -> Vec<View> {
    let mut number = vec![u32::MAX; completion.corner_count()];
    for (index, free) in free.iter().enumerate() {
        number[free.corner as usize] = index as u32;
    }
    let mut views = Vec::new();
    for (id, facet) in complex.facets().iter() {
        let triangles = completion.triangles(id);
        let mut corners: Vec<u32> =
            triangles.iter().flatten().map(|&corner| number[corner as usize]).collect();
        corners.sort_unstable();
        corners.dedup();
        corners.retain(|&corner| corner != u32::MAX);
        if corners.is_empty() {
            continue;
        }
        let place = |&corner: &u32| completion.point(free[corner as usize].corner);
        let points: Vec<DVec3> = corners.iter().map(place).collect();
        for cell in facet.cells.into_iter().flatten() {
            let facets = &complex.cells()[cell].facets;
            let Some(face) = facets.iter().position(|&facet| facet == id) else { continue };
            let (corners, points) = (corners.clone(), points.clone());
            views.push(View { cell, face: face as u32, corners, points });
        }
    }
    views
}
