//! Sections from closed loops with holes.
//!
//! A hole may lie in another one of the same outer loop: then it is an island, and one in that
//! is a hole again.

use std::collections::BTreeMap;

use glam::DVec2;

use super::draft::{Draft, stretch};
use super::subdivision::{Curves, Subdivision, Windings, times};
use super::{Findings, Loop, Overlap, Rules, Section};
use crate::error::{Remedy, Result};
use crate::label::Label;
use crate::plane::Plane;

impl Section {
    /// A section from closed loops.
    ///
    /// A point's label is that of the outer loop that covers it by the even-odd
    /// rule, holes taken away; a hole within a hole of the same loop is an island of it. Loops
    /// may touch themselves and each other, and what nearly touches does ([`Rules::snapping`]). Where there are loops and none encloses
    /// anything, all is unknown.
    ///
    /// # Errors
    /// Where the plane is none, a point is not finite or too far off the plane,
    /// a hole has no outer loop, and where loops of different labels overlap
    /// and `rules` does not say who wins.
    pub fn from_loops(
        name: &str,
        plane: Plane,
        loops: &[Loop],
        diagonal: f64,
        rules: &Rules,
    ) -> Result<(Self, Findings)> {
        let mut draft = Draft::new(name, plane, diagonal, rules)?;
        let mut curves = Curves::default();
        let mut sizes = Vec::with_capacity(loops.len());
        for (number, polygon) in loops.iter().enumerate() {
            check_hole(&draft, loops, number)?;
            let points = project(&mut draft, number, polygon)?;
            sizes.push(area(&points));
            curves.polygon(number, &points);
        }
        let subdivision = curves.subdivide(&mut draft)?;
        let windings = subdivision.windings();
        leave_out_degenerate(&mut draft, loops, &windings);
        warn_of_crossings(&mut draft, loops, &subdivision, &windings)?;
        let levels = levels(loops, &windings);
        warn_of_islands(&mut draft, loops, &levels)?;
        let faces = Faces {
            loops,
            sizes: &sizes,
            levels: &levels,
            subdivision: &subdivision,
            windings: &windings,
        };
        let mut labels = faces.labels(&mut draft)?;
        if draft.findings.is_void {
            labels.fill(Label::UNKNOWN);
        }
        let section = subdivision.section(&draft, &labels);
        Ok((section, draft.findings))
    }
}

fn check_hole(draft: &Draft, loops: &[Loop], number: usize) -> Result<()> {
    let Some(parent) = loops[number].hole_of else { return Ok(()) };
    match loops.get(parent) {
        None => Err(draft.error(format!(
            "loop {number} is a hole of loop {parent}, but there are only {} loops, from 0",
            loops.len()
        ))),
        Some(outer) if outer.hole_of.is_some() => Err(draft.error(format!(
            "loop {number} is a hole of loop {parent}, which is a hole itself: \
             name the outer loop, or make loop {number} one of its own"
        ))),
        Some(_) => Ok(()),
    }
}

fn project(draft: &mut Draft, number: usize, polygon: &Loop) -> Result<Vec<DVec2>> {
    polygon
        .points
        .iter()
        .enumerate()
        .map(|(i, &point)| draft.project(point, || format!("vertex {i} of loop {number}")))
        .collect()
}

/// The absolute area in kept coordinates, by the shoelace formula.
fn area(points: &[DVec2]) -> f64 {
    let Some(&origin) = points.first() else { return 0.0 };
    let next = points.iter().cycle().skip(1);
    let twice: f64 =
        points.iter().zip(next).map(|(&a, &b)| (a - origin).perp_dot(b - origin)).sum();
    0.5 * twice.abs()
}

pub(super) fn odd(winding: i32) -> bool {
    winding % 2 != 0
}

/// Loops that enclose nothing by the even-odd rule.
fn leave_out_degenerate(draft: &mut Draft, loops: &[Loop], windings: &[Windings]) {
    let mut encloses = vec![false; loops.len()];
    for &(curve, _) in windings.iter().flatten().filter(|&&(_, winding)| odd(winding)) {
        encloses[curve as usize] = true;
    }
    for number in (0..loops.len()).filter(|&number| !encloses[number]) {
        let points = &loops[number].points;
        let place = points.first().map_or(String::new(), |point| format!(" at {point}"));
        draft.leave_out(format!(
            "loop {number} ({} vertices{place}) encloses no area",
            points.len()
        ));
    }
    if !loops.is_empty() && !encloses.contains(&true) {
        draft.leave_all_out();
    }
}

