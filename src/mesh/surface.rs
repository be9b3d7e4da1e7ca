//! The closed surface of one label, or of several labels together, out of a
//! network.

use glam::DVec3;
use rayon::prelude::*;

use super::sheets::{Sheets, Side, corners_of, starts_at};
use super::{Mesh, Surface};
use crate::label::Label;

impl Mesh {
    /// The boundary of one label, oriented outward. Where its sheets touch in
    /// a vertex, each fan gets a vertex of its own.
    pub fn surface(&self, label: Label) -> Surface {
        self.surface_of(|side| side == label)
    }

    /// The boundary of the union of all labels that `inside` says yes to.
    pub fn surface_of(&self, inside: impl Fn(Label) -> bool + Sync) -> Surface {
        let triangles = self.triangles_around(inside);
        let sides = sorted_sides(&triangles);
        let Sheets { mut corners, .. } = Sheets::new(self, &triangles, &sides);
        // One vertex for each set of joined corners, in the order of the first.
        let mut number = vec![u32::MAX; 3 * triangles.len()];
        let mut surface = Surface::default();
        surface.triangles.reserve(triangles.len());
        for (triangle, vertices) in triangles.iter().enumerate() {
            surface.triangles.push(std::array::from_fn(|corner| {
                let root = corners.root((3 * triangle + corner) as u32) as usize;
                if number[root] == u32::MAX {
                    number[root] = surface.vertices.len() as u32;
                    surface.vertices.push(self.vertices[vertices[corner] as usize]);
                }
                number[root]
            }));
        }
        surface
    }

    /// The edges where two sheets of one label's surface, or of that of all materials
    /// together, touch and that end for both in the same vertices: whatever order the
    /// triangles there are paired in, the surface has four at that edge. Divided in the
    /// middle, where each sheet gets a vertex of its own, the edge becomes two for each.
    pub fn tied_edges(&self) -> Vec<[u32; 2]> {
        let mut found = self.tied_around(Label::is_material);
        for label in self.labels() {
            found.extend(self.tied_around(|side| side == label));
        }
        found.sort_unstable();
        found.dedup();
        found
    }

    fn tied_around(&self, inside: impl Fn(Label) -> bool + Sync) -> Vec<[u32; 2]> {
        let triangles = self.triangles_around(inside);
        let sides = sorted_sides(&triangles);
        let Sheets { mut corners, touching } = Sheets::new(self, &triangles, &sides);
        let mut is_tied = |sheets: &[[&Side; 2]]| {
            let ends_of = |[one, _]: &[&Side; 2]| {
                corners_of(&triangles, one).map(|corner| corners.root(corner))
            };
            let mut ends: Vec<_> = sheets.iter().map(ends_of).collect();
            ends.sort_unstable();
            ends.dedup();
            ends.len() < sheets.len()
        };
        let tied = touching.iter().filter(|sheets| is_tied(sheets));
        tied.map(|sheets| sheets[0][0].0).collect()
    }

    /// The triangles around the union of all labels that `inside` says yes
    /// to, oriented outward.
    pub fn triangles_around(&self, inside: impl Fn(Label) -> bool + Sync) -> Vec<[u32; 3]> {
        self.triangles
            .par_iter()
            .zip(&self.sides)
            .filter_map(|(&[a, b, c], &[back, front])| match (inside(back), inside(front)) {
                (true, false) => Some([a, b, c]),
                (false, true) => Some([a, c, b]),
                _ => None,
            })
            .collect()
    }
}

impl Surface {
    /// The middle of the first edge that has not one triangle each way; `None` where the
    /// surface is closed.
    pub fn first_gap(&self) -> Option<DVec3> {
        let sides = sorted_sides(&self.triangles);
        let is_whole = |same: &[Side]| match same {
            [one, other] => starts_at(&self.triangles, one) != starts_at(&self.triangles, other),
            _ => false,
        };
        let mut edges = sides.chunk_by(|one, other| one.0 == other.0);
        let [start, end] = edges.find(|same| !is_whole(same))?[0].0;
        Some(self.vertices[start as usize].midpoint(self.vertices[end as usize]))
    }

