//! Files, terminals and limits that mean no good: one line says so, and nothing is lost.
#![cfg(target_os = "linux")]

#[path = "common/program.rs"]
mod program;

use std::fs;
use std::path::Path;
use std::process::{Command, Output, Stdio};
use std::time::{Duration, Instant};

use program::*;

/// What a shell makes of the program (`$0`), with arguments `$1` and so on.
fn shell(script: &str, arguments: &[&Path]) -> Output {
    let mut command = Command::new("bash");
    command.args(["-c", script, env!("CARGO_BIN_EXE_transect")]).args(arguments);
    run(&mut command)
}

/// Two squares of one label that overlap, on three planes: three warnings.
fn overlapping(folder: &Path) -> std::path::PathBuf {
    let mut text = "CSLC\n3 2\n".to_owned();
    for z in 0..3 {
        text += &format!("{z} 8 2 0 0 1 {}\n", -z);
        for [x, y] in [[0, 0], [2, 0], [2, 2], [0, 2], [1, 1], [3, 1], [3, 3], [1, 3]] {
            text += &format!("{x} {y} {z}\n");
        }
        text += "4 1 0 1 2 3\n4 1 4 5 6 7\n";
    }
    let path = folder.join("overlapping.csl");
    fs::write(&path, text).expect("a file");
    path
}

#[test]
fn whoever_does_not_read_stops_nothing() {
    let folder = folder();
    let (sections, mesh) = (overlapping(folder.path()), folder.path().join("a.ply"));
    for end in ["2>&1 | true", "2>&1 | head -1", "2>/dev/full", "2>&-", ">&-", ">/dev/full"] {
        let script =
            format!("set -o pipefail; \"$0\" reconstruct \"$1\" --resolution 16 -o \"$2\" {end}");
        let output = shell(&script, &[&sections, &mesh]);
        assert_eq!(output.status.code(), Some(0), "{end}: {}", stderr(&output));
        assert!(fs::metadata(&mesh).expect("the mesh").len() > 1000, "{end}");
        fs::remove_file(&mesh).expect("it is there");
    }
    let output = shell("\"$0\" inspect \"$1\" >/dev/full", &[&sections]);
    assert_refused(&output, &["cannot be printed"]);
    assert_eq!(shell("\"$0\" inspect none.csl 2>/dev/full", &[]).status.code(), Some(1));
}

#[test]
fn names_of_others_are_shown_escaped_and_reported_as_they_are() {
    let folder = folder();
    let (sections, report) = (folder.path().join("a.json"), folder.path().join("r.json"));
    let square = |z: u8| {
        format!(
            r#"{{"name": "s{z}\n\u001b[2J", "normal": [0, 0, 1], "offset": {z}, "loops": [
            {{"label": 1, "points": [[0, 0, {z}], [3, 0, {z}], [3, 3, {z}], [0, 3, {z}]]}},
            {{"label": 1, "points": [[1, 1, {z}], [4, 1, {z}], [4, 4, {z}], [1, 4, {z}]]}}]}}"#
        )
    };
    let text = format!(
        r#"{{"transect": "sections", "version": 1, "units": "mm\nerror: no", "frame": "\u009b\u202e",
        "labels": [{{"id": 1, "name": "a\r\u001b[31m"}}], "sections": [{}, {}]}}"#,
        square(0),
        square(1)
    );
    fs::write(&sections, text).expect("a file");
    let mut command = transect();
    command.arg("reconstruct").arg(&sections).args(["--resolution", "16", "--report"]).arg(&report);
    let reconstructed = run(command.arg("-o").arg(folder.path().join("a.ply")));
    let inspected = run(transect().arg("inspect").arg(&sections));
    let strict = run(transect().args(["inspect", "--strict"]).arg(&sections));
    assert_done(&reconstructed);
    assert_done(&inspected);
    assert_refused(&strict, &["s0 \\u{1b}[2J"]);
    let shown = [reconstructed.stderr, inspected.stdout, strict.stderr].concat();
    let shown = String::from_utf8(shown).expect("text");
    let obeyed = shown.chars().find(|&c| c != '\n' && (c.is_control() || c == '\u{202e}'));
    assert_eq!(obeyed, None, "{shown}");
    assert!(shown.contains("mm\\nerror: no") && shown.contains("a\\r\\u{1b}[31m"), "{shown}");
    let report = fs::read_to_string(report).expect("a report");
    let report: serde_json::Value = serde_json::from_str(&report).expect("JSON");
    assert_eq!(report["materials"][0]["name"], "a\r\u{1b}[31m");
}

