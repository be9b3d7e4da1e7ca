//! A network cut into patches, each a manifold with a border: what hangs together across
//! edges of two triangles between the same two labels that need not stay. All other edges are
//! borders of patches: where these stay as they are, patches that change fit together.

use std::collections::BTreeMap;

use super::network::{Kind, Network};
use super::sheets::join_ends;
use crate::label::Label;
use crate::sets::Sets;

/// A patch with vertices of its own: where the network's surface touches itself
/// in a vertex, a patch has one for each fan.
pub struct Piece {
    /// The labels behind it and in front of it.
    pub sides: [Label; 2],
    /// Its number.
    pub patch: u32,
    /// For every vertex its number in the network.
    pub vertices: Vec<u32>,
    /// By its own vertices.
    pub triangles: Vec<[u32; 3]>,
}

impl Piece {
    /// Whether no two triangles pass an edge the same way.
    pub fn is_manifold(&self) -> bool {
        let edges = self.triangles.iter().flat_map(|&[a, b, c]| [[a, b], [b, c], [c, a]]);
        let mut edges: Vec<[u32; 2]> = edges.collect();
        edges.sort_unstable();
        edges.windows(2).all(|pair| pair[0] != pair[1])
            && edges.iter().all(|[start, end]| start != end)
    }
}

impl Network {
    /// All patches, in the order of their first triangles.
    pub fn pieces_of_patches(&self) -> Vec<Piece> {
        let count = self.mesh.triangles.len();
        let (mut corners, mut patches) = (Sets::new(3 * count), Sets::new(count));
        for sides in self.edges().iter() {
            if let ([one, other], Kind::Surface) = (sides, self.kind(sides)) {
                join_ends(&mut corners, one, other);
                patches.join(one.1, other.1);
            }
        }
        let mut members: BTreeMap<u32, Vec<u32>> = BTreeMap::new();
        for triangle in 0..count as u32 {
            members.entry(patches.root(triangle)).or_default().push(triangle);
        }
        members.into_values().map(|members| self.piece(&members, &mut corners)).collect()
    }

    fn piece(&self, members: &[u32], corners: &mut Sets) -> Piece {
        let mut numbers: BTreeMap<u32, u32> = BTreeMap::new();
        let first = members[0] as usize;
        let (sides, patch) = (self.mesh.sides[first], self.patches[first]);
        let mut piece = Piece { sides, patch, vertices: Vec::new(), triangles: Vec::new() };
        for &triangle in members {
            let vertices = self.mesh.triangles[triangle as usize];
            piece.triangles.push(std::array::from_fn(|corner| {
                *numbers.entry(corners.root(3 * triangle + corner as u32)).or_insert_with(|| {
                    piece.vertices.push(vertices[corner]);
                    piece.vertices.len() as u32 - 1
                })
            }));
        }
        piece
    }
}

/// The edges that only one triangle has, from start to end as it passes them, by
/// the names of their vertices.
pub fn border(triangles: &[u32], name: impl Fn(u32) -> u32) -> Vec<[u32; 2]> {
    let corners = triangles.chunks_exact(3);
    let mut edges: Vec<[u32; 2]> =
        corners.flat_map(|t| [[t[0], t[1]], [t[1], t[2]], [t[2], t[0]]]).collect();
    edges.sort_unstable();
    let alone = |[start, end]: &[u32; 2]| edges.binary_search(&[*end, *start]).is_err();
    let mut border: Vec<[u32; 2]> =
        edges.iter().filter(|edge| alone(edge)).map(|edge| edge.map(&name)).collect();
    border.sort_unstable();
    border
}
