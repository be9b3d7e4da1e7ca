mod snapping;

use glam::DVec3;

use super::*;
use crate::error::Error;

/// z = 0, seen from above.
const FLAT: Plane = Plane { normal: DVec3::Z, offset: 0.0 };

fn polygon(label: u32, points: &[[f64; 2]]) -> Loop {
    let points = points.iter().map(|&[x, y]| DVec3::new(x, y, 0.0)).collect();
    Loop { points, label: Label(label), hole_of: None }
}

/// An axis-parallel square by its smallest corner and side.
fn square(label: u32, [x, y]: [f64; 2], side: f64) -> Loop {
    polygon(label, &[[x, y], [x + side, y], [x + side, y + side], [x, y + side]])
}

fn hole(parent: usize, mut polygon: Loop) -> Loop {
    polygon.hole_of = Some(parent);
    polygon
}

fn read(loops: &[Loop], rules: &Rules) -> Result<(Section, Findings)> {
    Section::from_loops("s", FLAT, loops, 10.0, rules)
}

/// Reads loops that must raise no doubts.
fn clean(loops: &[Loop]) -> Section {
    let (section, findings) = read(loops, &Rules::default()).unwrap();
    assert_eq!((&findings.warnings, &findings.left_out), (&vec![], &vec![]));
    assert_valid(&section);
    section
}

/// The documented invariant: reading the section's own graph gives it back.
fn assert_valid(section: &Section) {
    let points: Vec<DVec3> = (0..section.vertices.len() as u32).map(|i| section.point(i)).collect();
    let rules = Rules { strict: true, ..Rules::default() };
    let (again, findings) =
        Section::from_graph("s", section.plane, &points, &section.edges, 10.0, &rules).unwrap();
    assert_eq!(again.vertices, section.vertices);
    assert_eq!(again.edges, section.edges);
    assert!(findings.left_out.is_empty());
}

/// The area of every label but outside.
fn areas(section: &Section) -> Vec<(Label, f64)> {
    let mut areas = std::collections::BTreeMap::new();
    for region in section.regions().unwrap().iter().filter(|region| region.outer.is_some()) {
        *areas.entry(region.label).or_insert(0.0) += region.area;
    }
    areas.into_iter().filter(|&(label, _)| label != Label::OUTSIDE).collect()
}

fn error_of(result: Result<(Section, Findings)>) -> String {
    result.map(|_| ()).unwrap_err().to_string()
}

fn assert_says(text: &str, words: &[&str]) {
    for word in words {
        assert!(text.contains(word), "{text:?} does not say {word:?}");
    }
}

#[test]
fn orientation_of_a_loop_does_not_matter() {
    let forward = square(1, [0.0, 0.0], 2.0);
    let mut backward = forward.clone();
    backward.points.reverse();
    for section in [clean(&[forward]), clean(&[backward])] {
        assert_eq!(areas(&section), [(Label(1), 4.0)]);
        assert_eq!(section.edges.len(), 4);
        assert_eq!(section.background, Label::OUTSIDE);
    }
}

#[test]
fn a_hole_is_outside_whatever_its_label_says() {
    let loops = [square(1, [0.0, 0.0], 4.0), hole(0, square(7, [1.0, 1.0], 2.0))];
    let section = clean(&loops);
    assert_eq!(areas(&section), [(Label(1), 12.0)]);
    assert_eq!(section.labels(), [Label::OUTSIDE, Label(1)]);
}

#[test]
fn other_loops_fill_holes() {
    // Label 2 fills the hole of label 1, sharing all its edges; label 1 has an
    // island in the hole of label 2.
    let loops = [
        square(1, [0.0, 0.0], 5.0),
        hole(0, square(1, [1.0, 1.0], 3.0)),
        square(2, [1.0, 1.0], 3.0),
        hole(2, square(2, [2.0, 2.0], 1.0)),
        square(1, [2.0, 2.0], 1.0),
    ];
    let section = clean(&loops);
    assert_eq!(areas(&section), [(Label(1), 17.0), (Label(2), 8.0)]);
    assert_eq!((section.vertices.len(), section.edges.len()), (12, 12));
}

