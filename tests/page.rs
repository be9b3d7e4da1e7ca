//! Reports that people read: what the program writes, and what a browser makes of it.

#[path = "common/program.rs"]
mod program;
#[path = "common/skipped.rs"]
mod skipped;
#[path = "common/structure_set.rs"]
mod structure_set;

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use dicom_dictionary_std::uids;
use glam::DVec3;
use program::*;
use skipped::skipped;
use structure_set::*;

/// What a page says but for its data.
fn html(path: &Path) -> String {
    let page = fs::read_to_string(path).expect("a page");
    let end = page.find("<script type=\"application/json\"").expect("data");
    page[..end].to_owned()
}

#[test]
fn a_page_is_an_output_and_a_report() {
    let folder = folder();
    let at = |name: &str| folder.path().join(name);
    let one = at("one.html");
    assert_done(&reconstruct(
        folder.path(),
        &["two.htm", "a.ply"],
        &["--report", one.to_str().unwrap(), "--view", "left"],
    ));
    assert_eq!(entries(folder.path()), ["a.ply", "one.html", "two.htm"]);
    let page = html(&one);
    assert_eq!(page, html(&at("two.htm")));
    for word in [
        "All 7 surfaces are closed",
        "phantom.json",
        "gallbladder",
        "From the left",
        "in <bdi>mm</bdi>",
        "The view asked for",
    ] {
        assert!(page.contains(word), "{word}");
    }
    let size = fs::metadata(&one).expect("a page").len();
    assert!((600_000..8_000_000).contains(&size), "{size} bytes");
}

#[test]
fn the_report_for_programs_stays() {
    let folder = folder();
    let json = folder.path().join("report.json");
    assert_done(&reconstruct(
        folder.path(),
        &["report.html"],
        &["--report", json.to_str().unwrap()],
    ));
    let report = fs::read_to_string(&json).expect("a report");
    let report: serde_json::Value = serde_json::from_str(&report).expect("JSON");
    let least = report["check"]["dice"]["min"].as_f64().expect("sections");
    assert!(html(&folder.path().join("report.html")).contains(&format!("{least:.4} at least")));
}

#[test]
fn a_page_appears_whole_or_not_at_all() {
    let folder = folder();
    let page = folder.path().join("report.html");
    fs::write(&page, "what was there").expect("a file");
    let output = reconstruct(folder.path(), &["report.html", "missing/a.ply"], &[]);
    assert_refused(&output, &["missing/a.ply"]);
    assert_eq!(fs::read_to_string(&page).expect("a file"), "what was there");
    assert_eq!(entries(folder.path()), ["report.html"]);
    assert_refused(&reconstruct(folder.path(), &["{label}.html"], &[]), &["leave {label}"]);
}

#[test]
fn structures_that_overlap_are_all_there() {
    let folder = folder();
    let (set, page) = (folder.path().join("set.dcm"), folder.path().join("report.html"));
    let slices = |radius: f64, x: f64| {
        let at = (0..6).map(|k| DVec3::new(x, 0.0, 4.0 * f64::from(k)));
        at.map(|at| closed(circle(at, radius, [DVec3::X, DVec3::Y]))).collect::<Vec<_>>()
    };
    let structure = |number, name, contours| Structure { number, name, contours };
    let structures =
        [structure(1, "Outer <b>", slices(20.0, 0.0)), structure(2, "PTV&1", slices(12.0, 14.0))];
    fs::write(&set, structure_set(&structures, uids::EXPLICIT_VR_LITTLE_ENDIAN)).expect("a file");
    let mut command = transect();
    command.arg("reconstruct").arg(&set).args(["--resolution", "40", "-q", "-o"]).arg(&page);
    assert_done(&run(&mut command));
    let page = html(&page);
    assert!(page.contains("Outer &lt;b&gt;") && page.contains("PTV&amp;1"), "escaped");
    assert!(page.contains("All 2 surfaces are closed"));
    assert!(page.contains("2 structures that may overlap"));
    assert_eq!(page.matches("<figure class=\"plate\">").count(), 12, "sections of both");
    // Who looks at a slice of a patient has the front above and the patient's right on the left.
    assert_eq!(
        page.matches("<span class=\"above\">A</span><span class=\"left\">R</span>").count(),
        12
    );
}

#[test]
fn a_living_model_is_saved_as_a_page() {
    let folder = folder();
    let page = folder.path().join("now.html");
    let lines = format!(
        "{}\n{}\n",
        serde_json::json!({ "add": phantom() }),
        serde_json::json!({ "report": page })
    );
    let input = folder.path().join("lines");
    fs::write(&input, lines).expect("a file");
    let mut command = transect();
    command.args(["online", "--resolution", "32"]).stdin(fs::File::open(&input).expect("a file"));
    assert_done(&run(&mut command));
    assert!(html(&page).contains("surfaces are closed"));
}

