//! One section made ready to be asked.

use std::collections::BTreeMap;

use glam::{DVec2, DVec3};

use super::exact::{ExactPlane, Number, Query, Spot, rounded};
use super::float::{FloatPlane, Range};
use super::foot::Foot;
use super::tree::BoxTree;
use crate::label::Label;
use crate::section::Section;

/// A section with what it takes to find the known point nearest to any other.
pub struct Site<'a> {
    pub section: &'a Section,
    pub plane: FloatPlane,
    pub exact: ExactPlane,
    /// All edges, by their kept coordinates.
    pub edges: BoxTree,
    /// For every label that has any, the edges with it on one side.
    around: BTreeMap<Label, BoxTree>,
    /// The smallest label around each vertex.
    labels: Vec<Label>,
    /// The vertices in space, rounded, and how far off the farthest may be.
    points: Vec<DVec3>,
    off: f64,
}

/// What is nearest on a section.
pub struct Candidate {
    /// How far away it is.
    pub distance: Range,
    /// Where, rounded.
    pub place: DVec3,
    /// What is there, once it is known.
    pub label: Option<Label>,
    /// The edges it can lie on; none for the foot itself.
    pub edges: Vec<u32>,
}

/// The nearest point of an edge as floats know it.
struct Touch {
    edge: u32,
    /// Its distance from the foot.
    aside: Range,
    place: DVec3,
    /// The vertex, or the edge when it is not near a vertex; nothing where
    /// floats cannot tell these.
    spot: Option<Spot>,
}

impl<'a> Site<'a> {
    pub fn new(section: &'a Section) -> Self {
        let plane = section.plane();
        let mut labels = vec![Label::UNKNOWN; section.vertices().len()];
        let mut around: BTreeMap<Label, Vec<(u32, [DVec2; 2])>> = BTreeMap::new();
        let mut all = Vec::with_capacity(section.edges().len());
        for (number, edge) in section.edges().iter().enumerate() {
            let [start, end] =
                [edge.start, edge.end].map(|vertex| section.vertices()[vertex as usize]);
            let thing = (number as u32, [start.min(end), start.max(end)]);
            all.push(thing);
            for label in [edge.left, edge.right] {
                around.entry(label).or_default().push(thing);
            }
            for vertex in [edge.start, edge.end] {
                let label = &mut labels[vertex as usize];
                *label = (*label).min(edge.left).min(edge.right);
            }
        }
        let points = (0..section.vertices().len() as u32).map(|vertex| section.point(vertex));
        let off = section.vertices().iter().map(|&kept| lift_error(section, kept));
        Self {
            section,
            plane: FloatPlane::new(plane),
            exact: ExactPlane::new(*plane),
            edges: BoxTree::new(all),
            around: around.into_iter().map(|(label, edges)| (label, BoxTree::new(edges))).collect(),
            labels,
            points: points.collect(),
            off: off.fold(0.0, f64::max),
        }
    }

    /// Whether anything is known on it.
    pub fn knows_anything(&self) -> bool {
        self.section.background() != Label::UNKNOWN || !self.section.edges().is_empty()
    }

    /// Whether everything is known on it.
    pub fn knows_all(&self) -> bool {
        self.section.background() != Label::UNKNOWN && !self.around.contains_key(&Label::UNKNOWN)
    }

    /// The ends of an edge by their kept coordinates.
    pub fn ends(&self, edge: u32) -> [DVec2; 2] {
        let edge = &self.section.edges()[edge as usize];
        [edge.start, edge.end].map(|vertex| self.section.vertices()[vertex as usize])
    }

    /// The nearest known point when it may be within a limit; `height` is the
    /// distance to the plane.
    pub fn candidate(&self, query: &Query, height: Range, limit: f64) -> Option<Candidate> {
        let foot = Foot::new(self, query);
        let here = |label| {
            Some(Candidate { distance: height, place: foot.place, label, edges: Vec::new() })
        };
        if self.knows_all() {
            return here(None);
        }
        match foot.label() {
            Label::UNKNOWN => self.border(&foot, height, limit),
            label => here(Some(label)),
        }
    }

    /// The nearest point on the edges between known and unknown.
    fn border(&self, foot: &Foot, height: Range, limit: f64) -> Option<Candidate> {
        // The distance is the hypotenuse over height and aside. The difference
        // of squares is good to a few roundings of the larger.
        let square = limit * limit * (1.0 + 8.0 * f64::EPSILON) - height.low * height.low;
        let limit = square.max(0.0).sqrt() * (1.0 + f64::EPSILON);
        let touches = self.nearest_edges(foot, Label::UNKNOWN, limit);
        let aside = touches.iter().map(|touch| touch.aside).reduce(Range::min)?;
        let place = touches.iter().find(|touch| touch.aside.value == aside.value)?.place;
        let label = self.agreed_label(&touches);
        let edges = touches.iter().map(|touch| touch.edge).collect();
        Some(Candidate { distance: height.hypot(aside), place, label, edges })
    }

