//! Sections that come one by one: as commands and as files, with a journal that outlives the
//! program.

#[path = "common/program.rs"]
mod program;
#[path = "common/random.rs"]
#[expect(dead_code, reason = "other tests use the rest")]
mod random;

use std::collections::BTreeMap;
use std::fs;
use std::io::{BufRead, BufReader, Read, Write};
use std::path::Path;
use std::process::{Child, ChildStdin, ChildStdout, Command, Stdio};
use std::thread;
use std::time::{Duration, Instant};

use program::*;
use random::Random;
use serde_json::{Value, json};

/// Quick, and the same on every machine.
const TINY: [&str; 6] = ["--method", "mvc", "--device", "cpu", "--resolution", "12"];
/// A box around all squares.
const BOX: &str = "--bounds=-1.3,-1.3,-1.3,1.3,1.3,1.3";

/// A number from the environment: more of what a test does.
fn more(variable: &str, usual: usize) -> usize {
    std::env::var(variable).ok().and_then(|count| count.parse().ok()).unwrap_or(usual)
}

/// A file's content: a square around the middle of an axis-parallel plane.
fn square(name: &str, axis: usize, offset: f64, half: f64, label: u32) -> Value {
    let mut normal = [0.0; 3];
    normal[axis] = 1.0;
    let corner = |(u, v): (f64, f64)| {
        let mut point = [0.0; 3];
        (point[axis], point[(axis + 1) % 3], point[(axis + 2) % 3]) = (offset, u, v);
        point
    };
    let points = [(-half, -half), (half, -half), (half, half), (-half, half)].map(corner);
    json!({
        "transect": "sections", "version": 1,
        "sections": [{
            "name": name, "normal": normal, "offset": offset,
            "loops": [{"label": label, "points": points}],
        }],
    })
}

/// The program, with somebody who sends it lines.
struct Online {
    child: Child,
    input: Option<ChildStdin>,
    output: BufReader<ChildStdout>,
}

/// What is run in a folder.
fn online(folder: &Path, options: &[&str]) -> Command {
    let mut command = transect();
    command.current_dir(folder).arg("online").args(TINY).args(options);
    command
}

impl Online {
    fn start(folder: &Path, options: &[&str]) -> Self {
        let mut command = online(folder, options);
        command.stdin(Stdio::piped()).stdout(Stdio::piped()).stderr(Stdio::piped());
        let mut child = command.spawn().expect("the program runs");
        let input = child.stdin.take();
        let output = BufReader::new(child.stdout.take().expect("its output"));
        Self { child, input, output }
    }

    fn answer(&mut self) -> Value {
        let mut line = String::new();
        self.output.read_line(&mut line).expect("a line");
        serde_json::from_str(&line).unwrap_or_else(|error| panic!("{error}: {line:?}"))
    }

    fn send(&mut self, line: &str) -> Value {
        let input = self.input.as_mut().expect("it is open");
        writeln!(input, "{line}").and_then(|()| input.flush()).expect("it is read");
        self.answer()
    }

    /// An answer that is no refusal.
    fn does(&mut self, command: Value) -> Value {
        let answer = self.send(&command.to_string());
        assert_eq!(answer.get("error"), None, "{command}");
        answer
    }

    fn refuses(&mut self, line: &str, words: &[&str]) {
        let answer = self.send(line);
        let error = answer["error"].as_str().unwrap_or_else(|| panic!("{answer}"));
        words.iter().for_each(|word| assert!(error.contains(word), "{word:?}: {error:?}"));
    }

    /// The end of input: exit status and what went to standard error.
    fn end(mut self) -> (Option<i32>, String) {
        drop(self.input.take());
        let mut rest = String::new();
        self.output.read_to_string(&mut rest).expect("its output");
        assert_eq!(rest, "");
        let output = self.child.wait_with_output().expect("it ends");
        (output.status.code(), stderr(&output))
    }
}

/// Numbers and names in an answer.
fn listed(sections: &Value) -> Vec<(u64, String)> {
    let sections = sections.as_array().expect("a list");
    let pair = |section: &Value| {
        let name = section["name"].as_str().expect("a name");
        (section["id"].as_u64().expect("a number"), name.to_owned())
    };
    sections.iter().map(pair).collect()
}

