//! Meshes as binary glTF 2.0 (`.glb`), for graphics programs: a node with a mesh and a material
//! for each label, in metres, y up and z to the front.

use std::collections::BTreeMap;
use std::io::{Error, Result, Write};

use glam::{DMat3, Vec3};
use gltf_json::accessor::{ComponentType, GenericComponentType, Type};
use gltf_json::buffer::{Target, View};
use gltf_json::material::{PbrBaseColorFactor, PbrMetallicRoughness, StrengthFactor};
use gltf_json::mesh::{Mode, Primitive, Semantic};
use gltf_json::validation::Checked::Valid;
use gltf_json::validation::USize64;
use gltf_json::{Accessor, Asset, Buffer, Extras, Index, Material, Node, Root, Scene};
use serde_json::json;
use serde_json::value::to_raw_value;

use super::bodies::{Body, bodies};
use super::mesh::About;
use super::units;
use crate::color::linear;
use crate::mesh::Mesh;

/// How often its diagonal a mesh may be away from the origin. Farther, single precision would
/// show, and its nodes are moved there instead.
const FAR: f64 = 16.0;
/// Dull, as tissue is.
const ROUGHNESS: f32 = 0.7;
/// Bytes of a vertex, its place and its normal, and of a triangle.
const VERTEX: u64 = 24;
const TRIANGLE: u64 = 12;

/// Writes the surface of every label, with one normal for each vertex.
pub fn write(mesh: &Mesh, about: &About, out: &mut dyn Write) -> Result<()> {
    let bodies = bodies(mesh, about);
    let lengths = bodies.iter().map(|Body { surface, .. }| {
        surface.vertices.len() as u64 * VERTEX + surface.triangles.len() as u64 * TRIANGLE
    });
    let length: u64 = lengths.sum();
    let length = count(usize::try_from(length).unwrap_or(usize::MAX))?;
    let mut scene = Composer::new(mesh, about);
    scene.binary.reserve_exact(length as usize);
    for body in &bodies {
        scene.add(body)?;
    }
    scene.write(about, out)
}

/// A scene that comes together.
struct Composer {
    root: Root,
    nodes: Vec<Index<Node>>,
    binary: Vec<u8>,
    /// From world coordinates to metres, less `origin`.
    axes: DMat3,
    /// Where all nodes are, in metres.
    origin: Option<Vec3>,
}

impl Composer {
    fn new(mesh: &Mesh, about: &About) -> Self {
        let [x, y, z] = about.sides.axes();
        let axes = DMat3::from_cols(x, y, z).transpose() * units::metres(about.units);
        let origin = mesh.bounds().and_then(|bounds| {
            let middle = bounds.min.midpoint(bounds.max);
            (middle.length() > FAR * bounds.diagonal()).then(|| (axes * middle).as_vec3())
        });
        Self { root: Root::default(), nodes: Vec::new(), binary: Vec::new(), axes, origin }
    }

    fn add(&mut self, body: &Body) -> Result<()> {
        let Body { material, surface } = body;
        let name = Some(material.name.clone());
        let origin = self.origin.unwrap_or_default().as_dvec3();
        let places = surface.vertices.iter().map(|&vertex| self.axes * vertex - origin);
        let places: Vec<Vec3> = places.map(|place| place.as_vec3()).collect();
        let normals = surface.vertex_normals().into_iter();
        // Of length 1 after a rotation in double precision too.
        let normals: Vec<Vec3> =
            normals.map(|normal| (self.axes * normal).normalize().as_vec3()).collect();
        let least = places.iter().copied().reduce(Vec3::min).unwrap_or_default();
        let most = places.iter().copied().reduce(Vec3::max).unwrap_or_default();
        if !(least.is_finite() && most.is_finite()) {
            let what = "a coordinate is too large for glTF's single precision: write another kind";
            return Err(Error::other(what));
        }
        let corners = surface.triangles.as_flattened();
        let places = self.vectors(&places);
        let normals = self.vectors(&normals);
        let accessor = &mut self.root.accessors[places.value()];
        (accessor.min, accessor.max) =
            (Some(json!(least.to_array())), Some(json!(most.to_array())));
        let indices = corners.iter().map(|corner| corner.to_le_bytes());
        let indices = self.array(Target::ElementArrayBuffer, Type::Scalar, indices);
        let primitive = Primitive {
            attributes: BTreeMap::from([
                (Valid(Semantic::Positions), places),
                (Valid(Semantic::Normals), normals),
            ]),
            indices: Some(indices),
            material: Some(self.material(body)),
            mode: Valid(Mode::Triangles),
            targets: None,
            extensions: None,
            extras: Extras::default(),
        };
        let mesh = self.root.push(gltf_json::Mesh {
            name: name.clone(),
            primitives: vec![primitive],
            weights: None,
            extensions: None,
            extras: Extras::default(),
        });
        self.nodes.push(self.root.push(Node {
            name,
            mesh: Some(mesh),
            translation: self.origin.map(|origin| origin.to_array()),
            extras: extras(&json!({ "label": material.id }))?,
            ..Node::default()
        }));
        Ok(())
    }

