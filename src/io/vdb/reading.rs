//! What is in an OpenVDB file.

use std::path::{Path, PathBuf};

use cxx::UniquePtr;
use glam::DVec3;

use crate::error::{Error, Result};
use crate::ffi::vdb as ffi;

/// An OpenVDB file, read whole.
pub struct VdbFile {
    file: PathBuf,
    volumes: UniquePtr<ffi::Volumes>,
}

/// A grid of a file.
#[derive(Debug, Clone, PartialEq)]
pub struct GridInfo {
    /// Its name.
    pub name: String,
    /// The type of its values, in OpenVDB's words (`float`, `int32`).
    pub value_type: String,
    /// Its class, in OpenVDB's words (`level set`, `fog volume`, `unknown`).
    pub class: String,
    /// The size of its voxels along the axes, in world units.
    pub voxel: DVec3,
    /// Where its node (0, 0, 0) is, in world units.
    pub origin: DVec3,
    /// How many voxels are active.
    pub active: u64,
    /// Its metadata by key, sorted.
    pub metadata: Vec<(String, String)>,
}

impl VdbFile {
    /// Reads a file.
    ///
    /// # Errors
    /// When it is none.
    pub fn read(path: &Path) -> Result<Self> {
        let name =
            path.to_str().ok_or_else(|| Error::file(path, "its name is not UTF-8; rename it"))?;
        let volumes = ffi::read(name).map_err(|error| Error::file(path, error.what()))?;
        Ok(Self { file: path.to_owned(), volumes })
    }

    /// Its grids by name, sorted, as OpenVDB's readers see them.
    ///
    /// # Errors
    /// When OpenVDB fails.
    pub fn grids(&self) -> Result<Vec<GridInfo>> {
        let found = ffi::describe(&self.volumes).map_err(|error| self.failed(&error))?;
        let info = |grid: ffi::Description| GridInfo {
            name: grid.name,
            value_type: grid.value_type,
            class: grid.class_name,
            voxel: DVec3::from_array(grid.voxel),
            origin: DVec3::from_array(grid.origin),
            active: grid.active,
            metadata: pairs(&grid.metadata),
        };
        Ok(found.into_iter().map(info).collect())
    }

    /// Its own metadata by key, sorted.
    ///
    /// # Errors
    /// When OpenVDB fails.
    pub fn metadata(&self) -> Result<Vec<(String, String)>> {
        let found = ffi::file_metadata(&self.volumes).map_err(|error| self.failed(&error))?;
        Ok(pairs(&found))
    }

    /// The value of a grid at a node.
    ///
    /// # Errors
    /// When there is no such grid, or it does not hold numbers.
    pub fn value(&self, grid: &str, node: [i32; 3]) -> Result<f64> {
        ffi::value(&self.volumes, grid, node).map_err(|error| self.failed(&error))
    }

    /// What OpenVDB finds wrong with a level set; empty when nothing is.
    ///
    /// # Errors
    /// When there is no such grid.
    pub fn check_level_set(&self, grid: &str) -> Result<String> {
        ffi::check_level_set(&self.volumes, grid).map_err(|error| self.failed(&error))
    }

    /// What OpenVDB finds wrong with a fog volume; empty when nothing is.
    ///
    /// # Errors
    /// When there is no such grid.
    pub fn check_fog_volume(&self, grid: &str) -> Result<String> {
        ffi::check_fog_volume(&self.volumes, grid).map_err(|error| self.failed(&error))
    }

    fn failed(&self, exception: &cxx::Exception) -> Error {
        Error::file(&self.file, exception.what())
    }
}

fn pairs(flat: &[String]) -> Vec<(String, String)> {
    flat.chunks_exact(2).map(|pair| (pair[0].clone(), pair[1].clone())).collect()
}
