//! Pieces of a label that hang in the air: no section passes through them.

use glam::DVec3;
use serde::Serialize;

use crate::mesh::Surface;
use crate::section::Section;
use crate::sets::Sets;

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

/// A connected piece of a surface that no section's plane passes through.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Piece {
    /// In cubic world units.
    pub volume: f64,
    /// The middle of its vertices.
    pub at: [f64; 3],
}

impl Afloat {
    /// Of a label's surface. Cavities are no pieces.
    pub fn new(surface: &Surface, sections: &[Section]) -> Self {
        let mut own = Self::default();
        for triangles in pieces(surface) {
            if !is_passed(surface, &triangles, sections) {
                let piece = measured(surface, &triangles);
                if piece.volume > 0.0 {
                    own.add(piece);
                }
            }
        }
        own
    }

    fn add(&mut self, piece: Piece) {
        self.pieces += 1;
        self.volume += piece.volume;
        // Of equals the first stays in front.
        let place = self.largest.partition_point(|other| other.volume >= piece.volume);
        self.largest.insert(place, piece);
        self.largest.truncate(LISTED);
    }
}

/// The triangles of each connected piece.
fn pieces(surface: &Surface) -> Vec<Vec<u32>> {
    let mut sets = Sets::new(surface.vertices.len());
    for &[a, b, c] in &surface.triangles {
        sets.join(a, b);
        sets.join(b, c);
    }
    let mut number = vec![u32::MAX; surface.vertices.len()];
    let mut pieces: Vec<Vec<u32>> = Vec::new();
    for (triangle, corners) in surface.triangles.iter().enumerate() {
        let own = &mut number[sets.root(corners[0]) as usize];
        if *own == u32::MAX {
            *own = pieces.len() as u32;
            pieces.push(Vec::new());
        }
        pieces[*own as usize].push(triangle as u32);
    }
    pieces
}

/// Whether a piece has vertices on both sides of a section's plane, or on it.
fn is_passed(surface: &Surface, triangles: &[u32], sections: &[Section]) -> bool {
    sections.iter().any(|section| {
        let mut sides = [false; 2];
        triangles.iter().any(|&triangle| {
            for corner in surface.corners(triangle as usize) {
                let height = section.plane().distance(corner);
                sides = [sides[0] || height <= 0.0, sides[1] || height >= 0.0];
            }
            sides == [true; 2]
        })
    })
}

fn measured(surface: &Surface, triangles: &[u32]) -> Piece {
    let corners: Vec<[DVec3; 3]> =
        triangles.iter().map(|&triangle| surface.corners(triangle as usize)).collect();
    let middle = corners.iter().flatten().sum::<DVec3>() / (3 * corners.len()) as f64;
    let cone = |corners: &[DVec3; 3]| {
        let [a, b, c] = corners.map(|corner| corner - middle);
        a.dot(b.cross(c)) / 6.0
    };
    Piece { volume: corners.iter().map(cone).sum(), at: middle.to_array() }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::check::shapes::section;
    use crate::label::Label;
    use crate::mesh::shapes::solid;
    use crate::plane::Plane;

    fn plane(normal: DVec3, offset: f64) -> Section {
        section(Plane { normal, offset }, &[], Label::OUTSIDE)
    }

    #[test]
    fn a_ball_between_sections_hangs_in_the_air() {
        // Two balls of radius 0.3; planes pass z = −0.4, through the first, and
        // x = 0, or x = 0.3, which passes through the second, too.
        let at = [DVec3::new(0.0, 0.0, -0.5), DVec3::new(0.5, 0.5, 0.4)];
        let balls = |point: DVec3| {
            let [one, other] = at.map(|at| 0.3 - (point - at).length());
            one.max(other)
        };
        let surface = solid(61, 1.0, balls).surface(Label(1));
        let floor = plane(DVec3::Z, -0.4);
        let found = Afloat::new(&surface, &[floor.clone(), plane(DVec3::X, 0.0)]);
        let [piece] = found.largest[..] else { panic!("{found:?}") };
        let volume = 4.0 / 3.0 * std::f64::consts::PI * 0.027;
        assert!((piece.volume / volume - 1.0).abs() < 0.02, "{}", piece.volume);
        assert!((DVec3::from(piece.at) - at[1]).length() < 0.01);
        assert_eq!((found.pieces, found.volume), (1, piece.volume));
        let passed = Afloat::new(&surface, &[floor, plane(DVec3::X, 0.3)]);
        assert_eq!(passed, Afloat::default());
        assert_eq!(Afloat::new(&surface, &[]).pieces, 2);
    }

    #[test]
    fn a_cavity_between_sections_is_no_piece() {
        // A shell between the radii 0.3 and 0.8; a plane passes between them.
        let shell = solid(61, 1.0, |point| 0.25 - (point.length() - 0.55).abs());
        let surface = shell.surface(Label(1));
        assert_eq!(Afloat::new(&surface, &[plane(DVec3::Z, 0.5)]), Afloat::default());
    }
}
