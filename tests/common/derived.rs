//! Models of sections by a method, sound and checked.

use transect::change::Change;
use transect::check::Check;
use transect::context::Context;
use transect::grid::lattice::Resolution;
use transect::method::Method;
use transect::model::{Model, Options};
use transect::section::{Rules, Section, Sections};

/// The model of sections on a grid of so many voxels.
pub fn model(sections: Vec<Section>, voxels: u32, method: Method) -> transect::Result<Model> {
    let resolution = Resolution::Voxels(voxels);
    let mut model = Model::new(Options { method, resolution, ..Options::default() });
    let sections = Sections::new(sections, &Rules::default())?;
    model.apply(Change::Add(sections), &mut Context::default())?;
    let samples = &model.derived().expect("something was derived").samples;
    samples.sanity_check().expect("sound samples");
    Ok(model)
}

/// What is found about a model whose surface is sound.
pub fn checked(model: &Model) -> Check {
    let found = model.check(&mut Context::default()).expect("it can be checked");
    assert!(found.is_sound());
    found
}
