//! Sections from planar graphs whose edges carry a label on either side.

use std::collections::BTreeMap;

use glam::DVec3;

use super::draft::Draft;
use super::loops::{crossings, odd};
use super::subdivision::{Cover, Curves, Side, Subdivision, UNBOUNDED, Windings, times};
use super::{Edge, Findings, Rules, Section};
use crate::error::{Error, Result};
use crate::label::Label;
use crate::plane::Plane;

impl Section {
    /// A section from a planar graph with labels on either side of its edges.
    ///
    /// Vertices may lie on edges, and what nearly touches does ([`Rules::snapping`]); edges with
    /// one label on both sides are dropped. The boundary of a label that crosses itself is read by
    /// the even-odd rule. Without edges the whole plane is *outside*; where there are some and
    /// none encloses anything, all is unknown.
    ///
    /// # Errors
    /// Where the plane is none, a vertex is not finite, too far off the plane
    /// or missing, and where the labels contradict each other.
    pub fn from_graph(
        name: &str,
        plane: Plane,
        points: &[DVec3],
        edges: &[Edge],
        diagonal: f64,
        rules: &Rules,
    ) -> Result<(Self, Findings)> {
        let mut draft = Draft::new(name, plane, diagonal, rules)?;
        let mut curves = Curves::default();
        let numbers = points
            .iter()
            .enumerate()
            .map(|(i, &point)| draft.project(point, || format!("vertex {i}")))
            .map(|kept| kept.map(|kept| curves.point(kept)))
            .collect::<Result<Vec<u32>>>()?;
        for (i, edge) in edges.iter().enumerate() {
            let missing = [edge.start, edge.end].into_iter().find(|&v| v as usize >= points.len());
            if let Some(vertex) = missing {
                return Err(draft.error(format!(
                    "edge {i} ends at vertex {vertex}, but there are only {}",
                    points.len()
                )));
            }
        }
        let drawn: Vec<Edge> =
            edges.iter().filter(|edge| edge.left != edge.right).copied().collect();
        let mut labels: Vec<Label> =
            drawn.iter().flat_map(|edge| [edge.left, edge.right]).collect();
        labels.sort();
        labels.dedup();
        curves.boundaries(&drawn, &numbers, |label| labels.binary_search(&label).ok());
        let mut graph = Graph { subdivision: curves.subdivide(&mut draft)?, labels };
        graph.settle_edges(&draft)?;
        graph.require_closed(&draft)?;
        let faces = graph.faces(&mut draft)?;
        if !drawn.is_empty() && faces.iter().all(|&face| face == faces[UNBOUNDED]) {
            draft.leave_all_out();
            let says_nothing = vec![Label::UNKNOWN; faces.len()];
            return Ok((graph.subdivision.section(&draft, &says_nothing), draft.findings));
        }
        let section = graph.subdivision.section(&draft, &faces);
        Ok((section, draft.findings))
    }

    /// A section from closed curves that may cross, touch and run along each other: a label
    /// wherever they wind around a point at all, outside elsewhere; with the least and the
    /// largest number of times that they wind, counter-clockwise positive.
    ///
    /// # Errors
    /// Where the plane is none, a vertex is not finite or too far off the plane.
    pub(crate) fn from_windings(
        name: &str,
        plane: Plane,
        points: &[DVec3],
        edges: &[Edge],
        label: Label,
        diagonal: f64,
    ) -> Result<(Self, [i32; 2])> {
        const ALL: u32 = 0;
        let rules = Rules { snapping: Some(0.0), ..Rules::default() };
        let mut draft = Draft::new(name, plane, diagonal, &rules)?;
        let mut curves = Curves::default();
        let mut numbers = Vec::with_capacity(points.len());
        for (i, &point) in points.iter().enumerate() {
            numbers.push(curves.point(draft.project(point, || format!("vertex {i}"))?));
        }
        for edge in edges {
            let [start, end] = [edge.start, edge.end].map(|vertex| numbers[vertex as usize]);
            curves.segment(ALL as usize, start, end);
        }
        let subdivision = curves.subdivide(&mut draft)?;
        let windings = subdivision.windings();
        let windings: Vec<i32> = windings.iter().map(|own| times(own, ALL)).collect();
        let of = |&winding: &i32| if winding == 0 { Label::OUTSIDE } else { label };
        let labels: Vec<Label> = windings.iter().map(of).collect();
        let range = windings.iter().fold([0; 2], |[low, high], &own| [low.min(own), high.max(own)]);
        Ok((subdivision.section(&draft, &labels), range))
    }
}

/// The boundaries of labels, and the faces between them.
struct Graph {
    /// A curve for every label, which lies left of it.
    subdivision: Subdivision,
    /// Sorted.
    labels: Vec<Label>,
}

