//! Edges where a solid touches itself and that both its sheets end at.
//!
//! Where sections contradict each other, or where contours touch in projection, four
//! triangles of one label can meet in an edge. Each pair of them that has the label between
//! it gets vertices of its own when the label's surface is taken out of the network, unless
//! the two are connected around both ends. Such an edge is divided.

use std::str::FromStr;

use dashu_ratio::RBig;

use super::{Skeleton, merge, splits};

/// More rounds than any edge needs: what is divided is tied again only where triangles
/// lie on each other.
const ROUNDS: usize = 8;

/// Divides the edges in their middles; whether none is left.
pub(super) fn divide(skeleton: &mut Skeleton) -> bool {
    for _ in 0..ROUNDS {
        let tied = skeleton.mesh.tied_edges();
        if tied.is_empty() {
            return true;
        }
        let chains: Vec<Vec<u32>> = tied
            .into_iter()
            .map(|ends @ [from, to]| vec![from, add_middle(skeleton, ends), to])
            .collect();
        splits::divide(skeleton, &chains);
        // Triangles that lay on each other may have got the same corners.
        merge::cancel(skeleton);
    }
    skeleton.mesh.tied_edges().is_empty()
}

/// A vertex of its own also where rounding knows no place between the two.
fn add_middle(skeleton: &mut Skeleton, ends: [u32; 2]) -> u32 {
    let [from, to] = ends.map(|end| end as usize);
    let vertices = &mut skeleton.mesh.vertices;
    vertices.push(vertices[from].midpoint(vertices[to]));
    if let Some(exact) = &mut skeleton.details.exact {
        let middle = |axis: usize| middle([&exact[from][axis], &exact[to][axis]]);
        exact.push(std::array::from_fn(middle));
    }
    skeleton.mesh.vertices.len() as u32 - 1
}

/// Of two fractions, as a fraction.
fn middle(ends: [&str; 2]) -> String {
    let [from, to] = ends.map(|end| RBig::from_str(end).unwrap_or_default());
    let middle = (from + to) / RBig::from(2);
    format!("{}/{}", middle.numerator(), middle.denominator())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn middles_are_exact() {
        assert_eq!(middle(["1/3", "2/7"]), "13/42");
        assert_eq!(middle(["-5/1", "5/1"]), "0/1");
        assert_eq!(middle(["9007199254740993/4", "1/4"]), "4503599627370497/4");
    }
}
