//! Whatever was added, replaced, removed and taken back: a model is the one that its sections
//! make at once. Random sections, in a box that is given or follows them.

#[path = "common/random.rs"]
mod random;

use std::f64::consts::TAU;
use std::ops::Range;

use glam::{DVec2, DVec3};
use random::Random;
use transect::change::{Change, SectionId};
use transect::context::Context;
use transect::grid::lattice::Resolution;
use transect::label::Label;
use transect::mesh::nearest::Nearest;
use transect::method::{MeanValue, Method, Skeleton, Variational};
use transect::model::{Model, Options};
use transect::plane::{Bounds, Plane};
use transect::section::{Overlap, Rules, Section, Sections};

const BOX: Bounds = Bounds { min: DVec3::splat(-1.5), max: DVec3::splat(1.5) };
/// How fine the grid is, and the box.
type Space = (Resolution, Option<Bounds>);
const GIVEN: Space = (Resolution::Voxels(24), Some(BOX));
/// Anew with every change.
const FOLLOWING: Space = (Resolution::Voxels(24), None);
/// On a grid that stays.
const GROWING: Space = (Resolution::VoxelSize(0.02), None);
/// Changes of one sequence.
const CHANGES: usize = 7;

fn rules() -> Rules {
    Rules { overlap: Some(Overlap::Last), ..Rules::default() }
}

/// Planes that are parallel, that pass through one line or point, that are one, and others.
fn plane(random: &mut Random, last: Option<Plane>) -> Plane {
    let axis = |random: &mut Random| DVec3::AXES[random.below(3)];
    let step = |random: &mut Random| random.below(5) as f64 / 4.0 - 0.5;
    match (random.below(6), last) {
        (0, Some(last)) => last,
        (1, Some(last)) => Plane { offset: last.offset + 0.25 * last.normal.length(), ..last },
        (2, _) => {
            let turn = TAU * random.below(8) as f64 / 8.0;
            Plane { normal: DVec3::new(turn.cos(), turn.sin(), 0.0), offset: 0.0 }
        }
        (3, _) => {
            let normal = axis(random) + step(random) * axis(random);
            Plane { normal: if normal == DVec3::ZERO { DVec3::Z } else { normal }, offset: 0.0 }
        }
        (4, _) => Plane { normal: axis(random), offset: step(random) },
        _ => {
            let normal = DVec3::from_array(std::array::from_fn(|_| random.between(-1.0..1.0)));
            Plane { normal, offset: random.between(-0.5..0.5) * normal.length() }
        }
    }
}

/// Up to three polygons, of which one may be unknown, or nothing known beyond one.
fn section(random: &mut Random, number: usize, last: Option<Plane>) -> Section {
    let plane = plane(random, last);
    let [u, v] = plane.tangents();
    let foot = plane.offset / plane.normal.length() * plane.unit_normal();
    let polygon = |random: &mut Random, size: f64| {
        let corners = 3 + random.below(6);
        let middle = DVec2::new(random.between(-0.2..0.2), random.between(-0.2..0.2));
        let corner = |corner: usize| {
            let turn = TAU * corner as f64 / corners as f64;
            let at = middle + size * random.between(0.6..1.0) * DVec2::from_angle(turn);
            foot + at.x * u + at.y * v
        };
        (0..corners).map(corner).collect::<Vec<DVec3>>()
    };
    let mut builder = Section::builder(format!("{number}"), plane);
    for _ in 0..random.below(3) {
        builder = builder.region(Label(1 + random.below(2) as u32), polygon(random, 0.7));
    }
    if random.percent(20) {
        builder = builder.region(Label::UNKNOWN, polygon(random, 0.5));
    }
    if random.percent(10) {
        builder = builder.within(polygon(random, 0.9));
    }
    builder.build(&rules()).expect("a section").0
}

fn model(method: Method, (resolution, bounds): Space) -> Model {
    Model::new(Options { method, resolution, bounds, ..Options::default() })
}

fn apply(model: &mut Model, change: Change) -> transect::Result<Vec<SectionId>> {
    model.apply(change, &mut Context { rules: rules(), ..Context::default() })
}

fn add(section: Section) -> Change {
    Change::Add(Sections::new(vec![section], &rules()).expect("sections"))
}

/// A change that may be refused; whether it was not.
fn change(random: &mut Random, living: &mut Model, number: usize) -> bool {
    let given: Vec<SectionId> = living.given().map(|(id, _)| id).collect();
    let last = living.given().last().map(|(_, section)| *section.plane());
    let new = section(random, number, last);
    let some = |random: &mut Random| given[random.below(given.len())];
    let change = match random.below(8) {
        0 if number > 3 => return living.undo(&mut Context::default()).expect("taken back"),
        1 | 2 if given.len() > 2 => Change::Remove(some(random)),
        3 if given.len() > 1 => Change::Replace(some(random), new),
        4 if given.len() > 2 => Change::All(vec![Change::Remove(some(random)), add(new)]),
        _ => add(new),
    };
    apply(living, change).is_ok()
}

