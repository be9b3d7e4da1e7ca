//! What can be turned in space: the surfaces with fewer triangles, and the sections' contours. As
//! JSON, with places as whole numbers of steps from a corner, in base64.

use std::collections::BTreeMap;

use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use glam::DVec3;
use serde::Serialize;

use super::Part;
use super::outlines::{Outline, Outlines};
use super::plates::Plate;
use super::text::name_of;
use crate::error::Result;
use crate::label::{Label, Material};
use crate::mesh::clusters::clustered;
use crate::mesh::{Mesh, Surface};
use crate::picture::{PictureOptions, glass, viewpoint};
use crate::plane::Bounds;
use crate::section::Sections;
use crate::sides::Sides;

/// About how many triangles all surfaces have together, and how many more than that at most.
const TRIANGLES: usize = 150_000;
const SLACK: usize = 2;
/// How many steps the longest side has.
const STEPS: f64 = 65_535.0;

/// Everything in space.
#[derive(Debug, Clone, Serialize)]
pub struct Scene {
    /// The corner that places are counted from, and how long a step is, in world units.
    corner: [f64; 3],
    step: f64,
    /// Up, towards who looks at the front, and the right as `Sides` has it.
    up: [f64; 3],
    front: [f64; 3],
    right: [f64; 3],
    /// To who looks first.
    view: [f64; 3],
    bodies: Vec<Body>,
    outlines: Vec<Lines>,
    /// How many triangles there are where all are shown, and here.
    #[serde(skip)]
    pub triangles: [usize; 2],
    /// How many sections have lines, and how many of them are here.
    #[serde(skip)]
    pub sections: [usize; 2],
    /// The names of labels that would be too much.
    #[serde(skip)]
    pub left_out: Vec<String>,
}

/// A label's surface.
#[derive(Debug, Clone, Serialize)]
struct Body {
    label: u32,
    name: String,
    color: [u8; 3],
    /// Whether one looks through it, since it hides another one.
    glass: bool,
    /// Three of 16 bits for each vertex.
    places: String,
    /// Three for each triangle, of 16 bits where vertices allow it, else of 32.
    corners: String,
    wide: bool,
}

/// Contours between two labels.
#[derive(Debug, Clone, Serialize)]
struct Lines {
    labels: [u32; 2],
    /// Whether something unknown is on one of the sides.
    unknown: bool,
    places: String,
    /// How many points each line has, of 32 bits.
    runs: String,
}

impl Scene {
    /// Of surfaces and of what they were made from; `None` where nothing can be seen.
    ///
    /// # Errors
    /// When cancelled, or when CGAL fails.
    pub fn new(
        parts: &[Part],
        surfaces: &Mesh,
        sections: &Sections,
        picture: &PictureOptions,
    ) -> Result<Option<Self>> {
        let points = sections.sections.iter().flat_map(|section| {
            (0..section.vertices().len() as u32).map(|vertex| section.point(vertex))
        });
        let all = surfaces.vertices.iter().copied().chain(points);
        let Some(bounds) = Bounds::around(all).filter(|bounds| bounds.diagonal() > 0.0) else {
            return Ok(None);
        };
        let packer = Packer { corner: bounds.min, step: bounds.size().max_element() / STEPS };
        let whole = triangles(surfaces);
        let wanted = surfaces.triangles.len() as f64 * TRIANGLES as f64 / whole.max(1) as f64;
        let simple = match whole > TRIANGLES {
            true => &clustered(surfaces, wanted as usize),
            false => surfaces,
        };
        let outlines = Outlines::new(parts, bounds.diagonal());
        let sides = Sides::of(sections);
        let sides = picture.up.map_or(sides, |up| sides.standing(up));
        let mut glass = glass(simple);
        if parts.len() > 1 {
            glass.extend(around_others(simple));
        }
        let mut scene = Self {
            corner: packer.corner.to_array(),
            step: packer.step,
            up: sides.up.to_array(),
            front: sides.front.to_array(),
            right: sides.right.to_array(),
            view: viewpoint(simple, sections, picture).direction(&sides).to_array(),
            bodies: Vec::new(),
            outlines: outlines.lines.iter().map(|line| packer.lines(line)).collect(),
            triangles: [whole, 0],
            sections: [outlines.count, outlines.shown],
            left_out: Vec::new(),
        };
        scene.add_bodies(simple, &glass, &sections.materials, &packer);
        Ok(Some(scene))
    }

    /// The labels that are here, with their colours, and whether one looks through them.
    pub fn labels(&self) -> impl Iterator<Item = (u32, [u8; 3], bool)> + '_ {
        self.bodies.iter().map(|body| (body.label, body.color, body.glass))
    }

    fn add_bodies(
        &mut self,
        mesh: &Mesh,
        glass: &[Label],
        materials: &[Material],
        packer: &Packer,
    ) {
        for label in mesh.labels() {
            let surface = mesh.surface(label);
            if self.triangles[1] + surface.triangles.len() > SLACK * TRIANGLES {
                self.left_out.push(name_of(label.0, materials));
                continue;
            }
            self.triangles[1] += surface.triangles.len();
            let own = materials.iter().find(|material| material.id == label.0).cloned();
            let Material { name, color, .. } = own.unwrap_or_else(|| Material::numbered(label));
            self.bodies.push(packer.body(label, &surface, (name, color, glass.contains(&label))));
        }
    }
}

