//! Which way is up, and which of a body's sides is the front, left or top.

use glam::{DVec3, Mat3, Vec3};

use crate::direction;
use crate::section::Sections;

/// What a body's sides are called: three perpendicular directions of length 1.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Sides {
    /// Up in pictures, towards the top.
    pub up: DVec3,
    /// Towards who looks at the front.
    pub front: DVec3,
    /// The body's right where its frame knows one, else the viewer's.
    pub right: DVec3,
}

/// Where nothing says otherwise: seen from the front, x points right and z up.
const PLAIN: Sides = Sides { up: DVec3::Z, front: DVec3::NEG_Y, right: DVec3::X };
/// How far apart, by the cosine, two directions count as one: 8°.
const ALONG: f64 = 0.99;

impl Sides {
    /// Up is, in this order, what the file says; superior in an anatomical
    /// frame; the axis of a tall pile of sections; z.
    pub fn of(sections: &Sections) -> Self {
        let frame = anatomical(&sections.frame);
        match (sections.up, frame) {
            (Some(up), _) => frame.unwrap_or(PLAIN).standing(up),
            (None, Some(sides)) => sides,
            (None, None) => PLAIN.standing(pile(sections).unwrap_or(DVec3::Z)),
        }
    }

    /// The same body with another direction up: its front stays where it was as
    /// far as that goes, else it turns with the top.
    pub fn standing(self, up: DVec3) -> Self {
        let Some(up) = direction::unit(up) else { return self };
        let level = |direction: DVec3| direction - direction.dot(up) * up;
        let tilt = self.front.dot(up);
        let front =
            if tilt.abs() < ALONG { level(self.front) } else { level(-tilt.signum() * self.up) };
        let front = front.normalize();
        // The frame may be left-handed: right stays on its side of front and up.
        let hand = self.up.cross(self.front).dot(self.right).signum();
        Self { up, front, right: hand * up.cross(front) }
    }

    /// The directions as the renderer takes them: up, front, and what is on the
    /// right of who looks at the front.
    pub fn seen(&self) -> [Vec3; 3] {
        let [right, up, front] = self.axes();
        [up, front, right].map(|direction| direction.as_vec3())
    }

    /// The axes of coordinates in which y is up, z points to who looks at the front, and x to the
    /// right of that person.
    pub fn axes(&self) -> [DVec3; 3] {
        [self.up.cross(self.front), self.up, self.front]
    }

    /// The rotation to the camera's space, which takes a direction to +z, towards the viewer,
    /// and up as far up as that goes. Seen from above the front is below.
    pub fn rotation(&self, toward_viewer: Vec3) -> Mat3 {
        let [up, front, _] = self.seen();
        let back = toward_viewer.normalize_or(front);
        let right = up.cross(back);
        let right = match right.length() < 1e-3 {
            true => (front * -back.dot(up).signum()).cross(back),
            false => right,
        };
        let right = right.normalize_or(Vec3::X);
        Mat3::from_cols(right, back.cross(right), back).transpose()
    }
}

/// The sides by a frame that is called after where its axes point: "LPS",
/// towards left, posterior and superior.
fn anatomical(frame: &str) -> Option<Sides> {
    let letters: Vec<char> = frame.trim().to_uppercase().chars().collect();
    let toward = |one: char, other: char| {
        letters.iter().zip(DVec3::AXES).find_map(|(&letter, axis)| match letter {
            _ if letter == one => Some(axis),
            _ if letter == other => Some(-axis),
            _ => None,
        })
    };
    if letters.len() != 3 {
        return None;
    }
    Some(Sides { up: toward('S', 'I')?, front: toward('A', 'P')?, right: toward('R', 'L')? })
}

/// The axis along which parallel sections lie on each other, when their
/// contours reach farther along it than across: a pile that stands.
fn pile(sections: &Sections) -> Option<DVec3> {
    let (first, others) = sections.sections.split_first()?;
    let normal = first.plane().unit_normal();
    let parallel = |&(_, axis): &(usize, DVec3)| {
        let along = |direction: DVec3| direction.dot(axis).abs() > ALONG;
        along(normal) && others.iter().all(|other| along(other.plane().unit_normal()))
    };
    let (number, axis) = DVec3::AXES.into_iter().enumerate().find(parallel)?;
    let bounds = sections.bounds()?;
    let size = bounds.max - bounds.min;
    (!others.is_empty() && size[number] >= size.max_element()).then_some(axis)
}

