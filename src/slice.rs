//! Sections from solids: a closed mesh, exact to rounding, or a volume of
//! labels, cut by planes.

use glam::DVec3;
use rayon::prelude::*;

use crate::error::{Error, Result};
use crate::label::Label;
use crate::mesh::Mesh;
use crate::mesh::cut::Cut;
use crate::plane::{Bounds, Plane};
use crate::random::Random;
use crate::section::{Rules, Section, Warning};
use crate::volume::LabelVolume;

/// The planes of a cut.
#[derive(Debug, Clone, PartialEq)]
pub enum Family {
    /// `count` planes normal to an axis (0, 1 or 2), number i at the part
    /// (i + ½)/count of the solid's extent.
    Axis {
        /// x, y or z.
        axis: usize,
        /// How many.
        count: u32,
    },
    /// Planes of random orientation through random places in the solid's box;
    /// the same ones for the same seed.
    Random {
        /// How many.
        count: u32,
        /// What they are drawn from.
        seed: u64,
    },
    /// These.
    Given(Vec<Plane>),
}

impl Family {
    /// The planes that cut a solid within these bounds.
    ///
    /// # Errors
    /// When the axis is none of 0, 1 and 2, or a given plane is none.
    pub fn planes(&self, bounds: &Bounds) -> Result<Vec<Plane>> {
        match self {
            &Self::Axis { axis: axis @ 0..3, count } => Ok((0..count)
                .map(|i| {
                    let part = (f64::from(i) + 0.5) / f64::from(count);
                    let offset = bounds.min[axis] + part * bounds.size()[axis];
                    Plane { normal: DVec3::AXES[axis], offset }
                })
                .collect()),
            Self::Axis { axis, .. } => {
                Err(Error::Option(format!("there is no axis {axis}: the axes are 0, 1 and 2")))
            }
            &Self::Random { count, seed } => {
                let mut random = Random::new(seed);
                Ok((0..count).map(|_| random_plane(&mut random, bounds)).collect())
            }
            Self::Given(planes) => match planes.iter().find(|plane| !is_plane(plane)) {
                Some(plane) => Err(Error::Option(format!(
                    "normal {} and offset {} are no plane: the normal must not be zero, and all \
                     numbers finite",
                    plane.normal, plane.offset
                ))),
                None => Ok(planes.clone()),
            },
        }
    }
}

fn is_plane(plane: &Plane) -> bool {
    plane.normal.is_finite() && plane.offset.is_finite() && plane.normal != DVec3::ZERO
}

/// A uniform normal (Archimedes: heights on a sphere are uniform) through a
/// uniform place in the box.
fn random_plane(random: &mut Random, bounds: &Bounds) -> Plane {
    let height = 2.0 * random.unit() - 1.0;
    let angle = std::f64::consts::TAU * random.unit();
    let radius = (1.0 - height * height).sqrt();
    let normal = DVec3::new(radius * angle.cos(), radius * angle.sin(), height);
    let part = DVec3::new(random.unit(), random.unit(), random.unit());
    Plane { normal, offset: normal.dot(bounds.min + part * bounds.size()) }
}

/// Cuts a closed mesh by planes, one section each, in their order.
///
/// Every crossing is computed once per mesh edge, from its two ends in a fixed
/// order, so that contours close; vertices on a plane count as above it. The
/// labels beside a contour are those beside the mesh's triangles. A plane that
/// misses the mesh gives a section that is outside everywhere.
///
/// Of a solid of one material, what its surface winds around is inside, whichever
/// way round and how often ([`slice_with_warnings`]).
///
/// # Errors
/// When the mesh is empty, damaged or not closed, and when it has several materials
/// and its cut is no partition of the plane.
pub fn slice(mesh: &Mesh, planes: &[Plane]) -> Result<Vec<Section>> {
    slice_with_warnings(mesh, planes).map(|(sections, _)| sections)
}

