//! The model: sections and everything derived from them.
//!
//! Sections are ground state; complex, samples and mesh follow from them.
//! Only [`Model::take`], and with it [`Model::apply`] and [`Model::undo`], changes a model,
//! all or nothing.

use std::collections::VecDeque;
use std::sync::{Mutex, PoisonError};

use crate::change::{Change, Given, Replaced, SectionId, Step};
use crate::check::{self, Check, check};
use crate::context::Context;
pub use crate::derived::Derived;
use crate::derived::{Lasting, derive};
use crate::error::{Error, Result};
use crate::grid::lattice::Resolution;
use crate::mesh::decimation::Decimation;
use crate::method::{Caps, Mesher, Method};
use crate::plane::Bounds;
use crate::report::Report;
use crate::section::{Section, Sections};
use crate::stage::Stages;

/// How many changes can be taken back, one after the other.
pub const MOST_UNDONE: usize = 64;

/// How a model is derived from its sections.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Options {
    /// How space between the sections is filled.
    pub method: Method,
    /// How fine the grid is.
    pub resolution: Resolution,
    /// The box that is filled; no contour may leave it. Without one it follows from the
    /// sections, anew with every change.
    ///
    /// The mean-value field is evaluated, and the variational field solved for, only where a
    /// change concerns it if the grid's nodes stay where they are: in a given box, and in one
    /// that follows the sections if the size of voxels is given and the box is closed and has 64 of
    /// them.
    pub bounds: Option<Bounds>,
    /// How far the box that follows from the sections reaches beyond their contours, in world
    /// units. Without it: beyond the last section of a stack a spacing, to the sides a twentieth of
    /// the diagonal ([`Sections::space`](crate::section::Sections::space)) or, with a method to
    /// which they are outside, three quarters of the widest gap between sections
    /// ([`Sections::space_of_cells`](crate::section::Sections::space_of_cells)).
    pub margin: Option<f64>,
    /// How far the surface is made simpler, last of all. What is kept for the next change is
    /// from before that.
    pub decimation: Option<Decimation>,
}

impl Default for Options {
    fn default() -> Self {
        let (method, resolution) = (Method::default(), Resolution::Voxels(256));
        Self { method, resolution, bounds: None, margin: None, decimation: None }
    }
}

/// Sections and everything derived from them.
#[derive(Debug)]
pub struct Model {
    options: Options,
    given: Given,
    /// What the last changes replaced, the last one last.
    past: VecDeque<Replaced>,
    /// Those given, of every plane one.
    sections: Sections,
    derived: Option<Derived>,
    /// Behind a lock, though nobody waits for it: threads may share a model but not this.
    lasting: Mutex<Lasting>,
}

impl Model {
    /// A model without sections.
    pub fn new(options: Options) -> Self {
        let (given, past, sections, derived, lasting) = Default::default();
        Self { options, given, past, sections, derived, lasting }
    }

    /// Changes the sections and derives everything anew; the model stays as it
    /// was when that fails. Returns the numbers of the sections that were added, in the order
    /// in which they were given.
    ///
    /// # Errors
    /// When a section is not there, when there is no contour at all, when sections on one
    /// plane contradict each other, when the grid would not fit into memory, or when a stage
    /// fails.
    pub fn apply(&mut self, change: Change, context: &mut Context) -> Result<Vec<SectionId>> {
        let added = self.take(Step::Change(Box::new(change)), context, || Ok(()))?;
        Ok(added.unwrap_or_default())
    }

    /// Takes the last change back that was not taken back yet; whether there was one. The last
    /// [`MOST_UNDONE`] are remembered.
    ///
    /// # Errors
    /// As [`Model::apply`]; then the model stays as it was.
    pub fn undo(&mut self, context: &mut Context) -> Result<bool> {
        Ok(self.take(Step::Undo, context, || Ok(()))?.is_some())
    }

    /// Takes a step, as [`Model::apply`] and [`Model::undo`] do. Once everything is derived,
    /// `keep` may write down that the step is taken; when it cannot, the step is not. Returns
    /// the numbers of the sections that were added; `None` where nothing is left to take back.
    ///
    /// # Errors
    /// As [`Model::apply`], and those of `keep`; then the model stays as it was.
    pub fn take(
        &mut self,
        step: Step,
        context: &mut Context,
        keep: impl FnOnce() -> Result<()>,
    ) -> Result<Option<Vec<SectionId>>> {
        let mut given = self.given.clone();
        match step {
            Step::Change(change) => {
                let (added, replaced) = given.change(*change, &context.rules)?;
                self.become_what_follows(given, context, keep)?;
                self.remember(replaced);
                Ok(Some(added))
            }
            Step::Undo => {
                let Some(replaced) = self.past.back() else { return Ok(None) };
                given.restore(replaced);
                self.become_what_follows(given, context, keep)?;
                self.past.pop_back();
                Ok(Some(Vec::new()))
            }
        }
    }

