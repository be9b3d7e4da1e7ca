//! Where the surface rests on little: its parts that are farthest from what
//! sections know.

use std::collections::BTreeMap;

use glam::DVec3;
use rayon::prelude::*;
use serde::Serialize;

use crate::grid::evidence::Evidence;
use crate::mesh::Mesh;
use crate::section::Section;
use crate::sets::Sets;

/// The share of the surface's area that counts as poorly supported.
const SHARE: f64 = 0.05;
/// How many parts are listed.
const PARTS: usize = 8;
/// Triangles that are looked up together: neighbours in a mesh are near each
/// other, as a rule.
const TOGETHER: usize = 64;

/// The twentieth of the surface that is farthest from known parts of sections.
#[derive(Debug, Clone, Default, PartialEq, Serialize)]
pub struct Support {
    /// How far from known parts it begins, in world units.
    pub threshold: f64,
    /// Its largest connected parts, at most eight; none where sections leave no
    /// room of a voxel.
    pub parts: Vec<Part>,
}

/// A connected part of the surface.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Part {
    /// In square world units.
    pub area: f64,
    /// Its centre of gravity.
    pub at: [f64; 3],
    /// Its greatest distance from known parts of sections, in world units.
    pub distance: f64,
    /// The materials that it bounds.
    pub labels: Vec<u32>,
}

/// Measures a mesh; `voxel` in world units.
pub fn support(mesh: &Mesh, sections: &[Section], voxel: f64) -> Support {
    let triangles = measured(mesh, &Evidence::new(sections));
    let (threshold, weak) = farthest(&triangles);
    if threshold <= voxel {
        return Support { threshold, parts: Vec::new() };
    }
    let mut parts = connected_parts(mesh, &triangles, &weak);
    parts.sort_by(|one, other| other.area.total_cmp(&one.area));
    parts.truncate(PARTS);
    Support { threshold, parts }
}

/// A triangle's area, centre and distance from known parts.
#[derive(Clone, Copy)]
struct Measured {
    area: f64,
    center: DVec3,
    distance: f64,
}

fn measured(mesh: &Mesh, evidence: &Evidence) -> Vec<Measured> {
    let numbers: Vec<usize> = (0..mesh.triangles.len()).collect();
    let together = |numbers: &[usize]| {
        let centers: Vec<DVec3> = numbers
            .iter()
            .map(|&triangle| mesh.corners(triangle).into_iter().sum::<DVec3>() / 3.0)
            .collect();
        let middle = centers.iter().sum::<DVec3>() / centers.len() as f64;
        let radius = centers.iter().map(|center| center.distance(middle)).fold(0.0, f64::max);
        let near = evidence.near(middle, radius);
        let measure = |(&triangle, center): (&usize, DVec3)| {
            let [a, b, c] = mesh.corners(triangle);
            let distance = near.distance(center).unwrap_or(0.0);
            Measured { area: (b - a).cross(c - a).length() / 2.0, center, distance }
        };
        numbers.iter().zip(centers).map(measure).collect::<Vec<_>>()
    };
    numbers.par_chunks(TOGETHER).flat_map_iter(together).collect()
}

/// The farthest triangles that together have [`SHARE`] of the area, and how far
/// the nearest of them is.
fn farthest(triangles: &[Measured]) -> (f64, Vec<u32>) {
    let mut order: Vec<u32> = (0..triangles.len() as u32).collect();
    let distance = |triangle: u32| triangles[triangle as usize].distance;
    order.par_sort_by(|&one, &other| distance(other).total_cmp(&distance(one)));
    let mut left = SHARE * triangles.iter().map(|triangle| triangle.area).sum::<f64>();
    let enough = order.iter().position(|&triangle| {
        left -= triangles[triangle as usize].area;
        left <= 0.0
    });
    order.truncate(enough.map_or(0, |last| last + 1));
    (order.last().map_or(0.0, |&last| distance(last)), order)
}

