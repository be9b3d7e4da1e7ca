//! Points where the field and the skeleton must agree, and whether they do.

use glam::DVec3;
use rayon::prelude::*;
use serde::Serialize;

use crate::complex::Complex;
use crate::error::{Error, Result};
use crate::field::{Boundaries, Field, Queries, Reference, Run};
use crate::label::Label;
use crate::oracle::Oracle;
use crate::plane::Bounds;
use crate::progress::Progress;
use crate::random::Random;
use crate::section::Section;

/// How many violations are listed.
const LISTED: usize = 32;
/// How far the backends may be from the reference: a label that changes within
/// that is a matter of rounding.
const ROUNDING: f32 = 1e-4;
/// Points that are asked for together.
const TOGETHER: usize = 1 << 16;

/// Everything that is asked at a point.
#[derive(Clone, Copy)]
pub struct Judges<'a> {
    /// The cells.
    pub complex: &'a Complex,
    /// Their boundaries.
    pub boundaries: &'a Boundaries<'a>,
    /// The field in them.
    pub field: &'a dyn Field,
    /// What the skeleton says.
    pub oracle: &'a Oracle<'a>,
    /// Whose names are told.
    pub sections: &'a [Section],
}

/// The points at which both were asked.
#[derive(Debug, Clone, Default, PartialEq, Serialize)]
pub struct Points {
    /// Points drawn in the box.
    pub drawn: u64,
    /// What they were drawn from: the same points for the same seed.
    pub seed: u64,
    /// How many of them have the same label in both.
    pub agree: u64,
    /// How many must have.
    pub must_agree: u64,
    /// How many nodes of the lattice have different labels, all of which were
    /// asked whether they may.
    pub nodes: u64,
    /// Points and nodes that must agree and do not.
    pub violations: u64,
    /// The first of them, nodes before drawn points, at most 32.
    pub first: Vec<Violation>,
}

/// A point that must agree and does not.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Violation {
    /// Where.
    pub at: [f64; 3],
    /// The cell's number.
    pub cell: u32,
    /// The name of the nearest section; none where that is the box.
    pub section: Option<String>,
    /// How far it is away, in world units.
    pub distance: f64,
    /// The distance to the nearest plane over that to the second.
    pub rho: f64,
    /// The distance from the foot to another label, over `distance`.
    pub alpha: f64,
    /// The label of the field.
    pub field: u32,
    /// The label of the skeleton.
    pub skeleton: u32,
    /// The field's value for the skeleton's label, at most 0 where the field
    /// has another one.
    pub value: f32,
    /// The same in double precision.
    pub reference: f64,
}

/// Asks at random points, and at those nodes that are known to differ.
///
/// # Errors
/// When the field cannot be evaluated.
pub fn points(
    judges: &Judges,
    nodes: &[DVec3],
    (drawn, seed): (u32, u64),
    progress: &dyn Progress,
) -> Result<Points> {
    let drawn = draw(judges.complex.bounds(), drawn, seed);
    progress.begin("points", (nodes.len() + drawn.len()) as u64);
    let mut found =
        Points { drawn: drawn.len() as u64, seed, nodes: nodes.len() as u64, ..Points::default() };
    for (points, is_drawn) in [(nodes, false), (&drawn, true)] {
        for points in points.chunks(TOGETHER) {
            let asked = judges.ask(points)?;
            if is_drawn {
                let count = |is: fn(&Asked) -> bool| asked.iter().filter(|one| is(one)).count();
                found.agree += count(|one| one.field == one.skeleton) as u64;
                found.must_agree += count(|one| one.must_agree) as u64;
            }
            found.add(judges.violations(&asked)?);
            progress.advance(points.len() as u64);
        }
    }
    Ok(found)
}

impl Points {
    fn add(&mut self, violations: Vec<Violation>) {
        self.violations += violations.len() as u64;
        let room = LISTED - self.first.len();
        self.first.extend(violations.into_iter().take(room));
    }

    /// Drawn points that agree, as a share.
    pub fn share(&self) -> f64 {
        if self.drawn == 0 { 1.0 } else { self.agree as f64 / self.drawn as f64 }
    }
}

/// Points of the box, uniformly.
fn draw(bounds: Bounds, count: u32, seed: u64) -> Vec<DVec3> {
    let mut random = Random::new(seed);
    let mut point = || {
        let [x, y, z] = std::array::from_fn(|_| random.unit());
        bounds.min + bounds.size() * DVec3::new(x, y, z)
    };
    (0..count).map(|_| point()).collect()
}