    fn material(&mut self, Body { material, surface }: &Body) -> Index<Material> {
        let color = linear(material.color).extend(1.0).to_array();
        self.root.push(Material {
            name: Some(material.name.clone()),
            // An open surface is seen from within.
            double_sided: surface.first_gap().is_some(),
            pbr_metallic_roughness: PbrMetallicRoughness {
                base_color_factor: PbrBaseColorFactor(color),
                metallic_factor: StrengthFactor(0.0),
                roughness_factor: StrengthFactor(ROUGHNESS),
                ..PbrMetallicRoughness::default()
            },
            ..Material::default()
        })
    }

    fn vectors(&mut self, vectors: &[Vec3]) -> Index<Accessor> {
        let bytes = vectors.iter().map(|vector| {
            let mut bytes = [0; 12];
            for (part, number) in bytes.chunks_exact_mut(4).zip(vector.to_array()) {
                part.copy_from_slice(&number.to_le_bytes());
            }
            bytes
        });
        self.array(Target::ArrayBuffer, Type::Vec3, bytes)
    }

    /// Adds an array. Its numbers have four bytes each, which keeps all arrays aligned.
    fn array<const N: usize>(
        &mut self,
        target: Target,
        kind: Type,
        items: impl ExactSizeIterator<Item = [u8; N]>,
    ) -> Index<Accessor> {
        let (start, count) = (self.binary.len(), items.len());
        self.binary.extend(items.flatten());
        let view = self.root.push(View {
            buffer: Index::new(0),
            byte_length: USize64::from(self.binary.len() - start),
            byte_offset: Some(USize64::from(start)),
            byte_stride: None,
            name: None,
            target: Some(Valid(target)),
            extensions: None,
            extras: Extras::default(),
        });
        let component = match kind {
            Type::Scalar => ComponentType::U32,
            _ => ComponentType::F32,
        };
        self.root.push(Accessor {
            buffer_view: Some(view),
            byte_offset: None,
            count: USize64::from(count),
            component_type: Valid(GenericComponentType(component)),
            type_: Valid(kind),
            min: None,
            max: None,
            name: None,
            normalized: false,
            sparse: None,
            extensions: None,
            extras: Extras::default(),
        })
    }

    /// The header, and two chunks whose lengths are multiples of four.
    fn write(mut self, about: &About, out: &mut dyn Write) -> Result<()> {
        self.root.asset = Asset { generator: Some("transect".to_owned()), ..Asset::default() };
        // Neither a scene nor a buffer may be empty.
        if !self.nodes.is_empty() {
            let scene = self.root.push(Scene {
                name: None,
                nodes: self.nodes,
                extensions: None,
                extras: extras(&json!({ "frame": about.frame, "units": about.units }))?,
            });
            self.root.scene = Some(scene);
            self.root.push(Buffer {
                byte_length: USize64::from(self.binary.len()),
                name: None,
                uri: None,
                extensions: None,
                extras: Extras::default(),
            });
        }
        let mut text = serde_json::to_vec(&self.root)?;
        text.resize(text.len().next_multiple_of(4), b' ');
        let chunks = [(b"JSON", &text), (b"BIN\0", &self.binary)];
        let chunks = chunks.iter().filter(|(_, bytes)| !bytes.is_empty());
        let length: usize = 12 + chunks.clone().map(|(_, bytes)| 8 + bytes.len()).sum::<usize>();
        out.write_all(b"glTF")?;
        out.write_all(&2u32.to_le_bytes())?;
        out.write_all(&count(length)?.to_le_bytes())?;
        for (name, bytes) in chunks {
            out.write_all(&count(bytes.len())?.to_le_bytes())?;
            out.write_all(*name)?;
            out.write_all(bytes)?;
        }
        Ok(())
    }
}

fn extras(value: &serde_json::Value) -> Result<Extras> {
    Ok(Some(to_raw_value(value)?))
}

fn count(bytes: usize) -> Result<u32> {
    u32::try_from(bytes)
        .map_err(|_| Error::other("glTF cannot count this many bytes: write another kind"))
}

#[cfg(test)]
mod tests {
    use glam::DVec3;
    use gltf_json::validation::Validate;

    use super::*;
    use crate::io::bodies::tests::{materials, two_tetrahedra};
    use crate::section::Sections;
    use crate::sides::Sides;

