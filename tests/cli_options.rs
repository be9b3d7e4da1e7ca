//! The options of the command line: what each of them changes.

#[path = "common/program.rs"]
mod program;

use std::fs;
use std::path::Path;
use std::process::Output;

use program::*;
use serde_json::Value;
use transect::io::mesh::read_mesh;
use transect::label::Label;

/// Reconstructs a file of the corpus.
fn reconstruct_small(sections: &str, output: &Path, more: &[&str]) -> Output {
    let mut command = transect();
    command.arg("reconstruct").arg(repository("tests/corpus").join(sections));
    run(command.args(["--resolution", "24"]).args(more).arg("-o").arg(output))
}

fn json(path: &Path) -> Value {
    serde_json::from_slice(&fs::read(path).expect("it exists")).expect("JSON")
}

/// Counters of a stage in a report.
fn counts<'a>(report: &'a Value, stage: &str) -> &'a Value {
    let stages = report["stages"].as_array().expect("stages");
    &stages.iter().find(|found| found["name"] == stage).expect("the stage")["counts"]
}

/// Whether a mesh is closed, by what `slice` says.
fn is_closed(mesh: &Path) -> bool {
    let mut command = transect();
    command.args(["slice", "--quiet", "--plane", "0,0,1,0"]).arg(mesh);
    let output = run(command.arg("-o").arg(mesh.with_extension("json")));
    if !output.status.success() {
        assert_refused(&output, &["not closed"]);
    }
    output.status.success()
}

#[test]
fn facets_are_as_fine_as_asked_for() {
    let folder = folder();
    let mesh = |name: &str, more: &[&str]| {
        let path = folder.path().join(name);
        // On three voxels of height the default method's surface bends within a voxel,
        // and so does a smoothed one: that alone says how fine facets are.
        let own = ["--method", "mvc", "--smooth", "0", "--mesher", "delaunay", "--quiet"];
        let more = [&own, more].concat();
        assert_done(&reconstruct_small("organs.csl", &path, &more));
        assert!(is_closed(&path), "{name}");
        read_mesh(&path).expect("a mesh")
    };
    let usual = mesh("usual.ply", &[]);
    let coarse = mesh("coarse.ply", &["--facet-size", "6", "--facet-distance", "1"]);
    let small = mesh("small.ply", &["--facet-size", "0.5"]);
    let near = mesh("near.ply", &["--facet-distance", "0.02"]);
    let blunt = mesh("blunt.ply", &["--facet-angle", "1", "--facet-distance", "0.02"]);
    let count = |mesh: &transect::mesh::Mesh| mesh.triangles.len();
    assert!(4 * count(&coarse) < 3 * count(&usual), "{} {}", count(&coarse), count(&usual));
    assert!(4 * count(&usual) < 3 * count(&small), "{} {}", count(&usual), count(&small));
    assert!(count(&usual) < count(&near), "{} {}", count(&usual), count(&near));
    assert!(count(&blunt) < count(&near), "{} {}", count(&blunt), count(&near));
}

#[test]
fn facets_are_the_delaunay_meshers_own() {
    let folder = folder();
    let refused = |more: &[&str], words: &[&str]| {
        assert_refused(&reconstruct(folder.path(), &["a.ply"], more), words);
    };
    for option in ["--facet-angle", "--facet-size", "--facet-distance"] {
        refused(&[option, "1"], &[option, "--mesher delaunay"]);
        refused(&["--mesher", "dual", option, "1"], &[option, "--mesher delaunay"]);
        for value in ["0", "-1", "nan", "x"] {
            let more = ["--mesher", "delaunay", option, value];
            let output = reconstruct(folder.path(), &["a.ply"], &more);
            assert_eq!(output.status.code(), Some(2), "{option} {value}");
        }
    }
    let steep = ["--mesher", "delaunay", "--facet-angle", "31"];
    assert_eq!(reconstruct(folder.path(), &["a.ply"], &steep).status.code(), Some(2));
    let tiny = ["--mesher", "delaunay", "--facet-size", "1e-9"];
    refused(&tiny, &["--facet-size", "larger"]);
    assert!(entries(folder.path()).is_empty());
}

