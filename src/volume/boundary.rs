//! The boundary of every label in a volume: the faces of its voxels that others lie behind.

use glam::DVec3;
use rayon::prelude::*;

use super::{LayeredVolume, Placement};
use crate::error::Result;
use crate::label::Label;
use crate::memory;
use crate::mesh::Surface;

/// Bytes that a face takes while all are found, and those of the largest surface are made
/// triangles and arranged.
const FOUND: u64 = 32;
const ARRANGED: u64 = 1000;

/// A face of a voxel: the label within, *outside* for the boundary of all materials together, and
/// six times the voxel's number, plus twice the axis, plus 1 for the face with the larger index.
type Face = (u32, u64);

/// The faces of voxels, by their labels.
#[derive(Debug)]
pub struct Boundary {
    dims: [usize; 3],
    placement: Placement,
    faces: Vec<Face>,
}

impl Boundary {
    /// Of all labels, and of all together.
    ///
    /// # Errors
    /// Where the faces would not fit into memory.
    pub fn new(volume: &LayeredVolume) -> Result<Self> {
        let depth = volume.dims()[2];
        let count = |slice| {
            let mut count = 0u64;
            each_face(volume, slice, &mut |_| count += 1);
            count
        };
        let needed: u64 = (0..depth).into_par_iter().map(count).sum::<u64>() * FOUND;
        memory::require(needed, too_many)?;
        let found = |slice| {
            let mut found: Vec<Face> = Vec::new();
            each_face(volume, slice, &mut |face| found.push(face));
            found
        };
        let slices: Vec<Vec<Face>> = (0..depth).into_par_iter().map(found).collect();
        let mut faces = slices.concat();
        drop(slices);
        faces.par_sort_unstable();
        let largest = faces.chunk_by(|one, other| one.0 == other.0).map(<[Face]>::len).max();
        memory::require(largest.unwrap_or(0) as u64 * ARRANGED, too_many)?;
        Ok(Self { dims: volume.dims(), placement: *volume.placement(), faces })
    }

    /// The surface around a label, or around all materials (*outside*), turned outward: two
    /// triangles for each face.
    pub fn surface(&self, label: Label) -> Surface {
        let faces = self.faces(label);
        let corners: Vec<[u64; 4]> = faces.par_iter().map(|face| self.corners(face.1)).collect();
        let mut places = corners.as_flattened().to_vec();
        places.par_sort_unstable();
        places.dedup();
        // A number that is not there cannot be asked for.
        let number = |corner| places.binary_search(&corner).unwrap_or(0) as u32;
        let triangles: Vec<[[u32; 3]; 2]> = corners
            .par_iter()
            .map(|corners| {
                let [a, b, c, d] = corners.map(number);
                [[a, b, c], [a, c, d]]
            })
            .collect();
        let vertices = places.par_iter().map(|&corner| self.point(corner)).collect();
        Surface { vertices, triangles: triangles.into_flattened() }
    }

    fn faces(&self, label: Label) -> &[Face] {
        let first = self.faces.partition_point(|face| face.0 < label.0);
        let count = self.faces[first..].partition_point(|face| face.0 == label.0);
        &self.faces[first..first + count]
    }

    /// The corners of a face, counter-clockwise as seen from outside, by their numbers.
    fn corners(&self, face: u64) -> [u64; 4] {
        let [x, y, _] = self.dims.map(|dim| dim as u64);
        let (voxel, axis, side) = (face / 6, (face % 6 / 2) as usize, face % 2);
        let mut base = [voxel % x, voxel / x % y, voxel / (x * y)];
        base[axis] += side;
        let corner = |u: u64, v: u64| {
            let mut at = base;
            at[(axis + 1) % 3] += u;
            at[(axis + 2) % 3] += v;
            at[0] + (x + 1) * (at[1] + (y + 1) * at[2])
        };
        let is_turned = self.placement.steps.determinant() < 0.0;
        match (side == 1) != is_turned {
            true => [corner(0, 0), corner(1, 0), corner(1, 1), corner(0, 1)],
            false => [corner(0, 0), corner(0, 1), corner(1, 1), corner(1, 0)],
        }
    }

    /// Where a corner is: half a voxel before the centre of the voxel with its number.
    fn point(&self, corner: u64) -> DVec3 {
        let [x, y, _] = self.dims.map(|dim| dim as u64 + 1);
        let index = [corner % x, corner / x % y, corner / (x * y)].map(|index| index as f64);
        self.placement.point(DVec3::from(index) - 0.5)
    }
}

