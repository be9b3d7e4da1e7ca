//! What nearly touches is made to touch, and nothing else moves.

use glam::DVec2;

use super::*;

/// The tolerance of the tests' drawings, whose diagonal is given as 10.
const NEAR: f64 = 1e-7;

/// Two layers whose common border both draw for themselves: the upper one's is moved by `off`.
fn layers(off: f64) -> [Loop; 2] {
    let border = [[0.0, 1.0], [1.0, 1.3], [2.0, 0.9], [3.0, 1.1], [4.0, 1.0]];
    let lower = border.iter().rev().copied().chain([[0.0, 0.0], [4.0, 0.0]]);
    let moved = border.iter().enumerate().map(|(i, &[x, y])| {
        let sign = if i % 2 == 0 { off } else { -off };
        [x + 0.3 * sign, y + sign]
    });
    let upper = moved.chain([[4.0, 2.0], [0.0, 2.0]]);
    [polygon(1, &lower.collect::<Vec<_>>()), polygon(2, &upper.collect::<Vec<_>>())]
}

#[test]
fn overlaps_and_gaps_below_the_tolerance_are_none() {
    let expected = clean(&layers(0.0));
    for off in [1e-15, 1e-11, 0.9 * NEAR, -1e-15, -1e-11, -0.9 * NEAR] {
        let (section, findings) = read(&layers(off), &Rules::default()).unwrap();
        assert_eq!(section, expected, "{off:e}");
        assert_eq!((findings.snapped, findings.snapping), (5, NEAR));
        assert!(findings.warnings.is_empty() && findings.left_out.is_empty());
        // Who asks for it has the drawing as it is.
        let exactly = Rules { snapping: Some(0.0), ..Rules::default() };
        assert_says(&error_of(read(&layers(off), &exactly)), &["overlap"]);
        let widely = Rules { snapping: Some(0.01), ..Rules::default() };
        assert_eq!(read(&layers(1e4 * off), &widely).unwrap().0, expected);
    }
    assert_says(&error_of(read(&layers(3.0 * NEAR), &Rules::default())), &["overlap"]);
}

#[test]
fn contours_beside_an_extent_are_on_it() {
    let extent = polygon(0, &[[0.0, 0.0], [4.0, 1.0], [4.0, 4.0], [0.0, 4.0]]).points;
    let within = |off: f64| {
        // Corners in two corners of the extent, one on a slanted side, one on an upright one.
        let shape = [[0.0, 4.0 - off], [off, off], [2.0, 0.5 + off], [4.0 - off, 3.0]];
        let shape = polygon(1, &shape);
        let (section, _) = read(std::slice::from_ref(&shape), &Rules::default()).unwrap();
        section.within(&extent, &[shape], 10.0, &Rules::default()).unwrap()
    };
    let (expected, _) = within(0.0);
    for off in [1e-16, 1e-9, -1e-9] {
        let (section, findings) = within(off);
        assert!(findings.warnings.is_empty(), "{:?}", findings.warnings);
        let size = |section: &Section| (section.vertices.len(), section.edges.len());
        assert_eq!(size(&section), size(&expected), "{off:e}");
        assert!((areas(&section)[0].1 - areas(&expected)[0].1).abs() < 1e-7);
        for own in &section.vertices {
            let near = |other: &DVec2| own.distance(*other) <= 2.0 * off.abs();
            assert_eq!(expected.vertices.iter().filter(|&other| near(other)).count(), 1, "{own}");
        }
        // The sides stay where they are: upright ones exactly.
        let on_side = section.vertices.iter().filter(|vertex| vertex.x == 4.0);
        assert_eq!(on_side.count(), 3);
    }
}

