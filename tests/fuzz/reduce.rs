//! Makes a failing set, or a failing file, small.

use std::path::Path;
use std::time::{Duration, Instant};

use super::judge::{Task, Verdict};
use super::set::Set;
use super::worker::Worker;
use super::{Job, Source, generate, readers};

/// Longer than this no set is reduced.
const LONGEST: Duration = Duration::from_secs(100);

/// Reduces what failed and puts it into the corpus.
pub fn keep(job: &Job, what: &str) {
    let Source::Seed(seed) = job.source else { return };
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/fuzz/corpus");
    let read = readers::file(seed);
    let kind = if job.task == Task::Read { &read.kind } else { "json" };
    let file = folder.join(format!("{}_{seed}.{kind}", job.task.name()));
    let mut reducer = Reducer {
        worker: Worker::default(),
        job: Job { source: Source::File(file.clone()), task: job.task },
        file: file.clone(),
        kind: alike(what),
    };
    let written = std::fs::create_dir_all(&folder);
    if let Err(error) = written {
        println!("{}: {error}", folder.display());
        return;
    }
    let small = match job.task {
        Task::Reconstruct(_) => {
            reducer.reduced(generate::set(seed), |set| set.to_json().into_bytes(), smaller)
        }
        Task::Read => reducer.reduced(read, |file| file.bytes.clone(), readers::smaller),
    };
    match std::fs::write(&file, small) {
        Ok(()) => println!("kept {} ({what})", file.display()),
        Err(error) => println!("{}: {error}", file.display()),
    }
}

/// What failures of one kind have in common: their words without numbers.
fn alike(what: &str) -> String {
    what.chars().filter(|letter| letter.is_alphabetic() || *letter == ' ').take(40).collect()
}

struct Reducer {
    worker: Worker,
    job: Job,
    file: std::path::PathBuf,
    kind: String,
}

impl Reducer {
    /// Whether a file fails as the first one did.
    fn fails(&mut self, bytes: &[u8]) -> bool {
        if std::fs::write(&self.file, bytes).is_err() {
            return false;
        }
        let verdict = self.worker.ask(&self.job).verdict;
        matches!(verdict, Verdict::Bad(what) if alike(&what) == self.kind)
    }

    /// Leaves out what can be left out, as long as there is time; the file that is left.
    fn reduced<T>(
        &mut self,
        mut whole: T,
        bytes: impl Fn(&T) -> Vec<u8>,
        smaller: impl Fn(&T) -> Vec<T>,
    ) -> Vec<u8> {
        let until = Instant::now() + LONGEST;
        if !self.fails(&bytes(&whole)) {
            return bytes(&whole);
        }
        loop {
            let mut parts = smaller(&whole).into_iter().take_while(|_| Instant::now() < until);
            match parts.find(|part| self.fails(&bytes(part))) {
                Some(part) => whole = part,
                None => return bytes(&whole),
            }
        }
    }
}

/// All sets with one thing less, large things first.
fn smaller(set: &Set) -> Vec<Set> {
    let mut found = Vec::new();
    let mut without = |change: &dyn Fn(&mut Set)| {
        let mut smaller = set.clone();
        change(&mut smaller);
        if smaller != *set {
            found.push(smaller);
        }
    };
    for section in 0..set.0.len() {
        without(&|set| drop(set.0.remove(section)));
    }
    for section in 0..set.0.len() {
        without(&|set| set.0[section].extent.clear());
        for contour in 0..set.0[section].contours.len() {
            without(&|set| drop(set.0[section].contours.remove(contour)));
        }
    }
    for (section, drawn) in set.0.iter().enumerate() {
        for (contour, own) in
            drawn.contours.iter().enumerate().filter(|(_, own)| own.points.len() > 3)
        {
            for point in 0..own.points.len() {
                without(&|set| {
                    set.0[section].contours[contour].points.remove(point);
                });
            }
        }
    }
    found
}
