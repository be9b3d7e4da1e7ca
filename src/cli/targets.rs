//! The files that a reconstruction is written to: one for each `--output`, or
//! one for each material where its name has a place for the material's.

use std::path::{Path, PathBuf};

use crate::error::{Error, Result};
use crate::io::mesh::MeshKind;
use crate::io::volume::write::VolumeKind;
use crate::label::{Label, Material};

/// In the name of an output, what stands for the label's number.
const LABEL: &str = "{label}";
/// And what stands for the material's name.
const NAME: &str = "{name}";

/// The kinds of files that a reconstruction is written to.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Kind {
    Vdb,
    Volume(VolumeKind),
    Mesh(MeshKind),
    Picture,
}

impl Kind {
    fn of(path: &Path) -> Result<Self> {
        let ending = path.extension().unwrap_or_default().to_string_lossy().to_lowercase();
        match (ending.as_str(), MeshKind::of(path)) {
            ("vdb", _) => Ok(Self::Vdb),
            ("png", _) => Ok(Self::Picture),
            (_, Some(kind)) => Ok(Self::Mesh(kind)),
            _ => VolumeKind::of(path).map(Self::Volume).ok_or_else(|| Error::file(
                path,
                "this kind of file is not known: the name of an output ends in .vdb, .ply, .vtp, \
                 .vtu, .obj, .stl, .off, .nrrd, .seg.nrrd, .nii, .nii.gz, .mha, .vti or .png",
            )),
        }
    }

    /// The stage that writes it.
    pub fn stage(self) -> &'static str {
        match self {
            Self::Vdb | Self::Volume(_) => "volumes",
            Self::Mesh(_) => "surfaces",
            Self::Picture => "picture",
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
    fn names_that_clash_and_kinds_without_labels_are_refused() {
        let materials = [material(1, "a b"), material(2, "a/b")];
        let clash = names("{name}.ply", &materials).unwrap_err().to_string();
        assert!(clash.contains("labels 1 and 2") && clash.contains("a_b.ply"), "{clash}");
        assert!(names("{name}.vdb", &materials).is_err());
        assert!(names("{label}.xyz", &materials).is_err());
    }
}