#[test]
fn chains_of_near_points_are_not_drawn_together() {
    // Points 0.6 tolerances apart, all around a square of 2.
    let count = 400;
    let step = 0.6 * NEAR;
    let side = f64::from(count) * step;
    let along = |from: [f64; 2], to: [f64; 2]| {
        (0..count).map(move |i| {
            let part = f64::from(i) / f64::from(count);
            [from[0] + part * (to[0] - from[0]), from[1] + part * (to[1] - from[1])]
        })
    };
    let corners = [[0.0, 0.0], [side, 0.0], [side, side], [0.0, side]];
    let points: Vec<[f64; 2]> =
        (0..4).flat_map(|i| along(corners[i], corners[(i + 1) % 4])).collect();
    let (section, findings) = read(&[polygon(1, &points)], &Rules::default()).unwrap();
    let area = areas(&section)[0].1;
    assert!((area / (side * side) - 1.0).abs() < 0.02, "{area:e}");
    // Every other point goes, and what is left stays.
    assert_eq!(findings.snapped, 800);
    let (again, findings) = again(&section);
    assert_eq!((again.vertices, findings.snapped), (section.vertices, 0));
}

/// A section's graph once more.
fn again(section: &Section) -> (Section, Findings) {
    let points: Vec<DVec3> = (0..section.vertices.len() as u32).map(|i| section.point(i)).collect();
    Section::from_graph("s", section.plane, &points, &section.edges, 10.0, &Rules::default())
        .unwrap()
}

#[test]
fn thin_parts_stay_and_what_is_thinner_goes() {
    let strip = |width: f64| polygon(1, &[[0.0, 0.0], [3.0, 0.0], [3.0, width], [0.0, width]]);
    let section = clean(&[strip(3.0 * NEAR)]);
    assert_eq!(section.vertices.len(), 4);
    for loops in [vec![strip(0.5 * NEAR)], vec![strip(0.5 * NEAR), polygon(2, &[[1.0, 1.0]])]] {
        let (section, findings) = read(&loops, &Rules::default()).unwrap();
        // It does not say that all is outside.
        assert_eq!((section.labels(), findings.is_void), (vec![Label::UNKNOWN], true));
        assert_says(&findings.left_out[0].what, &["loop 0", "encloses no area"]);
        assert_says(&findings.left_out[loops.len()].what, &["section is left out"]);
    }
    let (section, findings) = read(&[], &Rules::default()).unwrap();
    assert_eq!((section.labels(), findings.is_void), (vec![Label::OUTSIDE], false));
}

#[test]
fn slits_in_a_graph_close() {
    // 1 | 2 with a slit between, and one of two vertices within 2: a label that ends where it
    // begins is not there.
    let off = 0.5 * NEAR;
    let corners = [
        [0.0, 0.0],
        [1.0, 0.0],
        [1.0, 1.0],
        [0.0, 1.0],
        [1.0 + off, 0.0],
        [2.0, 0.0],
        [2.0, 1.0],
        [1.0 + off, 1.0],
        [1.3, 0.5],
        [1.6, 0.5],
        [1.3, 0.5 + off],
        [1.6, 0.5 + off],
    ];
    let points = polygon(0, &corners).points;
    let ring = |of: [u32; 4], left: u32, right: u32| {
        (0..4).map(move |i| Edge {
            start: of[i],
            end: of[(i + 1) % 4],
            left: Label(left),
            right: Label(right),
        })
    };
    let edges: Vec<Edge> = ring([0, 1, 2, 3], 1, 0)
        .chain(ring([4, 5, 6, 7], 2, 0))
        .chain(ring([8, 9, 11, 10], 0, 2))
        .collect();
    let (section, findings) =
        Section::from_graph("s", FLAT, &points, &edges, 10.0, &Rules::default()).unwrap();
    assert_valid(&section);
    assert_eq!((section.vertices.len(), section.edges.len(), findings.snapped), (6, 7, 4));
    let (exact, _) = Section::from_graph(
        "s",
        FLAT,
        &points,
        &edges,
        10.0,
        &Rules { snapping: Some(0.0), ..Rules::default() },
    )
    .unwrap();
    assert_eq!((exact.vertices.len(), exact.edges.len()), (12, 12));
}