#[test]
fn surfaces_are_decimated_whatever_made_them() {
    let folder = folder();
    let all = [
        &["--method", "variational"][..],
        &["--method", "mvc"],
        &["--method", "skeleton", "--fair"],
        &["--mesher", "delaunay"],
        &["--box", "unknown", "--caps", "flat"],
    ];
    for method in all {
        let counts_of = |more: &[&str]| {
            let path = folder.path().join("report.json");
            let own = ["--quiet", "--report", path.to_str().expect("a path in UTF-8")];
            let mesh = folder.path().join("mesh.ply");
            assert_done(&reconstruct_small("organs.csl", &mesh, &[&own, method, more].concat()));
            assert!(is_closed(&mesh), "{method:?} {more:?}");
            let report = json(&path);
            let facts = |label: &Value| [&label["components"], &label["genus"]].map(Value::as_i64);
            let labels = report["check"]["labels"].as_array().expect("labels");
            let labels: Vec<_> = labels.iter().map(facts).collect();
            let counts = counts(&report, "decimation");
            let count = |name: &str| counts[name].as_u64().expect("a count");
            (count("triangles before"), count("triangles"), labels, report["decimation"].clone())
        };
        let (before, same, labels, _) = counts_of(&["--decimate", "100%"]);
        assert_eq!(before, same, "{method:?}");
        let (_, left, after, _) = counts_of(&["--decimate", "50%"]);
        assert!(left <= before / 2 + 1, "{method:?}: {left} of {before}");
        assert_eq!(labels, after, "{method:?}");
        let (_, left, after, outcome) = counts_of(&["--decimate", "0.05"]);
        assert!(left < before, "{method:?}");
        assert_eq!(labels, after, "{method:?}");
        let moved = outcome["moved"].as_f64().expect("a number");
        assert!(moved > 0.0 && moved <= 0.05, "{method:?}: {moved}");
    }
}

#[test]
fn what_decimation_cannot_reach_it_says() {
    let folder = folder();
    let mesh = folder.path().join("mesh.ply");
    let output = reconstruct_small("organs.csl", &mesh, &["--decimate", "0.01%"]);
    assert_done(&output);
    assert!(stderr(&output).contains("triangles turn over"), "{}", stderr(&output));
    assert!(is_closed(&mesh));
    for senseless in ["0", "-1", "nan", "inf", "x", "%", "0%", "101%", "1%%", ""] {
        let option = format!("--decimate={senseless}");
        let output = reconstruct_small("organs.csl", &mesh, &[&option]);
        assert_eq!(output.status.code(), Some(2), "{senseless}");
    }
    let exact = folder.path().join("exact.json");
    let exact = exact.to_str().expect("a path in UTF-8");
    let more = ["--method", "skeleton", "--exact", exact, "--decimate", "50%"];
    assert_refused(&reconstruct_small("organs.csl", &mesh, &more), &["--decimate", "--exact"]);
}

#[test]
fn in_an_open_box_flat_caps_are_made_on_request() {
    let folder = folder();
    let report = |name: &str, more: &[&str]| {
        let path = folder.path().join(name).with_extension("report.json");
        let text = path.to_str().expect("a path in UTF-8");
        let more = [&["--quiet", "--report", text], more].concat();
        let output = reconstruct_small("square.csl", &folder.path().join(name), &more);
        assert_done(&output);
        json(&path)["check"]["labels"][0].clone()
    };
    for mesher in ["dual", "delaunay"] {
        let open = ["--mesher", mesher, "--box", "unknown"];
        let bare = ["--mesher", mesher, "--box", "unknown", "--caps", "none"];
        let capped = ["--mesher", mesher, "--box", "unknown", "--caps", "flat"];
        let [closed, open, bare, capped] = [
            report("closed.ply", &["--mesher", mesher]),
            report("open.ply", &open),
            report("bare.ply", &bare),
            report("capped.ply", &capped),
        ];
        let closed_files = ["closed.ply", "open.ply", "capped.ply"]
            .map(|name| is_closed(&folder.path().join(name)));
        assert_eq!(closed_files, [true, false, true], "{mesher}");
        let number = |label: &Value, name: &str| label[name].as_f64().expect("a number");
        assert_eq!(open, bare);
        assert_eq!((&open["closed"], &open["open_at_box"]), (&false.into(), &true.into()));
        assert_eq!((&capped["closed"], &capped["outward"]), (&true.into(), &true.into()));
        assert!(number(&open, "open_edges") > 0.0);
        // The square ends at the box in place of a rounded end in it.
        assert_eq!(number(&open, "volume"), number(&capped, "volume"));
        assert!(number(&capped, "volume") > number(&closed, "volume"));
        assert!(number(&open, "area") < number(&capped, "area"));
    }
}

