//! Samples cut off by planes: what lies beyond becomes outside, and the surface that
//! closes the solid lies on the planes.

use glam::DVec3;
use rayon::prelude::*;

use crate::label::Label;
use crate::plane::Plane;

use super::leaf::{LeafMut, LeafOf, LeafValues, NewLeaf};
use super::samples::{LEAF_NODES, LEAF_SIDE, Lattice, Samples, Values};

/// What a material is where a tile becomes a leaf: as far inside as a leaf is wide.
const DEEP: f64 = LEAF_SIDE as f64;
/// The nodes of a leaf and those next to it are all within a cube this far around its
/// middle, in voxels, with half a voxel left for rounding.
const AROUND: f64 = LEAF_SIDE as f64 / 2.0 + 1.0;

/// Cuts a solid off at planes whose normals point away from what stays. In a node that
/// is s voxels before the nearest plane no material leads over *outside* by more than
/// s, beyond by no more than the negative distance.
pub fn clip(samples: &mut Samples, planes: &[Plane]) {
    if planes.is_empty() {
        return;
    }
    let Samples { lattice, values, .. } = *samples;
    let cut = Cut::new(&lattice, planes);
    let cut_tile = |index: usize| {
        let (at, label) = (lattice.leaf_at(index), samples.tiles[index]);
        let is_cut = cut.place(at) == Place::Across && label.is_material();
        (is_cut && !samples.is_valued(at)).then(|| filled(at, label, values))
    };
    let added: Vec<NewLeaf> =
        (0..samples.tiles.len()).into_par_iter().filter_map(cut_tile).collect();
    samples.tiles.par_iter_mut().enumerate().for_each(|(index, tile)| {
        if cut.place(lattice.leaf_at(index)) == Place::Beyond {
            *tile = Label::OUTSIDE;
        }
    });
    samples.retain(|at| cut.place(at) != Place::Beyond);
    samples.add(added);
    samples.leaves_mut().par_iter_mut().for_each(|leaf| cut.clip(leaf, values));
}

/// A leaf of one material.
fn filled(at: [i32; 3], label: Label, values: Values) -> NewLeaf {
    let value = match values {
        Values::Indicators => 1.0,
        Values::Distances => DEEP as f32,
    };
    LeafOf { at, materials: vec![LeafValues { label, values: Box::new([value; LEAF_NODES]) }] }
}

/// Where a leaf's nodes, and those next to it, lie.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Place {
    /// Before all planes.
    Before,
    /// All of them beyond one.
    Beyond,
    /// Neither.
    Across,
}

/// The planes, in lattice units.
struct Cut {
    /// For each plane how far before it node (0, 0, 0) is, and what a step along each
    /// axis takes away.
    planes: Vec<(f64, DVec3)>,
}

impl Cut {
    fn new(lattice: &Lattice, planes: &[Plane]) -> Self {
        let in_voxels =
            |plane: &Plane| (-plane.distance(lattice.origin) / lattice.voxel, plane.unit_normal());
        Self { planes: planes.iter().map(in_voxels).collect() }
    }

    fn place(&self, at: [i32; 3]) -> Place {
        let middle = DVec3::from(
            at.map(|along| f64::from(along) * LEAF_SIDE as f64 + (LEAF_SIDE - 1) as f64 / 2.0),
        );
        let mut place = Place::Before;
        for (start, normal) in &self.planes {
            let depth = start - normal.dot(middle);
            let half = AROUND * normal.abs().element_sum();
            if depth + half <= 0.0 {
                return Place::Beyond;
            }
            if depth - half <= 0.0 {
                place = Place::Across;
            }
        }
        place
    }

    /// How far before the nearest plane a node is, in voxels.
    fn depth(&self, node: [i32; 3]) -> f64 {
        let node = DVec3::from(node.map(f64::from));
        let depths = self.planes.iter().map(|(start, normal)| start - normal.dot(node));
        depths.fold(f64::INFINITY, f64::min)
    }

    fn clip(&self, leaf: &mut LeafMut, values: Values) {
        for node in 0..LEAF_NODES {
            let depth = self.depth(leaf.node(node));
            let outside = leaf.share(node, Label::OUTSIDE);
            let shares = leaf.materials.iter().filter(|own| own.label.is_material());
            let shares = shares.map(|own| leaf.share(node, own.label));
            let Some(best) = shares.reduce(f64::max) else { continue };
            let (lead, most) = (best - outside, values.lead_of(depth));
            if lead > most {
                yield_lead(leaf, node, values, [lead, most]);
            }
        }
    }
}

