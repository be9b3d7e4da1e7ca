//! transect reconstructs volumes and surfaces from labelled planar
//! cross-sections of any orientation.

pub mod arrangement;
pub mod error;
pub mod ffi;
pub mod field;
pub mod grid;
pub mod io;
pub mod label;
pub mod mesh;
pub mod plane;
pub mod progress;
pub mod section;
