//! Sections that come and go: what remains is what would have been there without them.

use std::collections::BTreeMap;

use super::*;

/// A complex as text that does not depend on numbers: planes, outlines, labels and edges of
/// all facets, coordinates to 1e-9.
fn described(complex: &Complex) -> Vec<String> {
    // Zeros have no sign.
    let number = |number: f64| (number * 1e9).round() + 0.0;
    let point = |point: &DVec3| point.to_array().map(number);
    let sorted = |mut texts: Vec<String>| {
        texts.sort_unstable();
        texts.join(" ")
    };
    let facet = |facet: &Facet| {
        let plane = complex.planes()[facet.plane];
        let corners = facet.outline.iter().map(|corner| format!("{:?}", point(corner))).collect();
        let edges = facet.edges.iter().map(|edge| {
            let (start, end) = (point(&edge.start), point(&edge.end));
            format!("{start:?} {end:?} {:?} {:?}", edge.left, edge.right)
        });
        let is_inner = facet.cells.iter().all(Option::is_some);
        let (corners, edges) = (sorted(corners), sorted(edges.collect()));
        format!("{plane:?} {is_inner} {:?} {corners} {edges}", facet.labels)
    };
    let mut facets: Vec<String> = complex.facets().values().map(facet).collect();
    facets.push(format!("{} cells", complex.cells().count()));
    facets.sort_unstable();
    facets
}

/// Planes and rectangles that meet in all kinds of places, or in none that is special.
fn section(random: &mut Random, is_coarse: bool, index: usize) -> Section {
    let mut whole = |low: f64, high: f64| between(random, low, high + 1.0).floor();
    let mut normal = DVec3::new(whole(-2.0, 2.0), whole(-2.0, 2.0), whole(-1.0, 1.0));
    let offset = whole(-4.0, 4.0) / 2.0;
    if normal == DVec3::ZERO {
        normal = DVec3::X;
    }
    let min = [whole(-5.0, 2.0) / 4.0, whole(-5.0, 2.0) / 4.0];
    let max = min.map(|least| least + whole(1.0, 4.0) / 4.0);
    let background = if whole(0.0, 3.0) == 0.0 { Label::UNKNOWN } else { Label::OUTSIDE };
    let is_drawn = whole(0.0, 3.0) > 0.0;
    let plane = match is_coarse {
        true => Plane { normal, offset },
        false => plane_in(random, CENTERED),
    };
    let mut section = match is_drawn {
        true => drawn("drawn", plane, &[(&rectangle(min, max), 1 + index as u32 % 3)]),
        false => empty(plane),
    };
    section.edges.iter_mut().for_each(|edge| edge.right = background);
    Section { name: format!("section {index}"), background, ..section }
}

/// An editor with some sections, and their planes.
fn built(sections: &[&Section]) -> (Editor, Vec<u32>) {
    let mut editor = Editor::new(CENTERED, Label::OUTSIDE).unwrap();
    let planes = sections.iter().map(|section| editor.add(section).unwrap()).collect();
    editor.commit().unwrap();
    (editor, planes)
}

/// Sections on planes of their own.
fn sections(random: &mut Random, is_coarse: bool, count: usize) -> Vec<Section> {
    let mut editor = Editor::new(CENTERED, Label::OUTSIDE).unwrap();
    let drawn = (0..count).map(|index| section(random, is_coarse, index));
    drawn.filter(|section| editor.add(section).is_ok()).collect()
}

#[test]
fn sections_come_in_any_order_and_go_without_a_trace() {
    for round in 0..40 {
        let mut random = Random::new(round);
        let sections = sections(&mut random, round % 2 == 0, 3 + round as usize % 9);
        let mut kept: Vec<&Section> = sections.iter().collect();
        let (mut editor, planes) = built(&kept);
        let mut planes: BTreeMap<String, u32> =
            kept.iter().map(|section| section.name.clone()).zip(planes).collect();
        kept.reverse();
        assert_eq!(described(editor.complex()), described(built(&kept).0.complex()));
        while kept.len() > 1 {
            let gone = kept.remove(random.bits() as usize % kept.len());
            editor.remove(planes[&gone.name]).unwrap();
            editor.commit().unwrap();
            editor.assert_sane();
            let expected = described(built(&kept).0.complex());
            assert_eq!(described(editor.complex()), expected, "round {round}");
            // And back, every other time.
            if random.bits().is_multiple_of(2) {
                planes.insert(gone.name.clone(), editor.add(gone).unwrap());
                editor.commit().unwrap();
                editor.assert_sane();
                editor.remove(planes[&gone.name]).unwrap();
                editor.commit().unwrap();
                assert_eq!(described(editor.complex()), expected, "round {round}");
            }
        }
    }
}

