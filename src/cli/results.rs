//! The results of a model, written to files.

use std::borrow::Cow;
use std::path::Path;

use super::args::{PictureArguments, VolumeArguments, VoxelsName};
use super::targets::{Kind, Target};
use crate::check::Check;
use crate::error::{Error, Result};
use crate::io::dicom::{self, Template};
use crate::io::mesh::{About, MeshKind, write_mesh};
use crate::io::usd;
use crate::io::vdb::{self, GridName, Storage, VdbContents, Written};
use crate::io::volume::write::{VolumeKind, Voxels, write_volume};
use crate::label::{Label, Material};
use crate::layers::{
    meshes_side_by_side, own_voxels, planes_of, structure_contours, voxel_distances, voxel_layers,
};
use crate::mesh::Mesh;
use crate::mesh::caps::CAP_TOLERANCE;
use crate::model::{Derived, Model};
use crate::output::{Outputs, write_error};
use crate::page::{Page, Part};
use crate::picture::{self, PictureOptions};
use crate::plane::Plane;
use crate::progress::Progress;
use crate::report::Report;
use crate::section::Sections;

/// How many materials an error lists.
const LISTED: usize = 20;

/// What there is to write.
pub struct Results<'a> {
    /// Of each layer the model and what follows from its sections.
    layers: Vec<(&'a Model, &'a Derived)>,
    /// The sections of all layers.
    sections: Cow<'a, Sections>,
    /// The network as it goes to files, without caps where the box is open; of several layers
    /// side by side.
    surfaces: Cow<'a, Mesh>,
    grids: &'a [GridName],
    /// Whether their floats are of half precision.
    half: bool,
    /// What the voxels of other volumes hold.
    holding: VoxelsName,
    picture: PictureOptions,
    /// Where the voxels of volumes of labels are, if not on the grid's nodes.
    like: Option<Voxels>,
    /// Which planes the contours of structure sets are on, if not those of the sections.
    planes: Option<Vec<Plane>>,
    /// What structure sets take over.
    template: Option<Template>,
}

impl<'a> Results<'a> {
    /// What models have to write: one, or one for each layer.
    ///
    /// # Errors
    /// When one has no sections.
    pub fn new(
        models: impl IntoIterator<Item = &'a Model>,
        grids: &'a [GridName],
        picture: PictureOptions,
    ) -> Result<Self> {
        let nothing = || Error::Option("there is nothing to write: no section is left".to_owned());
        let of = |model: &'a Model| Ok((model, model.derived().ok_or_else(nothing)?));
        let layers = models.into_iter().map(of).collect::<Result<Vec<_>>>()?;
        let (sections, surfaces) = match layers[..] {
            [(model, derived)] => (Cow::Borrowed(model.sections()), surfaces(model, derived)),
            _ => {
                let sections = layers.iter().map(|(model, _)| model.sections());
                let surfaces: Vec<Cow<Mesh>> =
                    layers.iter().map(|&(model, derived)| surfaces(model, derived)).collect();
                let surfaces = meshes_side_by_side(surfaces.iter().map(Cow::as_ref));
                (Cow::Owned(Sections::side_by_side(sections)), Cow::Owned(surfaces))
            }
        };
        Ok(Self {
            layers,
            sections,
            surfaces,
            grids,
            half: false,
            holding: VoxelsName::default(),
            picture,
            like: None,
            planes: None,
            template: None,
        })
    }

    /// The same with volumes as these arguments say.
    pub fn stored(self, arguments: &VolumeArguments) -> Self {
        Self { half: arguments.half, holding: arguments.voxels, ..self }
    }

    /// The same with volumes of labels whose voxels are these.
    pub fn like(self, like: Option<Voxels>) -> Self {
        Self { like, ..self }
    }

    /// The same with structure sets on these planes, which take over what another one says.
    pub fn contoured(self, planes: Option<Vec<Plane>>, template: Option<Template>) -> Self {
        Self { planes, template, ..self }
    }

    /// Writes the files of a target, which are reserved.
    ///
    /// # Errors
    /// When a file cannot be made or written.
    pub fn write(&self, outputs: &mut Outputs, target: &Target) -> Result<()> {
        let sections = self.sections.as_ref();
        for (path, label) in target.files(&sections.materials)? {
            match (target.kind, label) {
                (Kind::Mesh(kind), None) => {
                    let about = self.about();
                    write_surface(outputs, &path, kind, &self.surfaces, &about)?;
                }
                (Kind::Mesh(kind), Some(label)) => {
                    let part = self.surfaces.surface(label).into_mesh(label);
                    let own: Vec<Material> =
                        sections.material(label).cloned().into_iter().collect();
                    let about = About { materials: &own, ..self.about() };
                    write_surface(outputs, &path, kind, &part, &about)?;
                }
                (Kind::Volume(kind), label) => self.write_voxels(outputs, &path, kind, label)?,
                (Kind::Structures, _) => self.write_structures(outputs, &path)?,
                (Kind::Vdb, _) => {
                    self.write_volumes(outputs, &path, Storage::OpenVdb { half: self.half })?;
                }
                (Kind::Nvdb, _) => {
                    self.write_volumes(outputs, &path, Storage::NanoVdb)?;
                }
                (Kind::Usd, _) => self.write_scene(outputs, &path)?,
                (Kind::Picture, _) => self.write_picture(outputs, &path)?,
                // It is written when the report is there.
                (Kind::Page, _) => (),
            }
        }
        Ok(())
    }

