//! The ways to fill space between sections, each with its own options: what a
//! method does not use cannot be given to it.
//!
//! They stand on three seams. A *kernel* is evaluated in the cells of the
//! complex by a backend ([`MeanValue`], [`Hermite`]); a *solver* fills the leaves of a grid
//! ([`Variational`], [`ShapeBased`]); and a *surface* is made directly ([`Skeleton`]). The first two
//! make samples, which a mesher turns into a surface.

use crate::field::{Device, hermite};
use crate::label::Label;
use crate::mesh::delaunay;
use crate::skeleton;
use crate::variational::Weights;

/// How space between the sections is filled.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Method {
    /// By the smoothest field through the contours.
    Variational(Variational),
    /// By the mean-value indicator (Bermano et al. 2011).
    MeanValue(MeanValue),
    /// By signed distances and their gradients (Sharma and Agarwal 2016).
    Hermite(Hermite),
    /// By the nearest section, exactly (Barequet and Vaxman 2009).
    Skeleton(Skeleton),
    /// Parallel sections by interpolating distances (Marker et al. 2006).
    Stack(ShapeBased),
}

/// The smoothest field through the contours.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Variational {
    /// What counts how much.
    pub weights: Weights,
    /// What is on the box's faces: [`Label::OUTSIDE`] closes every surface in
    /// the box, [`Label::UNKNOWN`] lets materials leave it.
    pub border: Label,
    /// How it ends beyond the outermost sections.
    pub caps: Caps,
    /// Where it is solved.
    pub device: Device,
    /// How the surface is made from the samples.
    pub mesher: Mesher,
}

/// The mean-value indicator.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MeanValue {
    /// How much ripples between the sections are smoothed away (Bermano §4.6): the
    /// length below which differences vanish, in typical distances between
    /// sections. 0 leaves the field as it is.
    pub smooth: f64,
    /// As in [`Variational`].
    pub border: Label,
    /// As in [`Variational`].
    pub caps: Caps,
    /// Where the field is evaluated.
    pub device: Device,
    /// How finely unknown regions are triangulated to be completed: the length
    /// of an edge in world units, a 16th of what is drawn when none
    /// is given.
    pub spacing: Option<f64>,
    /// How the surface is made from the samples.
    pub mesher: Mesher,
}

/// Signed distances on the sections and their gradients, interpolated in the cells.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Hermite {
    /// How facets are triangulated, and what is interpolated.
    pub interpolation: hermite::Options,
    /// As in [`Variational`].
    pub border: Label,
    /// As in [`Variational`].
    pub caps: Caps,
    /// Where the field is evaluated.
    pub device: Device,
    /// How the surface is made from the samples.
    pub mesher: Mesher,
}

/// The nearest section. The box's faces are outside, so that it ends midway to them:
/// flat, half a spacing beyond the last section of a stack.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Skeleton {
    /// How that is done.
    pub exactness: skeleton::Options,
    /// Whether the surface is made fair afterwards.
    pub fairing: Option<Fairing>,
}

/// Shape-based interpolation of parallel sections that know all of their planes. The box's faces
/// are outside.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct ShapeBased {
    /// Whether parts are linked that overlap nothing of their label on the next section. Without,
    /// they are told ([`Links`](crate::stack::Links)) and stay apart.
    pub link: Option<Linking>,
    /// As in [`Variational`].
    pub caps: Caps,
    /// How the surface is made from the samples.
    pub mesher: Mesher,
}

/// How parts are linked that do not overlap: a connected part of a label on a section that
/// overlaps none of it on the next section, and one there that overlaps none back, which matches
/// it when it is moved.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Linking {
    /// How far a part moves at most, in world units; twice the distance between its two
    /// sections when it is not given.
    pub farthest: Option<f64>,
}

/// How an exact surface is made fair.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Fairing {
    /// How long edges are to be, in world units; when it is not given 0.65 % of the box's
    /// longest side, whatever the grid is.
    pub edge_length: Option<f64>,
}

