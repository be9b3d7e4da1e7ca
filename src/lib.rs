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

mod capping;
pub mod change;
pub mod check;
pub mod cli;
pub mod compare;
pub mod complex;
mod components;
pub mod crosscheck;
pub mod direction;
pub mod error;
pub mod ffi;
pub mod field;
mod gpu;
pub mod grid;
pub mod inspect;
pub mod io;
pub mod label;
mod living;
pub mod mask;
pub mod memory;
pub mod mesh;
pub mod method;
pub mod model;
pub mod online;
pub mod oracle;
pub mod output;
pub mod picture;
pub mod plane;
pub mod progress;
mod random;
pub mod report;
pub mod section;
pub mod skeleton;
pub mod slice;
pub mod slots;
pub mod stage;
pub mod sweep;
pub mod variational;
pub mod volume;