/// A program and what it says of itself, if it is there.
fn program(name: &str) -> Option<String> {
    let output = Command::new(name).arg("--version").output().ok()?;
    output.status.success().then(|| String::from_utf8_lossy(&output.stdout).trim().to_owned())
}

/// The folder in which the scripts are made anew, with what they are made with.
fn web() -> Option<PathBuf> {
    if let Some(missing) = ["node", "npm"].into_iter().find(|name| program(name).is_none()) {
        skipped(format_args!("{missing} is absent"));
        return None;
    }
    let (from, to) = (repository("web"), repository("target/web"));
    for folder in ["", "src/viewer", "src/report", "test"] {
        let (from, to) = (from.join(folder), to.join(folder));
        let _ = fs::remove_dir_all(if folder.is_empty() { to.join("src") } else { to.clone() });
        fs::create_dir_all(&to).expect("a folder");
        for entry in fs::read_dir(&from).expect("a folder").map(|entry| entry.expect("an entry")) {
            if entry.file_type().is_ok_and(|kind| kind.is_file()) {
                fs::copy(entry.path(), to.join(entry.file_name())).expect("a copy");
            }
        }
    }
    let lock = fs::read(from.join("package-lock.json")).expect("what is needed");
    if fs::read(to.join("installed.json")).ok().as_ref() != Some(&lock) {
        let mut npm = Command::new("npm");
        npm.args(["ci", "--ignore-scripts", "--prefer-offline", "--no-audit", "--no-fund"]);
        let output = run(npm.current_dir(&to));
        if !output.status.success() {
            skipped(format_args!("npm ci fails: {}", stderr(&output)));
            return None;
        }
        fs::write(to.join("installed.json"), lock).expect("a file");
    }
    Some(to)
}

#[test]
fn the_scripts_are_what_their_sources_make() {
    let Some(web) = web() else { return };
    let made = web.join("made");
    let output = run(Command::new("node").args(["build.mjs", "made"]).current_dir(&web));
    assert!(output.status.success(), "{}", stderr(&output));
    for name in ["report.js", "report.js.sha256"] {
        let same =
            fs::read(made.join(name)).ok() == fs::read(repository("web/dist").join(name)).ok();
        assert!(same, "web/dist/{name} is not what web/ makes: run ./x web");
    }
    let output = run(Command::new("node").arg("--test").current_dir(&web));
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stdout));
}

/// A browser without a window, by hand: `cargo test --release --test page -- --ignored`.
#[test]
#[ignore = "needs Chromium, which is large"]
fn a_browser_shows_the_surfaces_and_has_nothing_to_say() {
    let folder = folder();
    assert_done(&reconstruct(folder.path(), &["report.html"], &["--quiet"]));
    let page = folder.path().join("report.html");
    // What is drawn is read back where it was drawn: the colours of the picture, and its markup.
    let picture = folder.path().join("page.png");
    let mut chromium = Command::new("chromium");
    chromium.args(["--headless=new", "--no-sandbox", "--disable-dev-shm-usage"]);
    chromium.args(["--enable-unsafe-swiftshader", "--use-angle=swiftshader", "--hide-scrollbars"]);
    chromium.args(["--window-size=1200,1400", "--virtual-time-budget=10000"]);
    chromium.args(["--enable-logging=stderr", "--blink-settings=preferredColorScheme=1"]);
    chromium.arg(format!("--user-data-dir={}", folder.path().join("profile").display()));
    chromium.arg(format!("--screenshot={}", picture.display()));
    let output = run(chromium.arg(format!("file://{}#space", page.display())));
    let said = stderr(&output);
    let console: Vec<&str> = said.lines().filter(|line| line.contains("CONSOLE")).collect();
    assert!(console.is_empty(), "{console:?}");
    let image = image::open(&picture).expect("a picture").to_rgb8();
    // Between the borders of the page, where the surfaces are: colours of organs, not greys.
    let mut hues = std::collections::BTreeSet::new();
    for pixel in image.enumerate_pixels().filter(|(x, y, _)| (60..800).contains(x) && *y < 700) {
        let [red, green, blue] = pixel.2.0.map(i32::from);
        if red.max(green).max(blue) - red.min(green).min(blue) > 60 {
            hues.insert([red / 64, green / 64, blue / 64]);
        }
    }
    assert!(hues.len() > 3, "{hues:?}");
}