/// Triangles that share a vertex belong to one part.
fn connected_parts(mesh: &Mesh, triangles: &[Measured], weak: &[u32]) -> Vec<Part> {
    let mut sets = Sets::new(mesh.vertices.len());
    for &triangle in weak {
        let [a, b, c] = mesh.triangles[triangle as usize];
        sets.join(a, b);
        sets.join(b, c);
    }
    let mut parts: BTreeMap<u32, Part> = BTreeMap::new();
    for &triangle in weak {
        let Measured { area, center, distance } = triangles[triangle as usize];
        let root = sets.root(mesh.triangles[triangle as usize][0]);
        let nothing = Part { area: 0.0, at: [0.0; 3], distance: 0.0, labels: Vec::new() };
        let part = parts.entry(root).or_insert(nothing);
        part.area += area;
        part.at = (DVec3::from(part.at) + area * center).to_array();
        part.distance = part.distance.max(distance);
        let sides = mesh.sides[triangle as usize];
        part.labels.extend(sides.iter().filter(|side| side.is_material()).map(|side| side.0));
        part.labels.sort_unstable();
        part.labels.dedup();
    }
    let centred = |mut part: Part| {
        part.at = part.at.map(|sum| sum / part.area.max(f64::MIN_POSITIVE));
        part
    };
    parts.into_values().map(centred).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::check::shapes::section;
    use crate::label::Label;
    use crate::mesh::shapes::solid;
    use crate::plane::Plane;

    fn plane(z: f64) -> Section {
        section(Plane { normal: DVec3::Z, offset: z }, &[], Label::OUTSIDE)
    }

    #[test]
    fn the_cap_beyond_the_last_section_is_found() {
        // A ball of radius 0.8 and sections up to z = 0.4: its top is up to
        // 0.4 from them, and everything else at most 0.2.
        let ball = solid(61, 1.0, |point| 0.8 - point.length());
        let sections = [-0.8, -0.4, 0.0, 0.4].map(plane);
        let Support { threshold, parts } = support(&ball, &sections, 2.0 / 60.0);
        let [top] = &parts[..] else { panic!("{parts:?}") };
        // A zone of a sphere has the area 2 π r h: a twentieth has h = r / 10.
        let area = 0.05 * 4.0 * std::f64::consts::PI * 0.64;
        assert!((top.area / area - 1.0).abs() < 0.02, "{}", top.area);
        assert!((threshold - (0.72 - 0.4)).abs() < 0.005, "{threshold}");
        assert!((top.distance - 0.4).abs() < 0.005, "{}", top.distance);
        assert!(DVec3::from(top.at).abs_diff_eq(DVec3::Z * 0.76, 0.005), "{:?}", top.at);
        assert_eq!(top.labels, [1]);
    }

    #[test]
    fn the_larger_of_two_parts_comes_first() {
        let ball = solid(61, 1.0, |point| 0.8 - point.length());
        // The poles are 0.35 and 0.34 from the sections, all else at most 0.225:
        // the twentieth are two zones whose edges are equally far, 2 π r h each,
        // with heights that add up to 0.08 and differ by 0.01.
        let sections = [-0.45, 0.0, 0.46].map(plane);
        let parts = support(&ball, &sections, 2.0 / 60.0).parts;
        let [bottom, top] = &parts[..] else { panic!("{parts:?}") };
        assert!(bottom.at[2] < -0.7 && top.at[2] > 0.7);
        assert!((bottom.area / top.area - 0.045 / 0.035).abs() < 0.1);
    }

    #[test]
    fn where_sections_leave_no_room_nothing_is_listed() {
        let voxel = 2.0 / 30.0;
        let ball = solid(31, 1.0, |point| 0.8 - point.length());
        let sections: Vec<Section> =
            (-14..=14).map(|layer| plane(f64::from(layer) * voxel)).collect();
        let support = support(&ball, &sections, voxel);
        assert!(support.threshold <= voxel / 2.0 + 0.3 * voxel && support.parts.is_empty());
        assert_eq!(super::support(&Mesh::default(), &sections, voxel), Support::default());
    }
}
