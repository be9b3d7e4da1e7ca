//! `transect online`: sections that come one by one, as commands or as files.

use std::io::{self, BufRead};
use std::path::{Path, PathBuf};
use std::thread;
use std::time::{Duration, Instant};

use serde::Serialize;
use serde_json::Value;

use super::args::{MethodArguments, OnlineArguments, ReadingArguments};
use super::frames::Frames;
use super::method::method;
use super::replies::{Cause, Reply, What, reply};
use super::results::{Results, picture_options, write_pages};
use super::targets::{Kind, Target, report_targets};
use super::{print_found, table, tell_shortened, write_json};
use crate::context::Context;
use crate::error::{Error, Result};
use crate::io::vdb::GridName;
use crate::io::{read_all, read_part};
use crate::model::Options;
use crate::online::answer::Answer;
use crate::online::command::{self, Act, Command, Edit};
use crate::online::folder::{self, Folder, Found, Refusal};
use crate::online::{Resumed, Session};
use crate::output::Outputs;
use crate::picture::PictureOptions;
use crate::plane::Bounds;
use crate::progress::Silent;
use crate::report::Report;
use crate::stage::Stages;

/// How often a folder is looked at.
const INTERVAL: Duration = Duration::from_millis(50);

/// Follows sections until there are no more, and writes what is asked for then.
pub fn run(arguments: &OnlineArguments) -> Result<()> {
    let mut online = Online::begin(arguments)?;
    match &arguments.watch {
        Some(path) => online.follow_folder(path)?,
        None => online.follow_commands(io::stdin().lock())?,
    }
    online.finish()
}

/// A session with whoever is told about it.
struct Online<'a> {
    arguments: &'a OnlineArguments,
    session: Session,
    frames: Option<Frames>,
    grids: Vec<GridName>,
    /// What is written at the end.
    targets: Vec<Target>,
    /// Where the report for programs goes.
    report: Option<&'a Path>,
}

/// The options as the user gave them.
#[derive(Serialize)]
struct Words<'a> {
    #[serde(flatten)]
    method: &'a MethodArguments,
    bounds: Option<[[f64; 3]; 2]>,
    #[serde(flatten)]
    reading: &'a ReadingArguments,
}

impl<'a> Online<'a> {
    fn begin(arguments: &'a OnlineArguments) -> Result<Self> {
        let OnlineArguments { bounds, reading, emit, emit_kind, .. } = arguments;
        let (method, grid) = (method(&arguments.method, false)?, arguments.method.grid);
        let (resolution, margin, bounds) = (grid.resolution(), grid.margin, *bounds);
        let options = Options { method, resolution, bounds, margin, ..Options::default() };
        let mut targets = Target::all(&arguments.output, &arguments.volumes)?;
        let (report, page) = report_targets(arguments.report.as_deref())?;
        targets.extend(page);
        let grids = GridName::parse_all(&arguments.volumes.grids)?;
        let is_written = !targets.is_empty() || arguments.report.is_some();
        if is_written && arguments.watch.is_some() && arguments.idle.is_none() {
            let what = "a folder is watched until Ctrl-C, and nothing is written then: add --idle \
                        SECONDS, or leave --output and --report out";
            return Err(Error::Option(what.to_owned()));
        }
        // They are written much later, but what is wrong with them is told now.
        reserve(&targets, report)?;
        let frames = emit.as_ref().map(|path| Frames::new(path, *emit_kind, arguments.resume));
        let frames = frames.transpose()?;
        let mut stages = Stages::default();
        let (mut session, resumed) = session(arguments, options, &mut stages)?;
        if arguments.patches {
            session.follow_patches();
        }
        let mut online = Self { arguments, session, frames, grids, targets, report };
        if let Some(resumed) = &resumed {
            online.tell_resumed(resumed)?;
        }
        if online.session.changes() == 0 && !arguments.sections.is_empty() {
            let mut stages = Stages::default();
            let sections =
                stages.run("read", |_| read_all(&arguments.sections, &reading.rules()))?;
            let act = Act::Edit(Box::new(Edit::Add(sections)));
            online.act(Cause::Line(0), act, stages)??;
        }
        Ok(online)
    }

    fn tell_resumed(&self, resumed: &Resumed) -> Result<()> {
        let mut resumed = resumed.clone();
        if resumed.changes > 0 && !self.arguments.sections.is_empty() {
            let what = "the journal holds changes, so the files to begin with are not read again";
            resumed.warnings.push(what.to_owned());
        }
        if !self.arguments.quiet {
            for warning in &resumed.warnings {
                tell_shortened(&format!("warning: {warning}"));
            }
        }
        // It may be that the last change was made, but its frame was not.
        let frame = self.write_frame()?;
        let journal = self.arguments.journal.as_deref().unwrap_or(Path::new(""));
        reply(&Reply {
            to: Cause::Resumed(journal),
            what: What::Resumed(&resumed),
            frame: frame.as_deref(),
        })
    }

