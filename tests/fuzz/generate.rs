//! Random sets of sections, most of them degenerate in some way: planes that are parallel,
//! that pass through one line or point, that nearly coincide; contours that touch, nest,
//! contradict each other, are slivers; coordinates huge, tiny and far from the origin.

use std::f64::consts::TAU;

use glam::{DVec2, DVec3};

use super::random::Random;
use super::set::{Contour, Drawn, Set, UNKNOWN};

/// A plane before something is drawn on it.
#[derive(Debug, Clone, Copy)]
struct Sheet {
    normal: DVec3,
    offset: f64,
}

/// The set of a seed.
pub fn set(seed: u64) -> Set {
    let mut random = Random::new(seed);
    let sheets = sheets(&mut random);
    let mut drawn = match random.below(4) {
        0 => cut(&mut random, &sheets),
        _ => sheets.iter().map(|&sheet| scribble(&mut random, sheet)).collect(),
    };
    // All, or some beside others that are whole.
    let partial = [100, 40, 0, 0, 0, 0][random.below(6)];
    for own in &mut drawn {
        if random.percent(partial) {
            make_partial(&mut random, own);
        }
    }
    if random.percent(20) {
        place(&mut random, &mut drawn);
    }
    Set(drawn)
}

fn small(random: &mut Random, most: i32) -> f64 {
    f64::from(random.below(2 * most as usize + 1) as i32 - most)
}

/// A normal of small integers.
fn normal(random: &mut Random, most: i32) -> DVec3 {
    loop {
        let normal = DVec3::from_array(std::array::from_fn(|_| small(random, most)));
        if normal != DVec3::ZERO {
            return normal;
        }
    }
}

fn anywhere(random: &mut Random) -> DVec3 {
    DVec3::from_array(std::array::from_fn(|_| random.between(-1.0..1.0)))
}

fn sheets(random: &mut Random) -> Vec<Sheet> {
    let count = 2 + random.below(4);
    let base = normal(random, 3);
    let through = DVec3::from_array(std::array::from_fn(|_| small(random, 2)));
    let kind = random.below(8);
    let nearness = 10f64.powf(random.between(-14.0..-3.0));
    let axes = [DVec3::X, DVec3::Y, DVec3::Z];
    let line = axes[random.below(3)];
    let mut sheet = |number: usize| match kind {
        // Parallel, at integers, some the other way round or of another length.
        0 => {
            let factor = [1.0, -1.0, 2.0, -0.5][random.below(4)];
            Sheet { normal: factor * base, offset: factor * (number as f64 + small(random, 1)) }
        }
        // Across the axes, on a grid.
        1 => Sheet { normal: axes[random.below(3)], offset: small(random, 3) },
        // Through one line.
        2 => {
            let normal = line.cross(normal(random, 3));
            let normal = if normal == DVec3::ZERO { line.any_orthogonal_vector() } else { normal };
            Sheet { normal, offset: normal.dot(through) }
        }
        // Through one point.
        3 => {
            let normal = normal(random, 3);
            Sheet { normal, offset: normal.dot(through) }
        }
        // Nearly one plane.
        4 => {
            let normal = base + nearness * anywhere(random);
            Sheet { normal, offset: base.dot(through) + nearness * random.between(-1.0..1.0) }
        }
        // Nearly one plane, and others.
        5 if number < 2 => {
            let normal = base + nearness * anywhere(random);
            Sheet { normal, offset: base.dot(through) + nearness * random.between(-1.0..1.0) }
        }
        // Small integers.
        5 | 6 => Sheet { normal: normal(random, 3), offset: small(random, 6) / 2.0 },
        // General.
        _ => Sheet { normal: anywhere(random), offset: random.between(-1.0..1.0) },
    };
    (0..count).map(&mut sheet).collect()
}

impl Sheet {
    /// The axis in which the normal is largest.
    fn dropped(&self) -> usize {
        let size = self.normal.abs();
        (0..3).fold(0, |best, axis| if size[axis] > size[best] { axis } else { best })
    }

    /// The point of the plane with the two other coordinates given.
    fn point(&self, kept: DVec2) -> DVec3 {
        let dropped = self.dropped();
        let [first, second] = [(dropped + 1) % 3, (dropped + 2) % 3];
        let mut point = DVec3::ZERO;
        point[first] = kept.x;
        point[second] = kept.y;
        point[dropped] = (self.offset - self.normal.dot(point)) / self.normal[dropped];
        point
    }
}

