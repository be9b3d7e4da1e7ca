//! Directions as people write them: an axis, `x` or `-y`, or three numbers.

use glam::DVec3;

const AXES: [(&str, DVec3); 6] = [
    ("x", DVec3::X),
    ("y", DVec3::Y),
    ("z", DVec3::Z),
    ("-x", DVec3::NEG_X),
    ("-y", DVec3::NEG_Y),
    ("-z", DVec3::NEG_Z),
];

/// The axis of a name.
pub fn axis(name: &str) -> Option<DVec3> {
    AXES.iter().find(|(known, _)| *known == name).map(|&(_, axis)| axis)
}

/// The name of an axis; `None` for every other direction.
pub fn axis_name(direction: DVec3) -> Option<&'static str> {
    AXES.iter().find(|&&(_, axis)| axis == direction).map(|&(name, _)| name)
}

/// The vector of length 1 in a direction; `None` without one: for zero, and
/// where a component is not finite.
pub fn unit(direction: DVec3) -> Option<DVec3> {
    // By the largest component first, so that no square overflows or vanishes.
    let largest = direction.abs().max_element();
    let is_direction = direction.is_finite() && largest > 0.0;
    // 1 / largest would overflow for the smallest numbers.
    is_direction.then(|| (direction / largest).normalize())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_axis_is_its_name_and_back() {
        for (name, direction) in AXES {
            assert_eq!((axis(name), axis_name(direction)), (Some(direction), Some(name)));
        }
        assert_eq!((axis("w"), axis_name(DVec3::ONE)), (None, None));
    }

    #[test]
    fn huge_and_tiny_vectors_have_a_direction_and_zero_has_none() {
        for length in [1e300, 1.0, 1e-310] {
            let found = unit(DVec3::new(0.0, 3.0, -4.0) * length).expect("a direction");
            assert!(found.distance(DVec3::new(0.0, 0.6, -0.8)) < 1e-9, "{length}: {found}");
        }
        for none in [DVec3::ZERO, DVec3::new(f64::NAN, 1.0, 0.0), DVec3::X * f64::INFINITY] {
            assert_eq!(unit(none), None);
        }
    }
}
