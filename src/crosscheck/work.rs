//! The stages of a cross-check, from the field's model on.

use glam::DVec3;

use super::against::{Against, Other, against};
use super::agreement::{Agreement, Pair, agreement};
use super::certain::{Judges, Points, points};
use super::depth::depths;
use super::gap::{Gap, Measured, gap};
use super::pairing::{Pairing, pairing};
use super::parts::{parts, positions};
use super::report::{Distances, Found, SkeletonReport};
use super::solids::{LabelSolids, solids};
use super::{Kind, Options, derived};
use crate::bounding::bordered;
use crate::complex::Complex;
use crate::derived::{CLEARANCE, Derived, arranged};
use crate::error::{Error, Result};
use crate::field::{self, Boundaries};
use crate::grid::evidence::Evidence;
use crate::grid::labels::LabelGrid;
use crate::label::Label;
use crate::mesh::delaunay::delaunay;
use crate::mesh::{Mesh, dual};
use crate::model::Model;
use crate::oracle::Oracle;
use crate::progress::Progress;
use crate::section::Section;
use crate::skeleton::{self, Details, skeleton};
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

/// What both methods start from.
#[derive(Clone, Copy)]
struct Base<'a> {
    /// Those that bound cells.
    sections: &'a [Section],
    derived: &'a Derived,
    complex: &'a Complex,
    oracle: &'a Oracle<'a>,
}

