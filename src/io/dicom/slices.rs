//! Contours that somebody traced slice by slice, put on the planes of these slices: contours of a
//! slice are rarely on one plane to the last digit, and slices may be tilted.

use glam::DVec3;

use crate::plane::{Bounds, Plane};

/// A contour may be off its plane by this part of its own size,
const OF_SIZE: f64 = 0.05;
/// or of the diagonal of all, which rounding explains.
const ROUNDED: f64 = 1e-5;
/// Contours nearer to one another than this part of the typical gap between slices are on one.
const OF_GAP: f64 = 0.05;
/// Components of a normal below this come of rounding.
const STRAIGHT: f64 = 1e-6;
/// A contour whose area is less than this part of the square of its size has no normal of its own.
const CLEAR: f64 = 1e-3;

/// A plane and the contours on it.
#[derive(Debug, Clone, PartialEq)]
pub struct Slice {
    pub plane: Plane,
    /// By their numbers, in order.
    pub contours: Vec<usize>,
}

/// The slices of contours, and those that lie on none.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Slices {
    /// Parallel ones together, by their offsets.
    pub slices: Vec<Slice>,
    /// How many contours have points that are off their slice by more than rounding explains.
    pub moved: usize,
    /// The largest distance of a point from its slice.
    pub farthest: f64,
    /// Contours that are not flat, with how far their points are off the best plane.
    pub bent: Vec<(usize, f64)>,
    /// Contours that enclose nothing and are on no slice.
    pub astray: Vec<usize>,
}

/// Finds the slices of contours; `tolerance` is how far points may be off a plane, in world units.
/// Contours without points are on none.
pub fn slices(contours: &[&[DVec3]], tolerance: f64) -> Slices {
    let diagonal = diagonal(contours.iter().copied().flatten());
    let traced: Vec<Traced> = contours.iter().map(|points| Traced::new(points)).collect();
    let allowed =
        |traced: &Traced| (0.5 * tolerance).min((OF_SIZE * traced.size).max(ROUNDED * diagonal));
    let mut found = Slices::default();
    let mut order: Vec<usize> =
        (0..contours.len()).filter(|&number| !contours[number].is_empty()).collect();
    let area = |number: usize| traced[number].area.length();
    order.sort_by(|&one, &other| area(other).total_cmp(&area(one)));
    let mut directions: Vec<Direction> = Vec::new();
    for number in order {
        let own = &traced[number];
        let off = |normal: DVec3| own.off(contours[number], normal);
        let known = directions.iter().enumerate().map(|(place, known)| (off(known.normal), place));
        let known = known.min_by(|one, other| one.0.total_cmp(&other.0));
        match known {
            Some((distance, place)) if distance <= allowed(own) => {
                directions[place].members.push(number);
            }
            _ if own.is_clear() && off(own.area.normalize()) <= allowed(own) => {
                let normal = own.area.normalize();
                directions.push(Direction { normal, members: vec![number] });
            }
            // What encloses nothing says nothing of its plane, and is left out where it is read.
            Some((distance, place)) if !own.is_clear() && distance <= 0.5 * tolerance => {
                directions[place].members.push(number);
            }
            _ if !own.is_clear() => found.astray.push(number),
            _ => {
                let best = own.area.try_normalize().map_or(f64::INFINITY, off);
                found.bent.push((number, best.min(known.map_or(best, |known| known.0))));
            }
        }
    }
    for direction in &directions {
        let normal = direction.refined(&traced);
        let members = &direction.members;
        found.slices.extend(on_planes(normal, members, contours, &traced, diagonal));
    }
    for Slice { plane, contours: members } in &found.slices {
        for &number in members {
            let distances = contours[number].iter().map(|&point| plane.distance(point).abs());
            let farthest = distances.fold(0.0, f64::max);
            found.moved += usize::from(farthest > ROUNDED * diagonal);
            found.farthest = found.farthest.max(farthest);
        }
    }
    found.bent.sort_unstable_by_key(|bent| bent.0);
    found.astray.sort_unstable();
    found
}

