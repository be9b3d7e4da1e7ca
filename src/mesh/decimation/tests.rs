use glam::DVec3;

use super::*;
use crate::grid::samples::Lattice;
use crate::label::Label;
use crate::mesh::caps::CAP_TOLERANCE;
use crate::mesh::dual;
use crate::mesh::shapes::{assert_edge_manifold, cylinder, open_samples, samples, solid};
use crate::plane::Bounds;
use crate::progress::Silent;

fn decimated(mesh: &Mesh, decimation: Decimation) -> Decimated {
    decimate(mesh, &[], decimation, &Silent).expect("a simpler mesh")
}

/// The pieces and handles of every label; all are closed, face outward, and cross nothing.
fn topology(mesh: &Mesh) -> Vec<(Label, usize, i64)> {
    let label = |label: Label| {
        assert_edge_manifold(mesh, label);
        let facts = mesh.surface(label).facts(true).expect("facts");
        assert!(facts.outward && facts.self_intersections == Some(0), "{label}: {facts:?}");
        (label, facts.components, facts.genus)
    };
    mesh.labels().into_iter().map(label).collect()
}

fn ball() -> Mesh {
    solid(41, 1.0, |point| 0.8 - point.length())
}

fn torus() -> Mesh {
    solid(51, 1.0, |point| 0.25 - (point.truncate().length() - 0.6).hypot(point.z))
}

/// A ball in two halves, two labels that touch in a disc, around the middle of which lies a third
/// one.
fn halves() -> Mesh {
    let voxel = 0.05;
    let lattice = Lattice { origin: DVec3::splat(-1.0), voxel, dims: [41; 3] };
    let values = |node| {
        let point = lattice.position(node);
        let (ball, core) = (0.8 - point.length(), 0.3 - point.length());
        let half = |side: f64| ball.min(side).min(-core);
        let scaled = |value: f64| (value / (3.0 * voxel)).clamp(-1.0, 1.0) as f32;
        [half(point.x - 0.01), half(0.01 - point.x), core].map(scaled).to_vec()
    };
    dual(&samples(lattice, values), &Silent).expect("a mesh")
}

#[test]
fn a_share_of_the_triangles_is_left() {
    let ball = ball();
    let volume = |mesh: &Mesh| mesh.surface(Label(1)).volume();
    for (share, tolerance) in [(0.5, 1e-3), (0.1, 5e-3), (0.02, 3e-2)] {
        let Decimated { mesh, outcome } = decimated(&ball, Decimation::Share(share));
        let wanted = (share * ball.triangles.len() as f64).ceil() as usize;
        assert!((wanted - 1..=wanted).contains(&mesh.triangles.len()), "{outcome:?}");
        assert_eq!(outcome.triangles, mesh.triangles.len());
        assert_eq!(outcome.shortfall(), None);
        assert_eq!(topology(&mesh), [(Label(1), 1, 0)]);
        let ratio = volume(&mesh) / volume(&ball);
        assert!((ratio - 1.0).abs() < tolerance, "{share}: {ratio}");
    }
}

#[test]
fn all_triangles_are_the_same_mesh() {
    let torus = torus();
    let made = decimated(&torus, Decimation::Share(1.0));
    assert_eq!(made.mesh, torus);
    assert_eq!(made.outcome.moved, 0.0);
}

#[test]
fn a_handle_stays_however_few_triangles_are_wanted() {
    let Decimated { mesh, outcome } = decimated(&torus(), Decimation::Share(1e-4));
    assert_eq!(topology(&mesh), [(Label(1), 1, 1)]);
    assert!(outcome.triangles < 300, "{outcome:?}");
    assert!(outcome.shortfall().expect("a word").contains("of "));
}

#[test]
fn a_mesh_of_nothing_or_of_four_triangles_stays() {
    let vertices = vec![DVec3::ZERO, DVec3::X, DVec3::Y, DVec3::Z];
    let triangles = vec![[0, 2, 1], [0, 3, 2], [0, 1, 3], [1, 2, 3]];
    let tetrahedron = Mesh { vertices, triangles, sides: vec![[Label(1), Label::OUTSIDE]; 4] };
    for decimation in [Decimation::Share(0.1), Decimation::Distance(10.0)] {
        assert_eq!(decimated(&Mesh::default(), decimation).mesh, Mesh::default());
        let made = decimated(&tetrahedron, decimation);
        assert_eq!((made.outcome.triangles, made.outcome.moved), (4, 0.0));
        assert_eq!(topology(&made.mesh), topology(&tetrahedron));
    }
}

