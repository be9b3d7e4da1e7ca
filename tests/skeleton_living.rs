//! What a change of sections costs the exact reconstruction: surfaces of cells that show the
//! same as before are remembered. What comes of them is in `history`.

use std::f64::consts::TAU;
use std::sync::atomic::AtomicUsize;
use std::sync::atomic::Ordering::Relaxed;

use glam::DVec3;
use transect::change::{Change, SectionId};
use transect::context::Context;
use transect::grid::lattice::Resolution;
use transect::label::Label;
use transect::method::{Method, Skeleton};
use transect::model::{Model, Options};
use transect::plane::{Bounds, Plane};
use transect::progress::Progress;
use transect::section::{Overlap, Rules, Section, Sections};

const BOX: Bounds = Bounds { min: DVec3::splat(-1.5), max: DVec3::splat(1.5) };
const OFFSETS: [f64; 3] = [-0.5, 0.1, 0.625];

/// Ends the work when it has been asked so many times whether to.
struct Patience(AtomicUsize);

impl Progress for Patience {
    fn begin(&self, _stage: &'static str, _total: u64) {}
    fn advance(&self, _steps: u64) {}
    fn is_cancelled(&self) -> bool {
        self.0.fetch_update(Relaxed, Relaxed, |left| left.checked_sub(1)).is_err()
    }
}

/// A circle of label 1 on an axis-parallel plane, as through a ball, and squares of label 2.
fn circle(axis: usize, offset: f64, squares: &[[f64; 2]]) -> Section {
    let at = |u: f64, v: f64| {
        let mut point = DVec3::ZERO;
        (point[axis], point[(axis + 1) % 3], point[(axis + 2) % 3]) = (offset, u, v);
        point
    };
    let radius = (1.0 - offset * offset).sqrt();
    let corner = |i: i32| {
        let (sin, cos) = (TAU * f64::from(i) / 24.0).sin_cos();
        at(radius * cos, radius * sin)
    };
    let plane = Plane { normal: DVec3::AXES[axis], offset };
    let mut builder = Section::builder(format!("{axis} {offset}"), plane)
        .region(Label(1), (0..24).map(corner).collect::<Vec<_>>());
    for &[u, v] in squares {
        let corners = [[0.0, 0.0], [0.1, 0.0], [0.1, 0.1], [0.0, 0.1]];
        builder = builder.region(Label(2), corners.map(|[a, b]| at(u + a, v + b)));
    }
    let rules = Rules { overlap: Some(Overlap::Last), ..Rules::default() };
    builder.build(&rules).expect("a section").0
}

/// Nine of them, which make 64 cells, 27 or more of them with a surface.
fn circles() -> Vec<Section> {
    let all = (0..3).flat_map(|axis| OFFSETS.map(|offset| circle(axis, offset, &[])));
    all.collect()
}

fn sections(sections: &[Section]) -> Sections {
    Sections::new(sections.to_vec(), &Rules::default()).expect("sections")
}

fn model(bounds: Option<Bounds>) -> Model {
    let method = Method::Skeleton(Skeleton::default());
    Model::new(Options { method, resolution: Resolution::Voxels(16), bounds, ..Options::default() })
}

/// The numbers of new sections, and in how many cells the surface was computed.
fn apply(model: &mut Model, change: Change) -> (Vec<SectionId>, u64) {
    let mut context = Context::default();
    let ids = model.apply(change, &mut context).expect("a change");
    (ids, context.stages.count_of("cells computed"))
}

fn assert_as_at_once(living: &Model) {
    let mut once = model(living.options().bounds);
    let given: Vec<Section> = living.given().map(|(_, section)| section.clone()).collect();
    // As they are: what is given at once would be aligned at once.
    apply(&mut once, Change::Add(Sections { sections: given, ..Sections::default() }));
    let [one, other] = [living, &once].map(|model| model.derived().expect("a surface"));
    assert!(one.mesh == other.mesh, "other surfaces than at once");
    assert!(one.exact == other.exact, "other details than at once");
}

#[test]
fn what_did_not_change_is_not_computed() {
    let mut living = model(Some(BOX));
    let (ids, all) = apply(&mut living, Change::Add(sections(&circles())));
    assert!((27..=64).contains(&all), "{all}");
    let same = |id: usize| Change::Replace(ids[id], circles()[id].clone());
    for id in [0, 4, 8] {
        assert_eq!(apply(&mut living, same(id)).1, 0);
    }
    // In one facet, between two cells.
    let edited = circle(2, 0.1, &[[0.2, 0.2]]);
    assert_eq!(apply(&mut living, Change::Replace(ids[7], edited)).1, 2);
    assert_as_at_once(&living);
    // What was there before the last change is not remembered.
    assert_eq!(apply(&mut living, same(7)).1, 2);
    assert_as_at_once(&living);
}

#[test]
fn a_section_costs_the_cells_that_it_cuts() {
    let mut living = model(Some(BOX));
    apply(&mut living, Change::Add(sections(&circles())));
    // Of 16 cells on one side, it makes 32.
    let (ids, added) = apply(&mut living, Change::Add(sections(&[circle(0, 0.75, &[])])));
    assert!((8..=32).contains(&added), "{added}");
    assert_as_at_once(&living);
    let (_, removed) = apply(&mut living, Change::Remove(ids[0]));
    assert!((8..=16).contains(&removed), "{removed}");
    assert_as_at_once(&living);
}

/// A part of a plane in one cell concerns no other.
#[test]
fn a_partial_section_costs_the_cells_in_which_it_is() {
    let mut living = model(Some(BOX));
    apply(&mut living, Change::Add(sections(&circles())));
    let plane = Plane { normal: DVec3::new(1.0, 1.0, 1.0), offset: 0.6 };
    let corners = [[0.15, 0.15], [0.25, 0.15], [0.2, 0.25]];
    let partial = Section::builder("partial", plane)
        .region(Label(2), corners.map(|[x, y]| DVec3::new(x, y, 0.6 - x - y)))
        .within(corners.map(|[x, y]| DVec3::new(x, y, 0.6 - x - y)))
        .build(&Rules { overlap: Some(Overlap::Last), ..Rules::default() });
    let partial = partial.expect("a section").0;
    let (ids, added) = apply(&mut living, Change::Add(sections(&[partial])));
    // Contours that its plane crosses get a vertex more there.
    assert!((1..=24).contains(&added), "{added}");
    assert_as_at_once(&living);
    apply(&mut living, Change::Remove(ids[0]));
    assert_as_at_once(&living);
}

/// The box follows the sections, and grows: cells that reach to it change, others do not.
#[test]
fn where_the_box_grows_cells_inside_stay() {
    let mut living = model(None);
    let mut all = circles();
    all.extend((0..3).map(|axis| circle(axis, -0.75, &[])));
    let (_, first) = apply(&mut living, Change::Add(sections(&all)));
    let plane = Plane { normal: DVec3::X, offset: 0.7 };
    let wider = [[-1.1, -0.1], [-0.9, -0.1], [-0.9, 0.1], [-1.1, 0.1]];
    let wider = Section::builder("wider", plane)
        .region(Label(1), wider.map(|[y, z]| DVec3::new(0.7, y, z)))
        .build(&Rules::default());
    let before = living.derived().expect("samples").samples.lattice;
    let (_, added) = apply(&mut living, Change::Add(sections(&[wider.expect("a section").0])));
    assert_ne!(living.derived().expect("samples").samples.lattice, before);
    assert!(added < first, "{added} of {first}");
    assert_as_at_once(&living);
}

/// What fails or is cancelled, also after surfaces were remembered, leaves nothing behind that
/// shows.
#[test]
fn after_a_failure() {
    let mut living = model(Some(BOX));
    let (ids, _) = apply(&mut living, Change::Add(sections(&circles())));
    let outside = circle(2, 0.1, &[[1.6, 0.0]]);
    let refused = Change::Replace(ids[7], outside);
    living.apply(refused, &mut Context::default()).expect_err("it leaves the box");
    let edited = circle(2, 0.1, &[[0.2, 0.2]]);
    for patience in [0, 1, 20, 60, 64] {
        let patience = Patience(AtomicUsize::new(patience));
        let mut context = Context::new(Rules::default(), &patience);
        let change = Change::Replace(ids[7], edited.clone());
        living.apply(change, &mut context).expect_err("it is cancelled");
    }
    let other = circle(1, 0.1, &[[-0.2, 0.2]]);
    apply(&mut living, Change::Replace(ids[4], other));
    assert_as_at_once(&living);
    apply(&mut living, Change::Replace(ids[7], edited));
    assert_as_at_once(&living);
}