    /// Commands, a line each, until there are no more.
    fn follow_commands(&mut self, mut input: impl BufRead) -> Result<()> {
        let failed = |error| Error::Option(format!("standard input cannot be read: {error}"));
        let (mut line, mut number) = (Vec::new(), 0);
        while input.read_until(b'\n', &mut line).map_err(failed)? > 0 {
            number += 1;
            if !line.trim_ascii().is_empty() {
                self.obey(number, &line)?;
            }
            line.clear();
        }
        Ok(())
    }

    fn obey(&mut self, number: u64, line: &[u8]) -> Result<()> {
        let mut stages = Stages::default();
        let command = stages.run("read", |_| {
            let text = std::str::from_utf8(line).map_err(|error| {
                Error::Option(format!("byte {} is no UTF-8", error.valid_up_to()))
            })?;
            let place = format!("line {number}");
            command::parse(text, Path::new(&place), self.session.rules())
        });
        let to = Cause::Line(number);
        let written = match command {
            Ok(Command::Act(act)) => return self.act(to, act, stages).map(|_| ()),
            Ok(Command::Save(path)) => self.save(&path, &mut stages).map(|()| path),
            Ok(Command::Report(path)) => self.save_report(&path, &mut stages).map(|()| path),
            Err(error) => Err(error),
        };
        let what = match &written {
            Ok(path) => What::Written { written: path, stages: &stages.stages },
            Err(error) => What::refused(error),
        };
        reply(&Reply { to, what, frame: None })
    }

    /// Changes the model and answers; what is refused is within.
    fn act(&mut self, to: Cause, act: Act, mut stages: Stages) -> Result<Result<()>> {
        match self.change(act, &mut stages)? {
            Ok(answer) => self.tell(to, answer).map(Ok),
            Err(error) => {
                reply(&Reply { to, what: What::refused(&error), frame: None })?;
                Ok(Err(error))
            }
        }
    }

    /// The files of a folder, for as long as there is something to do.
    fn follow_folder(&mut self, path: &Path) -> Result<()> {
        let mut folder = Folder::new(path, self.session.model())?;
        let mut last = Instant::now();
        let ends = |last: Instant| self.arguments.idle.is_some_and(|idle| last.elapsed() >= idle);
        while !(ends(last) && folder.is_settled()) {
            for file in folder.look()? {
                if self.follow_file(&mut folder, &file)? {
                    last = Instant::now();
                }
            }
            thread::sleep(INTERVAL);
        }
        Ok(())
    }

    /// Whether there was something to tell.
    fn follow_file(&mut self, folder: &mut Folder, file: &Found) -> Result<bool> {
        let (name, mut stages) = (file.name.as_str(), Stages::default());
        let read = |path: &PathBuf| stages.run("read", |_| read_part(path, self.session.rules()));
        let sections = match file.path.as_ref().map(read).transpose() {
            Ok(sections) => sections,
            Err(error) => return refuse(folder, name, Refusal::Unread(error)),
        };
        let Some(edit) = folder::edit(self.session.model(), name, sections) else {
            folder.settle(name);
            return Ok(false);
        };
        match self.change(Act::Edit(Box::new(edit)), &mut stages)? {
            Ok(answer) => {
                folder.accept(name);
                self.tell(Cause::File(name), answer).map(|()| true)
            }
            Err(error) => refuse(folder, name, Refusal::Unfit(error)),
        }
    }

    /// Changes the model. Failures of the program itself are on the outside, what is refused
    /// within.
    fn change(&mut self, act: Act, stages: &mut Stages) -> Result<Result<Answer>> {
        match self.session.act(act, stages) {
            Err(error) if self.session.is_broken() => Err(error),
            other => Ok(other),
        }
    }

    /// Acknowledges a change that was made.
    fn tell(&self, to: Cause, answer: Answer) -> Result<()> {
        let frame = self.write_frame()?;
        reply(&Reply { to, what: What::Changed(Box::new(answer)), frame: frame.as_deref() })
    }

    /// The frame of the model as it is; without sections there is none.
    fn write_frame(&self) -> Result<Option<PathBuf>> {
        let model = self.session.model();
        match &self.frames {
            Some(frames) if model.derived().is_some() => {
                let results = Results::new([model], &self.grids, PictureOptions::default())?;
                let results = results.stored(&self.arguments.volumes);
                frames.write(self.session.changes(), &results).map(Some)
            }
            _ => Ok(None),
        }
    }

    /// Writes the result as it is now.
    fn save(&self, path: &Path, stages: &mut Stages) -> Result<()> {
        let target = Target::new(path)?;
        let mut outputs = Outputs::default();
        self.write_targets(std::slice::from_ref(&target), &mut outputs, stages)?;
        outputs.commit()
    }

