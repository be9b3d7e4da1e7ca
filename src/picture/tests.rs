use glam::DVec2;

use super::*;
use crate::label::Material;
use crate::plane::Plane;
use crate::section::{Edge, Section};
use view::tests::{sphere, torus};

/// A circle on z = height.
fn circle(center: DVec2, radius: f64, height: f64, label: Label) -> Section {
    let count = 64u32;
    let point =
        |i: u32| center + radius * DVec2::from_angle(std::f64::consts::TAU * f64::from(i) / 64.0);
    Section {
        name: format!("z = {height}"),
        plane: Plane { normal: DVec3::Z, offset: height },
        vertices: (0..count).map(point).collect(),
        edges: (0..count)
            .map(|i| Edge { start: i, end: (i + 1) % count, left: label, right: Label::OUTSIDE })
            .collect(),
        background: Label::OUTSIDE,
        normals: Vec::new(),
    }
}

fn two_shapes() -> (Mesh, Sections) {
    let mut builder = torus(DVec3::ZERO, 2.0, 0.6, [Label(1), Label(0)]);
    builder.append(sphere(DVec3::new(0.0, 0.0, 0.3), 1.0, [Label(2), Label(0)]));
    let sections = vec![
        circle(DVec2::ZERO, 2.6, 0.0, Label(1)),
        circle(DVec2::ZERO, 1.0, 0.3, Label(2)),
        circle(DVec2::ZERO, 0.8, 0.9, Label(2)),
    ];
    (builder.mesh, Sections { sections, ..Sections::default() })
}

const SMALL: PictureOptions =
    PictureOptions { size: [320, 240], samples: 2, view: None, up: None, labels: None };

/// The part of the picture's pixels whose strongest channel is `channel`,
/// by a margin.
fn part(image: &RgbaImage, channel: usize) -> f64 {
    let is_strong = |pixel: &image::Rgba<u8>| {
        (0..3).all(|other| other == channel || pixel[channel] > pixel[other].saturating_add(25))
    };
    let count = image.pixels().filter(|&pixel| is_strong(pixel)).count();
    count as f64 / f64::from(image.width() * image.height())
}

#[test]
fn labels_appear_in_their_colours() {
    let (mesh, mut sections) = two_shapes();
    let material = |id, color| Material { id, name: format!("part {id}"), color };
    sections.materials = vec![material(1, [200, 40, 40]), material(2, [40, 40, 200])];
    let image = render(&mesh, &sections, &SMALL);
    assert!(part(&image, 0) > 0.15, "{}", part(&image, 0));
    assert!(part(&image, 2) > 0.05, "{}", part(&image, 2));
    assert!(part(&image, 1) < 0.01, "only an axis is green: {}", part(&image, 1));
}

#[test]
fn values_appear_in_the_colours_of_the_scale() {
    let (mesh, sections) = two_shapes();
    // The torus is far from something, the sphere is not.
    let torus = mesh.vertices.iter().map(|vertex| vertex.truncate().length() > 1.05);
    let values: Vec<f32> = torus.map(|far| if far { 3.0 } else { 0.0 }).collect();
    let image = render_values(&mesh, &values, "voxels", &sections, &SMALL);
    let none = render_values(&mesh, &[], "voxels", &sections, &SMALL);
    // Dark purple and light grey; a grey is nearly the same in all channels.
    let far = |image: &RgbaImage| {
        image.pixels().filter(|pixel| i32::from(pixel[0]) > i32::from(pixel[1]) + 30).count()
    };
    assert!(far(&image) > far(&none) + 5000, "{} {}", far(&image), far(&none));
}

/// A red ball on one side of the origin and a blue one opposite: from there,
/// the red one hides it.
fn red_before_blue(toward: DVec3) -> (Mesh, Sections) {
    let mut builder = sphere(toward, 0.9, [Label(1), Label(0)]);
    builder.append(sphere(-toward, 0.9, [Label(2), Label(0)]));
    let material = |id, color| Material { id, name: format!("ball {id}"), color };
    let materials = vec![material(1, [200, 40, 40]), material(2, [40, 40, 200])];
    (builder.mesh, Sections { materials, ..Sections::default() })
}

#[test]
fn bodies_are_seen_from_where_was_asked_for() {
    for (view, toward) in [
        ("front", DVec3::NEG_Y),
        ("back", DVec3::Y),
        ("left", DVec3::NEG_X),
        ("right", DVec3::X),
        ("top", DVec3::Z),
        ("bottom", DVec3::NEG_Z),
        ("-x", DVec3::NEG_X),
        ("back-right", DVec3::new(0.8, 0.8, 0.0)),
        ("1,2,-2", DVec3::new(1.0, 2.0, -2.0) / 3.0),
    ] {
        let (mesh, sections) = red_before_blue(toward);
        let view = Some(view.parse().expect(view));
        let image = render(&mesh, &sections, &PictureOptions { view: view.clone(), ..SMALL });
        // The ball is a circle over most of the height; of the other one there
        // is the dot in the legend and at most the blue axis.
        let parts = [0, 2].map(|channel| part(&image, channel));
        assert!(parts[0] > 0.3 && parts[1] < 0.01, "{view:?}: {parts:?}");
    }
}

