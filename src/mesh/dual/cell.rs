//! One lattice cell: which of its edges belong to the same piece of interface.
//!
//! Notation. Corner `4 x + 2 y + z` of a cell has the offset (x, y, z). For an
//! axis d let u = d + 1 and v = d + 2 (modulo 3), so that (d, u, v) is
//! right-handed. Edge `4 d + 2 i + j` runs along d at offset i along u and j
//! along v. Face `2 d + s` is perpendicular to d at offset s along d; seen
//! from +d its corners and edges are
//!
//! ```text
//!   v   3 ── e2 ── 2
//!   ↑   e3         e1
//!   │   0 ── e0 ── 1
//!   └──→ u
//! ```

use crate::label::Label;

/// Offsets of the two corners of each edge, as corner numbers.
pub const EDGE_CORNERS: [[usize; 2]; 12] = edge_corners();
/// The corners 0 to 3 of each face, as corner numbers of the cell.
pub const FACE_CORNERS: [[usize; 4]; 6] = face_corners();
/// The edges e0 to e3 of each face, as edge numbers of the cell.
pub const FACE_EDGES: [[usize; 4]; 6] = face_edges();

/// What an offset of one along an axis adds to a corner's number.
const STEP: [usize; 3] = [4, 2, 1];

const fn edge_corners() -> [[usize; 2]; 12] {
    let mut corners = [[0; 2]; 12];
    let mut edge = 0;
    while edge < 12 {
        let axis = edge / 4;
        let low = STEP[(axis + 1) % 3] * (edge / 2 % 2) + STEP[(axis + 2) % 3] * (edge % 2);
        corners[edge] = [low, low + STEP[axis]];
        edge += 1;
    }
    corners
}

const fn face_corners() -> [[usize; 4]; 6] {
    let mut corners = [[0; 4]; 6];
    let mut face = 0;
    while face < 6 {
        let axis = face / 2;
        let low = STEP[axis] * (face % 2);
        let (u, v) = (STEP[(axis + 1) % 3], STEP[(axis + 2) % 3]);
        corners[face] = [low, low + u, low + u + v, low + v];
        face += 1;
    }
    corners
}

const fn face_edges() -> [[usize; 4]; 6] {
    let mut edges = [[0; 4]; 6];
    let mut face = 0;
    while face < 6 {
        let (axis, side) = (face / 2, face % 2);
        // For an edge along u, the other axes in order are (v, d); for one
        // along v they are (d, u).
        let (along_u, along_v) = (4 * ((axis + 1) % 3), 4 * ((axis + 2) % 3));
        edges[face] =
            [along_u + side, along_v + 2 * side + 1, along_u + 2 + side, along_v + 2 * side];
        face += 1;
    }
    edges
}

/// How the interface passes through a face: which of its edges between
/// different labels are joined.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Links {
    /// All of them.
    Together,
    /// e3 with e0 and e1 with e2: the corners 1 and 3 are connected across
    /// the face, and cut off 0 and 2.
    AroundEven,
    /// e0 with e1 and e2 with e3: the corners 0 and 2 are connected across
    /// the face, and cut off 1 and 3.
    AroundOdd,
}

impl Links {
    /// From the labels of a face's corners alone, save for the checkerboard
    /// of two labels, where `even_connected` is asked which of the two is
    /// connected. Both cells at the face come to the same answer.
    pub fn of(corners: [Label; 4], even_connected: impl FnOnce() -> bool) -> Self {
        let [a, b, c, d] = corners;
        let all_edges_differ = a != b && b != c && c != d && d != a;
        match (all_edges_differ, a == c, b == d) {
            (true, true, true) if even_connected() => Self::AroundOdd,
            (true, true, true) => Self::AroundEven,
            (true, true, false) => Self::AroundOdd,
            (true, false, true) => Self::AroundEven,
            _ => Self::Together,
        }
    }

    /// Which of the two pairs an edge e0 … e3 is in: the pair of e0 is 0.
    pub fn pair(self, edge: usize) -> usize {
        match self {
            Self::Together => 0,
            Self::AroundEven => usize::from(edge == 1 || edge == 2),
            Self::AroundOdd => usize::from(edge >= 2),
        }
    }