#[test]
fn a_change_that_is_taken_back_leaves_nothing() {
    for round in 0..10 {
        let mut random = Random::new(100 + round);
        let sections = sections(&mut random, round % 2 == 0, 8);
        let kept: Vec<&Section> = sections[1..].iter().collect();
        let (mut editor, planes) = built(&kept);
        let before = format!("{:?}", editor.complex());
        editor.add(&sections[0]).unwrap();
        editor.remove(planes[0]).unwrap();
        editor.rollback();
        editor.assert_sane();
        assert_eq!(format!("{:?}", editor.complex()), before);
        // What is changed now concerns what it would have concerned without that.
        let touched = |editor: &mut Editor| {
            editor.add(&sections[0]).unwrap();
            editor.commit().unwrap()
        };
        assert_eq!(touched(&mut editor), touched(&mut built(&kept).0));
    }
}

#[test]
fn a_section_that_contradicts_itself_is_refused_and_leaves_nothing() {
    let plane = plane([0.0, 0.0, 1.0], 0.25);
    let square = rectangle([-0.5, -0.5], [0.5, 0.5]);
    let mut wrong = drawn("wrong", plane, &[(&square, 1)]);
    wrong.edges[2].left = Label(7);
    let across =
        [empty(super::plane([1.0, 0.0, 0.0], 0.1)), empty(super::plane([0.0, 1.0, 0.0], 0.1))];
    // On the lines of the others labels do not agree, and without others nobody notices: that
    // sections agree with themselves is promised by their making.
    let mut editor = Editor::new(CENTERED, Label::OUTSIDE).unwrap();
    for section in &across {
        editor.add(section).unwrap();
    }
    let error = editor.add(&wrong).unwrap_err().to_string();
    assert!(error.starts_with("section wrong: labels contradict each other at"), "{error}");
    // Nothing was committed yet: all of it goes.
    editor.rollback();
    editor.add(&across[0]).unwrap();
    editor.commit().unwrap();
    editor.assert_sane();
    assert_eq!(described(editor.complex()), described(built(&[&across[0]]).0.complex()));
    editor.add(&across[1]).unwrap();
    editor.add(&wrong).unwrap_err();
    editor.rollback();
    editor.assert_sane();
    assert_eq!(described(editor.complex()), described(built(&[&across[0]]).0.complex()));
}

#[test]
fn a_section_is_drawn_anew_in_its_place() {
    let plane = plane([0.0, 0.0, 1.0], 0.25);
    let first = drawn("first", plane, &[(&rectangle([-0.5, -0.5], [0.5, 0.5]), 1)]);
    let other = drawn("other", plane, &[(&rectangle([-0.5, -0.5], [0.25, 0.75]), 2)]);
    let across = empty(super::plane([1.0, 0.0, 0.0], 0.1));
    let (mut editor, planes) = built(&[&first, &across]);
    editor.replace(planes[0], &other).unwrap();
    let touched = editor.commit().unwrap();
    editor.assert_sane();
    assert_eq!(described(editor.complex()), described(built(&[&other, &across]).0.complex()));
    // No cell came or went: two facets are drawn anew, and all four cells see one of them.
    assert_eq!((touched.cells.len(), touched.facets.len()), (4, 2));
    assert_eq!((touched.removed_cells.len(), touched.removed_facets.len()), (0, 0));
}

#[test]
fn what_a_plane_does_not_touch_keeps_its_number() {
    let mut random = Random::new(7);
    let planes: Vec<Section> = (0..30).map(|_| empty(plane_in(&mut random, CENTERED))).collect();
    let (mut editor, _) = built(&planes.iter().collect::<Vec<_>>());
    let before = editor.complex().clone();
    editor.add(&empty(plane_in(&mut random, CENTERED))).unwrap();
    let touched = editor.commit().unwrap();
    let after = editor.complex();
    let kept: Vec<_> =
        before.cells().iter().filter(|(id, _)| !touched.cells.contains(id)).collect();
    assert!(kept.iter().all(|&(id, cell)| after.cells()[id] == *cell));
    // One in ten at most is cut, and as many are beside a facet that is.
    assert!(kept.len() > before.cells().count() / 2, "{} touched", touched.cells.len());
    assert!(touched.removed_cells.is_empty());
}
