//! All methods on the same sections, side by side: what each makes of them, what it takes, and
//! how near it comes to a reference.
//!
//! With a reference the figures are those of Sharma and Agarwal's Table 2 (ratios of volumes and
//! areas, mean distance) and more.

use serde::Serialize;

use super::normals::{NormalErrors, NormalOptions, normal_errors};
use super::{Comparison, compare};
use crate::change::Change;
use crate::check::Check;
use crate::context::Context;
use crate::error::{Error, Result};
use crate::mesh::Mesh;
use crate::method::Method;
use crate::model::{Model, Options};
use crate::plane::Plane;
use crate::progress::Progress;
use crate::section::{Rules, Sections};
use crate::stage::Stages;

/// How near a section is *at* it, as a part of the box's longest side: two voxels of 256.
const REACH: f64 = 1.0 / 128.0;

/// What all methods have in common.
#[derive(Debug)]
pub struct Common<'a> {
    /// What they reconstruct.
    pub sections: &'a Sections,
    /// Resolution and box; the method is that of each in turn.
    pub options: Options,
    /// What is right, if it is known.
    pub reference: Option<&'a Mesh>,
}

/// One method's result.
#[derive(Debug, Clone, Serialize)]
pub struct Entry {
    /// The method.
    pub method: String,
    /// Why it does not apply; then there is nothing else.
    pub refused: Option<String>,
    /// What it made.
    pub figures: Option<Figures>,
}

/// What a method made of sections.
#[derive(Debug, Clone, Serialize)]
pub struct Figures {
    /// Against the reference.
    pub reference: Option<Comparison>,
    /// The same of normals.
    pub normals: Option<NormalErrors>,
    /// The mean over the sections of how well they agree with the surface.
    pub dice: Option<f64>,
    /// The least of that.
    pub least_dice: Option<f64>,
    /// Of all materials, in cubic world units.
    pub volume: f64,
    /// Of all materials' surfaces, in square world units.
    pub area: f64,
    /// Pieces of all materials' surfaces.
    pub components: usize,
    /// Handles of all of them.
    pub genus: i64,
    /// Whether all are closed.
    pub closed: bool,
    /// To the mesh, without checks.
    pub seconds: f64,
    /// The largest resident size of the program meanwhile, in bytes.
    pub peak_memory: u64,
}

impl Common<'_> {
    /// What a method makes of the sections, and its surface, if it applies.
    ///
    /// # Errors
    /// When it is cancelled, or a bug is found.
    pub fn tried(
        &self,
        name: &str,
        method: Method,
        progress: &dyn Progress,
    ) -> Result<(Entry, Option<Mesh>)> {
        let mut model = Model::new(Options { method, ..self.options });
        let mut context = Context::new(Rules::default(), progress);
        let entry = |refused, figures| Entry { method: name.to_owned(), refused, figures };
        match model.apply(Change::Add(self.sections.clone()), &mut context) {
            Ok(_) => {}
            Err(error @ (Error::Cancelled | Error::Bug { .. })) => return Err(error),
            Err(error) => return Ok((entry(Some(error.to_string()), None), None)),
        }
        let stages = context.stages.clone();
        let check = model.check(&mut context)?;
        let Some(derived) = model.derived() else {
            return Ok((entry(Some("nothing was derived".to_owned()), None), None));
        };
        let figures = self.figures(&derived.mesh, &check, &stages, progress)?;
        Ok((entry(None, Some(figures)), Some(derived.mesh.clone())))
    }

    fn figures(
        &self,
        mesh: &Mesh,
        check: &Check,
        stages: &Stages,
        progress: &dyn Progress,
    ) -> Result<Figures> {
        let (mut against, mut normals) = (None, None);
        // Without a surface there is nothing to compare.
        if let Some(reference) = self.reference.filter(|_| !mesh.triangles.is_empty()) {
            let planes: Vec<Plane> =
                self.sections.sections.iter().map(|section| *section.plane()).collect();
            let longest = reference.bounds().map_or(0.0, |bounds| bounds.size().max_element());
            against = Some(compare(mesh, reference, &super::Options::default(), progress)?);
            let near = NormalOptions::within(REACH * longest);
            normals = Some(normal_errors(mesh, reference, &planes, &near)?);
        }
        let facts = || check.labels.iter().map(|label| &label.facts);
        Ok(Figures {
            reference: against,
            normals,
            dice: check.dice.mean,
            least_dice: check.dice.min,
            volume: facts().map(|facts| facts.volume).sum(),
            area: facts().map(|facts| facts.area).sum(),
            components: facts().map(|facts| facts.components).sum(),
            genus: facts().map(|facts| facts.genus).sum(),
            closed: facts().all(|facts| facts.closed),
            seconds: stages.seconds(),
            peak_memory: stages.peak_memory(),
        })
    }
}