#[test]
fn caps_are_refused_where_they_mean_nothing() {
    let folder = folder();
    let rounded = ["--box", "unknown", "--caps", "rounded"];
    let words = ["--caps rounded", "--box unknown", "--caps flat"];
    for method in ["variational", "mvc"] {
        let more = [&["--method", method], &rounded[..]].concat();
        assert_refused(&reconstruct(folder.path(), &["a.ply"], &more), &words);
    }
    for caps in ["rounded", "none"] {
        let more = ["--method", "skeleton", "--caps", caps];
        let option = format!("--caps {caps}");
        let words = [option.as_str(), "--method variational and mvc", "skeleton"];
        assert_refused(&reconstruct(folder.path(), &["a.ply"], &more), &words);
    }
    for more in [&["--caps"][..], &["--caps", "round"]] {
        assert_eq!(reconstruct(folder.path(), &["a.ply"], more).status.code(), Some(2));
    }
    assert!(entries(folder.path()).is_empty());
}

#[test]
fn caps_say_how_a_stack_ends() {
    let folder = folder();
    let heights = |name: &str, more: &[&str]| {
        let path = folder.path().join(name);
        assert_done(&reconstruct_small("organs.csl", &path, &[&["--quiet"], more].concat()));
        assert!(is_closed(&path), "{name}");
        let bounds = read_mesh(&path).expect("a mesh").bounds().expect("a surface");
        [bounds.min.z, bounds.max.z]
    };
    let [default, rounded] =
        [heights("default.ply", &[]), heights("rounded.ply", &["--caps", "rounded"])];
    assert_eq!(default, rounded);
    let [flat, none, exact, default_exact] = [
        heights("flat.ply", &["--caps", "flat"]),
        heights("none.ply", &["--caps", "none"]),
        heights("exact.ply", &["--method", "skeleton", "--caps", "flat"]),
        heights("default_exact.ply", &["--method", "skeleton"]),
    ];
    assert_eq!(exact, default_exact);
    for end in 0..2 {
        assert!((flat[end] - exact[end]).abs() < 0.05, "{flat:?} {exact:?}");
    }
    assert!(none[0] > flat[0] && none[1] < flat[1], "{none:?} {flat:?}");
}

#[test]
fn spacing_says_how_finely_unknown_regions_are_completed() {
    let folder = folder();
    let path = |name: &str| folder.path().join(name);
    let mut mask = transect();
    mask.arg("mask").arg(phantom()).args(["--blobs", "0.2", "--seed", "3"]);
    assert_done(&run(mask.arg("-o").arg(path("noisy.json"))));
    let corners = |spacing: &str| {
        let mut command = transect();
        command.arg("reconstruct").arg(path("noisy.json")).args(COARSE).args(["--quiet"]);
        command
            .args(["--method", "mvc", "--spacing", spacing])
            .arg("--report")
            .arg(path("report.json"));
        assert_done(&run(command.arg("-o").arg(path("a.ply"))));
        counts(&json(&path("report.json")), "completion")["corners"].as_u64().expect("a count")
    };
    // Contours end triangles, too, whatever the spacing.
    let (coarse, fine) = (corners("60"), corners("12"));
    assert!(3 * coarse < 2 * fine, "{coarse} {fine}");
    for spacing in ["0", "-3", "inf"] {
        let output = reconstruct(folder.path(), &["b.ply"], &["--spacing", spacing]);
        assert_eq!(output.status.code(), Some(2), "{spacing}");
    }
}

