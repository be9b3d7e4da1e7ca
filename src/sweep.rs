//! A sweep of a hand-held probe over a solid: frames that advance along an axis while they rock
//! and turn, so that neighbours cross. Each knows what is within its rectangle and nothing
//! else, as an ultrasound frame does.

use std::f64::consts::TAU;

use glam::{DQuat, DVec3};
use rayon::prelude::*;

use crate::error::{Error, Result};
use crate::plane::{Bounds, Plane};
use crate::random::Random;
use crate::section::{Rules, Section};

/// Frames in which the hand rocks once to and fro: few enough that neighbours differ.
const ROCKING: f64 = 7.0;
/// Frames in which it turns once to and fro. The two are not in step.
const TURNING: f64 = 11.0;
/// How much it turns and rolls, relative to how much it rocks.
const TURN: f64 = 0.6;
const ROLL: f64 = 0.3;
/// How much it trembles, relative to how much it rocks.
const TREMBLE: f64 = 0.1;
/// How far the path strays from the middle, relative to the solid's extent.
const STRAY: f64 = 0.1;
/// The default sides of a frame, relative to the solid's extent.
const PART: f64 = 0.75;

/// How the probe is led.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Sweep {
    /// The axis that it advances along: 0, 1 or 2. Frames are as wide as the axis after it
    /// and as high as the one after that.
    pub axis: usize,
    /// How many frames.
    pub count: u32,
    /// How far a frame leans against the axis at most, rocking, in degrees; in [0, 60].
    pub tilt: f64,
    /// Width and height of a frame in world units; without them three quarters of the solid's.
    pub size: Option<[f64; 2]>,
    /// What the hand's unsteadiness is drawn from; the same frames for the same seed.
    pub seed: u64,
}

/// A frame: all that is known of a plane is within a rectangle.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Frame {
    /// The plane.
    pub plane: Plane,
    /// The rectangle's corners, one after the other.
    pub corners: [DVec3; 4],
}

/// A wave through a sweep: an angle as the hand rocks, a way as it strays.
struct Wave {
    /// In frames.
    period: f64,
    phase: f64,
}

impl Wave {
    fn new(period: f64, random: &mut Random) -> Self {
        Self { period, phase: random.unit() }
    }

    /// From −1 to 1.
    fn at(&self, frame: u32) -> f64 {
        (TAU * (f64::from(frame) / self.period + self.phase)).sin()
    }
}

impl Sweep {
    /// The frames of a sweep over a solid within these bounds, in their order.
    ///
    /// # Errors
    /// When a number is out of range.
    pub fn frames(&self, bounds: &Bounds) -> Result<Vec<Frame>> {
        let Self { axis, count, tilt, size, seed } = *self;
        if axis > 2 {
            return Err(Error::Option(format!("there is no axis {axis}: they are 0, 1 and 2")));
        }
        if !(0.0..=60.0).contains(&tilt) {
            return Err(Error::Option(format!("frames cannot lean by {tilt}°: give 0 to 60")));
        }
        let [across, up] = [(axis + 1) % 3, (axis + 2) % 3];
        let extent = bounds.size();
        let [width, height] = size.unwrap_or([PART * extent[across], PART * extent[up]]);
        if ![width, height].iter().all(|side| side.is_finite() && *side > 0.0) {
            let what = format!("a frame cannot be {width} × {height}: both must be positive");
            return Err(Error::Option(what));
        }
        let axes = [axis, across, up].map(|axis| DVec3::AXES[axis]);
        let mut random = Random::new(seed);
        let [rocking, turning, rolling] =
            [ROCKING, TURNING, ROCKING + TURNING].map(|period| Wave::new(period, &mut random));
        let stray = [0.6, 0.9].map(|part| Wave::new(part * f64::from(count), &mut random));
        let frame = |number: u32| {
            let mut tremble = || TREMBLE * (2.0 * random.unit() - 1.0);
            let rock = tilt * (rocking.at(number) * (1.0 - TREMBLE) + tremble());
            let turn = tilt * TURN * (turning.at(number) + tremble());
            let roll = tilt * ROLL * (rolling.at(number) + tremble());
            let angles = [(axes[1], rock), (axes[2], turn), (axes[0], roll)];
            let hand = angles.iter().fold(DQuat::IDENTITY, |hand, &(axis, degrees)| {
                hand * DQuat::from_axis_angle(axis, degrees.to_radians())
            });
            let mut middle = bounds.middle();
            let part = (f64::from(number) + 0.5) / f64::from(count);
            middle[axis] = bounds.min[axis] + part * extent[axis];
            middle[across] += STRAY * extent[across] * stray[0].at(number);
            middle[up] += STRAY * extent[up] * stray[1].at(number);
            Frame::new(middle, axes.map(|axis| hand * axis), [width, height])
        };
        Ok((0..count).map(frame).collect())
    }
}

