//! How far voxels are from a surface.

use glam::DVec3;

use super::Placement;
use crate::error::Result;
use crate::label::Label;
use crate::mesh::Mesh;
use crate::mesh::nearest::Nearest;

/// The distances from the centres of voxels to the surface of the union of some labels, in world
/// units, less than zero for voxels of such a [label](super::fill()); the first axis runs fastest.
/// Infinite where there is no surface.
///
/// # Errors
/// Where memory runs out.
pub fn distances(
    mesh: &Mesh,
    within: impl Fn(Label) -> bool + Sync,
    labels: &[u32],
    [width, height, depth]: [usize; 3],
    placement: &Placement,
) -> Result<Vec<f32>> {
    let triangles = mesh.triangles_around(&within);
    if triangles.is_empty() {
        return Ok(vec![f32::INFINITY; labels.len()]);
    }
    let nearest = Nearest::new(&mesh.vertices, triangles.as_flattened())?;
    let mut all = Vec::with_capacity(labels.len());
    // A slice at a time, so that places take no room worth speaking of.
    for k in 0..depth {
        let row =
            |j| (0..width).map(move |i| placement.point(DVec3::new(i as f64, j as f64, k as f64)));
        let places: Vec<_> = (0..height).flat_map(row).collect();
        let own = &labels[k * places.len()..][..places.len()];
        let found = nearest.distances(&places)?;
        all.extend(found.into_iter().zip(own).map(|(distance, &label)| {
            let distance = distance as f32;
            if within(Label(label)) { -distance } else { distance }
        }));
    }
    Ok(all)
}
