use std::fs;

use glam::DVec3;

use super::*;
use crate::check::shapes::disc;
use crate::grid::distance::tests::sphere;
use crate::grid::leaf::{LeafOf, LeafValues};
use crate::grid::samples::Values;
use crate::plane::Plane;

/// A ball of label 7 in the middle of a lattice of 40 nodes a side.
struct Ball {
    lattice: Lattice,
    mesh: Mesh,
    samples: Samples,
    sections: Vec<Section>,
    materials: Vec<Material>,
}

const RADIUS: f64 = 12.0;

impl Ball {
    fn new() -> Self {
        Self::at(DVec3::new(1.0, 2.0, 3.0))
    }

    fn at(origin: DVec3) -> Self {
        Self::with_voxels(origin, 0.1)
    }

    fn with_voxels(origin: DVec3, voxel: f64) -> Self {
        let lattice = Lattice { origin, voxel, dims: [40; 3] };
        let center = lattice.origin + 19.5 * voxel;
        let (vertices, triangles) = sphere(center, RADIUS * lattice.voxel, 5);
        let sides = vec![[Label(7), Label::OUTSIDE]; triangles.len()];
        let mesh = Mesh { vertices, triangles, sides };
        let f = |node: [i32; 3]| {
            let radius = lattice.position(node).distance(center) / lattice.voxel;
            ((RADIUS - radius) / 20.0).clamp(-1.0, 1.0) as f32
        };
        let leaf = |index| {
            let at = lattice.leaf_at(index);
            let node = |node: usize| {
                let offset = [node / 64, node / 8 % 8, node % 8];
                f(std::array::from_fn(|axis| at[axis] * 8 + offset[axis] as i32))
            };
            let values = Box::new(std::array::from_fn(node));
            LeafOf { at, materials: vec![LeafValues { label: Label(7), values }] }
        };
        // The leaf in the very middle is a tile.
        let middle = lattice.leaf_index([2, 2, 2]);
        let mut tiles = vec![Label::OUTSIDE; 125];
        tiles[middle] = Label(7);
        let mut samples = Samples::new(lattice, tiles, None, Values::default());
        samples.add((0..125).filter(|&index| index != middle).map(leaf));
        let materials = vec![Material { id: 7, name: "Leber".to_owned(), color: [200, 16, 0] }];
        // A disc through the centre, normal to z.
        let plane = Plane { normal: DVec3::Z, offset: center.z };
        let sections = vec![disc(plane, RADIUS * lattice.voxel, 40, Label(7))];
        Self { lattice, mesh, samples, sections, materials }
    }

    fn contents<'a>(&'a self, grids: &'a [GridName]) -> VdbContents<'a> {
        VdbContents {
            lattice: &self.lattice,
            mesh: &self.mesh,
            samples: &self.samples,
            sections: &self.sections,
            materials: &self.materials,
            units: "mm",
            frame: "",
            grids,
        }
    }
}

/// As most files are.
const PLAIN: Storage = Storage::OpenVdb { half: false };

fn names(all: &str) -> Vec<GridName> {
    GridName::parse_all(&all.split(',').collect::<Vec<_>>()).unwrap()
}

fn written(ball: &Ball, grids: &str) -> (tempfile::TempDir, VdbFile) {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("ball.vdb");
    write(&path, &ball.contents(&names(grids)), PLAIN).unwrap();
    let file = VdbFile::read(&path).unwrap();
    (folder, file)
}

fn text(metadata: &[(String, String)], key: &str) -> Option<String> {
    metadata.iter().find(|(name, _)| name == key).map(|(_, text)| text.clone())
}

