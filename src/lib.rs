//! transect reconstructs volumes and surfaces from labelled planar
//! cross-sections of any orientation.

pub mod arrangement;
pub mod check;
pub mod compare;
pub mod error;
pub mod ffi;
pub mod field;
pub mod grid;
pub mod inspect;
pub mod io;
pub mod label;
pub mod mesh;
pub mod picture;
pub mod plane;
pub mod progress;
pub mod section;
pub mod slice;
