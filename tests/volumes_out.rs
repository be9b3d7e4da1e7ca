//! Volumes of labels as outputs: all kinds agree on values and places, also with an image's own
//! voxels, and with structures that overlap.

#[path = "common/program.rs"]
mod program;
#[path = "common/structure_set.rs"]
mod structure_set;

use std::fs;
use std::path::{Path, PathBuf};

use dicom_dictionary_std::uids;
use glam::DVec3;
use program::*;
use serde_json::Value;
use structure_set::*;

use transect::Rules;
use transect::io::structures::Chosen;
use transect::io::volume::like::read_voxels;
use transect::io::volume::read_volume;
use transect::io::volume::write::Voxels;
use transect::io::{nrrd, read_layers};
use transect::volume::LabelVolume;

fn reconstructed(sections: &Path, folder: &Path, names: &[&str], more: &[&str]) -> Value {
    let report = folder.join("report.json");
    let mut command = transect();
    command.arg("reconstruct").arg(sections).arg("-q").arg("--report").arg(&report).args(more);
    for name in names {
        command.arg("-o").arg(folder.join(name));
    }
    assert_done(&run(&mut command));
    serde_json::from_slice(&fs::read(report).expect("a report")).expect("JSON")
}

fn volume(path: &Path) -> LabelVolume {
    read_volume(path).unwrap_or_else(|error| panic!("{error}"))
}

/// The volume of a voxel.
fn voxel(voxels: &Voxels) -> f64 {
    voxels.placement.steps.determinant().abs()
}

/// Where a point is in voxels.
fn index(voxels: &Voxels, at: DVec3) -> DVec3 {
    voxels.placement.steps.inverse() * (at - voxels.placement.origin)
}

#[test]
fn all_kinds_hold_the_same_voxels_in_the_same_place() {
    let folder = folder();
    let names = ["a.nrrd", "a.seg.nrrd", "a.nii", "a.nii.gz", "a.mha"];
    let more = [&names[..], &["a.vti", "only_{name}.nii.gz"]].concat();
    let report = reconstructed(&phantom(), folder.path(), &more, COARSE);
    let [first, others @ ..] = names.map(|name| volume(&folder.path().join(name)));
    for (other, name) in others.iter().zip(&names[1..]) {
        assert_eq!(other.sizes(), first.sizes(), "{name}");
        let [here, there] = [names[0], name].map(|name| read_voxels(&folder.path().join(name)));
        let (here, there) = (here.unwrap(), there.unwrap());
        assert_eq!((there.dims, there.units.as_str()), (here.dims, "mm"), "{name}");
        // NIfTI has another frame, and single precision.
        let sign = if there.frame == "RAS" { DVec3::new(-1.0, -1.0, 1.0) } else { DVec3::ONE };
        let far = index(&here, sign * there.placement.origin).length();
        assert!(far < 1e-5, "{name} is {far} voxels off");
        assert!((voxel(&there) / voxel(&here) - 1.0).abs() < 1e-6);
    }
    assert_eq!(first.frame, "LPS");
    let named: Vec<&str> = first.materials.iter().map(|one| one.name.as_str()).collect();
    assert_eq!((named.len(), named[2]), (7, "liver"));
    let liver = &report["materials"][2];
    assert_eq!(serde_json::json!(first.materials[2].color), liver["color"]);
    // Voxels have the labels of their centres: their volume is the surfaces', as far as voxels go.
    let voxels = read_voxels(&folder.path().join("a.nrrd")).unwrap();
    for label in report["check"]["labels"].as_array().expect("labels") {
        let number = label["label"].as_u64().unwrap() as u32;
        let counted = first.sizes()[&transect::Label(number)] as f64 * voxel(&voxels);
        let wanted = label["volume"].as_f64().unwrap();
        assert!((counted / wanted - 1.0).abs() < 0.2, "label {number}: {counted} of {wanted}");
    }
    let liver = volume(&folder.path().join("only_liver.nii.gz"));
    assert_eq!(liver.sizes().into_iter().nth(1), first.sizes().into_iter().nth(3));
    assert_eq!(liver.sizes().len(), 2, "outside and one label");
    let vti = fs::read(folder.path().join("a.vti")).unwrap();
    let text = String::from_utf8_lossy(&vti);
    assert!(text.contains("<ImageData WholeExtent=\"0 49 0 ") && text.contains("Name=\"label\""));
}