#[test]
fn a_ball_has_every_grid_with_its_transform_and_metadata() {
    let ball = Ball::new();
    ball.samples.sanity_check().unwrap();
    let (_folder, file) = written(&ball, "surface,density,label,surface_*,indicator_7");
    let grids = file.grids().unwrap();
    let kinds: Vec<[&str; 3]> = grids
        .iter()
        .map(|grid| [grid.name.as_str(), grid.value_type.as_str(), grid.class.as_str()])
        .collect();
    assert_eq!(
        kinds,
        [
            ["density", "float", "fog volume"],
            ["indicator_7", "float", "unknown"],
            ["label", "int32", "unknown"],
            ["surface", "float", "level set"],
            ["surface_7", "float", "level set"],
        ]
    );
    for grid in &grids {
        assert!(grid.voxel.abs_diff_eq(DVec3::splat(0.1), 1e-15));
        assert_eq!(grid.origin, DVec3::new(1.0, 2.0, 3.0));
        assert_eq!(text(&grid.metadata, "units").as_deref(), Some("mm"));
        assert_eq!(text(&grid.metadata, "creator").as_deref(), Some(CREATOR));
        assert_eq!(text(&grid.metadata, "frame"), None);
    }
    assert_eq!(text(&grids[4].metadata, "label_name").as_deref(), Some("Leber"));
    assert_eq!(text(&grids[4].metadata, "label_color").as_deref(), Some("#c81000"));
    let labels = text(&file.metadata().unwrap(), "labels").unwrap();
    assert_eq!(serde_json::from_str::<Vec<Material>>(&labels).unwrap(), ball.materials);
}

#[test]
fn a_ball_passes_openvdbs_checks_and_has_the_right_values() {
    let ball = Ball::new();
    let (_folder, file) = written(&ball, "surface,density,label,surface_7,indicator_*");
    for level_set in ["surface", "surface_7"] {
        assert_eq!(file.check_level_set(level_set).unwrap(), "");
    }
    assert_eq!(file.check_fog_volume("density").unwrap(), "");
    for (x, inside) in [(0, false), (5, false), (9, true), (20, true), (30, true), (34, false)] {
        // The ball's centre is half a voxel off the node (19, 19, 19).
        let radius = ((f64::from(x) - 19.5).powi(2) + 0.5).sqrt();
        let node = [x, 19, 20];
        let distance = (0.1 * (radius - RADIUS)).clamp(-0.3, 0.3);
        assert!((file.value("surface", node).unwrap() - distance).abs() < 0.001);
        let density = (-distance / 0.3).clamp(0.0, 1.0);
        assert!((file.value("density", node).unwrap() - density).abs() < 0.01);
        assert_eq!(file.value("label", node).unwrap(), if inside { 7.0 } else { 0.0 });
        let indicator = file.value("indicator_7", node).unwrap();
        let expected = if (16..24).contains(&x) { 1.0 } else { (RADIUS - radius) / 20.0 };
        assert!((indicator - expected).abs() < 1e-6, "{x}: {indicator} {expected}");
    }
    assert_eq!(file.value("label", [-100, 0, 0]).unwrap(), 0.0);
    assert_eq!(file.value("indicator_7", [-100, 0, 0]).unwrap(), -1.0);
    // Voxels of the ball: 4/3 π 12³ = 7,238.
    let active = |index: usize| file.grids().unwrap()[index].active as f64;
    assert!((active(2) / 7238.0 - 1.0).abs() < 0.01, "{}", active(2));
}

/// Balls of radii from nothing to three voxels around nodes and between them:
/// their distances have corners next to the surface.
/// Lengths of millimetres and of nanometres in metres: OpenVDB makes no such transforms, so that
/// they are enlarged, which the file says.
#[test]
fn voxels_of_any_size_are_written_and_read() {
    for (voxel, scale) in [(1e-4, 1.0), (1e-5, 1e3), (1e-9, 1e6), (1e-15, 1e12), (1e6, 1.0)] {
        let ball = Ball::with_voxels(voxel * DVec3::new(10.0, -20.0, 30.0), voxel);
        let (_folder, file) = written(&ball, "surface,density,label,evidence");
        let said = (scale != 1.0).then(|| format!("{scale}"));
        assert_eq!(text(&file.metadata().unwrap(), "scale"), said);
        let size = scale * voxel;
        for grid in file.grids().unwrap() {
            assert!((grid.voxel / size).abs_diff_eq(DVec3::ONE, 1e-12), "{voxel}");
            assert!((grid.origin / size).abs_diff_eq(DVec3::new(10.0, -20.0, 30.0), 1e-10));
            assert_eq!(text(&grid.metadata, "scale"), said);
        }
        assert_eq!(file.check_level_set("surface").unwrap(), "", "{voxel}");
        for x in 5..34 {
            let radius = ((f64::from(x) - 19.5).powi(2) + 0.5).sqrt();
            let distance = (radius - RADIUS).clamp(-3.0, 3.0);
            let found = file.value("surface", [x, 19, 20]).unwrap() / size;
            assert!((found - distance).abs() < 0.01, "{voxel}: {found} {distance}");
            let inside = file.value("density", [x, 19, 20]).unwrap() > 0.0;
            assert_eq!(inside, distance < 0.0, "{voxel}");
        }
    }
}

