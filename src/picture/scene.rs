//! What there is to see: facets and contour strokes, sorted into what is solid
//! and what is glass.

use std::collections::BTreeMap;

use glam::{DVec3, Vec3};

use crate::label::{Label, Material};
use crate::mesh::Mesh;
use crate::plane::Bounds;
use crate::section::Section;

use super::normals::corner_normals;
use super::selection::Selection;

/// A triangle to be drawn.
#[derive(Debug, Clone, Copy)]
pub struct Facet {
    /// Indices into [`Scene::points`], counter-clockwise seen from outside the
    /// material that the facet shows.
    pub corners: [u32; 3],
    /// Index into [`Scene::materials`].
    pub material: u16,
}

/// A piece of a contour.
#[derive(Debug, Clone, Copy)]
pub struct Stroke {
    /// Its ends, in the scene's space.
    pub ends: [Vec3; 2],
    /// Index into [`Scene::materials`]; `None` for the border of what is
    /// unknown.
    pub material: Option<u16>,
}

/// What is drawn into one depth buffer.
#[derive(Debug, Clone, Default)]
pub struct Layer {
    /// The triangles.
    pub facets: Vec<Facet>,
    /// For each corner of each triangle its unit normal, outward.
    pub normals: Vec<[Vec3; 3]>,
    /// The contours.
    pub strokes: Vec<Stroke>,
}

/// A material as it is drawn.
#[derive(Debug, Clone)]
pub struct Paint {
    /// As the sections name it.
    pub name: String,
    /// sRGB.
    pub color: [u8; 3],
}

/// Everything that is drawn, around the origin.
#[derive(Debug, Clone)]
pub struct Scene {
    /// The mesh's vertices.
    pub points: Vec<Vec3>,
    /// What hides other things.
    pub solid: Layer,
    /// One translucent layer for each material that would hide another one.
    pub glass: Vec<Layer>,
    /// The materials that occur, by label.
    pub materials: Vec<Paint>,
    /// The diagonal of the box around everything; positive.
    pub diagonal: f32,
}

impl Scene {
    /// Sorts what is selected of a network and of the sections' contours into
    /// layers.
    pub fn new(
        mesh: &Mesh,
        sections: &[Section],
        materials: &[Material],
        selection: Selection,
    ) -> Self {
        let mesh = &*selection.mesh(mesh);
        let contour_points = sections.iter().flat_map(|section| {
            let ends = selection.contours(section).flat_map(|edge| [edge.start, edge.end]);
            ends.map(|vertex| section.point(vertex))
        });
        let bounds = Bounds::around(mesh.vertices.iter().copied().chain(contour_points))
            .unwrap_or(Bounds { min: DVec3::ZERO, max: DVec3::ONE });
        let center = (bounds.min + bounds.max) / 2.0;

        let shared = shared_areas(mesh);
        let roles = Roles {
            glass: glass_labels(&shared),
            labels: occurring_labels(shared.keys().copied(), sections, selection),
        };
        let mut scene = Self {
            points: mesh.vertices.iter().map(|&point| (point - center).as_vec3()).collect(),
            solid: Layer::default(),
            glass: vec![Layer::default(); roles.glass.len()],
            materials: roles.labels.iter().map(|&label| paint(label, materials)).collect(),
            diagonal: (bounds.diagonal() as f32).max(f32::MIN_POSITIVE),
        };
        scene.add_facets(mesh, &roles);
        scene.add_strokes(sections, selection, center, &roles);
        let Self { points, solid, glass, .. } = &mut scene;
        for layer in std::iter::once(solid).chain(glass) {
            layer.normals = corner_normals(points, &layer.facets);
        }
        scene
    }

    /// The layers, the solid one first.
    pub fn layers(&self) -> impl Iterator<Item = &Layer> {
        std::iter::once(&self.solid).chain(&self.glass)
    }

    /// Gives other colours to all facets, by their corners; contours get the
    /// dark of the first colour.
    pub fn paint(&mut self, colors: Vec<Paint>, color: impl Fn([u32; 3]) -> u16) {
        for layer in std::iter::once(&mut self.solid).chain(&mut self.glass) {
            layer.facets.iter_mut().for_each(|facet| facet.material = color(facet.corners));
            for stroke in &mut layer.strokes {
                stroke.material = stroke.material.map(|_| 0);
            }
        }
        self.materials = colors;
    }

