//! The indicators of all materials as OpenVDB trees, and their smoothing
//! (`cpp/grid.cc`).

#[cxx::bridge(namespace = "transect::grid")]
mod bridge {
    /// Leaves with their values.
    struct Leaves {
        /// Three coordinates each, in leaves.
        at: Vec<i32>,
        /// 512 values each.
        values: Vec<f32>,
    }

    unsafe extern "C++" {
        include!("transect/cpp/grid.h");

        /// A tree for each material, and the region in which they have values.
        type Grid;

        /// A grid of the given leaves (three coordinates each, in leaves),
        /// with one bit for every node that stays as it is (eight words a
        /// leaf, bit n of the leaf's node n).
        fn new_grid(leaves: &[i32], fixed: &[u64]) -> Result<UniquePtr<Grid>>;

        /// Adds a material that is −1 but for some leaves of the grid.
        fn add_material(grid: Pin<&mut Grid>, leaves: &[i32], values: &[f32]) -> Result<()>;

        /// Smooths every material by so many steps f −= rate · Δ²f, in voxels.
        fn smooth(grid: Pin<&mut Grid>, steps: u32, rate: f32) -> Result<()>;

        /// Takes the leaves of a material out of the grid, in no certain order.
        fn take_material(grid: Pin<&mut Grid>, material: usize) -> Result<Leaves>;
    }
}

pub use bridge::*;