/// Contours of one orientation.
struct Direction {
    normal: DVec3,
    members: Vec<usize>,
}

impl Direction {
    /// The mean normal, larger contours counting for more, without what comes of rounding; its
    /// largest component is positive.
    fn refined(&self, traced: &[Traced]) -> DVec3 {
        let sum = self.members.iter().fold(DVec3::ZERO, |sum, &number| {
            let area = traced[number].area;
            if area.dot(self.normal) < 0.0 { sum - area } else { sum + area }
        });
        let normal = sum.try_normalize().unwrap_or(self.normal);
        let straight = normal.to_array().map(|part| if part.abs() < STRAIGHT { 0.0 } else { part });
        let normal = DVec3::from(straight).normalize();
        let axis = Plane { normal, offset: 0.0 }.dropped_axis();
        normal * normal[axis].signum() + 0.0 // no -0
    }
}

/// What there is to know of a contour.
struct Traced {
    middle: DVec3,
    /// Its normal times its area, by Newell's formula.
    area: DVec3,
    /// The diagonal of its box.
    size: f64,
}

impl Traced {
    fn new(points: &[DVec3]) -> Self {
        let middle = points.iter().sum::<DVec3>() / points.len().max(1) as f64;
        let next = points.iter().cycle().skip(1);
        let area: DVec3 =
            points.iter().zip(next).map(|(&a, &b)| (a - middle).cross(b - middle)).sum();
        Self { middle, area: 0.5 * area, size: diagonal(points.iter()) }
    }

    fn is_clear(&self) -> bool {
        self.area.length() > CLEAR * self.size * self.size && self.size > 0.0
    }

    /// How far points are off the plane through their middle.
    fn off(&self, points: &[DVec3], normal: DVec3) -> f64 {
        points.iter().map(|&point| normal.dot(point - self.middle).abs()).fold(0.0, f64::max)
    }
}

/// Parallel contours by the planes they are on.
fn on_planes(
    normal: DVec3,
    members: &[usize],
    contours: &[&[DVec3]],
    traced: &[Traced],
    diagonal: f64,
) -> Vec<Slice> {
    let mut offsets: Vec<(f64, usize)> =
        members.iter().map(|&number| (normal.dot(traced[number].middle), number)).collect();
    offsets.sort_by(|one, other| one.0.total_cmp(&other.0).then(one.1.cmp(&other.1)));
    let apart = typical_gap(&offsets);
    let near = (OF_GAP * apart).max(ROUNDED * diagonal);
    let mut slices = Vec::new();
    let mut rest = offsets.as_slice();
    while let Some(&(first, _)) = rest.first() {
        let count = rest.partition_point(|(offset, _)| offset - first <= near);
        let (own, others) = rest.split_at(count);
        rest = others;
        let mut numbers: Vec<usize> = own.iter().map(|own| own.1).collect();
        numbers.sort_unstable();
        let heights =
            || numbers.iter().flat_map(|&number| contours[number]).map(|&point| normal.dot(point));
        let [low, high] = heights().fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], at| {
            [low.min(at), high.max(at)]
        });
        // To the last digit where they say it alike.
        let offset = match low == high {
            true => low,
            false => heights().sum::<f64>() / heights().count() as f64,
        };
        slices.push(Slice { plane: Plane { normal, offset: offset + 0.0 }, contours: numbers });
    }
    slices
}

/// The gap between neighbours below which half of the whole distance is: the many small ones
/// between contours of one slice do not count for much.
fn typical_gap(offsets: &[(f64, usize)]) -> f64 {
    let mut gaps: Vec<f64> = offsets.windows(2).map(|pair| pair[1].0 - pair[0].0).collect();
    gaps.sort_by(f64::total_cmp);
    let half = 0.5 * gaps.iter().sum::<f64>();
    let mut sum = 0.0;
    gaps.into_iter()
        .find(|gap| {
            sum += gap;
            sum >= half
        })
        .unwrap_or(0.0)
}

