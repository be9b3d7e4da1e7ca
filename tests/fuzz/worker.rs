//! Another process that reconstructs one set after another.

use std::io::{BufRead, BufReader, Write};
use std::path::Path;
use std::process::{Child, ChildStdin, Command, Stdio};
use std::sync::mpsc::{Receiver, RecvTimeoutError, channel};
use std::time::{Duration, Instant};

use super::generate;
use super::judge::{Task, Verdict, judge};
use super::{Job, Source, readers};

/// A set that takes longer has failed.
const LONGEST: Duration = Duration::from_secs(60);
/// A process that comes to need more has failed.
const LARGEST: u64 = 2 << 30;
/// A process is asked so often before another takes its place.
const SERVED: u32 = 300;

/// How a job went, and what it took.
pub struct Answer {
    pub verdict: Verdict,
    pub seconds: f64,
    pub memory: u64,
}

/// A process that is started when it is needed.
#[derive(Default)]
pub struct Worker {
    running: Option<Running>,
}

struct Running {
    child: Child,
    stdin: ChildStdin,
    lines: Receiver<String>,
    served: u32,
}

impl Drop for Running {
    fn drop(&mut self) {
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

impl Running {
    fn start() -> std::io::Result<Self> {
        let mut child = Command::new(std::env::current_exe()?)
            .arg("worker")
            .env("RAYON_NUM_THREADS", "1")
            .stdin(Stdio::piped())
            .stdout(Stdio::piped())
            .stderr(Stdio::null())
            .spawn()?;
        let broken = || std::io::Error::other("a pipe is missing");
        let stdin = child.stdin.take().ok_or_else(broken)?;
        let stdout = child.stdout.take().ok_or_else(broken)?;
        let (sender, lines) = channel();
        std::thread::spawn(move || {
            for line in BufReader::new(stdout).lines().map_while(Result::ok) {
                if sender.send(line).is_err() {
                    return;
                }
            }
        });
        Ok(Self { child, stdin, lines, served: 0 })
    }
}

impl Worker {
    pub fn ask(&mut self, job: &Job) -> Answer {
        let start = Instant::now();
        let (verdict, memory) = self.answer(job);
        let verdict = match verdict {
            Verdict::Bad(_) => verdict,
            _ if memory > LARGEST => Verdict::Bad(format!("it took {} MiB", memory >> 20)),
            _ => verdict,
        };
        if matches!(verdict, Verdict::Bad(_)) {
            self.running = None;
        }
        Answer { verdict, seconds: start.elapsed().as_secs_f64(), memory }
    }

    fn answer(&mut self, job: &Job) -> (Verdict, u64) {
        if self.running.as_ref().is_some_and(|running| running.served >= SERVED) {
            self.running = None;
        }
        if self.running.is_none() {
            match Running::start() {
                Ok(running) => self.running = Some(running),
                Err(error) => return (Verdict::Bad(format!("no process: {error}")), 0),
            }
        }
        let Some(running) = &mut self.running else {
            return (Verdict::Bad("no process".to_owned()), 0);
        };
        running.served += 1;
        let source = match &job.source {
            Source::Seed(seed) => format!("seed {seed}"),
            Source::File(file) => format!("file {}", file.display()),
        };
        if writeln!(running.stdin, "{} {source}", job.task.name()).is_err() {
            return (Verdict::Bad("the process is gone".to_owned()), 0);
        }
        match running.lines.recv_timeout(LONGEST) {
            Ok(line) => parse(&line),
            Err(RecvTimeoutError::Timeout) => {
                (Verdict::Bad(format!("it takes more than {} s", LONGEST.as_secs())), 0)
            }
            Err(RecvTimeoutError::Disconnected) => {
                let status = running.child.wait();
                let how = status.map_or_else(|error| error.to_string(), |how| how.to_string());
                (Verdict::Bad(format!("it crashed: {how}")), 0)
            }
        }
    }
}

fn parse(line: &str) -> (Verdict, u64) {
    let mut parts = line.splitn(3, '\t');
    let memory = parts.next().and_then(|part| part.parse().ok()).unwrap_or(0);
    let (kind, words) = (parts.next().unwrap_or(""), parts.next().unwrap_or("").to_owned());
    let verdict = match kind {
        "good" => Verdict::Good,
        "refused" => Verdict::Refused(words),
        _ => Verdict::Bad(words),
    };
    (verdict, memory)
}

/// What the process does: a line in, a line out.
pub fn serve() {
    // In a folder, for the name of a file says what it is.
    let folder = std::env::temp_dir().join(format!("transect-fuzz-{}", std::process::id()));
    if std::fs::create_dir_all(&folder).is_err() {
        return;
    }
    for line in std::io::stdin().lines().map_while(Result::ok) {
        let verdict = answer(&line, &folder);
        let (kind, words) = match verdict {
            Verdict::Good => ("good", String::new()),
            Verdict::Refused(words) => ("refused", words),
            Verdict::Bad(words) => ("bad", words),
        };
        let memory = peak_memory();
        println!("{memory}\t{kind}\t{}", words.replace(['\n', '\t'], " "));
    }
    let _ = std::fs::remove_dir_all(folder);
}

fn answer(line: &str, folder: &Path) -> Verdict {
    let mut words = line.splitn(3, ' ');
    let (task, kind, rest) = (words.next(), words.next(), words.next());
    let task = Task::all().find(|own| Some(own.name()) == task);
    let (Some(task), Some(kind), Some(rest)) = (task, kind, rest) else {
        return Verdict::Bad(format!("not understood: {line}"));
    };
    let judge = |file: &Path, seed: u64| match task {
        Task::Reconstruct(way) => judge(file, way, seed),
        Task::Read => readers::judge(file),
    };
    if kind == "file" {
        return judge(Path::new(rest), 0);
    }
    let seed = rest.parse().unwrap_or(0);
    let (file, bytes) = match task {
        Task::Reconstruct(_) => {
            (folder.join("set.json"), generate::set(seed).to_json().into_bytes())
        }
        Task::Read => {
            let made = readers::file(seed);
            (folder.join(format!("file.{}", made.kind)), made.bytes)
        }
    };
    if let Err(error) = std::fs::write(&file, bytes) {
        return Verdict::Bad(error.to_string());
    }
    judge(&file, seed)
}

/// The largest resident size of this process so far, in bytes; 0 where it is not told.
fn peak_memory() -> u64 {
    let status = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
    let line = status.lines().find_map(|line| line.strip_prefix("VmHWM:")).unwrap_or("");
    let kibibytes = line.split_whitespace().next().and_then(|word| word.parse::<u64>().ok());
    1024 * kibibytes.unwrap_or(0)
}
