//! Questions about triangle meshes, answered by CGAL's
//! Polygon_mesh_processing (`cpp/measure.cc`).

#[cxx::bridge(namespace = "transect::measure")]
mod bridge {
    unsafe extern "C++" {
        include!("transect/cpp/measure.h");

        /// The versions of CGAL and OpenVDB that this program was built with.
        fn library_versions() -> String;
    }
}

pub use bridge::*;