#[test]
fn holes_in_holes_of_one_loop_are_islands_in_turn() {
    // Squares around (4, 4), with sides 8, 6, 4, and 2; the last three holes of the first.
    let nested = |count: usize| -> Vec<Loop> {
        let own = (0..count).map(|i| (i as f64, square(1, [i as f64; 2], 8.0 - 2.0 * i as f64)));
        own.map(|(i, square)| if i > 0.0 { hole(0, square) } else { square }).collect()
    };
    for (count, area, islands) in [(2, 64.0 - 36.0, 0), (3, 44.0, 1), (4, 40.0, 1)] {
        let (section, findings) = read(&nested(count), &Rules::default()).unwrap();
        assert_valid(&section);
        assert_eq!(areas(&section), [(Label(1), area)]);
        assert_eq!(findings.warnings.len(), islands);
        if let [warning] = &findings.warnings[..] {
            assert_says(&warning.what, &["loops 2 and 1", "holes of loop 0", "island"]);
        }
    }
    // In another order it is the same, and holes that are alike or overlap in part are holes.
    let mut turned = nested(3);
    turned.swap(1, 2);
    assert_eq!(areas(&read(&turned, &Rules::default()).unwrap().0), [(Label(1), 44.0)]);
    let twice = [
        square(1, [0.0; 2], 8.0),
        hole(0, square(1, [1.0; 2], 2.0)),
        hole(0, square(1, [1.0; 2], 2.0)),
    ];
    assert_eq!(areas(&clean(&twice)), [(Label(1), 60.0)]);
    let aside = [
        square(1, [0.0; 2], 8.0),
        hole(0, square(1, [1.0; 2], 2.0)),
        hole(0, square(1, [2.0; 2], 2.0)),
    ];
    assert_eq!(areas(&clean(&aside)), [(Label(1), 57.0)]);
}

#[test]
fn shared_edges_are_one_edge_between_two_labels() {
    // The second square has a vertex in the middle of the shared edge.
    let split = polygon(2, &[[1.0, 0.0], [2.0, 0.0], [2.0, 1.0], [1.0, 1.0], [1.0, 0.5]]);
    let section = clean(&[square(1, [0.0, 0.0], 1.0), split]);
    assert_eq!(areas(&section), [(Label(1), 1.0), (Label(2), 1.0)]);
    assert_eq!((section.vertices.len(), section.edges.len()), (7, 8));
    let between = |edge: &&Edge| edge.left.is_material() && edge.right.is_material();
    assert_eq!(section.edges.iter().filter(between).count(), 2);
}

#[test]
fn edges_inside_one_label_vanish() {
    let loops = [square(3, [0.0, 0.0], 1.0), square(3, [1.0, 0.0], 1.0)];
    let section = clean(&loops);
    assert_eq!(areas(&section), [(Label(3), 2.0)]);
    assert_eq!((section.vertices.len(), section.edges.len()), (6, 6));
}

#[test]
fn loops_may_touch_themselves_in_points_and_edges() {
    // Two triangles joined in a vertex, gone round in one sweep.
    let pinched =
        polygon(1, &[[0.0, 0.0], [2.0, 2.0], [4.0, 0.0], [4.0, 4.0], [2.0, 2.0], [0.0, 4.0]]);
    assert_eq!(areas(&clean(&[pinched])), [(Label(1), 8.0)]);
    // A square with a square hole, joined by a seam that is run both ways.
    let keyhole = polygon(
        1,
        &[
            [0.0, 0.0],
            [4.0, 0.0],
            [4.0, 4.0],
            [0.0, 4.0],
            [0.0, 0.0],
            [1.0, 1.0],
            [1.0, 3.0],
            [3.0, 3.0],
            [3.0, 1.0],
            [1.0, 1.0],
        ],
    );
    let section = clean(&[keyhole]);
    assert_eq!(areas(&section), [(Label(1), 12.0)]);
    assert_eq!(section.edges.len(), 8);
}

#[test]
fn a_checkerboard_keeps_four_regions() {
    let loops = [
        square(1, [0.0, 0.0], 1.0),
        square(1, [1.0, 1.0], 1.0),
        square(2, [1.0, 0.0], 1.0),
        square(2, [0.0, 1.0], 1.0),
    ];
    let section = clean(&loops);
    assert_eq!(areas(&section), [(Label(1), 2.0), (Label(2), 2.0)]);
    assert_eq!((section.vertices.len(), section.edges.len()), (9, 12));
    assert_eq!(section.regions().unwrap().len(), 5);
}

