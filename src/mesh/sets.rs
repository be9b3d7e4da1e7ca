//! Sets that are joined: a union-find structure.

/// Numbers in disjoint sets, each named by its smallest.
pub struct Sets {
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
}