#[test]
fn an_unknown_label_that_does_not_occur_is_a_warning_and_with_strict_an_error() {
    let folder = folder();
    let output = folder.path().join("a.ply");
    let organs = |more: &[&str]| reconstruct_small("organs.csl", &output, more);
    let what = "label 7 is given as unknown but does not occur";
    let strict = organs(&["--unknown-label", "7", "--strict"]);
    assert_refused(&strict, &["organs.csl", what, "--unknown-label"]);
    assert!(entries(folder.path()).is_empty());
    let missing = organs(&["--unknown-label", "7"]);
    assert_done(&missing);
    assert!(stderr(&missing).contains(&format!("warning: {what}")), "{}", stderr(&missing));
    assert_eq!(read_mesh(&output).expect("a mesh").labels(), [1, 2, 4].map(Label));
    let found = organs(&["--unknown-label", "4", "--strict"]);
    assert_done(&found);
    assert!(!stderr(&found).contains("warning"), "{}", stderr(&found));
    assert_eq!(read_mesh(&output).expect("a mesh").labels(), [1, 2].map(Label));
}

#[test]
fn what_cannot_be_masked_is_refused() {
    let folder = folder();
    let mask = |sections: &str, more: &[&str]| {
        let mut command = transect();
        command.arg("mask").arg(repository("tests/corpus").join(sections)).args(more);
        run(command.arg("-o").arg(folder.path().join("a.json")))
    };
    for fraction in ["0", "1", "-0.1", "nan", "half"] {
        let output = mask("square.csl", &["--blobs", fraction]);
        assert_eq!(output.status.code(), Some(2), "{fraction}");
    }
    assert_refused(&mask("missing.csl", &["--blobs", "0.2"]), &["missing.csl", "no such file"]);
    assert_refused(&mask("none.csl", &["--blobs", "0.2"]), &["none.csl", "no section"]);
    assert!(entries(folder.path()).is_empty());
}

#[test]
fn a_section_without_contours_has_no_blobs_but_a_frame() {
    let folder = folder();
    let path = |name: &str| folder.path().join(name);
    let bare = r#"{"transect": "sections", "version": 1,
                   "sections": [{"normal": [0, 0, 1], "offset": 0, "loops": []}]}"#;
    fs::write(path("bare.json"), bare).expect("a file");
    for (option, value, beyond) in [("--blobs", "0.2", 0), ("--extent", "3,2", 1)] {
        let mut mask = transect();
        mask.arg("mask").arg(path("bare.json")).args([option, value]);
        assert_done(&run(mask.arg("-o").arg(path("masked.json"))));
        let output = run(transect().args(["inspect", "--json"]).arg(path("masked.json")));
        let found: Value = serde_json::from_slice(&output.stdout).expect("JSON");
        assert_eq!(found["unknown"].as_array().expect("a list").len(), beyond, "{option}");
    }
}

/// Width and height of a PNG file, from its header.
fn picture_size(path: &Path) -> [u32; 2] {
    let bytes = fs::read(path).expect("a picture");
    [16, 20].map(|at| u32::from_be_bytes(bytes[at..at + 4].try_into().expect("four bytes")))
}

#[test]
fn pictures_are_taken_as_asked_for() {
    let folder = folder();
    let picture = |name: &str, more: &[&str]| {
        let path = folder.path().join(name);
        let more = [&["--quiet", "--size", "160,120"], more].concat();
        assert_done(&reconstruct_small("organs.csl", &path, &more));
        assert_eq!(picture_size(&path), [160, 120], "{name}");
        fs::read(&path).expect("a picture")
    };
    let front = picture("front.png", &["--view", "front"]);
    // In a plain frame the front is at -y, and z is up.
    assert_eq!(front, picture("y.png", &["--view", "-y", "--up", "z"]));
    assert_eq!(front, picture("vector.png", &["--view", "0,-2,0", "--up", "0,0,5"]));
    assert_ne!(front, picture("turned.png", &["--view", "front", "--up", "-z"]));
    assert_ne!(front, picture("oblique.png", &["--view", "front-right-top"]));
    let one = picture("one.png", &["--view", "front", "--labels", "1"]);
    assert_ne!(front, one);
    assert_eq!(front, picture("all.png", &["--view", "front", "--labels", "4,1,2"]));
    // A size of its own, and names in place of numbers.
    let wide = folder.path().join("wide.png");
    assert_done(&reconstruct(folder.path(), &["wide.png"], &["--size", "300x90", "--quiet"]));
    assert_eq!(picture_size(&wide), [300, 90]);
    let small = ["--quiet", "--size", "160,120", "--labels"];
    let of = |labels: &str| {
        assert_done(&reconstruct(folder.path(), &["a.png"], &[&small[..], &[labels]].concat()));
        fs::read(folder.path().join("a.png")).expect("a picture")
    };
    assert_eq!(of("liver,spine"), of("2, 3"));
}