    /// The two pairs of edges of a face that does not join all.
    pub fn pairs(self) -> Option<[[usize; 2]; 2]> {
        match self {
            Self::Together => None,
            Self::AroundEven => Some([[0, 3], [1, 2]]),
            Self::AroundOdd => Some([[0, 1], [2, 3]]),
        }
    }
}

/// The connected pieces of interface in a cell.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Pieces {
    /// For each edge between different labels the piece it belongs to, from
    /// 0; [`Pieces::NONE`] for the others.
    pub of_edge: [u8; 12],
    /// How many.
    pub count: u8,
}

impl Pieces {
    /// An edge within one label.
    pub const NONE: u8 = u8::MAX;

    /// Joins the edges between different labels through the cell's faces.
    pub fn of(labels: &[Label; 8], links: &[Links; 6]) -> Self {
        let mut root: [u8; 12] = std::array::from_fn(|edge| {
            let [low, high] = EDGE_CORNERS[edge];
            if labels[low] == labels[high] { Self::NONE } else { edge as u8 }
        });
        for (edges, links) in FACE_EDGES.iter().zip(links) {
            let mut last_of_pair = [None; 2];
            for (place, &edge) in edges.iter().enumerate() {
                if root[edge] == Self::NONE {
                    continue;
                }
                let last = last_of_pair[links.pair(place)].replace(edge);
                if let Some(last) = last {
                    merge(&mut root, edge, last);
                }
            }
        }
        Self::numbered(root)
    }

    /// Numbers the sets by their first edges.
    fn numbered(root: [u8; 12]) -> Self {
        let mut pieces = Self { of_edge: [Self::NONE; 12], count: 0 };
        for edge in (0..12).filter(|&edge| root[edge] != Self::NONE) {
            let first = usize::from(root[edge]);
            if pieces.of_edge[first] == Self::NONE {
                pieces.of_edge[first] = pieces.count;
                pieces.count += 1;
            }
            pieces.of_edge[edge] = pieces.of_edge[first];
        }
        pieces
    }
}

/// Joins the sets of two edges. Every edge's root is the smallest edge of its
/// set.
fn merge(root: &mut [u8; 12], one: usize, other: usize) {
    let (from, to) = (root[one].max(root[other]), root[one].min(root[other]));
    for entry in root.iter_mut().filter(|entry| **entry == from) {
        *entry = to;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn face_edges_join_their_face_corners() {
        for face in 0..6 {
            for place in 0..4 {
                let ends = [FACE_CORNERS[face][place], FACE_CORNERS[face][(place + 1) % 4]];
                let mut corners = EDGE_CORNERS[FACE_EDGES[face][place]];
                if corners != ends {
                    corners.reverse();
                }
                assert_eq!(corners, ends, "face {face}, edge {place}");
            }
        }
    }

    #[test]
    fn a_lone_corner_makes_one_piece_of_three_edges() {
        let mut labels = [Label::OUTSIDE; 8];
        labels[5] = Label(1);
        let pieces = Pieces::of(&labels, &[Links::Together; 6]);
        assert_eq!(pieces.count, 1);
        assert_eq!(pieces.of_edge.iter().filter(|&&piece| piece == 0).count(), 3);
    }

    #[test]
    fn a_full_checkerboard_makes_four_pieces_around_the_connected_label() {
        // Label 1 at the corners with an even number of offsets.
        let labels = std::array::from_fn(|corner: usize| Label(1 - corner.count_ones() % 2));
        let links = std::array::from_fn(|face| {
            Links::of(FACE_CORNERS[face].map(|corner| labels[corner]), || {
                labels[FACE_CORNERS[face][0]] == Label(1)
            })
        });
        let pieces = Pieces::of(&labels, &links);
        assert_eq!(pieces.count, 4);
        for piece in 0..4 {
            assert_eq!(pieces.of_edge.iter().filter(|&&found| found == piece).count(), 3);
        }
    }
}
