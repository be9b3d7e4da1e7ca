//! Segmentations of 3D Slicer whose segments overlap: a fourth axis, the list, has the layers.

use std::collections::BTreeSet;
use std::path::Path;

use super::header::Header;
use super::{Checked, domain, frame, labels, opened, placement, scalar_storage, segments, units};
use crate::error::{Error, Result};
use crate::io::volume::{Storage, distinct};
use crate::label::{Label, Material};
use crate::volume::LabelVolume;

/// Where the list is among the axes.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
struct List {
    /// How many layers it has.
    count: usize,
    /// Whether it runs fastest, as Slicer writes it, or slowest.
    is_first: bool,
}

/// Whether the header at the beginning of a file tells of several layers.
pub fn has_layers(start: &[u8]) -> bool {
    Header::read(start).is_ok_and(|(header, _)| list(&header).is_ok_and(|list| list.is_some()))
}

/// Reads the layers of a file, each with its segments; `file` is for errors, and names the folder
/// of detached data. Where segments of different layers have one number, all are numbered anew.
///
/// # Errors
/// As [`read`](super::read), and where a layer holds a number that is no segment's but would have
/// to be numbered anew.
pub fn read_layers(bytes: &[u8], file: &Path) -> Result<Vec<LabelVolume>> {
    let at = |what: String| Error::input(file, "the header", what);
    let (header, rest) = Header::read(bytes).map_err(at)?;
    let list = list(&header).map_err(at)?;
    let List { count, is_first } = list.ok_or_else(|| at("it has no list of layers".into()))?;
    let dims = domain(&header).map_err(at)?;
    let placement = placement(&header).map_err(at)?;
    let [x, y, z] = dims;
    let all = match is_first {
        true => [x.saturating_mul(count), y, z],
        false => [x, y, z.saturating_mul(count)],
    };
    let storage = Storage { dims: all, ..scalar_storage(&header, all).map_err(at)? };
    let voxels = opened(&header, rest, &storage, file)?;
    let labels =
        labels(&header, &storage, &voxels).map_err(|what| Error::input(file, "the data", what))?;
    let segments = numbered(segments(&header), &header);
    let mut layers = Vec::with_capacity(count);
    for layer in 0..count {
        let own: Vec<u32> = match is_first {
            true => labels.iter().skip(layer).step_by(count).copied().collect(),
            false => labels[layer * x * y * z..(layer + 1) * x * y * z].to_vec(),
        };
        let (own, materials) = relabelled(own, layer, &segments)
            .map_err(|what| Error::input(file, "the data", what))?;
        let mut volume = LabelVolume::new(dims, own, placement).map_err(at)?;
        (volume.frame, volume.units) = (frame(&header), units(&header));
        volume.materials = materials;
        layers.push(volume);
    }
    Ok(layers)
}

/// The axis that is no direction in space, if there is one beside three that are.
fn list(header: &Header) -> Checked<Option<List>> {
    let sizes = header.numbers::<usize>("sizes")?.ok_or("it has no sizes")?;
    let directions = header.get("space directions").unwrap_or_default();
    let parts: Vec<&str> = directions.split_whitespace().collect();
    let place = parts.iter().position(|part| *part == "none");
    Ok(match (place, sizes.len(), parts.len()) {
        (Some(0), 4, 4) => Some(List { count: sizes[0], is_first: true }),
        (Some(3), 4, 4) => Some(List { count: sizes[3], is_first: false }),
        _ => None,
    }
    .filter(|list| list.count > 0))
}

/// A segment: its layer, its number there, and what it becomes.
struct Segment {
    layer: usize,
    value: u32,
    material: Material,
}

/// Segments with numbers that are different everywhere.
fn numbered(segments: Vec<(usize, Material)>, header: &Header) -> Vec<Segment> {
    let layer = |number: usize| {
        let layer = header.key(&format!("Segment{number}_Layer"));
        layer.and_then(|layer| layer.trim().parse().ok()).unwrap_or(0)
    };
    let numbers: BTreeSet<u32> = segments.iter().map(|(_, material)| material.id).collect();
    let are_different = numbers.len() == segments.len();
    let materials = segments.iter().enumerate().map(|(place, (_, material))| {
        let id = if are_different { material.id } else { place as u32 + 1 };
        Material { id, ..material.clone() }
    });
    let materials = distinct(materials.collect());
    segments
        .into_iter()
        .zip(materials)
        .map(|((number, own), material)| Segment { layer: layer(number), value: own.id, material })
        .collect()
}

/// The labels of a layer with the numbers of its segments, and these.
fn relabelled(
    mut labels: Vec<u32>,
    layer: usize,
    segments: &[Segment],
) -> Checked<(Vec<u32>, Vec<Material>)> {
    let own: Vec<&Segment> = segments.iter().filter(|segment| segment.layer == layer).collect();
    let is_renumbered = segments.iter().any(|segment| segment.value != segment.material.id);
    let taken = |label: u32| segments.iter().any(|segment| segment.material.id == label);
    let mut extra: Vec<Material> = Vec::new();
    for run in labels.chunk_by_mut(|one, other| one == other) {
        let value = run[0];
        if value == 0 {
            continue;
        }
        match own.iter().find(|segment| segment.value == value) {
            Some(segment) => run.fill(segment.material.id),
            None if is_renumbered || taken(value) => {
                return Err(format!("layer {layer} holds {value}, which is none of its segments"));
            }
            None if extra.iter().all(|material| material.id != value) => {
                extra.push(Material::numbered(Label(value)));
            }
            None => {}
        }
    }
    let materials = own.iter().map(|segment| segment.material.clone()).chain(extra);
    Ok((labels, materials.collect()))
}
