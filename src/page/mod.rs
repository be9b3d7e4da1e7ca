//! A report that people read: one file of HTML that needs neither a server nor a network, with a
//! verdict in words, pictures, tables, the surfaces to be turned, and the sections as small
//! pictures.
//!
//! ```text
//! models, checks ─► Page: views (pictures), scene (in space), plates (sections)
//!                      └─ with a Report ─► HTML: head, labels, sections, findings, stages
//! ```
//!
//! Everything is written by `maud`, which escapes what it is given; data for scripts is JSON that
//! cannot end its element (`text`). The scripts are made from `web/` (`./x web`), and the page
//! allows them alone, by their hash.

mod findings;
mod head;
mod labels;
mod lines;
mod marks;
mod outlines;
mod plates;
mod scene;
mod sections;
mod stages;
#[cfg(test)]
mod tests;
mod text;
mod verdict;
mod views;

use std::io::{self, Write};

use maud::{DOCTYPE, Markup, PreEscaped, html};
use serde_json::json;

use crate::check::Check;
use crate::error::{Error, Result};
use crate::mesh::Mesh;
use crate::model::Model;
use crate::picture::PictureOptions;
use crate::progress::Progress;
use crate::report::Report;
use crate::section::Sections;
use crate::sides::Sides;

use marks::{Kind, Mark, marks};
use plates::Plates;
use scene::Scene;
use text::{counted, json, name_of, swatch, text};
use views::View;

/// The scripts, and their hash as browsers have it.
const SCRIPT: &str = include_str!("../../web/dist/report.js");
const SCRIPT_HASH: &str = include_str!("../../web/dist/report.js.sha256");
const STYLE: &str = include_str!("../../web/report.css");

/// A model and what it is worth; of several layers each is one.
#[derive(Debug, Clone, Copy)]
pub struct Part<'a> {
    /// The sections and what follows from them.
    pub model: &'a Model,
    /// What the result is worth.
    pub check: &'a Check,
}

/// A page but for what the report says.
#[derive(Debug, Clone)]
pub struct Page {
    methods: Vec<String>,
    views: Vec<View>,
    /// `None` where there is nothing to see.
    scene: Option<Scene>,
    plates: Plates,
}

impl Page {
    /// Draws what there is to see: `surfaces` as they go to files and all `sections`, of several
    /// parts side by side.
    ///
    /// # Errors
    /// When cancelled, and when CGAL fails.
    pub fn new(
        parts: &[Part],
        surfaces: &Mesh,
        sections: &Sections,
        picture: &PictureOptions,
        progress: &dyn Progress,
    ) -> Result<Self> {
        let mut methods: Vec<String> = Vec::new();
        for part in parts {
            let method = part.model.options().method.in_words();
            if !methods.contains(&method) {
                methods.push(method);
            }
        }
        let scene = Scene::new(parts, surfaces, sections, picture)?;
        progress.begin("page", 0);
        let views = match scene {
            Some(_) => views::views(surfaces, sections, picture)
                .map_err(|error| Error::Bug { stage: "page", what: error.to_string() })?,
            None => Vec::new(),
        };
        progress.go_on()?;
        let sides = Sides::of(sections);
        let sides = picture.up.map_or(sides, |up| sides.standing(up));
        let plates = Plates::new(parts, &sides, &sections.frame);
        Ok(Self { methods, views, scene, plates })
    }

    /// Writes the page; `command` is what the program was called with, if anything.
    ///
    /// # Errors
    /// When `out` does.
    pub fn write(&self, report: &Report, command: &str, out: &mut dyn Write) -> io::Result<()> {
        let policy = format!(
            "default-src 'none'; img-src data:; style-src 'unsafe-inline'; \
             script-src 'sha256-{}'; base-uri 'none'; form-action 'none'",
            SCRIPT_HASH.trim()
        );
        let (marks, rest) = marks(report);
        let title = head::title(report);
        let corners = scene::corners(&self.plates.shown);
        let data = json(&json!({ "scene": self.scene, "marks": marks, "plates": corners }))?;
        let page = html! {
            (DOCTYPE)
            html lang="en" {
                head {
                    meta charset="utf-8";
                    meta http-equiv="Content-Security-Policy" content=(policy);
                    meta name="viewport" content="width=device-width, initial-scale=1";
                    meta name="color-scheme" content="light dark";
                    meta name="generator" content=(format!("transect {}", env!("CARGO_PKG_VERSION")));
                    title { (crate::terminal::escaped(&title)) " – transect" }
                    style { (PreEscaped(STYLE)) }
                }
                body {
                    (head::head(report))
                    (self.contents(report, &marks))
                    main { (self.body(report, (&marks, rest), command)) }
                    footer { p { "Made by " (text(&report.program)) "." } }
                    script type="application/json" id="data" { (PreEscaped(data)) }
                    script { (PreEscaped(SCRIPT)) }
                }
            }
        };
        out.write_all(page.into_string().as_bytes())
    }

    /// Where to find what.
    fn contents(&self, report: &Report, marks: &[Mark]) -> Markup {
        let looks = report.warnings.len();
        let scans = marks.iter().filter(|mark| mark.kind == Kind::Scan).count();
        html! {
            nav aria-label="Contents" {
                a href="#space" { "In space" }
                a href="#labels" { "Labels" }
                a href="#sections" { "Sections" }
                a href="#scan" { "Where to scan next" @if scans > 0 { small { (scans) } } }
                a href="#warnings" { "Warnings" @if looks > 0 { small { (looks) } } }
                a href="#made" { "How it was made" }
            }
        }
    }