    /// What files say about surfaces, with another direction up where one is asked for.
    fn about(&self) -> About<'_> {
        let sections = self.sections.as_ref();
        About { sides: self.picture.sides(sections), ..About::from(sections) }
    }

    /// What pages show besides a report, with what each layer is worth.
    ///
    /// # Errors
    /// When cancelled, and when CGAL fails.
    pub fn page<'b>(
        &self,
        checks: impl IntoIterator<Item = &'b Check>,
        progress: &dyn Progress,
    ) -> Result<Page> {
        let parts = self.layers.iter().zip(checks);
        let parts: Vec<Part> = parts.map(|(&(model, _), check)| Part { model, check }).collect();
        Page::new(&parts, &self.surfaces, &self.sections, &self.picture, progress)
    }

    fn write_volumes(
        &self,
        outputs: &mut Outputs,
        path: &Path,
        storage: Storage,
    ) -> Result<Written> {
        let contents = self.layers.iter().map(|(model, derived)| {
            let Derived { samples, mesh, .. } = derived;
            let Sections { sections, materials, units, frame, .. } = model.sections();
            let (lattice, grids) = (&samples.lattice, self.grids);
            VdbContents { lattice, mesh, samples, sections, materials, units, frame, grids }
        });
        let contents: Vec<VdbContents> = contents.collect();
        outputs.write_at(path, |temporary| vdb::write_layers(temporary, &contents, storage))
    }

    /// Writes a scene and the volumes in it.
    fn write_scene(&self, outputs: &mut Outputs, path: &Path) -> Result<()> {
        let volumes = usd::volumes(path);
        let written =
            self.write_volumes(outputs, &volumes, Storage::OpenVdb { half: self.half })?;
        let about = self.about();
        outputs.write(path, |out| {
            usd::write(&written, &volumes, &about, self.surfaces.bounds(), out)
                .map_err(|error| write_error(path, &error))
        })
    }

    /// Writes the labels of voxels or distances to them, all or one.
    fn write_voxels(
        &self,
        outputs: &mut Outputs,
        path: &Path,
        kind: VolumeKind,
        label: Option<Label>,
    ) -> Result<()> {
        let models: Vec<&Model> = self.layers.iter().map(|layer| layer.0).collect();
        let voxels = match &self.like {
            Some(like) => like.clone(),
            None => own_voxels(&models)?,
        };
        let layers = match self.holding {
            VoxelsName::Labels => voxel_layers(&models, &voxels, label)?,
            VoxelsName::Distances => vec![voxel_distances(&models, &voxels, label)?],
        };
        outputs.write(path, |out| {
            write_volume(kind, &voxels, &layers, out).map_err(|error| write_error(path, &error))
        })
    }

    fn write_structures(&self, outputs: &mut Outputs, path: &Path) -> Result<()> {
        let models: Vec<&Model> = self.layers.iter().map(|layer| layer.0).collect();
        let own;
        let planes = match &self.planes {
            Some(planes) => planes,
            None => {
                own = planes_of(&models);
                &own
            }
        };
        let structures = structure_contours(&models, planes)?;
        outputs.write(path, |out| {
            dicom::write(&structures, self.template.as_ref(), out)
                .map_err(|error| write_error(path, &error))
        })
    }

    fn write_picture(&self, outputs: &mut Outputs, path: &Path) -> Result<()> {
        let image = picture::render(&self.surfaces, &self.sections, &self.picture);
        outputs.write(path, |out| {
            picture::write_png(&image, out).map_err(|error| write_error(path, &error))
        })
    }
}

/// A model's network as it goes to files.
fn surfaces<'a>(model: &'a Model, derived: &'a Derived) -> Cow<'a, Mesh> {
    let tolerance = CAP_TOLERANCE * derived.samples.lattice.voxel;
    match model.open() {
        Some(bounds) => Cow::Owned(derived.mesh.without_caps(bounds, tolerance)),
        None => Cow::Borrowed(&derived.mesh),
    }
}

/// Writes a page to all of the targets that are one.
///
/// # Errors
/// When a file cannot be written.
pub fn write_pages(
    outputs: &mut Outputs,
    targets: &[Target],
    page: &Page,
    report: &Report,
) -> Result<()> {
    let command = std::env::args_os().map(|word| word.to_string_lossy().into_owned());
    let command = command.collect::<Vec<_>>().join(" ");
    for target in targets.iter().filter(|target| target.kind == Kind::Page) {
        for (path, _) in target.files(&[])? {
            outputs.write(&path, |out| {
                page.write(report, &command, out).map_err(|error| write_error(&path, &error))
            })?;
        }
    }
    Ok(())
}

/// Writes a file and those beside it.
fn write_surface(
    outputs: &mut Outputs,
    path: &Path,
    kind: MeshKind,
    mesh: &Mesh,
    about: &About,
) -> Result<()> {
    let stem = path.file_stem().unwrap_or_default().to_string_lossy();
    let about = &About { stem: &stem, ..*about };
    outputs.write(path, |out| {
        write_mesh(kind, mesh, about, out).map_err(|error| write_error(path, &error))
    })?;
    for (path, beside) in kind.beside(path, about.materials) {
        outputs.write(&path, |out| {
            beside.write(mesh, about, out).map_err(|error| write_error(&path, &error))
        })?;
    }
    Ok(())
}

/// Options of pictures without any are a mistake; which way is up counts elsewhere, too.
pub fn require_picture(arguments: &PictureArguments, targets: &[Target]) -> Result<()> {
    let any = |is: fn(Kind) -> bool| targets.iter().any(|target| is(target.kind));
    let what = if arguments.is_of_picture() && !any(Kind::has_pictures) {
        "--view, --size and --labels are for pictures: add -o FILE.png or FILE.html"
    } else if arguments.up.is_some() && !any(Kind::knows_up) {
        "--up is for pictures, .glb and .usda, and none is written: add -o FILE.png or another one"
    } else {
        return Ok(());
    };
    Err(Error::Option(what.to_owned()))
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