/// An image in another frame, turned, with oblong voxels and left-handed axes, and nothing in it.
fn reference(folder: &Path) -> PathBuf {
    let path = folder.join("image.nrrd");
    let header = "NRRD0004\ntype: short\ndimension: 3\nspace: right-anterior-superior\n\
        sizes: 40 50 30\nspace directions: (0,6,0) (5.5,0,0.5) (-0.6,0,8)\nendian: little\n\
        encoding: raw\nspace origin: (-140,-120,-130)\n\n";
    let mut bytes = header.as_bytes().to_vec();
    bytes.extend(std::iter::repeat_n([0xe8, 0x03], 40 * 50 * 30).flatten());
    fs::write(&path, bytes).expect("the folder is writable");
    path
}

/// The numbers of an unpacked NIfTI file of floats.
fn floats(path: &Path) -> Vec<f32> {
    let bytes = fs::read(path).expect("a file");
    assert_eq!(bytes[70..72], 16i16.to_le_bytes(), "DT_FLOAT32");
    let number = |bytes: &[u8]| f32::from_le_bytes(bytes.try_into().expect("four bytes"));
    bytes[352..].chunks(4).map(number).collect()
}

/// Distances at voxels of any shape are those to the surface in the mesh, less than zero where the
/// label is.
#[test]
fn distances_are_those_to_the_surface_of_a_label() {
    let folder = folder();
    let path = |name: &str| folder.path().join(name);
    let image = reference(folder.path());
    let like = ["--like", image.to_str().expect("a name"), "--resolution", "48"];
    reconstructed(&phantom(), folder.path(), &["labels.nii", "all.ply"], &like);
    let more = [&like[..], &["--voxels", "distances"]].concat();
    let names = ["{name}.nii", "all.nii", "{name}.nrrd", "all.mha", "all.vti"];
    reconstructed(&phantom(), folder.path(), &names, &more);
    let labels = fs::read(path("labels.nii")).unwrap()[352..].to_vec();
    let voxels = read_voxels(&path("labels.nii")).unwrap();
    let mesh = transect::io::read_mesh(&path("all.ply")).unwrap();
    let [width, height, _] = voxels.dims;
    let at = |voxel: usize| {
        let index = [voxel % width, voxel / width % height, voxel / width / height];
        let place = DVec3::from(index.map(|index| index as f64));
        // NIfTI is in RAS, the mesh in LPS.
        DVec3::new(-1.0, -1.0, 1.0) * (voxels.placement.origin + voxels.placement.steps * place)
    };
    for (name, label) in [("liver", Some(3)), ("all", None)] {
        let found = floats(&path(&format!("{name}.nii")));
        assert_eq!(found.len(), labels.len());
        let surface = mesh.surface_of(|own| label.map_or(own.is_material(), |one| own.0 == one));
        let edges = (0..surface.triangles.len()).flat_map(|triangle| {
            let [a, b, c] = surface.corners(triangle);
            [a.distance(b), b.distance(c), c.distance(a)]
        });
        let longest = edges.fold(0.0, f64::max);
        let is_within = |own: u8| label.map_or(own > 0, |one| u32::from(own) == one);
        for (voxel, &distance) in found.iter().enumerate() {
            assert_eq!(distance < 0.0, is_within(labels[voxel]), "{name}: voxel {voxel}");
        }
        for voxel in (0..found.len()).step_by(997) {
            let distance = f64::from(found[voxel].abs());
            let places = surface.vertices.iter().map(|vertex| vertex.distance(at(voxel)));
            let to_vertex = places.fold(f64::INFINITY, f64::min);
            assert!(distance < to_vertex + 1e-3, "{name}: {distance} {to_vertex}");
            assert!(to_vertex - distance < longest, "{name}: {distance} {to_vertex}");
        }
    }
    let header = fs::read(path("liver.nrrd")).unwrap();
    let header = String::from_utf8_lossy(&header[..600]);
    assert!(header.contains("type: float\n") && !header.contains("Segment"), "{header}");
    let header = fs::read(path("all.mha")).unwrap();
    assert!(String::from_utf8_lossy(&header[..600]).contains("ElementType = MET_FLOAT\n"));
    let header = fs::read(path("all.vti")).unwrap();
    let header = String::from_utf8_lossy(&header[..2000]);
    assert!(header.contains("type=\"Float32\" Name=\"distance\""), "{header}");
}

