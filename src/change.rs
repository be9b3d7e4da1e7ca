//! An edit of a model, as one value.

use crate::section::Sections;

/// What [`Model::apply`](crate::model::Model::apply) does.
#[derive(Debug, Clone)]
pub enum Change {
    /// Sections join those that are there; the offline run is one such change.
    Add(Sections),
}
