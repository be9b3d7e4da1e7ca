//! The bridges to C++: the only place where `cxx` appears. Flat slices cross
//! them, in few calls; every function that can throw returns a `Result`.

#[cfg_attr(not(test), allow(dead_code, reason = "tests alone ask whether places are right"))]
pub mod complex;
pub mod decimation;
pub mod delaunay;
pub mod fairing;
pub mod measure;
pub mod partition;
pub mod skeleton;
pub mod threads;
pub mod triangulation;
pub mod vdb;
