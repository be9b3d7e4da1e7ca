//! What a length counts, by its direction: less across a stack of sections than within
//! them.
//!
//! Nothing is known of what is between two parallel sections but what is on them, and a
//! surface that is smooth in all directions alike bulges and shrinks there, as it may
//! within a section, where a contour would say so. So all is measured in a space that is
//! squeezed by [`SQUEEZE`] along the sections' normal: to bend across sections costs
//! more, and the contours of the next one are nearer. How much of this there is comes from
//! N, the mean of n nᵀ over the sections' unit normals: its fourth power is n nᵀ for
//! parallel sections, nearly so where a few cross them, and next to nothing for sections
//! in all directions, which are measured as they are.
//!
//! In the squeezed space S x the squared second derivatives sum up to tr (M H M H), with
//! M = S⁻² and the Hessian H, and a volume is det S times as large; so M = √(det S) S⁻²
//! has both. On a lattice it is Σ w d dᵀ, with d from node to node and w > 0: *Selling's
//! decomposition* (J. Fehrenbach and J.-M. Mirebeau, Sparse non-negative stencils for
//! anisotropic diffusion, Journal of Mathematical Imaging and Vision 49, 2014).

use glam::{DMat3, DVec3, IVec3};

use crate::section::Section;

/// What is left of a length across a stack.
const SQUEEZE: f64 = 0.7;
/// With a smaller trace of N⁴ nothing is squeezed: a stack has 1, and ½ if a sixth of all
/// sections lie across it.
const LEAST: f64 = 0.5;
/// What entries of N⁴ are rounded to where sections are not all parallel: a tilt of the stack by
/// less than four degrees, which nobody would see. So one more frame of a sweep by hand mostly
/// leaves lengths as they are, and with them what was solved for.
const STEP: f64 = 0.125;
/// What is lost in rounding, beside 1.
const NOTHING: f64 = 1e-9;

/// By so much of a length two metrics may differ and be alike.
const ALIKE: f64 = 1e-3;

/// Directions of a metric at most.
pub const DIRECTIONS: usize = 6;

/// A direction of second differences.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Direction {
    /// From a node to the next; its entries are −1, 0 or 1.
    pub step: [i32; 3],
    /// w.
    pub weight: f32,
}

/// How lengths are measured.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Metric {
    /// S.
    squeeze: DMat3,
}

impl Metric {
    /// For the directions that sections have.
    pub fn new(sections: &[Section]) -> Self {
        let outer = |section: &Section| {
            let n = section.plane.unit_normal();
            DMat3::from_cols(n * n.x, n * n.y, n * n.z)
        };
        let sum = sections.iter().map(outer).fold(DMat3::ZERO, |sum, one| sum + one);
        let squared = sum * sum * (sections.len().max(1) as f64).powi(-2);
        let mut fourth = squared * squared;
        let trace = fourth.x_axis.x + fourth.y_axis.y + fourth.z_axis.z;
        if trace < 1.0 - NOTHING {
            fourth = DMat3::from_cols_array(
                &fourth.to_cols_array().map(|entry| (entry / STEP).round() * STEP),
            );
        }
        let is_stack = trace >= LEAST;
        let share = if is_stack { 1.0 - SQUEEZE } else { 0.0 };
        Self { squeeze: DMat3::IDENTITY - fourth * share }
    }

    /// Whether another one measures lengths alike, but for [`ALIKE`].
    pub fn is_near(self, other: Self) -> bool {
        self.squeeze.abs_diff_eq(other.squeeze, ALIKE)
    }

    /// Where a point is in the squeezed space.
    pub fn squeezed(&self, point: DVec3) -> DVec3 {
        self.squeeze * point
    }

    /// What is left of a length, in the mean of all directions.
    pub fn length(&self) -> f64 {
        self.squeeze.determinant().cbrt()
    }

    /// The directions in which second differences are taken, in a fixed order. Those of a
    /// space that is measured as it is are the axes, with weights of 1.
    pub fn directions(&self) -> Vec<Direction> {
        let volume = self.squeeze.determinant();
        decomposed((self.squeeze * self.squeeze).inverse() * volume.sqrt())
    }
}

