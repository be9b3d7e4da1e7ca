//! Six closed solids, given by formulas: what methods are judged by.
//!
//! ```text
//! pieces (round limbs, boxes, …) ─► vessel, bones, … (formulas) ─► meshing ─► Mesh
//! ```

mod body;
mod bones;
pub mod knot;
mod limbs;
mod meshing;
mod part;
mod pieces;
mod shells;
mod vessel;

use glam::DVec3;

use transect::plane::Bounds;

pub use meshing::mesh;

/// A solid by its formula.
pub struct Solid {
    /// One word.
    pub name: &'static str,
    /// A box around it.
    pub bounds: Bounds,
    /// What is known about it without looking.
    pub truth: Truth,
    distance: Box<dyn Fn(DVec3) -> f64 + Sync>,
}

/// The topology that a formula has, and where it is known the volume.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Truth {
    /// Connected surfaces, those around cavities included.
    pub components: usize,
    /// Closed spaces within the solid.
    pub cavities: usize,
    /// Handles of all surfaces together.
    pub genus: i64,
    /// Cubic units, where a formula gives it.
    pub volume: Option<f64>,
}

impl Solid {
    /// About the distance to the surface, negative inside. It changes by no more
    /// than [`STEEPEST`] times the way that one goes.
    pub fn distance(&self, place: DVec3) -> f64 {
        (self.distance)(place)
    }

    /// What is left of it behind the middle plane across y: nobody sees cavities
    /// from outside.
    pub fn opened(self) -> Self {
        let front = self.bounds.min.midpoint(self.bounds.max).y;
        let Self { distance, .. } = self;
        let distance = Box::new(move |place: DVec3| distance(place).max(front - place.y));
        Self { distance, ..self }
    }
}

/// How fast a solid's distance may change: true distances change by 1, and some
/// of the formulas are not quite distances.
pub const STEEPEST: f64 = 1.25;

/// All of them.
pub fn solids() -> Vec<Solid> {
    vec![
        vessel::vessel(),
        bones::bones(),
        knot::knot(),
        part::part(),
        body::body(),
        shells::shells(),
    ]
}