/// The same, with what had to be made right: surfaces that face inward, and such as
/// overlap.
///
/// # Errors
/// As [`slice()`].
pub fn slice_with_warnings(mesh: &Mesh, planes: &[Plane]) -> Result<(Vec<Section>, Vec<Warning>)> {
    check(mesh)?;
    let diagonal = mesh.bounds().map_or(0.0, |bounds| bounds.diagonal());
    let material = only_material(mesh);
    let cuts = planes.par_iter().enumerate();
    let cuts = cuts.map(|(number, plane)| cut(mesh, material, number, plane, diagonal));
    let (sections, windings): (Vec<Section>, Vec<[i32; 2]>) =
        cuts.collect::<Result<Vec<_>>>()?.into_iter().unzip();
    let found = |is_found: fn(&[i32; 2]) -> bool, what: &str| {
        let count = windings.iter().filter(|range| is_found(range)).count();
        let what = format!("on {count} of {} planes the mesh {what}", planes.len());
        (count > 0).then_some(Warning { section: String::new(), what })
    };
    let inward = found(
        |range| range[0] < 0,
        "faces inward, in part or everywhere: what it encloses counts as inside, as if it were \
         turned round",
    );
    let overlapping = found(
        |range| range[0] < -1 || range[1] > 1,
        "overlaps itself, or has a shell within another that faces the same way: what is inside \
         of any of them counts as inside (turn a shell round that is meant as a cavity)",
    );
    Ok((sections, inward.into_iter().chain(overlapping).collect()))
}

/// The material of a mesh between it and outside alone.
fn only_material(mesh: &Mesh) -> Option<Label> {
    let &[material, _] = mesh.sides.first()?;
    mesh.sides.iter().all(|&sides| sides == [material, Label::OUTSIDE]).then_some(material)
}

/// A section, and the least and largest number of times that the mesh winds around a place.
fn cut(
    mesh: &Mesh,
    material: Option<Label>,
    number: usize,
    plane: &Plane,
    diagonal: f64,
) -> Result<(Section, [i32; 2])> {
    let (name, rules) = (format!("plane {}", number + 1), Rules::default());
    let Cut { points, edges } = mesh.cut(plane);
    let drawn = Section::from_graph(&name, *plane, &points, &edges, diagonal, &rules);
    match (drawn, material) {
        (Ok((section, _)), _) if section.background() == Label::OUTSIDE => Ok((section, [0, 1])),
        (_, Some(material)) => {
            let Cut { points, edges } = mesh.segments(plane);
            Section::from_windings(&name, *plane, &points, &edges, material, diagonal)
        }
        (Ok(_), None) => Err(Error::Mesh(format!("is inside out on {name}; turn it round first"))),
        (Err(Error::Section { .. }), None) => Err(Error::Mesh(format!(
            "has labels that do not fit together on {name} (normal {}, offset {}): it crosses \
             itself there, or a part of it is turned the wrong way; repair it first",
            plane.normal, plane.offset
        ))),
        (Err(error), None) => Err(error),
    }
}

/// Cuts a volume of labels by planes, one section each, in their order. The
/// label of a point is the one with the largest share of the voxels around it,
/// so that borders run between voxels; beyond the volume is outside.
///
/// # Errors
/// When all of it is outside.
pub fn slice_volume(volume: &LabelVolume, planes: &[Plane]) -> Result<Vec<Section>> {
    let bounds = volume.bounds().ok_or_else(|| Error::Option(NOTHING.to_owned()))?;
    sections(planes, bounds.diagonal(), |plane| volume.cut(plane))
}

/// What is wrong with a volume that holds 0 alone.
const NOTHING: &str = "it holds no label but 0, which is outside: there is nothing to cut";

/// One section a plane, in their order.
fn sections(
    planes: &[Plane],
    diagonal: f64,
    cut: impl Fn(&Plane) -> Cut + Sync,
) -> Result<Vec<Section>> {
    planes
        .par_iter()
        .enumerate()
        .map(|(number, plane)| {
            let cut = cut(plane);
            let name = format!("plane {}", number + 1);
            // Nobody is told of what is doubtful.
            let rules = Rules { strict: true, ..Rules::default() };
            Section::from_graph(&name, *plane, &cut.points, &cut.edges, diagonal, &rules)
                .map(|(section, _)| section)
        })
        .collect()
}

/// Whether the mesh is sound and closed.
fn check(mesh: &Mesh) -> Result<()> {
    if mesh.triangles.is_empty() {
        return Err(Error::Mesh("has no triangles: there is nothing to cut".to_owned()));
    }
    if mesh.sides.len() != mesh.triangles.len() {
        let what = format!(
            "has {} triangles, but labels for {} of them",
            mesh.triangles.len(),
            mesh.sides.len()
        );
        return Err(Error::Mesh(what));
    }
    let count = mesh.vertices.len();
    let missing = |triangle: &[u32; 3]| triangle.iter().find(|&&v| v as usize >= count).copied();
    if let Some((number, vertex)) =
        mesh.triangles.iter().enumerate().find_map(|(i, triangle)| Some((i, missing(triangle)?)))
    {
        let what = format!("has {count} vertices, but triangle {number} asks for vertex {vertex}");
        return Err(Error::Mesh(what));
    }
    if let Some(number) = mesh.vertices.iter().position(|vertex| !vertex.is_finite()) {
        let what = format!("has a vertex that is not finite, number {number}: correct it");
        return Err(Error::Mesh(what));
    }
    check_closed(mesh)
}