    /// The edges of one triangle alone, by their vertices: where the surface is
    /// open.
    pub fn open_edges(&self) -> Vec<[u32; 2]> {
        let sides = sorted_sides(&self.triangles);
        let alone = |same: &[Side]| (same.len() == 1).then(|| same[0].0);
        sides.chunk_by(|one, other| one.0 == other.0).filter_map(alone).collect()
    }
}

/// The edges of all triangles, those between the same vertices together.
pub(super) fn sorted_sides(triangles: &[[u32; 3]]) -> Vec<Side> {
    let mut sides: Vec<Side> = triangles
        .par_iter()
        .enumerate()
        .flat_map_iter(|(index, triangle)| {
            (0..3u8).map(move |corner| {
                let [start, end] = [corner, (corner + 1) % 3].map(|at| triangle[usize::from(at)]);
                ([start.min(end), start.max(end)], index as u32, corner)
            })
        })
        .collect();
    sides.par_sort_unstable();
    sides
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Two tetrahedra of one label that share the vertex at the origin.
    fn touching_tetrahedra() -> Mesh {
        let mut mesh = Mesh { vertices: vec![DVec3::ZERO], ..Mesh::default() };
        for sign in [1.0, -1.0] {
            let first = mesh.vertices.len() as u32;
            mesh.vertices.extend([DVec3::X, DVec3::Y, DVec3::Z].map(|axis| sign * axis));
            let (x, y, z) = (first, first + 1, first + 2);
            let outward = [[0, y, x], [0, z, y], [0, x, z], [x, y, z]];
            mesh.triangles.extend(outward.map(|[a, b, c]| {
                // The mirrored tetrahedron turns its triangles round.
                if sign > 0.0 { [a, b, c] } else { [a, c, b] }
            }));
        }
        mesh.sides = vec![[Label(1), Label::OUTSIDE]; mesh.triangles.len()];
        mesh
    }

    #[test]
    fn a_shared_vertex_becomes_one_per_fan() {
        let surface = touching_tetrahedra().surface(Label(1));
        assert_eq!(surface.vertices.len(), 8);
        assert_eq!(surface.triangles.len(), 8);
        assert!((surface.volume() - 2.0 / 6.0).abs() < 1e-15);
    }

    /// Two tetrahedra of one label that share the edge from the origin to X.
    #[test]
    fn bodies_that_touch_along_an_edge_get_a_sheet_each() {
        let mut mesh = Mesh { vertices: vec![DVec3::ZERO, DVec3::X], ..Mesh::default() };
        for sign in [1.0, -1.0] {
            let first = mesh.vertices.len() as u32;
            mesh.vertices.extend([sign * DVec3::Y, sign * DVec3::Z]);
            let (y, z) = (first, first + 1);
            // The half turn around x keeps the orientation.
            mesh.triangles.extend([[0, y, 1], [0, z, y], [0, 1, z], [1, y, z]]);
        }
        mesh.sides = vec![[Label(1), Label::OUTSIDE]; mesh.triangles.len()];
        let surface = mesh.surface(Label(1));
        assert_eq!(surface.vertices.len(), 8);
        assert!(surface.open_edges().is_empty());
        let facts = surface.facts(false).expect("facts");
        assert!(facts.outward);
        assert_eq!((facts.components, facts.genus), (2, 0));
        assert!((facts.volume - 2.0 / 6.0).abs() < 1e-15);
        // What is outside is one piece with an edge that it touches itself at.
        assert!(mesh.surface(Label::OUTSIDE).open_edges().is_empty());
    }

    /// Two slabs of two by two cubes with two columns between them that touch in an edge.
    fn slabs_and_columns() -> Mesh {
        let is_full = |[x, y, z]: [i32; 3]| {
            (0..2).contains(&x) && (0..2).contains(&y) && (0..3).contains(&z) && (z != 1 || x == y)
        };
        let number = |[x, y, z]: [i32; 3]| (x * 3 + y) * 4 + z;
        let mut mesh = Mesh::default();
        for at in 0..36 {
            let place = [at / 12, at / 4 % 3, at % 4].map(f64::from);
            mesh.vertices.push(DVec3::from(place));
        }
        for at in 0..12 {
            let cube = [at / 6, at / 3 % 2, at % 3];
            if !is_full(cube) {
                continue;
            }
            for (axis, step) in [(0, -1), (0, 1), (1, -1), (1, 1), (2, -1), (2, 1)] {
                let mut beyond = cube;
                beyond[axis] += step;
                if is_full(beyond) {
                    continue;
                }
                let corner = |u: i32, v: i32| {
                    let mut corner = cube;
                    corner[axis] += i32::from(step > 0);
                    corner[(axis + 1) % 3] += u;
                    corner[(axis + 2) % 3] += v;
                    number(corner) as u32
                };
                let [a, b, c, d] = [corner(0, 0), corner(1, 0), corner(1, 1), corner(0, 1)];
                let [b, d] = if step > 0 { [b, d] } else { [d, b] };
                mesh.triangles.extend([[a, b, c], [a, c, d]]);
            }
        }
        mesh.sides = vec![[Label(1), Label::OUTSIDE]; mesh.triangles.len()];
        mesh
    }

    /// Divides the triangles at an edge at a place.
    fn divide(mesh: &mut Mesh, [start, end]: [u32; 2], place: DVec3) {
        let middle = mesh.vertices.len() as u32;
        mesh.vertices.push(place);
        for index in 0..mesh.triangles.len() {
            let triangle = mesh.triangles[index];
            let at = (0..3).find(|&at| {
                let ends = [triangle[at], triangle[(at + 1) % 3]];
                ends == [start, end] || ends == [end, start]
            });
            let Some(at) = at else { continue };
            let [from, to, apex] = [0, 1, 2].map(|step| triangle[(at + step) % 3]);
            mesh.triangles[index] = [from, middle, apex];
            mesh.triangles.push([middle, to, apex]);
            mesh.sides.push(mesh.sides[index]);
        }
    }

    /// Angles at the halves are different when their common end is beside the edge, as it
    /// is for rounding.
    #[test]
    fn halves_of_an_edge_are_paired_alike() {
        for (x, y) in [(0.5, 1.0), (1.5, 1.75)] {
            let mut mesh = slabs_and_columns();
            divide(&mut mesh, [17, 18], DVec3::new(x, y, 1.5));
            assert!(mesh.tied_edges().is_empty(), "{x}, {y}");
            assert!(mesh.surface(Label(1)).facts(false).expect("facts").closed, "{x}, {y}");
        }
    }

    #[test]
    fn a_tied_edge_is_found_and_comes_apart_when_divided() {
        let mut mesh = slabs_and_columns();
        assert!(!mesh.surface(Label(1)).facts(false).expect("facts").closed);
        // From (1, 1, 1) to (1, 1, 2).
        let tied = [17, 18];
        assert_eq!(mesh.tied_edges(), [tied]);
        divide(&mut mesh, tied, DVec3::new(1.0, 1.0, 1.5));
        assert!(mesh.tied_edges().is_empty());
        let facts = mesh.surface(Label(1)).facts(false).expect("facts");
        assert!(facts.closed && facts.outward, "{facts:?}");
        assert_eq!((facts.components, facts.genus), (1, 1));
        assert!((facts.volume - 10.0).abs() < 1e-12);
        // Two bodies that touch in a vertex share no edge.
        assert!(touching_tetrahedra().tied_edges().is_empty());
    }

    #[test]
    fn the_front_label_sees_the_triangles_reversed() {
        let mut mesh = touching_tetrahedra();
        mesh.sides = vec![[Label(1), Label(2)]; mesh.triangles.len()];
        assert!((mesh.surface(Label(2)).volume() + 2.0 / 6.0).abs() < 1e-15);
        let union = mesh.surface_of(|label| label.is_material());
        assert!(union.triangles.is_empty());
        assert_eq!(mesh.labels(), [Label(1), Label(2)]);
    }
}
