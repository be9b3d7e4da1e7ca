//! What follows from sections: the whole way from them to the mesh, by each of the methods.
//!
//! Every method keeps something for the next change ([`Lasting`]).

use std::borrow::Cow;
use std::collections::BTreeMap;

use crate::bounding::{bordered, frame};
use crate::capping::Capping;
use crate::complex::Complex;
use crate::error::Result;
use crate::field::{self, Boundaries, Evaluator, hermite};
use crate::grid::frame::Frame;
use crate::grid::memory::require_memory;
use crate::grid::samples::{Lattice, Samples};
use crate::grid::sampling::{Margin, Starts, sample, sample_again};
use crate::label::Label;
use crate::living::{self, Living};
use crate::mesh::Mesh;
use crate::mesh::caps::CAP_TOLERANCE;
use crate::mesh::decimation::{Decimation, Outcome, decimate};
use crate::mesh::delaunay::delaunay;
use crate::mesh::dual::{KeptBlocks, dual_again};
use crate::mesh::fairing::{FairingOptions, fair};
use crate::method::{
    Fairing, Hermite, MeanValue, Mesher, Method, ShapeBased, Skeleton, Variational,
};
use crate::model::Options;
use crate::oracle::Oracle;
use crate::plane::{Bounds, Plane};
use crate::progress::Progress;
use crate::section::{Section, Sections};
use crate::skeleton::{Details, Kept as KeptSurfaces};
use crate::stack::{Links, Stacked, stacked};
use crate::stage::Stages;
use crate::variational::smoothing::{KeptSmoothing, smoothed};
use crate::variational::specks::remove_specks;
use crate::variational::{Kept, KeptBackend, variational};

/// How near to a plane the field is told from its limit, in voxels: nearer
/// points are taken to be this far away. On the plane the indicator is a
/// step, in which an interpolated crossing would be lost.
pub(crate) const CLEARANCE: f64 = 0.02;

/// How long a fair surface's edges are, relative to the box's longest side: with shorter ones
/// terraces remain after as many steps, with longer ones thin limbs get narrower.
const FAIR_EDGE: f64 = 0.0065;
/// Steps of smoothing on each of fairing's levels: with fewer terraces remain, with more
/// thin limbs get narrower between the sections.
const FAIRING_STEPS: u32 = 400;

/// Where what is drawn is smaller in the box, lengths are chosen as if it were such a part of it.
const MOST_SPANS: f64 = 8.0;

/// What a method keeps for the next change.
#[derive(Debug, Default)]
pub(crate) struct Lasting {
    /// The cells and samples of the mean-value field.
    cells: Option<Living>,
    /// The variational field.
    fields: Option<Kept>,
    /// The fields that smooth the mean-value field.
    smoothing: Option<KeptSmoothing>,
    /// Surfaces of the exact reconstruction.
    surfaces: KeptSurfaces,
    /// Devices, which take a while to open.
    evaluator: Evaluator,
    solver: KeptBackend,
}

impl Lasting {
    /// Lets go of devices, one of which may be lost: another one will do.
    pub fn close_devices(&mut self) {
        (self.evaluator, self.solver) = Default::default();
    }
}

/// What follows from the sections.
#[derive(Debug)]
pub struct Derived {
    /// The cells between the sections, where the field was asked.
    pub complex: Option<Complex>,
    /// The field's values near the surface, smoothed.
    pub samples: Samples,
    /// The network of surfaces.
    pub mesh: Mesh,
    /// The backend that evaluated the field.
    pub device: String,
    /// What else an exact reconstruction says.
    pub exact: Option<Details>,
    /// The parts of a stack that are linked, or would be.
    pub links: Option<Links>,
    /// What making the mesh simpler did.
    pub decimation: Option<Outcome>,
    /// The mesh leaf by leaf, for the next one.
    blocks: KeptBlocks,
}

impl Derived {
    /// Makes the mesh simpler; where the box is open its caps stay on its faces.
    fn decimate(
        &mut self,
        decimation: Decimation,
        stages: &mut Stages,
        progress: &dyn Progress,
    ) -> Result<()> {
        let tolerance = CAP_TOLERANCE * self.samples.lattice.voxel;
        let rim = self.samples.open.map(|bounds| self.mesh.rim(bounds, tolerance));
        stages.run("decimation", |counts| {
            let made = decimate(&self.mesh, &rim.unwrap_or_default(), decimation, progress)?;
            counts.insert("triangles before".into(), made.outcome.before as u64);
            counts.insert("triangles".into(), made.outcome.triangles as u64);
            (self.mesh, self.decimation) = (made.mesh, Some(made.outcome));
            Ok(())
        })
    }

