//! Points and their cells.

use super::*;

/// Whether a point is on the cell's side of all planes, give or take.
fn is_in(complex: &Complex, cell: u32, point: DVec3, tolerance: f64) -> bool {
    complex.facets_of(cell).all(|(_, facet)| {
        let side = if facet.cells[0] == Some(cell) { 1.0 } else { -1.0 };
        side * complex.planes()[facet.plane].distance(point) >= -tolerance
    })
}

fn random_complex(seed: u64, count: usize) -> (Random, Complex) {
    let mut random = Random::new(seed);
    let planes: Vec<Plane> = (0..count).map(|_| plane_in(&mut random, CENTERED)).collect();
    let complex = arrange_planes(&planes, CENTERED);
    (random, complex)
}

#[test]
fn random_points_are_in_their_cells() {
    let (mut random, complex) = random_complex(5, 40);
    for _ in 0..2000 {
        let point = point_in(&mut random, CENTERED);
        assert!(is_in(&complex, complex.locate(point), point, 1e-14));
    }
}

#[test]
fn corners_are_at_cells_that_touch_them() {
    let (_, complex) = random_complex(6, 12);
    for corner in complex.facets().values().flat_map(|facet| &facet.outline) {
        assert!(is_in(&complex, complex.locate(*corner), *corner, 1e-9));
    }
}

#[test]
fn points_outside_the_box_count_as_the_nearest_inside() {
    let (mut random, complex) = random_complex(7, 10);
    for _ in 0..200 {
        let point = point_in(&mut random, CENTERED) * 3.0;
        let inside = point.clamp(DVec3::NEG_ONE, DVec3::ONE);
        assert_eq!(complex.locate(point), complex.locate(inside));
        assert!(is_in(&complex, complex.locate(point), inside, 1e-9));
    }
}

#[test]
fn points_on_a_common_line_have_a_cell() {
    // Eight planes around the vertical line through (0.1, 0.2), not exactly.
    let (center, up) = (DVec3::new(0.1, 0.2, 0.0), 0.123);
    let planes = (0..8).map(|i| {
        let angle = 0.3 + std::f64::consts::PI * f64::from(i) / 8.0;
        let normal = DVec3::new(angle.cos(), angle.sin(), 0.0);
        Plane { normal, offset: normal.dot(center) }
    });
    let complex = arrange_planes(&planes.collect::<Vec<_>>(), CENTERED);
    for i in -50..=50 {
        let nudge = DVec3::new(f64::from(i) * 1e-17, f64::from(i % 7) * 1e-17, up);
        let point = center + nudge;
        assert!(is_in(&complex, complex.locate(point), point, 1e-9));
    }
}

#[test]
fn wedges_thinner_than_rounding_are_found_or_their_neighbours() {
    let planes: Vec<Plane> =
        (0..10).map(|i| plane([f64::from(i) * 1e-17, 0.0, 1.0], 0.1)).collect();
    let complex = arrange_planes(&planes, CENTERED);
    assert_eq!(complex.cells().count(), 20);
    for x in [-1.0, -0.5, 0.0, 0.5, 1.0] {
        for z in [0.1, 0.1 - 1e-17, 0.1 + 2e-17, 0.5] {
            let point = DVec3::new(x, 0.0, z);
            assert!(is_in(&complex, complex.locate(point), point, 1e-15));
        }
    }
}

#[test]
fn a_locator_says_the_same_as_the_complex() {
    let (mut random, complex) = random_complex(8, 30);
    let mut uncut = 0;
    for _ in 0..500 {
        let center = point_in(&mut random, CENTERED);
        let side = between(&mut random, 0.001, 0.2);
        let region = Bounds { min: center - side, max: center + side };
        let locator = complex.locator(region);
        for _ in 0..10 {
            let point = point_in(&mut random, region);
            assert_eq!(locator.locate(point), complex.locate(point));
            if let Some(cell) = locator.only_cell() {
                assert_eq!(cell, complex.locate(point));
                uncut += 1;
            }
        }
    }
    assert!(uncut > 0);
}

#[test]
fn sides_are_exact_however_small_the_numbers() {
    for scale in [1.0, 1e-90, 1e-160, 1e120] {
        let bounds = Bounds { min: DVec3::splat(-scale), max: DVec3::splat(scale) };
        // In front of it x is larger than y.
        let diagonal = Plane { normal: scale * DVec3::new(1.0, -1.0, 0.0), offset: 0.0 };
        let complex = arrange_planes(&[diagonal], bounds);
        let third = scale / 3.0;
        let next = f64::from_bits(third.to_bits() + 1);
        // A point on the plane counts as moved along x.
        for (x, y, is_in_front) in [(next, third, true), (third, third, true), (third, next, false)]
        {
            let cell = complex.locate(DVec3::new(x, y, 0.1 * scale));
            let facet = facets_on(&complex, 0)[0];
            assert_eq!(facet.cells[0] == Some(cell), is_in_front, "{scale}: {x} and {y}");
        }
    }
}
