use std::collections::HashSet;
use std::f64::consts::PI;

use glam::DVec3;

use super::*;
use crate::label::Label;
use crate::mesh::shapes::assert_edge_manifold;
use crate::plane::Plane;
use crate::progress::Silent;

const A: Label = Label(1);
const B: Label = Label(2);
const O: Label = Label::OUTSIDE;

/// Rings of `count` corners around the z axis, joined by bands: of each its
/// height, its radius and what is below it, between it and the ring before. The
/// first is closed below, the last above.
fn lathe(count: u32, rings: &[(f64, f64, Label)]) -> Mesh {
    let mut mesh = Mesh::default();
    let corner = |ring: usize, at: u32| ring as u32 * count + at % count;
    for &(z, radius, _) in rings {
        let turn = |at: u32| (f64::from(at) + 0.5) * std::f64::consts::TAU / f64::from(count);
        let place = |at| DVec3::new(radius * turn(at).cos(), radius * turn(at).sin(), z);
        mesh.vertices.extend((0..count).map(place));
    }
    for (ring, &(_, _, below)) in rings.iter().enumerate().skip(1) {
        for at in 0..count {
            let [a, b] = [corner(ring - 1, at), corner(ring - 1, at + 1)];
            let [c, d] = [corner(ring, at), corner(ring, at + 1)];
            mesh.triangles.extend([[a, b, d], [a, d, c]]);
            mesh.sides.extend([[below, O]; 2]);
        }
    }
    for at in 1..count - 1 {
        let last = rings.len() - 1;
        mesh.triangles.push([corner(0, 0), corner(0, at + 1), corner(0, at)]);
        mesh.sides.push([rings[0].2, O]);
        mesh.triangles.push([corner(last, 0), corner(last, at), corner(last, at + 1)]);
        mesh.sides.push([rings[last].2, O]);
    }
    mesh
}

/// The edges of a ring.
fn ring_edges(count: u32, ring: u32) -> Vec<[u32; 2]> {
    (0..count).map(|at| [ring * count + at, ring * count + (at + 1) % count]).collect()
}

/// Panics unless the ends of edges are vertices of a mesh, bit by bit.
fn assert_kept(before: &Mesh, fixed: &[[u32; 2]], after: &Mesh) {
    let bits = |place: &DVec3| place.to_array().map(f64::to_bits);
    let places: HashSet<[u64; 3]> = after.vertices.iter().map(bits).collect();
    for &end in fixed.as_flattened() {
        let place = &before.vertices[end as usize];
        assert!(places.contains(&bits(place)), "{place} is gone");
    }
}

/// What comes of a unit ball by sections at multiples of 0.2: terraces. Rings 1,
/// 4, 7, … are the contours.
fn terraced_ball() -> (Mesh, Vec<[u32; 2]>) {
    let heights = (-4..=4).map(|at| 0.2 * f64::from(at));
    let terrace = |z: f64| {
        let radius = (1.0 - z * z).sqrt();
        [-0.1, 0.0, 0.1].map(|step| (z + step, radius, A))
    };
    let mesh = lathe(48, &heights.flat_map(terrace).collect::<Vec<_>>());
    let fixed = (0..9).flat_map(|at| ring_edges(48, 3 * at + 1)).collect();
    (mesh, fixed)
}

/// Triangles of three corners on one contour would lie in its plane, where the section says
/// something else. Their edges are turned, or they are divided and bent out of it.
#[test]
fn nothing_lies_in_the_plane_of_a_contour() {
    let (mesh, fixed) = terraced_ball();
    let heights: Vec<f64> = (-4..=4).map(|at| 0.2 * f64::from(at)).collect();
    let planes: Vec<Plane> =
        heights.iter().map(|&offset| Plane { normal: DVec3::Z, offset }).collect();
    for edge_length in [0.3, 0.7] {
        let fair = made(&mesh, &fixed, &planes, FairingOptions { edge_length, steps: 200 });
        let flat = |triangle: &&[u32; 3]| {
            let [a, b, c] = triangle.map(|vertex| fair.vertices[vertex as usize].z);
            heights.iter().any(|height| [a, b, c].iter().all(|z| (z - height).abs() < 1e-9))
        };
        assert_eq!(fair.triangles.iter().filter(flat).count(), 0);
        assert_kept(&mesh, &fixed, &fair);
    }
}

