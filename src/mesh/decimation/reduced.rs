//! A network that becomes simpler, and what its vertices were.

use std::collections::BTreeSet;

use crate::mesh::Mesh;
use crate::mesh::network::{Ends, Network};

/// A network in the making.
pub struct Reduced {
    pub mesh: Mesh,
    /// Edges that are curves though nothing but a surface meets there.
    pub kept: BTreeSet<Ends>,
    /// For every vertex that there was the one that it is part of.
    pub places: Vec<u32>,
    /// How far every vertex may be from what it was made of.
    pub limits: Vec<f64>,
    /// How far it is; 0 where it is what it was.
    pub reached: Vec<f64>,
    /// Vertices at which sheets came together that must not.
    pub torn: Vec<u32>,
}

impl Reduced {
    pub fn new(mesh: &Mesh, kept: &[Ends], limits: &[f64]) -> Self {
        Self {
            mesh: mesh.clone(),
            kept: kept.iter().map(|&[one, other]| [one.min(other), one.max(other)]).collect(),
            places: (0..mesh.vertices.len() as u32).collect(),
            limits: limits.to_vec(),
            reached: vec![0.0; mesh.vertices.len()],
            torn: Vec::new(),
        }
    }

    /// What is known of vertices goes to those that they became part of, of so many. Edges that
    /// are kept have both their ends, under other numbers.
    pub fn follow(&mut self, to: &[u32], count: usize) {
        let (mut limits, mut reached) = (vec![f64::INFINITY; count], vec![0.0f64; count]);
        for (vertex, &place) in to.iter().enumerate() {
            let place = place as usize;
            limits[place] = limits[place].min(self.limits[vertex]);
            reached[place] = reached[place].max(self.reached[vertex]);
        }
        (self.limits, self.reached) = (limits, reached);
        self.places.iter_mut().for_each(|place| *place = to[*place as usize]);
        let renamed = |&ends: &Ends| {
            let [one, other] = ends.map(|end| to[end as usize]);
            [one.min(other), one.max(other)]
        };
        self.kept = self.kept.iter().map(renamed).collect();
    }

    /// Lowers the limits of what became part of some vertices to a part of how far these are.
    pub fn limit(&self, limits: &mut [f64], wrong: &[u32], part: f64) {
        let mut is_wrong = vec![false; self.mesh.vertices.len()];
        wrong.iter().for_each(|&vertex| is_wrong[vertex as usize] = true);
        for (limit, &place) in limits.iter_mut().zip(&self.places) {
            if is_wrong[place as usize] {
                *limit = limit.min(part * self.reached[place as usize]);
            }
        }
    }

    /// Divides edges that two sheets of one label share with both their ends.
    pub fn untie(&mut self) {
        let mut network = Network::from(std::mem::take(&mut self.mesh));
        network.untie();
        self.mesh = network.mesh;
        self.limits.resize(self.mesh.vertices.len(), f64::INFINITY);
        self.reached.resize(self.mesh.vertices.len(), 0.0);
    }
}