#[test]
fn what_cannot_be_a_picture_is_refused() {
    let folder = folder();
    let refused = |name: &str, more: &[&str], words: &[&str]| {
        assert_refused(&reconstruct(folder.path(), &[name], more), words);
    };
    for option in [["--view", "front"], ["--up", "-z"], ["--size", "64,64"], ["--labels", "1"]] {
        refused("a.ply", &option, &[option[0], ".png"]);
    }
    refused("a.glb", &["--up", "-z", "--size", "64,64"], &["--size", ".png"]);
    refused("a.png", &["--labels", "1,lung"], &["--labels", "\"lung\"", "3 (liver)", "7 (body)"]);
    refused("a.png", &["--labels", "0"], &["\"0\"", "1 (vessels)"]);
    for [option, value] in [
        ["--view", "above"],
        ["--view", "front-back"],
        ["--view", "0,0,0"],
        ["--view", "1,2"],
        ["--up", "front"],
        ["--up", "nan,0,1"],
        ["--size", "100"],
        ["--size", "0,100"],
        ["--size", "20000,100"],
        // 10,000 × 10,000 pixels are 100 million.
        ["--size", "10000x10000"],
        ["--size", "4294967296,100"],
    ] {
        let output = reconstruct(folder.path(), &["a.png"], &[option, value]);
        assert_eq!(output.status.code(), Some(2), "{option} {value}");
    }
    assert!(entries(folder.path()).is_empty());
}

#[test]
fn masked_sections_keep_what_is_up() {
    let folder = folder();
    let path = |name: &str| folder.path().join(name);
    let text = fs::read_to_string(repository("examples/stripes.json")).expect("the example");
    let text = text.replacen("\"version\": 1,", "\"version\": 1, \"up\": \"-y\",", 1);
    fs::write(path("up.json"), text).expect("a file");
    let mut mask = transect();
    mask.arg("mask").arg(path("up.json")).args(["--blobs", "0.2"]);
    assert_done(&run(mask.arg("-o").arg(path("masked.json"))));
    assert_eq!(json(&path("masked.json"))["up"], "-y");
}

#[test]
fn grids_are_those_that_were_asked_for() {
    let folder = folder();
    let grids = |names: &str| {
        assert_done(&reconstruct(folder.path(), &["a.vdb"], &["--quiet", "--grids", names]));
        // Their names stand in the file as they are.
        let bytes = fs::read(folder.path().join("a.vdb")).expect("it exists");
        ["surface", "density", "evidence", "margin", "indicator_3"]
            .map(|name| bytes.windows(name.len()).any(|window| window == name.as_bytes()))
    };
    assert_eq!(grids("surface,evidence,margin"), [true, false, true, true, false]);
    assert_eq!(grids("density,indicator_3"), [false, true, false, false, true]);
}

#[test]
fn an_stl_file_for_each_label_has_its_closed_surface() {
    let folder = folder();
    let path = folder.path().join("organ_{label}.stl");
    assert_done(&reconstruct_small("organs.csl", &path, &["--quiet"]));
    let names = entries(folder.path());
    assert_eq!(names, ["organ_1.stl", "organ_2.stl", "organ_4.stl"]);
    for name in names {
        assert!(is_closed(&folder.path().join(name)));
    }
}