    /// A model that took all these steps: its sections have the numbers that they had, and
    /// the same changes can be taken back. Everything is derived once, after the last step.
    ///
    /// # Errors
    /// Those of the steps, and as [`Model::apply`].
    pub fn resume(
        options: Options,
        steps: impl IntoIterator<Item = Result<Step>>,
        context: &mut Context,
    ) -> Result<Self> {
        let (mut model, mut given) = (Self::new(options), Given::default());
        for step in steps {
            match step? {
                Step::Change(change) => {
                    model.remember(given.change(*change, &context.rules)?.1);
                }
                Step::Undo => {
                    let nothing = || Error::Option("there is no change to take back".to_owned());
                    given.restore(&model.past.pop_back().ok_or_else(nothing)?);
                }
            }
        }
        model.become_what_follows(given, context, || Ok(()))?;
        Ok(model)
    }

    fn remember(&mut self, replaced: Replaced) {
        if self.past.len() == MOST_UNDONE {
            self.past.pop_front();
        }
        self.past.push_back(replaced);
    }

    /// Derives everything from sections, and if that works and can be kept has them for its
    /// own.
    fn become_what_follows(
        &mut self,
        given: Given,
        context: &mut Context,
        keep: impl FnOnce() -> Result<()>,
    ) -> Result<()> {
        let Context { rules, stages, progress } = context;
        let sections = given.merged(rules)?;
        let lasting = self.lasting.get_mut().unwrap_or_else(PoisonError::into_inner);
        let before = self.derived.as_ref();
        let derive =
            |sections| derive(sections, &self.options, &mut *lasting, before, stages, *progress);
        let derived = sections.as_ref().map(derive).transpose();
        if let Err(Error::Device(_)) = derived {
            lasting.close_devices();
        }
        let derived = derived?;
        keep()?;
        self.derived = derived;
        self.sections = sections.unwrap_or_default();
        self.given = given;
        Ok(())
    }

    /// Lets go of all that is kept for the next change alone.
    pub(crate) fn forget(&mut self) {
        self.lasting = Mutex::default();
    }

    /// The sections as they were given, each by its number.
    pub fn given(&self) -> impl Iterator<Item = (SectionId, &Section)> {
        self.given.iter()
    }

    /// How the model is derived.
    pub fn options(&self) -> &Options {
        &self.options
    }

    /// The sections that everything is derived from: those given, where several lie on one
    /// plane merged.
    pub fn sections(&self) -> &Sections {
        &self.sections
    }

    /// What follows from the sections; `None` without any.
    pub fn derived(&self) -> Option<&Derived> {
        self.derived.as_ref()
    }

    /// The box on whose faces surfaces are open; with flat caps they are closed in them.
    pub fn open(&self) -> Option<Bounds> {
        let derived = self.derived.as_ref().filter(|_| self.options.method.caps() != Caps::Flat);
        derived.and_then(|derived| derived.samples.open)
    }

    /// Measures the surface.
    ///
    /// # Errors
    /// Without sections, when the check fails, and when it finds that a surface is not what it
    /// must be: closed, oriented outward, without doubled edges.
    pub fn check(&self, context: &mut Context) -> Result<Check> {
        let nothing = || Error::Option("there is nothing to check: no section is left".to_owned());
        let Derived { mesh, samples, .. } = self.derived().ok_or_else(nothing)?;
        let Context { stages, progress, .. } = context;
        let checked = stages.run("check", |_| {
            // Cheap where triangles are few, as the delaunay mesher's, and promised.
            let is_dual = matches!(self.options.method.mesher(), Some(Mesher::Dual));
            let self_intersections = !is_dual || self.options.decimation.is_some();
            let options = check::Options { open: self.open(), self_intersections };
            check(&self.sections.sections, mesh, samples, options, *progress)
        })?;
        match checked.fault(mesh) {
            Some(what) => Err(Error::Bug { stage: "check", what }),
            None => Ok(checked),
        }
    }

    /// The report of what was derived and checked; `stages` says what that took. `None` without
    /// sections.
    pub fn report(&self, check: Check, stages: &Stages) -> Option<Report> {
        Some(Report::new(self, self.derived()?, check, stages))
    }
}