#[test]
fn voxels_beyond_single_precision_are_refused() {
    for voxel in [1e-20, 1e20] {
        let (ball, names) = (Ball::with_voxels(DVec3::ZERO, voxel), names("surface"));
        let error =
            write(Path::new("none.vdb"), &ball.contents(&names), PLAIN).unwrap_err().to_string();
        assert!(error.contains("other units"), "{error}");
    }
}

#[test]
fn features_as_thin_as_a_voxel_pass_openvdbs_check() {
    let mut ball = Ball::new();
    ball.mesh = Mesh::default();
    let mut centers = Vec::new();
    for (index, radius) in (0..20).map(|index| (index, 0.2 + 0.15 * f64::from(index))) {
        let at = [8 * (index % 5) + 2, 8 * (index / 5) + 4, 19];
        let shift = DVec3::new(0.1, 0.3, 0.5) * f64::from(index % 3);
        let center = ball.lattice.position(at) + shift * ball.lattice.voxel;
        let (vertices, triangles) = sphere(center, radius * ball.lattice.voxel, 3);
        let first = ball.mesh.vertices.len() as u32;
        ball.mesh.vertices.extend(vertices);
        ball.mesh.triangles.extend(triangles.iter().map(|corners| corners.map(|v| v + first)));
        centers.push((at, shift.length() - radius));
    }
    ball.mesh.sides = vec![[Label(7), Label::OUTSIDE]; ball.mesh.triangles.len()];
    let (_folder, file) = written(&ball, "surface,density");
    assert_eq!(file.check_level_set("surface").unwrap(), "");
    assert_eq!(file.check_fog_volume("density").unwrap(), "");
    // What is deeper than a voxel is left as it is, or nearly so.
    let deep = centers.into_iter().filter(|(_, depth)| *depth < -1.0);
    for (at, expected) in deep {
        let depth = file.value("surface", at).unwrap() / ball.lattice.voxel;
        assert!((depth - expected.max(-3.0)).abs() < 0.1, "{depth} {expected}");
    }
}

#[test]
fn far_from_the_origin_nothing_is_lost() {
    let ball = Ball::at(DVec3::new(4.5e5, 5.4e6, -300.0));
    let (_folder, file) = written(&ball, "surface,density");
    assert_eq!(file.check_level_set("surface").unwrap(), "");
    assert_eq!(file.check_fog_volume("density").unwrap(), "");
    let near = written(&Ball::new(), "surface").1.value("surface", [9, 19, 20]).unwrap();
    assert!((file.value("surface", [9, 19, 20]).unwrap() - near).abs() < 1e-5);
}

#[test]
fn fog_needs_no_level_set_in_the_file() {
    let (_folder, file) = written(&Ball::new(), "density,density");
    let grids = file.grids().unwrap();
    assert_eq!(grids.iter().map(|grid| grid.name.as_str()).collect::<Vec<_>>(), ["density"]);
    assert_eq!(file.check_fog_volume("density").unwrap(), "");
}

#[test]
fn the_same_contents_make_the_same_bytes() {
    let ball = Ball::new();
    let folder = tempfile::tempdir().unwrap();
    let grids = names("surface,density,label,indicator_7");
    let bytes = |threads, name: &str| {
        let path = folder.path().join(name);
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| write(&path, &ball.contents(&grids), PLAIN)).unwrap();
        fs::read(path).unwrap()
    };
    let first = bytes(1, "a");
    assert_eq!(first, bytes(3, "b"));
    // Another content has another identifier.
    let mut other = Ball::new();
    other.materials[0].name.push('!');
    let path = folder.path().join("c");
    write(&path, &other.contents(&grids), PLAIN).unwrap();
    assert_ne!(first[21..57], fs::read(path).unwrap()[21..57]);
}

