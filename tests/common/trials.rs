//! Trials: a solid is cut, reconstructed from its sections, and compared with
//! what it is.

use transect::change::Change;
use transect::compare::normals::{Leaning, NormalOptions, leaning};
use transect::compare::{self, Comparison, compare};
use transect::context::Context;
use transect::error::{Error, Result};
use transect::grid::lattice::Resolution;
use transect::label::Label;
use transect::mesh::Mesh;
use transect::mesh::facts::Facts;
use transect::method::{Hermite, MeanValue, Method, Skeleton};
use transect::model::{Model, Options};
use transect::plane::{Bounds, Plane};
use transect::progress::Silent;
use transect::section::Sections;
use transect::slice::{Family, slice};

/// How near a section normals are compared, as a part of the longest side: two
/// voxels at resolution 256, whatever the resolution is, and an eighth of what
/// fifteen parallel planes are apart.
const REACH: f64 = 1.0 / 128.0;

/// All methods that are tried.
pub fn methods() -> Vec<(&'static str, Method)> {
    vec![
        ("variational", Method::default()),
        ("mean-value", Method::MeanValue(MeanValue::default())),
        ("hermite", Method::Hermite(Hermite::default())),
        ("skeleton", Method::Skeleton(Skeleton::default())),
    ]
}

/// A set of planes through a solid.
#[derive(Debug, Clone)]
pub struct Cut {
    /// What it is called.
    pub name: String,
    families: Vec<Family>,
}

impl Cut {
    /// Fifteen planes across the longest side.
    pub fn parallel(bounds: &Bounds) -> Self {
        let size = bounds.size();
        let longest = |&axis: &usize| size[axis] == size.max_element();
        let axis = (0..3).find(longest).unwrap_or(2);
        Self { name: "parallel".into(), families: vec![Family::Axis { axis, count: 15 }] }
    }

    /// Five planes across every axis.
    pub fn axes() -> Self {
        let families = (0..3).map(|axis| Family::Axis { axis, count: 5 }).collect();
        Self { name: "axes".into(), families }
    }

    /// Twenty planes of random orientation.
    pub fn random(seed: u64) -> Self {
        let families = vec![Family::Random { count: 20, seed }];
        Self { name: format!("random {seed}"), families }
    }

    /// The planes within these bounds.
    ///
    /// # Errors
    /// None of these families has any.
    pub fn planes(&self, bounds: &Bounds) -> Result<Vec<Plane>> {
        let planes: Result<Vec<_>> =
            self.families.iter().map(|family| family.planes(bounds)).collect();
        Ok(planes?.concat())
    }
}

/// What became of a solid.
#[derive(Debug, Clone)]
pub struct Trial {
    /// Volumes and distances.
    pub comparison: Comparison,
    /// Topology.
    pub facts: Facts,
    /// Normals near the planes; none where no plane meets the solid.
    pub leaning: Option<Leaning>,
    /// What the reconstruction took.
    pub seconds: f64,
}

/// Cuts a solid by planes and reconstructs it with so many voxels on the longest
/// side.
///
/// # Errors
/// When a step fails, or the planes miss the solid.
pub fn trial(solid: &Mesh, planes: &[Plane], method: Method, voxels: u32) -> Result<Trial> {
    let mut context = Context::default();
    let sections = Sections::new(slice(solid, planes)?, &context.rules)?;
    let resolution = Resolution::Voxels(voxels);
    let mut model = Model::new(Options { method, resolution, ..Options::default() });
    model.apply(Change::Add(sections), &mut context)?;
    let derived = model.derived().ok_or_else(|| Error::Option("nothing was derived".into()))?;
    let longest = solid.bounds().map_or(0.0, |bounds| bounds.size().max_element());
    let near = NormalOptions::within(REACH * longest);
    Ok(Trial {
        comparison: compare(&derived.mesh, solid, &compare::Options::default(), &Silent)?,
        facts: derived.mesh.surface_of(Label::is_material).facts(false)?,
        leaning: leaning(&derived.mesh, solid, planes, &near)?,
        seconds: context.stages.seconds(),
    })
}