fn pairs(expected: &[(u64, &str)]) -> Vec<(u64, String)> {
    expected.iter().map(|&(id, name)| (id, name.to_owned())).collect()
}

/// What the sections make that are given to `transect reconstruct`, in their order.
fn assert_reconstructs(folder: &Path, sections: &[Value], mesh: &str) {
    let one: Vec<&Value> = sections.iter().map(|one| &one["sections"][0]).collect();
    let all = json!({"transect": "sections", "version": 1, "sections": one});
    fs::write(folder.join("all.json"), all.to_string()).expect("written");
    let mut reconstruct = transect();
    reconstruct.current_dir(folder).args(["reconstruct", "all.json", "--quiet"]).args(TINY);
    assert_done(&run(reconstruct.args(["-o", "all.ply"])));
    assert_same_meshes(folder, "all.ply", mesh);
}

fn assert_same_meshes(folder: &Path, one: &str, other: &str) {
    let mut compare = transect();
    compare.current_dir(folder).args(["compare", "--json", one, other]);
    let output = run(&mut compare);
    assert_done(&output);
    let found: Value = serde_json::from_slice(&output.stdout).expect("JSON");
    assert!(found["hausdorff"].as_f64().expect("a number") < 1e-6, "{found}");
}

#[test]
fn every_command_is_answered_and_what_is_refused_changes_nothing() {
    let folder = folder();
    let path = folder.path();
    let mut online = Online::start(path, &["-o", "end.ply", "--quiet"]);
    let a = square("a", 0, -0.4, 1.0, 1);
    let b = square("b", 1, 0.1, 1.0, 1);
    let c = square("c", 2, -0.2, 1.0, 2);
    fs::write(path.join("b.json"), b.to_string()).expect("written");

    let answer = online.does(json!({"add": a}));
    assert_eq!((&answer["line"], &answer["change"]), (&1.into(), &1.into()));
    assert_eq!(listed(&answer["added"]), pairs(&[(0, "a")]));
    let stages = answer["stages"].as_array().expect("stages");
    for stage in ["read", "arrangement", "field", "mesh"] {
        assert!(stages.iter().any(|found| found["name"] == stage), "{stage}");
    }

    let answer = online.does(json!({"add": "b.json"}));
    assert_eq!(listed(&answer["added"]), pairs(&[(1, "b")]));
    assert_eq!((&answer["sections"], &answer["labels"][0]["label"]), (&2.into(), &1.into()));
    let volume = answer["labels"][0]["volume"].as_f64().expect("a volume");
    assert!((0.5..8.0).contains(&volume), "{answer}");

    // The refused are counted as lines, not as changes.
    online.refuses("add a section", &["this is no command", "docs/online.md"]);
    online.refuses(r#"{"add": "missing.csl"}"#, &["missing.csl", "no such file"]);
    online.refuses(r#"{"remove": 0, "why": "so"}"#, &["column"]);
    online.refuses(r#"{"remove": 17}"#, &["no section with the number 17"]);
    let wrong = square("wrong", 0, -0.4, 1.0, 7);
    let command = json!({"all": [{"remove": 1}, {"add": wrong}]}).to_string();
    online.refuses(&command, &["wrong", "lies on the plane of section a"]);
    let mut nan = a.clone();
    nan["sections"][0]["loops"][0]["points"][1][0] = json!(1e300);
    online.refuses(&json!({"add": nan}).to_string(), &["line 8", "section a", "vertex 1"]);
    online.refuses(r#"{"save": "a.xyz"}"#, &["a.xyz", ".vdb, .nvdb"]);
    online.refuses("\"\u{fffd}\u{0}", &["no command"]);

    let answer = online.does(json!({"all": [{"add": c}, {"remove": 1}]}));
    assert_eq!((&answer["line"], &answer["change"]), (&11.into(), &3.into()));
    assert_eq!(listed(&answer["added"]), pairs(&[(2, "c")]));
    assert_eq!(answer["removed"], json!([1]));
    let smaller = square("smaller", 0, -0.5, 0.5, 1);
    let answer = online.does(json!({"replace": {"id": 0, "with": smaller}}));
    assert_eq!((&answer["replaced"], &answer["sections"]), (&json!([0]), &2.into()));
    let answer = online.does(json!({"save": "now.ply"}));
    assert_eq!(answer["written"], "now.ply");
    assert_reconstructs(path, &[smaller, c.clone()], "now.ply");
    online.does(json!({"report": "now.json"}));
    let report = fs::read_to_string(path.join("now.json")).expect("a report");
    let report: Value = serde_json::from_str(&report).expect("JSON");
    assert_eq!((&report["transect"], &report["sections"]), (&"report".into(), &2.into()));

    let answer = online.does(json!("undo"));
    assert_eq!((&answer["replaced"], &answer["change"]), (&json!([0]), &5.into()));
    for _ in 0..3 {
        online.does(json!("undo"));
    }
    online.refuses("\"undo\"", &["no change to take back"]);
    online.does(json!({"add": a}));
    online.does(json!({"add": c}));
    let (status, errors) = online.end();
    assert_eq!((status, errors.as_str()), (Some(0), ""));
    assert_reconstructs(path, &[a, c], "end.ply");
}

#[test]
fn a_journal_is_gone_on_with() {
    let folder = folder();
    let path = folder.path();
    let all = [
        square("a", 0, -0.4, 1.0, 1),
        square("b", 1, 0.1, 1.0 / 3.0, 1),
        square("c", 2, -0.2, 0.1 + 0.7, 2),
        square("d", 0, 0.3, 1.0, 1),
    ];
    fs::write(path.join("a.json"), all[0].to_string()).expect("written");
    let begin = ["a.json", "--journal", "a.journal", "--quiet"];
    let mut first = Online::start(path, &begin);
    let answer = first.answer();
    assert_eq!((&answer["line"], listed(&answer["added"])), (&0.into(), pairs(&[(0, "a")])));
    first.does(json!({"add": all[1]}));
    first.does(json!({"add": all[2]}));
    first.does(json!("undo"));
    first.does(json!({"add": all[3]}));
    first.does(json!({"remove": 1}));
    // Nobody else writes to it meanwhile.
    assert_refused(&run(&mut online(path, &begin)), &["a.journal", "another transect"]);
    assert_eq!(first.end().0, Some(0));
    // What is there is neither overwritten nor forgotten.
    assert_refused(&run(&mut online(path, &begin)), &["a.journal", "--resume"]);

    // Files are not needed any more.
    fs::remove_file(path.join("a.json")).expect("removed");
    let resume = ["a.json", "--journal", "a.journal", "--resume", "--resolution", "13"];
    let mut second = transect();
    second.current_dir(path).args(["online", "--method", "mvc", "--device", "cpu"]).args(resume);
    second.stdin(Stdio::piped()).stdout(Stdio::piped()).stderr(Stdio::piped());
    let mut child = second.spawn().expect("the program runs");
    let (input, output) = (child.stdin.take(), child.stdout.take().expect("its output"));
    let mut second = Online { child, input, output: BufReader::new(output) };
    let answer = second.answer();
    assert_eq!((&answer["resumed"], &answer["changes"]), (&"a.journal".into(), &6.into()));
    assert_eq!(listed(&answer["sections"]), pairs(&[(0, "a"), (3, "d")]));
    let warnings = answer["warnings"].to_string();
    for word in ["--resolution was 12 and is 13", "not read again"] {
        assert!(warnings.contains(word), "{word}: {warnings}");
    }
    let answer = second.does(json!("undo"));
    assert_eq!((listed(&answer["added"]), &answer["change"]), (pairs(&[(1, "b")]), &7.into()));
    let answer = second.does(json!({"add": all[2]}));
    assert_eq!(listed(&answer["added"]), pairs(&[(4, "c")]));
    let (status, errors) = second.end();
    assert_eq!((status, errors.matches("warning: ").count()), (Some(0), 2), "{errors}");

    // A third time, to the end.
    let mut third = online(path, &["--journal", "a.journal", "--resume", "-o", "end.ply"]);
    assert_done(&run(third.stdin(Stdio::null())));
    let [a, b, c, d] = all;
    assert_reconstructs(path, &[a, b, d, c], "end.ply");
}

#[test]
fn a_torn_record_is_told_and_dropped_and_damage_is_an_error() {
    let folder = folder();
    let path = folder.path();
    let mut online = Online::start(path, &["--journal", "a.journal"]);
    for (name, axis) in [("a", 0), ("b", 1), ("c", 2)] {
        online.does(json!({"add": square(name, axis, 0.1, 1.0, 1)}));
    }
    assert_eq!(online.end().0, Some(0));
    let journal = path.join("a.journal");
    let whole = fs::read(&journal).expect("a journal");
    let line = |number: usize| {
        let ends = whole.iter().enumerate().filter(|(_, byte)| **byte == b'\n');
        ends.map(|(end, _)| end + 1).nth(number).expect("a line")
    };

    // The middle of the record of b, and so of everything after it.
    let (start, end) = (line(2), line(3));
    let mut damaged = whole.clone();
    damaged[usize::midpoint(start, end)] ^= 4;
    fs::write(&journal, &damaged).expect("written");
    let resume = ["--journal", "a.journal", "--resume"];
    let output = run(self::online(path, &resume).stdin(Stdio::null()));
    assert_refused(&output, &["a.journal", "damaged", &format!("begins at byte {start},")]);
    assert!(fs::read(&journal).expect("a journal") == damaged, "it is not touched");

    fs::write(&journal, &whole[..whole.len() - 7]).expect("written");
    let mut online = Online::start(path, &resume);
    let answer = online.answer();
    assert_eq!(listed(&answer["sections"]), pairs(&[(0, "a"), (1, "b")]));
    let told = "the last record of the journal is cut short or damaged: dropped";
    assert!(answer["warnings"][0].as_str().is_some_and(|warning| warning.contains(told)));
    online.does(json!({"add": square("c", 2, 0.1, 1.0, 1)}));
    let (status, errors) = online.end();
    assert!(status == Some(0) && errors.contains(told), "{errors}");
    assert!(fs::read(&journal).expect("a journal") == whole);
}

#[test]
#[cfg(unix)]
fn a_journal_that_cannot_be_written_ends_the_program_and_loses_nothing() {
    let folder = folder();
    let path = folder.path();
    // Files may have 4 KiB: room for some sections.
    let script = "trap '' XFSZ; ulimit -f 8; exec \"$0\" \"$@\"";
    let mut command = Command::new("sh");
    command.current_dir(path).args(["-c", script, env!("CARGO_BIN_EXE_transect"), "online"]);
    command.args(TINY).args(["--journal", "a.journal", "--quiet"]);
    command.stdin(Stdio::piped()).stdout(Stdio::piped()).stderr(Stdio::piped());
    let mut child = command.spawn().expect("the program runs");
    let mut input = child.stdin.take().expect("its input");
    let commands: String = (0..40)
        .map(|i| square(&format!("s{i}"), 0, -0.8 + 0.04 * f64::from(i), 1.0, 1))
        .map(|section| format!("{}\n", json!({"add": section})))
        .collect();
    // It ends before it has read everything.
    let _ = input.write_all(commands.as_bytes());
    drop(input);
    let output = child.wait_with_output().expect("it ends");
    assert_refused(&output, &["a.journal", "cannot be written"]);
    let acknowledged = output.stdout.iter().filter(|byte| **byte == b'\n').count();
    assert!((2..40).contains(&acknowledged), "{acknowledged}");
    let mut online = Online::start(path, &["--journal", "a.journal", "--resume", "--quiet"]);
    let answer = online.answer();
    assert_eq!((&answer["changes"], &answer["warnings"]), (&acknowledged.into(), &Value::Null));
    assert_eq!(online.end().0, Some(0));
}

/// What the program must know after each of the changes sent to it.
struct Story {
    random: Random,
    sections: BTreeMap<u64, Value>,
    past: Vec<BTreeMap<u64, Value>>,
    /// How many numbers were given away.
    numbers: u64,
    commands: Vec<Value>,
    /// Numbers and names after each change, from none on.
    states: Vec<Vec<(u64, String)>>,
}

impl Story {
    fn new(seed: u64) -> Self {
        let (sections, past, numbers, commands) = Default::default();
        let states = vec![Vec::new()];
        Self { random: Random::new(seed), sections, past, numbers, commands, states }
    }

    fn go_on(&mut self) {
        let before = self.sections.clone();
        let ids: Vec<u64> = before.keys().copied().collect();
        let choice = self.random.below(10);
        if choice == 0 && !self.past.is_empty() {
            self.sections = self.past.pop().expect("it is not empty");
            self.commands.push(json!("undo"));
            return self.be();
        }
        let section = self.any_square();
        match choice {
            1..=3 if ids.len() > 4 => {
                let id = ids[self.random.below(ids.len())];
                self.sections.remove(&id);
                self.commands.push(json!({"remove": id}));
            }
            4 | 5 if !ids.is_empty() => {
                let id = ids[self.random.below(ids.len())];
                self.commands.push(json!({"replace": {"id": id, "with": section}}));
                self.sections.insert(id, section);
            }
            _ => {
                self.commands.push(json!({"add": section}));
                self.sections.insert(self.numbers, section);
                self.numbers += 1;
            }
        }
        self.past.push(before);
        self.be();
    }

    /// On a plane of its own, with coordinates of all bits.
    fn any_square(&mut self) -> Value {
        let (axis, offset) = (self.random.below(3), self.random.between(-0.9..0.9));
        let half = self.random.between(0.5..1.0);
        square(&format!("s{}", self.commands.len()), axis, offset, half, 1)
    }

    fn be(&mut self) {
        let name = |section: &Value| section["sections"][0]["name"].as_str().map(str::to_owned);
        let listed = self.sections.iter();
        let listed = listed.map(|(&id, section)| (id, name(section).expect("a name")));
        self.states.push(listed.collect());
    }
}

/// Kills the program after so many milliseconds while it works on commands; returns how many
/// it acknowledged.
fn killed(path: &Path, options: &[&str], commands: &[Value], milliseconds: f64) -> usize {
    let start = Instant::now();
    let mut command = online(path, options);
    command.stdin(Stdio::piped()).stdout(Stdio::piped()).stderr(Stdio::null());
    let mut child = command.spawn().expect("the program runs");
    let mut input = child.stdin.take().expect("its input");
    let text: String = commands.iter().map(|command| format!("{command}\n")).collect();
    // It is killed before it has read everything.
    let writer = thread::spawn(move || drop(input.write_all(text.as_bytes())));
    let mut output = child.stdout.take().expect("its output");
    let reader = thread::spawn(move || {
        let mut text = Vec::new();
        output.read_to_end(&mut text).expect("its output");
        text
    });
    let delay = Duration::from_secs_f64(milliseconds / 1e3);
    thread::sleep(delay.saturating_sub(start.elapsed()));
    child.kill().expect("it runs");
    child.wait().expect("it ended");
    writer.join().expect("the writer");
    let text = String::from_utf8(reader.join().expect("the reader")).expect("text");
    // What ends without a line's end was not received.
    let lines = text.split_inclusive('\n').filter(|line| line.ends_with('\n'));
    let answers: Vec<Value> = lines.map(|line| serde_json::from_str(line).expect("JSON")).collect();
    assert!(answers.iter().all(|answer| answer.get("error").is_none()), "{text}");
    answers.iter().filter(|answer| answer.get("change").is_some()).count()
}

#[test]
fn nothing_acknowledged_is_lost_when_the_program_is_killed() {
    const KILLS: usize = 5;
    let kills = more("TRANSECT_KILLS", 20);
    let (mut total, mut acknowledged, mut unacknowledged, mut torn) = (0, 0, 0, 0);
    for seed in 0..kills.div_ceil(KILLS) {
        let folder = folder();
        let path = folder.path();
        let mut story = Story::new(seed as u64);
        let options = ["--journal", "a.journal", "--resume", BOX, "--quiet"];
        let mut done = 0;
        for _ in 0..KILLS {
            while story.commands.len() < done + 60 {
                story.go_on();
            }
            let milliseconds = story.random.between(5.0..400.0);
            let count = killed(path, &options, &story.commands[done..], milliseconds);
            (done, acknowledged) = (done + count, acknowledged + count);
            // What is there: everything acknowledged, and at most the change under way.
            let mut online = Online::start(path, &options);
            let answer = online.answer();
            let changes = answer["changes"].as_u64().expect("a count") as usize;
            assert!((done..=done + 1).contains(&changes), "{done} acknowledged: {answer}");
            assert_eq!(listed(&answer["sections"]), story.states[changes]);
            (total, unacknowledged) = (total + 1, unacknowledged + changes - done);
            torn += usize::from(answer.get("warnings").is_some());
            done = changes;
            assert_eq!(online.end().0, Some(0));
        }
        if seed == 0 {
            let mut online = Online::start(path, &options);
            online.answer();
            story.commands[done..].iter().for_each(|command| drop(online.does(command.clone())));
            online.does(json!({"save": "resumed.ply"}));
            assert_eq!(online.end().0, Some(0));
            let mut whole = Online::start(path, &[BOX, "--quiet"]);
            story.commands.iter().for_each(|command| drop(whole.does(command.clone())));
            whole.does(json!({"save": "whole.ply"}));
            assert_eq!(whole.end().0, Some(0));
            assert_same_meshes(path, "whole.ply", "resumed.ply");
        }
    }
    println!(
        "{total} kills: {acknowledged} changes acknowledged and kept, {unacknowledged} kept \
         unacknowledged, {torn} torn"
    );
    assert!(total >= kills && acknowledged > kills);
}

#[test]
fn every_change_leaves_a_frame_and_numbers_go_on() {
    let folder = folder();
    let path = folder.path();
    let options = ["--journal", "a.journal", "--emit", "frames", "--quiet"];
    let mut first = Online::start(path, &options);
    let answer = first.does(json!({"add": square("a", 0, -0.4, 1.0, 1)}));
    assert_eq!(answer["frame"], "frames/frame_000001.ply");
    first.refuses(r#"{"remove": 5}"#, &["5"]);
    first.does(json!({"add": square("b", 1, 0.1, 1.0, 1)}));
    first.does(json!({"save": "saved.ply"}));
    assert_eq!(first.end().0, Some(0));
    assert_same_meshes(path, "saved.ply", "frames/frame_000002.ply");
    // The frame of a change that was made just before a crash.
    fs::remove_file(path.join("frames/frame_000002.ply")).expect("removed");
    let mut second = Online::start(path, &[&options[..], &["--resume"]].concat());
    assert_eq!(second.answer()["frame"], "frames/frame_000002.ply");
    second.does(json!({"remove": 0}));
    assert_eq!(second.end().0, Some(0));
    let names = ["frame_000001.ply", "frame_000002.ply", "frame_000003.ply"];
    assert_eq!(entries(&path.join("frames")), names);
    assert_same_meshes(path, "saved.ply", "frames/frame_000002.ply");
    // Frames of two runs are not mixed.
    let output = run(online(path, &["--emit", "frames"]).stdin(Stdio::null()));
    assert_refused(&output, &["frames", "another folder"]);

    let options = ["--emit", "v", "--emit-kind", "vdb", "--labels", "7", "--quiet"];
    let mut volumes = Online::start(path, &options);
    let answer = volumes.does(json!({"add": square("a", 0, -0.4, 1.0, 1)}));
    assert_eq!(answer["frame"], "v/frame_000001.vdb");
    // Only pictures need a material that is not there yet.
    volumes.refuses(r#"{"save": "a.png"}"#, &["--labels", "\"7\""]);
    volumes.does(json!({"save": "a.obj"}));
    let answer = volumes.does(json!({"remove": 0}));
    assert_eq!(answer.get("frame"), None, "nothing is left");
    assert_eq!(volumes.end().0, Some(0));
    assert_eq!(entries(&path.join("v")), ["frame_000001.vdb"]);
}

/// Two layers of patches, of which a section far above changes the upper ones alone.
#[test]
fn patches_that_changed_are_named() {
    let folder = folder();
    let mut online = Online::start(folder.path(), &[BOX, "--smooth", "0", "--patches"]);
    let names = |answer: &Value, what: &str| -> Vec<[i64; 3]> {
        serde_json::from_value(answer["patches"][what].clone()).expect("names")
    };
    let squares = [(-0.8, 0.3), (0.5, 0.8), (0.8, 0.6)];
    let squares = squares
        .map(|(offset, half)| json!({"add": square(&offset.to_string(), 2, offset, half, 1)}));
    let first = online.does(json!({"all": squares}));
    let all = names(&first, "changed");
    assert_eq!(all.len(), 8);
    let (origin, side) = (&first["patches"]["origin"][2], &first["patches"]["side"]);
    let border = origin.as_f64().expect("a place") + side.as_f64().expect("a length");
    assert!(border > 0.0 && border < 0.5, "{border}");
    let upper: Vec<[i64; 3]> = all.iter().copied().filter(|name| name[2] == 1).collect();
    let above = square("1.0", 2, 1.0, 0.9, 1);
    let second = online.does(json!({"add": above}));
    assert_eq!(names(&second, "changed"), upper);
    let same = online.does(json!({"replace": {"id": 3, "with": above}}));
    assert_eq!(names(&same, "changed").len(), 0);
    let back = online.does(json!({"remove": 3}));
    assert_eq!(names(&back, "changed"), upper);
    let gone = online.does(json!({"all": [{"remove": 0}, {"remove": 1}, {"remove": 2}]}));
    assert_eq!((names(&gone, "changed").len(), names(&gone, "removed")), (0, all));
    assert_eq!(online.end().0, Some(0));
}

/// Waits for an answer about a file.
fn about(online: &mut Online, file: &str) -> Value {
    let answer = online.answer();
    assert_eq!(answer["file"], file, "{answer}");
    answer
}

#[test]
fn files_of_a_folder_are_followed() {
    let folder = folder();
    let path = folder.path();
    let watched = path.join("in");
    fs::create_dir(&watched).expect("a folder");
    let write = |name: &str, content: &str| {
        fs::write(watched.join(name), content).expect("written");
    };
    let text = |name: &str, axis, half| square(name, axis, 0.1, half, 1).to_string();
    write("a.json", &text("1", 0, 1.0));
    write(".b.json", "a temporary file");
    write("b.json.part", "another one");
    let options = ["--watch", "in", "--journal", "a.journal", "--resume", "--quiet"];
    let mut online = Online::start(path, &options);
    online.answer();
    let answer = about(&mut online, "a.json");
    assert_eq!(listed(&answer["added"]), pairs(&[(0, "watched/a.json/1")]));

    // Half a file is not yet a bad one.
    let b = text("1", 1, 1.0);
    write("b.json", &b[..b.len() / 2]);
    thread::sleep(Duration::from_millis(400));
    write("b.json", &b);
    let answer = about(&mut online, "b.json");
    assert_eq!(listed(&answer["added"]), pairs(&[(1, "watched/b.json/1")]));
    // A bad one is told once, and the rest goes on.
    write("c.json", &b[..b.len() / 2]);
    let answer = about(&mut online, "c.json");
    assert!(answer["error"].as_str().is_some_and(|error| error.contains("c.json")), "{answer}");
    write("c.json", &text("1", 2, 1.0));
    let answer = about(&mut online, "c.json");
    assert_eq!(listed(&answer["added"]), pairs(&[(2, "watched/c.json/1")]));
    // A change keeps the number.
    write("b.json", &text("1", 1, 0.5));
    let answer = about(&mut online, "b.json");
    assert_eq!((&answer["replaced"], &answer["sections"]), (&json!([1]), &3.into()));
    // What contradicts others fits when these are gone.
    write("d.json", &square("1", 0, 0.1, 1.0, 7).to_string());
    let answer = about(&mut online, "d.json");
    assert!(answer["error"].to_string().contains("lies on the plane"), "{answer}");
    fs::remove_file(watched.join("a.json")).expect("removed");
    assert_eq!(about(&mut online, "a.json")["removed"], json!([0]));
    let answer = about(&mut online, "d.json");
    assert_eq!(listed(&answer["added"]), pairs(&[(3, "watched/d.json/1")]));
    online.child.kill().expect("it runs");
    online.child.wait().expect("it ended");

    // What happened meanwhile is followed, and what did not change is left alone.
    fs::remove_file(watched.join("d.json")).expect("removed");
    write("c.json", &text("1", 2, 0.5));
    let more = ["--idle", "1", "-o", "end.ply"];
    let mut online = Online::start(path, &[&options[..], &more].concat());
    assert_eq!(listed(&online.answer()["sections"]).len(), 3);
    let mut answers = [online.answer(), online.answer()];
    answers.sort_by_key(|answer| answer["file"].to_string());
    assert_eq!((&answers[0]["file"], &answers[0]["replaced"]), (&"c.json".into(), &json!([2])));
    assert_eq!((&answers[1]["file"], &answers[1]["removed"]), (&"d.json".into(), &json!([3])));
    assert_eq!(online.end().0, Some(0));
    let left = [square("b", 1, 0.1, 0.5, 1), square("c", 2, 0.1, 0.5, 1)];
    assert_reconstructs(path, &left, "end.ply");
}

#[test]
#[cfg(unix)]
fn an_interrupt_ends_it_and_the_journal_goes_on() {
    let folder = folder();
    let path = folder.path();
    let options = ["--journal", "a.journal", "--resume", "--quiet"];
    let mut online = Online::start(path, &options);
    assert_eq!(online.answer()["changes"], 0, "a journal that is not there begins");
    online.does(json!({"add": square("a", 0, -0.4, 1.0, 1)}));
    let pid = online.child.id().to_string();
    assert!(Command::new("kill").args(["-INT", &pid]).status().expect("kill runs").success());
    assert_eq!(online.child.wait().expect("it ends").code(), Some(130));
    let mut online = Online::start(path, &options);
    assert_eq!(listed(&online.answer()["sections"]), pairs(&[(0, "a")]));
    assert_eq!(online.end().0, Some(0));
}

#[test]
fn wrong_usage_is_refused() {
    let folder = folder();
    let usages: &[&[&str]] = &[
        &["--resume"],
        &["--idle", "3"],
        &["--watch", ".", "a.csl"],
        &["--watch", ".", "--idle", "0"],
        &["--bounds", "0,0,0,1,1"],
        &["--bounds", "0,0,0,1,1,-1"],
        &["--emit-kind", "vdb"],
    ];
    for usage in usages {
        let output = run(online(folder.path(), usage).stdin(Stdio::null()));
        assert_eq!(output.status.code(), Some(2), "{usage:?}");
    }
    let refused = |options: &[&str], words: &[&str]| {
        assert_refused(&run(online(folder.path(), options).stdin(Stdio::null())), words);
    };
    refused(&["--watch", "missing"], &["missing", "cannot be watched"]);
    refused(&["--watch", ".", "-o", "a.ply"], &["--idle"]);
    refused(&["-o", "missing/a.ply"], &["does not exist"]);
    refused(&["missing.csl"], &["missing.csl", "no such file"]);
    refused(&["-o", "a.ply"], &["nothing to write"]);
    refused(&["--journal", "."], &["."]);
    refused(&["--fair"], &["--fair", "skeleton"]);
    assert!(entries(folder.path()).is_empty());
}

/// How much memory a process holds, in MiB.
#[cfg(target_os = "linux")]
fn resident(process: u32) -> f64 {
    let status = fs::read_to_string(format!("/proc/{process}/status")).expect("it runs");
    let line = status.lines().find(|line| line.starts_with("VmRSS:")).expect("a size");
    let kibibytes = line.split_whitespace().nth(1).and_then(|word| word.parse::<f64>().ok());
    kibibytes.expect("a number") / 1024.0
}

#[test]
#[cfg(target_os = "linux")]
fn memory_stays_flat_while_a_window_of_sections_goes_by() {
    let (count, window) = (more("TRANSECT_WINDOW", 120), 40);
    let folder = folder();
    let mut online = Online::start(folder.path(), &["--journal", "a.journal", BOX, "--quiet"]);
    let mut sizes = Vec::new();
    for i in 0..count {
        // Offsets by the golden ratio, so that planes in the window are apart.
        let offset = 1.8 * (i as f64 * 0.618_033_988_749_895).fract() - 0.9;
        let name = format!("frame {i}");
        let add = json!({"add": square(&name, i % 3, offset, 1.0, 1)});
        let command = match i.checked_sub(window) {
            Some(old) => json!({"all": [add, {"remove": old}]}),
            None => add,
        };
        let answer = online.does(command);
        assert_eq!(answer["sections"].as_u64(), Some((i + 1).min(window) as u64));
        sizes.push(resident(online.child.id()));
    }
    assert_eq!(online.end().0, Some(0));
    let (early, late) = (count / 6, count / 6 * 5);
    let largest = |sizes: &[f64]| sizes.iter().copied().fold(0.0, f64::max);
    let [half, whole] = [&sizes[early..count / 2], &sizes[late..]].map(largest);
    println!("after {early} {:.1} MiB, at the end {:.1} MiB", sizes[early], sizes[count - 1]);
    assert!(whole < 1.1 * half, "from {half} to {whole} MiB");
}