fn too_many() -> String {
    "the boundary of the voxels (are these labels, and not an image?)".to_owned()
}

/// Tells all faces of a slice.
fn each_face(volume: &LayeredVolume, slice: usize, tell: &mut impl FnMut(Face)) {
    let [width, height, depth] = volume.dims();
    let strides = [1, width, width * height];
    let layers = volume.layers();
    let has = |voxel: usize, label: u32| layers.iter().any(|own| own.labels[voxel] == label);
    let is_any = |voxel: usize| layers.iter().any(|own| own.labels[voxel] != 0);
    for row in 0..height {
        let start = width * (row + height * slice);
        for column in 0..width {
            let voxel = start + column;
            let at = [(column, width), (row, height), (slice, depth)];
            let mut is_first = true;
            for label in layers.iter().map(|own| own.labels[voxel]).filter(|&label| label != 0) {
                for (axis, (index, count)) in at.into_iter().enumerate() {
                    let beyond = [
                        (index > 0).then(|| voxel - strides[axis]),
                        (index + 1 < count).then(|| voxel + strides[axis]),
                    ];
                    for (side, beyond) in beyond.into_iter().enumerate() {
                        let face = 6 * voxel as u64 + 2 * axis as u64 + side as u64;
                        if beyond.is_none_or(|beyond| !has(beyond, label)) {
                            tell((label, face));
                        }
                        if is_first && beyond.is_none_or(|beyond| !is_any(beyond)) {
                            tell((Label::OUTSIDE.0, face));
                        }
                    }
                }
                is_first = false;
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use glam::DMat3;

    use super::*;
    use crate::volume::LabelVolume;

    fn volume(dims: [usize; 3], labels: &[u32], steps: DMat3) -> LabelVolume {
        let placement = Placement { origin: DVec3::new(3.0, -2.0, 1.0), steps };
        LabelVolume::new(dims, labels.to_vec(), placement).expect("a volume")
    }

    /// Two blocks that touch, in lattices that are turned, oblong and left-handed.
    #[test]
    fn surfaces_are_closed_and_enclose_their_voxels() {
        let labels = [0, 1, 1, 2, 0, 1, 0, 2];
        let turned = DMat3::from_axis_angle(DVec3::new(1.0, 2.0, -0.5).normalize(), 0.7);
        let oblong = turned * DMat3::from_diagonal(DVec3::new(1.0, 0.5, 3.0));
        let sheared = oblong * DMat3::from_cols(DVec3::X, DVec3::new(0.3, 1.0, 0.0), DVec3::Z);
        for steps in [DMat3::IDENTITY, oblong, sheared, oblong * -1.0] {
            let layers = vec![volume([4, 2, 1], &labels, steps)];
            let volume = LayeredVolume::new(layers).expect("layers");
            let boundary = Boundary::new(&volume).expect("memory");
            for (label, faces, voxels) in [(1, 14, 3.0), (2, 10, 2.0), (0, 22, 5.0)] {
                let surface = boundary.surface(Label(label));
                assert_eq!(surface.triangles.len(), 2 * faces, "label {label}");
                assert!(surface.open_edges().is_empty());
                let expected = voxels * volume.voxel_volume();
                assert!((surface.volume() / expected - 1.0).abs() < 1e-12, "label {label}");
            }
            assert!(boundary.surface(Label(3)).triangles.is_empty());
        }
    }

    #[test]
    fn what_is_in_two_layers_is_in_their_union_once() {
        let layers = [[1, 1, 0, 9], [0, 2, 2, 9]];
        let layers = layers.map(|labels| volume([4, 1, 1], &labels, DMat3::IDENTITY)).to_vec();
        let volume = LayeredVolume::new(layers).expect("layers");
        let boundary = Boundary::new(&volume).expect("memory");
        let volume_of = |label| boundary.surface(Label(label)).volume();
        for (label, expected) in [(1, 2.0), (2, 2.0), (9, 1.0), (0, 4.0)] {
            assert!((volume_of(label) - expected).abs() < 1e-12, "label {label}");
        }
        let tally = volume.tally();
        assert_eq!(tally.all, 4);
        assert_eq!(tally.labels.into_iter().collect::<Vec<_>>(), [(1, 2), (2, 2), (9, 1)]);
    }
}
