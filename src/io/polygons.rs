//! Closed polygons anywhere in space, as files of drawings have them, by the planes they lie on.

use std::collections::BTreeMap;
use std::path::Path;

use glam::{DVec2, DVec3};

use super::{Raw, check, diagonal};
use crate::error::{Error, Result};
use crate::label::Label;
use crate::plane::Plane;
use crate::section::{Loop, Rules, Section, Sections, Warning};

/// Polygons of one plane are so near to one another, as a part of the diagonal of all points, or
/// so many times nearer than their own points to their own planes.
const NEAR: f64 = 1e-6;
const TIMES: f64 = 4.0;
/// A polygon whose area is a smaller part of the diagonal's square encloses nothing.
const FLAT: f64 = 1e-14;
/// Coordinates that differ by less, as a part of the diagonal, are one.
const LEVEL: f64 = 1e-9;

/// A closed polygon; the last point joins the first.
pub(super) struct Polygon {
    pub label: Label,
    pub points: Vec<DVec3>,
    /// Where it is in the file, for errors: "line 7".
    pub place: String,
}

/// Polygons of a plane, the largest first.
struct Drawing {
    plane: Plane,
    /// How far points are off their own polygons' planes.
    off: f64,
    polygons: Vec<Polygon>,
    /// The first of them in the file.
    first: usize,
}

/// A section for each plane, in the order of the file. A polygon within another one of its label
/// is a hole, one in that an island, and so on by turns.
pub(super) fn sections(file: &Path, polygons: Vec<Polygon>, rules: &Rules) -> Result<Sections> {
    let diagonal = diagonal(polygons.iter().flat_map(|polygon| &polygon.points));
    let (drawings, left_out) = drawings(file, polygons, diagonal, rules)?;
    let raw: Vec<Raw<(Plane, Vec<Loop>)>> = (drawings.iter().enumerate())
        .map(|(number, drawing)| Raw {
            name: (number + 1).to_string(),
            place: drawing.polygons[0].place.clone(),
            content: (drawing.plane, nested(drawing)),
        })
        .collect();
    if raw.is_empty() {
        return Err(Error::file(file, "no contour encloses an area: export the contours again"));
    }
    let mut sections = check(file, &raw, rules, |raw| {
        let (plane, loops) = &raw.content;
        Section::from_loops(&raw.name, *plane, loops, diagonal, rules)
    })?;
    let loops = raw.iter().flat_map(|raw| &raw.content.1);
    let holes = loops.filter(|own| own.hole_of.is_some()).count();
    if holes > 0 {
        let what = format!("{holes} contours lie in others of their label, and are holes of these");
        sections.notes.push(Warning { section: String::new(), what });
    }
    sections.left_out.extend(left_out);
    Ok(sections)
}

/// The polygons by plane; large ones tell better where these are.
fn drawings(
    file: &Path,
    polygons: Vec<Polygon>,
    diagonal: f64,
    rules: &Rules,
) -> Result<(Vec<Drawing>, Vec<Warning>)> {
    let most = rules.tolerance * diagonal;
    let mut left_out = Vec::new();
    let mut sized: Vec<(usize, f64, Polygon)> = Vec::with_capacity(polygons.len());
    for (number, polygon) in polygons.into_iter().enumerate() {
        let finite = polygon.points.iter().all(|point| point.is_finite());
        if !finite {
            let what = "a coordinate is not a finite number: correct it, or export the file again";
            return Err(Error::input(file, polygon.place, what));
        }
        let area = area_vector(&polygon.points).length();
        match area > FLAT * diagonal * diagonal {
            true => sized.push((number, area, polygon)),
            false => {
                let what = format!("{}: the contour encloses no area", polygon.place);
                left_out.push(Warning { section: String::new(), what });
            }
        }
    }
    sized.sort_by(|one, other| other.1.total_cmp(&one.1));
    let mut drawings: Vec<Drawing> = Vec::new();
    for (number, _, polygon) in sized {
        let plane = plane(&polygon.points, diagonal);
        let off = off(&plane, &polygon.points, f64::INFINITY);
        if off > most {
            let what = format!(
                "the contour lies on no plane: it is off by {off:.3e}, and {most:.3e} are allowed"
            );
            return Err(Error::input(file, polygon.place, what));
        }
        let mut best: Option<(f64, usize)> = None;
        for (place, drawing) in drawings.iter().enumerate() {
            let near = (TIMES * off.max(drawing.off)).max(NEAR * diagonal).min(most);
            let limit = best.map_or(near, |(distance, _)| near.min(distance));
            let distance = self::off(&drawing.plane, &polygon.points, limit);
            if distance <= limit {
                best = Some((distance, place));
            }
        }
        match best {
            Some((_, place)) => {
                let drawing = &mut drawings[place];
                drawing.first = drawing.first.min(number);
                drawing.polygons.push(polygon);
            }
            None => drawings.push(Drawing { plane, off, polygons: vec![polygon], first: number }),
        }
    }
    drawings.sort_by_key(|drawing| drawing.first);
    Ok((drawings, left_out))
}