#[test]
fn options_of_volumes_without_any_are_refused() {
    let folder = folder();
    for (name, options, word) in [
        ("a.ply", ["--voxels", "distances"], "--voxels is about volumes"),
        ("a.seg.nrrd", ["--voxels", "distances"], "has labels, no distances"),
        ("a.nrrd", ["--half", "-q"], "--half is about .vdb files"),
        ("a.vdb", ["--grids", "density_heart"], "1 (vessels)"),
    ] {
        let output = reconstruct(folder.path(), &[name], &options);
        assert_refused(&output, &[word]);
        assert!(!folder.path().join(name).exists());
    }
}

/// A scene has its volumes beside it, also where these are asked for themselves.
#[test]
fn a_scene_names_the_grids_beside_it() {
    let folder = folder();
    let more = ["--grids", "houdini", "--half", "--quiet"];
    assert_done(&reconstruct(folder.path(), &["a.usda", "a.vdb"], &more));
    let scene = fs::read_to_string(folder.path().join("a.usda")).unwrap();
    let file = transect::io::vdb::VdbFile::read(&folder.path().join("a.vdb")).unwrap();
    let grids = file.grids().unwrap();
    assert_eq!(grids.len(), 3 + 3 * 7);
    for grid in &grids {
        assert!(scene.contains(&format!("token fieldName = \"{}\"", grid.name)), "{}", grid.name);
        let half = grid.metadata.iter().find(|(key, _)| key == "is_saved_as_half_float");
        assert_eq!(half.map(|(_, value)| value.as_str()), Some("true"), "{}", grid.name);
    }
    assert_eq!(scene.matches("def OpenVDBAsset").count(), grids.len());
    assert!(scene.contains("@@@./a.vdb@@@") && scene.contains("upAxis = \"Y\""));
}

#[test]
fn voxels_like_those_of_an_image() {
    let folder = folder();
    let image = reference(folder.path());
    let like = ["--like", image.to_str().expect("a name"), "--resolution", "64"];
    let names = ["like.nrrd", "like.nii.gz", "like.mha", "own.nrrd"];
    let report = reconstructed(&phantom(), folder.path(), &names[..3], &like);
    reconstructed(&phantom(), folder.path(), &names[3..], &["--resolution", "64"]);
    let wanted = read_voxels(&image).unwrap();
    let own = read_voxels(&folder.path().join("like.nrrd")).unwrap();
    assert_eq!(own, Voxels { units: String::new(), ..wanted.clone() });
    let [first, second, third, grid] = names.map(|name| volume(&folder.path().join(name)));
    assert_eq!(first.sizes(), second.sizes());
    assert_eq!(first.sizes(), third.sizes());
    // MetaImage is in LPS again.
    let lps = read_voxels(&folder.path().join("like.mha")).unwrap();
    let turned = DVec3::new(-1.0, -1.0, 1.0) * lps.placement.origin;
    assert!(turned.distance(wanted.placement.origin) < 1e-9);
    // What lies wholly in the image has the same volume on either lattice.
    let node = read_voxels(&folder.path().join("own.nrrd")).unwrap();
    let label = |name: &str| {
        let materials = report["materials"].as_array().unwrap();
        let own = materials.iter().find(|one| one["name"] == name).unwrap();
        transect::Label(own["id"].as_u64().unwrap() as u32)
    };
    for name in ["liver", "stomach", "spine"] {
        let label = label(name);
        let here = first.sizes()[&label] as f64 * voxel(&wanted);
        let there = grid.sizes()[&label] as f64 * voxel(&node);
        assert!((here / there - 1.0).abs() < 0.05, "{name}: {here} and {there}");
    }
    let mut command = transect();
    let refused = run(command.arg("reconstruct").arg(phantom()).args(["-o", "x.ply"]).args(like));
    assert_refused(&refused, &["--like", "volumes of labels"]);
}

