//! A pipe that goes on beyond its sections, in an open box.

use std::f64::consts::{PI, TAU};

use glam::{DVec2, DVec3};
use transect::change::Change;
use transect::check::{self, check};
use transect::context::Context;
use transect::grid::lattice::Resolution;
use transect::label::Label;
use transect::mesh::caps::CAP_TOLERANCE;
use transect::method::{MeanValue, Method};
use transect::model::{Derived, Model, Options};
use transect::plane::Plane;
use transect::progress::Silent;
use transect::section::{Loop, Rules, Section, Sections};

const RADIUS: f64 = 3.0;
/// Sections at z = 0, 2, …, 10.
const LAST: f64 = 10.0;

fn pipe() -> Sections {
    let rules = Rules::default();
    let section = |layer: u32| {
        let z = 2.0 * f64::from(layer);
        let point = |at: u32| (RADIUS * DVec2::from_angle(TAU * f64::from(at) / 200.0)).extend(z);
        let points = (0..200).map(point).collect();
        let ring = Loop { points, label: Label(1), hole_of: None };
        let plane = Plane { normal: DVec3::Z, offset: z };
        let name = format!("{layer}");
        Section::from_loops(&name, plane, &[ring], LAST, &rules).expect("a ring").0
    };
    Sections::new((0..6).map(section).collect(), &rules).expect("six rings")
}

fn reconstructed(border: Label) -> Model {
    let spacing = Some(1.5);
    let resolution = Resolution::Voxels(64);
    let method = Method::MeanValue(MeanValue { border, spacing, ..MeanValue::default() });
    let options = Options { method, resolution, ..Options::default() };
    let mut model = Model::new(options);
    model.apply(Change::Add(pipe()), &mut Context::default()).expect("it reconstructs");
    model
}

fn checked(model: &Model, caps: bool) -> check::Check {
    let Derived { mesh, samples, .. } = model.derived().expect("something was derived");
    let options =
        check::Options { open: samples.open.filter(|_| !caps), ..check::Options::default() };
    check(&model.sections().sections, mesh, samples, options, &Silent).expect("a check")
}

#[test]
fn in_an_open_box_a_pipe_goes_on_to_its_faces() {
    let model = reconstructed(Label::UNKNOWN);
    let Derived { mesh, samples, .. } = model.derived().expect("something was derived");
    let bounds = samples.open.expect("the box is open");
    let voxel = samples.lattice.voxel;
    let open = mesh.without_caps(bounds, CAP_TOLERANCE * voxel);
    let reached = open.bounds().expect("a surface");
    assert_eq!((reached.min.z, reached.max.z), (bounds.min.z, bounds.max.z));
    assert!(bounds.min.z < -0.5 && bounds.max.z > LAST + 0.5);
    // On the sections it is as wide as they say; between them, and up to the box
    // a spacing beyond, the mean-value field draws it in, by up to two fifths at the box.
    for vertex in &open.vertices {
        let off = vertex.truncate().length() - RADIUS;
        let on_section = (vertex.z / 2.0 - (vertex.z / 2.0).round()).abs() < 0.1 * voxel
            && (-0.1..=LAST + 0.1).contains(&vertex.z);
        assert!(if on_section { off.abs() < 0.5 * voxel } else { off.abs() < 1.25 }, "{vertex}");
    }
    let volume = PI * RADIUS * RADIUS * bounds.size().z;
    for caps in [false, true] {
        let check = checked(&model, caps);
        let label = &check.labels[0];
        assert!(check.is_sound());
        assert_eq!((label.facts.closed, label.open_edges > 0), (caps, !caps));
        assert!((0.8..1.02).contains(&(label.facts.volume / volume)), "{}", label.facts.volume);
        assert_eq!((label.facts.components, label.facts.genus), (1, 0));
    }
}

#[test]
fn in_a_closed_box_it_ends_within() {
    let model = reconstructed(Label::OUTSIDE);
    let Derived { mesh, samples, .. } = model.derived().expect("something was derived");
    assert_eq!(samples.open, None);
    let check = checked(&model, false);
    assert!(check.is_sound() && check.labels[0].facts.closed);
    let reached = mesh.bounds().expect("a surface");
    assert!(
        reached.max.z < samples.lattice.position(samples.lattice.dims).z - samples.lattice.voxel
    );
}