/// Two boxes, the upper one smaller and of another material or not, the lower
/// one's contour at height ½, the upper one's at 1½. The sides are 4 and 2.
fn stacked(upper: Label) -> (Mesh, Vec<[u32; 2]>) {
    let (large, small) = (8f64.sqrt(), 2f64.sqrt());
    let rings = [
        (0.0, large, B),
        (0.5, large, B),
        (1.0, large, B),
        (1.0, small, B),
        (1.5, small, upper),
        (2.0, small, upper),
    ];
    let mut mesh = lathe(4, &rings);
    if upper != B {
        // Between them, seen from the lower one: the label 1 is at the back.
        mesh.triangles.extend([[12, 14, 13], [12, 15, 14]]);
        mesh.sides.extend([[upper, B]; 2]);
    }
    (mesh, [ring_edges(4, 1), ring_edges(4, 4)].concat())
}

/// The fair mesh, no patch of which was left as it was.
fn made(mesh: &Mesh, fixed: &[[u32; 2]], planes: &[Plane], options: FairingOptions) -> Mesh {
    let fair = fair(mesh, fixed, planes, &options, &Silent).expect("a fair mesh");
    assert_eq!(fair.left, 0);
    fair.mesh
}

#[test]
fn terraces_of_a_ball_become_round() {
    let (mesh, fixed) = terraced_ball();
    let fair = made(&mesh, &fixed, &[], FairingOptions { edge_length: 0.05, steps: 200 });
    assert_edge_manifold(&fair, A);
    assert_kept(&mesh, &fixed, &fair);
    let facts = fair.surface(A).facts(true).unwrap();
    assert!(facts.closed && facts.outward);
    assert_eq!((facts.components, facts.genus, facts.self_intersections), (1, 0, Some(0)));
    // A ring of 48 has 0.9971 of the circle's area; of the caps beyond the last
    // contours, 0.028 of the volume each, only as much as its slope suggests.
    assert!((facts.volume / (4.0 * PI / 3.0) - 1.0).abs() < 0.04, "{}", facts.volume);
    // Between the first contour and the last.
    let off = |place: &DVec3| {
        if place.z.abs() > 0.8 { 0.0 } else { (place.length() - 1.0).abs() }
    };
    let [before, after] =
        [&mesh, &fair].map(|mesh| mesh.vertices.iter().map(off).fold(0.0, f64::max));
    assert!(after < 0.01 && before > 0.07, "{before} {after}");
}

#[test]
fn labels_stay_closed_where_three_meet() {
    for upper in [A, B] {
        let (mesh, fixed) = stacked(upper);
        assert_edge_manifold(&mesh, upper);
        assert_edge_manifold(&mesh, B);
        let whole = |mesh: &Mesh| mesh.surface_of(|label| label.is_material()).volume();
        assert!((whole(&mesh) - 20.0).abs() < 1e-12);
        for steps in [0, 10] {
            let options = FairingOptions { edge_length: 0.1, steps };
            let fair = made(&mesh, &fixed, &[], options);
            assert_edge_manifold(&fair, upper);
            assert_edge_manifold(&fair, B);
            assert_kept(&mesh, &fixed, &fair);
            // Creases of 56 in length in all are cut no deeper than 0.4, the
            // coarsest edge, with as much to either side.
            assert!((whole(&fair) - 20.0).abs() < 56.0 * 0.4 * 0.4 / 2.0);
        }
    }
}

#[test]
fn an_open_sheet_keeps_its_border() {
    let mesh = Mesh {
        vertices: [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]]
            .map(|[x, y]| DVec3::new(x, y, 3.0))
            .to_vec(),
        triangles: vec![[0, 1, 2], [0, 2, 3]],
        sides: vec![[A, O]; 2],
    };
    let fair = made(&mesh, &[[0, 2]], &[], FairingOptions { edge_length: 0.1, steps: 20 });
    assert!(fair.vertices.iter().all(|vertex| vertex.z == 3.0));
    assert!(fair.triangles.len() > 200);
    let area = |triangle| {
        let [a, b, c] = fair.corners(triangle);
        (b - a).cross(c - a).z / 2.0
    };
    let areas: Vec<f64> = (0..fair.triangles.len()).map(area).collect();
    assert!((areas.iter().sum::<f64>() - 1.0).abs() < 1e-12);
    assert!(areas.iter().all(|&area| area > 0.0));
}

#[test]
fn any_number_of_threads_gives_the_same() {
    let (mesh, fixed) = stacked(A);
    let options = FairingOptions { edge_length: 0.2, steps: 5 };
    let on = |threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| fair(&mesh, &fixed, &[], &options, &Silent).unwrap())
    };
    assert!(on(1) == on(3));
}