#[test]
fn structures_that_overlap_have_layers_and_come_back() {
    let folder = folder();
    let sides = [DVec3::X, DVec3::Y];
    let slices = |radius: f64| -> Vec<Contour> {
        let at = (0..10).map(|k| DVec3::new(10.0, 20.0, 3.0 * f64::from(k)));
        at.map(|at| closed(circle(at, radius, sides))).collect()
    };
    let structures = [
        Structure { number: 4, name: "Whole", contours: slices(20.0) },
        Structure { number: 9, name: "Part", contours: slices(8.0) },
    ];
    let set = folder.path().join("set.dcm");
    fs::write(&set, structure_set(&structures, uids::EXPLICIT_VR_LITTLE_ENDIAN)).unwrap();
    let coarse = ["--resolution", "48"];
    let names = ["both.seg.nrrd", "{name}.nii.gz"];
    let report = reconstructed(&set, folder.path(), &names, &coarse);
    let file = folder.path().join("both.seg.nrrd");
    let layers = nrrd::read_layers(&fs::read(&file).unwrap(), &file).unwrap();
    let voxels = read_voxels(&file).unwrap();
    assert_eq!(layers.len(), 2);
    for (layer, (number, name)) in layers.iter().zip([(4, "Whole"), (9, "Part")]) {
        assert_eq!(layer.materials[0].name, name);
        let counted = layer.sizes()[&transect::Label(number)] as f64 * voxel(&voxels);
        let labels = report["check"]["labels"].as_array().unwrap();
        let wanted = labels.iter().find(|one| one["label"] == number).unwrap();
        let wanted = wanted["volume"].as_f64().unwrap();
        assert!((counted / wanted - 1.0).abs() < 0.05, "{name}: {counted} of {wanted}");
        let alone = volume(&folder.path().join(format!("{name}.nii.gz")));
        assert_eq!(alone.sizes(), layer.sizes());
    }
    let plain = folder.path().join("both.nrrd");
    let mut command = transect();
    let refused = run(command.arg("reconstruct").arg(&set).arg("-o").arg(&plain));
    assert_refused(&refused, &["both.nrrd", ".seg.nrrd", "--partition"]);
    assert!(!plain.exists());
    // And back: each segment a solid of its own, or one of them.
    let read = |chosen: &Chosen| {
        let layers = read_layers(std::slice::from_ref(&file), chosen, &Rules::default()).unwrap();
        let names = layers.iter().flat_map(|layer| &layer.materials);
        names.map(|material| material.name.clone()).collect::<Vec<_>>()
    };
    assert_eq!(read(&Chosen::default()), ["Whole", "Part"]);
    assert_eq!(read(&Chosen { names: vec!["part".into()], partition: None }), ["Part"]);
    let mut command = transect();
    let refused = run(command.arg("crosscheck").arg(&file));
    assert_refused(&refused, &["2 structures that may overlap"]);
}