    fn body(&self, report: &Report, (marks, rest): (&[Mark], usize), command: &str) -> Markup {
        html! {
            section #space { h2 { "In space" } (self.space(report)) (self.pictures()) }
            section #labels { h2 { "Labels" } (labels::labels(report)) (findings::besides(report)) }
            section #sections { h2 { "Sections" } (sections::sections(&self.plates, report)) }
            section #scan { h2 { "Where to scan next" } (findings::scan(report, marks)) }
            section #warnings { h2 { "Warnings" } (findings::warnings(report, marks, rest)) }
            @if !report.left_out.is_empty() {
                section #left-out { h2 { "Left out" } (findings::told(&report.left_out)) }
            }
            @if !report.disagreements.is_empty() {
                section #disagreements {
                    h2 { "Sections that contradict each other" }
                    (findings::disagreements(report))
                }
            }
            section #made {
                h2 { "How it was made" }
                (head::made(report, &self.methods, command))
                @if !report.notes.is_empty() { h3 { "How files were understood" } (findings::notes(report)) }
                h3 { "What it took" }
                (stages::stages(report))
            }
            section #words { h2 { "Words" } (words()) }
        }
    }

    /// What can be turned, and by which labels. Scripts take it from here.
    fn space(&self, report: &Report) -> Markup {
        let Some(scene) = &self.scene else {
            return html! { p { "There is nothing to see: no surface and no contour." } };
        };
        html! {
            noscript { p.absent { "Scripts are off in this browser: the pictures below show the result." } }
            p.absent #no-webgl hidden {
                "This browser draws nothing in space (WebGL is absent): the pictures below show the result."
            }
            div.space #viewer hidden {
                div.stage {
                    canvas tabindex="0" role="application" aria-label="The surfaces, to be turned. Arrows turn, with shift they move, plus and minus come nearer and go away, F shows all." {}
                    div.signs {}
                    div.views role="group" aria-label="From where" {
                        @for side in ["front", "left", "top"] {
                            button type="button" data-view=(side) { (side) }
                        }
                        button type="button" data-view="fit" { "all" }
                    }
                }
                fieldset.panel {
                    legend { "What is shown" }
                    @for label in scene.labels() { (self.label(report, label)) }
                    hr;
                    label { input type="checkbox" data-show="outlines" checked; " sections" }
                    label { input type="checkbox" data-show="scan" checked; " where to scan next" }
                    label { input type="checkbox" data-show="look" checked; " places to look at" }
                }
                p.hint { "Drag to turn, with the right button or two fingers to move; the wheel comes nearer after a click. Keys: arrows, + and −, F." }
            }
            (note(scene))
        }
    }

    fn label(&self, report: &Report, (label, color, glass): (u32, [u8; 3], bool)) -> Markup {
        let name = name_of(label, &report.materials);
        html! {
            div.row {
                label {
                    input type="checkbox" data-label=(label) checked;
                    (swatch(color)) (text(&name))
                }
                button type="button" data-glass=(label) aria-pressed=(glass.to_string()) title="See through it" { "glass" }
            }
        }
    }

    fn pictures(&self) -> Markup {
        html! {
            div.pictures {
                @for View { title, size: [width, height], source } in &self.views {
                    figure {
                        img src=(source) alt=(format!("{title}: the surfaces with the contours on them")) width=(width) height=(height);
                        figcaption { (title) }
                    }
                }
            }
        }
    }
}

/// What of the scene is less than what there is.
fn note(scene: &Scene) -> Markup {
    let [whole, shown] = scene.triangles;
    let [count, sections] = scene.sections;
    html! {
        @if shown < whole || sections < count || !scene.left_out.is_empty() {
            p.note {
                @if shown < whole {
                    "To keep the file small the surfaces have " (crate::figures::grouped(shown as u64))
                    " triangles here, of " (crate::figures::grouped(whole as u64)) ". "
                }
                @if sections < count { (sections) " of " (count) " sections are drawn here. " }
                @if !scene.left_out.is_empty() {
                    (counted(scene.left_out.len(), "label is", "labels are")) " not here: "
                    (text(&scene.left_out.iter().take(20).cloned().collect::<Vec<_>>().join(", "))) "."
                }
            }
        }
    }
}

/// What the words mean.
fn words() -> Markup {
    let words = [
        (
            "Dice",
            "twice the area that a section and the result on its plane have in common, over the sum of both areas: 1 where they are the same, 0 where they have nothing in common.",
        ),
        (
            "Closed",
            "the surface has no hole and no loose edge, so that it has an inside, and volumes mean something.",
        ),
        (
            "Pieces, handles",
            "how many parts the surface is in, and how many holes go through them like that of a ring.",
        ),
        (
            "Of stack",
            "the volume over that of area times spacing of the slices (Cavalieri): far from 1 something was lost or added between them.",
        ),
        (
            "Ripple",
            "how much more the surface leans between sections than at them: some degrees at most in a true shape, more where there are beads or terraces.",
        ),
        ("Voxel", "the side of a cube of the grid: what is smaller cannot be seen in the result."),
    ];
    html! { dl.words { @for (word, meaning) in words { dt { (word) } dd { (meaning) } } } }
}
