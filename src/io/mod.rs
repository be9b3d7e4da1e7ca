//! Files.

pub mod vdb;
