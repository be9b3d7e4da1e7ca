//! Sets that are joined: a union-find structure, and connected components by it.

/// Numbers in disjoint sets, each named by its smallest.
pub(crate) struct Sets {
    parent: Vec<u32>,
}

impl Sets {
    /// The numbers below `count`, each alone.
    pub fn new(count: usize) -> Self {
        Self { parent: (0..count as u32).collect() }
    }

    /// The smallest number in the same set.
    pub fn root(&mut self, mut number: u32) -> u32 {
        while self.parent[number as usize] != number {
            let above = self.parent[number as usize];
            self.parent[number as usize] = self.parent[above as usize];
            number = above;
        }
        number
    }

    /// Makes the sets of two numbers one.
    pub fn join(&mut self, one: u32, other: u32) {
        let (one, other) = (self.root(one), self.root(other));
        self.parent[one.max(other) as usize] = one.min(other);
    }

    /// The root of every number.
    pub fn roots(mut self) -> Vec<u32> {
        (0..self.parent.len() as u32).map(|number| self.root(number)).collect()
    }
}

/// Numbers the connected components of `count` items; the component of the
/// first item is 0.
pub(crate) fn components(count: u32, pairs: impl Iterator<Item = [u32; 2]>) -> Vec<u32> {
    let mut sets = Sets::new(count as usize);
    pairs.for_each(|[one, other]| sets.join(one, other));
    // A root is the smallest of its component, so it is numbered first.
    let mut numbers = sets.roots();
    let mut next = 0;
    for item in 0..count as usize {
        let root = numbers[item] as usize;
        if root == item {
            numbers[item] = next;
            next += 1;
        } else {
            numbers[item] = numbers[root];
        }
    }
    numbers
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_set_is_named_by_its_smallest_number() {
        let mut sets = Sets::new(6);
        for [one, other] in [[5, 3], [4, 0], [3, 4]] {
            sets.join(one, other);
        }
        assert_eq!(sets.root(5), 0);
        assert_eq!(sets.roots(), [0, 1, 2, 0, 0, 0]);
    }

    #[test]
    fn components_are_numbered_in_the_order_of_their_first_items() {
        let pairs = [[3, 1], [4, 2], [5, 3]];
        assert_eq!(components(7, pairs.into_iter()), [0, 1, 2, 1, 2, 1, 3]);
        assert_eq!(components(0, [].into_iter()), [0; 0]);
    }
}