#[test]
fn up_is_what_was_asked_for_or_what_the_sections_say() {
    // Red above blue along z, seen from the front.
    let (mesh, sections) = red_before_blue(DVec3::Z);
    let front = PictureOptions { view: Some(Viewpoint::Sides(vec![Side::Front])), ..SMALL };
    // The mean row of the red pixels, from 0 (top) to 1.
    let height = |sections: &Sections, options: &PictureOptions| {
        let image = render(&mesh, sections, options);
        let is_red = |pixel: &image::Rgba<u8>| pixel[0] > pixel[2].saturating_add(40);
        let rows: Vec<f64> = image
            .enumerate_pixels()
            .filter(|(_, _, pixel)| is_red(pixel))
            .map(|(_, row, _)| f64::from(row) / f64::from(image.height()))
            .collect();
        rows.iter().sum::<f64>() / rows.len() as f64
    };
    let usual = height(&sections, &front);
    let down = PictureOptions { up: Some(DVec3::NEG_Z), ..front.clone() };
    let inferior = Sections { frame: "LPI".to_owned(), ..sections.clone() };
    let stated = Sections { up: Some(DVec3::NEG_Z), ..sections.clone() };
    let turned = [height(&sections, &down), height(&inferior, &front), height(&stated, &front)];
    // The ball's middle is at a quarter, or at three quarters, of the shape.
    assert!(usual < 0.4, "{usual}");
    assert!(turned.iter().all(|&row| row > 0.6), "{turned:?}");
    // What is asked for goes before what the sections say.
    let up = PictureOptions { up: Some(DVec3::Z), ..front };
    assert_eq!(height(&stated, &up), usual);
}

#[test]
fn chosen_labels_are_drawn_alone_and_as_large_as_fits() {
    let (mesh, mut sections) = two_shapes();
    let material = |id, color| Material { id, name: format!("part {id}"), color };
    sections.materials = vec![material(1, [200, 40, 40]), material(2, [40, 40, 200])];
    let top = PictureOptions { view: Some("top".parse().expect("a view")), ..SMALL };
    let all = render(&mesh, &sections, &top);
    let ball = PictureOptions { labels: Some(vec![Label(2)]), ..top };
    let ball = render(&mesh, &sections, &ball);
    assert!(part(&all, 0) > 0.15 && part(&ball, 0) < 0.01, "{}", part(&ball, 0));
    // 1 over 2.6 of the radius: some 7 times the area when drawn alone.
    assert!(part(&ball, 2) > 4.0 * part(&all, 2), "{} {}", part(&ball, 2), part(&all, 2));
}

#[test]
fn labels_that_are_not_drawn_have_no_contours() {
    let (mesh, sections) = two_shapes();
    let ball = PictureOptions { labels: Some(vec![Label(2)]), ..SMALL };
    let mut without = sections.clone();
    without.sections.remove(0);
    assert_eq!(render(&mesh, &sections, &ball), render(&mesh, &without, &ball));
    without.sections.remove(0);
    assert_ne!(render(&mesh, &sections, &ball), render(&mesh, &without, &ball));
}

#[test]
fn any_size_will_do() {
    let (mesh, mut sections) = two_shapes();
    sections.materials = (1..9).map(|id| Material::numbered(Label(id))).collect();
    for size in [[16, 16], [16, 300], [300, 16], [1, 1]] {
        let image = render(&mesh, &sections, &PictureOptions { size, ..SMALL });
        assert_eq!(<[u32; 2]>::from(image.dimensions()), size);
        assert!(size == [1, 1] || image.pixels().any(|pixel| pixel[1] < 150), "{size:?}");
    }
}

#[test]
fn contours_darken_the_surface() {
    let (mesh, sections) = two_shapes();
    let dark = |sections: &Sections| {
        let image = render(&mesh, sections, &SMALL);
        image.pixels().filter(|pixel| pixel.0[..3].iter().all(|&c| c < 110)).count()
    };
    assert!(dark(&sections) > dark(&Sections::default()) + 100);
}

#[test]
fn the_number_of_threads_does_not_matter() {
    let (mesh, sections) = two_shapes();
    let with_threads = |count| {
        rayon::ThreadPoolBuilder::new()
            .num_threads(count)
            .build()
            .map(|pool| pool.install(|| render(&mesh, &sections, &SMALL)))
            .map_err(|error| error.to_string())
    };
    assert_eq!(with_threads(1), with_threads(5));
}

#[test]
fn nothing_gives_an_empty_picture_of_the_right_size() {
    let image = render(&Mesh::default(), &Sections::default(), &SMALL);
    assert_eq!(image.dimensions(), (320, 240));
    assert!(image.pixels().all(|pixel| pixel[3] == 255));
}

#[test]
fn a_picture_far_from_the_origin_looks_the_same() {
    // As with map coordinates: 500 km east.
    let (mut mesh, _) = two_shapes();
    let near = render(&mesh, &Sections::default(), &SMALL);
    mesh.vertices.iter_mut().for_each(|point| point.x += 500_000.0);
    let far = render(&mesh, &Sections::default(), &SMALL);
    let differing = near
        .pixels()
        .zip(far.pixels())
        .filter(|(a, b)| (0..3).any(|channel| a[channel].abs_diff(b[channel]) > 8));
    assert!(differing.count() < 20);
}

#[test]
fn the_written_file_is_that_picture() {
    let (mesh, sections) = two_shapes();
    let image = render(&mesh, &sections, &SMALL);
    let mut file = Vec::new();
    write_png(&image, &mut file).expect("writing to memory");
    let read = image::load_from_memory(&file).expect("a valid PNG").to_rgba8();
    assert_eq!(read, image);
}
