//! Contours between the pixels of an image, by marching squares over their centres.
//!
//! A square of four centres holds the contours between their labels:
//!
//! ```text
//!   a───x───b     two crossings: one segment
//!   │   │   │     three: three segments that meet inside
//!   x   ·───x     four: two segments around the corners that are cut off, or four that meet
//!   │       │
//!   a───────a
//! ```
//!
//! Contours close, and never cross: a square's segments lie within it and end where its
//! neighbours' do. Around the image lies a ring of pixels that are outside.

use std::collections::HashMap;

use glam::DVec2;

use crate::label::Label;
use crate::section::Edge;

/// Crossings keep this part of the way between two centres away from both, so that no two points
/// coincide.
const CLEARANCE: f64 = 0.01;

/// The label of every pixel.
#[derive(Debug, Clone, PartialEq)]
pub struct Pixels {
    /// How many a row has, and how many rows there are.
    pub size: [usize; 2],
    /// Row by row.
    pub labels: Vec<u32>,
}

/// A pixel; beyond the image they are outside.
pub type At = [i32; 2];

impl Pixels {
    /// The label of a pixel.
    pub fn label(&self, [x, y]: At) -> u32 {
        let [width, height] = self.size;
        match (usize::try_from(x), usize::try_from(y)) {
            (Ok(x), Ok(y)) if x < width && y < height => self.labels[y * width + x],
            _ => 0,
        }
    }
}

/// A planar graph with a label on either side of each edge.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Contours {
    /// In pixels: the first one's centre is the origin.
    pub points: Vec<DVec2>,
    /// Labels as seen with y, the way of the columns, pointing to the left of x.
    pub edges: Vec<Edge>,
}

/// The contours between labels. `crossing` tells at which part of the way from a pixel to its
/// neighbour the labels change; `joined` which label goes on through the middle of a square,
/// given by its first pixel, whose opposite corners are alike. Where it says none, or
/// another, outside does before any material: so parts that touch in corners alone are apart.
pub fn trace(
    pixels: &Pixels,
    crossing: impl Fn(At, At) -> f64,
    joined: impl Fn(At) -> Option<u32>,
) -> Contours {
    let mut tracer = Tracer { crossing, crossings: HashMap::new(), contours: Contours::default() };
    let [width, height] = pixels.size.map(|pixels| pixels as i32);
    for y in -1..height {
        for x in -1..width {
            // Counter-clockwise.
            let corners = [[x, y], [x + 1, y], [x + 1, y + 1], [x, y + 1]];
            let labels = corners.map(|at| pixels.label(at));
            if labels.iter().any(|&label| label != labels[0]) {
                tracer.square(corners, labels, &joined);
            }
        }
    }
    tracer.contours
}

struct Tracer<F> {
    crossing: F,
    /// The crossing between two pixels, the one that comes first named first.
    crossings: HashMap<[At; 2], u32>,
    contours: Contours,
}

impl<F: Fn(At, At) -> f64> Tracer<F> {
    fn square(&mut self, corners: [At; 4], labels: [u32; 4], joined: impl Fn(At) -> Option<u32>) {
        let sides = (0..4).filter(|&side| labels[side] != labels[(side + 1) % 4]);
        // Each with the labels before and after it, counter-clockwise: seen from outside the
        // square, those on its left and on its right.
        let crossings: Vec<(u32, [u32; 2])> = sides
            .map(|side| {
                let next = (side + 1) % 4;
                (self.crossed(corners[side], corners[next]), [labels[side], labels[next]])
            })
            .collect();
        match crossings.as_slice() {
            &[(start, sides), (end, _)] => self.edge([start, end], sides),
            _ => match through(labels, joined(corners[0])) {
                Some(label) => self.cut_off(&crossings, label),
                None => self.junction(&crossings),
            },
        }
    }

    /// Corners with other labels are cut off, each by a segment.
    fn cut_off(&mut self, crossings: &[(u32, [u32; 2])], label: u32) {
        for (number, &(start, [before, own])) in crossings.iter().enumerate() {
            if before == label {
                let (end, _) = crossings[(number + 1) % crossings.len()];
                self.edge([start, end], [label, own]);
            }
        }
    }

    /// All crossings meet in the middle of those with outside, whose contour runs on smoothly
    /// where two materials meet on it; of all where there are none.
    fn junction(&mut self, crossings: &[(u32, [u32; 2])]) {
        let outer = crossings.iter().filter(|(_, sides)| sides.contains(&0));
        let outer: Vec<u32> = outer.map(|&(point, _)| point).collect();
        let all = || crossings.iter().map(|&(point, _)| point).collect();
        let meeting = if outer.is_empty() { all() } else { outer };
        let points = meeting.iter().map(|&point| self.contours.points[point as usize]);
        let middle = points.sum::<DVec2>() / meeting.len() as f64;
        let middle = self.add(middle);
        for &(start, sides) in crossings {
            self.edge([start, middle], sides);
        }
    }

    fn edge(&mut self, [start, end]: [u32; 2], [left, right]: [u32; 2]) {
        let (left, right) = (Label(left), Label(right));
        self.contours.edges.push(Edge { start, end, left, right });
    }

    fn crossed(&mut self, one: At, other: At) -> u32 {
        let is_first = (one[1], one[0]) < (other[1], other[0]);
        let [from, to] = if is_first { [one, other] } else { [other, one] };
        if let Some(&known) = self.crossings.get(&[from, to]) {
            return known;
        }
        let part = (self.crossing)(from, to).clamp(CLEARANCE, 1.0 - CLEARANCE);
        let [start, end] = [from, to].map(|[x, y]| DVec2::new(f64::from(x), f64::from(y)));
        let number = self.add(start.lerp(end, part));
        self.crossings.insert([from, to], number);
        number
    }

    fn add(&mut self, point: DVec2) -> u32 {
        self.contours.points.push(point);
        self.contours.points.len() as u32 - 1
    }
}

/// Which label goes on through the middle of a square, if one does.
fn through(labels: [u32; 4], wanted: Option<u32>) -> Option<u32> {
    let opposite = [0, 1].into_iter().filter(|&corner| labels[corner] == labels[corner + 2]);
    let alike: Vec<u32> = opposite.map(|corner| labels[corner]).collect();
    wanted.filter(|label| alike.contains(label)).or_else(|| alike.into_iter().min())
}
