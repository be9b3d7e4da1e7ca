//! `cargo bench --bench complex`: what a section costs in the cell complex, added last and
//! removed again, beside all sections one after the other: random planes in a cube, the
//! bundled example, and the real files there are.

mod common;

use std::time::Instant;

use common::{files, median, name};
use glam::DVec3;
use transect::complex::Editor;
use transect::error::Result;
use transect::io;
use transect::label::Label;
use transect::plane::{Bounds, Plane};
use transect::random::Random;
use transect::section::{Rules, Section};

/// How many random planes there are.
const PLANES: [usize; 4] = [20, 40, 81, 120];
/// How often the last section comes and goes: its median counts.
const TIMES: usize = 5;

fn main() -> Result<()> {
    println!(
        "{:<22}{:>9}{:>9}{:>12}{:>12}{:>12}{:>12}",
        "", "sections", "cells", "all, s", "last, s", "all / last", "removed, s"
    );
    let cube = Bounds { min: DVec3::NEG_ONE, max: DVec3::ONE };
    for count in PLANES {
        row("random planes", &random_planes(count)?, cube)?;
    }
    for file in files() {
        let sections = io::read_sections(&file, &Rules::default())?;
        let Some(space) = sections.space() else { continue };
        row(&name(&file), &sections.sections, space)?;
    }
    Ok(())
}

fn row(name: &str, sections: &[Section], bounds: Bounds) -> Result<()> {
    let Some((last, others)) = sections.split_last() else { return Ok(()) };
    let mut editor = Editor::new(bounds, Label::OUTSIDE)?;
    let start = Instant::now();
    for section in others {
        editor.add(section)?;
        editor.commit()?;
    }
    let before = start.elapsed().as_secs_f64();
    let (mut added, mut removed) = (Vec::new(), Vec::new());
    let mut cells = 0;
    for _ in 0..TIMES {
        let start = Instant::now();
        let plane = editor.add(last)?;
        editor.commit()?;
        added.push(start.elapsed().as_secs_f64());
        cells = editor.complex().cells().count();
        let start = Instant::now();
        editor.remove(plane)?;
        editor.commit()?;
        removed.push(start.elapsed().as_secs_f64());
    }
    let (added, removed) = (median(added), median(removed));
    let all = before + added;
    println!(
        "{name:<22}{:>9}{cells:>9}{all:>12.4}{added:>12.4}{:>12.1}{removed:>12.4}",
        sections.len(),
        all / added
    );
    Ok(())
}

/// Planes through the cube in all directions, without contours.
fn random_planes(count: usize) -> Result<Vec<Section>> {
    let mut random = Random::new(1);
    let mut point = || DVec3::from_array(std::array::from_fn(|_| 2.0 * random.unit() - 1.0));
    (0..count)
        .map(|index| {
            let (normal, through) = (point(), point());
            let plane = Plane { normal, offset: normal.dot(through) };
            let name = format!("plane {index}");
            Ok(Section::from_loops(&name, plane, &[], 1.0, &Rules::default())?.0)
        })
        .collect()
}
