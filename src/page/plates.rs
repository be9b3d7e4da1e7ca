//! The sections as small pictures: what is drawn as areas, and what the surface shows on their
//! planes as lines.

use std::fmt::Write;

use glam::{DVec2, DVec3};
use rayon::prelude::*;

use super::Part;
use super::lines::{Sheet, simplified, walks};
use crate::label::{Label, Material};
use crate::label_image::Contours;
use crate::plane::{Bounds, Plane};
use crate::section::Section;
use crate::sides::Sides;

/// How many sections are shown at most.
const PLATES: usize = 48;
/// How many bytes all of their lines have at most, and how many points one has unless it would
/// change.
const BYTES: usize = 1_500_000;
const POINTS: usize = 2500;
/// The longer side of a plate in its own units, and the shorter one at least.
const SIDE: f64 = 1000.0;
const SHORTEST: f64 = 250.0;
/// What is left free around the contours.
const MARGIN: f64 = 40.0;
/// How far lines may be from what they stand for: at first, and at most.
const NEAR: f64 = 0.4;
const FAR: f64 = 3.0;

/// A section as it is drawn.
#[derive(Debug, Clone)]
pub struct Plate {
    /// The section's name.
    pub name: String,
    /// What is drawn on it.
    pub labels: Vec<u32>,
    /// How well the surface shows it.
    pub dice: Option<f64>,
    /// The part of it that is unknown.
    pub unknown: f64,
    /// Width and height.
    pub size: [f64; 2],
    /// What is in the SVG: numbers and our own words alone.
    pub drawing: String,
    /// Where up and left are.
    pub directions: [String; 2],
    /// How long the bar is, in world units.
    pub bar: f64,
    /// The corners in space.
    pub corners: [[f64; 3]; 4],
}

/// What is shown of the sections.
#[derive(Debug, Clone, Default)]
pub struct Plates {
    /// The worst first; those with nothing to compare last.
    pub shown: Vec<Plate>,
    /// How many sections there are.
    pub count: usize,
    /// How many of those that were looked at have no line to show.
    pub empty: usize,
    /// The agreement of the first one that is left out since there are too many.
    pub next: Option<Option<f64>>,
}

impl Plates {
    pub fn new(parts: &[Part], sides: &Sides, frame: &str) -> Self {
        let mut all: Vec<(&Part, usize)> = Vec::new();
        for part in parts {
            all.extend((0..part.model.sections().sections.len()).map(|own| (part, own)));
        }
        let dice = |&(part, own): &(&Part, usize)| part.check.dice.sections.get(own)?.dice;
        // In the order of the sections where they are alike.
        all.sort_by(|one, other| {
            let [one, other] = [one, other].map(|own| dice(own).unwrap_or(f64::INFINITY));
            one.total_cmp(&other)
        });
        let mut plates = Self { count: all.len(), ..Self::default() };
        let mut bytes = 0;
        let mut rest = all.chunks(16);
        while let Some(some) = rest.next().filter(|_| plates.next.is_none()) {
            let drawn: Vec<Option<Plate>> =
                some.par_iter().map(|&(part, own)| plate(part, own, sides, frame)).collect();
            for (which, plate) in some.iter().zip(drawn) {
                let Some(plate) = plate else {
                    plates.empty += 1;
                    continue;
                };
                bytes += plate.drawing.len();
                if plates.shown.len() == PLATES || bytes > BYTES {
                    plates.next = Some(dice(which));
                    break;
                }
                plates.shown.push(plate);
            }
        }
        plates
    }
}

/// A section on paper; `None` where there is no line on it.
fn plate(part: &Part, own: usize, sides: &Sides, frame: &str) -> Option<Plate> {
    let sections = part.model.sections();
    let section = &sections.sections[own];
    let checked = part.check.dice.sections.get(own)?;
    let sheet = sheet(section.plane(), sides, frame);
    let drawn = sheet.contours(section);
    let result = sheet.cut(&part.model.derived()?.mesh.cut(section.plane()));
    let paper = Paper::around(drawn.points.iter().chain(&result.points).copied())?;
    let drawing = drawing(section, [&drawn, &result], &sections.materials, &paper);
    let [x, y] = [DVec2::X * paper.size.x, DVec2::Y * paper.size.y];
    let corner = |at: DVec2| sheet.space(paper.flat(at)).to_array();
    let [right, up] = sheet.axes;
    let labels = section.labels().into_iter().filter(|label| label.is_material());
    Some(Plate {
        name: section.name().to_owned(),
        labels: labels.map(|label| label.0).collect(),
        dice: checked.dice,
        unknown: checked.unknown,
        size: paper.size.to_array(),
        drawing,
        directions: [up, -right].map(|direction| toward(direction, frame)),
        bar: paper.bar(),
        corners: [DVec2::ZERO, x, x + y, y].map(corner),
    })
}