#[test]
fn a_proper_crossing_is_even_odd_and_told() {
    let bow = polygon(1, &[[0.0, 0.0], [2.0, 2.0], [2.0, 0.0], [0.0, 2.0]]);
    let (section, findings) = read(std::slice::from_ref(&bow), &Rules::default()).unwrap();
    assert_valid(&section);
    assert_eq!(areas(&section), [(Label(1), 2.0)]);
    assert_eq!((section.vertices.len(), section.edges.len()), (5, 6));
    assert_eq!(findings.warnings.len(), 1);
    assert_says(&findings.warnings[0].what, &["loop 0 crosses itself at [1, 1, 0]", "even-odd"]);
    let strict = error_of(read(&[bow], &Rules { strict: true, ..Rules::default() }));
    assert_says(&strict, &["section s", "loop 0", "[1, 1, 0]", "an error because warnings are"]);
}

#[test]
fn a_pentagram_has_a_hole_in_its_middle() {
    // All five crossings are irrational: they are rounded, and it still closes.
    let corner = |i: usize| {
        let angle = std::f64::consts::TAU * (2 * i) as f64 / 5.0;
        [angle.sin(), angle.cos()]
    };
    let star = polygon(1, &[corner(0), corner(1), corner(2), corner(3), corner(4)]);
    let (section, findings) = read(&[star], &Rules::default()).unwrap();
    assert_valid(&section);
    assert_says(&findings.warnings[0].what, &["and 4 more places"]);
    assert_eq!((section.vertices.len(), section.edges.len()), (10, 15));
    // The star without its middle, whose corners lie at radius 1/φ²: ten
    // triangles of the centre less the pentagon's five.
    let inner = (std::f64::consts::TAU / 5.0).cos() / (std::f64::consts::PI / 5.0).cos();
    let tips = 5.0 * inner * (std::f64::consts::PI / 5.0).sin();
    let middle = 2.5 * inner * inner * (std::f64::consts::TAU / 5.0).sin();
    assert!((areas(&section)[0].1 - (tips - middle)).abs() < 1e-12);
}

#[test]
fn degenerate_loops_are_left_out_and_listed() {
    let loops = [
        polygon(1, &[]),
        polygon(1, &[[5.0, 5.0]]),
        polygon(2, &[[0.0, 0.0], [1.0, 0.0], [0.0, 0.0]]),
        polygon(3, &[[0.0, 0.0], [1.0, 1.0], [3.0, 3.0], [2.0, 2.0]]),
        square(4, [0.0, 0.0], 1.0),
    ];
    let (section, findings) = read(&loops, &Rules::default()).unwrap();
    assert_valid(&section);
    assert_eq!(section.labels(), [Label::OUTSIDE, Label(4)]);
    assert_eq!(findings.left_out.len(), 4);
    assert_says(&findings.left_out[3].what, &["loop 3", "4 vertices", "encloses no area"]);
}

#[test]
fn overlapping_labels_need_a_winner() {
    let loops = [square(1, [0.0, 0.0], 3.0), square(2, [2.0, 0.0], 2.0)];
    let error = error_of(read(&loops, &Rules::default()));
    let place = "loops 0 (label 1) and 1 (label 2) overlap (area 2.000e0, near [";
    assert_says(&error, &["section s", place, "say who wins"]);
    for (overlap, expected) in
        [(Overlap::First, [9.0, 2.0]), (Overlap::Last, [7.0, 4.0]), (Overlap::Smallest, [7.0, 4.0])]
    {
        let rules = Rules { overlap: Some(overlap), ..Rules::default() };
        let (section, findings) = read(&loops, &rules).unwrap();
        assert_valid(&section);
        assert_eq!(areas(&section), [(Label(1), expected[0]), (Label(2), expected[1])]);
        assert_says(&findings.warnings[0].what, &[overlap.word(), "wins"]);
    }
}

#[test]
fn overlapping_loops_of_one_label_are_united() {
    let loops = [square(1, [0.0, 0.0], 3.0), square(1, [1.0, 1.0], 1.0)];
    let (section, findings) = read(&loops, &Rules::default()).unwrap();
    assert_eq!(areas(&section), [(Label(1), 9.0)]);
    assert_says(&findings.warnings[0].what, &["loops 0 and 1", "union", "hole"]);
}