/// The labels of structures that may overlap whose box has that of another one in it: most of what
/// is there would be hidden.
fn around_others(mesh: &Mesh) -> Vec<Label> {
    let mut boxes: BTreeMap<Label, Bounds> = BTreeMap::new();
    for (triangle, sides) in mesh.sides.iter().enumerate() {
        let Some(own) = Bounds::around(mesh.corners(triangle)) else { continue };
        for &label in sides.iter().filter(|label| label.is_material()) {
            boxes.entry(label).and_modify(|all| *all = all.union(own)).or_insert(own);
        }
    }
    let has_another = |(label, all): (&Label, &Bounds)| {
        boxes
            .iter()
            .any(|(other, own)| other != label && all.contains(own.min) && all.contains(own.max))
    };
    boxes.iter().filter(|&own| has_another(own)).map(|(&label, _)| label).collect()
}

/// How many triangles the surfaces of all labels have.
fn triangles(mesh: &Mesh) -> usize {
    mesh.sides.iter().flatten().filter(|label| label.is_material()).count()
}

/// Places as whole numbers.
struct Packer {
    corner: DVec3,
    step: f64,
}

impl Packer {
    fn places(&self, points: &[DVec3]) -> String {
        let numbers = points.iter().flat_map(|&point| {
            ((point - self.corner) / self.step)
                .round()
                .clamp(DVec3::ZERO, DVec3::splat(STEPS))
                .to_array()
        });
        STANDARD
            .encode(numbers.flat_map(|number| (number as u16).to_le_bytes()).collect::<Vec<u8>>())
    }

    fn body(
        &self,
        label: Label,
        surface: &Surface,
        (name, color, glass): (String, [u8; 3], bool),
    ) -> Body {
        let corners = surface.triangles.as_flattened().iter();
        let wide = surface.vertices.len() > usize::from(u16::MAX);
        let bytes: Vec<u8> = match wide {
            true => corners.flat_map(|corner| corner.to_le_bytes()).collect(),
            false => corners.flat_map(|&corner| (corner as u16).to_le_bytes()).collect(),
        };
        let (places, corners) = (self.places(&surface.vertices), STANDARD.encode(bytes));
        Body { label: label.0, name, color, glass, places, corners, wide }
    }

    fn lines(&self, (labels, Outline { points, runs }): (&[Label; 2], &Outline)) -> Lines {
        let runs: Vec<u8> = runs.iter().flat_map(|run| run.to_le_bytes()).collect();
        Lines {
            labels: labels.map(|label| label.0),
            unknown: labels.contains(&Label::UNKNOWN),
            places: self.places(points),
            runs: STANDARD.encode(runs),
        }
    }
}

/// The corners of plates in space, for who wants to see where one is.
pub fn corners(plates: &[Plate]) -> Vec<[[f64; 3]; 4]> {
    plates.iter().map(|plate| plate.corners).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn places_are_steps_from_the_corner() {
        let packer = Packer { corner: DVec3::new(-1.0, 0.0, 5e6), step: 2.0 / STEPS };
        let points = [DVec3::new(-1.0, 2.0, 5e6 + 1.0), DVec3::new(1.0, -9.0, 5e6)];
        let bytes = STANDARD.decode(packer.places(&points)).expect("base64");
        let numbers: Vec<u16> =
            bytes.as_chunks::<2>().0.iter().map(|&two| u16::from_le_bytes(two)).collect();
        assert_eq!(numbers, [0, 65535, 32768, 65535, 0, 0]);
    }

    #[test]
    fn what_is_around_others_is_glass() {
        let triangle = |size: f64| [DVec3::ZERO, DVec3::X, DVec3::ONE].map(|own| size * own + 5.0);
        let mesh = Mesh {
            vertices: [triangle(3.0), triangle(2.0), triangle(9.0).map(|own| own - 20.0)].concat(),
            triangles: vec![[0, 1, 2], [3, 4, 5], [6, 7, 8]],
            sides: [4, 2, 7].map(|own| [Label(own), Label::OUTSIDE]).to_vec(),
        };
        assert_eq!(around_others(&mesh), [Label(4)]);
    }

    #[test]
    fn corners_are_as_narrow_as_vertices_allow() {
        let packer = Packer { corner: DVec3::ZERO, step: 1.0 };
        for (count, wide) in [(65_535, false), (65_536, true)] {
            let surface = Surface {
                vertices: vec![DVec3::ZERO; count],
                triangles: vec![[0, 1, count as u32 - 1]],
            };
            let body = packer.body(Label(1), &surface, (String::new(), [0; 3], false));
            let bytes = STANDARD.decode(&body.corners).expect("base64");
            assert_eq!((body.wide, bytes.len()), (wide, if wide { 12 } else { 6 }));
            let last = &bytes[bytes.len() * 2 / 3..];
            assert_eq!(u16::from_le_bytes([last[0], last[1]]), (count - 1) as u16);
        }
    }
}