/// How a plane is looked at: from the front, from the left, or from below as radiologists do where
/// the frame is called after a body, from above like a map where it is not. What is nearest to up,
/// or to the front, is above. By what is on the right, since frames may be left-handed.
fn sheet(plane: &Plane, sides: &Sides, frame: &str) -> Sheet {
    let Sides { up, front, right } = *sides;
    let is_body = letters(frame).is_some();
    let normal = plane.unit_normal();
    let along = |direction: DVec3| normal.dot(direction).abs();
    let [tilt, ahead, aside] = [along(up), along(front), along(right)];
    let across = if is_body { -right } else { right };
    let (above, across) = match (is_body, tilt >= ahead && tilt >= aside, ahead >= aside) {
        (true, true, _) => (front, across),
        (false, true, _) => (-front, across),
        (_, false, true) => (up, across),
        (_, false, false) => (up, -front),
    };
    let above = (above - above.dot(normal) * normal).normalize_or(normal.any_orthonormal_vector());
    let toward = above.cross(normal);
    let turned = toward.dot(across) < 0.0;
    let origin = plane.offset / plane.normal.length() * normal;
    Sheet { origin, axes: [if turned { -toward } else { toward }, above], turned }
}

/// The letters of a frame that is called after where its axes point in a body.
fn letters(frame: &str) -> Option<[char; 3]> {
    let letters: Vec<char> = frame.trim().to_uppercase().chars().collect();
    let has = |pair: [char; 2]| letters.iter().any(|letter| pair.contains(letter));
    let is_body = has(['L', 'R']) && has(['A', 'P']) && has(['S', 'I']);
    letters.try_into().ok().filter(|_| is_body)
}

/// The letter of a frame that is called after where its axes point, else the axis.
fn toward(direction: DVec3, frame: &str) -> String {
    const LETTERS: [(char, char); 6] =
        [('L', 'R'), ('R', 'L'), ('P', 'A'), ('A', 'P'), ('S', 'I'), ('I', 'S')];
    let size = direction.abs();
    let axis = (0..3).fold(0, |best, axis| if size[axis] > size[best] { axis } else { best });
    let is_forward = direction[axis] > 0.0;
    let known = letters(frame).map(|letters| letters[axis]);
    match known.and_then(|own| LETTERS.iter().find(|(letter, _)| *letter == own)) {
        Some(&(letter, opposite)) => if is_forward { letter } else { opposite }.to_string(),
        None => format!("{}{}", if is_forward { '+' } else { '−' }, ['x', 'y', 'z'][axis]),
    }
}

/// Where things are on a plate: y points down.
struct Paper {
    size: DVec2,
    /// The place of the upper left corner, and how many of a plate's units a world unit is.
    corner: DVec2,
    scale: f64,
}

impl Paper {
    fn around(points: impl Iterator<Item = DVec2>) -> Option<Self> {
        let bounds = Bounds::around(points.map(|point| point.extend(0.0)))?;
        let (least, size) = (bounds.min.truncate(), bounds.size().truncate());
        let longest = size.max_element();
        if !(longest.is_finite() && longest > 0.0) {
            return None;
        }
        let scale = (SIDE - 2.0 * MARGIN) / longest;
        let own = (scale * size + 2.0 * MARGIN).max(DVec2::splat(SHORTEST)).ceil();
        let free = (own / scale - size) / 2.0;
        let corner = DVec2::new(least.x - free.x, least.y + size.y + free.y);
        Some(Self { size: own, corner, scale })
    }

    fn place(&self, point: DVec2) -> [i64; 2] {
        let [x, y] = (self.scale * (point - self.corner)).to_array();
        [x, -y].map(|at| at.round() as i64)
    }

    fn flat(&self, place: DVec2) -> DVec2 {
        self.corner + DVec2::new(place.x, -place.y) / self.scale
    }

    /// A round length, of a tenth to a quarter of the width.
    fn bar(&self) -> f64 {
        let most = self.size.x / self.scale / 4.0;
        let unit = 10f64.powf(most.log10().floor());
        let step = [5.0, 2.0, 1.0].into_iter().find(|step| step * unit <= most);
        step.unwrap_or(1.0) * unit
    }
}

