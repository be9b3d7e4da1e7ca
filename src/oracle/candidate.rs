//! The nearest known point of one section: the foot where that is known, else a
//! point of the edges between known and unknown.

use glam::DVec3;

use super::exact::{Number, Query, Spot, rounded};
use super::float::Range;
use super::foot::Foot;
use super::site::Site;
use super::tree::BoxTree;
use crate::label::Label;

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

/// The nearest point of an edge to a foot, as floats know it.
struct Touch {
    edge: u32,
    /// Its distance from the foot.
    aside: Range,
    place: DVec3,
    /// Nothing where floats cannot tell an end from what is next to it.
    spot: Option<Spot>,
}

impl Site<'_> {
    /// The nearest known point when it may be within a limit; `height` is the
    /// distance to the plane.
    pub fn candidate(&self, query: &Query, height: Range, limit: f64) -> Option<Candidate> {
        let foot = Foot::new(self, query);
        let candidate =
            |label| Candidate { distance: height, place: foot.place, label, edges: Vec::new() };
        if self.is_full {
            return Some(candidate(None)); // to be looked up when it is chosen
        }
        match foot.label() {
            Label::UNKNOWN => self.border(&foot, height, limit),
            label => Some(candidate(Some(label))),
        }
    }

    /// The nearest point on the edges between known and unknown.
    fn border(&self, foot: &Foot, height: Range, limit: f64) -> Option<Candidate> {
        // The distance is the hypotenuse over height and aside. The difference
        // of squares is good to a few roundings of the larger.
        let square = limit * limit * (1.0 + 8.0 * f64::EPSILON) - height.low * height.low;
        let limit = square.max(0.0).sqrt() * (1.0 + f64::EPSILON);
        let touches = self.nearest_borders(foot, limit);
        let aside = touches.iter().map(|touch| touch.aside).reduce(Range::min)?;
        let place = touches.iter().find(|touch| touch.aside.value == aside.value)?.place;
        let label = self.agreed_label(&touches);
        let edges = touches.iter().map(|touch| touch.edge).collect();
        Some(Candidate { distance: height.hypot(aside), place, label, edges })
    }

    /// The edges between known and unknown that can hold the nearest of all
    /// their points, unless that is beyond a limit; in their order.
    fn nearest_borders(&self, foot: &Foot, limit: f64) -> Vec<Touch> {
        let Some(tree) = self.around(Label::UNKNOWN) else { return Vec::new() };
        // Kept coordinates are a projection, so distances in them are no larger
        // than in space; the foot's own error comes on top.
        let reach = 2.0 * foot.error;
        let mut nearest = limit;
        let mut touches: Vec<Touch> = Vec::new();
        tree.approach(foot.kept, nearest + reach, |edge| {
            let touch = self.touch(foot, edge);
            if touch.aside.low <= nearest {
                nearest = nearest.min(touch.aside.high);
                touches.push(touch);
            }
            nearest + reach
        });
        touches.retain(|touch| touch.aside.low <= nearest);
        touches.sort_by_key(|touch| touch.edge);
        touches
    }

    /// The distance from a foot to the nearest of some edges when it is below a
    /// limit; in floats.
    pub fn aside(&self, foot: &Foot, edges: &BoxTree, limit: f64) -> Option<f64> {
        let mut nearest = limit;
        edges.approach(foot.kept, limit, |edge| {
            nearest = nearest.min(self.touch(foot, edge).aside.value);
            nearest
        });
        (nearest < limit).then_some(nearest)
    }

    fn touch(&self, foot: &Foot, edge: u32) -> Touch {
        let ends = &self.section.edges()[edge as usize];
        let [start, end] =
            [ends.start, ends.end].map(|vertex| self.vertices[vertex as usize].place);
        let (along, offset) = (end - start, foot.place - start);
        let square = along.length_squared();
        let times = if square > 0.0 { offset.dot(along) / square } else { 0.0 };
        let on_edge = times.clamp(0.0, 1.0) * along;
        let size = offset.length() + along.length();
        let error = 2.0 * (foot.error + self.off) + 16.0 * f64::EPSILON * size;
        // How far `times` may be off: the ends' errors turn the edge, and the
        // farther the foot is the more its projection moves.
        let doubt = 8.0 * error * size / square;
        let aside = Range::around((offset - on_edge).length(), error);
        Touch { edge, aside, place: start + on_edge, spot: Spot::told(times, doubt) }
    }

    /// The label of the nearest point, when it does not matter on which of the
    /// edges that is.
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
            Spot::Start => self.vertices[edge.start as usize].label,
            Spot::End => self.vertices[edge.end as usize].label,
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

impl Spot {
    /// From the part of a segment that lies before a point, where that is known
    /// well enough.
    fn told(times: f64, doubt: f64) -> Option<Self> {
        if times < -doubt {
            Some(Self::Start)
        } else if times > 1.0 + doubt {
            Some(Self::End)
        } else if times > doubt && times < 1.0 - doubt {
            Some(Self::Within)
        } else {
            None
        }
    }
}