/// Something on a plane, without a thought of the others.
fn scribble(random: &mut Random, sheet: Sheet) -> Drawn {
    let on_grid = random.percent(60);
    let count = [0, 1, 1, 1, 2, 2, 3][random.below(7)];
    let mut flat: Vec<Vec<DVec2>> = Vec::new();
    let mut contours = Vec::new();
    for _ in 0..count {
        let mut points = outline(random, on_grid);
        // Touching: a corner of the last one.
        if let Some(last) = flat.last().filter(|_| random.percent(40)) {
            let shift = last[random.below(last.len())] - points[0];
            points.iter_mut().for_each(|point| *point += shift);
        }
        let label = 1 + random.below(3) as u32;
        contours.push(Contour { label, points: lift(sheet, &points) });
        if random.percent(25) {
            let middle = points.iter().sum::<DVec2>() / points.len() as f64;
            let inner: Vec<DVec2> = points.iter().map(|&point| middle.lerp(point, 0.5)).collect();
            contours
                .push(Contour { label: 1 + random.below(3) as u32, points: lift(sheet, &inner) });
        }
        flat.push(points);
    }
    Drawn { normal: sheet.normal, offset: sheet.offset, extent: Vec::new(), contours }
}

fn lift(sheet: Sheet, points: &[DVec2]) -> Vec<DVec3> {
    points.iter().map(|&point| sheet.point(point)).collect()
}

/// A star-shaped polygon, its corners at integers or not.
fn outline(random: &mut Random, on_grid: bool) -> Vec<DVec2> {
    let corners = 3 + random.below(10);
    let middle = DVec2::new(small(random, 3), small(random, 3));
    let sliver = if random.percent(10) { 10f64.powf(random.between(-9.0..-1.0)) } else { 1.0 };
    let size = random.between(0.5..4.0);
    let start = random.between(0.0..TAU);
    let mut points: Vec<DVec2> = (0..corners)
        .map(|corner| {
            let angle = start + TAU * corner as f64 / corners as f64;
            let out = size * random.between(0.3..1.0) * DVec2::from_angle(angle);
            let point = middle + out * DVec2::new(1.0, sliver);
            if on_grid && sliver == 1.0 { point.round() } else { point }
        })
        .collect();
    points.dedup();
    points
}

/// Sections of balls, which agree with each other but for their corners.
fn cut(random: &mut Random, sheets: &[Sheet]) -> Vec<Drawn> {
    let balls: Vec<(u32, DVec3, f64)> = (0..1 + random.below(3))
        .map(|number| {
            let middle = 3.0 * anywhere(random);
            (number as u32 + 1, middle, random.between(0.5..2.5))
        })
        .collect();
    let corners = 3 + random.below(20);
    sheets
        .iter()
        .map(|&sheet| {
            let length = sheet.normal.length();
            let (unit, offset) = (sheet.normal / length, sheet.offset / length);
            let (u, v) = unit.any_orthonormal_pair();
            let mut contours = Vec::new();
            for &(label, middle, radius) in &balls {
                let height = unit.dot(middle) - offset;
                if height.abs() >= radius {
                    continue;
                }
                let (foot, reach) =
                    (middle - height * unit, (radius * radius - height * height).sqrt());
                let point = |corner: usize| {
                    let turn = DVec2::from_angle(TAU * corner as f64 / corners as f64);
                    foot + reach * (turn.x * u + turn.y * v)
                };
                contours.push(Contour { label, points: (0..corners).map(point).collect() });
            }
            Drawn { normal: sheet.normal, offset: sheet.offset, extent: Vec::new(), contours }
        })
        .collect()
}

/// A frame, or a part that is unknown.
fn make_partial(random: &mut Random, drawn: &mut Drawn) {
    let sheet = Sheet { normal: drawn.normal, offset: drawn.offset };
    if random.percent(50) {
        let (low, high) = (small(random, 3) - 2.0, small(random, 3) + 2.0);
        let corners = [[low, low], [high, low], [high, high], [low, high]];
        drawn.extent = lift(sheet, &corners.map(DVec2::from));
    } else {
        let points = lift(sheet, &outline(random, false));
        drawn.contours.push(Contour { label: UNKNOWN, points });
    }
}

/// Somewhere else, and of another size.
fn place(random: &mut Random, drawn: &mut [Drawn]) {
    let scale = 10f64.powf(random.between(-6.0..6.0));
    let shift = if random.percent(50) { scale * 1e3 * anywhere(random) } else { DVec3::ZERO };
    for own in drawn {
        let points = own.contours.iter_mut().flat_map(|one| &mut one.points);
        points.chain(&mut own.extent).for_each(|point| *point = scale * *point + shift);
        own.offset = scale * own.offset + own.normal.dot(shift);
    }
}