    /// The samples and what is kept of their mesh, their leaves named as those of a lattice;
    /// `None` where they have none in common, or nothing is kept.
    fn on(&self, lattice: Lattice) -> Option<(Cow<'_, Samples>, Cow<'_, KeptBlocks>)> {
        let by = self.samples.lattice.leaves_to(&lattice).filter(|_| !self.blocks.is_empty())?;
        Some(match self.samples.lattice == lattice {
            true => (Cow::Borrowed(&self.samples), Cow::Borrowed(&self.blocks)),
            false => {
                (Cow::Owned(self.samples.moved(by, lattice)), Cow::Owned(self.blocks.moved(by)))
            }
        })
    }
}

/// What methods derive from.
struct Ground<'a> {
    sections: &'a [Section],
    frame: Frame,
    /// How large what is drawn is, or the given box, in world units: what lengths are chosen by
    /// that nobody gave.
    span: f64,
    /// Whether the box was given: it may be evidence then, and stays when ends move.
    is_given: bool,
    /// Whether what is derived is to be kept for the next change.
    keeps: bool,
    /// What was derived from the sections as they were.
    before: Option<&'a Derived>,
}

/// The whole way from sections to the mesh.
pub(crate) fn derive(
    sections: &Sections,
    options: &Options,
    lasting: &mut Lasting,
    before: Option<&Derived>,
    stages: &mut Stages,
    progress: &dyn Progress,
) -> Result<Derived> {
    let frame = frame(sections, options)?;
    require_memory(&frame.lattice, &sections.sections, sections.materials.len())?;
    // Where the nodes follow the box, fields leave nothing behind: the same sections make the
    // same then, to the last bit, whatever was before.
    let keeps = options.bounds.is_some() || frame.is_fixed;
    let span = options.bounds.map_or_else(|| sections.span(), |given| given.size().max_element());
    let is_given = options.bounds.is_some();
    let ground = Ground { sections: &sections.sections, frame, span, is_given, keeps, before };
    let mut derived = match &options.method {
        Method::Variational(method) => ground.solve(method, lasting, stages, progress),
        Method::MeanValue(method) => ground.evaluate(method, lasting, stages, progress),
        Method::Hermite(method) => ground.blend(method, &mut lasting.evaluator, stages, progress),
        Method::Stack(method) => ground.interpolate(method, stages, progress),
        Method::Skeleton(method) => ground.build(method, &mut lasting.surfaces, stages, progress),
    }?;
    if let Some(decimation) = options.decimation {
        derived.decimate(decimation, stages, progress)?;
    }
    Ok(derived)
}

