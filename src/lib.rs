//! transect reconstructs volumes and surfaces from labelled planar
//! cross-sections of any orientation.

pub mod arrangement;
pub mod change;
pub mod check;
pub mod cli;
pub mod compare;
pub mod error;
pub mod ffi;
pub mod field;
pub mod grid;
pub mod inspect;
pub mod io;
pub mod label;
pub mod memory;
pub mod mesh;
pub mod model;
pub mod output;
pub mod picture;
pub mod plane;
pub mod progress;
pub mod report;
pub mod section;
pub mod slice;
pub mod stage;