    /// The edges with a label on one side that can hold the point of all such
    /// edges that is nearest to a foot, unless that is beyond a limit.
    fn nearest_edges(&self, foot: &Foot, label: Label, limit: f64) -> Vec<Touch> {
        let Some(tree) = self.around.get(&label) else { return Vec::new() };
        let mut nearest = limit;
        let mut touches: Vec<Touch> = Vec::new();
        // Kept coordinates are a projection, so distances in them are no larger
        // than in space; the foot's own error comes on top.
        tree.approach(foot.kept, nearest + 2.0 * foot.error, |edge| {
            let touch = self.touch(foot, edge);
            if touch.aside.low <= nearest {
                nearest = nearest.min(touch.aside.high);
                touches.push(touch);
            }
            nearest + 2.0 * foot.error
        });
        touches.retain(|touch| touch.aside.low <= nearest);
        touches.sort_by_key(|touch| touch.edge);
        touches
    }

    /// The nearest point of an edge to the foot.
    fn touch(&self, foot: &Foot, edge: u32) -> Touch {
        let ends = &self.section.edges()[edge as usize];
        let [start, end] = [ends.start, ends.end].map(|vertex| self.points[vertex as usize]);
        let (along, offset) = (end - start, foot.place - start);
        let square = along.length_squared();
        let times = if square > 0.0 { offset.dot(along) / square } else { 0.0 };
        let gap = offset - times.clamp(0.0, 1.0) * along;
        let reach = offset.length() + along.length();
        let error = 2.0 * (foot.error + self.off) + 16.0 * f64::EPSILON * reach;
        // How far `times` may be off: the ends' errors turn the edge, and the
        // farther the foot is the more its projection moves.
        let doubt = 8.0 * error * reach / square;
        let spot = if times < -doubt {
            Some(Spot::Start)
        } else if times > 1.0 + doubt {
            Some(Spot::End)
        } else if times > doubt && times < 1.0 - doubt {
            Some(Spot::Within)
        } else {
            None
        };
        let place = start + times.clamp(0.0, 1.0) * along;
        Touch { edge, aside: Range::around(gap.length(), error), place, spot }
    }

    /// The label at the nearest of some points, when all have the same or are
    /// the same.
    fn agreed_label(&self, touches: &[Touch]) -> Option<Label> {
        let label = |touch: &Touch| touch.spot.map(|spot| self.label_at(touch.edge, spot));
        let first = label(touches.first()?)?;
        touches.iter().all(|touch| label(touch) == Some(first)).then_some(first)
    }

    /// The smallest label around a point of an edge.
    fn label_at(&self, edge: u32, spot: Spot) -> Label {
        let edge = &self.section.edges()[edge as usize];
        match spot {
            Spot::Within => edge.left.min(edge.right),
            Spot::Start => self.labels[edge.start as usize],
            Spot::End => self.labels[edge.end as usize],
        }
    }

    /// The exact squared distance of a candidate.
    pub fn squared_distance(&self, candidate: &Candidate, query: &Query) -> Number {
        let edge = |&edge: &u32| self.exact.nearest_on(self.ends(edge), query.exact()).squared;
        let nearest = candidate.edges.iter().map(edge).min();
        nearest.unwrap_or_else(|| self.exact.squared_distance(query.exact()))
    }

    /// What is at a candidate, and where that is: of points that are equally
    /// near, one with the smallest label.
    pub fn resolve(&self, candidate: &Candidate, query: &Query) -> (Label, DVec3) {
        if let Some(label) = candidate.label {
            return (label, candidate.place);
        }
        let near = candidate.edges.iter().map(|&edge| {
            let found = self.exact.nearest_on(self.ends(edge), query.exact());
            let label = self.label_at(edge, found.at);
            (found.squared, label, rounded(&found.place))
        });
        let nearest = near.min_by(|one, other| one.0.cmp(&other.0).then(one.1.cmp(&other.1)));
        let foot = || (Foot::new(self, query).label(), candidate.place);
        nearest.map_or_else(foot, |(_, label, place)| (label, place))
    }
}

/// A bound on how far a rounded vertex is off its true place.
fn lift_error(section: &Section, kept: DVec2) -> f64 {
    let (plane, point) = (section.plane(), section.plane().lift(kept));
    let [first, second] = plane.kept_axes();
    let terms = (plane.normal[first] * kept.x).abs()
        + (plane.normal[second] * kept.y).abs()
        + plane.offset.abs();
    let dropped = plane.dropped_axis();
    8.0 * f64::EPSILON * (terms / plane.normal[dropped].abs() + point[dropped].abs())
}
