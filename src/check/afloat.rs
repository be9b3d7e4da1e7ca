//! Pieces of a solid that hang in the air: no section shows them.

use rayon::prelude::*;
use serde::Serialize;

use super::components::{Components, Part};
use super::raster::Raster;
use crate::label::Label;
use crate::section::Section;

/// A connected piece of a label that no section has a region of.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Piece {
    /// Its nodes times a voxel, in cubic world units.
    pub volume: f64,
    /// A place in it.
    pub at: [f64; 3],
}

/// How many pieces are listed.
const LISTED: usize = 8;

/// The pieces of a label that hang in the air.
#[derive(Debug, Clone, Default, PartialEq, Serialize)]
pub struct Afloat {
    /// How many there are.
    pub pieces: usize,
    /// All together, in cubic world units.
    pub volume: f64,
    /// The largest of them, at most eight.
    pub largest: Vec<Piece>,
}

/// The pieces of each label that hang in the air. `labels` are sorted; `whole`
/// are the solid's parts; `voxel` in world units.
pub fn afloat(
    sections: &[Section],
    rasters: &[Raster],
    whole: &Components,
    labels: &[Label],
    voxel: f64,
) -> Vec<Afloat> {
    let shown: Vec<Vec<u32>> = (sections.par_iter().zip(rasters))
        .map(|(section, raster)| shown_parts(section, raster, whole, voxel))
        .collect();
    let mut is_shown = vec![false; whole.count()];
    shown.into_iter().flatten().for_each(|part| is_shown[part as usize] = true);
    let mut found = vec![Afloat::default(); labels.len()];
    for (Part { label, nodes, at }, is_shown) in whole.parts().into_iter().zip(is_shown) {
        let Ok(own) = labels.binary_search(&label) else { continue };
        if !is_shown {
            let volume = nodes as f64 * voxel.powi(3);
            found[own].add(Piece { volume, at: at.to_array() });
        }
    }
    found
}

/// The parts of which a section has a piece of a region.
fn shown_parts(section: &Section, raster: &Raster, whole: &Components, voxel: f64) -> Vec<u32> {
    let mut parts = Vec::new();
    let mut show = |label: Label, point| {
        for (kind, part) in whole.around(point) {
            if kind.label == label && parts.last() != Some(&part) {
                parts.push(part);
            }
        }
    };
    raster.pixels().for_each(|(_, label, point)| show(label, point));
    // What is narrower than a pixel may have none.
    for edge in section.edges() {
        let [start, end] = [edge.start, edge.end].map(|vertex| section.point(vertex));
        let steps = (start.distance(end) / voxel).ceil().max(1.0);
        for step in 0..=steps as u32 {
            let point = start.lerp(end, f64::from(step) / steps);
            [edge.left, edge.right].into_iter().for_each(|label| show(label, point));
        }
    }
    parts
}

impl Afloat {
    fn add(&mut self, piece: Piece) {
        self.pieces += 1;
        self.volume += piece.volume;
        // Of equals the first stays in front.
        let place = self.largest.partition_point(|other| other.volume >= piece.volume);
        self.largest.insert(place, piece);
        self.largest.truncate(LISTED);
    }
}

#[cfg(test)]
mod tests {
    use glam::DVec3;

    use super::*;
    use crate::check::shapes::disc;
    use crate::grid::labels::LabelGrid;
    use crate::grid::samples::Lattice;
    use crate::mesh::shapes::samples;
    use crate::plane::Plane;

    #[test]
    fn a_ball_between_sections_hangs_in_the_air() {
        // Two balls of radius 0.3; the planes pass z = −0.4 and x = 0.
        let at = [DVec3::new(0.0, 0.0, -0.5), DVec3::new(0.5, 0.5, 0.4)];
        let voxel = 0.05;
        let lattice = Lattice { origin: DVec3::splat(-1.0), voxel, dims: [41; 3] };
        let inside = |point: DVec3| at.iter().any(|&at| (point - at).length() < 0.3);
        let value = |node| vec![if inside(lattice.position(node)) { 0.5 } else { -0.5 }];
        let whole = Components::whole(&LabelGrid::new(&samples(lattice, value)));
        let found = |label| {
            let sections = [
                disc(Plane { normal: DVec3::Z, offset: -0.4 }, 0.28, 60, label),
                disc(Plane { normal: DVec3::X, offset: 0.0 }, 0.01, 60, label),
            ];
            let raster = |section: &Section| {
                Raster::new(section, section.plane().unit_normal(), lattice.origin, voxel)
            };
            let rasters: Vec<Raster> = sections.iter().map(raster).collect();
            afloat(&sections, &rasters, &whole, &[Label(1), Label(2)], voxel)
        };
        let [one, two] = &found(Label(1))[..] else { panic!("two labels") };
        let [piece] = &one.largest[..] else { panic!("{one:?}") };
        let volume = 4.0 / 3.0 * std::f64::consts::PI * 0.027;
        assert!((piece.volume / volume - 1.0).abs() < 0.05, "{}", piece.volume);
        assert!((DVec3::from(piece.at) - at[1]).length() < 0.2);
        assert_eq!((one.pieces, one.volume), (1, piece.volume));
        assert_eq!(two, &Afloat::default());
        // Sections of another label show neither.
        assert_eq!(found(Label(2))[0].pieces, 2);
    }
}
