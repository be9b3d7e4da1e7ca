//! transect reconstructs volumes and surfaces from labelled planar
//! cross-sections of any orientation.
//!
//! ```text
//! section ─► variational ───────────► grid ─► mesh ─► check ─► report, io, picture
//!  exact ╎      f32                    f32     f64     CGAL
//!        └► complex ─► field ───────┘        ╎
//!        └► skeleton (exact) ────────────────────┘
//!             └────── model::Model applies a change::Change ──────┘
//! ```
//!
//! How space between sections is filled is a [`method::Method`].
//!
//! An arrow never points back. What holds after each stage:
//!
//! - a [`section::Section`] is valid by construction: its edges meet only in
//!   vertices, and every region has one label, decided exactly;
//! - a [`complex::Complex`] passes its `sanity_check` on every run;
//! - a [`field::Field`] reproduces constants: where one label borders a cell,
//!   or a group of cells joined through unknown regions, its value is 1 exactly;
//! - in [`grid::samples::Samples`] every node of the lattice has a label, and
//!   the outermost nodes are outside;
//! - in a [`mesh::Mesh`] every label's boundary is closed, oriented outward,
//!   and has two triangles at each edge.
//!
//! Beside this row stand the [`oracle`], the label of the nearest known point, and
//! the [`skeleton`](mod@skeleton), a surface made by that principle in rational
//! arithmetic; [`crosscheck`](mod@crosscheck) holds the two ways against each other.
//!
//! Sections that come one by one, with a journal of their changes, are [`online`].
//!
//! `docs/architecture.md` says why.
//!
//! # In a program
//!
//! A [`Model`] follows its sections: they are added, replaced and removed, and after each
//! [`Change`] the surface and the volume are there.
//!
//! ```
//! use transect::{Bounds, Change, Context, DVec3, Label, Method, Model, Options, Plane};
//! use transect::{Resolution, Rules, Section, Sections};
//!
//! // Three discs around the z axis.
//! let rules = Rules::default();
//! let disc = |height: f64, radius: f64| {
//!     let plane = Plane { normal: DVec3::Z, offset: height };
//!     let corner = |step: i32| {
//!         let (sin, cos) = (0.1 * f64::from(step)).sin_cos();
//!         DVec3::new(radius * cos, radius * sin, height)
//!     };
//!     Section::builder(format!("z = {height}"), plane)
//!         .region(Label(1), (0..62).map(corner))
//!         .build(&rules)
//! };
//! let discs = [disc(0.0, 1.0)?.0, disc(0.5, 0.8)?.0, disc(1.0, 0.5)?.0];
//!
//! let mut model = Model::new(Options {
//!     method: Method::default(),
//!     resolution: Resolution::Voxels(32),
//!     // In a box that stays, a change costs what it concerns.
//!     bounds: Some(Bounds { min: DVec3::new(-1.5, -1.5, -0.5), max: DVec3::new(1.5, 1.5, 1.5) }),
//!     ..Options::default()
//! });
//! let mut context = Context::default();
//! let ids = model.apply(Change::Add(Sections::new(discs.to_vec(), &rules)?), &mut context)?;
//! let wide = model.derived().expect("a surface").mesh.surface(Label(1)).volume();
//!
//! model.apply(Change::Replace(ids[1], disc(0.5, 0.4)?.0), &mut context)?;
//! let mesh = &model.derived().expect("a surface").mesh;
//! assert!(mesh.surface(Label(1)).volume() < wide);
//! // It is closed and faces outward, and there are figures about it.
//! let check = model.check(&mut context)?;
//! assert_eq!(check.labels[0].facts.components, 1);
//! # Ok::<(), transect::Error>(())
//! ```
//!
//! The modules say more: what a stage makes, files of every kind ([`io`]), measures
//! ([`check`](mod@check), [`compare`](mod@compare)), the other ways from sections to a surface.

mod bounding;
mod capping;
pub mod change;
pub mod check;
pub mod choice;
mod cli;
mod color;
pub mod compare;
pub mod complex;
pub mod context;
pub mod crosscheck;
mod derived;
pub mod direction;
pub mod error;
mod ffi;
pub mod field;
mod figures;
mod gpu;
pub mod grid;
pub mod inspect;
pub mod io;
pub mod label;
pub mod label_image;
pub mod layers;
mod living;
pub mod mask;
mod memory;
pub mod mesh;
pub mod method;
pub mod model;
pub mod online;
pub mod oracle;
mod output;
pub mod page;
pub mod picture;
pub mod plane;
pub mod progress;
#[doc(hidden)] // for the tests alone
pub mod random;
pub mod report;
pub mod section;
mod segments;
mod sets;
pub mod sides;
pub mod skeleton;
#[cfg(test)]
#[path = "../tests/common/skipped.rs"]
mod skipped;
pub mod slice;
pub mod slots;
pub mod stack;
pub mod stage;
pub mod sweep;
mod terminal;
pub mod variational;
pub mod volume;

pub use change::{Change, SectionId, Step};
#[doc(hidden)]
pub use cli::{Allocator, run};
pub use compare::compare;
pub use context::Context;
pub use crosscheck::crosscheck;
pub use error::{Error, Remedy, Result};
pub use field::Device;
pub use glam::DVec3;
pub use grid::lattice::Resolution;
pub use grid::samples::Samples;
pub use io::{read_all, read_sections};
pub use label::{Label, Material};
pub use mesh::Mesh;
pub use mesh::patches::Patches;
pub use method::{Hermite, MeanValue, Method, ShapeBased, Skeleton, Variational};
pub use model::{Derived, Model, Options};
pub use plane::{Bounds, Plane};
pub use progress::{Progress, Silent};
pub use report::Report;
pub use section::{Rules, Section, Sections};
pub use stage::Stages;