#[test]
fn what_cannot_be_is_an_error() {
    let (mesh, fixed) = stacked(A);
    for edge_length in [0.0, -1.0, f64::NAN, f64::INFINITY, 1e-9] {
        assert!(
            fair(&mesh, &fixed, &[], &FairingOptions { edge_length, steps: 1 }, &Silent).is_err()
        );
    }
    let options = FairingOptions { edge_length: 1.0, steps: 1 };
    assert!(matches!(fair(&mesh, &[[0, 24]], &[], &options, &Silent), Err(Error::Mesh(_))));
    assert_eq!(made(&Mesh::default(), &[], &[], options), Mesh::default());
}

#[test]
fn nothing_moves_through_a_plane() {
    // Between the two wide contours of four the surface bulges beyond both.
    let levels = [(0.0, 0.5), (0.3, 1.0), (0.6, 1.0), (0.9, 0.5)];
    let terrace = |(z, radius)| [-0.15, 0.0, 0.15].map(|step| (z + step, radius, A));
    let mesh = lathe(24, &levels.into_iter().flat_map(terrace).collect::<Vec<_>>());
    let fixed: Vec<[u32; 2]> = (0..4).flat_map(|at| ring_edges(24, 3 * at + 1)).collect();
    let options = FairingOptions { edge_length: 0.05, steps: 400 };
    let widest = |mesh: &Mesh| mesh.vertices.iter().fold(0.0, |widest: f64, at| widest.max(at.x));
    let wall = Plane { normal: 2.0 * DVec3::X, offset: 2.0 };
    let free = widest(&made(&mesh, &fixed, &[], options));
    assert!(free > 1.01, "{free}");
    let kept = made(&mesh, &fixed, &[wall], options);
    assert!(widest(&kept) <= 1.0, "{}", widest(&kept));
    assert!(kept.surface(A).facts(true).unwrap().outward);
}

#[test]
fn what_would_vanish_stays_as_it_is() {
    // Without a bend the fairest surface through one contour is flat, twice.
    let mesh = lathe(12, &[(-0.1, 1.0, A), (0.0, 1.0, A), (0.1, 1.0, A)]);
    let fixed = ring_edges(12, 1);
    let options = FairingOptions { edge_length: 0.05, steps: 200 };
    let fair = fair(&mesh, &fixed, &[], &options, &Silent).unwrap();
    let [before, after] = [&mesh, &fair.mesh].map(|mesh| mesh.surface(A).facts(true).unwrap());
    assert!(after.outward && after.self_intersections == Some(0));
    assert!(after.volume > 0.5 * before.volume, "{} of {}", after.volume, before.volume);
    assert_kept(&mesh, &fixed, &fair.mesh);
}

#[test]
fn sheets_that_are_close_do_not_come_to_cross() {
    // Two stacks of discs, one in the other: what is between them is a fiftieth thick
    // where the outer one is narrow and the inner one wide.
    let terrace = |z: f64, radius: f64| [-0.1, 0.0, 0.1].map(|step| (z + step, radius, A));
    let levels = || (-4..=4).map(|at| (0.2 * f64::from(at), at % 2 == 0));
    let outer: Vec<_> =
        levels().flat_map(|(z, wide)| terrace(z, if wide { 1.0 } else { 0.6 })).collect();
    let inner: Vec<_> =
        levels().flat_map(|(z, wide)| terrace(0.98 * z, if wide { 0.58 } else { 0.3 })).collect();
    let mut mesh = lathe(24, &outer);
    let hole = lathe(24, &inner);
    let first = mesh.vertices.len() as u32;
    mesh.vertices.extend(&hole.vertices);
    mesh.triangles.extend(hole.triangles.iter().map(|&[a, b, c]| [a, c, b].map(|at| at + first)));
    mesh.sides.extend(&hole.sides);
    let of = |ring: u32| [ring_edges(24, ring), ring_edges(24, ring + 27)].concat();
    let fixed: Vec<[u32; 2]> = (0..9).flat_map(|at| of(3 * at + 1)).collect();
    assert_eq!(mesh.surface(A).facts(true).unwrap().self_intersections, Some(0));
    let options = FairingOptions { edge_length: 0.04, steps: 100 };
    let fair = fair(&mesh, &fixed, &[], &options, &Silent).unwrap();
    let facts = fair.mesh.surface(A).facts(true).unwrap();
    assert!(facts.closed && facts.outward, "{facts:?}");
    assert_eq!(facts.self_intersections, Some(0));
    assert!(fair.left < fair.patches, "{} of {}", fair.left, fair.patches);
}
