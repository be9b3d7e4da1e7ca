//! The Hermite field of Sharma and Agarwal (2016): signed distances on the sections, and their
//! gradients, interpolated in the cells between them.
//!
//! O. Sharma, N. Agarwal, 3D surface reconstruction from unorganized sparse cross sections,
//! 2016.
//!
//! The facets of a cell are cut into triangles (`facet_mesh`). At their corners v_i every
//! label has a value f_i and a gradient ∇f_i (`nodes`), which along contours is the surface's
//! normal (`outline`). With the mean-value coordinates λ_i of x in the cell (Ju et al. 2005)
//! the value in between is (Eq. 3)
//!
//! ```text
//! f(x) = Σ_i g(λ_i) (f_i + ∇f_i · (x − v_i)) / Σ_i g(λ_i),   g(t) = 3 t² − 2 t³,
//! ```
//!
//! and the label with the largest one wins. On a facet only its own triangle counts, so cells
//! agree on the facets between them.
//!
//! For a triangle of area A at the distance γ, with corners p_i relative to x's foot on the
//! plane and edges d_i opposite to them, the weight of corner i is
//!
//! ```text
//! w_i = (x_i X / γ + γ d_i · D) / 4 A,   X = Σ_j r_j x_j,   D = Σ_j r_j d_j,
//! ```
//!
//! where x_j is the cross product of edge j's ends and r_j = θ / c as it is for the mean-value
//! indicator. That is Ju's m · n_i / (n_i · (v_i − x)), multiplied out. λ_i = w_i / Σ_j w_j over
//! all triangles.
//!
//! Eq. 3 counts a region by the size of its triangles: where contours are finely cut it counts
//! less. [`Options::density`] divides g(λ_i) by the area around v_i.

mod cpu;
mod facet_mesh;
pub(super) mod gpu;
mod kernel;
mod nodes;
mod outline;
mod packing;
mod reference;

#[cfg(test)]
mod contract;

use crate::error::{Error, Remedy, Result};
use crate::plane::Bounds;

pub use cpu::Cpu;
pub use gpu::Gpu;
pub use nodes::Nodes;
pub use reference::Reference;

/// How facets are triangulated when nothing else is said: the edges' length as a part of the
/// box's longest side.
pub(crate) const SPACING: f64 = 1.0 / 32.0;
/// The smallest spacing, likewise.
const FINEST: f64 = 1.0 / 512.0;

/// What is not in the paper, or not said there.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Options {
    /// How finely facets are triangulated: the length of an edge in world units, a 32nd of
    /// the box's longest side when none is given, in a [`Model`](crate::Model) of what is drawn;
    /// and there no longer ones.
    pub spacing: Option<f64>,
    /// What gradients are away from contours.
    pub gradients: Gradients,
    /// Whether corners count by the area around them.
    pub density: bool,
}

/// What gradients are away from contours; on contours, the surface's normals.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub enum Gradients {
    /// None anywhere: values alone are interpolated.
    None,
    /// Those of the distance to the nearest contour.
    Distance,
    /// The normal of the nearest contour within its section's plane, as if every surface stood at
    /// a right angle to it; on contours, too.
    InPlane,
    /// The surface's normal at the nearest place on a contour.
    #[default]
    Normals,
}

impl Options {
    /// The spacing in a box.
    fn spacing(&self, bounds: Bounds) -> f64 {
        self.spacing.unwrap_or(SPACING * bounds.size().max_element())
    }

    /// # Errors
    /// For a spacing that is not positive, or below a 512th of the box's longest side.
    fn check(&self, bounds: Bounds) -> Result<()> {
        let (spacing, finest) = (self.spacing(bounds), FINEST * bounds.size().max_element());
        if spacing.is_finite() && spacing >= finest {
            return Ok(());
        }
        let what =
            format!("a spacing of {spacing} is too small for this box: the least is {finest}");
        Err(Error::Option(what).avoidable(Remedy::LargerSpacing))
    }
}
