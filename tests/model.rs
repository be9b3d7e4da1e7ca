//! Models that change: sections are added, replaced and removed, and changes taken back.

use std::sync::atomic::AtomicUsize;
use std::sync::atomic::Ordering::Relaxed;

use glam::DVec3;
use transect::change::{Change, SectionId, Step};
use transect::context::Context;
use transect::error::{Error, Result};
use transect::grid::lattice::Resolution;
use transect::label::Label;
use transect::mesh::Mesh;
use transect::mesh::delaunay;
use transect::mesh::nearest::Nearest;
use transect::method::{Fairing, MeanValue, Mesher, Method, Skeleton, Variational};
use transect::model::{MOST_UNDONE, Model, Options};
use transect::plane::{Bounds, Plane};
use transect::progress::Progress;
use transect::section::{Loop, Rules, Section, Sections};

/// Ends the work when it has been asked so many times whether to.
struct Patience(AtomicUsize);

impl Progress for Patience {
    fn begin(&self, _stage: &'static str, _total: u64) {}
    fn advance(&self, _steps: u64) {}
    fn is_cancelled(&self) -> bool {
        let left = self.0.fetch_update(Relaxed, Relaxed, |left| left.checked_sub(1));
        left.is_err()
    }
}

/// A square around the middle of an axis-parallel plane.
fn square(name: &str, axis: usize, offset: f64, half: f64, label: u32) -> Section {
    let plane = Plane { normal: DVec3::AXES[axis], offset };
    let at = |u: f64, v: f64| {
        let mut point = DVec3::ZERO;
        (point[axis], point[(axis + 1) % 3], point[(axis + 2) % 3]) = (offset, u, v);
        point
    };
    let points = vec![at(-half, -half), at(half, -half), at(half, half), at(-half, half)];
    let ring = Loop { points, label: Label(label), hole_of: None };
    Section::from_loops(name, plane, &[ring], 4.0, &Rules::default()).expect("a section").0
}

/// Squares in all three directions.
fn squares() -> Vec<Section> {
    let drawn = [(0, -0.4), (1, 0.1), (2, -0.2), (0, 0.3), (2, 0.5)];
    let named = |(index, &(axis, offset)): (usize, &(usize, f64))| {
        square(&format!("section {index}"), axis, offset, 1.0, 1)
    };
    drawn.iter().enumerate().map(named).collect()
}

fn sections(sections: &[Section]) -> Sections {
    Sections::new(sections.to_vec(), &Rules::default()).expect("sections")
}

fn methods() -> [Method; 3] {
    let mean_value = Method::MeanValue(MeanValue::default());
    [Method::default(), mean_value, Method::Skeleton(Skeleton::default())]
}

fn model(method: Method) -> Model {
    Model::new(Options { method, resolution: Resolution::Voxels(24), ..Options::default() })
}

fn apply(model: &mut Model, change: Change) -> Result<Vec<SectionId>> {
    model.apply(change, &mut Context::default())
}

fn undo(model: &mut Model) -> bool {
    model.undo(&mut Context::default()).expect("it can be undone")
}

fn mesh(model: &Model) -> &Mesh {
    &model.derived().expect("a surface").mesh
}

/// Sums over a cell's edges may come in another order.
fn assert_same(one: &Mesh, other: &Mesh) {
    assert_eq!((one.vertices.len(), &one.triangles), (other.vertices.len(), &other.triangles));
    let pairs = one.vertices.iter().zip(&other.vertices);
    let apart = pairs.map(|(one, other)| one.distance(*other)).fold(0.0, f64::max);
    assert!(apart < 1e-4, "vertices are {apart} apart");
}

fn names(model: &Model) -> Vec<&str> {
    model.given().map(|(_, section)| section.name()).collect()
}

#[test]
fn sections_that_come_one_by_one_make_what_they_make_at_once() {
    for method in methods() {
        let (mut once, mut living) = (model(method), model(method));
        let ids = apply(&mut once, Change::Add(sections(&squares()))).unwrap();
        for (section, &id) in squares().iter().zip(&ids) {
            let change = Change::Add(sections(std::slice::from_ref(section)));
            assert_eq!(apply(&mut living, change).unwrap(), [id]);
        }
        assert_same(mesh(&living), mesh(&once));
        // Nobody is renamed or numbered anew.
        let expected: Vec<String> = (0..5).map(|index| format!("section {index}")).collect();
        assert_eq!(names(&living), expected);
        assert_eq!(ids, (0..5).map(SectionId).collect::<Vec<_>>());
    }
}

#[test]
fn what_is_removed_leaves_no_trace_and_comes_back() {
    for method in methods() {
        let (mut living, mut without) = (model(method), model(method));
        let ids = apply(&mut living, Change::Add(sections(&squares()))).unwrap();
        let before = mesh(&living).clone();
        apply(&mut living, Change::Remove(ids[3])).unwrap();
        let mut rest = squares();
        rest.remove(3);
        apply(&mut without, Change::Add(sections(&rest))).unwrap();
        assert_same(mesh(&living), mesh(&without));
        assert!(undo(&mut living));
        assert_same(mesh(&living), &before);
        assert_eq!(names(&living).len(), 5);
        // A number is never given twice.
        let added = sections(&[square("new", 1, -0.6, 1.0, 2)]);
        assert_eq!(apply(&mut living, Change::Add(added)).unwrap(), [SectionId(5)]);
        assert!(undo(&mut living) && undo(&mut living) && !undo(&mut living));
        assert!(living.derived().is_none() && names(&living).is_empty());
    }
}

#[test]
fn a_section_is_replaced_in_its_place() {
    let (mut living, mut other) = (model(Method::default()), model(Method::default()));
    let ids = apply(&mut living, Change::Add(sections(&squares()))).unwrap();
    let smaller = square("smaller", 0, -0.4, 0.5, 1);
    apply(&mut living, Change::Replace(ids[0], smaller.clone())).unwrap();
    let mut all = squares();
    all[0] = smaller;
    apply(&mut other, Change::Add(sections(&all))).unwrap();
    assert_same(mesh(&living), mesh(&other));
    assert_eq!(names(&living), names(&other));
}

#[test]
fn several_changes_are_one() {
    let mut living = model(Method::default());
    let ids = apply(&mut living, Change::Add(sections(&squares()))).unwrap();
    let before = mesh(&living).clone();
    let added = sections(&[square("new", 1, -0.6, 1.0, 2)]);
    let change = Change::All(vec![
        Change::Remove(ids[1]),
        Change::Add(added),
        Change::Replace(ids[2], square("replaced", 2, -0.2, 0.75, 1)),
    ]);
    assert_eq!(apply(&mut living, change).unwrap(), [SectionId(5)]);
    assert_eq!(names(&living), ["section 0", "replaced", "section 3", "section 4", "new"]);
    assert!(undo(&mut living));
    assert_same(mesh(&living), &before);
}

#[test]
fn a_change_that_is_refused_changes_nothing() {
    let mut living = model(Method::default());
    let ids = apply(&mut living, Change::Add(sections(&squares()))).unwrap();
    let before = mesh(&living).clone();
    let drawn = format!("{:?}", living.sections());
    // It lies on the plane of another one, and says something else.
    let wrong = square("wrong", 0, -0.4, 1.0, 7);
    let change = Change::All(vec![Change::Remove(ids[4]), Change::Add(sections(&[wrong]))]);
    let error = apply(&mut living, change).unwrap_err().to_string();
    assert!(error.contains("section wrong: lies on the plane of section section 0"), "{error}");
    let error = apply(&mut living, Change::Remove(SectionId(17))).unwrap_err().to_string();
    assert!(error.contains("no section with the number 17"), "{error}");
    assert!(*mesh(&living) == before && format!("{:?}", living.sections()) == drawn);
    // And it is not a change that could be taken back.
    assert!(undo(&mut living) && !undo(&mut living));
}

/// Wherever a change is when it is cancelled, the model is as it was, and the next change
/// makes what it would have made.
#[test]
fn a_cancelled_change_changes_nothing() {
    let delaunay = Mesher::Delaunay(delaunay::Options::default());
    let fairing = Some(Fairing { edge_length: Some(0.3) });
    let others = [
        Method::Variational(Variational { mesher: delaunay, ..Variational::default() }),
        Method::Skeleton(Skeleton { fairing, ..Skeleton::default() }),
    ];
    for method in methods().into_iter().chain(others) {
        let squares = squares();
        let [first, last] = [&squares[..4], &squares[4..]].map(sections);
        let mut model = boxed(method, 16);
        apply(&mut model, Change::Add(first.clone())).unwrap();
        let before = mesh(&model).clone();
        let mut patience = 0;
        loop {
            let patient = Patience(AtomicUsize::new(patience));
            let mut context = Context::new(Rules::default(), &patient);
            match model.apply(Change::Add(last.clone()), &mut context) {
                Ok(_) => break,
                Err(error) => assert_eq!(error, Error::Cancelled),
            }
            assert_same(mesh(&model), &before);
            assert_eq!(names(&model).len(), 4);
            patience += 1 + patience / 2;
        }
        assert!(patience > 2, "{method:?} asks {patience} times");
        let mut other = boxed(method, 16);
        apply(&mut other, Change::Add(first)).unwrap();
        apply(&mut other, Change::Add(last)).unwrap();
        assert_alike(&model, &other);
    }
}

#[test]
fn of_two_sections_on_one_plane_either_can_go() {
    let mut living = model(Method::default());
    let mut all = squares();
    let ids = apply(&mut living, Change::Add(sections(&all))).unwrap();
    let same = square("same", 0, -0.4, 1.0, 1);
    apply(&mut living, Change::Add(sections(&[same]))).unwrap();
    assert_eq!((living.sections().sections.len(), names(&living).len()), (5, 6));
    apply(&mut living, Change::Remove(ids[0])).unwrap();
    assert_eq!((living.sections().sections.len(), names(&living).len()), (5, 5));
    let mut other = model(Method::default());
    all.rotate_left(1);
    apply(&mut other, Change::Add(sections(&all))).unwrap();
    assert_same(mesh(&living), mesh(&other));
}

#[test]
fn only_the_last_changes_are_remembered() {
    let mut living = model(Method::Skeleton(Skeleton::default()));
    let ids = apply(&mut living, Change::Add(sections(&squares()))).unwrap();
    for step in 0..MOST_UNDONE {
        let half = if step % 2 == 0 { 0.75 } else { 0.5 };
        let change = Change::Replace(ids[1], square("section 1", 1, 0.1, half, 1));
        apply(&mut living, change).unwrap();
    }
    assert_eq!((0..2 * MOST_UNDONE).filter(|_| undo(&mut living)).count(), MOST_UNDONE);
    assert_eq!(names(&living).len(), 5);
}

const BOX: Bounds = Bounds { min: DVec3::splat(-1.3), max: DVec3::splat(1.3) };

/// A model in a box of its own.
fn boxed(method: Method, voxels: u32) -> Model {
    Model::new(Options {
        method,
        resolution: Resolution::Voxels(voxels),
        bounds: Some(BOX),
        ..Options::default()
    })
}

/// A model of the mean-value field in a box of its own.
fn evaluated() -> Model {
    boxed(Method::MeanValue(MeanValue { smooth: 0.0, ..MeanValue::default() }), 40)
}

#[test]
fn in_a_box_only_what_a_section_touches_is_evaluated_again() {
    let all = squares();
    let (mut living, mut once) = (evaluated(), evaluated());
    let (mut last, mut ids) = (Context::default(), Vec::new());
    for section in &all {
        let change = Change::Add(sections(std::slice::from_ref(section)));
        last = Context::default();
        let added = living.apply(change, &mut last).unwrap();
        ids.extend(added);
    }
    let mut offline = Context::default();
    once.apply(Change::Add(sections(&all)), &mut offline).unwrap();
    same_samples(&living, &once);
    // Below the section before the last, which is parallel, all is as it was.
    let [some, all_of_it] = [&last, &offline].map(|context| &context.stages);
    assert!(4 * some.count_of("evaluations") < 3 * all_of_it.count_of("evaluations"));
    assert!(some.count_of("touched") < all_of_it.count_of("touched"));

    // In turn each goes, and comes back as it was.
    for &id in &ids {
        apply(&mut living, Change::Remove(id)).unwrap();
        let rest: Vec<Section> = living.given().map(|(_, section)| section.clone()).collect();
        let mut without = evaluated();
        apply(&mut without, Change::Add(sections(&rest))).unwrap();
        same_samples(&living, &without);
        assert!(undo(&mut living));
        same_samples(&living, &once);
    }
    // What is refused is not drawn.
    let wrong = square("wrong", 0, -0.4, 1.0, 7);
    apply(&mut living, Change::Add(sections(&[wrong]))).unwrap_err();
    apply(&mut living, Change::Add(sections(&[square("far", 0, 0.7, 1.4, 1)]))).unwrap_err();
    assert!(undo(&mut living));
    let mut fewer = evaluated();
    apply(&mut fewer, Change::Add(sections(&all[..4]))).unwrap();
    same_samples(&living, &fewer);
}

/// Sums over a cell's edges may come in another order.
fn same_samples(one: &Model, other: &Model) {
    let [one, other] = [one, other].map(|model| &model.derived().expect("samples").samples);
    assert_eq!((&one.valued, &one.tiles), (&other.valued, &other.tiles));
    for (one, other) in one.leaves().zip(other.leaves()) {
        for (one, other) in one.materials.iter().zip(&other.materials) {
            assert_eq!(one.label, other.label);
            let pairs = one.values.iter().zip(other.values.iter());
            assert!(pairs.into_iter().all(|(one, other)| (one - other).abs() < 1e-6));
        }
    }
}

#[test]
fn in_a_box_fields_are_solved_for_where_a_section_concerns_them() {
    for method in [Method::default(), Method::MeanValue(MeanValue::default())] {
        solved_where_a_section_concerns(method);
    }
}

fn solved_where_a_section_concerns(method: Method) {
    // The last one is parallel to the one before, and smaller.
    let mut all = squares();
    all.extend([square("near", 2, 0.55, 0.8, 1), square("small", 2, 0.6, 0.5, 1)]);
    let (mut living, mut once) = (boxed(method, 64), boxed(method, 64));
    let mut ids = Vec::new();
    for section in &all {
        let change = Change::Add(sections(std::slice::from_ref(section)));
        ids.extend(apply(&mut living, change).unwrap());
    }
    let mut offline = Context::default();
    once.apply(Change::Add(sections(&all)), &mut offline).unwrap();
    assert_alike(&living, &once);
    let unknowns = |context: &Context| context.stages.count_of("unknowns");
    // The less changes the less is solved for.
    let [mut less, mut nothing] = [Context::default(), Context::default()];
    for (half, context) in [(0.49, &mut less), (0.49, &mut nothing)] {
        let change = Change::Replace(ids[6], square("small", 2, 0.6, half, 1));
        living.apply(change, context).unwrap();
    }
    let counts = [&less, &nothing, &offline].map(unknowns);
    assert!(2 * counts[0] < counts[2] && 20 * counts[1] < counts[2], "{counts:?}");
    assert!(undo(&mut living) && undo(&mut living));
    assert_alike(&living, &once);

    for id in [ids[0], ids[4], ids[6]] {
        apply(&mut living, Change::Remove(id)).unwrap();
        let rest: Vec<Section> = living.given().map(|(_, section)| section.clone()).collect();
        let mut without = boxed(method, 64);
        apply(&mut without, Change::Add(sections(&rest))).unwrap();
        assert_alike(&living, &without);
        assert!(undo(&mut living));
        assert_alike(&living, &once);
    }
    // Nothing that is refused is remembered.
    let wrong = square("wrong", 0, -0.4, 1.0, 7);
    apply(&mut living, Change::Add(sections(&[wrong]))).unwrap_err();
    assert!(undo(&mut living));
    let mut fewer = boxed(method, 64);
    apply(&mut fewer, Change::Add(sections(&all[..6]))).unwrap();
    assert_alike(&living, &fewer);
}

/// Whether surfaces differ by no more than a field that has a past may.
fn assert_alike(one: &Model, other: &Model) {
    let voxel = one.derived().expect("samples").samples.lattice.voxel;
    let nearest = Nearest::on_mesh(mesh(other)).unwrap();
    let mut apart = nearest.distances(&mesh(one).vertices).unwrap();
    apart.sort_by(f64::total_cmp);
    let at = |percent: usize| apart[(apart.len() - 1) * percent / 100] / voxel;
    let found = [95, 99, 100].map(at);
    assert!(found[0] < 0.02 && found[1] < 0.05 && found[2] < 0.5, "{found:?} voxels");
}

#[test]
fn a_step_that_cannot_be_kept_is_not_taken() {
    let (mut living, mut other) = (evaluated(), evaluated());
    apply(&mut living, Change::Add(sections(&squares()))).unwrap();
    apply(&mut other, Change::Add(sections(&squares()))).unwrap();
    let added = Change::Add(sections(&[square("new", 1, -0.6, 1.0, 2)]));
    for step in [Step::Change(Box::new(added)), Step::Undo] {
        let full = || Err(Error::Option("the disk is full".to_owned()));
        let error = living.take(step, &mut Context::default(), full).unwrap_err();
        assert_eq!(error.to_string(), "the disk is full");
        assert_eq!(names(&living), names(&other));
        same_samples(&living, &other);
    }
    // It goes on as if nothing had been.
    let change = || Change::Replace(SectionId(3), square("other", 0, 0.3, 0.5, 1));
    apply(&mut living, change()).unwrap();
    apply(&mut other, change()).unwrap();
    same_samples(&living, &other);
    assert!(undo(&mut living) && undo(&mut living) && !undo(&mut living));
}

#[test]
fn a_resumed_model_is_the_one_that_took_the_steps() {
    let all = squares();
    let one = |index: usize| Change::Add(sections(std::slice::from_ref(&all[index])));
    let change = |change| Step::Change(Box::new(change));
    let mut steps: Vec<Step> = (0..5).map(|index| change(one(index))).collect();
    steps.push(change(Change::Remove(SectionId(1))));
    steps.extend([Step::Undo, Step::Undo, change(one(4))]);
    steps.push(change(Change::Replace(SectionId(0), square("less", 0, -0.4, 0.5, 1))));
    let mut lived = model(Method::default());
    for step in steps.clone() {
        lived.take(step, &mut Context::default(), || Ok(())).unwrap();
    }
    let (options, mut context) = (*lived.options(), Context::default());
    let steps = steps.into_iter().map(Ok);
    let mut resumed = Model::resume(options, steps, &mut context).unwrap();
    // Derived once, and from the same: to the last bit.
    let stages = &context.stages.stages;
    assert_eq!(stages.iter().filter(|stage| stage.name == "field").count(), 1);
    loop {
        let ids = |model: &Model| model.given().map(|(id, _)| id).collect::<Vec<_>>();
        assert_eq!((ids(&resumed), names(&resumed)), (ids(&lived), names(&lived)));
        let meshes = [&resumed, &lived].map(|model| model.derived().map(|derived| &derived.mesh));
        assert!(meshes[0] == meshes[1]);
        let undone = undo(&mut resumed);
        assert_eq!(undone, undo(&mut lived));
        if !undone {
            break;
        }
    }
    for wrong in [vec![Ok(Step::Undo)], vec![Err(Error::Option("unread".to_owned()))]] {
        assert!(Model::resume(options, wrong, &mut context).is_err());
    }
}

#[test]
fn sections_that_come_and_go_leave_no_warnings_behind() {
    let mut living = model(Method::default());
    let mut named = |name: &str, offset: f64| {
        let mut one = sections(&[square(name, 0, offset, 1.0, 1)]);
        one.materials[0].name = name.to_owned();
        apply(&mut living, Change::Add(one)).unwrap();
        living.sections().warnings.len()
    };
    let told = ["a", "b", "c", "d"].map(|name| named(name, f64::from(name.as_bytes()[0]) / 256.0));
    assert_eq!(told, [0, 1, 1, 1]);
    assert!(living.sections().warnings[0].what.contains("\"a\" and \"b\""));
}

#[test]
fn threads_may_share_a_model() {
    fn is_shared<T: Send + Sync>(_: &T) {}
    is_shared(&model(Method::default()));
}