/// A loop that only touches itself winds either 0 or 1 times (or -1) around
/// every face; at a proper crossing the four faces wind w, w±1, and w±2 or w
/// with both neighbours: three values in any case.
fn warn_of_crossings(
    draft: &mut Draft,
    loops: &[Loop],
    subdivision: &Subdivision,
    windings: &[Windings],
) -> Result<()> {
    let mut ranges = vec![(0, 0); loops.len()];
    for &(curve, winding) in windings.iter().flatten() {
        widen(&mut ranges[curve as usize], winding);
    }
    for number in (0..loops.len()).filter(|&number| ranges[number].1 - ranges[number].0 > 1) {
        let places = crossings(subdivision, windings, number as u32);
        let place = places.first().copied().unwrap_or_default();
        draft.warn(format!(
            "loop {number} crosses itself at {}{}: read by the even-odd rule",
            draft.place(place),
            if places.len() > 1 {
                format!(" and {} more places", places.len() - 1)
            } else {
                String::new()
            },
        ))?;
    }
    Ok(())
}

fn widen(range: &mut (i32, i32), winding: i32) {
    *range = (range.0.min(winding), range.1.max(winding));
}

/// The vertices around which a curve's winding spans more than one.
pub(super) fn crossings(
    subdivision: &Subdivision,
    windings: &[Windings],
    curve: u32,
) -> Vec<DVec2> {
    let mut around: BTreeMap<u32, (i32, i32)> = BTreeMap::new();
    for edge in &subdivision.edges {
        if edge.covers.iter().any(|cover| cover.curve == curve) {
            for vertex in [edge.start, edge.end] {
                for face in [edge.left, edge.right] {
                    let winding = times(&windings[face], curve);
                    widen(around.entry(vertex).or_insert((winding, winding)), winding);
                }
            }
        }
    }
    around.retain(|_, range| range.1 - range.0 > 1);
    around.keys().map(|&vertex| subdivision.points[vertex as usize]).collect()
}

/// For every loop the holes of its outer loop that it lies in: those that cover all faces that
/// it covers, and more. Two that are the same, or overlap in part, are in one another's none.
fn levels(loops: &[Loop], windings: &[Windings]) -> Vec<Vec<usize>> {
    let mut faces = vec![0; loops.len()];
    let mut common: BTreeMap<[usize; 2], usize> = BTreeMap::new();
    for windings in windings {
        let inside = windings.iter().filter(|pair| odd(pair.1)).map(|pair| pair.0 as usize);
        let holes: Vec<usize> = inside.filter(|&hole| loops[hole].hole_of.is_some()).collect();
        for (i, &first) in holes.iter().enumerate() {
            faces[first] += 1;
            let of_one = |&&second: &&usize| loops[first].hole_of == loops[second].hole_of;
            for &second in holes[i + 1..].iter().filter(of_one) {
                *common.entry([first, second]).or_default() += 1;
            }
        }
    }
    let mut levels = vec![Vec::new(); loops.len()];
    for ([first, second], common) in common {
        for (inner, outer) in [(first, second), (second, first)] {
            if common == faces[inner] && common < faces[outer] {
                levels[inner].push(outer);
            }
        }
    }
    levels
}

/// Holes in holes of the same loop.
fn warn_of_islands(draft: &mut Draft, loops: &[Loop], levels: &[Vec<usize>]) -> Result<()> {
    for (island, within) in levels.iter().enumerate().filter(|(_, within)| within.len() % 2 == 1) {
        let outer = loops[island].hole_of.unwrap_or(island);
        draft.warn(format!(
            "loops {island} and {} are holes of loop {outer}, and the one lies in the other: read \
             as an island in a hole",
            within[0]
        ))?;
    }
    Ok(())
}

/// Loops that cover a common face, or a hole that covers one which its outer
/// loop does not: how much, and where most.
#[derive(Debug, Default)]
struct Common {
    area: f64,
    largest: f64,
    face: usize,
}

/// The faces between loops.
struct Faces<'a> {
    loops: &'a [Loop],
    /// The loops' areas.
    sizes: &'a [f64],
    /// [`levels`].
    levels: &'a [Vec<usize>],
    subdivision: &'a Subdivision,
    windings: &'a [Windings],
}