#[test]
fn sections_of_one_plane_agree_up_to_the_tolerance() {
    let [lower, upper] = layers(1e-10);
    let first = named("first", FLAT, &[lower, upper]);
    let second = named("second", FLAT, &layers(0.0));
    let merged = Sections::new(vec![first, second], &Rules::default()).unwrap();
    assert_eq!((merged.sections.len(), merged.sections[0].edges.len()), (1, 10));
}

#[test]
fn vertices_beside_a_common_line_are_on_it() {
    let off = 1e-9;
    let flat = polygon(1, &[[off, 0.0], [2.0, 0.0], [2.0, 2.0], [-off, 2.0], [1.0, 1.0]]);
    let upright = Plane { normal: DVec3::new(-2.0, 0.0, 0.0), offset: 0.0 };
    let slanted = Plane { normal: DVec3::new(1.0, 1.0, 3.0), offset: 4.0 };
    let sections = |off: bool| {
        let mut loops = flat.clone();
        if !off {
            loops.points.iter_mut().for_each(|point| point.x = (point.x * 1e3).round() / 1e3);
        }
        let all =
            [named("flat", FLAT, &[loops]), named("b", upright, &[]), named("c", slanted, &[])];
        Sections::new(all.to_vec(), &Rules::default()).unwrap()
    };
    let (found, expected) = (sections(true), sections(false));
    assert_eq!(found.sections, expected.sections);
    assert_says(&found.notes[0].what, &["lines where planes meet", ": 2"]);
    assert!(expected.notes.is_empty());
}

/// A square of label `label` around (x, 0), at a height.
fn part(label: u32, x: f64, height: f64) -> Section {
    let points = [[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]]
        .map(|[dx, y]| DVec3::new(x + dx, y, height));
    let plane = Plane { normal: DVec3::Z, offset: height };
    let name = format!("{label} at {height}");
    Section::from_loops(
        &name,
        plane,
        &[Loop { points: points.to_vec(), label: Label(label), hole_of: None }],
        10.0,
        &Rules::default(),
    )
    .unwrap()
    .0
}

#[test]
fn structures_drawn_one_by_one_are_one_drawing() {
    let rules = Rules::default();
    let strict = Rules { strict: true, ..rules };
    let beside = [part(1, 0.0, 0.0), part(2, 3.0, 1e-4), part(1, 0.0, 2.0), part(2, 3.0, 2.0001)];
    let found = Sections::new(beside.to_vec(), &rules).unwrap();
    assert_eq!((found.sections.len(), found.warnings.len()), (2, 2));
    for section in &found.sections {
        assert_eq!(areas(section), [(Label(1), 4.0), (Label(2), 4.0)]);
    }
    assert_says(&found.warnings[0].what, &["section 1 at 0", "read as one drawing"]);
    let error = Sections::new(beside.to_vec(), &strict).unwrap_err().to_string();
    assert_says(&error, &["section 2 at 0.0001", "section 1 at 0"]);
    // What overlaps is not for us to settle.
    let across = [part(1, 0.0, 0.0), part(2, 1.0, 1e-4), part(1, 0.0, 2.0)];
    let found = Sections::new(across.to_vec(), &rules).unwrap();
    assert_eq!((found.sections.len(), found.warnings.len()), (3, 1));
    assert_says(&found.warnings[0].what, &["contradict each other", "area of 2.000e0"]);
    assert!(Sections::new(across.to_vec(), &strict).is_err());
    // Two views of one structure, and dense stacks, are as they are.
    let views = [part(1, 0.0, 0.0), part(1, 0.0, 1e-4), part(2, 3.0, 2.0)];
    let dense: Vec<Section> =
        (0..8).map(|i| part(1 + i / 4, 3.0 * f64::from(i / 4), 1e-3 * f64::from(i))).collect();
    for sections in [views.to_vec(), dense] {
        let found = Sections::new(sections.clone(), &strict).unwrap();
        assert_eq!(found.sections, sections);
    }
}
