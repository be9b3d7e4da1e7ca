//! OpenVDB grids and their files (`cpp/vdb.cc`).

#[cxx::bridge(namespace = "transect::vdb")]
mod bridge {
    /// A grid as it is in a file.
    struct Description {
        /// Its name.
        name: String,
        /// Its value type, in OpenVDB's words.
        value_type: String,
        /// Its class, in OpenVDB's words.
        class_name: String,
        /// The size of its voxels along x, y and z.
        voxel: [f64; 3],
        /// Where its node (0, 0, 0) is.
        origin: [f64; 3],
        /// How many voxels are active, tiles counted by what they cover.
        active: u64,
        /// All other metadata, as text: keys and values in turn.
        metadata: Vec<String>,
    }

    unsafe extern "C++" {
        include!("transect/cpp/vdb.h");

        /// Grids with one transform, and text that belongs to all of them.
        type Volumes;

        /// No grids yet; node (i, j, k) will be at origin + voxel · (i, j, k). With `half`, files
        /// have floats of half precision.
        fn new_volumes(voxel: f64, origin: [f64; 3], half: bool) -> Result<UniquePtr<Volumes>>;

        /// Adds a level set: leaves (three coordinates each, in leaves) and
        /// 512 signed distances each, in voxels, cut off at ±`half_width`.
        fn add_level_set(
            volumes: Pin<&mut Volumes>,
            name: &str,
            half_width: f64,
            leaves: &[i32],
            values: &[f32],
        ) -> Result<()>;

        /// Adds the level set `from` under another name.
        fn add_alias(volumes: Pin<&mut Volumes>, from: &str, name: &str) -> Result<()>;

        /// Takes a grid away.
        fn remove(volumes: Pin<&mut Volumes>, name: &str) -> Result<()>;

        /// Adds all grids of others, whose nodes may be elsewhere.
        fn adopt(volumes: Pin<&mut Volumes>, others: &Volumes) -> Result<()>;

        /// Adds the fog volume of the level set `from`.
        fn add_fog(volumes: Pin<&mut Volumes>, from: &str, name: &str) -> Result<()>;

        /// Adds whole numbers, 0 being the background: leaves with 512 values
        /// each, and leaves of one value.
        fn add_numbers(
            volumes: Pin<&mut Volumes>,
            name: &str,
            leaves: &[i32],
            values: &[i32],
            tiles: &[i32],
            tile_values: &[i32],
        ) -> Result<()>;

        /// Adds values with a background: leaves with 512 values each, and
        /// leaves of one value.
        fn add_values(
            volumes: Pin<&mut Volumes>,
            name: &str,
            background: f32,
            leaves: &[i32],
            values: &[f32],
            tiles: &[i32],
            tile_values: &[f32],
        ) -> Result<()>;

        /// Sets metadata of a grid, or of the file when `grid` is empty.
        fn set_text(volumes: Pin<&mut Volumes>, grid: &str, key: &str, text: &str) -> Result<()>;

        /// Writes all grids to a file, in the order in which they were added.
        fn write(volumes: &Volumes, path: &str) -> Result<()>;

        /// Writes all grids to a NanoVDB file, in the order in which they were added.
        fn write_nano(volumes: &Volumes, path: &str) -> Result<()>;

        /// Whether NanoVDB was there when this was built.
        fn has_nano() -> bool;

        /// Reads a file.
        fn read(path: &str) -> Result<UniquePtr<Volumes>>;

        /// What grids there are.
        fn describe(volumes: &Volumes) -> Result<Vec<Description>>;

        /// The metadata of the file, as text: keys and values in turn.
        fn file_metadata(volumes: &Volumes) -> Result<Vec<String>>;

        /// The value of a grid at a node, as a double.
        fn value(volumes: &Volumes, grid: &str, node: [i32; 3]) -> Result<f64>;

        /// What `openvdb::tools::checkLevelSet` finds wrong with a grid.
        fn check_level_set(volumes: &Volumes, grid: &str) -> Result<String>;

        /// What `openvdb::tools::checkFogVolume` finds wrong with a grid.
        fn check_fog_volume(volumes: &Volumes, grid: &str) -> Result<String>;
    }
}

pub use bridge::*;