#[test]
fn what_has_no_end_is_refused_at_once() {
    let folder = folder();
    let endings = [
        "ply", "obj", "stl", "off", "nrrd", "nii", "nii.gz", "csl", "contour", "json", "png", "tif",
    ];
    for ending in endings {
        let zero = folder.path().join(format!("zero.{ending}"));
        std::os::unix::fs::symlink("/dev/zero", &zero).expect("a link");
        let pipe = folder.path().join(format!("pipe.{ending}"));
        assert!(run(Command::new("mkfifo").arg(&pipe)).status.success());
        for path in [zero, pipe] {
            let mut command = transect();
            match ending {
                "ply" | "obj" | "stl" | "off" => command.arg("compare").args([&path, &path]),
                _ => command.arg("inspect").arg(&path),
            };
            let start = Instant::now();
            let mut child = command.stderr(Stdio::piped()).spawn().expect("the program runs");
            while child.try_wait().expect("a child").is_none() {
                assert!(start.elapsed() < Duration::from_secs(20), "{}", path.display());
                std::thread::sleep(Duration::from_millis(5));
            }
            assert_refused(&child.wait_with_output().expect("it ended"), &["a device or a pipe"]);
        }
    }
}

/// A volume of NIfTI: 1000³ voxels of one byte, all of them 0.
fn vast(path: &Path) {
    let mut header = vec![0u8; 352];
    let mut put = |at: usize, bytes: &[u8]| header[at..at + bytes.len()].copy_from_slice(bytes);
    put(0, &348i32.to_le_bytes());
    put(40, &[3i16, 1000, 1000, 1000, 1, 1, 1, 1].map(i16::to_le_bytes).concat());
    put(70, &[2i16, 8].map(i16::to_le_bytes).concat());
    put(76, &[1.0f32; 8].map(f32::to_le_bytes).concat());
    put(108, &352f32.to_le_bytes());
    put(344, b"n+1\0");
    // One block, many times: gzip may have several members.
    let compressed = |bytes: &[u8]| {
        use std::io::Write;
        let mut encoder = flate2::write::GzEncoder::new(Vec::new(), flate2::Compression::best());
        encoder.write_all(bytes).expect("a vector takes all");
        encoder.finish().expect("a vector takes all")
    };
    let block = compressed(&vec![0; 10_000_000]);
    fs::write(path, [compressed(&header), block.repeat(100)].concat()).expect("a file");
}

#[test]
fn what_does_not_fit_is_told_before_it_is_read() {
    let folder = folder();
    let volume = folder.path().join("vast.nii.gz");
    vast(&volume);
    let start = Instant::now();
    let limited = |kibibytes: u32, script: &str, path: &Path| {
        shell(&format!("ulimit -v {kibibytes}; {script}"), &[path])
    };
    let output = limited(2_000_000, "\"$0\" inspect \"$1\"", &volume);
    assert_refused(&output, &["vast.nii.gz", "would take about 4.7 GiB", "are available"]);
    assert!(start.elapsed() < Duration::from_secs(20));
    // A file that is larger than what is there, and has no blocks on the disk.
    let huge = folder.path().join("huge.stl");
    fs::File::create(&huge).and_then(|file| file.set_len(1 << 40)).expect("a sparse file");
    let output = limited(2_000_000, "\"$0\" compare \"$1\" \"$1\"", &huge);
    assert_refused(&output, &["huge.stl", "would take about 4096.0 GiB"]);
    // What nobody knows before is an error as well.
    let text = folder.path().join("deep.json");
    let points = "[1,2,0],".repeat(1_000_000);
    let sections = format!(
        r#"{{"transect":"sections","version":1,"sections":[{{"normal":[0,0,1],"offset":0,"loops":[
        {{"label":1,"points":[{points}[0,0,0]]}}]}}]}}"#
    );
    fs::write(&text, sections).expect("a file");
    let output = limited(200_000, "\"$0\" inspect \"$1\"", &text);
    assert_refused(&output, &["memory"]);
}