/// Areas of what is drawn, lines of what the surface shows, and a bar.
fn drawing(
    section: &Section,
    [drawn, result]: [&Contours; 2],
    materials: &[Material],
    paper: &Paper,
) -> String {
    let simple =
        |lines: &Contours| simplified(lines, NEAR / paper.scale, FAR / paper.scale, POINTS);
    let (drawn, result) = (simple(drawn), simple(result));
    let [width, height] = paper.size.to_array();
    let mut svg = String::new();
    // Writing to a text cannot fail.
    let background = class(section.background());
    let _ = write!(svg, r#"<rect class="{background}" width="{width}" height="{height}"/>"#);
    for label in section.labels() {
        if label == section.background() {
            continue;
        }
        let mut path = String::new();
        for walk in walks(&drawn, label) {
            line(&mut path, walk.iter().map(|&own| drawn.points[own as usize]), paper);
            path.push('z');
        }
        let own = materials.iter().find(|material| material.id == label.0);
        let fill = own.filter(|_| label.is_material()).map_or(String::new(), |material| {
            let [red, green, blue] = material.color;
            let color = format!("#{red:02x}{green:02x}{blue:02x}");
            // As the style has it, mixed with the paper, or where a browser cannot mix as it is.
            format!(r#" fill="{color}" style="--own:{color}""#)
        });
        let _ = write!(svg, r#"<path class="{}"{fill} d="{path}"/>"#, class(label));
    }
    let mut path = String::new();
    for (run, _) in result.chains() {
        line(&mut path, run.iter().map(|&own| result.points[own as usize]), paper);
    }
    let _ = write!(svg, r#"<path class="result" d="{path}"/>"#);
    let length = (paper.scale * paper.bar()).round();
    let (x, y) = (MARGIN / 2.0, height - MARGIN / 2.0);
    let _ = write!(svg, r#"<path class="bar" d="M{x} {y}h{length}"/>"#);
    svg
}

fn class(label: Label) -> &'static str {
    match label {
        Label::OUTSIDE => "outside",
        Label::UNKNOWN => "unknown",
        _ => "drawn",
    }
}

/// Adds a line to a path, each point from the one before.
fn line(path: &mut String, points: impl Iterator<Item = DVec2>, paper: &Paper) {
    let mut last: Option<[i64; 2]> = None;
    for [x, y] in points.map(|point| paper.place(point)) {
        let _ = match last {
            None => write!(path, "M{x} {y}l"),
            Some([a, b]) if [a, b] == [x, y] => continue,
            Some([a, b]) => write!(path, "{} {} ", x - a, y - b),
        };
        last = Some([x, y]);
    }
    let end = path.trim_end_matches([' ', 'l']).len();
    path.truncate(end);
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::section::Sections;

    fn seen(normal: DVec3, frame: &str) -> ([String; 2], DVec3) {
        let sides = Sides::of(&Sections { frame: frame.to_owned(), ..Sections::default() });
        let Sheet { axes: [right, up], turned, .. } =
            sheet(&Plane { normal, offset: 1.0 }, &sides, frame);
        let toward_viewer = right.cross(up);
        assert!((toward_viewer.dot(normal.normalize()).abs() - 1.0).abs() < 1e-12);
        assert_eq!(turned, toward_viewer.dot(normal) < 0.0);
        ([up, -right].map(|direction| toward(direction, frame)), toward_viewer)
    }

    #[test]
    fn bodies_are_seen_as_radiologists_see_them() {
        for frame in ["LPS", "RAS", "RSA"] {
            let axis = |letters: [char; 2]| {
                let place = frame.chars().position(|own| letters.contains(&own));
                DVec3::AXES[place.expect("an axis")]
            };
            for sign in [1.0, -1.0] {
                let of = |letters| seen(sign * axis(letters), frame).0.join(" ");
                assert_eq!(of(['S', 'I']), "A R", "{frame}");
                assert_eq!(of(['A', 'P']), "S R", "{frame}");
                assert_eq!(of(['L', 'R']), "S A", "{frame}");
            }
            // A few degrees off it is the same.
            let tilted = axis(['S', 'I']) + 0.1 * axis(['A', 'P']) - 0.05 * axis(['L', 'R']);
            assert_eq!(seen(tilted, frame).0.join(" "), "A R", "{frame}");
        }
    }

    #[test]
    fn without_a_body_planes_are_seen_like_maps() {
        assert_eq!(seen(DVec3::Z, ""), (["+y", "−x"].map(String::from), DVec3::Z));
        assert_eq!(seen(DVec3::NEG_Y, ""), (["+z", "−x"].map(String::from), DVec3::NEG_Y));
        assert_eq!(seen(DVec3::X, ""), (["+z", "−y"].map(String::from), DVec3::X));
    }

    #[test]
    fn bars_are_round_and_fit() {
        for longest in [0.003, 1.0, 7.0, 100.0, 2600.0] {
            let points = [DVec2::ZERO, DVec2::new(longest, 0.4 * longest)];
            let paper = Paper::around(points.into_iter()).expect("a size");
            let share = paper.bar() / longest;
            assert!((0.09..0.28).contains(&share), "{longest}: {share}");
            let [x, y] = paper.place(paper.flat(DVec2::new(12.0, 34.0)));
            assert_eq!([x, y], [12, 34]);
        }
        assert!(Paper::around([DVec2::ONE; 2].into_iter()).is_none(), "a point is nothing");
    }

    #[test]
    fn lines_go_from_point_to_point() {
        let paper = Paper { size: DVec2::splat(100.0), corner: DVec2::ZERO, scale: 10.0 };
        let mut path = String::new();
        let points = [[0.0, 0.0], [1.0, 0.0], [1.01, 0.0], [1.0, -2.0]].map(DVec2::from);
        line(&mut path, points.into_iter(), &paper);
        assert_eq!(path, "M0 0l10 0 0 20");
    }
}