impl Faces<'_> {
    /// The label of every face.
    fn labels(&self, draft: &mut Draft) -> Result<Vec<Label>> {
        let areas = self.subdivision.areas();
        let mut overlaps: BTreeMap<[usize; 2], Common> = BTreeMap::new();
        let mut labels = Vec::with_capacity(areas.len());
        for (face, windings) in self.windings.iter().enumerate() {
            let covering = self.covering(windings);
            for (i, &first) in covering.iter().enumerate() {
                for &second in &covering[i + 1..] {
                    overlaps.entry([first, second]).or_default().add(face, areas[face]);
                }
            }
            labels.push(self.winner(&covering, draft.rules.overlap));
        }
        for (&pair, common) in &overlaps {
            self.report_overlap(draft, pair, common)?;
        }
        self.report_stray_holes(draft, &areas)?;
        Ok(labels)
    }

    /// The outer loops that cover a face, holes taken away: of nested ones the innermost decides.
    fn covering(&self, windings: &Windings) -> Vec<usize> {
        let inside = || windings.iter().filter(|pair| odd(pair.1)).map(|pair| pair.0 as usize);
        let mut deepest: BTreeMap<usize, usize> = BTreeMap::new();
        for hole in inside() {
            if let Some(outer) = self.loops[hole].hole_of {
                let level = deepest.entry(outer).or_default();
                *level = self.levels[hole].len().max(*level);
            }
        }
        let is_removed = |number: &usize| deepest.get(number).is_some_and(|level| level % 2 == 0);
        inside()
            .filter(|number| self.loops[*number].hole_of.is_none() && !is_removed(number))
            .collect()
    }

    fn winner(&self, covering: &[usize], overlap: Option<Overlap>) -> Label {
        let winner = match overlap {
            Some(Overlap::Last) => covering.last(),
            Some(Overlap::Smallest) => {
                covering.iter().min_by(|&&a, &&b| self.sizes[a].total_cmp(&self.sizes[b]))
            }
            Some(Overlap::First) | None => covering.first(),
        };
        winner.map_or(Label::OUTSIDE, |&number| self.loops[number].label)
    }

    fn report_overlap(&self, draft: &mut Draft, pair: [usize; 2], common: &Common) -> Result<()> {
        let [first, second] = pair;
        let labels = pair.map(|number| self.loops[number].label);
        let place = self.describe(draft, common);
        if labels[0] == labels[1] {
            return draft.warn(format!(
                "loops {first} and {second}, both of label {}, overlap {place}: read as their \
                 union (if one is meant as a hole, mark it as one)",
                labels[0]
            ));
        }
        let what = format!(
            "loops {first} (label {}) and {second} (label {}) overlap {place}",
            labels[0], labels[1]
        );
        match draft.rules.overlap {
            None => Err(draft.error(format!("{what}: correct them")).avoidable(Remedy::Overlap)),
            Some(overlap) => draft.warn(format!("{what}: the {} wins", overlap.word())),
        }
    }

    fn report_stray_holes(&self, draft: &mut Draft, areas: &[f64]) -> Result<()> {
        let mut stray: BTreeMap<[usize; 2], Common> = BTreeMap::new();
        for (face, windings) in self.windings.iter().enumerate() {
            for &(curve, _) in windings.iter().filter(|pair| odd(pair.1)) {
                let hole = curve as usize;
                let parent = self.loops[hole].hole_of;
                if let Some(parent) = parent.filter(|&outer| !odd(times(windings, outer as u32))) {
                    stray.entry([hole, parent]).or_default().add(face, areas[face]);
                }
            }
        }
        for (&[hole, parent], common) in &stray {
            let place = self.describe(draft, common);
            draft.warn(format!(
                "loop {hole} is a hole of loop {parent} but reaches outside it {place}: \
                 that part has no meaning"
            ))?;
        }
        Ok(())
    }

    fn describe(&self, draft: &Draft, common: &Common) -> String {
        let area = common.area * stretch(&draft.plane);
        let place = draft.place(self.subdivision.place(common.face));
        format!("(area {area:.3e}, near {place})")
    }
}

impl Common {
    fn add(&mut self, face: usize, area: f64) {
        self.area += area;
        if area > self.largest || self.largest == 0.0 {
            (self.largest, self.face) = (area, face);
        }
    }
}

impl Overlap {
    /// The word for it on the command line.
    pub fn word(self) -> &'static str {
        match self {
            Self::First => "first",
            Self::Last => "last",
            Self::Smallest => "smallest",
        }
    }
}