    /// Writes the report on what the model is now.
    fn save_report(&self, path: &Path, stages: &mut Stages) -> Result<()> {
        if let (_, Some(_)) = report_targets(Some(path))? {
            return self.save(path, stages);
        }
        let mut outputs = Outputs::reserve([path])?;
        let report = self.write_targets(&[], &mut outputs, stages)?;
        outputs.write(path, |out| write_json(path, &report, out))?;
        outputs.commit()
    }

    /// Checks and writes what the model is now.
    fn write_targets(
        &self,
        targets: &[Target],
        outputs: &mut Outputs,
        stages: &mut Stages,
    ) -> Result<Report> {
        let model = self.session.model();
        let materials = &model.sections().materials;
        // Materials that pictures ask for need not be there as long as none is drawn.
        let picture = match targets.iter().any(|target| target.kind.has_pictures()) {
            true => picture_options(&self.arguments.picture, materials)?,
            false => PictureOptions { up: self.arguments.picture.up, ..PictureOptions::default() },
        };
        let results = Results::new([model], &self.grids, picture)?;
        let results = results.stored(&self.arguments.volumes);
        for target in targets {
            target.reserve_known(outputs)?;
            target.reserve_named(outputs, materials)?;
        }
        let mut context = Context {
            stages: std::mem::take(stages),
            ..Context::new(*self.session.rules(), &Silent)
        };
        let checked = model.check(&mut context);
        *stages = context.stages;
        let checked = checked?;
        for target in targets.iter().filter(|target| target.kind != Kind::Page) {
            stages.run(target.kind.stage(), |_| results.write(outputs, target))?;
        }
        let is_page = targets.iter().any(|target| target.kind == Kind::Page);
        let drawn = || stages.run("page", |_| results.page([&checked], &Silent));
        let page = is_page.then(drawn).transpose()?;
        let nothing = || Error::Option("there is nothing to report: no section is left".to_owned());
        let report = model.report(checked, stages).ok_or_else(nothing)?;
        if let Some(page) = &page {
            write_pages(outputs, targets, page, &report)?;
        }
        Ok(report)
    }

    /// What is asked for at the end.
    fn finish(&self) -> Result<()> {
        let report_path = self.report;
        if self.targets.is_empty() && report_path.is_none() {
            return Ok(());
        }
        let mut stages = Stages::default();
        let mut outputs = Outputs::reserve(report_path)?;
        let report = self.write_targets(&self.targets, &mut outputs, &mut stages)?;
        if let Some(path) = report_path {
            outputs.write(path, |out| write_json(path, &report, out))?;
        }
        outputs.commit()?;
        if !self.arguments.quiet {
            let materials = &self.session.model().sections().materials;
            for doubt in self.targets.iter().filter_map(|target| target.doubt(materials)) {
                tell_shortened(&format!("warning: {doubt}"));
            }
            print_found(&report);
            table::print(&report);
        }
        Ok(())
    }
}

/// Tells why a file is not followed, unless that was told. Returns whether it was.
fn refuse(folder: &mut Folder, name: &str, why: Refusal) -> Result<bool> {
    let is_told = folder.refuse(name, &why);
    if is_told {
        let (Refusal::Unread(error) | Refusal::Unfit(error)) = &why;
        reply(&Reply { to: Cause::File(name), what: What::refused(error), frame: None })?;
    }
    Ok(is_told)
}

/// The session, and what its journal held.
fn session(
    arguments: &OnlineArguments,
    options: Options,
    stages: &mut Stages,
) -> Result<(Session, Option<Resumed>)> {
    let rules = arguments.reading.rules();
    let Some(path) = &arguments.journal else { return Ok((Session::new(options, rules), None)) };
    let words = words(arguments)?;
    if !arguments.resume {
        return Ok((Session::begin(options, rules, path, &words)?, None));
    }
    let (session, resumed) = Session::resume(options, rules, path, &words, stages)?;
    Ok((session, Some(resumed)))
}

fn words(arguments: &OnlineArguments) -> Result<Value> {
    let words = Words {
        method: &arguments.method,
        bounds: arguments.bounds.map(|Bounds { min, max }| [min, max].map(|it| it.to_array())),
        reading: &arguments.reading,
    };
    serde_json::to_value(words)
        .map_err(|error| Error::Bug { stage: "journal", what: error.to_string() })
}

/// Makes sure that what is written at the end can be, and that no two names are the same.
fn reserve(targets: &[Target], report: Option<&Path>) -> Result<()> {
    let mut outputs = Outputs::reserve(report)?;
    targets.iter().try_for_each(|target| target.reserve_known(&mut outputs))
}
