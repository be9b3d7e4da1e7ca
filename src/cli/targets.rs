//! The files that a reconstruction is written to: one for each `--output`, or
//! one for each material where its name has a place for the material's.

use std::path::{Path, PathBuf};

use super::args::{VolumeArguments, VoxelsName};
use crate::error::{Error, Result};
use crate::io::mesh::MeshKind;
use crate::io::usd;
use crate::io::vdb::has_nano;
use crate::io::volume::write::VolumeKind;
use crate::label::{Label, Material};
use crate::output::Outputs;

/// In the name of an output, what stands for the label's number.
const LABEL: &str = "{label}";
/// And what stands for the material's name.
const NAME: &str = "{name}";

/// The kinds of files that a reconstruction is written to.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Kind {
    Vdb,
    /// For graphics cards.
    Nvdb,
    /// A scene of volumes, which are in a `.vdb` beside it.
    Usd,
    Volume(VolumeKind),
    /// A structure set (DICOM RTSTRUCT).
    Structures,
    Mesh(MeshKind),
    Picture,
    /// A report that people read.
    Page,
}

impl Kind {
    fn of(path: &Path) -> Result<Self> {
        let ending = path.extension().unwrap_or_default().to_string_lossy().to_lowercase();
        match (ending.as_str(), MeshKind::of(path)) {
            ("vdb", _) => Ok(Self::Vdb),
            ("nvdb", _) if !has_nano() => Err(Error::file(
                path,
                "this transect was built where NanoVDB was not: install it (Debian: \
                 libnanovdb-dev) and build again, or write .vdb",
            )),
            ("nvdb", _) => Ok(Self::Nvdb),
            ("usda", _) => Ok(Self::Usd),
            ("png", _) => Ok(Self::Picture),
            ("html" | "htm", _) => Ok(Self::Page),
            ("dcm", _) => Ok(Self::Structures),
            (_, Some(kind)) => Ok(Self::Mesh(kind)),
            _ => VolumeKind::of(path).map(Self::Volume).ok_or_else(|| Error::file(
                path,
                "this kind of file is not known: the name of an output ends in .vdb, .nvdb, .usda, \
                 .ply, .vtp, .vtu, .vtm, .glb, .3mf, .obj, .stl, .off, .nrrd, .seg.nrrd, .nii, .nii.gz, \
                 .mha, .vti, .dcm, .png or .html",
            )),
        }
    }

    /// Whether it has grids that have names.
    pub fn has_grids(self) -> bool {
        matches!(self, Self::Vdb | Self::Nvdb | Self::Usd)
    }

    /// Whether it matters there which way is up.
    pub fn knows_up(self) -> bool {
        self.has_pictures() || matches!(self, Self::Usd | Self::Mesh(MeshKind::Glb))
    }

    /// Whether it shows the surface from somewhere.
    pub fn has_pictures(self) -> bool {
        matches!(self, Self::Picture | Self::Page)
    }

    /// The stage that writes it.
    pub fn stage(self) -> &'static str {
        match self {
            Self::Vdb | Self::Nvdb | Self::Usd | Self::Volume(_) => "volumes",
            Self::Structures => "contours",
            Self::Mesh(_) => "surfaces",
            Self::Picture => "picture",
            Self::Page => "page",
        }
    }
}

/// One `--output`.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Target {
    /// As the user named it.
    path: PathBuf,
    pub kind: Kind,
}

/// Where a report goes: the names of those for programs, and pages for people.
pub fn report_targets(report: Option<&Path>) -> Result<(Option<&Path>, Option<Target>)> {
    match report {
        Some(path) if Kind::of(path) == Ok(Kind::Page) => Ok((None, Some(Target::new(path)?))),
        _ => Ok((report, None)),
    }
}

impl Target {
    /// Refuses names of no known kind.
    pub fn new(path: &Path) -> Result<Self> {
        let target = Self { path: path.to_owned(), kind: Kind::of(path)? };
        if target.is_pattern() && !matches!(target.kind, Kind::Mesh(_) | Kind::Volume(_)) {
            let what = format!(
                "only surfaces and volumes of labels are written by label: leave {LABEL} and {NAME} \
                 out"
            );
            return Err(Error::file(path, what));
        }
        Ok(target)
    }

    /// All of them, without volumes that a scene among them has beside it already.
    ///
    /// # Errors
    /// A name of no known kind, or of one that has no room for what volumes are to hold.
    pub fn all(paths: &[PathBuf], volumes: &VolumeArguments) -> Result<Vec<Self>> {
        let mut all = paths.iter().map(|path| Self::new(path)).collect::<Result<Vec<_>>>()?;
        let scenes = all.iter().filter(|target| target.kind == Kind::Usd);
        let beside: Vec<PathBuf> = scenes.map(|target| usd::volumes(&target.path)).collect();
        all.retain(|target| target.kind != Kind::Vdb || !beside.contains(&target.path));
        let has_none = |target: &&Self| {
            volumes.voxels == VoxelsName::Distances
                && matches!(target.kind, Kind::Volume(kind) if !kind.has_distances())
        };
        if let Some(target) = all.iter().find(has_none) {
            let what = "a segmentation has labels, no distances: write .nrrd, .nii.gz, .mha or \
                        .vti, or leave --voxels distances out";
            return Err(Error::file(&target.path, what));
        }
        Ok(all)
    }

    /// Refuses a file that has room for one label a voxel where layers may overlap.
    pub fn require_layers(&self, layers: usize) -> Result<()> {
        match self.kind {
            Kind::Volume(kind) if layers > 1 && !kind.has_layers() && !self.is_pattern() => {
                let what = format!(
                    "it has room for one label a voxel, and here are {layers} structures that may \
                     overlap: write .seg.nrrd, a file for each (with {LABEL} or {NAME} in its name), \
                     or let them exclude each other with --partition"
                );
                Err(Error::file(&self.path, what))
            }
            _ => Ok(()),
        }
    }