    fn add_facets(&mut self, mesh: &Mesh, roles: &Roles) {
        for (&[a, b, c], &[back, front]) in mesh.triangles.iter().zip(&mesh.sides) {
            let (behind, before) = (roles.role(back), roles.role(front));
            if behind == before {
                continue;
            }
            let (shown, corners) =
                if behind > before { (back, [a, b, c]) } else { (front, [a, c, b]) };
            let facet = Facet { corners, material: roles.index(shown) };
            if let Some(layer) = self.layer(roles.role(shown)) {
                layer.facets.push(facet);
            }
        }
    }

    fn add_strokes(
        &mut self,
        sections: &[Section],
        selection: Selection,
        center: DVec3,
        roles: &Roles,
    ) {
        for section in sections {
            for edge in selection.contours(section) {
                let ends = [edge.start, edge.end].map(|v| (section.point(v) - center).as_vec3());
                let (left, right) = (roles.role(edge.left), roles.role(edge.right));
                let shown = if left >= right { edge.left } else { edge.right };
                let unknown = [edge.left, edge.right].contains(&Label::UNKNOWN);
                let role = match roles.role(shown) {
                    Role::Nothing if unknown => Role::Solid,
                    role => role,
                };
                let material = (!unknown).then(|| roles.index(shown));
                if let Some(layer) = self.layer(role) {
                    layer.strokes.push(Stroke { ends, material });
                }
            }
        }
    }

    fn layer(&mut self, role: Role) -> Option<&mut Layer> {
        match role {
            Role::Nothing => None,
            Role::Glass(number) => self.glass.get_mut(number),
            Role::Solid => Some(&mut self.solid),
        }
    }
}

/// How a label is drawn; the larger of two is what shows at their border.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
enum Role {
    /// Outside and unknown: not at all.
    Nothing,
    /// Translucent, in this glass layer; inner ones are later.
    Glass(usize),
    Solid,
}

struct Roles {
    /// The materials that occur, sorted.
    labels: Vec<Label>,
    /// Those drawn as glass, inner ones later.
    glass: Vec<Label>,
}

impl Roles {
    fn role(&self, label: Label) -> Role {
        match self.glass.iter().position(|&glass| glass == label) {
            Some(number) => Role::Glass(number),
            None if label.is_material() => Role::Solid,
            None => Role::Nothing,
        }
    }

    fn index(&self, label: Label) -> u16 {
        self.labels.binary_search(&label).unwrap_or(0).min(usize::from(u16::MAX)) as u16
    }
}

/// The materials of a network that are drawn as glass.
pub fn glass_of(mesh: &Mesh) -> Vec<Label> {
    glass_labels(&shared_areas(mesh))
}

fn occurring_labels(
    on_mesh: impl Iterator<Item = Label>,
    sections: &[Section],
    selection: Selection,
) -> Vec<Label> {
    let mut labels: Vec<Label> = on_mesh
        .chain(sections.iter().flat_map(Section::labels))
        .filter(|&label| selection.shows(label))
        .collect();
    labels.sort_unstable();
    labels.dedup();
    labels
}

fn paint(label: Label, materials: &[Material]) -> Paint {
    let known = materials.iter().find(|material| material.id == label.0).cloned();
    let Material { name, color, .. } = known.unwrap_or_else(|| Material::numbered(label));
    Paint { name, color }
}

/// A material shows when at least this part of its surface borders on outside
/// or on glass.
const SHOWN_PART: f64 = 0.15;

/// The materials to draw as glass: as long as there is a hidden material, the
/// neighbour that it shares most of its surface with becomes glass. Those that
/// border least on outside come last: they count as inner ones.
fn glass_labels(shared: &Shared) -> Vec<Label> {
    let mut glass: Vec<Label> = Vec::new();
    loop {
        let most_hidden = shared
            .iter()
            .filter(|(label, _)| !glass.contains(label))
            .filter_map(|(_, areas)| hider(areas, &glass))
            .min_by(|(one, _), (other, _)| one.total_cmp(other));
        let Some((_, label)) = most_hidden else {
            let open = |label: &Label| shown_part(&shared[label], &[]);
            glass.sort_by(|one, other| open(other).total_cmp(&open(one)).then(one.cmp(other)));
            return glass;
        };
        glass.push(label);
    }
}