/// What was found at a point.
#[derive(Debug, Clone, Copy)]
struct Asked {
    point: DVec3,
    cell: u32,
    field: Label,
    /// The field's value for the skeleton's label.
    value: f32,
    skeleton: Label,
    must_agree: bool,
}

impl Judges<'_> {
    /// Asks everybody.
    fn ask(&self, points: &[DVec3]) -> Result<Vec<Asked>> {
        let cells: Vec<u32> = points.par_iter().map(|&point| self.complex.locate(point)).collect();
        let exact = |&point: &DVec3| (self.oracle.nearest(point).label, self.must_agree(point));
        let exact: Vec<(Label, bool)> = points.par_iter().map(exact).collect();
        let values = values(self.field, points, &cells)?;
        let asked = points.iter().zip(cells).zip(values).zip(exact);
        Ok(asked
            .map(|(((&point, cell), values), (skeleton, must_agree))| {
                let labels = self.field.labels(cell);
                let own = labels.iter().position(|&label| label == skeleton);
                Asked {
                    point,
                    cell,
                    field: largest(labels, &values),
                    value: own.map_or(-1.0, |own| values[own]),
                    skeleton,
                    must_agree,
                }
            })
            .collect())
    }

    /// Whether the labels must be the same. Within the clearance of a plane the
    /// field is that of a point farther off, for which the bound was not asked.
    fn must_agree(&self, point: DVec3) -> bool {
        let certainty = self.oracle.certainty(point);
        certainty.must_agree() && self.oracle.nearest(point).distance >= self.boundaries.clearance()
    }

    /// Those that must agree and do not, and not by rounding.
    fn violations(&self, asked: &[Asked]) -> Result<Vec<Violation>> {
        let doubtful = |one: &&Asked| one.must_agree && one.field != one.skeleton;
        let doubtful: Vec<&Asked> = asked.iter().filter(doubtful).collect();
        if doubtful.is_empty() {
            return Ok(Vec::new());
        }
        let reference = Reference::new(self.boundaries)?;
        Ok(doubtful.into_iter().filter_map(|one| self.violation(&reference, one)).collect())
    }

    fn violation(&self, reference: &Reference, asked: &Asked) -> Option<Violation> {
        let values = reference.indicator(asked.cell, asked.point);
        let labels = reference.labels(asked.cell);
        let own = labels.iter().position(|&label| label == asked.skeleton);
        let value = own.map_or(-1.0, |own| values[own]);
        let agrees = own == (0..values.len()).max_by(|&a, &b| values[a].total_cmp(&values[b]));
        if agrees && (value as f32 - asked.value).abs() <= ROUNDING {
            return None;
        }
        let nearest = self.oracle.nearest(asked.point);
        let certainty = self.oracle.certainty(asked.point);
        let name = |section: u32| self.sections[section as usize].name().to_owned();
        Some(Violation {
            at: asked.point.to_array(),
            cell: asked.cell,
            section: nearest.section.map(name),
            distance: nearest.distance,
            rho: certainty.rho,
            alpha: certainty.alpha,
            field: asked.field.0,
            skeleton: asked.skeleton.0,
            value: asked.value,
            reference: value,
        })
    }
}

/// The label with the largest value, of equals the first.
fn largest(labels: &[Label], values: &[f32]) -> Label {
    let all = labels.iter().zip(values);
    let best = all.reduce(|best, next| if next.1 > best.1 { next } else { best });
    best.map_or(Label::OUTSIDE, |(&label, _)| label)
}

/// The field's values at points, for each label of their cells.
fn values(field: &dyn Field, points: &[DVec3], cells: &[u32]) -> Result<Vec<Vec<f32>>> {
    // A cell with one label alone has nothing to evaluate.
    let mut values = vec![vec![1.0]; points.len()];
    let several = |&point: &usize| field.labels(cells[point]).len() > 1;
    let mut order: Vec<usize> = (0..points.len()).filter(several).collect();
    if order.is_empty() {
        return Ok(values);
    }
    order.sort_by_key(|&point| cells[point]);
    let mut queries = Queries::default();
    for same in order.chunk_by(|&one, &other| cells[one] == cells[other]) {
        let start = queries.points.len();
        queries.points.extend(same.iter().map(|&point| points[point]));
        queries.runs.push(Run { cell: cells[same[0]], points: start..queries.points.len() });
    }
    let all = field.evaluate(&queries)?;
    let mut rest = all.as_slice();
    for &point in &order {
        let count = field.labels(cells[point]).len();
        let Some((own, left)) = rest.split_at_checked(count) else {
            let what = format!("{} values are too few", all.len());
            return Err(Error::Bug { stage: "points", what });
        };
        values[point] = own.to_vec();
        rest = left;
    }
    Ok(values)
}