/// What its sections make at once.
fn at_once(living: &Model) -> Option<Model> {
    let sections: Vec<Section> = living.given().map(|(_, section)| section.clone()).collect();
    let mut once = Model::new(*living.options());
    let sections = Sections::new(sections, &rules()).expect("sections");
    apply(&mut once, Change::Add(sections)).ok()?;
    Some(once)
}

/// Follows random changes and holds the model against what is made at once after each. With
/// `TRANSECT_SEQUENCES=N` N sequences, from the same one on.
fn follow(
    method: Method,
    space: Space,
    seeds: Range<u64>,
    same: impl Fn(&Model, &Model) -> Result<(), String>,
) {
    let number = std::env::var("TRANSECT_SEQUENCES").ok().and_then(|word| word.parse::<u64>().ok());
    let seeds = number.map_or(seeds.clone(), |number| seeds.start..seeds.start + number);
    let (mut compared, mut wrong) = (0, Vec::new());
    for seed in seeds.clone() {
        let mut random = Random::new(seed);
        let mut living = model(method, space);
        for number in 0..CHANGES {
            if !change(&mut random, &mut living, number) || living.derived().is_none() {
                continue;
            }
            let once = at_once(&living).expect("it was made before");
            if let Err(what) = same(&living, &once) {
                wrong.push(format!("sequence {seed}, after change {number}: {what}"));
            }
            compared += 1;
        }
    }
    assert!(wrong.is_empty(), "{compared} were compared: {wrong:#?}");
    assert!(compared > 3 * (seeds.end - seeds.start), "{compared} were compared");
}

/// Sums over a cell's edges may come in another order, in single precision; shares of
/// unknown regions are the same but for what a sweep still changes.
fn same_values(one: &Model, other: &Model) -> Result<(), String> {
    let most = if one.given().any(|(_, section)| section.is_partial()) { 5e-4 } else { 2e-6 };
    let [one, other] = [one, other].map(|model| &model.derived().expect("samples").samples);
    if (&one.valued, &one.tiles) != (&other.valued, &other.tiles) {
        return Err("leaves differ".to_owned());
    }
    let mut largest = 0.0f32;
    for (one, other) in one.leaves().zip(other.leaves()) {
        for (one, other) in one.materials.iter().zip(&other.materials) {
            let pairs = one.values.iter().zip(other.values.iter());
            largest = pairs.map(|(one, other)| (one - other).abs()).fold(largest, f32::max);
        }
    }
    if largest < most { Ok(()) } else { Err(format!("values differ by {largest}")) }
}

/// Fields that have a past may differ a little.
fn same_surfaces(one: &Model, other: &Model) -> Result<(), String> {
    let [mesh, wanted] = [one, other].map(|model| &model.derived().expect("a mesh").mesh);
    if mesh.triangles.is_empty() && wanted.triangles.is_empty() {
        return Ok(());
    }
    let voxel = one.derived().expect("samples").samples.lattice.voxel;
    let mut found = [0.0f64; 3];
    for (mesh, wanted) in [(mesh, wanted), (wanted, mesh)] {
        let nearest = Nearest::on_mesh(wanted).map_err(|error| error.to_string())?;
        let mut apart = nearest.distances(&mesh.vertices).map_err(|error| error.to_string())?;
        apart.sort_by(f64::total_cmp);
        for (found, percent) in found.iter_mut().zip([95, 99, 100]) {
            *found = found.max(apart[(apart.len() - 1) * percent / 100] / voxel);
        }
    }
    let good = found[0] < 0.02 && found[1] < 0.05 && found[2] < 0.5;
    if good { Ok(()) } else { Err(format!("{found:?} voxels")) }
}

#[test]
fn of_the_mean_value_field() {
    let method = Method::MeanValue(MeanValue { smooth: 0.0, ..MeanValue::default() });
    follow(method, GIVEN, 0..100, same_values);
    follow(method, GROWING, 100..110, same_values);
}

#[test]
fn of_the_variational_field() {
    let method = Method::Variational(Variational::default());
    follow(method, GIVEN, 0..15, same_surfaces);
    follow(method, GROWING, 15..19, same_surfaces);
}

/// All that is said, to the last bit.
fn same_exactly(one: &Model, other: &Model) -> Result<(), String> {
    let [one, other] = [one, other].map(|model| model.derived().expect("a mesh"));
    if one.mesh != other.mesh {
        return Err("meshes differ".to_owned());
    }
    if one.exact == other.exact { Ok(()) } else { Err("details differ".to_owned()) }
}

#[test]
fn of_the_skeleton() {
    follow(Method::Skeleton(Skeleton::default()), GIVEN, 0..10, same_exactly);
}

#[test]
fn of_the_skeleton_in_a_box_that_follows() {
    follow(Method::Skeleton(Skeleton::default()), FOLLOWING, 20..25, same_exactly);
}
