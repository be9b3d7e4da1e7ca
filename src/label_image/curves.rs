//! The contours of an image: smooth curves instead of pixels' outlines, none lost and none new.
//!
//! Every outline of every label is fitted by itself ([`super::mpu`]), so that small parts are not
//! lost in large ones, and each pixel near it gets the curve's value. What is outside is said by
//! its own curves, which run on smoothly where two materials meet on them; elsewhere the material
//! with the largest value wins, so no gap opens between labels. Then each outline is accounted for: where one did
//! not come back exactly once, pixels around there keep their labels, and the contour runs within
//! half a pixel of their outline.

use std::collections::{BTreeMap, HashMap, HashSet};

use glam::DVec2;

use super::mpu::{CurveOptions, Implicit};
use super::outline::Outline;
use super::trace::{At, Contours, Pixels, trace};

/// How far from an outline the values of its curve count, in pixels; beyond it pixels are what
/// the image says.
const BAND: f64 = 2.5;
/// The value there.
const BEYOND: f64 = 3.0;
/// How far from an outline that did not come back pixels keep their labels, and by how much farther
/// each time it does not help, in pixels.
const KEEP: f64 = 1.5;
/// Beyond that all do.
const KEEP_ALL: f64 = 12.0;
/// The value there of a pixel's own label at least, and of others at most less than 0.
const KEPT: f64 = 0.02;
/// Steps of the search for where two labels' values are equal: each halves it.
const STEPS: usize = 24;

/// The contours between the labels of an image.
pub fn contours(pixels: &Pixels, options: &CurveOptions) -> Contours {
    let mut curves = Curves::new(pixels, options);
    let mut keep = KEEP;
    loop {
        let labels = curves.labels();
        let lost = curves.unaccounted(&labels);
        if lost.is_empty() {
            let crossing = |from: At, to: At| curves.crossing(&labels, from, to);
            return trace(&labels, crossing, |at| labels.joined(at));
        }
        curves.keep(&lost, keep);
        keep *= 2.0;
    }
}

/// An outline with its curve.
struct Curve {
    label: u32,
    outline: Outline,
    fit: Implicit,
}

struct Curves<'a> {
    pixels: &'a Pixels,
    all: Vec<Curve>,
    /// For every pixel near an outline those near it, each label's nearest, and how far it is.
    near: HashMap<At, Vec<(usize, f64)>>,
    /// The outline of each label through each middle between two pixels, that in half pixels.
    through: HashMap<(u32, At), usize>,
    /// The pixels that keep their labels.
    kept: HashSet<At>,
}

impl<'a> Curves<'a> {
    fn new(pixels: &'a Pixels, options: &CurveOptions) -> Self {
        let fitted = |(label, outline): (u32, Outline)| {
            let fit = Implicit::new(&outline, options);
            Curve { label, outline, fit }
        };
        let all: Vec<Curve> = pixels.outlines().into_iter().map(fitted).collect();
        let (near, through, kept) = (HashMap::new(), HashMap::new(), HashSet::new());
        let mut own = Self { pixels, all, near, through, kept };
        for number in 0..own.all.len() {
            own.reach(number);
        }
        own
    }

    /// Notes the pixels near an outline.
    fn reach(&mut self, number: usize) {
        let label = self.all[number].label;
        for &point in &self.all[number].outline.points {
            self.through.insert((label, halves(point)), number);
            for at in within(point, BAND) {
                let far = center(at).distance(point);
                let known = self.near.entry(at).or_default();
                match known.iter_mut().find(|(own, _)| self.all[*own].label == label) {
                    Some(own) if own.1 <= far => {}
                    Some(own) => *own = (number, far),
                    None => known.push((number, far)),
                }
            }
        }
    }

    /// The outline of a label that is the nearest to a pixel.
    fn nearest(&self, label: u32, at: At) -> Option<usize> {
        let near = self.near.get(&at)?;
        near.iter().find(|(number, _)| self.all[*number].label == label).map(|(number, _)| *number)
    }

    /// The value of a label at a pixel.
    fn value(&self, label: u32, at: At) -> f64 {
        let is_own = self.pixels.label(at) == label;
        let beyond = if is_own { BEYOND } else { -BEYOND };
        if self.kept.contains(&at) {
            let share = 2.0 * self.pixels.share(label, center(at)) - 1.0;
            return if is_own { share.max(KEPT) } else { share.min(-KEPT) };
        }
        let fitted = self.nearest(label, at).and_then(|own| self.all[own].fit.value(center(at)));
        fitted.map_or(beyond, |value| value.clamp(-BEYOND, BEYOND))
    }