impl Ground<'_> {
    /// A length that nobody gave, as this share of what is drawn.
    fn spacing(&self, share: f64) -> f64 {
        // However small that is in the box, there are not to be too many triangles.
        share * self.span.max(self.frame.bounds.size().max_element() / MOST_SPANS)
    }

    /// The sections that cells lie between.
    fn bordered<'b>(&self, sections: &'b [Section], border: Label) -> Result<Cow<'b, [Section]>> {
        match self.is_given {
            true => Ok(Cow::from(sections)),
            false => bordered(sections, self.frame.bounds, border),
        }
    }

    /// Solves for the variational field on the grid.
    fn solve(
        &self,
        method: &Variational,
        Lasting { fields, solver, .. }: &mut Lasting,
        stages: &mut Stages,
        progress: &dyn Progress,
    ) -> Result<Derived> {
        let Self { sections, frame, keeps, .. } = self;
        let capping = Capping::new(sections, method.caps, method.border, frame.lattice.voxel)?;
        let (mut samples, device) = stages.run("field", |counts| {
            let solved =
                variational(&capping.sections, frame, method, (*keeps, fields), solver, progress)?;
            counts.insert("leaves".into(), solved.samples.valued.len() as u64);
            counts.insert("unknowns".into(), solved.effort.unknowns);
            counts.insert("updates".into(), solved.effort.updates);
            counts.insert("specks".into(), solved.specks);
            Ok((solved.samples, solved.device))
        })?;
        self.cut(&mut samples, &capping, stages, progress)?;
        let (mesh, blocks) = self.mesh(&samples, &method.mesher, stages, progress)?;
        Ok(Derived {
            complex: None,
            samples,
            mesh,
            device,
            exact: None,
            links: None,
            decimation: None,
            blocks,
        })
    }

    /// Evaluates the mean-value field in the cells between the sections.
    fn evaluate(
        &self,
        method: &MeanValue,
        lasting: &mut Lasting,
        stages: &mut Stages,
        progress: &dyn Progress,
    ) -> Result<Derived> {
        let Self { sections, frame, .. } = self;
        let Frame { bounds, lattice, .. } = frame;
        let capping = Capping::new(sections, method.caps, method.border, lattice.voxel)?;
        let sections = capping.sections.as_ref();
        let living = stages.run("arrangement", |counts| {
            progress.go_on()?;
            progress.begin("arrangement", 0);
            let all = self.bordered(sections, method.border)?;
            let (living, touched) =
                living::follow(&mut lasting.cells, &all, (*bounds, method.border), lattice)?;
            count(living.complex(), counts);
            counts.insert("touched".into(), touched as u64);
            Ok(living)
        })?;
        let complex = living.complex();
        let boundaries = stages.run("completion", |counts| {
            progress.go_on()?;
            progress.begin("completion", 0);
            let clearance = CLEARANCE * lattice.voxel;
            let before = Some(living.completion());
            let spacing = method.spacing.unwrap_or_else(|| self.spacing(field::SPACING));
            let boundaries = Boundaries::following(complex, clearance, Some(spacing), before)?;
            let completion = boundaries.completion();
            counts
                .insert("triangles of unknown regions".into(), completion.triangle_count() as u64);
            counts.insert("corners".into(), completion.corner_count() as u64);
            counts.insert("sweeps".into(), completion.sweeps().into());
            Ok(boundaries)
        })?;
        let shares = boundaries.shares();
        let changed = living.changed(&shares);
        let (kept, device) = stages.run("field", |counts| {
            let field = lasting.evaluator.field(&boundaries, method.device)?;
            let starts = Starts::new(sections, boundaries.completion(), lattice);
            let field_of = field.as_ref();
            let sampling = match living.before(lattice, &changed) {
                Some(before) => {
                    sample_again(complex, field_of, &starts, before, Margin(1), progress)
                }
                None => sample(complex, field_of, &starts, lattice, Margin(1), progress),
            }?;
            counts.insert("leaves".into(), sampling.kept.samples.valued.len() as u64);
            counts.insert("evaluations".into(), sampling.points);
            Ok((sampling.kept, field.name()))
        })?;
        let (complex, completion) = (complex.clone(), boundaries.into_completion());
        let mut samples = stages.run("smoothing", |counts| {
            let smoothing = (self.keeps, &mut lasting.smoothing);
            let solved =
                smoothed(&kept.samples, sections, frame, method.smooth, smoothing, progress)?;
            counts.insert("unknowns".into(), solved.effort.unknowns);
            counts.insert("updates".into(), solved.effort.updates);
            counts.insert("specks".into(), solved.specks);
            Ok(solved.samples)
        })?;
        living.keep(kept, completion, shares, &changed);
        self.cut(&mut samples, &capping, stages, progress)?;
        let (mesh, blocks) = self.mesh(&samples, &method.mesher, stages, progress)?;
        Ok(Derived {
            complex: Some(complex),
            samples,
            mesh,
            device,
            exact: None,
            links: None,
            decimation: None,
            blocks,
        })
    }

    /// Interpolates distances and their gradients in the cells between the sections.
    fn blend(
        &self,
        method: &Hermite,
        evaluator: &mut Evaluator,
        stages: &mut Stages,
        progress: &dyn Progress,
    ) -> Result<Derived> {
        let Self { sections, frame, .. } = self;
        let Frame { bounds, lattice, .. } = frame;
        let capping = Capping::new(sections, method.caps, method.border, lattice.voxel)?;
        let sections = capping.sections.as_ref();
        progress.go_on()?;
        let all = self.bordered(sections, method.border)?;
        let complex = arranged(&all, *bounds, method.border, stages, progress)?;
        // A region counts by the size of its triangles: between large ones contours would be lost.
        let spacing = |share| {
            let own = self.spacing(share);
            method.interpolation.spacing.map_or(own, |given| if given > own { own } else { given })
        };
        let interpolation =
            hermite::Options { spacing: Some(spacing(hermite::SPACING)), ..method.interpolation };
        let boundaries = stages.run("completion", |counts| {
            progress.go_on()?;
            progress.begin("completion", 0);
            let spacing = Some(spacing(field::SPACING));
            let boundaries = Boundaries::new(&complex, CLEARANCE * lattice.voxel, spacing)?;
            let triangles = boundaries.completion().triangle_count();
            counts.insert("triangles of unknown regions".into(), triangles as u64);
            Ok(boundaries)
        })?;
        let nodes = stages.run("triangulation", |counts| {
            progress.go_on()?;
            progress.begin("triangulation", 0);
            let nodes = hermite::Nodes::new(&boundaries, sections, &interpolation, progress)?;
            counts.insert("triangles".into(), nodes.triangle_count() as u64);
            Ok(nodes)
        })?;
        let (mut samples, device) = stages.run("field", |counts| {
            let (device, voxel) = (method.device, lattice.voxel);
            let field = evaluator.hermite(&boundaries, &nodes, &interpolation, voxel, device)?;
            let starts = Starts::new(sections, boundaries.completion(), lattice);
            let sampling = sample(&complex, field.as_ref(), &starts, lattice, Margin(1), progress)?;
            let mut samples = sampling.kept.samples;
            let specks = remove_specks(&mut samples, sections, *bounds);
            counts.insert("leaves".into(), samples.valued.len() as u64);
            counts.insert("evaluations".into(), sampling.points);
            counts.insert("specks".into(), specks as u64);
            debug_assert_eq!(samples.sanity_check(), Ok(()));
            Ok((samples, field.name()))
        })?;
        self.cut(&mut samples, &capping, stages, progress)?;
        let (mesh, blocks) = self.mesh(&samples, &method.mesher, stages, progress)?;
        Ok(Derived {
            complex: Some(complex),
            samples,
            mesh,
            device,
            exact: None,
            links: None,
            decimation: None,
            blocks,
        })
    }

    /// Interpolates the distances on the sections of a stack.
    fn interpolate(
        &self,
        method: &ShapeBased,
        stages: &mut Stages,
        progress: &dyn Progress,
    ) -> Result<Derived> {
        let Self { sections, frame, .. } = self;
        let capping = Capping::new(sections, method.caps, Label::OUTSIDE, frame.lattice.voxel)?;
        let Stacked { mut samples, links } = stages.run("field", |counts| {
            let made = stacked(&capping.sections, frame, method.link, progress)?;
            counts.insert("leaves".into(), made.samples.valued.len() as u64);
            debug_assert_eq!(made.samples.sanity_check(), Ok(()));
            Ok(made)
        })?;
        self.cut(&mut samples, &capping, stages, progress)?;
        let (mesh, blocks) = self.mesh(&samples, &method.mesher, stages, progress)?;
        let device = format!("cpu (threads: {})", rayon::current_num_threads());
        Ok(Derived {
            complex: None,
            samples,
            mesh,
            device,
            exact: None,
            links: Some(links),
            decimation: None,
            blocks,
        })
    }

    /// Cuts samples off where the solid ends.
    fn cut(
        &self,
        samples: &mut Samples,
        capping: &Capping,
        stages: &mut Stages,
        progress: &dyn Progress,
    ) -> Result<()> {
        if !capping.is_cut() {
            return Ok(());
        }
        stages.run("caps", |counts| {
            progress.go_on()?;
            progress.begin("caps", 0);
            let specks = capping.cut(samples, self.sections, self.frame.bounds);
            counts.insert("leaves".into(), samples.valued.len() as u64);
            counts.insert("specks".into(), specks as u64);
            debug_assert_eq!(samples.sanity_check(), Ok(()));
            Ok(())
        })
    }

    /// Builds the exact surface; the samples only say labels. Where there are too
    /// many partial sections for that, the surface comes from nearest points on the
    /// grid.
    fn build(
        &self,
        method: &Skeleton,
        surfaces: &mut KeptSurfaces,
        stages: &mut Stages,
        progress: &dyn Progress,
    ) -> Result<Derived> {
        let Self { sections, frame: Frame { bounds, lattice, .. }, .. } = self;
        let all = self.bordered(sections, Label::OUTSIDE)?;
        let mut made = stages.run("skeleton", |counts| {
            let mut made = surfaces.follow(&all, *bounds, &method.exactness, progress)?;
            // What stops a stack is nobody's section.
            for section in made.details.origins.iter_mut().flat_map(|origin| &mut origin.sections) {
                *section = section.filter(|&own| (own as usize) < sections.len());
            }
            counts.insert("cells".into(), made.details.cells.into());
            counts.insert("cells computed".into(), surfaces.computed().into());
            counts.insert("vertices".into(), made.mesh.vertices.len() as u64);
            counts.insert("triangles".into(), made.mesh.triangles.len() as u64);
            Ok(made)
        })?;
        let oracle = Oracle::new(&all, *bounds, Label::OUTSIDE)?;
        let is_exact = made.details.left_out.is_empty();
        let samples = stages.run("labels", |counts| {
            progress.go_on()?;
            progress.begin("labels", 0);
            let samples = match is_exact {
                true => oracle.sample_labels(lattice, progress)?,
                false => oracle.sample(lattice, progress)?,
            };
            counts.insert("leaves".into(), samples.valued.len() as u64);
            Ok(samples)
        })?;
        if !is_exact {
            made.mesh = self.mesh(&samples, &Mesher::Dual, stages, progress)?.0;
        } else if let Some(Fairing { edge_length }) = method.fairing {
            let edge_length = edge_length.unwrap_or(FAIR_EDGE * self.span);
            let options = FairingOptions { edge_length, steps: FAIRING_STEPS };
            let planes: Vec<Plane> = sections.iter().map(|section| *section.plane()).collect();
            made.mesh = stages.run("fairing", |counts| {
                let contours = &made.details.contours;
                let made = fair(&made.mesh, contours, &planes, &options, progress)?;
                counts.insert("triangles".into(), made.mesh.triangles.len() as u64);
                counts.insert("patches".into(), made.patches as u64);
                counts.insert("patches left as they were".into(), made.left as u64);
                Ok(made.mesh)
            })?;
        }
        let (device, exact) = ("exact arithmetic".to_owned(), Some(made.details));
        let blocks = KeptBlocks::default();
        Ok(Derived {
            complex: None,
            samples,
            mesh: made.mesh,
            device,
            exact,
            links: None,
            decimation: None,
            blocks,
        })
    }

    /// The surface of samples, and what is kept of it.
    fn mesh(
        &self,
        samples: &Samples,
        mesher: &Mesher,
        stages: &mut Stages,
        progress: &dyn Progress,
    ) -> Result<(Mesh, KeptBlocks)> {
        stages.run("mesh", |counts| {
            progress.go_on()?;
            let (mesh, blocks) = match mesher {
                Mesher::Dual => {
                    let before = self.before.and_then(|before| before.on(samples.lattice));
                    let before = before.as_ref().map(|(samples, blocks)| (&**samples, &**blocks));
                    dual_again(samples, before, progress)?
                }
                Mesher::Delaunay(limits) => {
                    (delaunay(samples, limits, progress)?, KeptBlocks::default())
                }
            };
            counts.insert("vertices".into(), mesh.vertices.len() as u64);
            counts.insert("triangles".into(), mesh.triangles.len() as u64);
            Ok((mesh, if self.keeps { blocks } else { KeptBlocks::default() }))
        })
    }
}

/// The cells between sections, as a stage of its own.
///
/// # Errors
/// CGAL's exceptions, and what its check finds wrong.
pub(crate) fn arranged(
    sections: &[Section],
    bounds: Bounds,
    border: Label,
    stages: &mut Stages,
    progress: &dyn Progress,
) -> Result<Complex> {
    stages.run("arrangement", |counts| {
        progress.begin("arrangement", 0);
        let complex = Complex::new(sections, bounds, border)?;
        count(&complex, counts);
        Ok(complex)
    })
}

fn count(complex: &Complex, counts: &mut BTreeMap<String, u64>) {
    counts.insert("planes".into(), complex.planes().count() as u64);
    counts.insert("facets".into(), complex.facets().count() as u64);
    counts.insert("cells".into(), complex.cells().count() as u64);
}
