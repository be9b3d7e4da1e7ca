//! Triangle networks: every triangle knows the label on its two sides.

use glam::DVec3;

use crate::label::Label;

/// A network of triangles between labels. Junction curves are shared vertex
/// for vertex.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Mesh {
    /// World units.
    pub vertices: Vec<DVec3>,
    /// Counter-clockwise as seen from the front.
    pub triangles: Vec<[u32; 3]>,
    /// For each triangle the labels `[back, front]`; the normal points from
    /// back to front. Between a material and outside, back is the material;
    /// between two materials, back is the smaller number.
    pub sides: Vec<[Label; 2]>,
}

/// The boundary of one label: closed, oriented outward, every edge with two
/// triangles and every vertex with one fan.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Surface {
    /// World units.
    pub vertices: Vec<DVec3>,
    /// Counter-clockwise as seen from outside.
    pub triangles: Vec<[u32; 3]>,
}