/// How a solid ends beyond the sections: on every side of a section beyond whose plane no
/// other section has a contour ([`Sections::ends`](crate::section::Sections::ends)).
///
/// In an open box ([`Label::UNKNOWN`] on its faces) it goes on up to these, whatever is
/// said here. There `Flat` asks for a surface that is closed in the box's faces, and the
/// others for one that is open there ([`Mesh::without_caps`](crate::mesh::Mesh::without_caps)).
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub enum Caps {
    /// As the field has it: rounded, up to about half a spacing beyond the last section.
    #[default]
    Rounded,
    /// In a plane half a spacing beyond the last section, which up to there is repeated.
    Flat,
    /// On the last section, or half a voxel beyond, so that the section's plane still
    /// passes through the solid.
    None,
}

/// How the surface is made from samples.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub enum Mesher {
    /// Dual contouring.
    #[default]
    Dual,
    /// Delaunay refinement.
    Delaunay(delaunay::Options),
}

impl Default for Method {
    fn default() -> Self {
        Self::Variational(Variational::default())
    }
}

impl Default for Variational {
    fn default() -> Self {
        let (weights, mesher) = (Weights::default(), Mesher::Dual);
        let (border, caps, device) = (Label::OUTSIDE, Caps::Rounded, Device::Auto);
        Self { weights, border, caps, device, mesher }
    }
}

impl Default for MeanValue {
    fn default() -> Self {
        let (border, device, mesher) = (Label::OUTSIDE, Device::Auto, Mesher::Dual);
        Self { smooth: 1.0, border, caps: Caps::Rounded, device, spacing: None, mesher }
    }
}

impl Default for Hermite {
    fn default() -> Self {
        let (border, caps, device) = (Label::OUTSIDE, Caps::Rounded, Device::Auto);
        let interpolation = hermite::Options::default();
        Self { interpolation, border, caps, device, mesher: Mesher::Dual }
    }
}

impl Method {
    /// What it is called, and what it does.
    pub fn in_words(&self) -> String {
        match self {
            Self::Variational(_) => {
                "variational: the smoothest field through the contours".to_owned()
            }
            Self::MeanValue(own) if own.smooth > 0.0 => {
                "mvc: the mean-value indicator, made smooth between sections".to_owned()
            }
            Self::MeanValue(_) => "mvc: the mean-value indicator".to_owned(),
            Self::Hermite(_) => {
                "hermite: distances and their gradients, interpolated cell by cell".to_owned()
            }
            Self::Skeleton(own) => {
                let fair = if own.fairing.is_some() { ", made fair" } else { "" };
                format!("skeleton: the label of the nearest section, exactly{fair}")
            }
            Self::Stack(_) => "stack: distances interpolated between parallel sections".to_owned(),
        }
    }

    /// What is on the box's faces.
    pub fn border(&self) -> Label {
        match self {
            Self::Variational(own) => own.border,
            Self::MeanValue(own) => own.border,
            Self::Hermite(own) => own.border,
            Self::Skeleton(_) | Self::Stack(_) => Label::OUTSIDE,
        }
    }

    /// How its solid ends.
    pub fn caps(&self) -> Caps {
        match self {
            Self::Variational(own) => own.caps,
            Self::MeanValue(own) => own.caps,
            Self::Hermite(own) => own.caps,
            Self::Skeleton(_) => Caps::Flat,
            Self::Stack(own) => own.caps,
        }
    }

    /// How its surface is made from samples, if it is.
    pub fn mesher(&self) -> Option<Mesher> {
        match self {
            Self::Variational(own) => Some(own.mesher),
            Self::MeanValue(own) => Some(own.mesher),
            Self::Hermite(own) => Some(own.mesher),
            Self::Skeleton(_) => None,
            Self::Stack(own) => Some(own.mesher),
        }
    }
}