#[test]
fn a_full_disk_and_a_missing_folder_are_errors() {
    let ball = Ball::new();
    let grids = names("surface");
    for (path, why) in [("/dev/full", "No space left"), ("/nowhere/a.vdb", "No such file")] {
        if path == "/dev/full" && !Path::new(path).exists() {
            eprintln!("skipped: there is no {path}");
            continue;
        }
        let error = write(Path::new(path), &ball.contents(&grids), PLAIN).unwrap_err().to_string();
        assert!(error.contains(path) && error.contains(why), "{error}");
    }
}

#[test]
fn grids_of_materials_that_are_not_there_are_errors() {
    let ball = Ball::new();
    let grids = names("surface,indicator_8");
    let error = write(Path::new("/nowhere"), &ball.contents(&grids), PLAIN).unwrap_err();
    assert_eq!(error.to_string(), "there is no grid for label 8: the labels are 7 (Leber)");
}

#[test]
fn a_label_too_large_for_the_grid_is_an_error() {
    let mut ball = Ball::new();
    ball.samples.tiles[0] = Label(3_000_000_000);
    ball.samples.retain(|at| at != [0; 3]);
    let grids = names("label");
    let error =
        write(Path::new("/nowhere"), &ball.contents(&grids), PLAIN).unwrap_err().to_string();
    assert!(error.contains("3000000000"), "{error}");
}

#[test]
fn evidence_and_margin_say_how_far_to_go() {
    let ball = Ball::new();
    let (_folder, file) = written(&ball, "evidence,margin");
    let grids = file.grids().unwrap();
    let names: Vec<&str> = grids.iter().map(|grid| grid.name.as_str()).collect();
    assert_eq!(names, ["evidence", "margin"]);
    assert!(grids.iter().all(|grid| grid.value_type == "float" && grid.class == "unknown"));
    for node in [[5, 9, 30], [20, 19, 8], [31, 20, 19]] {
        // The disc is known all over its plane, half a voxel above node 19.
        let height = 0.1 * (f64::from(node[2]) - 19.5).abs();
        assert!((file.value("evidence", node).unwrap() - height).abs() < 1e-6);
        // With one material the shares are (1 ± f) / 2: twice |f| apart.
        let radius = DVec3::from(node.map(|at| f64::from(at) - 19.5)).length();
        let margin = 2.0 * ((RADIUS - radius) / 20.0).abs();
        assert!((file.value("margin", node).unwrap() - margin).abs() < 1e-6);
    }
    // The tile in the middle is the ball's alone.
    assert_eq!(file.value("margin", [20, 20, 20]).unwrap(), 2.0);
}

#[test]
fn masks_and_densities_are_of_one_label_or_of_all() {
    let mut ball = Ball::new();
    // A second material, of which nothing is left.
    ball.materials.push(Material { id: 9, name: "none".to_owned(), color: [0; 3] });
    let (_folder, file) = written(&ball, "mask,mask_7,mask_none,density_Leber,label");
    let grids = file.grids().unwrap();
    let names: Vec<&str> = grids.iter().map(|grid| grid.name.as_str()).collect();
    assert_eq!(names, ["density_Leber", "label", "mask", "mask_7", "mask_none"]);
    assert_eq!(text(&grids[3].metadata, "label_name").as_deref(), Some("Leber"));
    assert_eq!(grids[2].value_type, "float");
    assert_eq!(
        [2, 3, 4].map(|index: usize| grids[index].active),
        [grids[1].active, grids[1].active, 0]
    );
    for x in 5..34 {
        let inside = f64::from(file.value("label", [x, 19, 20]).unwrap() != 0.0);
        assert_eq!(file.value("mask", [x, 19, 20]).unwrap(), inside);
        assert_eq!(file.value("mask_7", [x, 19, 20]).unwrap(), inside);
    }
    assert_eq!(file.check_fog_volume("density_Leber").unwrap(), "");
}