#[test]
fn exact_surfaces_have_exact_coordinates() {
    let folder = folder();
    let [mesh, exact, report] =
        ["surface.ply", "exact.json", "report.json"].map(|name| folder.path().join(name));
    let mut command = transect();
    command.arg("reconstruct").arg(repository("tests/corpus").join("organs.csl"));
    command.args(["--method", "skeleton", "--quiet"]);
    command.arg("-o").arg(&mesh).arg("--exact").arg(&exact).arg("--report").arg(&report);
    assert_done(&run(&mut command));
    assert!(is_closed(&mesh));
    let mesh = read_mesh(&mesh).expect("a mesh");
    let file = json(&exact);
    let vertices = file["vertices"].as_array().expect("vertices");
    assert_eq!(vertices.len(), mesh.vertices.len());
    for (vertex, fractions) in mesh.vertices.iter().zip(vertices) {
        for axis in 0..3 {
            // Of long numbers the leading digits do.
            let [above, below] = [0, 1].map(|which| fractions[axis][which].as_str().expect("text"));
            let leading = |text: &str| {
                let (sign, digits) = match text.strip_prefix('-') {
                    Some(digits) => (-1.0, digits),
                    None => (1.0, text),
                };
                let taken = digits.len().min(18);
                let number: f64 = digits[..taken].parse().expect("digits");
                (sign * number, (digits.len() - taken) as i32)
            };
            let ((above, more), (below, less)) = (leading(above), leading(below));
            let value = above / below * 10f64.powi(more - less);
            assert!((value - vertex[axis]).abs() <= 1e-12 * (1.0 + vertex[axis].abs()));
        }
    }
    let triangles = file["triangles"].as_array().expect("triangles").len();
    assert_eq!(triangles, mesh.triangles.len());
    for member in ["labels", "kinds", "sections", "cells"] {
        assert_eq!(file[member].as_array().expect(member).len(), triangles);
    }
    let report = json(&report);
    assert_eq!(report["exact"]["contradictions"], serde_json::json!([]));
    assert_eq!(report["exact"]["bits"], 60);
}

#[test]
fn a_fair_surface_keeps_the_contours() {
    let folder = folder();
    let surface = |name: &str, more: &[&str]| {
        let path = folder.path().join(name);
        let more = [&["--method", "skeleton", "--quiet"], more].concat();
        assert_done(&reconstruct_small("organs.csl", &path, &more));
        assert!(is_closed(&path), "{name}");
        read_mesh(&path).expect("a mesh")
    };
    let (plain, fair) = (surface("plain.ply", &[]), surface("fair.ply", &["--fair"]));
    assert_ne!(plain, fair);
    let sections = transect::io::read_all(
        &[repository("tests/corpus").join("organs.csl")],
        &transect::section::Rules::default(),
    )
    .expect("sections");
    let mut kept = 0;
    for section in &sections.sections {
        for vertex in 0..section.vertices().len() as u32 {
            let point = section.point(vertex);
            if plain.vertices.contains(&point) {
                assert!(fair.vertices.contains(&point), "{point}");
                kept += 1;
            }
        }
    }
    assert_eq!(kept, 12);
}

#[test]
fn the_exact_method_refuses_what_has_no_meaning_for_it() {
    let folder = folder();
    let mesh = folder.path().join("mesh.ply");
    let exact = folder.path().join("exact.json").display().to_string();
    let refused = |more: &[&str], words: &str| {
        assert_refused(&reconstruct_small("organs.csl", &mesh, more), &[words]);
        assert!(!mesh.exists());
    };
    refused(&["--exact", &exact], "--method skeleton");
    refused(&["--fair"], "--method skeleton");
    refused(&["--method", "skeleton", "--box", "unknown"], "--box unknown");
    refused(&["--method", "skeleton", "--mesher", "delaunay"], "--mesher");
    refused(&["--method", "skeleton", "--device", "cpu"], "--device");
    refused(&["--method", "skeleton", "--smooth", "3"], "--method mvc");
    refused(&["--smooth", "3"], "--method mvc");
    refused(&["--spacing", "0.1"], "--method mvc");
    refused(&["--method", "skeleton", "--fair", "--exact", &exact], "--fair");
}

