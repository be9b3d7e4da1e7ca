//! The exact reconstruction with partial sections: every label is closed and in
//! one piece, and nearly everywhere the label is that of the nearest known point.

use glam::DVec3;
use transect::label::Label;
use transect::mesh::Mesh;
use transect::plane::{Bounds, Plane};
use transect::progress::Silent;
use transect::section::{Loop, Overlap, Rules, Section};
use transect::skeleton::{Options, Skeleton, skeleton};

const BOX: Bounds = Bounds { min: DVec3::splat(-1.5), max: DVec3::splat(1.5) };

/// A plane through `origin` along `across` and `along`.
struct Frame {
    origin: DVec3,
    across: DVec3,
    along: DVec3,
}

fn flat(height: f64) -> Frame {
    Frame { origin: DVec3::Z * height, across: DVec3::X, along: DVec3::Y }
}

impl Frame {
    /// Nothing is known but within the loops.
    fn section(&self, loops: &[(Label, Vec<[f64; 2]>)]) -> Section {
        let around = (Label::UNKNOWN, rectangle([-9.0, 9.0], [-9.0, 9.0]));
        let place = |[u, v]: [f64; 2]| self.origin + u * self.across + v * self.along;
        let loops: Vec<Loop> = std::iter::once(&around)
            .chain(loops)
            .map(|(label, points)| Loop {
                points: points.iter().copied().map(place).collect(),
                label: *label,
                hole_of: None,
            })
            .collect();
        let normal = self.across.cross(self.along);
        let plane = Plane { normal, offset: normal.dot(self.origin) };
        // Loops lie on what is unknown, and on each other.
        let rules = Rules { overlap: Some(Overlap::Last), ..Rules::default() };
        Section::from_loops("partial", plane, &loops, 3.0, &rules).expect("a section").0
    }
}

fn rectangle([x0, x1]: [f64; 2], [y0, y1]: [f64; 2]) -> Vec<[f64; 2]> {
    vec![[x0, y0], [x1, y0], [x1, y1], [x0, y1]]
}

/// The same each time, whatever thread comes first.
fn reconstruct(sections: &[Section]) -> Skeleton {
    let once = || skeleton(sections, BOX, &Options::default(), &Silent).expect("a skeleton");
    let result = once();
    for _ in 0..3 {
        assert!(once() == result);
    }
    assert!(result.details.left_out.is_empty() && result.details.inexact.is_empty());
    assert_eq!(result.details.exact_share, 1.0);
    result
}

/// The label is one body without handles; its volume.
fn body(mesh: &Mesh, label: u32) -> f64 {
    let facts = mesh.surface(Label(label)).facts(true).expect("facts");
    assert!(facts.closed && facts.outward, "label {label}: {facts:?}");
    assert_eq!((facts.components, facts.genus), (1, 0), "label {label}");
    assert_eq!(facts.self_intersections, Some(0), "label {label}");
    mesh.surface(Label(label)).volume()
}

/// Two sections that know all of their planes contradict each other along the line in which
/// these meet: every cell around it has surfaces that end on it, and a partial section ends
/// some of them in a point that the others have to know.
#[test]
fn beside_sections_that_contradict_each_other() {
    let along = |normal: DVec3, offset: f64, points: &[[f64; 3]]| {
        let points = points.iter().copied().map(DVec3::from_array);
        let builder = Section::builder("whole", Plane { normal, offset });
        builder.region(Label(1), points).build(&Rules::default()).expect("a section").0
    };
    let square = [[-0.8, -0.8, 0.25], [0.8, -0.8, 0.25], [0.8, 0.6, 0.25], [-0.8, 0.6, 0.25]];
    let triangle = [[0.0, -0.7, 0.7], [0.0, 0.7, 0.7], [0.0, 0.7, -0.7]];
    let corners = [[-0.5, -0.5], [0.5, -0.5], [0.5, 0.75], [-0.5, 0.75]];
    let nothing = Section::builder("partial", Plane { normal: DVec3::Y, offset: -0.5 })
        .within(corners.map(|[x, z]| DVec3::new(x, -0.5, z)))
        .build(&Rules::default());
    let sections = [
        along(DVec3::Z, 0.25, &square),
        along(DVec3::X, 0.0, &triangle),
        nothing.expect("a section").0,
    ];
    let mesh = reconstruct(&sections).mesh;
    let facts = mesh.surface(Label(1)).facts(true).expect("facts");
    assert!(facts.closed && facts.outward, "{facts:?}");
}

/// Half of the plane z = 0 is outside but for a rectangle of label 1. Its body
/// reaches to halfway between the plane and the box, |z| ≤ ¾, and no nearer to
/// the face x = −1.5: |z| ≤ x + 1.5. So 2 · (¼ · 5/8 + ½ · ¾).
#[test]
fn half_a_plane() {
    let known = (Label(0), rectangle([-8.0, 0.0], [-8.0, 8.0]));
    let material = (Label(1), rectangle([-1.0, -0.25], [-0.5, 0.5]));
    let result = reconstruct(&[flat(0.0).section(&[known, material])]);
    assert!((body(&result.mesh, 1) - 1.0625).abs() < 1e-9);
}

