//! Borders that were traced from both sides, with errors from rounding up: they are one border,
//! in every format.

use std::path::Path;

use transect::io::{contour, csl, json};
use transect::label::Label;
use transect::section::{Region, Rules, Section, Sections};

use crate::random::Random;
use crate::{Reader, edges};

/// A patchwork of 4 × 4 quadrilaterals with labels, each corner inside moved a little.
struct Patchwork {
    corners: Vec<[f64; 2]>,
    labels: Vec<u32>,
}

impl Patchwork {
    fn new(random: &mut Random) -> Self {
        let mut corner = |i: usize| {
            let [x, y] = [i % 5, i / 5].map(|step| match step {
                1..=3 => step as f64 + random.between(-0.3..0.3),
                end => end as f64,
            });
            [10.0 * x, 10.0 * y]
        };
        let corners = (0..25).map(&mut corner).collect();
        Self { corners, labels: (0..16).map(|_| random.below(4) as u32).collect() }
    }

    /// The corners of a piece by number, counter-clockwise.
    fn piece(piece: usize) -> [usize; 4] {
        let first = piece / 4 * 5 + piece % 4;
        [first, first + 1, first + 6, first + 5]
    }

    /// A corner as somebody else traced it. On the slanted plane x = 1 + y / 2.
    fn traced(&self, corner: usize, off: f64, random: &mut Random) -> String {
        let [y, z] = self.corners[corner].map(|own| own + off * random.between(-1.0..1.0));
        format!("{:?} {y:?} {z:?}", 1.0 + 0.5 * y)
    }

    /// Every piece traced for itself.
    fn loops(&self, off: f64, random: &mut Random) -> Vec<(u32, Vec<String>)> {
        let mut corners = |piece| Self::piece(piece).map(|corner| self.traced(corner, off, random));
        (0..16)
            .filter(|&piece| self.labels[piece] > 0)
            .map(|piece| (self.labels[piece], corners(piece).to_vec()))
            .collect()
    }

    fn csl(&self, off: f64, random: &mut Random) -> String {
        let loops = self.loops(off, random);
        let mut text = format!("CSLC\n1 3\n1 {} {} 1 -0.5 0 -1\n", 4 * loops.len(), loops.len());
        loops.iter().for_each(|(_, corners)| text += &format!("{}\n", corners.join("\n")));
        for (number, (label, _)) in loops.iter().enumerate() {
            let first = 4 * number;
            text += &format!("4 {label} {first} {} {} {}\n", first + 1, first + 2, first + 3);
        }
        text
    }

    fn json(&self, off: f64, random: &mut Random) -> String {
        let point = |own: &String| format!("[{}]", own.replace(' ', ", "));
        let points = |own: &[String]| own.iter().map(point).collect::<Vec<_>>().join(", ");
        let loops: Vec<String> = (self.loops(off, random).iter())
            .map(|(label, own)| format!(r#"{{"label": {label}, "points": [{}]}}"#, points(own)))
            .collect();
        let frame = [0, 4, 24, 20].map(|corner| self.traced(corner, 0.0, random));
        format!(
            r#"{{"transect": "sections", "version": 1, "sections": [{{"normal": [1, -0.5, 0],
                "offset": 1, "extent": [{}], "loops": [{}]}}]}}"#,
            points(&frame),
            loops.join(", ")
        )
    }

    /// Every edge traced for itself.
    fn contour(&self, off: f64, random: &mut Random) -> String {
        let (mut points, mut edges) = (Vec::new(), Vec::new());
        for piece in 0..16 {
            let (corners, own) = (Self::piece(piece), self.labels[piece]);
            let (column, row) = (piece % 4, piece / 4);
            let beyond = [row > 0, column < 3, row < 3, column > 0];
            let others = [piece.wrapping_sub(4), piece + 1, piece + 4, piece.wrapping_sub(1)];
            for side in 0..4 {
                let other = if beyond[side] { self.labels[others[side]] } else { 0 };
                // A border between two pieces is traced once.
                if own != other && (others[side] > piece || !beyond[side]) {
                    edges.push(format!("{} {} {own} {other}", points.len(), points.len() + 1));
                    let ends = [side, (side + 1) % 4].map(|end| corners[end]);
                    points.extend(ends.map(|corner| self.traced(corner, off, random)));
                }
            }
        }
        let counts = format!("{} {}", points.len(), edges.len());
        format!("1\n1 -0.5 0 1\n{counts}\n{}\n{}\n", points.join("\n"), edges.join("\n"))
    }
}

/// The bounded regions: labels, corners of the outer boundary, holes; and the areas.
fn partition(section: &Section) -> (Vec<(Label, usize, usize)>, Vec<f64>) {
    let mut regions = section.regions().expect("regions");
    regions.retain(|region| region.outer.is_some());
    regions.sort_by(|a, b| a.area.total_cmp(&b.area));
    let shape = |region: &Region| {
        (region.label, region.outer.as_ref().map_or(0, Vec::len), region.holes.len())
    };
    (regions.iter().map(shape).collect(), regions.iter().map(|region| region.area).collect())
}

#[test]
fn traced_borders_give_one_partition_in_every_format() {
    type Text = fn(&Patchwork, f64, &mut Random) -> String;
    let formats: [(Text, Reader); 3] = [
        (Patchwork::csl, csl::read),
        (Patchwork::json, json::read),
        (Patchwork::contour, contour::read),
    ];
    let mut random = Random::new(0x51_1e55);
    // Relative to a diagonal of about 70.
    let rules = Rules { strict: true, ..Rules::default() };
    for _ in 0..12 {
        let patchwork = Patchwork::new(&mut random);
        for (text, read) in formats {
            let mut section = |off: f64| {
                let text = text(&patchwork, off, &mut random);
                let mut sections = read(&text, Path::new("traced"), &rules)
                    .unwrap_or_else(|error| panic!("{off:e}: {error}\n{text}"));
                assert!(sections.left_out.is_empty(), "{:?}", sections.left_out);
                sections.sections.remove(0)
            };
            let (shapes, areas) = partition(&section(0.0));
            for off in [1e-16, 1e-14, 1e-12, 1e-10, 1e-9].map(|share| 70.0 * share) {
                let traced = section(off);
                let (traced_shapes, traced_areas) = partition(&traced);
                assert_eq!(traced_shapes, shapes, "{off:e}");
                let near = |(one, other): (&f64, &f64)| (one - other).abs() < 1e-5;
                assert!(traced_areas.iter().zip(&areas).all(near));
                // What was snapped stays.
                let again = json::read(&written(&traced), Path::new("again"), &rules).unwrap();
                assert!(again.notes.is_empty(), "{:?}", again.notes);
                assert_eq!(edges(&again.sections[0]), edges(&traced));
            }
        }
    }
}

fn written(section: &Section) -> String {
    let mut text = Vec::new();
    let sections = Sections { sections: vec![section.clone()], ..Sections::default() };
    json::write(&sections, &mut text).unwrap();
    String::from_utf8(text).unwrap()
}