impl Default for Sides {
    fn default() -> Self {
        PLAIN
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::label::Label;
    use crate::plane::Plane;
    use crate::section::{Edge, Section};
    use glam::DVec2;

    fn in_frame(frame: &str) -> Sides {
        Sides::of(&Sections { frame: frame.to_owned(), ..Sections::default() })
    }

    /// Squares of side 2 on two planes normal to an axis, a distance apart.
    fn pile_of_two(axis: usize, apart: f64) -> Sections {
        let square = |height: f64| Section {
            name: format!("at {height}"),
            plane: Plane { normal: DVec3::AXES[axis], offset: height },
            vertices: [[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]]
                .map(DVec2::from_array)
                .to_vec(),
            edges: (0..4)
                .map(|start| Edge {
                    start,
                    end: (start + 1) % 4,
                    left: Label(1),
                    right: Label::OUTSIDE,
                })
                .collect(),
            background: Label::OUTSIDE,
            normals: Vec::new(),
        };
        Sections { sections: vec![square(0.0), square(apart)], ..Sections::default() }
    }

    #[test]
    fn frames_say_where_the_head_the_face_and_the_right_hand_are() {
        let sides = |up, front, right| Sides { up, front, right };
        let (x, y, z) = (DVec3::X, DVec3::Y, DVec3::Z);
        assert_eq!(in_frame("LPS"), sides(z, -y, -x));
        assert_eq!(in_frame("RAS"), sides(z, y, x));
        assert_eq!(in_frame("ras"), sides(z, y, x));
        assert_eq!(in_frame("RSA"), sides(y, z, x));
        assert_eq!(in_frame("PIR"), sides(-y, -x, z));
        // A graphics program sees the patient's left on the right.
        assert_eq!(in_frame("LPS").axes(), [x, z, -y]);
        assert_eq!(in_frame("RAS").axes(), [-x, z, y]);
        // Not so of a projection, or where an axis is missing.
        for other in ["", "UTM 33N", "RAP", "LLS", "LPSI", "XYZ"] {
            assert_eq!(in_frame(other), PLAIN, "{other}");
        }
    }

    #[test]
    fn what_the_file_calls_up_goes_before_its_frame() {
        let up = Some(DVec3::Y * 7.0);
        let plain = Sides::of(&Sections { up, ..Sections::default() });
        // As in graphics: y up, z towards who looks at the front.
        assert_eq!(plain, Sides { up: DVec3::Y, front: DVec3::Z, right: DVec3::X });
        let sections = Sections { up, frame: "LPS".to_owned(), ..Sections::default() };
        // The patient lies on the face; the right hand is where it was.
        let sides = Sides::of(&sections);
        assert_eq!(sides, Sides { up: DVec3::Y, front: DVec3::Z, right: DVec3::NEG_X });
    }

    #[test]
    fn the_front_stays_where_up_allows_it() {
        for up in [DVec3::NEG_Z, DVec3::X, DVec3::NEG_X] {
            assert_eq!(PLAIN.standing(up).front, PLAIN.front, "{up}");
        }
        assert_eq!(PLAIN.standing(DVec3::NEG_Y).front, DVec3::NEG_Z);
        let tilted = PLAIN.standing(DVec3::new(1.0, 2.0, 3.0));
        let [up, front, right] = [tilted.up, tilted.front, tilted.right];
        let products = [up.dot(front), front.dot(right), right.dot(up)];
        assert!(products.iter().all(|product| product.abs() < 1e-12), "{tilted:?}");
        assert!((up.cross(front).distance(right)) < 1e-12, "as in PLAIN: {tilted:?}");
    }

    #[test]
    fn a_pile_stands_when_it_is_taller_than_wide() {
        // The squares are 2 wide.
        for (axis, direction) in DVec3::AXES.into_iter().enumerate() {
            assert_eq!(Sides::of(&pile_of_two(axis, 3.0)).up, direction);
            assert_eq!(Sides::of(&pile_of_two(axis, 1.0)).up, DVec3::Z);
        }
        // A frame knows better.
        let sections = Sections { frame: "LPS".to_owned(), ..pile_of_two(0, 3.0) };
        assert_eq!(Sides::of(&sections).up, DVec3::Z);
        // And planes of several directions are no pile.
        let crossing =
            [pile_of_two(0, 3.0), pile_of_two(1, 3.0)].map(|pile| pile.sections).concat();
        let crossing = Sections { sections: crossing, ..Sections::default() };
        assert_eq!(Sides::of(&crossing).up, DVec3::Z);
    }

    #[test]
    fn from_above_the_front_is_below() {
        let at = |toward: Vec3, point: Vec3| PLAIN.rotation(toward) * point;
        // As a map: x right, y up.
        assert_eq!(at(Vec3::Z, Vec3::new(1.0, 2.0, 3.0)), Vec3::new(1.0, 2.0, 3.0));
        // From below x is right still, and the front, −y, is up.
        assert_eq!(at(Vec3::NEG_Z, Vec3::new(1.0, 2.0, 3.0)), Vec3::new(1.0, -2.0, -3.0));
    }
}
