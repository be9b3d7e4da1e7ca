//! The stages of a cross-check, from the field's model on.

use glam::DVec3;

use super::against::{Other, against};
use super::agreement::{Agreement, Pair, agreement};
use super::certain::{Judges, Points, points};
use super::exact::Exact;
use super::gap::{Gap, Measured, gap};
use super::pairing::pairing;
use super::parts::{parts, positions};
use super::report::{Distances, Found, SkeletonReport};
use super::solids::solids;
use super::{Options, derived};
use crate::error::Result;
use crate::field::{self, Boundaries};
use crate::grid::evidence::Evidence;
use crate::grid::labels::LabelGrid;
use crate::grid::samples::Samples;
use crate::grid::sampling::{Margin, Starts, sample};
use crate::label::Label;
use crate::mesh::delaunay::delaunay;
use crate::mesh::{Mesh, dual};
use crate::model::{CLEARANCE, Derived, Model};
use crate::oracle::Oracle;
use crate::progress::Progress;
use crate::section::Section;
use crate::skeleton::{self, skeleton};
use crate::stage::Stages;

/// What there is to work on.
#[derive(Clone, Copy)]
pub struct Work<'a> {
    /// The field's.
    pub model: &'a Model,
    /// What is asked for.
    pub options: &'a Options,
    /// Told how far it has come.
    pub progress: &'a dyn Progress,
}

/// What came out; see [`Findings`](super::Findings).
pub struct Compared {
    pub found: Found,
    pub skeleton: Mesh,
    pub pair: Pair,
    pub differing: Vec<[i32; 3]>,
    pub depths: Vec<f32>,
    pub distances: Vec<f32>,
}

/// The surfaces that are held against each other.
struct Surfaces<'a> {
    dual: &'a Mesh,
    delaunay: Option<&'a Mesh>,
    skeleton: &'a Mesh,
}

/// Distances between them.
struct Between {
    distances: Distances,
    depths: Vec<f32>,
    vertices: Vec<f32>,
}