#[test]
fn half_floats_pass_openvdbs_checks_and_take_half_the_space() {
    let grids = names("surface,density,mask,label,indicator_7,evidence,margin");
    for voxel in [1e-3, 0.1, 0.73, 1000.0] {
        let ball = Ball::with_voxels(voxel * DVec3::new(10.0, -20.0, 30.0), voxel);
        let folder = tempfile::tempdir().unwrap();
        let [half, whole] = [true, false].map(|half| {
            let path = folder.path().join(format!("{half}.vdb"));
            write(&path, &ball.contents(&grids), Storage::OpenVdb { half }).unwrap();
            let size = fs::metadata(&path).unwrap().len();
            (VdbFile::read(&path).unwrap(), size)
        });
        assert!(half.1 * 10 < whole.1 * 8, "{} {}", half.1, whole.1);
        let (half, whole) = (half.0, whole.0);
        assert_eq!(half.check_level_set("surface").unwrap(), "", "{voxel}");
        assert_eq!(half.check_fog_volume("density").unwrap(), "", "{voxel}");
        for name in ["surface", "density", "mask", "label", "indicator_7", "evidence", "margin"] {
            for x in 3..37 {
                let [one, other] =
                    [&half, &whole].map(|file| file.value(name, [x, 19, 20]).unwrap());
                // Eleven bits; what is three voxels away is rounded up.
                let step =
                    f64::from(2.0f32.powi(-10)) * one.abs().max(other.abs()).max(1e-4 * voxel);
                assert!((one - other).abs() <= step, "{name}: {one} {other}");
            }
        }
    }
}

#[test]
fn what_half_floats_cannot_hold_is_refused() {
    let (ball, grids) = (Ball::with_voxels(DVec3::ZERO, 3e4), names("density,surface"));
    let storage = Storage::OpenVdb { half: true };
    let error = write(Path::new("/nowhere"), &ball.contents(&grids), storage).unwrap_err();
    assert!(error.to_string().contains("leave --half out"), "{error}");
}

#[test]
fn layers_of_a_label_have_grids_of_their_own() {
    let (first, mut other) = (Ball::new(), Ball::with_voxels(DVec3::ZERO, 1e-5));
    other.materials[0] = Material { id: 8, name: "Niere".to_owned(), color: [1, 2, 3] };
    other.mesh.sides.iter_mut().for_each(|sides| sides[0] = Label(8));
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("layers.vdb");
    let grids = names("blender,surface,label");
    let layers = [first.contents(&grids), other.contents(&grids)];
    let found = write_layers(&path, &layers, PLAIN).unwrap();
    let names: Vec<&str> = found.fields.iter().map(|field| field.name.as_str()).collect();
    assert_eq!(
        names,
        [
            "density_Leber",
            "mask_Leber",
            "surface_7",
            "label_7",
            "density_Niere",
            "mask_Niere",
            "surface_8",
            "label_8"
        ]
    );
    // All grids of a file are in the same units.
    assert_eq!(found.scale, 1000.0);
    let file = VdbFile::read(&path).unwrap();
    for grid in file.grids().unwrap() {
        assert_eq!(text(&grid.metadata, "scale").as_deref(), Some("1000"), "{}", grid.name);
    }
    assert_eq!(file.check_level_set("surface_7").unwrap(), "");
}

#[test]
fn nanovdb_files_are_the_same_every_time() {
    if !has_nano() {
        eprintln!("skipped: NanoVDB was not there when this was built");
        return;
    }
    let (ball, folder) = (Ball::new(), tempfile::tempdir().unwrap());
    let grids = names("surface,density,label,mask");
    let [first, second] = ["a", "b"].map(|name| {
        let path = folder.path().join(name);
        write(&path, &ball.contents(&grids), Storage::NanoVdb).unwrap();
        fs::read(path).unwrap()
    });
    assert_eq!(&first[..7], b"NanoVDB");
    assert!(first == second, "the bytes differ");
    for name in ["surface", "density", "label", "mask"] {
        let name = [name.as_bytes(), b"\0"].concat();
        assert!(first.windows(name.len()).any(|bytes| bytes == name));
    }
    if Path::new("/dev/full").exists() {
        let full = Path::new("/dev/full");
        let error = write(full, &ball.contents(&grids), Storage::NanoVdb).unwrap_err().to_string();
        assert!(error.contains("No space left"), "{error}");
    }
}
