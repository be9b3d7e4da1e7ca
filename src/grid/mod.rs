//! The grid: the field sampled sparsely in an OpenVDB tree.

pub mod samples;