impl Graph {
    /// Leaves at most one label on either side of every edge. Of edges that lie on each other a
    /// label that ends where it begins goes: between 1|0 and 0|2 there was a sliver of 0.
    fn settle_edges(&mut self, draft: &Draft) -> Result<()> {
        for number in 0..self.subdivision.edges.len() {
            let mut sums: BTreeMap<u32, i32> = BTreeMap::new();
            for cover in &self.subdivision.edges[number].covers {
                *sums.entry(cover.curve).or_default() += if cover.forward { 1 } else { -1 };
            }
            sums.retain(|_, sum| *sum != 0);
            let side = &mut self.subdivision.edges[number];
            side.covers =
                sums.iter().map(|(&curve, &sum)| Cover { curve, forward: sum > 0 }).collect();
            let sides = [true, false]
                .map(|left| side.covers.iter().filter(|cover| cover.forward == left).count());
            if sides != [1, 1] && sides != [0, 0] {
                let label = self.labels[side.covers[0].curve as usize];
                let start = side.start;
                return Err(self.contradiction(draft, start, label));
            }
        }
        Ok(())
    }

    /// Around every vertex a label ends as often as it begins.
    fn require_closed(&self, draft: &Draft) -> Result<()> {
        let mut sums: BTreeMap<(u32, u32), i32> = BTreeMap::new();
        for Side { start, end, covers, .. } in &self.subdivision.edges {
            for cover in covers {
                let step = if cover.forward { 1 } else { -1 };
                *sums.entry((*start, cover.curve)).or_default() += step;
                *sums.entry((*end, cover.curve)).or_default() -= step;
            }
        }
        match sums.iter().find(|(_, sum)| **sum != 0) {
            Some((&(vertex, curve), _)) => {
                Err(self.contradiction(draft, vertex, self.labels[curve as usize]))
            }
            None => Ok(()),
        }
    }

    /// The label of every face: that whose boundary winds around it an odd number of times, or
    /// else what is far away.
    fn faces(&self, draft: &mut Draft) -> Result<Vec<Label>> {
        let windings = self.subdivision.windings();
        let far = self.far();
        let doubtful = self.doubtful(&windings, far);
        let mut places = Vec::new();
        for &curve in &doubtful {
            let crossings = crossings(&self.subdivision, &windings, curve);
            if crossings.is_empty() {
                let vertex = self.vertex_of(curve);
                return Err(self.contradiction(draft, vertex, self.labels[curve as usize]));
            }
            places.extend(crossings.into_iter().map(|place| place.to_array()));
        }
        places.sort_by(|a, b| a[0].total_cmp(&b[0]).then(a[1].total_cmp(&b[1])));
        places.dedup();
        let mut faces = Vec::with_capacity(windings.len());
        for around in &windings {
            let mut inside = around.iter().filter(|&&(curve, times)| curve != far && odd(times));
            let label = inside.next().map_or(far, |&(curve, _)| curve);
            if inside.next().is_some() {
                let vertex = self.vertex_of(label);
                return Err(self.contradiction(draft, vertex, self.labels[label as usize]));
            }
            faces.push(self.labels.get(label as usize).copied().unwrap_or(Label::OUTSIDE));
        }
        if let Some(&place) = places.first() {
            let more = match places.len() - 1 {
                0 => String::new(),
                more => format!(" and {more} more places"),
            };
            let labels: Vec<String> =
                doubtful.iter().map(|&curve| self.labels[curve as usize].to_string()).collect();
            draft.warn(format!(
                "the boundary of label {} crosses itself at {}{more}: read by the even-odd rule",
                labels.join(" and of label "),
                draft.place(place.into()),
            ))?;
        }
        Ok(faces)
    }

    /// The label (by its curve) that most of the outermost edges have on their far side.
    fn far(&self) -> u32 {
        let mut lengths = vec![0.0; self.labels.len()];
        for side in &self.subdivision.edges {
            let [start, end] =
                [side.start, side.end].map(|vertex| self.subdivision.points[vertex as usize]);
            for cover in &side.covers {
                if (if cover.forward { side.left } else { side.right }) == UNBOUNDED {
                    lengths[cover.curve as usize] += start.distance(end);
                }
            }
        }
        // Of equals the first.
        let longest = (0..lengths.len()).rev().max_by(|&a, &b| lengths[a].total_cmp(&lengths[b]));
        longest.unwrap_or_default() as u32
    }

    /// The curves that wind around some face neither 0 times nor once; that of the label far away
    /// does what is left.
    fn doubtful(&self, windings: &[Windings], far: u32) -> Vec<u32> {
        let mut doubtful: Vec<u32> = windings
            .iter()
            .flatten()
            .filter(|&&(curve, times)| curve != far && times != 1)
            .map(|&(curve, _)| curve)
            .collect();
        doubtful.sort_unstable();
        doubtful.dedup();
        doubtful
    }

    /// The first vertex of a label's boundary.
    fn vertex_of(&self, curve: u32) -> u32 {
        let along = |side: &&Side| side.covers.iter().any(|cover| cover.curve == curve);
        self.subdivision.edges.iter().find(along).map_or(0, |side| side.start)
    }

    fn contradiction(&self, draft: &Draft, vertex: u32, label: Label) -> Error {
        let place = draft.place(self.subdivision.points[vertex as usize]);
        draft.error(format!(
            "contradictory labels around vertex {vertex} at {place}: what edges say of label \
             {label} does not fit together: correct the labels or the missing or crossing edges"
        ))
    }
}
