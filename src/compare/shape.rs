//! Solids as files hold them: triangles or voxels, with their labels.

use glam::DVec3;

use crate::io::units;
use crate::io::volume::write::turn;
use crate::label::{Label, Material};
use crate::mesh::Mesh;
use crate::volume::LayeredVolume;

/// Solids with labels.
#[derive(Debug, Clone)]
pub struct Shape {
    /// Where they are.
    pub content: Content,
    /// Names, as far as they are known.
    pub materials: Vec<Material>,
    /// The unit of length; empty when unknown.
    pub units: String,
    /// The frame of the coordinates; empty when unknown.
    pub frame: String,
}

/// What solids are made of.
#[derive(Debug, Clone)]
pub enum Content {
    /// Triangles between labels.
    Mesh(Mesh),
    /// Voxels with labels: every one is a box, all of it within.
    Voxels(LayeredVolume),
}

impl From<Mesh> for Shape {
    fn from(mesh: Mesh) -> Self {
        let (content, materials) = (Content::Mesh(mesh), Vec::new());
        Self { content, materials, units: String::new(), frame: String::new() }
    }
}

impl Shape {
    /// The materials that occur, sorted.
    pub fn labels(&self) -> Vec<Label> {
        match &self.content {
            Content::Mesh(mesh) => mesh.labels(),
            Content::Voxels(volume) => {
                let mut labels: Vec<Label> =
                    volume.layers().iter().flat_map(|layer| layer.labels()).collect();
                labels.sort_unstable();
                labels.dedup();
                labels
            }
        }
    }

    /// What a label is called, if its name says more than its number.
    pub fn name(&self, label: Label) -> Option<&str> {
        let own = self.materials.iter().find(|material| material.id == label.0)?;
        let says_more = own.name != Material::numbered(label).name && !own.name.trim().is_empty();
        says_more.then_some(own.name.as_str())
    }

    /// The same in the unit and frame of another one, as far as both are known; what cannot be
    /// turned into each other is told.
    #[must_use]
    pub fn like(mut self, other: &Self, warnings: &mut Vec<String>) -> Self {
        let mut factors = DVec3::ONE;
        let both_say = |own: &str, other: &str| !own.is_empty() && !other.is_empty();
        if both_say(&self.units, &other.units) && self.units != other.units {
            match (units::known(&self.units), units::known(&other.units)) {
                (Some((_, own)), Some((_, wanted))) => factors *= own / wanted,
                _ => warnings.push(differ("unit", "lengths", &self.units, &other.units)),
            }
        }
        if both_say(&self.frame, &other.frame) && self.frame != other.frame {
            match turn(&self.frame, &other.frame) {
                Some(turn) => factors *= turn,
                None => warnings.push(differ("frame", "coordinates", &self.frame, &other.frame)),
            }
        }
        if !other.units.is_empty() {
            self.units.clone_from(&other.units);
        }
        if factors != DVec3::ONE {
            self.content = self.content.scaled(factors);
        }
        self
    }
}

fn differ(what: &str, of: &str, own: &str, other: &str) -> String {
    format!(
        "the {what} of the one is {own:?}, that of the reference {other:?}: {of} are compared as \
         they are"
    )
}

impl Content {
    /// The same with coordinates multiplied by factors.
    fn scaled(self, factors: DVec3) -> Self {
        match self {
            Self::Voxels(volume) => Self::Voxels(volume.scaled(factors)),
            Self::Mesh(mut mesh) => {
                mesh.vertices.iter_mut().for_each(|vertex| *vertex *= factors);
                // Mirrored, triangles show their other side.
                if factors.element_product() < 0.0 {
                    mesh.triangles.iter_mut().for_each(|triangle| triangle.swap(1, 2));
                }
                Self::Mesh(mesh)
            }
        }
    }
}
