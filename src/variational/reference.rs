//! The system in f64, as the module's page states it: every term of the energy is
//! w (Σ cᵢ fᵢ − t)² and adds w c cᵀ to the matrix and w t c to the right-hand side.
//! Nothing is taken from the stencil, and nothing is fast.

use std::collections::{BTreeMap, BTreeSet};

use super::metric::Direction;
use super::system::{Domain, Pull};

/// A node of the lattice.
pub type Node = [i32; 3];
/// A value for each node that is not 0.
pub type Vector = BTreeMap<Node, f64>;

/// The matrix's rows of free nodes, with the columns of all, and what they are to be
/// equal to.
pub struct Reference {
    rows: BTreeMap<Node, Vector>,
    right: Vector,
}

impl Reference {
    /// For the free nodes, which are held at a start.
    pub fn new(
        free: &BTreeSet<Node>,
        domain: Option<Domain>,
        pulls: &[Pull],
        directions: &[Direction],
        (hold, start): (f32, f32),
    ) -> Self {
        let rows = free.iter().map(|&node| (node, Vector::new())).collect();
        let mut reference = Self { rows, right: Vector::new() };
        let near: BTreeSet<Node> = free.iter().flat_map(|&node| cube(node, -2, 5)).collect();
        for node in near {
            reference.add_bending(node, domain, directions);
        }
        for pull in pulls {
            let target = f64::from(pull.target);
            reference.add(&interpolation(pull.at), f64::from(pull.weight), target);
        }
        for &node in free {
            reference.add(&[(node, 1.0)], f64::from(hold), f64::from(start));
        }
        reference
    }

    /// The second differences around a node and those at the parallelograms that begin
    /// there, where all their nodes exist.
    fn add_bending(&mut self, node: Node, domain: Option<Domain>, directions: &[Direction]) {
        let plus = |a: Node, b: Node| -> Node { std::array::from_fn(|axis| a[axis] + b[axis]) };
        let mut terms = Vec::new();
        for (number, one) in directions.iter().enumerate() {
            let (forward, weight) = (plus(node, one.step), f64::from(one.weight));
            let back = plus(node, one.step.map(|along| -along));
            terms.push((weight * weight, vec![(back, 1.0), (node, -2.0), (forward, 1.0)]));
            for other in &directions[number + 1..] {
                let beside = plus(node, other.step);
                let far = plus(forward, other.step);
                let weight = 2.0 * weight * f64::from(other.weight);
                terms
                    .push((weight, vec![(node, 1.0), (forward, -1.0), (beside, -1.0), (far, 1.0)]));
            }
        }
        for (weight, term) in terms {
            if term.iter().all(|&(node, _)| exists(node, domain)) {
                self.add(&term, weight, 0.0);
            }
        }
    }

    fn add(&mut self, term: &[(Node, f64)], weight: f64, target: f64) {
        for (node, own) in term {
            let Some(row) = self.rows.get_mut(node) else { continue };
            for &(column, other) in term {
                *row.entry(column).or_default() += weight * own * other;
            }
            *self.right.entry(*node).or_default() += weight * own * target;
        }
    }

    /// A x.
    pub fn apply(&self, values: &Vector) -> Vector {
        let sum = |row: &Vector| row.iter().map(|(node, by)| by * at(values, node)).sum();
        self.rows.iter().map(|(&node, row)| (node, sum(row))).collect()
    }

    /// The same with absolute values all over: what rounding errors are relative to.
    pub fn magnitude(&self, values: &Vector) -> Vector {
        let rows = self.rows.iter().map(|(&node, row)| {
            let row = row.iter().map(|(&column, by)| (column, by.abs())).collect();
            (node, row)
        });
        let right = self.right.iter().map(|(&node, value)| (node, value.abs())).collect();
        let values = values.iter().map(|(&node, value)| (node, value.abs())).collect();
        let absolute = Self { rows: rows.collect(), right };
        let product = absolute.apply(&values);
        let with_right = |(node, value)| (node, value + at(&absolute.right, &node));
        product.into_iter().map(with_right).collect()
    }

    /// b − A x; x has values where nodes are not free, too.
    pub fn residual(&self, values: &Vector) -> Vector {
        let product = self.apply(values);
        product.into_iter().map(|(node, value)| (node, at(&self.right, &node) - value)).collect()
    }

    /// The diagonal of A.
    pub fn diagonal(&self) -> Vector {
        self.rows.iter().map(|(node, row)| (*node, at(row, node))).collect()
    }

    /// What conjugate gradients come to for A x = `residual` after some iterations
    /// from 0, the diagonal as the preconditioner.
    pub fn solve(&self, residual: &Vector, iterations: u32) -> Vector {
        let inverse: Vector = self
            .diagonal()
            .into_iter()
            .map(|(node, own)| (node, if own > 0.0 { 1.0 / own } else { 0.0 }))
            .collect();
        let product = |one: &Vector, other: &Vector| -> f64 {
            one.iter().map(|(node, value)| value * other[node]).sum()
        };
        let scaled = |residual: &Vector| -> Vector {
            residual.iter().map(|(node, value)| (*node, value * inverse[node])).collect()
        };
        let add = |to: &mut Vector, factor: f64, other: &Vector| {
            to.iter_mut().for_each(|(node, value)| *value += factor * other[node]);
        };
        let mut residual = residual.clone();
        let mut correction: Vector = residual.keys().map(|&node| (node, 0.0)).collect();
        let mut direction = scaled(&residual);
        let mut size = product(&residual, &direction);
        for _ in 0..iterations {
            let image = self.apply(&direction);
            let length = size / product(&direction, &image);
            add(&mut correction, length, &direction);
            add(&mut residual, -length, &image);
            let mut next = scaled(&residual);
            let next_size = product(&residual, &next);
            add(&mut next, next_size / size, &direction);
            (direction, size) = (next, next_size);
        }
        correction
    }
}

fn at(vector: &Vector, node: &Node) -> f64 {
    vector.get(node).copied().unwrap_or_default()
}

fn exists(node: Node, domain: Option<Domain>) -> bool {
    domain.is_none_or(|domain| {
        (0..3).all(|axis| (domain.low[axis]..domain.high[axis]).contains(&node[axis]))
    })
}

/// `side`³ nodes, the first of them `step` away along each axis.
pub fn cube([x, y, z]: Node, step: i32, side: i32) -> impl Iterator<Item = Node> {
    let range = move |at: i32| at + step..at + step + side;
    range(x).flat_map(move |x| range(y).flat_map(move |y| range(z).map(move |z| [x, y, z])))
}

/// f at a place, from the nodes around it.
fn interpolation(at: [f64; 3]) -> Vec<(Node, f64)> {
    let low = at.map(|along| along.floor() as i32);
    let share = |node: Node| -> f64 {
        (0..3).map(|axis| 1.0 - (at[axis] - f64::from(node[axis])).abs()).product()
    };
    cube(low, 0, 2).map(|node| (node, share(node))).collect()
}