/// A floating square of half size a spreads to all sides, but no farther than
/// halfway to the box: within a cube of half size 1, and at least over its own prism.
#[test]
fn a_floating_patch() {
    let material = (Label(1), rectangle([-0.5, 0.5], [-0.5, 0.5]));
    let result = reconstruct(&[flat(0.0).section(&[material])]);
    let volume = body(&result.mesh, 1);
    assert!(volume > 1.5 && volume < 8.0 * 0.75, "{volume}");
}

/// The two halves of a patch have labels of their own, and bodies of one size.
#[test]
fn a_floating_patch_of_two_labels() {
    let halves = [
        (Label(1), rectangle([-0.5, 0.0], [-0.5, 0.5])),
        (Label(2), rectangle([0.0, 0.5], [-0.5, 0.5])),
    ];
    let result = reconstruct(&[flat(0.0).section(&halves)]);
    assert!((body(&result.mesh, 1) - body(&result.mesh, 2)).abs() < 1e-9);
}

/// Known all around, so the hole is filled.
#[test]
fn a_hole_and_a_slit() {
    let known = (Label(0), rectangle([-8.0, 8.0], [-8.0, 8.0]));
    let material = (Label(1), rectangle([-1.0, 1.0], [-0.75, 0.75]));
    for hole in
        [rectangle([-0.25, 0.25], [-0.25, 0.25]), rectangle([-0.75, 0.75], [-0.0625, 0.0625])]
    {
        let hole = (Label::UNKNOWN, hole);
        let loops = [known.clone(), material.clone(), hole];
        body(&reconstruct(&[flat(0.0).section(&loops)]).mesh, 1);
    }
}

#[test]
fn a_nonconvex_patch() {
    let corners = [[-0.75, -0.75], [0.75, -0.75], [0.75, 0.0], [0.0, 0.0], [0.0, 0.75]];
    let outline = corners.into_iter().chain([[-0.75, 0.75]]).collect();
    body(&reconstruct(&[flat(0.0).section(&[(Label(1), outline)])]).mesh, 1);
}

#[test]
fn three_patches() {
    let upright = Frame { origin: DVec3::X, across: DVec3::Z, along: DVec3::Y };
    let sections = [
        flat(-0.75).section(&[(Label(1), rectangle([-0.5, 0.5], [-0.5, 0.5]))]),
        flat(0.75).section(&[(Label(2), rectangle([-0.5, 0.25], [-0.25, 0.5]))]),
        upright.section(&[(Label(3), rectangle([-0.25, 0.25], [-0.5, 0.5]))]),
    ];
    let result = reconstruct(&sections);
    for label in 1..=3 {
        body(&result.mesh, label);
    }
}

/// A whole section, and a patch on one side of it that is partly over its square: the
/// section is between the patch and what lies beyond, where nothing changes.
#[test]
fn a_patch_behind_a_section() {
    let whole = (Label(0), rectangle([-8.0, 8.0], [-8.0, 8.0]));
    let square = (Label(1), rectangle([-0.5, 0.5], [-0.5, 0.5]));
    let section = flat(-0.5).section(&[whole, square]);
    let alone = body(&reconstruct(std::slice::from_ref(&section)).mesh, 1);
    // Halfway to the box above and below: ½ · (2 + 1).
    assert!((alone - 1.5).abs() < 1e-9, "{alone}");
    let patch = flat(0.25).section(&[(Label(1), rectangle([-0.75, 0.25], [-0.25, 0.75]))]);
    let result = reconstruct(&[section, patch]);
    assert!(body(&result.mesh, 1) > alone);
    let lowest = result.mesh.vertices.iter().map(|vertex| vertex.z).fold(f64::INFINITY, f64::min);
    assert_eq!(lowest, -1.0);
}

/// An upright patch that a whole section crosses, in the plane of its symmetry.
#[test]
fn a_patch_across_a_section() {
    let whole = (Label(0), rectangle([-8.0, 8.0], [-8.0, 8.0]));
    let section = flat(0.0).section(&[whole, (Label(1), rectangle([-0.5, 0.5], [-0.5, 0.5]))]);
    let upright = Frame { origin: DVec3::ZERO, across: DVec3::X, along: DVec3::Z };
    let patch = upright.section(&[
        (Label(0), rectangle([-1.0, 1.0], [-0.5, 0.5])),
        (Label(1), rectangle([-0.5, 0.5], [-0.25, 0.25])),
    ]);
    let result = reconstruct(&[section, patch]);
    assert!(result.details.contradictions.is_empty());
    body(&result.mesh, 1);
}