impl Work<'_> {
    /// All stages.
    ///
    /// # Errors
    /// Those of the stages.
    pub fn compare(&self, other: Option<&Other>, stages: &mut Stages) -> Result<Compared> {
        let derived = derived(self.model)?;
        let bounds = self.options.bounds(self.model.sections())?;
        let sections = bordered(self.sections(), bounds, self.options.border)?;
        let sections = sections.as_ref();
        let built = match derived.complex {
            Some(_) => None,
            None => {
                let border = self.options.border;
                Some(arranged(sections, bounds, border, stages, self.progress)?)
            }
        };
        let complex = derived.complex.as_ref().or(built.as_ref()).ok_or_else(no_cells)?;
        let oracle = Oracle::new(sections, bounds, self.options.border)?;
        let base = Base { sections, derived, complex, oracle: &oracle };

        let pair = self.labels(base, stages)?;
        let (skeleton, how) = self.skeleton(base, stages)?;
        let delaunay = self.delaunay(derived, stages)?;
        let surfaces =
            Surfaces { dual: &derived.mesh, delaunay: delaunay.as_ref(), skeleton: &skeleton };

        let (agreement, differing) = self.agreement(&pair, stages)?;
        let nodes = positions(&pair, &differing);
        let points = self.points(base, &nodes, stages)?;
        let pairing = self.pairing(complex, &pair, stages)?;
        let labels = self.solids(&surfaces, stages)?;
        let (distances, vertices) = self.distances(derived, &surfaces, stages)?;
        let depths = depths(&derived.samples.lattice, &differing);
        let (part_count, parts) = parts(&pair, &differing, &depths);
        let against = self.against(derived, other, stages)?;
        let found = Found {
            skeleton: how,
            agreement,
            points,
            part_count,
            parts,
            pairing,
            labels,
            distances,
            against,
        };
        Ok(Compared { found, skeleton, pair, differing, depths, distances: vertices })
    }

    fn sections(&self) -> &[Section] {
        &self.model.sections().sections
    }

    /// Both labels on the field's lattice.
    fn labels(&self, base: Base, stages: &mut Stages) -> Result<Pair> {
        stages.run("oracle", |counts| {
            let samples = &base.derived.samples;
            let found = base.oracle.sample_labels(&samples.lattice, self.progress)?;
            counts.insert("leaves".into(), found.valued.len() as u64);
            Ok(Pair { field: LabelGrid::new(samples), skeleton: LabelGrid::new(&found) })
        })
    }

    /// The skeleton's surface.
    fn skeleton(&self, base: Base, stages: &mut Stages) -> Result<(Mesh, SkeletonReport)> {
        let is_partial = self.options.border != Label::OUTSIDE
            || self.sections().iter().any(Section::is_partial);
        stages.run("skeleton", |counts| {
            let made = match is_partial {
                true => self.sampled_skeleton(base),
                false => self.exact_skeleton(base),
            }?;
            counts.insert("triangles".into(), made.0.triangles.len() as u64);
            Ok(made)
        })
    }

    /// Between full sections.
    fn exact_skeleton(&self, base: Base) -> Result<(Mesh, SkeletonReport)> {
        let options = skeleton::Options::default();
        let made = skeleton(base.sections, base.complex.bounds(), &options, self.progress)?;
        let report = SkeletonReport {
            exact: true,
            vertices: made.mesh.vertices.len(),
            triangles: made.mesh.triangles.len(),
            details: made.details,
        };
        Ok((made.mesh, report))
    }

    /// Where parts are unknown: what the oracle says on the grid.
    fn sampled_skeleton(&self, base: Base) -> Result<(Mesh, SkeletonReport)> {
        let samples = base.oracle.sample(&base.derived.samples.lattice, self.progress)?;
        let mesh = dual(&samples, self.progress)?;
        let report = SkeletonReport {
            exact: false,
            vertices: mesh.vertices.len(),
            triangles: mesh.triangles.len(),
            details: Details::default(),
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

    /// Random points, and nodes that differ: what must agree is known of the
    /// indicator alone.
    fn points(&self, base: Base, nodes: &[DVec3], stages: &mut Stages) -> Result<Option<Points>> {
        if self.options.field != Kind::MeanValue {
            return Ok(None);
        }
        stages.run("points", |counts| {
            let clearance = CLEARANCE * base.derived.samples.lattice.voxel;
            let boundaries = Boundaries::new(base.complex, clearance, self.options.spacing)?;
            let field = field::new(&boundaries, self.options.device)?;
            let judges = Judges {
                complex: base.complex,
                boundaries: &boundaries,
                field: field.as_ref(),
                oracle: base.oracle,
                sections: base.sections,
            };
            let drawn = (self.options.points, self.options.seed);
            let points = points(&judges, nodes, drawn, self.progress)?;
            counts.insert("must agree".into(), points.must_agree);
            Ok(Some(points))
        })
    }

    /// What is joined within cells.
    fn pairing(&self, cells: &Complex, pair: &Pair, stages: &mut Stages) -> Result<Pairing> {
        stages.run("pairing", |counts| {
            let pairing = pairing(cells, pair, self.progress);
            counts.insert("cells".into(), pairing.cells as u64);
            Ok(pairing)
        })
    }

    /// Every label's surface.
    fn solids(&self, surfaces: &Surfaces, stages: &mut Stages) -> Result<Vec<LabelSolids>> {
        stages.run("solids", |_| {
            self.progress.begin("solids", 0);
            solids(surfaces.dual, surfaces.delaunay, surfaces.skeleton)
        })
    }

    /// The field's surface and the user's.
    fn against(
        &self,
        derived: &Derived,
        other: Option<&Other>,
        stages: &mut Stages,
    ) -> Result<Option<Against>> {
        let Some(other) = other else { return Ok(None) };
        let voxel = derived.samples.lattice.voxel;
        stages.run("against", |_| against(&derived.mesh, other, voxel, self.progress).map(Some))
    }

    /// How far surfaces are from each other, and each vertex of the field's
    /// from the skeleton's, in voxels.
    fn distances(
        &self,
        derived: &Derived,
        surfaces: &Surfaces,
        stages: &mut Stages,
    ) -> Result<(Distances, Vec<f32>)> {
        let voxel = derived.samples.lattice.voxel;
        stages.run("distances", |_| {
            self.progress.begin("distances", 2);
            let dual = Measured::network(surfaces.dual)?;
            let skeleton = Measured::network(surfaces.skeleton)?;
            let delaunay = surfaces.delaunay.map(Measured::network).transpose()?.flatten();
            let to_skeleton = gap_between(dual.as_ref(), skeleton.as_ref(), voxel)?;
            self.progress.advance(1);
            let to_delaunay = gap_between(dual.as_ref(), delaunay.as_ref(), voxel)?;
            self.progress.advance(1);
            let (dual_skeleton, vertices) = to_skeleton.unzip();
            let dual_delaunay = to_delaunay.map(|(gap, _)| gap);
            // Without a skeleton there is nothing to be far from.
            let vertices = vertices.unwrap_or_default().into_iter();
            let vertices = vertices.map(|far| (far / voxel) as f32).collect();
            Ok((Distances { dual_skeleton, dual_delaunay }, vertices))
        })
    }
}

fn no_cells() -> Error {
    Error::Bug { stage: "crosscheck", what: "the sections have no cells".to_owned() }
}

/// The gap between two surfaces, if both are there.
fn gap_between(
    one: Option<&Measured>,
    other: Option<&Measured>,
    voxel: f64,
) -> Result<Option<(Gap, Vec<f64>)>> {
    one.zip(other).map(|(one, other)| gap(one, other, voxel)).transpose()
}
