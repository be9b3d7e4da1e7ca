//! Where somebody stands who looks at a body: as words, `front-left`, or as a
//! direction.

use std::str::FromStr;

use glam::DVec3;

use crate::direction;
use crate::sides::Sides;

/// From where a picture is taken.
#[derive(Debug, Clone, PartialEq)]
pub enum Viewpoint {
    /// In between these sides of the body, of which no two are opposite.
    Sides(Vec<Side>),
    /// In this direction from the body, in world coordinates.
    Direction(DVec3),
}

/// A side of a body.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Side {
    /// Where its face is.
    Front,
    /// Opposite to the front.
    Back,
    /// Its own left in an anatomical frame, else that of who looks at its front.
    Left,
    /// Opposite to the left.
    Right,
    /// Up.
    Top,
    /// Down.
    Bottom,
}

const NAMES: [(&str, Side); 6] = [
    ("front", Side::Front),
    ("back", Side::Back),
    ("left", Side::Left),
    ("right", Side::Right),
    ("top", Side::Top),
    ("bottom", Side::Bottom),
];

impl Viewpoint {
    /// The direction from the body to who looks at it.
    pub fn direction(&self, sides: &Sides) -> DVec3 {
        match self {
            Self::Direction(direction) => *direction,
            Self::Sides(names) => names.iter().map(|side| side.direction(sides)).sum(),
        }
    }
}

impl Side {
    fn direction(self, sides: &Sides) -> DVec3 {
        match self {
            Self::Front => sides.front,
            Self::Back => -sides.front,
            Self::Left => -sides.right,
            Self::Right => sides.right,
            Self::Top => sides.up,
            Self::Bottom => -sides.up,
        }
    }

    /// Which of three pairs of opposites it belongs to.
    fn pair(self) -> usize {
        match self {
            Self::Front | Self::Back => 0,
            Self::Left | Self::Right => 1,
            Self::Top | Self::Bottom => 2,
        }
    }
}

impl FromStr for Viewpoint {
    type Err = String;

    /// Sides joined by hyphens, an axis, or X,Y,Z.
    fn from_str(text: &str) -> Result<Self, String> {
        if let Ok(direction) = parse_direction(text) {
            return Ok(Self::Direction(direction));
        }
        let words = text.split('-').map(|word| word.trim().to_lowercase());
        let side = |word: String| NAMES.iter().find(|&&(name, _)| name == word).map(|&(_, s)| s);
        let sides: Vec<Side> = words.map(side).collect::<Option<_>>().ok_or(
            "front, back, left, right, top or bottom is needed, or several of them as \
             front-left-top, or an axis (x, -y), or a direction X,Y,Z that is not 0",
        )?;
        for (number, side) in sides.iter().enumerate() {
            if sides[..number].iter().any(|other| other.pair() == side.pair()) {
                return Err("a view is from one of two opposite sides: leave one out".to_owned());
            }
        }
        Ok(Self::Sides(sides))
    }
}

/// An axis or X,Y,Z.
///
/// # Errors
/// When it is neither, or no direction.
pub fn parse_direction(text: &str) -> Result<DVec3, String> {
    let numbers =
        || text.split(',').map(|number| number.trim().parse().ok()).collect::<Option<Vec<f64>>>();
    let vector = || numbers().and_then(|numbers| <[f64; 3]>::try_from(numbers).ok());
    direction::axis(text.trim())
        .or_else(|| vector().map(DVec3::from_array).and_then(direction::unit))
        .ok_or_else(|| {
            "an axis (x, y, z, -x, -y, -z) or a direction X,Y,Z that is not 0 is needed".to_owned()
        })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::section::Sections;

    fn direction(view: &str, frame: &str) -> DVec3 {
        let sides = Sides::of(&Sections { frame: frame.to_owned(), ..Sections::default() });
        view.parse::<Viewpoint>().expect("a view").direction(&sides)
    }

    #[test]
    fn sides_are_where_the_frame_has_them() {
        let views = ["front", "left", "top", "back", "right", "bottom"];
        let expected = |frame: [DVec3; 3]| [frame, frame.map(|direction| -direction)].concat();
        let found = |frame| views.map(|view| direction(view, frame)).to_vec();
        assert_eq!(found(""), expected([DVec3::NEG_Y, DVec3::NEG_X, DVec3::Z]));
        // The patient's left is where x points in LPS, and where −x does in RAS.
        assert_eq!(found("LPS"), expected([DVec3::NEG_Y, DVec3::X, DVec3::Z]));
        assert_eq!(found("RAS"), expected([DVec3::Y, DVec3::NEG_X, DVec3::Z]));
    }

    #[test]
    fn views_may_be_in_between_and_by_number() {
        assert_eq!(direction("front-left-top", ""), DVec3::new(-1.0, -1.0, 1.0));
        assert_eq!(direction("Top-Right", ""), DVec3::new(1.0, 0.0, 1.0));
        assert_eq!(direction("-y", "RAS"), DVec3::NEG_Y);
        let oblique = direction("-3, 0,4", "RAS");
        assert!(oblique.distance(DVec3::new(-0.6, 0.0, 0.8)) < 1e-12, "{oblique}");
    }

    #[test]
    fn what_is_no_view_is_refused() {
        for text in ["", "above", "front-", "1,2", "1,2,3,4", "0,0,0", "nan,0,1", "front,left"] {
            let refused = text.parse::<Viewpoint>().expect_err(text);
            assert!(refused.contains("front-left-top"), "{text}: {refused}");
        }
        for text in ["front-back", "top-left-top"] {
            let refused = text.parse::<Viewpoint>().expect_err(text);
            assert!(refused.contains("opposite"), "{text}: {refused}");
        }
    }
}