#[test]
fn holes_need_an_outer_loop() {
    let outer = square(1, [0.0, 0.0], 3.0);
    let missing = [outer.clone(), hole(5, square(1, [1.0, 1.0], 1.0))];
    assert_says(&error_of(read(&missing, &Rules::default())), &["loop 1", "loop 5", "only 2"]);
    let nested =
        [outer.clone(), hole(0, square(1, [1.0, 1.0], 1.0)), hole(1, square(1, [1.25, 1.25], 0.5))];
    assert_says(&error_of(read(&nested, &Rules::default())), &["loop 2", "a hole itself"]);
    let stray = [outer, hole(0, square(1, [2.0, 2.0], 2.0))];
    let (section, findings) = read(&stray, &Rules::default()).unwrap();
    assert_eq!(areas(&section), [(Label(1), 8.0)]);
    assert_says(&findings.warnings[0].what, &["loop 1", "outside", "area 3.000e0"]);
}

#[test]
fn planes_and_points_are_checked() {
    let loops = [square(1, [0.0, 0.0], 1.0)];
    let rules = Rules::default();
    let zero = Plane { normal: DVec3::ZERO, offset: 0.0 };
    let error = error_of(Section::from_loops("s", zero, &loops, 1.0, &rules));
    assert_says(&error, &["section s", "zero normal"]);
    let endless = Plane { normal: DVec3::Z, offset: f64::NAN };
    assert_says(&error_of(Section::from_loops("s", endless, &loops, 1.0, &rules)), &["not finite"]);
    let mut bent = loops.clone();
    bent[0].points[2].z = 0.02;
    assert_says(&error_of(read(&bent, &rules)), &["vertex 2 of loop 0", "0.020000 off its plane"]);
    bent[0].points[2].z = 0.005;
    assert_eq!(read(&bent, &rules).unwrap().1.off_plane, 0.005);
    bent[0].points[2].z = f64::NAN;
    assert_says(&error_of(read(&bent, &rules)), &["vertex 2 of loop 0", "NaN"]);
}

#[test]
fn contradictory_graphs_are_refused() {
    let corners = [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]];
    let points: Vec<DVec3> = corners.iter().map(|&[x, y]| DVec3::new(x, y, 0.0)).collect();
    let edge = |start, end, left| Edge { start, end, left: Label(left), right: Label::OUTSIDE };
    let graph =
        |edges: &[Edge]| Section::from_graph("s", FLAT, &points, edges, 1.0, &Rules::default());
    let ring = [edge(0, 1, 1), edge(1, 2, 1), edge(2, 3, 1), edge(3, 0, 1)];
    assert_eq!(areas(&graph(&ring).unwrap().0), [(Label(1), 1.0)]);
    let mut mixed = ring;
    mixed[2].left = Label(2);
    assert_says(
        &error_of(graph(&mixed)),
        &["section s", "contradictory labels around vertex 2", "[1, 1, 0]"],
    );
    assert_says(&error_of(graph(&ring[..3])), &["contradictory"]); // open
    let turned = [edge(0, 1, 1), edge(2, 1, 1), edge(2, 3, 1), edge(3, 0, 1)];
    assert_says(&error_of(graph(&turned)), &["contradictory"]);
    assert_says(&error_of(graph(&[edge(0, 4, 1)])), &["edge 0", "vertex 4", "only 4"]);
}

#[test]
fn crossings_are_read_the_same_in_graphs_and_in_loops() {
    // A bow; and a square whose upper side doubles back over 0.4 and returns 0.2 higher, which
    // crosses the side once.
    let bow = [[0.0, 0.0], [2.0, 2.0], [2.0, 0.0], [0.0, 2.0]];
    let hooked =
        [[0.0, 0.0], [4.0, 0.0], [4.0, 4.0], [2.0, 4.0], [2.4, 3.9], [2.4, 4.1], [0.0, 4.0]];
    for corners in [&bow[..], &hooked] {
        let ring = polygon(1, corners);
        let (expected, told) = read(std::slice::from_ref(&ring), &Rules::default()).unwrap();
        let count = corners.len() as u32;
        let edge = |i| Edge { start: i, end: (i + 1) % count, left: Label(1), right: Label(0) };
        let edges: Vec<Edge> = (0..count).map(edge).collect();
        let graph = |rules| Section::from_graph("s", FLAT, &ring.points, &edges, 10.0, &rules);
        let (section, findings) = graph(Rules::default()).unwrap();
        assert_valid(&section);
        assert_eq!((areas(&section), section.background), (areas(&expected), Label::OUTSIDE));
        assert_eq!((findings.warnings.len(), told.warnings.len()), (1, 1));
        let (what, place) = (&findings.warnings[0].what, "crosses itself at [");
        let (own, other) = (what.find(place).unwrap(), told.warnings[0].what.find(place).unwrap());
        assert_eq!(what[own..], told.warnings[0].what[other..]);
        let strict = error_of(graph(Rules { strict: true, ..Rules::default() }));
        assert_says(&strict, &["section s", "label 1", "an error because warnings are"]);
    }
}

