//! The files of the set, each in a kind of its own.

use std::fmt::Write as _;
use std::io::Write as _;

use flate2::Compression;
use flate2::write::GzEncoder;
use glam::DVec3;

use transect::label::Label;
use transect::section::Sections;

use super::solids::{REACH, Solid};

pub fn csl(sections: &Sections) -> Vec<u8> {
    let mut bytes = Vec::new();
    transect::io::csl::write(sections, &mut bytes).expect("no unknown parts");
    bytes
}

pub fn json(sections: &Sections) -> Vec<u8> {
    let mut bytes = Vec::new();
    transect::io::json::write(sections, &mut bytes).expect("writing to memory");
    bytes
}

/// Planar graphs with a label to the left and to the right of every edge.
pub fn contour(sections: &Sections) -> Vec<u8> {
    let mut text = format!("{}\n", sections.sections.len());
    for section in &sections.sections {
        let plane = section.plane();
        let DVec3 { x, y, z } = plane.normal;
        let (points, edges) = (section.vertices().len(), section.edges().len());
        line(&mut text, format_args!("{x} {y} {z} {}", plane.offset));
        line(&mut text, format_args!("{points} {edges}"));
        for point in (0..points as u32).map(|at| section.point(at)) {
            line(&mut text, format_args!("{} {} {}", point.x, point.y, point.z));
        }
        for edge in section.edges() {
            let (Label(left), Label(right)) = (edge.left, edge.right);
            line(&mut text, format_args!("{} {} {left} {right}", edge.start, edge.end));
        }
    }
    text.into_bytes()
}

fn line(text: &mut String, what: std::fmt::Arguments) {
    writeln!(text, "{what}").expect("writing to memory");
}

/// Only every fourth slice along z is drawn.
pub fn nrrd(solid: &Solid, step: f64) -> Vec<u8> {
    const EVERY: usize = 4;
    let size = (2.0 * REACH / step) as usize;
    let place = |index: usize| (index as f64 + 0.5) * step - REACH;
    let mut voxels = Vec::with_capacity(size * size * size);
    for z in 0..size {
        for (y, x) in (0..size).flat_map(|y| (0..size).map(move |x| (y, x))) {
            let Label(label) = (solid.label_at)(DVec3::new(place(x), place(y), place(z)));
            voxels.push(if z % EVERY == 0 { label as u8 } else { 0 });
        }
    }
    let from = place(0);
    let header = format!(
        "NRRD0004\ntype: uint8\ndimension: 3\nspace: LPS\nsizes: {size} {size} {size}\n\
         space directions: ({step},0,0) (0,{step},0) (0,0,{step})\n\
         space origin: ({from},{from},{from})\nencoding: gzip\n\n"
    );
    let mut encoder = GzEncoder::new(header.into_bytes(), Compression::best());
    encoder.write_all(&voxels).expect("writing to memory");
    encoder.finish().expect("writing to memory")
}

/// The volumes of all labels, in mm³.
pub fn truth(solids: &[Solid]) -> Vec<u8> {
    let of = |solid: &Solid| {
        let volumes: Vec<f64> = solid.volumes(0.8).iter().map(|volume| volume.round()).collect();
        format!("  \"{}\": {volumes:?}", solid.name)
    };
    let lines: Vec<String> = solids.iter().map(of).collect();
    format!("{{\n{}\n}}\n", lines.join(",\n")).into_bytes()
}