#[test]
fn no_point_is_farther_than_the_limit() {
    let torus = torus();
    let mut last = torus.triangles.len();
    for limit in [0.002, 0.01, 0.05] {
        let Decimated { mesh, outcome } = decimated(&torus, Decimation::Distance(limit));
        assert!(outcome.moved > 0.0 && outcome.moved <= limit, "{outcome:?}");
        assert!(2 * mesh.triangles.len() < last, "{outcome:?}");
        last = mesh.triangles.len();
        assert_eq!(topology(&mesh), [(Label(1), 1, 1)]);
        let largest = |from: &Mesh, to: &Mesh| {
            let middles = (0..from.triangles.len()).map(|own| from.corners(own));
            let middles: Vec<DVec3> =
                middles.map(|[a, b, c]| (a + b + c) / 3.0).chain(from.vertices.clone()).collect();
            let nearest = Nearest::on_mesh(to).expect("a surface");
            nearest.distances(&middles).expect("distances").into_iter().fold(0.0, f64::max)
        };
        assert!(largest(&torus, &mesh) <= limit && largest(&mesh, &torus) <= limit);
    }
}

#[test]
fn labels_that_touch_still_fit() {
    let halves = halves();
    let was = topology(&halves);
    assert_eq!(was.len(), 3);
    let lines = |mesh: &Mesh| sheets::curves(&Network::new(mesh, &[]).expect("a network")).len();
    for decimation in [Decimation::Share(0.1), Decimation::Share(0.04), Decimation::Distance(0.01)]
    {
        let Decimated { mesh, outcome } = decimated(&halves, decimation);
        assert_eq!(topology(&mesh), was, "{decimation:?}");
        assert!(outcome.triangles < halves.triangles.len() / 4, "{outcome:?}");
        let (lines, were) = (lines(&mesh), lines(&halves));
        assert!(4 * lines < 3 * were, "{decimation:?}: {lines} of {were}");
        assert!(outcome.moved < 0.15, "{outcome:?}");
    }
}

#[test]
fn caps_stay_on_the_faces_of_an_open_box() {
    let bounds = Bounds { min: DVec3::splat(-1.0), max: DVec3::splat(1.0) };
    let (radius, voxel) = (0.6, 0.05);
    let mesh = dual(&open_samples(bounds, 40, cylinder(radius, voxel)), &Silent).expect("a mesh");
    let tolerance = CAP_TOLERANCE * voxel;
    let rim = mesh.rim(bounds, tolerance);
    let made = decimate(&mesh, &rim, Decimation::Share(0.05), &Silent).expect("a mesh").mesh;
    assert!(20 * made.triangles.len() <= mesh.triangles.len() + 20);
    let open = |mesh: &Mesh| {
        let bare = mesh.without_caps(bounds, tolerance).surface(Label(1));
        let edges = bare.open_edges();
        let ends = |edge: [u32; 2]| edge.map(|vertex| bare.vertices[vertex as usize]);
        assert!(edges.iter().all(|&edge| bounds.on_one_face(&ends(edge), tolerance)));
        (edges.len(), bare.area())
    };
    let ((edges, area), (edges_was, area_was)) = (open(&made), open(&mesh));
    assert!(edges > 8 && 2 * edges < edges_was, "{edges} {edges_was}");
    assert!((area / area_was - 1.0).abs() < 0.02, "{area} {area_was}");
}

#[test]
fn what_makes_no_sense_is_refused() {
    let senseless = [0.0, -0.1, 1.1, f64::NAN].map(Decimation::Share);
    let limits = [0.0, -1.0, f64::NAN, f64::INFINITY].map(Decimation::Distance);
    for decimation in [senseless, limits].concat() {
        let error = decimate(&ball(), &[], decimation, &Silent).expect_err("none");
        assert!(matches!(error, Error::Option(_)), "{error}");
    }
}

#[test]
fn it_can_be_cancelled() {
    struct Impatient;
    impl Progress for Impatient {
        fn begin(&self, _: &'static str, _: u64) {}
        fn advance(&self, _: u64) {}
        fn is_cancelled(&self) -> bool {
            true
        }
    }
    let error = decimate(&ball(), &[], Decimation::Share(0.1), &Impatient).expect_err("cancelled");
    assert!(matches!(error, Error::Cancelled));
}