    /// The labels that win.
    fn labels(&self) -> Pixels {
        let mut labels = self.pixels.clone();
        let [width, height] = labels.size.map(|pixels| pixels as i32);
        for (&at, near) in &self.near {
            let [x, y] = at;
            if (0..width).contains(&x) && (0..height).contains(&y) {
                let own = near.iter().map(|&(number, _)| self.all[number].label);
                let is_outside = own.clone().any(|label| label == 0) && self.value(0, at) > 0.0;
                // Of equals the smaller one, whatever their order.
                let values =
                    own.filter(|&label| label > 0).map(|label| (self.value(label, at), label));
                let more = |best: (f64, u32), next: (f64, u32)| {
                    if (next.0, best.1) > (best.0, next.1) { next } else { best }
                };
                let best = values.reduce(more).filter(|_| !is_outside);
                let winner = best.map_or(0, |(_, label)| label);
                labels.labels[y as usize * width as usize + x as usize] = winner;
            }
        }
        labels
    }

    /// Where the labels of two neighbours change between them, as a part of the way.
    fn crossing(&self, labels: &Pixels, from: At, to: At) -> f64 {
        let sides = [labels.label(from), labels.label(to)];
        // Where one is outside its curve alone counts, as for the labels.
        let lead = |[one, other]: [f64; 2]| match sides {
            [0, _] => one,
            [_, 0] => -other,
            _ => one - other,
        };
        let [before, after] = [from, to].map(|at| lead(sides.map(|label| self.value(label, at))));
        let part = before / (before - after);
        let linear = if part.is_finite() { part } else { 0.5 };
        // Along the curves themselves, where both are known all the way.
        if [from, to].iter().any(|at| self.kept.contains(at)) {
            return linear;
        }
        let fits = sides.map(|label| {
            let ends = [from, to].map(|at| self.nearest(label, at));
            let number = ends[0].filter(|_| ends[0] == ends[1])?;
            Some(&self.all[number].fit)
        });
        let [Some(one), Some(other)] = fits else { return linear };
        let [start, end] = [center(from), center(to)];
        let lead = |part: f64| {
            let at = start.lerp(end, part);
            Some(lead([one.value(at)?, other.value(at)?]))
        };
        let mut ends = [0.0, 1.0];
        for _ in 0..STEPS {
            let middle = 0.5 * (ends[0] + ends[1]);
            match lead(middle) {
                Some(ahead) if ahead > 0.0 => ends[0] = middle,
                Some(_) => ends[1] = middle,
                None => return linear,
            }
        }
        0.5 * (ends[0] + ends[1])
    }

    /// The outlines that did not come back, and, of those that came back more than once, all but
    /// the longest.
    fn unaccounted(&self, labels: &Pixels) -> Vec<Outline> {
        let mut found: Vec<Vec<Outline>> = vec![Vec::new(); self.all.len()];
        for (label, outline) in labels.outlines() {
            if let Some(own) = self.origin(label, &outline) {
                found[own].push(outline);
            }
        }
        let lost = |(own, mut found): (&Curve, Vec<Outline>)| {
            found.sort_by_key(|outline| outline.points.len());
            match found.pop() {
                None => vec![own.outline.clone()],
                Some(_) => found,
            }
        };
        self.all.iter().zip(found).flat_map(lost).collect()
    }

    /// The outline that another came from: the one that most of its points are nearest to.
    fn origin(&self, label: u32, outline: &Outline) -> Option<usize> {
        let mut votes: BTreeMap<usize, usize> = BTreeMap::new();
        for number in outline.points.iter().filter_map(|&point| self.nearest_to(label, point)) {
            *votes.entry(number).or_default() += 1;
        }
        votes.into_iter().max_by_key(|&(_, votes)| votes).map(|(number, _)| number)
    }

    /// The outline of a label that goes through a middle between two pixels, or the nearest one.
    fn nearest_to(&self, label: u32, point: DVec2) -> Option<usize> {
        let at = halves(point);
        let here = self.through.get(&(label, at)).copied();
        here.or_else(|| {
            let near = within(2.0 * point, 2.0 * BAND).filter_map(|other| {
                let far = [0, 1].map(|axis| (other[axis] - at[axis]).pow(2)).iter().sum::<i32>();
                Some((far, *self.through.get(&(label, other))?))
            });
            near.min().map(|(_, number)| number)
        })
    }

    /// Pixels near some outlines keep their labels from now on.
    fn keep(&mut self, outlines: &[Outline], reach: f64) {
        if reach > KEEP_ALL {
            self.kept.extend(self.near.keys());
        }
        let points = outlines.iter().flat_map(|outline| &outline.points);
        self.kept.extend(points.flat_map(|&point| within(point, reach.min(KEEP_ALL))));
    }
}

/// The pixels around a point.
fn within(point: DVec2, reach: f64) -> impl Iterator<Item = At> {
    let [low, high] = [(point - reach).ceil(), (point + reach).floor()].map(|end| end.as_ivec2());
    let all = (low.y..=high.y).flat_map(move |y| (low.x..=high.x).map(move |x| [x, y]));
    all.filter(move |&at| center(at).distance(point) <= reach)
}

/// A middle between two pixels, in half pixels.
fn halves(point: DVec2) -> At {
    (2.0 * point).round().as_ivec2().to_array()
}

fn center([x, y]: At) -> DVec2 {
    DVec2::new(f64::from(x), f64::from(y))
}
