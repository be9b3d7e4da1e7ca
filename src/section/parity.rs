//! A section of one label from closed curves that take away from each other: a point is inside
//! where an odd number of them winds around it. So a curve in another one is a hole, one in that
//! an island; that is how structure sets say holes, whatever else they call them (DICOM PS3.3,
//! C.8.8.6).

use std::collections::BTreeMap;

use glam::DVec3;

use super::draft::{Draft, stretch};
use super::loops::{crossings, odd};
use super::subdivision::{Curves, Subdivision, Windings};
use super::{Findings, Overlap, Rules, Section};
use crate::error::{Remedy, Result};
use crate::label::Label;
use crate::plane::Plane;

/// Two curves overlap in part when each has more than this of the smaller one's area that the
/// other has not, and both have more than it: less comes from how borders are traced and rounded.
const IN_PART: f64 = 0.01;

/// A curve is drawn twice when less than this of it differs: what is between a thin ring's two
/// curves is more.
const TWICE: f64 = 1e-4;

/// A closed curve, as files give it; the last point joins the first.
#[derive(Debug, Clone, PartialEq)]
pub struct Curve {
    /// What errors call it: "contour 12".
    pub name: String,
    /// On the plane, within the tolerance; either orientation.
    pub points: Vec<DVec3>,
    /// Whether it says itself that it takes away from others, however they lie.
    pub is_exclusive: bool,
}

/// How the holes of a section are drawn.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Holes {
    /// Curves within others.
    pub nested: usize,
    /// Those of them that say themselves that they take away.
    pub exclusive: usize,
    /// Curves that go along one edge in both directions, to a hole and back.
    pub keyholes: usize,
}

impl Section {
    /// A section of one label from curves that take away from each other.
    ///
    /// Curves that enclose nothing are left out one by one. Where there are curves and none
    /// encloses anything, all is unknown.
    ///
    /// # Errors
    /// Where the plane is none, a point is not finite or too far off the plane, and where two
    /// curves overlap in part, unless one of them says that it takes away or `rules` say that
    /// overlapping curves are one.
    pub fn from_parity(
        name: &str,
        plane: Plane,
        label: Label,
        curves: &[Curve],
        diagonal: f64,
        rules: &Rules,
    ) -> Result<(Self, Holes, Findings)> {
        let mut draft = Draft::new(name, plane, diagonal, rules)?;
        let mut drawn = Curves::default();
        for (number, curve) in curves.iter().enumerate() {
            let points = curve.points.iter().enumerate();
            let points: Result<Vec<_>> = points
                .map(|(i, &point)| draft.project(point, || format!("point {i} of {}", curve.name)))
                .collect();
            drawn.polygon(number, &points?);
        }
        let subdivision = drawn.subdivide(&mut draft)?;
        let windings = subdivision.windings();
        let faces = Faces { curves, subdivision: &subdivision, windings: &windings };
        let areas = subdivision.areas();
        faces.leave_out_degenerate(&mut draft);
        faces.warn_of_crossings(&mut draft)?;
        let partial = faces.report_partial(&mut draft, &areas)?;
        let doubles = faces.report_doubles(&mut draft, &areas)?;
        let holes = faces.holes(&areas);
        let united =
            matches!(rules.overlap, Some(Overlap::First | Overlap::Last | Overlap::Smallest));
        let is_inside = |windings: &Windings| {
            let around = windings.iter().filter(|pair| odd(pair.1)).map(|pair| pair.0);
            let mut around: Vec<u32> = around.collect();
            // What is drawn twice does not take away from itself.
            let is_double = |&own: &u32| {
                doubles.iter().any(|&[one, other]| {
                    other == own && windings.iter().any(|pair| pair.0 == one && odd(pair.1))
                })
            };
            around.retain(|own| !is_double(own));
            let is_united =
                united && partial.iter().any(|pair| pair.iter().all(|one| around.contains(one)));
            is_united || around.len() % 2 == 1
        };
        let mut labels: Vec<Label> = windings
            .iter()
            .map(|windings| if is_inside(windings) { label } else { Label::OUTSIDE })
            .collect();
        if draft.findings.is_void {
            labels.fill(Label::UNKNOWN);
        }
        let section = subdivision.section(&draft, &labels);
        Ok((section, holes, draft.findings))
    }
}

/// The faces between curves.
struct Faces<'a> {
    curves: &'a [Curve],
    subdivision: &'a Subdivision,
    windings: &'a [Windings],
}

/// What of two curves is common, and what only one of them has.
#[derive(Debug, Default, Clone, Copy)]
struct Shares {
    common: f64,
    /// The largest face that both have.
    largest: f64,
    face: usize,
}

