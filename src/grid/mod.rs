//! The grid: the field sampled sparsely, in leaves as OpenVDB has them.
//!
//! ```text
//! frame ─► lattice ─► contour (voxels that contours pass) ─► sampling ─► samples
//!                                                           mesh ─► distance (level sets)
//! ```

pub mod assembly;
pub mod clip;
pub mod contour;
pub mod distance;
pub mod evidence;
pub mod frame;
pub(crate) mod invariant;
pub mod labels;
pub mod lattice;
pub mod leaf;
pub mod leaf_grid;
mod locate;
pub mod memory;
pub(crate) mod runs;
pub mod samples;
pub mod sampling;
pub mod volume;
mod winding;

pub use locate::Cells;
