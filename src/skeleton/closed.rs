//! Whether the surfaces of all cells fit together, looked at before anything is done to them.

use std::collections::HashMap;

use glam::DVec3;

use crate::error::{Error, Result};
use crate::label::Label;

use super::Skeleton;

/// Looks at every edge of every label's boundary.
///
/// # Errors
/// Where an edge is not met equally often from both ends, with the label, the place and a
/// cell that has a triangle there. That is a bug.
pub(super) fn require_closed(skeleton: &Skeleton) -> Result<()> {
    let mesh = &skeleton.mesh;
    let mut turns: HashMap<(u32, u32, Label), (i32, usize)> = HashMap::new();
    for (triangle, (corners, sides)) in mesh.triangles.iter().zip(&mesh.sides).enumerate() {
        for (label, way) in [(sides[0], 1), (sides[1], -1)] {
            if label == Label::OUTSIDE {
                continue;
            }
            for i in 0..3 {
                let (from, to) = (corners[i], corners[(i + 1) % 3]);
                let way = if from < to { way } else { -way };
                let ends = (from.min(to), from.max(to), label);
                let turn = turns.entry(ends).or_insert((0, triangle));
                turn.0 += way;
            }
        }
    }
    let open = turns.into_iter().filter(|&(_, (turn, _))| turn != 0);
    let Some(((from, to, label), (_, triangle))) = open.min_by_key(|&(edge, _)| edge) else {
        return Ok(());
    };
    let place = |vertex: u32| -> DVec3 { mesh.vertices[vertex as usize] };
    let DVec3 { x, y, z } = place(from).midpoint(place(to));
    let cell = skeleton.details.origins[triangle].cell;
    let what = format!("label {label} is not closed at ({x}, {y}, {z}), in cell {cell}");
    Err(Error::Bug { stage: "skeleton", what })
}

#[cfg(test)]
mod tests {
    use super::super::{Details, Kind, Origin};
    use super::*;
    use crate::mesh::Mesh;

    /// Tetrahedra of labels 1 and 2 with a common face, each in a cell of its own.
    fn pair() -> Skeleton {
        let corners = [[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1], [1, 1, 1]];
        let vertices =
            corners.map(|[x, y, z]| DVec3::new(f64::from(x), f64::from(y), f64::from(z)));
        let outer = [[0, 2, 1], [0, 1, 3], [0, 3, 2], [4, 3, 1], [4, 2, 3], [4, 1, 2]];
        let mut triangles = outer.to_vec();
        triangles.push([1, 2, 3]);
        let label = |index: usize| Label(1 + u32::from(index > 2));
        let mut sides: Vec<_> = (0..6).map(|index| [label(index), Label::OUTSIDE]).collect();
        sides.push([Label(1), Label(2)]);
        let origin = |cell| Origin { kind: Kind::Roof, sections: [None; 2], cell };
        let origins = (0..7).map(|index| origin(u32::from(index > 2))).collect();
        let mesh = Mesh { vertices: vertices.to_vec(), triangles, sides };
        Skeleton { mesh, details: Details { origins, ..Details::default() } }
    }

    #[test]
    fn an_open_edge_is_named() {
        let mut skeleton = pair();
        require_closed(&skeleton).expect("two solids");
        skeleton.mesh.triangles.remove(5);
        skeleton.mesh.sides.remove(5);
        skeleton.details.origins.remove(5);
        let error = require_closed(&skeleton).expect_err("a hole").to_string();
        assert!(error.contains("label 2 is not closed at (0.5, 0.5, 0), in cell 1"), "{error}");
    }

    #[test]
    fn a_turned_triangle_is_no_boundary() {
        let mut skeleton = pair();
        skeleton.mesh.sides[6].reverse();
        require_closed(&skeleton).expect_err("a common face turned round");
    }
}