/// The area of a contour, however it lies.
pub fn area(points: &[DVec3]) -> f64 {
    Traced::new(points).area.length()
}

fn diagonal<'a>(points: impl Iterator<Item = &'a DVec3>) -> f64 {
    Bounds::around(points.copied()).map_or(0.0, |bounds| bounds.diagonal())
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A circle about a point, on a plane with this normal.
    fn circle(center: DVec3, normal: DVec3, radius: f64) -> Vec<DVec3> {
        let [a, b] = Plane { normal, offset: 0.0 }.tangents();
        let angles = (0..24).map(|i| f64::from(i) * std::f64::consts::TAU / 24.0);
        angles.map(|angle| center + radius * (angle.cos() * a + angle.sin() * b)).collect()
    }

    fn found(contours: &[Vec<DVec3>]) -> Slices {
        let borrowed: Vec<&[DVec3]> = contours.iter().map(Vec::as_slice).collect();
        slices(&borrowed, 0.1)
    }

    #[test]
    fn contours_slightly_off_are_put_on_slices() {
        let mut contours: Vec<Vec<DVec3>> = (0..10)
            .map(|k| circle(DVec3::new(5.0, 3.0, 3.0 * f64::from(k)), DVec3::Z, 20.0))
            .collect();
        // A second one on slice 4, a little beside it, and turned the other way.
        let mut second = circle(DVec3::new(60.0, 0.0, 12.02), DVec3::Z, 5.0);
        second.reverse();
        contours.push(second);
        let Slices { slices, moved, farthest, bent, .. } = found(&contours);
        assert_eq!((slices.len(), bent.len()), (10, 0));
        assert!(slices.iter().all(|slice| slice.plane.normal == DVec3::Z));
        assert_eq!(slices[3].plane.offset, 9.0, "exactly what all of its points say");
        assert_eq!(slices[4].contours, [4, 10]);
        assert!(moved == 2 && (0.009..0.011).contains(&farthest), "{moved} {farthest}");
    }

    #[test]
    fn tilted_and_crossing_slices() {
        let tilted = DVec3::new(0.2, -0.1, 1.0).normalize();
        let across = tilted.cross(DVec3::Y).normalize();
        let mut contours: Vec<Vec<DVec3>> =
            (0..5).map(|k| circle(f64::from(k) * 4.0 * tilted, tilted, 10.0)).collect();
        contours.extend((0..3).map(|k| circle(f64::from(k) * 4.0 * across, across, 10.0)));
        let slices = found(&contours).slices;
        assert_eq!(slices.len(), 8);
        for slice in &slices {
            let near = |normal: DVec3| slice.plane.normal.cross(normal).length() < 1e-9;
            assert!(near(if slice.contours[0] < 5 { tilted } else { across }), "{slice:?}");
        }
    }

    #[test]
    fn what_is_bent_is_told_and_what_is_degenerate_goes_along() {
        let mut bent = circle(DVec3::ZERO, DVec3::Z, 10.0);
        bent[3].z += 2.0;
        let line = vec![DVec3::new(1.0, 1.0, 3.0), DVec3::new(2.0, 1.0, 3.0)];
        let astray = vec![DVec3::ZERO, DVec3::new(0.0, 0.0, 2.0)];
        let contours = [circle(DVec3::Z * 3.0, DVec3::Z, 10.0), bent, line, Vec::new(), astray];
        let Slices { slices, bent, astray, .. } = found(&contours);
        assert_eq!(astray, [4]);
        assert_eq!(slices.len(), 1);
        assert_eq!(slices[0].contours, [0, 2]);
        assert!(matches!(bent[..], [(1, distance)] if distance > 1.0), "{bent:?}");
    }
}