/// Twice the area of a polygon, along its normal.
fn area_vector(points: &[DVec3]) -> DVec3 {
    let Some(&first) = points.first() else { return DVec3::ZERO };
    points.windows(2).map(|pair| (pair[0] - first).cross(pair[1] - first)).sum()
}

/// The plane of a polygon: across an axis, where it lies so but for rounding.
fn plane(points: &[DVec3], diagonal: f64) -> Plane {
    for axis in 0..3 {
        let at = points[0][axis];
        if points.iter().all(|point| (point[axis] - at).abs() <= LEVEL * diagonal) {
            return Plane { normal: DVec3::AXES[axis], offset: at };
        }
    }
    let normal = area_vector(points).normalize();
    let largest = normal.abs().max_position();
    let normal = if normal[largest] < 0.0 { -normal } else { normal };
    let middle = points.iter().sum::<DVec3>() / points.len() as f64;
    Plane { normal, offset: normal.dot(middle) }
}

/// How far points are off a plane at most, as far as that is within a limit.
fn off(plane: &Plane, points: &[DVec3], limit: f64) -> f64 {
    let mut most = 0.0f64;
    for &point in points {
        most = most.max(plane.distance(point).abs());
        if most > limit {
            break;
        }
    }
    most
}

/// The polygons of a plane as loops with holes.
fn nested(drawing: &Drawing) -> Vec<Loop> {
    let flat: Vec<Vec<DVec2>> = drawing
        .polygons
        .iter()
        .map(|own| own.points.iter().map(|&point| drawing.plane.project(point)).collect())
        .collect();
    let boxes: Vec<[DVec2; 2]> = flat.iter().map(|own| ends(own)).collect();
    let label = |at: usize| drawing.polygons[at].label;
    let may_hold = |outer: usize, inner: usize| {
        let ([low, high], [from, to]) = (boxes[outer], boxes[inner]);
        label(outer) == label(inner) && low.cmplt(to).all() && from.cmplt(high).all()
    };
    let around = |at: usize| -> Vec<usize> {
        // Those that are larger come first.
        (0..at).filter(|&other| may_hold(other, at) && holds(&flat[other], &flat[at])).collect()
    };
    let loops = drawing.polygons.iter().enumerate().map(|(at, own)| {
        let around = around(at);
        let hole_of = around.last().copied().filter(|_| around.len() % 2 == 1);
        Loop { points: own.points.clone(), label: own.label, hole_of }
    });
    loops.collect()
}

/// The smallest and largest coordinates.
fn ends(points: &[DVec2]) -> [DVec2; 2] {
    let ends = [DVec2::INFINITY, DVec2::NEG_INFINITY];
    points.iter().fold(ends, |[low, high], &at| [low.min(at), high.max(at)])
}

/// Whether most corners of a polygon are within another one: they may touch.
pub(super) fn holds(outer: &[DVec2], inner: &[DVec2]) -> bool {
    let within = inner.iter().filter(|&&corner| is_within(outer, corner)).count();
    2 * within > inner.len()
}

/// The area of a polygon on a plane, whichever way round it goes.
pub(super) fn area(polygon: &[DVec2]) -> f64 {
    let ends = polygon.iter().zip(polygon.iter().cycle().skip(1));
    ends.map(|(a, b)| a.perp_dot(*b)).sum::<f64>().abs() / 2.0
}

/// By the even-odd rule.
fn is_within(polygon: &[DVec2], at: DVec2) -> bool {
    let ends = polygon.iter().zip(polygon.iter().cycle().skip(1));
    let crosses = |&(a, b): &(&DVec2, &DVec2)| {
        (a.y > at.y) != (b.y > at.y) && at.x < a.x + (at.y - a.y) / (b.y - a.y) * (b.x - a.x)
    };
    ends.filter(crosses).count() % 2 == 1
}

/// The polygons of a label from polylines, given by the numbers of their points, and how many stay
/// open; `place` is for errors.
///
/// # Errors
/// Where more than two ends meet in a point.
pub(super) fn joined(
    file: &Path,
    place: &str,
    label: Label,
    pieces: Vec<Vec<u32>>,
    points: &[DVec3],
) -> Result<(Vec<Polygon>, usize)> {
    let (found, open) = closed(pieces).map_err(|at| {
        let what = format!(
            "more than two of them meet at {}: contours are closed lines, one for each region",
            points[at as usize]
        );
        Error::input(file, place, what)
    })?;
    let polygon = |own: Vec<u32>| Polygon {
        label,
        points: own.into_iter().map(|at| points[at as usize]).collect(),
        place: place.to_owned(),
    };
    Ok((found.into_iter().map(polygon).collect(), open))
}