#[test]
fn labels_beyond_what_files_can_hold_are_refused_before_the_work() {
    let folder = folder();
    let sections = folder.path().join("a.csl");
    let text =
        |label: u32| format!("CSLC\n1 1\n1 3 1 0 0 1 0\n0 0 0\n1 0 0\n0 1 0\n3 {label} 0 1 2\n");
    fs::write(&sections, text(2_147_483_648)).expect("a file");
    let words = ["a.csl", "section 1", "label 2147483648 is too large", "2147483647"];
    assert_refused(&run(transect().arg("inspect").arg(&sections)), &words);
    let mut unknown = transect();
    unknown.args(["inspect", "--unknown-label", "2147483648"]).arg(&sections);
    assert_done(&run(&mut unknown));
    fs::write(&sections, text(2_147_483_647)).expect("a file");
    assert_done(&run(transect().arg("inspect").arg(&sections)));
}

#[test]
fn threads_that_cannot_run_are_not_started() {
    let folder = folder();
    let mut command = transect();
    command.arg("reconstruct").arg(overlapping(folder.path())).args(["--resolution", "16"]);
    let output =
        run(command.args(["--threads", "4000000000", "-o"]).arg(folder.path().join("a.ply")));
    assert_done(&output);
    assert!(stderr(&output).contains("note: --threads asks for 4000000000"), "{}", stderr(&output));
}

#[test]
fn a_name_too_long_leaves_all_outputs_as_they_were() {
    let folder = folder();
    let sections = folder.path().join("a.json");
    let name = "x".repeat(250);
    let square = |z: u8| {
        format!(
            r#"{{"normal": [0, 0, 1], "offset": {z}, "loops": [
            {{"label": 1, "points": [[0, 0, {z}], [3, 0, {z}], [3, 3, {z}], [0, 3, {z}]]}}]}}"#
        )
    };
    let text = format!(
        r#"{{"transect": "sections", "version": 1, "labels": [{{"id": 1, "name": "{name}"}}],
        "sections": [{}, {}]}}"#,
        square(0),
        square(1)
    );
    fs::write(&sections, text).expect("a file");
    fs::write(folder.path().join("n.ply"), "old").expect("a file");
    let mut command = transect();
    command.arg("reconstruct").arg(&sections).arg("-o").arg(folder.path().join("n.ply"));
    let output = run(command.arg("-o").arg(folder.path().join("part_{name}.stl")));
    assert_refused(&output, &["the name is too long"]);
    assert_eq!(fs::read_to_string(folder.path().join("n.ply")).expect("a file"), "old");
    assert_eq!(entries(folder.path()), ["a.json", "n.ply"]);
}

/// What takes no time and little memory, whatever a small file says.
#[test]
fn no_header_and_no_line_takes_for_ever() {
    let folder = folder();
    let path = |name: &str| folder.path().join(name);
    let start = Instant::now();
    // A line that goes on and on.
    let contours = "v 0 0 0\nv 1 0 0\nv 0 1 0\nl 1 2 3 1".to_owned() + &"\\\n".repeat(1_000_000);
    fs::write(path("lines.obj"), contours).expect("a file");
    assert_done(&run(transect().arg("inspect").arg(path("lines.obj"))));
    // A pile of slices of which few are where the contours are, and one that nothing can hold.
    let like = |slices: u64| {
        let header = format!(
            "ObjectType = Image\nNDims = 3\nBinaryData = True\nDimSize = 9 9 {slices}\n\
             ElementSpacing = 1 1 1\nElementType = MET_UCHAR\nElementDataFile = LOCAL\n"
        );
        fs::write(path("like.mha"), header).expect("a file");
        let mut command = transect();
        command.arg("reconstruct").arg(overlapping(folder.path())).arg("--planes-like");
        command.arg(path("like.mha")).args(["--resolution", "16", "-o"]).arg(path("a.dcm"));
        run(&mut command)
    };
    assert_done(&like(3_000_000));
    assert_refused(&like(1_000_000_000_000_000), &["like.mha", "slices", "are available"]);
    assert!(start.elapsed() < Duration::from_secs(20));
}
