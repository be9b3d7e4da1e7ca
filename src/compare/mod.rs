//! How far a solid is from a reference solid: all materials as one, and label by label.

mod agreement;
mod columns;
mod labels;
pub mod methods;
pub mod normals;
mod sampling;
mod shape;
mod solid;
mod steps;

pub(crate) use sampling::draw;

use serde::Serialize;

use crate::error::Result;
use crate::mesh::Mesh;
use crate::progress::Progress;
use agreement::agreement;
use solid::Solid;
use steps::Steps;

pub use agreement::{Agreement, Lengths};
pub use labels::{LabelComparison, LabelledComparison, compare_labels};
pub use shape::{Content, Shape};

/// How finely is looked.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Options {
    /// Voxels on the longest side of the box around both solids, for volumes
    /// in common.
    pub grid: u32,
    /// Points drawn on each surface.
    pub samples: u32,
    /// What they are drawn from: the same points for the same seed.
    pub seed: u64,
    /// How far surfaces may be apart to count as the same for the surface Dice, in world units of
    /// the reference; without it there is none.
    pub tolerance: Option<f64>,
}

impl Default for Options {
    fn default() -> Self {
        Self { grid: 256, samples: 100_000, seed: 0, tolerance: None }
    }
}

/// What two solids have in common.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Comparison {
    /// The volume in common over that of the union; 1 when alike.
    pub iou: f64,
    /// The larger of the two largest distances, over `diagonal`.
    pub hausdorff: f64,
    /// The mean of the two mean distances, over `diagonal`.
    pub chamfer: f64,
    /// From the mesh to the reference, over `diagonal`.
    pub to_reference: Distance,
    /// From the reference to the mesh, over `diagonal`.
    pub from_reference: Distance,
    /// The mesh's volume over the reference's.
    pub volume_ratio: f64,
    /// The mesh's area over the reference's.
    pub area_ratio: f64,
    /// The diagonal of the reference's box, in world units.
    pub diagonal: f64,
    /// What makes these figures doubtful.
    pub warnings: Vec<String>,
}

/// From one surface to the other.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Distance {
    /// The largest, from vertices and drawn points.
    pub max: f64,
    /// The mean over the surface, from evenly drawn points.
    pub mean: f64,
}

impl Comparison {
    /// The figures over the diagonal of the reference's box.
    fn new(agreement: &Agreement, diagonal: f64, warnings: Vec<String>) -> Self {
        let distance = |lengths: Lengths| Distance {
            max: lengths.max / diagonal,
            mean: lengths.mean / diagonal,
        };
        let to_reference = distance(agreement.to_reference);
        let from_reference = distance(agreement.from_reference);
        let ratio = |[own, reference]: [f64; 2]| own / reference;
        Self {
            iou: agreement.iou,
            hausdorff: to_reference.max.max(from_reference.max),
            chamfer: 0.5 * (to_reference.mean + from_reference.mean),
            to_reference,
            from_reference,
            volume_ratio: ratio(agreement.volumes),
            area_ratio: ratio(agreement.areas),
            diagonal,
            warnings,
        }
    }
}

/// Compares a mesh with a reference in the same frame. A network of several materials counts as
/// the union of them all.
///
/// # Errors
/// When one of them has no surface around its materials, or the reference no
/// volume.
pub fn compare(
    mesh: &Mesh,
    reference: &Mesh,
    options: &Options,
    progress: &dyn Progress,
) -> Result<Comparison> {
    let steps = Steps::new("compare", 1, progress);
    let mut warnings = Vec::new();
    let mut solids = [
        Solid::of_materials(mesh, "mesh", &mut warnings)?,
        Solid::of_materials(reference, "reference", &mut warnings)?,
    ];
    let found = agreement(&mut solids, None, options, &steps.part(0), &mut warnings)?;
    Ok(Comparison::new(&found, solids[1].bounds.diagonal(), warnings))
}

#[cfg(test)]
mod tests {
    use glam::DVec3;

    use super::*;
    use crate::mesh::shapes::solid;
    use crate::progress::Silent;