impl Faces<'_> {
    fn leave_out_degenerate(&self, draft: &mut Draft) {
        let mut encloses = vec![false; self.curves.len()];
        for &(curve, _) in self.windings.iter().flatten().filter(|pair| odd(pair.1)) {
            encloses[curve as usize] = true;
        }
        let degenerate = self.curves.iter().zip(&encloses).filter(|(_, encloses)| !**encloses);
        for (Curve { name, points, .. }, _) in degenerate {
            let place = points.first().map_or(String::new(), |point| format!(" at {point}"));
            let count = points.len();
            draft.leave_out(format!("{name} ({count} points{place}) encloses no area"));
        }
        if !self.curves.is_empty() && !encloses.contains(&true) {
            draft.leave_all_out();
        }
    }

    /// A curve that only touches itself winds either 0 or 1 times, or −1, around every face.
    fn warn_of_crossings(&self, draft: &mut Draft) -> Result<()> {
        let mut ranges = vec![[0, 0]; self.curves.len()];
        for &(curve, times) in self.windings.iter().flatten() {
            let [low, high] = &mut ranges[curve as usize];
            (*low, *high) = (times.min(*low), times.max(*high));
        }
        for (number, _) in ranges.iter().enumerate().filter(|(_, [low, high])| high - low > 1) {
            let places = crossings(self.subdivision, self.windings, number as u32);
            let place = draft.place(places.first().copied().unwrap_or_default());
            let name = &self.curves[number].name;
            draft.warn(format!("{name} crosses itself at {place}: read by the even-odd rule"))?;
        }
        Ok(())
    }

    /// The area of every curve, and what two have in common.
    fn shares(&self, areas: &[f64]) -> (Vec<f64>, BTreeMap<[u32; 2], Shares>) {
        let mut own = vec![0.0; self.curves.len()];
        let mut pairs: BTreeMap<[u32; 2], Shares> = BTreeMap::new();
        for (face, windings) in self.windings.iter().enumerate() {
            let around = || windings.iter().filter(|pair| odd(pair.1)).map(|pair| pair.0);
            for (i, first) in around().enumerate() {
                own[first as usize] += areas[face];
                for second in around().skip(i + 1) {
                    let shares = pairs.entry([first, second]).or_default();
                    shares.common += areas[face];
                    if areas[face] > shares.largest {
                        (shares.largest, shares.face) = (areas[face], face);
                    }
                }
            }
        }
        (own, pairs)
    }

    /// Curves of which neither is within the other, though they have something in common.
    fn report_partial(&self, draft: &mut Draft, areas: &[f64]) -> Result<Vec<[u32; 2]>> {
        let (own, pairs) = self.shares(areas);
        let mut partial = Vec::new();
        for ([first, second], Shares { common, face, .. }) in pairs {
            let [one, other] = [first, second].map(|number| &self.curves[number as usize]);
            let [area, other_area] = [first, second].map(|number| own[number as usize]);
            let least =
                [common, area - common, other_area - common].into_iter().fold(f64::MAX, f64::min);
            if one.is_exclusive || other.is_exclusive || least <= IN_PART * area.min(other_area) {
                continue;
            }
            let place = draft.place(self.subdivision.place(face));
            let what = format!(
                "{} and {} overlap in part (area {:.3e}, near {place}), so neither is a hole in the \
                 other",
                one.name,
                other.name,
                common * stretch(&draft.plane)
            );
            if draft.rules.overlap.is_none() {
                return Err(draft
                    .error(format!("{what}: correct them"))
                    .avoidable(Remedy::Overlap));
            }
            draft.warn(format!("{what}: read as their union"))?;
            partial.push([first, second]);
        }
        Ok(partial)
    }

    /// Curves that are one, drawn twice.
    fn report_doubles(&self, draft: &mut Draft, areas: &[f64]) -> Result<Vec<[u32; 2]>> {
        let (own, pairs) = self.shares(areas);
        let mut doubles = Vec::new();
        for ([first, second], Shares { common, .. }) in pairs {
            let [one, other] = [first, second].map(|number| &self.curves[number as usize]);
            let [area, other_area] = [first, second].map(|number| own[number as usize]);
            let rest = (area - common).max(other_area - common);
            if !one.is_exclusive && !other.is_exclusive && rest <= TWICE * area.min(other_area) {
                let what = format!(
                    "{} and {} are one, drawn twice: it is read once",
                    one.name, other.name
                );
                draft.warn(what)?;
                doubles.push([first, second]);
            }
        }
        Ok(doubles)
    }

    fn holes(&self, areas: &[f64]) -> Holes {
        let (own, pairs) = self.shares(areas);
        let mut within: Vec<usize> = Vec::new();
        for ([first, second], Shares { common, .. }) in pairs {
            let inner = if own[first as usize] < own[second as usize] { first } else { second };
            let rest = own[first as usize].max(own[second as usize]) - common;
            if common > 0.5 * own[inner as usize] && rest > TWICE * own[inner as usize] {
                within.push(inner as usize);
            }
        }
        within.sort_unstable();
        within.dedup();
        let exclusive = within.iter().filter(|&&curve| self.curves[curve].is_exclusive).count();
        let mut both_ways: Vec<u32> = Vec::new();
        for edge in &self.subdivision.edges {
            let along = |forward: bool| {
                edge.covers.iter().filter(move |own| own.forward == forward).map(|own| own.curve)
            };
            both_ways.extend(along(true).filter(|&curve| along(false).any(|other| other == curve)));
        }
        both_ways.sort_unstable();
        both_ways.dedup();
        Holes { nested: within.len(), exclusive, keyholes: both_ways.len() }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn square(name: &str, [x, y]: [f64; 2], half: f64) -> Curve {
        let corners = [[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]];
        let points = corners.map(|[a, b]| DVec3::new(x + half * a, y + half * b, 0.0)).to_vec();
        Curve { name: name.to_owned(), points, is_exclusive: false }
    }

    fn read(curves: &[Curve], rules: &Rules) -> Result<(f64, Holes, Findings)> {
        let plane = Plane { normal: DVec3::Z, offset: 0.0 };
        let (section, holes, findings) =
            Section::from_parity("s", plane, Label(1), curves, 10.0, rules)?;
        let regions = section.regions()?;
        let inside = regions.iter().filter(|region| region.label == Label(1));
        Ok((inside.map(|region| region.area).sum(), holes, findings))
    }

    #[test]
    fn holes_by_nesting_and_islands_in_them() {
        let rules = Rules::default();
        let nested = [4.0, 3.0, 1.0].map(|half| square("c", [0.0; 2], half));
        let (area, holes, findings) = read(&nested, &rules).unwrap();
        assert!((area - (64.0 - 36.0 + 4.0)).abs() < 1e-12, "{area}");
        assert_eq!(holes, Holes { nested: 2, exclusive: 0, keyholes: 0 });
        assert_eq!(findings.warnings, []);
    }

    #[test]
    fn a_keyhole_is_a_hole_and_its_channel_is_none() {
        let ring = |half: f64| square("c", [0.0; 2], half).points;
        let (outer, inner) = (ring(2.0), ring(1.0));
        let mut points = outer.clone();
        points.push(outer[0]);
        // To the hole, around it the other way, and back along the same edge.
        points.extend([inner[0], inner[3], inner[2], inner[1], inner[0]]);
        let keyhole = Curve { name: "keyhole".into(), points, is_exclusive: false };
        let (area, holes, _) = read(&[keyhole], &Rules::default()).unwrap();
        assert!((area - 12.0).abs() < 1e-12, "{area}");
        assert_eq!(holes, Holes { nested: 0, exclusive: 0, keyholes: 1 });
    }

    #[test]
    fn what_overlaps_in_part_is_refused_or_one_or_takes_away() {
        let pair = [square("one", [0.0; 2], 1.0), square("two", [1.0, 0.0], 1.0)];
        let refused = read(&pair, &Rules::default()).map(|_| ()).unwrap_err().to_string();
        assert!(refused.contains("one and two overlap in part"), "{refused}");
        let united = Rules { overlap: Some(Overlap::First), ..Rules::default() };
        let (area, _, findings) = read(&pair, &united).unwrap();
        assert!((area - 6.0).abs() < 1e-12 && findings.warnings.len() == 1, "{area}");
        let [one, two] = pair;
        let exclusive = [one, Curve { is_exclusive: true, ..two }];
        let (area, _, findings) = read(&exclusive, &Rules::default()).unwrap();
        assert!((area - 4.0).abs() < 1e-12 && findings.warnings.is_empty(), "{area}");
    }

    #[test]
    fn what_is_drawn_twice_is_there_once() {
        let all =
            [square("a", [0.0; 2], 2.0), square("b", [1e-5, 0.0], 2.0), square("c", [0.0; 2], 1.0)];
        let (area, _, findings) = read(&all, &Rules::default()).unwrap();
        assert!((area - 12.0).abs() < 1e-2, "{area}");
        assert_eq!(findings.warnings.len(), 1, "{findings:?}");
    }

    #[test]
    fn degenerate_curves_are_left_out_one_by_one() {
        let line = Curve {
            name: "line".into(),
            points: vec![DVec3::ZERO, DVec3::X, DVec3::ZERO],
            is_exclusive: false,
        };
        let (area, _, findings) =
            read(&[square("c", [5.0, 5.0], 1.0), line], &Rules::default()).unwrap();
        assert!((area - 4.0).abs() < 1e-12);
        assert_eq!(findings.left_out.len(), 1);
        assert!(findings.left_out[0].what.contains("line (3 points"), "{findings:?}");
    }
}