impl Work<'_> {
    /// All stages.
    ///
    /// # Errors
    /// Those of the stages.
    pub fn compare(&self, other: Option<&Other>, stages: &mut Stages) -> Result<Compared> {
        let derived = derived(self.model)?;
        let voxel = derived.samples.lattice.voxel;
        let boundaries =
            Boundaries::new(&derived.arrangement, CLEARANCE * voxel, self.options.spacing)?;
        let bounds = derived.arrangement.bounds();
        let oracle = Oracle::new(self.sections(), bounds, self.options.border)?;
        let exact = self.sample_oracle(derived, &oracle, &boundaries, stages)?;
        let (skeleton, how) = self.skeleton(derived, &oracle, stages)?;
        let pair =
            Pair { field: LabelGrid::new(&derived.samples), skeleton: LabelGrid::new(&exact) };
        drop(exact);
        let delaunay = self.delaunay(derived, stages)?;

        let (agreement, differing) = self.agreement(&pair, stages)?;
        let points =
            self.points(derived, &boundaries, &oracle, &positions(&pair, &differing), stages)?;
        let pairing = stages.run("pairing", |counts| {
            let names: Vec<&str> = self.sections().iter().map(Section::name).collect();
            let pairing = pairing(&derived.arrangement, &names, &pair, self.progress);
            counts.insert("cells".into(), pairing.cells as u64);
            Ok(pairing)
        })?;
        let surfaces =
            Surfaces { dual: &derived.mesh, delaunay: delaunay.as_ref(), skeleton: &skeleton };
        let labels = stages.run("solids", |_| {
            self.progress.begin("solids", 0);
            solids(surfaces.dual, surfaces.delaunay, surfaces.skeleton)
        })?;
        let between = self.between(&surfaces, &pair, &differing, voxel, stages)?;
        let (part_count, parts) = parts(&pair, &differing, &between.depths);
        let against = other.map(|other| {
            stages.run("against", |_| against(&derived.mesh, other, voxel, self.progress))
        });
        let found = Found {
            skeleton: how,
            agreement,
            points,
            part_count,
            parts,
            pairing,
            labels,
            distances: between.distances,
            against: against.transpose()?,
        };
        let Between { depths, vertices: distances, .. } = between;
        Ok(Compared { found, skeleton, pair, differing, depths, distances })
    }

    fn sections(&self) -> &[Section] {
        &self.model.sections().sections
    }

    /// The oracle's labels on the field's lattice.
    fn sample_oracle(
        &self,
        derived: &Derived,
        oracle: &Oracle,
        boundaries: &Boundaries,
        stages: &mut Stages,
    ) -> Result<Samples> {
        stages.run("oracle", |counts| {
            let starts = Starts { sections: self.sections(), completion: boundaries.completion() };
            let (cells, lattice) = (&derived.arrangement, &derived.samples.lattice);
            let exact = Exact::new(oracle, cells);
            let found = sample(cells, &exact, &starts, lattice, Margin(1), self.progress)?;
            counts.insert("leaves".into(), found.samples.leaves.len() as u64);
            counts.insert("evaluations".into(), found.points);
            Ok(found.samples)
        })
    }

    /// The skeleton's surface.
    fn skeleton(
        &self,
        derived: &Derived,
        oracle: &Oracle,
        stages: &mut Stages,
    ) -> Result<(Mesh, SkeletonReport)> {
        let unknown = |section: &Section| section.labels().contains(&Label::UNKNOWN);
        let is_partial =
            self.options.border != Label::OUTSIDE || self.sections().iter().any(unknown);
        stages.run("skeleton", |counts| {
            let made = if is_partial {
                self.sampled_skeleton(derived, oracle)
            } else {
                self.exact_skeleton(derived)
            }?;
            counts.insert("triangles".into(), made.0.triangles.len() as u64);
            Ok(made)
        })
    }

    /// Between full sections.
    fn exact_skeleton(&self, derived: &Derived) -> Result<(Mesh, SkeletonReport)> {
        let bounds = derived.arrangement.bounds();
        let options = skeleton::Options::default();
        let made = skeleton(self.sections(), bounds, &options, self.progress)?;
        let report = SkeletonReport {
            exact: true,
            vertices: made.mesh.vertices.len(),
            triangles: made.mesh.triangles.len(),
            contradictions: made.contradictions,
        };
        Ok((made.mesh, report))
    }

    /// Where parts are unknown: what the oracle says on the grid.
    fn sampled_skeleton(
        &self,
        derived: &Derived,
        oracle: &Oracle,
    ) -> Result<(Mesh, SkeletonReport)> {
        let samples = oracle.sample(&derived.samples.lattice, self.progress)?;
        let mesh = dual(&samples, self.progress)?;
        let report = SkeletonReport {
            exact: false,
            vertices: mesh.vertices.len(),
            triangles: mesh.triangles.len(),
            contradictions: Vec::new(),
        };
        Ok((mesh, report))
    }

    /// The field's surface by the other mesher.
    fn delaunay(&self, derived: &Derived, stages: &mut Stages) -> Result<Option<Mesh>> {
        let Some(limits) = self.options.delaunay else { return Ok(None) };
        stages.run("delaunay", |counts| {
            let mesh = delaunay(&derived.samples, &limits, self.progress)?;
            counts.insert("triangles".into(), mesh.triangles.len() as u64);
            Ok(Some(mesh))
        })
    }

    /// All nodes.
    fn agreement(&self, pair: &Pair, stages: &mut Stages) -> Result<(Agreement, Vec<[i32; 3]>)> {
        stages.run("agreement", |counts| {
            let evidence = Evidence::new(self.sections());
            let (agreement, differing) = agreement(pair, &evidence, self.progress);
            counts.insert("nodes".into(), agreement.nodes);
            counts.insert("differing".into(), differing.len() as u64);
            Ok((agreement, differing))
        })
    }

    /// Random points, and nodes that differ.
    fn points(
        &self,
        derived: &Derived,
        boundaries: &Boundaries,
        oracle: &Oracle,
        nodes: &[DVec3],
        stages: &mut Stages,
    ) -> Result<Points> {
        stages.run("points", |counts| {
            let field = field::new(boundaries, self.options.device)?;
            let judges = Judges {
                arrangement: &derived.arrangement,
                boundaries,
                field: field.as_ref(),
                oracle,
                sections: self.sections(),
            };
            let drawn = (self.options.points, self.options.seed);
            let points = points(&judges, nodes, drawn, self.progress)?;
            counts.insert("must agree".into(), points.must_agree);
            Ok(points)
        })
    }

    /// How far surfaces are from each other, and nodes from surfaces.
    fn between(
        &self,
        surfaces: &Surfaces,
        pair: &Pair,
        differing: &[[i32; 3]],
        voxel: f64,
        stages: &mut Stages,
    ) -> Result<Between> {
        stages.run("distances", |_| {
            self.progress.begin("distances", 3);
            let dual = Measured::network(surfaces.dual)?;
            let skeleton = Measured::network(surfaces.skeleton)?;
            let delaunay = surfaces.delaunay.map(Measured::network).transpose()?.flatten();
            let to_skeleton = gap_between(dual.as_ref(), skeleton.as_ref(), voxel)?;
            self.progress.advance(1);
            let to_delaunay = gap_between(dual.as_ref(), delaunay.as_ref(), voxel)?;
            self.progress.advance(1);
            let depths = least_distances([&dual, &skeleton], &positions(pair, differing))?;
            self.progress.advance(1);
            let (dual_skeleton, vertices) = to_skeleton.unzip();
            let dual_delaunay = to_delaunay.map(|(gap, _)| gap);
            // Without a skeleton there is nothing to be far from.
            let vertices = vertices.unwrap_or_default();
            Ok(Between {
                distances: Distances { dual_skeleton, dual_delaunay },
                depths: depths.into_iter().map(|depth| depth as f32).collect(),
                vertices: vertices.into_iter().map(|far| (far / voxel) as f32).collect(),
            })
        })
    }
}

/// The gap between two surfaces, if both are there.
fn gap_between(
    one: Option<&Measured>,
    other: Option<&Measured>,
    voxel: f64,
) -> Result<Option<(Gap, Vec<f64>)>> {
    one.zip(other).map(|(one, other)| gap(one, other, voxel)).transpose()
}

/// The distance of points to the nearest of the surfaces that there are; 0
/// where there is none.
fn least_distances(surfaces: [&Option<Measured>; 2], points: &[DVec3]) -> Result<Vec<f64>> {
    let mut least = vec![f64::INFINITY; points.len()];
    for surface in surfaces.into_iter().flatten() {
        for (least, distance) in least.iter_mut().zip(surface.distances(points)?) {
            *least = least.min(distance);
        }
    }
    Ok(least.into_iter().map(|least| if least.is_finite() { least } else { 0.0 }).collect())
}
