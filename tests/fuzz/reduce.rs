//! Makes a failing set small.

use std::path::Path;
use std::time::{Duration, Instant};

use super::generate;
use super::judge::Verdict;
use super::set::Set;
use super::worker::Worker;
use super::{Job, Source};

/// Longer than this no set is reduced.
const LONGEST: Duration = Duration::from_secs(100);

/// Reduces a set that failed and puts it into the corpus.
pub fn keep(job: &Job, what: &str) {
    let Source::Seed(seed) = job.source else { return };
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/fuzz/corpus");
    let file = folder.join(format!("{}_{seed}.json", job.way.name()));
    let mut reducer = Reducer {
        worker: Worker::default(),
        job: Job { source: Source::File(file.clone()), way: job.way },
        file: file.clone(),
        kind: kind(what),
    };
    let set = generate::set(seed);
    let written = std::fs::create_dir_all(&folder);
    if let Err(error) = written {
        println!("{}: {error}", folder.display());
        return;
    }
    let small = if reducer.fails(&set) { reducer.reduced(set) } else { set };
    match std::fs::write(&file, small.to_json()) {
        Ok(()) => println!("kept {} ({what})", file.display()),
        Err(error) => println!("{}: {error}", file.display()),
    }
}

/// What failures of one kind have in common: their words without numbers.
fn kind(what: &str) -> String {
    what.chars().filter(|letter| letter.is_alphabetic() || *letter == ' ').take(40).collect()
}

struct Reducer {
    worker: Worker,
    job: Job,
    file: std::path::PathBuf,
    kind: String,
}

impl Reducer {
    /// Whether a set fails as the first one did.
    fn fails(&mut self, set: &Set) -> bool {
        if std::fs::write(&self.file, set.to_json()).is_err() {
            return false;
        }
        matches!(self.worker.ask(&self.job).verdict, Verdict::Bad(what) if kind(&what) == self.kind)
    }

    /// Leaves out what can be left out: sections, contours, vertices. As long as there is
    /// time.
    fn reduced(&mut self, mut set: Set) -> Set {
        let until = Instant::now() + LONGEST;
        loop {
            let mut smaller = smaller(&set).into_iter().take_while(|_| Instant::now() < until);
            let smaller = smaller.find(|smaller| self.fails(smaller));
            match smaller {
                Some(smaller) => set = smaller,
                None => return set,
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