    /// Whether it stands for one file a material.
    pub fn is_pattern(&self) -> bool {
        self.path.to_str().is_some_and(|path| path.contains(LABEL) || path.contains(NAME))
    }

    /// Reserves the files whose names are known before anything is read.
    pub fn reserve_known(&self, outputs: &mut Outputs) -> Result<()> {
        if self.is_pattern() {
            return Ok(());
        }
        outputs.add(&self.path)?;
        self.beside(&self.path, &[]).iter().try_for_each(|path| outputs.add(path))
    }

    /// Reserves the others: those that are called after materials.
    pub fn reserve_named(&self, outputs: &mut Outputs, materials: &[Material]) -> Result<()> {
        if !self.is_pattern() {
            let known = self.beside(&self.path, &[]);
            let all = self.beside(&self.path, materials);
            let mut named = all.iter().filter(|path| !known.contains(path));
            return named.try_for_each(|path| outputs.add_with_folder(path));
        }
        for (path, label) in self.files(materials)? {
            outputs.add(&path)?;
            let own = materials.iter().find(|material| Some(Label(material.id)) == label);
            let beside = self.beside(&path, own.map(std::slice::from_ref).unwrap_or_default());
            beside.iter().try_for_each(|path| outputs.add_with_folder(path))?;
        }
        Ok(())
    }

    fn beside(&self, path: &Path, materials: &[Material]) -> Vec<PathBuf> {
        match self.kind {
            Kind::Mesh(kind) => {
                kind.beside(path, materials).into_iter().map(|(path, _)| path).collect()
            }
            Kind::Usd => vec![usd::volumes(path)],
            _ => Vec::new(),
        }
    }

    /// What is doubtful about writing these materials to it.
    pub fn doubt(&self, materials: &[Material]) -> Option<String> {
        let Kind::Mesh(kind) = self.kind else { return None };
        if kind.knows_labels() || self.is_pattern() || materials.len() < 2 {
            return None;
        }
        let [stem, ending] = [self.path.file_stem(), self.path.extension()]
            .map(|part| part.unwrap_or_default().to_string_lossy().into_owned());
        let pattern = self.path.with_file_name(format!("{stem}_{LABEL}.{ending}"));
        Some(format!(
            "{}: its {} labels cannot be told apart in this kind of file, and walls between them \
             are in it once: for a closed surface of each, name it {}",
            self.path.display(),
            materials.len(),
            pattern.display()
        ))
    }

    /// Its files: one, or one for each material.
    pub fn files(&self, materials: &[Material]) -> Result<Vec<(PathBuf, Option<Label>)>> {
        let pattern = match self.path.to_str() {
            Some(pattern) if self.is_pattern() => pattern,
            _ => return Ok(vec![(self.path.clone(), None)]),
        };
        let mut files: Vec<(PathBuf, Option<Label>)> = Vec::with_capacity(materials.len());
        for material in materials {
            let path = pattern.replace(LABEL, &material.id.to_string());
            let path = PathBuf::from(path.replace(NAME, &material.word()));
            if let Some((_, Some(other))) = files.iter().find(|(known, _)| *known == path) {
                let what = format!(
                    "labels {other} and {} would both be written to it: name the files by {LABEL}",
                    material.id
                );
                return Err(Error::file(&path, what));
            }
            files.push((path, Some(Label(material.id))));
        }
        Ok(files)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn material(id: u32, name: &str) -> Material {
        Material { id, name: name.to_owned(), color: [0; 3] }
    }

    fn names(path: &str, materials: &[Material]) -> Result<Vec<String>> {
        let files = Target::new(Path::new(path))?.files(materials)?;
        Ok(files.into_iter().map(|(path, _)| path.to_string_lossy().into_owned()).collect())
    }

    #[test]
    fn a_pattern_is_a_file_for_each_material() {
        let materials = [material(2, "left lung"), material(30, "a/b: {label}")];
        let both = names("x/{label}_{name}.stl", &materials);
        assert_eq!(both, Ok(vec!["x/2_left_lung.stl".into(), "x/30_a_b___label_.stl".into()]));
        assert_eq!(names("all.stl", &materials), Ok(vec!["all.stl".into()]));
    }

    #[test]
    fn several_labels_in_a_kind_that_knows_none_are_doubtful() {
        let materials = [material(1, "a"), material(2, "b")];
        let doubt = |path: &str, materials: &[Material]| {
            Target::new(Path::new(path)).expect("a kind").doubt(materials)
        };
        for ending in ["stl", "OFF"] {
            let what = doubt(&format!("x/a.b.{ending}"), &materials).expect("a doubt");
            assert!(what.contains(&format!("name it x/a.b_{{label}}.{ending}")), "{what}");
        }
        assert_eq!(doubt("a.stl", &materials[..1]), None);
        assert_eq!(doubt("a_{name}.stl", &materials), None);
        for ending in ["ply", "obj", "glb", "3mf", "vtm", "vtp", "vtu", "vdb", "png"] {
            assert_eq!(doubt(&format!("a.{ending}"), &materials), None);
        }
    }

    #[test]
    fn names_that_clash_and_kinds_without_labels_are_refused() {
        let materials = [material(1, "a b"), material(2, "a/b")];
        let clash = names("{name}.ply", &materials).unwrap_err().to_string();
        assert!(clash.contains("labels 1 and 2") && clash.contains("a_b.ply"), "{clash}");
        assert!(names("{name}.vdb", &materials).is_err());
        assert!(names("{label}.xyz", &materials).is_err());
    }
}