    fn ball(radius: f64, center: DVec3) -> Mesh {
        solid(61, 1.0, |point| radius - (point - center).length())
    }

    fn figures(mesh: &Mesh, reference: &Mesh) -> Comparison {
        let options = Options { samples: 20_000, ..Options::default() };
        compare(mesh, reference, &options, &Silent).unwrap()
    }

    #[test]
    fn a_solid_is_like_itself() {
        let ball = ball(0.7, DVec3::splat(0.01));
        let found = figures(&ball, &ball);
        assert_eq!((found.iou, found.volume_ratio, found.area_ratio), (1.0, 1.0, 1.0));
        assert!(found.hausdorff < 1e-12 && found.chamfer < 1e-12 && found.warnings.is_empty());
    }

    #[test]
    fn concentric_balls() {
        let found = figures(&ball(0.4, DVec3::ZERO), &ball(0.8, DVec3::ZERO));
        assert!((found.iou - 0.125).abs() < 2e-3, "{}", found.iou);
        assert!((found.volume_ratio - 0.125).abs() < 2e-3);
        assert!((found.area_ratio - 0.25).abs() < 2e-3);
        // Everywhere 0.4 apart, and the box's diagonal is 1.6 √3.
        let apart = 0.4 / (1.6 * 3f64.sqrt());
        for figure in [found.hausdorff, found.chamfer, found.to_reference.mean] {
            assert!((figure - apart).abs() < 2e-3, "{figure} {apart}");
        }
    }

    #[test]
    fn shifted_balls() {
        // Two balls of radius r at distance d have in common
        // π (2r − d)² (d² + 4dr) / (12 d).
        let (r, d) = (0.5f64, 0.4f64);
        let found = figures(&ball(r, -0.2 * DVec3::X), &ball(r, 0.2 * DVec3::X));
        let common =
            std::f64::consts::PI * (2.0 * r - d).powi(2) * (d * d + 4.0 * d * r) / (12.0 * d);
        let union = 8.0 / 3.0 * std::f64::consts::PI * r.powi(3) - common;
        assert!((found.iou - common / union).abs() < 3e-3, "{}", found.iou);
        // The far poles are d apart.
        assert!((found.hausdorff * found.diagonal - d).abs() < 2e-3);
    }

    /// Inside is what a surface winds around, whichever way round and how often.
    #[test]
    fn overlapping_and_turned_surfaces_count_once() {
        let (whole, inner) = (ball(0.7, DVec3::ZERO), ball(0.35, DVec3::ZERO));
        let both = |one: &Mesh, other: &Mesh| {
            let first = one.vertices.len() as u32;
            let moved = other.triangles.iter().map(|triangle| triangle.map(|at| at + first));
            Mesh {
                vertices: [&one.vertices[..], &other.vertices].concat(),
                triangles: one.triangles.iter().copied().chain(moved).collect(),
                sides: [&one.sides[..], &other.sides].concat(),
            }
        };
        let mut turned = whole.clone();
        turned.triangles.iter_mut().for_each(|triangle| triangle.swap(0, 1));
        for (mesh, word) in [
            (both(&whole, &whole), "overlaps itself in 100.00 %"),
            (both(&whole, &inner), "overlaps itself in 12."),
            (turned, "faces inward"),
        ] {
            let found = figures(&mesh, &whole);
            assert_eq!(found.iou, 1.0, "{word}");
            assert!((found.volume_ratio - 1.0).abs() < 1e-3, "{}", found.volume_ratio);
            assert!(matches!(&found.warnings[..], [only] if only.contains(word)), "{found:?}");
        }
    }

    #[test]
    fn holes_are_told() {
        let whole = ball(0.7, DVec3::ZERO);
        let mut open = whole.clone();
        // Without its cap at the upper pole.
        open.triangles.retain(|&[a, _, _]| whole.vertices[a as usize].z < 0.6);
        open.sides.truncate(open.triangles.len());
        let found = figures(&open, &whole);
        assert_eq!(found.warnings.len(), 2, "{:?}", found.warnings);
        assert!(compare(&Mesh::default(), &whole, &Options::default(), &Silent).is_err());
    }
}
