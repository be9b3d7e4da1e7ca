//! Sections as flat slices.

use crate::ffi::skeleton::Input;
use crate::plane::Bounds;
use crate::section::Section;

/// What the bridge wants to know.
pub(super) fn input(sections: &[Section], bounds: Bounds, tolerance: f64, bits: u32) -> Input {
    let mut input = Input { tolerance, bits, ..Input::default() };
    input.bounds = (0..3).flat_map(|axis| [bounds.min[axis], bounds.max[axis]]).collect();
    input.vertex_starts.push(0);
    input.edge_starts.push(0);
    for section in sections {
        add(&mut input, section);
    }
    input
}

fn add(input: &mut Input, section: &Section) {
    let plane = section.plane();
    input.planes.extend(plane.normal.to_array());
    input.planes.push(plane.offset);
    let [first, second] = plane.kept_axes();
    input.axes.extend([first, second, plane.dropped_axis()].map(|axis| axis as u32));
    input.vertices.extend(section.vertices().iter().flat_map(|vertex| vertex.to_array()));
    input.vertex_starts.push(input.vertices.len() as u32 / 2);
    for edge in section.edges() {
        input.edges.extend([edge.start, edge.end, edge.left.0, edge.right.0]);
    }
    input.edge_starts.push(input.edges.len() as u32 / 4);
    input.backgrounds.push(section.background().0);
    input.partial.push(u8::from(section.is_partial()));
}