/// Makes the lead of a node's best material over *outside* smaller. Materials keep
/// their order.
fn yield_lead(leaf: &mut LeafMut, node: usize, values: Values, [from, to]: [f64; 2]) {
    for own in &mut leaf.materials {
        let value = f64::from(own.values[node]);
        let is_outside = own.label == Label::OUTSIDE;
        let new = match values {
            // Shares that add up to 1: all materials' are made smaller alike. With p and
            // q those of the best and of outside the lead is p − q = p + (1 − q) − 1.
            Values::Indicators => {
                let scale = (1.0 + to) / (1.0 + from);
                let share = (value + 1.0) / 2.0;
                let share = if is_outside { 1.0 - scale * (1.0 - share) } else { scale * share };
                2.0 * share - 1.0
            }
            Values::Distances if is_outside => value + (from - to),
            Values::Distances => value - (from - to),
        };
        own.values[node] = new as f32;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::grid::labels::{LabelGrid, leaf_nodes};
    use crate::mesh::shapes::samples;

    const LATTICE: Lattice = Lattice { origin: DVec3::splat(-1.0), voxel: 0.05, dims: [41; 3] };
    const RADIUS: f64 = 0.9;
    /// Between the materials, no node's x.
    const BORDER: f64 = 0.11;

    /// A ball of two materials that meet at x = 0.11; leaves within it are tiles.
    fn ball(values: Values) -> Samples {
        let mut ball = samples(LATTICE, |node| {
            let at = LATTICE.position(node);
            let inside = (RADIUS - at.length()) / LATTICE.voxel;
            let [one, two] = [BORDER - at.x, at.x - BORDER].map(|side| side / LATTICE.voxel);
            let [one, two] = [inside.min(one), inside.min(two)];
            match values {
                Values::Distances => vec![-inside as f32, one as f32, two as f32],
                Values::Indicators => {
                    // Shares that add up to 1.
                    let inside = (0.5 + inside / 8.0).clamp(0.0, 1.0);
                    let part = (0.5 + (two - one) / 16.0).clamp(0.0, 1.0);
                    let shares = [1.0 - inside, inside * (1.0 - part), inside * part];
                    shares.map(|share| (2.0 * share - 1.0) as f32).to_vec()
                }
            }
        });
        // The helper counts from 1; here the first is outside.
        ball.fields.iter_mut().for_each(|field| field.label = Label(field.label.0 - 1));
        ball.values = values;
        tiled(ball)
    }

    /// Leaves of one label become tiles, where their neighbours' nodes have it as well.
    fn tiled(mut samples: Samples) -> Samples {
        let labels = LabelGrid::new(&samples);
        let is_kept = |at: [i32; 3]| {
            let own = labels.at(at.map(|along| along * LEAF_SIDE as i32));
            leaf_nodes(at).any(|node| {
                (0..27).any(|step| {
                    let offset = [step / 9 - 1, step / 3 % 3 - 1, step % 3 - 1];
                    let next: [i32; 3] = std::array::from_fn(|axis| node[axis] + offset[axis]);
                    let inside = (0..3).all(|axis| (0..LATTICE.dims[axis]).contains(&next[axis]));
                    inside && labels.at(next) != own
                })
            })
        };
        for (index, tile) in samples.tiles.iter_mut().enumerate() {
            *tile = labels.at(LATTICE.leaf_at(index).map(|along| along * LEAF_SIDE as i32));
        }
        samples.retain(is_kept);
        samples.sanity_check().unwrap();
        samples
    }

    fn planes() -> [Plane; 2] {
        let oblique = DVec3::new(1.0, -2.0, 2.0);
        [Plane { normal: oblique, offset: 0.31 * 3.0 }, Plane { normal: -DVec3::Z, offset: 0.42 }]
    }

    #[test]
    fn labels_change_beyond_the_planes_alone() {
        for values in [Values::Distances, Values::Indicators] {
            let before = ball(values);
            assert!(before.tiles.iter().any(|tile| tile.is_material()), "there are tiles to cut");
            let mut after = before.clone();
            clip(&mut after, &planes());
            after.sanity_check().unwrap();
            let [old, new] = [&before, &after].map(LabelGrid::new);
            let mut cut = 0;
            for node in (0..before.tiles.len()).flat_map(|leaf| leaf_nodes(LATTICE.leaf_at(leaf))) {
                let at = LATTICE.position(node);
                let distance = planes().map(|plane| plane.distance(at));
                let distance = distance[0].max(distance[1]) / LATTICE.voxel;
                if distance.abs() < 1e-4 || (0..3).any(|axis| node[axis] >= LATTICE.dims[axis]) {
                    continue;
                }
                let was = old.at(node);
                let is = if distance > 0.0 { Label::OUTSIDE } else { was };
                assert_eq!(new.at(node), is, "{values:?} {node:?}, {distance} beyond");
                cut += usize::from(was != is);
            }
            assert!(cut > 1000, "{cut}");
        }
    }

    #[test]
    fn the_surface_lies_on_the_planes() {
        for values in [Values::Distances, Values::Indicators] {
            let mut samples = ball(values);
            clip(&mut samples, &planes());
            let mesh = crate::mesh::dual::dual(&samples, &crate::progress::Silent).unwrap();
            let mut on = [0, 0];
            for &vertex in &mesh.vertices {
                let distance = planes().map(|plane| plane.distance(vertex) / LATTICE.voxel);
                // The mesher slides points of a rim along both surfaces that meet there.
                assert!(distance.iter().all(|&distance| distance < 0.2), "{distance:?}");
                // Away from the rims, and from where the materials meet: there an indicator
                // does not lead over outside by as much as the plane asks for.
                let is_inner = vertex.length() < 0.8 && (vertex.x - BORDER).abs() > 0.2;
                for (on, [here, other]) in on.iter_mut().zip([distance, [distance[1], distance[0]]])
                {
                    if is_inner && here > -1.0 && other < -3.0 {
                        assert!(here.abs() < 0.02, "{values:?} {vertex}: {here}");
                        *on += 1;
                    }
                }
            }
            assert!(on.iter().all(|&on| on > 200), "{on:?}");
        }
    }

    #[test]
    fn without_planes_nothing_changes() {
        let before = ball(Values::Distances);
        let mut after = before.clone();
        clip(&mut after, &[]);
        assert_eq!(before, after);
    }
}
