//! A network as bodies, for kinds of files that know no walls between labels.

use super::mesh::About;
use crate::label::Material;
use crate::mesh::{Mesh, Surface};

/// All of one label.
pub struct Body {
    pub material: Material,
    /// Closed, oriented outward; open where the network is.
    pub surface: Surface,
}

/// The body of every label that has triangles, by number.
pub fn bodies(mesh: &Mesh, about: &About) -> Vec<Body> {
    let body = |label| Body { material: about.material(label), surface: mesh.surface(label) };
    mesh.labels().into_iter().map(body).collect()
}

#[cfg(test)]
pub(super) mod tests {
    use glam::DVec3;

    use super::*;
    use crate::label::Label;

    /// Of [`two_tetrahedra`].
    pub fn materials() -> Vec<Material> {
        let given = [(1, "a <b>", [255, 128, 0]), (4, "c", [0, 0, 255])];
        given.map(|(id, name, color)| Material { id, name: name.to_owned(), color }).to_vec()
    }

    /// Two tetrahedra that share a wall, of labels 1 and 4.
    pub fn two_tetrahedra() -> Mesh {
        let (one, other, outside) = (Label(1), Label(4), Label::OUTSIDE);
        let vertices = vec![DVec3::ZERO, DVec3::X, DVec3::Y, DVec3::Z, -DVec3::Z];
        // The wall's normal is -z, from the one above to the one below.
        let triangles =
            vec![[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3], [0, 4, 1], [0, 2, 4], [1, 4, 2]];
        let mut sides = vec![[one, other]];
        sides.extend([[one, outside]; 3]);
        sides.extend([[other, outside]; 3]);
        Mesh { vertices, triangles, sides }
    }

    #[test]
    fn a_wall_belongs_to_the_bodies_on_both_sides() {
        let bodies = bodies(&two_tetrahedra(), &About::default());
        let labels: Vec<u32> = bodies.iter().map(|body| body.material.id).collect();
        assert_eq!(labels, [1, 4]);
        for Body { surface, .. } in &bodies {
            assert_eq!((surface.vertices.len(), surface.triangles.len()), (4, 4));
            assert_eq!(surface.first_gap(), None);
            assert!((surface.volume() - 1.0 / 6.0).abs() < 1e-15);
        }
    }
}