/// For a material that does not show, the part of it that does and the solid
/// neighbour that hides most of it.
fn hider(areas: &BTreeMap<Label, f64>, glass: &[Label]) -> Option<(f64, Label)> {
    let (&label, _) = areas
        .iter()
        .filter(|&(&label, _)| !is_clear(label, glass))
        .max_by(|(_, one), (_, other)| one.total_cmp(other))?;
    let part = shown_part(areas, glass);
    (part < SHOWN_PART).then_some((part, label))
}

fn is_clear(label: Label, glass: &[Label]) -> bool {
    !label.is_material() || glass.contains(&label)
}

/// The part of a material's surface that borders on outside or on glass.
fn shown_part(areas: &BTreeMap<Label, f64>, glass: &[Label]) -> f64 {
    let shown: f64 =
        areas.iter().filter(|&(&label, _)| is_clear(label, glass)).map(|(_, area)| area).sum();
    shown / areas.values().sum::<f64>()
}

/// For every material the area that it shares with each neighbour.
type Shared = BTreeMap<Label, BTreeMap<Label, f64>>;

fn shared_areas(mesh: &Mesh) -> Shared {
    let mut shared = Shared::new();
    let mut first = 0;
    for run in mesh.sides.chunk_by(PartialEq::eq) {
        let area: f64 = mesh.triangles[first..][..run.len()].iter().map(|t| area(mesh, t)).sum();
        first += run.len();
        let [back, front] = run[0];
        for (label, neighbor) in [(back, front), (front, back)] {
            if label.is_material() {
                *shared.entry(label).or_default().entry(neighbor).or_default() += area;
            }
        }
    }
    shared
}

fn area(mesh: &Mesh, triangle: &[u32; 3]) -> f64 {
    let [a, b, c] = triangle.map(|vertex| mesh.vertices[vertex as usize]);
    (b - a).cross(c - a).length() / 2.0
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::picture::view::tests::sphere;

    #[test]
    fn a_body_around_an_organ_is_glass_and_the_organ_solid() {
        let mut mesh = sphere(DVec3::ZERO, 2.0, [Label(1), Label(0)]);
        mesh.append(sphere(DVec3::ZERO, 1.0, [Label(1), Label(2)]).flipped());
        let scene = Scene::new(&mesh.mesh, &[], &[], Selection::default());
        assert_eq!(scene.glass.len(), 1);
        assert_eq!(scene.glass[0].facets[0].material, 0);
        assert!(scene.solid.facets.iter().all(|facet| facet.material == 1));
        // The organ's facets face outward, though the network has them inward.
        let outward = scene
            .solid
            .normals
            .iter()
            .zip(&scene.solid.facets)
            .all(|(n, facet)| n[0].dot(scene.points[facet.corners[0] as usize]) > 0.0);
        assert!(outward);
    }

    #[test]
    fn glass_within_glass_is_still_drawn() {
        // Label 1 is the outermost, 2 in it, 3 in the middle.
        let mut mesh = sphere(DVec3::ZERO, 3.0, [Label(1), Label(0)]);
        mesh.append(sphere(DVec3::ZERO, 2.0, [Label(1), Label(2)]).flipped());
        mesh.append(sphere(DVec3::ZERO, 1.0, [Label(2), Label(3)]).flipped());
        let scene = Scene::new(&mesh.mesh, &[], &[], Selection::default());
        assert_eq!(scene.glass.len(), 2);
        let shown = |layer: &Layer| layer.facets.iter().map(|facet| facet.material).max();
        assert_eq!(shown(&scene.glass[0]), Some(0));
        assert_eq!(shown(&scene.glass[1]), Some(1), "the wall of label 2 is its own");
        assert_eq!(shown(&scene.solid), Some(2));
    }

    #[test]
    fn organs_side_by_side_are_solid() {
        let mut mesh = sphere(DVec3::ZERO, 1.0, [Label(1), Label(0)]);
        mesh.append(sphere(DVec3::X * 3.0, 1.0, [Label(4), Label(0)]));
        let scene = Scene::new(&mesh.mesh, &[], &[], Selection::default());
        assert!(scene.glass.is_empty());
        assert_eq!(scene.materials.len(), 2);
    }
}
