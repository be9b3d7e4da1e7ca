//! The nearest of many segments in space: a tree of boxes over them.

use glam::DVec3;

/// Segments in a box of the tree that is not divided.
const FEW: usize = 4;

/// A tree of boxes over segments; a segment may be a point.
#[derive(Debug, Clone, Default)]
pub struct SegmentTree {
    /// So that every box has consecutive ones; each with its number among those given.
    segments: Vec<([DVec3; 2], u32)>,
    /// The first holds everything; none without segments.
    boxes: Vec<Node>,
}

/// A box. What follows it in the tree is its first half, if it is divided.
#[derive(Debug, Clone)]
struct Node {
    min: DVec3,
    max: DVec3,
    first: u32,
    count: u32,
    /// The second half, or 0 for a box that is not divided.
    second: u32,
}

/// Which segment was the nearest to the last point that was asked for: where
/// points come in an order along lines, the next one's is not far.
#[derive(Debug, Clone, Copy, Default)]
pub struct Hint(u32);

impl SegmentTree {
    /// Of some segments.
    pub fn new(segments: Vec<[DVec3; 2]>) -> Self {
        let mut boxes = Vec::new();
        let mut segments: Vec<_> = segments.into_iter().zip(0..).collect();
        if !segments.is_empty() {
            divide(&mut segments, 0, &mut boxes);
        }
        Self { segments, boxes }
    }

    /// The distance from a point to the nearest segment; infinite without any.
    pub fn distance(&self, point: DVec3, hint: &mut Hint) -> f64 {
        self.nearest(point, hint).map_or(f64::INFINITY, |(_, distance)| distance)
    }

    /// The number of the nearest segment among those given, and how far it is from a point;
    /// `None` without any.
    pub fn nearest(&self, point: DVec3, hint: &mut Hint) -> Option<(u32, f64)> {
        let &(guess, _) = self.segments.get(hint.0 as usize)?;
        let mut square = squared_distance(guess, point);
        self.search(point, &mut square, &mut hint.0);
        Some((self.segments[hint.0 as usize].1, square.sqrt()))
    }

    /// The distance from a point to the nearest segment, where it is below a
    /// limit.
    pub fn distance_below(&self, limit: f64, point: DVec3) -> Option<f64> {
        let mut square = limit * limit;
        let mut found = u32::MAX;
        self.search(point, &mut square, &mut found);
        (found != u32::MAX).then(|| square.sqrt())
    }

    /// The numbers of all segments that are no farther from a point than a limit, in their order.
    pub fn within(&self, limit: f64, point: DVec3) -> Vec<u32> {
        let square = limit * limit;
        let mut found = Vec::new();
        let mut waiting: Vec<u32> = if self.boxes.is_empty() { Vec::new() } else { vec![0] };
        while let Some(number) = waiting.pop() {
            let node = &self.boxes[number as usize];
            if node.squared_gap(point) > square {
                continue;
            }
            if node.second == 0 {
                let own = &self.segments[node.first as usize..][..node.count as usize];
                let near = own.iter().filter(|(ends, _)| squared_distance(*ends, point) <= square);
                found.extend(near.map(|&(_, number)| number));
            } else {
                waiting.extend([number + 1, node.second]);
            }
        }
        found.sort_unstable();
        found
    }

    /// Lowers `square` to the smallest squared distance, if there is a smaller
    /// one, and says whose it is.
    fn search(&self, point: DVec3, square: &mut f64, nearest: &mut u32) {
        // The tree halves its segments: 32 levels are enough for 2³² of them.
        let mut waiting = [(0.0, 0u32); 64];
        let mut count = 0;
        if let Some(root) = self.boxes.first() {
            waiting[0] = (root.squared_gap(point), 0);
            count = 1;
        }
        while count > 0 {
            count -= 1;
            let (gap, number) = waiting[count];
            if gap >= *square {
                continue;
            }
            let node = &self.boxes[number as usize];
            if node.second == 0 {
                for at in node.first..node.first + node.count {
                    let own = squared_distance(self.segments[at as usize].0, point);
                    if own < *square {
                        (*square, *nearest) = (own, at);
                    }
                }
                continue;
            }
            let halves = [number + 1, node.second]
                .map(|half| (self.boxes[half as usize].squared_gap(point), half));
            let far_first = usize::from(halves[0].0 < halves[1].0);
            waiting[count] = halves[far_first];
            waiting[count + 1] = halves[1 - far_first];
            count += 2;
        }
    }
}