#[test]
fn parts_that_do_not_overlap_are_linked_on_request() {
    let folder = folder();
    let square = |x: i32, height: i32| {
        let corner = |[right, up]: [i32; 2]| format!("[{}, {up}, {height}]", x + right);
        let points = [[0, 0], [2, 0], [2, 2], [0, 2]].map(corner).join(", ");
        format!(
            r#"{{"name": "s{height}", "normal": [0, 0, 1], "offset": {height},
                "loops": [{{"label": 1, "points": [{points}]}}]}}"#
        )
    };
    let sections = [square(0, 0), square(3, 2), square(6, 4)].join(",");
    let file = folder.path().join("leaning.json");
    let text = format!(r#"{{"transect": "sections", "version": 1, "sections": [{sections}]}}"#);
    fs::write(&file, text).expect("it is written");
    let reconstruct = |method: &str, more: &[&str]| {
        let mut command = transect();
        command.arg("reconstruct").args(["--resolution", "48", "--method", method]).args(more);
        command.arg("--report").arg(folder.path().join("report.json"));
        run(command.arg("-o").arg(folder.path().join("leaning.ply")).arg("--").arg(&file))
    };
    let report = || json(&folder.path().join("report.json"));
    let pieces = || report()["check"]["labels"][0]["components"].clone();

    let output = reconstruct("stack", &[]);
    assert_done(&output);
    let said = stderr(&output);
    assert!(said.contains("s0 to s2") && said.contains("--link connects them"), "{said}");
    assert_eq!((pieces(), report()["links"]["connected"].clone()), (3.into(), false.into()));
    assert!(!report()["warnings"].to_string().contains("--link"));

    let output = reconstruct("stack", &["--link"]);
    assert_done(&output);
    assert!(stderr(&output).contains("links            2 between parts"), "{}", stderr(&output));
    assert_eq!((pieces(), report()["links"]["connected"].clone()), (1.into(), true.into()));
    assert_eq!(report()["links"]["found"].as_array().map(Vec::len), Some(2));

    assert_done(&reconstruct("stack", &["--link", "2.5", "--quiet"]));
    assert_eq!(pieces(), 3);
    assert_refused(&reconstruct("variational", &["--link"]), &["--link", "--method stack"]);
}

#[test]
fn a_method_is_chosen_by_the_sections_and_the_options() {
    let folder = folder();
    let slice = |height: i32, side: f64| {
        format!(
            r#"{{"name": "s{height}", "normal": [0, 0, 1], "offset": {height},
                "loops": [{{"label": 1, "points": [[0, 0, {height}], [{side}, 0, {height}],
                           [{side}, 9, {height}], [0, 9, {height}]]}}]}}"#
        )
    };
    let file = folder.path().join("prism.json");
    let sections = [slice(0, 9.0), slice(3, 8.8), slice(6, 8.9)].join(",");
    let text = format!(r#"{{"transect": "sections", "version": 1, "sections": [{sections}]}}"#);
    fs::write(&file, text).expect("it is written");
    let reconstruct = |input: &Path, more: &[&str]| {
        let mut command = transect();
        command.arg("reconstruct").args(["--resolution", "24", "--method", "auto"]).args(more);
        command.arg("--report").arg(folder.path().join("report.json"));
        run(command.arg("-o").arg(folder.path().join("prism.ply")).arg("--").arg(input))
    };
    let choice = || json(&folder.path().join("report.json"))["choice"].clone();

    let output = reconstruct(&file, &[]);
    assert_done(&output);
    let said = stderr(&output);
    assert!(said.contains("method: stack, because all 3 sections are parallel"), "{said}");
    assert_eq!(choice()["method"], "stack");
    assert_eq!(choice()["reasons"].as_array().map(Vec::len), Some(2));
    let output = reconstruct(&phantom(), &[]);
    assert_done(&output);
    let said = stderr(&output);
    assert!(said.contains("method: variational, because sections are not parallel"), "{said}");

    // Options decide before the sections do.
    for (options, method) in [
        (&["--box", "unknown"][..], "variational"),
        (&["--device", "cpu"], "variational"),
        (&["--link"], "stack"),
        (&["--caps", "none", "--mesher", "delaunay"], "stack"),
    ] {
        assert_done(&reconstruct(&file, options));
        assert_eq!(choice()["method"], method, "{options:?}");
    }
    assert_refused(&reconstruct(&file, &["--fair"]), &["--fair", "does not choose"]);
    assert_refused(&reconstruct(&file, &["--smooth", "1"]), &["--smooth", "name the method"]);
    assert_refused(&reconstruct(&file, &["--link", "--box", "unknown"]), &["--link"]);
    assert_refused(&reconstruct(&file, &["--facet-size", "1"]), &["--mesher delaunay"]);
    let mut command = transect();
    let online = run(command.args(["online", "--method", "auto"]));
    assert_refused(&online, &["one by one: name a method"]);
    let mut command = transect();
    let compared = run(command.args(["compare-methods", "--methods", "auto,stack"]).arg(&file));
    assert_refused(&compared, &["auto", "leave it out"]);
}