/// Polylines, given by the numbers of their points, as closed polygons: pieces are joined where
/// the ends of two meet. Also how many stay open.
///
/// # Errors
/// The number of a point in which more than two ends meet.
fn closed(pieces: Vec<Vec<u32>>) -> std::result::Result<(Vec<Vec<u32>>, usize), u32> {
    let mut found = Vec::new();
    let mut open: Vec<Option<Vec<u32>>> = Vec::new();
    for piece in pieces {
        match piece[..] {
            [] | [_] => {}
            [first, .., last] if first == last => found.push(piece[1..].to_vec()),
            _ => open.push(Some(piece)),
        }
    }
    let mut ends: BTreeMap<u32, Vec<usize>> = BTreeMap::new();
    for (number, piece) in open.iter().enumerate() {
        for end in piece.iter().flat_map(|piece| [piece[0], piece[piece.len() - 1]]) {
            ends.entry(end).or_default().push(number);
        }
    }
    if let Some((&point, _)) = ends.iter().find(|(_, pieces)| pieces.len() > 2) {
        return Err(point);
    }
    let mut left = 0;
    for start in 0..open.len() {
        let Some(mut line) = open[start].take() else { continue };
        // On from its end, then from its beginning.
        for _ in 0..2 {
            while let Some(next) = line.last().and_then(|end| ends.get(end)) {
                let Some(piece) = next.iter().find_map(|&number| open[number].take()) else {
                    break;
                };
                let is_turned = piece.last() == line.last();
                let rest: Vec<u32> =
                    if is_turned { piece.into_iter().rev().collect() } else { piece };
                line.extend(&rest[1..]);
            }
            line.reverse();
        }
        match line[..] {
            [first, .., last] if first == last => found.push(line[1..].to_vec()),
            _ => left += 1,
        }
    }
    Ok((found, left))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pieces_become_polygons_where_two_ends_meet() {
        let pieces =
            vec![vec![0, 1, 2, 0], vec![5, 4], vec![5, 6, 7], vec![4, 7], vec![8, 9], vec![9, 10]];
        let (found, left) = closed(pieces).expect("no junction");
        assert_eq!((found.len(), left), (2, 1));
        let mut all = found[1].clone();
        all.sort_unstable();
        assert_eq!((&found[0][..], &all[..]), (&[1, 2, 0][..], &[4, 5, 6, 7][..]));
        assert_eq!(closed(vec![vec![0, 1], vec![2, 1], vec![1, 3]]), Err(1));
    }

    #[test]
    fn a_polygon_in_another_is_a_hole_and_one_in_that_an_island() {
        let square = |half: f64, at: DVec3, label| {
            let corners = [[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]];
            let points = corners.map(|[x, y]| at + half * DVec3::new(x, 0.5 * y, y)).to_vec();
            Polygon { label: Label(label), points, place: "there".to_owned() }
        };
        let far = DVec3::new(0.0, 30.0, 0.0);
        let polygons = vec![
            square(1.0, DVec3::ZERO, 1),
            square(5.0, far, 2),
            square(3.0, DVec3::ZERO, 1),
            square(5.0, DVec3::ZERO, 1),
            square(0.4, DVec3::ZERO, 2),
        ];
        let rules = Rules { overlap: Some(crate::section::Overlap::Smallest), ..Rules::default() };
        let sections = sections(Path::new("a"), polygons, &rules).expect("sections");
        assert_eq!(sections.sections.len(), 2);
        let regions = sections.sections[0].regions().expect("regions");
        let area = |label: u32| -> f64 {
            let own = regions.iter().filter(|own| own.label == Label(label));
            own.map(|own| own.area).sum::<f64>() / 1.25f64.sqrt() / 4.0
        };
        assert!((area(1) - (25.0 - 9.0 + 1.0 - 0.16)).abs() < 1e-9, "{}", area(1));
        assert!((area(2) - 0.16).abs() < 1e-9);
        let bent = vec![DVec3::ZERO, DVec3::X, DVec3::ONE, DVec3::Y];
        let bent = vec![Polygon { label: Label(1), points: bent, place: "line 3".to_owned() }];
        let error = super::sections(Path::new("a"), bent, &rules).expect_err("it is bent");
        assert!(error.to_string().contains("line 3: the contour lies on no plane"), "{error}");
    }
}