#[test]
fn an_extent_makes_the_rest_unknown() {
    let section = clean(&[square(1, [0.0, 0.0], 2.0)]);
    let extent = square(0, [-1.0, -1.0], 4.0).points;
    let (within, findings) = section.within(&extent, &[], 10.0, &Rules::default()).unwrap();
    assert!(findings.warnings.is_empty());
    assert_eq!(within.background, Label::UNKNOWN);
    assert_eq!(within.edges.len(), 8);
    assert_eq!(areas(&within), [(Label(1), 4.0)]);
    let small = square(0, [1.0, 1.0], 4.0).points;
    let (within, findings) = section.within(&small, &[], 10.0, &Rules::default()).unwrap();
    assert_eq!(areas(&within), [(Label(1), 1.0)]);
    // Three of the square's four units of area are beyond; its graph knows no loops.
    let told = "label 1 reaches beyond its extent (area 3.000e0, near [";
    assert_says(&findings.warnings[0].what, &[told, "that part is left out"]);
    assert_eq!(findings.warnings.len(), 1);
}

#[test]
fn loops_beyond_an_extent_are_named() {
    // Loops 0 and 3 cross the border x = 3, loop 4 lies beyond it, and the hole
    // in loop 3 hides nothing of it; loop 2 is inside.
    let loops = [
        square(2, [2.0, 0.0], 2.0),
        hole(3, square(1, [3.5, 3.5], 1.0)),
        square(1, [0.0, 0.0], 1.0),
        square(1, [2.0, 3.0], 2.5),
        square(1, [6.0, 0.0], 1.0),
    ];
    let section = clean(&loops);
    let extent = polygon(0, &[[-1.0, -1.0], [3.0, -1.0], [3.0, 9.0], [-1.0, 9.0]]).points;
    let (within, findings) = section.within(&extent, &loops, 10.0, &Rules::default()).unwrap();
    let told: Vec<&str> = findings.warnings.iter().map(|warning| warning.what.as_str()).collect();
    assert_eq!(told.len(), 2);
    // 1.5 × 2.5 less the hole's 1, and 1.
    assert_says(told[0], &["label 1 (loops 3, 4) reaches beyond its extent (area 3.750e0, near ["]);
    assert_says(told[1], &["label 2 (loop 0) reaches beyond its extent (area 2.000e0, near ["]);
    assert_eq!(areas(&within), [(Label(1), 3.5), (Label(2), 2.0)]);
    let strict = Rules { strict: true, ..Rules::default() };
    let error = error_of(section.within(&extent, &loops, 10.0, &strict));
    assert_says(&error, &["section s", "loops 3, 4", "an error because warnings are"]);
    // What means unknown may reach anywhere.
    let forgetful = Rules { unknown: Some(Label(1)), ..Rules::default() };
    let findings = section.within(&extent, &loops, 10.0, &forgetful).unwrap().1;
    assert_eq!(findings.warnings.len(), 1);
}