impl Node {
    fn squared_gap(&self, point: DVec3) -> f64 {
        (point - point.clamp(self.min, self.max)).length_squared()
    }
}

fn squared_distance([start, end]: [DVec3; 2], point: DVec3) -> f64 {
    let (along, from) = (end - start, point - start);
    let square = along.length_squared();
    let part = if square > 0.0 { (from.dot(along) / square).clamp(0.0, 1.0) } else { 0.0 };
    (from - part * along).length_squared()
}

/// Makes the box of some segments, the first of which is number `first`, and
/// of their halves; says which it is.
fn divide(segments: &mut [([DVec3; 2], u32)], first: u32, boxes: &mut Vec<Node>) -> u32 {
    let ends = || segments.iter().flat_map(|(ends, _)| ends);
    let min = ends().fold(DVec3::INFINITY, |min, &end| min.min(end));
    let max = ends().fold(DVec3::NEG_INFINITY, |max, &end| max.max(end));
    let number = boxes.len() as u32;
    boxes.push(Node { min, max, first, count: segments.len() as u32, second: 0 });
    if segments.len() > FEW {
        let axis = (max - min).max_position();
        let half = segments.len() / 2;
        let middle = |([start, end], _): &([DVec3; 2], u32)| start[axis] + end[axis];
        segments.select_nth_unstable_by(half, |a, b| middle(a).total_cmp(&middle(b)));
        let (one, other) = segments.split_at_mut(half);
        divide(one, first, boxes);
        let second = divide(other, first + half as u32, boxes);
        boxes[number as usize].second = second;
    }
    number
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::random::Random;

    #[test]
    fn the_nearest_is_that_of_all() {
        let mut random = Random::new(3);
        let mut place = || DVec3::from_array(std::array::from_fn(|_| random.unit()));
        let mut segments: Vec<[DVec3; 2]> = (0..300)
            .map(|_| {
                let start = place();
                [start, start + 0.05 * place()]
            })
            .collect();
        segments.extend((0..50).map(|_| [place(); 2]));
        let tree = SegmentTree::new(segments.clone());
        let mut hint = Hint::default();
        for _ in 0..1000 {
            let point = 1.5 * place() - 0.25;
            let distances = segments.iter().map(|&one| squared_distance(one, point).sqrt());
            let expected = distances.fold(f64::INFINITY, f64::min);
            assert_eq!(tree.distance(point, &mut hint), expected);
            let (nearest, _) = tree.nearest(point, &mut hint).unwrap();
            assert_eq!(squared_distance(segments[nearest as usize], point).sqrt(), expected);
            let below = tree.distance_below(0.05, point);
            assert_eq!(below, Some(expected).filter(|&distance| distance < 0.05));
            let near =
                |&number: &u32| squared_distance(segments[number as usize], point) <= 0.05 * 0.05;
            let right: Vec<u32> = (0..segments.len() as u32).filter(near).collect();
            assert_eq!(tree.within(0.05, point), right);
        }
    }

    #[test]
    fn without_segments_all_is_far() {
        let tree = SegmentTree::new(Vec::new());
        assert_eq!(tree.distance(DVec3::ZERO, &mut Hint::default()), f64::INFINITY);
        assert_eq!(tree.distance_below(1.0, DVec3::ZERO), None);
        assert!(tree.within(1.0, DVec3::ZERO).is_empty());
    }
}