/// A triangle's side, from the smaller vertex to the larger one, and a label
/// that lies behind (+1) or before (−1) the triangle as it runs that way.
type Border = ([u32; 2], Label, i32);

/// A label's region is closed when along every edge its triangles cancel: as
/// many run one way as the other.
fn check_closed(mesh: &Mesh) -> Result<()> {
    let mut borders: Vec<Border> = mesh
        .triangles
        .par_iter()
        .zip(&mesh.sides)
        .flat_map_iter(|(&triangle, &sides)| borders_of(triangle, sides))
        .collect();
    borders.par_sort_unstable();
    let open: Vec<[u32; 2]> = borders
        .chunk_by(|one, other| (one.0, one.1) == (other.0, other.1))
        .filter(|run| run.iter().map(|border| border.2).sum::<i32>() != 0)
        .map(|run| run[0].0)
        .collect();
    let Some(&edge) = open.first() else { return Ok(()) };
    let [from, to] = edge.map(|vertex| mesh.vertices[vertex as usize]);
    Err(Error::Mesh(format!(
        "is not closed, or its triangles do not agree on which side is out: {} of its edges are \
         open, the first from {from} to {to}; repair it first",
        open.len()
    )))
}

fn borders_of(triangle: [u32; 3], [back, front]: [Label; 2]) -> impl Iterator<Item = Border> {
    (0..3).flat_map(move |i| {
        let (start, end) = (triangle[i], triangle[(i + 1) % 3]);
        let way = if start < end { 1 } else { -1 };
        [(back, way), (front, -way)]
            .into_iter()
            .filter(move |_| start != end && back != front)
            .filter(|(label, _)| label.is_material())
            .map(move |(label, way)| ([start.min(end), start.max(end)], label, way))
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::grid::samples::Lattice;
    use crate::mesh::{dual, shapes};
    use crate::progress::Silent;

    const UNIT: Bounds = Bounds { min: DVec3::ZERO, max: DVec3::ONE };

    /// A tetrahedron with right angles at the origin and legs of this length.
    fn tetrahedron(leg: f64) -> Mesh {
        let vertices = vec![DVec3::ZERO, DVec3::X * leg, DVec3::Y * leg, DVec3::Z * leg];
        let triangles = vec![[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]];
        Mesh { vertices, triangles, sides: vec![[Label(1), Label::OUTSIDE]; 4] }
    }

    #[test]
    fn planes_along_an_axis_are_in_the_middle_of_equal_parts() {
        let planes = Family::Axis { axis: 1, count: 4 }.planes(&UNIT).expect("an axis");
        let offsets: Vec<f64> = planes.iter().map(|plane| plane.offset).collect();
        assert_eq!(offsets, [0.125, 0.375, 0.625, 0.875]);
        assert!(planes.iter().all(|plane| plane.normal == DVec3::Y));
    }

    #[test]
    fn random_planes_depend_on_the_seed_alone_and_go_through_the_box() {
        let planes = |seed| Family::Random { count: 50, seed }.planes(&UNIT).expect("planes");
        assert_eq!(planes(7), planes(7));
        assert_ne!(planes(7), planes(8));
        for plane in planes(7) {
            assert!((plane.normal.length() - 1.0).abs() < 1e-12);
            let corners =
                (0..8u32).map(|i| DVec3::from([i & 1, i >> 1 & 1, i >> 2].map(f64::from)));
            let above = corners.filter(|&corner| plane.distance(corner) > 0.0).count();
            assert!((1..8).contains(&above));
        }
    }

    #[test]
    fn what_is_no_plane_is_refused() {
        let zero = Plane { normal: DVec3::ZERO, offset: 1.0 };
        let infinite = Plane { normal: DVec3::Z, offset: f64::INFINITY };
        for plane in [zero, infinite] {
            assert!(Family::Given(vec![plane]).planes(&UNIT).is_err());
        }
        assert!(Family::Axis { axis: 3, count: 1 }.planes(&UNIT).is_err());
    }

    #[test]
    fn an_open_mesh_is_refused_with_the_place() {
        let mut mesh = tetrahedron(2.0);
        assert!(check(&mesh).is_ok());
        mesh.triangles.pop();
        mesh.sides.pop();
        let message = check(&mesh).expect_err("three edges are open").to_string();
        assert!(message.contains("3 of its edges"), "{message}");
        assert!(message.contains("[2, 0, 0] to [0, 2, 0]"), "{message}");
    }

    #[test]
    fn a_triangle_turned_round_is_refused() {
        let mut mesh = tetrahedron(1.0);
        mesh.triangles[2].swap(0, 1);
        assert!(check(&mesh).is_err());
    }

    #[test]
    fn labels_that_do_not_close_are_refused() {
        let mut mesh = tetrahedron(1.0);
        mesh.sides[1] = [Label(2), Label::OUTSIDE];
        assert!(check(&mesh).is_err());
    }

    /// Two meshes as one.
    fn both(one: &Mesh, other: &Mesh) -> Mesh {
        let first = one.vertices.len() as u32;
        let moved = other.triangles.iter().map(|triangle| triangle.map(|corner| corner + first));
        Mesh {
            vertices: [&one.vertices[..], &other.vertices].concat(),
            triangles: one.triangles.iter().copied().chain(moved).collect(),
            sides: [&one.sides[..], &other.sides].concat(),
        }
    }

    fn turned(mut mesh: Mesh) -> Mesh {
        mesh.triangles.iter_mut().for_each(|triangle| triangle.swap(0, 1));
        mesh
    }

    fn moved(mut mesh: Mesh, by: DVec3) -> Mesh {
        mesh.vertices.iter_mut().for_each(|vertex| *vertex += by);
        mesh
    }

    /// On the plane z = 1 the legs of a tetrahedron of 3 are 2, those of one within it a half,
    /// and those of what it has in common with one beside it 1.
    #[test]
    fn what_a_surface_winds_around_is_inside_whichever_way_and_how_often() {
        let own = tetrahedron(3.0);
        let far = moved(own.clone(), DVec3::X * 5.0);
        let beside = moved(own.clone(), DVec3::X);
        let inner = moved(tetrahedron(1.0), DVec3::new(0.25, 0.25, 0.5));
        let cases: [(&str, Mesh, f64, &[&str]); 8] = [
            ("a solid", own.clone(), 2.0, &[]),
            ("inside out", turned(own.clone()), 2.0, &["faces inward"]),
            ("one of two inside out", both(&own, &turned(far.clone())), 4.0, &["faces inward"]),
            ("both inside out", turned(both(&own, &far)), 4.0, &["faces inward"]),
            ("overlapping", both(&own, &beside), 3.5, &["overlaps itself"]),
            ("one within", both(&own, &inner), 2.0, &["overlaps itself"]),
            ("a cavity", both(&own, &turned(inner.clone())), 1.875, &[]),
            ("a cavity, inside out", both(&turned(own.clone()), &inner), 1.875, &["faces inward"]),
        ];
        for (name, mesh, expected, words) in cases {
            for sign in [1.0, -1.0] {
                let plane = Plane { normal: DVec3::Z * sign, offset: sign };
                let (sections, warnings) = slice_with_warnings(&mesh, &[plane]).expect(name);
                assert!((area(&sections[0], Label(1)) - expected).abs() < 1e-12, "{name}");
                assert_eq!(sections[0].background(), Label::OUTSIDE, "{name}");
                assert_eq!(warnings.len(), words.len(), "{name}: {warnings:?}");
                for (warning, word) in warnings.iter().zip(words) {
                    assert!(warning.what.contains(word), "{name}: {warning:?}");
                }
            }
        }
        // The same surface twice is there once.
        let (triangles, sides) = (own.triangles.repeat(2), own.sides.repeat(2));
        let twice = Mesh { triangles, sides, ..own.clone() };
        assert_eq!(area(&one_section(&twice, DVec3::Z, 1.0), Label(1)), 2.0);
        // Of several materials the labels say what is where.
        let mut two = both(&own, &beside);
        two.sides[4..].fill([Label(2), Label::OUTSIDE]);
        let plane = Plane { normal: DVec3::Z, offset: 1.0 };
        let error = slice(&two, &[plane]).expect_err("they overlap").to_string();
        assert!(
            error.contains("the mesh has labels that do not fit together on plane 1"),
            "{error}"
        );
    }

    #[test]
    fn damaged_meshes_are_refused() {
        assert!(check(&Mesh::default()).is_err());
        let mut mesh = tetrahedron(1.0);
        mesh.triangles[0][0] = 4;
        assert!(check(&mesh).expect_err("no vertex 4").to_string().contains("vertex 4"));
        let mut mesh = tetrahedron(1.0);
        mesh.vertices[3].x = f64::NAN;
        assert!(check(&mesh).expect_err("not a number").to_string().contains("number 3"));
    }

    /// The area of a label on a section, by the shoelace formula on the plane.
    fn area(section: &Section, label: Label) -> f64 {
        let normal = section.plane().unit_normal();
        let base = section.edges().first().map_or(DVec3::ZERO, |edge| section.point(edge.start));
        let swept = |start: u32, end: u32| {
            (section.point(start) - base).cross(section.point(end) - base).dot(normal) / 2.0
        };
        let edges = section.edges().iter();
        edges
            .map(|edge| match label {
                _ if edge.left == label => swept(edge.start, edge.end),
                _ if edge.right == label => swept(edge.end, edge.start),
                _ => 0.0,
            })
            .sum()
    }

    fn one_section(mesh: &Mesh, normal: DVec3, offset: f64) -> Section {
        slice(mesh, &[Plane { normal, offset }]).expect("a closed mesh").remove(0)
    }

    #[test]
    fn a_tetrahedron_is_cut_in_a_triangle() {
        // At a quarter of its height the legs are three quarters: 1.5.
        let section = one_section(&tetrahedron(2.0), DVec3::Z, 0.5);
        assert_eq!(section.vertices().len(), 3);
        assert_eq!(area(&section, Label(1)), 1.125);
        // Seen from below the same region is on the same side of its border.
        let below = one_section(&tetrahedron(2.0), DVec3::NEG_Z, -0.5);
        assert_eq!(area(&below, Label(1)), 1.125);
        assert_eq!(below.background(), Label::OUTSIDE);
    }

    #[test]
    fn slices_add_up_to_the_volume() {
        // The area at height z is (1 − z)²/2; the midpoint rule misses its
        // integral by h²/24 times the change of its derivative, here 1: 4e-6.
        let mesh = tetrahedron(1.0);
        let bounds = mesh.bounds().expect("vertices");
        let planes = Family::Axis { axis: 2, count: 100 }.planes(&bounds).expect("an axis");
        let sections = slice(&mesh, &planes).expect("a closed mesh");
        let volume: f64 = sections.iter().map(|section| area(section, Label(1)) / 100.0).sum();
        assert!((volume - 1.0 / 6.0).abs() < 1e-5, "{volume}");
    }

    #[test]
    fn vertices_and_faces_on_the_plane_count_as_above() {
        let mesh = tetrahedron(2.0);
        assert!(one_section(&mesh, DVec3::Z, 0.0).edges().is_empty(), "the bottom: all above");
        assert!(one_section(&mesh, DVec3::Z, 2.0).edges().is_empty(), "the tip: a point");
        assert!(one_section(&mesh, DVec3::Z, 3.0).edges().is_empty(), "beyond");
        // From the other side, the bottom is the last that is above.
        assert_eq!(area(&one_section(&mesh, DVec3::NEG_Z, 0.0), Label(1)), 2.0);
        // Through an edge and the middle of the opposite one.
        let diagonal = one_section(&mesh, DVec3::new(1.0, -1.0, 0.0), 0.0);
        assert!((area(&diagonal, Label(1)) - 2.0f64.sqrt()).abs() < 1e-15);
    }

    #[test]
    fn two_materials_keep_their_border_on_any_plane() {
        // Two balls that overlap; the first one has what both claim.
        let lattice = Lattice { origin: DVec3::splat(-1.0), voxel: 0.05, dims: [41; 3] };
        let ball = |point: DVec3, x: f64| 0.5 - (point - DVec3::X * x).length();
        let network = shapes::samples(lattice, |node| {
            let point = lattice.position(node);
            let [first, second] = [ball(point, -0.25), ball(point, 0.25)];
            let clamp = |value: f64| (value / 0.15).clamp(-1.0, 1.0) as f32;
            vec![clamp(first), clamp(second.min(-first))]
        });
        let mesh = dual(&network, &Silent).expect("samples of two balls");
        let bounds = mesh.bounds().expect("vertices");
        let planes = Family::Random { count: 60, seed: 3 }.planes(&bounds).expect("planes");
        let sections = slice(&mesh, &planes).expect("a closed network");
        for (plane, section) in planes.iter().zip(&sections) {
            // A plane's part of a ball is a disc.
            let gap = plane.distance(DVec3::X * -0.25);
            let exact = std::f64::consts::PI * (0.25 - gap * gap).max(0.0);
            // Half a voxel around a great circle would be 0.08.
            let off = area(section, Label(1)) - exact;
            assert!(off.abs() < 0.04, "{off} on {plane:?}");
        }
        let shares_border = |section: &&Section| {
            section.edges().iter().any(|edge| edge.left.is_material() && edge.right.is_material())
        };
        assert!(sections.iter().filter(shares_border).count() > 20);
    }
}