impl Frame {
    /// A rectangle around a point, its normal and the directions of its sides given.
    fn new(middle: DVec3, [normal, across, up]: [DVec3; 3], [width, height]: [f64; 2]) -> Self {
        let plane = Plane { normal, offset: normal.dot(middle) };
        let corners = [[-0.5, -0.5], [0.5, -0.5], [0.5, 0.5], [-0.5, 0.5]]
            .map(|[u, v]| middle + u * width * across + v * height * up);
        Self { plane, corners }
    }
}

/// Sections cut by the frames' planes, one each, and what each frame knows of its own.
///
/// # Errors
/// When a frame is no rectangle on its section's plane.
pub fn framed(sections: Vec<Section>, frames: &[Frame]) -> Result<Vec<Section>> {
    let rules = Rules::default();
    sections
        .into_par_iter()
        .zip(frames)
        .enumerate()
        .map(|(number, (mut section, frame))| {
            section.name = format!("frame {}", number + 1);
            let diagonal = frame.corners[0].distance(frame.corners[2]);
            section.within(&frame.corners, &[], diagonal, &rules).map(|(section, _)| section)
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::label::Label;

    const BOUNDS: Bounds =
        Bounds { min: DVec3::new(-3.0, 10.0, 100.0), max: DVec3::new(5.0, 16.0, 140.0) };

    fn sweep() -> Sweep {
        Sweep { axis: 2, count: 40, tilt: 25.0, size: None, seed: 1 }
    }

    /// Whether two rectangles cross: an edge of one passes through the other.
    fn cross(one: &Frame, other: &Frame) -> bool {
        let passes = |edges: &Frame, frame: &Frame| {
            (0..4).any(|corner| {
                let [a, b] = [corner, (corner + 1) % 4].map(|corner| edges.corners[corner]);
                let [from, to] = [a, b].map(|point| frame.plane.distance(point));
                let at = a.lerp(b, from / (from - to)) - frame.corners[0];
                let sides = [1, 3].map(|corner| frame.corners[corner] - frame.corners[0]);
                let within = |side: DVec3| (0.0..=1.0).contains(&(at.dot(side) / side.dot(side)));
                from * to < 0.0 && sides.into_iter().all(within)
            })
        };
        passes(one, other) || passes(other, one)
    }

    #[test]
    fn frames_are_rectangles_on_planes_that_lean_and_neighbours_cross() {
        let frames = sweep().frames(&BOUNDS).expect("frames");
        assert_eq!(frames.len(), 40);
        assert_eq!(frames, sweep().frames(&BOUNDS).expect("frames"));
        assert_ne!(frames, Sweep { seed: 2, ..sweep() }.frames(&BOUNDS).expect("frames"));
        let mut steepest = 0.0f64;
        for Frame { plane, corners } in &frames {
            assert!(corners.iter().all(|&corner| plane.distance(corner).abs() < 1e-12));
            let [a, b, c, d] = *corners;
            assert!((b - a).dot(d - a).abs() < 1e-9 && (a - b + c).distance(d) < 1e-9);
            assert!((a.distance(b) - 6.0).abs() < 1e-9 && (a.distance(d) - 4.5).abs() < 1e-9);
            steepest = steepest.max(plane.normal.z.acos().to_degrees());
        }
        assert!((20.0..35.0).contains(&steepest), "{steepest}");
        let size = Some([30.0, 30.0]);
        let wide = Sweep { size, ..sweep() }.frames(&BOUNDS).expect("frames");
        let crossing = wide.windows(2).filter(|pair| cross(&pair[0], &pair[1])).count();
        assert!(crossing > 30, "{crossing}");
        // Without a tilt they are parallel.
        let upright = Sweep { tilt: 0.0, ..sweep() }.frames(&BOUNDS).expect("frames");
        assert!(upright.iter().all(|frame| frame.plane.normal == DVec3::Z));
    }

    #[test]
    fn a_frame_knows_what_is_within_it_alone() {
        let frames = sweep().frames(&BOUNDS).expect("frames");
        let nothing = |frame: &Frame| {
            Section::from_graph("cut", frame.plane, &[], &[], 40.0, &Rules::default())
        };
        let cuts: Result<Vec<Section>> =
            frames.iter().map(|frame| nothing(frame).map(|(section, _)| section)).collect();
        let sections = framed(cuts.expect("cuts"), &frames).expect("sections");
        assert_eq!((sections[0].name(), sections[39].name()), ("frame 1", "frame 40"));
        for section in &sections {
            assert_eq!(section.background(), Label::UNKNOWN);
            assert_eq!(section.labels(), [Label::OUTSIDE, Label::UNKNOWN]);
            assert_eq!((section.vertices().len(), section.edges().len()), (4, 4));
        }
    }

    #[test]
    fn sweeps_out_of_range_are_refused() {
        for wrong in [
            Sweep { axis: 3, ..sweep() },
            Sweep { tilt: 61.0, ..sweep() },
            Sweep { tilt: f64::NAN, ..sweep() },
            Sweep { size: Some([1.0, 0.0]), ..sweep() },
        ] {
            assert!(wrong.frames(&BOUNDS).is_err(), "{wrong:?}");
        }
    }
}
