//! `./x fuzz sections [MINUTES]`: random degenerate sections through the exact
//! reconstruction, made fair or not, through the other methods and the Delaunay mesher.
//! `./x fuzz readers [MINUTES]`: spoilt files through every reader. As a test, a short
//! and fixed share of both and all that is in the corpus.
//!
//! Each set runs in another process, which may crash, hang or take too much memory without
//! harm. What fails is reduced as long as it fails in the same way and written to
//! `tests/fuzz/corpus`, whose files are run by every test.

mod generate;
mod judge;
#[path = "../common/random.rs"]
mod random;
mod readers;
mod reduce;
mod set;
#[path = "../common/structure_set.rs"]
mod structure_set;
mod worker;

use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::sync::Mutex;
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::{Duration, Instant};

use judge::{Task, Verdict, Way};
use worker::Worker;

/// Sets that every test runs the exact way, and the others.
const SHORT: [u64; 2] = [150, 12];
/// Files that every test reads.
const FILES: u64 = 2000;
/// Failures after which a run ends.
const MOST_FAILURES: usize = 10;

fn main() -> ExitCode {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let words: Vec<&str> = arguments.iter().map(String::as_str).collect();
    match words[..] {
        ["worker"] => {
            worker::serve();
            ExitCode::SUCCESS
        }
        ["show", seed] => {
            println!("{}", generate::set(seed.parse().unwrap_or(0)).to_json());
            ExitCode::SUCCESS
        }
        ["sections" | "skeleton", ref rest @ ..] => {
            let named = |way: &Way| rest.get(2).is_none_or(|&name| way.name() == name);
            let ways = Way::ALL.into_iter().filter(named).map(Task::Reconstruct).collect();
            asked(rest, ways, "sections [MINUTES [SEED [METHOD]]]")
        }
        ["readers", ref rest @ ..] => asked(rest, vec![Task::Read], "readers [MINUTES [SEED]]"),
        // What cargo's test runner is asked for is meant for tests with names.
        _ if words.iter().any(|word| word.starts_with("--list")) => ExitCode::SUCCESS,
        _ => test(),
    }
}

/// A search, if what is asked for is right.
fn asked(rest: &[&str], tasks: Vec<Task>, usage: &str) -> ExitCode {
    let minutes = rest.first().map_or(Some(10.0), |word| word.parse().ok());
    let first = rest.get(1).map(|word| word.parse()).transpose();
    match (minutes, first) {
        (Some(minutes), Ok(first)) if !tasks.is_empty() => search(minutes, first, &tasks),
        _ => {
            let ways: Vec<&str> = Way::ALL.into_iter().map(Way::name).collect();
            println!("{usage}; methods: {}", ways.join(", "));
            ExitCode::from(2)
        }
    }
}

/// The corpus and a fixed share.
fn test() -> ExitCode {
    let mut jobs: Vec<Job> = corpus();
    let kept = jobs.len();
    for way in Way::ALL {
        let sets = if way == Way::Exact { SHORT[0] } else { SHORT[1] };
        let task = Task::Reconstruct(way);
        jobs.extend((0..sets).map(|seed| Job { source: Source::Seed(seed), task }));
    }
    let sets = jobs.len() - kept;
    jobs.extend((0..FILES).map(|seed| Job { source: Source::Seed(seed), task: Task::Read }));
    println!("{kept} kept cases, {sets} random sets and {FILES} spoilt files");
    report(&run(jobs.into_iter(), None), false)
}

/// New sets for so many minutes.
fn search(minutes: f64, first: Option<u64>, tasks: &[Task]) -> ExitCode {
    let start = first.unwrap_or_else(|| {
        let now = std::time::SystemTime::now().duration_since(std::time::UNIX_EPOCH);
        now.map_or(0, |since| since.as_secs() << 20)
    });
    println!("seeds from {start} on, for {minutes} minutes");
    let until = Instant::now() + Duration::from_secs_f64(60.0 * minutes);
    let jobs = (start..)
        .flat_map(|seed| tasks.iter().map(move |&task| Job { source: Source::Seed(seed), task }));
    report(&run(jobs, Some(until)), true)
}

/// Where a set comes from.
#[derive(Debug, Clone, PartialEq)]
enum Source {
    Seed(u64),
    File(PathBuf),
}

/// A set or a file, and what to do with it.
#[derive(Debug, Clone, PartialEq)]
struct Job {
    source: Source,
    task: Task,
}

/// The files of the corpus, each by the task that it begins with.
fn corpus() -> Vec<Job> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/fuzz/corpus");
    let Ok(entries) = std::fs::read_dir(&folder) else { return Vec::new() };
    let mut files: Vec<PathBuf> = entries.flatten().map(|entry| entry.path()).collect();
    files.sort();
    let job = |file: PathBuf| {
        let name = file.file_name()?.to_str()?.to_owned();
        let task = Task::all().find(|task| name.starts_with(task.name()))?;
        Some(Job { source: Source::File(file), task })
    };
    files.into_iter().filter_map(job).collect()
}

struct Outcome {
    tried: u64,
    refused: u64,
    slowest: f64,
    largest: u64,
    failures: Vec<(Job, String)>,
}

/// Runs jobs on all processors until they or the time end, or too many fail.
fn run(jobs: impl Iterator<Item = Job> + Send, until: Option<Instant>) -> Outcome {
    let jobs = Mutex::new(jobs);
    let outcome = Mutex::new(Outcome {
        tried: 0,
        refused: 0,
        slowest: 0.0,
        largest: 0,
        failures: Vec::new(),
    });
    let (started, shown) = (Instant::now(), AtomicU64::new(0));
    let threads = std::thread::available_parallelism().map_or(1, usize::from);
    std::thread::scope(|scope| {
        for _ in 0..threads {
            scope.spawn(|| {
                let mut worker = Worker::default();
                loop {
                    if until.is_some_and(|until| Instant::now() >= until) {
                        return;
                    }
                    let Some(job) = jobs.lock().ok().and_then(|mut jobs| jobs.next()) else {
                        return;
                    };
                    let answer = worker.ask(&job);
                    let Ok(mut outcome) = outcome.lock() else { return };
                    outcome.tried += 1;
                    outcome.slowest = outcome.slowest.max(answer.seconds);
                    outcome.largest = outcome.largest.max(answer.memory);
                    match answer.verdict {
                        Verdict::Good => {}
                        Verdict::Refused(_) => outcome.refused += 1,
                        Verdict::Bad(what) => {
                            println!("failed: {:?} {}: {what}", job.source, job.task.name());
                            outcome.failures.push((job, what));
                        }
                    }
                    if outcome.failures.len() >= MOST_FAILURES {
                        return;
                    }
                    let minute = started.elapsed().as_secs() / 60;
                    if shown.swap(minute, Ordering::Relaxed) < minute {
                        println!("{minute} min: {} tried", outcome.tried);
                    }
                }
            });
        }
    });
    outcome.into_inner().unwrap_or_else(std::sync::PoisonError::into_inner)
}

fn report(outcome: &Outcome, keeps: bool) -> ExitCode {
    println!(
        "{} tried, {} of them refused with words about the input, {} failed; the slowest took \
         {:.1} s, the largest {} MiB",
        outcome.tried,
        outcome.refused,
        outcome.failures.len(),
        outcome.slowest,
        outcome.largest >> 20
    );
    if keeps {
        for (job, what) in &outcome.failures {
            reduce::keep(job, what);
        }
    }
    if outcome.failures.is_empty() { ExitCode::SUCCESS } else { ExitCode::FAILURE }
}