#[test]
fn an_extent_must_be_a_polygon_on_the_plane() {
    let section = clean(&[square(1, [0.0, 0.0], 2.0)]);
    let refused = |points: &[[f64; 2]], words: &[&str]| {
        let extent = polygon(0, points).points;
        let error = error_of(section.within(&extent, &[], 10.0, &Rules::default()));
        assert_says(&error, &["section s: its extent"]);
        assert_says(&error, words);
    };
    refused(&[[0.0, 0.0], [1.0, 0.0]], &["has 2 points", "needs three"]);
    refused(&[[0.0, 0.0], [1.0, 1.0], [3.0, 3.0]], &["encloses no area"]);
    let bow = [[0.0, 0.0], [2.0, 2.0], [2.0, 0.0], [0.0, 2.0]];
    refused(&bow, &["crosses itself at [1, 1, 0]", "order of its points"]);
    let mut off = square(0, [0.0, 0.0], 3.0).points;
    off[2].z = 0.5;
    let error = error_of(section.within(&off, &[], 10.0, &Rules::default()));
    assert_says(&error, &["vertex 2 of its extent at [3, 3, 0.5]", "0.500000 off its plane"]);
    // Touching itself is no crossing.
    let pinched = [[0.0, 0.0], [2.0, 2.0], [4.0, 0.0], [4.0, 4.0], [2.0, 2.0], [0.0, 4.0]];
    let extent = polygon(0, &pinched).points;
    let within = section.within(&extent, &[], 10.0, &Rules::default()).unwrap().0;
    assert_eq!(areas(&within), [(Label(1), 2.0)]);
}

#[test]
fn a_label_that_means_unknown_takes_its_edges_with_it() {
    // 1 | 2 | 3 side by side in the unknown: 2 goes, and with it all but the
    // borders of 1 and 3.
    let row = [square(1, [0.0, 0.0], 1.0), square(2, [1.0, 0.0], 1.0), square(3, [2.0, 0.0], 1.0)];
    let extent = square(0, [-1.0, -1.0], 5.0).points;
    let within = clean(&row).within(&extent, &[], 10.0, &Rules::default()).unwrap().0;
    let meaning = |rules: Rules| move |label| rules.meaning(label);
    let forget = |label| Rules { unknown: Some(Label(label)), ..Rules::default() };
    let section = within.clone().relabelled(meaning(forget(2)));
    assert_valid(&section);
    assert_eq!(areas(&section), [(Label(1), 1.0), (Label(3), 1.0), (Label::UNKNOWN, 1.0)]);
    assert_eq!(section.edges.len(), within.edges.len());
    // Outside goes: the extent's border and that between it and the rest.
    let section = within.relabelled(meaning(forget(0)));
    assert_valid(&section);
    assert_eq!((section.vertices.len(), section.edges.len()), (8, 10));
    assert_eq!(section.background, Label::UNKNOWN);
    let section = section.relabelled(|_| Label::UNKNOWN);
    assert_eq!((section.vertices.len(), section.edges.len()), (0, 0));
    let unknown = Sections::new(vec![section], &Rules::default()).unwrap();
    assert_says(&unknown.require_known().unwrap_err().to_string(), &["everything is unknown"]);
}

#[test]
fn sections_do_not_disagree_about_what_is_unknown() {
    // On the x axis: 1 from 0 to 2 and unknown beyond 1.5, against outside.
    let flat = named("flat", FLAT, &[square(1, [0.0, -1.0], 2.0)]);
    let extent = square(0, [-3.5, -2.0], 5.0).points;
    let flat = flat.within(&extent, &[], 10.0, &Rules::default()).unwrap().0;
    let wall = named("wall", Plane { normal: DVec3::Y, offset: 0.0 }, &[]);
    let found = Sections::new(vec![flat, wall], &Rules::default()).unwrap().disagreements();
    assert_eq!((found.len(), found[0].length, found[0].occupied), (1, 1.5, 1.5));
}

fn named(name: &str, plane: Plane, loops: &[Loop]) -> Section {
    Section::from_loops(name, plane, loops, 10.0, &Rules::default()).unwrap().0
}

#[test]
fn sections_of_one_plane_merge_or_are_refused() {
    let first = named("first", FLAT, &[square(1, [0.0, 0.0], 2.0)]);
    let below = Plane { normal: -3.0 * DVec3::Z, offset: 0.0 };
    let same = named("second", below, &[square(1, [0.0, 0.0], 2.0)]);
    let rules = Rules::default();
    let merged = Sections::new(vec![first.clone(), same], &rules).unwrap();
    assert_eq!(merged.sections, vec![first.clone()]);
    assert_eq!((merged.warnings.len(), merged.left_out.len()), (1, 1));
    let other = named("second", below, &[square(1, [0.0, 0.0], 1.0)]);
    let error = Sections::new(vec![first.clone(), other], &rules).unwrap_err().to_string();
    assert_says(&error, &["section second", "section first", "3.000e0", "near"]);
    assert!(matches!(Sections::new(vec![], &rules), Err(Error::Option(_))));
}

