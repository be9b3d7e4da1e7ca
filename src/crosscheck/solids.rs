//! What each label's surface is like in each of the meshes.

use rayon::prelude::*;
use serde::Serialize;

use crate::error::Result;
use crate::label::Label;
use crate::mesh::Mesh;

/// One label's surface in one mesh.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Solid {
    /// Whether every edge is passed as often one way as the other.
    pub closed: bool,
    /// Whether every edge has two triangles at most. Bodies may touch along an
    /// edge; each then has a sheet of its own there.
    pub manifold: bool,
    /// Cubic world units.
    pub volume: f64,
    /// Square world units.
    pub area: f64,
    /// Connected pieces, cavities included.
    pub components: usize,
    /// Handles of all pieces together; none where the surface is not closed.
    pub genus: Option<i64>,
    /// How many.
    pub triangles: usize,
}

/// One label's surface in all meshes; without triangles where it does not
/// occur.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct LabelSolids {
    /// The label.
    pub label: u32,
    /// The field by the dual mesher.
    pub dual: Solid,
    /// The field by the delaunay mesher, if it was asked for.
    pub delaunay: Option<Solid>,
    /// The skeleton.
    pub skeleton: Solid,
    /// The volume of `dual` less that of `skeleton`, over the latter; none where
    /// that has no volume.
    pub volume_difference: Option<f64>,
}

/// Measures the surface of every label that occurs.
///
/// # Errors
/// When measuring fails.
pub fn solids(dual: &Mesh, delaunay: Option<&Mesh>, skeleton: &Mesh) -> Result<Vec<LabelSolids>> {
    let meshes = [Some(dual), delaunay, Some(skeleton)];
    let mut labels: Vec<Label> = meshes.iter().flatten().flat_map(|mesh| mesh.labels()).collect();
    labels.sort_unstable();
    labels.dedup();
    let measure = |&label: &Label| {
        let (dual, skeleton) = (Solid::new(dual, label)?, Solid::new(skeleton, label)?);
        let difference = (dual.volume - skeleton.volume) / skeleton.volume;
        Ok(LabelSolids {
            label: label.0,
            dual,
            delaunay: delaunay.map(|mesh| Solid::new(mesh, label)).transpose()?,
            volume_difference: difference.is_finite().then_some(difference),
            skeleton,
        })
    };
    labels.par_iter().map(measure).collect()
}

impl Solid {
    /// Of one label.
    ///
    /// # Errors
    /// When measuring fails.
    pub fn new(mesh: &Mesh, label: Label) -> Result<Self> {
        Self::within(mesh, |side| side == label)
    }

    /// Of the union of some labels.
    ///
    /// # Errors
    /// When measuring fails.
    pub fn within(mesh: &Mesh, inside: impl Fn(Label) -> bool + Sync) -> Result<Self> {
        let surface = mesh.surface_of(&inside);
        let facts = surface.facts(false)?;
        let edges = Edges::new(&mesh.triangles_around(inside));
        Ok(Self {
            closed: edges.balanced,
            manifold: edges.manifold,
            volume: surface.volume(),
            area: surface.area(),
            components: facts.components,
            genus: facts.closed.then_some(facts.genus),
            triangles: facts.triangles,
        })
    }
}

/// What holds for all edges of some triangles.
struct Edges {
    balanced: bool,
    manifold: bool,
}

impl Edges {
    fn new(triangles: &[[u32; 3]]) -> Self {
        // Every edge by its ends in ascending order, and whether it is passed
        // downward.
        let mut sides: Vec<([u32; 2], bool)> = (triangles.par_iter())
            .flat_map_iter(|&[a, b, c]| [[a, b], [b, c], [c, a]])
            .map(|[start, end]| ([start.min(end), start.max(end)], start > end))
            .collect();
        sides.par_sort_unstable();
        let mut edges = Self { balanced: true, manifold: true };
        for passed in sides.chunk_by(|one, other| one.0 == other.0) {
            let down = passed.iter().filter(|(_, down)| *down).count();
            edges.balanced &= 2 * down == passed.len();
            edges.manifold &= passed.len() <= 2;
        }
        edges
    }
}

#[cfg(test)]
mod tests {
    use glam::DVec3;

    use super::*;

    /// A tetrahedron on an edge, and another on the same edge opposite to it.
    fn touching(both: bool) -> Mesh {
        let (x, y) = (DVec3::X, DVec3::Y);
        let vertices = vec![DVec3::ZERO, DVec3::Z, x - y, x + y, y - x, -x - y];
        let faces = |[a, b, c, d]: [u32; 4]| [[a, c, b], [a, b, d], [b, c, d], [a, d, c]];
        let mut triangles = faces([0, 1, 2, 3]).to_vec();
        if both {
            triangles.extend(faces([0, 1, 4, 5]));
        }
        let sides = vec![[Label(1), Label::OUTSIDE]; triangles.len()];
        Mesh { vertices, triangles, sides }
    }

    #[test]
    fn four_triangles_at_an_edge_are_closed_and_not_manifold() {
        let solid = |both| Solid::new(&touching(both), Label(1)).unwrap();
        let (one, two) = (solid(false), solid(true));
        assert_eq!((one.closed, one.manifold, one.genus), (true, true, Some(0)));
        assert_eq!((two.closed, two.manifold, two.genus), (true, false, Some(0)));
        assert_eq!((one.components, two.components), (1, 2));
        // |z · ((1, 1) × (1, −1))| / 6.
        assert!((one.volume - 1.0 / 3.0).abs() < 1e-15, "{}", one.volume);
        assert!((two.volume - 2.0 * one.volume).abs() < 1e-15, "{}", two.volume);
    }
}