/// Selling's decomposition of a matrix that is symmetric and positive.
fn decomposed(matrix: DMat3) -> Vec<Direction> {
    let product = |one: IVec3, other: IVec3| one.as_dvec3().dot(matrix * other.as_dvec3());
    // Two of four, and the other two.
    const PAIRS: [[usize; 4]; DIRECTIONS] =
        [[0, 3, 1, 2], [1, 3, 2, 0], [2, 3, 0, 1], [0, 1, 2, 3], [0, 2, 1, 3], [1, 2, 0, 3]];
    // Three vectors that span the lattice, and less the sum of them: no angle between two
    // of the four is to be acute. Every step shortens them.
    let mut base = [IVec3::X, IVec3::Y, IVec3::Z, IVec3::NEG_ONE];
    let acute = |base: &[IVec3; 4]| {
        PAIRS.into_iter().find(|&[i, j, ..]| product(base[i], base[j]) > NOTHING)
    };
    while let Some([i, j, k, l]) = acute(&base) {
        base = [-base[i], base[j], base[i] + base[k], base[i] + base[l]];
    }
    let direction = |[i, j, k, l]: [usize; 4]| {
        let weight = -product(base[i], base[j]);
        let step = base[k].cross(base[l]).to_array();
        (weight > NOTHING).then_some(Direction { step, weight: weight as f32 })
    };
    PAIRS.into_iter().filter_map(direction).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::check::shapes::disc;
    use crate::label::Label;
    use crate::plane::Plane;
    use crate::random::Random;

    fn metric(normals: &[DVec3]) -> Metric {
        let disc = |&normal: &DVec3| disc(Plane { normal, offset: 0.0 }, 1.0, 8, Label(1));
        Metric::new(&normals.iter().map(disc).collect::<Vec<_>>())
    }

    fn normal(random: &mut Random) -> DVec3 {
        let n = DVec3::from_array(std::array::from_fn(|_| 2.0 * random.unit() - 1.0));
        if n.length() > 0.1 { n } else { DVec3::X }
    }

    #[test]
    fn a_stack_along_an_axis_has_the_axes_for_directions() {
        let of = |step, weight| Direction { step, weight };
        let (within, across) = (SQUEEZE.sqrt() as f32, SQUEEZE.powf(-1.5) as f32);
        assert_eq!(
            metric(&[DVec3::Y, -2.0 * DVec3::Y, DVec3::Y]).directions(),
            [of([1, 0, 0], within), of([0, 1, 0], across), of([0, 0, 1], within)]
        );
        let as_it_is = metric(&[DVec3::X, DVec3::Y, DVec3::Z]);
        assert_eq!(as_it_is.squeeze, DMat3::IDENTITY);
        let axes = [of([1, 0, 0], 1.0), of([0, 1, 0], 1.0), of([0, 0, 1], 1.0)];
        assert_eq!(as_it_is.directions(), axes);
        assert_eq!(metric(&[]).directions(), axes);
    }

    #[test]
    fn a_stack_is_squeezed_along_its_normal() {
        let n = DVec3::new(1.0, -2.0, 0.5).normalize();
        let metric = metric(&[n, -n, 3.0 * n]);
        assert!((metric.squeezed(2.0 * n) - 2.0 * SQUEEZE * n).length() < 1e-12);
        let within = n.any_orthogonal_vector();
        assert!((metric.squeezed(within) - within).length() < 1e-12);
        assert!((metric.length() - SQUEEZE.cbrt()).abs() < 1e-12);
    }

    #[test]
    fn a_section_across_makes_a_stack_less_of_one() {
        let left = |across: usize| {
            let mut normals = vec![DVec3::Z; 15];
            normals.extend(vec![DVec3::X; across]);
            metric(&normals).squeezed(DVec3::Z).z
        };
        let all: Vec<f64> = (0..5).map(left).collect();
        assert!(all.is_sorted() && all[1] < 0.8, "{all:?}");
        assert_eq!(all[4], 1.0);
    }

    #[test]
    fn one_more_frame_of_a_sweep_mostly_changes_nothing() {
        let mut random = Random::new(2);
        let tilted = |random: &mut Random| {
            let [x, y] = std::array::from_fn(|_| 0.3 * (2.0 * random.unit() - 1.0));
            DVec3::new(x, y, 1.0)
        };
        let mut normals: Vec<DVec3> = (0..12).map(|_| tilted(&mut random)).collect();
        let mut same = 0;
        for _ in 0..40 {
            let before = metric(&normals);
            normals.push(tilted(&mut random));
            same += u32::from(metric(&normals) == before);
        }
        assert!(same > 35, "{same}");
    }

    #[test]
    fn directions_reach_to_the_next_nodes_and_add_up_to_the_metric() {
        let mut random = Random::new(1);
        for _ in 0..2000 {
            let mut normals = vec![normal(&mut random); 8];
            if random.unit() < 0.5 {
                normals.push(normal(&mut random));
            }
            let metric = metric(&normals);
            let mut sum = DMat3::ZERO;
            for Direction { step, weight } in metric.directions() {
                assert!(step.iter().all(|along| (-1..=1).contains(along)), "{normals:?} {step:?}");
                assert!(weight > 0.0);
                let d = IVec3::from_array(step).as_dvec3();
                sum += DMat3::from_cols(d * d.x, d * d.y, d * d.z) * f64::from(weight);
            }
            let of_squeezed = metric.squeeze * sum * metric.squeeze;
            let volume = metric.length().powi(3);
            assert!(of_squeezed.abs_diff_eq(DMat3::IDENTITY * volume.sqrt(), 1e-5), "{normals:?}");
        }
    }
}