    /// What a file says, and its binary part.
    fn parts(bytes: &[u8]) -> (Root, &[u8]) {
        let number = |at: usize| {
            u32::from_le_bytes(*bytes[at..].first_chunk::<4>().expect("a number")) as usize
        };
        assert_eq!((&bytes[..4], number(4), number(8)), (&b"glTF"[..], 2, bytes.len()));
        let length = number(12);
        assert_eq!((length % 4, &bytes[16..20]), (0, &b"JSON"[..]));
        let root = Root::from_slice(&bytes[20..20 + length]).expect("JSON");
        let mut errors = Vec::new();
        root.validate(&root, gltf_json::Path::new, &mut |path, error| {
            errors.push(format!("{}: {error}", path()));
        });
        assert!(errors.is_empty(), "{errors:?}");
        let rest = bytes.get(28 + length..).unwrap_or_default();
        (root, rest)
    }

    /// The places of the vertices of a node, as whoever shows them has them.
    fn places(root: &Root, binary: &[u8], node: usize) -> Vec<Vec3> {
        let node = &root.nodes[node];
        let mesh = &root.meshes[node.mesh.expect("a mesh").value()];
        let places = mesh.primitives[0].attributes[&Valid(Semantic::Positions)];
        let accessor = &root.accessors[places.value()];
        let view = &root.buffer_views[accessor.buffer_view.expect("a view").value()];
        let start = view.byte_offset.expect("an offset").0 as usize;
        let bytes = &binary[start..start + view.byte_length.0 as usize];
        let numbers: Vec<f32> =
            bytes.as_chunks::<4>().0.iter().map(|&number| f32::from_le_bytes(number)).collect();
        let origin = Vec3::from(node.translation.unwrap_or_default());
        numbers.as_chunks::<3>().0.iter().map(|&place| Vec3::from(place) + origin).collect()
    }

    fn written(mesh: &Mesh, about: &About) -> Vec<u8> {
        let mut bytes = Vec::new();
        write(mesh, about, &mut bytes).unwrap();
        bytes
    }

    #[test]
    fn every_label_is_a_node_with_a_name_and_a_colour_in_linear_light() {
        let materials = materials();
        let bytes =
            written(&two_tetrahedra(), &About { materials: &materials, ..About::default() });
        let (root, binary) = parts(&bytes);
        assert_eq!(binary.len() as u64, root.buffers[0].byte_length.0);
        let names: Vec<_> = root.nodes.iter().map(|node| node.name.as_deref()).collect();
        assert_eq!(names, [Some("a <b>"), Some("c")]);
        let [r, g, b, a] = root.materials[0].pbr_metallic_roughness.base_color_factor.0;
        assert_eq!((r, b, a), (1.0, 0.0, 1.0));
        assert!((g - 0.2158605).abs() < 1e-6, "128 of 255 is a fifth of the light: {g}");
        assert!(!root.materials[0].double_sided);
        // Vertices are shared: four for four triangles.
        let counts: Vec<u64> = root.accessors.iter().map(|accessor| accessor.count.0).collect();
        assert_eq!(counts, [4, 4, 12, 4, 4, 12]);
    }

    #[test]
    fn a_patient_stands_upright_in_metres() {
        for (frame, left) in [("LPS", 1.0), ("RAS", -1.0)] {
            let sections = Sections { frame: frame.to_owned(), ..Sections::default() };
            let about = About { units: "cm", sides: Sides::of(&sections), ..About::default() };
            let bytes = written(&two_tetrahedra(), &about);
            let (root, binary) = parts(&bytes);
            let found = places(&root, binary, 0);
            // The vertices at 0, x, y and z: to the left, to the back, up.
            for expected in [Vec3::ZERO, Vec3::X * left, Vec3::Z * -left, Vec3::Y] {
                let expected = expected * 0.01;
                let nearest = found.iter().map(|place| place.distance(expected));
                assert!(nearest.fold(1.0, f32::min) < 1e-9, "{frame}: {found:?}");
            }
        }
    }

    #[test]
    fn what_is_far_from_the_origin_keeps_its_shape() {
        let mut mesh = two_tetrahedra();
        for vertex in &mut mesh.vertices {
            *vertex += DVec3::new(500_000.0, 5_400_000.0, 0.0);
        }
        let bytes = written(&mesh, &About { units: "m", ..About::default() });
        let (root, binary) = parts(&bytes);
        let origin = root.nodes[0].translation.expect("it is far");
        assert!((origin[2] + 5_400_000.0).abs() < 2.0, "y is to the back: {origin:?}");
        let mut root = root;
        root.nodes[0].translation = None;
        let found = places(&root, binary, 0);
        let corner = found.iter().fold(Vec3::splat(9.0), |least, &place| least.min(place));
        let size = found.iter().fold(Vec3::ZERO, |most, &place| most.max(place - corner));
        assert_eq!(size, Vec3::ONE);
    }

    #[test]
    fn nothing_is_a_file_too() {
        let bytes = written(&Mesh::default(), &About::default());
        let (root, binary) = parts(&bytes);
        assert!(root.nodes.is_empty() && root.buffers.is_empty() && binary.is_empty());
    }
}
