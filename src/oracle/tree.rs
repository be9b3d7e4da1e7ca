//! A tree of boxes over things in the plane.

use glam::DVec2;

/// Things in a box of the tree that is not divided.
const FEW: usize = 4;

/// The smallest and the largest coordinates.
pub type Rectangle = [DVec2; 2];

/// A tree of boxes over numbered things.
pub struct BoxTree {
    /// The things' numbers, so that every box has consecutive ones.
    items: Vec<u32>,
    /// The first holds everything; none without things.
    boxes: Vec<Node>,
}

/// A box. What follows it in the tree is its first half, if it is divided.
struct Node {
    around: Rectangle,
    first: u32,
    count: u32,
    /// The second half, or 0 for a box that is not divided.
    second: u32,
}

impl BoxTree {
    /// Of numbered things with the rectangles around them.
    pub fn new(mut things: Vec<(u32, Rectangle)>) -> Self {
        let mut boxes = Vec::new();
        if !things.is_empty() {
            divide(&mut things, 0, &mut boxes);
        }
        Self { items: things.into_iter().map(|(number, _)| number).collect(), boxes }
    }

    /// Visits the things in all boxes, and boxes in them, that are passed.
    pub fn visit(&self, passes: impl Fn(Rectangle) -> bool, mut thing: impl FnMut(u32)) {
        let mut waiting: Vec<u32> = (0..self.boxes.len().min(1) as u32).collect();
        while let Some(number) = waiting.pop() {
            let node = &self.boxes[number as usize];
            if !passes(node.around) {
                continue;
            }
            if node.second == 0 {
                self.items_of(node).iter().copied().for_each(&mut thing);
            } else {
                waiting.extend([node.second, number + 1]);
            }
        }
    }

    /// Visits things near a place, roughly the nearest first: all in boxes that
    /// are not farther away than a limit, which every visit may lower by what
    /// it returns.
    pub fn approach(&self, at: DVec2, limit: f64, mut thing: impl FnMut(u32) -> f64) {
        let Some(root) = self.boxes.first() else { return };
        let mut limit = limit;
        let mut waiting = vec![(root.gap(at), 0u32)];
        while let Some((gap, number)) = waiting.pop() {
            if gap > limit {
                continue;
            }
            let node = &self.boxes[number as usize];
            if node.second == 0 {
                for &item in self.items_of(node) {
                    limit = limit.min(thing(item));
                }
                continue;
            }
            let mut halves =
                [number + 1, node.second].map(|half| (self.boxes[half as usize].gap(at), half));
            halves.sort_by(|one, other| other.0.total_cmp(&one.0));
            waiting.extend(halves);
        }
    }

    fn items_of(&self, node: &Node) -> &[u32] {
        &self.items[node.first as usize..][..node.count as usize]
    }
}

impl Node {
    /// The distance from a point to the box.
    fn gap(&self, at: DVec2) -> f64 {
        (at - at.clamp(self.around[0], self.around[1])).length()
    }
}

/// Makes the box of some things, the first of which is number `first`, and of
/// their halves; says which it is.
fn divide(things: &mut [(u32, Rectangle)], first: u32, boxes: &mut Vec<Node>) -> u32 {
    let around = things.iter().fold([DVec2::INFINITY, DVec2::NEG_INFINITY], |around, thing| {
        [around[0].min(thing.1[0]), around[1].max(thing.1[1])]
    });
    let number = boxes.len() as u32;
    boxes.push(Node { around, first, count: things.len() as u32, second: 0 });
    if things.len() > FEW {
        let size = around[1] - around[0];
        let axis = usize::from(size.y > size.x);
        let middle = |(_, [min, max]): &(u32, Rectangle)| min[axis] + max[axis];
        things.sort_by(|one, other| middle(one).total_cmp(&middle(other)));
        let (one, other) = things.split_at_mut(things.len() / 2);
        divide(one, first, boxes);
        let second = divide(other, first + one.len() as u32, boxes);
        boxes[number as usize].second = second;
    }
    number
}