#[test]
fn two_frames_of_one_plane_complete_each_other() {
    // Each frame knows one half of a square of side 2.
    let whole = named("whole", FLAT, &[square(1, [0.0, 0.0], 2.0)]);
    let frame = |x: f64| square(0, [x, -1.0], 4.0).points;
    let rules = Rules::default();
    let [left, right] = [-3.0, 1.0].map(|x| whole.within(&frame(x), &[], 10.0, &rules).unwrap().0);
    assert_eq!(areas(&left), [(Label(1), 2.0)]);
    let both = Sections::new(vec![left, right], &rules).unwrap();
    assert_eq!(both.sections.len(), 1);
    assert_eq!(areas(&both.sections[0]), [(Label(1), 4.0)]);
    assert_eq!(both.sections[0].background, Label::UNKNOWN);
}

#[test]
fn frames_of_one_plane_but_for_rounding_are_merged_if_they_agree() {
    let rules = Rules::default();
    let frame = |x: f64| square(0, [x, -1.0], 4.0).points;
    let within = |plane: Plane, side: f64, x: f64| {
        let whole = named("whole", plane, &[square(1, [0.0, 0.0], side)]);
        whole.within(&frame(x), &[], 10.0, &rules).unwrap().0
    };
    // Half a turn further, as sines and cosines have it, and a tilt that is none of rounding.
    let turned = |tilt: f64| Plane { normal: DVec3::new(tilt, 0.0, -1.0), offset: 0.0 };
    let left = within(FLAT, 2.0, -3.0);
    let both =
        Sections::new(vec![left.clone(), within(turned(1.2e-16), 2.0, 1.0)], &rules).unwrap();
    assert_eq!(both.sections.len(), 1);
    assert_eq!(areas(&both.sections[0]), [(Label(1), 4.0)]);
    assert_says(&both.warnings[0].what, &["but for rounding", "merged"]);
    let apart = |other: Section| Sections::new(vec![left.clone(), other], &rules).unwrap();
    assert_eq!(apart(within(turned(1e-5), 2.0, 1.0)).sections.len(), 2);
    // What overlaps and says something else, and what knows all of its plane, stay.
    assert_eq!(apart(within(turned(1.2e-16), 1.0, 0.0)).sections.len(), 2);
    assert_eq!(
        apart(named("all", turned(1.2e-16), &[square(1, [0.0, 0.0], 2.0)])).sections.len(),
        2
    );
}

#[test]
fn disagreement_is_measured_along_common_lines() {
    // On the x axis: material 1 from 0 to 2, against 1 from 0.5 to 3.
    let flat = named("flat", FLAT, &[square(1, [0.0, -1.0], 2.0)]);
    let upright = Plane { normal: DVec3::Y, offset: 0.0 };
    let points = [[0.5, -1.0], [3.0, -1.0], [3.0, 1.0], [0.5, 1.0]];
    let points = points.iter().map(|&[x, z]| DVec3::new(x, 0.0, z)).collect();
    let wall = named("wall", upright, &[Loop { points, label: Label(1), hole_of: None }]);
    let both = Sections::new(vec![flat, wall], &Rules::default()).unwrap();
    let found = both.disagreements();
    assert_eq!(found.len(), 1);
    assert_eq!((found[0].length, found[0].occupied, found[0].worst_length), (1.5, 3.0, 1.0));
    assert_eq!(found[0].worst, [2.5, 0.0, 0.0]);
    assert_eq!(found[0].labels, ["outside", "1"]);
}

#[test]
fn contours_far_from_the_origin_lose_nothing() {
    // UTM metres: neighbours that differ in the last place stay apart.
    let (east, north) = (500_000.125, 5_400_000.25);
    let step = north * f64::EPSILON;
    let loops =
        [square(1, [east, north], 100.0), square(1, [east, north + 100.0 + 2.0 * step], 50.0)];
    let plane = Plane { normal: DVec3::new(0.0, 0.0, 2.0), offset: 0.0 };
    let exactly = Rules { snapping: Some(0.0), ..Rules::default() };
    let section = Section::from_loops("s", plane, &loops, 150.0, &exactly).unwrap().0;
    assert_eq!(section.regions().unwrap().len(), 3);
    assert_eq!(section.vertices[0].to_array(), [east, north]);
    assert_eq!(areas(&section)[0].1.round(), 12_500.0);
}
