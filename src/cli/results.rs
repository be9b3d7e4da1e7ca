//! The results of a model, written to files.

use std::borrow::Cow;
use std::path::Path;

use super::args::PictureArguments;
use super::targets::{Kind, Target};
use crate::error::{Error, Result};
use crate::io::mesh::{About, MeshKind, write_mesh};
use crate::io::vdb::{self, GridName, VdbContents};
use crate::label::{Label, Material};
use crate::mesh::Mesh;
use crate::mesh::caps::CAP_TOLERANCE;
use crate::model::{Derived, Model};
use crate::output::{Outputs, write_error};
use crate::picture::{self, PictureOptions};
use crate::section::Sections;

/// How many materials an error lists.
const LISTED: usize = 20;

/// What there is to write.
pub struct Results<'a> {
    model: &'a Model,
    derived: &'a Derived,
    /// The network as it goes to files: without caps where the box is open.
    surfaces: Cow<'a, Mesh>,
    grids: &'a [GridName],
    picture: PictureOptions,
}

impl<'a> Results<'a> {
    /// What a model has to write.
    ///
    /// # Errors
    /// When it has no sections.
    pub fn new(model: &'a Model, grids: &'a [GridName], picture: PictureOptions) -> Result<Self> {
        let nothing = || Error::Option("there is nothing to write: no section is left".to_owned());
        let derived = model.derived().ok_or_else(nothing)?;
        let tolerance = CAP_TOLERANCE * derived.samples.lattice.voxel;
        let surfaces = match model.open() {
            Some(bounds) => Cow::Owned(derived.mesh.without_caps(bounds, tolerance)),
            None => Cow::Borrowed(&derived.mesh),
        };
        Ok(Self { model, derived, surfaces, grids, picture })
    }

    /// What follows from the sections.
    pub fn derived(&self) -> &'a Derived {
        self.derived
    }

    /// Writes the files of a target, which are reserved.
    ///
    /// # Errors
    /// When a file cannot be made or written.
    pub fn write(&self, outputs: &mut Outputs, target: &Target) -> Result<()> {
        let sections = self.model.sections();
        for (path, label) in target.files(&sections.materials)? {
            match (target.kind, label) {
                (Kind::Mesh(kind), None) => {
                    let about = About::from(sections);
                    write_surface(outputs, &path, kind, &self.surfaces, &about)?;
                }
                (Kind::Mesh(kind), Some(label)) => {
                    let part = self.surfaces.surface(label).into_mesh(label);
                    let own: Vec<Material> =
                        sections.material(label).cloned().into_iter().collect();
                    let about = About { materials: &own, ..About::from(sections) };
                    write_surface(outputs, &path, kind, &part, &about)?;
                }
                (Kind::Vdb, _) => self.write_volumes(outputs, &path)?,
                (Kind::Picture, _) => self.write_picture(outputs, &path)?,
            }
        }
        Ok(())
    }

    fn write_volumes(&self, outputs: &mut Outputs, path: &Path) -> Result<()> {
        let Derived { samples, mesh, .. } = self.derived;
        let Sections { sections, materials, units, frame, .. } = self.model.sections();
        let (lattice, grids) = (&samples.lattice, self.grids);
        let contents =
            VdbContents { lattice, mesh, samples, sections, materials, units, frame, grids };
        outputs.write_at(path, |temporary| vdb::write(temporary, &contents))
    }

    fn write_picture(&self, outputs: &mut Outputs, path: &Path) -> Result<()> {
        let image = picture::render(&self.surfaces, self.model.sections(), &self.picture);
        outputs.write(path, |out| {
            picture::write_png(&image, out).map_err(|error| write_error(path, &error))
        })
    }
}

fn write_surface(
    outputs: &mut Outputs,
    path: &Path,
    kind: MeshKind,
    mesh: &Mesh,
    about: &About,
) -> Result<()> {
    outputs.write(path, |out| {
        write_mesh(kind, mesh, about, out).map_err(|error| write_error(path, &error))
    })
}

/// How pictures are drawn, of these materials.
///
/// # Errors
/// When there is no material of a name.
pub fn picture_options(
    arguments: &PictureArguments,
    materials: &[Material],
) -> Result<PictureOptions> {
    let default = PictureOptions::default();
    let labels = arguments.labels.iter().map(|word| drawn(word, materials));
    let labels = labels.collect::<Result<Vec<_>>>()?;
    Ok(PictureOptions {
        size: arguments.size.unwrap_or(default.size),
        view: arguments.view.clone(),
        up: arguments.up,
        labels: (!labels.is_empty()).then_some(labels),
        ..default
    })
}

/// The material of a number or a name.
fn drawn(word: &str, materials: &[Material]) -> Result<Label> {
    let word = word.trim();
    let by_number = || materials.iter().find(|material| Ok(material.id) == word.parse());
    let by_name = || materials.iter().find(|material| material.name == word);
    by_number().or_else(by_name).map(|material| Label(material.id)).ok_or_else(|| {
        let known = materials.iter().take(LISTED);
        let known: Vec<String> =
            known.map(|material| format!("{} ({})", material.id, material.name)).collect();
        let more = materials.len().saturating_sub(LISTED);
        let more = if more > 0 { format!(" and {more} more") } else { String::new() };
        let known = known.join(", ");
        Error::Option(format!("--labels: there is no material {word:?}, but {known}{more}"))
    })
}