/// Positions in a .glb: the least and the largest corner of the first mesh.
fn glb_box(path: &Path) -> [Vec<f64>; 2] {
    let bytes = std::fs::read(path).expect("a file");
    let length = u32::from_le_bytes(bytes[12..16].try_into().expect("four bytes")) as usize;
    let root: serde_json::Value = serde_json::from_slice(&bytes[20..20 + length]).expect("JSON");
    let place = root["meshes"][0]["primitives"][0]["attributes"]["POSITION"].as_u64();
    let accessor = &root["accessors"][place.expect("an accessor") as usize];
    ["min", "max"].map(|end| {
        let numbers = accessor[end].as_array().expect("numbers").iter();
        numbers.map(|number| number.as_f64().expect("a number")).collect()
    })
}

/// A box of 2 × 4 × 8 without a unit, in metres, as .glb has it, and stood on another side.
#[test]
fn units_and_up_count_where_no_picture_is_drawn() {
    let folder = folder();
    let path = |name: &str| folder.path().join(name);
    let section = |number: usize, z: f64| {
        format!("{number} 4 1 0 0 1 {}\n0 0 {z}\n2 0 {z}\n2 4 {z}\n0 4 {z}\n4 1 0 1 2 3\n\n", -z)
    };
    let sections: String = (0..9).map(|number| section(number + 1, number as f64)).collect();
    std::fs::write(path("a.csl"), format!("CSLC\n9 2\n\n{sections}")).expect("a file");
    let made = |name: &str, more: &[&str]| {
        let mut command = transect();
        command.arg("reconstruct").arg(path("a.csl")).args(["--resolution", "32", "--quiet"]);
        let output = run(command.args(more).arg("-o").arg(path(name)));
        assert_done(&output);
        let [least, most] = glb_box(&path(name));
        let sizes = least.iter().zip(&most).map(|(least, most)| most - least);
        sizes.collect::<Vec<f64>>()
    };
    // Between 8 and 10 high, as the ends are rounded.
    let is_near = |sizes: &[f64], expected: [f64; 3], unit: f64| {
        let near = |(size, expected): (&f64, f64)| (size / unit / expected - 1.0).abs() < 0.3;
        assert!(sizes.iter().zip(expected).all(near), "{sizes:?} and not {expected:?} of {unit}");
    };
    // What stands is taller than wide: z becomes y.
    is_near(&made("a.glb", &[]), [2.0, 9.0, 4.0], 1e-3);
    is_near(&made("cm.glb", &["--unit", "Centimetres"]), [2.0, 9.0, 4.0], 1e-2);
    is_near(&made("inch.glb", &["--unit", "inch"]), [2.0, 9.0, 4.0], 0.0254);
    is_near(&made("x.glb", &["--up", "-x"]), [9.0, 2.0, 4.0], 1e-3);
    let refused = |name: &str, more: &[&str], words: &[&str]| {
        let mut command = transect();
        command.arg("reconstruct").arg(path("a.csl")).args(more).arg("-o").arg(path(name));
        assert_refused(&run(&mut command), words);
    };
    refused("a.3mf", &["--up", "x"], &["--up", ".glb"]);
    let mut command = transect();
    command.arg("reconstruct").arg(path("a.csl")).args(["--unit", "furlong", "-o", "b.glb"]);
    let output = run(&mut command);
    assert_eq!(output.status.code(), Some(2), "{}", stderr(&output));
    assert!(stderr(&output).contains("mm, cm, m"), "{}", stderr(&output));
    // What the file says is overruled, with a note.
    let mut command = transect();
    command.arg("reconstruct").arg(phantom()).args(COARSE).args(["--unit", "m"]);
    let output = run(command.arg("-o").arg(path("p.glb")));
    assert_done(&output);
    let text = stderr(&output);
    assert!(
        text.contains("note: lengths are taken for m, as was asked for") && text.contains("\"mm\"")
    );
}
