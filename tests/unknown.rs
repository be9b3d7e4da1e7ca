//! What becomes of unknown regions: noise stays local, and neighbouring
//! sections say what is there (Bermano, Figs. 10 and 11).

use std::path::Path;

use transect::change::Change;
use transect::check::Check;
use transect::context::Context;
use transect::field::hermite;
use transect::grid::lattice::Resolution;
use transect::io::{json, read_sections};
use transect::label::Label;
use transect::mesh::facts::Facts;
use transect::method::{Hermite, MeanValue, Method};
use transect::model::{Model, Options};
use transect::section::{Rules, Section, Sections};

/// Reconstructs sections given as the entries of our JSON format.
fn reconstruct(sections: &[String], voxels: u32) -> Check {
    reconstruct_by(Method::MeanValue(MeanValue::default()), sections, voxels)
}

fn reconstruct_by(method: Method, sections: &[String], voxels: u32) -> Check {
    let sections = sections.join(",\n");
    let text = format!(r#"{{"transect": "sections", "version": 1, "sections": [{sections}]}}"#);
    let rules = Rules::default();
    let sections = json::read(&text, Path::new("test"), &rules).expect("sections");
    let options = Options { method, resolution: Resolution::Voxels(voxels), ..Options::default() };
    let mut model = Model::new(options);
    let mut context = Context::default();
    model.apply(Change::Add(sections), &mut context).expect("it reconstructs");
    let check = model.check(&mut context).expect("it can be checked");
    assert!(check.is_sound());
    check
}

fn facts(check: &Check, label: u32) -> &Facts {
    &check.labels.iter().find(|found| found.label == label).expect("the label occurs").facts
}

/// A loop on z = `height`.
fn polygon(label: &str, height: f64, points: &[[f64; 2]]) -> String {
    let points: Vec<String> = points.iter().map(|[x, y]| format!("[{x}, {y}, {height}]")).collect();
    format!(r#"{{"label": {label}, "points": [{}]}}"#, points.join(", "))
}

fn square(label: &str, height: f64, [x, y]: [f64; 2], half: f64) -> String {
    let corners = [[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]];
    polygon(label, height, &corners.map(|[u, v]| [x + half * u, y + half * v]))
}

/// A regular polygon of 64 corners around (x, 0).
fn circle(height: f64, x: f64, radius: f64) -> String {
    let corner = |i: u32| {
        let (sin, cos) = (f64::from(i) * std::f64::consts::TAU / 64.0).sin_cos();
        [x + radius * cos, radius * sin]
    };
    polygon("1", height, &(0..64).map(corner).collect::<Vec<_>>())
}

fn flat(height: f64, loops: &[String]) -> String {
    let loops = loops.join(", ");
    format!(r#"{{"normal": [0, 0, 1], "offset": {height}, "loops": [{loops}]}}"#)
}

/// Two cylinders of radius 1 around x = ±2, with noise on the middle section.
fn cylinders(noise: &[String]) -> Check {
    let plain = |height: f64| vec![circle(height, -2.0, 1.0), circle(height, 2.0, 1.0)];
    let mut middle = plain(0.7);
    middle.extend_from_slice(noise);
    reconstruct(&[flat(0.0, &plain(0.0)), flat(0.7, &middle), flat(1.4, &plain(1.4))], 72)
}

#[test]
fn noise_between_two_cylinders_does_not_join_them() {
    let clean = cylinders(&[]);
    // Touches the circles in the points x = ±1, which are corners of theirs.
    let patch = [[-1.0, 0.0], [0.0, -0.5], [1.0, 0.0], [0.0, 0.5]];
    let noisy = cylinders(&[polygon(r#""unknown""#, 0.7, &patch)]);
    let [clean, noisy] = [&clean, &noisy].map(|check| facts(check, 1));
    for facts in [clean, noisy] {
        assert_eq!((facts.components, facts.genus), (2, 0), "{facts:?}");
    }
    let ratio = noisy.volume / clean.volume;
    assert!((ratio - 1.0).abs() < 0.02, "{ratio}");
}

#[test]
fn a_few_spots_do_not_outweigh_the_neighbouring_sections() {
    // Two large squares of label 1, and between them a section of which nothing
    // is known but four spots of label 2 (a hundredth of the squares' area).
    let wide = |height: f64| flat(height, &[square("1", height, [0.0, 0.0], 4.0)]);
    let spots = [[-2.0, -2.0], [2.0, -2.0], [2.0, 2.0], [-2.0, 2.0]];
    let mut vertices = Vec::new();
    let mut edges = Vec::new();
    for (spot, [x, y]) in spots.into_iter().enumerate() {
        for (i, [u, v]) in [[-0.2, -0.2], [0.2, -0.2], [0.2, 0.2], [-0.2, 0.2]].iter().enumerate() {
            vertices.push(format!("[{}, {}, 1]", x + u, y + v));
            let (start, end) = (4 * spot + i, 4 * spot + (i + 1) % 4);
            edges.push(format!(r#"[{start}, {end}, 2, "unknown"]"#));
        }
    }
    let middle = format!(
        r#"{{"normal": [0, 0, 1], "offset": 1, "vertices": [{}], "edges": [{}]}}"#,
        vertices.join(", "),
        edges.join(", ")
    );
    let check = reconstruct(&[wide(0.0), middle, wide(2.0)], 72);
    let (first, second) = (facts(&check, 1), facts(&check, 2));
    assert_eq!(second.components, 4, "{second:?}");
    assert_eq!(first.components - first.cavities, 1, "{first:?}");
    // The spots as wide as they are, through the whole slab, would be a
    // hundredth of it.
    let share = second.volume / (first.volume + second.volume);
    assert!(share < 0.02, "{share}");
}

/// A ring of radius 10 and 3 thick around z, in frames around its axis, as a probe that is turned
/// sees it: those that are opposite are on one plane but for rounding.
fn ring() -> Vec<String> {
    let frame = |number: u32| {
        let (sin, cos) = (f64::from(number) * std::f64::consts::TAU / 12.0).sin_cos();
        let points = |points: &mut dyn Iterator<Item = [f64; 2]>| {
            let point = |[out, up]: [f64; 2]| {
                let out = 10.0 + out;
                format!("[{}, {}, {up}]", out * cos, out * sin)
            };
            points.map(point).collect::<Vec<_>>().join(", ")
        };
        let circle = |corner: u32| {
            let (sin, cos) = (f64::from(corner) * std::f64::consts::TAU / 48.0).sin_cos();
            [3.0 * cos, 3.0 * sin]
        };
        let contour = points(&mut (0..48).map(circle));
        let corners = [[-4.5, -4.5], [4.5, -4.5], [4.5, 4.5], [-4.5, 4.5]];
        let extent = points(&mut corners.into_iter());
        format!(
            r#"{{"normal": [{}, {cos}, 0], "offset": 0,
                "loops": [{{"label": 1, "points": [{contour}]}}], "extent": [{extent}]}}"#,
            -sin
        )
    };
    (0..12).map(frame).collect()
}

#[test]
fn frames_keep_what_they_know_whatever_the_spacing() {
    let by_mean_value = |spacing| Method::MeanValue(MeanValue { spacing, ..MeanValue::default() });
    let by_hermite = |spacing| {
        let interpolation = hermite::Options { spacing, ..hermite::Options::default() };
        Method::Hermite(Hermite { interpolation, ..Hermite::default() })
    };
    let methods: [&dyn Fn(Option<f64>) -> Method; 2] = [&by_mean_value, &by_hermite];
    for (method, default) in methods.into_iter().zip([1.6, 0.8]) {
        let found = |spacing| {
            let check = reconstruct_by(method(spacing), &ring(), 48);
            // Opposite frames are one section.
            assert_eq!(check.dice.sections.len(), 6);
            let Facts { components, genus, .. } = *facts(&check, 1);
            assert_eq!((components, genus), (1, 1), "spacing {spacing:?}");
            check.dice.min.expect("there are contours")
        };
        let kept = found(None);
        assert!(kept > 0.985, "{kept}");
        for times in [0.25, 4.0, 20.0] {
            let dice = found(Some(times * default));
            assert!(dice > kept - 0.01, "{dice} at {times} times the spacing, {kept} at one");
        }
    }
}

/// Frames of a sweep know a part of their planes only, so all cells hang together through what
/// is unknown; still the last one costs less than all of them.
#[test]
fn one_more_frame_of_a_sweep_costs_less_than_all() {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("examples/sweep.json");
    let all = read_sections(&path, &Rules::default()).expect("the example");
    let (last, others) = all.sections.split_last().expect("frames");
    let part = |sections: &[Section]| Sections { sections: sections.to_vec(), ..all.clone() };
    let mvc = Method::MeanValue(MeanValue { smooth: 0.0, ..MeanValue::default() });
    // Of the variational field everything costs little more than what is near to the last frame.
    for (method, what, part_of_all) in
        [(mvc, "evaluations", 0.75), (Method::default(), "unknowns", 0.85)]
    {
        let resolution = Resolution::Voxels(128);
        let mut model =
            Model::new(Options { method, resolution, bounds: all.space(), ..Options::default() });
        let mut add = |sections: Sections| {
            let mut context = Context::default();
            model.apply(Change::Add(sections), &mut context).expect("it reconstructs");
            context.stages.count_of(what)
        };
        add(part(others));
        let of_last = add(part(std::slice::from_ref(last)));
        let mut context = Context::default();
        let mut once = Model::new(*model.options());
        once.apply(Change::Add(all.clone()), &mut context).expect("it reconstructs");
        let of_all = context.stages.count_of(what);
        let ratio = of_last as f64 / of_all as f64;
        assert!(ratio < part_of_all, "{of_last} {what} of {of_all}");
        // And it is the same surface.
        let volume = |model: &Model| -> f64 {
            let mesh = &model.derived().expect("a surface").mesh;
            all.materials.iter().map(|own| mesh.surface(Label(own.id)).volume()).sum()
        };
        let ratio = volume(&model) / volume(&once);
        assert!((ratio - 1.0).abs() < 1e-4, "{ratio}");
    }
}