/// Two slices whose stripes are not above each other are joined by a patch in between
/// (the paper's Figure 8), and not without it.
#[test]
fn a_patch_guides() {
    let whole = (Label(0), rectangle([-8.0, 8.0], [-8.0, 8.0]));
    let stripe = |x: [f64; 2]| (Label(1), rectangle(x, [-0.5, 0.5]));
    let slices = [
        flat(-0.75).section(&[whole.clone(), stripe([-1.0, -0.25])]),
        flat(0.75).section(&[whole, stripe([0.25, 1.0])]),
    ];
    let apart = reconstruct(&slices);
    let facts = apart.mesh.surface(Label(1)).facts(true).expect("facts");
    assert_eq!(facts.components, 2);
    let [lower, upper] = slices;
    let guide = flat(0.0).section(&[(Label(1), rectangle([-0.75, 0.75], [-0.375, 0.375]))]);
    body(&reconstruct(&[lower, upper, guide]).mesh, 1);
}

/// The middle one of three equal sections has octagons of unknown all over, within the square:
/// whatever is nearest to a place beside them says what it would have said itself.
#[test]
fn many_holes() {
    let whole = (Label(0), rectangle([-8.0, 8.0], [-8.0, 8.0]));
    let square = (Label(1), rectangle([-1.0, 1.0], [-1.0, 1.0]));
    let full = [whole, square];
    let hole = |number: i32| {
        let [x, y] = [number % 4, number / 4].map(|i| 0.4375 * f64::from(i) - 0.65625);
        let corner = |i: i32| {
            let angle = (f64::from(i) + 0.1 * f64::from(number)) * std::f64::consts::FRAC_PI_4;
            [x + 0.125 * angle.cos(), y + 0.125 * angle.sin()]
        };
        (Label::UNKNOWN, (0..8).map(corner).collect::<Vec<_>>())
    };
    let holed: Vec<_> = full.iter().cloned().chain((0..16).map(hole)).collect();
    let [below, above] = [-0.5, 0.5].map(|z| flat(z).section(&full));
    let bare = reconstruct(&[below.clone(), flat(0.0).section(&full), above.clone()]);
    let volume = body(&reconstruct(&[below, flat(0.0).section(&holed), above]).mesh, 1);
    assert!((volume - body(&bare.mesh, 1)).abs() < 1e-9, "{volume}");
}

/// Frames on top of each other, as of a sweep: squares are one body, in the box's middle.
#[test]
fn ten_frames() {
    let frame = |layer: i32| {
        let height = 0.1875 * f64::from(layer) - 0.84375;
        let square = |half: f64| rectangle([-half, half], [-half, half]);
        flat(height).section(&[(Label(0), square(0.75)), (Label(1), square(0.5))])
    };
    let frames: Vec<Section> = (0..10).map(frame).collect();
    let result = reconstruct(&frames);
    let volume = body(&result.mesh, 1);
    // Midway to the box over the outermost frames, straight between them.
    let height = 2.0 * 0.84375 + (1.5 - 0.84375);
    assert!((volume - height).abs() < 0.02 * height, "{volume}");
}

/// Triangles around a line that meet in one point: too many are equally near there, so a
/// small part around it is not exact. All is closed, and the report says where.
#[test]
fn too_many_patches_in_a_point() {
    let blade = |number: u32| {
        let angle = std::f64::consts::PI * f64::from(number) / 13.0;
        let across = DVec3::new(angle.cos(), angle.sin(), 0.0);
        let frame = Frame { origin: DVec3::ZERO, across, along: DVec3::Z };
        let corners = vec![[0.0, 0.0], [0.75, -0.25], [0.75, 0.5]];
        frame.section(&[(Label(1 + number % 2), corners)])
    };
    let blades: Vec<Section> = (0..13).map(blade).collect();
    let result = skeleton(&blades, BOX, &Options::default(), &Silent).expect("a skeleton");
    let details = &result.details;
    assert!(details.left_out.is_empty());
    assert_eq!(details.inexact.len(), 1, "{details:?}");
    assert_eq!(details.inexact[0].cell, 0);
    assert!(DVec3::from_array(details.inexact[0].at).length() < 0.1);
    assert!(details.exact_share > 0.999 && details.exact_share < 1.0, "{}", details.exact_share);
    for label in [1, 2] {
        let facts = result.mesh.surface(Label(label)).facts(false).expect("facts");
        assert!(facts.closed && facts.outward, "{facts:?}");
    }
}

/// As above, and each blade consists of two convex parts with a corner in the point: all is
/// closed although not all parts of a blade are asked there.
#[test]
fn too_many_parts_of_patches_in_a_point() {
    let blade = |number: u32| {
        let angle = std::f64::consts::PI * f64::from(number) / 8.0;
        let across = DVec3::new(angle.cos(), angle.sin(), 0.0);
        let frame = Frame { origin: DVec3::ZERO, across, along: DVec3::Z };
        let corners = vec![[0.0, 0.0], [0.5, -0.5], [0.25, 0.0], [0.5, 0.5]];
        frame.section(&[(Label(1 + number % 2), corners)])
    };
    let blades: Vec<Section> = (0..8).map(blade).collect();
    let result = skeleton(&blades, BOX, &Options::default(), &Silent).expect("a skeleton");
    assert!(result.details.left_out.is_empty());
    assert!(!result.details.inexact.is_empty());
    for label in [1, 2] {
        let facts = result.mesh.surface(Label(label)).facts(false).expect("facts");
        assert!(facts.closed && facts.outward, "{facts:?}");
    }
}
